"""The paper's "close to the manufacturers' claim", held against its own section III."""

import math

import pytest
from studies import paper_claims

from sigmatau.lab.datasheets.sheet import datasheet


def test_the_page_is_what_the_code_says():
    assert paper_claims.PAGE.read_text(encoding="utf-8") == paper_claims.page()


def test_measured_values_are_the_tables():
    """Table IV, gyro X: 0.094 ± 0.031 deg/√h; accelerometer quantization stands in the data file as value/3600 m/s."""
    model = paper_claims.measured("hg1700")
    unit = math.radians(1) / 60
    assert model.channels["gyro_x"]["random_walk"] == pytest.approx(0.094 * unit)
    assert model.channels["gyro_x"].intervals["random_walk"] == pytest.approx((0.063 * unit, 0.125 * unit))
    low, high = model.channels["accel_z"].intervals["quantization"]
    assert (high - low) / 2 == pytest.approx(0.058 / 3600, rel=2e-4)  # 2.185/3600 has four digits in the file
    for unit_name, table in paper_claims.TABLES.items():
        channels = paper_claims.measured(unit_name).channels
        assert {(name, term) for name, channel in channels.items() for term in channel} == set(table)


def test_claims_are_those_of_section_three():
    deg = math.radians(1)
    (walk, bias) = datasheet("cimu").of("gyro_x")
    assert walk.typical == pytest.approx(0.0022 * deg / 60)
    assert bias.typical == pytest.approx(0.0022 * deg / 3600)
    walk, bias = datasheet("cimu").of("accel_x")
    assert walk.typical == pytest.approx(0.0025 * 0.3048 / 60, rel=0.003)  # the paper: 0.00076, from 0.0025 ft/s/√h
    assert bias.typical == pytest.approx(25e-6 * 9.80665)
    (walk,) = datasheet("hg1700").of("gyro_z")
    assert (walk.typical, walk.maximum) == (None, pytest.approx(0.15 * deg / 60))
    assert datasheet("motionpak2").claims == ()


def test_verdicts():
    """By hand: ln(0.15/0.094) over ln(0.125/0.094), the upper end of 0.094 ± 0.031, is 1.64 standard errors."""
    found = paper_claims.verdicts()
    x, y, z = found["hg1700"].judged
    assert x.readings[0].maximum.sigmas == pytest.approx(-math.log(0.15 / 0.094) / math.log(0.125 / 0.094), rel=1e-6)
    assert [j.status for j in (x, y, z)] == ["undecided", "within", "within"]
    walks = [j for j in found["cimu"].judged if j.claim.key == "random_walk" and j.channel.startswith("gyro")]
    assert [j.status for j in walks] == ["within"] * 3
    assert all(j.readings[0].typical.side == "undecided" for j in walks)
    assert found["motionpak2"].judged == ()
    assert not any(verdict.out for verdict in found.values())
