"""Test of rest for short records: windows of moving records, simulated and real, and clean records of 10 s to 4 h.

The tables are part of docs/study/rest.md, which ``python -m studies.rest`` writes.
"""

from __future__ import annotations

import csv
import math
import os
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

import sigmatau as st
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.motion.stillness import find_movement
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.selection.rest import Rest, rest
from studies.motions import KINDS, held, moving

Floats = NDArray[np.float64]
Cells = dict[str, tuple[Any, tuple[Any, ...]]]

MOTIONS = (*KINDS, "held")
LENGTHS = (3, 4, 5, 10, 20)
SWING = math.radians(6.0)  # peak-to-peak rate of a window that must not be at rest [rad/s]
RATES = (1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 200.0, 1000.0)
# lengths of windows in the test without the rule of the shortest record [s]
JUDGED = (3, 4, 5, 6, 8, 10, 15, 20, 30, 50, 80, 150)
RECORDS, WINDOWS = 8, 4  # per cell

# Coefficients of gyros [deg/√h, deg/h, deg/h/√h] and of accelerometers [m/s/√h, mg], and angle noise [arcsec], from optical
# gyros to the noisiest MEMS at full range: first MEMS gyros have 0.1 (deg/s)/√Hz, consumer accelerometers 1 mg/√Hz.
CLASSES: dict[str, tuple[tuple[float, float, float], tuple[float, float], float]] = {
    "FOG": ((0.003, 0.01, 0.01), (0.005, 0.005), 0.1),
    "tactical": ((0.08, 0.5, 1.0), (0.02, 0.02), 1.0),
    "industrial MEMS": ((0.3, 5.0, 10.0), (0.06, 0.04), 0.0),
    "consumer MEMS": ((0.6, 20.0, 40.0), (0.15, 0.1), 0.0),
    "noisy MEMS": ((2.5, 60.0, 120.0), (0.4, 0.3), 0.0),
    "noisiest MEMS": ((6.0, 200.0, 300.0), (0.59, 1.0), 0.0),
}
VARIANTS = ("plain", "warm-up", "coarse", "filtered", "coarse and filtered")
CLEAN_RECORDS, SHORT_RECORDS, CELL = 2016, 1008, 42
MAX_SAMPLES = 150_000
MIN_SECONDS, MAX_SECONDS = 20.0, 4 * 3600.0
LIMIT_REFUSED = 0.005


def verdict(record: st.Record) -> Rest:
    """Verdict of `sigmatau.analyze`."""
    with keep_facts():
        return rest(from_the_start(record))


def windows(record: st.Record, length: float, starts: Floats) -> Iterator[tuple[float, st.Record]]:
    """Windows of a record, by the time at which they begin."""
    for start in starts:
        streams = []
        for stream in record.streams:
            a = min(max(stream.grid.sample(float(start)), 0), stream.grid.n)
            b = min(a + round(length * stream.grid.rate), stream.grid.n)
            streams.append(stream.cut(a, b))
        yield float(start), st.Record(streams=tuple(streams))


def swing(record: st.Record) -> float:
    """Largest peak-to-peak rate of a gyro axis. [rad/s]"""
    columns = [s.column(c) for s in record.streams if s.quantity == "angular_rate" for c in s.channels]
    return max(float(np.nanmax(x) - np.nanmin(x)) if np.isfinite(x).any() else 0.0 for x in columns)


def in_motion(seed: int, kind: str, rate: float | None = None) -> st.Record:
    """A record in motion: one minute if its rate is stated, longer for slow rates."""
    if kind == "held":
        return held(seed, rate=rate or 100.0, seconds=60.0 if rate is None else max(60.0, 300.0 / rate))
    return moving(seed, kind, rate=rate, minutes=None if rate is None else max(1.0, 5.0 / rate))


