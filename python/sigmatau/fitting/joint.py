"""One likelihood of several runs of a sensor, or of the axes of a triad; see `fit_jointly`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal, get_args

from sigmatau._native import likelihood as native
from sigmatau._native.likelihood import Estimate, LikelihoodSummary, LineEstimate
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.joint import UNFIT_WORDS, Unfit
from sigmatau.findings.reasons import CrowdedLines, VibrationPower
from sigmatau.fitting import likelihood
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.adjustment import Adjustment
from sigmatau.fitting.arguments import check_level, wanted_terms
from sigmatau.fitting.beside_vibration import as_wide
from sigmatau.fitting.channel import TEMPERATURE, fit_channel, sample_temperatures
from sigmatau.fitting.disturbance import is_disturbed, limits_alone, vibration_share
from sigmatau.fitting.fitted_values import Interval
from sigmatau.fitting.from_native import interval_with_unit
from sigmatau.fitting.joint_fit import JointChannel, JointFit, RunOfJoint, Spread
from sigmatau.fitting.misfit import misfit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.pass_over import never_changes, summarized, usable
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter
from sigmatau.noise.terms import NOISE
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

Over = Literal["runs", "axes"]

COMMON = ("bias_instability", "rate_random_walk")
"""Terms that are common to all runs by default. Quantization noise and random walk differ from day to day by a few per
cent, many times their error within a day.
"""

MAX_RUNS = 100
"""Largest number of runs of one fit. The work grows with the square of this number."""

_SAME_RATE = 0.01  # largest relative difference of sample intervals at which one filter describes all runs


@frozen(eq=False)
class JointRun:
    """Contribution of one record to a joint fit of a channel."""

    name: str
    channel: str
    stream: Stream
    summary: LikelihoodSummary
    curves: tuple[Floats, ...]  # regressors of the mean, such as the temperature, at the blocks of the summary
    fit: NoiseFit  # fit of this run alone


def fit_jointly(
    records: Iterable[Record],
    channels: Iterable[str] | None = None,
    *,
    over: Over = "runs",
    common: Iterable[str] = COMMON,
    names: Iterable[str] | None = None,
    terms: Iterable[str] | None = None,
    processes: Sequence[float] | None = None,
    level: float = 0.95,
) -> JointFit:
    """Fit one model to several runs of a sensor; several runs may show a term that no single run shows.

    The likelihoods of the runs are multiplied. Filter, processes and the terms in `common` are the same in all runs; the
    other terms differ from run to run, and their value is the mean over runs. Runs may have different lengths and missing
    samples. Lines, ramp, warm-up and temperature coefficient are fitted for each run.

    Parameters
    ----------
    records : iterable of Record
        Two or more, with the same channels and rate; each at rest and without disturbances: nothing is left out here.
    channels : iterable of str, optional
        Default: all channels that every record has, except the temperature.
    over : {"runs", "axes"}
        Pool a channel over the records, or all axes of a sensor (over the records too, if there are several). A joint
        fit of axes has the name of the sensor, ``"gyro"``.
    common : iterable of str
        Terms that are the same in all runs. The others are random: the logarithm of the coefficient is normally
        distributed over runs. A common term whose homogeneity has p < 0.01 is treated as random too.
    names : iterable of str, optional
        Names of the records. Default: their files, or ``"run 1"`` …
    terms, processes, level
        See `sigmatau.fit_channel`.

    Returns
    -------
    JointFit

    Raises
    ------
    OptionError
        For fewer than two runs or more than 100, records without a common channel, an unknown term, or not as many names
        as records.
    DataError
        For runs with different rates or units, a channel that never changes or is too short, or the same samples twice.

    See Also
    --------
    fit_channel : one run.

    Notes
    -----
    A random term that most runs do not show is treated as common, because such runs contain no information on its spread.
    The value of a random term has the interval of a mean over runs, Student's t with one degree of freedom fewer than
    runs; its spread is estimated by the method of Paule and Mandel [1]_.

    References
    ----------
    .. [1] R. C. Paule and J. Mandel, "Consensus values and weighting factors," J. Res. Natl. Bur. Stand., vol. 87, no. 5,
       1982, :doi:`10.6028/jres.087.022`.

    Examples
    --------
    >>> from sigmatau import NoiseModel, fit_jointly, simulate
    >>> model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 4e-7}})
    >>> days = [simulate(model, duration=1000, rate=10, rng=day) for day in range(7)]
    >>> joint = fit_jointly(days)
    >>> joint["gyro_x"].fit["random_walk"].observed, len(joint["gyro_x"].runs)
    (True, 7)
    """
    if over not in get_args(Over):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(Over))}, not {over!r}", option="over")
    check_level(level)
    listed = list(records)
    shared = common_terms(common)
    labels = run_names(listed, names)
    asked = _channels(listed, channels)
    pools: dict[str, list[tuple[Record, str, str]]] = {}
    for record, label in zip(listed, labels, strict=True):
        for channel in asked:
            sensor = record.stream_of(channel).name
            pool, name = (channel, label) if over == "runs" else (sensor, _axis_name(label, channel, len(listed)))
            pools.setdefault(pool, []).append((record, channel, name))
    return JointFit(
        {
            pool: join(
                [
                    build_run(record, channel, name=name, terms=terms, processes=processes, level=level)
                    for record, channel, name in members
                ],
                pool,
                common=shared,
                terms=terms,
                processes=processes,
                level=level,
            )
            for pool, members in pools.items()
        }
    )


def _axis_name(label: str, channel: str, records: int) -> str:
    return channel if records == 1 else f"{label} {channel}"


def common_terms(common: Iterable[str]) -> tuple[str, ...]:
    """Check the terms that are common to all runs, and return them."""
    listed = [common] if isinstance(common, str) else list(common)
    if unknown := [name for name in listed if name not in NOISE]:
        raise OptionError(
            f"{{option}}: {unknown[0]!r} cannot be common to runs; known terms: {', '.join(NOISE)}", option="common"
        )
    return tuple(dict.fromkeys(listed))


def run_names(records: Sequence[Record], names: Iterable[str] | None) -> list[str]:
    """A different name for each record."""
    if names is None:
        paths = [record.provenance.path for record in records]
        if None in paths or len(set(paths)) < len(paths):
            return [f"run {k}" for k in range(1, len(records) + 1)]
        return [str(path) for path in paths]
    texts = [str(name) for name in names]
    if len(texts) != len(records) or len(set(texts)) < len(texts):
        raise OptionError(
            f"{{option}} must be {len(records)} different names, one for each record, not {texts!r:.80}", option="names"
        )
    return texts


def _channels(records: Sequence[Record], channels: Iterable[str] | None) -> list[str]:
    if not records or not all(isinstance(record, Record) for record in records):
        raise OptionError("{option} must be records, see sigmatau.read", option="records")
    if channels is not None:
        asked = [channels] if isinstance(channels, str) else list(channels)
        for record in records:
            if missing := [channel for channel in asked if channel not in record.channels]:
                raise OptionError(
                    f"{{option}}: a record has no channel {missing[0]!r}; it has {', '.join(record.channels)}",
                    option="channels",
                )
    else:
        every = [
            channel for stream in records[0].streams if stream.quantity != "temperature" for channel in stream.channels
        ]
        asked = [channel for channel in every if all(channel in record.channels for record in records)]
    if not asked:
        raise OptionError("{option}: the records have no channel in common", option="channels")
    return asked


def build_run(
    record: Record,
    channel: str,
    *,
    name: str,
    fit: NoiseFit | None = None,
    terms: Iterable[str] | None = None,
    processes: Sequence[float] | None = None,
    level: float = 0.95,
) -> JointRun:
    """Collect what a record contributes to a joint fit. `fit` is that of the channel alone, if it exists.

    Raises
    ------
    DataError
        For a channel that never changes, or is too short for the likelihood.
    """
    stream = record.stream_of(channel)
    unfit = why_unfit(stream, channel)
    if unfit is not None:
        raise DataError(
            f"channel {channel!r} of {stream.grid.n} samples cannot be fitted jointly: {UNFIT_WORDS[unfit]}"
        ).about(name)
    if fit is None or fit.method != "likelihood":
        wanted = None if terms is None else list(terms)
        fit = fit_channel(record, channel, terms=wanted, processes=processes, level=level)
    summary, start = summarized(stream, channel)
    curves: list[Floats] = []
    if TEMPERATURE in fit.regressors:
        degrees = sample_temperatures(record, stream)
        if degrees is not None:
            curves.append(likelihood.at_blocks(summary.centres + start, degrees, stream.grid.tau0))
    return JointRun(name=name, channel=channel, stream=stream, summary=summary, curves=tuple(curves), fit=fit)


def why_unfit(stream: Stream, channel: str) -> Unfit | None:
    """Why a channel cannot be fitted jointly; None if it can be."""
    if not usable(stream, channel):
        return "too_few_samples"
    return "constant" if never_changes(stream, channel) else None


def join(
    runs: Sequence[JointRun],
    channel: str,
    *,
    common: Sequence[str] = COMMON,
    terms: Iterable[str] | None = None,
    processes: Sequence[float] | None = None,
    level: float = 0.95,
) -> JointChannel:
    """Fit the runs of one channel jointly."""
    _refuse(runs, channel)
    wanted = wanted_terms(terms)
    joint = native.fit_jointly(
        [(run.summary, run.curves, run.stream.grid.n, _lines(run.fit)) for run in runs],
        terms=[name for name in NOISE if name in wanted],
        common=list(common),
        processes=processes is None,
        drifts="rate_ramp" in wanted,
        times=[float(time) for time in processes or ()],
        level=level,
    )
    longest = max(runs, key=lambda run: run.summary.duration)
    fitted = likelihood.as_noise_fit(longest.stream, channel, joint.fit, level=level)
    fitted = replace(fitted, runs=tuple(run.stream.grid.duration for run in runs))
    fitted = adjusted(fitted, partial(_hidden_by_vibration, runs=runs, longest=longest))
    if fitted.verdict != "disturbed":
        crowded = [
            partial(as_wide, alone=run.fit["random_walk"], reason=reason)
            for run in runs
            for reason in run.fit.reasons
            if isinstance(reason, CrowdedLines)
        ]
        fitted = adjusted(fitted, *crowded, misfit)
    spreads = () if fitted.verdict == "disturbed" else joint.spreads
    return JointChannel(
        fit=fitted,
        common=tuple(joint.common),
        spreads={name: Spread(relative=relative, p_value=p_value) for name, (relative, p_value) in spreads},
        homogeneity={name: p_value for name, p_value in joint.homogeneity if fitted[name].observed},
        runs=tuple(
            RunOfJoint(
                name=run.name,
                fit=run.fit,
                values=_intervals(estimate.values, fitted),
                own=_intervals(estimate.own, fitted),
                p_value=estimate.p_value,
                cause=estimate.cause,
                factor=estimate.factor,
            )
            for run, estimate in zip(runs, joint.runs, strict=True)
        ),
    )


def _hidden_by_vibration(fitted: NoiseFit, *, runs: Sequence[JointRun], longest: JointRun) -> Adjustment | None:
    """Replace all terms by upper limits if vibration hides the noise of the joint fit or of one of its runs."""
    alone = replace(fitted, channel=longest.channel)
    if all(run.fit.verdict != "disturbed" for run in runs) and not is_disturbed(alone, longest.stream, unsteady=1.0):
        return None
    shares = [cause.share for run in runs for cause in run.fit.reasons if isinstance(cause, VibrationPower)]
    vibration = VibrationPower(
        lines=len(fitted.sinusoid),
        resonances=len(fitted.resonance),
        share=max([vibration_share(fitted), *shares]),
        start=0.0,
        stop=0.0,
        quietest=None,
    )
    adjustments = [
        limits_alone(replace(fitted, channel=run.channel), run.stream, cause="vibration", reason=vibration)
        for run in runs
    ]
    # All runs of one channel limit the same noise, so the lowest limit holds. An axis limits only its own noise.
    several_axes = len({run.channel for run in runs}) > 1
    return (max if several_axes else min)(adjustments, key=_walk_limit)


def _walk_limit(adjustment: Adjustment) -> float:
    """The limit of the random walk after an adjustment; inf if there is none."""
    limits = (change.after.upper_limit for change in adjustment.changes if change.parameter == Parameter("random_walk"))
    return next(limits, None) or math.inf


def _lines(fit: NoiseFit) -> list[LineEstimate]:
    """The lines of a fit in the form of the compiled core."""

    def estimate(interval: Interval) -> Estimate:
        return Estimate(interval.value, interval.low, interval.high)

    return [LineEstimate(estimate(line.amplitude), estimate(line.frequency)) for line in fit.sinusoid]


def _intervals(estimates: Iterable[tuple[str, Estimate]], fit: NoiseFit) -> dict[str, Interval]:
    """Coefficients by name, with the units of a fit."""
    return {name: interval_with_unit(estimate, fit[name].unit) for name, estimate in estimates}


def check_same_sensor(stream: Stream, first: Stream, *, channel: str, names: tuple[str, str]) -> None:
    """Raise `DataError` if the unit or rate of a run differs from that of the first run. `names`: those of both runs."""
    if (stream.quantity, stream.unit) != (first.quantity, first.unit):
        raise DataError(
            f"{names[0]}: {channel} is in {stream.unit}, in {names[1]} it is in {first.unit};"
            " give runs of one sensor in the same unit"
        )
    if not math.isclose(stream.grid.tau0, first.grid.tau0, rel_tol=_SAME_RATE):
        raise DataError(
            f"{names[0]}: {channel} has {stream.grid.rate:.6g} Hz, in {names[1]} it has {first.grid.rate:.6g} Hz;"
            " a joint fit needs runs with the same rate"
        )


def _refuse(runs: Sequence[JointRun], channel: str) -> None:
    if not 2 <= len(runs) <= MAX_RUNS:
        raise OptionError(
            f"{{option}}: a joint fit of {channel} needs 2 to {MAX_RUNS} runs, not {len(runs)}", option="records"
        )
    first = runs[0]
    for run in runs[1:]:
        check_same_sensor(run.stream, first.stream, channel=run.channel, names=(run.name, first.name))
    for k, run in enumerate(runs):
        for earlier in runs[:k]:
            if run.summary.is_same(earlier.summary):
                raise DataError(
                    f"{run.name}: {run.channel} has the same samples as {earlier.name}; give each run only once"
                )
