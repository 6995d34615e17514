"""Joint fits: identities with single fits, coverage and false alarms by Monte Carlo, runs that do not belong, refusals."""

import json
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, OptionError, Record, fit_channel, fit_jointly
from sigmatau._native import likelihood as native
from sigmatau.noise.terms import NOISE

ALL = NOISE


def samples(seed, n=8192, rate=10.0, walk=1.0, slow=0.0):
    rng = np.random.default_rng(seed_of(seed))
    x = walk * math.sqrt(rate) * rng.standard_normal(n)
    return x + np.cumsum(slow / math.sqrt(rate) * rng.standard_normal(n))


def record(seed, rate=10.0, channels=("gyro_x",), **more):
    columns = {name: samples(f"{seed} {name}", rate=rate, **more) for name in channels}
    return Record.from_arrays(rate=rate, unit={"gyro": "rad/s"}, **columns)


def test_a_run_twice_has_the_values_of_one():
    """Of the kernel: the package refuses the same run twice."""
    one = native.summarize([samples("twice", slow=0.1)], samples=8192, tau0=0.1)
    wanted = ("random_walk", "rate_random_walk")
    alone = dict(one.fit(terms=wanted, filter=False, processes=False, resonances=False).model)
    both = native.fit_jointly([(one, [], 8192, [])] * 2, terms=wanted, common=ALL, processes=False)
    model = dict(both.fit.model)
    for term in wanted:
        # Fits end where a step gains 1e-4 of deviance: a hundredth of a standard error.
        assert model[term] == pytest.approx(alone[term], rel=5e-4)
        for run in both.runs:  # a run has nothing to say against itself
            assert dict(run.own)[term].value == pytest.approx(model[term], rel=5e-4)
            assert run.p_value == 1.0


def test_levels_are_those_of_single_runs():
    """The runs share no term that ties them: each has the random walk of its own fit."""
    days = [record(f"levels {k}", walk=size) for k, size in enumerate((0.8, 1.0, 1.1, 1.3))]
    found = fit_jointly(days)["gyro_x"]
    for run, day in zip(found.runs, days, strict=True):
        alone = fit_channel(day, "gyro_x")["random_walk"]
        error = (alone.high - alone.low) / 4
        assert run.values["random_walk"].value == pytest.approx(alone.value, abs=0.5 * error)
    # mean and standard deviation of the logarithms, which have small errors
    logs = np.log([run.values["random_walk"].value for run in found.runs])
    fitted = found.fit["random_walk"]
    assert math.log(fitted.value) == pytest.approx(logs.mean(), abs=0.01)
    assert found.spreads["random_walk"].relative == pytest.approx(logs.std(ddof=1), rel=0.02)
    half = 3.182 * logs.std(ddof=1) / 2  # Student's t with 3 degrees of freedom
    assert math.log(fitted.high / fitted.low) / 2 == pytest.approx(half, rel=0.05)
    assert found.spreads["random_walk"].p_value < 1e-10


@pytest.fixture(scope="module")
def weak():
    """Sets of seven runs with a rate random walk that one run hardly shows; the random walk differs by 2.5 %."""
    found = []
    for k in range(8):
        rng = np.random.default_rng(seed_of(f"joint weak {k}"))
        sizes = np.exp(0.025 * rng.standard_normal(7))
        days = [record(f"joint weak {k} {day}", walk=size, slow=0.01) for day, size in enumerate(sizes)]
        found.append(fit_jointly(days)["gyro_x"])
    return found


def test_seven_runs_show_what_one_does_not(weak):
    single = [run.fit["rate_random_walk"].observed for one in weak for run in one.runs]
    together = [one.fit["rate_random_walk"].observed for one in weak]
    assert np.mean(single) < 0.3
    assert np.mean(together) > 2 * np.mean(single)


def test_intervals_hold_the_truth(weak):
    gate = 0.95 - 3 * math.sqrt(0.95 * 0.05 / len(weak))
    for term, truth in (("random_walk", 1.0), ("rate_random_walk", 0.01)):
        stated = [one.fit[term] for one in weak]
        held = [s.low <= truth <= s.high if s.observed else truth <= s.upper_limit for s in stated]
        assert np.mean(held) >= gate, term


def test_absent_terms_and_other_runs_are_false_alarms(weak):
    limit = 0.05 + 3 * math.sqrt(0.05 * 0.95 / len(weak))
    for term in ("quantization", "bias_instability", "rate_ramp"):
        assert np.mean([one.fit[term].observed for one in weak]) <= limit, term
    named = np.mean([bool(one.outliers) for one in weak])
    assert named <= 0.01 + 3 * math.sqrt(0.01 * 0.99 / len(weak))
    assert np.mean([one.fit.verdict == "widened" for one in weak]) <= 0.02 + 3 * math.sqrt(0.02 * 0.98 / len(weak))


def test_the_result_prints_itself_and_is_json(weak):
    one = weak[0]
    assert "7 runs, 1.6 h together" in repr(one)
    assert json.loads(json.dumps(one.to_dict(), allow_nan=False))["common"] == list(one.common)
    assert json.dumps(one.fit.to_dict(), allow_nan=False)
    assert len(set(map(len, one.columns().values()))) == 1
    assert "<li>" in one._repr_html_()


