"""A few missing samples: straight lines in their place, where that changes nothing; else the likelihood of the mask."""

import numpy as np
import pytest
from studies.samples import simulated

from known import seed_of
from sigmatau import Record
from sigmatau._native import likelihood as native
from sigmatau.fitting.likelihood import fit_samples

N = 100_000


def fits(truth, *, missing, monkeypatch):
    """Of the whole record and of that with missing samples, and how many passes knew the mask."""
    rng = np.random.default_rng(seed_of(f"few missing {sorted(truth)} {missing}"))
    y = simulated(N, 0.01, truth, seed=int(rng.integers(1 << 62)))
    holes = y.copy()
    holes[rng.choice(np.arange(1, N - 1), missing, replace=False)] = np.nan
    passes, masked = [], native.summarize_masked
    monkeypatch.setattr(native, "summarize_masked", lambda *a, **k: passes.append(1) or masked(*a, **k))
    found = [fit_samples(Record.from_arrays(rate=100, gyro_x=x).streams[0], "gyro_x") for x in (y, holes)]
    return *found, len(passes)


@pytest.mark.parametrize(
    "truth",
    [
        {"random_walk": 1e-3},
        {"random_walk": 1e-3, "bias_instability": 3e-3},
        {"random_walk": 1e-3, "rate_random_walk": 3e-4},
        {"quantization": 1e-5, "random_walk": 1e-3},
    ],
)
def test_the_fit_is_that_of_the_whole_record(truth, monkeypatch):
    whole, few, passes = fits(truth, missing=20, monkeypatch=monkeypatch)
    assert passes == 0
    assert few.verdict == whole.verdict
    for term, one in whole.items():
        assert few[term].observed == one.observed
        if one.observed:
            width = (one.high - one.low) / 4
            assert few[term].value == pytest.approx(one.value, abs=0.2 * width)
            assert few[term].low == pytest.approx(one.low, abs=0.4 * width)
            assert few[term].high == pytest.approx(one.high, abs=0.4 * width)


def test_more_than_a_few_use_the_mask(monkeypatch):
    assert fits({"random_walk": 1e-3}, missing=40, monkeypatch=monkeypatch)[-1] == 1


def test_so_do_those_that_would_leak_into_a_low_density(monkeypatch):
    """Quantization noise far above the random walk: the error of a straight line is white, and 2e-4 of it is too much."""
    whole, few, passes = fits({"quantization": 1e-3, "random_walk": 3e-4}, missing=20, monkeypatch=monkeypatch)
    assert passes >= 1
    truth = 3e-4
    for fitted in (whole, few):
        walk = fitted["random_walk"]
        ends = (walk.low, walk.high) if walk.observed else (0.0, walk.upper_limit)
        assert ends[0] <= truth <= ends[1]
