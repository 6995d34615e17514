"""`tune`: judge a filter by its innovations, without ground truth."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sigmatau._native.distributions import chi2_above, chi2_quantile_above, student_below
from sigmatau.arrays import SIGMA_OF_MAD, Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import allan
from sigmatau.exporting.tuning.filters import MEASUREMENT, SLOW, WHITE, BiasFilter, Filter, FilterMatrices
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.exporting.tuning.likelihood import FactorInterval, Periodogram, Shares, coarse
from sigmatau.exporting.tuning.result import NoiseFactor, Tuning, Tunings, Verdict, Whiteness
from sigmatau.hints import Hint
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom

_CHANCE = 0.04
"""Probability that a right filter is called wrong, at most."""

_REJECTION = 0.01  # probability that the true single cause is rejected

_CLUSTERS = 8  # fewest independent averages; the interval of fewer is wider than a factor of 3
_LOWEST = 5  # frequencies whose mean power is the density of a mean that no filter explains
_OFFSET = 0.001  # probability that the mean of innovations without an offset is called one
_MISFIT = 0.003  # probability that a filter whose factors alone are wrong is called not explained
_TAILS = (0.05, 0.95)  # quantiles of S and of the intervals of time, without rare gaps
_VARIATION = 1.5  # ratio of these quantiles, above which the gain of the filter is not constant
_OUTLYING = 7.0  # deviations of the others; 1e6 Gaussian innovations have such a one with the probability 3e-6
_IMMATERIAL = 1.05  # factor of a standard deviation that changes no filter, however sure it is
_EVIDENCE = 6.0  # rise of the deviance, a likelihood ratio of 20, by which the second best single cause is worse


def tune(
    innovations: Innovations | Mapping[str, Innovations],
    *,
    filters: Filter | Mapping[str, Filter] | None = None,
    skip: float = 0.0,
    level: float = 0.95,
) -> Tunings:
    """Judge a filter by its innovations: which noise that it assumes is wrong, and by which factor.

    Parameters
    ----------
    innovations : Innovations or mapping of str to Innovations
        Of one channel, or by channel. The filter has converged.
    filters : BiasFilter, FilterMatrices, or mapping of str to these, optional
        The filter, for all channels or by channel. Default: unknown; then only the NIS and the whiteness are judged.
    skip : float
        Time at the beginning that is left out, in which the filter converges. [s]
    level : float
        Confidence level of the intervals.

    Returns
    -------
    Tunings
        A mapping from channel to `Tuning`; a single channel without a name is ``"innovation"``.

    Raises
    ------
    OptionError
        For anything but `Innovations`, a filter of a channel that does not exist, a filter whose S is not the stated one,
        a `skip` that is negative, or a level outside 0 … 1.
    DataError
        For a filter whose S or interval is not constant.
    RecordTooShortError
        If fewer than 100 innovations are left.

    See Also
    --------
    Innovations : the data.
    BiasFilter : an integrated rate and its bias.
    FilterMatrices : any filter with constant matrices.

    Notes
    -----
    In a filter that is right, innovations over their stated standard deviations are white with variance 1. Their density is
    otherwise the sum of the shares of each noise, times its factor. The factors maximise Whittle's likelihood, with
    intervals by its profile. A single noise is the cause if it alone explains the innovations, and no other does.

    References
    ----------
    R. K. Mehra, "On the identification of variances and adaptive Kalman filtering," IEEE Trans. Automatic Control, vol. 15,
    no. 2, 1970.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> nu = 1.4e-4 * np.random.default_rng(1).standard_normal(3000)
    >>> data = st.Innovations(time=np.arange(3000) / 5, innovation=nu, variance=np.full(3000, 1.4e-4**2))
    >>> judged = st.tune({"gyro_x": data}, filters=st.BiasFilter(noise=1e-4, walk=1e-5))
    >>> judged["gyro_x"].verdict
    'consistent'
    """
    if not 0 < level < 1:
        raise OptionError(f"{{option}} must lie between 0 and 1, not {level!r}", option="level")
    if not (isinstance(skip, int | float) and 0 <= skip < math.inf):
        raise OptionError(f"{{option}} must be a time that is not negative, in s, not {skip!r}", option="skip")
    channels = {"innovation": innovations} if isinstance(innovations, Innovations) else innovations
    if not isinstance(channels, Mapping) or not all(isinstance(data, Innovations) for data in channels.values()):
        raise OptionError(
            "{option} must be Innovations(time=…, innovation=…, variance=…), or a mapping of them by channel",
            option="innovations",
        )
    by_channel = filters if isinstance(filters, Mapping) else dict.fromkeys(channels, filters)
    for name, filter_ in by_channel.items():
        if name not in channels:
            raise OptionError(f"{{option}} of {name}: the innovations are of {', '.join(channels)}", option="filters")
        if filter_ is not None and not isinstance(filter_, BiasFilter | FilterMatrices):
            raise OptionError(
                f"{{option}} must be a BiasFilter or FilterMatrices, not {type(filter_).__name__}", option="filters"
            )
    tunings = {}
    for name, data in channels.items():
        try:
            tunings[name] = _tune(name, data.after(skip) if skip else data, by_channel.get(name), level)
        except (DataError, OptionError) as error:
            raise error.about(name) from None
    return Tunings(tunings)


def _tune(channel: str, data: Innovations, filter_: Filter | None, level: float) -> Tuning:
    series = data.normalised
    whole, wide = Periodogram.of(series), coarse(series)
    nis, nis_low, nis_high = _nis(series, level)
    factors: tuple[NoiseFactor, ...] = ()
    causes: tuple[NoiseFactor, ...] = ()
    p_misfit: float | None = None
    slowest: float | None  # density at the lowest frequency, if it is explained
    verdict: Verdict
    if filter_ is None:
        p_value = wide.misfit(np.ones(len(wide.power)), 0)
        slowest = None
        verdict = "inconsistent" if p_value < _CHANCE else "consistent"
    else:
        _require_stationary(data)
        matrices = filter_.matrices(interval=data.interval, stated=data.stated)
        names = (MEASUREMENT, *matrices.Q)
        shares = Shares(whole, list(matrices.shares(whole.frequency).values()))
        best = shares.fit(range(len(names)))
        density = np.exp(best.logs) @ np.array(list(matrices.shares(wide.frequency).values()))
        p_misfit = wide.misfit(density, len(names))
        slowest = float(shares.density(best.logs)[0]) if p_misfit >= _MISFIT else None
        alone = np.array([shares.fit((k,)).deviance for k in range(len(names))])
        p_value = _significance(shares.fit(()).deviance, alone, best.deviance)
        assumed = _assumed(filter_, matrices, data.stated)
        intervals = [shares.interval(best, k, level) for k in range(len(names))]
        factors = tuple(
            NoiseFactor(noise=name, value=part.value, low=part.low, high=part.high, assumed=assumed.get(name))
            for name, part in zip(names, intervals, strict=True)
        )
        verdict = "consistent" if p_value >= _CHANCE else "wrong"
        if p_misfit < _MISFIT:
            verdict = "not explained"
        elif verdict == "wrong" and all(_is_immaterial(part) for part in intervals):
            verdict = "consistent"
        elif verdict == "wrong":
            chosen = _single_causes(alone, best.deviance)
            causes = tuple(factors[k] for k in chosen) or tuple(factor for factor in factors if factor.has_error)
            if len(chosen) > 1 or not causes:
                verdict, causes = "ambiguous", causes or factors
    if _chance_of_mean(series, whole, slowest) < _OFFSET:
        verdict, causes = "offset", ()
    outlying = np.flatnonzero(np.abs(series) > _OUTLYING * SIGMA_OF_MAD * float(np.median(np.abs(series))))
    if outlying.size and verdict != "consistent":
        verdict, causes = "outliers", ()
    return Tuning(
        channel=channel,
        n=len(series),
        interval=data.interval,
        mean=float(series.mean()),
        nis=nis,
        nis_low=nis_low,
        nis_high=nis_high,
        whiteness=_whiteness(series, data.interval, level),
        factors=factors,
        causes=causes,
        verdict=verdict,
        p_value=p_value,
        p_misfit=p_misfit,
        level=level,
        outliers=len(outlying),
        first_outlier=float(data.time[outlying[0]]) if outlying.size else None,
    )


def _chance_of_mean(series: Floats, periodogram: Periodogram, density: float | None) -> float:
    """p-value of the mean: n·mean² is χ² about the density at frequency 0, or Student's t² about that of the lowest ones."""
    if density is not None:
        return float(chi2_above(1, series.mean() ** 2 * len(series) / density))
    measured = float(np.mean(periodogram.power[:_LOWEST]))
    return 2 * float(student_below(2 * _LOWEST, -abs(series.mean()) * math.sqrt(len(series) / measured)))


