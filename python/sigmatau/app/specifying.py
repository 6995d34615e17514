"""Curves of datasheets and of noise models, for the figure of the comparison step."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

import numpy as np

from sigmatau import NoiseModel
from sigmatau.app.calls import Progress
from sigmatau.app.kinds import file_kind
from sigmatau.app.log import LogFile
from sigmatau.errors import OptionError
from sigmatau.lab.datasheets.sheet import Datasheet, list_datasheets
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.reporting.charts import collect_sensors, digits
from sigmatau.results import printable

_FIRST, _LAST, _PER_DECADE = 1e-3, 1e5, 12  # first and last averaging time of a curve [s], and their number per decade


def listed_datasheets(*, progress: Progress) -> str:
    """The datasheets of the library by name, as JSON."""
    rows = [{"name": name, "headline": sheet.headline()} for name, sheet in list_datasheets().items()]
    return json.dumps({"datasheets": rows})


def specification(
    *, log: LogFile | None, name: str | None, use: str | None, sided: str | None, bias: str | None, progress: Progress
) -> str:
    """Expected curves as JSON: of a datasheet of the library, or of a file with a datasheet or a noise model."""
    if log is not None and file_kind(Path(log.path)) == "model":
        model, title, source, origins = NoiseModel.read(log.path), Path(log.name).stem, "", list[str]()
    else:
        sheet = _in_library(name or "") if log is None else Datasheet.read(log.path)
        stated: Any = {"use": use or "typical", "sided": sided, "bias": bias}
        model = sheet.model(**stated)
        title, source, origins = sheet.headline(), sheet.source, list(sheet.origins(**stated))
    tau = np.geomspace(_FIRST, _LAST, 1 + round(_PER_DECADE * np.log10(_LAST / _FIRST)))
    channels: dict[str, Any] = {
        channel: {"deviation": {"tau": digits(tau), "adev": digits(cast("Any", noise).adev(tau))}}
        for channel, noise in model.channels.items()
    }
    if not channels:
        raise OptionError(f"{title}: has no channels; choose another file", option="name")
    content = {
        "name": printable(title),
        "source": printable(source),
        "origins": [printable(line) for line in origins],
        "charts": {"sensors": collect_sensors(model.channels), "channels": channels},
    }
    return json.dumps(content, allow_nan=False)


def _in_library(name: str) -> Datasheet:
    """Find a datasheet by name. A path is refused, because the page may only read files in the opened folders."""
    if name.endswith(".toml") or set("/\\") & set(name):
        raise OptionError(
            f"{printable(name[:80])!r} is not a datasheet of the library; choose a name of the list", option="name"
        )
    return find_datasheet(name)
