"""What a lot keeps of one unit: a result of `analyze` without what no comparison needs, so that thousands fit in memory."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.analysis import Analysis
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.model.from_result import WITHOUT_REST
from sigmatau.noise.terms import TERMS

Floats = NDArray[np.float64]

_MOST_SAMPLES = 2**53  # whole numbers that a float holds exactly
_SEVERITIES = ("info", "warning", "error")


@frozen
class Coefficient:
    """A coefficient, or the standard deviation of means, in SI; a ramp without its sign.

    Attributes
    ----------
    value : float or None
        None if it was not observed. [SI]
    low, high : float or None
        Its interval; None without one. [SI]
    limit : float or None
        Upper limit if it was not observed. [SI]
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    limit: float | None = None


@frozen(eq=False)
class UnitChannel:
    """One channel of a unit.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    unit : str
        Quantity and unit of the rate; SI.
    rate : float
        Sampling rate. [Hz]
    samples : int
        Samples in the record.
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    adev : ndarray, shape (n_tau,)
        Allan deviation. [unit]
    coefficients : mapping of str to Coefficient
        By term, and by ``"means_10"`` and ``"means_100"``.
    trust : str
        ``"good"``, ``"partial"`` or ``"poor"``; empty if not known.
    """

    quantity: str
    unit: str
    rate: float
    samples: int
    tau: Floats
    adev: Floats
    coefficients: Mapping[str, Coefficient]
    trust: str = ""

    @property
    def duration(self) -> float:
        """Length of the record. [s]"""
        return self.samples / self.rate


@frozen
class UnitFinding:
    """A finding of the analysis of a unit, with its words, which are only shown.

    Attributes
    ----------
    code : str
        Code of the finding.
    severity : {"info", "warning", "error"}
    channels : tuple of str
        The channels concerned; empty for the whole record.
    told : str
        Message.
    advice : str
        What to do; empty if there is nothing to do.
    left_out : int
        Samples that were treated as missing for it.
    """

    code: str
    severity: str
    channels: tuple[str, ...]
    told: str
    advice: str
    left_out: int = 0


@frozen(eq=False)
class UnitResult:
    """The result of one unit, or why there is none.

    Attributes
    ----------
    path : str
        File of the result; empty if it came from memory.
    sha256 : str
        Checksum of the log; empty if not known.
    channels : mapping of str to UnitChannel
        By name.
    findings : tuple of UnitFinding
        Findings of the analysis.
    rest : str
        Verdict about rest, as in `Analysis.rest`; empty if not known.
    error : str
        Why the unit has no result; empty if it has one.
    absent : bool
        Whether there is no file at all.
    """

    path: str = ""
    sha256: str = ""
    channels: Mapping[str, UnitChannel] = field(default_factory=dict)
    findings: tuple[UnitFinding, ...] = ()
    rest: str = ""
    error: str = ""
    absent: bool = False


def without_result(error: str, *, path: str = "", absent: bool = False) -> UnitResult:
    """A unit whose log or result cannot be read."""
    return UnitResult(error=error, path=path, absent=absent)


def content_of(result: Analysis | Mapping[str, Any] | str | Path) -> dict[str, Any]:
    """The JSON form of a result, from an analysis or a file; raises `DataError`."""
    if isinstance(result, Analysis):
        return result.to_dict()
    if isinstance(result, Mapping):
        return dict(result)
    path = Path(result)
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: not JSON: {error}") from None
    if not isinstance(content, dict):
        raise DataError(f"{path}: not a result of sigmatau analyze: no channels")
    return content


def unit_of(content: Mapping[str, Any]) -> UnitResult:
    """The result of a unit from the JSON form of its analysis; raises `DataError` if it is not one."""
    error = content.get("error")
    source = content.get("source")
    path = str(source.get("path") or "") if isinstance(source, Mapping) else ""
    if error is not None:
        message = error.get("message") if isinstance(error, Mapping) else error
        return without_result(str(message)[:500] or "the analysis failed", path=path)
    channels = content.get("channels")
    if not isinstance(channels, Mapping) or not channels:
        raise DataError("not a result of sigmatau analyze: it has no channels")
    rest = content.get("rest")
    verdict = str(rest.get("verdict", "")) if isinstance(rest, Mapping) else ""
    found = {}
    for name, channel in channels.items():
        try:
            found[str(name)] = _channel(channel)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as problem:
            raise DataError(f"channel {name!r}: not a result of sigmatau analyze ({problem!r})") from None
    try:
        findings = tuple(_finding(one) for one in content.get("findings") or ())
    except (TypeError, ValueError, AttributeError, OverflowError):
        raise DataError("not a result of sigmatau analyze, or changed: its findings are of another form") from None
    return UnitResult(
        path=path,
        sha256=str(source.get("sha256") or "") if isinstance(source, Mapping) else "",
        channels=found,
        findings=findings,
        rest=verdict,
    )


def reason_without_rest(unit: UnitResult) -> str:
    """Why a unit has no coefficients, if it was not at rest or its record is too short to tell; else empty."""
    has = any(channel.coefficients for channel in unit.channels.values())
    return "" if has else WITHOUT_REST.get(unit.rest, "")


def _channel(channel: Mapping[str, Any]) -> UnitChannel:
    curve = channel["curve"]
    tau, adev = (np.asarray(curve[key], dtype=np.float64) for key in ("tau_s", "adev"))
    if not (tau.shape == adev.shape and tau.ndim == 1 and len(tau) and np.isfinite(tau).all() and (tau > 0).all()):
        raise ValueError("tau_s and adev are not a curve")
    rate, samples = float(channel["sample_rate_hz"]), int(channel["samples"])
    if not (math.isfinite(rate) and rate > 0 and 0 < samples < _MOST_SAMPLES):
        raise ValueError(f"{samples} samples at {rate} Hz")
    terms = (channel.get("fit") or {}).get("terms") or {}
    coefficients = {name: _coefficient(terms[name]) for name in TERMS if name in terms}
    for row in channel.get("mean_stability") or ():
        coefficients[f"means_{row['average_s']:.3g}"] = _coefficient(row)
    return UnitChannel(
        quantity=str(channel["quantity"]),
        unit=str(curve["unit"]),
        rate=rate,
        samples=samples,
        tau=tau,
        adev=adev,
        coefficients=coefficients,
        trust=str(channel.get("trust", "")),
    )


def _coefficient(term: Mapping[str, Any]) -> Coefficient:
    numbers = {key: _number(term.get(key)) for key in ("value", "low", "high", "upper_limit")}
    value, low, high = (None if numbers[key] is None else abs(numbers[key] or 0.0) for key in ("value", "low", "high"))
    if low is not None and high is not None:
        across = (numbers["low"] or 0.0) < 0 < (numbers["high"] or 0.0)
        low, high = 0.0 if across else min(low, high), max(low, high)
    return Coefficient(value=value, low=low, high=high, limit=numbers["upper_limit"])


def _number(value: object) -> float | None:
    """A finite number, or None."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{value!r:.40} is not a number")
    return float(value)


def _finding(one: Mapping[str, Any]) -> UnitFinding:
    severity = str(one.get("severity", "info"))
    return UnitFinding(
        code=str(one.get("code", "")),
        severity=severity if severity in _SEVERITIES else "warning",
        channels=tuple(str(name) for name in one.get("channels") or ()),
        told=str(one.get("message", ""))[:500],
        advice=str(one.get("action", ""))[:500],
        left_out=int(one.get("left_out") or 0),
    )
