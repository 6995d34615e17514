"""Origin of the ± of the paper: eq. (26) at a power of 2 per cell, rounded or not, and the probability of this by chance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_HALF_UP, Decimal

import numpy as np

from sigmatau.noise.uncertainty import percentage_error
from studies.paper.tables import PRINTED, RATES, Cell

__all__ = [
    "DECODED",
    "Decoded",
    "Expected",
    "decoded",
    "expected_hits",
    "longest_time",
    "reproducing_share",
    "reproducing_sizes",
    "reproducing_times",
    "significant_digits",
    "to_digits",
    "undecoded",
]

_TENTH_OF_A_PERCENT = 3  # decimals of a δ that is rounded to 0.1 % before the multiplication


@dataclass(frozen=True, slots=True)
class Decoded:
    """A cluster size that results in the printed error of a cell."""

    size: int  # [samples]
    rounded: bool  # whether δ is rounded to 0.1 % first


def _decoded(size: int, *, rounded: bool = False) -> Decoded:
    return Decoded(size, rounded)


# By unit, channel and term. There is no evidence of sizes between powers of 2: see `expected_hits`.
DECODED: Mapping[tuple[str, str, str], Decoded] = {
    ("cimu", "gyro_x", "quantization"): _decoded(2**14, rounded=True),
    ("cimu", "gyro_y", "quantization"): _decoded(2**12),
    ("cimu", "gyro_z", "quantization"): _decoded(2**11, rounded=True),
    ("cimu", "accel_x", "quantization"): _decoded(2**14, rounded=True),
    ("cimu", "accel_y", "quantization"): _decoded(2**14, rounded=True),
    **{("cimu", f"gyro_{axis}", "random_walk"): _decoded(2**18) for axis in "xyz"},
    **{("cimu", f"accel_{axis}", "rate_ramp"): _decoded(2**18) for axis in "xy"},
    ("hg1700", "gyro_x", "quantization"): _decoded(2**8),
    ("hg1700", "accel_y", "quantization"): _decoded(2**12),
    ("hg1700", "accel_z", "quantization"): _decoded(2**10),
    ("hg1700", "gyro_x", "random_walk"): _decoded(2**17),
    **{("hg1700", f"accel_{axis}", "rate_random_walk"): _decoded(2**17) for axis in "xyz"},
    ("motionpak2", "gyro_x", "random_walk"): _decoded(2**8),
    ("motionpak2", "gyro_z", "random_walk"): _decoded(2**8),
    **{("motionpak2", f"accel_{axis}", "random_walk"): _decoded(2**2) for axis in "xyz"},
    ("motionpak2", "accel_x", "bias_instability"): _decoded(2**7),
    ("motionpak2", "accel_y", "bias_instability"): _decoded(2**9),
    ("motionpak2", "accel_z", "bias_instability"): _decoded(2**9),
}


def decoded(cell: Cell) -> tuple[Decoded, float, str] | None:
    """Explanation of the printed error of a cell: the cluster size, δ, and the error to the printed digit."""
    size = DECODED.get((cell.unit, cell.channel, cell.term))
    if size is None:
        return None
    delta = float(percentage_error(cell.samples, size.size)[0])
    used = round(delta, _TENTH_OF_A_PERCENT) if size.rounded else delta
    return size, delta, to_digits(cell.value * used, cell.decimals)


def undecoded() -> Iterator[Cell]:
    """Cells whose error no power of 2 explains, see `reproducing_times`."""
    return (cell for cell in PRINTED if (cell.unit, cell.channel, cell.term) not in DECODED)


def to_digits(value: float, decimals: int) -> str:
    """Round a value to some decimals, halves away from 0."""
    return str(Decimal(repr(value)).quantize(Decimal(1).scaleb(-decimals), rounding=ROUND_HALF_UP))


def reproducing_times(cell: Cell) -> tuple[float, float]:
    """Averaging times between which eq. (26) without rounding gives the printed error. [s]"""
    half = 0.5 * 10.0**-cell.decimals
    low, high = (
        1 / (1 + 0.5 / ((cell.error + sign * half) / cell.value) ** 2) * cell.samples / RATES[cell.unit]
        for sign in (-1, 1)
    )
    return low, high


def longest_time(cell: Cell) -> float:
    """Longest averaging time of the line of the authors, from the printed error. [s]"""
    size = DECODED.get((cell.unit, cell.channel, cell.term))
    if size is not None:
        return size.size / RATES[cell.unit]
    low, high = reproducing_times(cell)
    return math.sqrt(low * high)


def significant_digits(cell: Cell) -> int:
    """Significant digits of the printed error."""
    return len(Decimal(cell.printed_error).as_tuple().digits)


def reproducing_sizes(cell: Cell, *, per_octave: int = 1) -> list[Decoded]:
    """Cluster sizes 2^(k/per_octave) up to half the record that give the printed error, with δ rounded or not."""
    reproducing = []
    for k in range(per_octave * int(math.log2(cell.samples / 2)) + 1):
        size = round(2 ** (k / per_octave))
        delta = float(percentage_error(cell.samples, size)[0])
        reproducing += [
            Decoded(size, rounded) for rounded in (False, True) if _reproduces(cell, delta, rounded=rounded)
        ]
    return reproducing


def _reproduces(cell: Cell, delta: float, *, rounded: bool) -> bool:
    error = cell.value * (round(delta, _TENTH_OF_A_PERCENT) if rounded else delta)
    return Decimal(to_digits(error, cell.decimals)) == Decimal(cell.printed_error)


_STARTS = 500  # starts per octave; more change the sums by less than 0.05


def reproducing_share(cell: Cell, *, rounding: bool, per_octave: int = 1) -> float:
    """Probability that sizes in steps of 2^(1/per_octave) from a random start contain one that gives the printed error.

    `rounding`: δ may be rounded to 0.1 % first.
    """
    steps = np.arange(per_octave * math.log2(cell.samples / 2))
    # Errors outside this range cannot have the printed digits.
    reach = 10.0**-cell.decimals + cell.value * 0.1**_TENTH_OF_A_PERCENT
    hits = 0
    for start in (np.arange(_STARTS) + 0.5) / _STARTS:
        delta = 1 / np.sqrt(2 * (cell.samples / 2 ** ((steps + start) / per_octave) - 1))  # eq. (26)
        within = delta[np.abs(cell.value * delta - cell.error) <= reach].tolist()
        hits += any(_reproduces(cell, x, rounded=way) for x in within for way in {False, rounding})
    return hits / _STARTS


@dataclass(frozen=True, slots=True)
class Expected:
    """Number of cells that a set of cluster sizes reproduces, and the number expected by chance."""

    hits: int
    cells: int
    mean: float
    std: float
    p_value: float  # probability of as many hits by chance


def expected_hits(cells: Sequence[Cell], *, rounding: bool) -> Expected:
    """Numbers of cells that powers of 2 reproduce, and that octaves from a random start reproduce."""
    share = [reproducing_share(cell, rounding=rounding) for cell in cells]
    hits = sum(any(rounding or not decoded.rounded for decoded in reproducing_sizes(cell)) for cell in cells)
    counts = np.ones(1)  # probability of each number of hits
    for p in share:
        counts = np.convolve(counts, [1 - p, p])
    spread = math.sqrt(sum(p * (1 - p) for p in share))
    return Expected(hits, len(cells), sum(share), spread, float(counts[hits:].sum()))
