"""Files of docs/how-to/gaps.md."""

from pathlib import Path

import numpy as np

from known import seed_of
from page_records import index_model, lossy, some

ROWS, RATE = 6000, 100


def make(folder: Path) -> None:
    """A log with losses, and short ones with one fault of the time stamps each."""
    lossy(folder / "gaps.csv", "how-to: gaps", some(index_model(folder / "imu.toml"), "gyro_x"), seconds=3600, rate=50)
    rng = np.random.default_rng(seed_of("how-to: stamps"))
    rates, times = 1e-3 * rng.standard_normal(ROWS), np.arange(ROWS) / RATE
    _table(folder / "jitter.csv", times + rng.normal(0, 5e-4, ROWS), rates)
    _table(folder / "host.csv", np.sort(np.repeat(times[::8] + 0.08, 8) + rng.exponential(2e-4, ROWS)), rates)
    _table(folder / "pause.csv", times + 7200 * (np.arange(ROWS) >= 2000), rates)
    twice = 1 + (np.arange(ROWS) % 50 == 7)
    _table(folder / "twice.csv", np.repeat(times, twice), np.repeat(rates, twice))
    slower = np.concatenate([times[:3000], times[2999] + np.arange(1, 3001) * 2 / RATE])
    _table(folder / "change.csv", slower, rates)
    empty = rates.copy()
    empty[500:520] = np.nan
    _table(folder / "empty.csv", times, empty)


def _table(path: Path, times: np.ndarray, rates: np.ndarray) -> None:
    rows = (
        f"{t:.6f},{'' if np.isnan(x) else f'{x:.9g}'}\n" for t, x in zip(times.tolist(), rates.tolist(), strict=True)
    )
    path.write_text("time [s],gyro_x [rad/s]\n" + "".join(rows), encoding="utf-8")
