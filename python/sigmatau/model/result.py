"""Noise models from results of `analyze`, as they stand in its JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, Sinusoid
from sigmatau.terms import TERMS

__all__ = ["channel_of_fit", "channels_of_result", "models_of", "results_by_channel"]


def channels_of_result(content: Mapping[str, Any], *, channels: Iterable[str] | None) -> dict[str, ChannelModel]:
    """The models of the channels that have one, or of those that are named; raises `DataError`."""
    found = results_by_channel(content)
    named = list(found) if channels is None else list(channels)
    for name in named:
        if name not in found:
            raise DataError(f"no channel {name!r}; channels: {', '.join(found)}")
    models, without = models_of({name: found[name] for name in named})
    if without and channels is not None:
        raise DataError(f"channel {without[0]!r} has no model: its fit is {found[without[0]]['fit'].get('verdict')!r}")
    if not models:
        raise DataError("no channel of this result has a model")
    return models


def results_by_channel(content: Mapping[str, Any]) -> dict[str, Any]:
    """What a result has of each channel, whatever that is; raises `DataError` if it has none."""
    channels = content.get("channels") if isinstance(content, Mapping) else None
    if not isinstance(channels, Mapping) or not channels:
        raise DataError("this is no result of sigmatau analyze: it has no channels")
    return {str(name): channel for name, channel in channels.items()}


def models_of(channels: Mapping[str, Any]) -> tuple[dict[str, ChannelModel], list[str]]:
    """The models of channels by name, and the names of those without one; raises `DataError`, which names the channel.

    Parameters
    ----------
    channels : mapping of str to mapping
        As a result has them. What is needed: ``fit``, ``quantity``, ``curve.unit``.
    """
    models, without = {}, []
    for name, channel in channels.items():
        try:
            fit, quantity, unit = channel["fit"], channel["quantity"], channel["curve"]["unit"]
            if not (isinstance(quantity, str) and isinstance(unit, str)):
                raise TypeError(f"quantity {quantity!r}, unit {unit!r}")
            if fit["model"] or fit["terms"]["gauss_markov"] or fit["terms"]["sinusoid"]:
                models[name] = channel_of_fit(
                    fit, quantity=quantity, unit=unit, duration=_duration(channel), rate=_rate(channel)
                )
            else:
                without.append(name)
        except DataError as error:
            raise DataError(f"channel {name!r}: {error}") from None
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            raise DataError(
                f"channel {name!r}: not a result of sigmatau analyze with a fit ({error!r} is missing or wrong)"
            ) from None
    return models, without


def channel_of_fit(
    fit: Mapping[str, Any], *, quantity: str, unit: str, duration: float = 0.0, rate: float = 0.0
) -> ChannelModel:
    """The model of one channel from a fit's ``to_dict``; `duration` of its record in s, its sampling rate in Hz."""
    terms = fit["terms"]
    five = {name: terms[name] for name in TERMS if name in terms}
    model = {term: float(value) for term, value in fit["model"].items() if term in TERMS}
    names, matrix = _covariance(fit.get("covariance") or {})
    return ChannelModel(
        terms=model,
        gauss_markov=tuple(
            GaussMarkov(sigma=float(g["sigma"]["value"]), time=float(g["time"]["value"])) for g in terms["gauss_markov"]
        ),
        sinusoid=tuple(
            Sinusoid(amplitude=float(s["amplitude"]["value"]), frequency=float(s["frequency"]["value"]))
            for s in terms["sinusoid"]
        ),
        quantity=quantity,
        unit=unit,
        intervals={
            name: (float(term["low"]), float(term["high"]))
            for name, term in five.items()
            if term.get("low") is not None and term.get("high") is not None and name in model
        },
        limits={name: float(term["upper_limit"]) for name, term in five.items() if "upper_limit" in term},
        covariance=(names, matrix),
        level=next((float(term["level"]) for term in five.values()), 0.95),
        tau_min=float(fit.get("tau_min_s") or 0.0),
        duration=duration,
        rate=rate,
        adequate=fit.get("verdict") != "descriptive",
    )


def _rate(channel: Mapping[str, Any]) -> float:
    """Sampling rate in Hz; 0 if the result does not say."""
    return max(float(channel.get("sample_rate_hz") or 0.0), 0.0)


def _duration(channel: Mapping[str, Any]) -> float:
    """Length of the record in s; 0 if the result does not say."""
    rate = _rate(channel)
    return float(channel.get("samples") or 0) / rate if rate > 0 else 0.0


def _covariance(content: Mapping[str, Any]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    names = tuple(content.get("terms", ()))
    matrix = np.asarray(content.get("matrix", ()), dtype=np.float64)
    return names, matrix.reshape(len(names), len(names))
