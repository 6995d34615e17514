"""Patterns that a shell did not expand."""

from pathlib import Path

import pytest

from sigmatau.cli import main
from sigmatau.cli.options import matched
from sigmatau.errors import DataError


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shift" / "late").mkdir(parents=True)
    for name in ("shift/b.csv", "shift/a.csv", "shift/late/c.csv", "shift/d[1].csv", "shift/d1.csv"):
        (tmp_path / name).touch()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (["shift/?.csv"], ["shift/a.csv", "shift/b.csv"]),
        (["shift/late/c.csv", "shift/[ab].csv"], ["shift/late/c.csv", "shift/a.csv", "shift/b.csv"]),
        (["shift/**/c.csv"], ["shift/late/c.csv"]),
        (["shift/d[1].csv"], ["shift/d[1].csv"]),  # the name of a file, not a pattern
        (["none.csv"], ["none.csv"]),
        ([], []),
    ],
)
def test_are_expanded(given, expected):
    assert matched([Path(one) for one in given]) == tuple(map(Path, expected))


@pytest.mark.parametrize(
    "command",
    [("analyze",), ("lot",), ("compare",), ("store", "add", "--store", "x.db")],
    ids=lambda command: command[0],
)
def test_one_that_matches_nothing(command, capsys):
    assert main([*command, "shift/*.npy"]) == 1
    out, err = capsys.readouterr()
    assert (out, err) == ("", "sigmatau: shift/*.npy: no file matches this pattern\n")
    assert not Path("x.db").exists()


def test_a_name_that_is_too_long():
    with pytest.raises(DataError, match="no file matches"):
        matched([Path("x" * 5000 + "[1]")])
