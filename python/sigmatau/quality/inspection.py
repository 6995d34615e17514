"""What is in a log, and what is wrong with it: that of the file, and that of its samples."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from sigmatau.errors import DataError
from sigmatau.estimators.allan import allan
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.fit import CheckedWithoutFit
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.io.read import inspection
from sigmatau.io.read.inspection import Inspection
from sigmatau.quality import curve_checks
from sigmatau.quality.causes import one_cause
from sigmatau.quality.check import Bandwidth, check, check_fits, with_fits
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.selection.exclusion import leave_out as leave_out_of
from sigmatau.record import memory
from sigmatau.record.record import Record

__all__ = ["FITTED", "Inspection", "inspect"]

FITTED = 8_000_000
"""So many samples, of all channels together, are fitted in passing: some seconds on one core."""


def inspect(
    path: str | os.PathLike[str],
    *,
    bandwidth: Bandwidth | None = None,
    leave_out: str | Sequence[str] | None = None,
    **reading: Any,  # noqa: ANN401
) -> Inspection:
    """What a file holds, and what is wrong with it and with the samples that would be analysed.

    Nothing has to be known of the file. Tables with a sensor by the names of their columns, and those that are asked for by
    `topic` or `channels`, are read; of the others only names are told.

    Parameters
    ----------
    path : str or path
    bandwidth : mapping of str to (float, int or None), optional
        The sensors' own bandwidth, see `sigmatau.check`. [Hz]
    leave_out : str or sequence of str, optional
        Stretches to take for missing before the samples are checked, see `sigmatau.analyze`.
    **reading
        As `sigmatau.read` takes them: then it is said what would come of it.

    Returns
    -------
    Inspection

    Raises
    ------
    DataError
        If nothing of the file can be read.
    OptionError
        For an option of the wrong form, a topic or a sensor that is not there.
    """
    found = inspection.inspect(path, **reading)
    if found.record is None:
        return found
    record = from_the_start(found.record)
    left: list[Finding] = []
    if leave_out is not None:
        record, left = leave_out_of(record, leave_out)
    nothing = [finding for stream in record.streams for finding in curve_checks.constant_channels(stream)]
    checked = [*left, *nothing, *check(record, bandwidth=bandwidth)]
    return replace(found, record=record, checks=tuple(_against_fits(record, checked)))


def _against_fits(record: Record, found: Sequence[Finding]) -> list[Finding]:
    """With what shows only against the noise that is fitted, as `sigmatau.analyze` finds it."""
    streams = [stream for stream in record.streams if stream.quantity != "temperature"]
    number = sum(stream.grid.n * len(stream.channels) for stream in streams)
    if number > FITTED or not all(memory.fits(stream, None) for stream in streams):
        return [*found, Finding(details=CheckedWithoutFit(samples=number), severity="info")]
    fits: dict[str, NoiseFit] = {}
    for stream in streams:
        for channel in stream.channels:
            with contextlib.suppress(DataError):  # too short, or too much is missing: then there is nothing to judge by
                curve = allan(Record(streams=(stream.only(channel),)))[channel]
                if curve_checks.LEAST < curve.avar.max() < curve_checks.LARGEST and curve.adev.max() > (
                    curve_checks.rounding(stream, channel)
                ):
                    fits[channel] = fit(curve)
    told = [*with_fits(record, fits, found), *check_fits(record, fits, found=found)]
    return one_cause(told, list(fits), max((stream.grid.duration for stream in streams), default=0.0))
