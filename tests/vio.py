"""Content of the files for VIO and LIO by a YAML parser and the rule of each program; and a substitute for GTSAM."""

import re
import sys
import types

import numpy as np
from ruamel.yaml import YAML

from sigmatau.exporting.targets import NAMES, target

YAMLS = tuple(name for name in NAMES if target(name).text)  # short YAML from a template
COEFFICIENTS = tuple((sensor, letter) for letter in "NK" for sensor in ("accel", "gyro"))
DENSITIES = {
    "N": lambda number, _: number,
    "K": lambda number, _: number,
    "N*sqrt(2*rate)": lambda number, rate: number / np.sqrt(2 * rate),
    "K*sqrt(rate)": lambda number, rate: number / np.sqrt(rate),
    "N^2*rate": lambda number, rate: np.sqrt(number / rate),
    "K^2*rate": lambda number, rate: np.sqrt(number / rate),
}  # meaning of a file with numbers in such a form, for a filter with a sampling rate [Hz]

# Files in the form of Kalibr and imu_utils
KALIBR = """\
#Accelerometers
accelerometer_noise_density: 1.86e-03   #Noise density (continuous-time)
accelerometer_random_walk:   4.33e-04   #Bias random walk

#Gyroscopes
gyroscope_noise_density:     1.87e-04
gyroscope_random_walk:       2.66e-05

rostopic:                    /imu0      #the IMU ROS topic
update_rate:                 200.0      #Hz (for discretization of the values above)
"""

IMU_UTILS = """\
%YAML:1.0
---
type: IMU
name: xsens
Gyr:
   unit: " rad/s"
   avg-axis:
      gyr_n: 2.0e-03
      gyr_w: 7.2e-05
   x-axis:
      gyr_n: 1.0e-03
      gyr_w: 1.8e-05
   y-axis:
      gyr_n: 2.0e-03
      gyr_w: 8.7e-05
   z-axis:
      gyr_n: 3.0e-03
      gyr_w: 1.1e-04
Acc:
   unit: " m/s^2"
   avg-axis:
      acc_n: 2.0e-02
      acc_w: 6.0e-04
   x-axis:
      acc_n: 1.0e-02
      acc_w: 4.0e-04
   y-axis:
      acc_n: 2.0e-02
      acc_w: 6.0e-04
   z-axis:
      acc_n: 3.0e-02
      acc_w: 8.0e-04
"""


def parse(text, version="1.2"):
    """Parse with a real parser; the first line of OpenCV, which is not YAML, is removed as by OpenCV."""
    yaml = YAML(typ="safe", pure=True)
    yaml.version = version
    return yaml.load(text.removeprefix("%YAML:1.0\n"))


def places_of(name):
    """Key and form of accelerometer and gyro noise, accelerometer and gyro walk, by the template of a target."""
    fields = re.findall(r"^ *([\w.]+): \{(accel|gyro) ([NK][^}]*)\}", target(name).text, flags=re.MULTILINE)
    places = {(sensor, form[0]): (key, form) for key, sensor, form in fields}
    return [places[each] for each in COEFFICIENTS]


def block_with(key, content):
    """The block of nested mappings that has a key; None if there is none."""
    if key in content:
        return content
    blocks = (block_with(key, value) for value in content.values() if isinstance(value, dict))
    return next((block for block in blocks if block is not None), None)


def keys_of(name, content):
    """Noise of accelerometer and gyro, walk of accelerometer and gyro, in this order, as in the file."""
    if name == "basalt":  # x, y and z in arrays
        content = {key: value[0] for key, value in content["value0"].items() if isinstance(value, list)}
        keys = [f"{sensor}_{kind}_std" for kind in ("noise", "bias") for sensor in ("accel", "gyro")]
    else:
        keys = [key for key, _ in places_of(name)]
    content = block_with(keys[0], content)
    assert all(type(content[key]) is float for key in keys)
    return [content[key] for key in keys]


def in_si(name, values, rate):
    """N of accelerometers and gyros, then K of both, by the convention of the keys of the target."""
    return [DENSITIES[form](value, rate) for value, (_, form) in zip(values, places_of(name), strict=True)]


class _Params:
    def __init__(self, gravity):
        self.gravity, self.set = gravity, {}

    @classmethod
    def MakeSharedU(cls, gravity):  # noqa: N802  GTSAM's name
        return cls(gravity)

    def __getattr__(self, name):
        if not name.startswith("set") or name == "setBiasAccOmegaInt":
            raise AttributeError(name)
        return lambda value: self.set.__setitem__(name[3:], value)


def gtsam_params(text, monkeypatch):
    """Settings of the module written for GTSAM, run with a GTSAM that only records them."""
    fake = types.ModuleType("gtsam")
    fake.PreintegrationCombinedParams = _Params
    monkeypatch.setitem(sys.modules, "gtsam", fake)
    space = {}
    exec(compile(text, "imu.py", "exec"), space)
    return space["params"]()
