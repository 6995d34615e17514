"""Each target's own propagation, fed with the file that was written, gives the covariance of the model's simulated noise.

The propagations are those of the targets' sources, on one axis at rest: position, velocity (or angle) and bias. Where a
target keeps the bias out of its preintegration (ORB-SLAM3, GTSAM without combined factor, as LIO-SAM uses it), the noise and
the bias are compared apart, as it uses them.
"""

import numpy as np
import pytest

import vio
from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.targets import NAMES, target

RATE, STEPS, RUNS = 100.0, 100, 20_000
DT, TIME = 1 / RATE, STEPS / RATE
N = {"accel": 2e-3, "gyro": 1e-3}
K = {"accel": 3.1e-3, "gyro": 2.3e-3}  # so large that after a second the walk makes half of the variance
MODEL = NoiseModel(channels={s: {"random_walk": N[s], "rate_random_walk": K[s]} for s in N})


def written(name, monkeypatch):
    """By sensor the numbers for noise and walk, as the target's file has them."""
    text = export(MODEL, to=name, choices=Choices(filter_rate=RATE))
    if name == "gtsam":
        made = vio.gtsam_params(text, monkeypatch)
        keys = ("AccelerometerCovariance", "GyroscopeCovariance", "BiasAccCovariance", "BiasOmegaCovariance")
        acc_n, gyr_n, acc_w, gyr_w = (float(made.set[key][0, 0]) for key in keys)
    else:
        acc_n, gyr_n, acc_w, gyr_w = vio.keys_of(name, vio.parse(text))
    return {"accel": (acc_n, acc_w), "gyro": (gyr_n, gyr_w)}


def propagate(f, q):
    p = np.zeros((3, 3))
    for _ in range(STEPS):
        p = f @ p @ f.T + q
    return p


def transition(*, coupled, square):
    """Of position, velocity and bias; `square` where the position takes half an acceleration over the step."""
    f = np.eye(3)
    f[0, 1] = DT
    if coupled:
        f[1, 2], f[0, 2] = -DT, -(DT**2) / 2 if square else 0.0
    return f


def vins(n, w):
    """integration_base.h, midPointIntegration: V has the noise at both ends of the step with half weights."""
    v = np.zeros((3, 3))  # noise at the beginning, at the end, and of the bias
    v[0, :2], v[1, :2], v[2, 2] = DT**2 / 4, DT / 2, DT
    return propagate(transition(coupled=True, square=True), v @ np.diag([n**2, n**2, w**2]) @ v.T)


