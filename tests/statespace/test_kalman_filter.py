"""The exported matrices in a Kalman filter: its innovations on simulated records are as large as it says."""

import numpy as np
import pytest
from scipy import stats

from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.statespace.state_space import state_space

DT = 0.1
STEPS, RECORDS = 600, 300
SETTLED = 100
"""Steps after which the level at the start, which records begin with at 0 and the model as stationary, is known."""

FIVE = {"quantization": 3e-4, "random_walk": 2e-4, "bias_instability": 2e-3, "rate_random_walk": 5e-4}


def mean_nis(system, y):
    """Mean normalised innovation squared of records side by side, shape (records, steps), and how many innovations."""
    noise = system.G @ system.Qd @ system.G.T
    x, p = np.zeros((len(y), len(system.states))), np.array(system.P0)
    h, squares = system.H[0], 0.0
    if system.output == "integrated":
        # Sums of rates begin one step after the angle 0, and have the quantization error of that angle in them for ever.
        p[0, 0] += float(system.R[0, 0])
        p = system.F @ p @ system.F.T + noise
    for k in range(y.shape[1]):  # of time; the records go together
        s = float(h @ p @ h) + float(system.R[0, 0])
        innovation = y[:, k] - x @ h
        if k >= SETTLED:
            squares += float(innovation @ innovation) / s
        gain = p @ h / s
        x = x + np.outer(innovation, gain)
        keep = np.eye(len(p)) - np.outer(gain, h)
        p = keep @ p @ keep.T + np.outer(gain, gain) * float(system.R[0, 0])
        x, p = x @ system.F.T, system.F @ p @ system.F.T + noise
    count = len(y) * (y.shape[1] - SETTLED)
    return squares / count, count


def records(terms, name):
    """As channels of one record, which is made at once."""
    model = NoiseModel(channels={f"gyro_{k}": terms for k in range(RECORDS)})
    (stream,) = simulate(model, duration=STEPS * DT, rate=1 / DT, rng=seed_of(name)).streams
    return np.array([stream.column(channel) for channel in stream.channels])


def interval(count):
    """99 % of the mean of so many squares of standard normal numbers."""
    return np.array(stats.chi2.interval(0.99, count)) / count


def as_measured(y, output):
    if output == "rate":
        return y
    return y * DT if output == "increments" else np.cumsum(y, axis=1) * DT


def system_of(model, output):
    return state_space(model, dt=DT, output=output, tau_max=STEPS * DT, flicker_error=1e-3)


@pytest.mark.parametrize("output", ["rate", "increments", "integrated"])
@pytest.mark.parametrize("terms", [FIVE, {"random_walk": 2e-4, "bias_instability": 2e-3}], ids=["QNBK", "NB"])
def test_consistent(terms, output):
    """150 000 innovations: their mean square is known to 0.4 %."""
    system = system_of(ChannelModel(terms=terms), output)
    y = as_measured(records(terms, f"kalman {' '.join(terms)}"), output)
    nis, count = mean_nis(system, y)
    low, high = interval(count)
    assert low < nis < high


@pytest.mark.parametrize("output", ["rate", "integrated"])
def test_a_random_walk_that_is_10_percent_off_shows(output):
    terms = {"random_walk": 2e-3, "bias_instability": 2e-3, "rate_random_walk": 5e-4}
    y = as_measured(records(terms, "kalman N off"), output)
    low, high = interval(RECORDS * (STEPS - SETTLED))
    for factor in (0.9, 1.1):
        wrong = ChannelModel(terms={**terms, "random_walk": factor * terms["random_walk"]})
        nis, _ = mean_nis(system_of(wrong, output), y)
        assert nis > high if factor < 1 else nis < low
    nis, _ = mean_nis(system_of(ChannelModel(terms=terms), output), y)
    assert low < nis < high


@pytest.mark.parametrize("output", ["rate", "integrated"])
def test_gauss_markov_process(output):
    """Drawn here, stationary from the first sample, so that no step is left out of account for it."""
    from scipy.signal import lfilter

    rng = np.random.default_rng(seed_of("kalman Gauss-Markov"))
    model = ChannelModel(terms={"random_walk": 2e-4}, gauss_markov=(GaussMarkov(sigma=2e-3, time=3.0),))
    phi = np.exp(-DT / 3.0)
    drive = 2e-3 * np.sqrt(1 - phi**2) * rng.standard_normal((RECORDS, STEPS))
    drive[:, 0] /= np.sqrt(1 - phi**2)
    y = lfilter([1.0], [1.0, -phi], drive) + 2e-4 / np.sqrt(DT) * rng.standard_normal((RECORDS, STEPS))
    nis, count = mean_nis(system_of(model, output), as_measured(y, output))
    low, high = interval(count)
    assert low < nis < high
    wrong = ChannelModel(terms=model.terms, gauss_markov=(GaussMarkov(sigma=2.2e-3, time=3.0),))
    nis, _ = mean_nis(system_of(wrong, output), as_measured(y, output))
    assert nis < low
