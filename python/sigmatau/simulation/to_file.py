"""Records simulated into a file, piece by piece."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.io.write import table_writer
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.unobserved import Unobserved, unobserved_texts
from sigmatau.record.streams import CHUNK
from sigmatau.record.thermometers import CELSIUS
from sigmatau.results import Printed, duration_text, plain
from sigmatau.simulation.imperfections import Imperfections
from sigmatau.simulation.rows import Channel, Flicker, Stamps, job


@frozen
class Simulated(Printed):
    """Description of the file that was written.

    Attributes
    ----------
    path : str
        The file.
    channels : tuple of str
        Channels in it.
    samples : int
        Samples of each channel that were simulated.
    lost : int
        Rows that `Imperfections` left out.
    rate : float
        Sampling rate. [Hz]
    seed : int
        Seed that reproduces the file.
    unobserved : tuple of str
        How the file includes terms that were not observed, one line per channel.

    See Also
    --------
    sigmatau.simulate_to : makes it.
    """

    path: str
    channels: tuple[str, ...]
    samples: int
    lost: int
    rate: float
    seed: int
    unobserved: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "path channels samples lost_rows=lost sample_rate_hz=rate seed unobserved")

    def __repr__(self) -> str:
        lost = f", {self.lost} rows lost" if self.lost else ""
        return (
            f"{self.path}: {self.samples} samples of {len(self.channels)} channels,"
            f" {duration_text(self.samples / self.rate)} at {self.rate:g} Hz{lost}, seed {self.seed}"
        )


def simulate_to(
    path: str | os.PathLike[str],
    model: NoiseModel,
    *,
    duration: float,
    rate: float,
    rng: int | np.random.Generator,
    imperfections: Imperfections | None = None,
    flicker: Flicker = "poles",
    unobserved: Unobserved = "absent",
    chunk: int = CHUNK,
    progress: Callable[[float], None] | None = None,
) -> Simulated:
    """Simulate a record into a file, which may be larger than memory. `sigmatau.read` returns the record of `simulate`.

    `sigmatau.read` returns channels other than ``gyro_x`` … ``accel_z`` and the temperature only if its `channels` names
    them.

    Parameters
    ----------
    path : str or path
        ``.csv``, ``.csv.gz``, ``.npy`` (a structured array of 64-bit floats, one field per column), ``.npz`` (one array
        per column), ``.parquet``: time, channels and temperature, in SI, with their units. ``.bag`` (ROS 1), ``.mcap`` and
        ``.db3`` (ROS 2): rates of a gyro and an accelerometer of three axes, or of one of them, as ``sensor_msgs/Imu`` on
        ``/imu``, the temperature on ``/imu/temperature``; the first stamp is 1 700 000 000 s.
    model, duration, rate, rng, imperfections
        As for `simulate`. Read a log of increments or accumulated output with the same `input`.
    flicker : {"poles", "exact"}
        Generator of bias instability: a bank of poles, whose Allan deviation is within 0.002 % of the exact one up to a
        third of the record; or exact, which keeps all samples of channels with bias instability in memory.
    unobserved : {"absent", "mean", "upper-limit"}
        As for `simulate`. `Simulated.unobserved` states how the file includes them.
    chunk : int
        Samples generated at a time. The file does not depend on it.
    progress : callable, optional
        Called after each chunk with the share done, 0 to 1.

    Returns
    -------
    Simulated

    Raises
    ------
    OptionError
        As `simulate`, and for a file name of another ending.
    DataError
        If the file cannot be written, its format has no field for a channel, or a library is not installed. An
        unfinished file is removed, after an error as well as after an interruption.

    See Also
    --------
    simulate : simulates in memory.
    read : reads the file.

    Notes
    -----
    The filter of flicker noise [1]_ is (1 − z⁻¹)^(−1/2) = (1/π)·∫ x^(−1/2)·(1 − x)^(−1/2)/(1 − x·z⁻¹) dx from 0 to 1;
    by a trapezoidal rule it becomes a sum of poles that share one white noise. They start with their joint stationary
    covariance.

    References
    ----------
    .. [1] N. J. Kasdin, Proc. IEEE 83, 1995, :doi:`10.1109/5.381848`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     st.simulate_to(pathlib.Path(folder) / "log.csv", model, duration=10, rate=100, rng=1).samples
    1000
    """
    if isinstance(chunk, bool) or not isinstance(chunk, int | np.integer) or chunk < 1:
        raise OptionError(f"{{option}} must be a positive number of samples, not {chunk!r}", option="chunk")
    task = job(
        model,
        duration=duration,
        rate=rate,
        rng=rng,
        imperfections=imperfections,
        flicker=flicker,
        unobserved=unobserved,
    )
    warmth = task.imperfections.temperature
    columns = [("time", "s"), *((name, task.unit(name)) for name in model.channels)]
    if warmth is not None:
        columns.append(("temperature", CELSIUS))
    target = Path(path)
    written = 0
    threads = max(1, min(len(model.channels), os.cpu_count() or 1))
    with table_writer(target, columns) as put, ThreadPoolExecutor(threads) as pool:
        channels = [Channel(task, name) for name in model.channels]
        stamps = Stamps(task)
        row = 0
        for start in range(0, task.n, chunk):
            size = min(chunk, task.n - start)
            pieces = list(pool.map(lambda channel, size=size: channel.next(size), channels))
            rows = len(pieces[0])
            t, present = stamps.next(rows)
            if warmth is not None:
                pieces.append(warmth.shown(task.times(row, row + rows)))
            pieces.insert(0, t)
            if present is not None:
                pieces = [piece[present] for piece in pieces]
            if len(pieces[0]):
                put(pieces)
            row += rows
            written += len(pieces[0])
            if progress is not None:
                progress((start + size) / task.n)
    return Simulated(
        path=str(target),
        channels=tuple(name for name, _ in columns[1:]),
        samples=task.n,
        lost=task.rows - written,
        rate=rate,
        seed=task.seed,
        unobserved=unobserved_texts(model, unobserved),
    )
