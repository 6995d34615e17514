"""Test of whether the direction of gravity changes in the frame of an accelerometer triad."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats, median
from sigmatau.findings.finding import Span
from sigmatau.findings.rest import Motion
from sigmatau.quality.motion.octave_means import OctaveMeans
from sigmatau.quality.samples.common import present, row_means
from sigmatau.quality.samples.units import GRAVITY_TOLERANCE
from sigmatau.units import STANDARD_GRAVITY

# Length of the means whose directions are compared. [s] Judgement: the noise of a mean over 5 s is far below 5° of
# gravity.
_BLOCK = 5
# Smallest number of means; a short record has shorter ones. [1] Judgement: a record of 4 s can then be judged.
_MIN_BLOCKS = 4
# Number of means (one minute) over which all directions are compared. [means] Judgement: a hand tilts a sensor within a
# minute.
_APART = 12
# Change of direction that no bias can cause, 0.087 g. [rad] Datasheets: a warm-up is up to 50 mg, see `sensor_class`;
# consumer accelerometers change by 1.5 mg/K, and no sensor at rest warms by 50 K.
_TILT = math.radians(5.0)
# Length of a mean vector above which it is gravity. [m/s^2] Judgement: no bias is half of gravity.
_MIN_GRAVITY = 0.5 * STANDARD_GRAVITY
# Length of the mean vector if values in g were read as m/s². [m/s^2] Standard: definition of the unit g.
_G_AS_SI = 1.0
# Smallest ratio of a mean vector with a direction to the noise of its axes. [1] Judgement: noise turns the vector by
# 11° at most.
_OVER_NOISE = 5.0


def measures_gravity(means: Sequence[OctaveMeans], *, in_si: bool) -> bool:
    """Whether three axes measure gravity: in m/s², or in any unit."""
    if len(means) != 3 or means[0].quantity != "acceleration":
        return False
    second = [axis.by_octave[axis.second_octave] for axis in means]
    length = median(present(np.asarray(np.sqrt(sum(x * x for x in second)))))
    if in_si:
        return abs(length / STANDARD_GRAVITY - 1) < GRAVITY_TOLERANCE
    noise = max(axis.floor for axis in means) / math.sqrt(means[0].tau(means[0].second_octave))
    return length > _OVER_NOISE * noise and (length > _MIN_GRAVITY or abs(length / _G_AS_SI - 1) < GRAVITY_TOLERANCE)


def gravity_tilts(means: Sequence[OctaveMeans]) -> list[tuple[Span, Motion]]:
    """Find stretches in which the direction of gravity changes, within a minute or over the whole record, with their
    motion.
    """
    if not measures_gravity(means, in_si=False):
        return []
    x = np.stack([mean.by_octave[mean.second_octave] for mean in means])
    size = max(min(x.shape[1] // _MIN_BLOCKS, _BLOCK), 1)
    blocks = np.stack([row_means(axis[: len(axis) // size * size].reshape(-1, size)) for axis in x])
    with np.errstate(invalid="ignore"):
        unit = blocks / np.sqrt((blocks * blocks).sum(axis=0))
    length = size * means[0].tau(means[0].second_octave)
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
        place = int(cosines[lag - 1].argmin())
        if angles[lag - 1] <= _TILT:
            place, lag = _farthest(run)
            angles = [_angle(run[:, place], run[:, place + lag])]
        if max(angles) <= _TILT:
            continue
        change = np.abs(run[:, place + lag] - run[:, place])
        axis = means[int(change.argmax())]
        motion = axis.motion("tilts", max(angles), max(angles) / _TILT, lag * length)
        tilts.append((axis.span(a * length, b * length), motion))
    return tilts


def _farthest(directions: Floats) -> tuple[int, int]:
    """Find two directions nearly as far apart as any; return the first, and the number of blocks to the second."""
    some = int((directions[:, 0] @ directions).argmin())
    opposite = int((directions[:, some] @ directions).argmin())
    return min(some, opposite), abs(some - opposite)


def _angle(a: Floats, b: Floats) -> float:
    return math.acos(min(float(a @ b), 1.0))
