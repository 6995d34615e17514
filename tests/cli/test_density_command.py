"""``sigmatau density``: what a table must state, what is refused, and numbers that come back."""

import json

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.fitting.density_neighbours import independent_step

N, AVERAGES, POINTS = 1e-5, 200, 100
DEG = np.pi / 180


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Frequencies and a two-sided white density N² with the scatter of averages, in SI."""
    rng = np.random.default_rng(seed_of("density command"))
    f = np.geomspace(0.01, 50, POINTS)
    return f, N**2 * rng.chisquare(2 * AVERAGES, POINTS) / (2 * AVERAGES), tmp_path_factory.mktemp("density")


def written(table, head, density, name="d.csv", delimiter=","):
    rows = [head, *(f"{f:.9g}{delimiter}{x:.9g}" for f, x in zip(table[0], density, strict=True))]
    path = table[2] / name
    path.write_text("\n".join(rows) + "\n")
    return str(path)


@pytest.mark.parametrize(
    ("head", "options", "factor", "power"),
    [
        ("f [Hz],psd two-sided [(rad/s)^2/Hz]", [], 1.0, 1),
        ("f,S", ["--sided", "two", "--unit", "(rad/s)^2/Hz"], 1.0, 1),
        ("f,S", ["--sided", "one", "--unit", "(deg/s)²/Hz"], 2 / DEG**2, 1),
        ("frequency (Hz),ASD one-sided (mdps/rtHz)", [], np.sqrt(2) / DEG * 1e3, 0.5),
        ("freq;x [deg/s/√Hz]", ["--sided", "one"], np.sqrt(2) / DEG, 0.5),
        ("f,N [deg/sqrt(h)]", [], 60 / DEG, 0.5),
        ("f,x", ["--sided", "two", "--unit", "rad^2/s^2/Hz"], 1.0, 1),
    ],
)
def test_one_density_in_any_unit(table, head, options, factor, power, capsys):
    path = written(table, head, factor * table[1] ** power, delimiter=";" if ";" in head else ",")
    out = table[2] / "m.toml"
    json_file = table[2] / "r.json"
    argv = ["density", path, *options, "--averages", str(AVERAGES), "-o", str(out), "--json", str(json_file), "-q"]
    assert main(argv) == 0
    low, high = st.NoiseModel.read(out).channels["gyro"].terms["random_walk"] * np.array([0.97, 1.03])
    assert low < N < high  # 3 standard errors: 1/(2·√(AVERAGES·POINTS)) = 0.35 %, and the share of other terms
    content = json.loads(json_file.read_text())
    assert content["unit"] == "rad/s"
    sigma = np.array(content["allan"]["adev"]) * np.sqrt(content["allan"]["tau_s"])
    assert sigma[5:-8] == pytest.approx(N, rel=0.1)
    assert "angle random walk" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("head", "options", "code", "words"),
    [
        ("f,psd", ["--sided", "one"], 2, "does not state the unit of psd. Give it, e.g. --unit"),
        ("f,psd [g^2/Hz]", [], 2, "does not state whether psd [g^2/Hz] is one- or two-sided. Give --sided one"),
        (
            "f,psd one-sided [g^2/Hz]",
            ["--sided", "two"],
            2,
            "is not that of psd one-sided [g^2/Hz], which is one-sided",
        ),
        ("f,psd [g^2/Hz]", ["--sided", "one", "--unit", "ug/rtHz"], 2, "is not the unit 'g^2/Hz' of psd"),
        ("f,psd", ["--sided", "one", "--unit", "dB"], 2, "is in decibels"),
        ("f,psd", ["--sided", "one", "--unit", "rad/s^2/Hz"], 2, "is ambiguous. Write (rad/s)^2/Hz"),
        ("f,psd", ["--sided", "one", "--unit", "rad^2/Hz"], 2, "is not the density of a rate"),
        ("f,psd", ["--sided", "one", "--unit", "deg/h"], 2, "is not the unit of a density"),
        ("f,N [deg/sqrt(h)]", ["--sided", "one"], 2, "which is two-sided"),
        ("time [s],psd", ["--sided", "one", "--unit", "ug/rtHz"], 1, "has times, not frequencies. sigmatau psd"),
        ("x,psd", ["--sided", "one", "--unit", "ug/rtHz"], 2, "no single column of the frequency: x, psd."),
        ("f [rad/s],psd", ["--sided", "one", "--unit", "ug/rtHz"], 1, "the frequency is in 'rad/s'"),
        ("f,psd", ["--sided", "one", "--unit", "ug/rtHz", "-o", "m.toml"], 2, "--output needs --averages"),
        (
            "f,psd",
            ["--sided", "one", "--unit", "ug/rtHz", "--rate", "20"],
            2,
            "--rate: at 20 Hz samples have densities up to 10 Hz",
        ),
        ("f,psd", ["--sided", "one", "--unit", "ug/rtHz", "--taus", "1h"], 2, "--taus of 3600 s is outside the band"),
        (
            "f,psd",
            ["--sided", "one", "--unit", "ug/rtHz", "--channel", "gyro_x"],
            2,
            "the unit does not fit this sensor",
        ),
        ("f,psd", ["--sided", "one", "--unit", "ug/rtHz", "--columns", "frequency=3"], 2, "no column '3' among f, psd"),
        (
            "f,psd",
            ["--sided", "one", "--unit", "ug/rtHz", "--show", "nT"],
            2,
            "'nT' fits no printed value of accel",
        ),
    ],
)
def test_what_is_not_stated_is_asked(table, head, options, code, words, capsys):
    assert main(["density", written(table, head, table[1], "asked.csv"), *options]) == code
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("0,5 0.01,1e-8 0.02,1e-8 0.02,1e-8", "line 5: the frequency does not rise"),
        ("-2,1e-8 -1,1e-8 1,1e-8", "line 2: the frequency is negative"),
        ("1,1e-8 2,-1e-8", "line 3: psd is not positive"),
        ("1,1e-8 2,0", "line 3: psd is not positive"),
        ("1,1e-8 2,nan 3,1e-8", "line 3: psd is not a finite number"),
        ("1,1e-8 nan,1e-8 3,1e-8", "line 3: the frequency is not a finite number"),
    ],
)
def test_values_of_no_density(tmp_path, rows, words, capsys):
    path = tmp_path / "d.csv"
    path.write_text("f,psd two-sided [(rad/s)^2/Hz]\n" + rows.replace(" ", "\n") + "\n")
    assert main(["density", str(path)]) == 1
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(("correlated", "step"), [(False, 1), (True, 2)])
def test_neighbours_of_a_window(correlated, step):
    """A periodogram of a Hann window has a correlation of 4/9 with its neighbour."""
    rng = np.random.default_rng(seed_of("neighbours"))
    windows = np.hanning(512) if correlated else np.ones(512)
    density = np.mean([np.abs(np.fft.rfft(rng.standard_normal(512) * windows)) ** 2 for _ in range(40)], axis=0)
    assert independent_step(density[1:-1]) == step


def test_the_slope_of_a_curve(tmp_path, capsys):
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    log = tmp_path / "log.csv"
    st.write(st.simulate(model, duration=300, rate=20, rng=seed_of("slope")), log)
    assert main(["analyze", str(log), "-q", "--slope", "0.5s:10s"]) == 0
    assert "gyro_x, τ 0.6 … 9.6 s: slope -0.4" in (out := capsys.readouterr().out) or "slope -0.5" in out
    assert ": angle random walk" in out
    for options in (["--slope", "10s"], ["--slope", "1h:2h"], ["--slope", "1s:2s", "--json", "-"], ["--slope", "1:2s"]):
        assert main(["analyze", str(log), "-q", *options]) == 2
        assert "--slope" in capsys.readouterr().err
