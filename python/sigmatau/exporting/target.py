"""`Target`: declaration of a target of an export."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Literal

from sigmatau.exporting.values import Numbers
from sigmatau.frozen import frozen


@frozen
class Unused:
    """Choices without a field in a target."""

    choices: tuple[str, ...]  # attributes of `Choices`
    why: str
    when: Callable[[Numbers], bool] | None = None  # condition on models and other choices; None: always


@frozen
class Target:
    """A target of ``sigmatau export``."""

    name: str  # Name as it is typed: that of its module
    program: str = ""  # Program in the tables of docs/how-to/README.md; empty for a target that is not listed there
    columns: tuple[str, str] = (
        "",
        "",
    )  # Cells of that table: form of N and of K; for other targets, the content and the requirements
    aliases: tuple[str, ...] = ()  # Other names of the same program
    summary: str  # One line of ``sigmatau export --list``: what the file contains and how the program interprets it
    ending: str  # File name extension, with the dot
    write: Callable[[Numbers], str | bytes]  # Writes `Numbers` as the text of the file; bytes if the file is binary
    sensors: Literal["both", "either", "any"] = "both"  # Gyro and accelerometer, either sensor, or any signals
    needs_axes: bool = False  # Whether ``axes="each"`` needs x, y and z of each sensor
    needs_step: bool = False  # Whether the file depends on a step from the record or the user
    may_need_rate: bool = False  # Whether some noise needs the rate of the filter: checked before the analysis
    needs_rate: bool = False  # Whether the file depends on the rate of the filter
    has_rate_field: bool = False  # Whether this rate is only a field of the file and does not affect its densities
    has_step: bool = False  # Whether the file depends on the step of the filter, so that ``step`` can be chosen
    has_walk: bool = False  # Whether the file has N and K, and no other field for slow noise
    has_unobserved: bool = False  # Whether a file with more than N and K depends on `Choices.unobserved`
    has_process: bool = False  # Whether the file has slow noise as one Gauss-Markov process
    has_consistent: bool = False  # Whether this process is that of a consistent filter unless a walk is chosen
    has_horizon: bool = False  # Whether the file depends on ``horizon`` even without ``walk="horizon"``
    unused: tuple[Unused, ...] = ()  # Further choices without a field, with reasons
    per_axis: bool = False  # Whether the file has a field for each axis, so that ``axes="each"`` can be chosen
    every_axis: bool = False  # Whether the file always has each axis separately
    # Writers of other forms of the file, by extension, from `Numbers` to bytes
    binary: Mapping[str, Callable[[Numbers], bytes]] = field(default_factory=dict)
    text: str = ""  # Text of a target that is a template, see `sigmatau.exporting.template`
    # Fields besides the noise parameters, with their defaults: ``{"topic": "/imu0"}``
    names: Mapping[str, str] = field(default_factory=dict)
    # Allowed values of fields that have only a few
    name_values: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
