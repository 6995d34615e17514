"""Mean of a channel: what it is of, and the coverage of its error."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate

RECORDS = 30


def test_of_what_was_analysed():
    rng = np.random.default_rng(seed_of("mean of what was analysed"))
    rates = 1e-3 * rng.standard_normal(20_000) + 0.01
    rates[5000] += 5.0  # a spike, which is left out: it would move the mean by 2.5e-4
    rates[9000:9100] = np.nan
    record = Record.from_arrays(rate=100, gyro_x=rates, unit={"gyro": "rad/s"})
    analysis = analyze(record)
    mean = analysis.means["gyro_x"]
    assert mean.value == pytest.approx(np.nanmean(np.delete(rates, 5000)), abs=1e-6)  # its neighbours are left out too
    assert analysis.to_dict()["channels"]["gyro_x"]["mean"] == mean.to_dict()
    assert (mean.unit, analysis.notes) == ("rad/s", {})
    assert "notes" not in analysis.to_dict()
    assert analyze(record, notes={"run": "1"}).to_dict()["notes"] == {"run": "1"}


@pytest.mark.parametrize("process", [False, True])
def test_coverage_of_the_error(process):
    """The mean of noise that averages out."""
    scores = []
    for k in range(RECORDS):
        record = simulate(_model(process=process), duration=200, rate=20, rng=seed_of(f"mean {process} {k}"))
        mean = analyze(record, at_rest=True, threads=1).means["gyro_x"]
        if mean.error is not None:
            scores.append(mean.value / mean.error)
    assert len(scores) > 0.5 * RECORDS
    # Three standard errors of the share, and 3 %: the noise is fitted, and the error of the fit is not in that of the mean.
    assert np.mean(np.abs(scores) < 1.96) >= 0.95 - 3 * np.sqrt(0.05 * 0.95 / len(scores)) - 0.03


def _model(*, process):
    from sigmatau import ChannelModel, GaussMarkov

    slow = (GaussMarkov(sigma=5e-3, time=2.0),) if process else ()
    return NoiseModel(channels={"gyro_x": ChannelModel(terms={"random_walk": 1e-3}, gauss_markov=slow)})


def test_no_error_of_a_bias_that_wanders():
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-4}})
    analysis = analyze(simulate(model, duration=1000, rate=20, rng=seed_of("a bias that wanders")))
    assert analysis["gyro_x"]["rate_random_walk"].observed
    assert analysis.means["gyro_x"].error is None
