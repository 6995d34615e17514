"""``sigmatau plan``: the length of a record that shows a noise term."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.analysis.inputs import is_result, require_model
from sigmatau.analysis.reading import read_analysis
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.declared import Show
from sigmatau.cli.options import say, working, write_result
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting.fitted_noise import QUANTIFIED
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.planning import plan
from sigmatau.fitting.to_model import has_model
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import has_unit, value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.shown import set_shown
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import TERMS, check_shown, coefficient_unit


@dataclass(frozen=True)
class _Channel:
    """Noise of one channel, and the parameters of its record if it has one."""

    name: str
    quantity: str
    rate_unit: str
    noise: Mapping[str, float]
    rate: float | None = None
    duration: float | None = None
    tau_min: float = 0.0
    verdict: str = "adequate"
    ignored: str = ""


def plan_command(
    source: Path,
    /,
    *,
    term: str,
    hours: float | None = None,
    value: str | None = None,
    rate: float | None = None,
    channels: Annotated[list[str] | None, Parameter(negative=())] = None,
    show: Show = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Plan the length of a record that shows a noise term, or the smallest value that a record shows.

    Parameters
    ----------
    source
        A model file (.toml), or the JSON that analyze writes.
    term
        The noise term: quantization, random_walk, bias_instability, rate_random_walk or rate_ramp.
    hours
        Length of a record in hours, to find the smallest value that it shows. Default: the length of the record, if the
        source is a result.
    value
        A value with its unit, "0.5 deg/h", to find the length of a record that shows it. Default: the value of the source.
    rate
        Sampling rate in Hz. Default: the rate of the record, if the source is a result.
    channels
        Channels to plan for. Default: all channels that have other noise terms and the unit of the value.
    json
        Print JSON instead of text.
    quiet
        Print only errors on standard error.
    """
    if term not in TERMS:
        raise OptionError(f"--term: {unknown_term(term)}", option="term")
    check_model(source)
    set_shown(show)
    noises = _channels(source)
    check_shown({name: (noise.quantity, noise.rate_unit) for name, noise in noises.items()})
    unknown = sorted(set(channels or ()) - set(noises))
    if unknown:
        raise OptionError(f"--channels {unknown[0]}: {source} has {', '.join(noises)}", option="channels")
    if hours is not None and not 0 < hours < float("inf"):
        raise OptionError(f"--hours {hours:g}: must be a positive number", option="hours")
    plans = []
    misfits = []  # units of the channels that the value does not fit: "deg/h" is not for an accelerometer
    for name in channels or noises:
        channel = noises[name]
        if getattr(channel.noise, "matern", ()):
            raise OptionError(
                f"{name}: planning does not count a Matérn process. Give a Gauss-Markov process of its sigma and time",
                option="model",
            )
        processes = getattr(channel.noise, "gauss_markov", ())
        if not processes and not any(v for t, v in channel.noise.items() if t not in (term, "rate_ramp")):
            if channels:
                raise OptionError(
                    f"{name}: has no noise besides {term}, so any value of it is visible", option="channels"
                )
            continue
        frequency = rate if rate is not None else channel.rate
        if frequency is None:
            raise OptionError("--rate: a model has no sampling rate; give it in Hz", option="rate")
        unit = coefficient_unit(term, channel.quantity, channel.rate_unit)
        if value is not None and not channels and not has_unit(value, unit):
            misfits.append(unit)
            continue
        sought = channel.noise.get(term) if value is None else value_in_si(value, unit, "--value")
        duration = channel.duration if hours is None else 3600 * hours
        if sought is None and duration is None:
            raise OptionError(f"{name} has no {term}; give --hours or --value", option="hours")
        if channel.verdict not in QUANTIFIED:
            say(f"warning: {name}: {source} has no model that fits it, so the plan is uncertain", quiet=quiet)
        if channel.ignored:
            say(f"warning: {name}: the plan ignores its {channel.ignored}", quiet=quiet)
        with working(f"planning {name}", quiet=quiet):
            plans.append(
                plan(
                    channel.noise,
                    term,
                    channel=name,
                    quantity=channel.quantity,
                    rate_unit=channel.rate_unit,
                    rate=frequency,
                    tau_min=channel.tau_min,
                    duration=duration,
                    value=None if sought is None else abs(sought),
                )
            )
    if not plans:
        if value is not None and misfits:
            value_in_si(value, misfits[-1], "--value")  # raises an error that lists the possible units
        raise OptionError(f"{source}: no channel has noise besides {term}", option="term")
    write_result("\n".join(map(repr, plans)), [plan.to_dict() for plan in plans], Path("-") if json else None)
    return 0


def _channels(source: Path) -> dict[str, _Channel]:
    if not is_result(source):
        return {name: _model_channel(name, noise) for name, noise in NoiseModel.read(source).items()}
    analysis = read_analysis(source)
    if not analysis.fits:
        require_model(analysis, source)  # raises an error with the reason
    try:
        return {name: _fit_channel(name, fit) for name, fit in analysis.fits.items()}
    except DataError as error:
        raise error.about(str(source)) from None


def _counted(noise: ChannelModel) -> tuple[ChannelModel | Mapping[str, float], str]:
    """Split a model into the part that planning uses and the names of the ignored parts."""
    ignored = {
        "sinusoid": bool(noise.sinusoid),
        "resonance": bool(noise.resonance),
        "bandwidth": noise.bandwidth is not None,
        "Gauss-Markov processes": len(noise.gauss_markov) > 1,
    }
    processes = () if ignored["Gauss-Markov processes"] else noise.gauss_markov
    counted: ChannelModel | Mapping[str, float] = {}
    if noise.terms or processes or noise.matern:
        counted = replace(noise, gauss_markov=processes, resonance=(), sinusoid=(), bandwidth=None)
    return counted, " and ".join(name for name, present in ignored.items() if present)


def _model_channel(name: str, noise: ChannelModel) -> _Channel:
    counted, ignored = _counted(noise)
    return _Channel(name, noise.quantity, noise.unit, counted, ignored=ignored)


def _fit_channel(name: str, fit: NoiseFit) -> _Channel:
    noise, ignored = _counted(fit.to_model()) if has_model(fit) else ({}, "")
    rate = 1 / fit.tau0
    return _Channel(
        name, fit.quantity, fit.rate_unit, noise, rate, fit.n / rate, fit.tau_min or 0.0, fit.verdict, ignored
    )
