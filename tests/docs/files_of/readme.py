"""The files of README.md: the log of the demo, and logs that do not state everything."""

from importlib import resources
from pathlib import Path

from logs_of_pages import AXES, noise, table, timed

from sigmatau import NoiseModel, simulate
from sigmatau.io.write import write


def demo_log(place: Path) -> None:
    """What `sigmatau demo` simulates: two hours of the HG1700 at 100 Hz, seed 0."""
    with resources.as_file(resources.files("sigmatau.data").joinpath("hg1700.toml")) as model:
        write(simulate(NoiseModel.read(model), duration=7200, rate=100, rng=0), place)


def make(folder: Path) -> None:
    """The files that the page names."""
    demo_log(folder / "static.csv")
    samples = noise("log without units", 3000, 6) * 0.01
    table(folder / "log.csv", samples, ",".join(AXES))
    timed(folder / "imu.csv", samples, dict.fromkeys(AXES, "x"))
    (folder / "imu.txt").write_text("".join((folder / "imu.csv").open().readlines()[1:]).replace(",", " "))
