"""Conversion of a fit to the noise model that simulations, filters and exports use."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from sigmatau._native import kernels
from sigmatau.errors import DataError
from sigmatau.fitting.fitted_noise import FittedNoise
from sigmatau.fitting.fitted_values import FittedResonance
from sigmatau.model.channel import ChannelModel
from sigmatau.model.parameters import Covariance, Parameter
from sigmatau.model.processes import GaussMarkov, Resonance, Sinusoid

_LEFT_OUT_ABOVE = 1.5  # a fit whose shortest averaging time is longer has left out short times [samples]
_WITHOUT_MODEL = ("too_short",)  # verdicts of fits that have no model


def has_model(fit: FittedNoise) -> bool:
    """Whether a fit has a coefficient or a process."""
    return bool(fit.model or fit.gauss_markov or fit.resonance or fit.sinusoid)


def to_model(fit: FittedNoise) -> ChannelModel:
    """The model of a fit, with its intervals, limits and covariance.

    Resonances that sampling would fold into the white noise are left out.

    Raises
    ------
    DataError
        For a fit without a model, or with values that a model does not allow.
    """
    if fit.verdict in _WITHOUT_MODEL:
        raise DataError(f"its fit is {fit.verdict!r} and has no model")
    rate = 1 / fit.tau0
    numbers = _unfolded(fit, rate)
    resonances = (fit.resonance[k - 1] for k in numbers)
    alike = fit.alike_from is not None and fit.alike_sigma is not None and "rate_random_walk" in fit.model
    return ChannelModel(
        terms=fit.model,
        gauss_markov=tuple(GaussMarkov(sigma=p.sigma.value, time=p.time.value) for p in fit.gauss_markov),
        resonance=tuple(
            Resonance(sigma=p.sigma.value, frequency=p.frequency.value, width=p.width.value) for p in resonances
        ),
        sinusoid=tuple(Sinusoid(amplitude=p.amplitude.value, frequency=p.frequency.value) for p in fit.sinusoid),
        alike_from=GaussMarkov(sigma=fit.alike_sigma, time=fit.alike_from) if alike else None,  # type: ignore[arg-type]
        alternatives=tuple(
            ChannelModel(
                terms=second.terms,
                gauss_markov=tuple(GaussMarkov(sigma=sigma, time=time) for sigma, time in second.gauss_markov),
                quantity=fit.quantity,
                unit=fit.rate_unit,
            )
            # White noise after a filter is left out: it has the curve of the process that it replaces.
            for second in fit.second
            if second.filter is None
        ),
        bandwidth=fit.response.low_pass if fit.response is not None and "random_walk" in fit.model else None,
        quantity=fit.quantity,
        unit=fit.rate_unit,
        intervals={
            name: (term.low, term.high)
            for name, term in fit.terms.items()
            if term.low is not None and term.high is not None and name in fit.model
        },
        limits={name: term.upper_limit for name, term in fit.terms.items() if term.upper_limit is not None},
        covariance=fit.covariance if len(numbers) == len(fit.resonance) else _resonance_block(fit.covariance, numbers),
        level=next((term.level for term in fit.terms.values()), fit.level),
        tau_min=fit.tau_min or 0.0,
        duration=fit.n / rate,
        rate=rate,
        adequate=fit.quantified,
        highest=_highest_frequency(fit, rate),
    )


def _unfolded(fit: FittedNoise, rate: float) -> list[int]:
    """Numbers, from 1, of the resonances that sampling does not fold into the white noise."""
    walk = fit.model.get("random_walk", math.inf)

    def is_folded(p: FittedResonance) -> bool:
        return kernels.resonance_folds(p.sigma.value, p.frequency.value, p.width.value, 1 / rate, random_walk=walk)

    return [k for k, process in enumerate(fit.resonance, 1) if not is_folded(process)]


def _resonance_block(covariance: Covariance, numbers: Sequence[int]) -> Covariance:
    """Select the covariance of some resonances, and renumber them from 1."""
    renumbered = {old: new for new, old in enumerate(numbers, 1)}

    def renamed(parameter: Parameter) -> Parameter | None:
        if parameter.part != "resonance" or parameter.number is None:
            return parameter
        new = renumbered.get(parameter.number)
        return None if new is None else replace(parameter, number=new)

    return covariance.select(renamed)


def _highest_frequency(fit: FittedNoise, rate: float) -> float | None:
    """Highest frequency that the model describes: that of the fit, or half over its shortest time if that is lower."""
    ends = [] if fit.highest is None else [fit.highest]
    ends += [0.5 / fit.tau_min] if fit.tau_min and fit.tau_min * rate > _LEFT_OUT_ABOVE else []
    return min(ends, default=None)


def to_models(fits: Mapping[str, FittedNoise]) -> dict[str, ChannelModel]:
    """Convert the fits that have a model. Raises a `DataError` that names the channel."""
    models = {}
    for name, fit in fits.items():
        if has_model(fit):
            try:
                models[name] = to_model(fit)
            except DataError as error:
                raise DataError(f"channel {name!r}: {error}") from None
    return models
