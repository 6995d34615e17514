"""Noise models from the JSON results of `analyze`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import DataError
from sigmatau.model.channel import PROCESSES, ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, real
from sigmatau.noise.terms import TERMS

_QUANTIFIED = ("adequate", "adequate_with", "widened")  # Verdicts of a fit whose coefficients have intervals
WITHOUT_REST = {
    "not_at_rest": (
        "the sensor was not at rest, so the result has no coefficients; sigmatau analyze --at-rest takes motion for noise"
    ),
    "too_short_to_tell": (
        "the record is too short to tell rest from motion, so the result has no coefficients; record for longer, or run "
        "sigmatau analyze --at-rest"
    ),
}
"""Why a result has no coefficients, by its verdict about rest."""
_FIRST_SAMPLES = 1.5  # samples of the shortest averaging time from which on a fit left out short times
_SCHEMAS = (1, 2)  # Forms of a result that are read
_WITH_MODEL = (*_QUANTIFIED, "disturbed", "descriptive")  # Verdicts of a fit that has coefficients


def channels_of_result(content: Mapping[str, Any], *, channels: Iterable[str] | None) -> dict[str, ChannelModel]:
    """Models of all channels that have one, or of the named channels; raises `DataError`."""
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
    """Results by channel; raises `DataError` if there are none."""
    if not isinstance(content, Mapping):
        raise DataError(
            f"a result of sigmatau analyze is an object, not {type(content).__name__}; NoiseModel.read reads a file"
        )
    error, schema = content.get("error"), content.get("schema", 1)
    if isinstance(error, Mapping):
        raise DataError(f"the analysis failed: {error.get('message')!s:.500}")
    if schema not in _SCHEMAS:
        raise DataError(
            f"schema {schema!r:.20} is of a newer version of sigmatau; known: {', '.join(map(str, _SCHEMAS))}"
        )
    channels = content.get("channels")
    if not isinstance(channels, Mapping) or not channels:
        raise DataError("this is not a result of sigmatau analyze: it has no channels")
    found = {str(name): channel for name, channel in channels.items()}
    rest = content.get("rest")
    reason = WITHOUT_REST.get(rest.get("verdict", "")) if isinstance(rest, Mapping) else None
    if reason and not any(map(_fitted, found.values())):
        raise DataError(reason)
    return found


def _fitted(channel: object) -> bool:
    return isinstance(channel, Mapping) and "fit" in channel


def models_of(channels: Mapping[str, Any]) -> tuple[dict[str, ChannelModel], list[str]]:
    """The models of channels by name, and the names of those without one; raises `DataError`, which names the channel."""
    models, without = {}, []
    for name, channel in channels.items():
        if isinstance(channel, Mapping) and "fit" not in channel and "read_off" in channel:
            raise DataError(
                f"channel {name!r}: its coefficients were only read off; a model needs a fit (method likelihood)"
            )
        try:
            fit, quantity, unit = channel["fit"], channel["quantity"], channel["curve"]["unit"]
            if not (isinstance(quantity, str) and isinstance(unit, str)):
                raise TypeError(f"quantity {quantity!r}, unit {unit!r}")
            if fit["model"] or any(fit["terms"].get(kind) for kind in PROCESSES):
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
    model = {term: _number(term, value) for term, value in fit["model"].items() if term in TERMS}
    if fit.get("verdict") not in _WITH_MODEL:
        raise DataError(
            f"the verdict of its fit is {fit.get('verdict')!r}; one with a model is {' or '.join(_WITH_MODEL)}"
        )
    names, matrix = _covariance(fit.get("covariance") or {})
    processes = {kind: _processes(terms.get(kind, ()), of) for kind, of in PROCESSES.items()}
    processes["resonance"], names, matrix = _without_folded(
        processes["resonance"], names, matrix, walk=model.get("random_walk", math.inf), rate=rate
    )
    return ChannelModel(
        terms=model,
        **processes,
        alike_from=_alike(fit) if "rate_random_walk" in model else None,
        bandwidth=_bandwidth(fit, rate) if "random_walk" in model else None,
        quantity=quantity,
        unit=unit,
        intervals={
            name: (_number("low", term["low"]), _number("high", term["high"]))
            for name, term in five.items()
            if term.get("low") is not None and term.get("high") is not None and name in model
        },
        limits={
            name: _number("upper_limit", term["upper_limit"]) for name, term in five.items() if "upper_limit" in term
        },
        covariance=(names, matrix),
        level=[*(_level(term["level"]) for term in five.values()), 0.95][0],
        tau_min=_number("tau_min_s", fit.get("tau_min_s")),
        duration=duration,
        rate=rate,
        adequate=fit["verdict"] in _QUANTIFIED,
        highest=_highest(fit, rate),
    )


def _processes(rows: Iterable[Mapping[str, Any]], kind: type) -> tuple[Any, ...]:
    return tuple(kind(**{part.name: row[part.name]["value"] for part in fields(kind)}) for row in rows)


def _without_folded(
    resonances: tuple[Any, ...], names: tuple[str, ...], matrix: NDArray[np.float64], *, walk: float, rate: float
) -> tuple[tuple[Any, ...], tuple[str, ...], NDArray[np.float64]]:
    """The resonances without those that a sampled model would fold into the white noise; and the covariance."""
    if rate <= 0:
        return resonances, names, matrix
    kept = [
        k
        for k, one in enumerate(resonances, 1)
        if not kernels.resonance_folds(one.sigma, one.frequency, one.width, 1 / rate, random_walk=walk)
    ]
    number = {f"resonance_{old}": f"resonance_{new}" for new, old in enumerate(kept, 1)}
    rows = [k for k, name in enumerate(names) if not name.startswith("resonance_") or name.partition(".")[0] in number]
    heads = [names[k].partition(".") for k in rows]
    renamed = tuple(f"{number.get(head, head)}{dot}{tail}" for head, dot, tail in heads)
    return tuple(resonances[k - 1] for k in kept), renamed, matrix[np.ix_(rows, rows)]


def _alike(fit: Mapping[str, Any]) -> GaussMarkov | None:
    """The process that explains the record as well as the rate random walk."""
    time, sigma = fit.get("alike_from_s"), fit.get("alike_sigma")
    return None if time is None or sigma is None else GaussMarkov(sigma=sigma, time=time)


def _highest(fit: Mapping[str, Any], rate: float) -> float | None:
    """The frequency up to which the model describes the record: that of the fit, or half over its shortest time."""
    shortest = _number("tau_min_s", fit.get("tau_min_s"))
    ends = [_number("highest_hz", fit["highest_hz"])] if fit.get("highest_hz") else []
    ends += [0.5 / shortest] if shortest * rate > _FIRST_SAMPLES else []
    return min(ends, default=None)


def _bandwidth(fit: Mapping[str, Any], rate: float) -> LowPass | None:
    """The filter of a fit, if a low-pass of the model is like it."""
    found = (fit.get("filter") or {}).get("low_pass")
    return None if found is None else LowPass(order=found["order"], corner=found["corner_hz"], rate=rate)


def _number(name: str, value: object) -> float:
    """A finite number, 0 for None; `DataError` for NaN, text or True."""
    number = 0.0 if value is None else real(value)
    if not math.isfinite(number):
        raise DataError(f"{name} must be a number, not {value!r:.80}")
    return number


def _level(value: object) -> float:
    if not 0 < real(value) < 1:
        raise DataError(f"the level of an interval must be between 0 and 1, not {value!r:.80}")
    return real(value)


def _rate(channel: Mapping[str, Any]) -> float:
    """Sampling rate; 0 if the result does not contain it. [Hz]"""
    return max(_number("sample_rate_hz", channel.get("sample_rate_hz")), 0.0)


def _duration(channel: Mapping[str, Any]) -> float:
    """Length of the record; 0 if the result does not contain it. [s]"""
    rate = _rate(channel)
    return _number("samples", channel.get("samples")) / rate if rate > 0 else 0.0


def _covariance(content: Mapping[str, Any]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    names = tuple(content.get("terms", ()))
    if not all(isinstance(name, str) for name in names):
        raise DataError(f"the terms of its covariance must be names, not {names!r:.80}")
    matrix = np.asarray(content.get("matrix", ()), dtype=np.float64)
    return names, matrix.reshape(len(names), len(names))
