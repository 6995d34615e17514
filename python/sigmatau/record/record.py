"""Records: returned by every reader and taken by every estimator.

A `Record` is a tuple of streams, their origin, and the findings of the reader.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau import units
from sigmatau._native import kernels
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.record.missing import find_missing, missing_values
from sigmatau.record.sampling import GIVEN_RATE, RateSource
from sigmatau.record.streams import Columns, Grid, InputKind, Stream, Transform, check_kind, check_rate, check_rates
from sigmatau.record.thermometers import CELSIUS, TO_CELSIUS, thermometers
from sigmatau.results import Printed, plain_value

QUANTITIES: Mapping[str, str] = {"angular_rate": "rad/s", "acceleration": "m/s^2"}
"""SI units by quantity. Any other signal keeps its unit."""

MIN_SAMPLES = 4
"""Fewest samples of a record; fewer give no useful curve."""


class Checksum:
    """SHA-256 of a file, computed on first use: for a large log it takes as long as reading it.

    Parameters
    ----------
    file : Path
        The file as it is now: if it changes before the checksum is computed, the checksum is None.
    """

    __slots__ = ("_digest", "_file", "_state")

    def __init__(self, file: Path) -> None:
        self._file = file.absolute()
        self._state = _state(file.stat())
        self._digest: str | None = None

    def value(self) -> str | None:
        """The checksum; None if the file was changed."""
        if self._digest is None:
            import hashlib

            try:
                if self._file.is_dir():  # a log of several files
                    return None
                with self._file.open("rb") as stream:
                    if _state(os.fstat(stream.fileno())) != self._state:
                        return None
                    digest = hashlib.file_digest(stream, "sha256").hexdigest()
                    if _state(os.fstat(stream.fileno())) != self._state:
                        return None
            except OSError:
                return None
            self._digest = digest
        return self._digest


def _state(status: os.stat_result) -> tuple[int, ...]:
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


@frozen
class TemperatureRange:
    """Temperature during a record, by its own thermometer.

    Attributes
    ----------
    mean, low, high : float
        Mean, lowest and highest temperature. [degC]
    """

    mean: float
    low: float
    high: float


@frozen
class Provenance:
    """Origin of a record, and the conversions made.

    Attributes
    ----------
    path : str or None
        File name as given by the caller.
    format : str
        ``"text"``, ``"npy"``, ``"npz"``, ``"array"``, ``"simulation"``.
    topics : tuple of str
        Topics read, if the file has several.
    rows : int
        Rows of data read.
    conversions : tuple of str
        Descriptions of conversions and choices.
    ignored : tuple of str
        Columns of the file that are not in the record.
    units_stated : tuple of str
        Channels whose unit the file states and no option overrides.
    options : mapping
        Arguments of `sigmatau.read` that are not the default and matter for the numbers, as plain values.
    checksum : Checksum, str or None
        SHA-256 of the file, computed on first use; or as a result states it. See `sha256`.
    started : str or None
        Time of the first sample, ``"2026-05-01T12:00:00"``, by the clock of the log; of stamps that count from 1970 in UTC.
        None if the log has no dates.
    temperature : TemperatureRange or None
        Temperature during the record; None without a thermometer.
    """

    path: str | None = None
    format: str = "array"
    topics: tuple[str, ...] = ()
    rows: int = 0
    conversions: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    units_stated: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict, compare=False)
    checksum: Checksum | str | None = field(default=None, repr=False, compare=False)
    started: str | None = None
    temperature: TemperatureRange | None = None

    @property
    def sha256(self) -> str | None:
        """Checksum of the file's bytes, computed when it is first asked for; None if the file has been changed since."""
        return self.checksum.value() if isinstance(self.checksum, Checksum) else self.checksum

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "path": self.path,
            "format": self.format,
            **({"topics": list(self.topics)} if self.topics else {}),
            "sha256": self.sha256,
            "rows": self.rows,
            "conversions": list(self.conversions),
            "ignored_columns": list(self.ignored),
            **({"started": self.started} if self.started else {}),
            **({"temperature_degc": plain_value(self.temperature)} if self.temperature else {}),
        }


