"""`tune`: judge a filter by its innovations, without ground truth."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sigmatau._native.distributions import chi2_above, chi2_quantile_above, student_below
from sigmatau.arrays import SIGMA_OF_MAD, Bools, Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import allan
from sigmatau.exporting.tuning.filters import SLOW, WHITE, BiasFilter, Filter, FilterMatrices
from sigmatau.exporting.tuning.innovations import Innovations
from sigmatau.exporting.tuning.judgement import CHANCE, Judgement, Runs, RunSpectra, judge
from sigmatau.exporting.tuning.likelihood import coarse
from sigmatau.exporting.tuning.motion import MotionEffect
from sigmatau.exporting.tuning.result import NoiseVerdict, Tuning, Tunings, Verdict, Whiteness
from sigmatau.exporting.tuning.run import FilterRun
from sigmatau.exporting.tuning.statements import ROOT_OF_VARIANCE
from sigmatau.hints import Hint
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom

_CLUSTERS = 8  # smallest number of independent averages; with fewer, the interval is wider than a factor of 3
_LOWEST = 5  # number of frequencies whose mean power is the density at 0 if no filter explains the innovations
_OFFSET = 0.001  # probability that an offset is reported for innovations without one
_TAILS = (0.05, 0.95)  # quantiles of S
_VARIATION = 1.5  # ratio of these quantiles above which S is tested for alternation and a fall
_BEGINNING = 10  # a filter may converge during this fraction of the run: 1/10
_OUTLYING = 7.0  # smallest outlier [standard deviations]; 1e6 Gaussian innovations reach it with probability 3e-6


def tune(
    innovations: Innovations | Mapping[str, Innovations],
    *,
    filters: Filter | Mapping[str, Filter] | None = None,
    skip: float = 0.0,
    level: float = 0.95,
) -> Tunings:
    """Judge a filter by its innovations: find the assumed noise that is wrong, and its factor.

    Parameters
    ----------
    innovations : Innovations or mapping of str to Innovations
        Innovations of one channel, or by channel, of a converged filter.
    filters : BiasFilter, FilterMatrices, or mapping of str to these, optional
        Filter for all channels, or by channel. Default: unknown; then only the NIS and the whiteness are judged.
    skip : float
        Length of the beginning that is left out because the filter converges. [s]
    level : float
        Confidence level of the intervals.

    Returns
    -------
    Tunings
        A mapping from channel to `Tuning`; a single channel without a name is ``"innovation"``.

    Raises
    ------
    OptionError
        For data other than `Innovations`, a filter of a channel that does not exist, a filter whose S differs from the
        stated S, a negative `skip`, or a level outside 0 … 1.
    DataError
        For an S that falls because the filter converges, an S that alternates as for rows of two sensors, or a standard
        deviation in place of S.
    RecordTooShortError
        If fewer than 100 innovations remain.

    See Also
    --------
    Innovations : the data.
    BiasFilter : an integrated rate and its bias.
    FilterMatrices : any filter, given by matrices that are constant or vary by step.

    Notes
    -----
    For a correct filter, innovations over their stated standard deviations are white with variance 1. Otherwise their
    density is the sum of the shares of each noise, times its factor. The factors maximise Whittle's likelihood, with
    intervals from its profile. A noise is the cause if it explains the innovations alone, and no other noise does.

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
    runs = Runs()
    for name, whole in channels.items():
        filter_ = by_channel.get(name)
        try:
            data = whole.after(skip) if skip else whole
            if filter_ is None:
                tunings[name] = _tune(name, data, None, {}, level)
                continue
            _require_converged(data)
            spectra = runs.reconstruct(filter_, data, len(whole.time) - len(data.time))
            tunings[name] = _tune(name, data, spectra, _assumed(filter_, spectra.run, data), level)
        except OptionError as error:
            if whole.has_root_of_variance:
                raise DataError(f"`variance` {ROOT_OF_VARIANCE}").about(name) from None
            raise error.about(name) from None
        except DataError as error:
            raise error.about(name) from None
    return Tunings(tunings)


def _tune(
    channel: str, data: Innovations, spectra: RunSpectra | None, assumed: Mapping[str, float], level: float
) -> Tuning:
    series = np.nan_to_num(data.normalised.reshape(len(data.time), -1))
    motion: tuple[MotionEffect, ...] = ()
    if spectra is None:
        wide = coarse(series, data.is_present.sum(axis=0))
        white = np.broadcast_to(np.diag(data.is_present.mean(axis=0)), wide.power.shape)
        p_value = wide.misfit(wide.restrict(white), 0)
        as_stated: NoiseVerdict = "inconsistent" if p_value < CHANCE else "consistent"
        judged = Judgement(explained=np.zeros_like(series), p_value=p_value, verdict=as_stated)
    else:
        motion, judged = judge(data, series, spectra, assumed, level)
    residual = series - judged.explained
    means, p_mean = _means(residual, data.is_present, judged)
    has_offset = p_mean < _OFFSET
    verdict: Verdict = judged.verdict
    causes = judged.causes
    sizes = np.abs(np.where(data.is_present, residual, np.nan))
    outlying = np.flatnonzero((sizes > _OUTLYING * SIGMA_OF_MAD * np.nanmedian(sizes, axis=0)).any(axis=1))
    if outlying.size and verdict != "consistent":
        verdict, causes = "outliers", ()
    elif any(effect.has_error for effect in motion):
        verdict = "motion"
    elif has_offset:
        verdict = "offset"
    nis, nis_low, nis_high = _nis(series, data.is_present, level)
    return Tuning(
        channel=channel,
        n=int(data.is_present.sum()),
        duration=float(data.time[-1] - data.time[0]) + data.interval,
        interval=data.interval,
        measurements=data.measurements,
        means=tuple(means),
        has_offset=has_offset,
        nis=nis,
        nis_low=nis_low,
        nis_high=nis_high,
        whiteness=_whiteness(series, data, level),
        factors=judged.factors,
        causes=causes,
        motion=motion,
        has_rate=data.rate is not None,
        has_root_of_variance=data.has_root_of_variance,
        verdict=verdict,
        noise_verdict=judged.verdict,
        p_value=judged.p_value,
        p_misfit=judged.p_misfit,
        level=level,
        outliers=len(outlying),
        first_outlier=float(data.time[outlying[0]]) if outlying.size else None,
    )


