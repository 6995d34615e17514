"""Analysis of a log while it is written: running sums of the received samples, with curves and coefficients at any time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from sigmatau.analysis.entry import of_curves
from sigmatau.analysis.recent import RecentChannel, RecentSamples
from sigmatau.analysis.result import Analysis
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import Accumulator
from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import RateMismatch
from sigmatau.findings.reading import SkippedMessages
from sigmatau.findings.stamps import BadStamps, IrregularStamps
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.outlook import outlook
from sigmatau.io.live import Live
from sigmatau.noise.terms import check_shown
from sigmatau.quality.selection.live import LiveStretches
from sigmatau.record.record import MIN_SAMPLES, Provenance, conversion, stream_name
from sigmatau.record.sampling import Sampling, sampling_text
from sigmatau.results import duration_text

_EQUAL_RATES = 1e-3  # largest relative difference of rates that count as equal


class LiveAnalysis:
    """Analysis of the samples received so far from a live log."""

    def __init__(self, source: str, live: Live, *, at_rest: bool = False) -> None:
        self.name: str = "standard input" if source == "-" else source
        self.live = live
        self.at_rest = at_rest
        self.stretches: LiveStretches | None = None
        self._recent: RecentSamples | None = None

    def take(self, piece: bytes, *, last: bool = False) -> None:
        """Process the next bytes; `last`: whether they are the last ones.

        Raises
        ------
        DataError, OptionError
            If the lines are not a table, or an option is missing; the error names the source.
        """
        try:
            samples = self.live.push(piece, last=last)
        except (DataError, OptionError) as error:
            raise error.about(self.name) from None
        if self.live.channels and self.stretches is None:
            stated = {c: u for c, u in self.live.unit.items() if c in self.live.channels}
            kind: Any = self.live.options.input
            check_shown({c: conversion(c, stated, kind)[:2] for c in self.live.channels})
            self.stretches = LiveStretches(
                self.live.channels, rate=self.live.rate, unit=stated, input=kind, assumed=self.at_rest
            )
            self._recent = RecentSamples(len(self.live.channels), self.live.rate)
        if self.stretches is not None and self._recent is not None and len(samples):
            self.stretches.push(samples)
            self._recent.push(samples)

    def _with_rate(self, sums: Accumulator) -> Accumulator:
        """Replace the rate from the first stamps by that from all stamps. Increments were divided by the first rate."""
        measured = self.live.rate_by_stamps()
        if measured and self.live.options.rate is None and self.live.options.input == "rate":
            sums.tau0 = 1 / measured
            self.live.rate = measured
        return sums

    def finish(self) -> None:
        """Process the samples of the last, incomplete block."""
        if self.stretches is not None:
            self.stretches.finish()

    def analysis(self) -> Analysis:
        """Curves and coefficients of the samples so far.

        Raises
        ------
        RecordTooShortError
            Before two blocks are complete.
        """
        n = 0 if self.stretches is None else self.stretches.n
        if self.stretches is None or self.stretches.sums.n < MIN_SAMPLES:
            raise RecordTooShortError(
                f"{self.name}: has {n} samples; at least {MIN_SAMPLES} are needed", need=MIN_SAMPLES, got=n
            )
        resting = self.stretches.rest()
        moving = not resting.is_usable and not self.at_rest
        channels = list(self.live.channels)
        streams = dict.fromkeys(map(stream_name, channels))
        analysed = of_curves(
            self._with_rate(self.stretches.sums).snapshot(),
            source=Provenance(path=self.name, format="live", rows=n),
            findings=self.findings(),
            grids={name: self._sampling([c for c in channels if stream_name(c) == name]) for name in streams},
            method="read-off" if moving else "gls",
        )
        return replace(analysed, read_off={} if moving else analysed.read_off, rest=resting)

    def recent(self) -> dict[str, RecentChannel]:
        """Last minutes of each channel, as rates in SI; empty before the first samples."""
        recent, kind = self._recent, self.live.options.input
        if recent is None:
            return {}
        pictures = {}
        for k, channel in enumerate(self.live.channels):
            quantity, unit, factor = conversion(channel, self.live.unit, kind)
            factor *= recent.rate if kind == "increments" else 1.0
            pictures[channel] = RecentChannel(
                quantity=quantity,
                unit=unit,
                low=recent.low[:, k] * factor,
                high=recent.high[:, k] * factor,
                start=recent.first / recent.rate,
                duration=len(recent.low) * recent.width / recent.rate,
            )
        return pictures

    def outlooks(self, analysis: Analysis) -> list[tuple[str, str]]:
        """Gain of more samples, by sensor; see `sigmatau.fitting.outlook.outlook`."""
        by_sensor: dict[str, dict[str, NoiseFit]] = {}
        for channel, fitted in analysis.fits.items():
            by_sensor.setdefault(stream_name(channel), {})[channel] = fitted
        outlooks = {sensor: outlook(fits) for sensor, fits in by_sensor.items()}
        return [(sensor, str(expected)) for sensor, expected in outlooks.items() if expected is not None]

    def wait(self) -> str:
        """Reason why there are no coefficients yet, and the time until there are."""
        if self.stretches is None:
            return ""
        if self.stretches.moving:
            return "the sensor moves: no coefficients"
        first = max(self.stretches.first_block, self.stretches.rest().shortest)
        remaining = first - self.stretches.n / self.live.rate
        return f"too short to tell: coefficients in {duration_text(remaining)}" if remaining > 0 else ""

    def heading(self) -> str:
        """The source, its channels and its rate."""
        if self.stretches is None:
            return f"{self.name}: waiting for the first lines"
        moving = ", moving now" if self.stretches.moving else ""
        return f"{self.name}: {sampling_text(self._sampling(self.live.channels))}{moving}"

    def _sampling(self, channels: Sequence[str]) -> Sampling:
        n = 0 if self.stretches is None else self.stretches.n
        return Sampling(channels=tuple(channels), n=n, rate=self.live.rate, source=self.live.source_of_rate)

    def findings(self) -> list[Finding]:
        """Faults of the lines and the stamps, and motion, so far."""
        findings = [] if self.stretches is None else self.stretches.findings()
        if self.live.lost:
            lost = SkippedMessages(count=self.live.lost, unit="lines", example=self.live.lost_example)
            findings.append(Finding(details=lost, severity="warning"))
        if self.live.repeated:
            total = self.live.lines + self.live.repeated
            repeated = BadStamps(what="repeated", rows=total, place="the beginning of the input")
            findings.append(Finding(details=repeated, severity="warning", size=self.live.repeated))
        if self.live.leaps:
            findings.append(
                Finding(details=IrregularStamps(interval=1 / self.live.rate, leaps=self.live.leaps), severity="warning")
            )
        if (change := self.live.rate_change()) is not None:
            findings.append(change)
        measured = self.live.rate_by_stamps()
        if measured is not None and abs(measured / self.live.rate - 1) > _EQUAL_RATES:
            findings.append(Finding(details=RateMismatch(used=self.live.rate, other=measured), severity="warning"))
        return findings
