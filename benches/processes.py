"""Whole processes: from a text log to six curves, and the time to start.

Each process is started by a small process, because the peak memory that the system reports for a child is at least that
of its parent.
"""

from __future__ import annotations

import compileall
import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau
from benches import text
from benches.measure import Settings
from benches.peers import AXES, noise
from benches.text import Gate
from sigmatau import Record
from sigmatau.io.write import write as write_log

RATE = 200.0

_LONGEST = 1800.0  # longest run of a process [s]

# Runs a command: wall time, CPU time and peak memory. If Python does not store bytecode, every run would compile all
# imported packages; here only the first run does.
_LAUNCHER = """
import json, os, sys, time
argv = json.loads(sys.stdin.read())
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
out = os.open(os.devnull, os.O_WRONLY)
start = time.perf_counter()
pid = os.posix_spawn(argv[0], argv, os.environ, file_actions=[(os.POSIX_SPAWN_DUP2, out, 1), (os.POSIX_SPAWN_DUP2, out, 2)])
_, status, used = os.wait4(pid, 0)
wall = time.perf_counter() - start
print(json.dumps([wall, used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss, os.waitstatus_to_exitcode(status)]))
"""

# Each program prints the deviations of all axes.
_OURS = """
import sys
from sigmatau import allan, read
curves = allan(read(sys.argv[1]), taus="octave")
print(*(float(s) for curve in curves.values() for s in curve.adev))
"""
_OCTAVES = """
m = 2 ** np.arange((len(columns[0]) // 2).bit_length())
for y in columns:
    print(*map(float, allantools.oadev(y, rate=RATE, data_type="freq", taus=m / RATE)[1]))
""".replace("RATE", str(RATE))
_PANDAS = """
import sys
import allantools, numpy as np, pandas
table = pandas.read_csv(sys.argv[1])
columns = [table[name].to_numpy() for name in table.columns[HAS_TIME:]]
"""
_LOADTXT = """
import sys
import allantools, numpy as np
columns = np.ascontiguousarray(np.loadtxt(sys.argv[1], delimiter=",", skiprows=1)[:, 1:].T)
"""

STARTS = {
    "python, nothing": ["-c", "pass"],
    "import sigmatau": ["-c", "import sigmatau"],
    "from sigmatau import read, allan": ["-c", "from sigmatau import read, allan"],
    "import numpy": ["-c", "import numpy"],
    "sigmatau --help": ["-m", "sigmatau", "--help"],
}


def compiled() -> None:
    """Compile the package: an installed package is compiled, a checkout may not be."""
    compileall.compile_dir(Path(sigmatau.__file__).parent, quiet=1)


def bare_curves(log: str, *, has_time: bool = True) -> list[str]:
    """Arguments of Python for six curves by pandas and allantools of a log whose first column may be the time."""
    return ["-c", (_PANDAS + _OCTAVES).replace("HAS_TIME", str(int(has_time))), log]


def measure(settings: Settings) -> dict[str, Any]:
    """Both kinds of processes."""
    compiled()
    n = settings.samples(1.44e6)
    axes: dict[str, Any] = {axis: noise(n, k) for k, axis in enumerate(AXES)}
    with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
        log = str(Path(folder) / "log.csv")
        write_log(Record.from_arrays(rate=RATE, **axes), log)
        size = Path(log).stat().st_size
        commands = {
            "sigmatau": ["-c", _OURS, log],
            "pandas + allantools": bare_curves(log),
            "numpy.loadtxt + allantools": ["-c", _LOADTXT + _OCTAVES, log],
        }
        if settings.is_trial:
            del commands["numpy.loadtxt + allantools"]
        _check({name: _printed(arguments) for name, arguments in commands.items()})
        commands["sigmatau analyze --method read-off"] = [
            "-m",
            "sigmatau",
            "analyze",
            log,
            "--taus",
            "octave",
            "--method",
            "read-off",
            "--at-rest",  # the noise of these rates, which is that of a turntable
            "--quiet",
        ]
        log_to_curves = _turns(commands, min(settings.rounds, 5))
    return {
        "samples": n,
        "bytes": size,
        "log": log_to_curves,
        "starts": _turns(STARTS, 1 if settings.is_trial else 2 * settings.rounds),
    }


