"""`Source`: noise model with sampling rates and sample variances, from an analysis, a model file or a YAML file.

YAML is ``imu.yaml`` of Kalibr or a result of imu_utils. The file of Kalibr has one number for three axes, in the units of
a model. imu_utils writes two numbers per axis with misleading names: ``gyr_n`` is the standard deviation of a sample, √f
times the density; ``gyr_w`` is the minimum of the Allan deviation, 0.664 times the bias instability if there is any, in
rad/s instead of rad/s²/√Hz. The first is converted and the second omitted, each with a finding.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import not_of_a_log
from sigmatau.findings.exporting import DeviationAsDensity, ImportedWithoutIntervals, KeysNotRead, MinimumAsWalk
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import stream_name
from sigmatau.results import Printed
from sigmatau.units import find

_SAME_RATE = 1e-3  # largest relative difference of rates of two sensors of one unit with separate time stamps


@frozen
class Sample:
    """Measured variance of a sample.

    Attributes
    ----------
    variance : float
        Variance about the mean over `time`. [(rate unit)²]
    time : float
        Averaging time of the mean. [s]
    """

    variance: float
    time: float


@frozen
class Source(Printed):
    """A noise model and the data about its record that an export needs.

    Attributes
    ----------
    model : NoiseModel
    rates : mapping of str to float
        Sampling rate by channel, if known. [Hz]
    findings : tuple of Finding
        Findings about the file that was read.
    corners : mapping of str to float
        Corner of the low-pass filter that the analysis found, by channel. [Hz]
    samples : mapping of str to Sample
        Measured variance of a sample, by channel.
    names : mapping of str to str
        Fields of the file besides the noise parameters, such as a topic.
    poor : tuple of str
        Channels whose coefficients should not be used, according to the analysis.
    head : tuple of str
        Lines about the source for the head of a file.

    See Also
    --------
    sigmatau.export : writes it for another program.
    """

    model: NoiseModel
    rates: Mapping[str, float]
    findings: tuple[Finding, ...] = ()
    corners: Mapping[str, float] = field(default_factory=dict)
    samples: Mapping[str, Sample] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    poor: tuple[str, ...] = ()
    head: tuple[str, ...] = ()

    @classmethod
    def of_model(cls, model: NoiseModel) -> Source:
        """Build the source of a model; the sampling rate is known if the model is from a fit.

        Parameters
        ----------
        model : NoiseModel
            Noise of the channels to export.

        Returns
        -------
        Source
        """
        return cls(model=model, rates={name: channel.rate for name, channel in model.channels.items() if channel.rate})

    def of(self, channels: Iterable[str]) -> Source:
        """Select some of the channels.

        Parameters
        ----------
        channels : iterable of str
            Names of the channels.

        Returns
        -------
        Source
        """
        return replace(self, model=self.model.of(channels))

    def __repr__(self) -> str:
        return "\n".join([repr(self.model), *map(str, self.findings)])


def make_source(noise: object) -> Source:
    """Build the source of a model or an analysis. Raises `OptionError` for other types."""
    if isinstance(noise, Source):
        return noise
    if isinstance(noise, NoiseModel):
        return Source.of_model(noise)
    make = getattr(noise, "to_source", None)  # an Analysis, which this package cannot import
    if callable(make) and not isinstance(noise, type):
        made: Source = make()
        return made
    advice = ""
    if isinstance(noise, str | Path):
        advice = f": read it first, sigmatau.analysis.inputs.read_source({str(noise)!r})"
    elif hasattr(noise, "streams"):
        advice = ": analyse it first, sigmatau.analyze(record)"
    raise OptionError(
        f"{{option}} must be a NoiseModel or an Analysis, not {type(noise).__name__}{advice}", option="model"
    )


def read_file(path: Path, *, rate: float | None = None) -> Source:
    """Read a model file (.toml), or a YAML file of Kalibr or imu_utils.

    `rate`: sampling rate of the record, for a YAML file, which does not state it [Hz]. Raises `OptionError` for a rate
    with another kind of file.
    """
    head = (f"from {path.name}",)
    if path.suffix.lower() not in (".yaml", ".yml"):
        if rate is not None:
            raise not_of_a_log(rate).about(str(path))
        return replace(Source.of_model(NoiseModel.read(path)), head=head)
    try:
        return replace(read_yaml(path.read_text(encoding="utf-8-sig"), rate=rate), head=head)
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except OptionError as error:
        raise error.about(str(path)) from None
    except ValueError as error:  # includes DataError and UnicodeDecodeError
        raise DataError(f"{path}: {error}") from None


def have_several_rates(rates: Mapping[str, float]) -> bool:
    """Whether the rates differ by more than the clocks of two sensors of one unit."""
    return bool(rates) and max(rates.values()) > (1 + _SAME_RATE) * min(rates.values())


def sensor_rates(rates: Mapping[str, float]) -> dict[str, float]:
    """Highest sampling rate by sensor: gyro and accelerometer, or the other signals if there are neither. [Hz]"""
    highest: dict[str, float] = {}
    for channel, rate in rates.items():
        sensor = stream_name(channel)
        highest[sensor] = max(rate, highest.get(sensor, 0.0))
    return {name: rate for name, rate in highest.items() if name in ("gyro", "accel")} or highest


def common_rate(rates: Mapping[str, float]) -> float | None:
    """Sampling rate of gyros and accelerometers; None if it is unknown or not unique. [Hz]"""
    relevant = {name: rate for name, rate in rates.items() if stream_name(name) in ("gyro", "accel")} or dict(rates)
    return None if not relevant or have_several_rates(relevant) else next(iter(relevant.values()))


_KALIBR = {
    "gyroscope_noise_density": ("gyro", "random_walk"),
    "gyroscope_random_walk": ("gyro", "rate_random_walk"),
    "accelerometer_noise_density": ("accel", "random_walk"),
    "accelerometer_random_walk": ("accel", "rate_random_walk"),
}
_RATES = ("update_rate", "rate_hz")
_IMU_UTILS = {"Gyr": ("gyro", "gyr", "rad/s"), "Acc": ("accel", "acc", "m/s^2")}
_AXES = ("x-axis", "y-axis", "z-axis", "avg-axis")
_IGNORED = (  # keys of Kalibr, OpenVINS and EuRoC that are not noise parameters
    *("rostopic", "topic", "time_offset", "model", "sensor_type", "comment"),
    *("T_i_b", "T_ib", "T_BS", "Tw", "R_IMUtoGYRO", "Ta", "R_IMUtoACC", "Tg"),
)
_LINE = re.compile(r"""( *)(?:"([^"\\]*)"|'([^']*)'|([A-Za-z_][^\s:#'"]*))[ \t]*:(?:[ \t]+(.*))?""")
_UNSUPPORTED = re.compile(r"^\s*<<\s*:|:\s*[*{]", flags=re.MULTILINE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


def read_yaml(text: str, *, rate: float | None = None) -> Source:
    """Read the model of an ``imu.yaml`` of Kalibr, OpenVINS or EuRoC, or of a result of imu_utils; the keys show which.
    `rate`: sampling rate of the record; required for imu_utils, whose file does not contain it [Hz].
    """
    values = _values(text)
    unsupported = (
        "; anchors and {…} are not supported: write each key on a separate line" if _UNSUPPORTED.search(text) else ""
    )
    imus = sorted({path[:-1] for path in values if path[-1] in _KALIBR})
    if len(imus) > 1:
        listed = ", ".join(".".join(imu) or "the top" for imu in imus)
        raise DataError(f"several IMUs ({listed}); keep only one")
    if imus:
        return _kalibr({path[-1]: text for path, text in values.items() if path[:-1] == imus[0]}, rate, unsupported)
    if any(path[0] in _IMU_UTILS and len(path) == 3 and path[-1].endswith("_n") for path in values):
        return _imu_utils(values, rate)
    raise DataError(
        f"not an imu.yaml of Kalibr ({', '.join(_KALIBR)}) or a result of imu_utils (Gyr: x-axis: gyr_n); other YAML is"
        f" not read{_nearly((key for path in values for key in path), (*_KALIBR, *_IMU_UTILS)) or unsupported}"
    )


def _kalibr(values: Mapping[str, str], rate: float | None, unsupported: str) -> Source:
    unread = [key for key in values if key not in _KALIBR and key not in _RATES and key not in _IGNORED]
    missing = [key for key in _KALIBR if key not in values]
    nearly = _nearly(unread, (*_KALIBR, *_RATES))
    if missing:
        raise DataError(f"missing {', '.join(missing)}: all four densities are needed{nearly or unsupported}")
    if nearly:
        raise DataError(f"unknown key{nearly}")
    channels: dict[str, dict[str, float]] = {}
    for key, (sensor, term) in _KALIBR.items():
        channels.setdefault(sensor, {})[term] = _positive(key, values[key])
    if rate is None:
        rate = next((_positive(key, values[key]) for key in _RATES if key in values), None)
    findings = [Finding(severity="info", details=ImportedWithoutIntervals())]
    if unread:
        findings.append(Finding(severity="info", details=KeysNotRead(keys=tuple(unread))))
    topic = values.get("rostopic", "").strip("\"'")
    return Source(
        model=NoiseModel(channels=channels),
        rates={} if rate is None else dict.fromkeys(channels, rate),
        findings=tuple(findings),
        names={"topic": topic} if topic else {},
    )


def _imu_utils(values: Mapping[tuple[str, ...], str], rate: float | None) -> Source:
    if rate is None:
        raise OptionError(
            "gyr_n and acc_n of imu_utils are standard deviations of a sample, not densities: give {option}, the sampling"
            " rate of the record in Hz",
            option="rate",
        )
    for path in values:
        if len(path) > 1:
            _understood(path)
    channels: dict[str, dict[str, float]] = {}
    walks: list[str] = []
    for block, (sensor, prefix, si) in _IMU_UTILS.items():
        size = _unit(block, values.get((block, "unit"), si), si) / math.sqrt(rate)
        axes = [axis for axis in "xyz" if (block, f"{axis}-axis", f"{prefix}_n") in values]
        for axis in axes:
            key = (block, f"{axis}-axis", f"{prefix}_n")
            channels[f"{sensor}_{axis}"] = {"random_walk": _positive(".".join(key), values[key]) * size}
        average = (block, "avg-axis", f"{prefix}_n")
        if not axes and average in values:
            channels[sensor] = {"random_walk": _positive(".".join(average), values[average]) * size}
        if any(path[0] == block and path[-1] == f"{prefix}_w" for path in values):
            walks.append(f"{prefix}_w")
    if not channels:
        raise DataError("a result of imu_utils without gyr_n or acc_n")
    findings = [Finding(severity="warning", size=math.sqrt(rate), details=DeviationAsDensity(rate=rate))]
    if walks:
        findings.append(Finding(severity="warning", details=MinimumAsWalk(keys=tuple(walks))))
    return Source(model=NoiseModel(channels=channels), rates=dict.fromkeys(channels, rate), findings=tuple(findings))


def _positive(key: str, text: str) -> float:
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not (math.isfinite(value) and value > 0):
        raise DataError(f"{key}: {text[:80]!r} is not a positive number")
    return value


def _understood(path: tuple[str, ...]) -> None:
    """Raise `DataError` for an unknown key in a block of imu_utils."""
    block, name, *rest = path
    expected: Iterable[str] = _IMU_UTILS
    if block in _IMU_UTILS:
        prefix = _IMU_UTILS[block][1]
        leaves = (f"{prefix}_n", f"{prefix}_w")
        if path[1:] == ("unit",) or (name in _AXES and len(rest) == 1 and rest[0] in leaves):
            return
        expected = ("unit", *_AXES) if name not in _AXES else leaves
    wrong = next((key for key in path if key not in _IMU_UTILS and key not in _AXES), name)
    hint = _nearly([wrong], expected) or f"; known keys: {', '.join(expected)}"
    raise DataError(f"{'.'.join(path)}: unknown key{hint}")


def _unit(block: str, text: str, si: str) -> float:
    """Convert a unit of imu_utils to SI. Raises `DataError` for an unknown unit or another quantity."""
    symbol = text.strip("\"' \t")
    try:
        unit = find(symbol)
    except OptionError as error:
        raise DataError(f"{block}.unit: {error}") from None
    if unit.si != si:
        raise DataError(f"{block}.unit: {symbol!r} is not a unit of {block}, whose numbers are in {si} or a multiple")
    return unit.factor


def _nearly(keys: Iterable[str], expected: Iterable[str]) -> str:
    """Hint ``; 'Gyr_n': did you mean gyr_n?`` for misspelled keys, or an empty text."""
    names = {name.lower(): name for name in expected}
    suggestions = []
    for key in dict.fromkeys(keys):
        close = difflib.get_close_matches(key.lower()[:80], names, n=1, cutoff=0.75)
        if close and key not in names.values():
            suggestions.append(f"; {key[:80]!r}: did you mean {names[close[0]]}?")
    return "".join(suggestions)


def _values(text: str) -> dict[tuple[str, ...], str]:
    """Read the values of the nested block mappings of a YAML file, by their path of keys; lists are skipped.

    These files do not use other parts of YAML. A value may follow a tab, or be on or continue on the next line: deeper
    lines belong to the key above. Raises `DataError` for a duplicate key.
    """
    values: dict[tuple[str, ...], str] = {}
    above: list[tuple[int, str]] = []
    last: tuple[str, ...] = ()  # the key to which deeper lines belong
    depth, filled = 0, False
    for line in re.split(r"\r\n|\r|\n", text.removeprefix("\ufeff")):
        content = re.sub(r"(?:^|\s)#.*", "", line).rstrip()
        if not content.strip() or content.startswith(("%", "---", "...")):
            continue
        indent = len(content) - len(content.lstrip(" "))
        match = _LINE.fullmatch(content)
        if last and indent > depth and (filled or not (match or content.lstrip().startswith("-"))):
            if not filled and last in values:
                raise DataError(f"{'.'.join(last)} is a duplicate key")
            values[last] = f"{values[last]} {content.strip()}" if filled else content.strip()
            filled = True
        elif match is not None:
            key = next(name for name in match.groups()[1:4] if name is not None)
            while above and above[-1][0] >= indent:
                above.pop()
            last, depth = (*(name for _, name in above), key), indent
            scalar = re.sub(r"^(?:[!&]\S*\s*)+", "", (match[5] or "").strip())  # value without tag and anchor
            filled = bool(scalar)
            if not filled:
                above.append((indent, key))
            elif last in values:
                raise DataError(f"{'.'.join(last)} is a duplicate key")
            else:
                values[last] = scalar
    return values
