"""Texts of the pages for the excerpts of the search, in one file: a page opened from a folder may not read the others."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

_LONGEST = 2000  # characters of a page, from which an excerpt is taken
_SKIPPED = ("script", "style", "math", "h1", "nav", "a.headerlink")
_VOID = ("br", "img", "hr", "input", "col", "wbr", "source", "link", "meta")


class _Article(HTMLParser):
    """Collects the text of the article of a page, without its title."""

    def __init__(self) -> None:
        super().__init__()
        self.parts: list[str] = []
        self._depth = self._hidden = 0  # of open elements in the article, and in one that is skipped

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = (dict(attrs).get("class") or "").split()
        if tag in _VOID or (not self._depth and not (tag == "article" and "bd-article" in names)):
            return
        self._depth += 1
        if self._hidden or tag in _SKIPPED or any(f"{tag}.{name}" in _SKIPPED for name in names):
            self._hidden += 1

    def handle_endtag(self, tag: str) -> None:
        if self._depth and tag not in _VOID:
            self._depth -= 1
            self._hidden = max(self._hidden - 1, 0)

    def handle_data(self, data: str) -> None:
        if self._depth and not self._hidden:
            self.parts.append(data)


def text_of(page: str) -> str:
    """The text of a page of the site, from below its title."""
    article = _Article()
    article.feed(page)
    return " ".join("".join(article.parts).split())[:_LONGEST]


def write(site: Path) -> None:
    """Write the texts of all pages into ``_static/search-texts.js``."""
    pages = sorted(page for page in site.rglob("*.html") if not page.relative_to(site).parts[0].startswith("_"))
    texts = {
        page.relative_to(site).with_suffix("").as_posix(): text_of(page.read_text(encoding="utf-8")) for page in pages
    }
    content = json.dumps(
        {name: text for name, text in texts.items() if text}, ensure_ascii=False, separators=(",", ":")
    )
    (site / "_static" / "search-texts.js").write_text(f"window.SEARCH_TEXTS = {content};\n", encoding="utf-8")
