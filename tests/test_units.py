"""Units as the field spells them; datasheets above all."""

import math

import pytest

from sigmatau import OptionError
from sigmatau.units import find, find_unit, needs_scale, symbols, to_si, usual

DEG = math.pi / 180

# Spellings of units in the headers of loggers, by what they mean.
LOGGED = {
    "m/s^2": "m/(s^2), m/(s²), m.s-2, m·s⁻², m⋅s⁻², m s-2, ms-2, m/s/s, m/ss, m/s*s, mps2, m/sec2",
    "rad/s": "rad.s-1, rad·s⁻¹, rad.s^-1, rads-1, rad s^-1, rad/(s), rad/second",
    "deg/s": "°/s, º/s, dps, deg.s^-1, deg⋅s⁻¹, °·s⁻¹, °s-1, deg/(s), degree/sec",
    "mdeg/s": "mdps, milli-dps, millidegrees per second",
    "g": "gees, gee, g's, G, g-force, gn",
    "mg": "mG, milli-g, milli g, milligee, milli-g's",
    "ms": "mSecs, msec, millis, milliseconds",
}

# Spellings of noise densities and random walks as datasheets, papers and manuals have them, by what they mean.
SPELLED = {
    "mdeg/s/sqrt(Hz)": "mdps/sqrt(Hz), mdps/√Hz, mdps/rtHz, mdps/√(Hz), mdps/Hz^0.5, (mdps)/√Hz, mdeg/s/√Hz",
    "deg/s/sqrt(Hz)": (
        "(deg/s)/√Hz, [deg/s]/√Hz, (°/s)/√Hz, (°/s) / √Hz, °/s/√Hz, °/sec/√Hz, º/s/√Hz, dps/rtHz, dps/√Hz, "
        "dps/√(Hz), dps/rt(Hz), dps per root Hz, deg/s/Hz^0.5, deg/s/Hz^(1/2), deg/s/Hz½, deg/s Hz^-1/2, "
        "°·s⁻¹·Hz⁻½, deg/sec/sqrt(hertz), degrees per second per root Hz"
    ),
    "ug/sqrt(Hz)": "ug/√Hz, µg/√Hz, μg/√Hz, µg/rt(Hz), ug/rtHz, micro-g/√Hz, ug/Hz^½, µg·Hz^-1/2, µG/√Hz",
    "mg/sqrt(Hz)": "mg/√Hz, mg/rtHz, milli-g/√Hz, mg/Hz^1/2",
    "ng/sqrt(Hz)": "ng/√Hz",
    "m/s^2/sqrt(Hz)": "m/s²/√Hz, (m/s²)/√Hz, (m/s^2)/sqrt(Hz), m/sec²/√Hz, m/s^2/Hz^0.5, m/s/s/√Hz",
    "deg/sqrt(h)": (
        "deg/√h, deg/√hr, deg/√(hr), °/√h, °/√hr, °/√hour, deg/rt-hr, deg/rt hr, deg/root-hour, deg per root hour, "
        "deg/hr^0.5, deg/h^(1/2), deg·h^-1/2, deg h^-0.5, °/h½"
    ),
    "m/s/sqrt(h)": "m/s/√h, m/s/√hr, (m/s)/√h, (m/s)/√hr, m/s/rt-hr, m/sec/√hour, m/s/hr^0.5",
    "deg/h/sqrt(Hz)": "°/h/√Hz, (°/h)/√Hz, deg/hr/√Hz, dph/√Hz",
    "deg/h": "°/h, °/hr, deg/hr, deg/hour, dph, °·h⁻¹, deg*h^-1",
    "deg/h/sqrt(h)": (
        "°/h/√h, (°/h)/√h, °/hr/√hr, deg/hr/rt-hr, deg/h^1.5, deg/h^(3/2), °/h^{3/2}, deg/hr^3/2, deg/h**1.5, "
        "deg·h^-1.5, deg h^(-3/2)"
    ),
    "rad/s/sqrt(Hz)": "rad/s/√Hz, (rad/s)/√Hz, rad·s⁻¹·Hz⁻½",
    "rad/sqrt(s)": "rad/√s, rad/s^0.5, rad/s^(1/2)",
    "m/s/sqrt(s)": "m/s/√s, m/s^1.5, m/s^(3/2)",
    "rad/s/sqrt(s)": "rad/s/√s, rad/s^1.5, rad/s^(3/2)",
    "m/s^2/sqrt(s)": "m/s²/√s, m/s^2.5, m/s^(5/2)",
    "m/s/h^(3/2)": "m/s/h^1.5, m/s/h^3/2, m/s·h^-1.5, m/s/h^{3/2}, m/s/hr^(3/2)",
    "m/s^2": "m/s², m·s⁻², m s^-2, m/sec², m/s/s, mps2",
    "ft/s/sqrt(h)": "fps/√hr, ft/sec/√hr",
    "mg": "milli-g, milli g",
    "ug": "micro-g, micro g, µg",
    "deg/s": "dps, °/s, °/sec, deg/sec, °·s⁻¹, deg s-1",
}


