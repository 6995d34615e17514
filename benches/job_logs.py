"""Logs of the main job: what is in them, and the arguments with which they are analysed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from benches.measure import Settings
from sigmatau import NoiseModel, Record, simulate
from sigmatau.io.write import write as write_log

RATE = 100.0

_NOISE = {
    "gyro": {"random_walk": 2e-3, "bias_instability": 5e-5, "rate_random_walk": 1e-6},
    "accel": {"random_walk": 1e-3, "bias_instability": 2e-4, "rate_random_walk": 3e-6},
}

_MODEL = NoiseModel(channels={f"{sensor}_{axis}": noise for sensor, noise in _NOISE.items() for axis in "xyz"})

LOGS, _LOGS_APART = 40, 4  # number of logs in a folder, and of those with separate samples; the others are links
_CHANNELS = 60
_REAL = Path("adis16405_static.csv.gz")  # log of the field data
_DAY, _DAY_RATE = 17_280_000, 200.0  # samples of 24 hours [Hz]

# Options of `read` for logs that need them; the parts of these are timed too.
OPTIONS: dict[str, dict[str, Any]] = {
    "real": {"rate": RATE},
    "day": {
        "rate": _DAY_RATE,
        "channels": {"gyro": "1:3", "accel": "4:6"},
        "unit": {"gyro": "rad/s", "accel": "m/s^2"},
    },
}


def log(samples: int, *, disturbed: bool) -> Record:
    """Six axes at rest; if `disturbed`, with a knock and spikes as in most logs."""
    rng = np.random.default_rng(2)
    axes = _axes(samples, seed=1)
    places = rng.integers(samples // 4, samples, 20)
    for name, x in axes.items():
        if disturbed:
            x[places] += 40 * float(x.std()) * rng.standard_normal(len(places))
            x[samples // 5 : samples // 5 + 30] += 60 * float(x.std()) * np.exp(-np.arange(30) / 8)
        if name == "accel_z":
            x += 9.80665
    return Record.from_arrays(rate=RATE, **axes)


def _axes(samples: int, seed: int, rate: float = RATE) -> dict[str, Any]:
    record = simulate(_MODEL, duration=samples / rate, rate=rate, rng=seed)
    return {name: np.array(record.stream_of(name).column(name)) for name in _MODEL.channels}


def moving(samples: int) -> Record:
    """Six axes with a rotation for some time, spikes, and a step of the mean."""
    rng = np.random.default_rng(4)
    axes = _axes(samples, seed=3)
    start, stop = samples // 4, samples // 4 + samples // 16
    t = np.arange(stop - start) / RATE
    for name, x in axes.items():
        spread = float(x.std())
        x[rng.integers(samples // 4, samples, 15)] += 40 * spread * rng.standard_normal(15)
        size = 0.5 if name.startswith("gyro") else 1.0
        x[start:stop] += size * np.sin(2 * np.pi * (0.4 + 0.1 * rng.random()) * t)
        x[samples // 10 * 7 :] += 3 * spread
        if name == "accel_z":
            x += 9.80665
    return Record.from_arrays(rate=RATE, **axes)


def people(samples: int) -> Record:
    """Gyro rates of a navigation-grade unit whose table is nudged at irregular times by people in the room."""
    rng = np.random.default_rng(5)
    model = NoiseModel(channels={f"gyro_{axis}": {"random_walk": 2e-7, "quantization": 2e-6} for axis in "xyz"})
    record = simulate(model, duration=samples / RATE, rate=RATE, rng=6)
    axes: dict[str, Any] = {name: np.array(record.stream_of(name).column(name)) for name in model.channels}
    decay = np.exp(-np.arange(300) / 60) * np.sin(2 * np.pi * 3.0 / RATE * np.arange(300))
    for start in rng.integers(samples // 10, samples - 300, 30):
        for x in axes.values():
            x[start : start + 300] += 20 * float(x[:1000].std()) * rng.standard_normal() * decay
    return Record.from_arrays(rate=RATE, **axes)


def many_channels(samples: int) -> Record:
    """Short records of sixty gyros."""
    rng = np.random.default_rng(7)
    axes: dict[str, Any] = {f"gyro{k}": 1e-2 * rng.standard_normal(samples) for k in range(_CHANNELS)}
    return Record.from_arrays(rate=RATE, **axes)


def write_logs(folder: Path, settings: Settings) -> dict[str, list[str]]:
    """Write all logs into a folder; return the arguments of `sigmatau analyze` by their names."""
    n = settings.samples(720_000)
    records = {
        "clean": log(n, disturbed=False),
        "disturbed": log(n, disturbed=True),
        "moving": moving(settings.samples(50_000)),
        "people": people(settings.samples(185_000)),
        "channels": many_channels(600),
    }
    arguments_of_logs = {}
    for name, record in records.items():
        write_log(record, str(folder / f"{name}.csv"))
        arguments_of_logs[name] = [str(folder / f"{name}.csv")]
    numbered = [f"gyro{k}" for k in range(_CHANNELS)]
    arguments_of_logs["channels"] += [
        "--channels=time=1," + ",".join(f"{name}={k + 2}" for k, name in enumerate(numbered)),
        "--unit=" + ",".join(f"{name}=rad/s" for name in numbered),
    ]
    logs = folder / "logs"
    logs.mkdir()
    (folder / "results").mkdir()
    for k in range(LOGS):
        if k < _LOGS_APART:
            record = Record.from_arrays(rate=RATE, **_axes(settings.samples(360_000), seed=10 + k))
            write_log(record, str(logs / f"{k:02}.csv"))
        else:
            os.link(logs / f"{k % _LOGS_APART:02}.csv", logs / f"{k:02}.csv")
    day = folder / "day.npy"
    n = settings.samples(_DAY)
    table = np.lib.format.open_memmap(day, mode="w+", dtype=np.float64, shape=(n, 6))
    for k, x in enumerate(_axes(n, seed=20, rate=_DAY_RATE).values()):
        table[:, k] = x
    table.flush()
    columns = [f"--{option}={_pairs(OPTIONS['day'][option])}" for option in ("channels", "unit")]
    arguments_of_logs |= {
        "folder, one": [str(logs), "--jobs", "1", "--threads", "1"],
        "folder, two": [str(logs), "--jobs", "2"],
        "day": [str(day), "--rate", f"{_DAY_RATE:g}", *columns],
    }
    real = Path(os.environ.get("SIGMATAU_FIELD_DATA", Path(__file__).parents[2] / "shared" / "data")) / _REAL
    return arguments_of_logs | ({"real": [str(real), "--rate", f"{RATE:g}"]} if real.exists() else {})


def _pairs(options: dict[str, str]) -> str:
    return ",".join(f"{name}={value}" for name, value in options.items())
