"""What is in a log, and what is wrong with it: that of the file, and that of its samples."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

from sigmatau.diagnose import Bandwidth, check
from sigmatau.diagnose import curves as curve_findings
from sigmatau.io.read import inspection
from sigmatau.io.read.inspection import Inspection

__all__ = ["Inspection", "inspect"]


def inspect(path: str | os.PathLike[str], *, bandwidth: Bandwidth | None = None, **reading: Any) -> Inspection:  # noqa: ANN401
    """What a file holds, and what is wrong with it and with the samples that would be analysed.

    Nothing has to be known of the file. Tables with a sensor by the names of their columns, and those that are asked for by
    `topic` or `channels`, are read; of the others only names are told.

    Parameters
    ----------
    path : str or path
    bandwidth : mapping of str to (float, int or None), optional
        The sensors' own bandwidth, see `sigmatau.check`. [Hz]
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
    nothing = [finding for stream in found.record.streams for finding in curve_findings.lifeless(stream)]
    return replace(found, checks=(*nothing, *check(found.record, bandwidth=bandwidth)))
