"""inspect(): what is in a file, before anything is asked of it."""

import json

import h5py
import numpy as np
import pytest
import scipy.io

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import as_arguments, speaking
from sigmatau.io.read import inspection
from sigmatau.io.read.options import ReadOptions
from sigmatau.record.summary import summarise


@pytest.fixture
def csv(tmp_path):
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{k / 50},{k % 7},{k % 5},{k % 3}" for k in range(100))
    path.write_text(f"time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]\n{rows}\n")
    return path


def test_a_log_that_says_all(csv):
    (table,) = st.inspect(csv).tables
    assert (table.rows, table.rate, table.chosen, table.wanting) == (100, pytest.approx(50), True, "")
    assert [(c.channel, c.unit) for c in table.columns] == [("time", "s")] + [(f"gyro_{a}", "deg/s") for a in "xyz"]
    printed = repr(st.inspect(csv))
    assert "100 rows, 2 s, 50 Hz (time stamps in column 'time [s]')" in printed
    assert "3 gyro_y [deg/s]  gyro_y [deg/s]" in printed


def test_what_would_be_asked_for(saved):
    path = saved("gx,gy,gz\n" + "1,2,3\n" * 40, "b.csv")
    found = st.inspect(path)
    assert found.tables[0].rows == 40
    assert "does not state the unit of gyro_x" in found.tables[0].wanting
    assert "--rate HZ" in found.tables[0].wanting
    assert st.inspect(path, unit={"gyro": "deg/s"}, rate=10).tables[0].wanting == ""


@pytest.mark.parametrize(
    ("gravity", "example"),
    [(9.81, "accel=m/s^2"), (1.0, "accel=g"), (1000.0, "accel=mg"), (3.0, "accel=UNIT")],
)
def test_both_units_of_a_gyro_are_offered_with_its_noise_in_each(tmp_path, gravity, example):
    """The unit of the accelerometer is that in which gravity is seen; one that the values do not show cannot be run."""
    path = tmp_path / "b.csv"
    rows = "".join(f"{x},0.02,0.03,{0.6 * gravity},0.0,{-0.8 * gravity}\n" for x in (0.01, 0.02) * 50)
    path.write_text("gx,gy,gz,ax,ay,az\n" + rows)
    asked = st.inspect(path, rate=10).tables[0].wanting
    assert f"e.g. --unit gyro=deg/s,{example} (gyro noise 0.0071 deg/s rms) or" in asked
    assert f" or --unit gyro=rad/s,{example} (gyro noise 0.41 deg/s rms). The values do not show which" in asked
    units = {"gyro": "rad/s", "accel": example.partition("=")[2]}
    if units["accel"] == "UNIT":
        with pytest.raises(st.OptionError, match="unknown unit 'UNIT'"):
            st.read(path, rate=10, unit=units)
    else:
        accel = st.read(path, rate=10, unit=units).stream_of("accel_z").column("accel_z")
        assert accel[0] == pytest.approx(-0.8 * 9.8, rel=2e-3)


@pytest.mark.parametrize(
    ("header", "options", "asked"),
    [
        ("ax,ay", {}, "give e.g. --unit accel=m/s^2 or --unit accel=g. The values do not show which"),
        (
            "gx,gy",
            {"input": "increments"},
            "give e.g. --unit gyro=deg or --unit gyro=rad. The values do not show which",
        ),
        ("gx,gy", {"scale": {"gyro": 0.01}}, "give e.g. --unit gyro=deg/s or --unit gyro=rad/s. The values"),
        ("ax,ay", {"input": "increments"}, "give e.g. --unit accel=m/s"),
    ],
)
def test_units_that_the_values_leave_open(saved, header, options, asked):
    path = saved(header.replace("a", "accel_").replace("g", "gyro_") + "\n" + "1.5,2.5\n2.5,1.5\n" * 40, "b.csv")
    assert asked in st.inspect(path, rate=10, **options).tables[0].wanting


def test_the_unit_that_is_asked_for_leaves_those_that_are_stated(saved):
    path = saved("gyro_x,gyro_y [rad/s],accel_x\n" + "1,2,3\n" * 40, "b.csv")
    assert (
        "e.g. --unit gyro_x=deg/s,accel=UNIT or --unit gyro_x=rad/s,accel=UNIT"
        in st.inspect(path, rate=10).tables[0].wanting
    )


def test_no_names(tmp_path):
    path = tmp_path / "c.npy"
    np.save(path, np.ones((30, 7)))
    found = st.inspect(path)
    assert found.tables[0].rows == 30
    assert "--channels time=N,gyro=N:N,accel=N:N" in found.tables[0].wanting
    assert st.inspect(path, channels={"gyro": "2:4"}, unit={"gyro": "rad/s"}, rate=5).tables[0].rate == 5


def test_columns_without_known_names_show_their_first_value(tmp_path):
    path = tmp_path / "m.mat"
    scipy.io.savemat(path, {"data": np.arange(2.5, 122.5).reshape(30, 4)})
    (table,) = st.inspect(path).tables
    assert [(c.name, c.first) for c in table.columns] == [(f"data_{k + 1}", f"{k + 2.5}") for k in range(4)]
    assert "2 data_2 (3.5 …)\n" in repr(st.inspect(path))
    text = tmp_path / "t.csv"
    text.write_text("0.0,2,3\n" + "1,2,3\n" * 40)
    assert [(c.name, c.first) for c in st.inspect(text).tables[0].columns] == [("", "0.0"), ("", "2"), ("", "3")]
    named = tmp_path / "b.csv"
    named.write_text("gx,gy,gz\n" + "1,2,3\n" * 40)
    assert [c.first for c in st.inspect(named).tables[0].columns] == [""] * 3