@frozen(eq=False)
class Record(Printed):
    """A static record: streams, their origin, and findings of the reader.

    Attributes
    ----------
    streams : tuple of Stream
    provenance : Provenance
    findings : tuple of sigmatau.findings.finding.Finding
        Findings of the reader.

    See Also
    --------
    sigmatau.read : a record from a file.
    sigmatau.from_frame : a record from a data frame.
    sigmatau.simulate : a simulated record.

    Examples
    --------
    >>> import numpy as np
    >>> from sigmatau import Record
    >>> Record.from_arrays(rate=100, unit={"gyro": "deg/s"}, gyro=np.zeros((1000, 3)))
    Record of 1 stream
      gyro: gyro_x, gyro_y, gyro_z [rad/s], 1000 samples at 100 Hz (10 s)
    """

    streams: tuple[Stream, ...]
    provenance: Provenance = Provenance()
    findings: tuple[Finding, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels, stream by stream."""
        return tuple(name for stream in self.streams for name in stream.channels)

    def stream_of(self, channel: str) -> Stream:
        """The stream that contains a channel.

        Parameters
        ----------
        channel : str
            Name of the channel.

        Returns
        -------
        Stream

        Raises
        ------
        KeyError
            For a channel that the record does not have.
        """
        for stream in self.streams:
            if channel in stream.channels:
                return stream
        raise KeyError(f"no channel {channel!r}; the record has {', '.join(self.channels)}")

    def longest_run(self) -> Record:
        """Each stream cut to its longest run without a missing sample."""
        return replace(self, streams=tuple(s.longest_run() for s in self.streams))

    def __repr__(self) -> str:
        lines = [f"Record of {len(self.streams)} stream{'s' if len(self.streams) != 1 else ''}"]
        for s in self.streams:
            missing = "" if s.mask is None else f", {int(s.mask.any(axis=1).sum())} samples missing"
            lines.append(
                f"  {s.name}: {', '.join(s.channels)} [{s.unit}], {s.grid.n} samples at {s.grid.rate:.6g} Hz"
                f" ({s.grid.duration:.6g} s{missing})"
            )
        return "\n".join(lines)

    @classmethod
    def from_arrays(
        cls,
        *,
        rate: float | Mapping[str, float],
        unit: Mapping[str, str] | None = None,
        input: InputKind = "rate",  # noqa: A002  the word users know from --input
        **channels: ArrayLike,
    ) -> Record:
        """A record from arrays in memory.

        Parameters
        ----------
        rate : float or mapping of str to float
            Sampling rate; by stream if they have different rates, ``{"gyro": 400, "accel": 200}``. [Hz]
        unit : mapping, optional
            Unit by stream (``"gyro"``, ``"accel"``) or channel. Default: SI.
        input : {"rate", "increments", "accumulated"}
            Content of the arrays; see `Transform`.
        **channels : array_like, shape (n,) or (n, 3)
            ``gyro_x=…`` one axis, ``gyro=…`` an array of three. Names that begin with ``gyro`` or ``accel`` are angular
            rates and accelerations. A channel named ``temperature`` or ``temp`` (``imu_temp`` …) is a thermometer that
            explains drifts, in °C unless `unit` is ``"K"`` or ``"degF"``; with another unit it is a signal. All other
            names are signals. NaN marks a missing sample. A float64 array is not copied: do not change it while the
            record is in use. [`unit`]

        Returns
        -------
        Record

        Raises
        ------
        TypeError
            If `unit` is not a mapping.
        OptionError
            For a rate that is not positive, or outside 1e-6 … 1e9 Hz, or an unknown unit.
        DataError
            For no channel, arrays of unequal length in one stream, an infinite sample, fewer than 4 samples.
        """
        common_rate, rates = check_rates(rate)
        check_kind(input)
        if unit is not None and not isinstance(unit, Mapping):
            raise TypeError(f"`unit` must be a mapping such as {{'gyro': 'deg/s'}}, not {unit!r}")
        by_stream: dict[str, dict[str, NDArray[np.float64]]] = {}
        arrays = {name: real_numbers(name, values) for name, values in channels.items()}
        finite = dict(zip(arrays, kernels.all_finite(list(arrays.values())), strict=True))
        with_gaps = {stream_name(name) for name in arrays if not finite[name]}
        for name, values in arrays.items():
            array = values.view()
            array.setflags(write=False)
            stream = stream_name(name)
            if array.ndim == 2 and array.shape[1] == 3:
                columns = {f"{name}_{axis}": array[:, i] for i, axis in enumerate("xyz")}
            elif array.ndim == 1:
                columns = {name: array}
            else:
                raise DataError(f"`{name}` has shape {array.shape}; want (n,) or (n, 3)")
            twice = set(by_stream.setdefault(stream, {})) & set(columns)
            if twice:
                raise DataError(f"`{min(twice)}` is given twice, by itself and in an array of three")
            by_stream[stream].update(columns)
        if not by_stream:
            raise DataError("no channel was given; give at least one array, e.g. gyro_x=…")
        names = dict.fromkeys([*by_stream, *(channel for columns in by_stream.values() for channel in columns)])
        for key in unit or {}:
            if key not in names:
                raise OptionError(
                    f"{{option}} names {key!r}, which is not a channel; channels: {', '.join(names)}", option="unit"
                )
        rate_by_stream = _rates_of_streams(common_rate, rates, list(by_stream))
        thermometer_units, notes = thermometers(by_stream, unit or {})
        streams = [
            replace(
                make_temperature(columns[name], thermometer_units[name], rate=rate_by_stream[name]),
                name=name,
                channels=(name,),
            )
            if name in thermometer_units
            else make_stream(
                name,
                columns,
                rate=rate_by_stream[name],
                unit=dict(unit or {}),
                kind=input,
                finite=name not in with_gaps,
            )
            for name, columns in by_stream.items()
        ]
        masks_by_rate: dict[float, dict[str, NDArray[np.bool_]]] = {}
        for s in streams:
            if s.mask is None or s.quantity == "temperature":  # thermometers may be read less often
                continue
            for k, channel in enumerate(s.channels):
                if np.count_nonzero(~s.mask[:, k]) >= MIN_SAMPLES:  # the analysis reports the other channels as empty
                    masks_by_rate.setdefault(rate_by_stream[s.name], {})[channel] = s.mask[:, k]
        return cls(
            streams=tuple(streams),
            provenance=Provenance(rows=max(len(next(iter(c.values()))) for c in by_stream.values()), conversions=notes),
            findings=tuple(
                finding
                for hertz, masks in masks_by_rate.items()
                for finding in missing_values(masks, partial(_index_text, hertz), 1 / hertz, unit="samples")
            ),
        )


def _index_text(rate: float, index: int) -> str:
    return f"index {index} (t = {index / rate:.6g} s)"


def _rates_of_streams(rate: float | None, rates: Mapping[str, float], streams: Sequence[str]) -> dict[str, float]:
    """The sampling rate of each stream; raises `OptionError` for a stream without one, or a rate without a stream. [Hz]"""
    if rate is None and not rates:
        check_rate(rate)
    if rate is not None:
        return dict.fromkeys(streams, rate)
    wrong = [*(name for name in streams if name not in rates), *(name for name in rates if name not in streams)]
    if wrong:
        raise OptionError(
            f"{{option}} must have one rate for each of {', '.join(streams)}; {wrong[0]!r} is missing or unknown",
            option="rate",
        )
    return dict(rates)


def make_temperature(values: NDArray[np.float64], unit: str, **grid: Any) -> Stream:  # noqa: ANN401  of `make_stream`
    """The stream of a thermometer, from raw values in one of the units of temperature."""
    scale, offset = TO_CELSIUS[unit]
    key = "temperature"
    return make_stream(key, {key: values}, unit={key: CELSIUS}, scale={key: scale}, offset={key: offset}, **grid)


def need_record(value: object, *, name: str = "record", stream: bool = False) -> None:
    """Raise `TypeError`, with the call to write, for a value that is not a record or, if allowed, a stream."""
    if not isinstance(value, (Record, Stream) if stream else Record):
        raise TypeError(
            f"`{name}` must be a Record{' or a Stream' if stream else ''}, not a {type(value).__name__}: see sigmatau.read"
            " for files, sigmatau.from_frame for data frames and sigmatau.Record.from_arrays(rate=100, gyro_x=x) for arrays"
        )


def real_numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64, masked ones as NaN."""
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    array = np.asarray(values)
    if array.dtype.kind not in "buifO":
        raise DataError(f"`{name}` holds {array.dtype} values; want real numbers")
    try:
        return np.asarray(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(f"`{name}` contains a non-numeric value") from None


def stream_name(channel: str) -> str:
    """The stream a channel belongs to, by its name."""
    for stream in ("gyro", "accel"):
        if channel == stream or channel.startswith(stream + "_"):
            return stream
    return channel


def make_stream(
    name: str,
    columns: Mapping[str, NDArray[Any]],
    *,
    rate: float,
    unit: Mapping[str, str],
    kind: InputKind = "rate",
    scale: Mapping[str, float] | None = None,
    offset: Mapping[str, float] | None = None,
    grid_source: RateSource = GIVEN_RATE,
    start: float = 0.0,
    epoch: float = 0.0,
    jitter: float | None = None,
    finite: bool = False,
) -> Stream:
    """A stream from raw columns; units, scales and offsets are looked up by channel, then by stream.

    A missing unit means SI here; readers ask for it before they call this function (see `sigmatau.io.read`). `finite`
    means that the raw columns are known to be free of NaN and infinities.
    """
    transforms = []
    for channel in columns:
        quantity, si, factor = conversion(channel, unit, kind)
        transforms.append(
            Transform(
                scale=_lookup(scale, channel, name, 1.0),
                offset=_lookup(offset, channel, name, 0.0),
                factor=factor,
                kind=kind,
            )
        )
    lengths = {channel: len(values) for channel, values in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{c}: {n}" for c, n in lengths.items())
        raise DataError(f"the channels of {name} have unequal lengths ({listed}); one stream has one grid")
    samples = Columns(tuple(columns.values()), tuple(transforms), 1.0 / rate)
    n = len(samples)
    if n < MIN_SAMPLES:
        raise RecordTooShortError(f"{name} has {n} samples; at least {MIN_SAMPLES} are needed", need=MIN_SAMPLES, got=n)
    return Stream(
        name=name,
        quantity=quantity,
        unit=si,
        channels=tuple(columns),
        grid=Grid(n=n, tau0=1.0 / rate, start=start, epoch=epoch, source=grid_source, jitter=jitter),
        samples=samples,
        mask=find_missing(samples, tuple(columns), finite=finite),
    )


def channel_quantities(record: Record) -> dict[str, tuple[str, str]]:
    """Quantity and unit of each channel of a record."""
    return {channel: (stream.quantity, stream.unit) for stream in record.streams for channel in stream.channels}


def conversion(channel: str, unit: Mapping[str, str], kind: InputKind) -> tuple[str, str, float]:
    """Quantity of a channel, unit of its rates, and the factor from the unit given for it or for its stream.

    Without a unit, a channel is in SI already. A signal keeps its unit.
    """
    stream = stream_name(channel)
    quantity = {"gyro": "angular_rate", "accel": "acceleration"}.get(stream, "signal")
    spelled = unit.get(channel, unit.get(stream))
    si = QUANTITIES.get(quantity)
    if stream == "temperature" and spelled == CELSIUS and kind == "rate":
        return "temperature", CELSIUS, 1.0
    if si is None:
        return quantity, _rate_unit(spelled or "1", kind), 1.0
    return quantity, si, 1.0 if spelled is None else _factor(spelled, channel, si, kind)


def _lookup(values: Mapping[str, float] | None, channel: str, stream: str, default: float) -> float:
    values = values or {}
    return float(values.get(channel, values.get(stream, default)))


def _factor(spelled: str, channel: str, si: str, kind: InputKind) -> float:
    wanted = si if kind == "rate" else units.integral(si)
    stated = units.find(spelled, si=(si, units.integral(si)))
    if stated.si != wanted:
        choices = ", ".join(units.symbols(wanted))
        if kind == "rate":
            remedy = (
                f"is not a unit of a rate: give one of {choices}; or {Hint('input', value='increments')} or accumulated"
            )
        else:
            remedy = f"is the unit of a rate, but the input is {kind}: give one of {choices}"
        raise OptionError(f"{channel}: {spelled!r} {remedy}", option="unit")
    return stated.factor


def _rate_unit(spelled: str, kind: InputKind) -> str:
    """Unit of the rate of a signal: a phase in seconds has a rate in 1."""
    if kind == "rate":
        return spelled
    return "1" if spelled == "s" else f"{spelled}/s"
