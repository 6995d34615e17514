"""Files of docs/how-to/formats.md."""

from pathlib import Path

import numpy as np
import zarr
from benches.logs import CHANNELS, KINDS, START, made

from page_records import index_model, simulated

_ROWS = 4400
_MADE = (
    *("CSV", "CSV, decimal comma", "VectorNav ASCII", "ROS 2 db3", "ROS 1 bag, lz4", "PX4 ULog", "ArduPilot DataFlash"),
    *("LVM of LabVIEW", "names with values", "JSON lines", "ros2 topic echo, YAML", "ros2 topic echo, CSV", "Excel"),
    *("MATLAB 5", "HDF5, fletcher32", "Parquet, page checksums", "LabVIEW TDMS", "NumPy .npy", "raw binary"),
)


def make(folder: Path) -> None:
    """Twenty-two seconds of one sensor at 200 Hz, in many formats."""
    stamps, _ = made(_ROWS)
    record = simulated("how-to: formats", index_model(folder / "imu.toml"), seconds=_ROWS / 200, rate=200)
    values = np.stack([record.stream_of(name).column(name) for name in CHANNELS], axis=1)
    values[:, 5] += 9.80665
    values = values.astype(np.float32).astype(np.float64)
    for kind in _MADE:
        path = KINDS[kind].make(folder, stamps, values)
        if kind == "ROS 2 db3":
            path.parent.rename(folder / "rec")
    rows = np.column_stack([(stamps - START) * 1e-9, np.degrees(values[:, :3]), values[:, 3:] / 9.80665])
    np.savetxt(folder / "imu.txt", rows, fmt="%.9g")
    np.savetxt(folder / "names.csv", values, fmt="%.9g", delimiter=",", header="wx,wy,wz,ax,ay,az", comments="")
    text = (folder / "log.csv").read_text()
    (folder / "lab.txt").write_text("".join(f"{k},{k}\n" for k in range(3)) + text)
    root = zarr.open_group(str(folder / "log.zarr"), mode="w", attributes={"rate": 200.0})
    for k, name in enumerate(CHANNELS):
        unit = {"unit": "rad/s" if k < 3 else "m/s^2"}
        root.create_array(name, shape=(_ROWS,), chunks=(260,), dtype="f8", attributes=unit)[:] = values[:, k]
    data = (folder / "log.bag").read_bytes()
    (folder / "cut.bag").write_bytes(data[: len(data) // 2])
