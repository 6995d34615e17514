"""Resolution: the step of the numbers, against the noise that must blur it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Finding
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import affected, block_rms, present, rounding_dust, sample_of, white_level
from sigmatau.record.streams import Stream
from sigmatau.results import Printed

__all__ = [
    "Resolution",
    "coarse_resolution",
    "common_step",
    "quantization_mismatch",
    "quantization_step",
    "resolution",
    "too_coarse",
]

# Samples that the step is looked for in: enough for each step of a channel with 1e5 of them to the standard deviation.
_LOOKED_AT = 16384

# A lattice is believed if no value is further from its point than this many steps; chance gives a half of that range
# to every value, so that 30 values all within it are worth 0.3^30.
_OFF, _BY_CHANCE = 0.15, 30

# Rounding by q adds q²/12 to a sample of white noise; that 0.5 % of N shows, and 5 % is more than the usual interval of it.
_SHOWS, _MATTERS = 1.005, 1.05

# Below 0.5 steps of noise, rounding errors are no longer white nor independent of the signal: how much they add depends on
# where between two steps the mean lies (at 0.3, sd of the excess is as large as its mean). Rounded, 0.5 steps show 0.577
# whatever the mean; 0.2 steps show anything up to 0.5.
_BLURRED = 0.54


@dataclass(frozen=True, slots=True, kw_only=True)
class Resolution(Printed):
    """Step of a channel's numbers, and the noise beside it.

    Attributes
    ----------
    channel : str
    step : float
        Common step of all values, of the rate. [unit of the stream]
    noise : float
        Standard deviation of the white part of a sample: root mean square of the differences of neighbours over √2; of
        noise that is coarser than the step, its own. [unit of the stream]
    unit : str
    """

    channel: str
    step: float
    noise: float
    unit: str

    @property
    def ratio(self) -> float:
        """Noise in steps."""
        return self.noise / self.step

    def to_dict(self) -> dict[str, Any]:
        return {"channel": self.channel, "step": self.step, "noise": self.noise, "unit": self.unit}

    def __repr__(self) -> str:
        noise = f"noise {self.noise:.4g} {self.unit} ({self.ratio:.3g} steps)"
        return f"{self.channel}: step {self.step:.6g} {self.unit}, {noise}"


def common_step(x: NDArray[np.float64], *, rounding: float = 0.0) -> float | None:
    """The step q of numbers that are a + k·q with whole k, each known to a part of q; None if there is none.

    Offsets and scales do not matter, nor that each value was rounded after it was scaled (printed decimals, float32):
    the step is that of the counts, by regression of the values on their whole numbers.

    Parameters
    ----------
    x : ndarray, shape (n,)
        NaN is passed over.
    rounding : float
        Values closer than this are the same. [unit of x]

    Returns
    -------
    float or None
        [unit of x]
    """
    x = present(x)
    values = np.unique(x)
    if len(values) < 2:
        return None
    gaps = np.diff(values)
    least = max(rounding, 8 * np.finfo(float).eps * float(np.abs(values[[0, -1]]).max()))
    gaps = gaps[gaps > least]
    if len(gaps) == 0 or (len(gaps) < _BY_CHANCE and 2 * (len(gaps) + 1) > len(x)):
        return None
    # The least gap is the step to one rounding; each wider set of gaps gives it more exactly, for the next.
    step = float(gaps.min())
    for widest in (1.5, 6.5, 50.5, math.inf):
        near = gaps[gaps < widest * step]
        step = float(near.sum() / np.rint(near / step).sum())
    counts = np.concatenate(([0.0], np.cumsum(np.rint(gaps / step))))
    levels = np.concatenate(([0.0], np.cumsum(gaps)))
    centred = counts - counts.mean()
    slope = float(centred @ levels / (centred @ centred))
    off = levels - levels.mean() - slope * centred
    return slope if np.abs(off).max() <= _OFF * slope else None


@channel_fact
def resolution(stream: Stream, channel: str) -> Resolution | None:
    """Step and noise of a channel; None if its values have no common step that can be told from none.

    Parameters
    ----------
    stream : Stream
    channel : str

    Returns
    -------
    Resolution or None
    """
    x = sample_of(stream, channel, most=_LOOKED_AT)
    rounding = _rounding(stream, channel)
    if stream.samples.transforms[stream.channels.index(channel)].kind == "increments":
        rounding = max(rounding, rounding_dust(x, stream.grid.n))
    step = common_step(x, rounding=rounding)
    if step is None:
        return None
    differences = np.diff(x)
    noise = block_rms(differences)
    if noise == 0.0:  # most blocks see no change
        differences = present(differences)
        noise = float(np.sqrt(np.mean(differences * differences)))
    return Resolution(channel=channel, step=step, noise=noise / math.sqrt(2), unit=stream.unit)


def quantization_step(stream: Stream, channel: str) -> float | None:
    """Step S of the increments or of the accumulated angle or velocity that a log holds, for Q against S/√12.

    Parameters
    ----------
    stream : Stream
    channel : str

    Returns
    -------
    float or None
        None for a log of rates, to whose rounding no Q belongs, and where no step is found. [unit of the stream, times s]
    """
    if stream.samples.transforms[stream.channels.index(channel)].kind == "rate":
        return None
    found = resolution(stream, channel)
    return None if found is None else found.step * stream.grid.tau0


# The paper's bound, below eq. (13): Qz ≤ S/√12. Fits are right to some percent.
_LARGER = 1.2


def quantization_mismatch(stream: Stream, channel: str, quantization: float, *, low: float = 0.0) -> list[Finding]:
    """A finding if a fitted quantization noise is larger than the step of the log can make.

    Parameters
    ----------
    stream : Stream
    channel : str
    quantization : float
        Fitted Q. [unit of the stream, times s]
    low : float
        Lower end of its interval. Default: the value alone counts.

    Returns
    -------
    list of Finding
        At most one, of severity info.
    """
    step = quantization_step(stream, channel)
    if step is None:
        return []
    most = step / math.sqrt(12)
    if (low or quantization) <= _LARGER * most:
        return []
    return [
        Finding(
            code="quantization_mismatch",
            severity="info",
            channel=channel,
            message=(
                f"Q = {quantization:.3g} {stream.unit}·s is {quantization / most:.3g} times what the step of the log,"
                f" S = {step:.3g} {stream.unit}·s, can make (S/√12)"
            ),
            size=quantization / most,
            effect="what was fitted as quantization is mostly something else of slope -1, such as white noise of the angle",
            remedy="do not change the log's resolution to cure it",
        )
    ]


def too_coarse(finding: Finding) -> bool:
    """Whether a finding says that the step is so coarse that no coefficient can be trusted."""
    return finding.code == "coarse_resolution" and finding.severity == "warning" and not finding.changes


def coarse_resolution(stream: Stream) -> list[Finding]:
    """Channels whose step is so coarse against their noise that rounding shows in a coefficient.

    Rounding of a rate by q adds q²/12 to the variance of each sample, N_add² = q²·τ₀/12: white noise, not quantization
    noise, which belongs to increments and accumulated values alone. Below half a step of noise no number can be trusted.

    Parameters
    ----------
    stream : Stream

    Returns
    -------
    list of Finding
        One a channel; ``changes`` holds the random walk's factor where it can be known.
    """
    return [finding for channel in stream.channels for finding in _coarse(stream, channel)]


def _coarse(stream: Stream, channel: str) -> list[Finding]:
    found = resolution(stream, channel)
    # At 3 steps of white noise rounding makes 0.5 % of N; channels that are not white may bear less or more.
    if found is None or found.ratio > 3:
        return []
    sample = present(sample_of(stream, channel, most=_LOOKED_AT))
    if 2 * len(np.unique(np.rint((sample - sample[0]) / found.step))) > len(sample):
        return []  # a line without noise has a step too, but no value twice
    tau0 = stream.grid.tau0
    said = f"the step is {found.step:.4g} {found.unit}, the noise of a sample {found.ratio:.2g} steps"
    if stream.samples.transforms[stream.channels.index(channel)].kind != "rate":
        step = found.step * tau0
        return [
            Finding(
                code="coarse_resolution",
                severity="info",
                channel=channel,
                message=said,
                size=found.ratio,
                unit="steps",
                effect=f"quantization noise up to S/√12 = {step / math.sqrt(12):.3g} {found.unit}·s",
                remedy="none is needed while quantization is among the terms that are fitted",
            )
        ]
    added = found.step**2 * tau0 / 12
    level, _ = white_level(sample_of(stream, channel, most=1 << 18), tau0)
    factor = math.sqrt(level / (level - added)) if level > added else math.inf
    remedy = "choose a finer range or more bits for the log; record again if this coefficient matters"
    if found.ratio < _BLURRED or factor > 2:
        return [
            Finding(
                code="coarse_resolution",
                severity="warning",
                channel=channel,
                message=said,
                size=found.ratio,
                unit="steps",
                effect="rounding is no white noise here: neither random walk nor bias instability can be trusted",
                remedy=remedy,
            )
        ]
    if factor < _SHOWS:
        return []
    return [
        Finding(
            code="coarse_resolution",
            severity="warning" if factor > _MATTERS else "info",
            channel=channel,
            message=said,
            size=found.ratio,
            unit="steps",
            effect=(f"rounding adds white noise of {math.sqrt(added):.3g} {found.unit}·√s: {affected(factor)}"),
            changes=(("random_walk", factor),),
            remedy=remedy if factor > _MATTERS else "none is needed",
        )
    ]


def _rounding(stream: Stream, channel: str) -> float:
    """What the type of the raw numbers may leave between two that are the same. [unit of the stream]"""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    if raw.dtype.kind != "f" or len(raw) == 0:
        return 0.0
    step = max(len(raw) // 4096, 1)
    some = np.asarray(raw[::step], dtype=float)
    if stream.mask is not None:  # what is taken for missing may be any number
        gone = stream.mask[::step, k]
        some = some[: len(gone)][~gone]
    with np.errstate(invalid="ignore"):
        largest = float(np.nanmax(np.abs(some), initial=0.0))
    if not math.isfinite(largest):
        return 0.0
    # One unit in the last place is a step that a log may have; half of one is the rounding.
    epsilon = float(np.finfo(raw.dtype).eps) if raw.dtype.itemsize < 8 else 8 * float(np.finfo(float).eps)
    factor = abs(t.scale * t.factor) / (1.0 if t.kind == "rate" else stream.grid.tau0)
    return 0.4 * epsilon * largest * factor
