"""Kernels compared with the limits of the machine, as printed by ``crates/core/examples/roof.rs``."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from benches import text
from benches.measure import Settings
from benches.text import Gate

ROOT = Path(__file__).parent.parent
SAMPLES = (1.44e6, 1e7)


def measure(settings: Settings) -> dict[str, Any]:
    """Build and run the probes."""
    command = ["cargo", "build", "--release", "--locked", "--quiet", "-p", "sigmatau-core", "--example", "roof"]
    done = subprocess.run([*command, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE)
    built = [json.loads(line) for line in done.stdout.splitlines()]
    program = next(message["executable"] for message in built if message.get("executable"))
    samples = [settings.samples(n) for n in SAMPLES]
    output = subprocess.run([program, *map(str, samples)], check=True, capture_output=True, text=True).stdout
    return {"samples": samples, "probes": parse(output)}


def parse(output: str) -> dict[str, float]:
    """Values by name from lines `name value unit`."""
    return {name: float(value) for name, value, _ in (line.split() for line in output.splitlines())}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    p, samples = measured["probes"], measured["samples"]
    lines = [
        "## Kernels and the limit of the processor",
        "",
        *text.prose(
            "Time for one term of eq. (10) at one averaging time, with one thread and the phase already",
            "computed. The limit is",
            "the time of one addition and two fused multiplications on vectors of four, without memory access.",
            "The correction",
            "by the origins of the phase blocks, which keeps the precision, takes one more addition. `make bench",
            "PARTS=kernels`.",
        ),
    ]
    rows = [["limit", "**100 %**", f"{p['roof']:.0f} ps", ""]]
    with_correction = p["roof_with_correction"]
    rows.append(["with the correction", text.share(p["roof"], with_correction), f"{with_correction:.0f} ps", ""])
    for n in samples:
        for name, label in (("octaves", "octaves"), ("log100", "100 log-spaced")):
            value = p[f"{name}_{n}"]
            corrected = f"{text.share(with_correction, value)} of the limit with the correction"
            rows.append(
                [
                    f"{label}, {text.number(n)} samples",
                    f"**{text.share(p['roof'], value)}**",
                    f"{value:.0f} ps",
                    corrected,
                ]
            )
    lines += text.table(["", "share of the limit", "time per term", ""], rows)
    rows = []
    for n in samples:
        fresh, again = p[f"prefix_fresh_{n}"], p[f"prefix_again_{n}"]
        rows.append([text.number(n), f"{again:.2f} ns", f"{16 / again:.1f} GB/s", f"{fresh:.2f} ns"])
    lines += ["Time of the running sum per sample, which reads and writes eight bytes:", ""]
    lines += text.table(["samples", "into used memory", "throughput", "into new memory"], rows)
    lines += [
        f"One core reads {p['read_memory']:.0f} GB/s from memory and {p['read_l2']:.0f} GB/s from its second-level cache.",
        "",
        *text.prose(
            "`cargo run --release -p sigmatau-core --example roof` gives these numbers.",
        ),
    ]
    short, long = samples
    at_long = f"octave kernel, {text.number(long)} samples, a term"
    reached = [
        text.at_least_percent(f"octave kernel, {text.number(short)} samples, share of the limit",
                              100 * p["roof"] / p[f"octaves_{short}"], 75),
        text.at_most(at_long, p[f"octaves_{long}"], 190, "ps"),
    ]  # fmt: skip
    return [*lines, *text.gates(reached)], reached
