"""Running sums of live samples, for the longest stretch at rest and the longest in motion, in bounded memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.estimators.accumulator import Accumulator
from sigmatau.findings.finding import Finding, Span
from sigmatau.findings.rest import KeptOfStream, Motion
from sigmatau.quality.selection.rest import Rest, is_too_short, partly, rest, rest_findings, shortest_length
from sigmatau.record.record import MIN_SAMPLES, Record, stream_name
from sigmatau.record.streams import PLAUSIBLE_RATES

_SENSORS = {"gyro": "angular_rate", "accel": "acceleration"}


# Length of a block. [s] Judgement: three blocks are longer than a block of `sigmatau.quality.motion.stillness`.
_BLOCK = 30.0
# Smallest length of a block. [samples] Judgement: three blocks are longer than the shortest record, see
# `sigmatau.quality.selection.rest`.
_MIN_BLOCK = 64
# Largest length of a block. [samples] Judgement: limits the memory.
_MAX_BLOCK = 1 << 18


class LiveStretches:
    """Running sums of live samples, separate for stretches at rest and in motion.

    A block is summed only when the next block is complete, because a motion also affects the preceding seconds.

    Parameters
    ----------
    channels : sequence of str
    rate : float
        [Hz]
    unit : mapping of str to str
        By channel.
    input : {"rate", "increments"}
    assumed : bool
        Whether all samples count as at rest.
    """

    def __init__(
        self,
        channels: Sequence[str],
        *,
        rate: float,
        unit: Mapping[str, str],
        input: Literal["rate", "increments"],  # noqa: A002  as in `Accumulator`
        assumed: bool,
    ) -> None:
        self.channels: tuple[str, ...] = tuple(channels)
        self.rate = rate
        self.unit: dict[str, str] = dict(unit)
        self.input = input
        self.assumed = assumed
        self.judged: bool = PLAUSIBLE_RATES[0] <= rate <= PLAUSIBLE_RATES[1]
        self.n: int = 0  # samples received so far
        self.motion: Motion | None = None  # the strongest motion so far
        self._block = min(max(round(_BLOCK * rate), _MIN_BLOCK), _MAX_BLOCK)
        self._before: Floats = np.empty((0, len(self.channels)))  # the last block that was summed
        self._waiting: list[Floats] = []
        self._number = 0  # number of waiting samples
        self._moving = False
        self._current = self._new(0)
        self._longest: dict[bool, Accumulator] = {}  # longest ended stretch, by whether the sensor moves
        # first and last sample of each ended stretch, and whether the sensor moves in it
        self._stretches: list[tuple[int, int, bool]] = []

    def push(self, samples: Floats) -> None:
        """Take the next samples, shape (n, n_channels)."""
        self.n += len(samples)
        if not self.judged:
            self._current.push(samples)
            return
        self._waiting.append(samples)
        self._number += len(samples)
        if self._number >= 2 * self._block:
            x = np.concatenate(self._waiting)
            while len(x) >= 2 * self._block:
                self._add_block(x[: self._block], x[self._block : 2 * self._block])
                x = x[self._block :]
            self._waiting, self._number = [x], len(x)

    def finish(self) -> None:
        """Sum the samples that are waiting for a complete block."""
        if self._number:
            x = np.concatenate(self._waiting)
            self._add_block(x[: self._block], x[self._block :])
            if len(x) > self._block:
                self._add_block(x[self._block :], x[:0])
            self._waiting, self._number = [], 0

    @property
    def first_block(self) -> float:
        """Length of the record from which there are sums. [s]"""
        return 2 * self._block / self.rate if self.judged else 0.0

    @property
    def moving(self) -> bool:
        """Whether the sensor moves now."""
        return self._moving

    @property
    def sums(self) -> Accumulator:
        """Sums of the longest stretch at rest, or of the longest in motion if the sensor is not at rest."""
        moving = self.rest().verdict == "not_at_rest" and not self.assumed
        ended = self._longest.get(moving)
        if self._moving is not moving and not self.assumed:
            return ended or self._current
        return self._current if ended is None or self._current.n >= ended.n else ended

    def rest(self) -> Rest:
        """The verdict on the samples summed so far."""
        spans = self._spans()
        still = tuple((a, b) for a, b, moves in spans if not moves)
        length = spans[-1][1] if spans else 0.0
        if self.motion is None:
            shortest = shortest_length(
                (_SENSORS.get(stream_name(channel), "") for channel in self.channels), 1 / self.rate
            )
            if is_too_short(length, shortest):
                return Rest(verdict="too_short_to_tell", still=(), duration=length, shortest=shortest)
            return Rest(verdict="at_rest", still=((0.0, length),))
        verdict: Literal["partly_at_rest", "not_at_rest"] = "partly_at_rest" if partly(still, length) else "not_at_rest"
        return Rest(verdict=verdict, still=still, motion=self.motion)

    def findings(self) -> list[Finding]:
        """Report motion; empty at rest."""
        resting, spans = self.rest(), self._spans()
        length = spans[-1][1] if spans else 0.0
        start, stop = self.sums.start / self.rate, (self.sums.start + self.sums.n) / self.rate
        share = (stop - start) / length if length else 0.0
        names = dict.fromkeys(stream_name(channel) for channel in self.channels)
        return rest_findings(
            replace(resting, still=()),
            assumed=self.assumed,
            duration=length,
            parts=tuple(
                KeptOfStream(stream=name, start=start, stop=stop, left_out=0.0, share=share)
                for name in names
                if name in _SENSORS
            ),
            moved=tuple((a, b) for a, b, moves in spans if moves),
        )

    def _spans(self) -> list[tuple[float, float, bool]]:
        first = self._stretches[-1][1] if self._stretches else 0
        last = first + self._current.n
        stretches = [*self._stretches, *([(first, last, self._moving)] if last > first else [])]
        return [(a / self.rate, b / self.rate, moves) for a, b, moves in stretches]

    def _add_block(self, block: Floats, following: Floats) -> None:
        motion = self._motion(block, following)
        if motion is not None and (self.motion is None or motion.times > self.motion.times):
            self.motion = motion
        moving = motion is not None and not self.assumed
        if moving is not self._moving:
            self._begin_stretch(moving)
        self._current.push(block)
        self._before = block

    def _begin_stretch(self, moving: bool) -> None:  # noqa: FBT001
        ended = self._current
        if ended.n:
            self._stretches.append((ended.start, ended.start + ended.n, self._moving))
            before = self._longest.get(self._moving)
            if before is None or ended.n > before.n:
                self._longest[self._moving] = ended
            self._current = self._new(ended.start + ended.n)
        self._moving = moving

    def _motion(self, block: Floats, following: Floats) -> Motion | None:
        """The strongest motion of a block, judged with both neighbours; None if the whole block is at rest."""
        x = np.concatenate([self._before, block, following])
        if len(x) < MIN_SAMPLES:
            return None
        columns = dict(zip(self.channels, x.T.copy(), strict=True))
        record = Record.from_arrays(rate=self.rate, unit=self.unit, input=self.input, **columns)
        verdict = rest(record)
        begins = len(self._before) / self.rate
        ends = begins + len(block) / self.rate
        return None if any(_contains(span, begins, ends) for span in verdict.still) else verdict.motion

    def _new(self, start: int) -> Accumulator:
        stated = {channel: unit for channel, unit in self.unit.items() if channel in self.channels}
        return Accumulator(*self.channels, rate=self.rate, unit=stated, input=self.input, long="strided", start=start)


def _contains(span: Span, begins: float, ends: float) -> bool:
    slack = 1e-6 * (1 + ends)
    return span[0] <= begins + slack and ends <= span[1] + slack
