"""`calibrate_over_runs`: noise and bias of a sensor over temperature from runs at several temperatures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau import Analysis
from sigmatau._native.distributions import normal_quantile, student_quantile
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.temperature.bias_fit import DEFAULT_DEGREE, MAX_DEGREE
from sigmatau.lab.temperature.branches import LEAST_RANGE
from sigmatau.lab.temperature.calibrate import ROOM
from sigmatau.lab.temperature.polynomial import BiasPolynomial, from_scaled
from sigmatau.lab.temperature.result import TERMS, ChannelCalibration, TemperatureCalibration, TemperatureWindow

_LEAST_FREEDOM = 2  # smallest number of runs beyond the number of coefficients
_SAME = 1.0  # temperatures that differ by less count as one [K]
# Ratio of the highest coefficient to its standard error below which the degree is lowered, as for a log. [1]
_LEAST_RATIO = 1.0


@frozen(eq=False)
class TemperatureRun:
    """A run at one temperature.

    Attributes
    ----------
    name : str
    temperature : float
        [°C]
    result : Analysis

    See Also
    --------
    calibrate_over_runs : calibrates a sensor from several runs.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> log = st.simulate(model, duration=600, rate=10, rng=1)
    >>> st.TemperatureRun(name="cold", temperature=-40.0, result=st.analyze(log)).temperature
    -40.0
    """

    name: str
    temperature: float
    result: Analysis


def calibrate_over_runs(
    runs: Sequence[TemperatureRun],
    *,
    degree: int | None = None,
    reference: float | None = None,
    level: float = 0.95,
    source: str = "",
    unit_name: str = "",
) -> TemperatureCalibration:
    """Noise and bias over temperature from runs of one sensor, each at one temperature.

    Parameters
    ----------
    runs : sequence of TemperatureRun
        At two temperatures or more.
    degree : int, optional
        Degree of the polynomial, 1 to 5. Default: at most 3, as many as the temperatures and two spare runs allow, without
        the highest coefficients that are smaller than their standard errors.
    reference : float, optional
        Temperature about which the polynomial is written. [°C] Default: 25 °C if observed, or the middle of the range.
    level : float
        Confidence level of intervals.
    source, unit_name : str
        Name of the runs, and serial number of the sensor.

    Returns
    -------
    TemperatureCalibration

    Raises
    ------
    DataError
        If the temperatures do not vary by 5 K, or if there are fewer than two runs more than coefficients.
    OptionError
        For a degree outside 1 … 5, a reference outside the range, or a level outside 0.5 … 0.999.

    See Also
    --------
    calibrate_temperature : from one log of a ramp or a soak.

    Notes
    -----
    The bias changes from one power-up to the next by much more than the error of a mean. Intervals of the polynomial are
    those of ordinary least squares: Student's t with the spread of the runs about the polynomial. The branch of a run is
    not known, so that hysteresis is part of this spread.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> runs = []
    >>> for k, temperature in enumerate([-20.0, 0.0, 20.0, 40.0, 60.0]):
    ...     bias = st.Imperfections(level={"gyro_x": 1e-3 + 2e-5 * temperature})
    ...     log = st.simulate(model, duration=600, rate=10, rng=k, imperfections=bias)
    ...     runs.append(st.TemperatureRun(name=f"run {k}", temperature=temperature, result=st.analyze(log)))
    >>> result = st.calibrate_over_runs(runs, degree=1)
    >>> round(float(result["gyro_x"].polynomial.coefficients[1]), 6)
    2e-05
    """
    if degree is not None and (isinstance(degree, bool) or degree not in range(1, MAX_DEGREE + 1)):
        raise OptionError(f"{{option}} must be 1 to {MAX_DEGREE}, not {degree!r}", option="degree")
    if not 0.5 <= level <= 0.999:
        raise OptionError(f"{{option}} must be 0.5 to 0.999, not {level!r}", option="level")
    ordered = sorted(runs, key=lambda run: run.temperature)
    channels = list(dict.fromkeys(name for run in ordered for name in run.result.means))
    if not channels:
        raise DataError("no run has a mean of a channel. Analyse the logs again")
    results = {}
    for channel in channels:
        chosen = [run for run in ordered if channel in run.result.means]
        results[channel] = _channel(channel, chosen, degree=degree, reference=reference, level=level)
    spread = [f"{name}" for name, result in results.items() if result.run_spread]
    return TemperatureCalibration(
        channels=results,
        source=source,
        low=ordered[0].temperature,
        high=ordered[-1].temperature,
        level=level,
        unit_name=unit_name,
        remarks=("hysteresis is not observable: the direction of the runs is not known",) if spread else (),
    )


def _channel(
    channel: str, runs: Sequence[TemperatureRun], *, degree: int | None, reference: float | None, level: float
) -> ChannelCalibration:
    t = np.array([run.temperature for run in runs])
    means = np.array([run.result.means[channel].value for run in runs])
    unit = runs[0].result.means[channel].unit
    low, high = float(t.min()), float(t.max())
    if high - low < LEAST_RANGE:
        raise DataError(
            f"the runs of {channel} are within {high - low:.2g} K. Measure at temperatures {LEAST_RANGE:g} K apart"
        )
    origin = reference
    if origin is None:
        origin = ROOM if low <= ROOM <= high else (low + high) / 2
    elif not low <= origin <= high:
        raise OptionError(
            f"{{option}} {origin:g} °C is outside the observed {low:.4g} to {high:.4g} °C", option="reference"
        )
    polynomial, spread = fit_runs(t, means, degree=degree, reference=origin, level=level, unit=unit)
    curve = next(run.result.curves[channel] for run in runs if channel in run.result.curves)
    return ChannelCalibration(
        channel=channel,
        quantity=curve.quantity,
        unit=unit,
        windows=tuple(_window(channel, run, level) for run in runs),
        polynomial=polynomial,
        run_spread=spread,
    )


def _window(channel: str, run: TemperatureRun, level: float) -> TemperatureWindow:
    """Mean and noise of a run. The mean has an interval if its standard error is known."""
    mean = run.result.means[channel]
    half = None if mean.error is None else float(normal_quantile((1 + level) / 2)) * mean.error
    fitted: Mapping[str, object] = run.result.fits.get(channel, {})
    return TemperatureWindow(
        name=run.name,
        start=0.0,
        stop=run.result.curves[channel].n * run.result.curves[channel].tau0 if channel in run.result.curves else 0.0,
        temperature=run.temperature,
        span=0.0,
        branch="",
        held=True,
        mean=mean.value,
        low=None if half is None else mean.value - half,
        high=None if half is None else mean.value + half,
        terms={name: fitted[name] for name in TERMS if name in fitted},  # type: ignore[misc]
    )


def fit_runs(
    t: Floats, means: Floats, *, degree: int | None, reference: float, level: float, unit: str
) -> tuple[BiasPolynomial, float]:
    """Ordinary least squares, and the standard deviation of the runs about the polynomial.

    `t`, `means`: temperature [°C] and mean of each run, shape (n,).
    """
    low, high, n = float(t.min()), float(t.max()), len(t)
    distinct = 1 + int(np.count_nonzero(np.diff(np.sort(t)) >= _SAME))
    largest = min(distinct - 1, n - 1 - _LEAST_FREEDOM, DEFAULT_DEGREE if degree is None else degree)
    if largest < (1 if degree is None else degree):
        needed = (1 if degree is None else degree) + 1
        raise DataError(
            f"{n} runs at {distinct} temperatures; degree {needed - 1} needs {needed + _LEAST_FREEDOM} runs at {needed}"
            " temperatures. Add runs"
        )
    u = (t - (low + high) / 2) / ((high - low) / 2)

    def fitted(chosen: int) -> tuple[Floats, Floats, float]:
        columns = np.vander(u, chosen + 1, increasing=True)
        inverse = np.linalg.inv(columns.T @ columns)
        estimate = inverse @ columns.T @ means
        freedom = n - chosen - 1
        variance = float(np.sum((means - columns @ estimate) ** 2)) / freedom
        # The covariance is scaled so that normal intervals have the width of Student's t.
        ratio = float(student_quantile(freedom, (1 + level) / 2)) / float(normal_quantile((1 + level) / 2))
        return estimate, np.asarray(variance * ratio**2 * inverse, dtype=np.float64), math.sqrt(variance)

    chosen = largest
    estimate, covariance, spread = fitted(chosen)
    while (
        degree is None and chosen > 1 and abs(estimate[chosen]) < _LEAST_RATIO * math.sqrt(covariance[chosen, chosen])
    ):
        chosen -= 1
        estimate, covariance, spread = fitted(chosen)
    polynomial = from_scaled(
        estimate, covariance, scaled=(low, high), low=low, high=high, reference=reference, level=level, unit=unit
    )
    return polynomial, spread
