"""Does the fit stay unbiased, and do its intervals hold, where samples are missing."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from studies.mixtures import Mixture
from studies.runner import run

Floats = NDArray[np.float64]

RECORDS = 320
PARTS = 8
_N, _RATE = 2**15, 100.0
_LOSS, _OUTAGE = 0.05, 60.0

# Terms well above what such a record can just show: the squared coefficient of one that is sometimes not seen has no mean.
MIXTURES: dict[str, Mixture] = {
    "N B": Mixture(_N, _RATE, {"random_walk": 0.05, "bias_instability": 0.08}),
    "N B K": Mixture(_N, _RATE, {"random_walk": 0.05, "bias_instability": 0.15, "rate_random_walk": 0.1}),
    "Q N B": Mixture(_N, _RATE, {"quantization": 0.002, "random_walk": 0.05, "bias_instability": 0.1}),
    "N K": Mixture(_N, _RATE, {"random_walk": 0.05, "rate_random_walk": 0.05}),
}
LOSSES = ("none", "5 % at random", "60 s outage", "both")


def lost(rate: Floats, kind: str, rng: np.random.Generator) -> Floats:
    """A record with samples taken away."""
    y = rate.copy()
    if kind in ("5 % at random", "both"):
        y[rng.random(len(y)) < _LOSS] = np.nan
    if kind in ("60 s outage", "both"):
        length = round(_OUTAGE * _RATE)
        start = int(rng.integers(0, len(y) - length))
        y[start : start + length] = np.nan
    return y


def fits(seed: int, name: str, kind: str, records: int) -> list[dict[str, Any]]:
    """What a fit states of each record: verdict, and of each term whether it is there, free value, low, high, limit.

    The mean over records is that of the least-squares values of all terms that may be there, found or not.
    """
    mixture = MIXTURES[name]
    model = st.NoiseModel(channels={mixture.channel: mixture.truth})
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(records):
        record = st.simulate(model, duration=mixture.n / mixture.rate, rate=mixture.rate, rng=rng)
        y = lost(record.streams[0].column(mixture.channel), kind, rng)
        curve = st.allan(st.Record.from_arrays(rate=mixture.rate, gyro_x=y), threads=1)["gyro_x"]
        # The terms that are there: what else may be there would be part of them now and then, with or without gaps.
        fitted, given = st.fit(curve), st.fit(curve, terms=mixture.truth)
        results.append(
            {
                "verdict": fitted.verdict,
                "moved": fitted.tau_min is None or fitted.tau_min > 1.5 * curve.tau0,
                "given": {term: given.model.get(term, 0.0) for term in mixture.truth},
                "adequate": given.verdict == "adequate",
                "terms": {term: [t.observed, t.value, t.low, t.high, t.upper_limit] for term, t in fitted.items()},
            }
        )
    return results


def bias(records: list[dict[str, Any]], term: str, value: float) -> tuple[float, float]:
    """Mean of the squared coefficient over the true one, less 1, and its standard error."""
    ratios = np.array([(r["given"][term] / value) ** 2 for r in records if r["adequate"]])
    return float(ratios.mean() - 1), float(ratios.std(ddof=1) / math.sqrt(len(ratios)))


def covered(records: list[dict[str, Any]], term: str, value: float) -> float:
    """Share of the adequate fits whose interval, or limit, holds the true coefficient."""
    hold = []
    for r in records:
        if r["verdict"] == "adequate":
            observed, _, low, high, limit = r["terms"][term]
            hold.append(low <= value <= high if observed else limit is None or value <= limit)
    return float(np.mean(hold))


def main() -> None:
    """Run the study and write docs/study/gaps.md."""
    cells = {
        f"{name}, {kind} {k}": (fits, (name, kind, RECORDS // PARTS))
        for k in range(PARTS)
        for name in MIXTURES
        for kind in LOSSES
    }
    results = run("gaps", cells, settings=repr((RECORDS, MIXTURES, _LOSS, _OUTAGE)))
    Path("docs/study/gaps.md").write_text(page(results), encoding="utf-8")


def page(results: dict[str, Any]) -> str:
    """The page, from the parts of the cells that are there."""
    lines, failures = [_HEAD.format(n=_N)], []
    refused: list[str] = [_VERDICTS]
    for name, mixture in MIXTURES.items():
        shares = {}
        for kind in LOSSES:
            parts = (results.get(f"{name}, {kind} {k}", []) for k in range(PARTS))
            records = [record for part in parts for record in part]
            bad = float(np.mean([r["verdict"] != "adequate" for r in records]))
            moved = float(np.mean([r["moved"] for r in records]))
            shares[kind] = (bad, moved)
            for term, value in mixture.truth.items():
                off, error = bias(records, term, value)
                share = covered(records, term, value)
                found = f"{100 * off:+.1f} ± {100 * error:.1f} | {100 * share:.1f}"
                lines.append(f"| {name} | {kind} | {len(records)} | {term} | {found} |")
                if abs(off) > 3 * error:
                    failures.append(f"- {name}, {kind}: {term}² is {100 * off:+.1f} ± {100 * error:.1f} % off")
                beyond = 3 * math.sqrt(0.05 * 0.95 / len(records))
                if not 0.92 - beyond <= share <= 0.98 + beyond:
                    failures.append(f"- {name}, {kind}: {term} covered in {100 * share:.1f} % of the records")
        for kind, (bad, moved) in shares.items():
            refused.append(f"| {name} | {kind} | {100 * bad:.1f} | {100 * moved:.1f} |")
            for what, share, without in (
                ("refused", bad, shares["none"][0]),
                ("τ_min moved", moved, shares["none"][1]),
            ):
                mean = 0.5 * (share + without)
                if share - without > 3 * math.sqrt(max(2 * mean * (1 - mean), 0.02) / len(records)):
                    failures.append(
                        f"- {name}, {kind}: {what} in {100 * share:.1f} % of the records, {100 * without:.1f} % without gaps"
                    )
    lines += [*refused, "", "## Gates", "", *(failures or ["All gates are met."])]
    return "\n".join(lines) + "\n"


_HEAD = """# Records with missing samples

Made by `make study` (studies/gaps.py): simulated records of {n} samples at 100 Hz; the seeds are derived from the names
of the cells. The removed samples are: none; each sample with a probability of 5 %; an outage of 60 s at a random time; or
both. Missing samples are not filled in. Clusters that are at least half full are used, and the fit uses the expected
effect of the missing samples on each term (`sigmatau.estimators.gaps`). Letters are those of IEEE 952: Q quantization, N
random walk, B bias instability, K rate random walk. Cells with fewer than 320 records were stopped early.

"Bias" is the relative error of the mean squared coefficient, with its standard error, for fits with known terms.
"Covered" is the share of records in which the 95 % interval (or the limit, if the term is not observed) contains the true
value, for fits that choose the terms. Gates: bias within three standard errors; coverage of 92 to 98 %, plus or minus
three standard errors.

| record of | missing | records | term | bias of the square [%] | covered [%] |
|---|---|---|---|---|---|"""

_VERDICTS = """
## Goodness of fit with the right model

Share of records without an adequate model, and with the shortest averaging times left out, for fits that choose the terms
[%]. Gate: not larger than without missing samples by more than three standard errors.

| record of | missing | refused | τ_min moved |
|---|---|---|---|"""

if __name__ == "__main__":
    main()
