"""The README as the package index shows it: no link that leads nowhere, and the code as it is."""

import re

import pytest
from scripts_of import script

from conftest import ROOT

long_description = script("long_description")
README = (ROOT / "README.md").read_text(encoding="utf-8")
PLACE = "https://forge.example/sigmatau"


def targets(text):
    return re.findall(r"\]\(([^)]+)\)", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE))


def code(text):
    return re.findall(r"^```.*?^```", text, flags=re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("repository", [None, PLACE])
def test_links(repository):
    page = long_description.converted(README, repository=repository, tag="v1.2.3")
    assert targets(page)
    assert all(target.startswith(("https://", "#")) for target in targets(page))
    assert code(page) == code(README)
    assert len(code(page)) >= 4
    for heading in ("## Install", "## Analyse a log", "## Licence"):
        assert heading in page


def test_links_of_the_tag_when_the_repository_is_known():
    page = long_description.converted(README, repository=PLACE, tag="v1.2.3")
    assert f"]({PLACE}/blob/v1.2.3/docs/numbers.md)" in page
    assert f"]({PLACE}/raw/v1.2.3/docs/figures/demo.png)" in page
    assert len(targets(page)) == len(targets(README))


def test_words_stay_without_a_repository():
    page = long_description.converted("![x](a.png)\n\n[a](b.md) [c](https://d) `[e](f)`\n", repository=None, tag="v1")
    assert page == "\n\na [c](https://d) `e`\n"
    whole = long_description.converted(README, repository=None, tag="v1")
    assert "What the numbers mean" in whole
    assert "demo.png" not in whole
    assert "## Documentation" not in whole
