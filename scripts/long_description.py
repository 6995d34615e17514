#!/usr/bin/env python3
"""The README as the package index shows it, where relative links lead nowhere: ``long_description.py -o README.md``.

With the address of the repository (``Repository`` in ``[project.urls]`` of pyproject.toml) links and images become absolute,
those of the tag of the version. Without one, a link becomes its text, and images and the list of pages are left out.
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
    """The page for the package index; blocks of code stay as they are."""

    def image(found: re.Match[str]) -> str:
        if elsewhere(found["target"]):
            return found[0]
        return f"![{found['text']}]({repository}/raw/{tag}/{found['target']})" if repository else ""

    def link(found: re.Match[str]) -> str:
        if elsewhere(found["target"]):
            return found[0]
        return f"[{found['text']}]({repository}/blob/{tag}/{found['target']})" if repository else found["text"]

    text = text if repository else PAGES.sub("", text)
    parts = FENCE.split(text)  # code is every second one
    for place in range(0, len(parts), 2):
        parts[place] = LINK.sub(link, IMAGE.sub(image, parts[place]))
    return re.sub(r"\n{3,}", "\n\n", "".join(parts))


def of_project(root: Path = ROOT) -> str:
    """The long description of the project in a folder."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    repository = project.get("urls", {}).get("Repository")
    readme = (root / "README.md").read_text(encoding="utf-8")
    return converted(readme, repository=repository and repository.rstrip("/"), tag=f"v{project['version']}")


def main() -> int:
    """Write the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.parse_args().output.write_text(of_project(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
