"""What becomes of a file whose disk is full, or whose process is told to end: an error in words, and nothing left."""

import json
import signal
import subprocess
import sys
import time

import pytest

from known import interruptible
from sigmatau.io.write import RECORD_ENDINGS

pytest.importorskip("resource")

MODEL = "".join(  # three axes each, as a message of a bag has
    f'[channels.{sensor}_{axis}]\nrandom_walk = "{noise}"\n'
    for sensor, noise in (("gyro", "0.3 deg/sqrt(h)"), ("accel", "0.1 m/s/sqrt(h)"))
    for axis in "xyz"
)
SIMULATE = (sys.executable, "-m", "sigmatau", "simulate", "m.toml", "--rate", "100", "-q")
needs = {".parquet": "pyarrow"}


@pytest.fixture
def ending(request, tmp_path):
    if request.param in needs:
        pytest.importorskip(needs[request.param])
    (tmp_path / "m.toml").write_text(MODEL)
    return request.param


FULL = """
import contextlib, io, json, pathlib, resource, sys
from sigmatau.cli import main
for folder, ending in json.loads(sys.argv[1]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (200 * 1024, resource.RLIM_INFINITY))
    argv = ["simulate", "m.toml", "--rate", "100", "-q", "--hours", "0.03", "-o", f"x{ending}"]
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as out:
        with contextlib.redirect_stderr(io.StringIO()) as err:
            code = main(argv)
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """What the command says of each full disk, and its folder; in one process, since each takes a second to start."""
    folders = [tmp_path_factory.mktemp("full") for _ in RECORD_ENDINGS]
    for folder in folders:
        (folder / "m.toml").write_text(MODEL)
    asked = json.dumps([[str(folder), ending] for folder, ending in zip(folders, RECORD_ENDINGS, strict=True)])
    done = subprocess.run([sys.executable, "-c", FULL, asked], capture_output=True, text=True, check=True)
    answers = map(json.loads, done.stdout.splitlines())
    return {ending: (folder, *answer) for ending, folder, answer in zip(RECORD_ENDINGS, folders, answers, strict=True)}


@pytest.mark.parametrize("ending", RECORD_ENDINGS)
def test_a_full_disk_is_an_error_in_words(full, ending):
    if ending in needs:
        pytest.importorskip(needs[ending])
    folder, code, out, said = full[ending]
    assert (code, out) == (1, "")
    assert said.startswith(f"sigmatau: x{ending}: cannot be written: ")
    assert said.endswith(("File too large\n", "disk I/O error\n"))  # the second of SQLite
    assert said.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ["m.toml"]


# Both signals take the same way out, of a format written straight through, one in parts, and that of a library.
@pytest.mark.parametrize(
    ("ending", "number"),
    [(".csv", signal.SIGTERM), (".npz", signal.SIGINT), (".parquet", signal.SIGTERM)],
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
