"""``sigmatau tune``: columns and units of tables, exit codes, outputs."""

import json
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau.cli import main
from sigmatau.exporting.tuning.table import read_innovations

STATED = 1.5e-8  # S of N = 1e-4, K = 1e-5 and √R = 9.6e-5 every 0.2 s
FILTER = ["--noise", "gyro=0.0001 rad/s/sqrt(Hz)", "--walk", "gyro=1e-5 rad/s/sqrt(s)"]
MODEL = '[channels.gyro_x]\nrandom_walk = "1e-4 rad/sqrt(s)"\nrate_random_walk = "1e-5 rad/s/sqrt(s)"\n'


def columns(n=1000, channels=1, scale=1.0):
    """Times and white innovations with their variance, by channel."""
    rng = np.random.default_rng(seed_of(f"tune command: {n} {channels}"))
    values = [np.arange(n) / 5]
    for _ in range(channels):
        values += [scale * math.sqrt(STATED) * rng.standard_normal(n), np.full(n, STATED)]
    return values


def table(place, header, values, separator=","):
    np.savetxt(place, np.column_stack(values), delimiter=separator, header=header, comments="", fmt="%.12g")
    return str(place)


@pytest.fixture(autouse=True)
def inside(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def content(capsys, *arguments):
    assert main(["tune", *arguments, "--json", "-"]) == 0
    return json.loads(capsys.readouterr().out)["channels"]


def test_screen_and_figure(tmp_path, capsys):
    place = table(tmp_path / "i.csv", "t,nu_gyro_x,S_gyro_x", columns())
    assert main(["tune", place, *FILTER, "--plot", "f.png", "--json", "t.json"]) == 0
    out, _ = capsys.readouterr()
    assert "gyro_x   1000 innovations, one every 0.2 s" in out
    assert "Nothing is wrong" in out
    assert (tmp_path / "f.png").stat().st_size > 10_000
    result = json.loads((tmp_path / "t.json").read_text())["channels"]["gyro_x"]
    assert result["verdict"] == "consistent"
    assert [each["noise"] for each in result["factors"]] == ["measurement", "white", "slow"]


@pytest.mark.parametrize(
    ("header", "separator", "channels"),
    [
        ("t,nu,S", ",", ["innovation"]),
        ("time;innovation;variance", ";", ["innovation"]),
        ("timestamp\tinnov\tinnov_var", "\t", ["innovation"]),
        ("# t nu_x s_x", " ", ["x"]),
        ("time [s],heading_innov [rad],heading_innov_var [rad^2]", ",", ["heading"]),
        ("t,gyro_x.innovation,gyro_x.S", ",", ["gyro_x"]),
        ("timestamp,heading_innov[0],heading_innov_cov[0]", ",", ["heading_0"]),
        ("t,nu_x,S_x,nu_y,S_y", ",", ["x", "y"]),
    ],
)
def test_recognised_columns(tmp_path, capsys, header, separator, channels):
    place = table(tmp_path / "i.csv", header, columns(channels=len(channels)), separator)
    result = content(capsys, place)
    assert list(result) == channels
    assert {each["interval_s"] for each in result.values()} == {0.2}
    assert {each["verdict"] for each in result.values()} == {"consistent"}


@pytest.mark.parametrize(
    ("names", "channels"), [(("gyro_x", "gyro_y"), ["gyro_x", "gyro_y"]), ((0, 1), ["id_0", "id_1"])]
)
def test_rows_of_two_sensors(tmp_path, capsys, names, channels):
    """A column names the sensor of each row; decimal commas where semicolons separate."""
    t, x, s, y, _ = columns(channels=2)
    rows = ["time;id;nu;S"]
    for moment, *pair, variance in zip(t, x, y, s, strict=True):
        rows += [
            f"{moment:.3f};{name};{value:.9g};{variance:.9g}".replace(".", ",")
            for name, value in zip(names, pair, strict=True)
        ]
    (tmp_path / "rows.csv").write_text("\n".join(rows) + "\n")
    table(tmp_path / "columns.csv", "t,nu_a,S_a,nu_b,S_b", [t, x, s, y, s])
    ours, theirs = content(capsys, "rows.csv"), content(capsys, "columns.csv")
    assert list(ours) == channels
    assert [each["nis"] for each in ours.values()] == pytest.approx([each["nis"] for each in theirs.values()], rel=1e-6)


def test_rows_of_two_sensors_have_one_time(tmp_path):
    """The second sensor begins later; both are measurements of one filter."""
    t, x, s, y, _ = columns(channels=2)
    rows = [f"{a:.9g},{name},{b:.9g},{c:.9g}" for a, name, b, c in zip(t, ["gnss"] * len(t), x, s, strict=True)]
    rows += [f"{a + 7.1:.9g},camera,{b:.9g},{c:.9g}" for a, b, c in zip(t, y, s, strict=True)]
    (tmp_path / "rows.csv").write_text("\n".join(["t,sensor,nu,S", *rows]) + "\n")
    read = read_innovations(tmp_path / "rows.csv")
    assert [float(data.time[0]) for data in read.values()] == pytest.approx([0.0, 7.1], abs=1e-9)
    assert main(["tune", "rows.csv", *FILTER]) == 2  # the channels of one filter are to be joined


def test_units_and_deviations(tmp_path, capsys):
    t, nu, s = columns()
    degrees = [t * 1e3, np.degrees(nu), np.degrees(np.sqrt(s))]
    place = table(tmp_path / "i.csv", "t [ms],innov_gyro_x [deg],innov_std_gyro_x [deg]", degrees)
    plain = table(tmp_path / "p.csv", "t,nu_gyro_x,S_gyro_x", [t, nu, s])
    ours, theirs = (content(capsys, each, *FILTER)["gyro_x"] for each in (place, plain))
    assert ours["nis"] == pytest.approx(theirs["nis"], rel=1e-9)
    for a, b in zip(ours["factors"], theirs["factors"], strict=True):
        assert a["assumed"] == pytest.approx(b["assumed"], rel=1e-6)
    for square in ("[m^2/s^2]", "[(m/s)^2]", "((m/s)²)", "[(m/s) ^ 2]"):
        place = table(tmp_path / "v.csv", f"t,nu_accel_x [m/s],S_accel_x {square}", [t, nu, s])
        assert content(capsys, place)["accel_x"]["nis"] == pytest.approx(theirs["nis"], rel=1e-9)
    mixed = table(tmp_path / "v.csv", "t,nu_accel_x [m/s],S_accel_x [m^2]", [t, nu, s])
    assert main(["tune", mixed]) == 2
    assert "nu_accel_x has the unit 'm/s', S_accel_x 'm^2'. Write m/s and (m/s)^2" in capsys.readouterr().err
    mixed = table(tmp_path / "m.csv", "t,nu [deg],S", [t, nu, s])
    assert main(["tune", mixed]) == 2
    assert "nu has the unit 'deg', S 'none'" in capsys.readouterr().err


def test_named_columns(tmp_path, capsys):
    place = table(tmp_path / "i.csv", "a,b,c", columns())
    assert list(content(capsys, place, "--time", "a", "--columns", "gyro_x=b:c")) == ["gyro_x"]
    assert list(content(capsys, place, "--time", "1", "--columns", "gyro_x=2:3")) == ["gyro_x"]


def test_channels_at_their_times(tmp_path, capsys):
    """Rows of two sensors in one table: empty cells are not of a channel."""
    t, nu, s = columns(n=600)
    rows = [
        f"{a:.9g},{b:.9g},{c:.9g},," if k % 2 else f"{a:.9g},,,{b:.9g},{c:.9g}"
        for k, (a, b, c) in enumerate(zip(t, nu, s, strict=True))
    ]
    (tmp_path / "i.csv").write_text("\n".join(["t,nu_x,S_x,nu_y,S_y", *rows]) + "\n")
    result = content(capsys, "i.csv")
    assert [each["n"] for each in result.values()] == [300, 300]
    assert {each["interval_s"] for each in result.values()} == {0.4}


def test_model_and_command_of_the_export(tmp_path, capsys):
    (tmp_path / "imu.toml").write_text(MODEL)
    place = table(tmp_path / "i.csv", "t,nu,S", columns(scale=3.0))
    assert main(["tune", place, "--model", "imu.toml"]) == 0
    out, err = capsys.readouterr()
    assert "0.0001" in out
    assert "All noises are too small by one factor, 3: innovation and S are in different units" in " ".join(out.split())
    assert "a file with these factors" not in err  # its noises are not wrong


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--noise", "gyro=0.3 deg/sqrt(h)"], "--walk: N and K of the filter of gyro_x are both needed"),
        (
            ["--noise", "accel=1 m/s/sqrt(s)", "--walk", "accel=1 m/s^2/sqrt(s)"],
            "--noise accel: the innovations are of",
        ),
        (["--noise", "gyro_x=30 deg/sqrt(h)", "--walk", "gyro_x=1 deg/h/sqrt(h)"], "larger S than the stated"),
        (["--noise", "gyro=0.3 deg", "--walk", "gyro=1"], "--noise gyro"),
        ([*FILTER, "--model", "imu.toml"], "--model has N and K"),
        (["--columns", "gyro_x=nu"], "must name the innovation and its variance"),
        (["--columns", "gyro_x=nu:S"], "no column 'nu'"),
        (["--time", "q"], "--time: no column 'q'"),
        (["--skip", "soon"], "--skip"),
        (["--style", "paper"], "--style"),
        (["--plot", "f.txt"], "--plot"),
    ],
)
def test_wrong_options(tmp_path, capsys, arguments, words):
    (tmp_path / "imu.toml").write_text(MODEL)
    place = table(tmp_path / "i.csv", "t,nu_gyro_x,S_gyro_x", columns())
    assert main(["tune", place, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("", 1, "is empty"),
        ("0,1,2\n" * 200, 1, "line 1: has no header"),
        ("t,nu,S\n0,1\n", 1, "line 2: 2 columns, but the header has 3"),
        ("t,nu,S\n0,one,1\n", 1, "line 2: nu is not a number: 'one'"),
        ("t,nu,S\n0,nan,1\n", 1, "line 2: nu is not a finite number"),
        ("t,nu,S\n0,1,\n", 1, "line 2: S is not a finite number"),
        ("t,nu,S\n0,1,1\n1,1,0\n", 1, "line 3: S is not positive"),
        ("t,nu,S\n0,1,1\n0,1,1\n", 1, "line 3: the time does not increase"),
        ("t,nu,S\n0,1,1\n1,1,1\n", 1, "2 innovations are too few to judge a filter. At least 100 are needed"),
        ("t,nu,S\n" + "".join(f"{k},0.5,1\n" for k in range(200)), 1, "constant, 0.5"),
        ("timestamp,nu,S\n" + "".join(f"{k * 10**8},{k % 3},1\n" for k in range(200)), 2, "timestamp [ns]"),
        ("t,nu\n0,1\n", 2, "nu has no column of its variance"),
        ("t,nu,residual,S\n0,1,1,1\n", 2, "two columns of the innovation"),
        ("t,x,y\n0,1,1\n", 2, "no column is recognised as an innovation"),
        ("nu,S\n1,1\n", 2, "no column is recognised as the time"),
        ("t [h],nu,S\n1,1,1\n", 2, "the time has the unit 'h'"),
    ],
)
def test_bad_tables(tmp_path, capsys, text, code, words):
    (tmp_path / "i.csv").write_text(text)
    assert main(["tune", "i.csv"]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err


def test_bad_files(tmp_path, capsys):
    assert main(["tune", "absent.csv"]) == 1
    (tmp_path / "i.csv").write_bytes(b"\xff\xfe\x00\x80")
    assert main(["tune", "i.csv"]) == 1
    assert "is not text" in capsys.readouterr().err
