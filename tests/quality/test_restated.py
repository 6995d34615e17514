"""What bad samples and filters are said to do to the fit that is printed, against the same noise without them."""

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov

N, RATE = 60_000, 100.0
TRUTH = {"random_walk": 1e-4, "bias_instability": 1.5e-5}


def noise(name):
    model = st.NoiseModel(channels={"gyro_x": TRUTH})
    record = st.simulate(model, duration=N / RATE, rate=RATE, rng=seed_of(name))
    return np.array(record.streams[0].column("gyro_x"))


def analyzed(x):
    return st.analyze(st.Record.from_arrays(rate=RATE, gyro_x=x), threads=1)


def dropped(x, rng, size=20, count=60, level=0.0):
    for start in rng.choice(np.arange(size, N - size, size + 1), count, replace=False):
        x[start : start + size] = 0.0 if level is not None else x[start]


def spiked(x, rng, *, share=1e-3, height=0.05, signs=(1.0,), width=1):
    at = np.flatnonzero(rng.random(N - width) < share / width)
    heights = height * rng.choice(signs, len(at))
    for k in range(width):
        x[at + k] += heights


CASES = {
    "dropouts": ("dropout", lambda x, rng: dropped(np.add(x, 0.01, out=x), rng)),
    "dropouts far from zero": ("dropout", lambda x, rng: dropped(np.add(x, 0.03, out=x), rng)),
    "stuck": ("stuck_samples", lambda x, rng: dropped(x, rng, size=200, count=40, level=None)),
    "spikes": ("spikes", spiked),
    "spikes both ways": ("spikes", lambda x, rng: spiked(x, rng, signs=(-1.0, 1.0))),
    "pairs": ("spikes", lambda x, rng: spiked(x, rng, width=2)),
    "every thousandth": ("spikes", lambda x, rng: np.add.at(x, np.arange(500, N, 1000), 0.05)),
    "a twentieth": ("spikes", lambda x, rng: spiked(x, rng, share=0.05, height=1.0)),
}


@pytest.mark.parametrize("case", CASES)
def test_changes_are_those_of_the_fit_that_is_printed(case):
    """By the same noise without the fault; the rest, a few per cent fewer samples, differs from it by its own errors."""
    code, plant = CASES[case]
    clean = noise(case)
    x = clean.copy()
    plant(x, np.random.default_rng(seed_of(f"places of {case}")))
    analysis = analyzed(x)
    (finding,) = (f for f in analysis.findings if f.code == code)
    assert finding.severity == "warning"
    assert code in finding.fit_effect.without
    printed = analysis.fits["gyro_x"]
    without = st.fit(st.allan(st.Record.from_arrays(rate=RATE, gyro_x=clean))["gyro_x"], tau_min=printed.tau_min)
    changes = dict(finding.factors)
    assert finding.fit_effect.tau_min_s == printed.tau_min
    for term in TRUTH:
        before, after = printed[term].value, without[term]
        if not before or not after.value:
            continue
        # Half the interval of the clean fit, for it and that of the rest are made from nearly the same noise.
        error = (after.high - after.low) / (2 * after.value) if after.high else 0.2
        assert changes.get(term, 1.0) == pytest.approx(before / after.value, rel=0.05 + error), term
    # No second warning that is but the first once more; what is left out of the record is told of dropouts alone.
    codes = {f.code for f in analysis.findings if f.severity == "warning"} - {code}
    assert codes <= ({"non_stationary"} if code == "dropout" else set())


def test_no_large_value_goes_unmarked():
    """A random walk of 500 times the sensor's own is told so, by what is printed."""
    x = noise("unmarked") + 1.0
    dropped(x, np.random.default_rng(seed_of("unmarked places")))
    analysis = analyzed(x)
    value = analysis.fits["gyro_x"]["random_walk"].value
    (finding,) = (f for f in analysis.findings if f.code == "dropout")
    assert value > 100 * TRUTH["random_walk"]
    assert value / dict(finding.factors)["random_walk"] == pytest.approx(TRUTH["random_walk"], rel=0.1)


