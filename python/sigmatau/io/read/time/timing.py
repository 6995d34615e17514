"""Sampling times of a table: by its stamps, by the rate that the file states, or by the rate that the user gives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from sigmatau import units
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stamps import RateOverruled
from sigmatau.io.read.columns import Choice
from sigmatau.io.read.options import Options
from sigmatau.io.read.table import Table
from sigmatau.io.read.time import stamps
from sigmatau.io.read.time.placement import laid
from sigmatau.io.read.time.rows import in_order
from sigmatau.record.record import MIN_SAMPLES, stream_name

__all__ = ["Timing", "timed"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Sampling times of a stream."""

    rate: float  # Sampling rate. [Hz]
    start: float = 0.0  # Time of the first sample. [s]
    source: str = "given"  # How the rate was found, in words
    rows: NDArray[np.int64] | None = None  # See `sigmatau.io.read.time.stamps.Fit`; n is None where there are no stamps
    # See `sigmatau.io.read.time.stamps.Fit`; n is None where there are no stamps
    places: NDArray[np.int64] | None = None
    n: int | None = None  # See `sigmatau.io.read.time.stamps.Fit`; n is None where there are no stamps
    jitter: float | None = None  # Standard deviation of the stamps about the grid. [s]
    step: float = 0.0  # Resolution of their clock. [s]
    counted: bool = False  # Whether the stamps show lost samples
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()

    def laid(self, column: NDArray[Any]) -> NDArray[Any]:
        """A column of the table on this grid."""
        return laid(column, self.rows, self.places, self.n)


def timed(
    table: Table,
    choice: Choice,
    raw: Mapping[int, NDArray[Any]],
    spelled: str | None,
    options: Options,
    stream: str = "",
    own: NDArray[np.int64] | None = None,
) -> Timing:
    """Sampling times of all rows, or of the rows `own` that only one stream fills."""
    if choice.time is None:
        if options.rate is None and table.rate is None:
            raise OptionError(
                "has no time column: give --rate HZ, or name the column with --channels time=…", option="rate"
            )
        if options.rate is None and table.rate is not None:
            source = table.rate_source or "the file"
            return Timing(rate=table.rate, source=source, notes=(f"sampling rate {table.rate:.6g} Hz from {source}",))
        rate = cast("float", options.rate)
        return Timing(rate=rate, findings=_rate_overruled(rate, table))
    name = table.label(choice.time)
    stamps_raw = raw[choice.time]
    members = [i for channel, i in choice.channels.items() if not stream or stream_name(channel) == stream]
    if own is None:
        used = in_order(stamps_raw, [raw[i] for i in members], table.where, name)
    else:
        if len(own) < MIN_SAMPLES:
            raise RecordTooShortError(
                f"has {len(own)} rows with {stream}; at least {MIN_SAMPLES} are needed", need=MIN_SAMPLES, got=len(own)
            )
        used = in_order(stamps_raw[own], [raw[i][own] for i in members], table.where, name, own)
    if len(used.stamps) < 2:
        raise RecordTooShortError(
            f"has {len(used.stamps)} rows with a time stamp", need=MIN_SAMPLES, got=len(used.stamps)
        )
    second = None
    if spelled is not None:
        second = units.find(spelled).factor * float(options.scale.get("time", 1.0))
        if second < 0:
            raise OptionError("the scale of time must be positive", option="scale")
    elif options.rate is None:
        raise stamps.without_unit(used.stamps, used.intervals, name)
    found = stamps.fit(used, second, table.where, name, rate=options.rate)
    findings = found.findings
    notes = found.notes
    if options.rate is None:
        notes = (*notes, f"sampling rate {found.rate:.6g} Hz from {found.source}")
    elif second is None:
        notes = (f"time stamps in column {name} checked for order and gaps only",)
    else:
        findings = (*stamps.mismatch(options.rate, found, options.input), *findings)
    if own is not None:
        findings = tuple(f if f.channels else replace(f, channels=(stream,)) for f in findings)
        notes = (*notes, f"{stream} in {len(own)} of {len(stamps_raw)} rows, with the stamps of these")
    return Timing(
        rate=found.rate if options.rate is None else options.rate,
        start=0.0 if second is None else found.start,
        source=_source(found, options.rate, known=second is not None),
        rows=found.rows,
        places=found.places,
        n=found.n,
        jitter=found.jitter,
        step=found.step,
        counted=found.on_grid,
        notes=notes,
        findings=findings,
    )


def _source(found: stamps.Fit, given: float | None, *, known: bool) -> str:
    """How the rate was found: "given" alone means that the log does not confirm it."""
    if given is None:
        return found.source
    return f"given, and {found.source} agree" if known and not stamps.mismatch(given, found) else "given"


def _rate_overruled(rate: float, table: Table) -> tuple[Finding, ...]:
    if table.rate is None or math.isclose(rate, table.rate, rel_tol=1e-3):
        return ()
    return (Finding(details=RateOverruled(given=rate, stated=table.rate), severity="warning"),)
