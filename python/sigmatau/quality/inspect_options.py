"""The options of `sigmatau.inspect`: those of reading, and those of the checks that need no fit."""

from __future__ import annotations

from collections.abc import Sequence

from sigmatau.frozen import frozen
from sigmatau.io.read.options import ReadOptions
from sigmatau.options import same_option
from sigmatau.quality.options import Bandwidth, CheckOptions


@frozen
class InspectOptions(ReadOptions):
    """Options of `sigmatau.inspect`."""

    leave_out: str | Sequence[str] | None = same_option(CheckOptions, "leave_out")
    keep: str | Sequence[str] = same_option(CheckOptions, "keep")
    bandwidth: Bandwidth | None = same_option(CheckOptions, "bandwidth")
