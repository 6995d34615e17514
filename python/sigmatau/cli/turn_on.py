"""Turn-on bias of a unit, as ``sigmatau compare --model`` writes it."""

from __future__ import annotations

from pathlib import Path

from sigmatau.analysis.inputs import is_result, require_model
from sigmatau.analysis.reading import read_analysis
from sigmatau.errors import DataError, OptionError
from sigmatau.io.atomic import atomic
from sigmatau.lab.lots.comparison import RunComparison
from sigmatau.lab.lots.runs import ComparedRun
from sigmatau.lab.lots.turn_on import measure_turn_on
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.turn_on import is_wide
from sigmatau.results import printable


def write_model(comparison: RunComparison, path: Path) -> list[str]:
    """Write the noise of the longest run with the turn-on bias of all runs; return lines for the terminal."""
    if comparison.by != "unit":
        raise OptionError(f"--model is for the runs of a unit, not --by {comparison.by}", option="model")
    if len(comparison.groups) > 1:
        listed = ", ".join(comparison.groups[:5])
        raise OptionError(
            f"--model is for the runs of one unit, not of {listed}: name the results of one", option="model"
        )
    spreads = measure_turn_on(comparison)
    runs = [run for run in comparison.runs if not run.problem]
    longest, noise = _longest(runs)
    lacking = [name for name in spreads if name not in noise.channels]
    model = noise.with_turn_on({name: spread for name, spread in spreads.items() if name in noise.channels})
    head = f"# Noise of the longest record, {longest.name}; turn_on: spread of {', '.join(run.name for run in runs)}"
    with atomic(path) as temporary:
        temporary.write_text(f"{printable(head)}\n\n{model.to_toml()}", encoding="utf-8")
    written = {name: channel for name, channel in model.channels.items() if channel.turn_on is not None}
    lines = [f"{path}: noise of {longest.name}, turn-on bias of {len(written)} channels"]
    for name, channel in written.items():
        if channel.turn_on is not None:
            lines.append(f"  {name}: {channel.turn_on.text(channel.quantity, channel.unit)}")
    if any(is_wide(spreads[name]) for name in written):
        lines.append("warning: few power-ups: the intervals of the turn-on bias are wide; record more of them")
    if lacking:
        lines.append(f"warning: {longest.name} has no noise model of {', '.join(lacking)}: left out of {path}")
    return lines


def _longest(runs: list[ComparedRun]) -> tuple[ComparedRun, NoiseModel]:
    """Select the run with the longest record, and its model. Raises `DataError` if no run has a file with a model."""
    best: tuple[float, ComparedRun, NoiseModel] | None = None
    reasons = []
    for run in runs:
        place = Path(run.place)
        if not is_result(place):
            continue
        try:
            model = require_model(read_analysis(place), place)
        except DataError as error:
            reasons.append(str(error))
            continue
        duration = max(channel.duration for channel in model.values())
        if best is None or duration >= best[0]:
            best = duration, run, model
    if best is None:
        raise DataError(reasons[0] if reasons else "--model needs the JSON of sigmatau analyze, for the noise of a run")
    return best[1:]
