"""``sigmatau app``: its address, its end, and what it refuses."""

import os
import signal
import socket
import subprocess
import sys
from urllib.request import urlopen

import pytest

from sigmatau.app.server import need_libraries
from sigmatau.cli import main


@pytest.mark.skipif(os.name == "nt", reason="no SIGINT for one process")
@pytest.mark.parametrize(("end", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143)])
def test_a_page_until_it_is_ended(tmp_path, end, code):
    command = [sys.executable, "-m", "sigmatau", "app", str(tmp_path), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as served:
        address = served.stdout.readline().strip()
        with urlopen(address, timeout=60) as answer:
            assert answer.status == 200
        served.send_signal(end)
        _, messages = served.communicate(timeout=60)
    assert served.returncode == code
    assert "Traceback" not in messages
    assert address.startswith("http://127.0.0.1:")
    assert len(address.split("/")[3]) >= 32


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["nothing"], 1, "there is no such file or folder"),
        (["--nonsense"], 2, "Unknown option: --nonsense."),
        (["--no-browsr"], 2, "Did you mean --no-browser?"),
        (["--prot", "8000"], 2, "Unknown option: --prot. Did you mean --port?"),
        (["--port", "70000"], 2, "must be a number from 0 to 65535"),
        (["--max-upload", "0"], 2, "must be a positive number of GB"),
        (["--baud", "9600"], 2, "--baud is for live samples: give --serial PORT too, or -"),
        (["--save", "new.csv"], 2, "--save is for live samples"),
        (["--rate", "100"], 2, "--rate is for live samples"),
        (["--at-rest"], 2, "--at-rest is for live samples"),
        (["-", "--serial", "/dev/none"], 2, "leave out -"),
        (["--serial", "/dev/none", "--baud", "0"], 2, "must be a positive number of bits per second"),
        (["--serial", "/dev/none", "--input", "accumulated"], 2, "accumulated values are for a saved log"),
        (["--serial", "/dev/none", "--rate", "100"], 1, "the serial port cannot be opened"),
    ],
)
def test_wrong_words(words, code, message, capsys):
    assert main(["app", "--no-browser", *words]) == code
    assert message in capsys.readouterr().err


def test_a_port_that_is_taken(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        assert main(["app", "--no-browser", "--port", str(taken.getsockname()[1])]) == 1
    assert "is not available" in capsys.readouterr().err


def test_without_the_libraries(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    with pytest.raises(ImportError, match=r"sigmatau\[app\]"):
        need_libraries()
    assert main(["app", "--no-browser"]) == 1
    assert "pip install 'sigmatau[app]'" in capsys.readouterr().err