def test_two_faults_are_counted_once():
    x = noise("two faults") + 0.01
    rng = np.random.default_rng(seed_of("two places"))
    dropped(x, rng)
    spiked(x, rng)
    analysis = analyzed(x)
    told = {f.code: f for f in analysis.findings if f.code in ("dropout", "spikes")}
    assert len(told) == 2
    assert sorted(bool(f.factors) for f in told.values()) == [False, True]
    (counted,) = (f for f in told.values() if f.factors)
    (other,) = (f for f in told.values() if not f.factors)
    assert counted.fit_effect.without == ("dropout", "spikes")
    assert (counted.fit_effect.counted_in, other.fit_effect.counted_in) == ("", counted.code)
    value = analysis.fits["gyro_x"]["random_walk"].value
    assert value / dict(counted.factors)["random_walk"] == pytest.approx(TRUTH["random_walk"], rel=0.2)


@pytest.mark.parametrize("corner", [3.0, 20.0])
def test_a_filter_below_the_fit_changes_nothing(corner):
    """The fit begins where the curve is right, or nearly; what is read at one sample is in words."""
    from scipy.signal import butter, lfilter

    x = lfilter(*butter(2, corner / (RATE / 2)), noise(f"filter {corner}"))
    analysis = analyzed(x)
    (finding,) = (f for f in analysis.findings if f.code == "low_pass_filter")
    fitted = analysis.fits["gyro_x"]["random_walk"]
    stated = dict(finding.factors).get("random_walk", 1.0)
    assert finding.fit_effect.tau_min_s == analysis.fits["gyro_x"].tau_min
    # What is printed over the truth, to the interval of the fit, and to 5 %: the least that is said.
    error = (fitted.high - fitted.low) / (2 * fitted.value)
    assert stated == pytest.approx(fitted.value / TRUTH["random_walk"], rel=0.05 + 1.5 * error)


@pytest.mark.parametrize("corner", [5.0, 2.0])
def test_a_filter_is_no_gauss_markov_process(corner):
    """White noise behind a first-order filter is one, and at long times a random walk: no limit is below that."""
    from scipy.signal import lfilter

    pole = np.exp(-2 * np.pi * corner / RATE)
    white = np.random.default_rng(seed_of(f"first order {corner}")).normal(size=N) * 1e-3
    filtered = lfilter([1 - pole], [1, -pole], white)
    analysis = analyzed(filtered)
    fitted = analysis.fits["gyro_x"]
    assert not fitted.gauss_markov
    walk = fitted["random_walk"]
    if walk.value is None:
        assert walk.upper_limit > 1e-4
    else:
        assert walk.value == pytest.approx(1e-4, abs=3 * (walk.high - walk.low) / (2 * 1.96))
    assert "takes the filter at" in fitted.reason
    (finding,) = (f for f in analysis.findings if f.code == "low_pass_filter")
    effect = finding.fit_effect
    assert (effect.tau_min_s, effect.verdict, effect.verdict_without) == (fitted.tau_min, "adequate", "adequate")
    assert (finding.factors, effect.hidden) == ((), ())
    # Where there are too few averaging times beyond the filter nothing is said of the random walk.
    short = analyzed(filtered[: round(RATE * 150 / corner)]).fits["gyro_x"]
    assert short.verdict == "descriptive"
    assert short["random_walk"].upper_limit is None


def test_a_gauss_markov_process_stays_one():
    """Its spectrum has the white noise as its floor: that is no filter."""
    model = st.NoiseModel(
        channels={
            "gyro_x": ChannelModel(terms={"random_walk": 1e-4}, gauss_markov=(GaussMarkov(sigma=5e-4, time=0.3),))
        }
    )
    record = st.simulate(model, duration=N / RATE, rate=RATE, rng=seed_of("Gauss-Markov over white"))
    fitted = analyzed(np.array(record.streams[0].column("gyro_x"))).fits["gyro_x"]
    (process,) = fitted.gauss_markov
    assert process.time.value == pytest.approx(0.3, abs=3 * (process.time.high - process.time.low) / (2 * 1.96))