def _printed(arguments: Sequence[str]) -> list[float]:
    done = subprocess.run([sys.executable, *arguments], check=True, capture_output=True, text=True)
    return [float(word) for word in done.stdout.split()]


def _check(deviations: dict[str, list[float]]) -> None:
    ours = deviations["sigmatau"]
    for name, theirs in deviations.items():
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, err_msg=name)


def _turns(commands: dict[str, list[str]], rounds: int) -> dict[str, dict[str, float]]:
    runs: dict[str, list[list[float]]] = {name: [] for name in commands}
    for _ in range(rounds):
        for name, arguments in commands.items():
            runs[name].append(launch([sys.executable, *arguments]))
    median = {name: [statistics.median(column) for column in zip(*rows, strict=True)] for name, rows in runs.items()}
    return {name: {"wall": m[0], "cpu": m[1], "peak": m[2]} for name, m in median.items()}


def launch(argv: Sequence[str], codes: Sequence[int] = (0,)) -> list[float]:
    """Wall time [s], CPU time [s] and peak memory [bytes] of a command that ends with one of these codes.

    Prints a dot on stderr for each, because they take minutes on a busy machine. A command that takes longer than
    _LONGEST is stopped.
    """
    launcher = [sys.executable, "-I", "-S", "-c", _LAUNCHER]
    done = subprocess.run(
        launcher, input=json.dumps(list(argv)), check=True, capture_output=True, text=True, timeout=_LONGEST
    )
    sys.stderr.write(".")
    sys.stderr.flush()
    *used, code = json.loads(done.stdout)
    if code not in codes:
        raise RuntimeError(f"{' '.join(argv)[:200]} ended with {code:.0f}")
    return [float(value) for value in used]


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    log, starts = measured["log"], measured["starts"]
    ours = log["sigmatau"]
    rows = []
    for name, used in log.items():
        wall, cpu, peak = (
            "" if used is ours else f"**{text.times(used[k] / ours[k])}** " for k in ("wall", "cpu", "peak")
        )
        row = [(wall, text.seconds(used["wall"])), (cpu, text.seconds(used["cpu"])), (peak, text.size(used["peak"]))]
        rows.append([name, *(f"{ratio}({value})" if ratio else value for ratio, value in row)])
    lines = [
        "## From a log to curves",
        "",
        *text.prose(
            f"A text log of {text.number(measured['samples'])} rows of 7 columns, {text.size(measured['bytes'])}, to the",
            "deviations of six axes on octaves, as whole processes: start of Python, imports, reading, computing.",
            'Ratios are over sigmatau (`allan(read(path), taus="octave")`), which uses both cores. The command also',
            "reads coefficients off and prints a table. `make bench PARTS=processes`.",
        ),
        *text.table(["", "wall time", "CPU time", "peak memory"], rows),
    ]
    base = starts["import numpy"]
    cells = []
    for name, used in starts.items():
        ratios = [f"**{used[k] / base[k]:.2f}** ({text.seconds(used[k])})" for k in ("wall", "cpu")]
        cells.append([name, *ratios])
    lines += ["## Starting", ""]
    lines += text.prose(
        "Whole processes. Ratios are relative to a process that imports NumPy. Its CPU time includes waiting threads of the",
        "linear algebra library. `make bench PARTS=processes`.",
    )
    lines += text.table(["", "wall time", "CPU time"], cells)
    reached = [
        text.at_least("log to curves, pandas + allantools", log["pandas + allantools"]["wall"] / ours["wall"], 10),
        text.at_most(
            "`import sigmatau` over `import numpy`", starts["import sigmatau"]["wall"] / base["wall"], 1.3, "times"
        ),
        text.at_most("`sigmatau --help`, CPU time", starts["sigmatau --help"]["cpu"], 0.25, "s"),
    ]
    return [*lines, *text.gates(reached)], reached