def fast_lio(n, w):
    """esekfom.hpp, predict: F P Fᵀ + (dt·F_w) Q (dt·F_w)ᵀ; no noise in the position."""
    f_w = np.array([[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    return propagate(transition(coupled=True, square=False), (DT * f_w) @ np.diag([n, w]) @ (DT * f_w).T)


def orb_slam3(n, w):
    """Tracking.cc makes the numbers discrete, ImuTypes.cc IntegrateNewMeasurement adds B·Nga·Bᵀ, and NgaWalk apart."""
    root = np.sqrt(RATE)
    nga, nga_walk = (n * root) ** 2, (w / root) ** 2
    b = np.array([DT**2 / 2, DT, 0.0])
    return propagate(transition(coupled=False, square=True), nga * np.outer(b, b) + np.diag([0.0, 0.0, nga_walk]))


def gtsam_parts(covariance):
    b = np.array([DT**2 / 2, DT, 0.0])
    return covariance / DT * np.outer(b, b)


def lio_sam(n, w):
    """ImuFactor with imuAccNoise², divided by dt; between key frames a bias factor of √Δt·imuAccBiasN."""
    p = propagate(transition(coupled=False, square=True), gtsam_parts(n**2))
    p[2, 2] = (np.sqrt(TIME) * w) ** 2
    return p


def gtsam(n, w):
    """CombinedImuFactor: the bias is part of the state, its covariance multiplied by dt."""
    return propagate(transition(coupled=True, square=True), gtsam_parts(n) + np.diag([0.0, 0.0, w * DT]))


def okvis2(n, w):
    """ImuError.cpp, append: dt·σ² of the velocity and of the bias, dt³/2·σ² of the position."""
    return propagate(transition(coupled=False, square=True), np.diag([0.5 * DT**3 * n**2, DT * n**2, DT * w**2]))


def basalt(n, w):
    """preintegration.h adds A·cov·Aᵀ with cov = n²·imu_update_rate; the bias has the weight 1/(w·√Δt)."""
    b = np.array([DT**2 / 2, DT, 0.0])
    p = propagate(transition(coupled=False, square=True), n**2 * RATE * np.outer(b, b))
    p[2, 2] = w**2 * TIME
    return p


def cuvslam(n, w):
    """imu_preintegration.cpp, update_state: B·n²·f·Bᵀ, and w²/f with each sample."""
    b = np.array([DT**2 / 2, DT, 0.0])
    return propagate(
        transition(coupled=False, square=True), n**2 * RATE * np.outer(b, b) + np.diag([0.0, 0.0, w**2 / RATE])
    )


# the propagation, whether the bias is in it, and whether samples are averaged two by two
TARGETS = {
    "vins": (vins, True, True),
    "fast-lio": (fast_lio, True, True),
    "orb-slam3": (orb_slam3, False, False),
    "lio-sam": (lio_sam, False, False),
    "gtsam": (gtsam, True, False),
    "okvis2": (okvis2, False, True),
    "basalt": (basalt, False, False),
    "cuvslam": (cuvslam, False, False),
}


ELSEWHERE = {
    "kalibr": "calibrates by batch optimisation; its rule is the definition of the densities",
    "openvins": "takes the numbers of Kalibr: N²/dt and K²·dt",
    "euroc": "a file of data sets, in the convention of Kalibr",
    "px4": "tests/exporting/test_export_autopilots.py propagates its filter",
    "ardupilot": "tests/exporting/test_export_autopilots.py propagates its filter",
}
"""Targets with N and K without a propagation here, and why."""


def test_every_target_with_a_walk_is_propagated():
    with_walk = {name for name in NAMES if target(name).has_walk}
    assert with_walk == TARGETS.keys() | ELSEWHERE.keys(), "add the propagation of the new target to TARGETS"


def simulated(sensor, *, coupled, midpoint, square):
    """Covariance of position, velocity and bias after a second, and how many runs it is of."""
    seed = seed_of(f"vio propagation {sensor}")
    parts = {f"{sensor}_x": {"random_walk": N[sensor]}, f"{sensor}_y": {"rate_random_walk": K[sensor]}}
    record = simulate(NoiseModel(channels=parts), duration=(RUNS + 1) * TIME, rate=RATE, rng=seed)
    noise, bias = (record.stream_of(name).column(name) for name in parts)
    begin = np.arange(RUNS)[:, None] * STEPS
    drift = bias[begin + np.arange(STEPS + 1)] - bias[begin]
    error = noise[begin + np.arange(STEPS + 1)] - (drift if coupled else 0.0)
    rate = (error[:, :-1] + error[:, 1:]) / 2 if midpoint else error[:, :-1]
    velocity = DT * np.cumsum(rate, axis=1)
    before = np.concatenate([np.zeros((RUNS, 1)), velocity[:, :-1]], axis=1)
    position = DT * (before + (DT / 2 * rate if square else 0.0)).sum(axis=1)
    return np.cov(np.stack([position, velocity[:, -1], drift[:, -1]]), bias=True)


@pytest.mark.parametrize("sensor", N)
@pytest.mark.parametrize("name", TARGETS)
def test_covariance_is_that_of_the_simulated_model(name, sensor, monkeypatch):
    """Within three standard errors of a covariance of normal numbers, and 1.5 % that the rules of integration differ by:
    averaging two samples loses half a sample at either end of a second's hundred, and delays the bias by half a step.
    """
    rule, coupled, midpoint = TARGETS[name]
    expected = rule(*written(name, monkeypatch)[sensor])
    got = simulated(sensor, coupled=coupled, midpoint=midpoint, square=name != "fast-lio")
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    error = np.sqrt((size**2 + expected**2) / RUNS)
    limit = 3 * error + (1.5 / STEPS if midpoint else 0.0) * size
    assert (np.abs(got - expected) <= limit).all(), (got - expected) / error
    assert got[1, 1] == pytest.approx(expected[1, 1], rel=0.1)


@pytest.mark.parametrize("sensor", N)
@pytest.mark.parametrize("name", TARGETS)
def test_angle_velocity_and_bias_in_closed_form(name, sensor, monkeypatch):
    """White noise alone gives N²·T and N²·T³/3, a walk alone K²·T; exact where there is nothing to be discretised."""
    rule, _, _ = TARGETS[name]
    noise, walk = written(name, monkeypatch)[sensor]
    white, slow = rule(noise, 0.0), rule(0.0, walk)
    assert white[1, 1] == pytest.approx(N[sensor] ** 2 * TIME, rel=1e-12)
    assert white[0, 0] == pytest.approx(N[sensor] ** 2 * TIME**3 / 3, rel=2 / STEPS)
    assert white[2, 2] == 0
    assert slow[2, 2] == pytest.approx(K[sensor] ** 2 * TIME, rel=1e-12)


def test_the_common_number_for_vins_gives_half_the_covariance(monkeypatch):
    n, _ = written("vins", monkeypatch)["gyro"]
    common = N["gyro"] * np.sqrt(RATE)
    assert n == pytest.approx(np.sqrt(2) * common, rel=1e-12)
    np.testing.assert_allclose(2 * vins(common, 0.0), vins(n, 0.0), rtol=1e-12)
    assert vins(common, 0.0)[1, 1] == pytest.approx(N["gyro"] ** 2 * TIME / 2, rel=1e-12)


@pytest.mark.parametrize("per_scan", [3, 20])
def test_fast_lio_splits_a_sample_at_the_end_of_a_scan(per_scan):
    """IMU_Processing.hpp, UndistortPcl: from the last sample to the end of the scan, and from there to the next sample."""
    scan = per_scan * DT * 1.000731  # so that the ends fall anywhere between samples
    scans = 4000
    samples = DT * np.arange(int(scans * scan / DT) + 2)
    ends = scan * np.arange(1, scans + 1)
    variance = 0.0
    for begin, end in zip(np.concatenate([[0.0], ends[:-1]]), ends, strict=True):
        inside = samples[np.searchsorted(samples, begin, "right") : np.searchsorted(samples, end, "right")]
        variance += RATE * np.square(np.diff([begin, *inside, end])).sum()  # N = 1: variances N²·f·dt²
    # Ends move by 0.07 % of a scan and cover all places between two samples evenly.
    assert variance / ends[-1] == pytest.approx((per_scan - 1 / 3) / per_scan, rel=2e-3)
