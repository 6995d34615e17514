"""What becomes of a file whose disk is full, or whose process is told to end: an error in words, and nothing left."""

import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from known import interruptible
from sigmatau.io.write import RECORD_ENDINGS
from sigmatau.io.writers import _Patient

pytest.importorskip("resource")

MODEL = '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n[channels.accel_x]\nrandom_walk = "0.1 m/s/sqrt(h)"\n'
SIMULATE = (sys.executable, "-m", "sigmatau", "simulate", "m.toml", "--rate", "100", "-q")
needs = {".parquet": "pyarrow", ".h5": "h5py"}


@pytest.fixture
def ending(request, tmp_path):
    if request.param in needs:
        pytest.importorskip(needs[request.param])
    (tmp_path / "m.toml").write_text(MODEL)
    return request.param


FULL = """
import contextlib, io, json, pathlib, resource, sys
from sigmatau.cli import main
for folder, ending, kib in json.loads(sys.argv[1]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (kib * 1024, resource.RLIM_INFINITY))
    argv = ["simulate", "m.toml", "--rate", "100", "-q", "--hours", "0.2" if kib < 2400 else "2", "-o", f"x{ending}"]
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as out:
        with contextlib.redirect_stderr(io.StringIO()) as err:
            code = main(argv)
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""
# In the middle; of the format that is not written straight through, also from a disk that is full at the first piece, and
# at the end, when what was held back is written.
DISKS = [*((ending, 200) for ending in RECORD_ENDINGS), (".h5", 4), (".h5", 2400)]


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """What the command says of each full disk, and its folder; in one process, since each takes a second to start."""
    folders = [tmp_path_factory.mktemp("full") for _ in DISKS]
    for folder in folders:
        (folder / "m.toml").write_text(MODEL)
    asked = json.dumps([[str(folder), *disk] for folder, disk in zip(folders, DISKS, strict=True)])
    done = subprocess.run([sys.executable, "-c", FULL, asked], capture_output=True, text=True, check=True)
    answers = map(json.loads, done.stdout.splitlines())
    return {disk: (folder, *answer) for disk, folder, answer in zip(DISKS, folders, answers, strict=True)}


@pytest.mark.parametrize(("ending", "kib"), DISKS)
def test_a_full_disk_is_an_error_in_words(full, ending, kib):
    if ending in needs:
        pytest.importorskip(needs[ending])
    folder, code, out, said = full[ending, kib]
    assert (code, out) == (1, "")
    assert said.startswith(f"sigmatau: x{ending}: cannot be written: ")
    assert said.endswith("File too large\n")
    assert said.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ["m.toml"]


# Both signals take the same way out, of a format written straight through, one in parts, and those of libraries.
@pytest.mark.parametrize(
    ("ending", "number"),
    [*((ending, signal.SIGTERM) for ending in (".csv", ".npz", ".parquet")), (".h5", signal.SIGINT)],
    indirect=["ending"],
)
def test_a_signal_leaves_nothing_behind(tmp_path, ending, number):
    code, word = {signal.SIGTERM: (143, "terminated"), signal.SIGINT: (130, "interrupted")}[number]
    argv = [*SIMULATE, "--hours", "5000", "-o", f"x{ending}"]
    process = subprocess.Popen(argv, cwd=tmp_path, stderr=subprocess.PIPE, text=True, preexec_fn=interruptible)
    try:
        while not any(path.stat().st_size for path in tmp_path.rglob("*") if path.is_file() and path.name != "m.toml"):
            assert process.poll() is None
            time.sleep(0.02)
        while process.poll() is None:  # a signal in a callback of a library is lost now and then
            process.send_signal(number)
            time.sleep(0.5)
        _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    # Where Python was compiling a piece of code from text just then, it ends itself by the signal; a shell says 130 of both.
    assert process.returncode in (code, -number)
    assert said == f"sigmatau: {word}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["m.toml"]


def test_what_the_disk_does_not_take_is_read_back_from_memory():
    class Full:
        """Takes 10 bytes."""

        def __init__(self):
            self.data = b""
            self.at = 0

        def seek(self, offset, whence=0):
            self.at = offset + (len(self.data) if whence == 2 else 0)
            return self.at

        def read(self, size):
            return self.data[self.at : self.at + size]

        def write(self, data):
            there = min(len(data), 10 - self.at)
            if there <= 0:
                raise OSError(28, "No space left on device")
            self.data = self.data[: self.at].ljust(self.at, b"\0") + bytes(data[:there]) + self.data[self.at + there :]
            self.at += there
            return there

        def truncate(self, size):
            raise AssertionError

    file = _Patient(Full())
    pieces = [(0, b"abcdef"), (4, b"0123456789"), (2, b"XY"), (20, b"end")]
    expected = np.zeros(23, dtype=np.uint8)
    for at, data in pieces:
        file.seek(at)
        assert file.write(data) == len(data)
        expected[at : at + len(data)] = list(data)
    assert file.seek(0, 2) == 23
    for start, stop in [(0, 23), (3, 12), (9, 11), (18, 23)]:
        got = bytearray(stop - start)
        file.seek(start)
        assert file.readinto(got) == stop - start
        assert got == expected[start:stop].tobytes()
    assert file.truncate(5) == 5  # nothing is asked of a disk that is full
    with pytest.raises(OSError, match="No space"):
        file.check()
