"""Units in which values are shown: sizes, sides, prefixes, and what is refused."""

import math

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import OptionError
from sigmatau.noise.shown import show_in
from sigmatau.noise.terms import TERMS, check_shown, display_units
from sigmatau.plot.curves import curve_unit

G = 9.80665
DEG = math.pi / 180
KINDS = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2"), "mag": ("signal", "T")}


@pytest.mark.parametrize(
    ("unit", "kind", "term", "text", "size"),
    [
        ("deg/h", "gyro", "bias_instability", "deg/h", DEG / 3600),
        ("deg/s", "gyro", "bias_instability", "deg/s", DEG),
        ("mdps/rtHz", "gyro", "random_walk", "mdeg/s/√Hz, two-sided", DEG / 1e3),
        ("mdps/rtHz:one-sided", "gyro", "random_walk", "mdeg/s/√Hz, one-sided", DEG / 1e3 / math.sqrt(2)),
        ("mdps/rtHz two-sided", "gyro", "random_walk", "mdeg/s/√Hz, two-sided", DEG / 1e3),
        ("deg/h/h", "gyro", "rate_ramp", "deg/h/h", DEG / 3600**2),
        ("urad", "gyro", "quantization", "µrad", 1e-6),
        ("ug/rtHz", "accel", "random_walk", "µg/√Hz, two-sided", G * 1e-6),
        ("m/s/h", "accel", "bias_instability", "m/s/h", 1 / 3600),
        ("mg", "accel", "bias_instability", "mg", G * 1e-3),
        ("nT", "mag", "bias_instability", "nT", 1e-9),
        ("nT", "mag", "random_walk", "nT·√s", 1e-9),
        ("nT", "mag", "rate_ramp", "nT/s", 1e-9),
        ("pT/√Hz", "mag", "random_walk", "pT/√Hz, two-sided", 1e-12),
        ("uT/sqrt(h)", "mag", "rate_random_walk", "µT/√h", 1e-6 / 60),
        ("nT/d", "mag", "rate_ramp", "nT/d", 1e-9 / 86400),
    ],
)
def test_text_and_size(unit, kind, term, text, size):
    with show_in(unit):
        ((shown, factor),) = display_units(term, *KINDS[kind])
    assert shown == text
    assert factor == pytest.approx(size, rel=1e-12)
    assert display_units(term, *KINDS[kind])[0][0] != text or kind != "mag"  # the block has ended


@pytest.mark.parametrize(
    ("own", "unit", "size"),
    [
        ("hPa", "Pa", 0.01),
        ("mbar", "Pa", 0.01),
        ("V", "uV", 1e-6),
        ("µT", "nT", 1e-3),
        ("K", "mK", 1e-3),
        ("degC", "mK", 1e-3),
    ],
)
def test_a_signal_in_a_unit_of_its_own(own, unit, size):
    with show_in(unit):
        assert display_units("bias_instability", "signal", own) == ((unit.replace("u", "µ"), pytest.approx(size)),)


def test_the_unit_of_a_coefficient_comes_before_that_of_all():
    with show_in(["nT", "pT/rtHz"]):
        texts = [display_units(term, *KINDS["mag"])[0][0] for term in TERMS]
    assert texts == ["nT·s", "pT/√Hz, two-sided", "nT", "nT/√s", "nT/s"]


