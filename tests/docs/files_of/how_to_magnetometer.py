"""Files of docs/how-to/magnetometer.md."""

from pathlib import Path

from other_sensors import write_log

_NOISE = {"random_walk": 2e-9, "bias_instability": 3e-10}


def make(folder: Path) -> None:
    """A magnetometer in teslas, as ROS has it, in the field of the Earth."""
    fields = {"mag_x": 19.8e-6, "mag_y": -1.2e-6, "mag_z": 43.5e-6}
    write_log(
        folder / "mag.csv", {name: (_NOISE, level) for name, level in fields.items()}, unit="T", seconds=3600, rate=20
    )