@pytest.mark.parametrize(("symbol", "row"), [*LOGGED.items(), *SPELLED.items()])
def test_spellings_of_the_field(symbol, row):
    for spelling in row.split(", "):
        assert find(spelling).symbol == symbol, spelling
        assert find(f"  {spelling.upper()} ").symbol == symbol, spelling


def test_each_unit_is_understood_as_it_is_typed_and_as_it_is_printed():
    for symbol in symbols():
        unit = find(symbol)
        assert unit.symbol == symbol
        assert find(unit.text) is unit, symbol


# In SI, by hand: a density in unit/√Hz is unit·√s, because 1/√Hz = √s; an hour has 3600 s.
FACTORS = {
    "mdps/√Hz": 1e-3 * DEG,
    "deg/√h": DEG / 60,
    "m/s/√h": 1 / 60,
    "µg/√Hz": 9.80665e-6,
    "deg/h/√Hz": DEG / 3600,
    "ng/√Hz": 9.80665e-9,
    "arcsec/√h": DEG / 3600 / 60,
    "µrad/√h": 1e-6 / 60,
    "mdeg/√h": 1e-3 * DEG / 60,
    "mdps/√h": 1e-3 * DEG / 60,
    "mm/s/√h": 1e-3 / 60,
    "µm/s²/√Hz": 1e-6,
    "mg/√s": 9.80665e-3,
    "µ°/s/√Hz": 1e-6 * DEG,
}


@pytest.mark.parametrize("spelling", FACTORS)
def test_values(spelling):
    assert to_si(1.0, spelling) == pytest.approx(FACTORS[spelling], rel=1e-15)


def test_one_value_said_in_several_units():
    """0.3 deg/√h = 5 mdps/√Hz; 60 µg/√Hz = 0.0353 m/s/√h: the conversions of every datasheet."""
    assert to_si(0.3, "deg/√hr") == pytest.approx(to_si(5.0, "mdps/√Hz"), rel=1e-15)
    assert to_si(60, "µg/√Hz") == pytest.approx(to_si(60 * 9.80665e-6 * 60, "(m/s)/√hr"), rel=1e-15)


@pytest.mark.parametrize(
    "wrong", ["", "deg/√m", "deg/h^0.3", "deg/√", "√Hz", "mg/Hz", "arcsec/√Hz", "(deg/s/√Hz", "dB", "1/√Hz"]
)
def test_what_is_no_unit_is_refused(wrong):
    with pytest.raises(OptionError, match="unknown unit"):
        find(wrong)


def test_the_usual_unit_is_of_its_kind():
    for si in sorted({find(symbol).si for symbol in symbols()}):
        assert find(usual(si)).si == si


def test_a_unit_of_another_kind_is_refused():
    with pytest.raises(OptionError, match="does not fit here"):
        find("mdps/√Hz", si="m/s/sqrt(s)")
    # A power of a spectrum is no density: twice as far in the logarithm, and never taken for one.
    with pytest.raises(OptionError):
        find("(deg/s)^2/Hz")


def test_a_ramp_is_spelled_as_a_square_or_twice():
    assert to_si(470, "deg/h/h") == to_si(470, "deg/h^2") == to_si(470, "deg/h2")


@pytest.mark.parametrize("spelling", ["LSB", "counts", "ADC", "digits", "V", "mV", "no units"])
def test_counts_and_volts_need_a_scale(spelling):
    assert needs_scale(spelling)
    assert find_unit(spelling) is None


@pytest.mark.parametrize("spelling", ["m/s^2", "furlong/s", "rad", "m/s/Hz", "uT", ""])
def test_other_units_need_none(spelling):
    assert not needs_scale(spelling)
