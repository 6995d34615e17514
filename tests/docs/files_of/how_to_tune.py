"""Files of docs/how-to/tune.md."""

from pathlib import Path

from filter_runs import write_innovations, write_joint_innovations, write_turning_innovations

MODEL = """\
[channels.gyro_x]
random_walk = "0.34 deg/sqrt(h)"
rate_random_walk = "41 deg/h/sqrt(h)"

[channels.accel_x]
random_walk = "0.03 m/s/sqrt(h)"
rate_random_walk = "50 ug/sqrt(h)"
"""


def make(folder: Path) -> None:
    """Innovations of a filter whose K is a third of the true one, in motion, and with two sensors; its model."""
    write_innovations(folder / "innovations.csv", {"gyro_x": ("nu_gyro_x", "S_gyro_x")}, walk=1e-5)
    write_turning_innovations(folder / "turning.csv")
    write_joint_innovations(folder / "aided.csv")
    (folder / "imu.toml").write_text(MODEL)
