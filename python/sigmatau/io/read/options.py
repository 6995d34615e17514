"""The options of reading: declared, and checked before the file is opened."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import TypeGuard, get_args

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.options import option
from sigmatau.record.streams import InputKind, check_kind, check_rates


@frozen
class TableOptions:
    """Options of reading columns, from a file or from a data frame."""

    rate: float | Mapping[str, float] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Sampling rate in Hz, if the log has no time stamps or they are wrong.",
            "Default: computed from the time stamps. A rate that differs by more than 10 % from theirs also"
            " needs time=none in channels.",
            form="rates",
            unit="Hz",
            kind="float or mapping of str to float, optional",
            python='By sensor if several topics or kinds of rows have different rates, ``{"gyro": 400, "accel": 200}``.',
            typed="100 for all sensors, gyro=400,accel=200 for each; for several logs 10 50 in order, or day1.csv=10.",
            main=True,
        ),
    )
    unit: Mapping[str, str] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Unit of a channel, of a sensor or of the time, which overrules that of the log.",
            "Required if the log does not state it.",
            form="pairs",
            kind="mapping of str to str, optional",
            example="gyro=deg/s",
            python='By channel (``"gyro_x"``), by sensor (``"gyro"``, ``"accel"``), or ``"time"``. A signal may have any'
            ' unit, ``"1"`` for none.',
            typed="Examples: gyro=deg/s, accel_x=g, time=ns.",
            main=True,
        ),
    )
    channels: Mapping[str, str | int] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Columns of the channels, by name or number from 1.",
            "Names that do not begin with gyro or accel are further signals. Default: columns that are recognised by their"
            " names.",
            form="pairs",
            kind="mapping of str to str or int, optional",
            example="gyro_x=wx",
            python='Example: ``{"time": "stamp", "gyro_x": 2, "accel": "5:7", "phase": "x"}``. Then only these are read, and'
            ' the time column if it is recognised. With ``"time"`` alone the sensors are recognised by name, and'
            ' ``{"time": "none"}`` ignores the time stamps.',
            typed="Examples: gyro_x=wx, time=1, gyro=2:4; time=none ignores the time stamps.",
            main=True,
        ),
    )
    input: InputKind = field(
        default="rate",
        metadata=option(
            "Input",
            "Content of the columns: rates, increments per sample, or accumulated angle and velocity.",
            choices=get_args(InputKind),
            python="N accumulated points give N-1 rates.",
        ),
    )
    scale: Mapping[str, float] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Factor from counts or volts to the unit: value = (raw - offset) × scale.",
            "Default: 1.",
            form="numbers",
            unit="stated unit per count",
            kind="mapping of str to float, optional",
            example="gyro=0.01",
            python='By channel or sensor; ``"time"`` may have one too.',
            typed="Example: gyro=1/131.",
        ),
    )
    offset: Mapping[str, float] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Reading at zero, in counts or volts.",
            "Default: 0.",
            form="numbers",
            unit="counts",
            kind="mapping of str to float, optional",
            example="gyro=2048",
            python="By channel or sensor.",
            typed="Example: gyro=2048.",
        ),
    )
    topic: str | Sequence[str] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Topic, message, variable or kind of rows to read if the log has several: one, or one for each sensor."
            " Default: the only one with a gyro and an accelerometer, or the only one of each.",
            form="texts",
            kind="str or sequence of str, optional",
        ),
    )
    interleaved: int | None = field(
        default=None,
        metadata=option(
            "Input",
            "Number of sensors whose rows take turns in a table, if no column distinguishes them: 2 or more reads them as"
            " topics imu0, imu1 …, 1 states a single sensor. Default: a single sensor; the option is required"
            " if the samples or the time stamps show several.",
            form="count",
            kind="int, optional",
        ),
    )

    def checked(self) -> Options:
        """Options of the right types and values; raises `OptionError`."""
        rate, rates = check_rates(self.rate)
        return Options(
            rate=rate,
            rates=rates,
            unit={c: _spelled(c, v) for c, v in _mapping("unit", self.unit).items()},
            channels={c: _column(c, v) for c, v in _mapping("channels", self.channels).items()},
            input=check_kind(self.input),
            scale={c: _factor("scale", c, v) for c, v in _mapping("scale", self.scale).items()},
            offset={c: _factor("offset", c, v) for c, v in _mapping("offset", self.offset).items()},
            topic=_topics(self.topic),
            interleaved=_sensors_in_turn(self.interleaved),
        )


@frozen
class ReadOptions(TableOptions):
    """Options of `sigmatau.read`."""

    layout: str | None = field(
        default=None,
        metadata=option(
            "Input",
            'Fields of a row of a raw binary file, in order: "<u8 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"; 4x skips four'
            " bytes. Required for raw binary files.",
            form="text",
            kind="str, optional",
            python="A field is a count (default 1), a NumPy type (i1 to i8, u1 to u8, f4, f8), a name, and an optional unit"
            " in brackets. A count of three gives x, y and z. ``<`` (low byte first, the usual order) and ``>`` (high byte"
            " first) hold for all fields that follow. ``header 512`` at the beginning skips 512 bytes before the first"
            " row.",
        ),
    )
    skip: int = field(
        default=0,
        metadata=option(
            "Input",
            "Number of lines to skip at the beginning of a text table; lines of text above a table are skipped anyway.",
            form="count",
            kind="int",
        ),
    )
    max_expansion: float | None = field(
        default=None,
        metadata=option(
            "Input",
            "Largest ratio of unpacked to compressed size (default 100; 64 MiB are always unpacked).",
            form="number",
            kind="float, optional",
            matters=False,
        ),
    )

    def checked(self) -> Options:
        """Options of the right types and values; raises `OptionError`."""
        if not isinstance(self.skip, int | np.integer) or isinstance(self.skip, bool) or self.skip < 0:
            raise OptionError(f"{{option}} must be a number of lines, 0 or more, not {self.skip!r}", option="skip")
        ratio = self.max_expansion
        if ratio is not None and not (isinstance(ratio, int | float) and ratio >= 1):
            raise OptionError(f"{{option}} must be a number, 1 or more, not {ratio!r}", option="max_expansion")
        return TableOptions.checked(self)


@frozen
class Options:
    """Checked options of reading columns, see `TableOptions`."""

    rate: float | None  # Rate of all sensors that have no entry in `rates`. [Hz]
    unit: Mapping[str, str]
    channels: Mapping[str, str | int]
    input: InputKind
    scale: Mapping[str, float]
    offset: Mapping[str, float]
    topic: tuple[str, ...] = ()
    rates: Mapping[str, float] = field(default_factory=dict)  # By sensor. [Hz]
    sensors: tuple[str, ...] = ()  # Sensors to read from a topic with the fields of both; all if empty
    interleaved: int | None = None  # Number of sensors whose rows take turns; None if the samples decide

    @property
    def states_rate(self) -> bool:
        """Whether a sampling rate is given, for all sensors or for some."""
        return self.rate is not None or bool(self.rates)

    def for_streams(self, streams: Sequence[str]) -> Options:
        """Combine the options of streams in the same rows, which have one rate. Raises `OptionError` if several rates are
        given.
        """
        if not self.rates:
            return self
        rates = {stream: self.rates[stream] for stream in streams if stream in self.rates}
        if len(set(rates.values())) > 1:
            listed = " and ".join(rates)
            raise OptionError(
                f"{listed} are in the same rows, which have one rate; give {{option}} as one number", option="rate"
            )
        return replace(self, rate=next(iter(rates.values()), self.rate), rates={})


_MAX_IN_TURN = 16  # largest number of sensors whose rows take turns: the same as that of instances in a column
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


def check_live_options(options: ReadOptions, *, command: str) -> Options:
    """The options of reading live lines; raises `OptionError` for those that are for a saved log."""
    checked = options.checked()
    if options.input == "accumulated":
        raise OptionError(
            f"{command} reads rates or increments; accumulated values are for a saved log", option="input"
        )
    if options.interleaved not in (None, 1):
        raise OptionError(
            f"{command} follows one sensor: {{option}} {options.interleaved} is for a saved log, sigmatau analyze FILE",
            option="interleaved",
        )
    return checked
