"""Other names of the noise terms: the glossary lists them, and each leads to one term."""

import pytest

from conftest import ROOT
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import TERMS


def test_the_glossary_has_the_names():
    glossary = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").lower()
    words = " ".join(glossary.replace("-", " ").replace("_", " ").split())
    names = [name for term in TERMS.values() for name in term.synonyms.split(", ")]
    assert len(names) == len(set(names))
    # Letters are symbols there; the other one is a spelling.
    lacking = [name for name in names if len(name) > 1 and name not in words and name != "quantisation"]
    assert not lacking, f"add to `also called` of the term in docs/glossary.md: {lacking}"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("ARW", "unknown term 'ARW'; it is random_walk here"),
        ("in-run_bias stability", "unknown term 'in-run_bias stability'; it is bias_instability here"),
        ("Q", "unknown term 'Q'; it is quantization (IEEE 952) or random_walk (the paper) here"),
        ("wander", f"unknown term 'wander'; terms: {', '.join(TERMS)}"),
    ],
)
def test_messages(name, message):
    assert unknown_term(name) == message
