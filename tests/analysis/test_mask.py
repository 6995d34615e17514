"""`Analysis.mask`: every sample that was not used, with its reason, from the analysis and from its JSON."""

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT
from known import seed_of
from sigmatau.analysis import Analysis
from sigmatau.errors import DataError
from sigmatau.record.mask import MAX_LISTED, ChannelMask, ExcludedSpan, stretches_of_runs

SCHEMA = ROOT / "python" / "sigmatau" / "schema" / "result-2.schema.json"
RATE, N = 100, 60_000
SPIKES = (7_000, 7_500, 21_000)
GAP = slice(10_000, 10_250)
KNOCK = slice(40_000, 40_040)


def samples(name):
    """Gyro and accelerometer at rest, with noise in fine steps."""
    rng = np.random.default_rng(seed_of(name))
    return 1e-3 * rng.standard_normal((N, 3)), 1e-2 * rng.standard_normal((N, 3)) + [0, 0, 9.81]


def disturbed(name):
    gyro, accel = samples(name)
    gyro[SPIKES, 0] += 0.2
    gyro[GAP] = np.nan
    gyro[KNOCK] += 0.05 * np.random.default_rng(seed_of(f"knock {name}")).standard_normal((40, 3))
    return st.Record.from_arrays(rate=RATE, gyro=gyro, accel=accel)


def analysed(record, **options):
    """By the curve alone: the fit changes no mask."""
    return st.analyze(record, method="read-off", **options)


@pytest.fixture(scope="module")
def of_disturbed():
    return analysed(disturbed("json"))


def reasons(mask):
    """The reason of each sample; empty for those that were used."""
    of = np.full(mask.samples, "", dtype="<U20")
    for span in mask.spans:
        assert (of[span.start : span.stop] == "").all()
        of[span.start : span.stop] = span.reason
    return of


def test_each_sample_has_its_reason():
    analysis = analysed(disturbed("mask"), leave_out="30s:32s", window="20s:")
    gyro, accel = reasons(analysis.mask("gyro_x")), reasons(analysis.mask("accel_z"))
    knock = slice(KNOCK.start - 100, KNOCK.start + 200)  # the second that has it, and one on either side
    expected = np.full(N, "", dtype="<U20")
    expected[list(SPIKES)], expected[GAP] = "spikes", "missing"
    expected[3000:3200], expected[:2000], expected[knock] = "left_out", "window", "not_static"
    assert gyro.tolist() == expected.tolist()
    expected[list(SPIKES)], expected[GAP] = "", ""  # what one sensor shows alone; a knock is of both
    assert accel.tolist() == expected.tolist()
    curve = analysis.curves["gyro_x"]
    assert analysis.mask("gyro_x").excluded[2000:].sum() == curve.missing
    assert analysis.mask("gyro_x").excluded.dtype == bool


def test_saturation_is_in_the_mask_of_its_axis():
    gyro, accel = samples("saturation")
    limit = 5 * gyro[:, 1].std()
    at = slice(20_000, 20_060)
    gyro[at, 1] = limit
    np.clip(gyro, -limit, limit, out=gyro)
    analysis = analysed(st.Record.from_arrays(rate=RATE, gyro=gyro, accel=accel))
    of = reasons(analysis.mask("gyro_y"))
    assert set(of[at]) <= {"saturation", "stuck_samples"}
    assert (of[at] != "").all()
    assert not analysis.mask("gyro_x").spans


def test_motion_is_in_the_mask_of_all_sensors():
    gyro, accel = samples("motion")
    moving = slice(0, 12_000)
    gyro[moving] += 0.5 * np.sin(np.arange(12_000) / 40)[:, None]
    analysis = analysed(st.Record.from_arrays(rate=RATE, gyro=gyro, accel=accel))
    assert analysis.rest.verdict == "partly_at_rest"
    for channel in ("gyro_x", "accel_x"):
        of = reasons(analysis.mask(channel))
        assert set(of[moving]) == {"partly_at_rest"}
        still = np.flatnonzero(of == "")
        assert still[0] / RATE == analysis.used[channel][0, 0]
        assert len(still) == analysis.curves[channel].n


