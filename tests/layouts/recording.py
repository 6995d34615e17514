"""Simulated records of a known random walk, and the description of a log layout.

A record at rest is white noise plus a constant rate and a constant specific force; a moving record adds a motion.
Everything depends only on the name of the layout: the seed is a hash of the name.
"""

import dataclasses
import gzip
import hashlib
import io
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

GYRO_RANDOM_WALK = math.radians(0.300) / 60  # rad/√s: 0.300 deg/√h
ACCEL_RANDOM_WALK = 0.0588 / 60  # m/s/√s: 0.0588 m/s/√h
STANDARD_GRAVITY = 9.80665  # m/s²
EPOCH_S = 1714557600  # 2024-05-01 10:00:00 UTC, the start of every log that has a date
LARGEST_FILE = 1_000_000  # bytes

GYRO = ("gyro_x", "gyro_y", "gyro_z")
ACCEL = ("accel_x", "accel_y", "accel_z")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Log:
    """Samples of a simulated unit in SI units, arrays of shape (n,) and (n, 3); `accel_time` differs if the rates do."""

    time: np.ndarray
    gyro: np.ndarray
    accel_time: np.ndarray
    accel: np.ndarray
    gyro_mean: np.ndarray
    accel_mean: np.ndarray
    rng: np.random.Generator

    @property
    def gyro_deg(self) -> np.ndarray:
        """Rates in deg/s."""
        return np.degrees(self.gyro)

    @property
    def accel_g(self) -> np.ndarray:
        """Specific forces in g."""
        return self.accel / STANDARD_GRAVITY

    def fill(self, columns: int, level: float, noise: float) -> np.ndarray:
        """Columns of another quantity, such as a magnetic field: a constant of about `level` each, and noise."""
        n = len(self.time)
        return level * self.rng.uniform(0.3, 1.0, columns) + self.rng.normal(0.0, noise, (n, columns))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """A log layout, and the expected result of a program.

    `asks` names the question that is right if the file does not state something (empty: the file states all). `answers` are
    the options of a sensible answer; each alternative is tried alone. Without `answers`, a refusal is right.
    `gyro_step` and `accel_step` are the resolution of the file in SI units.
    """

    name: str
    file: str
    source: str
    write: Callable[[Path, Log], None]
    rate_hz: float
    seconds: float
    accel_rate_hz: float | None = None
    channels: tuple[str, ...] = GYRO + ACCEL
    motion: str = ""
    options: tuple[str, ...] = ()
    asks: str = ""
    answers: tuple[tuple[str, ...], ...] = ()
    gyro_step: float = 0.0
    accel_step: float = 0.0

    @property
    def readable(self) -> bool:
        """Whether the file has data that a program can analyse."""
        return bool(self.channels)

    def rate_of(self, channel: str) -> float:
        """Sampling rate of a channel in Hz."""
        return self.accel_rate_hz if channel.startswith("accel") and self.accel_rate_hz else self.rate_hz

    def random_walk(self, channel: str) -> float:
        """Random walk of a channel in rad/√s or m/s/√s, with the white noise that rounding to the step adds."""
        gyro = channel.startswith("gyro")
        white = GYRO_RANDOM_WALK if gyro else ACCEL_RANDOM_WALK
        step = self.gyro_step if gyro else self.accel_step
        return math.hypot(white, step / math.sqrt(12 * self.rate_of(channel)))

    def mean(self, channel: str) -> float:
        """Mean of a channel in rad/s or m/s²."""
        log = simulate(self)
        axis = "xyz".index(channel[-1])
        return float((log.gyro_mean if channel.startswith("gyro") else log.accel_mean)[axis])

    def save(self, folder: Path) -> Path:
        """Write the file and return its path."""
        path = folder / self.file
        self.write(path, simulate(self))
        if path.stat().st_size > LARGEST_FILE:
            raise ValueError(f"{path.name} has {path.stat().st_size} bytes, more than {LARGEST_FILE}")
        return path


def layout(**fields: object) -> Callable[[Callable[[Path, Log], None]], Layout]:
    """Make a `Layout` of the function that writes its file; the function's name is the name of the layout."""

    def make(write: Callable[[Path, Log], None]) -> Layout:
        return Layout(name=write.__name__, write=write, **fields)

    return make


