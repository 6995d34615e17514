"""The page of promises: each figure stands on the page that it cites, and each named test, study and file exists."""

import re
from importlib.util import find_spec

import pytest

from conftest import ROOT

DOCS = ROOT / "docs"
PAGE = (DOCS / "promises.md").read_text(encoding="utf-8")
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ") and not line.startswith(("| promise", "|---"))]


def test_the_figures_are_those_of_their_pages():
    quoted = [(row, figure) for row in ROWS for figure in re.findall(r'"([^"]*\d[^"]*|All rows meet it)"', row)]
    assert len(quoted) >= 8
    for row, figure in quoted:
        (page,) = re.findall(r"\]\((study/[\w-]+\.md|fuzzing\.md|scale\.md)\)", row)
        text = " ".join((DOCS / page).read_text(encoding="utf-8").split()).replace("\u00a0", " ")
        assert figure in text, (figure, page)


@pytest.mark.parametrize("name", sorted(set(re.findall(r"(?:tests|studies)/[\w/.-]*\w", PAGE))))
def test_named_files_exist(name):
    assert (ROOT / name).exists()


@pytest.mark.parametrize("module", sorted(set(re.findall(r"python -m ([\w.]+)", PAGE))))
def test_named_programs_exist(module):
    assert find_spec(module) is not None
