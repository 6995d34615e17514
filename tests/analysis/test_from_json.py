"""`Analysis.from_json`: what was written is read back, by this version and by earlier ones; damage is named."""

import copy
import json
from dataclasses import MISSING, fields, replace

import jsonschema
import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau import Analysis, DataError, analyze
from sigmatau.exporting.targets import NAMES
from sigmatau.findings.reasons import Misfit, StatedReason, UnmodelledBand
from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.fitted_matern import FittedMatern
from sigmatau.fitting.fitted_values import (
    FittedGaussMarkov,
    FittedResonance,
    FittedSinusoid,
    FittedTerm,
    FittedWarmUp,
    Interval,
    SecondModel,
)
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.response import FittedFilter
from sigmatau.model.parameters import Covariance, Parameter
from sigmatau.model.processes import LowPass

SCHEMA = jsonschema.Draft202012Validator(
    json.loads((ROOT / "python" / "sigmatau" / "schema" / "result-2.schema.json").read_text(encoding="utf-8"))
)
FROZEN = sorted((ROOT / "tests" / "release" / "frozen").glob("result-*-by-*.json"))
LINES = st.ChannelModel(
    terms={"random_walk": 1e-4},
    sinusoid=(st.Sinusoid(amplitude=1e-3, frequency=7.0),),
    gauss_markov=(st.GaussMarkov(sigma=3e-4, time=5.0),),
    bandwidth=st.LowPass(order=2, corner=12.0),
)


def record_of(noise, *, duration=900.0, rate=50.0, damaged=False, moving=False):
    model = st.NoiseModel(channels={"gyro_x": noise, "gyro_y": noise})
    record = st.simulate(model, duration=duration, rate=rate, rng=seed_of(f"{noise} {duration}"))
    columns = {name: record.stream_of(name).column(name).copy() for name in model}
    for x in columns.values():
        if damaged:
            x[1000:1100] = np.nan
            x[5000] += 1.0
        if moving:
            x += 0.5 * np.sin(np.arange(len(x)) / 50)
    return st.Record.from_arrays(rate=rate, unit={"gyro": "rad/s"}, **columns)


RESULTS = {
    "plain": lambda: analyze(record_of({"random_walk": 1e-4, "rate_random_walk": 1e-5}), notes={"run": "3"}),
    "lines, a process and a filter": lambda: analyze(record_of(LINES, rate=100.0)),
    "gaps and spikes": lambda: analyze(record_of({"random_walk": 1e-4}, damaged=True)),
    "least squares": lambda: analyze(record_of(LINES), method="gls", tau_min=0.5),
    "read off": lambda: analyze(record_of({"random_walk": 1e-4}), method="read-off", taus=[0.1, 1, 10]),
    "maps": lambda: analyze(record_of({"random_walk": 1e-4}, damaged=True), stability=True),
    "moving": lambda: analyze(record_of({"random_walk": 1e-4}, moving=True)),
    "taken as at rest": lambda: analyze(record_of({"random_walk": 1e-4}, moving=True), at_rest=True),
    "too short": lambda: analyze(record_of({"random_walk": 1e-4}, duration=4.0)),
    "ninths of a second": lambda: analyze(record_of({"random_walk": 1e-4}, duration=400.0, rate=9.7)),
    "paper's counting": lambda: analyze(record_of({"random_walk": 1e-4}), overlap="none", counting="paper"),
}


@pytest.mark.parametrize("name", RESULTS)
def test_what_was_written_is_read_back(name):
    analysis = RESULTS[name]()
    text = analysis.to_json()
    SCHEMA.validate(json.loads(text))
    back = Analysis.from_json(text)
    assert back.to_dict() == analysis.to_dict()
    assert Analysis.from_dict(json.loads(text)).to_json() == text
    assert Analysis.from_json(text.encode()).to_json() == text
    assert list(back.findings) == list(analysis.findings)
    assert {name: fit.trust for name, fit in back.fits.items()} == {n: f.trust for n, f in analysis.fits.items()}
    if analysis.fits and any(fit.model for fit in analysis.fits.values()):
        assert back.model == analysis.model
        for to in NAMES:
            assert exported(back, to) == exported(analysis, to)


def exported(analysis, to):
    try:
        return analysis.export(to=to, choices=st.Choices(filter_rate=100.0, walk={"gyro": 1e-6}, noise={"gyro": 1e-4}))
    except (DataError, st.OptionError) as error:
        return str(error)


def interval(value):
    return Interval(value=value, low=0.9 * value, high=1.1 * value, unit="rad/s")


