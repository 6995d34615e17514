"""Instructions of small fixed pieces of work, which no other load on the machine changes; ``make test`` compares them.

A change that makes one of them need more instructions than its limit fails the check. Fewer is no failure, but is said:
``python benches/instructions.py --write`` makes the new counts the stored ones, after a change that is meant.

Counts are the same to the last one with one compiler. Those of Rust 1.85 are up to 7 % above those of 1.95, hence the
margin. An instruction is not a time; ``make bench`` measures times.

The main job, `analyze` of 20 000 samples of six axes, is counted too, without the imports: a first analysis in the same
process does them. Otherwise the count would depend on what ran before: modules without stored bytecode (pip installs
them with --no-compile) are compiled at their first import, which is a quarter of the job. It is the same to 0.1 % with
one version of Python and of NumPy, and is counted where both are those of the stored count, and where the package is built.
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

# Prints the versions that matter, or simulates a record and analyses it. What comes before, mainly the imports, is counted
# by a child that ends there. A shorter record is analysed first, so that nothing is imported or compiled in the job.
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
if os.fork() == 0:
    os._exit(0)
os.wait()
analyze(record, threads=1)
os._exit(0)
"""

# What is taken off each: making the data, or the phase as well.
LESS = {"phase": "nothing", "octaves": "phase", "log30": "phase", "push": "nothing", "parse": "nothing"}


def why_not() -> str | None:
    """Why nothing can be counted here, if so."""
    if shutil.which("valgrind") is None:
        return "valgrind is not installed"
    try:
        flags = Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
    except OSError:
        flags = []
    if platform.machine() != "x86_64" or not {"avx2", "fma"} <= set(flags):
        return "the stored counts are of the path for AVX2 and FMA"
    return None


def build() -> Path:
    """The optimised program."""
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
    """Instructions of one piece of work with all that comes before it."""
    (found,) = counted([str(program), work], os.environ)
    return found


def counted(work: Sequence[str], environment: Mapping[str, str]) -> list[int]:
    """Instructions of the processes of a command, in the order of their ends."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *work]
    done = subprocess.run(command, env={**environment, "LC_ALL": "C"}, capture_output=True, text=True, check=False)
    collected = re.findall(r"Collected : (\d+)", done.stderr)
    if done.returncode or not collected:
        raise SystemExit(f"{' '.join(command)[:200]} failed:\n{done.stderr}")
    return [int(found) for found in collected]


def job() -> dict[str, str | int] | None:
    """Instructions of the main job, and the versions that they hold for; None where the package cannot be imported."""
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
    before, whole = counted([*command, "job"], environment)
    return {"python": python, "numpy": numpy, "instructions": whole - before}


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
    of_job = job()
    if arguments.write:
        STORED.write_text(json.dumps(counts, indent=2) + "\n", encoding="utf-8")
        if of_job is not None:
            STORED_JOB.write_text(json.dumps(of_job, indent=2) + "\n", encoding="utf-8")
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    known = json.loads(STORED_JOB.read_text(encoding="utf-8"))
    if of_job is None or any(of_job[name] != known[name] for name in ("python", "numpy")):
        print(f"analyze  SKIPPED, the package is not built for Python {known['python']} and NumPy {known['numpy']}")
    else:
        counts["analyze"], stored["analyze"] = int(of_job["instructions"]), known["instructions"]
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