def _require_stationary(data: Innovations) -> None:
    """Refuse innovations of a filter that is not stationary, whose density is not a sum of constant shares."""
    for values, what in ((data.variance, "S"), (np.diff(data.time), "the time between two innovations")):
        low, high = (float(value) for value in np.quantile(values, _TAILS))
        if high <= _VARIATION * low:
            continue
        if _takes_turns(values):
            raise DataError(
                f"{what} takes turns between {low:.3g} and {high:.3g}, as if rows of two sensors alternate."
                " Write each sensor in columns of its own, or its name in a column sensor"
            )
        if what == "S":
            raise DataError(
                f"S varies from {low:.3g} to {high:.3g}, so that the filter is not stationary."
                f" Leave out its convergence, {Hint('skip', value=60)}, or use a stretch in which it is constant"
            )
        raise DataError(
            f"{what} varies from {low:.3g} to {high:.3g} s, so that the filter is not stationary."
            " Use a stretch in which measurements come at a constant interval"
        )


def _takes_turns(values: Floats) -> bool:
    """Whether the values of even and odd rows are constant and differ."""
    (low, high), (low_2, high_2) = (np.quantile(values[k::2], _TAILS) for k in (0, 1))
    constant = high <= _VARIATION * low and high_2 <= _VARIATION * low_2
    return bool(constant and not 1 / _VARIATION < float(np.median(values[::2]) / np.median(values[1::2])) < _VARIATION)


