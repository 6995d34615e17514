"""Slow lines: sinusoids of many seconds are found with their amplitude, and take nothing from the terms."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, fit_channel, simulate
from sigmatau.model.numbers import adev_interval
from sigmatau.noise.terms import avar

N, B = 1e-4, 5e-5
RATE, DURATION = 10.0, 3600.0
COUNT = 8


def records(name, lines, **terms):
    """Records with sinusoids of (period, amplitude) of a random phase."""
    model = NoiseModel(channels={"gyro_x": {"random_walk": N, **terms}})
    rng = np.random.default_rng(seed_of(f"slow lines, {name}"))
    t = np.arange(round(RATE * DURATION)) / RATE
    for _ in range(COUNT):
        x = simulate(model, duration=DURATION, rate=RATE, rng=rng).streams[0].column("gyro_x")
        for period, amplitude in lines:
            x = x + amplitude * np.sin(2 * np.pi * t / period + rng.uniform(0, 2 * np.pi))
        yield Record.from_arrays(rate=RATE, gyro_x=x, unit={"gyro": "rad/s"})


def most(share, count=COUNT):
    """A share of the records and three standard errors."""
    return count * share + 3 * math.sqrt(count * share * (1 - share))


@pytest.mark.parametrize("period", [47.0, 1000.0])
def test_a_line_is_a_line(period):
    """Before, 80 % of such lines were a Gauss-Markov process, or had an amplitude that was wrong by half."""
    found, covered, inside, off, false = 0, 0, 0, 0, 0
    sizes = np.unique(np.round(np.geomspace(10, RATE * DURATION / 4, 24)).astype(int))
    tau = sizes / RATE
    true = np.sqrt(
        avar("random_walk", N, m=sizes, tau0=1 / RATE)
        + (3e-5 * np.sin(np.pi * tau / period) ** 2 / (np.pi * tau / period)) ** 2
    )
    for record in records(f"{period:g} s", [(period, 3e-5)]):
        fit = fit_channel(record, "gyro_x")
        false += bool(fit.gauss_markov or fit["bias_instability"].low or fit["rate_random_walk"].low)
        lines = fit.sinusoid
        found += len(lines) == 1
        if len(lines) == 1:
            line = lines[0]
            covered += line.amplitude.low <= 3e-5 <= line.amplitude.high
            inside += line.frequency.low <= 1 / period <= line.frequency.high
            low, high = adev_interval(fit.to_model(), m=sizes, tau0=1 / RATE)
            middle = np.log(low * high) / 2
            off += bool(np.any(np.abs(np.log(true) - middle) > 3 * np.log(high / low) / 2))
    assert found >= COUNT - most(0.05)
    assert covered >= found - most(0.05)
    assert inside >= found - most(0.05)
    assert off == 0
    assert false <= most(0.08)


def test_flicker_noise_beside_a_line():
    fits = [fit_channel(record, "gyro_x") for record in records("flicker", [(300.0, 8e-5)], bias_instability=B)]
    terms = [fit["bias_instability"] for fit in fits]
    assert sum(len(fit.sinusoid) > 0 for fit in fits) >= COUNT - most(0.1)
    assert sum(term.observed and term.low <= B <= term.high for term in terms) >= COUNT - most(0.08)


@pytest.mark.parametrize("terms", [{}, {"bias_instability": B, "rate_random_walk": 5e-6}])
def test_noise_has_no_lines(terms):
    """A false line has a probability of 1e-4 in an octave, and there are eleven."""
    fits = [fit_channel(record, "gyro_x") for record in records(f"none, {sorted(terms)}", [], **terms)]
    assert sum(bool(fit.sinusoid) for fit in fits) <= most(0.005)


def test_a_finding_states_period_and_amplitude():
    record = next(iter(records("finding", [(300.0, 3e-5)])))
    (finding,) = (one for one in analyze(record, threads=1).findings if one.code == "spectral_line")
    assert finding.details.lines[0].weakest < 3e-5 < finding.details.lines[0].strongest
    assert "with a period of" in finding.message
    assert "±" in finding.message or "[" in finding.message


def test_missing_samples_hide_no_line():
    rng = np.random.default_rng(seed_of("slow lines, missing"))
    for record in list(records("missing", [(300.0, 5e-5)]))[:4]:
        x = record.streams[0].column("gyro_x").copy()
        x[rng.random(len(x)) < 0.1] = np.nan
        x[9000:11000] = np.nan
        fit = fit_channel(Record.from_arrays(rate=RATE, gyro_x=x, unit={"gyro": "rad/s"}), "gyro_x")
        (line,) = fit.sinusoid
        half = (line.amplitude.high - line.amplitude.low) / 2
        assert abs(line.amplitude.value - 5e-5) < 2 * half
        assert abs(line.frequency.value * 300 - 1) < 0.03