def test_findings_of_several_topics_name_theirs(tmp_path, capsys):
    path = tmp_path / "two.h5"
    with h5py.File(path, "w") as file:
        for name, lost in (("imu0", 0), ("imu1", 40)):
            times = np.delete(np.arange(400) / 50, np.s_[100 : 100 + lost])
            file[f"{name}/time [s]"] = times
            file[f"{name}/gyro [rad/s]"] = np.random.default_rng(seed_of(name)).standard_normal((len(times), 3))
    found = st.inspect(path)
    assert [(one.code, one.topic) for one in found.findings] == [("gaps", "/imu1")]
    assert main(["inspect", str(path)]) == 0
    assert ": /imu1: 40 of 400 samples" in capsys.readouterr().out


def test_data_that_cannot_be_used_are_a_finding(csv):
    csv.write_text(csv.read_text().replace("\n0.2,", "\nx,"))
    (finding,) = st.inspect(csv).findings
    assert (finding.code, finding.severity) == ("unusable", "error")
    assert "line 12: column time [s] has 'x', which is not a number" in finding.details.reason


def test_no_file_and_wrong_options(tmp_path, csv):
    with pytest.raises(DataError, match="there is no such file"):
        st.inspect(tmp_path / "none")
    with pytest.raises(OptionError, match="one table and no topics"):
        st.inspect(csv, topic="imu")
    with pytest.raises(OptionError, match="--rate must be"):
        st.inspect(csv, rate=-1)


def test_command(csv, tmp_path, capsys):
    assert main(["inspect", str(csv)]) == 0
    assert capsys.readouterr().out.startswith(f"{csv}: text\n  100 rows")
    assert main(["inspect", str(csv), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == st.inspect(csv).to_dict()
    target = tmp_path / "i.json"
    assert main(["inspect", str(csv), "--json", str(target)]) == 0
    assert json.loads(target.read_text()) == found
    csv.write_text(csv.read_text().replace("\n0.2,", "\nx,"))
    assert main(["inspect", str(csv)]) == 4
    assert main(["inspect", str(csv), "--json", str(csv)]) == 2
    assert main(["inspect", str(tmp_path / "none")]) == 1


def test_options_are_typed_or_arguments(tmp_path, capsys):
    """As they are typed on the command line, as arguments in Python."""
    bare, named = tmp_path / "c.npy", tmp_path / "b.csv"
    np.save(bare, np.ones((30, 7)))
    named.write_text("gx,gy,gz,ax,ay,az\n" + "1,2,3,4,5,6\n" * 40)
    assert main(["inspect", str(bare)]) == 0
    assert "--channels time=N,gyro=N:N,accel=N:N" in capsys.readouterr().out
    with speaking(as_arguments):
        assert '`channels={"time": "N", "gyro": "N:N", "accel": "N:N"}`' in repr(st.inspect(bare))
        assert 'give e.g. `unit={"gyro": "deg/s", "accel": "UNIT"}, rate=HZ`' in repr(st.inspect(named))
    assert main(["inspect", str(named)]) == 0
    assert "give e.g. --unit gyro=deg/s,accel=UNIT --rate HZ or --unit gyro=rad/s" in capsys.readouterr().out


def test_what_the_columns_contain(tmp_path):
    """First values and a picture of every column that can be loaded, those that are no channels too."""
    log = tmp_path / "log.csv"
    rows = np.column_stack(
        [np.arange(1000) / 100, np.random.default_rng(seed_of("columns")).standard_normal((1000, 2))]
    )
    rows[10, 2] = np.nan
    np.savetxt(log, rows, delimiter=",", header="time [s],gyro_x [rad/s],load", comments="")
    (table,) = inspection.inspect(log, ReadOptions(), sampled=True).tables
    assert table.places == {"time": 0, "gyro_x": 1}
    for k in range(3):
        samples = table.samples[k]
        assert samples.first == pytest.approx(rows[:5, k])
        assert len(samples.low) == len(samples.high) == 64
        assert (samples.low.min(), samples.high.max()) == pytest.approx((np.nanmin(rows[:, k]), np.nanmax(rows[:, k])))
    (plain,) = inspection.inspect(log, ReadOptions()).tables
    assert not plain.samples
    (named,) = inspection.inspect(log, ReadOptions(channels={"time": 1, "gyro_x": 3}), sampled=True).tables
    assert named.question
    assert named.places == {"time": 0, "gyro_x": 2}


def test_a_channel_in_a_few_numbers():
    x = np.arange(1000.0)
    x[[10, 11, 500]] = np.nan
    summary = summarise(st.Record.from_arrays(rate=100, gyro_x=x, unit={"gyro": "rad/s"}).streams[0], "gyro_x")
    assert (summary.low, summary.high, summary.peak_to_peak) == (0, 999, 999)
    assert (summary.missing, summary.gaps) == (3, 2)
    assert summary.mean == pytest.approx(np.nanmean(x))