FULL = NoiseFit(
    channel="gyro_x",
    quantity="angular_rate",
    rate_unit="rad/s",
    n=12_000,
    tau0=0.02,
    terms={
        "random_walk": FittedTerm(
            term="random_walk",
            unit="rad/sqrt(s)",
            observed=True,
            level=0.9,
            value=1e-4,
            low=0.9e-4,
            high=1.1e-4,
            p_value=0.0,
        ),
        "rate_ramp": FittedTerm(term="rate_ramp", unit="rad/s^2", observed=False, level=0.9, upper_limit=1e-9),
    },
    gauss_markov=(FittedGaussMarkov(sigma=interval(1e-5), time=interval(30.0)),),
    sinusoid=(FittedSinusoid(amplitude=interval(1e-3), frequency=interval(7.0)),),
    resonance=(FittedResonance(sigma=interval(1e-4), frequency=interval(3.0), width=interval(0.1)),),
    response=FittedFilter(
        coefficients=(0.5, 0.1),
        tau0=0.02,
        interval=0.04,
        shape="butterworth",
        order=2,
        corner=12.0,
        low=11.0,
        high=13.0,
        low_pass=LowPass(order=2, corner=12.1, rate=50.0),
        known_to=20.0,
    ),
    matern=FittedMatern(
        observed=True,
        sigma=interval(1e-4),
        upper_limit=2e-4,
        time=interval(30.0),
        smoothness=interval(0.3),
        terms={"random_walk": 1e-5},
        gauss_markov_p_value=0.02,
        gain=3.0,
        p_value=0.4,
    ),
    warm_up=FittedWarmUp(amplitude=interval(1e-4), time=300.0),
    regressors={"temperature": interval(1e-6)},
    highest=18.0,
    alike_from=200.0,
    alike_sigma=1e-5,
    second=(SecondModel(terms={"random_walk": 1e-4}, gauss_markov=((1e-5, 200.0), (2e-5, 9.0))),),
    discrepancy=((1.0, 0.1),),
    model={"random_walk": 1e-4},
    verdict="widened",
    reasons=(UnmodelledBand(highest=18.0), Misfit(p_value=None, tau_min=0.02, tau=1.0, ratio=1.5)),
    unclear=("bias_instability", "rate_random_walk"),
    tau_min=0.04,
    tau_max=80.0,
    p_value=0.2,
    covariance=Covariance.of(["random_walk", "gauss_markov_1.time"], [[1e-10, 1e-6], [1e-6, 9.0]]),
    level=0.9,
    method="likelihood",
    runs=(100.0, 240.0),
    adjustments=(
        Adjustment(
            cause="rounding",
            findings=("coarse_resolution",),
            changes=(
                Change(
                    Parameter("random_walk"), "widen", Ends(0.95e-4, 1.05e-4, None), Ends(0.9e-4, 1.1e-4, None), 2.0
                ),
                Change(Parameter("gauss_markov", 1, "time"), "limit", Ends(1.0, 2.0, None), Ends(None, None, None)),
            ),
            verdict="widened",
            without=("second",),
            tau_min=0.04,
        ),
    ),
    trust="partial",
)


def test_every_field_of_a_fit_is_read_back():
    """A field that is added to `NoiseFit` fails here until the JSON has it."""
    defaults = {one.name: one.default for one in fields(NoiseFit) if one.default is not MISSING}
    assert not [name for name, value in defaults.items() if name != "covariance" and getattr(FULL, name) == value]
    analysis = replace(RESULTS["plain"](), fits=st.analysis.result.Fits({"gyro_x": FULL}))
    (back,) = Analysis.from_json(analysis.to_json()).fits.values()
    for one in fields(NoiseFit):
        found, wanted = getattr(back, one.name), getattr(FULL, one.name)
        if one.name == "covariance":
            assert found.parameters == wanted.parameters
            np.testing.assert_array_equal(found.matrix, wanted.matrix)
        elif one.name not in ("n", "tau0"):  # of the curve
            assert found == wanted, one.name


@pytest.mark.parametrize("path", FROZEN, ids=lambda path: path.stem)
def test_results_of_earlier_versions_have_all_their_numbers(path):
    stated = json.loads(path.read_text(encoding="utf-8"))
    analysis = Analysis.from_json(path)
    for name, channel in stated["channels"].items():
        fit = analysis[name]
        assert fit.verdict == channel["fit"]["verdict"]
        for term, row in channel["fit"]["terms"].items():
            if term in fit:
                found = fit[term]
                assert [found.observed, found.value, found.low, found.high, found.upper_limit] == [
                    row.get(key) for key in ("observed", "value", "low", "high", "upper_limit")
                ]
        assert analysis.curves[name].adev.tolist() == channel["curve"]["adev"]
        assert {term: c.value for term, c in analysis.read_off[name].items()} == {
            term: row["value"] for term, row in channel["read_off"].items()
        }
    assert [one.code for one in analysis.findings] == [one["code"] for one in stated["findings"]]
    assert analysis.source.path == stated["source"]["path"]
    assert analysis.notes == stated.get("notes", {})
    assert Analysis.from_json(analysis.to_json()).to_dict() == analysis.to_dict()


