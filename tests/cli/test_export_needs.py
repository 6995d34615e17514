"""What an export needs is asked before a log is read, if the options show it, and else before its analysis."""

import numpy as np
import pytest

from known import seed_of
from sigmatau.cli import main
from sigmatau.errors import DataError

GYRO = [f"gyro_{axis} [rad/s]" for axis in "xyz"]
ACCEL = [f"accel_{axis} [m/s^2]" for axis in "xyz"]


def table(path, names, *, rate=100, n=2000):
    cells = np.random.default_rng(seed_of(path.name)).normal(0, 1e-3, (n, len(names)))
    rows = np.column_stack([np.arange(n) / rate, cells])
    np.savetxt(path, rows, delimiter=",", header=",".join(["time [s]", *names]), comments="", fmt="%.6g")
    return path


def of_two_rates(path, n=2000):
    """Rows of a gyro of 100 Hz and of an accelerometer of 50 Hz."""
    rng = np.random.default_rng(seed_of(path.name))
    rows = [(k / 100, "Gyro", *rng.normal(0, 1e-3, 3)) for k in range(n)]
    rows += [(k / 50 + 0.001, "Accel", *rng.normal([0, 0, 9.81], 1e-2)) for k in range(n // 2)]
    lines = (f"{word},{t:.4f},{x:.6f},{y:.6f},{z:.6f}" for t, word, x, y, z in sorted(rows))
    path.write_text("\n".join(["sensor,time [s],x,y,z", *lines]) + "\n")
    return path


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for k in "12":
        table(tmp_path / f"gyro{k}.csv", GYRO)
        table(tmp_path / f"two_axes{k}.csv", [*GYRO[:2], *ACCEL])
        of_two_rates(tmp_path / f"rates{k}.csv")
    return tmp_path


def forbid(monkeypatch, *names):
    for name in names:
        monkeypatch.setattr(f"sigmatau.cli.{name}", None)


UNITS = ("--unit", "gyro=rad/s,accel=m/s^2")
NEEDS = {
    "a sensor": ("gyro", ("--export", "kalibr=imu.yaml"), "kalibr: the log has no accelerometers"),
    "a rate": ("rates", (*UNITS, "--export", "vins=imu.yaml"), "(gyro 100 Hz, accel 50 Hz): give --filter-rate in Hz"),
    "a step": ("rates", (*UNITS, "--export", "state-space=m.json"), "give --step in seconds, or --filter-rate in Hz"),
    "an axis": (
        "two_axes",
        ("--axes", "each", "--export", "gazebo=imu.sdf"),
        "--export gazebo: --axes each needs three axes, and there is no gyro_z; --axes worst writes one value for all",
    ),
}


@pytest.mark.parametrize("case", NEEDS)
@pytest.mark.parametrize("joint", [False, True])
def test_before_the_analysis(folder, case, joint, monkeypatch, capsys):
    forbid(monkeypatch, "analyze.analyze", "joint.analyze")
    stem, words, message = NEEDS[case]
    logs = [f"{stem}1.csv", f"{stem}2.csv", "--joint"] if joint else [f"{stem}1.csv"]
    before = sorted(folder.iterdir())
    assert main(["analyze", *logs, *words]) == 2
    assert message in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before


OPTIONS = {
    "a sensor": (
        ("--channels", "time=2,gyro=3:5", "--export", "kalibr=imu.yaml"),
        "kalibr: the log has no accelerometers",
    ),
    "a rate": (
        ("--rate", "gyro=400,accel=200", "--export", "vins=imu.yaml"),
        "(gyro 400 Hz, accel 200 Hz): give --filter-rate in Hz",
    ),
    "an axis": (
        ("--channels", "gyro_x=3,gyro_y=4,accel=5:7", "--axes", "each", "--export", "gazebo=imu.sdf"),
        "--axes each needs three axes, and there is no gyro_z",
    ),
    "a horizon": (("--rate-random-walk", "gyro=horizon", "--export", "kalibr=imu.yaml"), "needs --horizon"),
    "a field": (("--step", "5ms", "--export", "kalibr=imu.yaml"), "--step does not apply to kalibr"),
}


@pytest.mark.parametrize("case", OPTIONS)
@pytest.mark.parametrize("joint", [False, True])
def test_before_a_log_is_read(folder, case, joint, monkeypatch, capsys):
    forbid(monkeypatch, "analyze.read_log", "joint.read_log")
    words, message = OPTIONS[case]
    assert main(["analyze", *(["rates1.csv", "rates2.csv", "--joint"] if joint else ["rates1.csv"]), *words]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ("--rate", "gyro=100,accel=50", "--filter-rate", "100", *UNITS),
        ("--rate", "gyro=100", *UNITS, "--filter-rate", "100"),
    ],
)
def test_what_is_stated_is_not_asked(folder, words, capsys):
    assert main(["analyze", "rates1.csv", *words, "--export", "vins=imu.yaml", "-q"]) == 0, capsys.readouterr().err
    assert (folder / "imu.yaml").is_file()


def test_runs_of_other_sensors_are_refused_before_their_analysis(folder, monkeypatch, capsys):
    table(folder / "fast.csv", GYRO, rate=200)
    analysed = []
    import sigmatau.cli.joint as command

    real = command.analyze
    monkeypatch.setattr(command, "analyze", lambda record, **how: analysed.append(record) or real(record, **how))
    assert main(["analyze", "gyro1.csv", "fast.csv", "--joint"]) == 1
    assert "fast.csv: gyro_x has 200 Hz, in gyro1.csv it has 100 Hz" in capsys.readouterr().err
    assert len(analysed) == 1


def test_a_picture_that_fails_takes_no_summary_away(folder, monkeypatch, capsys):
    def fail(*_):
        raise DataError("all.png: cannot be written: No space left on device")

    monkeypatch.setattr("sigmatau.cli.analyze.write_figure", fail)
    code = main(["analyze", "gyro1.csv", "gyro2.csv", "--overlay", "all.png"])
    out, err = capsys.readouterr()
    assert code == 1
    assert "gyro1.csv" in out
    assert "No space left on device" in err
