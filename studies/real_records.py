"""Real records at rest: the random walk and bias instability of every axis, and of both halves of each record.

The records are not distributed with the package: SIGMATAU_FIELD_DATA is their folder; absent records are skipped.
``python -m studies.real_records`` writes docs/study/real-records.md.
"""

from __future__ import annotations

import math
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau import Record
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.rounding import rounding_adjustment
from sigmatau.quality.samples.resolution import resolution
from sigmatau.quality.selection.window import choose

RECORDS: dict[str, dict[str, Any]] = {
    "adis16405_static.csv.gz": {"rate": 100},
    "hfi/imu_data.txt.gz": {
        "rate": 9.86,
        "channels": {"gyro": "2:4", "accel": "5:7"},
        "unit": {"gyro": "rad/s", "accel": "g"},
    },
    "vn100/live_capture.txt.gz": {"rate": 40},
    "mpu6050_10min.npz": {"unit": {"time": "s"}},
    "field/ch104.mat": {
        "rate": 100,
        "channels": {"gyro": "4:6", "accel": "1:3"},
        "unit": {"gyro": "deg/s", "accel": "g"},
    },
    "field/vn100_stationary.mat": {
        "channels": {"time": "1", "gyro": "11:13", "accel": "8:10"},
        "unit": {"time": "us", "gyro": "rad/s", "accel": "m/s^2"},
    },
    "field/xdot_2.csv.gz": {"unit": {"gyro": "deg/s", "accel": "m/s^2", "time": "s"}},
}
WINDOWS = {"field/vn100_stationary.mat": "520s:1140s", "field/xdot_2.csv.gz": "1s:120s"}
"""Parts at rest: people walked past before; the first row is not a sample."""

TERMS = ("random_walk", "bias_instability")
LIMIT = 1.5


def fitted(record: Record, channel: str) -> NoiseFit:
    """Fit a channel like `analyze`."""
    fit = fit_channel(record, channel)
    steps = resolution(record.stream_of(channel), channel)
    if steps is None or steps.ratio > 3:
        return fit
    return adjusted(fit, partial(rounding_adjustment, step=steps.step, noise=steps.noise))


def deviate(first: NoiseFit, second: NoiseFit, term: str) -> float | None:
    """Difference of the logarithms of a coefficient over its standard error; None if either has no interval."""
    sides = []
    for fit in (first, second):
        stated = fit.terms.get(term)
        if stated is None or not stated.value or not stated.low or not stated.high:
            return None
        sides.append((math.log(stated.value), math.log(stated.high / stated.low) / 3.92))
    (a, ea), (b, eb) = sides
    return (a - b) / math.hypot(ea, eb)


def rows(folder: Path) -> list[dict[str, Any]]:
    """Results of every axis: its fit, the fits of the halves, and their deviates."""
    results = []
    for name, options in RECORDS.items():
        if not (folder / name).exists():
            sys.stderr.write(f"real_records: skipped, {name} is absent\n")
            continue
        record = st.read(folder / name, **options)
        start, end = 0.0, max(stream.grid.duration for stream in record.streams)
        if name in WINDOWS:
            start, end = (float(part.rstrip("s")) for part in WINDOWS[name].split(":"))
        middle = (start + end) / 2
        halves = [choose(record, f"{a}s:{b}s")[0] for a, b in ((start, middle), (middle, end))]
        record = choose(record, f"{start}s:{end}s")[0]
        for stream in record.streams:
            if stream.quantity == "temperature":
                continue
            for channel in stream.channels:
                whole, first, second = (fitted(part, channel) for part in (record, *halves))
                deviates = {term: deviate(first, second, term) for term in TERMS}
                results.append({"record": name, "whole": whole, "halves": (first, second), "deviates": deviates})
    return results


def main() -> None:
    """Run the study and write docs/study/real-records.md."""
    results = rows(Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data")))
    if not results:
        return
    lines = [_HEAD]
    for row in results:
        fit = row["whole"]
        text = f"| {Path(row['record']).name} | {fit.channel} | {fit.headline()}"
        for term in TERMS:
            text += f" | {_stated(fit, term)} | {' , '.join(_stated(half, term) for half in row['halves'])}"
            z = row["deviates"][term]
            text += " | " if z is None else f" | {z:+.1f}"
        lines.append(text + " |")
    lines.append("")
    for name, chosen in (("gyros", "gyro"), ("accelerometers", "accel")):
        for term in TERMS:
            z = [r["deviates"][term] for r in results if r["whole"].channel.startswith(chosen)]
            deviates = np.array([value for value in z if value is not None])
            rms = math.sqrt(float(np.mean(deviates**2))) if len(deviates) else math.nan
            lines.append(
                f"- {name}, {term}: rms {rms:.2f} of {len(deviates)} axes, {np.sum(np.abs(deviates) > 3)} beyond 3"
            )
    without = [r for r in results if r["whole"].terms["random_walk"].high is None]
    lines.append(f"- axes without an interval of the random walk: {len(without)} of {len(results)}")
    Path("docs/study/real-records.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _stated(fit: NoiseFit, term: str) -> str:
    if fit.terms.get(term) is None:
        return "no fit"
    value, interval, unit = fit.texts(term)[0]
    return " ".join(part for part in (value, interval, unit) if part)


_HEAD = f"""# Real records

Made by `make study` (studies/real_records.py). Every axis fitted with the defaults of `sigmatau analyze`, and the halves of
each record alone. z is the difference of the logarithms of the halves' values over its standard error, from their 95 %
intervals. Wanted: an interval of the random walk on every axis, and a root mean square of z
of at most {LIMIT} for the gyros.

| record | axis | fit | N | halves | z | B | halves | z |
|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
