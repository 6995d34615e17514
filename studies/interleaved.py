"""Alternating rows of several sensors: detected and missed ones, and single sensors mistaken for several.

``python -m studies.interleaved`` writes docs/study/interleaved.md. Real records: see `studies.real_records`.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from sigmatau.io.read import turns
from sigmatau.io.read.interleaving import find_interleaving
from sigmatau.io.read.turns import compare_slow_noise
from studies.integer_logs import KINDS, integer_log
from studies.real_records import RECORDS
from studies.rest_windows import real_logs
from studies.runner import run
from studies.turns import SEVERAL, SINGLE, sensor, stamps

RECORDS_OF_A_CELL = 20
LENGTHS = {"10 s at 100 Hz": (1000, 100.0), "20 s at 1 kHz": (20_000, 1000.0), "10 min at 50 Hz": (30_000, 50.0)}
AXES = (3, 6)
STAMPS = {"even": "even stamps or none", "equal pairs": "stamps in groups"}
CLEAN = 250  # number of records of each of eight kinds
NULL = 400  # number of pairs of series
EQUAL_MEANS = 100  # number of logs of 6000 rows
WINDOW = 6000  # number of rows of a window of a real record
CHANNELS = tuple(f"{name}_{axis}" for name in ("gyro", "accel") for axis in "xyz")

Floats = NDArray[np.float64]


def verdict(samples: Floats, times: Floats | None) -> str:
    """``none``, ``asked`` or ``certain``."""
    result = find_interleaving({name: samples[:, k] for k, name in enumerate(CHANNELS[: samples.shape[1]])}, times)
    return "none" if result is None else "certain" if result.certain else "asked"


def judge_kind(seed: int, kind: str, how: str, length: str) -> dict[str, int]:
    """Verdicts on simulated logs, half of them with 3 axes and half with 6."""
    rng = np.random.default_rng(seed)
    n, rate = LENGTHS[length]
    make = {**SEVERAL, **SINGLE}[kind]
    verdicts: Counter[str] = Counter()
    for k in range(RECORDS_OF_A_CELL):
        samples = make(rng, n, rate, AXES[k % len(AXES)])
        times = stamps(rng, len(samples), rate, how, 3 if kind.startswith("three") else 2)
        verdicts[verdict(samples, times)] += 1
    return dict(verdicts)


def judge_clean(seed: int, kind: str) -> dict[str, int]:
    """Verdicts on integer logs of one sensor, with three axes of one kind and even stamps."""
    rng = np.random.default_rng(seed)
    verdicts: Counter[str] = Counter()
    for _ in range(CLEAN):
        axes = [integer_log(int(rng.integers(1 << 62)), kind)[0] for _ in range(3)]
        n = min(map(len, axes))
        verdicts[verdict(np.stack([axis[:n] for axis in axes], axis=1), None)] += 1
    return dict(verdicts)


def judge_null(seed: int, n: int) -> dict[str, int]:
    """Verdicts from the slow noise on pairs of independent sensors, whose rows have nothing in common."""
    rng = np.random.default_rng(seed)
    return dict(Counter(compare_slow_noise(sensor(rng, n, 50.0, 6), sensor(rng, n, 50.0, 6)) for _ in range(NULL)))


def judge_equal_means(seed: int, kind: str) -> int:
    """Number of logs of 100 in which the means do not depend on the turn. `kind`: of `SEVERAL` or `SINGLE`, or "zeroed":
    units of a model minus their means over the first 2 s, like the zeroing of gyros by firmware.
    """
    rng = np.random.default_rng(seed)
    make = {**SEVERAL, **SINGLE, "zeroed": SEVERAL["two units of a model"]}[kind]
    equal = 0
    for k in range(EQUAL_MEANS):
        samples = make(rng, WINDOW, 100.0, AXES[k % len(AXES)])
        if kind == "zeroed":
            units = samples.reshape(-1, 2, samples.shape[1])
            samples = (units - units[:100].mean(axis=0)).reshape(samples.shape)
        starts = turns.starts_of_parts(WINDOW, 2, 16)
        parts = np.stack([turns.rows_by_turn(axis, starts, 2) for axis in samples.T], axis=-1)
        equal += turns.means_by_turn(parts) is None
    return equal


def real(folder: Path) -> dict[str, Any]:
    """Number of windows of real records, and windows mistaken for several sensors."""
    windows, asked = 0, []
    at_rest = ((name, st.read(folder / name, **how)) for name, how in RECORDS.items() if (folder / name).exists())
    names = set()
    for name, record in (*at_rest, *real_logs(folder)):
        names.add(name)
        columns = {channel: record.stream_of(channel).column(channel) for channel in record.channels}
        columns = {channel: x for channel, x in columns.items() if channel in CHANNELS}
        n = min(map(len, columns.values()))
        for start in range(0, max(n - WINDOW, 0) + 1, WINDOW):
            window = {channel: x[start : start + WINDOW] for channel, x in columns.items()}
            windows += 1
            if find_interleaving(window, None) is not None:
                asked.append(f"{name} from row {start}")
    return {"windows": windows, "records": len(names), "asked": asked}


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Function and arguments of each cell, by its name."""
    made: dict[str, tuple[Any, tuple[Any, ...]]] = {}
    for kind in (*SEVERAL, *SINGLE):
        for how in STAMPS:
            for length in LENGTHS:
                made[f"{kind}, {how}, {length}"] = (judge_kind, (kind, how, length))
    made |= {f"clean, {kind}": (judge_clean, (kind,)) for kind in KINDS}
    made |= {
        f"equal means, {kind}": (judge_equal_means, (kind,)) for kind in ("clean", "two units of a model", "zeroed")
    }
    made |= {f"null, {n} rows": (judge_null, (n,)) for n in (500, 15_000)}
    return made


