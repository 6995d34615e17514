"""Exports of stated values. If a datasheet states no slow noise, a walk is matched at a horizon, with a remark in the
file.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from sigmatau.exporting.choices import KINDS, Choices
from sigmatau.exporting.export import Prepared, find_unplaced, prepare
from sigmatau.exporting.source import Source
from sigmatau.exporting.targets import target
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import BIAS_LEVEL
from sigmatau.record.record import stream_name
from sigmatau.results import seconds

HORIZON = 10.0
"""Default averaging time at which the rate random walk is matched to the random walk: the time for which a filter with
cameras or satellites relies on a bias before other sensors correct it. [s]

A process is matched where random walk and bias instability are equal.
"""


def prepare_stated(
    model: NoiseModel, *, to: str, path: Path | None = None, choices: Choices, origins: Iterable[str]
) -> Prepared:
    """Prepare the file of a target for a model of stated values.

    If a bias instability is stated, the rate random walk is that of a consistent filter, as for a measured sensor. If no
    slow noise is stated, the walk has the Allan variance of the random walk at the horizon: a larger walk would be
    visible in the stated random walk.

    Parameters
    ----------
    model : NoiseModel
    to : str
    path : Path or None
        File to write, as for `prepare`.
    choices : Choices
        Chosen walks have priority. With `strict`, a walk that is not stated has to be chosen.
    origins : iterable of str
        Lines for the head of the file: the sources of the values.
    """
    wanted = target(to)
    horizon = choices.horizon or (not wanted.has_walk and _minimum(model)) or HORIZON
    walks, reasons, matched = dict(choices.walk), list(origins), False
    for sensor, kind in KINDS.items():
        names = [name for name in model.channels if stream_name(name) == sensor]
        lacking = names and not any("rate_random_walk" in model.channels[name] for name in names)
        if choices.strict or not lacking or sensor in walks or not (wanted.has_walk or wanted.has_process):
            continue
        if any(map(Numbers(model, choices).has_slow_noise, names)):
            continue  # the target has a consistent walk or a process for bias instability
        noise = max(model.channels[name].get("random_walk", 0.0) for name in names)
        if not noise:
            continue
        walks[sensor], matched = math.sqrt(3) * noise / horizon, True
        horizon_option = Hint("horizon")
        reasons.append(
            f"Rate random walk of the {kind}: not stated; with the Allan variance at {seconds(horizon)} s ({horizon_option})"
            " of the random walk, because no bias instability is stated"
        )
    source = replace(Source.of_model(model), head=tuple(reasons))
    # The horizon of a consistent walk has a separate default.
    keeps_horizon = wanted.has_walk or (wanted.has_consistent and not matched)
    chosen = replace(choices, walk=walks, horizon=choices.horizon if keeps_horizon else horizon)
    unplaced = {each.choice for each in find_unplaced(wanted, chosen, source)}
    if "horizon" in unplaced and (choices.horizon is None or matched):
        chosen = chosen.without("horizon")
    return prepare(source, to=to, path=path, choices=chosen)


def _minimum(model: NoiseModel) -> float | None:
    """Averaging time at which the Allan deviation reaches the stated bias instability: N²/τ = 2 ln 2/π·B². [s]"""
    both = [
        (c["random_walk"], c["bias_instability"]) for c in model.values() if {"random_walk", "bias_instability"} <= {*c}
    ]
    return max((noise**2 / (BIAS_LEVEL * flicker) ** 2 for noise, flicker in both), default=None)
