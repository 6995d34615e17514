"""Disturbed records: disturbances in quiet real records, and the effect of a parked vehicle on the random walk.

The real records are not distributed with the package: SIGMATAU_FIELD_DATA is their folder; absent records are skipped.
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
from sigmatau.findings.reasons import CoarseCounts, CrowdedLines
from sigmatau.fitting.disturbance import HIDDEN, MAX_BURSTS, MAX_HIDING_SHARE, MAX_SHARE, vibration_share
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.selection.window import choose
from studies import parked
from studies.real_records import RECORDS, WINDOWS
from studies.runner import run

LENGTHS, PARTS, LONGEST = (60.0, 200.0, 600.0, 4000.0), 2, 4000.0
"""Lengths of the parts of real records, and numbers of each; not more of a record than the longest is used. [s]"""
QUIET, PARKED, BURSTS = 60, 40, 20
"""Numbers of axes: of a grade on a bench, of a grade and kind of disturbance, and of a kind of burst."""
_BURSTS = {"10 times in 2 %": (10.0, 0.02), "30 times in 0.5 %": (30.0, 0.005), "5 times in 10 %": (5.0, 0.1)}
MAX_DISTURBED = 0.005
LEVEL, WRONG_BY = 0.05, 1.0
"""Share of intervals that do not contain the truth; and distance of the truth from an interval, in half widths, beyond
which a number is wrong: 3.9 standard errors, once in 10,000 by chance.
"""


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
        "vibration": fitted.verdict == "disturbed"
        and not any(isinstance(reason, CoarseCounts) for reason in fitted.reasons),
        "crowded": any(isinstance(reason, CrowdedLines) for reason in fitted.reasons),
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


def fit_bursts(seed: int, size: float, share: float) -> list[dict[str, Any]]:
    """Fits of white noise of level 1 that is larger in one part of the record; it has no line."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(BURSTS):
        x = rng.standard_normal(int(rng.integers(30_000, 150_000)))
        length = round(share * len(x))
        start = int(rng.integers(0, len(x) - length))
        x[start : start + length] *= size
        fitted = st.fit_channel(st.Record.from_arrays(rate=100.0, gyro_x=1e-3 * x), "gyro_x")
        rows.append(_row(fitted) | {"truth": 1e-4 * float(x.std())})
    return rows


def fit_real(_: int, folder: str, name: str) -> list[dict[str, Any]]:
    """Fits of the parts of a real record."""
    return [row | {"length": length} for length, part in _parts(Path(folder), name) for row in _rows(part)]


def fit_simulated(seed: int, name: str, kind: str, records: int) -> list[dict[str, Any]]:
    """Fits of gyros of a grade, parked or on a bench."""
    rng = np.random.default_rng(seed)
    seeds = [int(rng.integers(1 << 62)) for _ in range(records)]
    made = (parked.bench(seed_, name) if kind == "quiet" else parked.parked(seed_, name, kind) for seed_ in seeds)
    return [row for record in made for row in _rows(record)]


def held(row: dict[str, Any], truth: float) -> bool:
    """Whether the interval, or the interval from 0 to the limit, contains the truth."""
    value, low, high, limit = row["walk"]
    if value is None:
        return limit is None or truth <= limit
    return low is None or bool(low <= truth <= high)


def distance(row: dict[str, Any], truth: float) -> float:
    """Distance of the truth from the interval, in half widths, or from a limit, relative to it; 0 inside."""
    value, low, high, limit = row["walk"]
    if held(row, truth):
        return 0.0
    if value is None:
        return float((truth - limit) / limit)
    return float((truth - high if truth > high else low - truth) / ((high - low) / 2))


def main() -> None:
    """Run the study and write docs/study/disturbed.md."""
    folder = Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data"))
    real = {name: (fit_real, (str(folder), name)) for name in RECORDS if (folder / name).exists()}
    simulated = {
        f"{kind} {name}": (fit_simulated, (name, kind, QUIET if kind == "quiet" else PARKED))
        for kind in ("quiet", *parked.KINDS)
        for name in parked.GRADES
    }
    bursts = {f"burst {name}": (fit_bursts, settings) for name, settings in _BURSTS.items()}
    settings = repr((LENGTHS, PARTS, QUIET, PARKED, BURSTS))
    results = run("disturbed", {**real, **simulated, **bursts}, settings=settings)
    lines = [_HEAD]
    for name in real:
        for length in dict.fromkeys(row["length"] for row in results[name]):
            rows = [row for row in results[name] if row["length"] == length]
            lines.append(f"| {Path(name).name} | {length:.0f} | {_counts(rows)} |")
    lines += ["", _SIMULATED]
    failures, good, missed, wrong_good = [], 0, 0, 0
    for kind in ("quiet", *parked.KINDS):
        for name, grade in parked.GRADES.items():
            rows, truth = results[f"{kind} {name}"], parked.truth_of(grade)
            valued = [row for row in rows if row["verdict"] != "disturbed"]
            wrong = Counter(row["trust"] for row in valued if distance(row, truth) > WRONG_BY)
            bad = Counter(row["trust"] for row in valued if not held(row, truth))
            limits = [row for row in rows if row["verdict"] == "disturbed"]
            above = sum(not held(row, truth) for row in limits)
            trusted = sum(row["trust"] == "good" for row in rows)
            good, missed, wrong_good = good + trusted, missed + bad["good"], wrong_good + wrong["good"]
            lines.append(
                f"| {kind} | {name} | {len(rows)} | {len(limits)} | {above} | {len(valued) - trusted}"
                f" | {bad['partial'] + bad['poor']} | {wrong['partial'] + wrong['poor']} | {trusted} | {bad['good']}"
                f" | {wrong['good']} |"
            )
    share = missed / max(good, 1)
    lines += ["", f"Of the {good} good axes, {missed} miss ({100 * share:.2g} %), {wrong_good} are wrong."]
    if share > LEVEL + 3 * math.sqrt(LEVEL * (1 - LEVEL) / max(good, 1)):
        failures.append(f"- {100 * share:.2g} % of the good axes miss the random walk")
    if wrong_good:
        failures.append(f"- {wrong_good} good axes are wrong")
    lines += ["", _BURST_HEAD]
    for name in _BURSTS:
        rows = results[f"burst {name}"]
        most_lines = max(row["lines"] for row in rows)
        widened = sum(row["crowded"] for row in rows)
        lost = [row for row in rows if not held(row, row["truth"])]
        beyond = sum(distance(row, row["truth"]) > WRONG_BY for row in lost)
        disturbed = sum(row["verdict"] == "disturbed" for row in rows)
        lines.append(f"| {name} | {len(rows)} | {most_lines} | {widened} | {disturbed} | {len(lost)} | {beyond} |")
    every = [row for name in real for row in results[name]]
    quiet = [row for name in parked.GRADES for row in results[f"quiet {name}"]]
    for source, rows in (("real", every), ("simulated", quiet)):
        share = float(np.mean([row["vibration"] for row in rows])) if rows else 0.0
        lines += ["", f"Disturbed by vibration, of {len(rows)} {source} quiet axes: {100 * share:.2g} %."]
        if share > MAX_DISTURBED + 3 * math.sqrt(MAX_DISTURBED / max(len(rows), 1)):
            failures.append(f"- {100 * share:.2g} % of the {source} quiet axes are disturbed")
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


