"""Test of rest for accelerometers alone and for one axis: verdicts on moving records, and trusted axes.

The table is part of docs/study/rest.md, which ``python -m studies.rest`` writes.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau.units import to_si
from studies.motions import GRADES, KINDS, SMALL_KINDS, held, moving
from studies.rest_windows import CLASSES, clean, verdict

SENSORS = {
    "accel, 3": "three accelerometers",
    "accel, 2": "two accelerometers",
    "accel, 1": "one accelerometer",
    "gyro, 1": "one gyro",
}
MOTIONS = {
    "accel": ("tilt", "springs", "car", "walk", "drone", "hand", "held", "vibration"),
    "gyro": ("car", "walk", "drone", "hand", "held", "turntable"),
}
RATES = (25.0, 50.0, 100.0, 250.0, 1000.0)
SHORTEST, LONGEST, MAX_SAMPLES = 20.0, 300.0, 60_000
RECORDS = 20  # per cell
CLEAN_RECORDS, CLEAN_CELLS = 14, 9  # records per cell, cells per class of sensors
UNIT_OF_WALK = {"gyro": "deg/sqrt(h)", "accel": "m/s/sqrt(h)"}
LARGE = 1.5  # error that makes a random walk useless


def grade_of_axes(seed: int, kind: str) -> str:
    """The grade of the sensor of `moving_axes`."""
    return "MEMS" if kind == "held" else str(np.random.default_rng([seed, 1]).choice(list(GRADES)))


def random_walk_of(grade: str, sensor: str) -> float:
    """The true random walk of a sensor. [SI]"""
    stated = GRADES[grade][sensor == "accel"]["random_walk"]
    return to_si(float(stated.split()[0]), UNIT_OF_WALK[sensor])


def moving_axes(seed: int, kind: str, sensors: str) -> st.Record:
    """A record of 20 s to 300 s of some axes of one sensor."""
    rng = np.random.default_rng(seed)
    sensor, axes = sensors.split(", ")
    rate = float(rng.choice(RATES))
    seconds = min(SHORTEST * (LONGEST / SHORTEST) ** rng.uniform(), MAX_SAMPLES / rate)
    drawn = int(rng.integers(1 << 62))
    if kind == "held":
        record = held(drawn, rate=rate, seconds=seconds, sensors=sensor)
    else:
        record = moving(drawn, kind, sensors=sensor, rate=rate, minutes=seconds / 60, grade=grade_of_axes(seed, kind))
    names = rng.permutation([f"{sensor}_{axis}" for axis in "xyz"])[: int(axes)]
    columns = {str(name): record.stream_of(str(name)).column(str(name)) for name in sorted(names)}
    return st.Record.from_arrays(rate=rate, **columns)  # type: ignore[arg-type]  # names of channels


def judge_axes(seed: int, kind: str, sensors: str) -> list[dict[str, Any]]:
    """Verdicts, replaced by "good" for a record at rest with an axis of trust "good"; and errors of the random walk of
    such axes.
    """
    rng = np.random.default_rng(seed)
    sensor = sensors.split(", ")[0]
    rows = []
    for _ in range(RECORDS):
        drawn = int(rng.integers(1 << 62))
        analysis = st.analyze(moving_axes(drawn, kind, sensors), threads=1)
        at_rest = "" if analysis.rest is None else analysis.rest.verdict
        truth = random_walk_of(grade_of_axes(drawn, kind), sensor)
        errors = [error_of_walk(fitted, truth) for fitted in analysis.fits.values() if fitted.trust == "good"]
        rows.append({"verdict": "good" if errors and at_rest == "at_rest" else at_rest, "errors": errors})
    return rows


def error_of_walk(fitted: st.NoiseFit, truth: float) -> float:
    """The random walk over the truth, and 1 if its interval or limit has the truth."""
    walk = fitted.terms["random_walk"]
    low, high = (walk.low, walk.high) if walk.observed else (0.0, walk.upper_limit)
    if (low or 0.0) <= truth <= (high or math.inf):
        return 1.0
    return float((walk.value or high or 0.0) / truth)


def judge_clean_axes(seed: int, grade: str) -> list[dict[str, Any]]:
    """Clean records: verdicts on some axes of each, and whether the fit of an axis exceeds the noisiest sensors."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(CLEAN_RECORDS):
        record = clean(int(rng.integers(1 << 62)), grade)
        for sensors in SENSORS:
            sensor, axes = sensors.split(", ")
            columns = {
                f"{sensor}_{axis}": record.stream_of(f"{sensor}_{axis}").column(f"{sensor}_{axis}") for axis in "xyz"
            }
            some = dict(list(columns.items())[-int(axes) :])
            part = st.Record.from_arrays(rate=record.streams[0].grid.rate, **some)  # type: ignore[arg-type]
            row: dict[str, Any] = {"sensors": sensors, "verdict": verdict(part).verdict}
            if axes == "1" and all(np.ptp(x) > 0 for x in some.values()):  # coarse steps may hide all noise
                codes = {finding.code for finding in st.analyze(part, threads=1).findings}
                row["doubted"] = bool(codes & {"beyond_class", "implausible_unit"})
            rows.append(row)
    return rows


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Function and arguments of each cell, by its name."""
    moves = {
        f"axes, {kind}, {sensors}": (judge_axes, (kind, sensors))
        for sensors in SENSORS
        for kind in MOTIONS[sensors.split(", ")[0]]
    }
    return moves | {
        f"clean axes, {grade}, {k}": (judge_clean_axes, (grade,)) for grade in CLASSES for k in range(CLEAN_CELLS)
    }


def text(results: Mapping[str, Any]) -> str:
    """Section of the page."""
    kinds = dict.fromkeys(kind for kinds in MOTIONS.values() for kind in kinds)
    assert set(kinds) <= {*KINDS, *SMALL_KINDS, "held"}
    lines = [_HEAD, f"| axes | {' | '.join(kinds)} |", "|---" * (len(kinds) + 1) + "|"]
    for sensors, name in SENSORS.items():
        row = [name]
        for kind in kinds:
            count = Counter(row["verdict"] for row in results.get(f"axes, {kind}, {sensors}", ()))
            numbers = count["not_at_rest"], count["partly_at_rest"], count["at_rest"], count["good"]
            row.append(" / ".join(map(str, numbers)) if count else "–")
        lines.append(f"| {' | '.join(row)} |")
    errors = {
        kind: [
            error
            for sensors in SENSORS
            for row in results.get(f"axes, {kind}, {sensors}", ())
            if row["verdict"] == "good"
            for error in row["errors"]
        ]
        for kind in kinds
    }
    lines += [_TAIL, _ERRORS]
    for kind, errors_of_kind in errors.items():
        if errors_of_kind:
            outside = sum(error != 1 for error in errors_of_kind)
            large = sum(max(error, 1 / error) > LARGE for error in errors_of_kind)
            lines.append(f"| {kind} | {len(errors_of_kind)} | {outside} | {large} |")
    names = [f"clean axes, {grade}, {k}" for grade in CLASSES for k in range(CLEAN_CELLS)]
    rows = [row for name in names for row in results[name]]
    refused = sum(row["verdict"] != "at_rest" for row in rows)
    doubted = [row["doubted"] for row in rows if "doubted" in row]
    lines.append(_CLEAN.format(refused=refused, records=len(rows), doubted=sum(doubted), axes=len(doubted)))
    return "\n".join(lines)


_HEAD = f"""
## Accelerometers alone, and one axis

