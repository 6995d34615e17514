"""The logs of docs/screens.md: that of the demo, and logs of other parties, which are not distributed with the package."""

import os
from pathlib import Path

import pytest
from logs_of_pages import demo_log

from conftest import ROOT

DATA = Path(os.environ.get("SIGMATAU_FIELD_DATA", ROOT.parent / "shared" / "data"))


def make(folder: Path) -> None:
    """Links to the logs."""
    if not DATA.is_dir():
        pytest.skip(f"no field data: {DATA} is absent; SIGMATAU_FIELD_DATA names another folder")
    for log in [*DATA.glob("*.gz"), *(DATA / "field").iterdir()]:
        (folder / log.name).symlink_to(log)
    (folder / "demo").mkdir()
    demo_log(folder / "demo" / "static.csv")
