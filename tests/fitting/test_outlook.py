"""What more recording would show, against simulated records of the predicted lengths."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, allan, analyze, fit, simulate
from sigmatau.fitting.outlook import ENOUGH, outlook
from sigmatau.units import to_si

RATE, N = 100.0, 1e-4  # [Hz], [rad/√s]


def fitted(case, seconds, **terms):
    model = NoiseModel(channels={"gyro_x": {"random_walk": N, **terms}})
    record = simulate(model, duration=seconds, rate=RATE, rng=seed_of(case))
    return fit(allan(record)["gyro_x"])


def half_width(fit_):
    walk = fit_["random_walk"]
    return (walk.high - walk.low) / (2 * walk.value)


@pytest.mark.parametrize(("seconds", "terms"), [(4.0, {}), (16.0, {"quantization": 3e-6})])
def test_a_record_of_the_predicted_length_has_the_predicted_interval(seconds, terms):
    """Half of the intervals are narrower than ± 5 %; the law of the square root would say four times the length at 4 s."""
    needed, was = [], []
    for k in range(8):
        case = f"outlook {seconds} {sorted(terms)} {k}"
        before = fitted(case, seconds, **terms)
        expected = outlook({"gyro_x": before})
        if expected is None:
            continue
        assert expected.width == pytest.approx(half_width(before))
        needed.append(expected.needed)
        was.append(expected.width)
    assert min(was) > ENOUGH
    assert min(needed) > seconds
    length = float(np.median(needed))
    widths = [half_width(fitted(f"outlook of {length} {sorted(terms)} {k}", length, **terms)) for k in range(16)]
    # The widths scatter by a third from record to record: their mean by 8 %, the prediction by as much.
    assert np.mean(widths) == pytest.approx(ENOUGH, rel=0.3)


def test_the_value_is_within_the_predicted_interval():
    """± 5 % holds 95 % of the estimates of records of that length, whose scatter it is."""
    length = outlook({"gyro_x": fitted("outlook of a value", 8.0)}).needed
    errors = [fitted(f"outlook value {k}", length)["random_walk"].value / N - 1 for k in range(40)]
    inside = sum(abs(error) <= ENOUGH for error in errors)
    assert inside >= 34  # of 38 expected; 3 standard deviations
    assert np.std(errors) > 0.25 * ENOUGH  # the interval is not far too wide


def test_half_of_the_records_show_the_bias_instability():
    """By the whole analysis of a log of that length, to 3 standard errors and to the tolerance of studies/planning.py."""
    expected = outlook({"gyro_x": fitted("outlook of a term 5.0", 5.0)})
    assert expected.visible_in > 7.5
    model = NoiseModel(channels={"gyro_x": {"random_walk": N, "bias_instability": expected.hidden}})

    def is_shown(k):
        seed = seed_of(f"outlook visible {k}")
        record = simulate(model, duration=expected.visible_in, rate=RATE, rng=seed)
        return analyze(record, at_rest=True, threads=1).fits["gyro_x"]["bias_instability"].value is not None

    share = sum(map(is_shown, range(40))) / 40
    assert share == pytest.approx(0.5, abs=3 * math.sqrt(0.25 / 40) + 0.15)


def test_words():
    """What is enough; what is not yet, and when; and what a longer record would show."""
    long = outlook({"gyro_x": fitted("outlook words", 600.0)})
    assert long.needed == pytest.approx(600.0)
    assert str(long).startswith(f"angle random walk ± {100 * long.width:.2g} %, enough; a bias instability of ")
    assert f"{long.hidden / to_si(1.0, 'deg/h'):.2g} deg/h would be visible in " in str(long)
    short = outlook({"gyro_x": fitted("outlook words", 8.0)})
    assert f" %, ± 5 % in {short.needed:.3g} s" in str(short)


def test_the_worst_axis_counts():
    """The coefficients of a sensor are used together."""
    narrow, wide = fitted("outlook narrow", 60.0), fitted("outlook wide", 8.0)
    assert outlook({"gyro_x": narrow, "gyro_y": wide}) == outlook({"gyro_y": wide})


def test_no_interval_no_outlook():
    assert outlook({}) is None
    ramp = fit(
        allan(simulate(NoiseModel(channels={"gyro_x": {"rate_ramp": 1e-3}}), duration=60, rate=10, rng=1))["gyro_x"]
    )
    assert ramp["random_walk"].value is None
    assert outlook({"gyro_x": ramp}) is None


def test_a_term_that_is_visible_is_not_announced():
    shown = fitted("outlook shown", 200.0, bias_instability=2e-4)
    assert shown["bias_instability"].value is not None
    assert outlook({"gyro_x": shown}).hidden is None
