"""Output that nobody reads: closed streams, a pipe whose reader has ended, and pipes among the logs of a folder."""

import os
import subprocess
import sys

import pytest

from sigmatau.cli import main


@pytest.mark.parametrize(
    "words", [["export", "--list"], ["analyze", "--help"], ["analyze", "missing.csv"]], ids=" ".join
)
def test_closed_streams(words, monkeypatch):
    with monkeypatch.context() as closed:
        closed.setattr(sys, "stdout", None)
        closed.setattr(sys, "stderr", None)
        assert main(words) == ("missing.csv" in words)
        sys.stdout.close()
        sys.stderr.close()


def test_help_in_a_pipe_without_reader():
    """In another process: Rich prints nothing more in a process whose pipe has broken."""
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as stream:
        ended = subprocess.run(
            [sys.executable, "-m", "sigmatau", "--help"], stdout=stream, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("command", ["analyze", "lot", "compare"])
def test_pipes_in_a_folder_are_not_opened(command, tmp_path, capsys):
    for name in ("pipe.csv", "pipe.json"):
        os.mkfifo(tmp_path / name)  # opening one would wait for a writer
    assert main([command, str(tmp_path)]) == 1
    assert "no " in capsys.readouterr().err
