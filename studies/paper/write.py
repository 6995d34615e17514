"""Fill the tables of docs/paper: ``make paper``, which then writes the outputs by tests/docs/pages.py.

Pages and the notebook are templates: ``<!-- made: NAME -->`` … ``<!-- end -->`` holds a table of `rows`.
"""

from __future__ import annotations

import re
import sys

from studies.paper import days, figures, notebook
from studies.paper.rows import TABLES, Days
from studies.paper.tables import PAGES

__all__ = ["PAGES", "made"]

_MADE = re.compile(r"^(<!-- made: ([\w -]+) -->\n).*?^(<!-- end -->)", flags=re.DOTALL | re.MULTILINE)


def made(page: str, content: Days) -> str:
    """Fill the tables of a page."""
    return _MADE.sub(lambda mark: f"{mark[1]}\n{TABLES[mark[2]](content)}\n\n{mark[3]}", page)


def main() -> None:
    """Simulate days that are not in the cache, draw the figures, fill the tables of all pages, and run the notebook."""
    days.save(days.results())
    content = days.load()
    figures.draw()
    for path in sorted(PAGES.glob("*.md")):
        sys.stderr.write(f"{path.name}\n")
        path.write_text(made(path.read_text(encoding="utf-8"), content), encoding="utf-8")
    sys.stderr.write(f"{notebook.NOTEBOOK.name}\n")
    notebook.write()


if __name__ == "__main__":
    main()
