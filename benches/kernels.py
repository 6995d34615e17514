"""The kernels against the roof: what ``crates/core/examples/roof.rs`` prints."""

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
    said = subprocess.run([program, *map(str, samples)], check=True, capture_output=True, text=True).stdout
    return {"samples": samples, "probes": parse(said)}


def parse(said: str) -> dict[str, float]:
    """Values by name from lines `name value unit`."""
    return {name: float(value) for name, value, _ in (line.split() for line in said.splitlines())}


def write(found: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """The section of the page."""
    p, samples = found["probes"], found["samples"]
    lines = [
        "## The kernels and the roof",
        "",
        *text.prose(
            "Time for one term of eq. (10) at one averaging time, one thread; the phase is there. The roof is an addition",
            "and two fused products on vectors of four, nothing loaded: the least that a term takes. The correction by the",
            "anchors of the phase, which keeps its digits, is one addition more. `make bench PARTS=kernels`.",
        ),
    ]
    rows = [["the roof", "**100 %**", f"{p['roof']:.0f} ps", ""]]
    with_correction = p["roof_with_correction"]
    rows.append(["with the correction", text.share(p["roof"], with_correction), f"{with_correction:.0f} ps", ""])
    for n in samples:
        for name, what in (("octaves", "octaves"), ("log100", "100 log-spaced")):
            value = p[f"{name}_{n}"]
            corrected = f"{text.share(with_correction, value)} of the roof with the correction"
            rows.append(
                [
                    f"{what}, {text.number(n)} samples",
                    f"**{text.share(p['roof'], value)}**",
                    f"{value:.0f} ps",
                    corrected,
                ]
            )
    lines += text.table(["", "share of the roof", "a term", ""], rows)
    rows = []
    for n in samples:
        fresh, again = p[f"prefix_fresh_{n}"], p[f"prefix_again_{n}"]
        rows.append([text.number(n), f"{again:.2f} ns", f"{16 / again:.1f} GB/s", f"{fresh:.2f} ns"])
    lines += ["The running sum before it, a sample; it reads eight bytes and writes eight:", ""]
    lines += text.table(["samples", "into memory in use", "that is", "into fresh memory"], rows)
    lines += [
        f"One core reads {p['read_memory']:.0f} GB/s from memory and {p['read_l2']:.0f} GB/s from its second cache.",
        "",
        *text.prose(
            "`cargo run --release -p sigmatau-core --example roof` makes these figures; `cargo bench -p sigmatau-core`",
            "times the parts of the core one by one.",
        ),
    ]
    short, long = samples
    at_long = f"octave kernel, {text.number(long)} samples, a term"
    reached = [
        text.at_least_percent(f"octave kernel, {text.number(short)} samples, share of the roof",
                              100 * p["roof"] / p[f"octaves_{short}"], 75),
        text.at_most(at_long, p[f"octaves_{long}"], 190, "ps"),
    ]  # fmt: skip
    return [*lines, *text.gates(reached)], reached