@pytest.mark.parametrize(
    ("own", "term", "values", "text", "size"),
    [
        ("T", "random_walk", [1.4e-8, None], "nT/√Hz, two-sided", 1e-9),
        ("T", "bias_instability", [3e-10, 2e-9], "nT", 1e-9),
        ("µT", "bias_instability", [3e-4], "pT", 1e-6),
        ("Pa", "rate_random_walk", [0.005], "mPa/√s", 1e-3),
        ("V", "quantization", [2e-6], "µV·s", 1e-6),
        ("hPa", "bias_instability", [0.009], "mPa", 1e-5),
        ("°C", "bias_instability", [0.002], "mK", 1e-3),
        ("V", "bias_instability", [2e-15], "pV", 1e-12),
        ("Pa", "bias_instability", [3e6], "MPa", 1e6),
        ("Pa", "bias_instability", [0.01, 9e4], "Pa", 1.0),
        ("Pa", "random_walk", [0.01], "Pa·√s", 1.0),
        ("T", "bias_instability", [0.0, math.nan, None], "T", 1.0),
        ("furlong", "bias_instability", [1e-9], "furlong", 1.0),
    ],
)
def test_the_prefix_that_the_numbers_of_a_column_need(own, term, values, text, size):
    assert display_units(term, "signal", own, values) == ((text, pytest.approx(size)),)
    with show_in("kT,kPa,kV,kK"):
        assert own == "furlong" or display_units(term, "signal", own, values)[0][0].startswith("k")
    for quantity, unit in (KINDS["gyro"], KINDS["accel"]):
        assert display_units(term, quantity, unit, values) == display_units(term, quantity, unit)


@pytest.mark.parametrize("unit", ["", "foo", "Hz", "deg/h/h/h", "nT/rtHz/s", "xT", "furlong", "nT,,uT", "m"])
def test_what_is_no_unit_of_a_coefficient(unit):
    with (
        pytest.raises(OptionError, match=r"is not a unit of a coefficient. Give units such as deg/h") as refused,
        show_in(unit),
    ):
        pass
    assert refused.value.option == "show"


def test_a_side_of_what_is_no_density():
    for unit in ("deg/h:one-sided", "nT two-sided", "deg/sqrt(h):one-sided"):
        with pytest.raises(OptionError, match="only a density is one- or two-sided"), show_in(unit):
            pass


@pytest.mark.parametrize(
    ("units", "kinds", "words"),
    [
        ("nT", ("gyro",), "'nT' fits no printed value of gyro_x. Units that fit: mdps/rtHz, deg/sqrt(h), deg/h"),
        ("uV", ("mag",), "'uV' fits no printed value of mag_x. Units that fit: mT, uT/rtHz"),
        ("deg/h,ug", ("gyro",), "'ug' fits no printed value"),
        ("deg/h,deg/s", ("gyro",), "deg/h and deg/s are units of the same coefficient of gyro_x. Give one of them"),
        ("deg/sqrt(h),mdps/rtHz", ("gyro", "accel"), "are units of the same coefficient"),
        ("nT,uT", ("mag",), "nT and uT are units of the same coefficient"),
    ],
)
def test_what_does_not_fit(units, kinds, words):
    with show_in(units), pytest.raises(OptionError) as refused:
        check_shown({f"{kind}_x": KINDS[kind] for kind in kinds})
    assert words in str(refused.value)


def test_units_that_fit_some_channel():
    with show_in("deg/h,mdps/rtHz,ug/rtHz,m/s/h,nT"):
        check_shown({f"{kind}_x": KINDS[kind] for kind in KINDS})
    check_shown({})


@pytest.fixture(scope="module")
def record():
    noise = np.random.default_rng(seed_of("units that are shown")).standard_normal((6000, 2))
    return st.Record.from_arrays(rate=10, gyro_x=1e-3 * noise[:, 0], mag_x=1e-8 * noise[:, 1], unit={"mag_x": "T"})


def test_everything_that_prints(record):
    """A one-sided density is √2 times N, curves are in the unit of the bias, and an argument comes before both."""
    analysis = st.analyze(record)
    usual = repr(analysis)
    with show_in("mdps/rtHz:one-sided,deg/s,nT"):
        shown = repr(analysis)
        value = float(analysis.fits["gyro_x"].texts("random_walk")[0][0])
        assert curve_unit(analysis.curves["gyro_x"], None) == (pytest.approx(DEG), "deg/s")
        assert curve_unit(analysis.curves["mag_x"], None) == (pytest.approx(1e-9), "nT")
        assert curve_unit(analysis.curves["gyro_x"], "deg/h")[1] == "deg/h"
        axes = analysis.plot().axes
        assert ["deg/s" in axes[0].get_ylabel(), "nT" in axes[1].get_ylabel()] == [True, True]
    assert value == pytest.approx(math.sqrt(2) * 1e3 * analysis.fits["gyro_x"]["random_walk"].value / DEG, rel=1e-3)
    assert "mdeg/s/√Hz, one-sided" in shown
    assert "nT·√s" in shown
    assert "nT/√Hz, two-sided" in usual
    assert repr(analysis) == usual


