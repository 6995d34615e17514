"""The screens of the docs are short; tests/docs compares them with what the program prints."""

import re

from conftest import ROOT

PAGE = (ROOT / "docs" / "screens.md").read_text(encoding="utf-8")


def test_every_screen_fits():
    """24 lines of 80 columns, below the command."""
    screens = re.findall(
        r"^```sh\n(.*?)^```\n\n<!-- output: screen -->\n```text\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE
    )
    assert len(screens) == PAGE.count("```text") == 9
    for command, screen in screens:
        assert len(screen.splitlines()) <= 24, command
        assert max(map(len, screen.splitlines())) <= 80, command
