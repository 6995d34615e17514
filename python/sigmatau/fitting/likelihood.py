"""Fit of one channel by the likelihood of its spectrum; see `fit_samples`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau._native.likelihood import Bounds, Outcome, Process
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.findings.kinds.fit import MOST_LINES, BandLeftOut, BandsOff, Reason
from sigmatau.fitting.arguments import check_level, wanted_terms
from sigmatau.fitting.beside_vibration import allowing_for_changes, crowded_share, with_lines_as_noise
from sigmatau.fitting.components import LINEAR
from sigmatau.fitting.disturbance import is_disturbed, vibration_of, with_limits
from sigmatau.fitting.noise_fit import (
    FittedTerm,
    GaussMarkov,
    Interval,
    NoiseFit,
    Resonance,
    Sinusoid,
    Verdict,
    WarmUp,
)
from sigmatau.fitting.observed import observed_term
from sigmatau.fitting.pass_over import never_changes, summary_of
from sigmatau.fitting.response import UNUSED_POWER, FittedFilter, named
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.resonance import folds
from sigmatau.noise.terms import coefficient_unit
from sigmatau.record.streams import Stream

Floats = NDArray[np.float64]

# Difference of the Allan variances of fit and model where the model describes the curve: relative, and in standard errors of
# a measured one
_SAME, _SAME_ERRORS = 0.02, 0.5
_MEAN_OF_SINE_4 = 0.375  # mean of sin⁴ over an oscillation
_MOST_PROCESSES, _MOST_REGRESSORS = 8, 20
_LEAST_CURVE, _LARGEST_CURVE = 1e-150, 1e150  # sizes of regressors whose squares stay in range
_LONGEST_SHARE = 3  # of the record: its length over the longest averaging time


def fit_samples(
    stream: Stream,
    channel: str,
    *,
    terms: Iterable[str] | None = None,
    processes: Sequence[float] | None = None,
    regressors: Mapping[str, ArrayLike] | None = None,
    level: float = 0.95,
) -> NoiseFit:
    """Fit the noise of a channel to its samples.

    The model holds the terms and what else the spectrum shows: a filter, lines, Gauss-Markov processes, resonances, a
    warm-up, a ramp. Each was added because it raises the likelihood by more than its price. Where the model is not quite
    right, the intervals are wider for it.

    Parameters
    ----------
    stream, channel : Stream, str
        `usable`; samples may be missing.
    terms : iterable of str, optional
        Terms that may be present, keys of `sigmatau.noise.terms.TERMS`. Default: all.
    processes : sequence of float, optional
        Correlation times at which to start Gauss-Markov processes; no other process or resonance is then added. [s]
    regressors : mapping of str to array_like, shape (n,), optional
        Curves at the samples that the mean may follow, by name.
    level : float
        Of intervals and limits.

    Raises
    ------
    OptionError
        For an unknown term or no noise term, a correlation time that is not positive, a regressor of another length, that is
        not finite or never changes, or a level outside 0.5 … 0.999.
    DataError
        For a channel that never changes.
    """
    given_terms = wanted_terms(terms)
    _refuse(processes, regressors, stream.grid.n, level)
    if never_changes(stream, channel):
        raise DataError(f"channel {channel!r} never changes in {stream.grid.n} samples: it has no noise to fit")
    summary, start = summary_of(stream, channel)
    wanted = given_terms & set(LINEAR)
    given = regressors or {}
    curves = [at_blocks(summary.centres + start, curve, stream.grid.tau0) for curve in given.values()]
    sizes = [float(curve.std()) or 1.0 for curve in curves]

    def analysed(*, lines: bool = True) -> Outcome:
        return summary.analyse(
            terms=wanted,
            processes=processes is None,
            resonances=processes is None,
            lines=lines,
            drifts="rate_ramp" in given_terms,
            times=processes or (),
            regressors=[(curve - curve.mean()) / size for curve, size in zip(curves, sizes, strict=True)],
            level=level,
        )

    found = analysed()
    coefficients = tuple(
        (value / size, error / size) for size, (value, error) in zip(sizes, found.regressors, strict=True)
    )
    found = replace(found, regressors=coefficients)
    fitted = stated(stream, channel, found, wanted=wanted, regressors=tuple(given), level=level)
    if is_disturbed(fitted, stream, unsteady=found.unsteadiness[1]):
        return with_limits(fitted, stream, vibration_of(fitted, stream))
    highest = found.highest or 0.5 / stream.grid.tau0
    if share := crowded_share(found.lines, spacing=summary.spacing, highest=highest):
        fitted = with_lines_as_noise(fitted, analysed(lines=False), share, highest=highest)
    return allowing_for_changes(fitted, found.unsteadiness)


def _refuse(
    processes: Sequence[float] | None,
    regressors: Mapping[str, ArrayLike] | None,
    n: int,
    level: float,
) -> None:
    check_level(level)
    times = _numbers(() if processes is None else processes)
    if times is None or times.ndim != 1 or len(times) > _MOST_PROCESSES or not ((times > 0) & (times < math.inf)).all():
        raise OptionError(
            f"{{option}} must be up to {_MOST_PROCESSES} positive times in s, not {processes!r:.80}", option="processes"
        )
    if len(regressors or {}) > _MOST_REGRESSORS:
        raise OptionError(
            f"{{option}} must be at most {_MOST_REGRESSORS} curves, not {len(regressors or {})}", option="regressors"
        )
    for name, curve in (regressors or {}).items():
        values = _numbers(curve)
        if (
            values is None
            or values.shape != (n,)
            or not (np.ptp(values) > _LEAST_CURVE and np.abs(values).max() < _LARGEST_CURVE)
        ):
            raise OptionError(f"{{option}} {name!r} must be {n} finite real numbers that change", option="regressors")


def _numbers(values: object) -> Floats | None:
    """Real numbers; None if they are not."""
    try:
        found = np.asarray(values)
        return None if found.dtype.kind not in "biuf" else found.astype(np.float64)
    except (TypeError, ValueError):
        return None


def at_blocks(centres: Floats, curve: ArrayLike, tau0: float) -> Floats:
    """A curve that is given at the samples, at other times."""
    values = np.asarray(curve, dtype=float)
    return np.asarray(np.interp(centres, (np.arange(len(values)) + 0.5) * tau0, values))


def stated(
    stream: Stream, channel: str, found: Outcome, *, wanted: set[str], regressors: tuple[str, ...], level: float
) -> NoiseFit:
    """The fit of a channel from the outcome of its likelihood, with the names of its regressors."""
    n, tau0 = stream.grid.n, stream.grid.tau0
    quantile = -float(normal_quantile((1 - level) / 2))
    model = {name: math.sqrt(value) for name, value in found.reduced.items() if value > 0}
    names, covariance = _covariance(found, model)
    errors = dict(zip(names, np.sqrt(np.maximum(np.diag(covariance), 0.0)), strict=True))
    terms = {name: _term(stream, found, name, model, errors, level) for name in LINEAR if name in wanted}
    ramp = _ramp(stream, found, quantile, level)
    terms["rate_ramp"] = ramp
    if ramp.value is not None:
        model["rate_ramp"] = ramp.value
    response = None
    if found.filter:
        own = len(found.parameters)
        rows = slice(own, own + len(found.filter))
        response = named(
            found.filter,
            found.covariance[rows, rows],
            tau0=tau0,
            interval=found.filter_interval,
            quantile=quantile,
        )
        last = float(found.bins[:, 0].max())
        if found.highest is None or response.power(np.array([last]))[0] < UNUSED_POWER:
            response = replace(response, known_to=last)
    processes, resonances, steady = _processes(stream, found, response)
    warm_up = None
    if found.warm_up is not None:
        time, size, error, _ = found.warm_up
        warm_up = WarmUp(amplitude=_around(size, quantile * error, stream.unit), time=time)
    lines = tuple(
        Sinusoid(
            amplitude=_around(line.amplitude, min(quantile * line.error, 0.999 * line.amplitude), stream.unit),
            frequency=Interval(value=line.frequency, low=line.low, high=line.high, unit="Hz"),
        )
        for line in found.lines
        if line.amplitude > 0
    )
    lines = tuple(sorted((*lines, *steady), key=lambda line: -line.amplitude.value))[:MOST_LINES]
    reasons: tuple[Reason, ...] = () if found.highest is None else (BandLeftOut(highest=found.highest),)
    verdict: Verdict = "adequate"
    if found.widened:
        frequency, ratio = _worst(found)
        verdict, reasons = "widened", (*reasons, BandsOff(frequency=frequency, ratio=ratio))
    elif response or lines or processes or resonances or warm_up or found.highest is not None:
        verdict = "adequate_with"
    fitted = NoiseFit(
        channel=channel,
        quantity=stream.quantity,
        rate_unit=stream.unit,
        n=n,
        tau0=tau0,
        terms=terms,
        gauss_markov=processes,
        resonance=resonances,
        sinusoid=lines,
        response=response,
        warm_up=warm_up,
        regressors={
            name: _around(value, quantile * error, stream.unit)
            for name, (value, error) in zip(regressors, found.regressors, strict=True)
        },
        highest=found.highest,
        alike_from=None if found.alike_from is None else found.alike_from[0],
        alike_sigma=_alike_sigma(found, model),
        discrepancy=found.discrepancy if found.widened else (),
        model=model,
        unclear=tuple(name for name in model if not terms[name].observed),
        verdict=verdict,
        reasons=reasons,
        tau_min=tau0,
        tau_max=n // _LONGEST_SHARE * tau0,
        p_value=found.p_value,
        covariance=(names, covariance),
        level=level,
        method="likelihood",
    )
    return _from_clear_times(fitted)


def _term(
    stream: Stream,
    found: Outcome,
    name: str,
    model: Mapping[str, float],
    errors: Mapping[str, float],
    level: float,
) -> FittedTerm:
    unit = coefficient_unit(name, stream.quantity, stream.unit)
    bounds = found.terms.get(name)
    if bounds is None:  # a filter took its place
        return FittedTerm(term=name, unit=unit, observed=False, level=level)
    p_value = 0.5 * math.erfc(math.sqrt(max(bounds.loss, 0.0) / 2))
    low, high = math.sqrt(max(bounds.low, 0.0)), math.sqrt(bounds.high)
    if bounds.observed and math.isfinite(high):  # a term without an upper bound is not known
        value = model.get(name, math.sqrt(bounds.value))
        error = float(errors.get(name, 0.0))
        return observed_term(
            term=name, unit=unit, level=level, p_value=p_value, value=value, low=low, high=high, error=error
        )
    limit = high if math.isfinite(high) else None
    return FittedTerm(term=name, unit=unit, observed=False, level=level, upper_limit=limit, p_value=p_value)


def _ramp(stream: Stream, found: Outcome, quantile: float, level: float) -> FittedTerm:
    value, error = found.ramp
    unit = coefficient_unit("rate_ramp", stream.quantity, stream.unit)
    p_value = math.erfc(abs(value / error) / math.sqrt(2)) if error > 0 else 1.0
    if found.ramp_observed and abs(value) > quantile * error:  # a profile is wider than the test
        around = _around(value, quantile * error, unit)
        return FittedTerm(
            term="rate_ramp",
            unit=unit,
            observed=True,
            level=level,
            value=around.value,
            low=around.low,
            high=around.high,
            p_value=p_value,
        )
    limit = abs(value) + quantile * error
    return FittedTerm(
        term="rate_ramp",
        unit=unit,
        observed=False,
        level=level,
        upper_limit=limit if math.isfinite(limit) else None,
        p_value=max(p_value, 1 - level),
    )


def _processes(
    stream: Stream, found: Outcome, response: FittedFilter | None
) -> tuple[tuple[GaussMarkov, ...], tuple[Resonance, ...], tuple[Sinusoid, ...]]:
    """Processes, resonances before the filter, and lines behind it: resonances of the least width."""
    processes, resonances, lines = [], [], []
    for process in found.processes:
        if not process.variance.value > 0:
            continue
        sigma = _root(process.variance, stream.unit)
        if process.kind == "gauss_markov":
            processes.append(GaussMarkov(sigma=sigma, time=_plain(process.shape[0], "s")))
            continue
        centre, width = (_plain(bounds, "Hz") for bounds in process.shape)
        centre = _at_bins(centre, width.value, found.bins[:, 0])
        if _steady(process):
            power = 1.0 if response is None else float(response.power(np.array([centre.value]))[0])
            lines.append(Sinusoid(amplitude=_scaled(sigma, math.sqrt(2 * power)), frequency=centre))
        else:
            resonances.append(Resonance(sigma=sigma, frequency=centre, width=width))
    return tuple(processes), tuple(resonances), tuple(lines)


def _steady(process: Process) -> bool:
    """Whether a process is a line: a resonance of the least width that the points of the spectrum can show."""
    return process.kind == "resonance" and process.shape[1].low >= process.shape[1].value * (1 - 1e-9)


def _at_bins(centre: Interval, width: float, bins: Floats) -> Interval:
    """The frequency of a resonance; one that is narrower than the bins may be anywhere between two of them."""
    near = np.searchsorted(bins, centre.value)
    spacing = float(np.diff(bins[max(near - 2, 0) : near + 2]).max(initial=0.0))
    if width >= spacing or centre.low is None or centre.high is None:
        return centre
    low, high = max(centre.value - spacing, 0.0), centre.value + spacing
    return replace(centre, low=min(centre.low, low), high=max(centre.high, high))


def _scaled(one: Interval, factor: float) -> Interval:
    low, high = (None if end is None else factor * end for end in (one.low, one.high))
    return Interval(value=factor * one.value, low=low, high=high, unit=one.unit)


def _root(bounds: Bounds, unit: str) -> Interval:
    value, low, high = (math.sqrt(max(x, 0.0)) for x in (bounds.value, bounds.low, bounds.high))
    return _ordered(value, low, high, unit)


def _plain(bounds: Bounds, unit: str) -> Interval:
    return _ordered(bounds.value, bounds.low, bounds.high, unit)


def _ordered(value: float, low: float, high: float, unit: str) -> Interval:
    """A value inside its interval, which is not known if it has no upper end."""
    if not math.isfinite(high):
        return Interval(value=value, low=None, high=None, unit=unit)
    return Interval(value=value, low=min(low, value), high=max(high, value), unit=unit)


def _around(value: float, half: float, unit: str) -> Interval:
    return Interval(value=value, low=value - half, high=value + half, unit=unit)


def _worst(found: Outcome) -> tuple[float, float]:
    """Frequency and ratio of the density to that of the model, in the band that deviates most."""
    frequency = max(found.bands, key=lambda band: abs(band[1]))[0] if found.bands else float(found.bins[0, 0])
    near = np.abs(np.log(found.bins[:, 0] / frequency)) < math.log(10) / 8
    near[int(np.argmin(np.abs(found.bins[:, 0] - frequency)))] = True
    weights = found.bins[near, 3]
    if not 0 < weights.sum() < math.inf:  # of a band in which no bin counts, or of a spectrum that no model is near
        weights = np.ones(len(weights))
    return frequency, float(np.average(found.bins[near, 1] / found.bins[near, 2], weights=weights))


def _alike_sigma(found: Outcome, model: Mapping[str, float]) -> float | None:
    """Standard deviation of the process in place of the rate random walk; that of the same density above 1/T if the record
    could do without both.
    """
    if found.alike_from is None or "rate_random_walk" not in model:
        return None
    time, variance = found.alike_from
    return math.sqrt(variance) if variance > 0 else model["rate_random_walk"] * math.sqrt(time / 2)


def _covariance(found: Outcome, model: Mapping[str, float]) -> tuple[tuple[str, ...], Floats]:
    """Names and covariance of the coefficients √θ and of the numbers of processes, from that of θ and the shapes."""
    at: list[int] = []
    names: list[str] = []
    slopes: list[float] = []  # of the number, by that of the covariance
    shape = len(found.parameters) + len(found.filter)
    processes = iter(found.processes)
    counts = dict.fromkeys(("gauss_markov", "resonance"), 0)
    for k, part in enumerate(found.parameters):
        if part in model:
            at, names, slopes = [*at, k], [*names, part], [*slopes, 0.5 / model[part]]
        if part not in counts:
            continue
        process = next(processes)
        own = [one.value for one in process.shape]
        sigma = math.sqrt(process.variance.value)
        numbers = ("sigma", "time") if part == "gauss_markov" else ("sigma", "frequency", "width")
        rows = [k, *range(shape, shape + len(own))]
        shape += len(own)
        if _steady(process) or not sigma > 0:  # among the lines, or not there
            continue
        counts[part] += 1
        at += rows
        names += [f"{part}_{counts[part]}.{number}" for number in numbers]
        slopes += [0.5 / sigma, *((own[-1],) * len(own))]
    scale = np.array(slopes)
    return tuple(names), found.covariance[np.ix_(at, at)] * np.outer(scale, scale)


def _from_clear_times(fitted: NoiseFit) -> NoiseFit:
    """The fit with the averaging time from which the model made from it describes the curve, with a low-pass filter in the
    place of that of the fit if it helps.
    """
    sizes = cluster_sizes("half", n=fitted.n, tau0=fitted.tau0)
    noise = replace(fitted, response=None, sinusoid=(), warm_up=None)
    filtered = noise.avar(m=sizes)
    walk = fitted.model.get("random_walk", math.inf)
    shapes = {one: (one.sigma.value, one.frequency.value, one.width.value) for one in noise.resonance}
    kept = tuple(one for one, of in shapes.items() if not folds(*of, fitted.tau0, random_walk=walk))
    bare = replace(noise, resonance=kept).avar(m=sizes)  # what a model carries
    if fitted.response is not None:
        filtered -= fitted.response.taken_off(fitted.filtered_psd, sizes, highest=fitted.highest)
    # White noise of a band that was left out has this share of the variance; what is there instead is not known.
    left_out = None if fitted.response is not None and fitted.response.known_to is not None else fitted.highest
    unknown = 0.0 if left_out is None else 4 * _MEAN_OF_SINE_4 / (np.pi**2 * left_out * sizes * fitted.tau0)
    enough = np.minimum(_SAME, _SAME_ERRORS * np.sqrt(2 * sizes / fitted.n)) * bare

    def beginning(avar: Floats) -> float:
        beyond = np.flatnonzero(np.abs(avar - filtered) + unknown * bare > enough)
        return float(sizes[min(beyond[-1] + 1, len(sizes) - 1)] * fitted.tau0) if len(beyond) else fitted.tau0

    first = beginning(bare)
    low_pass = None if fitted.response is None else fitted.response.like()
    if fitted.response is not None and low_pass is not None and fitted.model.get("random_walk"):
        one = ChannelModel(terms={"random_walk": fitted.model["random_walk"]}, bandwidth=low_pass)
        unfiltered = replace(one, bandwidth=None).avar(m=sizes, tau0=fitted.tau0)
        with_it = beginning(bare - unfiltered + one.avar(m=sizes, tau0=fitted.tau0))
        if with_it < first:
            first = with_it
            fitted = replace(fitted, response=replace(fitted.response, low_pass=low_pass))
    return replace(fitted, tau_min=min(first, fitted.tau_max or first))
