"""The temperature as a stream beside the sensors, for the check of drift."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.thermometer import Thermometer
from sigmatau.io.read.time.timing import Timing
from sigmatau.record.record import MIN_SAMPLES, TEMPERATURE, make_stream
from sigmatau.record.streams import Stream
from sigmatau.record.thermometers import PLAUSIBLE, TO_CELSIUS, typical

__all__ = ["temperature_stream"]


def temperature_stream(
    label: str, found: Thermometer, raw: Mapping[int, NDArray[Any]], timing: Timing, *, missing: bool
) -> tuple[tuple[Stream, ...], str]:
    """The temperature stream and a note; no stream if the numbers are not temperatures. Never raises `DataError`.

    A thermometer with a lower rate than the sensors leaves its column empty in between; these samples are missing.
    """
    column = raw[found.index]
    scale, offset = TO_CELSIUS[found.unit or "degC"]
    values = column[~np.isnan(column)] if missing else column
    if len(values) < MIN_SAMPLES:
        return (), f"temperature: column {label} has {len(values)} numbers, too few"
    median = typical(values, found.unit or "degC")
    if not PLAUSIBLE[0] <= median <= PLAUSIBLE[1]:
        unit = found.unit or "degC, which was assumed"
        return (), f"temperature: column {label} is not a temperature in {unit} (median {median:.4g} °C)"
    try:
        stream = make_stream(
            "temperature",
            {"temperature": timing.laid(column)},
            rate=timing.rate,
            unit={"temperature": TEMPERATURE},
            scale={"temperature": scale},
            offset={"temperature": offset},
            grid_source=timing.source,
            start=timing.start,
            jitter=timing.jitter,
            finite=timing.places is None and not missing,
        )
    except DataError as error:
        return (), f"temperature: column {label} is not used: {error}"
    how = "degC assumed" if found.unit is None else found.unit
    return (stream,), f"temperature from column {label}, {how}"