_SHARE, _HIDING = MAX_SHARE, MAX_HIDING_SHARE
_HIDDEN, _LOUD = HIDDEN, MAX_BURSTS
_HEAD = f"""# Disturbed records

Made by `make study` (studies/disturbed.py). A vehicle with people in it, an idle engine or the ventilation of a building
shakes a sensor that is at rest. A good gyro shows this as dozens of lines and resonances, and its random walk is what the
model leaves between them. The verdict `disturbed` then gives the random walk as [0, limit]; the limit is that of the Allan
variances, to which every vibration only adds.

The verdict needs one of three conditions:

- Lines and narrow resonances have more than {_SHARE:g} of the power, beside random walk and quantization noise. At most
  three lines beside a white level that is steady are exempt: a steady line hides nothing.
- They have more than {_HIDING:g} of it, and the random walk of the model is below {_HIDDEN:g} times the limit of the
  curve, so that it shows at no averaging time; or the lower end of its interval is above that limit. No line is exempt: of
  11 parked axes with at most three lines and more than 0.85 of the power, 6 had a random walk 2.5 to 26 times too large.
- Motion comes and goes, as of people in a vehicle: at some averaging time up to 1 s the loudest differences of neighbouring
  clusters, by their 97.5 % quantile, have more than {_LOUD:g} times the power that their median lets expect of normal
  noise, relative to the same ratio of neighbouring samples. Of 198 parts of real records at rest 1.45 is the largest.

Where lines and resonances have a tenth of the power or more and the white level differs between eighths of the record, the
interval of the random walk has the levels of the eighths.

## Quiet real records

Parts of real records at rest, all axes. Median and largest number of lines, resonances and Gauss-Markov processes, and of
the share of the power. The number of lines is not a limit: ch104.mat has 100 lines, the most that are kept, in 53 minutes,
and is a quiet record.

| record | length [s] | axes | lines | resonances | processes | share | disturbed |
|---|---|---|---|---|---|---|---|"""

_SIMULATED = f"""## Simulated gyros

Gyros on a bench, with up to seven weak lines and some behind a filter, and in a parked vehicle or a building: motion of
2 µrad/s to 2 mrad/s whatever the grade. Records of 1 to 30 min at 50 to 200 Hz. The laser gyros and the fibre-optic
gyro count pulses.

At 95 %, one interval of twenty misses the random walk. A number is wrong if the random walk is further from the
interval than {WRONG_BY:g} times the half width of the interval: 3.9 standard errors, which chance makes once in 10,000.
"Above": disturbed, and the random walk is above the limit. "Other": not disturbed and not good.

| kind | grade | axes | disturbed | above | other | miss | wrong | good | miss | wrong |
|---|---|---|---|---|---|---|---|---|---|---|"""

_BURST_HEAD = """## Noise without a line that has many

White noise that is louder in one part of the record has a periodogram whose densities scatter more than those of steady
noise: lines are found, and not one is true. Left out as lines, they take white noise. Where ten lines or more take 5 %
of the band ("crowded"), the interval is joined with that of the model in which no line is left out. The truth is the
level of the whole record. `analyze` leaves most such bursts out before the fit; here they are fitted as they are.

| louder | records | most lines | crowded | disturbed | miss | wrong |
|---|---|---|---|---|---|---|"""

_TAIL = """## Pulses

The coarse ring laser gyro counts pulses of 0.8 arcsec, 30 to 60 times the noise of a sample. The rounding of such an
angle hardly changes from one sample to the next, and its density rises with the frequency like no term's: fitted sample
by sample, the interval of the random walk missed on 39 of 60 axes on a bench, and on 8 of 60 axes of the finer ring
laser gyro. Increments are now summed until the variance of the sums is half a squared step (a quarter of noise, a
quarter of rounding): the rounding of one sum then has 0.7 % of the next one's, and is quantization noise. With fewer
than 256 sums all terms are upper limits, and the verdict is `disturbed`: hidden by the rounding."""


if __name__ == "__main__":
    main()
