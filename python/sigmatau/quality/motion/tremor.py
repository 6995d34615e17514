"""Detection of shaking: noise on all axes beyond that of any sensor, and the tremor of a hand."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import median
from sigmatau.findings.rest import Motion
from sigmatau.frozen import frozen
from sigmatau.quality.motion.octave_means import NOISIEST, OctaveMeans
from sigmatau.quality.samples.common import take_samples

_AXES = 3  # axes of a sensor that shows gravity


@frozen(kw_only=False)
class _LeastRatios:
    """Smallest ratios of the density in the tremor band to that below (geometric mean over the axes, and each axis) and
    to that above (each axis).
    """

    below_by_mean: float
    below: float
    above: float


# Octaves of the means whose noise is judged, 1/4 s and 1/2 s. [octaves] Judgement: fast vibration has averaged out, and
# a short record still has enough means.
_OCTAVES = (2, 3)
# Smallest noise of each axis of a loud sensor, over that of the noisiest sensor. [1] Judgement: shaking has a
# direction, but reaches all axes.
_MIN_SHARE = 0.5
# Band of the density below the tremor of a hand. [Hz] Derived: between slower motion and the tremor, see `_TREMOR`.
_BAND_BELOW = (2.5, 6.5)
# Band of the tremor of a hand. [Hz] Literature: 8 to 12 Hz; R. J. Elble, W. C. Koller, Tremor, Johns Hopkins
# University Press, 1990.
_TREMOR = (7.5, 12.5)
# Band of the density above the tremor. [Hz] Derived: beyond the tremor, see `_TREMOR`, below the corner of most
# filters.
_BAND_ABOVE = (15.0, 40.0)
# Band just below the tremor, where a slower motion may hide everything else. [Hz] Derived: the upper part of `_BAND_BELOW`.
_VALLEY = (5.0, 6.5)
# Length of the periodograms. [s] Judgement: four of them are in the shortest record, with ten frequencies in the band
# of tremor.
_SEGMENT = 2.0
# Smallest number of periodograms. [1] Judgement: their mean scatters by half at a single frequency, and by less in a
# band.
_MIN_SEGMENTS = 4
# Band below the vibration of engines. [Hz] Study: docs/study/rest.md compares the noise below 2 Hz.
_BELOW_VIBRATION = (0.75, 2.0)
# Length of the periodograms of that band. [s] Derived: six frequencies in it.
_LONG_SEGMENT = 4.0
# Smallest density in that band that is motion, over that of the noisiest accelerometer. [1] Judgement: the factor of
# `beyond_class`.
_MIN_EXCESS = 1.25
# Half the sampling rate above which a tremor is visible. [Hz] Derived: there are frequencies above 15 Hz, see
# `_BAND_ABOVE`.
_MIN_NYQUIST = 18.0
# Largest ratio of the density in the band of tremor to that below for which the peaks may be lobes of a moving average.
# [1] Study: docs/study/rest.md; none of 400 sensors with a moving average is reported as moving.
_LOBES_BELOW = 0.8
# Largest ratio to the density above for which the peaks may be such lobes. [1] Derived: twice the ratio of a lobe,
# which is at most 20.
_LOBES_OVER_ABOVE = 40.0
# Root mean square in the band of tremor above which it may be a hand. [rad/s, m/s^2] Study: docs/study/rest.md;
# half of the steadiest of the simulated hands.
_MIN_TREMOR = {"angular_rate": math.radians(0.04), "acceleration": 0.005}
# Smallest ratios of medians of the density, which lines do not raise. [1] Measured: in real and simulated records at
# rest the ratio to the density below is up to 1.8; with lobes of filters and the angle noise of optical gyros, the
# ratio to the density above is up to 3.3. For hands they are six or more.
_RATIOS_OF_MEDIANS = _LeastRatios(2.5, 1.5, 3.0)
# Smallest ratios of the means of the density, which scatter less, for loud gyros. [1] Derived: a low-pass filter raises
# the ratio to the density above, but not to the density below; in a record of 10 s the mean of three axes scatters by
# 13 %.
_RATIOS_OF_LOUD = _LeastRatios(1.5, 0.9, 1.2)
# Smallest noise of the loudest axis that is motion if the rate is too low for a tremor, over that of the noisiest
# sensor. [1] Judgement: twice the power, for sensors that are worse than their datasheet.
_LOUD_WITHOUT_TREMOR = 1.5
# Number of samples whose density is computed. [samples] Judgement: limits the time; 65 periodograms at 1 kHz.
_EXAMINED = 1 << 17
# Number of parts of a record whose noise is compared. [1] Judgement: a hand that takes or releases the sensor changes a
# quarter.
_PARTS = 4
# Smallest number of means in a part. [means] Derived: a level from the median of 35 differences scatters by 15 %.
_MIN_IN_PART = 35
# Ratio of the levels of the parts that white noise does not reach. [1] Derived: more than four standard errors of 15 %,
# see `_MIN_IN_PART`.
_UNSTEADY = 2.0


def shaken(means: Sequence[OctaveMeans]) -> Motion | None:
    """Detect a tremor, or noise on all axes beyond that of any sensor in a certain unit.

    The unit is certain if the accelerometers are as noisy and measure gravity in the stated unit, if there is a tremor,
    or if the noise grows or fades within the record. A sampling rate too low for a tremor cannot distinguish motion from
    white noise. At such a rate, and for one or two accelerometers alone, which do not show gravity, the motion is "loud",
    and the unit is in doubt.
    """
    axes = [axis for axis in means if not axis.slow]
    gyros = [axis for axis in axes if axis.quantity == "angular_rate"]
    loud = _loud_motion(gyros)
    if (tremor := _tremor(axes, is_loud=loud is not None)) is not None:
        return tremor
    if not gyros and len(means) < _AXES:
        return _loud_without_tremor(_loud_motion(axes))
    accelerometers = [axis for axis in axes if axis.unit_is_sure]
    if (slow_shaking := _loud_below_vibration(accelerometers)) is not None:
        return slow_shaking
    if loud is None:
        return None
    if _loud_motion(accelerometers) is not None or all(_is_unsteady(axis) for axis in gyros):
        return loud
    return _loud_without_tremor(loud) if gyros[0].stream.grid.rate < 2 * _MIN_NYQUIST else None


def _loud_without_tremor(motion: Motion | None) -> Motion | None:
    if motion is None or motion.times <= _LOUD_WITHOUT_TREMOR:
        return None
    return replace(motion, kind="loud", size=motion.size * math.sqrt(motion.tau))


def _loud_motion(means: Sequence[OctaveMeans]) -> Motion | None:
    """Noise of the loudest axis, if all axes exceed the noise of any sensor."""
    if not means:
        return None
    levels = [_level(axis) for axis in means]
    noisiest = NOISIEST[means[0].quantity]
    if not (min(levels) > _MIN_SHARE * noisiest and math.hypot(*levels) > noisiest * math.sqrt(len(levels))):
        return None
    loudest, level = max(zip(means, levels, strict=True), key=lambda pair: pair[1])
    tau = loudest.tau(max(_OCTAVES[-1], loudest.first))
    return loudest.motion("varies", level / math.sqrt(tau), level / noisiest, tau)


def _loud_below_vibration(accelerometers: Sequence[OctaveMeans]) -> Motion | None:
    """The loudest axis whose density below vibration exceeds that of any sensor, if the unit is certain."""
    motions: list[Motion] = []
    limit = _MIN_EXCESS * NOISIEST["acceleration"]
    for axis in accelerometers:
        if not _level(axis) > NOISIEST["acceleration"]:
            continue  # the means have more noise than this band
        density = _densities(axis, (_BELOW_VIBRATION,), segment=_LONG_SEGMENT)
        if density is not None and (level := math.sqrt(density[0])) > limit:
            tau = axis.tau(_OCTAVES[-1])
            motions.append(axis.motion("varies", level / math.sqrt(tau), level / NOISIEST["acceleration"], tau))
    return max(motions, key=lambda motion: motion.times, default=None)


def _level(means: OctaveMeans) -> float:
    """Root mean square of √τ times the deviation of means; NaN if there are too few, or if rounding explains it.
    [unit/√Hz]
    """
    power = 0.0
    for octave in (max(octave, means.first) for octave in _OCTAVES):
        level = means.median_level(octave)
        if level <= means.rounding_level(octave):
            return math.nan
        power += level * level / len(_OCTAVES)
    return math.sqrt(power)


def _is_unsteady(means: OctaveMeans) -> bool:
    """Whether the noise of the shortest means differs between parts of the record by more than that of a sensor."""
    if len(means.by_octave[means.first]) < _PARTS * _MIN_IN_PART:
        return False
    edges = np.linspace(0.0, means.stream.grid.duration, _PARTS + 1)
    levels = [means.median_level(means.first, a, b) for a, b in itertools.pairwise(edges.tolist())]
    return max(levels) > _UNSTEADY * min(levels)


@frozen(kw_only=False)
class _Peak:
    """Tremor band in the density of an axis."""

    axis: OctaveMeans
    rms: float  # [unit of the stream]
    over_below: float  # ratios of densities
    over_valley: float
    over_above: float


def _tremor(axes: Sequence[OctaveMeans], *, is_loud: bool) -> Motion | None:
    """The tremor of a hand: a band of noise at 8 to 12 Hz, where neither a low-pass filter nor a drift has a peak.

    It must be on all axes of gyros and accelerometers. For loud gyros a single axis suffices, without accelerometers.
    """
    gyros = [axis for axis in axes if axis.quantity == "angular_rate"]
    peaks = _peaks(axes, _RATIOS_OF_MEDIANS, by_median=True) if len(gyros) >= _AXES else ()
    if not peaks and is_loud:
        peaks = _peaks(gyros, _RATIOS_OF_LOUD, by_median=False)
    gyro_peaks = [peak for peak in peaks if peak.axis.quantity == "angular_rate"]
    if not gyro_peaks:
        return None
    largest = max(gyro_peaks, key=lambda peak: peak.rms)
    return largest.axis.motion("shakes", largest.rms, math.sqrt(largest.over_above), 1 / sum(_TREMOR))


def _peaks(axes: Sequence[OctaveMeans], ratios: _LeastRatios, *, by_median: bool) -> Sequence[_Peak]:
    """Peaks of all axes, if each stands out from the density above, and those of each sensor also from the density below."""
    peaks: list[_Peak] = []
    for axis in axes:
        peak = _peak(axis, by_median=by_median)
        if peak is None or peak.rms < _MIN_TREMOR[axis.quantity] or peak.over_above < ratios.above:
            return ()
        peaks.append(peak)
    quantities = dict.fromkeys(axis.quantity for axis in axes)
    by_sensor = [[peak for peak in peaks if peak.axis.quantity == quantity] for quantity in quantities]
    if all(_stand_out([peak.over_below for peak in alike], ratios) for alike in by_sensor):
        return peaks
    are_lobes = min(peak.over_above for peak in peaks) <= _LOBES_OVER_ABOVE and any(
        _geometric_mean([peak.over_below for peak in alike]) <= _LOBES_BELOW for alike in by_sensor
    )
    stand_out = all(_stand_out([peak.over_valley for peak in alike], _RATIOS_OF_MEDIANS) for alike in by_sensor)
    return peaks if stand_out and not are_lobes else ()


def _stand_out(ratios: Sequence[float], limits: _LeastRatios) -> bool:
    return _geometric_mean(ratios) > limits.below_by_mean and min(ratios) > limits.below


def _geometric_mean(x: Sequence[float]) -> float:
    return math.exp(sum(map(math.log, x)) / len(x))


def _peak(axis: OctaveMeans, *, by_median: bool) -> _Peak | None:
    if axis.stream.grid.rate / 2 < _MIN_NYQUIST:
        return None
    densities = _densities(
        axis,
        (_BAND_BELOW, _VALLEY, _TREMOR, _BAND_ABOVE),
        segment=_SEGMENT,
        by_median=by_median,
    )
    if densities is None:
        return None
    below, valley, tremor, above = densities
    rms = math.sqrt(2 * tremor * (_TREMOR[1] - _TREMOR[0]))
    return _Peak(axis, rms, tremor / below, tremor / valley, tremor / above)


def _densities(
    means: OctaveMeans, bands: Sequence[tuple[float, float]], *, segment: float, by_median: bool = False
) -> list[float] | None:
    """Two-sided densities in some bands [Hz], from periodograms of a length [s]; None if there are too few periodograms,
    or if a density is 0.

    Each is the mean over the frequencies of a band, or the median, which lines do not raise.
    """
    rate = means.stream.grid.rate
    size = round(segment * rate)
    x = take_samples(means.stream, means.channel, count=_EXAMINED)
    rows = x[: len(x) // size * size].reshape(-1, size)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) < _MIN_SEGMENTS:
        return None
    taper = np.hanning(size)
    power = np.abs(np.fft.rfft((rows - rows.mean(axis=1, keepdims=True)) * taper, axis=1)) ** 2
    density = power.mean(axis=0) / rate / float(taper @ taper)
    f = np.arange(len(density)) / segment
    average = median if by_median else np.mean
    by_band = [float(average(density[(f >= low) & (f <= min(high, 0.45 * rate))])) for low, high in bands]
    return by_band if min(by_band) > 0 else None
