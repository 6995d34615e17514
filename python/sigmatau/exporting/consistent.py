"""K for which a filter with N and K states its errors correctly, and how wrong its statement is at other times.

No K is consistent for flicker noise at all horizons. The default K is correct at the horizon of use; the file states
how wrong the filter is at other times, and how wrong it is about the bias.
"""

from __future__ import annotations

from collections.abc import Sequence

from sigmatau.exporting.choices import Criterion
from sigmatau.findings.exporting import PairConsistency, StatedError
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.model.unobserved import Unobserved, assume_terms
from sigmatau.navigation.reference_filter import (
    AIDING,
    ConsistentProcess,
    ConsistentWalk,
    FilterModel,
    TrueNoise,
    find_consistent_process,
    find_consistent_walk,
    find_third_state,
    judge_filter,
    run_of_process,
)
from sigmatau.noise.terms import SLOW

HORIZON = 60.0
"""Default time at which a filter has to state its error correctly: a minute without the aiding sensor. [s]"""

_TIMES = (1 / 6, 1.0, 10.0)  # times at which a file states the error, in horizons: 10 s, 60 s and 10 min


@frozen(eq=False)
class AssumedNoise:
    """Noise that is assumed for a channel: the observed terms and, depending on a policy, the other terms.

    Attributes
    ----------
    noise : TrueNoise
    slow : bool
        Whether its bias changes, or may change within the limits of terms that were not observed.
    assumed : bool
        Whether it has terms that were not observed.
    """

    noise: TrueNoise
    slow: bool
    assumed: bool


def assume_noise(model: ChannelModel, policy: Unobserved) -> AssumedNoise:
    """Build the assumed noise of a channel, with a policy for terms that were not observed."""
    terms = assume_terms(model, policy)
    possible = {**model.terms, **model.limits}
    return AssumedNoise(
        noise=TrueNoise(terms=terms, gauss_markov=model.gauss_markov, resonance=model.resonance),
        slow=any(term in possible for term in SLOW) or bool(model.gauss_markov or model.resonance),
        assumed=len(terms) > len(model.terms),
    )


def consistent_walk(
    truth: AssumedNoise, *, sensor: str, noise: float, horizon: float, criterion: Criterion
) -> ConsistentWalk:
    """Consistent K of one channel for N = `noise`."""
    return find_consistent_walk(truth.noise, noise=noise, aiding=AIDING[sensor], horizon=horizon, criterion=criterion)


def judge_pair(
    truths: Sequence[AssumedNoise], *, sensor: str, noise: float, walk: float, horizon: float, mean: bool
) -> PairConsistency:
    """Errors stated by a filter with N = `noise` and K = `walk`, for the worst axis or the mean square of the axes."""
    assumed = FilterModel(noise=noise, walk=walk)
    return _stated([truth.noise for truth in truths], assumed, sensor=sensor, horizon=horizon, mean=mean)


def consistent_process(
    truth: AssumedNoise, *, sensor: str, noise: float, horizon: float, time: float
) -> ConsistentProcess:
    """Consistent Gauss-Markov bias of one channel for N = `noise`."""
    return find_consistent_process(truth.noise, noise=noise, aiding=AIDING[sensor], horizon=horizon, time=time)


def judge_process(
    truths: Sequence[AssumedNoise], process: GaussMarkov, *, sensor: str, noise: float, horizon: float, mean: bool
) -> PairConsistency:
    """Errors stated by a filter with a Gauss-Markov bias, for the worst axis or the mean square of the axes."""
    assumed, run = FilterModel(noise=noise, process=process), run_of_process(horizon, process.time)
    return _stated([truth.noise for truth in truths], assumed, sensor=sensor, horizon=horizon, mean=mean, run=run)


def third_state(model: ChannelModel, *, sensor: str, horizon: float) -> FilterModel:
    """Walk and Gauss-Markov process for a filter that can have a third state."""
    noise = TrueNoise(terms=model.terms, gauss_markov=model.gauss_markov, resonance=model.resonance)
    return find_third_state(noise, noise=model.terms["random_walk"], aiding=AIDING[sensor], horizon=horizon)


def judge_third_state(model: ChannelModel, assumed: FilterModel, *, sensor: str, horizon: float) -> PairConsistency:
    """Errors stated by a filter with a third state."""
    truth = TrueNoise(terms=model.terms, gauss_markov=model.gauss_markov, resonance=model.resonance)
    return _stated([truth], assumed, sensor=sensor, horizon=horizon, mean=False)


def _stated(
    truths: Sequence[TrueNoise],
    assumed: FilterModel,
    *,
    sensor: str,
    horizon: float,
    mean: bool,
    run: float | None = None,
) -> PairConsistency:
    """Errors stated by a filter, up to ten times the horizon."""
    times = [share * horizon for share in _TIMES]
    judged = judge_filter(truths, assumed, aiding=AIDING[sensor], times=times, mean=mean, run=run)
    stated = tuple(StatedError(time=error.time, share=error.stated / error.real) for error in judged.coasting)
    return PairConsistency(sensor=sensor, walk=assumed.walk, horizon=horizon, nees=judged.nees, stated=stated)
