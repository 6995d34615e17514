#!/usr/bin/env python3
"""Convert the README for the package index, where relative links do not work: ``long_description.py -o README.md``.

With the address of the repository (``Repository`` in ``[project.urls]`` of pyproject.toml), links and images become
absolute, at the tag of the version. Without an address, a link becomes text, and images and the list of pages are
omitted.
"""

from __future__ import annotations

import argparse
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
IMAGE = re.compile(r"!\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
LINK = re.compile(r"(?<!!)\[(?P<text>[^\]]*)\]\((?P<target>[^)\s]+)\)")
PAGES = re.compile(r"^## Documentation\n.*?(?=^## )", flags=re.DOTALL | re.MULTILINE)
FENCE = re.compile(r"^(```.*?^```)", flags=re.DOTALL | re.MULTILINE)


def elsewhere(target: str) -> bool:
    """Whether a link is absolute, or leads to a place in the same page."""
    return target.startswith(("https://", "http://", "mailto:", "#"))


def converted(text: str, *, repository: str | None, tag: str) -> str:
    """Convert the page for the package index; blocks of code do not change."""

    def image(match: re.Match[str]) -> str:
        if elsewhere(match["target"]):
            return match[0]
        return f"![{match['text']}]({repository}/raw/{tag}/{match['target']})" if repository else ""

    def link(match: re.Match[str]) -> str:
        if elsewhere(match["target"]):
            return match[0]
        return f"[{match['text']}]({repository}/blob/{tag}/{match['target']})" if repository else match["text"]

    text = text if repository else PAGES.sub("", text)
    parts = FENCE.split(text)  # every second part is code
    for place in range(0, len(parts), 2):
        parts[place] = LINK.sub(link, IMAGE.sub(image, parts[place]))
    return re.sub(r"\n{3,}", "\n\n", "".join(parts))


def convert_project(root: Path = ROOT) -> str:
    """The long description of the project in a folder."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    repository = project.get("urls", {}).get("Repository")
    readme = (root / "README.md").read_text(encoding="utf-8")
    return converted(readme, repository=repository and repository.rstrip("/"), tag=f"v{project['version']}")


def main() -> int:
    """Write the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.parse_args().output.write_text(convert_project(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