def _is_immaterial(part: FactorInterval) -> bool:
    """Whether a factor is so near to 1 that no filter is changed by it; or is not shown."""
    shown = part.high is not None and part.low > 0 and (part.low > 1 or part.high < 1)
    return not shown or (part.low > 1 / _IMMATERIAL and (part.high or math.inf) < _IMMATERIAL)


def _significance(unchanged: float, alone: Floats, best: float) -> float:
    """p-value of a filter by the largest rise of the likelihood, by one factor or by all of them (Bonferroni)."""
    count = len(alone)
    single = count * float(chi2_above(1, max(unchanged - float(alone.min()), 0.0)))
    joint = float(chi2_above(count, max(unchanged - best, 0.0)))
    return min(2 * min(single, joint), 1.0)


def _single_causes(alone: Floats, best: float) -> list[int]:
    """The noises of which each alone explains the innovations; the best of them if the others are much worse."""
    rise = float(chi2_quantile_above(len(alone) - 1, _REJECTION)) if len(alone) > 1 else math.inf
    accepted = [k for k, deviance in enumerate(alone) if deviance - best < rise]
    if len(accepted) > 1:
        first, second = sorted(alone[accepted])[:2]
        if second - first > _EVIDENCE:
            accepted = [int(np.argmin(alone))]
    return accepted


def _assumed(filter_: Filter, matrices: FilterMatrices, stated: float) -> dict[str, float]:
    """What the filter assumes, by noise, where it is one number."""
    if isinstance(filter_, FilterMatrices):
        return {MEASUREMENT: math.sqrt(matrices.R)}
    return {MEASUREMENT: math.sqrt(matrices.R * stated), WHITE: filter_.noise, SLOW: filter_.walk}


def _nis(series: Floats, level: float) -> tuple[float, float, float]:
    """Mean square with its interval by a χ² of as many degrees as there are independent squares.

    The variance of the mean square of a Gaussian series is 2∫P²/n of its density P, and the product of neighbours in the
    periodogram has the mean P².
    """
    n = len(series)
    nis = float(np.mean(series**2))
    power = np.abs(np.fft.rfft(series)[1 : (n - 1) // 2 + 1]) ** 2
    freedom = n * min(float(np.mean(power)) ** 2 / float(np.mean(power[1:] * power[:-1])), 1.0)
    low, high = (
        nis * freedom / float(chi2_quantile_above(freedom, chance)) for chance in ((1 - level) / 2, (1 + level) / 2)
    )
    return nis, low, high


def _whiteness(series: Floats, interval: float, level: float) -> Whiteness:
    curve = allan(series, rate=1 / interval, taus=interval * 2.0 ** np.arange(math.log2(len(series) / _CLUSTERS)))
    freedom = degrees_of_freedom({"random_walk": 1.0}, n=len(series), m=curve.m, tau0=interval)
    low, high = chi2_factors(freedom, level=level)
    ratio = curve.adev * np.sqrt(curve.m)
    m = curve.m.astype(np.float64)
    return Whiteness(m=m, tau=np.asarray(m * interval), ratio=ratio, low=ratio * low, high=ratio * high)