def test_what_cannot_be_told_is_not_denied():
    """A filter and a line that wanders: no fit is adequate, and none says what the filter does to the other."""
    from scipy.signal import butter, lfilter

    white = np.random.default_rng(seed_of("filter and line")).normal(size=N) * 1e-3
    t = np.arange(N) / RATE
    line = 1e-3 * np.sin(2 * np.pi * (0.5 * t + 0.1 * t**2 / t[-1]))
    analysis = analyzed(lfilter(*butter(2, 10 / (RATE / 2)), white) + line)
    fitted = analysis.fits["gyro_x"]
    (finding,) = (f for f in analysis.findings if f.code == "low_pass_filter")
    assert fitted.verdict == "descriptive"
    assert fitted.tau_min == 1 / RATE
    assert finding.factors == ()
    assert finding.fit_effect.verdict == "descriptive"
    assert finding.fit_effect.verdict_without == "descriptive"


FAULTS = {
    "filter": ("low_pass_filter", lambda x: lowpassed(x, corner=4.0)),
    "line": ("spectral_line", lambda x: x + 2e-4 * np.sin(2 * np.pi * 7.3 * np.arange(N) / RATE)),
}


def lowpassed(x, corner):
    from scipy.signal import butter, lfilter

    return lfilter(*butter(1, corner / (RATE / 2)), x)


@pytest.mark.parametrize("fault", FAULTS)
def test_what_is_advised_can_be_done(fault):
    """From the averaging time that is advised on, the random walk is the sensor's own."""
    code, plant = FAULTS[fault]
    x = plant(np.random.default_rng(seed_of(f"advice {fault}")).normal(size=N) * 1e-3)
    record = st.Record.from_arrays(rate=RATE, gyro_x=x)
    (finding,) = (f for f in st.check(record) if f.code == code)
    tau_min = finding.details.tau_min
    fitted = st.analyze(record, tau_min=tau_min, threads=1).fits["gyro_x"]
    # On half octaves, of which it may leave out one and a half.
    assert tau_min <= fitted.tau_min < 1.6 * tau_min
    walk = fitted["random_walk"]
    assert walk.value == pytest.approx(1e-4, rel=0.01, abs=3 * (walk.high - walk.low) / (2 * 1.96))


def test_a_line_that_no_fit_gets_beyond():
    t = np.arange(N) / RATE
    x = np.random.default_rng(seed_of("slow line")).normal(size=N) * 1e-3 + 2e-3 * np.sin(2 * np.pi * 0.05 * t)
    (finding,) = (f for f in st.check(st.Record.from_arrays(rate=RATE, gyro_x=x)) if f.code == "spectral_line")
    assert finding.details.clear_from is None
    assert finding.details.tau_min == 0


def test_a_fit_that_is_not_adequate_begins_there_too():
    t = np.arange(N) / RATE
    line = 1e-3 * np.sin(2 * np.pi * (0.1 * t + 0.02 * t**2 / t[-1]))
    x = np.random.default_rng(seed_of("begins there")).normal(size=N) * 1e-3 + line
    fitted = st.analyze(st.Record.from_arrays(rate=RATE, gyro_x=x), tau_min=0.5, threads=1).fits["gyro_x"]
    assert fitted.verdict == "descriptive"
    assert fitted.tau_min == pytest.approx(0.64)


@pytest.mark.parametrize("looked_at", [0, 1, 63, -5, True, 1e5])
def test_so_few_samples_are_no_check(looked_at):
    record = st.Record.from_arrays(rate=RATE, gyro_x=noise("looked at"))
    with pytest.raises(st.OptionError, match="`looked_at` must be a whole number"):
        st.check(record, looked_at=looked_at)


@pytest.mark.parametrize("rate", [1e300, 1e-300, 1e16, True, float("nan"), float("inf"), -1.0])
def test_no_such_rate(rate):
    with pytest.raises(st.OptionError, match="`rate` must be a positive number"):
        st.Record.from_arrays(rate=rate, gyro_x=np.zeros(1000))


@pytest.mark.parametrize("rate", [1e-15, 1e15])
def test_extreme_rates_are_analysed(rate):
    x = np.random.default_rng(seed_of(f"rate {rate}")).normal(size=1000)
    assert st.analyze(st.Record.from_arrays(rate=rate, gyro_x=x)).fits["gyro_x"].n == 1000
