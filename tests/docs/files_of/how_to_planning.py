"""Files of docs/how-to/planning.md."""

import re
from pathlib import Path

from conftest import ROOT
from page_records import index_model

PAGE = ROOT / "docs" / "how-to" / "planning.md"


def make(folder: Path) -> None:
    """The grades that the page shows, and the model of the how-to pages."""
    (text,) = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    (folder / "grades.toml").write_text(text, encoding="utf-8")
    index_model(folder / "imu.toml")
