"""The options of reading, checked before the file is opened."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeGuard

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.record.streams import InputKind, check_kind, check_rates
from sigmatau.results import plain


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Checked options, see `sigmatau.io.read.read`."""

    rate: float | None  # Of all sensors without one of their own. [Hz]
    unit: Mapping[str, str]
    channels: Mapping[str, str | int]
    input: InputKind
    scale: Mapping[str, float]
    offset: Mapping[str, float]
    topic: tuple[str, ...] = ()
    rates: Mapping[str, float] = field(default_factory=dict)  # By sensor. [Hz]
    sensors: tuple[
        str, ...
    ] = ()  # The gyro or the accelerometer alone of a topic with the fields of both; all if empty
    interleaved: int | None = None  # Sensors whose rows take turns; None if the samples are to tell

    @property
    def states_rate(self) -> bool:
        """Whether a sampling rate is given, for all sensors or for some."""
        return self.rate is not None or bool(self.rates)

    def rate_of(self, stream: str) -> float | None:
        """The given sampling rate of a stream. [Hz]"""
        return self.rates.get(stream, self.rate)

    def of_streams(self, streams: Sequence[str]) -> Options:
        """The options of streams in the same rows, which have one rate; raises `OptionError` if several are given."""
        if not self.rates:
            return self
        rates = {stream: self.rates[stream] for stream in streams if stream in self.rates}
        if len(set(rates.values())) > 1:
            listed = " and ".join(rates)
            raise OptionError(
                f"{listed} are in the same rows, which have one rate; give {{option}} as one number", option="rate"
            )
        return replace(self, rate=next(iter(rates.values()), self.rate), rates={})

    @classmethod
    def check(
        cls,
        *,
        rate: object = None,
        unit: object = None,
        channels: object = None,
        input: object = "rate",  # noqa: A002  as in `read`
        scale: object = None,
        offset: object = None,
        topic: object = None,
        interleaved: object = None,
    ) -> Options:
        """Options of the right types and values; raises `OptionError`."""
        of_all, rates = check_rates(rate)
        return cls(
            rate=of_all,
            rates=rates,
            unit={c: _spelled(c, v) for c, v in _mapping("unit", unit).items()},
            channels={c: _column(c, v) for c, v in _mapping("channels", channels).items()},
            input=check_kind(input),
            scale={c: _factor("scale", c, v) for c, v in _mapping("scale", scale).items()},
            offset={c: _factor("offset", c, v) for c, v in _mapping("offset", offset).items()},
            topic=_topics(topic),
            interleaved=_sensors_in_turn(interleaved),
        )


def check_skip(skip: object) -> int:
    """The number of lines to skip; raises `OptionError`."""
    if not isinstance(skip, int | np.integer) or isinstance(skip, bool) or skip < 0:
        raise OptionError(f"{{option}} must be a number of lines, 0 or more, not {skip!r}", option="skip")
    return int(skip)


def stated_options(**options: object) -> dict[str, object]:
    """Arguments of `sigmatau.read` that are not the default and matter for the numbers, as plain values."""
    chosen = {name: value for name, value in options.items() if value and name in _MATTER}
    return plain(None, **{name: value for name, value in chosen.items() if (name, value) != ("input", "rate")})


_MATTER = ("rate", "unit", "channels", "input", "scale", "offset", "topic", "layout", "skip", "interleaved")
_MAX_IN_TURN = 16  # sensors whose rows take turns: as many as instances in a column
_EXAMPLES = {
    "unit": '{"gyro": "deg/s"}',
    "channels": '{"gyro_x": 2}',
    "scale": '{"gyro": 0.01}',
    "offset": '{"gyro": 512}',
}


def _topics(value: object) -> tuple[str, ...]:
    named = (value,) if isinstance(value, str) else () if value is None else value
    if not isinstance(named, Sequence) or not all(isinstance(name, str) for name in named):
        raise OptionError(f"{{option}} must be a name, or several, not {value!r}", option="topic")
    return tuple(named)


def _sensors_in_turn(value: object) -> int | None:
    if value is None:
        return None
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or not 1 <= value <= _MAX_IN_TURN:
        raise OptionError(
            f"{{option}} must be a number of sensors, 1 to {_MAX_IN_TURN}, not {value!r}", option="interleaved"
        )
    return int(value)


def _mapping(name: str, value: object) -> Mapping[str, object]:
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise OptionError(f"{{option}} must be a mapping of names, e.g. {_EXAMPLES[name]}, not {value!r}", option=name)
    return value


def _spelled(channel: str, value: object) -> str:
    if not isinstance(value, str) or not value.strip():
        raise OptionError(f"the unit of {channel} must be a word, not {value!r}", option="unit")
    return value


def _column(channel: str, value: object) -> str | int:
    if isinstance(value, str | int | np.integer) and not isinstance(value, bool):
        return value if isinstance(value, str) else int(value)
    raise OptionError(f"the column of {channel} must be a name or a number, not {value!r}", option="channels")


def _factor(name: str, channel: str, value: object) -> float:
    if not _is_number(value) or (name == "scale" and value == 0):
        but = " but 0" if name == "scale" else ""
        raise OptionError(f"the {name} of {channel} must be a finite number{but}, not {value!r}", option=name)
    return float(value)


def _is_number(value: object) -> TypeGuard[float]:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