def test_streams_that_begin_later_count_their_own_samples():
    gyro, accel = samples("later")
    accel[500] += 3.0
    record = st.Record.from_arrays(rate={"gyro": RATE, "accel": 50}, gyro=gyro, accel=accel)
    first, second = record.streams
    record = replace(record, streams=(first, replace(second, grid=replace(second.grid, start=12.0))))
    mask = analysed(record, window="15s:").mask("accel_x")
    assert (mask.lead, mask.samples) == (12.0, N)
    assert mask.columns()["stop_s"][0] == 15.0
    assert mask.spans[1].start == 500


def test_the_json_has_the_mask(of_disturbed):
    analysis = of_disturbed
    again = Analysis.from_json(analysis.to_json())
    for channel in analysis.curves:
        mask, same = analysis.mask(channel), again.mask(channel)
        assert (mask.samples, mask.tau0, mask.lead, mask.spans) == (same.samples, same.tau0, same.lead, same.spans)
        assert again.used[channel].tolist() == analysis.used[channel].tolist()


def test_results_without_a_mask_say_so(of_disturbed):
    with pytest.raises(KeyError, match="no channel 'gyro_q'; channels: gyro_x"):
        of_disturbed.mask("gyro_q")
    content = json.loads(of_disturbed.to_json())
    for channel in content["channels"].values():
        del channel["excluded"]
    earlier = Analysis.from_dict(content)
    with pytest.raises(DataError, match="does not list the samples"):
        earlier.mask("gyro_x")
    assert earlier.used == {}


def test_a_mask_of_thousands_of_stretches_is_in_the_json():
    gyro, accel = samples("many")
    gyro[np.arange(20, 20 * (MAX_LISTED + 2), 20)] = np.nan
    gyro[50_000, 0] += 0.2
    analysis = analysed(st.Record.from_arrays(rate=RATE, gyro=gyro, accel=accel))
    mask = analysis.mask("gyro_x")
    assert {span.reason for span in mask.spans} == {"missing", "spikes"}
    assert len(mask.spans) == MAX_LISTED + 2
    text = analysis.to_json()
    assert Analysis.from_json(text).mask("gyro_x").spans == mask.spans
    assert Analysis.from_json(text).mask("accel_x").spans == ()
    content = json.loads(text)
    assert content["channels"]["gyro_x"]["excluded_runs"]["runs"]["missing"].startswith("20 1 19 1 19 1")
    jsonschema.validate(content, json.loads(SCHEMA.read_text(encoding="utf-8")))


def test_a_mask_of_a_hundred_thousand_stretches_is_below_a_megabyte():
    rng = np.random.default_rng(seed_of("hundred thousand stretches"))
    edges = np.cumsum(rng.integers(1, 2000, 200_000)).reshape(-1, 2)
    spans = tuple(ExcludedSpan(start, stop, "spikes") for start, stop in edges.tolist())
    mask = ChannelMask(channel="gyro_x", samples=int(edges[-1, 1]), tau0=0.01, spans=spans)
    text = json.dumps(mask.to_dict(), indent=1)
    assert len(text) < 1_000_000
    assert stretches_of_runs(json.loads(text)["excluded_runs"]["runs"]["spikes"]) == list(map(tuple, edges.tolist()))


@pytest.mark.parametrize("runs", ["20 1 19", "20 x", "1.5 2", "20 1 -5 2", "59000 1001", "20 -1"])
def test_damaged_runs_are_refused(of_disturbed, runs):
    content = json.loads(of_disturbed.to_json())
    excluded = content["channels"]["gyro_x"].pop("excluded")
    del excluded["spans"]
    content["channels"]["gyro_x"]["excluded_runs"] = excluded | {"runs": {"spikes": runs}}
    with pytest.raises(DataError, match=r"channels.gyro_x: excluded(_runs: its runs are not|: its spans overlap)"):
        Analysis.from_dict(content)


@pytest.mark.parametrize("spans", [[[0, 10], [5, 20]], [[10, 5]], [[59_000, 60_001]], [[-1, 5]]])
def test_damaged_spans_are_refused(of_disturbed, spans):
    content = json.loads(of_disturbed.to_json())
    content["channels"]["gyro_x"]["excluded"]["spans"] = {"spikes": spans}
    with pytest.raises(DataError, match=r"excluded: its spans overlap, or end after the record"):
        Analysis.from_dict(content)
