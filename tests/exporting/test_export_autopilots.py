"""PX4 and ArduPilot: files read as those programs read them, and their propagation run on what was read."""

import math
import re

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.model.noise_model import NoiseModel

# Half a unit of the last place of single precision, in which both keep their parameters.
SINGLE = 2.0**-24

N, K = {"gyro": 8.7e-5, "accel": 1.3e-3}, {"gyro": 1.6e-6, "accel": 2.4e-5}


def model(**gyro_x):
    channels = {}
    for sensor in ("gyro", "accel"):
        for axis, size in (("x", 1.0), ("y", 0.8), ("z", 0.6)):
            channels[f"{sensor}_{axis}"] = {"random_walk": size * N[sensor], "rate_random_walk": size * K[sensor]}
    channels["gyro_x"] |= gyro_x
    return NoiseModel(channels=channels)


def qgroundcontrol(text):
    """As QGroundControl reads them: lines of five cells between tabs; those that begin with # are skipped."""
    found = {}
    for line in text.splitlines():
        if line.startswith("#") or not line.strip():
            continue
        vehicle, component, name, value, kind = line.split("\t")
        assert (int(vehicle), int(component)) == (1, 1)
        assert int(kind) == 9  # MAV_PARAM_TYPE_REAL32
        assert len(name) <= 16  # MAVLink's room for a name
        found[name] = float(np.float32(value))
    return found


def mavproxy(text):
    """As MAVProxy and Mission Planner read them: a name and a value, between them a comma or blanks."""
    found = {}
    for line in text.splitlines():
        line = line.strip()
        if not line or line[0] == "#":
            continue
        name, value = line.replace(",", " ").split()
        assert len(name) <= 16
        found[name] = float(np.float32(value))
    return found


STEP = {"px4": 0.01, "ardupilot": 0.0125}  # of their filters, s

CASES = {
    "px4": (qgroundcontrol, ("EKF2_GYR_NOISE", "EKF2_ACC_NOISE", "EKF2_GYR_B_NOISE", "EKF2_ACC_B_NOISE")),
    "ardupilot": (mavproxy, ("EK3_GYRO_P_NSE", "EK3_ACC_P_NSE", "EK3_GBIAS_P_NSE", "EK3_ABIAS_P_NSE")),
}


def read(target, **choices):
    parse, names = CASES[target]
    found = parse(export(model(), to=target, choices=Choices(**choices)))
    assert sorted(found) == sorted(names)
    return [found[name] for name in names]


@pytest.mark.parametrize("step", [None, 0.01, 0.004])
@pytest.mark.parametrize("target", CASES)
def test_values_in_si_are_the_models(target, step):
    dt = step or STEP[target]
    expected = [N["gyro"], N["accel"], K["gyro"], K["accel"]]
    assert [p * math.sqrt(dt) for p in read(target, step=step)] == pytest.approx(expected, rel=1.01 * SINGLE)


@pytest.mark.parametrize("target", CASES)
def test_mean_of_axes_and_factors(target):
    rms = math.sqrt((1 + 0.64 + 0.36) / 3)
    found = read(target, axes="mean", noise_factor=2.0, walk_factor=3.0)
    expected = [2 * rms * N["gyro"], 2 * rms * N["accel"], 3 * rms * K["gyro"], 3 * rms * K["accel"]]
    assert [p * math.sqrt(STEP[target]) for p in found] == pytest.approx(expected, rel=1.01 * SINGLE)


def propagate(target, p_noise, p_bias, dt, steps):
    """Variances of the angle that white noise alone makes, and of the bias [rate], by the code of each filter."""
    f4 = np.float32
    angle = bias = 0.0
    for _ in range(steps):
        # Both: d_ang_var = sq(dt * gyro_noise), of each prediction.
        angle += float((f4(dt) * f4(p_noise)) ** 2)
        if target == "px4":  # the state is the bias: sq(dt * gyro_bias_p_noise)
            bias += float((f4(dt) * f4(p_bias)) ** 2)
        else:  # the state is the bias times dt: sq(sq(dt) * _gyroBiasProcessNoise)
            bias += float((f4(dt) ** 2 * f4(p_bias)) ** 2) / dt**2
    return angle, bias


def step_of_ardupilot(loop_rate):
    """readIMUData: loops are summed until EKF_TARGET_DT, 12 ms, less half a loop is reached. [s]"""
    dt, summed = 1 / loop_rate, 0.0
    while True:
        summed += dt
        if summed >= 0.012 - 0.5 * dt:
            return summed


