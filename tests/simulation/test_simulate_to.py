"""Records simulated into files: the same as in memory, for any chunk, in every format; whole files or none."""

import sys

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, Imperfections, NoiseModel, OptionError, read, simulate, simulate_to
from sigmatau.io.write import TABLE_ENDINGS
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.simulation.imperfections import Outage, Temperature, WarmUp

MODEL = NoiseModel(
    channels={
        "gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6, "rate_ramp": 1e-7},
        "gyro_y": ChannelModel(terms={"random_walk": 1e-4}, bandwidth=LowPass(order=2, corner=30.0)),
        "accel_z": ChannelModel(
            terms={"quantization": 1e-3, "random_walk": 1e-2, "bias_instability": 1e-4},
            gauss_markov=(GaussMarkov(sigma=1e-3, time=2.0),),
            sinusoid=(Sinusoid(amplitude=0.01, frequency=3.0),),
            quantity="acceleration",
            unit="m/s^2",
        ),
    },
    correlation={"bias_instability": {("gyro_x", "accel_z"): 0.4}},
)
REAL = {
    "level": {"accel_z": 9.8},
    "warm_up": {"gyro": WarmUp(amplitude=1e-3, time=20.0)},
    "temperature": Temperature(start=20.0, end=30.0, time=30.0, swing=1.0, sensitivity={"gyro_x": 1e-5}),
    "lsb": {"gyro_x": 1e-5},
    "saturation": {"gyro_y": 2e-3},
    "lost": 0.01,
    "outages": (Outage(start=30.0, length=1.0),),
    "jitter": 2e-5,
}
OPTIONS = {"duration": 100.0, "rate": 100.0, "rng": seed_of("into files")}
needs = {".parquet": "pyarrow"}


def same(got, expected, *, rtol=0.0, rate=1e-12):
    """Names, units, grid, missing samples and samples; those to `rtol`, the sampling rate to `rate`, relative."""
    assert [s.name for s in got.streams] == [s.name for s in expected.streams]
    for a, b in zip(got.streams, expected.streams, strict=True):
        assert (a.quantity, a.unit, a.channels, a.grid.n) == (b.quantity, b.unit, b.channels, b.grid.n)
        assert a.grid.rate == pytest.approx(b.grid.rate, rel=rate)
        for channel in a.channels:
            np.testing.assert_allclose(a.column(channel), b.column(channel), rtol=rtol, atol=0)


@pytest.mark.parametrize("ending", TABLE_ENDINGS)
@pytest.mark.parametrize("output", ["rate", "increments", "accumulated"])
def test_a_real_log_is_read_back_to_the_same_record(tmp_path, ending, output):
    if ending in needs:
        pytest.importorskip(needs[ending])
    given = Imperfections(output=output, **REAL)
    made = simulate_to(tmp_path / f"log{ending}", MODEL, imperfections=given, chunk=777, **OPTIONS)
    back = read(tmp_path / f"log{ending}", input=output)
    expected = simulate(MODEL, imperfections=given, flicker="poles", **OPTIONS)
    # Jittering stamps give the interval to 20 µs·√12/10000^(3/2) of 10 ms, 7e-9, times 4; increments are divided by it.
    same(back, expected, rtol=0 if output == "rate" else 3e-8, rate=3e-8)
    assert [f.code for f in back.findings] == ["gaps"]
    assert [p.name for p in tmp_path.iterdir()] == [f"log{ending}"]
    assert made.samples == 10_000
    assert made.lost == made.samples + (output == "accumulated") - back.provenance.rows
    assert made.lost > 100
    assert made.channels == back.channels


@pytest.mark.parametrize("ending", TABLE_ENDINGS)
def test_a_clean_log_is_bit_for_bit_what_is_in_memory(tmp_path, ending):
    if ending in needs:
        pytest.importorskip(needs[ending])
    for flicker in ("poles", "exact"):
        simulate_to(tmp_path / f"log{ending}", MODEL, flicker=flicker, **OPTIONS)
        same(read(tmp_path / f"log{ending}"), simulate(MODEL, flicker=flicker, **OPTIONS))


@pytest.mark.parametrize("output", ["rate", "increments", "accumulated"])
def test_any_chunks_give_the_same_file(tmp_path, output):
    given = Imperfections(output=output, **REAL | {"lsb": {"gyro_x": 1e-7}})
    files = []
    for chunk in (7, 37, 1000, 10_000, 1 << 20):
        path = tmp_path / f"{chunk}.npy"
        simulate_to(path, MODEL, imperfections=given, chunk=chunk, **{**OPTIONS, "duration": 40.0})
        files.append(path.read_bytes())
    assert len(set(files)) == 1


@pytest.mark.parametrize("ending", TABLE_ENDINGS)
def test_the_same_seed_gives_the_same_bytes(tmp_path, ending):
    if ending in needs:
        pytest.importorskip(needs[ending])
    for name in "abc":
        rng = OPTIONS["rng"] + (name == "c")
        simulate_to(tmp_path / f"{name}{ending}", MODEL, duration=1.0, rate=100.0, rng=rng)
    a, b, c = ((tmp_path / f"{name}{ending}").read_bytes() for name in "abc")
    assert a == b
    assert a != c
    if ending == ".csv.gz":
        assert a[4:8] == bytes(4)  # RFC 1952: the time, which another second would change


