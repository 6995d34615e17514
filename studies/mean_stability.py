"""Coverage of the intervals of the standard deviation of 10 s and 100 s means, through the whole analysis."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sigmatau import NoiseModel, analyze, simulate
from sigmatau.noise import terms
from studies.runner import run

PAGE = Path(__file__).resolve().parent.parent / "docs" / "study" / "mean-stability.md"

_RATE = 1.0  # [Hz]
_MEANS = 512  # number of means of 10 s: a power of two, so that the expectation is a sum of Allan variances
_TRIALS = 500
_AT_ONCE = 50
_LEVEL = 0.95

# Coefficients in SI: white noise alone; with flicker noise as large as the white noise of 10 s means; also with a
# random walk that dominates their variance.
CASES = {
    "N": {"random_walk": 1e-3},
    "N, B": {"random_walk": 1e-3, "bias_instability": 3e-4},
    "N, B, K": {"random_walk": 1e-3, "bias_instability": 3e-4, "rate_random_walk": 1.5e-5},
    "N, K": {"random_walk": 1e-3, "rate_random_walk": 3e-5},
}


def expected(model: dict[str, float], average: float, means: int) -> float:
    """√E[s²] of 2^k means: s² (ddof = 1) is n/(n − 1) times half the sum of the Allan variances of 1, 2, 4 … n/2 means."""
    steps = np.array([round(average * _RATE) * (1 << j) for j in range(int(math.log2(means)))])
    avar = sum(terms.avar(name, value, m=steps, tau0=1 / _RATE) for name, value in model.items())
    return math.sqrt(means / (means - 1) * float(np.sum(avar)) / 2)


def cell(seed: int, case: str) -> dict[str, list[float]]:
    """Numbers of intervals below, containing and above the truth, and absent ones, by averaging time; and the sum of the
    logarithms of the ratio of their ends.
    """
    model, rng = CASES[case], np.random.default_rng(seed)
    counts = {"10": [0.0] * 5, "100": [0.0] * 5}
    for _ in range(_AT_ONCE):
        noise = NoiseModel(channels={"gyro_x": model})
        record = simulate(noise, duration=10 * _MEANS / _RATE, rate=_RATE, rng=rng)
        for stability in analyze(record, threads=1).mean_stability["gyro_x"]:
            name = f"{stability.average:g}"
            # The expectation of 51 means of 100 s is interpolated between those of 32 and 64, linearly in the logarithm.
            truth = (
                expected(model, stability.average, stability.means)
                if stability.means == _MEANS
                else _between(model, stability.average, stability.means)
            )
            if stability.low is None or stability.high is None:
                counts[name][3] += 1
                continue
            counts[name][0 if stability.high < truth else 2 if stability.low > truth else 1] += 1
            counts[name][4] += math.log(stability.high / stability.low)
    return counts


def _between(model: dict[str, float], average: float, means: int) -> float:
    low = 1 << int(math.log2(means))
    share = math.log(means / low) / math.log(2)
    a, b = expected(model, average, low), expected(model, average, 2 * low)
    return math.exp((1 - share) * math.log(a) + share * math.log(b))


def gate(trials: int) -> float:
    """Three standard errors of the coverage."""
    return 3 * math.sqrt(_LEVEL * (1 - _LEVEL) / trials)


def main() -> None:
    """Run the study and write its page."""
    cells = {f"mean stability {case} {k}": (cell, (case,)) for case in CASES for k in range(_TRIALS // _AT_ONCE)}
    done = run("mean-stability", cells, settings=f"{CASES} {_RATE} {_MEANS} {_TRIALS} {_AT_ONCE}")
    rows, failed = [], []
    for case in CASES:
        for name in ("10", "100"):
            total = np.sum([done[f"mean stability {case} {k}"][name] for k in range(_TRIALS // _AT_ONCE)], axis=0)
            below, within, above, without = (int(count) for count in total[:4])
            stated = below + within + above
            covered, width = within / stated, math.exp(total[4] / stated / 2) - 1
            ok = covered >= _LEVEL - gate(stated)
            failed += [] if ok else [f"{case}, {name} s"]
            rows.append(
                f"| {case} | {name} s | {100 * width:.0f} | {100 * covered:.1f} | {100 * below / stated:.1f}"
                f" | {100 * above / stated:.1f} | {without} | {'yes' if ok else '**no**'} |"
            )
    PAGE.write_text(_text(rows, failed), encoding="utf-8")


def _text(rows: list[str], failed: list[str]) -> str:
    cases = "; ".join(f"{case}: {', '.join(f'{k} {v:g}' for k, v in model.items())}" for case, model in CASES.items())
    verdict = "All cells meet it." if not failed else f"Cells that do not: {'; '.join(failed)}."
    return f"""# Coverage of the standard deviation of means

Made by `make study` (studies/mean_stability.py). {_TRIALS} simulated records a case, {10 * _MEANS} s at {_RATE:g} Hz, are
analysed. The interval of the standard deviation of 10 s and 100 s means is compared with the square root of its
expectation, which follows from the Allan variances of the model: for 2^k means, s² is n/(n − 1) times half the sum of the
Allan variances of 1, 2, 4 … n/2 means. For 51 means of 100 s it is interpolated between 32 and 64.

Coefficients in SI: {cases}.

| noise | means of | ±, % | covered, % | truth above, % | truth below, % | no interval | gate |
|---|---|---|---|---|---|---|---|
{chr(10).join(rows)}

±: half the width of the interval, as a mean of logarithms. The interval includes the ends of the intervals of flicker noise
and random walk too, because a random walk that the record does not show makes the variance less certain: so the intervals
cover more than 95 % where there is none.

Gate: covered in at least 95 % less three standard errors of {_TRIALS} records, {100 * gate(_TRIALS):.1f} %. {verdict}
"""


if __name__ == "__main__":
    main()
