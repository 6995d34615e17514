"""Exclusion of stretches of a record: their samples count as missing, and the grid stays as it is.

Unlike a window, it can leave out several short stretches from the middle of a record.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.findings.disturbances import LeftOut, LeftOutOfStream
from sigmatau.findings.finding import Finding
from sigmatau.quality.samples.disturbances import CAUSES, first_sample_from
from sigmatau.quality.samples.masking import masked
from sigmatau.quality.selection.time_text import parse_time
from sigmatau.record.record import MIN_SAMPLES, Record
from sigmatau.results import seconds

_FORMS = "give stretches such as 720s:722s,1080s:1083s, :10s or 2h:"
_LISTED = 5


def from_the_start(record: Record) -> Record:
    """Count the times of all streams from the beginning of the earliest one, as options do."""
    origin = min(stream.grid.start for stream in record.streams)
    if all(stream.grid.lead == stream.grid.start - origin for stream in record.streams):
        return record
    streams = (replace(s, grid=replace(s.grid, lead=s.grid.start - origin)) for s in record.streams)
    return replace(record, streams=tuple(streams))


def leave_out(record: Record, stretches: str | Sequence[str]) -> tuple[Record, list[Finding]]:
    """Mark some stretches of a record as missing on all sensors, and report the finding ``"left_out"``, an info.

    Parameters
    ----------
    record : Record
    stretches : str or sequence of str
        ``"720s:722s"``, ``"720s:722s,1080s:1083s"``, ``":10s"``, ``"2h:"``: times from the beginning of the record,
        without the end; units ms, s, min, h, d.

    Raises
    ------
    OptionError
        For any other text, for a stretch beyond the record, or if fewer than 4 samples remain.
    """
    parts = _parts(stretches)
    if not parts:
        raise OptionError(f"{{option}} names nothing: {_FORMS}", option="leave_out")
    end = max(stream.grid.lead + stream.grid.duration for stream in record.streams)
    spans = [_span(part, end, "leave_out") for part in parts]
    streams, left_out = [], list[LeftOutOfStream]()
    for stream in record.streams:
        if stream.quantity == "temperature":  # not affected by a disturbance of the sensors
            streams.append(stream)
            continue
        bad = np.zeros(stream.grid.n, dtype=bool)
        for start, stop in spans:
            bad[first_sample_from(stream, start) : first_sample_from(stream, stop)] = True
        count = int(bad.sum())
        if not count:
            streams.append(stream)
            continue
        left_out.append(
            LeftOutOfStream(stream=stream.name, count=count, samples=stream.grid.n, duration=count * stream.grid.tau0)
        )
        without = masked(stream, bad)
        remaining = 0 if without.mask is None else int((~without.mask).sum(axis=0).max())
        if remaining < MIN_SAMPLES:
            message = f"{{option}} leaves {remaining} samples of {stream.name}; at least {MIN_SAMPLES} are needed"
            raise OptionError(message, option="leave_out")
        streams.append(without)
    listed = [f"{seconds(a)} s to {seconds(b)} s" for a, b in spans[:_LISTED]]
    listed += [f"{len(spans) - _LISTED} more"] if len(spans) > _LISTED else []
    conversions = (*record.provenance.conversions, f"left out as asked: {', '.join(listed)}")
    provenance = replace(record.provenance, conversions=conversions)
    details = LeftOut(streams=tuple(left_out))
    finding = Finding(
        details=details, severity="info", spans=tuple(spans), size=float(sum(b - a for a, b in spans)), unit="s"
    )
    return replace(record, streams=tuple(streams), provenance=provenance), [finding]


def causes_to_keep(keep: str | Sequence[str]) -> tuple[str, ...]:
    """Causes of disturbances by their names, ``"spikes,shocks"`` or a sequence of them; ``"all"`` means all causes.

    Times in the text are ignored; `spans_to_keep` reads them.
    """
    names = [part for part in _parts(keep) if ":" not in part]
    for name in names:
        if name != "all" and name not in CAUSES:
            raise OptionError(
                f"{{option}} {name!r} must be all or some of {', '.join(CAUSES)}, or times such as 12s:12.5s",
                option="keep",
            )
    return tuple(CAUSES) if "all" in names else tuple(dict.fromkeys(names))


def spans_to_keep(keep: str | Sequence[str]) -> tuple[tuple[float, float], ...]:
    """Times in which no disturbance is left out, ``"12s:12.5s"``, in a text that may also name causes. Raises
    `OptionError`. [s]
    """
    return tuple(_span(part, math.inf, "keep") for part in _parts(keep) if ":" in part)


def _parts(texts: str | Sequence[str]) -> list[str]:
    """Split texts at commas."""
    listed = [texts] if isinstance(texts, str) else list(texts)
    return [part.strip() for text in listed for part in text.split(",") if part.strip()]


def _span(text: str, end: float, option: str) -> tuple[float, float]:
    first, colon, last = text.partition(":")
    if not colon or ":" in last or not (first.strip() or last.strip()):
        raise OptionError(f"{{option}} {text!r} is not understood: {_FORMS}", option=option)
    start = parse_time(first, text, option=option, forms=_FORMS) if first.strip() else 0.0
    stop = parse_time(last, text, option=option, forms=_FORMS) if last.strip() else end
    if start >= end:
        raise OptionError(
            f"{{option}} {text!r} begins at {seconds(start)} s; the record is {seconds(end)} s long", option=option
        )
    if start >= stop:
        raise OptionError(f"{{option}} {text!r} ends at {seconds(stop)} s, before it begins", option=option)
    return start, min(stop, end)
