"""`tune`: the wrong noise of a filter from its innovations; against an exact likelihood and simulated Kalman filters."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.signal import lfilter
from studies.tune import SETTINGS, WRONG, cell, innovations
from studies.tune_filters import AIDED, AIDINGS, Setting, aided_innovations, moving_innovations

import sigmatau as st
from known import seed_of
from sigmatau.exporting.tuning.filters import SLOW, WHITE
from sigmatau.exporting.tuning.run import MEASUREMENT, constant_run, varying_run
from sigmatau.exporting.tuning.tune import _nis

GYRO = SETTINGS["consumer gyro, 20 min"]
RUNS = 5  # of each wrong number


def data(name, *, factors=(1.0, 1.0, 1.0), runs=1, duration=1200.0, setting=GYRO):
    """Innovations of a filter that assumes the true numbers times factors: of √R, N and K."""
    assumed = Setting(
        deviation=factors[0] * setting.deviation,
        noise=factors[1] * setting.noise,
        walk=factors[2] * setting.walk,
        interval=setting.interval,
        duration=duration,
    )
    true = Setting(
        deviation=setting.deviation,
        noise=setting.noise,
        walk=setting.walk,
        interval=setting.interval,
        duration=duration,
    )
    values, stated = innovations(true, assumed, runs, np.random.default_rng(seed_of(f"tune: {name}")))
    time = np.arange(len(values)) * setting.interval
    filter_ = st.BiasFilter(noise=assumed.noise, walk=assumed.walk)
    return [st.Innovations(time=time, innovation=series, variance=stated) for series in values.T], filter_


def judged(name, **options):
    (series,), filter_ = data(name, **options)
    return st.tune(series, filters=filter_)["innovation"]


def test_cause_direction_and_coverage():
    """Right in 90 %, nothing found in 95 %, factors covered in 95 %, each less 3 standard errors of this small number."""
    counts = {
        wrong: cell("consumer gyro, 20 min", wrong, RUNS, np.random.default_rng(seed_of(f"tune: {wrong}")))
        for wrong in WRONG
    }
    n = RUNS * (len(WRONG) - 1)
    right = sum(counts[wrong][0] for wrong in WRONG if wrong != "nothing")
    assert right / n > 0.90 - 3 * math.sqrt(0.9 * 0.1 / n)
    assert counts["nothing"][0] / RUNS > 0.95 - 3 * math.sqrt(0.95 * 0.05 / RUNS)
    covered = np.sum(list(counts.values()), axis=0)[2:] / (RUNS * len(WRONG))
    assert (covered > 0.95 - 3 * math.sqrt(0.95 * 0.05 / (RUNS * len(WRONG)))).all()


def test_exact_likelihood():
    """A Kalman filter with other numbers reruns the measurements that the innovations imply: same factors, in its errors."""
    result = judged("exact", factors=(0.5, 1.0, 2.0), duration=400.0)
    (series,), filter_ = data("exact", factors=(0.5, 1.0, 2.0), duration=400.0)
    matrices = filter_.matrices(interval=0.2, stated=series.stated)
    gain = matrices.F @ matrices.covariance @ matrices.H / matrices.innovation_variance
    state, measured = np.zeros(2), []
    for normalised in series.normalised:
        measured.append(state[0] + normalised)
        state = matrices.F @ state + gain * normalised

    p00, p01, _, p11 = (1e3 * matrices.covariance).ravel().tolist()

    def deviance(logs):
        """Minus twice the logarithm of the likelihood, by the recursion of a filter with a vague start."""
        r, white, slow = np.exp(2 * logs)
        (q00, q01), (_, q11) = (white * matrices.Q[WHITE] + slow * matrices.Q[SLOW]).tolist()
        angle, rate, a, b, c, total = 0.0, 0.0, p00, p01, p11, 0.0
        for y in measured:
            variance, difference = a + r * matrices.R, y - angle
            total += math.log(variance) + difference**2 / variance
            g, h = a / variance, b / variance
            angle, rate = angle + rate + (g + h) * difference, rate + h * difference
            a, b, c = a - g * a, b - g * b, c - h * b
            a, b, c = a + 2 * b + c + q00, b + c + q01, c + q11
        return total

    exact = np.exp(minimize(deviance, np.zeros(3), method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3}).x)
    for factor, value in zip(result.factors, exact, strict=True):
        # The periodogram is without the mean, whose share in what is known of K is the largest.
        limit = 0.2 if factor.noise == SLOW else 0.1  # of the interval, which is four standard errors
        assert abs(math.log(factor.value / value)) < limit * math.log(factor.high / factor.low), factor.noise


def test_shares_of_a_right_filter_are_white():
    frequency = np.geomspace(1e-5, 0.5, 50)
    bias = st.BiasFilter(noise=1e-4, walk=1e-5).matrices(interval=0.2, stated=1.5e-8)
    turning = st.FilterMatrices(
        F=[[1, 0.1, 0], [0, 1, 0.1], [0, 0, 0.99]], H=[1, 0, 0], R=0.3,
        Q={"white": np.diag([0.01, 0, 0]), "jerk": np.diag([0, 0, 1e-3]), "both": 1e-4 * np.ones((3, 3))},
    )  # fmt: skip
    for filter_ in (bias, turning):
        run = constant_run(filter_.steps, filter_.covariance, np.array([filter_.R]))
        spectra = run._constant_shares(frequency)[..., 0, 0]
        assert spectra.sum(axis=0) == pytest.approx(np.ones(50), rel=1e-7)  # of the Riccati equation


def test_measurement_noise_from_the_stated_variance():
    (series,), filter_ = data("stated")
    result = st.tune(series, filters=filter_)["innovation"]
    assert result.factors[0].assumed == pytest.approx(GYRO.deviation, rel=1e-3)  # S is stationary to 1e-3
    assert [factor.assumed for factor in result.factors[1:]] == [GYRO.noise, GYRO.walk]
    stated = st.BiasFilter(noise=filter_.noise, walk=filter_.walk, deviation=GYRO.deviation)
    again = st.tune(series, filters=stated)["innovation"]
    assert again.factors[0].value == pytest.approx(result.factors[0].value, rel=1e-3)
    with pytest.raises(st.OptionError, match="times that of the filter"):
        st.tune(series, filters=st.BiasFilter(noise=1e-4, walk=1e-5, deviation=1e-3))


def test_matrices_are_the_same_filter():
    (series,), filter_ = data("matrices", factors=(1.0, 1.0, 0.3))
    dt = GYRO.interval
    matrices = st.FilterMatrices(
        F=[[1, dt], [0, 1]], H=[1, 0], R=GYRO.deviation**2,
        Q={
            "white": np.diag([filter_.noise**2 * dt, 0.0]),
            "slow": filter_.walk**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]),
        },
    )  # fmt: skip
    ours, theirs = (st.tune(series, filters=each)["innovation"] for each in (filter_, matrices))
    assert [cause.noise for cause in ours.causes] == [cause.noise for cause in theirs.causes] == [SLOW]
    for a, b in zip(ours.factors, theirs.factors, strict=True):
        assert b.value == pytest.approx(a.value, rel=0.01)  # R differs by the error of a stationary S


def test_one_factor_on_all_noises_is_a_unit():
    (series,), filter_ = data("units")
    degrees = st.Innovations(time=series.time, innovation=np.degrees(series.innovation), variance=series.variance)
    result = st.tune(degrees, filters=filter_)["innovation"]
    assert result.common_factor == pytest.approx(math.degrees(1), rel=0.05)
    assert "57.3 is degrees instead of radians" in result.statements()[0]
    for factor in (1e6, math.degrees(1) ** 2):  # S, whose filter is not that of N and K
        scaled = st.Innovations(time=series.time, innovation=series.innovation, variance=factor * series.variance)
        result = st.tune(scaled, filters=filter_)["innovation"]
        assert result.verdict == "wrong"
        assert result.common_factor == pytest.approx(1 / math.sqrt(factor), rel=0.05)
    assert judged("two units", factors=(1 / 3, 1 / 3, 1.0), duration=2400.0).common_factor is None


def test_outliers_are_no_noise():
    (series,), filter_ = data("outliers")
    spoiled = series.innovation.copy()
    spoiled[[100, 900]] *= 1e3
    result = st.tune(st.Innovations(time=series.time, innovation=spoiled, variance=series.variance), filters=filter_)
    assert (result["innovation"].verdict, result["innovation"].outliers) == ("outliers", 2)
    assert result["innovation"].first_outlier == pytest.approx(series.time[100])


def test_what_is_sure_and_changes_nothing_is_not_wrong():
    rng = np.random.default_rng(seed_of("tune: immaterial"))
    n, stated = 100_000, 1.5e-8
    nu = 1.02 * math.sqrt(stated) * rng.standard_normal(n)
    series = st.Innovations(time=np.arange(n) / 5, innovation=nu, variance=np.full(n, stated))
    result = st.tune(series, filters=st.BiasFilter(noise=1e-4, walk=1e-5))["innovation"]
    assert result.p_value < 1e-6
    assert result.verdict == "consistent"


def test_two_noises_are_wrong():
    result = judged("two", factors=(1 / 3, 1 / 3, 1.0), duration=2400.0)
    assert [(cause.noise, cause.direction) for cause in result.causes] == [
        (MEASUREMENT, "too small"), (WHITE, "too small"),
    ]  # fmt: skip
    assert result.nis_low > 5  # of 9, less what is of K
    assert "white process noise N is too small: multiply it by" in " ".join(repr(result).split())


def test_a_short_run_does_not_tell():
    """Of twenty short runs of a filter whose N is hardly in its innovations none has a wrong cause."""
    hidden = Setting(noise=1e-3, walk=1e-4, deviation=0.01, interval=0.2, duration=0.0)
    series, filter_ = data("short", setting=hidden, factors=(1.0, 1 / 5, 1.0), runs=20, duration=400.0)
    results = [st.tune(each, filters=filter_)["innovation"] for each in series]
    assert any(result.verdict == "ambiguous" for result in results)
    assert sum(result.verdict == "wrong" and result.causes[0].noise != WHITE for result in results) <= 2
    unsure = next(result for result in results if result.verdict == "ambiguous")
    assert "does not show the cause" in repr(unsure)


def test_a_line_is_not_explained():
    (series,), filter_ = data("line")
    shaken = st.Innovations(
        time=series.time,
        innovation=series.innovation + 1e-4 * np.sin(2 * np.pi * 0.3 * series.time),
        variance=series.variance,
    )
    result = st.tune(shaken, filters=filter_)["innovation"]
    assert result.verdict == "not explained"
    assert not result.causes
    assert "Add the rate of motion to the table" in " ".join(repr(result).split())


def test_an_offset_is_not_consistent():
    (series,), filter_ = data("offset")
    biased = st.Innovations(
        time=series.time,
        innovation=series.innovation + 0.2 * np.sqrt(series.variance),
        variance=series.variance,
    )
    for known_filter in (filter_, None):
        result = st.tune(biased, filters=known_filter)["innovation"]
        assert (result.verdict, result.causes) == ("offset", ())
        assert result.mean == pytest.approx(0.2, abs=3 * math.sqrt(1 / result.n))
        assert "has an offset that the filter does not estimate" in " ".join(repr(result).split())


def test_slow_noise_and_a_wrong_unit_are_no_offset():
    """Without a filter that explains them, the error of the mean is that of the slowest innovations, whatever their unit."""
    runs, filter_ = data("slow", factors=(1.0, 1.0, 0.1), runs=20)
    assert sum(st.tune(series)["innovation"].verdict == "offset" for series in runs) <= 1
    scaled = st.Innovations(time=runs[0].time, innovation=1e6 * runs[0].innovation, variance=runs[0].variance)
    assert st.tune(scaled)["innovation"].verdict == "inconsistent"
    assert st.tune(scaled, filters=filter_)["innovation"].verdict == "not explained"


def test_without_a_filter():
    (series,), _ = data("unknown")
    right = st.tune(series)["innovation"]
    assert right.verdict == "consistent"
    assert "Give N and K of the filter" in repr(right)
    (series,), _ = data("unknown", factors=(1.0, 1.0, 1 / 3))
    result = st.tune({"gyro_x": series})["gyro_x"]
    assert (result.verdict, result.factors, result.p_misfit) == ("inconsistent", (), None)
    assert "larger than stated at averaging times from" in " ".join(repr(result).split())
    assert "Give N and K of the filter" in repr(result)
    (series,), _ = data("unknown", factors=(3.0, 1.0, 1.0))
    assert "smaller than stated" in repr(st.tune(series))


def test_whiteness_of_white_innovations():
    """Of 15 white series each ratio is in its interval in 95 %, less 3 standard errors of its averages."""
    rng = np.random.default_rng(seed_of("tune: white"))
    time = np.arange(1000.0)
    ones = np.ones(1000)
    curves = [
        st.tune(st.Innovations(time=time, innovation=rng.standard_normal(1000), variance=ones))["innovation"].whiteness
        for _ in range(15)
    ]
    assert curves[0].m.tolist() == [1, 2, 4, 8, 16, 32, 64]
    inside = 1 - np.mean([curve.is_outside for curve in curves], axis=0)
    assert (inside > 0.95 - 3 * math.sqrt(0.95 * 0.05 / 15)).all()


def test_interval_of_the_nis_counts_the_correlation():
    """A first-order process with φ = 0.8: its mean square has 1 − φ⁴ over 1 + … fewer independent squares."""
    rng = np.random.default_rng(seed_of("tune: correlated"))
    phi, held, widths = 0.8, 0, []
    for _ in range(80):
        start, *steps = rng.standard_normal(1000)
        x = lfilter([1.0], [1.0, -phi], np.r_[start, math.sqrt(1 - phi**2) * np.array(steps)])
        nis, low, high = _nis(x[:, None], np.ones((1000, 1), dtype=bool), 0.95)
        held += low < 1 < high
        widths.append((high - low) / nis)
    assert held / 80 > 0.95 - 3 * math.sqrt(0.95 * 0.05 / 80)
    # Σφ^{2|k|} = (1 + φ²)/(1 − φ²) squares for one independent; 2·1.96·√(2/n) for white noise.
    expected = 2 * 1.96 * math.sqrt(2 / 1000 * (1 + phi**2) / (1 - phi**2))
    assert np.median(widths) == pytest.approx(expected, rel=0.1)


def test_several_channels_and_their_time():
    series, filter_ = data("channels", runs=2)
    named = dict(zip(("gyro_x", "gyro_y"), series, strict=True))
    result = st.tune(named, filters={"gyro_x": filter_}, skip=100.0)
    assert list(result) == ["gyro_x", "gyro_y"]
    assert (len(result["gyro_x"].factors), len(result["gyro_y"].factors)) == (3, 0)
    assert result["gyro_x"].n == len(series[0].time) - 500
    assert result.plot().axes[0].get_xscale() == "log"
    content = result.to_dict()["gyro_x"]
    assert content["interval_s"] == 0.2
    assert [factor["noise"] for factor in content["factors"]] == [MEASUREMENT, WHITE, SLOW]


def arrays(n=200, **changed):
    rng = np.random.default_rng(seed_of("tune: arrays"))
    return {"time": np.arange(n) / 5, "innovation": rng.standard_normal(n), "variance": np.ones(n)} | changed


@pytest.mark.parametrize(
    ("changed", "error", "words"),
    [
        ({"variance": np.r_[np.ones(150), 0.0, np.ones(49)]}, st.DataError, "not positive at index 150"),
        ({"variance": -np.ones(200)}, st.DataError, "not positive at index 0"),
        ({"innovation": np.r_[np.zeros(7), np.nan, np.ones(192)]}, st.DataError, "not finite, the first at index 7"),
        ({"time": np.arange(200)[::-1]}, st.DataError, "does not increase at index 1"),
        ({"time": np.r_[np.arange(199), 198]}, st.DataError, "does not increase at index 199"),
        ({"innovation": np.full(200, 0.25)}, st.DataError, "constant, 0.25"),
        ({"variance": np.ones(199)}, st.DataError, "`time` has"),
        ({"innovation": 1e12 * np.arange(200)}, st.DataError, "Check the units of it"),
    ],
)
def test_bad_innovations(changed, error, words):
    with pytest.raises(error, match=words):
        st.Innovations(**arrays(**changed))


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"variance": np.geomspace(10, 1, 200)}, "S falls from 8.91 to 1.12: the filter still converges"),
        ({"variance": np.tile([1.0, 2.0], 100)}, "S alternates between 1 and 2"),
    ],
)
def test_a_filter_that_converges_or_two_sensors(changed, words):
    series = st.Innovations(**arrays(**changed))
    with pytest.raises(st.DataError, match=words):
        st.tune(series, filters=st.BiasFilter(noise=0.1, walk=0.01))


def test_too_few_innovations():
    with pytest.raises(st.RecordTooShortError, match="At least 100") as caught:
        st.Innovations(**arrays(n=99))
    assert (caught.value.need, caught.value.got) == (100, 99)
    with pytest.raises(st.RecordTooShortError):
        st.tune(st.Innovations(**arrays()), skip=39.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"filters": {"gyro_q": st.BiasFilter(noise=1, walk=1)}}, "the innovations are of innovation"),
        ({"filters": "px4"}, "must be a BiasFilter or FilterMatrices, not str"),
        ({"filters": st.BiasFilter(noise=5.0, walk=1.0)}, "make a larger S than the stated 1"),
        ({"filters": st.FilterMatrices(F=[[1]], H=[1], Q={"q": [[1]]}, R=1)}, "times that of the filter"),
        ({"skip": -1.0}, "not negative"),
        ({"level": 95}, "between 0 and 1"),
    ],
)
def test_wrong_options(options, words):
    with pytest.raises(st.OptionError, match=words):
        st.tune(st.Innovations(**arrays()), **options)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"F": [[1, 2]]}, "must be"), ({"R": 0.0}, "positive variance"), ({"Q": {}}, "mapping"), ({"Q": [[1.0]]}, "mapping"),
        ({"Q": {"q": [[-1.0]]}}, "covariance"), ({"Q": {"q": np.eye(2)}}, "shape"), ({"H": [np.nan]}, "finite"),
    ],
)  # fmt: skip
def test_wrong_matrices(changed, words):
    with pytest.raises(st.OptionError, match=words):
        st.FilterMatrices(**({"F": [[1.0]], "H": [1.0], "Q": {"q": [[1.0]]}, "R": 1.0} | changed))


def moving(name, wrong=(1.0, 1.0, 1.0), **changed):
    """Innovations with their rate, of a filter whose sensor has a scale error or whose measurement is late."""
    errors = {"scale": 0.0, "delay": 0.0, "of_sensor": False} | changed
    rng = np.random.default_rng(seed_of(f"tune: {name}"))
    time, values, stated, rates = moving_innovations(
        errors["scale"], errors["delay"], np.array(wrong), 1, rng, of_sensor=errors["of_sensor"], duration=400.0
    )
    filter_ = st.BiasFilter(noise=wrong[1] * GYRO.noise, walk=wrong[2] * GYRO.walk)
    series = st.Innovations(time=time, innovation=values[0], variance=stated, rate=rates[0])
    return series, filter_


def test_scale_and_delay_beside_a_wrong_noise():
    series, filter_ = moving("moving", (1.0, 1 / 3, 1.0), scale=2e-3, delay=-2e-3)
    result = st.tune(series, filters=filter_)["innovation"]
    scale, delay = result.motion
    assert (result.verdict, result.noise_verdict) == ("motion", "wrong")
    assert [cause.noise for cause in result.causes] == [WHITE]
    for effect, true in ((scale, 2e-3), (delay, -2e-3)):
        assert effect.has_error
        assert effect.value == pytest.approx(true, abs=2 * effect.resolution)  # four standard errors
        assert effect.resolution < 0.05 * abs(true)
    text = " ".join(repr(result).split())
    assert "The scale of the sensor is too large: its error is 0.20" in text
    assert "The measurement is early: its delay is -" in text
    without = st.Innovations(time=series.time, innovation=series.innovation, variance=series.variance)
    assert st.tune(without, filters=filter_)["innovation"].verdict == "not explained"


def test_motion_is_not_claimed_where_it_cannot_be_seen():
    series, filter_ = moving("still", of_sensor=True)
    right = st.tune(series, filters=filter_)["innovation"]
    assert (right.verdict, [effect.has_error for effect in right.motion]) == ("consistent", [False, False])
    assert all(effect.is_shown for effect in right.motion)
    # Without motion the rate of the sensor is its noise, which is in the innovations too.
    true, _ = moving("still")
    noise = series.rate - true.rate
    weak = 0.02 * true.rate
    for rate, words in ((weak, "does not show a scale error below"), (noise, "Turn the"), (0 * noise, "Turn the")):
        changed = st.Innovations(time=series.time, innovation=series.innovation, variance=series.variance, rate=rate)
        result = st.tune(changed, filters=filter_)["innovation"]
        assert (result.verdict, [effect.has_error for effect in result.motion]) == ("consistent", [False, False])
        assert words in " ".join(repr(result).split())


def aided(name, kind, true, runs=1):
    """Innovations of filters with several measurements or a varying S, which assume the true numbers over `true`."""
    rng = np.random.default_rng(seed_of(f"tune: {name}"))
    time, values, stated = aided_innovations(AIDINGS[kind], 1 / np.array(true), runs, rng, duration=400.0)
    if values.shape[2] == 1:
        values, stated = values[..., 0], stated[:, 0, 0]
    filter_ = st.BiasFilter(noise=AIDED.noise / true[-2], walk=AIDED.walk / true[-1])
    return {
        str(k): st.Innovations(time=time, innovation=each, variance=stated) for k, each in enumerate(values)
    }, filter_


@pytest.mark.parametrize(
    ("kind", "true", "cause"),
    [
        ("Two measurements at once", (1, 3, 1, 1), ("measurement 2", "too small")),
        ("Two sensors at times of their own", (1 / 3, 1, 1, 1), ("measurement 1", "too large")),
        ("R that the filter adapts", (1, 3, 1), (WHITE, "too small")),
        ("Dropouts", (1, 1, 1 / 3), (SLOW, "too large")),
    ],
)
def test_several_measurements_and_a_varying_s(kind, true, cause):
    series, filter_ = aided(kind, kind, true)
    result = st.tune(series, filters=filter_)["0"]
    assert [(each.noise, each.direction) for each in result.causes] == [cause]
    for factor, value in zip(result.factors, true, strict=True):
        # Twice as wide as the interval of 95 % in logarithms: four standard errors.
        assert factor.low**2 / factor.value < value < factor.high**2 / factor.value, factor.noise


def test_constant_and_varying_runs_agree():
    """Of the same filter the recursion along its run has the density of the closed form, and a gap is a step of F twice."""
    (series,), filter_ = data("agree", duration=200.0)
    matrices = filter_.matrices(interval=0.2, stated=series.stated)
    closed = constant_run(matrices.steps, matrices.covariance, np.array([matrices.R]))
    scaled = st.Innovations(time=series.time, innovation=series.normalised, variance=np.ones(len(series.time)))
    run = varying_run(matrices.steps, scaled)
    frequency = np.array([5, 20, 100, 400]) / len(series.time)
    assert run.measured.mean() == pytest.approx(matrices.R, rel=1e-3)
    assert run.shares(frequency) == pytest.approx(closed.shares(frequency), abs=0.01)  # of a run that begins and ends
    kept = np.arange(len(series.time)) % 7 != 3
    lossy = st.Innovations(time=series.time[kept], innovation=series.innovation[kept], variance=series.variance[kept])
    dt, n, k = 0.2, filter_.noise, filter_.walk
    by_matrices = st.FilterMatrices(
        F=[[1, dt], [0, 1]], H=[1, 0],
        Q={
            "white": np.diag([n**2 * dt, 0]),
            "slow": k**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]),
        },
    )  # fmt: skip
    ours, theirs = (st.tune(lossy, filters=each)["innovation"] for each in (filter_, by_matrices))
    assert [a.value for a in ours.factors] == pytest.approx([b.value for b in theirs.factors], rel=1e-6)


def test_an_offset_does_not_hide_a_wrong_noise():
    (series,), filter_ = data("both", factors=(1.0, 1 / 3, 1.0))
    biased = st.Innovations(
        time=series.time,
        innovation=series.innovation + 0.3 * np.sqrt(series.variance),
        variance=series.variance,
    )
    result = st.tune(biased, filters=filter_)["innovation"]
    assert (result.verdict, [cause.noise for cause in result.causes]) == ("offset", [WHITE])
    text = " ".join(repr(result).split())
    assert "has an offset" in text
    assert "white process noise N is too small" in text


@pytest.mark.parametrize("size", [1e-4, 30.0])
def test_the_root_of_s(size):
    """A standard deviation in place of S is said, whether it makes the innovations too small or too large."""
    rng = np.random.default_rng(seed_of("tune: root"))
    nu = size * rng.standard_normal(200)
    series = st.Innovations(time=np.arange(200) / 5, innovation=nu, variance=np.full(200, size))
    assert "S looks like a standard deviation" in repr(st.tune(series))
    with pytest.raises(st.DataError, match="looks like a standard deviation"):
        st.tune(series, filters=st.BiasFilter(noise=10 * math.sqrt(size), walk=size))
