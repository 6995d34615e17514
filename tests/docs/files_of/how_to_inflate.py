"""Files of docs/how-to/inflate.md."""

from pathlib import Path

from filter_runs import write_innovations

MODEL = """\
[channels.gyro_x]
random_walk = "0.34 deg/sqrt(h)"
rate_random_walk = "41 deg/h/sqrt(h)"
"""

REST = """\
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
bias_instability = "6 deg/h"

[channels.accel_z]
random_walk = "120 ug/sqrt(Hz)"
bias_instability = "40 ug"
"""


def make(folder: Path) -> None:
    """Models at rest and with running motors; innovations of a filter whose K is a third of the true one."""
    write_innovations(folder / "innovations.csv", {"gyro_x": ("nu_gyro_x", "S_gyro_x")}, walk=1e-5)
    (folder / "imu.toml").write_text(MODEL)
    (folder / "rest.toml").write_text(REST)
    (folder / "running.toml").write_text(REST.replace("0.3 deg", "0.9 deg").replace("120 ug", "1200 ug"))
