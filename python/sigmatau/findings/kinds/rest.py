"""Kinds of findings about a sensor that does not rest, or rests for a part of the record."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details, Span
from sigmatau.frozen import frozen


@frozen
class Motion:
    """The strongest sign that a sensor moves.

    Attributes
    ----------
    channel : str
        That shows it.
    quantity : str
        Of the channel.
    kind : {"varies", "turns", "tilts", "shakes", "loud"}
        The mean varies; the mean rate is beyond any bias; the direction of gravity changes; tremor of a hand; noise beyond
        that of any sensor, which may be aliased motion.
    size : float
        Change of the mean from one averaging time to the next, mean rate, or root mean square of the tremor [SI unit]; angle
        between the directions of gravity [rad]; density of loud noise [SI unit/√Hz].
    times : float
        Size over that of the noise at rest, over the largest bias, or over the largest change that a bias makes. [1]
    tau : float
        Averaging time, or half the period of the tremor. [s]
    """

    channel: str
    quantity: str
    kind: Literal["varies", "turns", "tilts", "shakes", "loud"]
    size: float
    times: float
    tau: float


@frozen
class NotAtRest(Details, code="not_at_rest", alters_all=True):
    """The sensor moves: no coefficients are given.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    duration : float
        Of the record. [s]
    still : tuple of (float, float)
        Longest stretches at rest, the longest first, from the beginning of the log. [s]
    """

    motion: Motion
    duration: float
    still: tuple[Span, ...] = ()


@frozen
class TooShortToTell(Details, code="too_short_to_tell"):
    """The record does not show motion, and is too short to show rest.

    No coefficients are given, unless rest was assumed as requested: then the finding is an info.

    Attributes
    ----------
    duration : float
        Of the samples that are present. [s]
    shortest : float
        Shortest record that the test of rest can judge. [s]
    """

    duration: float
    shortest: float


@frozen
class KeptOfStream:
    """What is analysed of a stream, from the beginning of the log.

    Attributes
    ----------
    stream : str
        Name of the stream.
    start : float
        Beginning. [s]
    stop : float
        End. [s]
    left_out : float
        Length of the stretches within that are left out. [s]
    share : float
        Of the record that is left. [1]
    """

    stream: str
    start: float
    stop: float
    left_out: float
    share: float


@frozen
class PartlyAtRest(Details, code="partly_at_rest"):
    """The sensor moves during a part of the record; this part is left out.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    moved : tuple of (float, float)
        In order of time, from the beginning of the log. [s]
    kept : tuple of KeptOfStream
        By stream.
    """

    motion: Motion
    moved: tuple[Span, ...]
    kept: tuple[KeptOfStream, ...]


@frozen
class AssumedAtRest(Details, code="assumed_at_rest"):
    """The sensor moves, and the motion is analysed as noise, as requested.

    Attributes
    ----------
    motion : Motion
        The strongest motion.
    """

    motion: Motion
