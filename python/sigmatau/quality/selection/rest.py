"""Verdict on a record (at rest, partly at rest, not at rest, too short to tell), and the part that is analysed.

A record that is partly at rest is cut to the longest stretch at rest. If the mean of a sensor is the same before and
after a motion, to within its drift, only the motion is left out: its samples count as missing.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from sigmatau.arrays import Floats, column_counts
from sigmatau.findings.finding import Finding, Severity, Span
from sigmatau.findings.rest import AssumedAtRest, KeptOfStream, Motion, NotAtRest, PartlyAtRest, TooShortToTell
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.quality.motion.stillness import find_movement
from sigmatau.quality.samples.common import present, row_means
from sigmatau.quality.samples.disturbances import without
from sigmatau.quality.samples.masking import mask_from_spans, masked
from sigmatau.quality.sensor_class import SENSOR_CLASSES
from sigmatau.record.record import MIN_SAMPLES, Record
from sigmatau.record.streams import Stream
from sigmatau.results import plain_value

Verdict = Literal["at_rest", "partly_at_rest", "not_at_rest", "too_short_to_tell"]

_AS_NOISE = command("analyze", Hint("at_rest", value=True))
_NO_COEFFICIENTS = {
    "not_at_rest": (
        f"the sensor was not at rest, so the result has no coefficients; {_AS_NOISE} treats motion as noise"
    ),
    "too_short_to_tell": (
        "the record is too short to tell rest from motion, so the result has no coefficients; record for longer, or run"
        f" {_AS_NOISE}"
    ),
}
_REASONS = {"not_at_rest": "not at rest", "too_short_to_tell": "too short to tell rest from motion"}


# Shortest stretch at rest that is analysed. [s] Judgement: as the shortest record with accelerometers alone, see
# `_SHORTEST`.
_MIN_STILL = 20.0
# Smallest share of the longest stretch in a record that is partly at rest. [1] Judgement: by chance, a moving sensor is
# at rest for a shorter time.
_MIN_SHARE = 0.25
# Smallest share of all stretches in a record that is partly at rest. [1] Judgement: allows for a record in several
# positions.
_MIN_SUM = 0.5
# Number of stretches at rest that a finding about motion lists. [1] Judgement: the longest are enough to choose from.
_LISTED = 3
# Largest loss of a record that is only an info, as a share. [1] Judgement: intervals become 5 % wider.
_MINOR_LOSS = 0.1
# Longest means that are compared before and after a motion. [s] Judgement: the drift over a minute is small.
_MEAN = 60.0
# Longest such means, as a share of the longer of the two stretches. [1] Judgement: each then has several differences.
_MEAN_SHARE = 0.1
# Difference of the means before and after a motion, over the root mean square of differences without motion above
# which the position has changed. [1] Derived: noise exceeds it in 0.3 % of the cases.
_OTHER_POSITION = 3.0
# Smallest number of differences without motion. [1] Judgement: their root mean square then has an error of a quarter.
_MIN_DIFFERENCES = 8
# Length of the shortest record that can be judged. [s] Study: docs/study/rest.md lists the shares of moving records
# that shorter records hide.
_SHORTEST = {"angular_rate": 10.0, "acceleration": 20.0}
# Length of the shortest record that can be judged. [samples] Study: docs/study/rest.md.
_MIN_SAMPLES = 150
# Smallest share of that length that counts as long enough. [1] Judgement: a record of 10 s may lack its last samples.
_LONG_ENOUGH = 0.99


@frozen
class Rest:
    """Whether the sensors of a record are at rest.

    Attributes
    ----------
    verdict : {"at_rest", "partly_at_rest", "not_at_rest", "too_short_to_tell"}
    still : tuple of (float, float)
        Stretches at rest of 20 s or longer, in order of time, from the beginning of the whole record. [s]
    motion : Motion or None
        The strongest motion; None at rest.
    duration : float
        Length of the samples that were judged. [s]
    shortest : float
        Shortest record that the test can judge. [s]
    """

    verdict: Verdict
    still: tuple[Span, ...]
    motion: Motion | None = None
    duration: float = math.inf
    shortest: float = 0.0

    @property
    def is_usable(self) -> bool:
        """Whether the record or a part of it is at rest, so that there are coefficients."""
        return self.verdict in ("at_rest", "partly_at_rest")

    @property
    def reason(self) -> str:
        """Why there are no coefficients: not at rest, or too short to tell; empty if there are coefficients."""
        return _REASONS.get(self.verdict, "")

    @property
    def unit_in_doubt(self) -> bool:
        """Whether the only sign of motion is a rate or a noise beyond that of any gyro, which a wrong unit would also
        explain.
        """
        return self.motion is not None and self.motion.kind in ("turns", "loud")

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "verdict": self.verdict,
            "still_s": [list(span) for span in self.still],
            "motion": plain_value(self.motion),
            **({"shortest_s": self.shortest} if self.verdict == "too_short_to_tell" else {}),
        }


def reason_without_fits(rest: Rest | None, *, has_read_off: bool = False) -> str:
    """Reason why a result has no fit: motion, a record that is too short to tell, or coefficients that were only read
    off.

    Empty if it has a fit.
    """
    reason = "" if rest is None else _NO_COEFFICIENTS.get(rest.verdict, "")
    if has_read_off:
        return "the coefficients were only read off; a model needs a fit (method likelihood)"
    return reason


def rest(record: Record, *, threads: int | None = None) -> Rest:
    """Judge whether a record is at rest, from its angular rates and accelerations.

    Parameters
    ----------
    record : Record
        Samples may be missing; spikes and runs of identical values do not count as motion.
    threads : int, optional
        Default: all processors.
    """
    begins, ends = _ends(record)
    movement = find_movement(record.streams, threads=threads)
    if movement.spans:  # bad samples also shift means
        movement = find_movement(map(_without_faults, record.streams), threads=threads)
    spans, motion = movement.spans, movement.motion
    if motion is None:
        duration, shortest = judged_length(record.streams), shortest_record(record.streams)
        if is_too_short(duration, shortest):
            return Rest(verdict="too_short_to_tell", still=(), duration=duration, shortest=shortest)
        return Rest(verdict="at_rest", still=((begins, ends),))
    edges = [begins, *(edge for span in spans for edge in span), ends]
    between = zip(edges[::2], edges[1::2], strict=True)
    still = tuple((start, stop) for start, stop in between if stop - start >= _MIN_STILL)
    return Rest(verdict="partly_at_rest" if partly(still, ends - begins) else "not_at_rest", still=still, motion=motion)


def partly(still: Sequence[Span], duration: float) -> bool:
    """Whether a record of `duration` [s] with motion is at rest for long enough to be analysed in part."""
    lengths = [stop - start for start, stop in still if stop - start >= _MIN_STILL]
    return bool(lengths) and (max(lengths) >= _MIN_SHARE * duration or sum(lengths) >= _MIN_SUM * duration)


def at_rest_only(record: Record, resting: Rest, *, assumed: bool) -> tuple[Record, list[Finding]]:
    """Select the part of a record that is analysed, and report it; no finding for a record at rest.

    Parameters
    ----------
    record : Record
    resting : Rest
        Verdict on the record.
    assumed : bool
        Whether the whole record is analysed regardless of the verdict.
    """
    if not resting.is_usable or resting.motion is None or assumed:
        begins, ends = _ends(record)
        return record, rest_findings(resting, assumed=assumed, duration=ends - begins)
    longest = max(resting.still, key=lambda span: span[1] - span[0])
    streams, parts = [], list[KeptOfStream]()
    for stream in record.streams:
        if stream.quantity not in ("angular_rate", "acceleration"):
            streams.append(stream)
            continue
        part = _still_part(stream, resting.still, longest)
        streams.append(part)
        missing = 0.0 if part.mask is None else float(functools.reduce(np.logical_and, part.mask.T).mean())
        gone = part.grid.duration * missing
        start, stop = part.grid.lead, part.grid.lead + part.grid.duration
        share = (stop - start - gone) / stream.grid.duration
        parts.append(KeptOfStream(stream=stream.name, start=start, stop=stop, left_out=gone, share=share))
    begins, ends = _ends(record)
    edges = [begins, *(edge for span in resting.still for edge in span), ends]
    moved = tuple((a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a)
    conversion = f"left out, not at rest: {', '.join(f'{a:.6g} s to {b:.6g} s' for a, b in moved[:5])}"
    provenance = replace(record.provenance, conversions=(*record.provenance.conversions, conversion))
    findings = rest_findings(resting, assumed=assumed, duration=ends - begins, parts=tuple(parts), moved=moved)
    return replace(record, streams=tuple(streams), provenance=provenance), findings


def rest_findings(
    resting: Rest, *, assumed: bool, duration: float, parts: tuple[KeptOfStream, ...] = (), moved: tuple[Span, ...] = ()
) -> list[Finding]:
    """Report the verdict; no finding for a record at rest.

    Parameters
    ----------
    resting : Rest
    assumed : bool
        Whether the whole record is analysed regardless of the verdict.
    duration : float
        Duration of the record. [s]
    parts : tuple of KeptOfStream
        Analysed parts of the streams, for a record partly at rest.
    moved : tuple of (float, float)
        Stretches in motion. [s]
    """
    if resting.verdict == "too_short_to_tell":
        short = TooShortToTell(duration=resting.duration, shortest=resting.shortest)
        return [Finding(details=short, severity="info" if assumed else "error")]
    if resting.motion is None:
        return []
    if assumed:
        return [Finding(details=AssumedAtRest(motion=resting.motion), severity="info")]
    if resting.verdict == "not_at_rest":
        longest = sorted(resting.still, key=lambda span: span[0] - span[1])[:_LISTED]
        details = NotAtRest(motion=resting.motion, duration=duration, still=tuple(longest))
        return [Finding(details=details, severity="error")]
    lost = 1 - min(part.share for part in parts)
    partly_at_rest = PartlyAtRest(motion=resting.motion, moved=moved, kept=parts)
    severity: Severity = "info" if lost < _MINOR_LOSS else "warning"
    return [Finding(details=partly_at_rest, severity=severity, spans=moved, size=lost)]


def _ends(record: Record) -> Span:
    """Beginning and end of the streams of a record. [s]"""
    grids = [stream.grid for stream in record.streams]
    return min(grid.lead for grid in grids), max(grid.lead + grid.duration for grid in grids)


def _without_faults(stream: Stream) -> Stream:
    """Remove bad samples, but keep shocks and start transients, which may be motion."""
    return without(stream, keep=("start", "shocks", "copies"))[0]


def _still_part(stream: Stream, still: Sequence[Span], longest: Span) -> Stream:
    """Select the longest stretch at rest, extended by neighbouring stretches with the same mean."""
    stretches = [(_sample_index(stream, start), _sample_index(stream, stop)) for start, stop in still]
    stretches = [(a, b) for a, b in stretches if b - a >= MIN_SAMPLES]
    k = min(range(len(stretches)), key=lambda i: abs(stretches[i][0] - _sample_index(stream, longest[0])))
    first = last = k
    while first > 0 and _same_level(stream, stretches, first - 1):
        first -= 1
    while last + 1 < len(stretches) and _same_level(stream, stretches, last):
        last += 1
    start, stop = stretches[first][0], stretches[last][1]
    gaps = [
        (b - start, c - start)
        for (_, b), (c, _) in zip(stretches[first:last], stretches[first + 1 : last + 1], strict=True)
    ]
    part = stream if (start, stop) == (0, stream.grid.n) else stream.cut(start, stop)
    return masked(part, mask_from_spans(part.grid.n, gaps))


def _sample_index(stream: Stream, time: float) -> int:
    return min(max(stream.grid.sample(time), 0), stream.grid.n)


def _same_level(stream: Stream, stretches: Sequence[tuple[int, int]], k: int) -> bool:
    """Whether the mean of every channel is the same before and after the motion between stretches k and k + 1."""
    (a, b), (c, d) = stretches[k], stretches[k + 1]
    length = min(_MEAN / stream.grid.tau0, _MEAN_SHARE * max(b - a, d - c), b - a, d - c)
    w = max(int(length), 1)
    lag = w + c - b
    for channel in range(len(stream.channels)):
        change = _mean(stream, channel, c, c + w) - _mean(stream, channel, b - w, b)
        usual = np.concatenate([_differences(stream, channel, start, stop, w, lag) for start, stop in stretches])
        if len(usual) < _MIN_DIFFERENCES:
            return False
        if not abs(change) <= _OTHER_POSITION * float(np.sqrt(np.mean(usual * usual))):
            return False
    return True


def _mean(stream: Stream, channel: int, start: int, stop: int) -> float:
    x = present(stream.samples.read(channel, start, stop))
    return float(x.mean()) if len(x) else float("nan")


def _differences(stream: Stream, channel: int, start: int, stop: int, w: int, lag: int) -> Floats:
    """Differences of means of w samples that are `lag` samples apart, rounded to a whole number of means."""
    n = (stop - start) // w
    apart = max(round(lag / w), 1)
    if n <= apart:
        return np.zeros(0)
    x = stream.samples.read(channel, start, start + n * w)
    means = row_means(x.reshape(n, w))
    return present(means[apart:] - means[:-apart])


def shortest_record(streams: Sequence[Stream]) -> float:
    """Shortest record that can be judged, for the sensor that needs the least. [s]

    It is 0 without a gyro or an accelerometer, because other quantities are not judged.
    """
    return min(
        (shortest_length([stream.quantity], stream.grid.tau0) for stream in streams if _is_judged(stream)), default=0.0
    )


def shortest_length(quantities: Iterable[str], tau0: float) -> float:
    """Length of the shortest record of some quantities with the same sample interval. [s]"""
    lengths = [_SHORTEST[quantity] for quantity in quantities if quantity in SENSOR_CLASSES]
    return max(min(lengths), _MIN_SAMPLES * tau0) if lengths else 0.0


def judged_length(streams: Sequence[Stream]) -> float:
    """Total length of the present samples, in the stream with the most. [s]"""
    return max(map(_present_length, filter(_is_judged, streams)), default=0.0)


def is_too_short(duration: float, shortest: float) -> bool:
    """Whether a record is clearly shorter than the shortest that can be judged, not only by some samples at its ends."""
    return duration < _LONG_ENOUGH * shortest


def _is_judged(stream: Stream) -> bool:
    return stream.quantity in SENSOR_CLASSES


def _present_length(stream: Stream) -> float:
    missing = 0.0 if stream.mask is None else float(column_counts(stream.mask).min() / stream.grid.n)
    return stream.grid.duration * (1 - missing)
