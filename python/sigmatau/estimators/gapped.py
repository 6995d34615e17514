"""Running Allan variance of a channel with missing samples, in bounded memory; sums of consecutive stretches can be
merged.

The samples between two gaps form a run, which has an `Accumulator`. A pair of clusters counts if it lies within one
run: the variance is the mean of all these pairs. Pairs across a gap are lost, and with them the averaging times that
are longer than half the longest run. For noise with stationary increments the mean is unbiased, because each pair is
complete; it has fewer pairs than the same record without gaps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import RecordTooShortError
from sigmatau.estimators.accumulator import Accumulator
from sigmatau.estimators.allan import DeviationCurve


class GappedSums:
    """Sums of consecutive samples of one channel, NaN where one is missing.

    Parameters
    ----------
    new : callable
        Returns an empty `Accumulator` of the channel that begins at a given index in the record.
    start : int
        Index in the record of the first sample.
    """

    __slots__ = ("_closed", "_curve", "_first", "_last", "_new", "missing", "start", "stop")

    def __init__(self, new: Callable[[int], Accumulator], start: int = 0) -> None:
        self._new = new
        self.start: int = int(start)
        self.stop: int = self.start
        self.missing: int = 0
        self._first: Accumulator | None = None  # run that begins with the first sample
        self._last: Accumulator | None = None  # run that ends with the last sample, if there is a gap before it
        self._closed: dict[
            int, tuple[int, float, float, int]
        ] = {}  # by size: pairs, sums of variances and ramps, stride
        self._curve: DeviationCurve | None = None  # curve of any run, a template for names and units

    def push(self, x: Floats) -> None:
        """Add the next samples, shape (n,)."""
        bad = np.flatnonzero(~np.isfinite(x))
        start = 0
        for k in [*bad.tolist(), len(x)]:
            if k > start:
                self._run().push(x[start:k])
                self.stop += k - start
            if k < len(x):
                self._lose()
            start = k + 1

    def _run(self) -> Accumulator:
        """The run to which the next sample belongs."""
        if not self.missing:
            self._first = self._first or self._new(self.stop)
            return self._first
        self._last = self._last or self._new(self.stop)
        return self._last

    def _lose(self) -> None:
        """Record that the next sample is missing."""
        if self._last is not None:
            self._close(self._last)
            self._last = None
        self.missing += 1
        self.stop += 1

    def merge(self, later: GappedSums) -> None:
        """Add the samples of the next stretch; `later` must not be used afterwards.

        Raises
        ------
        ValueError
            If it does not begin where this one ends.
        """
        if later.start != self.stop:
            raise ValueError(f"the stretch to merge begins at sample {later.start}, this one ends before {self.stop}")
        if later._first is not None:
            if (self._last if self.missing else self._first) is not None:
                self._run().merge(later._first)
            elif self.missing:
                self._last = later._first
            else:
                self._first = later._first
        if later.missing:
            if self._last is not None:
                self._close(self._last)
            self._last = later._last
            for m, (pairs, variances, ramps, stride) in later._closed.items():
                self._add(m, pairs, variances, ramps, stride)
        self._curve = _template(self._curve, later._curve)
        self.missing += later.missing
        self.stop = later.stop

    def _close(self, run: Accumulator) -> None:
        for m, pairs, variance, ramp, stride in self._rows(run):
            self._add(m, pairs, pairs * variance, pairs * ramp, stride)

    def _add(self, m: int, pairs: int, variances: float, ramps: float, stride: int) -> None:
        before = self._closed.get(m, (0, 0.0, 0.0, stride))
        self._closed[m] = (before[0] + pairs, before[1] + variances, before[2] + ramps, stride)

    def _rows(self, run: Accumulator) -> list[tuple[int, int, float, float, int]]:
        try:
            (curve,) = run.snapshot().values()
        except RecordTooShortError:  # the run is shorter than two clusters of any size
            return []
        self._curve = _template(self._curve, curve)
        strides = np.ones_like(curve.m) if curve.stride is None else curve.stride
        columns = (curve.m, curve.n_pairs, curve.avar, curve.ramp, strides)
        return list(zip(*(column.tolist() for column in columns), strict=True))

    def snapshot(self) -> DeviationCurve:
        """The curve of the samples so far.

        Raises
        ------
        RecordTooShortError
            If no run has two clusters of any size.
        """
        if self._first is not None and not self.missing:
            (curve,) = self._first.snapshot().values()
            return curve
        whole = dict(self._closed)
        for run in filter(None, (self._first, self._last)):
            for m, pairs, variance, ramp, stride in self._rows(run):
                before = whole.get(m, (0, 0.0, 0.0, stride))
                whole[m] = (before[0] + pairs, before[1] + pairs * variance, before[2] + pairs * ramp, stride)
        n = self.stop - self.start
        if self._curve is None:
            raise RecordTooShortError(
                f"no run of samples between two gaps has two clusters ({self.missing} of {n} samples missing)",
                need=2,
                got=0,
            )
        sizes = np.array(sorted(whole), dtype=np.int64)
        columns = [np.array([whole[k][column] for k in sizes.tolist()]) for column in range(4)]
        counts, strides = columns[0], columns[3]
        like = self._curve
        return DeviationCurve(
            channel=like.channel,
            quantity=like.quantity,
            unit=like.unit,
            m=sizes,
            tau=np.asarray(sizes * like.tau0, dtype=np.float64),
            avar=columns[1] / counts,
            n_pairs=counts,
            ramp=columns[2] / counts,
            n=n,
            tau0=like.tau0,
            stride=strides if (strides > 1).any() else None,
            missing=self.missing,
        )


def _template(first: DeviationCurve | None, second: DeviationCurve | None) -> DeviationCurve | None:
    return second if first is None else first
