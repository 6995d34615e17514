"""Options of ``sigmatau simulate`` for imperfections of a log: values with units, as `Imperfections`."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from sigmatau.cli.options import key_values
from sigmatau.errors import OptionError
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import stream_name
from sigmatau.record.streams import InputKind
from sigmatau.simulation.imperfections import Imperfections, Outage, Temperature, WarmUp
from sigmatau.units import integral

T = TypeVar("T")

_NAMES = {"lost": "gaps", "output": "input"}  # options of arguments with another name
_SUMMED = ("rad/s", "m/s^2")  # units of rates that increments and accumulated values sum

_DEGREES = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) *(°C|degC|C|K)")
_ZERO_CELSIUS = 273.15  # [K]
_DIGITS = 9  # decimals of a converted temperature, so that 300 K are 26.85 °C
_TEMPERATURE_EXAMPLE = "start=20degC,end=35degC,time=20min"


def imperfections_of(
    model: NoiseModel,
    *,
    output: InputKind,
    level: Sequence[str],
    warm_up: Sequence[str],
    temperature: Sequence[str],
    sensitivity: Sequence[str],
    saturation: Sequence[str],
    lsb: Sequence[str],
    gaps: Sequence[str],
    jitter: str | None,
) -> Imperfections:
    """The imperfections in SI; raises `OptionError` with the name of the option."""
    if sensitivity and not temperature:
        raise OptionError("--sensitivity needs --temperature", option="temperature")
    units = _units(model)
    sums = {name: unit if output == "rate" or unit not in _SUMMED else integral(unit) for name, unit in units.items()}
    lost, outages = _gaps(gaps)
    try:
        return Imperfections(
            level=_values(level, "level", "accel_z=1g", units, value_in_si),
            warm_up=_values(warm_up, "warm-up", "gyro=20deg/h:10min", units, _warm_up),
            temperature=_temperature(
                temperature, _values(sensitivity, "sensitivity", "gyro=5deg/h/K", units, _per_kelvin)
            )
            if temperature
            else None,
            saturation=_values(saturation, "saturation", "gyro=250deg/s", units, value_in_si),
            output=output,
            lsb=_values(lsb, "lsb", "gyro=0.01deg/s" if output == "rate" else "gyro=0.1arcsec", sums, value_in_si),
            lost=lost,
            outages=outages,
            jitter=0.0 if jitter is None else value_in_si(jitter, "s", "--jitter"),
        )
    except OptionError as error:
        raise OptionError(error.for_command_line(_NAMES), option=error.option) from None


def _units(model: NoiseModel) -> dict[str, str]:
    """Rate units of channels and sensors."""
    units: dict[str, str] = {}
    for name, channel in model.channels.items():
        units[name] = units[stream_name(name)] = channel.unit
    return units


def _values(
    texts: Sequence[str], option: str, example: str, units: Mapping[str, str], value: Callable[[str, str, str], T]
) -> dict[str, T]:
    """Values of NAME=VALUE by channel or sensor, converted to its unit."""
    found = {}
    for name, text in key_values(texts, option, example).items():
        if name not in units:
            raise OptionError(f"--{option}: the model has no {name!r}; it has {', '.join(units)}", option=option)
        found[name] = value(text, units[name], f"--{option} {name}")
    return found


def _warm_up(text: str, unit: str, what: str) -> WarmUp:
    amplitude, colon, time = text.partition(":")
    if not colon:
        raise OptionError(f"{what} {text!r}: must be amplitude:time, e.g. 20deg/h:10min", option="warm-up")
    return WarmUp(amplitude=value_in_si(amplitude, unit, what), time=value_in_si(time, "s", what))


def _per_kelvin(text: str, unit: str, what: str) -> float:
    rate, slash, kelvin = text.rpartition("/")
    if not slash or kelvin.strip() not in ("K", "degC", "°C", "C"):
        raise OptionError(f"{what} {text!r}: must be a rate per kelvin, e.g. 5deg/h/K", option="sensitivity")
    return value_in_si(rate, unit, what)


def _temperature(texts: Sequence[str], sensitivity: Mapping[str, float]) -> Temperature:
    given = key_values(texts, "temperature", _TEMPERATURE_EXAMPLE)
    if not {"start", "end"} <= set(given) <= {"start", "end", "time", "swing", "resolution"}:
        raise OptionError(
            f"--temperature {','.join(texts)}: must have start and end, and optionally time, swing and resolution, e.g."
            f" {_TEMPERATURE_EXAMPLE},swing=3K,resolution=0.0625K",
            option="temperature",
        )
    degrees = {}
    for name, text in given.items():
        if name == "time":
            continue
        match = _DEGREES.fullmatch(text)
        difference = name in ("swing", "resolution")
        if match is None:
            example = "3K" if difference else "20degC or 293.15K"
            raise OptionError(f"--temperature {name}={text}: must be degrees, e.g. {example}", option="temperature")
        degrees[name] = float(match[1])
        if match[2] == "K" and not difference:
            degrees[name] = round(degrees[name] - _ZERO_CELSIUS, _DIGITS)
    time = {"time": value_in_si(given["time"], "s", "--temperature time")} if "time" in given else {}
    return Temperature(**degrees, **time, sensitivity=sensitivity)


def _gaps(texts: Sequence[str]) -> tuple[float, tuple[Outage, ...]]:
    """``["0.1%", "600s:2s"]``: the random share of lost rows, and outages."""
    lost, outages = 0.0, []
    for part in (part.strip() for text in texts for part in text.split(",")):
        start, colon, length = part.partition(":")
        if colon:
            times = [value_in_si(text, "s", f"--gaps {part}") for text in (start, length)]
            outages.append(Outage(start=times[0], length=times[1]))
            continue
        try:
            if not part.endswith("%") or lost:
                raise ValueError
            lost = float(part[:-1]) / 100
        except ValueError:
            raise OptionError(
                f"--gaps {part}: must be a share of the rows, given once, and outages as start:length, e.g. 0.1%,600s:2s",
                option="gaps",
            ) from None
    return lost, tuple(outages)
