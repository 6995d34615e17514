"""Numbers of instructions of small fixed pieces of work, which do not depend on other load; ``make test`` compares them.

The check fails if a piece of work needs more instructions than its limit. Fewer instructions are reported:
``python benches/instructions.py --write`` stores the new counts after an intended change.

Counts are exactly reproducible with one compiler. Those of Rust 1.85 are up to 7 % above those of 1.95, hence the margin.
Instructions are not times; ``make bench`` measures times.

The main job, `analyze` of 20 000 samples of six axes, is counted too, without the imports, which a first analysis in the
same process does. Otherwise the count would depend on earlier runs: modules without stored bytecode (pip installs them
with --no-compile) are compiled at their first import, a quarter of the job. The count is reproducible to 0.1 % with one
version of Python and of NumPy. It is made if both versions are those of the stored count and the package is built.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

HERE = Path(__file__).parent
STORED = HERE / "instructions.json"
STORED_JOB = HERE / "instructions_job.json"
MARGIN = 0.10

# Prints the relevant versions, or simulates a record and, after a line on its standard input, analyses it. Instructions are
# counted from that line on. A shorter record is analysed first, so that nothing is imported or compiled in the job.
JOB = """
import os
import sys
import numpy
import sigmatau
from sigmatau import analyze
if sys.argv[1] == "versions":
    print("{}.{}".format(*sys.version_info), numpy.__version__)
    sys.exit()
noise = {"random_walk": 5e-3, "bias_instability": 3e-4, "rate_random_walk": 1e-5}
model = sigmatau.NoiseModel(channels={f"{sensor}_{axis}": noise for sensor in ("gyro", "accel") for axis in "xyz"})
analyze(sigmatau.simulate(model, duration=20, rate=100, rng=1), threads=1)
record = sigmatau.simulate(model, duration=200, rate=100, rng=1)
print("ready", flush=True)
sys.stdin.readline()
analyze(record, threads=1)
os._exit(0)
"""

# Work that is subtracted from each: making the data, or the data and the phase.
LESS = {"phase": "nothing", "octaves": "phase", "log30": "phase", "push": "nothing", "parse": "nothing"}


def why_not() -> str | None:
    """Reason why instructions cannot be counted; empty if they can."""
    if shutil.which("valgrind") is None or shutil.which("vgdb") is None:
        return "valgrind is not installed"
    try:
        flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    except OSError:
        flags = []
    if platform.machine() != "x86_64" or not {"avx2", "fma"} <= set(flags):
        return "the stored counts are of the path for AVX2 and FMA"
    return None


def build() -> Path:
    """Build the optimised program."""
    command = [
        "cargo",
        "build",
        "--release",
        "--locked",
        "--quiet",
        "--workspace",
        "--example",
        "instructions",
    ]
    done = subprocess.run([*command, "--message-format=json"], cwd=HERE.parent, check=True, stdout=subprocess.PIPE)
    built = [json.loads(line) for line in done.stdout.splitlines()]
    return Path(next(message["executable"] for message in built if message.get("executable")))


def count(program: Path, work: str) -> int:
    """Number of instructions of one piece of work, including its preparation."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(program), work]
    done = subprocess.run(command, env={**os.environ, "LC_ALL": "C"}, capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or not collected:
        raise SystemExit(f"{' '.join(command)[:200]} failed:\n{done.stderr}")
    return int(collected[1])


def job() -> dict[str, str | int] | None:
    """Number of instructions of the main job, and the versions for which it holds; None if the package cannot be
    imported.
    """
    environment = os.environ | {
        "PYTHONPATH": str(HERE.parent / "python"),
        "PYTHONHASHSEED": "0",
        "PYTHONDONTWRITEBYTECODE": "",
        "OPENBLAS_NUM_THREADS": "1",
        "RAYON_NUM_THREADS": "1",
    }
    command = [sys.executable, "-c", JOB]
    done = subprocess.run([*command, "versions"], env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        return None
    python, numpy = done.stdout.split()
    return {"python": python, "numpy": numpy, "instructions": counted_from_ready([*command, "job"], environment)}


def counted_from_ready(work: Sequence[str], environment: Mapping[str, str]) -> int:
    """Number of instructions of a command after it printed "ready". To count the preparation too takes twice as long."""
    command = ["valgrind", "--tool=callgrind", "--instr-atstart=no", "--callgrind-out-file=/dev/null", *work]
    pipe = subprocess.PIPE
    process = subprocess.Popen(
        command, env={**environment, "LC_ALL": "C"}, stdin=pipe, stdout=pipe, stderr=pipe, text=True
    )
    assert process.stdout is not None
    process.stdout.readline()
    begun = subprocess.run(["vgdb", f"--pid={process.pid}", "instrumentation", "on"], capture_output=True, check=False)
    _, errors = process.communicate("\n")
    collected = re.findall(r"Collected : (\d+)", errors)
    if process.returncode or begun.returncode or len(collected) != 1:
        raise SystemExit(f"{' '.join(command)[:200]} failed:\n{errors}")
    return int(collected[0])


def main() -> int:
    """Count, and compare or store."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="store the counts")
    arguments = parser.parse_args()
    if reason := why_not():
        print(f"instructions: SKIPPED, {reason}")
        return 0
    program = build()
    raw = {work: count(program, work) for work in ("nothing", *LESS)}
    counts = {work: raw[work] - raw[less] for work, less in LESS.items()}
    job_counts = job()
    if arguments.write:
        STORED.write_text(json.dumps(counts, indent=2) + "\n", encoding="utf-8")
        if job_counts is not None:
            STORED_JOB.write_text(json.dumps(job_counts, indent=2) + "\n", encoding="utf-8")
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    stored_job = json.loads(STORED_JOB.read_text(encoding="utf-8"))
    if job_counts is None or any(job_counts[name] != stored_job[name] for name in ("python", "numpy")):
        print(
            f"analyze  SKIPPED, the package is not built for Python {stored_job['python']} and NumPy {stored_job['numpy']}"
        )
    else:
        counts["analyze"], stored["analyze"] = int(job_counts["instructions"]), stored_job["instructions"]
    above = 0
    for work, instructions in counts.items():
        change = instructions / stored[work] - 1
        verdict = "ok"
        if change > MARGIN:
            verdict, above = f"MORE than {MARGIN:.0%} above", above + 1
        elif change < -MARGIN:
            verdict = "fewer: store it with --write"
        print(f"{work:<8} {instructions:>12,} instructions, {change:+7.2%}  {verdict}")
    return 1 if above else 0


if __name__ == "__main__":
    sys.exit(main())
