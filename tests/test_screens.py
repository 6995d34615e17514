"""The screens of the docs are what the program prints; where the field data are absent, they are skipped."""

import importlib.util

import pytest

from conftest import ROOT

_spec = importlib.util.spec_from_file_location("screens", ROOT / "docs" / "screens.py")
screens = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(screens)

PAGE = screens.PAGE.read_text(encoding="utf-8")
# Those that take seconds are compared when the page is made.
QUICK = [row for row in screens.SCREENS if "xdot" in row[1] or "many_positions" in row[1] or "dataflash" in row[1]]


@pytest.mark.parametrize(("title", "command"), QUICK)
def test_the_page_shows_what_is_printed(field_data, title, command, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    assert screens.block(title, command, screens.screen(command, field_data)) in PAGE


def test_every_screen_fits():
    """24 lines of 80 columns, below the command."""
    blocks = PAGE.split("```text\n")[1:]
    assert len(blocks) == len(screens.SCREENS) + 1
    for block in blocks:
        lines = block.split("```")[0].splitlines()[1:]
        assert len(lines) <= 24, lines[0]
        assert max(map(len, lines)) <= 80, lines[0]
