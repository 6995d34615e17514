"""`analyze_array`: covariance of several synchronous sensors of one axis, and the virtual sensor that combines them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau import Analysis, NoiseFit, Record, analyze
from sigmatau.arrays import Bools
from sigmatau.errors import DataError, NotAtRestError, OptionError
from sigmatau.hints import Hint
from sigmatau.lab.arrays.array_fit import (
    choose_components,
    estimate_coefficients,
    estimate_correlations,
    find_conditions,
    measure_covariances,
    without_drifts,
)
from sigmatau.lab.arrays.channels import ArrayRecord, collect_channels, complete_rows, make_record, refuse_unusable
from sigmatau.lab.arrays.codeviation import AllanCovariance, HatCurve, hat_curves
from sigmatau.lab.arrays.components import component_unit, first_values, observed_components
from sigmatau.lab.arrays.fusing import FittedArray, make_virtual
from sigmatau.lab.arrays.goodness import judge_goodness
from sigmatau.lab.arrays.result import ArrayAnalysis
from sigmatau.lab.arrays.virtual_sensor import mixed_terms
from sigmatau.noise.terms import NOISE
from sigmatau.noise.uncertainty import degrees_of_freedom
from sigmatau.record import stream_name
from sigmatau.results import seconds

_TOO_WEAK = (
    "the record determines the covariance of the target too weakly for weights. Record longer, or take another target"
)
_LEAST_OF_HAT = 3  # smallest number of sensors of an N-cornered hat
# Correlation of two sensors below which one has the opposite sign. [1] Judgement: independent noise does not reach it.
_OPPOSITE, _OPPOSITE_COMMON = -0.8, -0.3
_DUPLICATED = (
    1e-6  # ratio of variances, of the difference of two sensors to one of them, below which they are one signal [1]
)


def analyze_array(
    record: Record | Sequence[Record],
    *,
    axes: Sequence[str] | None = None,
    invert: Sequence[str] = (),
    target: str | float = "random_walk",
    common: bool = False,
    name: str | None = None,
    level: float = 0.95,
    threads: int | None = None,
) -> ArrayAnalysis:
    """Analyse several sensors of one axis that were sampled together: covariance, weights, virtual sensor.

    The covariance matrix of each noise term is estimated by the likelihood of the cosine transforms of all channels. The
    weights of the virtual sensor minimise the noise that `target` names.

    Parameters
    ----------
    record : Record or sequence of Record
        Log of all sensors at rest; or several logs with the same clock, one sensor each.
    axes : sequence of str, optional
        Channels of the sensors. For several logs, the single channel that each has; the channels are then named
        ``gyro_x_1``, ``gyro_x_2`` … Default: all channels, if they have one quantity.
    invert : sequence of str
        Channels whose sign is reversed, because their sensors point in the opposite direction.
    target : str or float
        What the weights minimise: a term, ``"random_walk"``, ``"bias_instability"`` or ``"rate_random_walk"``, or the Allan
        deviation at an averaging time. [s]
    common : bool
        Eliminate a disturbance that all sensors have in common, such as the motion of a table: only differences are used,
        and the noise of the sensors is assumed to be independent (N-cornered hat).
    name : str, optional
        Channel of the virtual sensor. Default: ``"gyro_x"`` if all channels are of the axis x, otherwise ``"gyro_virtual"``.
    level : float
        Confidence level of intervals.
    threads : int, optional
        Default: all cores. Results do not depend on it.

    Returns
    -------
    ArrayAnalysis

    Raises
    ------
    OptionError
        For an unknown channel or target, one sensor, or two sensors with `common`.
    DataError
        For channels that are not synchronous, a sensor that is dead, duplicated, moving or of opposite sign, or a record
        that is too short.

    See Also
    --------
    analyze : each sensor alone.
    cross_spectrum : coherence of two channels.

    References
    ----------
    .. [1] R. J. Vaccaro, A. S. Zaki, "Reduced-drift virtual gyro from an array of low-cost gyros," Sensors, vol. 17, no. 2,
       352, 2017, :doi:`10.3390/s17020352`.
    .. [2] É. Lantz et al., "KLTS: a rigorous method to compute the confidence intervals for the three-cornered hat and for
       Groslambert covariance," IEEE Trans. UFFC, vol. 66, no. 12, 2019, :doi:`10.1109/TUFFC.2019.2931911`.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={f"gyro_{k}": {"random_walk": 1e-4} for k in "abcd"})
    >>> array = st.analyze_array(st.simulate(model, duration=600, rate=10, rng=1))
    >>> array.virtual.weights.differ  # equal sensors
    False
    >>> walk = array.virtual.coefficients["random_walk"]
    >>> walk.low < 1e-4 / 2 < walk.high
    True
    """
    _check_options(target, level)
    array = collect_channels(record, axes, invert)
    _check_number(array.names, common=common)
    _check_virtual_name(name, array.names)
    stream = array.record.streams[0]
    refuse_unusable(array.names, array.samples, stream.quantity)
    analysis, fits, rows = _analyze_channels(array, common=common, threads=threads)
    raw, filled = complete_rows(array.samples, rows)
    tau0, unit = stream.grid.tau0, stream.unit
    components, conditions = observed_components(fits), find_conditions(fits)
    first = first_values(components, fits)
    if common:
        first = np.repeat(0.5 * first.mean(axis=1, keepdims=True), len(array.names), axis=1)
    samples = without_drifts(raw, tau0, conditions)
    components, first, fit = choose_components(
        samples, tau0, components, fits, first, common=common, conditions=conditions
    )
    goodness = judge_goodness(fit)
    fitted = FittedArray(
        samples=samples,
        tau0=tau0,
        components=components,
        first=first,
        conditions=conditions,
        fit=fit,
        widening=goodness.widening,
        level=level,
        common=common,
    )
    m = fitted.cluster_sizes
    covariances = measure_covariances(array.names, samples, tau0, m, fit, components, level)
    _refuse_opposite(covariances, common=common)
    units = [component_unit(component, stream.quantity, unit) for component in components]
    coefficients = estimate_coefficients(array.names, fit, components, goodness.widening, level, units)
    virtual = make_virtual(
        fitted,
        target,
        channel=name or _virtual_name(array.names),
        quantity=stream.quantity,
        unit=unit,
        units=units,
    )
    hat: tuple[HatCurve, ...] = ()
    if common:
        edf = degrees_of_freedom(mixed_terms(components, fit.theta.mean(axis=1)), n=samples.shape[1], m=m, tau0=tau0)
        hat = hat_curves(array.names, samples, tau0, m * tau0, edf, level=level)
    return ArrayAnalysis(
        names=array.names,
        sources=array.sources,
        quantity=stream.quantity,
        unit=unit,
        samples=samples.shape[1],
        filled=filled,
        tau0=tau0,
        common=common,
        level=level,
        components=components,
        coefficients=coefficients,
        correlations={}
        if common
        else estimate_correlations(array.names, fit, components, coefficients, goodness.widening, level),
        covariances=covariances,
        hat=hat,
        goodness=goodness,
        virtual=virtual,
        no_weights="" if virtual is not None else _TOO_WEAK,
        analysis=analysis,
        fused=np.empty(0) if virtual is None else virtual.weights.vector @ raw,
    )


def _check_options(target: str | float, level: float) -> None:
    if isinstance(target, str) and target not in NOISE:
        raise OptionError(
            f"{{option}} must be {', '.join(NOISE)} or an averaging time in s, not {target!r}", option="target"
        )
    if not isinstance(target, str) and not (np.isfinite(target) and target > 0):
        raise OptionError(f"{{option}} must be a positive averaging time in s, not {target!r}", option="target")
    if not 0.5 <= level <= 0.999:
        raise OptionError(f"{{option}} must be 0.5 to 0.999, not {level!r}", option="level")


def _check_number(names: Sequence[str], *, common: bool) -> None:
    if len(names) < 2:
        raise OptionError(f"{{option}}: an array has at least two sensors, not {', '.join(names)}", option="axes")
    if common and len(names) < _LEAST_OF_HAT:
        raise OptionError(
            "{option} needs three sensors or more: the difference of two does not show which of them has the noise",
            option="common",
        )


def _analyze_channels(
    array: ArrayRecord, *, common: bool, threads: int | None
) -> tuple[Analysis, Mapping[str, NoiseFit], Bools]:
    """Analyse the sensors, or their differences; return the analysis, its fits, and the rows that are left out."""
    record, names, samples = array.record, list(array.names), array.samples
    if common:
        prefix = names[0].rpartition("_")[0] or names[0]
        differences = {f"{prefix}_difference_{j}": samples[0] - samples[j] for j in range(1, len(samples))}
        for j, values in enumerate(differences.values(), 1):
            if float(np.nanvar(np.diff(values))) < _DUPLICATED * float(np.nanvar(np.diff(samples[j]))):
                raise DataError(f"{names[0]} and {names[j]} are one signal. Leave one out")
        record, names = make_record(differences, record.streams[0]), list(differences)
    analysis = analyze(record, threads=threads)
    if not analysis.fits:
        reason = analysis.reason_without_fits or "no channel has a fit"
        raise NotAtRestError(f"{', '.join(array.names)}: {reason}. An array needs a record at rest")
    lacking = [name for name in names if name not in analysis.fits or not analysis[name].model]
    if lacking:
        raise DataError(f"{', '.join(lacking)}: no noise model fits this sensor. Leave it out of {Hint('axes')}")
    rows = np.zeros(record.streams[0].grid.n, dtype=bool)
    for each in names:
        rows |= analysis.mask(each).excluded
    return analysis, {name: analysis[name] for name in names}, rows


def _refuse_opposite(covariances: Sequence[AllanCovariance], *, common: bool) -> None:
    """Raise `OptionError` for two sensors whose noise has opposite signs at an averaging time."""
    limit = _OPPOSITE_COMMON if common else _OPPOSITE
    for curve in covariances:
        k = int(np.argmin(curve.correlation_high))
        if curve.correlation_high[k] < limit:
            raise OptionError(
                f"{curve.first} and {curve.second} have opposite signs: correlation {curve.correlation[k]:.2f} at"
                f" {seconds(float(curve.tau[k]))} s. Invert one: {{option}} {curve.second}",
                option="invert",
            )
        if not common and np.max(curve.correlation_low) > 1 - _DUPLICATED:
            raise DataError(f"{curve.first} and {curve.second} are one signal with two scales. Leave one out")


def _check_virtual_name(name: str | None, names: Sequence[str]) -> None:
    sensor = stream_name(names[0])
    if name is not None and (name in names or stream_name(name) != sensor or not re.fullmatch(r"\w+", name)):
        raise OptionError(f"{{option}} {name!r:.40}: must be a new channel of {sensor}, e.g. {sensor}_x", option="name")


def _virtual_name(names: Sequence[str]) -> str:
    """Sensor and axis of the channels, if they have one axis."""
    sensor = names[0].split("_")[0]
    axes = {part for name in names for part in name.split("_")[1:] if part in ("x", "y", "z")}
    return f"{sensor}_{axes.pop()}" if len(axes) == 1 else f"{sensor}_virtual"
