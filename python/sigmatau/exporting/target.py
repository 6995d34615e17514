"""`Target`: a program that reads noise parameters, and the writer of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from sigmatau.exporting.values import Numbers


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A target of ``sigmatau export``."""

    name: str  # As it is typed
    summary: str  # One line of ``sigmatau export --list``: what the file contains and how the program interprets it
    ending: str  # File name extension, with the dot
    write: Callable[[Numbers], str | bytes]  # From `Numbers` to the text of the file; bytes where the file is binary
    needs_rate: bool = False  # Whether the file depends on the sampling rate
    has_step: bool = False  # Whether the file depends on the step of the filter, so that ``step`` can be chosen
    has_horizon: bool = False  # Whether the file depends on ``horizon`` without ``walk="horizon"`` too
    per_axis: bool = False  # Whether the file has a field for each axis, so that ``axes="each"`` can be chosen
    every_axis: bool = False  # Whether the file always has each axis separately
    # Writers of other forms of the file, by extension, from `Numbers` to bytes
    binary: Mapping[str, Callable[[Numbers], bytes]] = field(default_factory=dict)
    # Fields beside the noise parameters, with their defaults: ``{"topic": "/imu0"}``
    names: Mapping[str, str] = field(default_factory=dict)
