"""Channels of a log in this package's own form that are no sensor's by their names: said, with the way to read them."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, OptionError, inspect, read, simulate, simulate_to
from sigmatau.findings.kinds.reading import UnitOverruled
from sigmatau.io.read.names import signal_name
from sigmatau.io.read.table import Column
from sigmatau.model.channel import ChannelModel

SIGNAL = {"pressure_a": ("Pa", 0.2), "range": ("m", 1e-3), "magnet": ("uT", 0.1)}
MODEL = NoiseModel(
    channels={
        "gyro_x": {"random_walk": 1e-4},
        "accel_x": {"random_walk": 1e-3},
        **{n: ChannelModel(terms={"random_walk": v}, quantity="signal", unit=u) for n, (u, v) in SIGNAL.items()},
    }
)
OPTIONS = {"duration": 20.0, "rate": 50.0, "rng": seed_of("columns not read")}
NEEDS = {"parquet": "pyarrow", "h5": "h5py"}


def asked(text):
    """The mapping that stands in an advice."""
    (option,) = (word for word in text.split("--channels ")[1].replace(";", " ").split()[:1])
    return dict(pair.split("=") for pair in option.split(","))


@pytest.mark.parametrize("ending", ["csv", "csv.gz", "npy", "npz", "parquet", "h5"])
def test_what_the_advice_says_reads_the_whole_record(tmp_path, ending):
    """By it `read` gives the record of `simulate`, in the units of the log, which nobody has to say again."""
    if ending in NEEDS:
        pytest.importorskip(NEEDS[ending])
    path = tmp_path / f"a.{ending}"
    simulate_to(path, MODEL, **OPTIONS)
    (finding,) = read(path).findings
    assert (finding.code, finding.severity) == ("columns_not_read", "info")
    for name in SIGNAL:
        assert any(name in column for column in finding.details.columns)
    record = read(path, channels=dict(finding.details.channels))
    assert record.findings == ()
    expected = simulate(MODEL, **OPTIONS)
    assert set(record.channels) == set(MODEL.channels)
    for channel in MODEL.channels:
        got, wanted = record.stream_of(channel), expected.stream_of(channel)
        assert got.unit == wanted.unit
        np.testing.assert_array_equal(got.column(channel), wanted.column(channel))
    assert "columns_not_read" in [f.code for f in inspect(path).findings]


def test_a_model_of_signals_alone(tmp_path):
    simulate_to(tmp_path / "a.csv", MODEL.of(SIGNAL), **OPTIONS)
    with pytest.raises(OptionError, match=r"--channels pressure_a=2,range=3,magnet=4$") as error:
        read(tmp_path / "a.csv")
    record = read(tmp_path / "a.csv", channels=asked(str(error.value)))
    assert [stream.unit for stream in record.streams] == ["Pa", "m", "uT"]


def test_the_unit_of_a_signal_is_the_files(tmp_path):
    """Another one than the file's is taken, and said; the same is no finding."""
    path = tmp_path / "a.csv"
    simulate_to(path, MODEL, **OPTIONS)
    (finding,) = read(path, channels={"pressure_a": 4}, unit={"pressure_a": "V"}).findings
    assert (finding.channels, finding.details) == (("pressure_a",), UnitOverruled(given="V", stated="Pa"))
    assert read(path, channels={"pressure_a": 4}, unit={"pressure_a": "Pa"}).findings == ()


def test_increments_are_read_without_the_signals(tmp_path):
    """Else the numbers of a signal would be divided by the sample interval."""
    path = tmp_path / "a.csv"
    path.write_text("time [s],gyro_x [rad],p [Pa]\n" + "".join(f"{k / 10},{k % 3},{k % 5}\n" for k in range(40)))
    (finding,) = (f for f in read(path, input="increments").findings if f.code == "columns_not_read")
    assert (finding.details.channels, finding.details.as_rates) == ((("p", 3),), True)


@pytest.mark.parametrize(
    "header",
    [
        "time [s],gyro_x [rad/s],p",  # no unit: no measured quantity by its name
        "time [s],gyro_x [rad/s],temp [degC]",  # read, as a temperature
        "time [s],gyro_x [rad/s],log_time [s]",  # another clock
        "Time (s),Gyroscope x (rad/s),Absolute (rad/s)",  # other programs' logs have more than one asks for
        "time [s],gyr_x [rad/s],p [Pa]",
    ],
)
def test_others_are_not_told_of(tmp_path, header):
    path = tmp_path / "a.csv"
    path.write_text(header + "\n" + "".join(f"{k / 10},{k % 3},{20 + k % 5}\n" for k in range(40)))
    assert "columns_not_read" not in [f.code for f in read(path).findings]
    words = tmp_path / "b.csv"
    words.write_text("time [s],gyro_x [rad/s],p [Pa]\n" + "".join(f"{k / 10},{k % 3},ok\n" for k in range(40)))
    assert read(words).findings == ()


def test_names_that_an_option_can_hold():
    taken = {}
    for name in (
        "Pressure a [Pa]",
        "pressure-a (hPa)",
        "gyro temp [degX]",
        "1 [V]",
        "Δp, total [Pa]",
        "time of flight [ns]",
    ):
        taken[signal_name(Column(name=name), taken=taken)] = name
    assert list(taken) == [
        "pressure_a",
        "pressure_a_2",
        "signal_gyro_temp",
        "signal_1",
        "δp_total",
        "signal_time_of_flight",
    ]
