"""Test of rest for slightly moving sensors: hands with a faint tremor, and accelerometers that tilt by a few degrees.

The tables are part of docs/study/rest.md, which ``python -m studies.rest`` writes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from studies.motions import DEGREE, GRAVITY, band, sensed
from studies.rest_axes import LARGE, error_of_walk, random_walk_of
from studies.rest_windows import verdict

Floats = NDArray[np.float64]

TREMORS = (0.1, 0.2, 0.4, 0.8)  # root mean square of a gyro at 8 to 12 Hz [deg/s]
SLOW = (0.0, 0.3, 0.6, 1.0, 1.5)  # ratio of the motion of 0.3 to 4 Hz to the tremor, root mean squares [1]
HAND_RATES, HAND_SECONDS = (50.0, 100.0, 400.0), (12.0, 60.0)
ACCELERATION = 1 / 9  # acceleration of a hand over its rate [m/s² per deg/s]
AVERAGED = (2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0)  # first zeros of moving averages [Hz]
TILTS = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)  # tilt in a record [deg]
TILT_SECONDS = (20.0, 60.0, 300.0, 1800.0)
WANDERS = ("gyro, slow", "gyro, walk", "accel, slow", "accel, walk")
RECORDS, TILT_RECORDS, WANDER_RECORDS = 40, 10, 20  # per cell
PEOPLE_RECORDS, PEOPLE_CELLS = 6, 6


def small_hand(seed: int, tremor: float, slow: float) -> st.Record:
    """Six axes of a MEMS in a hand, with a tremor [deg/s] and a slow motion relative to it."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice(HAND_RATES))
    n = round(rate * rng.uniform(*HAND_SECONDS))

    def shaken() -> Floats:
        fast = np.stack([band(rng, n, rate, 8, 12) for _ in "xyz"])
        return np.asarray(fast + slow * np.stack([band(rng, n, rate, 0.3, 4) for _ in "xyz"]))

    upright = np.array([[0.0], [0.0], [GRAVITY]])
    return sensed(
        rng, tremor * DEGREE * shaken(), upright + tremor * ACCELERATION * shaken(), rate, "MEMS", sensors="both"
    )


def judge_hands(seed: int, tremor: float, slow: float) -> list[str]:
    """Verdicts on records of a sensor in a hand."""
    rng = np.random.default_rng(seed)
    return [verdict(small_hand(int(rng.integers(1 << 62)), tremor, slow)).verdict for _ in range(RECORDS)]


def judge_averaged(seed: int, zero: float) -> list[str]:
    """Verdicts on sensors at rest with one or two moving averages whose first zero is at a frequency. [Hz]"""
    rng = np.random.default_rng(seed)
    verdicts: list[str] = []
    for _ in range(RECORDS):
        rate = float(rng.choice(HAND_RATES))
        n = round(rate * rng.uniform(*HAND_SECONDS))
        still = np.zeros((3, n)), np.array([[0.0], [0.0], [GRAVITY]]) + np.zeros((3, n))
        record = sensed(rng, *still, rate, "MEMS")
        kernel = np.ones(round(rate / zero)) / round(rate / zero)
        if rng.random() < 0.5:
            kernel = np.convolve(kernel, kernel)
        columns = {c: np.convolve(record.stream_of(c).column(c), kernel, mode="valid") for c in record.channels}
        verdicts.append(verdict(st.Record.from_arrays(rate=rate, **columns)).verdict)  # type: ignore[arg-type]
    return verdicts


def judge_tilts(seed: int, degrees: float, seconds: float) -> list[str]:
    """Verdicts on MEMS accelerometers that tilt steadily about an axis."""
    rng = np.random.default_rng(seed)
    rate = 20.0 if seconds > 1000 else 100.0
    angle = np.radians(np.linspace(0, degrees, round(seconds * rate)))
    force = GRAVITY * np.stack([np.sin(angle), 0 * angle, np.cos(angle)])
    none = np.zeros_like(force)
    return [verdict(sensed(rng, none, force, rate, "MEMS", sensors="accel")).verdict for _ in range(TILT_RECORDS)]


