"""Does a record show a term as often as `plan` states? Records with the planned value, through the whole analysis."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sigmatau import NoiseModel, analyze, plan, simulate
from sigmatau.noise.terms import TERMS
from studies.runner import run

PAGE = Path(__file__).resolve().parent.parent / "docs" / "study" / "planning.md"

_RATE = 10.0  # [Hz]
_TRIALS = 100
_AT_ONCE = 25
_LENGTHS = (600.0, 3600.0)  # of the records, the second with white noise alone [s]
_TOLERANCE = 0.15
"""Largest error of a stated probability: a value 15 % larger changes the probability by as much."""

_N = 1e-4  # angle random walk [rad/√s]
# The other noise of the record: white noise alone; with quantization noise; with a rate random walk and with a
# bias instability that are seen.
BACKGROUNDS = {
    "N": {"random_walk": _N},
    "N, Q": {"random_walk": _N, "quantization": 1.5e-5},
    "N, K": {"random_walk": _N, "rate_random_walk": 1e-5},
    "N, B": {"random_walk": _N, "bias_instability": 1.2e-4},
}
CASES = tuple(
    (term, background, seconds)
    for term in ("quantization", "bias_instability", "rate_random_walk", "rate_ramp")
    for background in BACKGROUNDS
    for seconds in _LENGTHS
    if term not in BACKGROUNDS[background] and (background == "N" or seconds == _LENGTHS[0])
)


def planned(term: str, background: str, seconds: float) -> tuple[float, float]:
    """The values that a record shows with probabilities of 50 % and 90 %, as `plan` states them."""
    result = plan(
        BACKGROUNDS[background],
        term,
        channel="gyro_x",
        quantity="angular_rate",
        rate_unit="rad/s",
        rate=_RATE,
        duration=seconds,
    )
    if result.half is None or result.most is None:
        raise RuntimeError(f"no value of {term} is shown within {seconds} s")
    return result.half, result.most


def cell(seed: int, term: str, background: str, seconds: float, value: float) -> int:
    """Number of records that show the term."""
    rng = np.random.default_rng(seed)
    model = NoiseModel(channels={"gyro_x": BACKGROUNDS[background] | {term: value}})
    count = 0
    for _ in range(_AT_ONCE):
        record = simulate(model, duration=seconds, rate=_RATE, rng=rng)
        fitted = analyze(record, threads=1, at_rest=True).fits["gyro_x"].get(term)
        count += fitted is not None and fitted.value is not None
    return count


def gate(probability: float) -> float:
    """The tolerance and three standard errors of a share."""
    return _TOLERANCE + 3 * math.sqrt(probability * (1 - probability) / _TRIALS)


def main() -> None:
    """Run the study and write its page."""
    values = {case: planned(*case) for case in CASES}
    cells = {
        f"planning {term} {background} {seconds:g} {k} {part}": (cell, (term, background, seconds, values[case][k]))
        for case in CASES
        for term, background, seconds in [case]
        for k in range(2)
        for part in range(_TRIALS // _AT_ONCE)
    }
    done = run("planning", cells, settings=f"{BACKGROUNDS} {values} {_RATE} {_AT_ONCE}")
    rows, missed = [], []
    for term, background, seconds in CASES:
        shares = [
            sum(done[f"planning {term} {background} {seconds:g} {k} {part}"] for part in range(_TRIALS // _AT_ONCE))
            / _TRIALS
            for k in range(2)
        ]
        ok = all(abs(share - p) <= gate(p) for share, p in zip(shares, (0.5, 0.9), strict=True))
        missed += [] if ok else [f"{TERMS[term].label('angular_rate')}, {background}, {seconds:g} s"]
        rows.append(
            f"| {TERMS[term].label('angular_rate')} | {background} | {seconds:g} | {100 * shares[0]:.0f}"
            f" | {100 * shares[1]:.0f} | {'yes' if ok else '**no**'} |"
        )
    PAGE.write_text(_text(rows, missed), encoding="utf-8")


def _text(rows: list[str], missed: list[str]) -> str:
    cases = "; ".join(
        f"{name}: {', '.join(f'{k} {v:g}' for k, v in noise.items())}" for name, noise in BACKGROUNDS.items()
    )
    verdict = "All rows meet it." if not missed else f"Rows that do not: {'; '.join(missed)}."
    return f"""# Does a record show a term as often as plan states?

Made by `make study` (studies/planning.py). `sigmatau plan` states the value of a term that a record shows with a
probability of 50 % and of 90 %. {_TRIALS} records with each of these values, {_RATE:g} Hz, are analysed with the default
options. The table has the share of records in which the term was observed.

Coefficients of the other noise in SI: {cases}.

| term | other noise | length, s | at the value of 50 % | at the value of 90 % | gate |
|---|---|---|---|---|---|
{chr(10).join(rows)}

A term is shown if it is significant and no other explanation of the record is as good. The first part is the test on the
Allan deviation of the fit on a curve. The second is needed for two terms: the default fit also considers a Gauss–Markov
process in place of a bias instability, and a rate random walk in place of a ramp. The rise of the deviance with the other
explanation, 2.6 of which a process gains by chance, comes from the densities (sigmatau.fitting.alternatives). By the
significance alone `plan` would promise 2.5 times smaller bias instabilities and three times smaller ramps.

Gate: {100 * _TOLERANCE:.0f} percentage points and three standard errors, ±{100 * gate(0.5):.0f} at 50 % and
±{100 * gate(0.9):.0f} at 90 %. {verdict}
"""


if __name__ == "__main__":
    main()
