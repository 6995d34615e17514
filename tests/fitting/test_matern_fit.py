"""The fit of a Matérn process: intervals, the test of the Gauss-Markov process, and records that do not show the slope."""

import math

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.units import to_si

DEG_H = to_si(1, "deg/h")
RECORDS = 24


def record(name, process, *, white=0.1, duration=7200.0, rate=5.0):
    kind = {"matern" if isinstance(process, st.Matern) else "gauss_markov": (process,)} if process else {}
    channel = st.ChannelModel(terms={"random_walk": to_si(white, "deg/sqrt(h)")}, **kind)
    model = st.NoiseModel(channels={"gyro_x": channel})
    return st.simulate(model, duration=duration, rate=rate, rng=seed_of(name))


def fitted(*args, **options):
    return st.fit_channel(record(*args, **options), "gyro_x", processes="matern")


@pytest.mark.parametrize("smoothness", [0.1, 0.25])
def test_intervals_hold_and_the_slope_is_told_from_gauss_markov(smoothness):
    """95 % in 24 records, less 3 standard errors of it: 0.82; the full cells are in docs/study/matern.md."""
    process = st.Matern(sigma=20 * DEG_H, time=20.0, smoothness=smoothness)
    fits = [fitted(f"matern {smoothness} {k}", process).matern for k in range(RECORDS)]
    for name in ("sigma", "time", "smoothness"):
        truth = getattr(process, name)
        intervals = [getattr(fit, name) for fit in fits]
        inside = np.mean([each.low <= truth <= each.high for each in intervals])
        assert inside >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / RECORDS), name
        logs = np.log([each.value / truth for each in intervals])
        assert abs(logs.mean()) < 0.1 + 3 * logs.std() / math.sqrt(RECORDS), name
    assert all(fit.observed and fit.slope_observed and fit.gauss_markov_p_value < 1e-6 for fit in fits)
    assert np.mean([fit.p_value < 0.05 for fit in fits]) <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / RECORDS)


def test_gauss_markov_process_is_the_end_of_the_range():
    """Rejected at 1 % in at most 3 standard errors more than 1 % of the records, and the fit is that of the process."""
    process = st.GaussMarkov(sigma=20 * DEG_H, time=20.0)
    fits = [fitted(f"matern markov {k}", process) for k in range(RECORDS)]
    assert sum(fit.matern.gauss_markov_p_value < 0.01 for fit in fits) <= 2
    at_end = [fit for fit in fits if fit.matern.smoothness.value == 0.5]
    assert len(at_end) > RECORDS / 4
    for fit in at_end:
        assert fit.matern.gauss_markov_p_value > 0.05
        assert fit.matern.to_process().smoothness == 0.5
        # A shorter time would need a larger smoothness, which is out of range: the lower end is that of the process.
        (markov,) = fit.gauss_markov
        assert fit.matern.time.low == pytest.approx(markov.time.low, rel=0.05)


def test_white_noise_has_no_process_and_a_limit():
    fit = fitted("matern white", None)
    assert not fit.matern.observed
    assert not fit.matern.slope_observed
    assert 0 < fit.matern.upper_limit < 20 * DEG_H
    assert any(note.startswith("no Matérn process seen: below ") for note in fit.notes())
    with pytest.raises(st.DataError, match="does not show"):
        fit.matern.to_process()


def test_hidden_slope_is_stated():
    """White noise hides all but the lowest frequencies, at which every slope is flat: a short process of few samples."""
    process = st.Matern(sigma=6 * DEG_H, time=20.0, smoothness=0.25)
    fit = fitted("matern hidden", process, white=0.6, duration=14_400.0)
    assert fit.matern.observed
    assert fit.matern.smoothness.low < 0.03
    assert fit.matern.smoothness.high > 0.45
    assert "smoothness" in " ".join(fit.notes())