def test_a_reason_in_words_alone_is_kept():
    content = Analysis.from_json(FROZEN[0]).to_dict()
    content["channels"]["gyro_x"]["fit"] |= {"verdict": "descriptive", "reason": "an older reason"}
    fit = Analysis.from_dict(content)["gyro_x"]
    assert fit.reasons == (StatedReason(text="an older reason"),)
    assert fit.to_dict()["reason"] == "an older reason"


def change(*path, value):
    def made(content):
        *keys, last = path
        for key in keys:
            content = content[key]
        content[last] = value

    return made


TERM = ("channels", "gyro_x", "fit", "terms", "random_walk")
DAMAGES = {
    "a text for a number": (change(*TERM, "value", value="1e-4"), "channels.gyro_x.fit.terms.random_walk.value: '1e-4'"),
    "true for a number": (change(*TERM, "low", value=True), "random_walk.low: True is not a number"),
    "a level of 2": (change(*TERM, "level", value=2), "random_walk.level is 2, not between 0 and 1"),
    "another verdict": (change("channels", "gyro_x", "fit", "verdict", value="fine"), "verdict: 'fine' is not adequate or"),
    "a channel that is a number": (change("channels", "gyro_x", value=3), "channels.gyro_x: 3 is not an object"),
    "no rate": (change("channels", "gyro_x", "sample_rate_hz", value=None), "channels.gyro_x: sample_rate_hz is missing"),
    "a rate of 0": (change("channels", "gyro_x", "sample_rate_hz", value=0), "sample_rate_hz is 0, not from"),
    "a shorter column": (change("channels", "gyro_x", "curve", "adev", value=[1.0]), "columns have several lengths"),
    "a text in a column": (change("channels", "gyro_x", "curve", "adev", value=["1"]), "curve.adev: .* list of numbers"),
    "a covariance of another size": (
        change("channels", "gyro_x", "fit", "covariance", "matrix", value=[]), "fit.covariance: the matrix is not",
    ),
    "a note that is a number": (change("notes", value={"run": 3}), "notes.run: 3 is not a text"),
    "findings that are a text": (change("findings", value="none"), "findings: 'none' is not a list"),
    "a verdict on rest": (change("rest", "verdict", value="asleep"), "rest.verdict: 'asleep' is not"),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_names_its_place(damage):
    alter, words = DAMAGES[damage]
    content = copy.deepcopy(json.loads(FROZEN[0].read_text(encoding="utf-8")))
    alter(content)
    with pytest.raises(DataError, match=f"not a result of sigmatau analyze, or changed: .*{words}"):
        Analysis.from_dict(content)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}", "it has no channels"),
        ("[]", "a result of sigmatau analyze is an object, not list"),
        (b"null", "an object, not NoneType"),
        (b"", "not JSON"),
        ("{", "not JSON"),
        ("[" * 100_000, "not JSON"),
        (b"\xff", "not JSON"),
        ('{"channels": {"gyro_x": NaN}}', "not JSON: NaN is not a number"),
        ('{"channels": {"gyro_x": {"quantity": "angular_rate", "sample_rate_hz": 1e999}}}', "inf is not a number"),
        ('{"channels": 3}', "it has no channels"),
        ('{"schema": 3, "channels": {}}', "schema 3 is of a newer version of sigmatau; update sigmatau"),
        ('{"channels": {}, "error": {"message": "no columns", "exit_code": 1}}', "the analysis failed: no columns"),
    ],
)
def test_what_is_no_result(text, words, tmp_path):
    with pytest.raises(DataError, match=words):
        Analysis.from_json(text)
    file = tmp_path / "r.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(DataError, match=rf"r\.json: .*{words}"):
        Analysis.from_json(file)


def test_a_file_that_is_not_there():
    with pytest.raises(DataError, match=r"missing\.json: No such file"):
        Analysis.from_json("missing.json")


def test_keys_of_later_versions_are_ignored():
    content = json.loads(FROZEN[0].read_text(encoding="utf-8"))
    wanted = Analysis.from_dict(content).to_dict()
    content["humidity"] = 0.5
    content["channels"]["gyro_x"]["fit"]["terms"]["flicker_walk"] = {"value": 1.0}
    assert Analysis.from_dict(content).to_dict() == wanted
