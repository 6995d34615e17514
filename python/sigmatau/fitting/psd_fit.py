"""The noise terms of a measured density, by the likelihood of its χ² scatter."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native.distributions import chi2_quantile_above, normal_below
from sigmatau._native.gls import non_negative
from sigmatau.arrays import Floats
from sigmatau.digits import limit_text, round_to_error
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting.arguments import check_level, wanted_terms
from sigmatau.fitting.filter_fit import deviance_law
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.density_sources import check_density, rising_frequencies
from sigmatau.model.psd_avar import Sided, check_interval, check_nyquist
from sigmatau.noise.terms import NOISE, TERMS, display_units, psd
from sigmatau.results import Printed, lines_text, plain
from sigmatau.units import find

_MIN_FREQUENCIES = 10  # smallest number of frequencies
_STEPS = 100  # largest number of steps of the reweighted least squares
_CONVERGED = 1e-9  # tolerance of −2 ln L
_LARGEST_RANGE = 60  # largest range of densities and of frequencies [decades]
_HALVINGS = 40  # largest number of halvings of a step, and of steps towards an end of an interval
_ROOT_TOLERANCE = 1e-6  # tolerance of the root of the rise of −2 ln L, and relative width of the bracket
_MISFIT = 0.01
"""p-value below which the terms do not describe the density, as in `sigmatau.fit`."""

QUANTITIES = {"rad/s": "angular_rate", "m/s^2": "acceleration"}


@frozen
class PsdFit(Printed):
    """Noise terms of a measured density.

    Attributes
    ----------
    model : ChannelModel
        The observed terms with their intervals, and limits of the others, as input of `state_space`, `predict` and the
        exports. It has no intervals and limits if the terms do not describe the density.
    p : float
        P-value of the goodness of fit: probability of a larger misfit if the model is correct.
    f_min, f_max : float
        Frequencies of the density. [Hz]
    level : float
        Probability of the intervals and limits.

    See Also
    --------
    fit_psd : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> f = np.geomspace(0.01, 50, 400)
    >>> measured = 1e-8 * np.random.default_rng(1).chisquare(40, 400) / 40
    >>> fit = st.fit_psd(f, measured, dof=40, sided="two")
    >>> list(fit.model), fit.is_adequate
    (['random_walk'], True)
    """

    model: ChannelModel
    p: float
    f_min: float
    f_max: float
    level: float = 0.95

    @property
    def is_adequate(self) -> bool:
        """Whether the terms describe the density: p is at least 0.01."""
        return self.p >= _MISFIT

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        intervals = {name: list(ends) for name, ends in self.model.intervals.items()}
        values = {"terms": dict(self.model), "intervals": intervals, "limits": dict(self.model.limits)}
        return plain(self, "p f_min_hz=f_min f_max_hz=f_max level", unit=self.model.unit, **values)

    def __repr__(self) -> str:
        band = f"density from {self.f_min:.4g} to {self.f_max:.4g} Hz"
        lines = [f"{band}, p = {self.p:.2g}; {100 * self.level:g} % intervals"]
        if not self.is_adequate:
            lines.append("  the terms do not describe this density: no interval holds")
        for name in NOISE:
            printed = self.model.get(name, self.model.limits.get(name))
            unit, factor = display_units(name, self.model.quantity, self.model.unit, [printed])[0]
            label = TERMS[name].label(self.model.quantity)
            if name in self.model:
                ends = self.model.intervals.get(name, ())
                lines.append(f"  {label:24} {round_to_error(self.model[name], *ends, size=factor).with_unit(unit)}")
            elif name in self.model.limits:
                lines.append(f"  {label:24} {limit_text(self.model.limits[name] / factor)} {unit}: not observed")
        return lines_text(lines)


def fit_psd(
    frequency: ArrayLike,
    density: ArrayLike,
    *,
    dof: ArrayLike,
    sided: Sided,
    unit: str = "rad/s",
    tau0: float | None = None,
    terms: Iterable[str] | None = None,
    level: float = 0.95,
) -> PsdFit:
    """Noise terms of a measured density, with intervals.

    Parameters
    ----------
    frequency : array_like, shape (n_f,)
        Rising frequencies above 0. [Hz]
    density : array_like, shape (n_f,)
        Measured density of the rate, positive. [unit²/Hz]
    dof : float or array_like, shape (n_f,)
        Degrees of freedom of each density: twice the number of averages. The densities must be independent: use only
        every second frequency of a Hann window, or use `Spectrum.binned` and its `dof`. [1]
    sided : {"one", "two"}
        As in `avar_from_psd`.
    unit : str
        SI unit of the rate: rad/s, m/s^2, or the unit of another signal.
    tau0 : float, optional
        Sample interval, if the density is that of samples: the terms are then folded at 1/(2·tau0), and quantization
        noise is fitted too. Default: continuous time. [s]
    terms : iterable of str, optional
        Terms to fit, keys of `sigmatau.noise.terms.TERMS`. Default: all but the ramp, which has no density.
    level : float
        Confidence level of the intervals and limits; a term is observed if its p-value is below 1 − level.

    Returns
    -------
    PsdFit

    Raises
    ------
    DataError
        For a density that is not positive or not finite, for frequencies that do not rise, fewer than ten of them, or if no
        term is observed.
    OptionError
        For degrees of freedom that are not positive, another `sided`, a unit that is not SI, a `tau0` that is not positive,
        frequencies above 1/(2·tau0), an unknown term, a level outside 0.5 … 0.999.
    TypeError
        If `unit` is not a text.

    See Also
    --------
    avar_from_psd : Allan variance of the density, without a model.
    analyze : the terms of a record; it uses the whole record, including the lowest frequencies, which a spectrum has lost.

    Notes
    -----
    Each density P is S·χ²/dof, so that −2 ln L = Σ dof·(ln S + P/S), S = Σ c²·s(f) over the terms with c² ≥ 0 [1]_. A
    term is observed if the likelihood without it is smaller than half the χ² of one degree of freedom at 2·level − 1. Its
    interval is that of the profile likelihood, with all terms and with the observed ones; the limit of a term that is not
    observed is the upper end of its interval.

    References
    ----------
    .. [1] P. Whittle, "Estimation and information in stationary time series," Arkiv för Matematik 2 (1953).

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "bias_instability": 2e-4}})
    >>> spectrum = st.psd(st.simulate(model, duration=3600, rate=10, rng=1))["gyro_x"].binned()
    >>> use = spectrum.frequency > spectrum.trusted
    >>> f, s, dof = spectrum.frequency[use], spectrum.density[use], spectrum.dof[use]
    >>> st.fit_psd(f, s, dof=dof, sided="two", tau0=0.1)
    density from 0.01221 to 4.794 Hz, p = 0.2; 95 % intervals
      quantization             below 0.98 arcsec: not observed
      angle random walk        0.3408 [0.3273, 0.3473] deg/√h
      bias instability         42.2 [40.3, 43.7] deg/h
      rate random walk         below 480 deg/h/√h: not observed
    """
    if sided not in ("one", "two"):
        raise OptionError(f"{{option}} must be 'one' or 'two', not {sided!r}", option="sided")
    check_level(level)
    check_interval(tau0)
    _check_unit(unit)
    f = rising_frequencies(frequency)
    measured = np.asarray(density)
    if measured.shape != f.shape or measured.dtype.kind not in "fiu":
        raise DataError(
            f"`density` must be {len(f)} numbers, as `frequency`, not {measured.dtype} of shape {measured.shape}"
        )
    check_density(measured, f)
    if len(f) < _MIN_FREQUENCIES or not (measured > 0).all():
        positive = np.count_nonzero(measured > 0)
        raise DataError(f"`density` must have {_MIN_FREQUENCIES} or more values above 0; it has {positive}")
    for name, column in (("density", measured), ("frequency", f)):
        if np.ptp(np.log10(column)) > _LARGEST_RANGE:  # squares of the fit would not be doubles
            raise DataError(f"`{name}` has values from {column.min():g} to {column.max():g}; leave out the wrong ones")
    weights = _freedom(dof, f)
    check_nyquist(float(f[-1]), tau0)
    names = [name for name in NOISE if name in wanted_terms(terms) and (tau0 is not None or name != "quantization")]
    shapes = np.array([psd(name, 1.0, f, tau0=tau0) for name in names])
    # scale so that squares of very small and very large densities stay in range
    scale = float(np.exp(np.log(measured).mean()))
    fitted = _Likelihood(measured / scale * (0.5 if sided == "one" else 1.0), weights, shapes)
    best = fitted.maximum()
    rise, threshold = (float(chi2_quantile_above([1.0], [q])[0]) for q in (1 - level, 2 - 2 * level))
    ends = {name: fitted.profile(k, best, rise) for k, name in enumerate(names)}
    observed = [k for k in range(len(names)) if fitted.without(k) - best.value > threshold]
    if not observed:
        raise DataError("no noise term is observed in the density; it may have too few degrees of freedom")
    chosen = _Likelihood(fitted.measured, weights, shapes[observed])
    maximum = chosen.maximum()
    values = maximum.theta
    present = [names[k] for k in observed]
    if len(present) < len(names):  # observed terms absorb part of the others
        for k, name in enumerate(present):
            low, high = chosen.profile(k, maximum, rise)
            ends[name] = min(ends[name][0], low), max(ends[name][1], high)
    p = fitted.p_value(values @ shapes[observed], len(observed))
    adequate = p >= _MISFIT
    root = math.sqrt(scale)
    intervals = {name: (root * math.sqrt(ends[name][0]), root * math.sqrt(ends[name][1])) for name in present}
    limits = {name: root * math.sqrt(ends[name][1]) for name in names if name not in present}
    model = ChannelModel(
        terms={name: root * math.sqrt(value) for name, value in zip(present, values, strict=True)},
        quantity=QUANTITIES.get(unit, "signal"),
        unit=unit,
        intervals=intervals if adequate else {},
        limits=limits if adequate else {},
        level=level,
        adequate=adequate,
    )
    return PsdFit(model=model, p=p, f_min=float(f[0]), f_max=float(f[-1]), level=level)


def _check_unit(unit: str) -> None:
    """Raise `OptionError` unless the unit of the rate is SI."""
    if not isinstance(unit, str):
        raise TypeError(f"`unit` must be a text such as 'rad/s', not {unit!r}")
    try:
        rate_unit = find(unit)
    except ValueError:  # the unit of another signal
        return
    if rate_unit.factor != 1.0:
        raise OptionError(
            f"{{option}} must be SI, {rate_unit.si}, not {unit}: multiply the density by {rate_unit.factor**2:.6g}",
            option="unit",
        )


def _freedom(dof: ArrayLike, f: Floats) -> Floats:
    """Degrees of freedom of each density. Raises `OptionError` unless they are positive numbers."""
    values = np.asarray(dof)
    if values.dtype.kind not in "fiu" or values.shape not in ((), f.shape):
        raise OptionError(
            f"{{option}} must be a number, or one for each of {len(f)} densities, not {dof!r}", option="dof"
        )
    if not (np.isfinite(values) & (values > 0)).all():
        raise OptionError("{option} must be positive: twice the number of averages", option="dof")
    return np.asarray(np.broadcast_to(values, f.shape), dtype=np.float64)


@frozen(kw_only=False, eq=False)
class _Maximum:
    """Squared coefficients, and −2 ln L at this point."""

    theta: Floats
    value: float


@frozen(kw_only=False, eq=False)
class _Likelihood:
    """Whittle's likelihood of densities, as a function of the squared coefficients of given shapes."""

    measured: Floats
    dof: Floats
    shapes: Floats

    def maximum(self, held: Floats | float = 0.0) -> _Maximum:
        """Maximise the likelihood over non-negative squared coefficients, with a fixed additional density.

        The densities S are weighted by dof/S² in least squares, and again with the new S, until the likelihood is
        stationary.
        """
        starts = [_non_negative(self.shapes, self.measured - held, np.sqrt(self.dof) / self.measured)]
        medians = np.array([float(np.median(self.measured / shape)) for shape in self.shapes])
        starts += [medians / len(medians), *np.diag(medians)]
        return min((self._climbed(start, held) for start in starts), key=lambda end: end.value)

    def _climbed(self, theta: Floats, held: Floats | float) -> _Maximum:
        """Iterate from a start to a stationary point of the likelihood."""
        value = self._value(theta @ self.shapes + held)
        for _ in range(_STEPS):
            total = theta @ self.shapes + held
            if not (total > 0).all():
                return _Maximum(theta, value)
            step = _non_negative(self.shapes, self.measured - held, np.sqrt(self.dof) / total) - theta
            before = value
            for _ in range(_HALVINGS):
                value = self._value((theta + step) @ self.shapes + held)
                if value <= before:
                    break
                step = step / 2
            else:
                return _Maximum(theta, before)
            theta = theta + step
            if before - value < _CONVERGED:
                break
        return _Maximum(theta, value)

    def _value(self, density: Floats) -> float:
        """−2 ln L, without terms that do not depend on the density."""
        if not (density > 0).all():
            return math.inf
        ratio = self.measured / density
        return float(self.dof @ (ratio - 1 - np.log(ratio)))

    def value_with(self, k: int, theta: float) -> float:
        """Smallest −2 ln L with one squared coefficient fixed."""
        rest = np.delete(self.shapes, k, axis=0)
        held = theta * self.shapes[k]
        if not len(rest):
            return self._value(held)
        return _Likelihood(self.measured, self.dof, rest).maximum(held).value

    def without(self, k: int) -> float:
        """Smallest −2 ln L without a term; infinite for the only term."""
        return math.inf if len(self.shapes) == 1 else self.value_with(k, 0.0)

    def profile(self, k: int, best: _Maximum, rise: float) -> tuple[float, float]:
        """Ends of the interval of a squared coefficient, where −2 ln L is higher by `rise`."""
        total = best.theta @ self.shapes
        error = math.sqrt(2 / float(self.dof @ (self.shapes[k] / total) ** 2))
        middle = float(best.theta[k])
        high = middle + error
        while self.value_with(k, high) - best.value < rise:
            high = middle + 2 * (high - middle)
        upper = self._crossing(k, middle, high, best.value, rise)
        if middle == 0 or self.without(k) - best.value <= rise:
            return 0.0, upper
        return self._crossing(k, middle, 0.0, best.value, rise), upper

    def _crossing(self, k: int, inside: float, outside: float, target: float, rise: float) -> float:
        """The squared coefficient between two others at which −2 ln L is `target` + `rise`.

        Regula falsi (Illinois) on the root of the rise, which is nearly linear.
        """

        def excess(theta: float) -> float:
            return math.sqrt(max(self.value_with(k, theta) - target, 0.0)) - math.sqrt(rise)

        below, above, side = -math.sqrt(rise), excess(outside), 0
        for _ in range(_HALVINGS):
            share = 0.5 if math.isinf(above) else below / (below - above)  # infinite if the only term is left out
            middle = inside + share * (outside - inside)
            value = excess(middle)
            if abs(value) < _ROOT_TOLERANCE or abs(outside - inside) < _ROOT_TOLERANCE * abs(outside + inside):
                return middle
            if value < 0:
                inside, below, above = middle, value, above / 2 if side < 0 else above
                side = -1
            else:
                outside, above, below = middle, value, below / 2 if side > 0 else below
                side = 1
        return (inside + outside) / 2

    def p_value(self, density: Floats, terms: int) -> float:
        """P-value of the misfit dof·(P/S − 1 − ln P/S), whose mean and variance are those of a χ² law."""
        mean, variance = deviance_law(self.dof)
        share = 1 - terms / len(density)
        return float(normal_below([(share * mean - self._value(density)) / math.sqrt(share * variance)])[0])


def _non_negative(shapes: Floats, target: Floats, weight: Floats) -> Floats:
    """Weighted least squares with coefficients that are not negative."""
    columns = shapes * weight
    size = np.sqrt((columns**2).sum(axis=1))
    return np.asarray(non_negative((columns / size[:, None]).T, target * weight) / size)
