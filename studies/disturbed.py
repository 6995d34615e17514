"""Disturbed records: what quiet real records show beside their noise, and what a parked vehicle makes of the random walk.

The real records are not ours to ship: SIGMATAU_FIELD_DATA names the folder that holds them; those that are absent are
skipped.
``python -m studies.disturbed`` writes docs/study/disturbed.md.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau import Record
from sigmatau.fitting.disturbance import HIDDEN, MAX_HIDING_SHARE, MAX_SHARE, vibration_share
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.selection.window import choose
from studies import parked
from studies.real_records import RECORDS, WINDOWS
from studies.runner import run

LENGTHS, PARTS, LONGEST = (60.0, 200.0, 600.0, 4000.0), 2, 4000.0
"""Lengths of the parts of real records, and how many of each; no more of a record than the longest is used. [s]"""
QUIET, PARKED = 60, 10
MOST_DISTURBED = 0.005


def _row(fitted: NoiseFit) -> dict[str, Any]:
    walk = fitted.terms["random_walk"]
    return {
        "channel": fitted.channel,
        "lines": len(fitted.sinusoid),
        "resonances": len(fitted.resonance),
        "processes": len(fitted.gauss_markov),
        "share": vibration_share(fitted),
        "verdict": fitted.verdict,
        "trust": fitted.trust,
        "walk": [walk.value, walk.low, walk.high, walk.upper_limit],
    }


def _rows(record: Record) -> list[dict[str, Any]]:
    """Rows of all axes of a record that is at rest."""
    return [_row(fitted) for fitted in st.analyze(record, threads=1).fits.values() if fitted.terms]


def _parts(folder: Path, name: str) -> Iterator[tuple[float, Record]]:
    """Parts of a real record, with their lengths."""
    record = st.read(folder / name, **RECORDS[name])
    start, end = 0.0, max(stream.grid.duration for stream in record.streams)
    if name in WINDOWS:
        start, end = (float(part.rstrip("s")) for part in WINDOWS[name].split(":"))
    end = min(end, start + LONGEST)
    for wanted in LENGTHS:
        length = min(wanted, end - start)
        count = int((end - start) // length)
        for k in np.unique(np.linspace(0, count - 1, min(count, PARTS)).astype(int)).tolist():
            yield length, choose(record, f"{start + k * length}s:{start + (k + 1) * length}s")[0]
        if length < wanted:
            return


def of_real(_: int, folder: str, name: str) -> list[dict[str, Any]]:
    """Fits of the parts of a real record."""
    return [row | {"length": length} for length, part in _parts(Path(folder), name) for row in _rows(part)]


def of_simulated(seed: int, name: str, kind: str, records: int) -> list[dict[str, Any]]:
    """Fits of gyros of a grade, parked or on a bench."""
    rng = np.random.default_rng(seed)
    seeds = [int(rng.integers(1 << 62)) for _ in range(records)]
    made = (parked.bench(one, name) if kind == "quiet" else parked.parked(one, name, kind) for one in seeds)
    return [row for record in made for row in _rows(record)]


def held(row: dict[str, Any], truth: float) -> bool:
    """Whether the interval, or the interval from 0 to the limit, has the truth."""
    value, low, high, limit = row["walk"]
    if value is None:
        return limit is None or truth <= limit
    return low is None or bool(low <= truth <= high)


def main() -> None:
    """Run the study and write docs/study/disturbed.md."""
    folder = Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data"))
    real = {name: (of_real, (str(folder), name)) for name in RECORDS if (folder / name).exists()}
    simulated = {
        f"{kind} {name}": (of_simulated, (name, kind, QUIET if kind == "quiet" else PARKED))
        for kind in ("quiet", *parked.KINDS)
        for name in parked.GRADES
    }
    found = run("disturbed", {**real, **simulated}, settings=repr((LENGTHS, PARTS, QUIET, PARKED)))
    lines = [_HEAD]
    for name in real:
        for length in dict.fromkeys(row["length"] for row in found[name]):
            rows = [row for row in found[name] if row["length"] == length]
            lines.append(f"| {Path(name).name} | {length:.0f} | {_counts(rows)} |")
    lines += ["", _SIMULATED]
    failures = []
    for kind in ("quiet", *parked.KINDS):
        for name, grade in parked.GRADES.items():
            rows, truth = found[f"{kind} {name}"], parked.truth_of(grade)
            bad = Counter(row["trust"] for row in rows if not held(row, truth))
            disturbed = [row for row in rows if row["verdict"] == "disturbed"]
            limits = Counter(held(row, truth) for row in disturbed)
            lines.append(
                f"| {kind} | {name} | {len(rows)} | {len(disturbed)} | {limits[False]} | {bad['partial']} | {bad['good']} |"
            )
    every = [row for name in real for row in found[name]]
    quiet = [row for name in parked.GRADES for row in found[f"quiet {name}"]]
    for what, rows in (("real", every), ("simulated", quiet)):
        share = float(np.mean([row["verdict"] == "disturbed" for row in rows])) if rows else 0.0
        lines += ["", f"Disturbed of {len(rows)} {what} quiet axes: {100 * share:.2g} %."]
        if share > MOST_DISTURBED + 3 * math.sqrt(MOST_DISTURBED / max(len(rows), 1)):
            failures.append(f"- {100 * share:.2g} % of the {what} quiet axes are disturbed")
    lines += ["", _TAIL, "", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/disturbed.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _counts(rows: list[dict[str, Any]]) -> str:
    """Median and largest number of lines, resonances and processes, and share of the power."""
    texts = []
    for part in ("lines", "resonances", "processes"):
        numbers = sorted(row[part] for row in rows)
        texts.append(f"{numbers[len(numbers) // 2]}, {numbers[-1]}")
    shares = sorted(row["share"] for row in rows)
    disturbed = sum(row["verdict"] == "disturbed" for row in rows)
    return " | ".join([str(len(rows)), *texts, f"{shares[len(shares) // 2]:.2f}, {shares[-1]:.2f}", str(disturbed)])


_HEAD = f"""# Disturbed records