def judge_windows(seed: int, kind: str, records: int = RECORDS) -> dict[str, dict[str, int]]:
    """Verdicts on windows above `SWING` by length."""
    rng = np.random.default_rng(seed)
    counts: dict[str, Counter[str]] = {str(length): Counter() for length in LENGTHS}
    for _ in range(records):
        record = in_motion(int(rng.integers(1 << 62)), kind)
        end = record.streams[0].grid.duration
        for length in LENGTHS:
            for _, window in windows(record, length, rng.uniform(0, end - length, WINDOWS)):
                if swing(window) > SWING:
                    counts[str(length)][verdict(window).verdict] += 1
    return {length: dict(count) for length, count in counts.items()}


def judge_evidence(seed: int, kind: str, rate: float) -> dict[str, list[int]]:
    """Numbers of windows above `SWING` and of those without a sign of motion, by sensors and length, without a shortest
    record.
    """
    rng = np.random.default_rng(seed)
    counts = {f"{sensor} {length}": [0, 0] for sensor in ("gyro", "accel") for length in JUDGED}
    for _ in range(RECORDS // 2):
        record = in_motion(int(rng.integers(1 << 62)), kind, rate)
        end = record.streams[0].grid.duration
        for length in JUDGED:
            for _, window in windows(record, length, rng.uniform(0, max(end - length, 0), WINDOWS)):
                if window.streams[0].grid.duration < 0.99 * length or swing(window) <= SWING:
                    continue
                for sensor, stream in zip(("gyro", "accel"), window.streams, strict=True):
                    count = counts[f"{sensor} {length}"]
                    count[0] += 1
                    count[1] += find_movement([stream]).motion is None
    return counts


def clean(seed: int, grade: str, *, shortest: float = MIN_SECONDS, longest: float = MAX_SECONDS) -> st.Record:
    """A record at rest of six axes: 10 Hz to 4 kHz, one of the variants, no more than `MAX_SAMPLES`."""
    rng = np.random.default_rng(seed)
    rate = math.exp(rng.uniform(math.log(10), math.log(4000)))
    seconds = math.exp(rng.uniform(math.log(shortest), math.log(longest)))
    n = max(round(min(seconds, max(MAX_SAMPLES / rate, shortest)) * rate), math.ceil(shortest * rate))
    variant = str(rng.choice(VARIANTS))
    (arw, bias, rrw), (vrw, instability), angle = CLASSES[grade]
    t = np.arange(n) / rate
    columns = {}
    for sensor in ("gyro", "accel"):
        degree, hour = math.pi / 180, 3600.0
        if sensor == "gyro":
            terms = arw * degree / 60, bias * degree / hour, rrw * degree / hour / 60, angle * degree / hour
            offset, warm, finest = rng.normal(0, 1) * degree, 1 * degree, 0.06 * degree
        else:
            terms = vrw / 60, instability * 9.8e-3, 0.0, 0.0
            offset, warm, finest = 0.05, 0.2, 0.005
        for axis in "xyz":
            white, flicker, walk, quantization = (x * rng.uniform(0.7, 1.0) for x in terms)
            x = white * math.sqrt(rate) * rng.standard_normal(n)
            for time in (1.0, 10.0, 100.0, 1000.0):  # a sum of processes as flat as bias instability
                a = math.exp(-1 / rate / time)
                x += lfilter([0.4 * flicker * math.sqrt(1 - a * a)], [1, -a], rng.standard_normal(n))
            x += walk / math.sqrt(rate) * np.cumsum(rng.standard_normal(n))
            x += quantization * rate * np.diff(rng.standard_normal(n + 1))
            if variant == "warm-up":
                x += rng.uniform(0.2, 1.0) * warm * np.exp(-t / rng.uniform(100, 1200))
            if "filtered" in variant:
                a = math.exp(-2 * math.pi * max(rng.uniform(0.03, 0.3), 1.0 / rate))
                x = lfilter([1 - a], [1, -a], x, zi=[a * x[0]])[0]
            x += offset + (9.80665 if (sensor, axis) == ("accel", "z") else 0.0)
            if "coarse" in variant:
                step = max(finest, white * math.sqrt(rate) * rng.uniform(0.5, 5))
                x = step * np.round(x / step)
            columns[f"{sensor}_{axis}"] = x
    return st.Record.from_arrays(rate=rate, **columns)  # type: ignore[arg-type]  # names of channels


def judge_clean(seed: int, grade: str, shortest: float, longest: float, records: int) -> list[dict[str, Any]]:
    """Verdicts on clean records of six axes and of their accelerometers alone, with length and rate."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(records):
        record = clean(int(rng.integers(1 << 62)), grade, shortest=shortest, longest=longest)
        grid = record.streams[0].grid
        rows.append({"verdict": verdict(record).verdict, "seconds": grid.duration, "rate": grid.rate})
    return rows


def real_logs(folder: Path) -> Iterator[tuple[str, st.Record]]:
    """Real logs that move, by file; those that are absent are skipped."""
    reading: dict[str, dict[str, Any]] = {
        "field/dataflash_171.bin": {"topic": "IMU"},
        "field/moving_1khz.csv.gz": {
            "channels": {"time": 2, "accel": "3:5", "gyro": "6:8"},
            "unit": {"time": "s", "gyro": "rad/s", "accel": "g"},
        },
        "field/many_positions.log": {
            "rate": 100,
            "channels": {"accel": "1:3", "gyro": "4:6"},
            "unit": {"accel": "m/s^2", "gyro": "rad/s"},
        },
        "cases/car_drive.csv": {"unit": {"time": "s", "gyro": "rad/s", "accel": "m/s^2"}},
        "cases/moving_phone_5s_xyz.csv": {"channels": {"time": "1", "gyro": "2:4"}},
    }
    for name, options in reading.items():
        if (folder / name).exists():
            yield name, st.read(folder / name, **options)
        else:
            sys.stderr.write(f"rest: skipped, {name} is absent\n")
    name = "cases/clock_one_digit_hour.txt"
    if (folder / name).exists():
        with (folder / name).open(encoding="utf-8", newline="") as file:
            values = np.array([row[1:7] for row in list(csv.reader(file))[1:]], dtype=float)
        unit = {"gyro": "deg/s", "accel": "g"}
        yield name, st.Record.from_arrays(rate=10, unit=unit, gyro=values[:, 3:], accel=values[:, :3])


def judge_real(folder: Path, *, stride: int = 1) -> dict[str, dict[int, Counter[str]]]:
    """Verdicts on every `stride`-th window above `SWING` of each real log, by length."""
    counts_by_log: dict[str, dict[int, Counter[str]]] = {}
    for name, record in real_logs(folder):
        record = from_the_start(record)
        end = record.streams[0].grid.duration
        for length in LENGTHS:
            count = counts_by_log.setdefault(name, {}).setdefault(length, Counter())
            for _, window in windows(record, length, np.arange(0.0, end - length + 1e-6, stride * length)):
                if swing(window) > SWING:
                    count[verdict(window).verdict] += 1
    return counts_by_log


def cells() -> Cells:
    """Function and arguments of each cell, by its name."""
    made: Cells = {f"windows, {kind}": (judge_windows, (kind,)) for kind in MOTIONS}
    for kind in MOTIONS:
        for rate in RATES:
            made[f"evidence, {kind}, {rate:g}"] = (judge_evidence, (kind, rate))
    for grade in CLASSES:
        for k in range(CLEAN_RECORDS // CELL // len(CLASSES)):
            made[f"clean, {grade}, {k}"] = (judge_clean, (grade, MIN_SECONDS, MAX_SECONDS, CELL))
        for k in range(SHORT_RECORDS // CELL // len(CLASSES)):
            made[f"short, {grade}, {k}"] = (judge_clean, (grade, 10.0, MIN_SECONDS, CELL))
    return made


def text(results: Mapping[str, Any]) -> str:
    """Sections of the page."""
    lines = [_EVIDENCE]
    for sensor, title in (("gyro", "gyros"), ("accel", "accelerometers")):
        lines += [f"\n| {title} | {' | '.join(f'{rate:g} Hz' for rate in RATES)} |", "|---" * (len(RATES) + 1) + "|"]
        for length in JUDGED:
            row = [f"{length} s"]
            for rate in RATES:
                counts = [results[f"evidence, {kind}, {rate:g}"][f"{sensor} {length}"] for kind in MOTIONS]
                total, hidden = (sum(count[k] for count in counts) for k in (0, 1))
                row.append(f"{hidden} of {total}" if total else "–")
            lines.append(f"| {' | '.join(row)} |")
    lines.append(_WINDOWS)
    at_rest = total = 0
    table: dict[str, Mapping[Any, Mapping[str, int]]] = {
        kind: {length: results[f"windows, {kind}"][str(length)] for length in LENGTHS} for kind in MOTIONS
    }
    table |= judge_real(Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data")))
    for name, by_length in table.items():
        row = [f"`{Path(name).name}`" if "/" in name else name]
        for length in LENGTHS:
            count = by_length[length]
            at_rest += count.get("at_rest", 0) + count.get("partly_at_rest", 0)
            total += sum(count.values())
            row.append(
                " / ".join(str(count.get(verdict, 0)) for verdict in ("not_at_rest", "too_short_to_tell", "at_rest"))
            )
        lines.append(f"| {' | '.join(row)} |")
    lines.append(f"\nAt rest: **{at_rest}** of {total} windows; none is allowed.\n{_REFUSED}")
    refused = number = 0
    for grade in CLASSES:
        row = [grade]
        for part in ("clean", "short"):
            rows = [verdict for name in results if name.startswith(f"{part}, {grade}, ") for verdict in results[name]]
            bad = sum(verdict["verdict"] != "at_rest" for verdict in rows)
            if part == "clean":
                refused, number = refused + bad, number + len(rows)
            row.append(f"{bad} of {len(rows)}")
        lines.append(f"| {' | '.join(row)} |")
    error = math.sqrt(max(refused, 1)) / number
    holds = "holds" if refused / number <= LIMIT_REFUSED + 3 * error else "does NOT hold"
    lines.append(f"\nRefused from 20 s on: {refused} of {number}; the limit of {100 * LIMIT_REFUSED:g} % {holds}.\n")
    return "\n".join(lines)


_EVIDENCE = """
## The shortest record

A record that shows no motion is at rest only if motion would show. Windows of the moving records above, and of a phone in a
hand that is kept as still as possible (tremor of 8 to 12 Hz, 7 to 16 deg/√h), in which a gyro swings by more than 6 deg/s
peak to peak. Number of windows without a sign of motion in the samples of one kind of sensor:
"""

_WINDOWS = f"""
Accelerometers alone do not show a phone that is kept still, nor always a drone, in windows of any length; below 10 Hz
aliased motion is white.

From these tables: the shortest record is 10 s with gyros and 20 s with accelerometers alone, and 150 samples. A shorter
record that shows no motion is too short to tell, with exit code 5, unless `--at-rest` is given.

## Windows of moving records

Windows in which a gyro swings by more than {math.degrees(SWING):g} deg/s peak to peak, of simulated records and of real
logs of a flight, of sensors in someone's hands, and of a car. Number of windows not at rest / too short to tell / at rest:

| record | {" | ".join(f"{length} s" for length in LENGTHS)} |
|---|---|---|---|---|---|"""

_REFUSED = """
## Clean records of any length

Six axes of optical gyros to the noisiest MEMS, 10 Hz to 4 kHz, with bias instability and rate random walk. Four fifths have
a warm-up, coarse steps, a low-pass filter of 0.03 to 0.3 of the sampling rate (1 Hz or more), or the last two. Number of
records that are not called at rest:

| class | 20 s to 4 h | 10 s to 20 s |
|---|---|---|"""
