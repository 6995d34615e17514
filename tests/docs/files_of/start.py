"""The file of docs/start.md."""

from pathlib import Path

import sigmatau as st
from known import seed_of


def make(folder: Path) -> None:
    """A log of six axes at rest."""
    axes = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    model = st.NoiseModel(channels={axis: {"random_walk": 1e-4, "rate_random_walk": 1e-6} for axis in axes})
    st.write(st.simulate(model, duration=900, rate=20, rng=seed_of("docs/start.md")), folder / "static.csv")
