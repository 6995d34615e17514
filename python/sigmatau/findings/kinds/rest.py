"""Kinds of findings about a sensor that does not rest, or rests for a part of the record."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details, Span
from sigmatau.frozen import frozen


@frozen
class Motion:
    """The strongest sign that a sensor moves."""

    channel: str
    quantity: str  # of the channel
    kind: Literal["varies", "turns"]  # means that vary beyond noise, or a mean rate beyond any bias
    size: float  # change of the mean from one averaging time to the next, or the mean rate [SI unit]
    times: float  # size over that of the noise at rest, or over the largest bias
    tau: float  # averaging time [s]


@frozen
class NotAtRest(Details, code="not_at_rest"):
    """The sensor moves: no coefficients are given."""

    motion: Motion
    duration: float  # of the record [s]
    still: tuple[Span, ...] = ()  # longest stretches at rest, the longest first, from the beginning of the log [s]


@frozen
class KeptOfStream:
    """What is analysed of a stream: from `start` to `stop`, from the beginning of the log, without `left_out`. [s]"""

    stream: str
    start: float
    stop: float
    left_out: float  # length of the stretches within that are left out
    share: float  # of the record that is left


@frozen
class PartlyAtRest(Details, code="partly_at_rest"):
    """The sensor moves for a part of the record, which is left out."""

    motion: Motion
    moved: tuple[Span, ...]  # in order of time, from the beginning of the log [s]
    kept: tuple[KeptOfStream, ...]


@frozen
class AssumedAtRest(Details, code="assumed_at_rest"):
    """The sensor moves, and is analysed as if it rested, as asked."""

    motion: Motion
