"""Covariance of the Allan variances of a record if a model is true, and whether noise dominates it.

Let C(l) be the covariance of the second differences z_j(n) and z_{j+l}(m) of the phase. The covariance of two Allan
variances is Σ w(l)·[C(l)² + 2·R²n²m²τ₀⁴·C(l)]/(2n²m²τ₀⁴·M(n)·M(m)), where w(l) is the number of pairs at the lag l and
R a ramp. For white noise after a low-pass filter and for resonances, C is the sum of F from one such part and E from
all other noise. The kernels compute Σ w·E². This module adds Σ w·(F² + 2FE) and Σ w·F for the ramp, from the
generalised autocovariances of the phase (`sigmatau.model.covariance`), for one part after the other.

F is smooth except at the nine lags at which ends of the two clusters coincide, and is negligible beyond the memory of
the part. The sums therefore include all lags near those nine, and Gauss points of panels in between. The panels grow
with the distance, up to one oscillation of the part.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.model import covariance as covariances
from sigmatau.model.channel import ChannelModel
from sigmatau.model.covariance import Damped
from sigmatau.model.parameters import Covariance
from sigmatau.model.processes import Sinusoid
from sigmatau.noise.terms import NOISE

# sine of the phase step per sample below which the samples of a sinusoid are constant or alternate
_SMALLEST_SINE = 1e-9
_MAX_PHASE_SHARE = 0.1
"""Largest error of a variance over its standard error. The change x of the variance by the phase of a sinusoid is
treated to first order; the next order, x²/2, is neglected.
"""


def covariance_of_model(
    model: ChannelModel, *, n: int, m: NDArray[np.int64], tau0: float, together: NDArray[np.bool_] | None = None
) -> Floats:
    """Covariance of the Allan variances if the model is true; shape (n_tau, n_tau). `together`: sizes whose mutual
    covariances include filtered noise and resonances. Default: all.
    """
    model = model.expand_matern(rate=1 / tau0)
    times = [process.time for process in model.gauss_markov]
    noise, ramp = kernels.covariance_tensors(n, m, tau0, correlation_times=times)
    theta = np.array(
        [model.terms.get(term, 0.0) ** 2 for term in NOISE] + [process.sigma**2 for process in model.gauss_markov]
    )
    if model.bandwidth is not None:
        theta[NOISE.index("random_walk")] = 0.0
    total = np.einsum("p,q,pqij->ij", theta, theta, noise)
    total += model.terms.get("rate_ramp", 0.0) ** 2 * np.einsum("p,pij->ij", theta, ramp)
    if model.bandwidth is not None or model.resonance:
        marked = np.ones(len(m), dtype=np.bool_) if together is None else together
        noise_ = replace(model, sinusoid=(), intervals={}, limits={}, covariance=Covariance())
        total += _damped(_CacheKey(noise_), n, tuple(m.tolist()), tau0, tuple(marked.tolist()))
    if model.sinusoid:
        quiet = replace(model, sinusoid=())
        for line, column, phase in _lines(model, n=n, m=m, tau0=tau0):
            # The squared amplitude that a record shows has the variance 8A²S/(n·tau0).
            density = float(quiet.psd(_folded(line.frequency, tau0), tau0=tau0)[0])
            total += 8 * density / (n * tau0 * line.amplitude**2) * np.outer(column, column)
            total += np.outer(column * phase, column * phase) / 2
    return np.asarray(total)


@dataclass(frozen=True)
class _CacheKey:
    """A key for the cache: models with the same noise are equal."""

    model: ChannelModel = field(compare=False)
    key: tuple[object, ...] = field(init=False)

    def __post_init__(self) -> None:
        model = self.model
        key = (tuple(model.terms.items()), model.gauss_markov, model.resonance, model.bandwidth)
        object.__setattr__(self, "key", key)


@functools.lru_cache(maxsize=8)
def _damped(same: _CacheKey, n: int, m: tuple[int, ...], tau0: float, together: tuple[bool, ...]) -> Floats:
    """Contribution of filtered white noise and resonances; cached, because it is the same for all records of one length."""
    model, filtered = same.model, same.model.bandwidth is not None
    terms = {
        term: value for term, value in model.terms.items() if term in NOISE and not (filtered and term == "random_walk")
    }
    covariances_damped = [covariances.gauss_markov(process, tau0) for process in model.gauss_markov]
    total = np.zeros((len(m), len(m)))
    # The slowest part is first: the other factor of a product is then smooth where the part is not.
    for part in sorted(replace(model, gauss_markov=()).damped(tau0), key=lambda part: part.fastest):

        def rest(lags: Floats, processes: tuple[Damped, ...] = tuple(covariances_damped)) -> Floats:
            phases = [
                covariances.phase_autocovariance_of_term(term, value, lags, tau0) for term, value in terms.items()
            ]
            return np.asarray(
                sum([*phases, *(process.phase(lags, tau0) for process in processes)], np.zeros(lags.shape))
            )

        total += covariance_with(
            part,
            n=n,
            m=np.array(m, dtype=np.int64),
            tau0=tau0,
            rest=rest,
            ramp=model.terms.get("rate_ramp", 0.0),
            together=np.array(together),
        )
        covariances_damped.append(part)
    total.setflags(write=False)
    return total


def _lines(model: ChannelModel, *, n: int, m: NDArray[np.int64], tau0: float) -> list[tuple[Sinusoid, Floats, Floats]]:
    """Variances of each sinusoid, and the relative change of the variances of a record by its unknown phase. For the
    phase φ at the middle of the record, the mean over M second differences is 1 + cos(2φ)·sin(Mω)/(M·sin ω) times the
    variance.
    """
    lines = []
    for line in model.sinusoid:
        turn = 2 * math.pi * _folded(line.frequency, tau0) * tau0
        terms = n - 2 * m + 1.0
        share = np.sin(terms * turn) / (terms * math.sin(turn)) if math.sin(turn) > _SMALLEST_SINE else np.ones(len(m))
        lines.append((line, kernels.sinusoid_avar(line.amplitude, line.frequency, m, tau0), share))
    return lines


def check_noise(model: ChannelModel, curve: DeviationCurve) -> None:
    """Raise `DataError` for a model without noise."""
    if not (set(model.terms) & set(NOISE) or model.gauss_markov or model.matern or model.resonance):
        raise DataError(
            f"the model of {curve.channel} has no noise, so a misfit has no probability; verify a model with noise"
        )


def check_phases(model: ChannelModel, curve: DeviationCurve, m: NDArray[np.int64], variance: Floats) -> None:
    """Raise `DataError` for a model whose variances depend more on the phase of a sinusoid than on noise."""
    expected = model.avar(m=m, tau0=curve.tau0)
    for line, column, share in _lines(model, n=curve.n, m=m, tau0=curve.tau0):
        moved = column * share / expected
        noise = np.sqrt(np.maximum(variance / expected**2 - moved**2 / 2, 0.0))
        # V includes the shares to first order; the error is half of their square.
        wrong = np.divide(moved**2 / 2, noise, out=np.full(len(m), np.inf), where=noise > 0)
        if wrong[moved != 0].max(initial=0.0) > _MAX_PHASE_SHARE:
            turns = _folded(line.frequency, curve.tau0) * curve.n * curve.tau0
            raise DataError(
                f"the model of {curve.channel} has a sinusoid at {line.frequency:.4g} Hz, of {turns:.3g} turns in the"
                f" record as it is sampled: its phase alone changes a variance by up to"
                f" {100 * np.abs(moved).max():.2g} %, which hides the noise; verify a longer record, or the model and the"
                " record without it"
            )


def _folded(frequency: float, tau0: float) -> float:
    """Frequency at which a sinusoid appears in the samples."""
    turns = frequency * tau0 % 1.0
    return max(min(turns, 1 - turns), 1e-12) / tau0


Phase = Callable[[Floats], Floats]

_SECOND_DIFFERENCE = np.array([1.0, -2.0, 1.0])

# Time constants of the slowest pole after which the memory of a part, e^−20 = 2e-9, is neglected
_MEMORY = 20.0
_NARROW = 10.0  # ratio of frequency to half width above which a resonance is narrow
_EXACT_SWINGS = 20.0  # half oscillations around a coincidence within which a narrow resonance is summed exactly
_WHOLE_LAGS = 24  # Lags on either side of a coincidence of cluster ends that are summed one by one
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


def covariance_with(
    part: Damped,
    *,
    n: int,
    m: NDArray[np.int64],
    tau0: float,
    rest: Phase,
    ramp: float,
    together: NDArray[np.bool_],
) -> Floats:
    """Covariance of Allan variances minus the covariance without one part of the noise.

    `tau0` is in s. `rest` is the generalised autocovariance of the phase of all other noise, at lags that need not be
    whole. `together` are the sizes whose mutual covariances are computed; for other sizes only the variances are, and
    the rest is 0.

    The error is 1e-4 of the whole, larger at averaging times far below those of the part, where the autocovariances lose
    digits (`ChannelModel.phase_autocovariance`). For a narrow resonance far from the nine lags, F² is replaced by its mean
    over an oscillation, and the product with other noise is neglected.
    """

    def own_phase(lags: Floats) -> Floats:
        return part.phase(lags, tau0)

    narrow = part.fastest > _NARROW * part.slowest and len(part.decays) == 1
    memory = math.ceil(_MEMORY / part.slowest)
    swing = math.pi / part.fastest
    exact = _EXACT_SWINGS * swing if narrow else math.inf
    panels = _panels(n, memory=min(memory, exact, 2 * n), swing=swing)
    total = np.zeros((len(m), len(m)))
    for i, first in enumerate(m.tolist()):
        for j, second in enumerate(m[: i + 1].tolist()):
            if i == j or (together[i] and together[j]):
                pairs = float(n - 2 * first + 1), float(n - 2 * second + 1)
                meetings = np.subtract.outer(np.arange(3) * first, np.arange(3) * second).ravel()
                lags, weights = _lags(meetings, pairs, memory, panels)
                change, exact_lags = np.empty(lags.shape), np.abs(lags[:, None] - meetings).min(axis=1) <= exact
                corrected = _differences(own_phase, first, second, lags[exact_lags])
                change[exact_lags] = corrected * (corrected + 2 * _differences(rest, first, second, lags[exact_lags]))
                change[~exact_lags] = _mean_square(part, tau0, first, second, lags[~exact_lags])
                change /= 2.0 * (float(first) * second * tau0**2) ** 2
                change[exact_lags] += ramp**2 * corrected
                total[i, j] = total[j, i] = weights @ change / (pairs[0] * pairs[1])
    return total


def _mean_square(part: Damped, tau0: float, first: int, second: int, lags: Floats) -> Floats:
    """Mean of C² over an oscillation, for a part with a single pole."""
    decay = complex(part.decays[0])
    size = tau0**2 / 4 * abs(complex(part.weights[0]) / np.sinh(decay / 2) ** 2)
    total = np.zeros(lags.shape, dtype=np.complex128)
    for a, weight in enumerate(_SECOND_DIFFERENCE):
        for b, right in enumerate(_SECOND_DIFFERENCE):
            distance = lags + float(b * second - a * first)
            swing = np.exp(-decay * np.abs(distance))
            total += weight * right * np.where(distance < 0, np.conj(swing), swing)
    return np.asarray((size * np.abs(total)) ** 2 / 2)


def _differences(phase: Phase, first: int, second: int, lags: Floats) -> Floats:
    """C at lags that need not be whole."""
    total = np.zeros(lags.shape)
    for a, weight in enumerate(_SECOND_DIFFERENCE):
        for b, right in enumerate(_SECOND_DIFFERENCE):
            total += weight * right * phase(np.abs(lags + float(b * second - a * first)))
    return total


def _lags(
    meetings: NDArray[np.int64], pairs: tuple[float, float], memory: int, panels: Floats
) -> tuple[Floats, Floats]:
    """Lags, and the number of pairs of second differences at each lag."""
    low = max(-int(pairs[0]), int(meetings.min()) - memory)
    high = min(int(pairs[1]), int(meetings.max()) + memory)
    ends = np.unique(np.concatenate([meetings[(meetings > low) & (meetings < high)], [low, high]]))
    lag_parts, standing = [np.array([float(high)])], [np.ones(1)]
    for begin, end in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        up = (end - begin) // 2
        for start, sign, inside in ((begin, 1.0, up), (end, -1.0, end - begin - 1 - up)):
            distance, count = _outwards(inside, panels)
            lag_parts.append(start + sign * distance)
            standing.append(count)
        lag_parts.append(np.array([float(begin)]))
        standing.append(np.ones(1))
    lags, weights = np.concatenate(lag_parts), np.concatenate(standing)
    number = np.minimum(pairs[0], pairs[1] - lags) - np.maximum(0.0, -lags)
    return lags, weights * np.maximum(number, 0.0)


def _panels(longest: int, *, memory: float, swing: float) -> Floats:
    """Ends of the panels of distances, which grow with the distance up to one oscillation."""
    ends = [min(_WHOLE_LAGS, longest)]
    while ends[-1] < longest:
        width = ends[-1] / 2
        if ends[-1] < memory:
            width = min(width, swing)
        ends.append(min(ends[-1] + max(math.floor(width), 1), longest))
    return np.array(ends, dtype=np.float64)


def _outwards(inside: int, panels: Floats) -> tuple[Floats, Floats]:
    """Distances 1 … `inside`, integers or Gauss points, and the number of distances that each represents."""
    whole = np.arange(1.0, min(inside, panels[0]) + 1)
    ends = np.minimum(panels[: np.searchsorted(panels, inside) + 1], inside)
    begin, width = ends[:-1], np.diff(ends)
    short = (width <= len(_POINTS)) & (width > 0)
    steps = np.arange(1.0, len(_POINTS) + 1)
    each = (begin[short, None] + steps)[steps <= width[short, None]]
    long = width > len(_POINTS)
    middle = begin[long] + 0.5 + width[long] / 2
    points = (middle[:, None] + width[long, None] / 2 * _POINTS).ravel()
    counts = (width[long, None] / 2 * _WEIGHTS).ravel()
    return np.concatenate([whole, each, points]), np.concatenate([np.ones(len(whole) + len(each)), counts])
