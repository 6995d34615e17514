"""Models and simulated logs for the commands of the pages."""

import re
from pathlib import Path

import numpy as np

from conftest import ROOT
from known import seed_of
from sigmatau import Imperfections, NoiseModel, Record, simulate
from sigmatau._native import formats
from sigmatau.io.write import write
from sigmatau.simulation.imperfections import Outage

_INDEX = ROOT / "docs" / "how-to" / "README.md"


def index_model(path: Path) -> NoiseModel:
    """The model of the how-to pages, also written to `path`."""
    (text,) = re.findall(r"^```toml\n(.*?)^```", _INDEX.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    path.write_text(text, encoding="utf-8")
    return NoiseModel.read(path)


def model_of(**channels: dict[str, object]) -> NoiseModel:
    """A model with the values of a model file: ``model_of(gyro_x={"random_walk": "0.3 deg/sqrt(h)"})``."""
    return NoiseModel.from_dict({"channels": channels})


def simulated(
    case: str, model: NoiseModel, *, seconds: float, rate: float, imperfections: Imperfections | None = None
) -> Record:
    """A record with a seed from the name of its case."""
    return simulate(model, duration=seconds, rate=rate, rng=seed_of(case), imperfections=imperfections)


def write_log(path: Path, case: str, model: NoiseModel, *, seconds: float, rate: float) -> None:
    """A simulated log of a sensor at rest; the ending of `path` gives the format."""
    write(simulated(case, model, seconds=seconds, rate=rate), path)


def some(model: NoiseModel, *names: str) -> NoiseModel:
    """Some channels of a model, to shorten a test."""
    return NoiseModel(channels={name: model.channels[name] for name in names})


def lossy(path: Path, case: str, model: NoiseModel, *, seconds: float, rate: float) -> None:
    """A log with lost rows: 5 % at random, and 90 s in one piece."""
    lost = Imperfections(lost=0.05, outages=(Outage(start=seconds / 3, length=90),))
    write(simulated(case, model, seconds=seconds, rate=rate, imperfections=lost), path)
    rows = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(row for row in rows if "NaN" not in row), encoding="utf-8")


def bench() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times and samples of ten undisturbed minutes at 50 Hz on a bench: two gyros, and gravity."""
    noise = {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "5 deg/h"}
    accel = {"random_walk": "120 ug/sqrt(Hz)", "bias_instability": "40 ug"}
    model = model_of(gyro_x=noise, gyro_y=noise, accel_z=accel)
    record = simulated("how-to: moving", model, seconds=600, rate=50)
    columns = {name: record.stream_of(name).column(name).copy() for name in model.channels}
    columns["accel_z"] += 9.80665
    return np.arange(30_000) / 50, columns


def write_table(path: Path, times: np.ndarray, columns: dict[str, np.ndarray]) -> None:
    """A text table in SI."""
    names = (f"{name} [{'rad/s' if name.startswith('gyro') else 'm/s^2'}]" for name in columns)
    rows = formats.format_text(",", [times, *columns.values()])
    path.write_bytes(",".join(["time [s]", *names]).encode() + b"\n" + rows)
