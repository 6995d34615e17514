"""The noisiest and the quietest existing gyros and accelerometers, as limits of the noise of a sensor."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sigmatau.frozen import frozen
from sigmatau.units import STANDARD_GRAVITY

_DEGREE = math.pi / 180


@frozen
class SensorClass:
    """Coefficients of the noisiest sensors by term, and the random walk of the quietest. [SI]"""

    noisiest: Mapping[str, float]
    quietest: float


SENSOR_CLASSES: dict[str, SensorClass] = {
    # Random walk: datasheets of the first MEMS gyros have 0.1 (deg/s)/√Hz; later consumer gyros have 0.004 to 0.03.
    # Bias instability and rate random walk: several times those of the noisiest MEMS in studies/rest_windows.py, 200
    # deg/h and 300 deg/h/√h. Ramp: a warm-up of 1 deg/s within 100 s. Quietest: the fibre-optic rotational seismometer
    # blueSeis-3A, 20 nrad/s/√Hz (F. Bernauer et al., Seismol. Res. Lett. 89, 2018, doi:10.1785/0220170143).
    "angular_rate": SensorClass(
        noisiest={
            "random_walk": 0.1 * _DEGREE,
            "bias_instability": 0.1 * _DEGREE,
            "rate_random_walk": _DEGREE / 60,
            "rate_ramp": 0.01 * _DEGREE,
        },
        quietest=20e-9,
    ),
    # Random walk: datasheets of consumer accelerometers have up to 1 mg/√Hz, and 1.5 mg/√Hz at low power. Bias
    # instability: 2 mg, twice the noisiest. Ramp: a warm-up of 50 mg within 100 s. Quietest: 3 ng/√Hz of a seismic
    # piezoelectric accelerometer at 100 Hz, 37 ng/√Hz at 1 Hz (F. A. Levinzon, in Earthquakes, InTech 2017,
    # doi:10.5772/65925).
    "acceleration": SensorClass(
        noisiest={"random_walk": 0.015, "bias_instability": 0.02, "rate_random_walk": 0.002, "rate_ramp": 0.005},
        quietest=3e-9 * STANDARD_GRAVITY / math.sqrt(2),  # two-sided density
    ),
}