def seed_of(name: str) -> int:
    """Seed from the name of a layout: neither chosen nor changed."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:7], "big")


def simulate(described: Layout) -> Log:
    """Simulate the record of a layout."""
    rng = np.random.default_rng(seed_of(described.name))
    gyro_mean = np.radians(rng.uniform(0.02, 0.8, 3) * rng.choice([-1.0, 1.0], 3))
    accel_mean = STANDARD_GRAVITY * draw_direction(rng)
    accel_rate = described.accel_rate_hz or described.rate_hz
    time = np.arange(round(described.seconds * described.rate_hz)) / described.rate_hz
    accel_time = np.arange(round(described.seconds * accel_rate)) / accel_rate
    gyro = gyro_mean + rng.normal(0.0, GYRO_RANDOM_WALK * math.sqrt(described.rate_hz), (len(time), 3))
    accel = accel_mean + rng.normal(0.0, ACCEL_RANDOM_WALK * math.sqrt(accel_rate), (len(accel_time), 3))
    if described.motion:
        tones = MOTIONS[described.motion]
        gyro = gyro + np.radians(sum_tones(rng, time, tones.rate_deg_s))
        accel = accel + sum_tones(rng, accel_time, tones.acceleration)
    return Log(
        time=time,
        gyro=gyro,
        accel_time=accel_time,
        accel=accel,
        gyro_mean=gyro_mean,
        accel_mean=accel_mean,
        rng=rng,
    )


def draw_direction(rng: np.random.Generator) -> np.ndarray:
    """A unit vector close to an axis of either sign, tilted by up to 25°, so that no two components are equal."""
    direction = np.zeros(3)
    axis = rng.integers(3)
    direction[axis] = rng.choice([-1.0, 1.0])
    direction[(axis + 1) % 3] = math.tan(math.radians(rng.uniform(2.0, 17.0))) * rng.choice([-1.0, 1.0])
    direction[(axis + 2) % 3] = math.tan(math.radians(rng.uniform(2.0, 17.0))) * rng.choice([-1.0, 1.0])
    return direction / np.linalg.norm(direction)


@dataclasses.dataclass(frozen=True)
class Tones:
    """Bands of a motion: (lowest Hz, highest Hz, rms); rates in deg/s, accelerations in m/s²."""

    rate_deg_s: tuple[tuple[float, float, float], ...]
    acceleration: tuple[tuple[float, float, float], ...]


MOTIONS = {
    "drive": Tones(((0.02, 0.3, 6.0), (8.0, 20.0, 0.8)), ((0.02, 0.5, 1.0), (8.0, 24.0, 0.7))),
    "walk": Tones(((0.1, 0.5, 20.0), (1.8, 2.0, 40.0), (3.6, 4.0, 20.0)), ((1.8, 2.0, 1.5), (3.6, 4.0, 1.0))),
    "hand": Tones(((0.1, 0.8, 35.0), (8.0, 12.0, 2.0)), ((0.1, 0.8, 2.0), (8.0, 12.0, 0.3))),
    "flight": Tones(((0.2, 3.0, 40.0), (60.0, 110.0, 6.0)), ((0.2, 3.0, 2.0), (60.0, 110.0, 3.0))),
}


def sum_tones(rng: np.random.Generator, time: np.ndarray, bands: Iterable[tuple[float, float, float]]) -> np.ndarray:
    """Sum 12 tones of random frequency and phase in each band and axis."""
    total = np.zeros((len(time), 3))
    for lowest, highest, rms in bands:
        for axis in range(3):
            for _ in range(12):
                angle = 2 * math.pi * (rng.uniform(lowest, highest) * time + rng.uniform())
                total[:, axis] += rms * math.sqrt(2 / 12) * np.sin(angle)
    return total


def save_text(path: Path, text: str, *, encoding: str = "utf-8") -> None:
    """Write a text, compressed if the name ends in .gz, with the same bytes on every system."""
    data = text.encode(encoding)
    if path.suffix == ".gz":
        buffer = io.BytesIO()
        with gzip.GzipFile(fileobj=buffer, mode="wb", filename="", mtime=0) as packed:
            packed.write(data)
        data = buffer.getvalue()
    path.write_bytes(data)


def save_rows(
    path: Path,
    head: str,
    row: str,
    *columns: Iterable[object],
    decimal: str = ".",
    end: str = "\n",
    encoding: str = "utf-8",
    tail: str = "",
) -> None:
    """Write a head, and a row for each sample: `row` is a %-format of the columns, of shape (n,) or (n, k) each."""
    cells = []
    for column in columns:
        values = column if isinstance(column, list) else np.asarray(column)
        if isinstance(values, np.ndarray) and values.ndim == 2:
            cells += [part.tolist() for part in values.T]
        else:
            cells.append(values if isinstance(values, list) else values.tolist())
    lines = [row % each for each in zip(*cells, strict=True)]
    if decimal != ".":
        lines = [line.replace(".", decimal) for line in lines]
    save_text(path, head + end.join(lines) + end + tail, encoding=encoding)


def stamps(time: np.ndarray, pattern: str, *, digits: int) -> list[str]:
    """Clock times of seconds since the start of the log: `pattern` of strftime, with `{f}` for the fraction of a second."""
    units = np.round(time * 10**digits).astype(np.int64)
    seconds = EPOCH_S + units // 10**digits
    parts = np.datetime_as_string(seconds.astype("datetime64[s]"))
    day = [text[:10] for text in parts]
    clock = [text[11:] for text in parts]
    fraction = [f"{unit % 10**digits:0{digits}d}" for unit in units.tolist()]
    return [
        pattern.format(
            Y=date[:4], m=date[5:7], d=date[8:10], H=hms[:2], M=hms[3:5], S=hms[6:8], date=date, clock=hms, f=part
        )
        for date, hms, part in zip(day, clock, fraction, strict=True)
    ]


def whole(values: np.ndarray) -> np.ndarray:
    """Round to integers, as counts of a converter."""
    return np.round(values).astype(np.int64)
