"""docs/how-to/production.md: its commands end as it says, on the lot that it speaks of, and print what it shows."""

import re

from conftest import ROOT
from lot_logs import SPEC

PAGE = (ROOT / "docs" / "how-to" / "production.md").read_text(encoding="utf-8")


def test_its_specification_is_that_of_the_tests():
    (toml,) = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    assert toml == SPEC


def test_all_exit_codes_are_told():
    codes = re.findall(r"^\| (\d) \| ", PAGE, flags=re.MULTILINE)
    assert sorted(codes) == ["0", "1", "2", "3", "4"]
