"""Test of whether a record is at rest: moving sensors of six kinds, clean records, and records of sensors that are picked
up for ten seconds.

``python -m studies.rest`` writes docs/study/rest.md.
"""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

import sigmatau as st
from sigmatau.fitting.channel import fit_channel
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.selection.rest import Rest, at_rest_only, rest
from sigmatau.units import to_si
from studies import false_alarms, rest_axes, rest_small, rest_windows
from studies.motions import GRADES, KINDS, band, handled, moving
from studies.runner import run

MOVING, CLEAN, HANDLED = 204, 360, 200
A_CELL = 10
SENSORS = {"both": "six axes", "gyro": "gyros only", "accel": "accelerometers only"}
DISTURBED = ("warm-up", "lines", "coarse", "filtered", "vibrated", "Gauss-Markov")
LIMIT_FALSE, MIN_COVERED = 0.02, 0.92
TERMS = ("random_walk", "bias_instability", "rate_random_walk")


def verdict(record: st.Record) -> Rest:
    """Verdict of `sigmatau.analyze`."""
    with keep_facts():
        return rest(from_the_start(record))


def judge_moving(seed: int, kind: str, sensors: str, records: int) -> list[str]:
    """Verdicts on moving records."""
    rng = np.random.default_rng(seed)
    return [verdict(moving(int(rng.integers(1 << 62)), kind, sensors=sensors)).verdict for _ in range(records)]


def at_rest(seed: int, kind: str, length: str) -> st.Record:
    """A record at rest of one of the grades of the study of false alarms, or of consumer MEMS with a disturbance."""
    rng = np.random.default_rng(seed)
    grade = kind if kind in false_alarms.GRADES else "consumer MEMS"
    record = false_alarms.record(seed, grade, length, gravity=True)
    if kind == grade:
        return record
    rate = record.streams[0].grid.rate
    columns = {}
    for name in record.channels:
        x = record.stream_of(name).column(name)
        t = np.arange(len(x)) / rate
        white = float(np.median(np.abs(np.diff(x)))) / 0.954  # standard deviation of the white noise
        unit = to_si(1.0, "deg/s") if name.startswith("gyro") else to_si(20.0, "mg")
        if kind == "warm-up":
            x = x + rng.uniform(0.2, 1.0) * unit * np.exp(-t / rng.uniform(100, 1200))
        elif kind == "lines":
            for f in 10 ** rng.uniform(-1, math.log10(rate / 2), size=8):
                x = x + white * rng.uniform(0.05, 0.3) * np.sin(2 * np.pi * f * t + rng.uniform(0, 6))
        elif kind == "coarse":
            step = white * rng.uniform(2, 20)
            x = step * np.round(x / step)
        elif kind == "filtered":
            level = x.mean()
            f = np.fft.rfftfreq(len(x), 1 / rate)
            gain = 1 / np.sqrt(1 + (f / (rng.uniform(0.02, 0.3) * rate)) ** 4)
            x = level + np.fft.irfft(np.fft.rfft(x - level) * gain, len(x))
        elif kind == "Gauss-Markov":
            time, power = rng.uniform(1, 3), rng.uniform(1, 5) * white / math.sqrt(rate)
            a = math.exp(-1 / rate / time)
            x = x + lfilter([power * math.sqrt((1 - a * a) / (2 * time))], [1, -a], rng.standard_normal(len(x)))
        else:
            shaken = (0.3 if name.startswith("gyro") else 5.0) * unit
            x = x + rng.uniform(0.2, 2) * shaken * band(rng, len(x), rate, 0.2 * rate, 0.45 * rate)
        columns[name] = x
    return st.Record.from_arrays(rate=rate, **columns)  # type: ignore[arg-type]  # names of channels


def judge_clean(seed: int, kind: str, length: str, records: int) -> list[str]:
    """Verdicts on records at rest."""
    rng = np.random.default_rng(seed)
    return [verdict(at_rest(int(rng.integers(1 << 62)), kind, length)).verdict for _ in range(records)]


