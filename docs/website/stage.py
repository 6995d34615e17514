"""Collect the pages of the site: Markdown of the repository, notebooks, and pages generated from the code.

Sphinx reads them from a separate folder, so that the sources remain readable on a Git host, without directives of Sphinx.
This module adds the order of the pages, and links that leave docs/.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath

from website import api, command_line, kinds, notebooks, schema

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"

# Sections of the site in the order of its navigation bar: title and first page. `examples` is the gallery.
SECTIONS = {
    "Start": "start",
    "How to": "how-to/index",
    "Questions": "questions/index",
    "Theory": "theory/index",
    "Examples": "examples/index",
    "Reference": "reference",
    "The paper": "paper/index",
    "Studies": "study/index",
    "Performance": "performance",
    "Decisions": "decisions/index",
    "Contributing": "contributing",
    "Changelog": "changelog",
}
# Pages below a page that is not the index of their folder; pages without a link go to the reference.
BELOW = {
    "start": ("overview", "tutorial/index", "coming-from/index", "guide", "notebook", "screens", "report"),
    "reference": (
        "api/index",
        "command-line",
        "findings",
        "details",
        "formats",
        "numbers",
        "glossary",
        "model",
        "json",
    ),
    "performance": ("scale",),
    "contributing": ("promises", "fuzzing", "security", "code-of-conduct"),
}
# Titles of folders without a README.md.
UNTITLED = {
    "tutorial": "Tutorial",
    "coming-from": "Coming from other tools",
    "questions": "Questions",
    "theory": "Theory",
}
NO_PAGES = {"THIRD_PARTY_LICENSES.md", "README.md"}

_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
_FENCE = re.compile(r"^ *(```+|~~~+)")


def pages() -> dict[PurePosixPath, PurePosixPath]:
    """Pages of the repository, and their places in the site."""
    page_of = {PurePosixPath("README.md"): PurePosixPath("overview.md")}
    for path in sorted(ROOT.glob("*.md")):
        if path.name not in NO_PAGES:
            page_of[PurePosixPath(path.name)] = PurePosixPath(path.name.lower().replace("_", "-"))
    for path in [*sorted(DOCS.rglob("*.md")), *sorted(DOCS.rglob("*.ipynb"))]:
        here = PurePosixPath(path.relative_to(DOCS).as_posix())
        name = "index.md" if here.name == "README.md" else f"{here.stem}.md"
        page_of[PurePosixPath("docs") / here] = here.with_name(name)
    return page_of


def outside_code(text: str) -> Iterator[tuple[bool, str]]:
    """Parts of a page, each with whether it is outside fenced code."""
    fence, part = "", ""
    for line in text.splitlines(keepends=True):
        mark = _FENCE.match(line)
        if mark and not fence:
            yield True, part
            fence, part = mark[1], line
        elif mark and mark[1].startswith(fence):
            yield False, part + line
            fence, part = "", ""
        else:
            part += line
    yield not fence, part


def with_links(text: str, source: PurePosixPath, staged: dict[PurePosixPath, PurePosixPath]) -> str:
    """Adapt the links of a page to the site; a link to a file outside the site becomes text."""
    here = staged[source].parent

    def link(match: re.Match[str]) -> str:
        image, label, target = match.groups()
        path, _, anchor = target.partition("#")
        if not path or "://" in target or target.startswith("mailto:"):
            return match[0]
        destination = PurePosixPath(os.path.normpath(source.parent / path))
        if (ROOT / destination).is_dir():
            destination /= "README.md"
        if destination in staged:
            site = os.path.relpath(staged[destination], here)
        elif destination.parts[0] == "docs" and (ROOT / destination).exists():
            site = os.path.relpath(PurePosixPath(*destination.parts[1:]), here)
        elif (ROOT / destination).exists():
            return f"{label} (`{destination}`)"
        else:
            return match[0]  # Sphinx reports it
        return f"{image}[{label}]({site}{'#' if anchor else ''}{anchor})"

    return "".join(_LINK.sub(link, part) if free else part for free, part in outside_code(text))


def linked(text: str, folder: PurePosixPath) -> Iterator[str]:
    """Names of the pages to which a page links, in order."""
    for free, part in outside_code(text):
        for _, _, target in _LINK.findall(part) if free else ():
            path = target.partition("#")[0]
            if path.endswith(".md") and "://" not in path:
                yield os.path.normpath(folder / path).removesuffix(".md")


def title(text: str) -> str:
    """First heading of a page."""
    return next(
        line[2:].strip() for free, part in outside_code(text) if free for line in part.splitlines() if line[:2] == "# "
    )


def toctree(entries: Iterable[str]) -> str:
    """A table of contents that is only shown in the navigation."""
    return "\n```{toctree}\n:hidden:\n\n" + "\n".join(entries) + "\n```\n"


def _index(folder: str, texts: dict[str, str]) -> str:
    below = sorted(name for name in texts if name.startswith(f"{folder}/"))
    return f"# {UNTITLED.get(folder, folder.capitalize())}\n\n" + "".join(
        f"- [{title(texts[name])}]({name.removeprefix(f'{folder}/')}.md)\n" for name in below
    )


def contents(texts: dict[str, str]) -> dict[str, list[str]]:
    """Names of the pages below each page, in order. `texts`: pages by name."""
    below: dict[str, list[str]] = {parent: [name for name in names if name in texts] for parent, names in BELOW.items()}
    placed = {"index", *SECTIONS.values(), *(name for names in below.values() for name in names)}
    for name in texts:
        parent = str(PurePosixPath(name).parent / "index") if "/" in name else "reference"
        if name not in placed and name != parent:
            below.setdefault(parent, []).append(name)
    for parent, names in below.items():
        order = {
            name: place
            for place, name in reversed(list(enumerate(linked(texts[parent], PurePosixPath(parent).parent))))
        }
        if parent not in BELOW:
            names.sort(key=lambda name: (order.get(name, len(order)), name))
    return below


def stage(folder: Path) -> None:
    """Write all pages and their pictures into a new folder."""
    shutil.rmtree(folder, ignore_errors=True)
    ignored = shutil.ignore_patterns("*.py", "*.md", "gallery", "website", "__pycache__", "_build")
    shutil.copytree(DOCS, folder, ignore=ignored)
    staged = pages()
    texts = {}
    for source, destination in staged.items():
        path = ROOT / source
        text = notebooks.markdown(path) if path.suffix == ".ipynb" else path.read_text(encoding="utf-8")
        texts[str(destination.with_suffix(""))] = with_links(text, source, staged)
    for directory in sorted({name.partition("/")[0] for name in texts if "/" in name}):
        if f"{directory}/index" not in texts:
            texts[f"{directory}/index"] = _index(directory, texts)
    made = {**api.pages(), "command-line": command_line.page(), "details": kinds.page(), "json": schema.page()}
    shutil.copy(schema.FILE, folder)
    texts["index"] = texts["index"].replace("<!-- doors -->\n", "{.doors}\n")
    texts["reference"] = texts["reference"].replace("<!-- made pages -->\n", _made(made))
    for parent, names in contents(texts | made).items():
        if parent in texts:
            texts[parent] += toctree(f"/{name}" for name in names)
    existing = {*texts, "examples/index"}  # sphinx-gallery writes the examples
    texts["index"] += toctree(f"{name} <{page}>" for name, page in SECTIONS.items() if page in existing)
    for name, text in (texts | made).items():
        path = folder / f"{name}.{'rst' if name in made else 'md'}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def add_alive(site: Path) -> None:
    """Add the theory page to the site: that of `make alive`, or without it a page that says how to make it."""
    made = ROOT / "target" / "alive" / "index.html"
    (site / "alive").mkdir(exist_ok=True)
    shutil.copyfile(made if made.exists() else DOCS / "alive" / "index.html", site / "alive" / "index.html")


def _made(made: dict[str, str]) -> str:
    """Rows of the reference for the pages generated from the code."""
    rows = {
        "api/index": ("Python", "every public function and class, by job"),
        "command-line": ("Command line", "every command and option"),
        "details": ("Details of findings", "the parameters of each kind of finding"),
        "json": ("JSON of a result", "every field of `analyze --json`"),
    }
    return "".join(f"- [{name}]({page}.rst): {purpose}.\n" for page, (name, purpose) in rows.items() if page in made)
