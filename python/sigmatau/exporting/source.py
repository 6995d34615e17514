"""`Source`: noise model with sampling rates and sample variances, read from a model file, a result or a YAML file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.read_back import read_yaml
from sigmatau.findings.finding import Finding
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import stream_name
from sigmatau.results import Printed

_SAME_RATE = 1e-3  # relative difference of rates: two sensors of one unit, each with its own stamps
_FILTER = "low_pass_filter"
_SHORTEST_MEANS = 32  # samples; shorter means leave noise of the minimum of the curve out of the variance


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """Measured variance of a sample."""

    variance: float  # About the mean over `time`. [(rate unit)²]
    time: float  # Length of this mean. [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Source(Printed):
    """A noise model and the data about its record that an export needs."""

    model: NoiseModel
    rates: Mapping[str, float]  # Sampling rate by channel, if known. [Hz]
    findings: tuple[Finding, ...] = ()  # Findings about the file that was read
    # Corner of the low-pass filter that the analysis found, by channel. [Hz]
    corners: Mapping[str, float] = field(default_factory=dict)
    samples: Mapping[str, Sample] = field(default_factory=dict)  # Measured variance of a sample, by channel
    # Fields of the file beside the noise parameters, such as a topic
    names: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of_model(cls, model: NoiseModel) -> Source:
        """The source of a model; the sampling rate is known if the model is from a fit."""
        return cls(model=model, rates={name: channel.rate for name, channel in model.channels.items() if channel.rate})

    @classmethod
    def of_result(cls, content: Mapping[str, Any]) -> Source:
        """The source of a result of `analyze`, in the form of ``to_dict`` or its JSON; raises `DataError` if invalid."""
        plain = cls.of_model(NoiseModel.from_result(content))
        corners: dict[str, float] = {}
        samples: dict[str, Sample] = {}
        try:
            for finding in content.get("findings", ()):
                if finding.get("code") == _FILTER:
                    channels = finding.get("channels") or [finding.get("channel")]
                    corners |= {name: float(finding["size"]) for name in channels if name in plain.model.channels}
            for name in plain.model.channels:
                _check_rate(content["channels"][name]["sample_rate_hz"])
                if (sample := _sample(content["channels"][name]["curve"])) is not None:
                    samples[name] = sample
        except (LookupError, TypeError, AttributeError, ValueError) as error:
            raise DataError(f"not a result of sigmatau analyze ({error!r} is missing or wrong)") from None
        return replace(plain, corners=corners, samples=samples)

    def of(self, channels: Iterable[str]) -> Source:
        """The same with some of the channels."""
        return replace(self, model=self.model.of(channels))

    def __repr__(self) -> str:
        return "\n".join([repr(self.model), *map(str, self.findings)])


def source_of(given: object) -> Source:
    """The source of a model or an analysis; raises `OptionError` for other types."""
    if isinstance(given, Source):
        return given
    if isinstance(given, NoiseModel):
        return Source.of_model(given)
    make = getattr(given, "to_source", None)  # an Analysis, which this package cannot import
    if callable(make) and not isinstance(given, type):
        made: Source = make()
        return made
    more = ""
    if isinstance(given, str | Path):
        more = f": read it first, sigmatau.exporting.source.read_source({str(given)!r})"
    elif hasattr(given, "streams"):
        more = ": analyse it first, sigmatau.analyze(record)"
    raise OptionError(
        f"{{option}} must be a NoiseModel or an Analysis, not {type(given).__name__}{more}", option="model"
    )


def read_source(path: str | Path, *, rate: float | None = None) -> Source:
    """Read a model file (.toml), a result of ``sigmatau analyze`` (.json), or a YAML file of Kalibr or imu_utils.

    `rate`: sampling rate; replaces that of a YAML file [Hz].
    """
    path = Path(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        try:
            back = read_yaml(path.read_text(encoding="utf-8-sig"), rate=rate)
        except OSError as error:
            raise DataError(f"{path}: {error.strerror or error}") from None
        except OptionError as error:
            raise error.about(str(path)) from None
        except ValueError as error:  # includes DataError and UnicodeDecodeError
            raise DataError(f"{path}: {error}") from None
        rates = {} if back.rate is None else dict.fromkeys(back.model.channels, back.rate)
        return Source(model=back.model, rates=rates, findings=back.findings, names=back.names)
    model = NoiseModel.read(path)
    if path.suffix.lower() != ".json":
        return Source.of_model(model)
    content = json.loads(path.read_text(encoding="utf-8-sig"))
    try:
        source = Source.of_result(content)
    except DataError as error:
        raise DataError(f"{path}: {error}") from None
    return source


def _sample(curve: Mapping[str, Any]) -> Sample | None:
    """The variance of a sample, from the Allan variances up to the minimum of the curve.

    A record minus its means of 2ᵏ samples is the sum of the differences of neighbouring means of 1, 2, 4 … 2ᵏ⁻¹ samples
    (Haar's decomposition), so that its variance is half the sum of their Allan variances. It includes filtered noise, lines
    and quantization. None if the curve lacks an octave, or ends before means of 32 samples.
    """
    pairs = zip(curve["m"], curve["adev"], strict=True)
    adev = {m: float(sigma) for m, sigma in pairs if sigma is not None}
    if 1 not in adev:
        return None
    lowest = max(min(adev, key=lambda m: adev[m]), _SHORTEST_MEANS)
    octaves = [2**k for k in range(int(lowest).bit_length())]
    if not all(m in adev for m in octaves) or not octaves[-1] >= _SHORTEST_MEANS:
        return None
    last = octaves[-1]
    means = adev[last] ** 2 / 2  # variance of the means, if their noise is white
    time = 2 * last * float(curve["tau_s"][0])
    return Sample(variance=sum(adev[m] ** 2 for m in octaves) / 2 + means, time=time)


def _check_rate(value: object) -> None:
    """Raise `ValueError` for an invalid sampling rate."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
        raise ValueError(f"sample_rate_hz {value!r}, which is not a positive number,")


def one_rate(rates: Mapping[str, float]) -> float | None:
    """The sampling rate of gyros and accelerometers; None if not known."""
    found = {name: rate for name, rate in rates.items() if stream_name(name) in ("gyro", "accel")} or dict(rates)
    if not found:
        return None
    if max(found.values()) > (1 + _SAME_RATE) * min(found.values()):
        listed = ", ".join(f"{name} {rate:.6g} Hz" for name, rate in found.items())
        raise OptionError(
            f"the channels have several sampling rates ({listed}): give {{option}} of the filter", option="rate"
        )
    return next(iter(found.values()))
