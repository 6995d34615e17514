"""docs/how-to/production.md: its commands end as it says, on the lot that it speaks of, and print what it shows."""

import re
import shlex

from conftest import ROOT
from lot_logs import SPEC, write_lot
from sigmatau.cli import batch, main

PAGE = (ROOT / "docs" / "how-to" / "production.md").read_text(encoding="utf-8")


def test_its_specification_is_that_of_the_tests():
    (toml,) = re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    assert toml == SPEC


def test_the_commands_in_their_order(tmp_path, monkeypatch, capsys):
    def run(logs, work, *, jobs, keep=None):
        for log in logs:
            yield batch._outcome(log, work, keep)

    monkeypatch.setattr(batch, "run", run)
    write_lot(tmp_path / "shift")
    (tmp_path / "units.txt").write_text("".join(f"unit{k:02}\n" for k in range(1, 41)))
    monkeypatch.chdir(tmp_path)
    commands = re.findall(r"^(sigmatau .*?) +# exit code (\d)$", PAGE, flags=re.MULTILINE)
    assert len(commands) == 9
    (shown,) = re.findall(r"^```text\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    for line, code in commands:
        assert main(shlex.split(line)[1:]) == int(code), line
        out = capsys.readouterr().out
        if "lot shift" in line:
            assert out.startswith(shown)
        if line.endswith("units.txt"):
            assert re.search(r"^missing +unit40 ", out, flags=re.MULTILINE)


def test_all_exit_codes_are_told():
    codes = re.findall(r"^\| (\d) \| ", PAGE, flags=re.MULTILINE)
    assert sorted(codes) == ["0", "1", "2", "3", "4"]
