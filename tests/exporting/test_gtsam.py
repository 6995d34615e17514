"""The module written for GTSAM in GTSAM itself, where that is installed (``pip install gtsam``)."""

import runpy

import numpy as np
import pytest

from sigmatau import NoiseModel, TurnOn
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export


@pytest.fixture
def gtsam():
    """Imported by these tests alone."""
    return pytest.importorskip("gtsam")


N = {"gyro": (1.1e-4, 3.7e-4, 2.9e-4), "accel": (1.3e-3, 0.9e-3, 2.2e-3)}
K = {"gyro": (3.1e-6, 1.7e-6, 2.9e-6), "accel": (3.3e-5, 8.9e-5, 2.2e-5)}
STEP, STEPS = 0.005, 400


@pytest.fixture
def params(gtsam, tmp_path):
    model = NoiseModel(
        channels={
            f"{s}_{a}": {"random_walk": N[s][i], "rate_random_walk": K[s][i]} for s in N for i, a in enumerate("xyz")
        }
    )
    export(model, to="gtsam", path=tmp_path / "imu.py", choices=Choices(axes="each"))
    return runpy.run_path(str(tmp_path / "imu.py"))["params"]()


def test_it_takes_the_models_densities(params):
    held = {
        "gyro": (params.getGyroscopeCovariance(), params.getBiasOmegaCovariance()),
        "accel": (params.getAccelerometerCovariance(), params.getBiasAccCovariance()),
    }
    for sensor, (noise, walk) in held.items():
        np.testing.assert_allclose(noise, np.diag(np.square(N[sensor])), rtol=1e-12)
        np.testing.assert_allclose(walk, np.diag(np.square(K[sensor])), rtol=1e-12)


def test_its_preintegration_has_the_models_covariance(gtsam, params):
    """At rest for 2 s: N²T + K²T³/3 of each angle, K²T of each bias, N²T + (gN)²T³/3 of a level velocity."""
    measured = gtsam.PreintegratedCombinedMeasurements(params, gtsam.imuBias.ConstantBias())
    for _ in range(STEPS):
        measured.integrateMeasurement(np.array([0.0, 0.0, 9.80665]), np.zeros(3), STEP)
    variances, t = np.diag(measured.preintMeasCov()), STEP * STEPS  # angle, position, velocity, biases
    gyro, accel = (np.square(N[s]) for s in ("gyro", "accel"))
    # Sums of steps, whose ends are off by 1.5 steps at most: T³ by 1.5·3·STEP/T.
    np.testing.assert_allclose(variances[:3], gyro * t + np.square(K["gyro"]) * t**3 / 3, rtol=1e-3)
    np.testing.assert_allclose(variances[9:12], np.square(K["accel"]) * t, rtol=1e-9)
    np.testing.assert_allclose(variances[12:], np.square(K["gyro"]) * t, rtol=1e-9)
    level = accel[:2] * t + 9.80665**2 * gyro[[1, 0]] * t**3 / 3
    np.testing.assert_allclose(variances[6:8], level, rtol=4.5 * STEP / t)


def test_its_prior_has_the_turn_on_bias(gtsam, tmp_path):
    """In the order of a ConstantBias, which a prior on the first bias takes."""
    sigmas = {"gyro": (1e-3, 2e-3, 3e-3), "accel": (0.1, 0.2, 0.3)}
    model = NoiseModel(
        channels={
            f"{s}_{a}": {"random_walk": N[s][i], "rate_random_walk": K[s][i]} for s in N for i, a in enumerate("xyz")
        }
    ).with_turn_on({f"{s}_{a}": TurnOn(sigma=sigmas[s][i]) for s in N for i, a in enumerate("xyz")})
    export(model, to="gtsam", path=tmp_path / "imu.py", choices=Choices(axes="each"))
    prior = runpy.run_path(str(tmp_path / "imu.py"))["prior"]()
    np.testing.assert_allclose(prior.sigmas(), [*sigmas["accel"], *sigmas["gyro"]], rtol=1e-12)
    bias = gtsam.imuBias.ConstantBias(np.array(sigmas["accel"]), np.array(sigmas["gyro"]))
    factor = gtsam.PriorFactorConstantBias(0, gtsam.imuBias.ConstantBias(), prior)
    values = gtsam.Values()
    values.insert(0, bias)
    assert factor.error(values) == pytest.approx(6 / 2)  # one sigma of each