def _cell(verdicts: dict[str, int]) -> str:
    return f"{verdicts.get('certain', 0)} + {verdicts.get('asked', 0)}"


def _table(done: dict[str, Any], kinds: dict[str, Any], how: str) -> list[str]:
    lines = [f"| {STAMPS[how]} | {' | '.join(LENGTHS)} |", "|---" * (len(LENGTHS) + 1) + "|"]
    lines += [
        f"| {kind} | {' | '.join(_cell(done[f'{kind}, {how}, {length}']) for length in LENGTHS)} |" for kind in kinds
    ]
    return lines


def main() -> None:
    """Run the study and write its page."""
    done = run("interleaved", cells(), settings=f"{RECORDS_OF_A_CELL} {CLEAN} {NULL} {list(LENGTHS)}")
    clean: Counter[str] = Counter()
    for kind in KINDS:
        clean.update(done[f"clean, {kind}"])
    nulls: Counter[str] = Counter()
    for n in (500, 15_000):
        nulls.update(done[f"null, {n} rows"])
    measured = real(Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data")))
    lines = [_HEAD, *_table(done, SEVERAL, "even"), "", *_table(done, SEVERAL, "equal pairs")]
    lines += [_SINGLE, *_table(done, SINGLE, "even"), "", *_table(done, SINGLE, "equal pairs")]
    wrong = clean.total() - clean["none"]
    wrongly = f": {', '.join(measured['asked'])}" if measured["asked"] else ""
    lines += [
        "\n## False alarms\n",
        f"- {wrong} of {clean.total()} simulated logs of whole numbers of one sensor (studies/integer_logs.py: pulses,",
        "  counts, increments and rounded rates, some with lines, vibration and filters) are asked about.",
        f"- {len(measured['asked'])} of {measured['windows']} windows of {WINDOW} rows of {measured['records']} real records"
        f" at rest and moving{wrongly}.",
        f"- Slow noise of two independent sensors is called common in {nulls['in common']} of {nulls.total()} pairs of 10 s",
        "  to 5 min, six axes each.",
        _LIMITS.format(*(done[f"equal means, {kind}"] for kind in ("clean", "two units of a model", "zeroed"))),
    ]
    Path("docs/study/interleaved.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = f"""# Rows of several sensors in turn

Made by `make study` (studies/interleaved.py). A table may have the rows of several sensors in turn, without a column that
tells them. Each reading as one sensor gives a wrong rate and a wrong random walk. The rows show several sensors by

- their means: every second, third or fourth row has another mean, the same in all parts of the log, on two axes or more;
- their scatter: every second row has 1.3 times the scatter of the others;
- time stamps that come in groups of two, three or four.

A line locked to half the sampling rate, the two phases of a converter, and samples that are sent together make such rows of
one sensor too. The slow noise decides if there is any: of two series with independent noise of one spectrum, the sum and the
difference have the same expected power at each frequency, so that the share of the sum is uniform between 0 and 1, whatever
the spectrum. The wander of one sensor, its filter and its motion are in the sum only. If the mean share up to a frequency
exceeds 1/2 by 4.5 standard errors and 0.15, the rows are of one sensor and are read. If the slow noise is independent,
they are
of several sensors. Otherwise the log may be either, and `--interleaved` is asked for (exit code 2).

Sensors of this page (studies/turns.py) have white noise, a flicker floor that begins at 3 to 300 s, a random walk, and
biases of 3 to 60 times the noise of a sample; they are not those of the tests. Each cell: questions that name several
sensors alone + questions that name both readings, of {RECORDS_OF_A_CELL} logs, half of them with three axes, half with six.
The others are read as one sensor.

## Several sensors
"""

_SINGLE = """
## One sensor

Here 0 + 0 is best.
"""

_LIMITS = """
## What cannot be distinguished

- Two sensors of equal bias and equal noise with even stamps, or none: their rows are those of one sensor at twice the
  rate. They are read as such, and the random walk is too small by √2. Only a column that names the sensor helps.
- Samples of one sensor that are sent in groups of two to four, and have white noise alone: asked about too.
  A rule that rows of equal means are of one sensor would read {} of 100 such logs, and {} of 100 of two units of a model;
  but also {} of 100 of two units whose means were set to zero at the start, as firmware does with gyros.
- A line locked to half the rate for the whole log, beside white noise alone. It is asked about; the answer is
  `--interleaved 1`.
- Two sensors of which one has two or three rows for each row of the other, if their means differ by less than twice
  the noise.
- Two sensors one after the other whose stamps go on: a sensor whose settings change has such rows too. They are read as
  one; a finding names the time at which the noise changes, and the axes are `partial` at best.
- Motion and vibration that two sensors on one board share looks like the slow noise of one. Logs with stamps in groups
  and different means are asked about whatever the slow noise is.
- Fewer than 512 rows."""


if __name__ == "__main__":
    main()
