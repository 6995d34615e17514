"""What is exported from: a model file, the JSON of an analysis, or another program's YAML; by its ending."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.export.read_back import read_yaml
from sigmatau.model import NoiseModel
from sigmatau.record import stream_name
from sigmatau.results import Finding, Printed

__all__ = ["Source", "one_rate", "read_source"]

_SAME = 1e-3  # relative: two sensors of one unit, each with its own stamps


@dataclass(frozen=True, slots=True, kw_only=True)
class Source(Printed):
    """What is exported from.

    Attributes
    ----------
    model : NoiseModel
    rates : mapping of str to float
        Sampling rate by channel, where it is known. [Hz]
    findings : tuple of Finding
        What should be known of it.
    """

    model: NoiseModel
    rates: Mapping[str, float]
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        return "\n".join([repr(self.model), *map(str, self.findings)])


def read_source(path: str | Path, *, rate: float | None = None) -> Source:
    """Read a model file (.toml), a result of ``sigmatau analyze`` (.json), or a YAML of Kalibr's kind or imu_utils'.

    Parameters
    ----------
    path : str or Path
    rate : float, optional
        Sampling rate, in place of the file's. [Hz]

    Raises
    ------
    DataError
        If the file cannot be read or understood.
    OptionError
        If it needs a rate and none is given.
    """
    path = Path(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        try:
            back = read_yaml(path.read_text(encoding="utf-8"), rate=rate)
        except OSError as error:
            raise DataError(f"{path}: {error.strerror or error}") from None
        except OptionError as error:
            raise OptionError(f"{path}: {error}", option=error.option) from None
        except ValueError as error:  # of which a DataError and Unicode's are kinds
            raise DataError(f"{path}: {error}") from None
        rates = {} if back.rate is None else dict.fromkeys(back.model.channels, back.rate)
        return Source(model=back.model, rates=rates, findings=back.findings)
    model = NoiseModel.read(path)
    rates = dict.fromkeys(model.channels, rate) if rate is not None else {}
    if path.suffix.lower() == ".json" and rate is None:
        channels = json.loads(path.read_text(encoding="utf-8"))["channels"]
        try:
            rates = {name: _rate(channels[name]["sample_rate_hz"]) for name in model.channels}
        except (KeyError, TypeError, ValueError) as error:
            raise DataError(f"{path}: not a result of sigmatau analyze ({error!r} is missing or wrong)") from None
    return Source(model=model, rates={name: value for name, value in rates.items() if value is not None})


def _rate(value: object) -> float:
    """A sampling rate of a result; raises `ValueError` for what is none."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise ValueError(f"sample_rate_hz {value!r}, which is no positive number,")
    return float(value)


def one_rate(rates: Mapping[str, float]) -> float | None:
    """The sampling rate of gyros and accelerometers, None if it is not known.

    Raises
    ------
    OptionError
        If they differ: a filter has one.
    """
    found = {name: rate for name, rate in rates.items() if stream_name(name) in ("gyro", "accel")} or dict(rates)
    if not found:
        return None
    if max(found.values()) > (1 + _SAME) * min(found.values()):
        listed = ", ".join(f"{name} {rate:.6g} Hz" for name, rate in found.items())
        raise OptionError(
            f"the channels have several sampling rates ({listed}): give --rate, the filter's", option="rate"
        )
    return next(iter(found.values()))