def test_record_shorter_than_the_corner_has_a_limit_of_the_time():
    """At T of five records the interval reaches a quarter of the record, the longest time that is tried: no upper end."""
    process = st.Matern(sigma=200 * DEG_H, time=9000.0, smoothness=0.25)
    fit = fitted("matern long", process, duration=1800.0)
    assert fit.matern.time.high is None
    assert fit.matern.sigma.high is None
    assert 0 < fit.matern.time.low < 9000.0
    assert fit.to_dict()["matern"]["time"]["high"] is None
    assert "correlation time at least " in " ".join(fit.notes())
    assert fit.matern.smoothness.low <= 0.25 <= fit.matern.smoothness.high


@pytest.mark.parametrize("kind", ["gap", "scattered", "increments", "accumulated"])
def test_gaps_and_increments_keep_the_intervals(kind):
    """Each interval holds in 95 % of 16 records, less 3 standard errors of it: 0.79."""
    process, fits = st.Matern(sigma=20 * DEG_H, time=20.0, smoothness=0.25), []
    for k in range(16):
        stream = record(f"matern {kind} {k}", process).streams[0]
        rate = np.asarray(stream.samples.read(0, 0, stream.grid.n)).copy()
        options = {}
        if kind == "gap":
            rate[9000:11_000] = np.nan
        elif kind == "scattered":
            rate[np.random.default_rng(k).random(len(rate)) < 0.02] = np.nan
        else:
            options = {"input": kind}
            rate = rate / 5 if kind == "increments" else np.cumsum(rate) / 5
        log = st.Record.from_arrays(rate=5, gyro_x=rate, **options)
        fits.append(st.fit_channel(log, "gyro_x", processes="matern").matern)
    for name in ("sigma", "time", "smoothness"):
        truth = getattr(process, name)
        ends = [(each.low or 0, each.high or math.inf) for each in (getattr(fit, name) for fit in fits)]
        assert np.mean([low <= truth <= high for low, high in ends]) >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / 16), name
    assert all(fit.observed and fit.sigma.unit == "rad/s" for fit in fits)
    assert np.median([fit.gauss_markov_p_value for fit in fits]) < 0.01


def test_other_values_are_those_without_it():
    log = record("matern same", st.Matern(sigma=20 * DEG_H, time=20.0, smoothness=0.25))
    plain, fit = (st.fit_channel(log, "gyro_x", processes=processes) for processes in (None, "matern"))
    content = fit.to_dict()
    assert content.pop("matern")["smoothness"]["unit"] == "1"
    assert plain.to_dict() == content
    assert plain.matern is None
    assert fit.to_model() == plain.to_model()


def test_wrong_name_of_a_process():
    with pytest.raises(st.OptionError, match="must be 'matern' or up to 8 positive times"):
        st.fit_channel(record("matern same", None), "gyro_x", processes="markov")


def test_a_limit_of_the_time_leaves_no_upper_limit_of_sigma():
    """T is 140 records: the standard deviation is that of the lower end, not an interval about a wrong value."""
    process = st.Matern(sigma=100 * DEG_H, time=1e6, smoothness=0.25)
    (note,) = [note for note in fitted("matern drift", process).notes() if "Matérn" in note]
    assert "process of at least " in note


def test_a_time_below_the_shortest_leaves_no_smoothness():
    """T is 5 samples, and the shortest time that is tried 20."""
    process = st.Matern(sigma=100 * DEG_H, time=1.0, smoothness=0.25)
    fit = fitted("matern fast", process)
    (note,) = [note for note in fit.notes() if "Matérn" in note]
    assert fit.matern.time.low is None
    assert fit.matern.smoothness.low is fit.matern.smoothness.high is None
    assert not fit.matern.slope_observed
    assert ("correlation time not determined" if fit.matern.time.high is None else "correlation time below ") in note
    assert "smoothness not determined" in note


def test_a_model_that_does_not_describe_the_record_is_stated():
    """Flicker noise to beyond the Nyquist frequency: the samples of a process with its slope have more variance."""
    terms = {"random_walk": to_si(0.1, "deg/sqrt(h)"), "bias_instability": 20 * DEG_H}
    record = st.simulate(st.NoiseModel(channels={"gyro_x": terms}), duration=7200, rate=10, rng=1)
    fit = st.fit_channel(record, "gyro_x", processes="matern")
    assert fit.matern.p_value < 1e-6
    assert any("does not describe the record" in note for note in fit.notes())
