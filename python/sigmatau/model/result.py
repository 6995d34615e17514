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

__all__ = ["channel_of_fit", "channels_of_result"]


def channels_of_result(content: Mapping[str, Any], *, channels: Iterable[str] | None) -> dict[str, ChannelModel]:
    """The channels that have a fit, or those that are named; raises `DataError`."""
    try:
        found: dict[str, Mapping[str, Any]] = dict(content["channels"])
    except (KeyError, TypeError, ValueError, AttributeError):
        raise DataError("this is no result of sigmatau analyze: it has no channels") from None
    names = list(channels) if channels is not None else list(found)
    models = {}
    for name in names:
        if name not in found:
            raise DataError(f"no channel {name!r}; channels: {', '.join(found)}")
        try:
            channel = found[name]
            fit = channel["fit"]
            if fit["model"] or fit["terms"]["gauss_markov"] or fit["terms"]["sinusoid"]:
                models[name] = channel_of_fit(
                    fit,
                    quantity=channel["quantity"],
                    unit=channel["curve"]["unit"],
                    duration=_duration(channel),
                )
            elif channels is not None:
                raise DataError(f"channel {name!r} has no model: its fit is {fit['verdict']!r}")
        except DataError:
            raise
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise DataError(
                f"channel {name!r}: not a result of sigmatau analyze with a fit ({error!r} is missing or wrong)"
            ) from None
    if not models:
        raise DataError("no channel of this result has a model")
    return models


def channel_of_fit(fit: Mapping[str, Any], *, quantity: str, unit: str, duration: float = 0.0) -> ChannelModel:
    """The model of one channel from a fit's ``to_dict``; `duration` of its record in s."""
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
    )


def _duration(channel: Mapping[str, Any]) -> float:
    """Length of the record in s; 0 if the result does not say."""
    rate = float(channel.get("sample_rate_hz") or 0.0)
    return float(channel.get("samples") or 0) / rate if rate > 0 else 0.0


def _covariance(content: Mapping[str, Any]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    names = tuple(content.get("terms", ()))
    matrix = np.asarray(content.get("matrix", ()), dtype=np.float64)
    return names, matrix.reshape(len(names), len(names))
