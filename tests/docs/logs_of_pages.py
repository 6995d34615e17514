"""Small logs, models and results for several pages."""

import shutil
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from pages import ROOT, blocks

from known import seed_of
from sigmatau import ChannelModel, LowPass, NoiseModel, Record, simulate
from sigmatau.cli import main
from sigmatau.io.write import write

AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
# A MEMS unit: 0.34 deg/√h, 6 deg/h and 25 deg/h/√h; 0.06 m/s/√h, 31 µg and 0.4 m/s/h^1.5
MEMS = {
    "gyro": {"random_walk": 1e-4, "bias_instability": 3e-5, "rate_random_walk": 2e-6},
    "accel": {"random_walk": 1e-3, "bias_instability": 3e-4, "rate_random_walk": 2e-6},
}


def noise(name: str, rows: int, columns: int) -> np.ndarray:
    """White noise of a case, shape (rows, columns)."""
    return np.random.default_rng(seed_of(name)).standard_normal((rows, columns))


def table(place: Path, columns: np.ndarray, header: str = "", delimiter: str = ",") -> None:
    """A text table."""
    place.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(place, columns, delimiter=delimiter, header=header, comments="", fmt="%.9g")


def timed(place: Path, samples: np.ndarray, units: dict[str, str], *, rate: float = 100.0) -> None:
    """A log with a time column; `units` of the columns of the samples, by name."""
    header = ",".join(["time [s]", *(f"{name} [{unit}]" for name, unit in units.items())])
    table(place, np.column_stack([np.arange(len(samples)) / rate, samples]), header)


def mems_log(
    place: Path, *, duration: float = 60.0, rate: float = 100.0, axes: list[str] = AXES, unit: dict[str, Any] = MEMS
) -> None:
    """A log of the MEMS unit, or of another one, at rest."""
    model = NoiseModel(channels={axis: unit[axis.split("_")[0]] for axis in axes})
    write(simulate(model, duration=duration, rate=rate, rng=seed_of(place.name)), place)


def filtered(name: str, rate: float, axes: list[str], *, samples: int = 6000) -> Record:
    """White noise of a sensor with two poles at 80 Hz, sampled at a rate."""
    channel = {"random_walk": 1e-4}
    model = NoiseModel(
        channels={axis: ChannelModel(terms=channel, bandwidth=LowPass(order=2, corner=80.0)) for axis in axes}
    )
    return simulate(model, duration=samples / rate, rate=rate, rng=seed_of(name))


def demo_log(place: Path) -> None:
    """The log of `sigmatau demo`: two hours of the HG1700 at 100 Hz, seed 0."""
    with resources.as_file(resources.files("sigmatau.data").joinpath("hg1700.toml")) as model:
        write(simulate(NoiseModel.read(model), duration=7200, rate=100, rng=0), place)


def analysed(log: Path, result: Path, *more: str) -> None:
    """Write the result of a log like the command line."""
    assert main(["analyze", str(log), "--json", str(result), "-q", *more]) == 0


def block_of(page: str, language: str) -> str:
    """The first block of a language of a page."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return next(block.content for block in blocks(text) if block.language == language)


def index_model(folder: Path) -> None:
    """imu.toml of docs/how-to/README.md."""
    (folder / "imu.toml").write_text(block_of("docs/how-to/README.md", "toml"), encoding="utf-8")


def copied(source: Path, *copies: Path) -> None:
    """A file under other names."""
    for copy in copies:
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, copy)


def typed(unit: str, values: tuple[float, ...]) -> str:
    """Coefficients of several days, as typed by a user."""
    rows = [f"{day},gyro_x,quantization,{value},{unit},0.06" for day, value in enumerate(values, 1)]
    return "\n".join(["run,channel,term,value,unit,error_percent", *rows]) + "\n"