def test_step_of_ardupilot_is_that_of_its_loop():
    """What the head of the file says of loop rates."""
    (words,) = [line for line in export(model(), to="ardupilot").splitlines() if "SCHED_LOOP_RATE" in line]
    found = re.search(r"a filter step of 12.5 ms. .* SCHED_LOOP_RATE: ([\d.]+) ms at (\d+) Hz, (.*); set it", words)
    pairs = [(found[1], found[2])]
    for dt, rates in re.findall(r"([\d.]+) at ([\d or]+)", found[3]):
        pairs += [(dt, rate) for rate in rates.split(" or ")]
    assert len(pairs) == 5
    for dt, rate in pairs:
        assert float(dt) == pytest.approx(1000 * step_of_ardupilot(float(rate)), abs=0.005)


@pytest.mark.parametrize("target", CASES)
def test_propagation_finds_the_scatter_of_simulated_noise(target):
    """At another rate than the filter's: samples of 2.5 ms, summed to steps by the rule of each filter."""
    p = read(target)
    runs, time, tau0 = 4000, 2.0, 0.0025
    rng = np.random.default_rng(seed_of(f"autopilots {target}"))
    white = N["gyro"] / math.sqrt(tau0) * rng.standard_normal((runs, round(time / tau0)))
    walked = K["gyro"] * math.sqrt(tau0) * rng.standard_normal((runs, round(time / tau0)))
    step = {"px4": 0.01, "ardupilot": step_of_ardupilot(400)}[target]
    angle, bias = propagate(target, p[0], p[2], step, round(time / step))
    error = 3 * math.sqrt(2 / runs)  # of a variance, three standard errors
    assert np.mean((tau0 * white.sum(axis=1)) ** 2) == pytest.approx(angle, rel=error)
    assert np.mean(walked.sum(axis=1) ** 2) == pytest.approx(bias, rel=error)


@pytest.mark.parametrize("target", CASES)
def test_out_of_the_range_is_said(target):
    names = CASES[target][1]

    def said(words, **choices):
        lines = export(model(), to=target, choices=Choices(**choices)).splitlines()
        return [line.split()[1] for line in lines if words in line]

    outside = "outside the documented range, "
    assert said(f"{outside}0.0001 to 0.1", step=1.0) == [names[0]]
    assert said(f"{outside}0.01 to 1", step=1.0) == [names[1]]
    assert said("documented", noise_factor=10.0, walk_factor=10.0) == []
    assert said("the filter limits it to 1", noise_factor=1e4) == [n for n in names[:2] if n != "EK3_ACC_P_NSE"]
    assert said("the filter limits it to 5", noise_factor=1e4) == [n for n in names[:2] if n == "EK3_ACC_P_NSE"]
    assert said(f"{outside}0.0001 to 0.1", noise_factor=200.0) == [names[0]]
    if target == "px4":
        assert said(f"{outside}0 to 0.01", walk_factor=3000.0) == [*names[2:]]
    else:
        assert said(f"{outside}1e-05 to 0.001", walk_factor=100.0) == [names[2]]
        assert said(f"{outside}1e-05 to 0.02", walk_factor=100.0) == [names[3]]
        assert said(outside, walk_factor=0.01) == [*names[2:]]


@pytest.mark.parametrize("target", CASES)
def test_flicker_is_in_no_number_and_that_is_said(target):
    flicker = model(bias_instability=5e-5)
    plain = export(flicker, to=target, choices=Choices(walk={"gyro": "observed"}))
    assert CASES[target][0](plain) == CASES[target][0](export(model(), to=target))
    assert "Gyro N and K: a filter states" in plain
    chosen = export(flicker, to=target, choices=Choices(walk={"gyro": "horizon"}, horizon=100.0, filter_rate=100.0))
    found = CASES[target][0](chosen)[CASES[target][1][2]] * math.sqrt(STEP[target])
    # K² = 3·(σ²(T) − N²/T)/T, of the channel with flicker.
    rest = float(flicker.avar("gyro_x", m=[10_000], tau0=0.01)[0]) - N["gyro"] ** 2 / 100
    assert found == pytest.approx(math.sqrt(3 * rest / 100), rel=1e-6)


@pytest.mark.parametrize("target", CASES)
def test_what_has_to_be_chosen(target):
    no_walk = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}, "accel_x": {"random_walk": 1e-3}})
    with pytest.raises(OptionError, match=r"`walk="):
        export(no_walk, to=target)
    with pytest.raises(OptionError, match=f"{target} has one number for all axes"):
        export(model(), to=target, choices=Choices(axes="each"))
    with pytest.raises(DataError, match="accelerometers"):
        export(NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6}}), to=target)


@pytest.mark.parametrize("value", ["1\t1\tEKF2_GYR_NOISE\t9\t9\n1", "0", "256", "1.5", "nan", "x", ""])
def test_hostile_identities_are_refused(value):
    for key in ("vehicle", "component"):
        with pytest.raises(OptionError, match=key):
            export(model(), to="px4", choices=Choices(names={key: value}))
    assert "\n7\t1\tEKF2" in export(model(), to="px4", choices=Choices(names={"vehicle": "7"}))
