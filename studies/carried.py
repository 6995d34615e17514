"""Check of results derived from a fit: verification, Allan deviation and predicted heading of its model.

``python -m studies.carried`` prints the table; records of 3 h at 100 Hz, as in `studies.likelihood`.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from sigmatau.estimators.allan import allan
from sigmatau.fitting.likelihood import fit_samples
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.numbers import adev_interval
from sigmatau.model.processes import GaussMarkov
from sigmatau.navigation.predict import predict
from sigmatau.simulation.in_memory import simulate
from sigmatau.statespace.verify import verify
from studies.likelihood import BACKGROUNDS, SIGMA, TIMES
from studies.runner import run, seed_of

RECORDS = 40
DURATION, RATE = 10800.0, 100.0
AFTER = (60.0, 600.0)
LEVELS = (0.05, 0.002)


def cell(_: int, background: str, time: float, records: int = RECORDS) -> list[dict[str, Any]]:
    """Results derived from the fits of some records, each with a seed from its name."""
    truth = ChannelModel(terms=BACKGROUNDS[background], gauss_markov=(GaussMarkov(sigma=SIGMA, time=time),))
    return [judge_record(truth, seed_of(f"carried {background}, {time:g} s, {k}")) for k in range(records)]


def judge_record(truth: ChannelModel, seed: int) -> dict[str, Any]:
    """Results derived from the fit of one record."""
    true = NoiseModel(channels={"gyro_z": truth})
    record = simulate(true, duration=DURATION, rate=RATE, rng=seed)
    curve = allan(record)["gyro_z"]
    fitted = fit_samples(record.streams[0], "gyro_z")
    model = fitted.to_model()
    sizes = curve.m[3 * curve.m <= curve.n]
    low, high = adev_interval(model, m=sizes, tau0=curve.tau0)
    pointwise_low, pointwise_high = adev_interval(model, m=sizes, tau0=curve.tau0, simultaneous=False)
    expected = truth.adev(m=sizes, tau0=curve.tau0)
    ratio = model.adev(m=sizes, tau0=curve.tau0) / expected
    heading = predict(NoiseModel(channels={"gyro_z": model}), after=AFTER, rate=RATE)["heading"]
    right = predict(true, after=AFTER, rate=RATE)["heading"].rms
    ends = (heading.rms if end is None else end for end in (heading.low, heading.high))
    lowest, highest = ends
    return {
        "verdict": fitted.verdict,
        "verified": verify(model, curve).p_value,
        "curve": ((low <= expected) & (expected <= high)).tolist(),
        "at": ((pointwise_low <= expected) & (expected <= pointwise_high)).tolist(),
        "worst": [float(ratio.min()), float(ratio.max())],
        "predicted": ((lowest <= right) & (right <= highest)).tolist(),
        "at_most": None if heading.at_most is None else ((lowest <= right) & (right <= heading.at_most)).tolist(),
        "ratio": (heading.rms / right).tolist(),
    }


def table(results: Mapping[str, list[dict[str, Any]]]) -> str:
    """One row per cell: shares in per cent."""
    head = "case; adequate; verify p < " + "; ".join(f"{level:g}" for level in LEVELS)
    rows = [head + "; curve inside at every tau; at a tau by the interval of each; " + f"heading after {AFTER}"]
    for name, every in [*results.items(), ("all", [row for rows in results.values() for row in rows])]:
        good = [row for row in every if row["verdict"] in ("adequate", "adequate_with")]
        numbers = [len(good) / len(every)]
        numbers += [float(np.mean([row["verified"] < level for row in good])) for level in LEVELS]
        numbers += [
            float(np.mean([all(row["curve"]) for row in every])),
            float(np.mean([row["at"] for row in every])),
        ]
        numbers += np.mean([row["predicted"] for row in every], axis=0).tolist()
        numbers += np.mean([row["at_most"] or row["predicted"] for row in every], axis=0).tolist()
        rows.append(f"{name}; {len(every)} records; " + "; ".join(f"{100 * x:.1f}" for x in numbers))
    return "\n".join(rows)


if __name__ == "__main__":
    cells = {f"carried {b}, {t:g} s": (cell, (b, t)) for b in BACKGROUNDS for t in TIMES}
    sys.stdout.write(table(run("carried", cells, settings=f"{RECORDS} {DURATION}")) + "\n")