def test_jitter_is_in_the_stamps_alone(tmp_path):
    sigma = 1e-4
    path = tmp_path / "log.npy"
    simulate_to(path, MODEL, imperfections=Imperfections(jitter=sigma), **OPTIONS)
    off = np.load(path)["time [s]"] - np.arange(10_000) / 100
    assert off.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * 10_000))
    assert np.abs(off).max() <= 4.5 * sigma * (1 + 1e-9)
    assert abs(np.corrcoef(off[1:], off[:-1])[0, 1]) < 0.04
    same(read(path), simulate(MODEL, flicker="poles", **OPTIONS), rate=4 * sigma / 0.01 * np.sqrt(12) / 1e6)


def test_rows_of_an_array_are_columns_with_units(tmp_path):
    simulate_to(tmp_path / "a.npy", MODEL, **OPTIONS)
    array = np.load(tmp_path / "a.npy")
    assert array.dtype.names == ("time [s]", "gyro_x [rad/s]", "gyro_y [rad/s]", "accel_z [m/s^2]")
    assert array.shape == (10_000,)


@pytest.mark.parametrize("ending", TABLE_ENDINGS)
@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_nothing_is_left_of_a_run_that_ends_early(tmp_path, ending, error):
    if ending in needs:
        pytest.importorskip(needs[ending])
    (tmp_path / f"a{ending}").write_text("what was there")

    def stop(part):
        if part > 0.5:
            raise error

    with pytest.raises(error):
        simulate_to(tmp_path / f"a{ending}", MODEL, chunk=1000, progress=stop, **OPTIONS)
    assert [p.name for p in tmp_path.iterdir()] == [f"a{ending}"]
    assert (tmp_path / f"a{ending}").read_text() == "what was there"


def test_progress(tmp_path):
    parts = []
    simulate_to(tmp_path / "a.npy", MODEL, chunk=2500, progress=parts.append, **OPTIONS)
    assert parts == [0.25, 0.5, 0.75, 1.0]


def test_wrong_arguments(tmp_path):
    with pytest.raises(OptionError, match="chunk"):
        simulate_to(tmp_path / "a.npy", MODEL, chunk=0, **OPTIONS)
    with pytest.raises(OptionError, match=r"\.parquet"):
        simulate_to(tmp_path / "a.xlsx", MODEL, **OPTIONS)
    with pytest.raises(DataError, match="no directory"):
        simulate_to(tmp_path / "absent" / "a.npy", MODEL, **OPTIONS)
    odd = NoiseModel(channels={"a,b": ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")})
    with pytest.raises(DataError, match="'a,b'"):
        simulate_to(tmp_path / "a.csv", odd, **OPTIONS)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", needs)
def test_a_missing_library_is_told(tmp_path, monkeypatch, ending):
    monkeypatch.setitem(sys.modules, needs[ending], None)
    with pytest.raises(DataError, match=r"pip install 'sigmatau\["):
        simulate_to(tmp_path / f"a{ending}", MODEL, **OPTIONS)
    assert list(tmp_path.iterdir()) == []


NAMES = {
    "time": "together with 'time': a reader reads both as time",
    "stamp": "together with 'time': a reader reads both as time",
    "Time ": "together with 'time': a reader reads both as time",
    "gyr_x": "a reader reads both as gyro_x",
    "": "a channel needs a name",
    " ": "a channel needs a name",
    "a\0b": "must be printable text",
    "a\x1bb": "must be printable text",
    "a\ud800": "must be printable text",
    "a" * 70_000: "70004 characters, and at most 200 are allowed",
}


@pytest.mark.parametrize("ending", TABLE_ENDINGS)
@pytest.mark.parametrize(
    "name", NAMES, ids=[name[:6].strip().encode("unicode_escape").decode() or "none" for name in NAMES]
)
def test_names_that_no_reader_gives_back_are_refused_at_once(tmp_path, ending, name):
    """Of HDF5 the second column of a name was a crash; of text the log could not be read."""
    if ending in needs:
        pytest.importorskip(needs[ending])
    noise = ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="V")
    model = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}, name: noise})
    with pytest.raises(DataError, match=NAMES[name]):
        simulate_to(tmp_path / f"a{ending}", model, **OPTIONS)
    assert not list(tmp_path.iterdir())


def test_names_of_a_format(tmp_path):
    for name, unit, ending, words in (
        ("a,b", "V", ".csv", "',' in its name"),
        ("a", "V,", ".csv", "',' in its unit"),
    ):
        if ending in needs:
            pytest.importorskip(needs[ending])
        noise = ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit=unit)
        with pytest.raises(DataError, match=words):
            simulate_to(tmp_path / f"a{ending}", NoiseModel(channels={name: noise}), **OPTIONS)
    assert not list(tmp_path.iterdir())
