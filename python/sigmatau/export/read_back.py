"""Reading back what other programs hold: noise parameters of Kalibr's ``imu.yaml`` and of imu_utils' results.

Kalibr's file is one number for three axes, in the units of a model. imu_utils writes two numbers an axis, and neither is
what it is called: ``gyr_n`` is the deviation of a sample, √f times the density; ``gyr_w`` is the minimum of the Allan
deviation, a bias instability times 0.664 if there is one, in rad/s and not in rad/s²/√Hz. The first is converted, the
second left out, and both are said.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from sigmatau.errors import DataError, OptionError
from sigmatau.model import NoiseModel
from sigmatau.results import Finding, Printed

__all__ = ["ReadBack", "read_yaml"]

_KALIBR = {
    "gyroscope_noise_density": ("gyro", "random_walk"),
    "gyroscope_random_walk": ("gyro", "rate_random_walk"),
    "accelerometer_noise_density": ("accel", "random_walk"),
    "accelerometer_random_walk": ("accel", "rate_random_walk"),
}
_RATES = ("update_rate", "rate_hz")
_IMU_UTILS = {"Gyr": ("gyro", "gyr", "rad/s"), "Acc": ("accel", "acc", "m/s^2")}
_LINE = re.compile(r"""( *)(?:"([^"\\]*)"|'([^']*)'|([A-Za-z_][^\s:#'"]*)) *:(?: +(.*))?""")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadBack(Printed):
    """A model from another program's file.

    Attributes
    ----------
    model : NoiseModel
        Channels ``gyro`` and ``accel`` where the file has one number for all axes.
    rate : float or None
        Sampling rate, where the file or the caller says it. [Hz]
    findings : tuple of Finding
        What the file calls by a wrong name, and what was left out.
    names : mapping of str to str
        The topic, where the file names one.
    """

    model: NoiseModel
    rate: float | None
    findings: tuple[Finding, ...]
    names: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return "\n".join([repr(self.model), *map(str, self.findings)])


def read_yaml(text: str, *, rate: float | None = None) -> ReadBack:
    """The model of a Kalibr ``imu.yaml`` (also OpenVINS', EuRoC's) or of a result of imu_utils, told apart by their keys.

    Parameters
    ----------
    text : str
        The file.
    rate : float, optional
        Sampling rate of the record that imu_utils saw, which its file does not hold. [Hz]

    Raises
    ------
    DataError
        If it is neither, describes several IMUs, or a value is no positive number.
    OptionError
        If it is of imu_utils and there is no `rate`.
    """
    values = _values(text)
    imus = sorted({path[:-1] for path in values if path[-1] in _KALIBR})
    if len(imus) > 1:
        listed = ", ".join(".".join(imu) or "the top" for imu in imus)
        raise DataError(f"several IMUs ({listed}); keep the one that is meant")
    if imus:
        return _kalibr({path[-1]: text for path, text in values.items() if path[:-1] == imus[0]}, rate)
    if any(path[0] in _IMU_UTILS and len(path) == 3 and path[-1].endswith("_n") for path in values):
        return _imu_utils(values, rate)
    raise DataError(
        f"neither a Kalibr imu.yaml ({', '.join(_KALIBR)}) nor a result of imu_utils (Gyr: x-axis: gyr_n); other YAML is"
        " not read"
    )


def _kalibr(values: Mapping[str, str], rate: float | None) -> ReadBack:
    channels: dict[str, dict[str, float]] = {}
    for key, (sensor, term) in _KALIBR.items():
        if key in values:
            channels.setdefault(sensor, {})[term] = _positive(key, values[key])
    if rate is None:
        rate = next((_positive(key, values[key]) for key in _RATES if key in values), None)
    finding = Finding(
        code="imported_without_intervals",
        severity="info",
        message="one number for all axes, without interval; files of this kind are often inflated by hand",
        effect="what is written from it is no surer, and inflated as it was",
    )
    topic = values.get("rostopic", "").strip("\"'")
    return ReadBack(
        model=NoiseModel(channels=channels),
        rate=rate,
        findings=(finding,),
        names={"topic": topic} if topic else {},
    )


def _imu_utils(values: Mapping[tuple[str, ...], str], rate: float | None) -> ReadBack:
    if rate is None:
        raise OptionError(
            "a file of imu_utils: its gyr_n and acc_n are deviations of a sample, not densities; give --rate, the sampling"
            " rate of that record in Hz, to divide by its root",
            option="rate",
        )
    channels: dict[str, dict[str, float]] = {}
    walks: list[str] = []
    for block, (sensor, prefix, _) in _IMU_UTILS.items():
        axes = [axis for axis in "xyz" if (block, f"{axis}-axis", f"{prefix}_n") in values]
        for axis in axes:
            key = (block, f"{axis}-axis", f"{prefix}_n")
            channels[f"{sensor}_{axis}"] = {"random_walk": _positive(".".join(key), values[key]) / math.sqrt(rate)}
        average = (block, "avg-axis", f"{prefix}_n")
        if not axes and average in values:
            channels[sensor] = {"random_walk": _positive(".".join(average), values[average]) / math.sqrt(rate)}
        if any(path[0] == block and path[-1] == f"{prefix}_w" for path in values):
            walks.append(f"{prefix}_w")
    if not channels:
        raise DataError("a result of imu_utils without gyr_n or acc_n of any axis")
    findings = [
        Finding(
            code="deviation_as_density",
            severity="warning",
            message=f"gyr_n and acc_n of imu_utils are deviations of a sample: divided by sqrt({rate:g} Hz)",
            effect=f"copied as densities they are {math.sqrt(rate):.3g} times too large",
            size=math.sqrt(rate),
        )
    ]
    if walks:
        findings.append(
            Finding(
                code="minimum_as_walk",
                severity="warning",
                message=f"{' and '.join(walks)} of imu_utils left out: the minimum of the Allan deviation, no random walk",
                effect="the model has no rate random walk; another unit, and a wrong number, if it is copied as one",
                remedy="analyse the record itself, or choose what to write with --rate-random-walk",
            )
        )
    return ReadBack(model=NoiseModel(channels=channels), rate=rate, findings=tuple(findings))


def _positive(key: str, text: str) -> float:
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not (math.isfinite(value) and value > 0):
        raise DataError(f"{key}: {text[:80]!r} is no positive number")
    return value


def _values(text: str) -> dict[tuple[str, ...], str]:
    """Scalars of the nested block mappings of a YAML file, by the keys that lead to them; lists are passed over.

    That is all of YAML that these files use. Raises `DataError` for a key that comes twice.
    """
    values: dict[tuple[str, ...], str] = {}
    above: list[tuple[int, str]] = []
    for line in text.removeprefix("\ufeff").split("\n"):
        match = _LINE.fullmatch(line.rstrip())
        if match is None or line.startswith("%"):
            continue
        indent, key = len(match[1]), next(name for name in match.groups()[1:4] if name is not None)
        while above and above[-1][0] >= indent:
            above.pop()
        path = (*(name for _, name in above), key)
        scalar = re.sub(r"(?:^|\s+)#.*", "", match[5] or "").strip()
        if not scalar:
            above.append((indent, key))
        elif path in values:
            raise DataError(f"{'.'.join(path)} comes twice")
        else:
            values[path] = scalar
    return values
