"""Bias of the result if the window is chosen by the least scatter of its own noise.

Stationary noise has quiet stretches, and the window whose means scatter least contains less slow noise than any other: of
four hours of a rate random walk, the two most stable hours show half of its Allan variance at τ = 30 min. The choice is
simulated: means over 60 s of records with the given noise (their differences are a stationary Gaussian series of known
covariance, drawn by circulant embedding), the most stable window of each, and its Allan variance over the expected one.

References
----------
R. B. Davies, D. S. Harte, "Tests for Hurst effect", Biometrika 74 (1987), :doi:`10.1093/biomet/74.1.95`, for the generator.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.kinds import disturbances as kinds
from sigmatau.fitting.components import LINEAR, components, power_of_interval
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import TERMS, avar
from sigmatau.quality.drift.block_means import autocovariance
from sigmatau.quality.selection.window import block_length, criterion, scatter, wanted_length
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

__all__ = ["SelectionBias", "bias_finding", "selection_bias"]

Models = Mapping[str, Mapping[str, float]]

SEED = 952  # default seed of the simulated records
DRAWS = 1000  # default number of simulated records
WARN_BIAS = 0.05  # relative change of a coefficient from which on the finding is a warning; a convention
_ROUGH_DRAWS = 250  # in all iterations but the last
_ITERATIONS = 4  # of the noise that shows, after the choice, what was fitted
_LEAST_FACTOR = 0.2  # a smaller factor is that of a term which the window does not show
_SLOWEST = "rate_random_walk"
_WINDOW_PER_TAU = 3  # averaging times up to a third of the window, as in a fit
_LEAST_RATIO = 0.8  # a warning below: Allan variance over that of the noise
_TOLD_TAUS = (300.0, 600.0, 1200.0, 1800.0)  # at which the finding states the ratio [s]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SelectionBias:
    """Mean effect of choosing the most stable window on one channel."""

    channel: str
    tau: Floats  # averaging times [s]
    ratio: Floats  # Allan variance of the chosen window over that of the noise
    error: Floats  # standard error of the ratio from the number of draws
    factors: Mapping[str, float]  # coefficient of the chosen window over that of the noise
    record: float  # lengths [s]
    window: float
    draws: int

    def at(self, tau: float) -> float:
        """The ratio at an averaging time, between those computed by a line in the logarithm of τ."""
        return float(np.interp(math.log(tau), np.log(self.tau), self.ratio))


def selection_bias(
    models: Models,
    *,
    n: int,
    window: int,
    tau0: float,
    block: int | None = None,
    draws: int = DRAWS,
    rng: int | np.random.Generator = SEED,
) -> dict[str, SelectionBias]:
    """Effect of choosing the most stable window of stationary noise on the Allan variance and the coefficients, by channel.

    Parameters
    ----------
    models : mapping of str to mapping of str to float
        Coefficients of the noise by channel, terms as in `sigmatau.noise.terms.TERMS`; the window is chosen by all channels
        together, as `sigmatau.quality.selection.window.most_stable` does. [SI]
    n, window, block : int
        Samples in the record, in the window, and in the blocks whose means are compared, see `block_length`.
    tau0 : float
        Sample interval. [s]
    draws : int
        Simulated records.
    rng : int or numpy.random.Generator

    Raises
    ------
    ValueError
        For a window that is longer than the record, or shorter than ten blocks; for an unknown term, or no noise.
    """
    block = block_length(window * tau0, tau0) if block is None else block
    blocks, size = n // block, window // block
    if not (block >= 1 and size >= 10 and window <= n):
        raise ValueError(
            f"a window of {window} samples of {n} in blocks of {block}: want 10 blocks, and no more than {n}"
        )
    if not models:
        raise ValueError("no channel was given")
    generator = rng if isinstance(rng, np.random.Generator) else np.random.default_rng(rng)
    means = np.stack([_draw(model, blocks, block, tau0, draws, generator) for model in models.values()], axis=1)
    start = np.argmin(scatter(means, size), axis=-1)
    index = start[:, None] + np.arange(size)
    sizes = _sizes(size)
    result = {}
    for k, (channel, model) in enumerate(models.items()):
        chosen = np.take_along_axis(means[:, k], index, axis=1)
        expected = sum((avar(term, value, m=sizes * block, tau0=tau0) for term, value in model.items()), np.zeros(1))
        ratio, error = _ratios(chosen, means[:, k], sizes, expected)
        result[channel] = SelectionBias(
            channel=channel,
            tau=np.asarray(sizes * (block * tau0), dtype=np.float64),
            ratio=ratio,
            error=error,
            factors=_factors(model, window, tau0, sizes * block, ratio),
            record=n * tau0,
            window=window * tau0,
            draws=draws,
        )
    return result


def bias_finding(
    record: Record,
    text: str,
    fits: Mapping[str, NoiseFit],
    *,
    rng: int | np.random.Generator = SEED,
    warn_bias: float = WARN_BIAS,
) -> list[Finding]:
    """Bias of the coefficients that were fitted to the most stable window, as ``"most-stable=2h"`` chose it.

    One ``"selection_bias"`` for each channel of the streams whose window was chosen by their own scatter: a warning if a
    coefficient is more than 5 % too small or too large, or the Allan variance more than 20 % too small. The fitted noise is
    itself too small: the bias stated is that of the noise which, after the choice, shows on average what was fitted; the
    simulation is iterated four times. A term that is not observed in the window is taken as absent.

    Parameters
    ----------
    record : Record
        The whole one, before `sigmatau.quality.selection.window.choose`.
    text : str
        The option; any other than ``"most-stable=…"`` gives no finding.
    fits : mapping of str to NoiseFit
        Of the channels in the window.
    rng : int or numpy.random.Generator
        Seed of the simulated choices, or a generator.
    warn_bias : float
        Relative change of a coefficient from which on the finding is a warning.
    """
    length = wanted_length(text)
    if length is None:
        return []
    findings = []
    for stream in record.streams:
        if criterion(record, stream).kind != "own" or stream.quantity == "temperature":
            continue
        seen = {c: _noise_of(fits[c]) for c in stream.channels if c in fits and any(_noise_of(fits[c]).values())}
        window = round(length / stream.grid.tau0)
        if not seen or window // block_length(length, stream.grid.tau0) < 10 or window >= stream.grid.n:
            continue
        found = _undone(seen, stream, window, rng)
        hidden = _hidden_walks(seen, fits, stream, window, rng, warn_bias)
        findings += [_finding(stream, one, hidden[channel], warn_bias) for channel, one in found.items()]
    return findings


def _hidden_walks(
    seen: Models,
    fits: Mapping[str, NoiseFit],
    stream: Stream,
    window: int,
    rng: int | np.random.Generator,
    warn_bias: float,
) -> dict[str, kinds.HiddenWalk | None]:
    """By channel, the limit of a rate random walk that the window does not show, and the bias of such a walk; else None."""
    limits = {
        channel: limit
        for channel, model in seen.items()
        if _SLOWEST not in model and _SLOWEST in fits[channel] and (limit := fits[channel][_SLOWEST].upper_limit)
    }
    result: dict[str, kinds.HiddenWalk | None] = dict.fromkeys(seen)
    if not limits:
        return result
    models = {c: {**model, **({_SLOWEST: limits[c]} if c in limits else {})} for c, model in seen.items()}
    found = _undone(models, stream, window, rng)
    for channel, limit in limits.items():
        factor = max(found[channel].factors.get(_SLOWEST, 1.0), _LEAST_FACTOR)
        if factor < 1 - warn_bias:
            result[channel] = kinds.HiddenWalk(limit=limit, factor=factor)
    return result


def _noise_of(fitted: NoiseFit) -> dict[str, float]:
    return {term: value for term, value in fitted.model.items() if value}


def _undone(seen: Models, stream: Stream, window: int, rng: int | np.random.Generator) -> dict[str, SelectionBias]:
    """The bias of the noise that shows, after the choice, what was seen."""
    seed = int(rng.integers(1 << 62)) if isinstance(rng, np.random.Generator) else rng
    models = {channel: dict(model) for channel, model in seen.items()}
    found: dict[str, SelectionBias] = {}
    for step in range(_ITERATIONS):
        draws = DRAWS if step == _ITERATIONS - 1 else _ROUGH_DRAWS
        found = selection_bias(models, n=stream.grid.n, window=window, tau0=stream.grid.tau0, draws=draws, rng=seed)
        for channel, model in models.items():
            for term, factor in found[channel].factors.items():
                # Half a step in the logarithm: a whole one may swing.
                model[term] = math.sqrt(model[term] * seen[channel][term] / max(factor, _LEAST_FACTOR))
    return found


def _finding(stream: Stream, bias: SelectionBias, hidden: kinds.HiddenWalk | None, warn_bias: float) -> Finding:
    taus = [tau for tau in _TOLD_TAUS if bias.tau[0] <= tau <= bias.window / 4 * 1.001]
    if not taus:
        taus = [float(tau) for tau in bias.tau[bias.tau <= bias.window / 4][-3:]]
    ratios = tuple((tau, bias.at(tau)) for tau in taus)
    least = min((ratio for _, ratio in ratios), default=1.0)
    known = ((term, max(factor, _LEAST_FACTOR)) for term, factor in bias.factors.items())
    factors = tuple((term, factor) for term, factor in known if abs(factor - 1) > warn_bias)
    details = kinds.SelectionBias(
        quantity=stream.quantity,
        record=bias.record,
        window=bias.window,
        ratios=ratios,
        draws=bias.draws,
        hidden_walk=hidden,
    )
    severity: Severity = "warning" if factors or least < _LEAST_RATIO else "info"
    return Finding(details=details, severity=severity, channels=(bias.channel,), size=least, factors=factors)


def _draw(
    model: Mapping[str, float], blocks: int, block: int, tau0: float, draws: int, generator: np.random.Generator
) -> Floats:
    """Block means of records with the given noise, from 0 at the first; shape (draws, blocks)."""
    unknown = set(model) - set(TERMS)
    if unknown:
        raise ValueError(f"unknown term {min(unknown)!r}; terms: {', '.join(TERMS)}")
    count = blocks - 1
    covariance = np.zeros(count + 1)
    for term in LINEAR:
        if model.get(term):
            theta = model[term] ** 2 * tau0 ** (power_of_interval(term) - 2)
            covariance += theta * autocovariance(term, count + 1, block)
    if not covariance[0] > 0:
        raise ValueError("the model has no noise")
    # The eigenvalues of the circulant are those of its first row; none is below 0 but by rounding.
    power = np.maximum(np.fft.rfft(np.concatenate([covariance, covariance[-2:0:-1]])).real, 0.0)
    white = np.fft.rfft(generator.standard_normal((draws, 2 * count)), axis=1)
    differences = np.fft.irfft(white * np.sqrt(power), n=2 * count, axis=1)[:, :count]
    differences += model.get("rate_ramp", 0.0) * block * tau0
    return np.concatenate([np.zeros((draws, 1)), np.cumsum(differences, axis=1)], axis=1)


def _sizes(size: int) -> Ints:
    """Averaging times in blocks: whole ones, about four an octave, up to a third of the window."""
    steps = np.unique(np.round(2.0 ** np.arange(0, math.log2(size / _WINDOW_PER_TAU) + 0.01, 0.25)))
    return np.union1d(steps, [size // 4]).astype(np.int64)


def _variances(means: Floats, sizes: Sequence[int]) -> Floats:
    """Overlapped Allan variances of rows of block means; shape (draws, n_tau)."""
    total = np.concatenate(
        [np.zeros((len(means), 1)), np.cumsum(means - means.mean(axis=1, keepdims=True), axis=1)], axis=1
    )
    columns = []
    for m in sizes:
        z = total[:, 2 * m :] - 2 * total[:, m:-m] + total[:, : -2 * m]
        columns.append((z * z).mean(axis=1) / (2 * m * m))
    return np.stack(columns, axis=1)


def _ratios(chosen: Floats, whole: Floats, sizes: Ints, expected: Floats) -> tuple[Floats, Floats]:
    """Mean Allan variance of the chosen windows over the expected one, with that of the whole records as control variate."""
    of_chosen = _variances(chosen, sizes.tolist()) / expected
    control = _variances(whole, sizes.tolist()) / expected - 1
    spread = control.std(axis=0)
    both = ((of_chosen - of_chosen.mean(axis=0)) * (control - control.mean(axis=0))).mean(axis=0)
    slope = np.divide(both, spread**2, out=np.zeros_like(both), where=spread > 0)
    left = of_chosen - slope * control
    return np.asarray(left.mean(axis=0)), np.asarray(left.std(axis=0, ddof=1) / math.sqrt(len(left)))


def _factors(model: Mapping[str, float], window: int, tau0: float, m: Ints, ratio: Floats) -> dict[str, float]:
    """What a fit to the mean Allan variances of the chosen windows finds, over what is there."""
    half = [1 << j for j in range(int(math.log2(window)) + 1)]
    sizes = sorted({size for one in half for size in (one, one + one // 2) if 1 <= size <= window // _WINDOW_PER_TAU})
    parts = components(window, tuple(sizes))
    theta = np.array([model.get(term, 0.0) ** 2 * tau0 ** (power_of_interval(term) - 2) for term in LINEAR])
    # Below a block the choice tells the less, the shorter: what it lowers is slow.
    lowered = np.interp(np.log(sizes), np.log(m), ratio)
    short = np.array(sizes) < m[0]
    lowered[short] = 1 - (1 - ratio[0]) * np.array(sizes)[short] / m[0]
    terms = [p for p in range(len(LINEAR)) if theta[p] > 0]
    scale = float(np.median(parts.design @ theta))
    try:
        found = Gls(parts, parts.design @ theta / scale * lowered, terms).fit(start=theta / scale) * scale
    except FloatingPointError:
        return {}
    return {LINEAR[p]: math.sqrt(found[p] / theta[p]) for p in terms}
