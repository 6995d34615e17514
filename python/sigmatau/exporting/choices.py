"""What the user decides, because no record does, and the errors that say what there is to decide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from sigmatau.errors import OptionError, argument
from sigmatau.model.file import value_in_si
from sigmatau.model.processes import LARGEST, RATES, SMALLEST, real
from sigmatau.noise.terms import coefficient_unit

__all__ = ["KINDS", "RANGES", "Axes", "Choices", "NoPlaceError", "NotChosenError", "given"]

Axes = Literal["worst", "mean", "each"]

KINDS = {"gyro": "gyros", "accel": "accelerometers"}

_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}
# Beyond these a number is a slip of the keyboard, and its squares and products leave the range of what is written.
RANGES = {
    "horizon": (1e-9, 1e12, " s"),
    "noise_factor": (1e-6, 1e6, ""),
    "walk_factor": (1e-6, 1e6, ""),
    "rate": (*RATES, " Hz"),
    "step": (1 / RATES[1], 1 / RATES[0], " s"),
}

_TERMS = {"walk": "rate_random_walk", "noise": "random_walk"}
_OPTIONS = {**_TERMS, "names": "name"}


class NoPlaceError(OptionError):
    """A choice that was made and has no place in a target.

    Attributes
    ----------
    choice : str
        The attribute of `Choices`.
    key : str or None
        Of ``names``, which of them.
    """

    def __init__(self, message: str, *, choice: str, key: str | None = None) -> None:
        super().__init__(message, option=_OPTIONS.get(choice, choice))
        self.choice = choice
        self.key = key


class NotChosenError(OptionError):
    """A number that was not observed, and in whose place nothing was chosen.

    Attributes
    ----------
    sensor : str
        ``"gyro"`` or ``"accel"``.
    choice : str
        The attribute of `Choices`, ``"walk"`` or ``"noise"``.
    """

    def __init__(self, message: str, *, sensor: str, choice: str) -> None:
        super().__init__(message, option=_TERMS[choice])
        self.sensor = sensor
        self.choice = choice


def given(choice: str, value: object, sensor: str | None = None) -> str:
    """A placeholder for a choice in the message of an `OptionError`, as it is written in Python or on the command line."""
    return argument(choice, value, key=sensor)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """What the user decides, because no record does.

    Attributes
    ----------
    axes : {"worst", "mean", "each"}
        Of three axes the largest number, the root of the mean of the squares, or each where a target has a place for it.
    walk : mapping of str to (str or float)
        By sensor, ``"gyro"`` and ``"accel"``, what to write where no rate random walk was observed: ``"upper-limit"``, or
        a value, a number in SI or a text with its unit, ``"1e-6 rad/s^2/sqrt(Hz)"``. ``"horizon"`` matches the model's
        Allan variance at `horizon`, observed or not. Default: what was observed, or an error that says what there is to
        choose from.
    noise : mapping of str to (str or float)
        By sensor, what to write where no random walk was observed, as where quantization covers it: ``"upper-limit"``, or a
        value, a number in SI or a text with its unit.
    horizon : float or None
        Averaging time at which ``"horizon"`` matches. [s]
    noise_factor, walk_factor : float
        By which what is written is larger than what was found: of the random walk, and of slow noise, whichever of rate
        random walk, bias instability and Gauss-Markov process a target has a place for.
    rate : float or None
        Sampling rate of the sensor. Default: that of the record, where the model is of one. [Hz]
    step : float or None
        Step of the filter, where it has one of its own. [s]
    names : mapping of str to str
        Names and constants that a target has beside the numbers, such as a topic.

    Raises
    ------
    OptionError
        For a value that cannot be; it names the attribute.
    """

    axes: Axes = "worst"
    walk: Mapping[str, str | float] = field(default_factory=dict)
    noise: Mapping[str, str | float] = field(default_factory=dict)
    horizon: float | None = None
    noise_factor: float = 1.0
    walk_factor: float = 1.0
    rate: float | None = None
    step: float | None = None
    names: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.axes not in ("worst", "mean", "each"):
            raise OptionError(f"{{option}} must be 'worst', 'mean' or 'each', not {self.axes!r}", option="axes")
        for name in ("horizon", "noise_factor", "walk_factor", "rate", "step"):
            value = getattr(self, name)
            low, high, unit = RANGES[name]
            absent = value is None and not name.endswith("factor")
            if not absent and not _between(value, low, high):
                raise OptionError(
                    f"{{@{name}}} must be a positive number, from {low:g} to {high:g}{unit}, not {value!r}", option=name
                )
        object.__setattr__(self, "walk", _in_si("walk", self.walk, ("upper-limit", "horizon")))
        object.__setattr__(self, "noise", _in_si("noise", self.noise, ("upper-limit",)))
        if not isinstance(self.names, Mapping) or not all(
            isinstance(text, str) for pair in self.names.items() for text in pair
        ):
            raise OptionError(
                f'{{@names}} must be a mapping of texts, e.g. {{"topic": "/imu0"}}, not {self.names!r}', option="name"
            )
        if "horizon" in self.walk.values() and self.horizon is None:
            raise OptionError(
                f"a walk that matches the Allan variance at a horizon needs {{option}}: give e.g. {given('horizon', 10)},"
                " in s",
                option="horizon",
            )

    def without(self, choice: str, key: str | None = None) -> Choices:
        """The same with one choice as if it had not been made; `key` is one of the names."""
        default: Any = getattr(Choices(), choice)
        if choice == "names" and key is not None:
            default = {name: text for name, text in self.names.items() if name != key}
        return replace(self, **{choice: default})


def _between(value: object, low: float, high: float) -> bool:
    """Whether it is a number within a range; NumPy's numbers too."""
    return low <= real(value) <= high


def _in_si(name: str, chosen: object, words: tuple[str, ...]) -> dict[str, str | float]:
    """What was chosen by sensor, texts with a unit in SI; raises `OptionError`."""
    option = _TERMS[name]
    if not isinstance(chosen, Mapping):
        raise OptionError(
            f"{{@{name}}} must be a mapping by sensor, e.g. {given(name, words[0], 'gyro')}, not {chosen!r}",
            option=option,
        )
    found: dict[str, str | float] = {}
    for sensor, wanted in chosen.items():
        if sensor not in KINDS:
            raise OptionError(f"{{@{name}}}: {sensor!r} is no sensor; there are gyro and accel", option=option)
        value = wanted
        if isinstance(wanted, str) and wanted not in words:
            unit = coefficient_unit(option, *_QUANTITIES[sensor])
            try:
                value = value_in_si(wanted, unit, f"{argument(name)} of {sensor}")
            except OptionError as error:
                others = ", ".join(given(name, word, sensor) for word in words)
                raise OptionError(f"{error.message}; or {others}", option=option) from None
        if not isinstance(value, str) and not _between(value, SMALLEST, LARGEST):
            raise OptionError(
                f"{{@{name}}} of {sensor} must be positive, from {SMALLEST:g} to {LARGEST:g} in SI, not {wanted!r}",
                option=option,
            )
        found[sensor] = value
    return found
