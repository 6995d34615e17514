"""A lot with known faults at two temperatures: each unit is named with the right word, and the trend of the store agrees."""

from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Datasheet, NoiseModel, Record, Store, analyze, judge_lot, simulate
from sigmatau.analysis import FailedAnalysis
from sigmatau.errors import DataError
from sigmatau.lab.store.choosing import Chosen

UNITS, RATE, DURATION = 40, 5.0, 600.0  # [Hz], [s]
NOISY, EXCHANGED, WALKING, SCALED, EMPTY, COPY, MISSING = 7, 12, 19, 22, 25, 28, 33
ODD = {NOISY, EXCHANGED, WALKING, SCALED, EMPTY, COPY - 1, COPY, MISSING}
FIRST, RISE = 31, 0.03  # first unit of a batch, whose noise rises from unit to unit [1]
FACTORS = {25: 1.0, 85: 1.12}  # of all noise at a temperature [degC]
SHEET = """
name = "MINS-7"
maker = "Acme"
source = "specification 12"

[gyro]
random_walk = { typical = "0.1 deg/sqrt(h)", maximum = "0.2 deg/sqrt(h)" }

[accel]
random_walk = { typical = "0.03 m/s/sqrt(h)", maximum = "0.06 m/s/sqrt(h)" }
"""


def name(unit):
    return f"SN{1000 + unit}"


def day(unit):
    return f"2026-05-{4 + (unit - 1) // 10:02d}"


def measured(unit, temperature):
    """Result of a unit at a temperature: N differs by 5 % between units and axes."""
    rng = np.random.default_rng(seed_of(f"trial {unit}"))
    spread = np.exp(0.05 * rng.standard_normal(6)) * FACTORS[temperature] * (1 + RISE * max(unit - FIRST + 1, 0))
    axes = np.array([4.0 if unit == NOISY else 1.0, 1, 1, 1, 1, 1]) * spread
    walk = 3 * (16 if unit == WALKING else 1)  # which 75 s show surely
    channels = {}
    for k, axis in enumerate("xyz"):
        gyro = {"random_walk": f"{0.1 * axes[k]} deg/sqrt(h)", "rate_random_walk": f"{walk} deg/h/sqrt(h)"}
        accel = {"random_walk": f"{0.03 * axes[3 + k]} m/s/sqrt(h)", "rate_random_walk": "1 m/s/h/sqrt(h)"}
        channels |= {f"gyro_{axis}": gyro, f"accel_{axis}": accel}
    model = NoiseModel.from_dict({"channels": channels})
    record = simulate(model, duration=DURATION, rate=RATE, rng=seed_of(f"trial {unit} {temperature}"))
    rates = {channel: record.stream_of(channel).column(channel) for channel in record.channels}
    rates["gyro_z"] = rates["gyro_z"] + 5e-5
    rates["accel_z"] = rates["accel_z"] + 9.81
    if unit == EXCHANGED:
        for sensor in ("gyro", "accel"):
            rates[f"{sensor}_y"], rates[f"{sensor}_z"] = rates[f"{sensor}_z"], rates[f"{sensor}_y"]
    if unit == SCALED:
        rates = {channel: 1.25 * x for channel, x in rates.items()}
    return analyze(Record.from_arrays(rate=RATE, **rates), notes=notes(unit, temperature))


def notes(unit, temperature):
    return {"serial number": name(unit), "date": day(unit), "temperature": f"{temperature} degC"}


@pytest.fixture(scope="module")
def shift():
    """Results by temperature and unit; one log is empty, one is missing, one is there under two names."""
    results = {}
    for t in FACTORS:
        units = {unit: measured(unit, t) for unit in range(1, UNITS + 1) if unit not in (EMPTY, COPY, MISSING)}
        units[EMPTY] = FailedAnalysis.of(DataError("is empty"), f"{name(EMPTY)}.csv")
        units[COPY] = replace(units[COPY - 1], notes=notes(COPY, t))
        results[t] = {name(unit): units[unit] for unit in sorted(units)}
    return results


@pytest.fixture(scope="module", params=FACTORS)
def lot(request, shift, tmp_path_factory):
    path = tmp_path_factory.mktemp("trial") / "spec.toml"
    path.write_text(SHEET)
    expected = [name(unit) for unit in range(1, UNITS + 1)]
    return judge_lot(shift[request.param], Datasheet.read(path), expect=expected)


def test_each_fault_has_its_word(lot):
    units = {unit.name: unit for unit in lot.units}
    states = {unit: units[name(unit)].state for unit in ODD}
    reasons = {unit: units[name(unit)].reason for unit in ODD}
    assert states == {
        NOISY: "failed",
        EXCHANGED: "not_judged",
        WALKING: "passed",  # the specification has no maximum of slow noise
        SCALED: "not_judged",
        EMPTY: "unreadable",
        COPY - 1: "not_judged",
        COPY: "not_judged",
        MISSING: "missing",
    }
    assert reasons[NOISY].startswith("gyro x: angle random walk")
    assert reasons[EXCHANGED].startswith("gyro, accel: axes y and z exchanged")
    assert reasons[SCALED].startswith("accel: wrong scale: gravity is 25 % above the lot's median")
    assert reasons[EMPTY] == "is empty"
    assert reasons[COPY - 1] == f"the data are those of {name(COPY)}; log this unit again"
    assert reasons[COPY] == f"the data are those of {name(COPY - 1)}; log this unit again"


def test_nobody_else_is_named(lot):
    named = {}
    for unit in lot.units:
        for remark in unit.remarks:
            named.setdefault(remark.code, set()).add(unit.name)
    assert named["orientation"] == {name(EXCHANGED)}
    assert named["other_scale"] == {name(SCALED)}
    assert named["slow_noise"] == {name(WALKING)}
    assert named["outlier"] == {name(NOISY), name(WALKING), name(SCALED)}
    assert named.get("other_mean", set()) <= {name(WALKING)}  # its mean walks, too


def test_the_batch_is_named_with_date_and_size(lot):
    (batch,) = (each.order for each in lot.drifts if (each.channel, each.what) == ("gyro", "random_walk"))
    assert (batch.kind, batch.first, batch.last) == ("rise", name(FIRST), name(UNITS))
    assert batch.low < RISE < batch.high
    assert f"Batch from {name(FIRST)} to {name(UNITS)} (9 units, {day(UNITS)}): " in " ".join(repr(lot).split())


def test_the_trend_of_the_store_agrees(shift, tmp_path):
    with Store(tmp_path / "lab.db") as store:
        for by_unit in shift.values():
            store.add([result for result in by_unit.values() if not isinstance(result, FailedAnalysis)])
        for t in FACTORS:
            trend = store.trend("random_walk", chosen=Chosen(temperature=(t - 1, t + 1)), by="week")
            assert len(trend.channels) == 6
            for channel in trend.channels.values():
                assert channel.order.kind == "rise"
                assert channel.order.last == name(UNITS)
            near = [abs(int(channel.order.first[2:]) - 1000 - FIRST) <= 2 for channel in trend.channels.values()]
            assert sum(near) >= 5  # 92 % of such series, docs/study/lots.md
            assert repr(trend).count("see the batch (38 units)") == 6
