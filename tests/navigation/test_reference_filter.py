"""The reference filter: identities, known answers of another program, a simulated filter, and numbers of any size."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.model.processes import GaussMarkov, Resonance
from sigmatau.navigation.reference_filter import (
    AIDING,
    Aiding,
    FilterModel,
    TrueNoise,
    find_consistent_walk,
    find_third_state,
    judge_filter,
)

DEG_H = math.radians(1) / 3600
DEG_SQRT_H = math.radians(1) / 60
GYRO = AIDING["gyro"]
TIMES = (10.0, 60.0, 600.0)
# N in deg/√h, B in deg/h, K in deg/h/√h, processes in deg/h and s; then by criterion K, NEES and real over stated error
# after 10, 60 and 600 s, as computed by a program of its own (the table of docs/study/consistent.md), to its digits.
SENSORS = {
    "consumer": (
        (0.55, 8, 24.8, ((5, 300.0),)),
        {"horizon": (81, 2.96, 1.09, 1.00, 0.60), "bias": (291, 1.00, 0.83, 0.50, 0.22)},
    ),
    "flicker": ((0.3, 10, 0, ()), {"horizon": (111, 4.6, 1.27, 1.00, 0.46), "bias": (529, 1.00, 0.65, 0.34, 0.13)}),
    "process": ((0.1, 0.5, 0, ((3, 1000.0),)), {"horizon": (8.8, 1.42, 1.01, 1.00, 0.86)}),
}


def noise_of(n, b=0.0, k=0.0, processes=()):
    terms = {"random_walk": n * DEG_SQRT_H, "bias_instability": b * DEG_H, "rate_random_walk": k * DEG_H / 60}
    return TrueNoise(
        terms={term: value for term, value in terms.items() if value},
        gauss_markov=tuple(GaussMarkov(sigma=s * DEG_H, time=t) for s, t in processes),
    )


def judge(truth, walk, times=TIMES, aiding=GYRO):
    assumed = FilterModel(noise=truth.terms["random_walk"], walk=walk)
    return judge_filter([truth], assumed, aiding=aiding, times=times)


@pytest.mark.parametrize(("name", "criterion"), [(name, c) for name, (_, rows) in SENSORS.items() for c in rows])
def test_known_answers(name, criterion):
    parts, rows = SENSORS[name]
    truth = noise_of(*parts)
    chosen = find_consistent_walk(
        truth, noise=truth.terms["random_walk"], aiding=GYRO, horizon=60.0, criterion=criterion
    )
    judged = judge(truth, chosen.walk)
    walk, *ratios = rows[criterion]
    assert chosen.walk / DEG_H * 60 == pytest.approx(walk, rel=0.01)
    assert [judged.nees, *(c.real / c.stated for c in judged.coasting)] == pytest.approx(ratios, abs=0.021, rel=0.01)
    assert not chosen.is_floor


def test_a_filter_with_the_model_of_the_truth_is_consistent():
    truth = noise_of(0.3, k=60)
    judged = judge(truth, truth.terms["rate_random_walk"])
    assert judged.nees == pytest.approx(1, rel=1e-9)
    assert [c.real / c.stated for c in judged.coasting] == pytest.approx([1, 1, 1], rel=1e-9)
    process = GaussMarkov(sigma=3 * DEG_H, time=1000.0)
    of_process = TrueNoise(terms={"random_walk": 1e-5}, gauss_markov=(process,))
    judged = judge_filter([of_process], FilterModel(noise=1e-5, process=process), aiding=AIDING["accel"], times=TIMES)
    assert judged.nees == pytest.approx(1, rel=1e-9)
    assert [c.real / c.stated for c in judged.coasting] == pytest.approx([1, 1, 1], rel=1e-9)


def test_the_search_ends_where_the_error_is_stated_right():
    for part in ({"rate_ramp": 1e-9}, {"bias_instability": 1e-5}, {"rate_random_walk": 1e-6, "bias_instability": 1e-5}):
        truth = TrueNoise(terms={"random_walk": 1e-4, **part})
        chosen = find_consistent_walk(truth, noise=1e-4, aiding=GYRO, horizon=60.0)
        (coasting,) = judge(truth, chosen.walk, times=(60.0,)).coasting
        assert coasting.real / coasting.stated == pytest.approx(1, abs=1e-3), part


def test_the_least_walk_adds_one_percent():
    truth = TrueNoise(terms={"random_walk": 1e-4})
    chosen = find_consistent_walk(truth, noise=1e-4, aiding=GYRO, horizon=60.0)
    assert chosen.is_floor
    (coasting,) = judge(truth, chosen.walk, times=(60.0,), aiding=Aiding(interval=0.2, deviation=1e-7)).coasting
    assert coasting.stated**2 / (1e-8 * 60) == pytest.approx(1.01, abs=0.001)


@pytest.mark.parametrize("scale", [1e-60, 1e-30, 1e30, 1e60])
def test_numbers_of_any_size(scale):
    truth = TrueNoise(terms={"random_walk": scale * 1e-4, "bias_instability": scale * 1e-5})
    chosen = find_consistent_walk(truth, noise=scale * 1e-4, aiding=GYRO, horizon=60.0)
    judged = judge(truth, chosen.walk)
    assert judged.coasting[1].real / judged.coasting[1].stated == pytest.approx(1, abs=1e-3)
    assert math.isfinite(judged.nees)


@pytest.mark.parametrize("time", [1e-9, 1e-3, 1e9])
def test_processes_of_any_time(time):
    truth = TrueNoise(
        terms={"random_walk": 1e-4},
        gauss_markov=(GaussMarkov(sigma=1e-5, time=time),),
        resonance=(Resonance(sigma=1e-4, frequency=30.0, width=0.1),),
    )
    judged = judge(truth, 1e-6)
    assert all(math.isfinite(c.real) for c in judged.coasting)
    assert math.isfinite(judged.nees)


@pytest.mark.parametrize("name", SENSORS)
def test_a_third_state_is_right_up_to_the_horizon(name):
    truth = noise_of(*SENSORS[name][0])
    assumed = find_third_state(truth, noise=truth.terms["random_walk"], aiding=GYRO, horizon=60.0)
    judged = judge_filter([truth], assumed, aiding=GYRO, times=(10.0, 30.0, 60.0))
    assert 0.95 < judged.nees < 1.05
    assert [c.real / c.stated for c in judged.coasting] == pytest.approx([1, 1, 1], abs=0.04)


def test_several_axes():
    quiet, loud = noise_of(0.3, 5), noise_of(0.3, 10)
    assumed = FilterModel(noise=quiet.terms["random_walk"], walk=1e-6)
    of = {}
    for name, truths, mean in (("quiet", [quiet], False), ("loud", [loud], False), ("worst", [quiet, loud], False)):
        of[name] = judge_filter(truths, assumed, aiding=GYRO, times=(60.0,), mean=mean)
    mean = judge_filter([quiet, loud], assumed, aiding=GYRO, times=(60.0,), mean=True)
    assert of["worst"] == of["loud"]
    assert mean.nees == pytest.approx((of["quiet"].nees + of["loud"].nees) / 2, rel=1e-9)


def test_a_simulated_filter_has_this_error():
    """A Gauss-Markov truth and a walking filter, step by step: NEES and the error after 60 s, to 3 standard errors."""
    n, sigma, time, walk, steps, runs = 1e-4, 3e-5, 100.0, 2e-6, 3000, 400
    rng = np.random.default_rng(seed_of("a simulated filter"))
    h, r = GYRO.interval, GYRO.deviation
    judged = judge(
        TrueNoise(terms={"random_walk": n}, gauss_markov=(GaussMarkov(sigma=sigma, time=time),)), walk, (60.0,)
    )
    fine = 4  # parts of a step, within which the bias is constant
    keep = math.exp(-h / fine / time)
    bias = sigma * rng.standard_normal(runs)
    angle, estimate, slope = np.zeros(runs), np.zeros(runs), np.zeros(runs)
    p = np.array([[r**2, 0.0], [0.0, sigma**2]])
    f = np.array([[1.0, h], [0.0, 1.0]])
    q = np.array([[n**2 * h + walk**2 * h**3 / 3, walk**2 * h**2 / 2], [walk**2 * h**2 / 2, walk**2 * h]])
    squares = []
    for step in range(steps + round(60 / h)):
        for _ in range(fine):
            angle += bias * h / fine
            bias = keep * bias + sigma * math.sqrt(1 - keep**2) * rng.standard_normal(runs)
        angle += n * math.sqrt(h) * rng.standard_normal(runs)
        estimate += slope * h
        p = f @ p @ f.T + q
        if step >= steps:
            continue
        gain = p[:, 0] / (p[0, 0] + r**2)
        innovation = angle + r * rng.standard_normal(runs) - estimate
        estimate, slope = estimate + gain[0] * innovation, slope + gain[1] * innovation
        p = p - np.outer(gain, p[0])
        if step == steps - 1:
            squares = (bias - slope) ** 2 / p[1, 1]
    error = 3 * math.sqrt(2 / runs)
    assert np.mean(squares) == pytest.approx(judged.nees, rel=error)
    assert np.mean((angle - estimate) ** 2) == pytest.approx(judged.coasting[0].real ** 2, rel=error)
    assert math.sqrt(p[0, 0]) == pytest.approx(judged.coasting[0].stated, rel=1e-6)