Made by `make study` (studies/disturbed.py). A vehicle with people in it, an idle engine or the ventilation of a building
shakes a sensor that is at rest. A good gyro shows this as dozens of lines and resonances, and its random walk is what the
model leaves between them. The verdict `disturbed` then gives the random walk as [0, limit]; the limit is that of the Allan
variances, to which every vibration only adds.

The verdict needs one of two conditions:

- Lines and narrow resonances have more than {MAX_SHARE:g} of the power, beside random walk and quantization noise. At most
  three lines beside a white level that is steady are exempt: a steady line hides nothing.
- They have more than {MAX_HIDING_SHARE:g} of it, are more than three lines, and the random walk of the model is below
  {HIDDEN:g} times the limit of the curve: it shows at no averaging time.

## Quiet real records

Parts of real records at rest, all axes. Median and largest number of lines, resonances and Gauss-Markov processes, and of
the share of the power. The number of lines is not a limit: ch104.mat has 100 lines, the most that are kept, in 53 minutes,
and is a quiet record.

| record | length [s] | axes | lines | resonances | processes | share | disturbed |
|---|---|---|---|---|---|---|---|"""

_SIMULATED = """## Simulated gyros

Gyros on a bench, with up to seven weak lines and some behind a filter, and in a parked vehicle or a building: motion of 2
µrad/s to 2 mrad/s whatever the grade. Records of 1 to 30 min at 50 to 200 Hz. "Limit wrong": disturbed, and the random walk
is above its limit. "Partial" and "good": the interval does not contain the random walk, by trust; at 95 % one in twenty of
quiet records is expected.

| kind | grade | axes | disturbed | limit wrong | partial | good |
|---|---|---|---|---|---|---|"""

_TAIL = """The coarse ring laser gyro counts pulses of 0.8 arcsec, of which an axis that hardly turns has few: its rounding
is not white, and the interval of the random walk is often too high, on a bench as well."""

if __name__ == "__main__":
    main()
