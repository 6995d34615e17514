"""Share of units with the status "out", by the ratio of their noise to the limit of the datasheet."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from sigmatau import NoiseModel, allan, compare_with, fit, simulate
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.noise.terms import BIAS_LEVEL
from studies.runner import run

PAGE = Path(__file__).resolve().parent.parent / "docs" / "study" / "datasheets.md"

RATE, SAMPLES = 10.0, 1 << 15  # 55 min
AXES = 240
PARTS = 4
RATIOS = (0.5, 0.8, 0.9, 1.0, 1.1, 1.25, 1.6, 2.0)
LEVEL = 0.95
LEVELS = (0.7, 0.95, 0.99)  # levels for units exactly at the limit
_ASKED = (*((LEVEL, ratio) for ratio in RATIOS), *((level, 1.0) for level in LEVELS))
_N, _B, _K = 0.005, 0.0028, 1e-4

# Name: noise, key of the datasheet, further specifications, true value of the limited quantity, unit.
CASES: dict[str, tuple[dict[str, float], str, dict[str, str], float, str]] = {
    "N, of white noise": ({"random_walk": _N}, "random_walk", {}, _N, "rad/sqrt(s)"),
    "N, with B": ({"random_walk": _N, "bias_instability": _B}, "random_walk", {}, _N, "rad/sqrt(s)"),
    "N, with a B too small to be seen": (
        {"random_walk": _N, "bias_instability": 1e-4},
        "random_walk",
        {},
        _N,
        "rad/sqrt(s)",
    ),
    "B, with N": (
        {"random_walk": _N, "bias_instability": _B},
        "bias_instability",
        {"as": "coefficient"},
        _B,
        "rad/s",
    ),
    "Allan minimum, of N and B": (
        {"random_walk": _N, "bias_instability": _B},
        "bias_instability",
        {"as": "minimum"},
        _B * BIAS_LEVEL,
        "rad/s",
    ),
    "Allan minimum, of N and K": (
        {"random_walk": _N, "rate_random_walk": _K},
        "bias_instability",
        {"as": "minimum"},
        math.sqrt(2 * _N * _K / math.sqrt(3)),
        "rad/s",
    ),
    "K, with N": ({"random_walk": _N, "rate_random_walk": _K}, "rate_random_walk", {}, _K, "rad/s/sqrt(s)"),
}


def cell(seed: int, name: str) -> list[list[str]]:
    """Status of each axis for each ratio of its true value to the limit, and for each level at the limit."""
    rng = np.random.default_rng(seed)
    terms, key, specifications, truth, unit = CASES[name]
    channels = [f"gyro_{axis}" for axis in "xyz"]
    model = NoiseModel(channels=dict.fromkeys(channels, terms))
    rows = []
    for _ in range(AXES // PARTS // len(channels)):
        record = simulate(model, duration=SAMPLES / RATE, rate=RATE, rng=rng)
        result = SimpleNamespace(fits={channel: fit(curve) for channel, curve in allan(record, threads=1).items()})
        asked = []
        for level, ratio in _ASKED:
            claim = {"maximum": f"{truth / ratio!r} {unit}", **specifications}
            sheet = Datasheet.from_dict({"name": "-", "maker": "-", "source": "-", "gyro": {key: claim}})
            asked.append({judged.channel: judged.status for judged in compare_with(result, sheet, level=level).judged})
        rows += [[str(statuses.get(channel, "undecided")) for statuses in asked] for channel in channels]
    return rows


def _allowed(level: float) -> float:
    return float(1 - level + 3 * np.sqrt((1 - level) * level / AXES))


def main() -> None:
    """Run the study and write docs/study/datasheets.md."""
    cells = {f"{name} {k}": (cell, (name,)) for name in CASES for k in range(PARTS)}
    results = run("datasheets", cells, settings=repr((CASES, RATE, SAMPLES, AXES, _ASKED)))
    lines = [
        _HEAD.format(axes=AXES, minutes=SAMPLES / RATE / 60, rate=RATE, ratios=" | ".join(f"{r:g}" for r in RATIOS))
    ]
    lines.append("|---" * (len(RATIOS) + 2) + "|")
    failures = []
    allowed = _allowed(LEVEL)
    at_limit = [_AT_LIMIT, "|---" * (len(LEVELS) + 1) + "|"]
    for name in CASES:
        rows = np.array([row for k in range(PARTS) for row in results[f"{name} {k}"]])
        for status in ("out", "undecided", "within"):
            shares = (rows[:, : len(RATIOS)] == status).mean(axis=0)
            lines.append(f"| {name} | {status} | " + " | ".join(f"{100 * s:.1f}" for s in shares) + " |")
            if status == "out":
                failures += [
                    f"- {name}: {100 * s:.1f} % have the status out at {r:g} times the limit"
                    for r, s in zip(RATIOS, shares, strict=True)
                    if r <= 1 and s > allowed
                ]
        shares = (rows[:, len(RATIOS) :] == "out").mean(axis=0)
        at_limit.append(f"| {name} | " + " | ".join(f"{100 * s:.1f}" for s in shares) + " |")
        failures += [
            f"- {name}: {100 * s:.1f} % have the status out at the limit with a level of {level:g}"
            for level, s in zip(LEVELS, shares, strict=True)
            if s > _allowed(level)
        ]
    gates = ", ".join(f"{100 * (1 - level):.2g} % ({100 * _allowed(level):.1f} %)" for level in LEVELS)
    lines += ["", *at_limit, ""]
    lines.append(
        f"Gates: up to the limit, at most 1 - level of the units get the status out, plus three standard errors of {AXES}"
        f" axes: {gates}."
    )
    lines += ["Not met:", *failures] if failures else ["All gates are met."]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# False failures of the datasheet comparison

Made by `make study` (studies/datasheets.py). {axes} simulated axes of {minutes:.0f} min at {rate:g} Hz are fitted and
compared with a maximum by `compare_with` at 95 %. The table gives the percentage of axes by status, for several ratios
of the true value to the maximum. N = 0.005, B = 0.0028 (the small one 1e-4), K = 1e-4 in SI.

| compared | percent | {ratios} |"""

_AT_LIMIT = f"""Percentage of units exactly at the limit that get the status out, by `level`. It is at most 1 - level. It
is usually less, because the intervals include the effect of terms that the record does not show.

| compared | {" | ".join(f"{level:g}" for level in LEVELS)} |"""


if __name__ == "__main__":
    main()
