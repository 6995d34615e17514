"""Phrases that the words of findings share: names of axes, times, shares, factors."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from sigmatau.digits import significant
from sigmatau.findings.finding import Span
from sigmatau.hints import Hint, as_options, worded
from sigmatau.noise.terms import TERMS

LONGEST = 120
"""Largest number of characters of a message or an action, so that each fits on one or two lines of a terminal."""

LONGEST_NAME = 24
"""Largest number of characters of a name in a list."""

_NAMES_LISTED = 6

_MANY = 8
"""Number of stretches above which an option joins neighbours that are less than `_TOGETHER` apart."""

_TOGETHER = 1.0  # distance of stretches that are joined [s]

_DIGITS = 3  # decimals of a second in an option; ends are rounded outwards


def short_axes(channels: Sequence[str]) -> str:
    """``"gyro x, y, accel z"`` of ``gyro_x``, ``gyro_y`` and ``accel_z``; a sensor with three axes is its name."""
    by_sensor: dict[str, list[str]] = {}
    for channel in channels:
        sensor, _, axis = channel.rpartition("_")
        by_sensor.setdefault(sensor or channel, []).extend([axis] if sensor else [])
    return ", ".join(
        f"{sensor} {', '.join(axes)}" if 0 < len(axes) < 3 else sensor for sensor, axes in by_sensor.items()
    )


def clock(time: float) -> str:
    """A time from the beginning of the record: ``"12.34 s"``, ``"2400 s"``."""
    return f"{time:.4g} s" if time < 1000 else f"{time:.0f} s"


def while_short(text: str, additions: Iterable[str], *, between: str = "; ", longest: int = LONGEST) -> str:
    """Append as many additions, in order, as fit in a sentence."""
    for addition in filter(None, additions):
        if sum(len(worded(part, as_options)) for part in (text, between, addition)) <= longest:
            text += between + addition
    return text


def shortened(text: str, longest: int = 60) -> str:
    """The beginning of a long text: ``"invalid header in the mid…"``."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def plural(count: int, noun: str) -> str:
    """``"1 row"``, ``"5 rows"`` of ``"rows"``."""
    return f"{count} {noun if count != 1 else noun.removesuffix('s')}"


def listed(names: tuple[str, ...]) -> str:
    """List as many names as fit in a message: ``"a, b and 7 more"``."""
    shown = ", ".join(shortened(name, LONGEST_NAME) for name in names[:_NAMES_LISTED])
    while len(shown) > LONGEST - 40 and "," in shown:
        shown = shown.rpartition(", ")[0]
    rest = len(names) - shown.count(", ") - 1
    return f"{shown} and {rest} more" if rest > 0 else shown


def percent(share: float) -> str:
    """A share with two digits: ``"3.8 %"``, ``"42 %"``."""
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def factor_text(term: str, factor: float, *, quantity: str = "") -> str:
    """A factor on a coefficient: ``"random walk 3.8 % too large"``, ``"random walk 4.1 times too large"``."""
    label = TERMS[term].label(quantity) if term in TERMS else term
    off = abs(factor - 1)
    if not math.isfinite(factor):
        return f"{label} unknown"
    if off < 0.2:
        return f"{label} {100 * off:.2g} % too {'large' if factor > 1 else 'small'}"
    if factor > 1:
        return f"{label} {significant(factor)} times too large"
    return f"{label} {significant(1 / factor)} times too small" if factor > 0 else f"{label} hidden"


def largest_factor_text(factors: Sequence[tuple[str, float]], *, quantity: str = "", channel: str = "") -> str:
    """The factor farthest from 1, with its channel if that is named; empty without factors."""
    if not factors:
        return ""
    term, factor = max(factors, key=lambda pair: abs(math.log(pair[1])) if 0 < pair[1] < math.inf else math.inf)
    text = "no coefficient changed" if abs(factor - 1) < 5e-4 else factor_text(term, factor, quantity=quantity)
    return f"{text} on {channel}" if channel else text


def leave_out_hint(spans: Sequence[Span], *, longest: int = LONGEST) -> Hint:
    """The option that leaves some stretches out: ``720s:722s,1080s:1083.2s``.

    Parameters
    ----------
    spans : sequence of (float, float)
        From the beginning of the log. [s] The longest are named, as many as fit.
    longest : int
        Characters of the option, as it is typed.
    """
    joined: list[Span] = []
    for start, stop in sorted(spans):
        if joined and start - joined[-1][1] <= (_TOGETHER if len(spans) > _MANY else 0.0):
            joined[-1] = (joined[-1][0], max(stop, joined[-1][1]))
        else:
            joined.append((start, stop))
    room, named = longest - len(as_options([Hint("leave_out")])), list[tuple[float, str]]()
    for start, stop in sorted(joined, key=lambda span: span[0] - span[1]):
        text = f"{_in_seconds(start, math.floor)}:{_in_seconds(stop, math.ceil)}"
        room -= len(text) + 1
        if room < 0 and named:
            break
        named.append((start, text))
    return Hint("leave_out", value=",".join(text for _, text in sorted(named)))


def window_hint(span: tuple[float | None, float | None]) -> Hint:
    """The option that keeps a part of a log: ``600s:``; None for an end of the record."""
    start, stop = span
    begins = "" if start is None else _in_seconds(start, math.ceil)
    return Hint("window", value=f"{begins}:{'' if stop is None else _in_seconds(stop, math.floor)}")


def _in_seconds(time: float, to_whole: Callable[[float], int]) -> str:
    scale = 10**_DIGITS
    whole = to_whole(round(time * scale, 3))  # three more digits, to absorb rounding
    return f"{whole / scale:.{_DIGITS}f}".rstrip("0").rstrip(".") + "s"
