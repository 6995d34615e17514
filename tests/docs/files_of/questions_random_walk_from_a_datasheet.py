"""Files of docs/questions/random-walk-from-a-datasheet.md."""

import re
from pathlib import Path

from conftest import ROOT

PAGE = ROOT / "docs" / "questions" / "random-walk-from-a-datasheet.md"


def make(folder: Path) -> None:
    """The datasheet that the page shows."""
    (text,) = re.findall(r"^```toml\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    (folder / "mysensor.toml").write_text(text, encoding="utf-8")