def test_the_command_line(tmp_path, record, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    gyro = st.Record.from_arrays(rate=10, gyro_x=record.stream_of("gyro_x").column("gyro_x"))
    st.write(gyro, "log.csv")
    options = ["analyze", "log.csv", "--json", "plain.json", "-q"]
    assert main(options) == 0
    assert main([*options[:2], "--json", "shown.json", "-q", "--show", "mdps/rtHz,deg/s", "--report", "r.html"]) == 0
    assert "mdeg/s/√Hz, two-sided" in capsys.readouterr().out
    assert "mdeg/s/√Hz, two-sided" in (tmp_path / "r.html").read_text()
    results = [st.Analysis.from_json((tmp_path / f"{name}.json").read_text()) for name in ("plain", "shown")]
    assert results[0].fits["gyro_x"].to_dict() == results[1].fits["gyro_x"].to_dict()  # numbers are in SI
    assert main(["plan", "plain.json", "--term", "bias_instability", "--show", "deg/s"]) == 0
    assert "deg/s" in capsys.readouterr().out
    assert main(options) == 0
    assert "deg/√h" in capsys.readouterr().out  # the units end with their command
    assert main([*options, "--show", "hPa"]) == 2
    assert "Units that fit: mdps/rtHz" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "unit", "text", "wrong"),
    [
        (["psd", "log.csv", "--segment", "10s"], "mdps/rtHz:one-sided", "√(2S) one-sided [mdeg/s/√Hz], 95 %", "deg/h"),
        (["deviation", "log.csv", "--kind", "time"], "urad", "time deviation [µrad]", "deg/h"),
        (["deviation", "log.csv", "--kind", "hadamard"], "deg/s", "Hadamard deviation [deg/s]", "mdps/rtHz"),
        (["bandwidth", "log.csv"], "mdps/rtHz", "random walk in it [mdeg/s/√Hz, two-sided]", "deg/h"),
        (["watch", "log.csv", "--idle", "0.1"], "mdps/rtHz", "mdeg/s/√Hz, two-sided", "ug"),
        (["predict", "log.json", "--after", "60s"], "arcmin", "arcmin", "deg/h"),
        (["tune", "--rest", "log.json", "log.json"], "mdps/rtHz:one-sided", "mdeg/s/√Hz, one-sided", "ug"),
        (["export", "log.json", "--to", "state-space", "-o", "x.json"], "ug", None, "nT"),
        (["store", "show", "A", "--store", "s.db"], "mdps/rtHz", "mdeg/s/√Hz, two-sided", "ug"),
        (["store", "trend", "--store", "s.db"], "mdps/rtHz", "median [mdeg/s/√Hz, two-sided]", "deg/h"),
    ],
)
def test_every_command_that_prints_noise(results, monkeypatch, capsys, argv, unit, text, wrong):
    monkeypatch.chdir(results)
    if text is not None:
        assert main([*argv, "--show", unit]) in (0, 1)  # 1 of a bandwidth that the log does not show
        assert text in capsys.readouterr().out
    assert main([*argv, "--show", wrong]) == 2
    assert f"{wrong!r} fits no printed value of" in capsys.readouterr().err


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A log, its result, and a store with it."""
    folder = tmp_path_factory.mktemp("shown")
    noise = np.random.default_rng(seed_of("units of every command")).standard_normal(3000)
    st.write(st.Record.from_arrays(rate=10, gyro_x=1e-3 * noise), folder / "log.csv")
    assert main(["analyze", str(folder / "log.csv"), "--json", str(folder / "log.json"), "-q"]) == 0
    named = ["--unit", "A", "--date", "2026-01-02"]
    assert main(["store", "add", str(folder / "log.json"), "--store", str(folder / "s.db"), *named]) == 0
    return folder
