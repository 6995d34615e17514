"""Curves of a lot: their median and range, the scale of a unit against them, and mistaken units that explain a scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.units import STANDARD_GRAVITY


@frozen(eq=False)
class Band:
    """The curves of a channel of all units, with their median and the range of the middle four fifths.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Quantity and SI unit of the rate.
    tau : ndarray, shape (n_tau,)
        The averaging times that most units have. [s]
    median, low, high : ndarray, shape (n_tau,)
        Median, 10 % and 90 % quantile of the units. [unit]
    curves : mapping of str to ndarray, shape (n_tau,)
        Curves by unit, at these times; NaN outside its curve. [unit]
    """

    channel: str
    quantity: str
    unit: str
    tau: Floats
    median: Floats
    low: Floats
    high: Floats
    curves: Mapping[str, Floats]


def band(channel: str, curves: Mapping[str, tuple[Floats, Floats]], *, quantity: str, unit: str) -> Band:
    """Build the band of a channel from averaging times and deviations by unit."""
    grids: dict[bytes, int] = {}
    for tau, _ in curves.values():
        grids[tau.tobytes()] = grids.get(tau.tobytes(), 0) + 1
    grid = np.frombuffer(max(grids, key=lambda grid_bytes: (grids[grid_bytes], len(grid_bytes))), dtype=np.float64)
    by_unit: dict[str, Floats] = {}
    for name, (tau, adev) in curves.items():
        positive = adev > 0
        if not positive.any():
            continue
        logs = np.interp(np.log(grid), np.log(tau[positive]), np.log(adev[positive]), left=np.nan, right=np.nan)
        by_unit[name] = np.exp(logs)
    table = np.array(list(by_unit.values())) if by_unit else np.full((1, len(grid)), np.nan)
    enough = 2 * np.isfinite(table).sum(axis=0) >= len(table)
    enough_table = table[:, enough]
    low, median, high = np.nanquantile(enough_table, (0.1, 0.5, 0.9), axis=0) if enough.any() else np.empty((3, 0))
    return Band(
        channel=channel,
        quantity=quantity,
        unit=unit,
        tau=grid[enough],
        median=median,
        low=low,
        high=high,
        curves={name: curve[enough] for name, curve in by_unit.items()},
    )


def scale(band_: Band, name: str) -> float | None:
    """Logarithm of the ratio of the curve of a unit to the median of the lot, as a median over averaging times.

    None if they have no averaging time in common.
    """
    curve = band_.curves.get(name)
    if curve is None:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.log(curve / band_.median)
    finite = ratios[np.isfinite(ratios)]
    return float(np.median(finite)) if len(finite) else None


FACTORS: Mapping[str, Sequence[tuple[float, str, str]]] = {
    "angular_rate": (
        (180 / math.pi, "deg/s", "rad/s"),
        (3600.0, "deg/h", "deg/s"),
        (3600.0 * 180 / math.pi, "deg/h", "rad/s"),
        (1000.0, "mdeg/s", "deg/s"),
    ),
    "acceleration": (
        (STANDARD_GRAVITY, "m/s^2", "g"),
        (1000.0, "mg", "g"),
        (1000.0 / STANDARD_GRAVITY, "mg", "m/s^2"),
    ),
}
"""Factors of mistaken units by quantity: numbers in the first unit were read as numbers in the second one."""

_SAME_FACTOR = math.log(1.1)  # largest ratio, as a logarithm, between a scale and the factor that explains it


def mistaken_units(quantity: str, ratio: float) -> tuple[str, str] | None:
    """The unit of the numbers and the unit that was assumed, if this mistake explains the ratio; otherwise None."""
    for factor, written_in, read_as in FACTORS.get(quantity, ()):
        if abs(math.log(ratio / factor)) < _SAME_FACTOR:
            return written_in, read_as
        if abs(math.log(ratio * factor)) < _SAME_FACTOR:
            return read_as, written_in
    return None