def _means(series: Floats, present: Bools, judged: Judgement) -> tuple[Floats, float]:
    """Means of the measurements, and their smallest p-value times their number.

    n·mean² over the density at frequency 0 is χ², or Student's t² with the density of the lowest frequencies.
    """
    n, count = series.shape
    means = series.mean(axis=0)
    if judged.lowest_density is not None:
        chances = chi2_above(1, means**2 * n / np.diag(judged.lowest_density).real)
    else:
        lowest = np.abs(np.fft.rfft(series, axis=0)[1 : _LOWEST + 1]) ** 2 / n
        chances = 2 * student_below(2 * _LOWEST, -np.abs(means) * np.sqrt(n / lowest.mean(axis=0)))
    return means / present.mean(axis=0), count * float(np.min(chances))


def _require_converged(data: Innovations) -> None:
    """Raise an error for a filter that still converges, or for rows of two sensors in one channel."""
    for stated, present in zip(np.diagonal(data.covariance, axis1=1, axis2=2).T, data.is_present.T, strict=True):
        values = stated[present]
        low, high = (float(value) for value in np.quantile(values, _TAILS))
        if high > _VARIATION * low and _alternates(values):
            raise DataError(
                f"S alternates between {low:.3g} and {high:.3g}, as for rows of two sensors."
                " Write each sensor in separate columns, or its name in a column sensor"
            )
        n = len(values)
        if float(np.median(values[: n // _BEGINNING])) > _VARIATION * float(np.quantile(values[n // 2 :], _TAILS[1])):
            raise DataError(
                f"S falls from {high:.3g} to {low:.3g}: the filter still converges."
                f" Leave out the time of convergence, {Hint('skip', value=60)}"
            )


def _alternates(values: Floats) -> bool:
    """Whether the values of even and odd rows are constant and differ from each other."""
    (low, high), (low_2, high_2) = (np.quantile(values[k::2], _TAILS) for k in (0, 1))
    constant = high <= _VARIATION * low and high_2 <= _VARIATION * low_2
    return bool(constant and not 1 / _VARIATION < float(np.median(values[::2]) / np.median(values[1::2])) < _VARIATION)


def _assumed(filter_: Filter, run: FilterRun, data: Innovations) -> dict[str, float]:
    """Noise that the filter assumes, by name, if it is a single number."""
    if isinstance(filter_, FilterMatrices) and len(run.closed) == 1:
        variances = run.measured[0]
    elif len(run.closed) == 1:
        variances = run.measured[0] * data.stated
    else:
        variances = np.nanmedian(np.where(data.is_present, run.measured, np.nan), axis=0)
    count = data.columns.shape[1]
    assumed = dict(zip(run.noises[:count], np.sqrt(variances).tolist(), strict=True))
    return assumed if isinstance(filter_, FilterMatrices) else assumed | {WHITE: filter_.noise, SLOW: filter_.walk}


def _nis(series: Floats, present: Bools, level: float) -> tuple[float, float, float]:
    """Mean square with its interval, from a χ² whose degrees of freedom are the number of independent squares.

    The variance of the mean square of a Gaussian series with the density P is 2∫P²/n, and the product of neighbours in
    the periodogram has the mean P².
    """
    n, total = len(series), int(present.sum())
    nis = float(np.sum(series**2)) / total
    power = np.abs(np.fft.rfft(series, axis=0)[1 : (n - 1) // 2 + 1]) ** 2
    independent = float(np.mean(power)) ** 2 / float(np.mean(power[1:] * power[:-1]))
    freedom = total * min(independent, 1.0)
    low, high = (
        nis * freedom / float(chi2_quantile_above(freedom, chance)) for chance in ((1 - level) / 2, (1 + level) / 2)
    )
    return nis, low, high


def _whiteness(series: Floats, data: Innovations, level: float) -> Whiteness:
    """Mean of the Allan variances of the innovations of all measurements."""
    each = [values[present] for values, present in zip(series.T, data.is_present.T, strict=True)]
    shortest = min(map(len, each))
    interval = data.interval * len(series) / (sum(map(len, each)) / len(each))
    variances, freedom = [], np.zeros(0)
    for values in each:
        curve = allan(
            values[:shortest], rate=1 / interval, taus=interval * 2.0 ** np.arange(math.log2(shortest / _CLUSTERS))
        )
        variances.append(curve.adev**2 * curve.m)
        m, freedom = curve.m, degrees_of_freedom({"random_walk": 1.0}, n=shortest, m=curve.m, tau0=interval)
    low, high = chi2_factors(len(each) * freedom, level=level)
    ratio = np.sqrt(np.mean(variances, axis=0))
    averaged = m.astype(np.float64)
    return Whiteness(m=averaged, tau=np.asarray(averaged * interval), ratio=ratio, low=ratio * low, high=ratio * high)
