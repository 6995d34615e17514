"""Spans of a finding: the longest of many, in order of time."""

import numpy as np

from sigmatau.findings.spans import MAX_SPANS, longest_spans


def test_the_longest_of_many_are_listed_in_order():
    starts = np.arange(0.0, 3 * MAX_SPANS, 3.0)
    lengths = np.ones(len(starts))
    assert longest_spans(starts, starts + lengths) == (tuple((x, x + 1) for x in starts), 0)
    starts, lengths = np.append(starts, 4e3), np.append(lengths, 2.0)
    spans, more = longest_spans(starts, starts + lengths)
    assert (len(spans), more) == (MAX_SPANS, 1)
    assert spans[-1] == (4e3, 4002.0)  # the longest, and the first of the others
    assert spans[:-1] == tuple((x, x + 1) for x in starts[: MAX_SPANS - 1])
