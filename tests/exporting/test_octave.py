"""The script written for MATLAB run by Octave, where that is installed, with stand-ins for the toolbox's classes."""

import shutil
import subprocess

import numpy as np
import pytest

from sigmatau import NoiseModel
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export

OCTAVE = shutil.which("octave-cli")
pytestmark = pytest.mark.skipif(OCTAVE is None, reason="octave-cli is not installed")

N = {"gyro": (1.1e-4, 3.7e-4, 2.9e-4), "accel": (1.3e-3, 0.9e-3, 2.2e-3)}
B = {"gyro": (2.1e-5, 3.1e-5, 1.7e-5), "accel": (3.3e-4, 4.1e-4, 2.9e-4)}
K = {"gyro": (3.1e-6, 1.7e-6, 2.9e-6), "accel": (3.3e-5, 8.9e-5, 2.2e-5)}
STAND_INS = {
    "gyroparams": "function p = gyroparams()\n  p = struct();\nend\n",
    "accelparams": "function p = accelparams()\n  p = struct();\nend\n",
    "fractalcoef": "function c = fractalcoef(poles)\n  c = poles;\nend\n",
    "imuSensor": "function s = imuSensor(kind, varargin)\n  s = struct(varargin{:});\n  s.kind = kind;\nend\n",
}
ROW = "printf('%s', '{0}'); printf(' %.17g', imu.{1}.{2}); printf('\\n');\n"


def test_its_objects_hold_the_model(tmp_path):
    channels = {
        f"{s}_{a}": {"random_walk": N[s][i], "bias_instability": B[s][i], "rate_random_walk": K[s][i]}
        for s in N
        for i, a in enumerate("xyz")
    }
    export(
        NoiseModel(channels=channels),
        to="matlab",
        path=tmp_path / "imu_noise.m",
        choices=Choices(axes="each", filter_rate=217.3),
    )
    for name, text in STAND_INS.items():
        (tmp_path / f"{name}.m").write_text(text)
    fields = {"NoiseDensity": N, "BiasInstability": B, "RandomWalk": K}
    names = {"gyro": "Gyroscope", "accel": "Accelerometer"}
    rows = "".join(ROW.format(f"{s} {field}", names[s], field) for s in names for field in fields)
    (tmp_path / "show_it.m").write_text(f"imu_noise\n{rows}printf('rate %.17g\\n', imu.SampleRate);\n")
    ended = subprocess.run(
        [OCTAVE, "--no-init-file", "--quiet", "show_it.m"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 0, ended.stderr
    found = {line.rsplit(maxsplit=3)[0]: line.split()[2:] for line in ended.stdout.splitlines() if "rate" not in line}
    for sensor in names:
        for field, expected in fields.items():
            got = np.array(found[f"{sensor} {field}"], dtype=float)
            np.testing.assert_allclose(got, expected[sensor], rtol=1e-12)
    assert float(ended.stdout.splitlines()[-1].split()[1]) == 217.3
