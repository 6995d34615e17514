"""What all results share: findings, number formats, plain dictionaries."""

from __future__ import annotations

import html
import math
from dataclasses import dataclass
from typing import Any, Literal

__all__ = ["Finding", "Printed", "Severity", "seconds", "value_error_text"]

Severity = Literal["info", "warning", "error"]


class Printed:
    """A result that shows in a notebook what it prints."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Something that the user should know about the record before trusting a number.

    Attributes
    ----------
    code : str
        Stable name of the kind of finding, e.g. ``"constant_channel"``.
    severity : {"info", "warning", "error"}
    message : str
        What was found, where, and how large.
    channel : str or None
        The channel concerned; None for the whole record.
    effect : str
        What it does to which coefficient, and the remedy; may be empty.
    """

    code: str
    severity: Severity
    message: str
    channel: str | None = None
    effect: str = ""

    def to_dict(self) -> dict[str, Any]:
        return {
            "code": self.code,
            "severity": self.severity,
            "channel": self.channel,
            "message": self.message,
            "effect": self.effect,
        }

    def __str__(self) -> str:
        where = f"{self.channel}: " if self.channel else ""
        return f"{self.severity}: {where}{self.message}" + (f" ({self.effect})" if self.effect else "")


def value_error_text(value: float, error: float) -> str:
    """``0.973 ± 0.074``: the error with two significant digits, a last digit of 0 dropped; the value with as many decimals.

    Two digits, because the paper prints ``0.973 ± 0.074``; without a trailing zero, because it prints ``0.0015 ± 0.0005``.
    """
    if not (math.isfinite(error) and error > 0):
        return f"{value:.6g} ± {error:.2g}"
    mantissa, exponent = f"{error:.1e}".split("e")
    decimals = 1 - int(exponent)
    if mantissa.endswith("0"):
        decimals -= 1
    if decimals > 12 or decimals < -6:
        return f"{value:.4g} ± {error:.2g}"
    digits = max(decimals, 0)
    return f"{round(value, decimals):.{digits}f} ± {round(error, decimals):.{digits}f}"


def seconds(value: float) -> str:
    """A time with three significant digits and never an exponent of a thousand: ``0.01``, ``40.96`` as ``41``, ``1311``."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
