"""What the files for VIO and LIO say, by a YAML parser and each program's own rule; and a stand-in for GTSAM."""

import sys
import types

import numpy as np
from ruamel.yaml import YAML

CONTINUOUS = ("kalibr", "openvins", "euroc", "orb-slam3", "lio-sam", "okvis2", "cuvslam")
DISCRETE = ("vins", "fast-lio")
YAMLS = (*CONTINUOUS, *DISCRETE)

# Files as Kalibr and imu_utils write them
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
    """By a real parser; OpenCV's own first line, which is no YAML, is taken off as OpenCV does."""
    yaml = YAML(typ="safe", pure=True)
    yaml.version = version
    return yaml.load(text.removeprefix("%YAML:1.0\n"))


def keys_of(target, content):
    """acc noise, gyro noise, acc walk, gyro walk, as the file has them."""
    if target == "openvins":
        content = content["imu0"]
    if target in ("kalibr", "openvins", "euroc"):
        names = [f"{s}_{k}" for k in ("noise_density", "random_walk") for s in ("accelerometer", "gyroscope")]
    elif target == "orb-slam3":
        names = ["IMU.NoiseAcc", "IMU.NoiseGyro", "IMU.AccWalk", "IMU.GyroWalk"]
    elif target == "lio-sam":
        content, names = content["lio_sam"], ["imuAccNoise", "imuGyrNoise", "imuAccBiasN", "imuGyrBiasN"]
    elif target == "okvis2":
        content, names = content["imu_parameters"], ["sigma_a_c", "sigma_g_c", "sigma_aw_c", "sigma_gw_c"]
    elif target == "cuvslam":
        content = content["/**"]["ros__parameters"]
        names = ["accel_noise_density", "gyro_noise_density", "accel_random_walk", "gyro_random_walk"]
    elif target == "basalt":  # x, y and z in arrays
        content = {key: value[0] for key, value in content["value0"].items() if isinstance(value, list)}
        names = [f"{sensor}_{kind}_std" for kind in ("noise", "bias") for sensor in ("accel", "gyro")]
    elif target == "vins":
        names = ["acc_n", "gyr_n", "acc_w", "gyr_w"]
    elif target == "fast-lio":
        content, names = content["mapping"], ["acc_cov", "gyr_cov", "b_acc_cov", "b_gyr_cov"]
    else:
        raise KeyError(f"the keys of {target} are missing in keys_of of tests/vio.py")
    assert all(type(content[name]) is float for name in names)
    return [content[name] for name in names]


def in_si(target, values, rate):
    """N of accelerometers and gyros, K of both, by the convention of the target's keys."""
    if target == "vins":
        return [v / np.sqrt(2 * rate) for v in values[:2]] + [v / np.sqrt(rate) for v in values[2:]]
    if target == "fast-lio":
        return [np.sqrt(v / rate) for v in values]
    return values


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
    """What the module written for GTSAM sets, run with a GTSAM that only remembers."""
    fake = types.ModuleType("gtsam")
    fake.PreintegrationCombinedParams = _Params
    monkeypatch.setitem(sys.modules, "gtsam", fake)
    space = {}
    exec(compile(text, "imu.py", "exec"), space)
    return space["params"]()


def target_needs_rate(name):
    from sigmatau.exporting.targets import target

    return target(name).needs_rate
