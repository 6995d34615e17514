"""Joint likelihood of the filter of a sensor over logs at several rates.

S(f) = N² Σ_k |H(f + k·rate)|² + b/f + k/f² + v/rate + the rounding of the values. N² and the parameters of the filter are
the same for all logs. Slow noise, 1/f and 1/f², is separate for each log; it passes the filter, or is added after it. White
noise of the converter, after the filter, has one variance v for all logs; it is in the model if the logs require it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import field, replace

import numpy as np

from sigmatau._native.distributions import digamma
from sigmatau.arrays import Floats
from sigmatau.fitting.log_spectra import NODES, LogSpectrum
from sigmatau.fitting.sensor_filters import SensorFilter, all_filters
from sigmatau.frozen import frozen

PRICE = 4.0
"""Amount by which a further parameter must lower the deviance, as for the filters of a single record."""

_MEAN = np.full(NODES, 1 / NODES)  # weights of the mean of a model over a bin
_SLOW = 2  # number of powers of 1/f in slow noise
_ROUNDS = 40  # largest number of reweightings in a fit
_ROUNDS_OF_SEARCH = 5  # largest number of reweightings for each tested corner
_DEVIANCE_TOLERANCE = 1e-4  # fall of the deviance below which the reweighting ends
_STEPS = 25  # largest number of steps of the parameters of a filter
_DIFFERENCE = 1e-3  # difference of the logarithm of a parameter, for derivatives
_MAX_STEP = 1.0  # largest step of the logarithm of a parameter
_SINGULAR = 1e-8  # ratio of a singular value to the largest one below which it counts as 0
_ZERO_LENGTH = 1e-150  # replaces a length of 0
_SMALLEST_ERROR = 1e-4  # smallest standard error of the logarithm of a parameter; smaller ones are due to rounding
_LARGEST_ERROR = 0.5  # largest such error; beyond it the likelihood is not a parabola
_HALVINGS = 6
_CORNERS = 2.0  # number of corners that are tested per octave
_LOWEST_CORNER = 0.002  # lowest corner that is tested, over the lowest rate
_HIGHEST_CORNER = 64.0  # highest corner that is tested, over the highest rate
# families that are tested with all corners; the others start at the best corner
_SEARCHED = (("one pole", 1), ("running mean", 1))
_STEPS_OF_FIRST_LOOK = 4
_DROPPED_ABOVE = 100.0  # rise above the best deviance at which a family is dropped after a first look
_MODES_OF_SEARCH = 30.0  # degrees of freedom of a bin in the search: an error of 26 % covers the step between corners
_NOISE_OF_SEARCH = 0.1  # white noise that fills the zeros of running means, over the median density
_TRIALS = (0.7, 1.0, 1.4)  # factors of the best corner at which the other families start


@frozen(eq=False)
class LinearFit:
    """Levels that explain the logs best with a filter of given parameters.

    Attributes
    ----------
    deviance : float
    levels : ndarray, shape (n_levels,)
        N², then 1/f and 1/f² of each log, then the converter if it is in the model; all are non-negative.
    model : ndarray, shape (n_bins,)
    """

    deviance: float
    levels: Floats
    model: Floats


@frozen
class ResponseForm:
    """Parts of the model besides the white noise of the sensor.

    Attributes
    ----------
    filter : SensorFilter
    converter : bool
        Whether there is white noise of the converter.
    passes : bool
        Whether slow noise passes the filter; otherwise it is added after it.
    """

    filter: SensorFilter
    converter: bool = False
    passes: bool = True

    @property
    def price(self) -> float:
        """Penalty for its parameters after the first."""
        return PRICE * (self.filter.count - 1 + self.converter)


@frozen(eq=False)
class FilterFit:
    """A form of the model with its best parameters.

    Attributes
    ----------
    form : ResponseForm
    numbers : ndarray, shape (n_numbers,)
        Parameters of the filter.
    fit : LinearFit
    """

    form: ResponseForm
    numbers: Floats
    fit: LinearFit

    @property
    def filter(self) -> SensorFilter:
        """The family of filters."""
        return self.form.filter

    @property
    def cost(self) -> float:
        """Deviance plus penalty."""
        return self.fit.deviance + self.form.price


@frozen(eq=False)
class Logs:
    """The bins of all logs of one channel.

    Attributes
    ----------
    spectra : tuple of LogSpectrum
    density, modes : ndarray, shape (n_bins,)
    rounding : ndarray, shape (n_bins,)
        Density of the rounding of the values.
    places : tuple of slice
        Positions of the bins of each log.
    rounds : int
        Largest number of reweightings.
    """

    spectra: tuple[LogSpectrum, ...]
    density: Floats = field(repr=False)
    modes: Floats = field(repr=False)
    rounding: Floats = field(repr=False)
    places: tuple[slice, ...] = field(repr=False)
    rounds: int = _ROUNDS

    @classmethod
    def from_spectra(cls, spectra: Sequence[LogSpectrum]) -> Logs:
        """Join the bins of logs."""
        ends = np.cumsum([0, *(len(s.density) for s in spectra)]).tolist()
        return cls(
            spectra=tuple(spectra),
            density=np.concatenate([s.density for s in spectra]),
            modes=np.concatenate([s.modes for s in spectra]),
            rounding=np.concatenate([np.full(len(s.density), s.quantization) for s in spectra]),
            places=tuple(slice(a, b) for a, b in itertools.pairwise(ends)),
        )

    def weakened(self) -> Logs:
        """The same logs with few degrees of freedom per bin and more white noise, so that the maxima of a search are
        wide.
        """
        added = np.concatenate([np.full(len(s.density), _NOISE_OF_SEARCH * np.median(s.density)) for s in self.spectra])
        modes = np.minimum(self.modes, _MODES_OF_SEARCH)
        density, rounding = self.density + added, self.rounding + added
        return replace(self, modes=modes, density=density, rounding=rounding, rounds=_ROUNDS_OF_SEARCH)

    def columns(self, form: ResponseForm, numbers: Floats) -> Floats:
        """Density of each level for the level 1, shape (n_bins, n_levels)."""
        count, family = len(self.spectra), form.filter
        table = np.zeros((len(self.density), 1 + _SLOW * count + form.converter))
        for k, (log, place) in enumerate(zip(self.spectra, self.places, strict=True)):
            f = log.nodes.ravel()
            table[place, 0] = family.folded(f, log.rate, numbers).reshape(log.nodes.shape) @ _MEAN
            slow = log.nodes[0, 0] / log.nodes
            passed = slow * family.power(f, numbers).reshape(log.nodes.shape) if form.passes else slow
            table[place, 1 + _SLOW * k] = passed @ _MEAN
            table[place, 2 + _SLOW * k] = (passed * slow) @ _MEAN
            if form.converter:
                table[place, -1] = 1 / log.rate
        return table

    def deviance(self, model: Floats) -> float:
        """Twice the fall of the log-likelihood, relative to a model that equals every density."""
        ratio = self.density / model
        return float(np.sum(self.modes * (ratio - 1 - np.log(ratio))))

    def fit_levels(self, form: ResponseForm, numbers: Floats, *, begin: Floats | None = None) -> LinearFit:
        """Fit non-negative levels by reweighted least squares."""
        from scipy.optimize import nnls

        table = self.columns(form, numbers)
        model = self.density if begin is None else begin
        best, levels = math.inf, np.zeros(table.shape[1])
        for _ in range(self.rounds):
            weight = np.sqrt(self.modes) / model
            levels, _ = nnls(table * weight[:, None], (self.density - self.rounding) * weight)
            model = np.maximum(table @ levels + self.rounding, 1e-9 * self.density)
            reached = self.deviance(model)
            if abs(best - reached) < _DEVIANCE_TOLERANCE:
                break
            best = reached
        return LinearFit(deviance=self.deviance(model), levels=levels, model=model)

    def error_of_density(self, form: ResponseForm, numbers: Floats, fit: LinearFit) -> float:
        """Standard error of N² with fixed parameters; infinite if it is 0."""
        if not fit.levels[0] > 0:
            return math.inf
        weight = np.sqrt(self.modes / 2) / fit.model
        design = self.columns(form, numbers)[:, fit.levels > 0] * weight[:, None]
        size = np.sqrt((design**2).sum(axis=0))
        inverse = np.linalg.pinv((design / size).T @ (design / size), hermitian=True)
        return math.sqrt(max(float(inverse[0, 0]), 0.0)) / float(size[0])

    def fit_numbers(self, start: FilterFit, *, steps: int = _STEPS) -> FilterFit:
        """Fit the parameters of a form from a start, by scoring of parameters and levels together."""
        form, numbers, fit = start.form, start.numbers, start.fit
        for _ in range(steps):
            step = self._step(form, numbers, fit)
            for _ in range(_HALVINGS):
                tried = limited(form.filter, numbers + step, self.spectra)
                moved = self.fit_levels(form, tried, begin=fit.model)
                if moved.deviance < fit.deviance:
                    break
                step = step / 3
            else:
                break
            gain = fit.deviance - moved.deviance
            numbers, fit = tried, moved
            if gain < 10 * _DEVIANCE_TOLERANCE:
                break
        return FilterFit(form=form, numbers=numbers, fit=fit)

    def _step(self, form: ResponseForm, numbers: Floats, fit: LinearFit) -> Floats:
        design = self._design(form, numbers, fit)
        size = np.sqrt((design**2).sum(axis=0)) + _ZERO_LENGTH
        target = (self.density - fit.model) * np.sqrt(self.modes) / fit.model
        solution = np.linalg.lstsq(design / size, target, rcond=_SINGULAR)[0] / size
        return np.asarray(np.clip(solution[: len(numbers)], -_MAX_STEP, _MAX_STEP))

    def _design(self, form: ResponseForm, numbers: Floats, fit: LinearFit) -> Floats:
        """Derivatives of ln S with respect to the parameters and then the non-zero levels, times the root of the number
        of modes.
        """
        table = self.columns(form, numbers)
        slopes = []
        for k in range(len(numbers)):
            moved = numbers.copy()
            moved[k] += _DIFFERENCE
            slopes.append((self.columns(form, moved) - table) @ fit.levels / _DIFFERENCE)
        weight = np.sqrt(self.modes) / fit.model
        return np.asarray(np.column_stack([*slopes, table[:, fit.levels > 0]]) * weight[:, None])

    def errors_of_numbers(self, best: FilterFit) -> Floats:
        """A root of the covariance of the parameters of a fit, shape (n_numbers, n_numbers)."""
        design = self._design(best.form, best.numbers, best.fit) / math.sqrt(2)
        size = np.sqrt((design**2).sum(axis=0)) + _ZERO_LENGTH
        inverse = np.linalg.pinv((design / size).T @ (design / size), rcond=_SINGULAR, hermitian=True)
        count = len(best.numbers)
        covariance = inverse[:count, :count] / size[:count, None] / size[:count]
        values, vectors = np.linalg.eigh(np.nan_to_num(covariance, posinf=1.0))
        lengths = np.clip(np.sqrt(np.maximum(values, 0.0)), _SMALLEST_ERROR, _LARGEST_ERROR)
        return np.asarray(vectors * lengths)


def deviance_law(freedom: Floats) -> tuple[float, float]:
    """Mean and variance of the deviance Σ ν(r − 1 − ln r) of densities from the true model, where r is χ²(ν)/ν."""
    half = freedom / 2
    mean = freedom * (np.log(half) - digamma(half))
    # Var[ν r − ν ln r] = ν² ψ′(ν/2) − 2ν, with ψ′ by its recurrence and its series, which holds to 1e-6 from 4 on.
    h = half + 4
    trigamma = 1 / h + 1 / (2 * h**2) + 1 / (6 * h**3) - 1 / (30 * h**5)
    for k in range(4):
        trigamma = trigamma + 1 / (half + k) ** 2
    return float(mean.sum()), float((4 * half**2 * trigamma - 4 * half).sum())


def limited(family: SensorFilter, numbers: Floats, spectra: Sequence[LogSpectrum]) -> Floats:
    """Clip parameters to the limits of corners and of the family."""
    low, high = corner_limits(spectra)
    limits = ((low, high), *family.limits)
    return np.array([min(max(x, a), b) for x, (a, b) in zip(numbers, limits, strict=True)])


def corner_limits(spectra: Sequence[LogSpectrum]) -> tuple[float, float]:
    """Lowest and highest frequency of −3 dB that are tested, as logarithms."""
    rates = [log.rate for log in spectra]
    lowest = max(_LOWEST_CORNER * min(rates), min(float(log.nodes[0, 0]) for log in spectra))
    return math.log(lowest), math.log(_HIGHEST_CORNER * max(rates))


def best_fits(logs: Logs) -> list[FilterFit]:
    """Fit all families that are not dropped after a first look; the best first."""
    rates = {log.rate for log in logs.spectra}
    # A digital filter runs at the rate of the logs, which must have one common rate.
    families = {(f.name, f.order): f for f in all_filters(rates.pop() if len(rates) == 1 else None)}
    low, high = corner_limits(logs.spectra)
    corners = np.linspace(low, high, math.ceil((high - low) / math.log(2) * _CORNERS) + 1)
    rough = logs.weakened()
    starts = [_started(rough, families[key], corners) for key in _SEARCHED]
    tried = min(starts, key=lambda fit: fit.cost).numbers[0] + np.log(_TRIALS)
    starts += [_started(rough, family, tried) for key, family in families.items() if key not in _SEARCHED]
    forms = [_changed(logs, fit, replace(fit.form, passes=passes)) for fit in starts for passes in (True, False)]
    fits = _refined(logs, forms)
    converted = _refined(logs, [_changed(logs, fit, replace(fit.form, converter=True)) for fit in fits])
    # Noise of the converter is included only if the logs require it.
    return sorted([*converted, *fits], key=_cost) if converted[0].cost < fits[0].cost else fits


def _started(logs: Logs, family: SensorFilter, corners: Floats) -> FilterFit:
    """Find the best of some corners, and refine the parameters from there."""
    fits, form = [], ResponseForm(filter=family)
    for corner in corners:
        numbers = limited(family, np.array([corner, *family.start]), logs.spectra)
        fits.append(FilterFit(form=form, numbers=numbers, fit=logs.fit_levels(form, numbers)))
    return logs.fit_numbers(min(fits, key=lambda fit: fit.cost))


def _refined(logs: Logs, starts: Sequence[FilterFit]) -> list[FilterFit]:
    """Complete the fits of the families that remain after a few steps; the best is first."""
    rough = [logs.fit_numbers(start, steps=_STEPS_OF_FIRST_LOOK) for start in starts]
    lowest = min(fit.cost for fit in rough)
    return sorted((logs.fit_numbers(fit) for fit in rough if fit.cost < lowest + _DROPPED_ABOVE), key=_cost)


def _cost(fit: FilterFit) -> float:
    return fit.cost


def _changed(logs: Logs, fit: FilterFit, form: ResponseForm) -> FilterFit:
    """Keep the parameters, and refit the levels in another form or with other weights."""
    return FilterFit(form=form, numbers=fit.numbers, fit=logs.fit_levels(form, fit.numbers, begin=fit.fit.model))
