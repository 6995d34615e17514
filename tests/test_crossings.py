"""One typed result: what an analysis and an export go through in the package, and that no JSON is on the way."""

import importlib
import pkgutil

import pytest
from benches import crossings

import sigmatau
from sigmatau.exporting.targets import NAMES


@pytest.fixture(scope="module")
def analysis():
    return sigmatau.analyze(crossings.simulated(), threads=1)


def test_crossings_have_a_limit():
    counted = crossings.counted()
    assert 0 < counted["analyze"].crossings <= crossings.ANALYZE_LIMIT
    assert 0 < counted["kalibr"].crossings <= crossings.KALIBR_LIMIT


def test_calls_within_a_file_do_not_cross():
    traced = crossings.trace(lambda: sigmatau.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}}))
    assert traced.calls > traced.crossings > 0
    assert crossings.trace(lambda: None) == (0, 0, 0, 0)


@pytest.fixture(scope="module")
def sheet():
    return sigmatau.datasheet("icm42688p")  # its file is TOML


@pytest.fixture
def without_json(monkeypatch):
    """Every `to_dict` and `from_dict` of the package, and the reader of results, as a failure."""

    def refused(*_, **__):
        raise AssertionError("JSON on the way")

    for module in pkgutil.walk_packages(sigmatau.__path__, "sigmatau."):
        if module.name.startswith(("sigmatau.cli", "sigmatau.lab.store", "sigmatau.__main__")):
            continue
        for value in list(vars(importlib.import_module(module.name)).values()):
            if isinstance(value, type) and value.__module__ == module.name:
                for name in {"to_dict", "from_dict", "to_json", "from_json"} & vars(value).keys():
                    monkeypatch.setattr(value, name, refused)
    for name in ("to_dict", "with_joint", "to_json"):
        monkeypatch.setattr(f"sigmatau.analysis.json.{name}", refused)
    monkeypatch.setattr("sigmatau.analysis.reading.result_of_dict", refused)


def test_json_is_refused(analysis, without_json):
    for write in (analysis.to_dict, analysis.to_json, analysis["gyro_x"].to_dict):
        with pytest.raises(AssertionError, match="on the way"):
            write()


@pytest.mark.parametrize("target", [name for name in NAMES if name != "model"])
def test_no_json_on_the_way_to_an_export(analysis, without_json, target):
    choices = sigmatau.Choices(step=0.01) if target in ("px4", "ardupilot", "state-space") else None
    assert analysis.export(to=target, choices=choices)


def test_no_json_on_the_way_to_predictions_and_judgements(analysis, sheet, without_json):
    assert sigmatau.predict(analysis.model, after=[60.0], rate=50.0)
    assert sigmatau.compare_with(analysis, sheet, sided="one", bias="minimum")
    assert sigmatau.compare_runs([analysis, analysis], names=["1", "2"])
    assert sigmatau.judge_lot({"A1": analysis})
