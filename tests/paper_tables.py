"""Tables I and III of the paper: quantization of three gyros over seven days; doi 10.1109/TIM.2007.908635. [arcsec]"""

import numpy as np

TABLE_I = np.array(
    [
        [0.973, 0.517, 0.577],
        [0.960, 0.536, 0.602],
        [0.919, 0.506, 0.575],
        [0.947, 0.498, 0.569],
        [0.958, 0.499, 0.559],
        [0.959, 0.507, 0.562],
        [0.945, 0.507, 0.579],
    ]
)
TABLE_III = np.array(
    [
        [5.115, 1.274, 1.232],
        [5.112, 1.284, 1.203],
        [5.111, 1.280, 1.223],
        [5.124, 1.307, 1.226],
        [5.031, 1.286, 1.219],
        [5.105, 1.305, 1.207],
        [5.049, 1.295, 1.223],
    ]
)
SAMPLES = {"I": 1_440_000, "III": 720_000}  # numbers of samples: two hours at 200 and 100 Hz
DELTAS = {"I": (0.074, 0.020, 0.016), "III": (0.068, 0.0032, 0.0028)}  # ± of Tables II and IV [arcsec]


def relative_errors(values, samples):
    """Relative error of a fit to `samples` samples and of rounding to three decimals."""
    return np.sqrt(1 / (2 * samples) + (0.0005 / np.sqrt(3) / values) ** 2)


def csv_of(table):
    """The table as typed by a user."""
    values = {"I": TABLE_I, "III": TABLE_III}[table]
    lines = ["run,channel,term,value,unit,error_percent,plus_minus"]
    for day, row in enumerate(values, 1):
        for axis, value, delta in zip("xyz", row, DELTAS[table], strict=True):
            percent = 100 * relative_errors(value, SAMPLES[table])
            lines.append(f"{day},gyro_{axis},quantization,{value:.3f},arcsec,{percent:.5f},{delta if day == 1 else ''}")
    return "\n".join(lines) + "\n"
