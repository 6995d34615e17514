"""Work side by side: results by name, the first error in the order of the names, the facts of the caller."""

import threading

import pytest

from sigmatau.quality.facts import _KEPT, facts_kept, in_threads

NAMES = ("a", "b", "c", "d")


@pytest.mark.parametrize("threads", [1, 2, 8])
def test_results_in_the_order_of_the_names(threads):
    assert list(in_threads(str.upper, NAMES, threads).items()) == [("a", "A"), ("b", "B"), ("c", "C"), ("d", "D")]
    assert in_threads(str.upper, (), threads) == {}


@pytest.mark.parametrize("threads", [1, 2, 8])
def test_the_first_error_by_name(threads):
    def refuse(name):
        if name in "bd":
            raise ValueError(name)
        return name

    with pytest.raises(ValueError, match="b"):
        in_threads(refuse, NAMES, threads)


def test_threads_share_the_facts():
    """Both wait for each other, so that two threads are at work."""
    meeting = threading.Barrier(2, timeout=60)

    def facts(_):
        meeting.wait()
        return id(_KEPT.get())

    with facts_kept():
        assert set(in_threads(facts, ("a", "b"), 2).values()) == {id(_KEPT.get())}
