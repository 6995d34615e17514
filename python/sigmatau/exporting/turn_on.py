"""Turn-on bias of a sensor, for targets that have a field for the uncertainty of the initial bias.

It is the spread between power-ups in the model, or the value of the user. A single record at rest does not show it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from sigmatau.errors import DataError
from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.source import Source
from sigmatau.exporting.text import number
from sigmatau.exporting.values import Number, Numbers
from sigmatau.findings.exporting import WideTurnOn
from sigmatau.findings.finding import Finding
from sigmatau.hints import Hint, command
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.turn_on import is_wide

_SMALLEST = 1e-9  # Smallest turn-on bias that the user can give [rad/s or m/s²]
TURN_ON_NAMES = {"gyro_turn_on_bias": "", "accel_turn_on_bias": ""}
"""Names of a target with a field for the turn-on bias; their values, given by the user, are in rad/s or m/s²."""


def turn_on_key(sensor: str) -> str:
    """Key of the turn-on bias among the names of a target."""
    return f"{sensor}_turn_on_bias"


def turn_on(numbers: Numbers, sensor: str, *, minimum: float = _SMALLEST) -> Number | None:
    """Standard deviation of the bias at turn-on for all axes of a sensor; None if it is not known. [rad/s or m/s²]

    `minimum`: smallest value that the user can give, because a filter with 0 would treat its first bias as exact.
    """
    axes = _collect_spreads(numbers, sensor, minimum)
    if axes is None or isinstance(axes, Number):
        return axes
    if numbers.choices.axes == "mean":
        mean = (sum(axis.value**2 for axis in axes.values()) / len(axes)) ** 0.5
        return Number(value=mean, words=f"root mean square: {'; '.join(axis.words for axis in axes.values())}")
    return _worst(axes, numbers.sensors[sensor])


def turn_on_axes(numbers: Numbers, sensor: str, *, minimum: float = _SMALLEST) -> tuple[Number, Number, Number] | None:
    """Standard deviations of the bias at turn-on for x, y and z. For ``axes="each"``, an axis without a known spread gets
    the largest of the others.
    """
    axes = _collect_spreads(numbers, sensor, minimum)
    if axes is None or isinstance(axes, Number) or numbers.choices.axes != "each":
        every = turn_on(numbers, sensor, minimum=minimum)
        return None if every is None else (every, every, every)
    worst = _worst(axes, numbers.sensors[sensor])
    x, y, z = (axes.get(f"{sensor}_{axis}", worst) for axis in "xyz")
    return x, y, z


def unknown_turn_on(sensor: str) -> str:
    """Remark of a file on an unknown turn-on bias."""
    return (
        f"turn-on bias of the {KINDS[sensor]}: not visible in one record; sigmatau compare measures it from several"
        f" power-ups, {Hint('names', turn_on_key(sensor), 'VALUE')} sets it"
    )


def _collect_spreads(numbers: Numbers, sensor: str, minimum: float) -> Number | dict[str, Number] | None:
    """Number given by the user, or the numbers of the channels with a spread."""
    key = turn_on_key(sensor)
    if key in numbers.choices.names:
        return Number(value=number(numbers.choices.names[key], key, low=minimum), words="turn-on bias, given")
    numbers_by_channel = {}
    for name, model in numbers.sensors.get(sensor, {}).items():
        spread = model.turn_on
        if spread is None:
            continue
        words = f"{name}: turn-on bias {spread.text(model.quantity, model.unit)}, about its mean"
        if not spread.sigma:
            words += "; no spread observed, the upper end"
        numbers_by_channel[name] = Number(value=spread.prior, words=words)
    _add_wide(numbers, {name: numbers.sensors[sensor][name] for name in numbers_by_channel})
    return numbers_by_channel or None


def _add_wide(numbers: Numbers, channels: Mapping[str, ChannelModel]) -> None:
    """Add a finding if the spread of any channel is from few power-ups."""
    wide = {name: model.turn_on for name, model in channels.items() if model.turn_on and is_wide(model.turn_on)}
    ratios = [spread.high / spread.sigma for spread in wide.values() if spread.high and spread.sigma]
    counts = [spread.power_ups for spread in wide.values() if spread.power_ups is not None]
    if counts:
        details = WideTurnOn(power_ups=min(counts), ratio=max(ratios, default=None))
        numbers.add_finding(Finding(severity="warning", channels=tuple(wide), details=details))


def _worst(axes: Mapping[str, Number], channels: Mapping[str, ChannelModel]) -> Number:
    """Largest of the axes; the comment names axes without a number."""
    worst = max(axes.values(), key=lambda axis: axis.value)
    lacking = [name for name in channels if name not in axes]
    words = f"worst of {len(axes)} axes, {worst.words}" if len(axes) > 1 else worst.words
    return replace(worst, words=words + (f"; not measured for {', '.join(lacking)}" if lacking else ""))


def with_turn_on(source: Source, path: Path) -> Source:
    """Add the turn-on biases of a model file to a source. Raises `DataError` if the file has none of the channels."""
    channels = NoiseModel.read(path).channels
    spreads = {name: channel.turn_on for name, channel in channels.items() if channel.turn_on is not None}
    shared = {name: spread for name, spread in spreads.items() if name in source.model.channels}
    if not shared:
        listed = ", ".join(spreads) or "none"
        writes = command("compare", "RESULTS", Hint("model", value="FILE"))
        raise DataError(f"{path}: no turn_on of a channel of the source (it has: {listed}); {writes} writes it")
    return replace(source, model=source.model.with_turn_on(shared))
