"""Options of an export that no record can determine, and the errors for missing or unsupported ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field, replace
from typing import Any, Literal, get_args

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.model.processes import LARGEST, SMALLEST, real
from sigmatau.model.unobserved import Unobserved
from sigmatau.noise.terms import coefficient_unit
from sigmatau.options import declared, option, with_attributes
from sigmatau.record.streams import RATES

Axes = Literal["worst", "mean", "each"]
Criterion = Literal["horizon", "bias"]

KINDS = {"gyro": "gyros", "accel": "accelerometers"}

_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}
# Numbers outside these ranges are typing errors; their squares and products would overflow.
RANGES = {
    "horizon": (1e-9, 1e12, " s"),
    "noise_factor": (1e-6, 1e6, ""),
    "walk_factor": (1e-6, 1e6, ""),
    "filter_rate": (*RATES, " Hz"),
    "step": (1 / RATES[1], 1 / RATES[0], " s"),
}

_TERMS = {"walk": "rate_random_walk", "noise": "random_walk"}
_OPTIONS = {**_TERMS, "names": "name"}


@frozen
class Unplaced:
    """A choice that a target does not use.

    Attributes
    ----------
    choice : str
        The attribute of `Choices`.
    key : str or None
        Key, if the choice is ``names``.
    why : str
        Message of the error.
    """

    choice: str
    key: str | None = None
    why: str

    @property
    def option(self) -> str:
        """Option that the `OptionError` names."""
        return _OPTIONS.get(self.choice, self.choice)

    def error(self) -> OptionError:
        """Build the error for this choice."""
        return OptionError(self.why, option=self.option)


def not_of_a_log(rate: float) -> OptionError:
    """Build the error for a sampling rate of a log, given where only the rate of the filter applies."""
    return OptionError(
        f"{{option}} is the sampling rate of a log; the rate of the filter is {Hint('filter_rate', value=rate)}",
        option="rate",
    )


@with_attributes
@dataclass(frozen=True, slots=True, kw_only=True)  # `frozen` has no arguments that are not fields
class Choices:
    """Options of an export that no record can determine.

    Raises
    ------
    OptionError
        For an invalid value; the error names the attribute.

    See Also
    --------
    export : takes them.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> chosen = st.Choices(filter_rate=200, walk={"gyro": 1e-6})
    >>> chosen.filter_rate, chosen.axes
    (200, 'worst')
    """

    axes: Axes = field(
        default="worst",
        metadata=option(
            "Export",
            "How to combine three axes: worst (the largest), mean (root mean square), or each, for targets with a field per"
            " axis.",
            choices=get_args(Axes),
        ),
    )
    walk: Mapping[str, str | float] = field(
        default_factory=dict,
        metadata=option(
            "Export",
            "Rate random walk to write for a filter with N and K.",
            "Default: consistent.",
            form="pairs",
            choices=("upper-limit", "consistent", "horizon", "observed"),
            kind="mapping of str to (str or float)",
            example="gyro=upper-limit",
            python='By sensor, ``"gyro"`` and ``"accel"``. ``"consistent"``: a filter with this value states its error'
            ' after `horizon` correctly, for any slow noise of the model. ``"horizon"`` matches the Allan variance of'
            ' the model at `horizon`. ``"observed"`` is the walk of the model. ``"upper-limit"``, a number in SI, or a text'
            ' with a unit, ``"1e-6 rad/s^2/sqrt(Hz)"``, is for axes without an observed walk.',
            typed=f"Values: gyro=consistent, with which a filter states its error after {Hint('horizon')} correctly;"
            " gyro=horizon, which matches the Allan variance of the model there; gyro=observed, the walk of the model; for"
            ' axes without an observed walk gyro=upper-limit or gyro="1e-6 rad/s/sqrt(s)".',
        ),
    )
    noise: Mapping[str, str | float] = field(
        default_factory=dict,
        metadata=option(
            "Export",
            "Random walk to write if none was observed, for example because quantization hides it.",
            "Default: upper-limit.",
            form="pairs",
            choices=("upper-limit",),
            kind="mapping of str to (str or float)",
            example="gyro=upper-limit",
            python='By sensor: ``"upper-limit"``, a number in SI, or a text with a unit.',
            typed="Values: accel=upper-limit, or a value with unit.",
        ),
    )
    horizon: float | None = field(
        default=None,
        metadata=option(
            "Export",
            "Time after which a filter states its error right; averaging time for gyro=horizon and Gauss-Markov biases.",
            "Default of a filter with N and K: 60 s.",
            form="time",
            unit="s",
            kind="float or None",
            typed="Example: 10s (ms, s, min, h, d). Required with gyro=horizon.",
        ),
    )
    consistent: Criterion = field(
        default="horizon",
        metadata=option(
            "Export",
            "Which error a filter with N and K states correctly: that after the horizon, or that of its bias.",
            choices=get_args(Criterion),
        ),
    )
    unobserved: Unobserved = field(
        default="mean",
        metadata=option(
            "Export",
            "Terms that were not observed, for a consistent walk and a state space: at their upper limits, with the mean"
            " variance up to there (1/sqrt(3) of the limit), or absent.",
            choices=get_args(Unobserved),
        ),
    )
    noise_factor: float | Mapping[str, float] = field(
        default=1.0,
        metadata=option(
            "Export",
            "Factor on the random walk; the file states estimate and factor.",
            form="factors",
            kind="float or mapping of str to float",
            example="gyro=3,accel=10",
            python='A mapping is by sensor, ``"gyro"`` and ``"accel"``.',
            typed="By sensor: gyro=3,accel=10.",
        ),
    )
    walk_factor: float | Mapping[str, float] = field(
        default=1.0,
        metadata=option(
            "Export",
            "Factor on slow noise: rate random walk, bias instability and Gauss-Markov processes.",
            form="factors",
            kind="float or mapping of str to float",
            example="gyro=3,accel=10",
            python="A mapping is by sensor.",
            typed="By sensor: gyro=3.",
        ),
    )
    filter_rate: float | None = field(
        default=None,
        metadata=option(
            "Export",
            "Rate at which the other program takes samples.",
            "Default: the sampling rate of the record.",
            form="number",
            unit="Hz",
            kind="float or None",
            typed="In Hz.",
        ),
    )
    step: float | None = field(
        default=None,
        metadata=option(
            "Export",
            "Step of the filter: px4 (default 10 ms), ardupilot (default 12.5 ms), state-space (default 1/rate).",
            form="seconds",
            unit="s",
            kind="float or None",
            typed="In seconds or with a unit, 5ms.",
        ),
    )
    names: Mapping[str, str] = field(
        default_factory=dict,
        metadata=option(
            "Export",
            "Other fields of a target, such as a topic.",
            form="pairs",
            kind="mapping of str to str",
            example="topic=/imu0",
            typed="Examples: topic=/imu0, gravity=9.81.",
        ),
    )
    strict: bool = field(
        default=False,
        metadata=option(
            "Export",
            "Refuse a coefficient that was not observed or stated on every axis, instead of writing its upper limit or a"
            " matched value.",
            form="flag",
            kind="bool",
        ),
    )
    rate: InitVar[float | None] = None

    def __post_init__(self, rate: float | None) -> None:
        if rate is not None:
            raise not_of_a_log(rate)
        if self.axes not in get_args(Axes):
            raise OptionError(f"{{option}} must be 'worst', 'mean' or 'each', not {self.axes!r}", option="axes")
        for name, values in (("consistent", get_args(Criterion)), ("unobserved", get_args(Unobserved))):
            if getattr(self, name) not in values:
                listed = " or ".join(map(repr, values))
                raise OptionError(f"{{option}} must be {listed}, not {getattr(self, name)!r}", option=name)
        for name in ("horizon", "noise_factor", "walk_factor", "filter_rate", "step"):
            value = getattr(self, name)
            low, high, unit = RANGES[name]
            absent = value is None and not name.endswith("factor")
            by_sensor = name.endswith("factor") and isinstance(value, Mapping)
            for sensor in value if by_sensor else ():
                if sensor not in KINDS:
                    raise OptionError(f"{Hint(name)}: unknown sensor {sensor!r}; sensors: gyro, accel", option=name)
            for each in value.values() if by_sensor else [value]:
                if not absent and not _between(each, low, high):
                    raise OptionError(
                        f"{Hint(name)} must be a positive number, from {low:g} to {high:g}{unit}, not {each!r}",
                        option=name,
                    )
        for name in ("walk", "noise"):
            object.__setattr__(self, name, _in_si(name, getattr(self, name), declared(Choices)[name].choices))
        if not isinstance(self.names, Mapping) or not all(
            isinstance(text, str) for pair in self.names.items() for text in pair
        ):
            raise OptionError(
                f'{Hint("names")} must be a mapping of texts, e.g. {{"topic": "/imu0"}}, not {self.names!r}',
                option="name",
            )
        if "horizon" in self.walk.values() and self.horizon is None:
            raise OptionError(
                f"a random walk that matches the Allan variance at a horizon needs {{option}} in s, e.g."
                f" {Hint('horizon', value=10)}",
                option="horizon",
            )

    def without(self, choice: str, key: str | None = None) -> Choices:
        """Reset one choice to its default.

        Parameters
        ----------
        choice : str
            Name of the attribute.
        key : str, optional
            One of the `names`, if `choice` is ``"names"``. Default: all.

        Returns
        -------
        Choices
        """
        default: Any = getattr(Choices(), choice)
        if choice == "names" and key is not None:
            default = {name: text for name, text in self.names.items() if name != key}
        return replace(self, **{choice: default})


def _between(value: object, low: float, high: float) -> bool:
    """Whether the value is a number in a range; accepts NumPy scalars."""
    return low <= real(value) <= high


def _in_si(name: str, chosen: object, words: tuple[str, ...]) -> dict[str, str | float]:
    """Convert choices by sensor from text to SI. Raises `OptionError`."""
    from sigmatau.model.file import value_in_si

    spelled = _TERMS[name]
    if not isinstance(chosen, Mapping):
        raise OptionError(
            f"{Hint(name)} must be a mapping by sensor, e.g. {Hint(name, 'gyro', words[0])}, not {chosen!r}",
            option=spelled,
        )
    converted: dict[str, str | float] = {}
    for sensor, wanted in chosen.items():
        if sensor not in KINDS:
            raise OptionError(f"{Hint(name)}: unknown sensor {sensor!r}; sensors: gyro, accel", option=spelled)
        value = wanted
        if isinstance(wanted, str) and wanted not in words:
            unit = coefficient_unit(spelled, *_QUANTITIES[sensor])
            try:
                value = value_in_si(wanted, unit, f"{Hint(name)} of {sensor}")
            except OptionError as error:
                hints = ", ".join(f"{Hint(name, sensor, word)}" for word in words)
                raise OptionError(f"{error.message}; or {hints}", option=spelled) from None
        if not isinstance(value, str) and not _between(value, SMALLEST, LARGEST):
            raise OptionError(
                f"{Hint(name)} of {sensor} must be positive, from {SMALLEST:g} to {LARGEST:g} in SI, not {wanted!r}",
                option=spelled,
            )
        converted[sensor] = value
    return converted
