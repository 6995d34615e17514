"""Sampling of a stream as data: samples, rate and the source of the rate. `sampling_text` words it."""

from __future__ import annotations

from typing import Literal

from sigmatau.digits import two_digits
from sigmatau.frozen import frozen

RateKind = Literal["given", "time stamps", "file", "simulated"]


@frozen
class RateSource:
    """Source of a sampling rate.

    Attributes
    ----------
    kind : {"given", "time stamps", "file", "simulated"}
    place : str
        Column of the time stamps, or the key of the file that states the rate; empty if it has none.
    line : int or None
        Line of the file that states the rate; None if it is not text.
    lost : int
        Number of samples that are lost according to the time stamps; their places are empty.
    confirmed : bool
        Whether the time stamps agree with a rate that was given.
    """

    kind: RateKind = "given"
    place: str = ""
    line: int | None = None
    lost: int = 0
    confirmed: bool = False

    @property
    def given_alone(self) -> bool:
        """Whether the rate was given, and the log does not confirm it."""
        return self.kind == "given" and not self.confirmed

    @property
    def short(self) -> str:
        """The source in two words."""
        if self.kind != "file":
            return self.kind
        where = "in the file" if self.line is None else f"on line {self.line}"
        return f"{self.place!r} {where}" if self.place else "the file"

    def __str__(self) -> str:
        stamps = f"time stamps in column {self.place}" + (f", {self.lost} lost samples left empty" if self.lost else "")
        if self.kind == "time stamps":
            return stamps
        return f"given, and {stamps} agree" if self.kind == "given" and self.confirmed else self.short


GIVEN_RATE = RateSource()
"""A rate that was given, and that the log does not confirm."""

STATED = RateSource(kind="file")
"""A rate that the file states."""


@frozen
class Sampling:
    """Samples, rate and length of a stream.

    Attributes
    ----------
    channels : tuple of str
    n : int
        Number of samples.
    rate : float
        Sampling rate. [Hz]
    source : RateSource
    missing : tuple of float
        Share of the samples that is missing, by channel; empty if none is.
    """

    channels: tuple[str, ...]
    n: int
    rate: float
    source: RateSource
    missing: tuple[float, ...] = ()


def sampling_text(sampling: Sampling) -> str:
    """Number of channels and samples, rate, length and missing samples, as text."""
    count, duration = len(sampling.channels), sampling.n / sampling.rate
    length = f"{duration / 3600:.4g} h" if duration >= 3600 else f"{duration:.4g} s"
    missing = f", {_missing_text(sampling)} of samples missing" if sampling.missing else ""
    return (
        f"{count} channel{'s' if count > 1 else ''}, {sampling.n} samples at {sampling.rate:.6g} Hz ({sampling.source}),"
        f" {length}{missing}"
    )


def _missing_text(sampling: Sampling) -> str:
    """The share of all samples that is missing; by channel where it differs."""
    texts = [f"{two_digits(100 * share)} %" if share else "none" for share in sampling.missing]
    if len(set(texts)) == 1:
        return texts[0]
    return ", ".join(f"{text} ({channel})" for channel, text in zip(sampling.channels, texts, strict=True))
