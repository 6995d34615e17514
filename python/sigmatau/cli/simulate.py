"""``sigmatau simulate``: a log from a noise model, with imperfections given as values with units."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from cyclopts import Parameter

from sigmatau.analysis.inputs import read_model
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.options import check_output, say, working
from sigmatau.errors import OptionError
from sigmatau.io.write import RECORD_ENDINGS
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.unobserved import Unobserved
from sigmatau.record.record import stream_name
from sigmatau.record.streams import InputKind
from sigmatau.simulation.imperfections import Imperfections, Outage, Temperature, WarmUp
from sigmatau.simulation.to_file import simulate_to
from sigmatau.typed.pairs import key_values
from sigmatau.units import integral

_Values = Annotated[list[str] | None, Parameter(negative=())]


def simulate_command(
    model: Path,
    /,
    *,
    hours: float,
    rate: float,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    seed: int = 0,
    input: Literal["rate", "increments", "accumulated"] = "rate",  # noqa: A002  the option of `analyze`
    level: _Values = None,
    warm_up: _Values = None,
    temperature: _Values = None,
    sensitivity: _Values = None,
    saturation: _Values = None,
    lsb: _Values = None,
    gaps: _Values = None,
    jitter: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    flicker: Literal["poles", "exact"] = "poles",
    unobserved: Unobserved = "absent",
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Simulate a sensor at rest from its noise model, and write the log.

    Parameters
    ----------
    model
        A model file (.toml): tables [channels.gyro_x] with values and units, random_walk = "0.3 deg/sqrt(h)".
    hours
        Length of the record in hours. The record may be larger than the memory.
    rate
        Sampling rate in Hz.
    output
        The log to write: .csv, .csv.gz, .npy, .npz or .parquet; time and channels in SI. Or a log of ROS, an IMU of
        three axes on the topic /imu: .bag (ROS 1), .mcap or .db3 (ROS 2).
    seed
        The same seed gives the same log.
    input
        Content of the columns: rates, increments per sample, or accumulated angle and velocity. Readers of the log need the
        same --input. Increments and accumulated values are for gyros and accelerometers only.
    level
        Constant level by channel or sensor: accel_z=1g. Default: 0.
    warm_up
        Exponential warm-up, amplitude:time constant: gyro=20deg/h:10min. Default: none.
    temperature
        Temperature of the sensor, written as a column: start=20degC,end=35degC,time=20min (or start=293.15K). Optional:
        swing=3K for a daily cycle, resolution=0.0625K for the thermometer. Default: no thermometer.
    sensitivity
        Sensitivity to temperature: gyro=5deg/h/K. Default: 0.
    saturation
        Largest rate of the output: gyro=250deg/s. Default: no limit.
    lsb
        Resolution: gyro=0.01deg/s. For increments and accumulated values: resolution of the sum, gyro=0.1arcsec.
        Default: not rounded.
    gaps
        Missing rows: a random share, 0.1%, and outages as start:length, 600s:2s. Default: none.
    jitter
        Standard deviation of the time stamps: 20us. Default: 0.
    flicker
        Generator of bias instability: poles (error of the Allan deviation 0.002 %), or exact (record held in memory).
    unobserved
        Terms that the record of a result did not show: absent, with the mean variance up to their upper limit, or at the
        limit.
    quiet
        Print only errors on standard error.
    """
    check_output(output, RECORD_ENDINGS, "output")
    if output.exists() and model.exists() and output.samefile(model):
        raise OptionError(f"--output {output} is the model itself; name another file", option="output")
    check_model(model)
    noise = read_model(model)
    imperfections = parse_imperfections(
        noise,
        output=input,
        level=level or (),
        warm_up=warm_up or (),
        temperature=temperature or (),
        sensitivity=sensitivity or (),
        saturation=saturation or (),
        lsb=lsb or (),
        gaps=gaps or (),
        jitter=jitter,
    )
    with working(f"simulating {hours:g} h into {output}", quiet=quiet) as done:
        made = simulate_to(
            output,
            noise,
            duration=hours * 3600,
            rate=rate,
            rng=seed,
            imperfections=imperfections,
            flicker=flicker,
            unobserved=unobserved,
            progress=done,
        )
    lost = f", {made.lost} rows lost" if made.lost else ""
    count = len(made.channels)
    channels = "1 channel" if count == 1 else f"{count} channels"
    say(f"{output}: {made.samples} samples of {channels}{lost}, seed {seed}", quiet=quiet)
    for text in made.unobserved:
        say(f"info: {text}", quiet=quiet)
    return 0


T = TypeVar("T")

_NAMES = {"lost": "gaps", "output": "input"}  # options of arguments with another name
_SUMMED = ("rad/s", "m/s^2")  # units of rates, for sums (increments and accumulated values)

_DEGREES = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?) *(°C|degC|C|K)")
_ZERO_CELSIUS = 273.15  # [K]
_DIGITS = 9  # decimals of a converted temperature, so that 300 K is 26.85 °C
_TEMPERATURE_EXAMPLE = "start=20degC,end=35degC,time=20min"


def parse_imperfections(
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
    """Parse the imperfections to SI. Raises `OptionError` with the name of the option."""
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
        raise error.named(_NAMES.get(str(error.option), str(error.option)), error.key) from None


def _units(model: NoiseModel) -> dict[str, str]:
    """Rate units of channels and sensors, by name."""
    units: dict[str, str] = {}
    for name, channel in model.channels.items():
        units[name] = units[stream_name(name)] = channel.unit
    return units


def _values(
    texts: Sequence[str], option: str, example: str, units: Mapping[str, str], value: Callable[[str, str, str], T]
) -> dict[str, T]:
    """Parse values of NAME=VALUE by channel or sensor, converted to its unit."""
    values = {}
    for name, text in key_values(texts, option, example).items():
        if name not in units:
            raise OptionError(f"--{option}: the model has no {name!r}; it has {', '.join(units)}", option=option)
        values[name] = value(text, units[name], f"--{option} {name}")
    return values


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
    texts_by_name = key_values(texts, "temperature", _TEMPERATURE_EXAMPLE)
    if not {"start", "end"} <= set(texts_by_name) <= {"start", "end", "time", "swing", "resolution"}:
        raise OptionError(
            f"--temperature {','.join(texts)}: must have start and end, and optionally time, swing and resolution, e.g."
            f" {_TEMPERATURE_EXAMPLE},swing=3K,resolution=0.0625K",
            option="temperature",
        )
    degrees = {}
    for name, text in texts_by_name.items():
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
    time = {"time": value_in_si(texts_by_name["time"], "s", "--temperature time")} if "time" in texts_by_name else {}
    return Temperature(**degrees, **time, sensitivity=sensitivity)


def _gaps(texts: Sequence[str]) -> tuple[float, tuple[Outage, ...]]:
    """Parse ``["0.1%", "600s:2s"]``: the random share of lost rows, and outages."""
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