@pytest.mark.parametrize("missing", [False, True])
def test_lengths_differ_and_samples_are_missing(missing):
    """The estimate of the whole is as good as the runs together."""
    held = 0
    for k in range(4):
        days = []
        for day, n in enumerate((4000, 8192, 16384)):
            x = samples(f"lengths {k} {day}", n=n, slow=0.05)
            if missing:
                x[n // 4 : n // 4 + 500] = np.nan
            days.append(Record.from_arrays(rate=10, gyro_x=x, unit={"gyro": "rad/s"}))
        fitted = fit_jointly(days)["gyro_x"].fit
        walk = fitted["rate_random_walk"]
        assert walk.observed
        held += walk.low <= 0.05 <= walk.high
        assert fitted.n == 16384
        assert fitted.runs == (400.0, 819.2, 1638.4)
    assert held >= 2  # 3.8 of 4 expected; 1 or none has a probability of 0.05 %


def test_the_run_that_differs_is_named_and_no_other():
    for factor, term in (({"slow": 0.5}, "rate_random_walk"), ({"walk": 1.6}, "random_walk")):
        days = [record(f"odd {term} 0 {day}", **{"slow": 0.05, **(factor if day == 3 else {})}) for day in range(7)]
        found = fit_jointly(days, names="abcdefg")["gyro_x"]
        assert found.outliers == ("d",)
        odd = found.runs[3]
        assert odd.cause == term
        assert odd.factor == pytest.approx(10 if term == "rate_random_walk" else 1.6, rel=0.6)
        assert f"d: {'rate' if term[0:4] == 'rate' else 'angle'} random walk" in repr(found)


def test_ramps_of_all_runs_are_no_rate_random_walk():
    """Each run has a ramp that it does not show by itself; without ramps in all, they are a slow walk."""
    seen = 0
    for k in range(8):
        days = []
        for day in range(7):
            x = samples(f"ramps {k} {day}")
            time = np.arange(len(x)) / 10
            days.append(
                Record.from_arrays(rate=10, gyro_x=x + 4e-4 * (-1) ** day * time, unit={"gyro": "rad/s"})
            )  # 2.7 standard errors of a ramp in white noise, √12 N/T^1.5
        seen += fit_jointly(days)["gyro_x"].fit["rate_random_walk"].observed
    assert seen <= 2  # 0.4 expected; three or more have a probability of 0.6 %


def test_axes_of_a_triad():
    axes = ("gyro_x", "gyro_y", "gyro_z")
    joint = fit_jointly([record("triad", channels=axes, slow=0.5)], over="axes")
    assert list(joint) == ["gyro"]
    assert [run.name for run in joint["gyro"].runs] == list(axes)
    assert joint["gyro"].fit["rate_random_walk"].observed


def test_a_common_term_that_differs_has_levels():
    """K differs by 40 %: its interval is that of the mean over five runs, and each run has its own value."""
    held = refused = 0
    for k in range(8):
        sizes = 0.5 * np.exp(0.4 * np.random.default_rng(seed_of(f"refused {k}")).standard_normal(5))
        days = [record(f"refused {k} {day}", slow=size) for day, size in enumerate(sizes)]
        found = fit_jointly(days)["gyro_x"]
        walk = found.fit["rate_random_walk"]
        held += walk.low <= 0.5 <= walk.high
        if "rate_random_walk" in found.common:
            continue
        refused += 1
        assert found.spreads["rate_random_walk"].p_value < 0.05
        assert "rate_random_walk" not in found.homogeneity
        values = [run.values["rate_random_walk"] for run in found.runs]
        assert all(one.low < one.value < one.high for one in values)
        assert "rate_random_walk" not in found.runs[0].own
        assert "the interval is too narrow" not in repr(found)
    assert refused >= 5  # the error of one run is 6 %
    assert held >= 6  # 7.6 expected; 5 or fewer have a probability of 0.6 %


def test_no_term_is_common():
    days = [record(f"own {day}", slow=0.5 * (1 + 0.2 * (day - 2))) for day in range(5)]
    found = fit_jointly(days, common=())["gyro_x"]
    walk = found.fit["rate_random_walk"]
    assert found.spreads["rate_random_walk"].relative > 0.1
    # K differs by a third, so that its homogeneity is refused: it has levels in either case.
    same = fit_jointly(days)["gyro_x"].fit["rate_random_walk"]
    assert (same.low, same.value, same.high) == pytest.approx((walk.low, walk.value, walk.high), rel=1e-3)


class TestRefusals:
    def test_one_run(self):
        with pytest.raises(OptionError, match="needs 2 to 100 runs, not 1"):
            fit_jointly([record("one")])

    def test_the_same_run_twice(self):
        day = record("same")
        with pytest.raises(DataError, match="b: gyro_x has the same samples as a; give each run only once"):
            fit_jointly([day, day], names="ab")

    def test_other_rate(self):
        with pytest.raises(DataError, match="20 Hz, in run 1 it has 10 Hz"):
            fit_jointly([record("rate"), record("rate", rate=20.0)])

    def test_a_constant_channel(self):
        flat = Record.from_arrays(rate=10, gyro_x=np.full(8192, 0.5), unit={"gyro": "rad/s"})
        with pytest.raises(DataError, match=r"run 2: channel 'gyro_x' .*: it never changes"):
            fit_jointly([record("flat"), flat])

    def test_a_short_run(self):
        with pytest.raises(DataError, match=r"run 2: channel 'gyro_x' of 300 samples .*too few"):
            fit_jointly([record("short"), record("shorter", n=300)])

    @pytest.mark.parametrize(
        ("option", "value"),
        [("over", "days"), ("common", ["rate_ramp"]), ("names", ["a"]), ("channels", ["gyro_q"]), ("level", 2.0)],
    )
    def test_options(self, option, value):
        with pytest.raises(OptionError, match=f"`{option}`"):
            fit_jointly([record("a"), record("b")], **{option: value})

    def test_no_common_channel(self):
        with pytest.raises(OptionError, match="no channel in common"):
            fit_jointly([record("x"), record("y", channels=("gyro_y",))])