Records of {SHORTEST:g} s to {LONGEST:g} s at {RATES[0]:g} to {RATES[-1]:g} Hz, as `sigmatau.analyze` has them.
Tilt: a steady 0.3 to 1 deg/s. Springs: a car's 0.4 m/s² peak to peak, below 4 Hz and at its wheels. Vibration: 10 to 50 Hz
alone, up to 0.4 m/s² peak to peak. Held: a phone that is kept still. Number of {RECORDS} records that are not at rest /
partly at rest / at rest without an axis of trust "good" / at rest with one:
"""

_TAIL = """
Noise below 2 Hz beyond that of the noisiest accelerometer, on three axes that measure gravity, is motion, and so is a mean
that changes faster than in any warm-up. One or two axes do not show whether the unit is wrong: there the finding
`beyond_class` bars "good" where the fit exceeds the noisiest sensors. Vibration above 10 Hz is not motion: it averages out.
A phone that is kept still makes less than the noise of the noisiest accelerometers. A constant rate of a turntable that is
below the largest bias of gyros is a bias to a single gyro."""

_ERRORS = f"""
Axes of trust "good" in records at rest; those whose random walk has the truth outside its 95 % interval; and those whose
random walk is wrong by more than {LARGE:g} times:

| motion | good | outside | wrong by more than {LARGE:g} times |
|---|---|---|---|"""

_CLEAN = """
The same axes of clean records (below): {refused} of {records} are not called at rest. Of {axes} fits of one axis, {doubted}
have the finding `beyond_class` or `implausible_unit`."""
