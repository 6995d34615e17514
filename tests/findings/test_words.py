"""The words of findings: a golden file per subject, and the rules of plain technical English.

Each kind of `sigmatau.findings` has one or more findings in `EXAMPLES` of a module ``examples_SUBJECT`` here, and
``SUBJECT.txt`` has their words. ``UPDATE_WORDS=1`` writes these files anew.
"""

import importlib
import os
import re
from pathlib import Path

import pytest

from sigmatau.findings import details_by_code
from sigmatau.findings.phrases import largest_factor_text, leave_out_hint, window_hint
from sigmatau.hints import Hint

HERE = Path(__file__).parent
SUBJECTS = sorted(path.stem.removeprefix("examples_") for path in HERE.glob("examples_*.py"))
LONGEST = 120  # characters of a sentence, see CONTRIBUTING
PUNS = re.compile(r"\b(so many|of which|is no |are no |there is none|none of the|of its own|seen to|see to|on end)\b")


def examples(subject):
    return importlib.import_module(f"examples_{subject}").EXAMPLES


def test_every_kind_has_an_example():
    shown = {type(one.details) for subject in SUBJECTS for one in examples(subject)}
    lacking = {kind.__name__ for kind in {*details_by_code().values()} - shown}
    assert not lacking, f"add to `EXAMPLES` in tests/findings/examples_SUBJECT.py: {sorted(lacking)}"
    assert shown == {*details_by_code().values()}


@pytest.mark.parametrize("subject", SUBJECTS)
def test_words_are_those_of_the_golden_file(subject):
    said = ((one.code, *one.words_of_files()) for one in examples(subject))
    text = "".join(f"{code}\n    {message}\n    {action}\n" for code, message, action in said)
    golden = HERE / f"{subject}.txt"
    if os.environ.get("UPDATE_WORDS"):
        golden.write_text(text, encoding="utf-8")
    words = golden.read_text(encoding="utf-8")
    assert text == words, (
        f"if the words are right: UPDATE_WORDS=1 .venv/bin/python -m pytest tests/findings, read {subject}.txt"
    )


@pytest.mark.parametrize("subject", SUBJECTS)
def test_sentences_are_short_and_plain(subject):
    for one in examples(subject):
        for sentence in one.words_of_files():
            assert len(sentence) <= LONGEST, (one.code, len(sentence), sentence)
            assert not PUNS.search(sentence), (one.code, sentence)
            assert not sentence.endswith("."), (one.code, sentence)
        assert one.message, one.code


@pytest.mark.parametrize("subject", SUBJECTS)
def test_python_names_arguments(subject):
    for one in examples(subject):
        for sentence in (one.message, one.action):
            assert sentence.isprintable(), one.code
            assert " --" not in sentence or "sigmatau " in sentence, (one.code, sentence)


def test_codes_are_unique():
    kinds = {type(one.details) for subject in SUBJECTS for one in examples(subject)}
    assert len({kind.code for kind in kinds}) == len(kinds)


def test_options_leave_out_the_whole_of_a_fault():
    """Times have milliseconds: the ends of what is left out are rounded outwards, those of what is kept inwards."""
    assert leave_out_hint([(720.0006, 722.0002)]) == Hint("leave_out", value="720s:722.001s")
    assert window_hint((600.0004, 7200.0016)) == Hint("window", value="600.001s:7200.001s")


def test_the_factor_farthest_from_one_is_named():
    """By its ratio: half is farther than a quarter more."""
    assert (
        largest_factor_text([("random_walk", 1.25), ("rate_random_walk", 0.5)]) == "rate random walk 2 times too small"
    )
    assert largest_factor_text([("random_walk", 3.0), ("rate_random_walk", 0.5)]) == "random walk 3 times too large"
    assert largest_factor_text([("random_walk", 1.0)]) == "no coefficient changed"
