"""Comparison of the likelihood with the exact likelihood of all samples, for records of 512 to 4096 samples.

``python -m studies.oracle`` writes docs/study/oracle.md.
"""

from __future__ import annotations

import datetime as dt
import math
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau._native.likelihood import summarize
from studies.exact import TERMS, Exact
from studies.runner import run
from studies.samples import simulated

RECORDS = {512: 60, 1024: 40, 2048: 16, 4096: 6}
MIXTURES = {
    "N": {"random_walk": 1.0},
    "Q N": {"quantization": 1.0, "random_walk": 0.3},
    "N B": {"random_walk": 1.0, "bias_instability": 0.5},
    "N K": {"random_walk": 1.0, "rate_random_walk": 0.1},
    "Q K": {"quantization": 1.0, "rate_random_walk": 0.02},
    "N B K": {"random_walk": 1.0, "bias_instability": 0.5, "rate_random_walk": 0.05},
}
LETTERS = {"quantization": "Q", "random_walk": "N", "bias_instability": "B", "rate_random_walk": "K"}
TENTH = 0.1  # standard errors

_exact = cache(Exact)


def compared(seed: int, name: str, n: int) -> list[list[float] | None]:
    """Differences from the exact estimates, in standard errors; None for a record with further parts in the model."""
    exact, mixture = _exact(n, 1.0), MIXTURES[name]
    terms = tuple(term for term in TERMS if term in mixture)
    information = exact.information(terms, np.array([mixture[term] ** 2 for term in terms]))
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    rng = np.random.default_rng(seed)
    rows: list[list[float] | None] = []
    for _ in range(RECORDS[n]):
        y = simulated(n, 1.0, mixture, seed=int(rng.integers(1 << 62)))
        fitted = summarize([y], samples=n, tau0=1.0).fit()
        model = {term: value**2 for term, value in fitted.model if term in TERMS}
        if model.keys() != set(terms) or fitted.gauss_markov or fitted.resonance or fitted.response:
            rows.append(None)
            continue
        theta = np.array([model[term] for term in terms])
        rows.append(((theta - exact.fit(y, terms, theta, information).theta) / errors).tolist())
    return rows


def main() -> None:
    """Run the study and write docs/study/oracle.md."""
    cells: dict[str, Any] = {f"{name} {n}": (compared, (name, n)) for n in RECORDS for name in MIXTURES}
    results = run("oracle", cells, settings=repr((RECORDS, MIXTURES)))
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout
    lines = [_HEAD.format(date=dt.datetime.now(tz=dt.UTC).date(), commit=commit.strip() or "unknown")]
    failed = []
    for name, mixture in MIXTURES.items():
        for n in RECORDS:
            rows = [row for row in results[f"{name} {n}"] if row is not None]
            if not rows:
                lines.append(f"| {name} | {n} | 0 | |")
                continue
            rms = np.sqrt(np.mean(np.square(rows), axis=0))
            terms = [LETTERS[term] for term in TERMS if term in mixture]
            shown = ", ".join(f"{letter} {value:.3f}" for letter, value in zip(terms, rms, strict=True))
            lines.append(f"| {name} | {n} | {len(rows)} of {RECORDS[n]} | {shown} |")
            if rms.max() > TENTH * (1 + 3 / math.sqrt(2 * len(rows))):
                failed.append(f"- {name}, {n} samples: {rms.max():.3f}")
    lines += ["", "## Gates", "", *(failed or ["All gates are met."])]
    Path("docs/study/oracle.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """\
# The likelihood against an exact one

Made by `make study` (studies/oracle.py); {date}, commit {commit}. The exact likelihood is that of all
samples, by their dense covariance (studies/exact.py), for the terms that the record has. Difference of the estimates of
the squared coefficients, root mean square over the records, in standard errors of the exact estimate; of records in which
exactly the true terms are found. Gate: a tenth, with 3 standard errors of the simulation.

| mixture | samples | records | difference |
|---|---|---|---|"""

if __name__ == "__main__":
    main()
