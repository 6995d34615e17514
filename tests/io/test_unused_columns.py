"""Channels of a log that are not a sensor's by their names: read if they are asked for."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, OptionError, read, simulate, simulate_to
from sigmatau.findings.columns import UnitOverruled
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
NEEDS = {"parquet": "pyarrow"}


def asked(text):
    """The mapping that stands in an advice."""
    (option,) = (word for word in text.split("--channels ")[1].replace(";", " ").split()[:1])
    return dict(pair.split("=") for pair in option.split(","))


@pytest.mark.parametrize("ending", ["csv", "csv.gz", "npy", "npz", "parquet"])
def test_signals_are_read_if_they_are_named(tmp_path, ending):
    """By their columns `read` gives the record of `simulate`, in the units of the log, which nobody has to say again."""
    if ending in NEEDS:
        pytest.importorskip(NEEDS[ending])
    path = tmp_path / f"a.{ending}"
    simulate_to(path, MODEL, **OPTIONS)
    left = read(path)
    assert set(left.channels) == {"gyro_x", "accel_x"}
    assert len(left.provenance.ignored) == len(SIGNAL)
    record = read(path, channels={name: name for name in MODEL.channels})
    assert record.findings == ()
    expected = simulate(MODEL, **OPTIONS)
    assert set(record.channels) == set(MODEL.channels)
    for channel in MODEL.channels:
        got, wanted = record.stream_of(channel), expected.stream_of(channel)
        assert got.unit == wanted.unit
        np.testing.assert_array_equal(got.column(channel), wanted.column(channel))


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


def test_names_that_an_option_can_hold():
    taken = {}
    for name, expected in {
        "Pressure a [Pa]": "pressure_a",
        "pressure-a (hPa)": "pressure_a_2",
        "gyro temp [degX]": "signal_gyro_temp",
        "1 [V]": "signal_1",
        "Δp, total [Pa]": "δp_total",
        "time of flight [ns]": "signal_time_of_flight",
    }.items():
        taken[signal_name(Column(name=name), taken=taken)] = name
        assert list(taken)[-1] == expected
