"""Changes of the axes of a sensor: exchanges, reversed signs, and rotations by multiples of 90°; with their words."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

AXES = "xyz"


@frozen
class AxisChange:
    """The axes of a unit in terms of those of the lot: a permutation with signs.

    Attributes
    ----------
    sources : tuple of int
        For x, y and z of the unit, the axis of the lot that it shows: 0, 1 or 2.
    signs : tuple of int
        Sign of each, 1 or -1.
    """

    sources: tuple[int, int, int]
    signs: tuple[int, int, int]

    @property
    def matrix(self) -> Floats:
        """Matrix that converts a vector of the lot to one of the unit, shape (3, 3)."""
        result = np.zeros((3, 3))
        result[range(3), self.sources] = self.signs
        return result

    @property
    def is_rotation(self) -> bool:
        """Whether the change is a rotation, which mounting explains; otherwise axes are exchanged or a sign is reversed."""
        return bool(np.linalg.det(self.matrix) > 0)

    @property
    def is_exchange(self) -> bool:
        """Whether two axes are exchanged and no sign is reversed."""
        return len(self.moved) == 2 and all(sign == 1 for sign in self.signs)

    @property
    def moved(self) -> tuple[int, ...]:
        """Axes that show another axis of the lot."""
        return tuple(axis for axis in range(3) if self.sources[axis] != axis)

    @property
    def reversed_axes(self) -> tuple[int, ...]:
        """Axes with the opposite sign."""
        return tuple(axis for axis in range(3) if self.signs[axis] < 0)

    @property
    def about(self) -> int | None:
        """Axis of a rotation by 90° or 180°; None for another change."""
        fixed = [axis for axis in range(3) if self.sources[axis] == axis and self.signs[axis] > 0]
        return fixed[0] if self.is_rotation and len(fixed) == 1 else None

    def words(self, vertical: int | None) -> str:
        """The change in words. `vertical`: axis of gravity in the lot, if it is along an axis."""
        if self.is_exchange:
            return f"axes {_listed(self.moved)} exchanged"
        if not self.moved and not self.is_rotation:
            return f"sign of {_listed(self.reversed_axes)} reversed"
        if self.about is not None:
            angle, upright = 90 if self.moved else 180, vertical is None or self.about == vertical
            if not upright and angle == 180:
                return "mounted upside down"
            return f"{'turned by' if upright else 'mounted on its side,'} {angle}° about {AXES[self.about]}"
        shown = (f"{'−' if sign < 0 else ''}{AXES[axis]}" for axis, sign in zip(self.sources, self.signs, strict=True))
        return f"x, y, z are {', '.join(shown)} of the lot"


def _listed(axes: Iterable[int]) -> str:
    return " and ".join(AXES[axis] for axis in axes)


def _rank(change: AxisChange) -> int:
    """Sort key by plausibility: a single mistake of mounting or wiring comes before a combination."""
    if change.is_exchange or (change.about is not None and not change.moved):
        return 0
    return 1 if change.about is not None or (not change.moved and len(change.reversed_axes) == 1) else 2


CHANGES = tuple(
    sorted(
        (
            AxisChange(sources=sources, signs=signs)  # type: ignore[arg-type]
            for sources in itertools.permutations(range(3))
            for signs in itertools.product((1, -1), repeat=3)
            if sources != (0, 1, 2) or signs != (1, 1, 1)
        ),
        key=_rank,
    )
)
"""All 47 changes of three axes, the most plausible ones first."""
