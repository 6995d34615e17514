"""What a target is: a program that reads noise parameters, and how its file is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from sigmatau.exporting.values import Numbers

__all__ = ["Target"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A target of ``sigmatau export``.

    Attributes
    ----------
    name : str
        As it is typed.
    summary : str
        One line of ``sigmatau export --list``: what is written, and what the program makes of it.
    ending : str
        Of its file, with the dot.
    write : callable
        From `Numbers` to the text of the file; bytes where the file is binary.
    needs_rate : bool
        Whether the sampling rate enters, and must be known.
    has_step : bool
        Whether a step of the filter enters, so that ``step`` can be chosen.
    has_horizon : bool
        Whether a horizon enters by itself, and not only through a walk that stands for the model there.
    per_axis : bool
        Whether it has a place for each axis, so that ``axes="each"`` can be chosen.
    every_axis : bool
        Whether it holds each axis by itself whatever is chosen.
    binary : mapping of str to callable
        Other forms of its file by their ending, from `Numbers` to bytes.
    names : mapping of str to str
        Names that it has beside the numbers, with what stands there if none is given: ``{"topic": "/imu0"}``.
    """

    name: str
    summary: str
    ending: str
    write: Callable[[Numbers], str | bytes]
    needs_rate: bool = False
    has_step: bool = False
    has_horizon: bool = False
    per_axis: bool = False
    every_axis: bool = False
    binary: Mapping[str, Callable[[Numbers], bytes]] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
