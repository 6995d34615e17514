"""Instructions of small fixed pieces of work, which no other load on the machine changes; ``make test`` compares them.

A change that makes one of them need more instructions than its limit fails the check. Fewer is no failure, but is said:
``python benches/instructions.py --write`` makes the new counts the stored ones, after a change that is meant.

Counts are the same to the last one with one compiler. Those of Rust 1.85 are up to 7 % above those of 1.95, hence the
margin. An instruction is not a time; ``make bench`` measures times.
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
from pathlib import Path

HERE = Path(__file__).parent
STORED = HERE / "instructions.json"
MARGIN = 0.10

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
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(program), work]
    done = subprocess.run(command, env=os.environ | {"LC_ALL": "C"}, capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode or collected is None:
        raise SystemExit(f"{' '.join(command)} failed:\n{done.stderr}")
    return int(collected.group(1))


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
    if arguments.write:
        STORED.write_text(json.dumps(counts, indent=2) + "\n", encoding="utf-8")
    stored = json.loads(STORED.read_text(encoding="utf-8"))
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
