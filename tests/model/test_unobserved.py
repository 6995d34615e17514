"""Terms that were not observed: three policies, the same in systems, records and files, which say what they have."""

import json
import math

import numpy as np
import pytest

from sigmatau import ChannelModel, Choices, NoiseModel, OptionError, export, simulate, simulate_to, state_space
from sigmatau.model.unobserved import find_unobserved, include_unobserved

LIMIT = 3e-6
MODEL = ChannelModel(
    terms={"random_walk": 1e-4, "bias_instability": 1e-5},
    limits={"rate_random_walk": LIMIT, "quantization": 1e-6, "bias_instability": 2e-5},
    rate=100.0,
)
SHARES = {"upper-limit": 1.0, "mean": 1 / math.sqrt(3), "absent": 0.0}


@pytest.mark.parametrize(("policy", "share"), SHARES.items())
def test_systems_have_what_the_policy_assumes(policy, share):
    """Beside what was observed, which keeps its value; quantization does not accumulate, and is absent."""
    system = state_space(MODEL, dt=0.01, unobserved=policy)
    has = "rate_random_walk" in system.inputs
    assert has == bool(share)
    if has:
        k = system.inputs.index("rate_random_walk")
        assert system.Qd[k, k] == pytest.approx((share * LIMIT) ** 2 * 0.01, rel=1e-12)
    assert not any("angle_error" in state for state in system.states)
    assert system.not_observed == ("rate_random_walk",)
    assert system.unobserved == policy
    assert "not observed: rate random walk; " in repr(system)
    assert system.to_dict()["unobserved"] == policy
    assert include_unobserved(MODEL, policy)["bias_instability"] == 1e-5


def test_the_default_of_a_system_is_the_model_itself():
    bare = state_space(ChannelModel(terms=dict(MODEL.terms)), dt=0.01)
    assert state_space(MODEL, dt=0.01).states == bare.states
    assert bare.not_observed == ()
    assert "not observed" not in repr(bare)


@pytest.mark.parametrize("policy", SHARES)
def test_records_have_what_the_policy_assumes(policy, tmp_path):
    model = NoiseModel(channels={"gyro_x": MODEL})
    explicit = NoiseModel(channels={"gyro_x": ChannelModel(terms=dict(include_unobserved(MODEL, policy).terms))})
    arguments = {"duration": 10, "rate": 100, "rng": 5}
    record = simulate(model, **arguments, unobserved=policy)
    samples, expected = (made.streams[0].column("gyro_x") for made in (record, simulate(explicit, **arguments)))
    np.testing.assert_array_equal(samples, expected)
    assert any("not observed: rate random walk; " in text for text in record.provenance.conversions)
    written = simulate_to(tmp_path / "log.npz", model, **arguments, unobserved=policy)
    assert len(written.unobserved) == 1
    assert simulate_to(tmp_path / "log.npz", explicit, **arguments).unobserved == ()


@pytest.mark.parametrize(("policy", "share"), SHARES.items())
def test_files_have_what_the_policy_assumes(policy, share):
    model = NoiseModel(channels={"gyro_x": MODEL})
    content = json.loads(export(model, to="state-space", choices=Choices(unobserved=policy)))["systems"]["gyro_x"]
    assert ("bias" in content["states"]) == bool(share)
    assert "gyro_x: not observed: rate random walk; " in content["note"]
    chosen = Choices(unobserved=policy, walk={"gyro": 1e-7})
    of_choice = json.loads(export(model, to="state-space", choices=chosen))["systems"]["gyro_x"]
    assert "note" not in of_choice
    k = of_choice["inputs"].index("rate_random_walk")
    assert of_choice["Qd"][k][k] == pytest.approx(1e-16, rel=1e-12)
    strict = json.loads(export(model, to="state-space", choices=Choices(unobserved=policy, strict=True)))
    assert "bias" not in strict["systems"]["gyro_x"]["states"]


def test_a_file_with_a_third_state():
    """A walk and a process, with which a filter states its errors right up to the horizon; the note says what it states."""
    model = NoiseModel(
        channels={"gyro_x": MODEL, "temp": ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="K")}
    )
    choices = Choices(names={"form": "third-state"})
    content = json.loads(export(model.of(["gyro_x"]), to="state-space", choices=choices))["systems"]["gyro_x"]
    assert content["states"] == ["bias", "gauss_markov_1"]
    assert content["R"] == [[pytest.approx(1e-8 / 0.01, rel=1e-12)]]
    assert "gyro with a third state: a filter states " in content["note"]
    assert "bias covariance right" in content["note"]
    with pytest.raises(OptionError, match="neither a gyro nor an accelerometer"):
        export(model, to="state-space", choices=Choices(names={"form": "third-state"}, step=0.01))


@pytest.mark.parametrize(
    "function", [lambda p: state_space(MODEL, dt=0.01, unobserved=p), lambda p: Choices(unobserved=p)]
)
def test_an_unknown_policy(function):
    with pytest.raises(OptionError, match="'upper-limit'"):
        function("maximum")
    assert find_unobserved(MODEL) == ("rate_random_walk",)
