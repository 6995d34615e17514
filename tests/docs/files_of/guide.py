"""The files of docs/guide.md, and of the examples of ``--help``."""

from pathlib import Path

import numpy as np
from filter_runs import write_innovations
from logs_of_pages import AXES, analysed, block_of, copied, filtered, mems_log, noise, table, timed, typed
from temperature_cycle import write_cycle

from drawn_curves import by_hand
from sigmatau.cli import main
from sigmatau.io.write import write

SHORT_ROWS = 2200  # number of rows, 11 s at 200 Hz: just above the shortest record that is judged
GYROS = dict.fromkeys(AXES[:3], "deg/s")
SIX = {axis: "deg/s" if axis.startswith("gyro") else "g" for axis in AXES}
SUBSTITUTED = {"--hours 2 --rate 100": "--hours 0.1 --rate 100"}  # a record of two hours shows no more of the options


def make(folder: Path) -> None:
    """The files that the page names."""
    mems_log(folder / "static.csv", duration=3600.0, rate=20.0, axes=["gyro_x", "accel_x"])
    timed(folder / "unit.csv", 0.1 * noise("unit", 1000, 3), GYROS)
    for name in ("night1.csv", "night2.csv"):
        timed(folder / name, (*(0.1,) * 3, *(0.02,) * 3) * noise(name, SHORT_ROWS, 6), SIX)
    samples = noise("few rows", SHORT_ROWS, 7)
    samples[:, 0] = np.arange(SHORT_ROWS) / 100
    np.savetxt(folder / "imu.txt", samples)
    timed(folder / "growing.csv", 1e-3 * noise("growing", 1000, 3), dict.fromkeys(AXES[:3], "rad/s"))
    for name, columns in (("log.csv", AXES), ("daq.csv", AXES[:3]), ("counts.csv", AXES[:3])):
        volts = 2.5 + 1e-3 * noise(name, SHORT_ROWS, len(columns))
        table(folder / name, volts, ",".join(columns))
    for name in ("rlg.csv", "laser_gyro.csv"):
        table(folder / name, samples, ",".join(["time [s]", *AXES]))
    np.savetxt(folder / "phase.txt", np.cumsum(noise("phase", 1000, 1)))
    for name in ("imu.toml", "rlg.toml"):
        (folder / name).write_text(block_of("docs/guide.md", "toml"), encoding="utf-8")
    spec = 'name = "spec"\nmaker = "us"\nsource = "here"\n[gyro]\nrandom_walk = { maximum = "6 deg/sqrt(h)" }\n'
    (folder / "spec.toml").write_text(spec)
    (folder / "units.txt").write_text("unit1\nunit2\n")
    for unit in (1, 2):
        log = folder / "shift" / f"unit{unit}.csv"
        timed(log, 0.1 * noise(f"unit {unit}", 1000, 3), GYROS)
        copied(log, folder / "logs" / log.name, folder / "night" / log.name)
        analysed(log, folder / f"unit{unit}.json")
    analysed(folder / "static.csv", folder / "result.json")
    copied(folder / "result.json", folder / "static.json", folder / "running.json")
    frequency = np.linspace(0.01, 50.0, 5000)
    density = 1e-8 + 1e-11 / frequency
    np.savetxt(
        folder / "density.csv", np.c_[frequency, density], delimiter=",", header="frequency,density", comments=""
    )
    tau = 0.01 * 2.0 ** np.arange(17)
    curve = np.c_[np.arange(1, 18), tau, np.zeros((17, 3)), 5 / np.sqrt(tau), np.zeros(17)]
    np.savetxt(folder / "stable32.txt", curve, header="AF Tau # Alpha Min Sigma Max")
    header = "tau [s],gyro_x adev [deg/h]"
    np.savetxt(folder / "adev.csv", curve[:, [1, 5]], delimiter=",", header=header, comments="")
    by_hand(folder / "figure.svg")
    places = np.c_[80 + 100 * np.log10(tau / 0.01), 310 - 280 / 3 * np.log10(curve[:, 5])]
    np.savetxt(folder / "clicks.csv", places, delimiter=",", header="x,y", comments="")
    board = noise("board", 3000, 4)
    timed(folder / "board.csv", 0.1 * board, {f"g{k}": "deg/s" for k in range(1, 5)})
    write_cycle(folder, seconds=5400)
    (folder / "table1.csv").write_text(typed("arcsec", (0.973, 0.960, 0.919)))
    for day in range(1, 4):
        log = folder / f"day{day}.csv"
        timed(log, (0.1, 0.002) * noise(log.name, 1000, 2), {"gyro_x": "deg/s", "accel_x": "g"})
        analysed(log, log.with_suffix(".json"), "--note", "serial number=A123", "--note", f"run=day {day}")
        copied(log.with_suffix(".json"), folder / "results" / f"day{day}.json")
    add = ["store", "add", str(folder / "results"), "--store", str(folder / "lab.db"), "--date", "2026-05-01", "-q"]
    assert main(add) == 0
    for name, rate in (("50Hz.csv", 50.0), ("500Hz.csv", 500.0), ("fast.csv", 500.0)):
        write(filtered(name, rate, ["gyro_x"], samples=3000), folder / name)
    for name, rate in (("slow.txt", 50.0), ("fast.txt", 500.0)):
        record = filtered(name, rate, AXES[:3], samples=3000)
        np.savetxt(folder / name, np.column_stack([record.streams[0].column(axis) for axis in AXES[:3]]))
    write_innovations(folder / "innovations.csv", {"x": ("nu_gyro_x", "S_gyro_x")}, walk=1e-5, duration=120.0)
    write_innovations(folder / "run.csv", {"x": ("r0", "s0"), "y": ("r1", "s1")}, walk=1e-5, duration=120.0)
    # A program that prints samples, in place of the one of the reader
    logger = folder / "logger"
    logger.write_text("#!/bin/sh\nawk 'BEGIN { srand(1); for (k = 0; k < 2200; k++) print rand(), rand(), rand() }'\n")
    logger.chmod(0o755)
