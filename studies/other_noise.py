"""Analysis of noise without one of the five slopes: coverage, false terms, curves; and power for ideal noise.

``python -m studies.other_noise`` writes docs/study/other-noise.md.
"""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from sigmatau.model.numbers import adev_interval
from studies.other_kinds import KINDS, RATE, SAMPLES, TAU0
from studies.runner import run

RECORDS, A_CELL = 20, 5
"""Number of records of three axes per kind, and per cell."""

COVERED, POOLED, FALSE, OFF = 0.95, 0.93, 0.05, 0.01
"""Limits: coverage of a kind and of all, false terms without an alternative, curves of good records off by three bands."""

TIMES = 24
BANDS = 3.0
LETTERS = {"N": "random_walk", "B": "bias_instability", "K": "rate_random_walk", "Q": "quantization"}

Row = dict[str, Any]


def _axis(analysis: st.Analysis, channel: str, kind: str) -> Row:
    fit = analysis.fits[channel]
    row: Row = {"trust": fit.trust, "named": bool(fit.second), "terms": {}}
    for letter, name in LETTERS.items():
        if (term := fit.get(name)) is not None:
            row["terms"][letter] = (term.observed, term.value, term.low, term.high, term.upper_limit)
    parts = {"line": fit.sinusoid, "process": fit.gauss_markov, "resonance": fit.resonance}
    row["parts"] = [name for name, is_present in parts.items() if is_present]
    row["parts"] += [fit.response.shape] if fit.response is not None else []
    row["parts"] += ["warm-up"] if fit.warm_up is not None else []
    if fit.trust == "good" and analysis.model is not None and channel in analysis.model.channels:
        model = analysis.model.channels[channel]
        m = np.unique(np.round(np.geomspace(1, SAMPLES * TAU0 / 4, TIMES) * RATE)).astype(int)
        m = m[m * TAU0 >= (model.tau_min or 0.0)]
        true = np.sqrt(KINDS[kind].avar(m.astype(float), lines=bool(model.sinusoid)))
        middle = np.sqrt(model.avar(m=m, tau0=TAU0))
        low, high = adev_interval(model, m=m, tau0=TAU0)
        off = np.log(true / middle)
        band = np.maximum(np.where(off > 0, np.log(high / middle), np.log(middle / low)), 1e-6)
        row["bands"] = float(np.max(np.abs(off) / band))
    return row


