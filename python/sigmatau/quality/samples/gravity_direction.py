"""Whether the direction of gravity changes in the frame of a triad of accelerometers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats, median
from sigmatau.findings.finding import Span
from sigmatau.findings.rest import Motion
from sigmatau.quality.samples.common import present, row_means
from sigmatau.quality.samples.octave_means import OctaveMeans
from sigmatau.quality.samples.units import GRAVITY, GRAVITY_TOLERANCE

_BLOCK, _LEAST_BLOCKS = 5, 4  # seconds of the means whose directions are compared, and their number in a short record
_APART = 12  # blocks, one minute, over which all directions are compared
# Change of direction that no bias makes, in a minute or in a record: 0.087 g. A warm-up is up to 50 mg, see `sensor_class`;
# consumer accelerometers change by 1.5 mg/K at most, and no sensor at rest warms by 50 K. [rad]
_TILT = math.radians(5.0)
# Least length of a mean vector that must be gravity: no bias is half of it. Gravity in g, read as m/s², has a length of 1.
_LEAST_GRAVITY, _IN_G = 0.5 * GRAVITY, 1.0
_OVER_NOISE = 5.0  # least length of a mean vector over the noise of its axes: that of noise alone has no direction


def measures_gravity(means: Sequence[OctaveMeans], *, in_si: bool) -> bool:
    """Whether three axes measure gravity: in m/s², or in any unit."""
    if len(means) != 3 or means[0].quantity != "acceleration":
        return False
    second = [one.by_octave[one.second] for one in means]
    length = median(present(np.asarray(np.sqrt(sum(x * x for x in second)))))
    if in_si:
        return abs(length / GRAVITY - 1) < GRAVITY_TOLERANCE
    noise = max(one.floor for one in means) / math.sqrt(means[0].tau(means[0].second))
    return length > _OVER_NOISE * noise and (length > _LEAST_GRAVITY or abs(length / _IN_G - 1) < GRAVITY_TOLERANCE)


def gravity_tilts(means: Sequence[OctaveMeans]) -> list[tuple[Span, Motion]]:
    """Stretches in which the direction of gravity changes, within a minute or from one end to another, with its motion."""
    if not measures_gravity(means, in_si=False):
        return []
    x = np.stack([one.by_octave[one.second] for one in means])
    size = max(min(x.shape[1] // _LEAST_BLOCKS, _BLOCK), 1)
    blocks = np.stack([row_means(axis[: len(axis) // size * size].reshape(-1, size)) for axis in x])
    with np.errstate(invalid="ignore"):
        unit = blocks / np.sqrt((blocks * blocks).sum(axis=0))
    length = size * means[0].tau(means[0].second)
    tilts: list[tuple[Span, Motion]] = []
    edges = np.flatnonzero(np.diff(np.isfinite(unit[0]), prepend=False, append=False)).reshape(-1, 2)
    for a, b in edges.tolist():
        run = unit[:, a:b]
        apart = min(_APART, b - a - 1)
        if apart < 1:
            continue
        cosines = [(run[:, k:] * run[:, : b - a - k]).sum(axis=0) for k in range(1, apart + 1)]
        angles = [math.acos(min(float(c.min()), 1.0)) for c in cosines]
        lag = 1 + angles.index(max(angles))
        at = int(cosines[lag - 1].argmin())
        if angles[lag - 1] <= _TILT:
            at, lag = _farthest(run)
            angles = [_angle(run[:, at], run[:, at + lag])]
        if max(angles) <= _TILT:
            continue
        change = np.abs(run[:, at + lag] - run[:, at])
        axis = means[int(change.argmax())]
        motion = axis.motion("tilts", max(angles), max(angles) / _TILT, lag * length)
        tilts.append((axis.span(a * length, b * length), motion))
    return tilts


def _farthest(directions: Floats) -> tuple[int, int]:
    """First of two directions that are nearly as far apart as any, and how many blocks the second is behind it."""
    some = int((directions[:, 0] @ directions).argmin())
    other = int((directions[:, some] @ directions).argmin())
    return min(some, other), abs(some - other)


def _angle(a: Floats, b: Floats) -> float:
    return math.acos(min(float(a @ b), 1.0))
