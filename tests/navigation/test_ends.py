"""What becomes of a file whose disk is full, or whose process is told to end: an error in words, and nothing left."""

import signal
import subprocess
import sys
import time

import pytest

from known import interruptible
from sigmatau.io.write import RECORD_ENDINGS

resource = pytest.importorskip("resource")

MODEL = '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n[channels.accel_x]\nrandom_walk = "0.1 m/s/sqrt(h)"\n'
SIMULATE = (sys.executable, "-m", "sigmatau", "simulate", "m.toml", "--rate", "100", "-q")
needs = {".parquet": "pyarrow"}


@pytest.fixture
def ending(request, tmp_path):
    if request.param in needs:
        pytest.importorskip(needs[request.param])
    (tmp_path / "m.toml").write_text(MODEL)
    return request.param


@pytest.mark.parametrize("ending", RECORD_ENDINGS, indirect=True)
def test_a_full_disk_is_an_error_in_words(tmp_path, ending):
    def small():
        resource.setrlimit(resource.RLIMIT_FSIZE, (200 * 1024, 200 * 1024))

    argv = [*SIMULATE, "--hours", "0.2", "-o", f"x{ending}"]
    ended = subprocess.run(argv, cwd=tmp_path, preexec_fn=small, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr.startswith(f"sigmatau: x{ending}: cannot be written: ")
    assert ended.stderr.endswith("File too large\n")
    assert ended.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["m.toml"]


# Both signals take the same way out.
@pytest.mark.parametrize(
    ("ending", "number"),
    [*((ending, signal.SIGTERM) for ending in RECORD_ENDINGS), (".npz", signal.SIGINT)],
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
