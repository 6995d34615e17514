"""Work side by side: results by name, the first error in the order of the names, the facts of the caller."""

import threading

import numpy as np
import pytest

from sigmatau import Record
from sigmatau.quality.facts import _FACTS, channel_fact, forget, in_threads, keep_facts

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
        return id(_FACTS.get())

    with keep_facts():
        assert set(in_threads(facts, ("a", "b"), 2).values()) == {id(_FACTS.get())}


def test_only_the_facts_of_these_samples_are_forgotten():
    asked = []

    @channel_fact
    def size(stream, channel):
        asked.append((stream.name, channel))
        return float(stream.column(channel).std())

    record = Record.from_arrays(rate=100, gyro=np.eye(6)[:, :3].copy(), accel=np.eye(6)[:, 3:].copy())
    gyro, accel = record.streams
    with keep_facts():
        for _ in range(2):
            assert size(gyro, "gyro_x") == size(accel, "accel_x")
        forget(gyro)
        size(gyro, "gyro_x"), size(accel, "accel_x")
        assert asked == [("gyro", "gyro_x"), ("accel", "accel_x"), ("gyro", "gyro_x")]
    forget(gyro)
