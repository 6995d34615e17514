"""Values of records for tests of reading."""

import numpy as np


def axes(record, *sensors):
    """Axes of these sensors as columns."""
    names = [f"{sensor}_{axis}" for sensor in sensors for axis in "xyz"]
    return np.stack([record.stream_of(name).column(name) for name in names], axis=1)


def six(record):
    return axes(record, "gyro", "accel")