def judge_handled(seed: int, grade: str, records: int) -> list[dict[str, Any]]:
    """Records of sensors that are picked up for ten seconds: verdict, share kept of gyros and accelerometers, and
    coverage.
    """
    rng = np.random.default_rng(seed)
    truth = st.NoiseModel.from_dict({"channels": {"gyro_x": GRADES[grade][0]}}).channels["gyro_x"].terms
    rows = []
    for _ in range(records):
        record, (start, stop) = handled(int(rng.integers(1 << 62)), grade)
        with keep_facts():
            record = from_the_start(record)
            resting = rest(record)
            part, findings = at_rest_only(record, resting, assumed=False)
            shares = {
                stream.stream: stream.share for finding in findings for stream in getattr(finding.details, "kept", ())
            }
            holds: dict[str, list[bool]] = {term: [] for term in TERMS}
            for channel in part.stream_of("gyro_x").channels if resting.verdict == "partly_at_rest" else ():
                fitted = fit_channel(part, channel)
                for term in TERMS:
                    stated = fitted.terms[term]
                    low, high = (stated.low, stated.high) if stated.observed else (0.0, stated.upper_limit or math.inf)
                    holds[term].append(bool((low or 0.0) <= truth[term] <= (high or math.inf)))
        outside = all(b <= start + 1 or a >= stop - 1 for a, b in resting.still)
        rows.append({"verdict": resting.verdict, "kept": shares, "holds": holds, "outside": outside})
    return rows


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Function and arguments of each cell, by its name."""
    made: dict[str, tuple[Any, tuple[Any, ...]]] = {}
    for kind in KINDS:
        for sensors in SENSORS:
            made[f"{kind}, {sensors}"] = (judge_moving, (kind, sensors, MOVING // len(KINDS)))
    kinds = (*false_alarms.GRADES, *DISTURBED)
    pairs = [(kind, length) for kind in kinds for length in false_alarms.LENGTHS]
    for kind, length in pairs:
        made[f"{kind}, {length}"] = (judge_clean, (kind, length, math.ceil(CLEAN / len(pairs))))
    for grade in GRADES:
        for k in range(HANDLED // len(GRADES) // A_CELL):
            made[f"handled, {grade}, {k}"] = (judge_handled, (grade, A_CELL))
    return rest_windows.cells() | rest_axes.cells() | rest_small.cells() | made


def main() -> None:
    """Run the study and write docs/study/rest.md."""
    every = cells()
    results = run("rest", every, settings=repr((MOVING, CLEAN, HANDLED, A_CELL)))
    lines = [_HEAD]
    wrong = 0
    for sensors, text in SENSORS.items():
        row = [f"| {text}"]
        for kind in KINDS:
            counts = Counter(results[f"{kind}, {sensors}"])
            wrong += len(results[f"{kind}, {sensors}"]) - counts["not_at_rest"] if sensors == "both" else 0
            row.append(" / ".join(str(counts[verdict]) for verdict in ("not_at_rest", "partly_at_rest", "at_rest")))
        lines.append(" | ".join(row) + " |")
    lines.append(f"\nSix-axis records with coefficients: **{wrong}** of {MOVING}; none is allowed.\n{_CLEAN}")
    false = total = 0
    for kind in (*false_alarms.GRADES, *DISTURBED):
        row = [f"| {kind}"]
        for length in false_alarms.LENGTHS:
            verdicts = results[f"{kind}, {length}"]
            moving = sum(verdict != "at_rest" for verdict in verdicts)
            false, total = false + moving, total + len(verdicts)
            row.append(f"{moving} of {len(verdicts)}")
        lines.append(" | ".join(row) + " |")
    error = math.sqrt(max(false, 1)) / total
    holds = "holds" if false / total <= LIMIT_FALSE + 3 * error else "does NOT hold"
    lines.append(f"\nNot called at rest: {false} of {total}; the limit of {100 * LIMIT_FALSE:g} % {holds}.\n{_HANDLED}")
    for grade in GRADES:
        rows = [row for name in results if name.startswith(f"handled, {grade}") for row in results[name]]
        partly = [row for row in rows if row["verdict"] == "partly_at_rest"]
        shares = [np.mean([row["kept"][sensor] for row in partly]) for sensor in ("gyro", "accel")]
        texts = []
        for term in TERMS:
            inside = [holds_ for row in partly for holds_ in row["holds"][term]]
            share = float(np.mean(inside))
            error = math.sqrt(MIN_COVERED * (1 - MIN_COVERED) / len(inside))
            texts.append(f"{100 * share:.1f} %" + ("" if share >= MIN_COVERED - 3 * error else " (too few)"))
        outside = sum(row["outside"] for row in rows)
        lines.append(
            f"| {grade} | {len(partly)} of {len(rows)} | {outside} | {100 * shares[0]:.0f} % | {100 * shares[1]:.0f} % | "
            + " | ".join(texts)
            + " |"
        )
    lines.append(rest_axes.text(results))
    lines.append(rest_small.text(results))
    lines.append(rest_windows.text(results))
    Path("docs/study/rest.md").write_text("\n".join(lines), encoding="utf-8")


_HEAD = """# At rest or not

Made by `make study` (studies/rest.py). `sigmatau analyze` gives coefficients only of a sensor at rest. The verdict is tested
with simulated records.

## Moving records

Cars, walks, drones, hand-held sensors, turntables and ships at anchor (studies/motions.py): 1 to 10 min at 50 to 200 Hz,
with gravity, rigid-body rotation and the noise of MEMS or tactical sensors. Turntables have constant rates above 20 deg/s,
steps, or oscillations. Accelerometers alone on a level turntable with a constant rate rest, beside a line.

Number of records not at rest / partly at rest / at rest:

| sensors | car | walk | drone | hand | turntable | ship |
|---|---|---|---|---|---|---|"""

_CLEAN = """
## Clean records

The grades of the [study of false alarms](false-alarms.md), and consumer MEMS with a warm-up of up to 1 deg/s or 20 mg, eight
lines from 0.1 Hz on, steps of 2 to 20 standard deviations, a low-pass filter from 0.02 of the sampling rate on, the
vibration of an engine, or a Gauss–Markov process of 1 to 3 s that is one to five times the white noise at zero frequency.
One more than 8 times the white noise, and beyond 0.05 (deg/s)/√Hz or 15 (mm/s²)/√Hz, is called motion: it has the spectrum
of motion. `--at-rest` analyses it. Number of records that are not called at rest:

| grade | 20 min at 50 Hz | 1 h at 100 Hz | 2 h at 25 Hz |
|---|---|---|---|"""

_HANDLED = f"""
## Ten seconds of handling

Records of 30 min at 50 Hz: the sensor is taken up for 10 s, and is put down in another position half of the time. The gyros
feel the rotation of the Earth. Share of the record that is kept, and coverage of the 95 % intervals and limits of the gyros,
at least {100 * MIN_COVERED:g} % wanted:

| grade | partly at rest | handling left out | gyro kept | accel kept | N | B | K |
|---|---|---|---|---|---|---|---|"""


if __name__ == "__main__":
    main()
