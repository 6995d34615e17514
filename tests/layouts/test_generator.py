"""The corpus of layouts: names, answers, and the same bytes in every run."""

import hashlib

import pytest
from generator import LAYOUTS


def test_names_are_unique_and_sources_stated():
    assert len({described.name for described in LAYOUTS}) == len(LAYOUTS) >= 50
    assert all(described.source for described in LAYOUTS)


def test_a_question_has_an_answer_or_a_refusal_is_right():
    for described in LAYOUTS:
        assert described.asks or not described.answers, described.name
        assert described.readable or not described.answers, described.name


@pytest.mark.parametrize("described", LAYOUTS[::20], ids=lambda described: described.name)
def test_a_file_has_the_same_bytes_in_every_run(described, tmp_path):
    digests = []
    for run in ("first", "second"):
        (tmp_path / run).mkdir()
        digests.append(hashlib.sha256(described.save(tmp_path / run).read_bytes()).hexdigest())
    assert digests[0] == digests[1]
