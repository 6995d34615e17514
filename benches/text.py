"""Tables and gates of the page."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Gate:
    """A target and the measured value."""

    what: str
    aim: str
    got: str
    passed: bool


def at_least(what: str, got: float, least: float) -> Gate:
    """Gate for a ratio with a smallest value."""
    return Gate(what, f"≥ {least:g}×", times(got), got >= least)


def at_least_percent(what: str, got: float, least: float) -> Gate:
    """Gate for a share with a smallest value."""
    return Gate(what, f"≥ {least:g} %", f"{got:.0f} %", got >= least)


def at_most(what: str, got: float, most: float, unit: str, *, digits: int = 3) -> Gate:
    """Gate for a value with a largest value."""
    return Gate(what, f"≤ {most:g} {unit}", f"{got:.{digits}g} {unit}", got <= most)


def times(ratio: float) -> str:
    """A ratio as printed."""
    return f"{ratio:.1f}×" if ratio < 99.95 else f"{ratio:.0f}×"


def share(least: float, got: float) -> str:
    """Share of the possible speed, in per cent."""
    return f"{100 * least / got:.0f} %"


def seconds(value: float) -> str:
    """A time with three digits and its unit."""
    for factor, unit in ((1, "s"), (1e3, "ms")):
        if value * factor >= 1:
            return f"{_three(value * factor)} {unit}"
    return f"{_three(value * 1e6)} µs"


def size(value: float) -> str:
    """A number of bytes in MB."""
    return f"{_three(value / 1e6)} MB"


def number(n: int) -> str:
    """Print a number of samples."""
    return f"{n:,}".replace(",", " ")


def prose(*sentences: str) -> list[str]:
    """Lines of a paragraph, and an empty one."""
    return [*textwrap.wrap(" ".join(sentences), 120, break_long_words=False, break_on_hyphens=False), ""]


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table, and an empty one."""
    lines = ["| " + " | ".join(cells) + " |" for cells in (head, *rows)]
    return [lines[0], "|" + "---|" * len(head), *lines[1:], ""]


def gates(found: Sequence[Gate]) -> list[str]:
    """Lines of the gates of a section, and an empty one."""
    return [
        *(
            f"- {g.what}: target {g.aim}, measured {g.got}: **{'reached' if g.passed else 'not reached'}**"
            for g in found
        ),
        "",
    ]


def _three(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:#.3g}".rstrip(".")