def judge_wander(seed: int, kind: str) -> list[list[Any]]:
    """Verdicts on three axes that wander below 0.3 Hz or walk, and the number of axes with the finding `beyond_class`."""
    rng = np.random.default_rng(seed)
    sensor, motion = kind.split(", ")
    rows: list[list[Any]] = []
    for _ in range(WANDER_RECORDS):
        rate = float(rng.choice([50.0, 100.0]))
        n = round(rate * rng.uniform(40, 400))
        size = 10 ** (rng.uniform(-1.7, -0.3) if sensor == "gyro" else rng.uniform(-1, 0.7)) * DEGREE  # [rad/s or rad]
        wander = size * np.stack(
            [
                band(rng, n, rate, 0, rng.uniform(0.01, 0.3))
                if motion == "slow"
                else np.cumsum(rng.standard_normal(n)) / np.sqrt(60 * rate)
                for _ in "xyz"
            ]
        )
        still = np.zeros((3, n))
        tilt = wander[:2] + 30 * DEGREE  # so that three axes sense it
        force = GRAVITY * np.stack(
            [np.sin(tilt[0]), np.sin(tilt[1]) * np.cos(tilt[0]), np.cos(tilt[1]) * np.cos(tilt[0])]
        )
        rates, forces = (wander, still) if sensor == "gyro" else (still, force)
        analysis = st.analyze(sensed(rng, rates, forces, rate, "MEMS", sensors=sensor), threads=1)
        beyond = {c for finding in analysis.findings if finding.code == "beyond_class" for c in finding.channels}
        rows.append(["" if analysis.rest is None else analysis.rest.verdict, len(beyond)])
    return rows


def parked_people(seed: int) -> st.Record:
    """Six axes of a MEMS in a parked vehicle whose occupants move 4 to 80 times in 2 to 7 min, 0.03 to 0.4 deg/s."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice([50.0, 100.0, 200.0]))
    n = round(rate * rng.uniform(120, 400))
    t = np.arange(n) / rate
    envelope = np.zeros(n)
    for _ in range(int(rng.integers(4, 80))):
        envelope += np.exp(-(((t - rng.uniform(0, t[-1])) / rng.uniform(0.5, 2.5)) ** 2) / 2)
    envelope = np.minimum(envelope, 1)
    size = 10 ** rng.uniform(-1.5, -0.4)  # [deg/s]
    low = rng.uniform(0.6, 2.0)
    high = low + rng.uniform(0.5, 2.0)
    sway = rng.choice([0.0, 1 / 30])  # share of the size that is always present

    def moved() -> Floats:
        return np.stack([envelope * band(rng, n, rate, low, high) + sway * band(rng, n, rate, 1.2, 2) for _ in "xyz"])

    upright = np.array([[0.0], [0.0], [GRAVITY]])
    return sensed(rng, size * DEGREE * moved(), upright + size / 4 * moved(), rate, "MEMS")


def judge_people(seed: int) -> list[dict[str, Any]]:
    """Verdicts, and the errors of the random walk of axes of trust "good", see `error_of_walk`."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(PEOPLE_RECORDS):
        analysis = st.analyze(parked_people(int(rng.integers(1 << 62))), threads=1)
        good = [(channel, fitted) for channel, fitted in analysis.fits.items() if fitted.trust == "good"]
        errors = [error_of_walk(fitted, random_walk_of("MEMS", channel.split("_")[0])) for channel, fitted in good]
        rows.append({"verdict": "" if analysis.rest is None else analysis.rest.verdict, "errors": errors})
    return rows


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Function and arguments of each cell, by its name."""
    hands = {f"hand {tremor:g}, {slow:g}": (judge_hands, (tremor, slow)) for tremor in TREMORS for slow in SLOW}
    averaged = {f"averaged {zero:g}": (judge_averaged, (zero,)) for zero in AVERAGED}
    tilts = {f"tilt {d:g}, {seconds:g}": (judge_tilts, (d, seconds)) for d in TILTS for seconds in TILT_SECONDS}
    wanders = {f"wander, {kind}": (judge_wander, (kind,)) for kind in WANDERS}
    people = {f"people, {k}": (judge_people, ()) for k in range(PEOPLE_CELLS)}
    return {**hands, **averaged, **tilts, **wanders, **people}


def _moving(verdicts: list[str]) -> str:
    count = Counter(verdicts)
    return f"{count['not_at_rest'] + count['partly_at_rest']} of {len(verdicts)}"


def text(results: Mapping[str, Any]) -> str:
    """Section of the page."""
    lines = [
        _HANDS,
        f"| tremor | {' | '.join(f'slow motion {slow:g}' for slow in SLOW)} |",
        "|---" * (len(SLOW) + 1) + "|",
    ]
    for tremor in TREMORS:
        cells_of_row = [_moving(results[f"hand {tremor:g}, {slow:g}"]) for slow in SLOW]
        lines.append(f"| {tremor:g} deg/s | {' | '.join(cells_of_row)} |")
    averaged = [verdict for zero in AVERAGED for verdict in results[f"averaged {zero:g}"]]
    refused = sum(verdict != "at_rest" for verdict in averaged)
    lines.append(_AVERAGED.format(refused=refused, records=len(averaged)))
    lines += [f"| length | {' | '.join(f'{tilt:g}°' for tilt in TILTS)} |", "|---" * (len(TILTS) + 1) + "|"]
    for seconds in TILT_SECONDS:
        cells_of_row = [_moving(results[f"tilt {tilt:g}, {seconds:g}"]) for tilt in TILTS]
        lines.append(f"| {seconds:g} s | {' | '.join(cells_of_row)} |")
    wanders = [row for kind in WANDERS for row in results[f"wander, {kind}"]]
    still = [beyond for at_rest, beyond in wanders if at_rest == "at_rest"]
    beyond_on = ", ".join(str(still.count(k)) for k in (1, 2, 3))
    people = [row for k in range(PEOPLE_CELLS) for row in results[f"people, {k}"]]
    errors = [error for row in people for error in row["errors"]]
    lines.append(
        _PEOPLE.format(
            records=len(people),
            still=sum(row["verdict"] == "at_rest" for row in people),
            good=len(errors),
            axes=6 * len(people),
            outside=sum(error != 1 for error in errors),
            large=sum(max(error, 1 / error) > LARGE for error in errors),
        )
    )
    lines.append(_LIMITS.format(records=len(wanders), still=len(still), beyond=beyond_on))
    return "\n".join(lines)


_HANDS = f"""
## Hands with a faint tremor, and small tilts

