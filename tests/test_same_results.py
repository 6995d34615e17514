"""The comparison of the results of two checkouts sees what differs, and no more."""

from benches.same_results import differences


def test_same_results():
    finding = {"code": "spikes", "channels": ["gyro_x"], "size": 2.0, "message": "2 spikes"}
    before = {"sigmatau": "1", "findings": [finding, {"code": "gaps", "channels": []}], "channels": {"x": {"p": 0.5}}}
    reworded = {**before, "sigmatau": "2", "findings": [*reversed(before["findings"])]}
    reworded["findings"][1] = finding | {"message": "Two spikes", "size": 2.0 * (1 + 1e-13)}
    assert list(differences(before, reworded)) == []
    assert list(differences(before, {**before, "channels": {"x": {"p": 0.5 * (1 + 1e-11)}}}))
    assert list(differences(before, {**before, "findings": before["findings"][1:]}))
    assert list(differences(before, {**before, "channels": {"x": {"p": 0.5, "q": 1}}}))
    assert list(differences(before, {**before, "findings": [finding | {"size": 3.0}, before["findings"][1]]}))
