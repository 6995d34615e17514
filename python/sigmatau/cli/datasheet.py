"""``sigmatau datasheet``: list or show datasheets of the library, or print one as a model file."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.cli.options import json_text
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.lab.datasheets.sheet import list_datasheets


def datasheet_command(
    action: Literal["list", "show"],
    name: str | None = None,
    /,
    *,
    model: Annotated[bool, Parameter(negative=())] = False,
    use: Literal["typical", "maximum"] = "typical",
    sided: Literal["one", "two"] | None = None,
    bias: Literal["minimum", "coefficient"] | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Show datasheet values of common sensors with their sources, or convert a datasheet to a noise model.

    Parameters
    ----------
    action
        list (all datasheets) or show (one).
    name
        Datasheet to show: a name of the list, or your file (.toml).
    model
        Print a model file, for simulate and plan.
    use
        Values for the model (default: typical). If the datasheet states only the other kind, the other kind is used.
    sided
        For the model: convention of noise densities. Required if the datasheet does not state it.
    bias
        For the model: convention of bias instabilities. Required if the datasheet does not state it.
    json
        Print JSON.
    """
    if action == "list":
        if name is not None:
            raise OptionError(f"list takes no name; to see {name!r}: sigmatau datasheet show {name}", option="name")
        if model:
            raise OptionError("--model needs one datasheet: sigmatau datasheet show NAME --model", option="model")
        library = list_datasheets()
        text = json_text({key: sheet.to_dict() for key, sheet in library.items()}) if json else f"{library!r}\n"
    else:
        if name is None:
            raise OptionError("show needs a name; see sigmatau datasheet list", option="name")
        sheet = find_datasheet(name)
        if model and json:
            raise OptionError("--model prints TOML: give --model or --json, not both", option="json")
        if not model and (sided is not None or bias is not None or use != "typical"):
            raise OptionError("--use, --sided and --bias need --model", option="model")
        if model:
            content = sheet.model(use=use, sided=sided, bias=bias).to_toml()
            origins = "".join(f"# {line}\n" for line in sheet.origins(use=use, sided=sided, bias=bias))
            text = f"# {sheet.name} ({sheet.maker}); {sheet.source}\n{origins}\n{content}"
        else:
            text = json_text(sheet.to_dict()) if json else f"{sheet!r}\n"
    sys.stdout.write(text)
    return 0


def check_model(
    path: Path, instead: str = "sigmatau datasheet show {0} --model > {0}.toml makes a model of it"
) -> None:
    """Raise `DataError` for the name of a datasheet in place of a model file. `instead`: the text to type; {0} is the
    name.
    """
    if path.exists():
        return
    try:
        find_datasheet(str(path))
    except (OptionError, DataError):
        return
    raise DataError(f"{path}: is the name of a datasheet, not of a file: {instead.format(path)}")
