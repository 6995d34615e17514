"""Time to compare 5000 units × 7 days × 6 axes: from one JSON file per result, one CSV file per result, and one table of
all results.

``python -m benches.comparison`` makes the results in a temporary folder (1.7 GB for 35 000 files) and prints the times.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from studies.runner import seed_of

from sigmatau import NoiseModel, analyze, simulate
from sigmatau.results import csv_text

DAYS = 7
VARIANTS = 20  # number of analysed records; their numbers are scaled for each result


def main() -> None:
    """Make the results and time the command."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--units", type=int, default=5000)
    parser.add_argument("--folder", type=Path, help="where the results are made, and kept")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = args.folder or Path(temporary)
        for kind in ("json", "csv", "table"):
            place = folder / kind
            if not place.exists():
                place.mkdir(parents=True)
                write(place, kind, args.units)
            times = []
            for _ in range(3):
                start = time.perf_counter()
                subprocess.run(
                    [sys.executable, "-m", "sigmatau", "compare", str(place)], check=True, stdout=subprocess.DEVNULL
                )
                times.append(time.perf_counter() - start)
            size = sum(file.stat().st_size for file in place.rglob("*") if file.is_file())
            texts = ", ".join(f"{seconds:.1f}" for seconds in times)
            print(f"{kind}: {args.units} units x {DAYS} days x 6 axes, {size / 1e6:.0f} MB: {texts} s")


def results() -> list[dict[str, Any]]:
    """Results of two hours of a unit with six axes."""
    gyro = {"random_walk": 8.7e-5, "bias_instability": 5.8e-5}
    accel = {"random_walk": 5e-4, "bias_instability": 3e-4}
    channels = {f"{sensor}_{axis}": terms for sensor, terms in (("gyro", gyro), ("accel", accel)) for axis in "xyz"}
    model = NoiseModel(channels=channels)
    contents = []
    for k in range(VARIANTS):
        record = simulate(model, duration=7200, rate=20, rng=seed_of(f"comparison {k}"))
        contents.append(analyze(record).to_dict())
    return contents


def write(folder: Path, kind: str, units: int) -> None:
    """Write the results of all units and days, one file each or one table."""
    rng = np.random.default_rng(seed_of(f"comparison {kind}"))
    texts = [json.dumps(result, indent=1) for result in results()]
    parsed = [json.loads(text) for text in texts]
    lines: list[str] = []
    for unit in range(units):
        unit_folder = folder / f"unit{unit:04}"
        if kind != "table":
            unit_folder.mkdir()
        for day in range(1, DAYS + 1):
            k, factor = int(rng.integers(VARIANTS)), float(np.exp(0.02 * rng.standard_normal()))
            if kind == "json":
                notes = json.dumps({"serial number": f"{unit:04}", "run": f"day {day}"})
                text = texts[k].replace('\n "source"', f'\n "notes": {notes},\n "source"', 1)
                for content in parsed[k]["channels"].values():
                    mean = content["mean"]["value"]
                    text = text.replace(repr(mean), repr(mean * factor), 1)
                (unit_folder / f"day{day}.json").write_text(text, encoding="utf-8")
                continue
            columns: dict[str, list[object]] = {name: [] for name in _COLUMNS}
            for channel, content in parsed[k]["channels"].items():
                for term, stated in content["fit"]["terms"].items():
                    if isinstance(stated, dict):
                        row = (stated.get(name) for name in ("value", "low", "high", "upper_limit"))
                        scaled = [None if x is None else x * factor for x in row]
                        cells = [channel, term, *scaled[:3], stated["unit"], stated["observed"], scaled[3], "adequate"]
                        for name, cell in zip(_COLUMNS, cells, strict=True):
                            columns[name].append(cell)
            if kind == "csv":
                (unit_folder / f"day{day}.csv").write_text(csv_text(columns), encoding="utf-8")
            else:
                head, *rows = csv_text(columns).splitlines()
                if not lines:
                    lines.append(f"serial,run,{head}")
                lines += [f"{unit:04},day {day},{row}" for row in rows]
    if kind == "table":
        (folder / "all.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


_COLUMNS = ("channel", "term", "value", "low", "high", "unit", "observed", "upper_limit", "verdict")

if __name__ == "__main__":
    main()