Six axes of a MEMS of 0.05 deg/s at 100 Hz, for {HAND_SECONDS[0]:g} s to {HAND_SECONDS[1]:g} s at 50, 100 or 400 Hz.
Tremor of 8 to 12 Hz by its root mean square, and motion of 0.3 to 4 Hz by its size over that of the tremor; the acceleration
is 1/9 m/s² for 1 deg/s. Number of records that are recognised as motion:
"""

_AVERAGED = """
A moving average makes lobes at these frequencies on all axes. Sensors at rest behind one or two, with a first zero at 2.5 Hz
to 12 Hz: {refused} of {records} are not called at rest.

Accelerometers alone that tilt steadily by an angle within the record. Number that are recognised as motion:
"""

_PEOPLE = """
Six axes of a MEMS in a parked vehicle with people: {still} of {records} records rest, and {good} of {axes} axes are "good".
The truth is outside the 95 % interval of the random walk on {outside} of these; random walks that are wrong by more than
1.5 times: {large}. An axis of a sensor whose other axes are `disturbed` is at best "partial"."""

_LIMITS = """
A tilt of up to 5° that changes a mean no faster than the steepest warm-up, 50 mg within 100 s, is treated as a ramp of the
sensor, which is a term of the model beside the random walk.

Noise beyond that of the noisiest sensors is a warning, also on all three axes. Of {records} records of three gyros or three
accelerometers that wander below 0.3 Hz, or whose rate or tilt is a random walk, {still} are at rest. Records of these with
the warning on one, two and three axes: {beyond}.

Gyros in deg/s that are read as deg/h are not recognised from 0.25 deg/√h on, if they are one axis, and from 1.8 deg/√h on,
if they are three: read so, they are as quiet as optical gyros for sale, and one axis need not sense the Earth's rotation."""
