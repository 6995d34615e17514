"""Temperatures of runs as groups: runs at different temperatures are not compared with each other."""

from __future__ import annotations

from collections.abc import Sequence

_GAP = 5.0  # smallest difference between two temperatures of a test plan; a chamber keeps within less [K]


def temperature_groups(temperatures: Sequence[float | None]) -> list[str]:
    """The group of each run in words, ``"at 25 °C"``; all are empty if the stated temperatures are about the same.

    Parameters
    ----------
    temperatures : sequence of float or None
        Stated temperatures. [degC] A run without one is in a group of its own, if others differ.

    Returns
    -------
    list of str
    """
    stated = sorted({value for value in temperatures if value is not None})
    groups: list[list[float]] = []
    for value in stated:
        if groups and value - groups[-1][-1] < _GAP:
            groups[-1].append(value)
        else:
            groups.append([value])
    if len(groups) < 2:
        return [""] * len(temperatures)
    names = {value: f"at {(group[0] + group[-1]) / 2:.3g} °C" for group in groups for value in group}
    return ["at an unknown temperature" if value is None else names[value] for value in temperatures]
