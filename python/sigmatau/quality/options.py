"""Options of the checks that need no fit, for `sigmatau.inspect` and `sigmatau.analyze`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

from sigmatau.frozen import frozen
from sigmatau.io.read.options import ReadOptions
from sigmatau.options import option, same_option

Bandwidth = Mapping[str, tuple[float, int | None]]
"""Bandwidth of the sensor in Hz and order of its filter, if known, by channel or stream."""


@frozen
class CheckOptions:
    """Options of the checks."""

    leave_out: str | Sequence[str] | None = field(
        default=None,
        metadata=option(
            "Selection",
            "Times to treat as missing, 720s:722s,1080s:1083s from the beginning of the log.",
            "Default: none.",
            form="spans",
            kind="str or sequence of str, optional",
        ),
    )
    keep: str | Sequence[str] = field(
        default=(),
        metadata=option(
            "Selection",
            "Disturbances to keep in the analysis: dropouts, saturation, stuck, interpolated, copies, start, shocks, spikes"
            " (with commas between), or all; or times in which nothing is left out, 12s:12.5s.",
            "Default: none; they are treated as missing, with a finding.",
            form="texts",
            kind="str or sequence of str",
        ),
    )
    bandwidth: Bandwidth | None = field(
        default=None,
        metadata=option(
            "Method",
            "Bandwidth of the sensor from its datasheet. A finding then reports the random walk that aliasing adds.",
            "Default: unknown.",
            form="bandwidths",
            unit="Hz",
            kind="mapping of str to (float, int or None), optional",
            python='With the order of the filter if it is known: ``{"gyro": (30.0, 1)}``; see `sigmatau.check`.',
            typed="Example: gyro=30Hz, or gyro=30Hz/2 for a second-order filter.",
        ),
    )

    def __post_init__(self) -> None:
        _ = self.kept_causes, self.kept_spans  # raise an error for a word that is neither

    @property
    def kept_causes(self) -> tuple[str, ...]:
        """Causes of disturbances that are not left out."""
        from sigmatau.quality.selection.exclusion import causes_to_keep  # which imports the checks

        return causes_to_keep(self.keep)

    @property
    def kept_spans(self) -> tuple[tuple[float, float], ...]:
        """Times in which no disturbance is left out. [s]"""
        from sigmatau.quality.selection.exclusion import spans_to_keep

        return spans_to_keep(self.keep)


@frozen
class InspectOptions(ReadOptions):
    """Options of `sigmatau.inspect`: those of reading, and those of the checks that need no fit."""

    leave_out: str | Sequence[str] | None = same_option(CheckOptions, "leave_out")
    keep: str | Sequence[str] = same_option(CheckOptions, "keep")
    bandwidth: Bandwidth | None = same_option(CheckOptions, "bandwidth")