def cell(seed: int, kind: str) -> list[Row]:
    """Results for the axes of the records of a cell."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(A_CELL):
        samples = np.stack([KINDS[kind].make(rng) for _ in range(3)], axis=1)
        record = st.Record.from_arrays(rate=RATE, gyro=samples, unit={"gyro": "rad/s"})
        analysis = st.analyze(record, threads=1)
        rows += [_axis(analysis, channel, kind) for channel in record.channels if channel in analysis.fits]
    return rows


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Four cells per kind."""
    return {f"other noise, {kind}, {k}": (cell, (kind,)) for kind in KINDS for k in range(RECORDS // A_CELL)}


def _covers(term: tuple[Any, ...], true: float) -> bool | None:
    """Whether an interval or a limit contains the truth; None if the term is unknown."""
    observed, _, low, high, limit = term
    if not observed:
        return None if limit is None else true <= limit
    return None if low is None else low <= true <= high


def _covered(rows: list[Row], letter: str, true: float) -> list[bool]:
    covers_ = (_covers(row["terms"][letter], true) for row in rows if letter in row["terms"])
    return [covers for covers in covers_ if covers is not None]


def _lower_gate(limit: float, count: int) -> float:
    """A limit minus three standard errors of a share of `count`."""
    return limit - 3 * math.sqrt(limit * (1 - limit) / max(count, 1))


def _row(kind: str, rows: list[Row]) -> tuple[str, list[str], list[bool]]:
    """Row of the table, failed gates, and whether each interval of N, B and K contains the truth."""
    terms, fails, every = KINDS[kind].terms, [], []
    shares = []
    for letter in ("N", "B", "K", "Q"):
        covered = _covered(rows, letter, terms.get(letter, 0.0))
        if letter == "B" and kind.startswith("f^"):
            covered = []  # B has no single value
        shares.append(f"{100 * np.mean(covered):.0f}" if covered else "–")
        if letter in "NBK" and covered:
            every += covered
            if np.mean(covered) < _lower_gate(COVERED, len(covered)):
                fails.append(f"{letter} covered in {100 * np.mean(covered):.0f} %")
    absent = [letter for letter in "BKQ" if not terms.get(letter) and not (letter == "B" and kind.startswith("f^"))]
    false = []
    for letter in absent:
        bare = [row["terms"].get(letter, (False,))[0] and not row["named"] for row in rows]
        if any(bare):
            false.append(f"{letter} {100 * np.mean(bare):.0f}")
        if np.mean(bare) > FALSE + 3 * math.sqrt(FALSE * (1 - FALSE) / len(bare)):
            fails.append(f"{letter} falsely in {100 * np.mean(bare):.0f} %")
    observed_terms = []
    for letter in (letter for letter in "BK" if terms.get(letter)):
        widths = [
            50 * (high - low) / value
            for observed, value, low, high, _ in (row["terms"][letter] for row in rows)
            if observed and low is not None
        ]
        observed_terms.append(
            f"{letter} {100 * len(widths) / len(rows):.0f} (±{np.median(widths) if widths else math.nan:.0f} %)"
        )
    trust = Counter(row["trust"] for row in rows)
    bands = [row["bands"] for row in rows if "bands" in row]
    off = sum(x > BANDS for x in bands)
    if off > OFF * len(bands) + 3 * math.sqrt(OFF * (1 - OFF) * len(bands)):
        fails.append(f"{off} of {len(bands)} curves off")
    parts = Counter(part for row in rows for part in row["parts"])
    listed = ", ".join(f"{part} {100 * count / len(rows):.0f}" for part, count in parts.most_common(3))
    grades = "/".join(f"{100 * trust[grade] / len(rows):.0f}" for grade in ("good", "partial", "poor"))
    named = 100 * np.mean([row["named"] for row in rows])
    text = (
        f"| {kind} | {grades} | {' | '.join(shares)} | {', '.join(observed_terms) or '–'} | {', '.join(false) or '–'} "
        f"| {named:.0f} | {listed or '–'} | {sum(x > 1 for x in bands)}, {off} of {len(bands)} |"
    )
    return text, fails, every


def main() -> None:
    """Run the study and write docs/study/other-noise.md."""
    every = cells()
    results = run("other_noise", every, settings=repr((A_CELL, RATE, SAMPLES)))
    lines, failing, pooled = [], [], []
    for kind in KINDS:
        rows = [row for k in range(RECORDS // A_CELL) for row in results[f"other noise, {kind}, {k}"]]
        text, fails, covered = _row(kind, rows)
        lines.append(text)
        pooled += covered
        failing += [f"- {kind}: {'; '.join(fails)}." for _ in (1,) if fails]
    share = 100 * float(np.mean(pooled))
    head = _HEAD.format(
        kinds=len(KINDS), axes=3 * RECORDS, covered=100 * COVERED, pooled=share, least=100 * POOLED, false=100 * FALSE
    )
    verdict = "holds" if share / 100 >= _lower_gate(POOLED, len(pooled)) else "does NOT hold"
    tail = [f"\nThe limit of {100 * POOLED:g} % for all kinds together {verdict}.\n"]
    tail += ["Kinds that do not hold a limit:\n", *failing, ""] if failing else ["Every kind holds its limits.\n"]
    page = "\n".join([head, *lines, *tail, _LIMITS])
    Path("docs/study/other-noise.md").write_text(page, encoding="utf-8")


_HEAD = """# Noise that is not one of five slopes

Made by `make study` (studies/other_noise.py): {kinds} kinds of sensor, {axes} axes of one hour at 50 Hz of each, analysed
with `sigmatau.analyze` as a user does. The records are made from the definitions of the noise (studies/other_kinds.py), not
from the models that are fitted. N = 10⁻⁴, B = 5·10⁻⁵, K = 5·10⁻⁶ in rad/s. Seeds are derived from the names of the cells.

The limits, each ± 3 standard errors: intervals and limits of N, B and K contain the truth in {covered:g} % of a kind, in
{least:g} % of all ({pooled:.1f} % here); a term that is absent is observed, and no other model named, in {false:g} %; the
curve of a `good` record is off by more than three times its band in 1 %.

- **trust**: share of good/partial/poor, in %.
- **N, B, K, Q**: share of intervals and limits that contain the truth, in %.
- **observed**: how often a term that is there is observed, in %, and the median half width of its interval.
- **false**: terms that are absent and observed without another model, in %. **named**: records with another model, in %.
- **curve**: good records whose Allan deviation leaves its simultaneous 95 % band, and three times the band, from 1 s to a
  quarter of the record.

| kind | trust | N | B | K | Q | observed | false | named | parts | curve |
|---|---|---|---|---|---|---|---|---|---|---|"""


_LIMITS = """
## What a single record does not show

- **Flicker noise f^-0.9**: its curve is off by 1 to 5 % at 5 to 15 s, where it crosses the white noise. The fit has f^-1;
  the interval of the curve contains other exponents only if they explain the record as well and are named.
- **Flicker noise f^-1.5**: B has no single value, because the curve rises with τ. Its interval contains the value at
  0.01 Hz in 73 % of 60 records of an independent simulator.
- **A record interpolated from 99.7 to 50 Hz without an anti-alias filter**: the folded noise is white, and N is 15 %
  larger than that of the sensor. The record cannot show this; logs at two rates do:
  [`sigmatau bandwidth`](../how-to/bandwidth.md).
"""


if __name__ == "__main__":
    main()
