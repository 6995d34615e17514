"""Records from data frames in memory."""

import numpy as np
import pytest
from readings import axes

import sigmatau
from sigmatau.errors import DataError, OptionError

N = 500
RNG = np.random.default_rng(9)
GYRO = RNG.normal(size=(N, 3))
STAMPS = 1_700_000_000_000_000_001 + np.arange(N) * 5_000_000


class Plain:
    """As little of a data frame as most libraries have: names, and columns by name."""

    def __init__(self, data):
        self.data = data
        self.columns = list(data)

    def __getitem__(self, name):
        return self.data[name]


NAMED = {"t_ns": STAMPS, "wx": GYRO[:, 0], "wy": GYRO[:, 1], "wz": GYRO[:, 2]}


def frames():
    yield "mapping", dict
    yield "plain", Plain
    yield "structured", lambda data: np.rec.fromarrays(list(data.values()), names=list(data))
    yield "pandas", lambda data: pytest.importorskip("pandas").DataFrame(data)
    yield "pyarrow", lambda data: pytest.importorskip("pyarrow").table(data)
    yield "polars", lambda data: pytest.importorskip("polars").DataFrame(data)
    yield "polars, lazy", lambda data: pytest.importorskip("polars").LazyFrame(data)


@pytest.mark.parametrize("make", [pytest.param(make, id=name) for name, make in frames()])
class TestFrames:
    def test_exact(self, make):
        record = sigmatau.from_frame(make(NAMED), unit={"gyro": "rad/s"})
        np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
        assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)
        assert (record.provenance.format, record.provenance.path, record.provenance.sha256) == ("frame", None, None)

    def test_options(self, make):
        options = {"unit": {"gyro": "deg/s"}, "scale": {"gyro": 2.0}, "offset": {"gyro": 1.0}}
        record = sigmatau.from_frame(make(NAMED), rate=200, channels={"gyro_x": "wy"}, **options)
        expected = (GYRO[:, 1] - 1) * 2 * (np.pi / 180)
        np.testing.assert_allclose(record.streams[0].column("gyro_x"), expected, rtol=1e-15)
        assert record.provenance.ignored == ("wx", "wz")
        with pytest.raises(OptionError, match=r"the frame: does not state the unit of gyro_x"):
            sigmatau.from_frame(make(NAMED))
        with pytest.raises(OptionError, match=r"the frame: has no column 'q'"):
            sigmatau.from_frame(make(NAMED), channels={"gyro_x": "q"})

    def test_not_a_number(self, make):
        data = NAMED | {"wy": np.where(np.arange(N) == 17, np.nan, 0.0)}
        record = sigmatau.from_frame(make(data), unit={"gyro": "rad/s"})
        assert np.flatnonzero(np.isnan(record.streams[0].column("gyro_y"))).tolist() == [17]
        assert [(f.code, f.details.place) for f in record.findings] == [("missing_values", "row 17")]
        data["wy"][17] = np.inf
        record = sigmatau.from_frame(make(data), unit={"gyro": "rad/s"})
        assert [(f.code, f.details.place) for f in record.findings] == [("missing_values", "row 17")]

    def test_dates(self, make):
        data = {"time": STAMPS.astype("M8[ns]")} | NAMED
        del data["t_ns"]
        record = sigmatau.from_frame(make(data), unit={"gyro": "rad/s"})
        assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)

    def test_words(self, make):
        data = NAMED | {"wx": np.array(["a"] * N)}
        with pytest.raises(DataError, match=r"the frame: column 'wx' holds .* not real numbers"):
            sigmatau.from_frame(make(data), channels={"gyro_x": "wx"}, rate=1, unit={"gyro": "rad/s"})


def test_mapping_of_three_columns():
    record = sigmatau.from_frame({"gyro_dps": GYRO.astype("f4")}, rate=10)
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO.astype("f4").astype(float) * (np.pi / 180))
    with pytest.raises(DataError, match=r"unequal length \(wx 500, wy 499\)"):
        sigmatau.from_frame({"wx": GYRO[:, 0], "wy": GYRO[1:, 1]}, rate=1, unit={"gyro": "rad/s"})


def test_pandas_index_units_and_missing_numbers():
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame(GYRO, columns=["wx", "wy", "wz"], index=pd.to_datetime(STAMPS, utc=True))
    frame.attrs["units"] = {"wx": "deg/s", "wy": "deg/s", "wz": "deg/s"}
    record = sigmatau.from_frame(frame)
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO * (np.pi / 180))
    assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)
    whole = pd.DataFrame({"wx": pd.array([1, 2, 3, 4, 5], dtype="Int64")})
    np.testing.assert_array_equal(
        sigmatau.from_frame(whole, rate=1, unit={"gyro": "rad/s"}).streams[0].column("gyro_x"), [1, 2, 3, 4, 5]
    )
    whole.loc[3, "wx"] = pd.NA
    holed = sigmatau.from_frame(whole, rate=1, unit={"gyro": "rad/s"}).streams[0]
    np.testing.assert_array_equal(holed.column("gyro_x"), [1, 2, 3, np.nan, 5])


def test_missing_times():
    times = STAMPS.astype("M8[ns]")
    times[4] = "NaT"
    record = sigmatau.from_frame({"time": times, "wx": GYRO[:, 0]}, unit={"gyro": "rad/s"})
    missing, gaps = record.findings
    assert (missing.code, missing.details.place) == ("bad_stamps", "row 4")
    assert (gaps.code, gaps.spans[0]) == ("gaps", pytest.approx((0.02, 0.025)))
    expected = GYRO[:, 0].copy()
    expected[4] = np.nan
    np.testing.assert_array_equal(record.streams[0].column("gyro_x"), expected)
    assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-15)


@pytest.mark.parametrize("what", [3, "log.csv", np.zeros(5), [1, 2, 3]])
def test_no_frame(what):
    with pytest.raises(TypeError, match="`frame` must be a data frame"):
        sigmatau.from_frame(what)


def test_a_series_is_no_frame():
    class Series:
        dtype = "float64"

        def __arrow_c_stream__(self, requested_schema=None):
            raise AssertionError("not asked for")

    with pytest.raises(DataError, match="one column without a name; give a frame"):
        sigmatau.from_frame(Series())


@pytest.mark.parametrize("kind", ["f8", "i4"])
def test_what_is_masked_is_missing(kind):
    values = np.ma.array(GYRO[:, 0] * 100, dtype=kind)
    assert sigmatau.from_frame({"wx": values, "wy": GYRO[:, 1]}, rate=1, unit={"gyro": "rad/s"}).channels
    values[17] = np.ma.masked
    record = sigmatau.from_frame({"wx": values, "wy": GYRO[:, 1]}, rate=1, unit={"gyro": "rad/s"})
    assert np.flatnonzero(np.isnan(record.streams[0].column("gyro_x"))).tolist() == [17]


def labelled(**variables):
    xr = pytest.importorskip("xarray")
    times = np.datetime64("2026-01-01") + np.arange(N) * np.timedelta64(5, "ms")
    return xr.Dataset(variables, coords={"time": times, "axis": list("xyz")})


def test_a_dataset_of_xarray():
    """Axes along a dimension with labels, in any order of the dimensions; units from attributes; dates as stamps."""
    data = labelled(
        gyro=(("axis", "time"), GYRO.T, {"units": "rad s-1"}),
        accel=(("time", "axis"), GYRO, {"units": "g"}),
        temperature=("time", GYRO[:, 0], {"units": "degC"}),
        serial=((), 7),
    )
    record = sigmatau.from_frame(data)
    np.testing.assert_array_equal(axes(record, "gyro"), GYRO)
    assert [stream.name for stream in record.streams] == ["gyro", "accel", "temperature"]
    assert record.streams[1].column("accel_z") == pytest.approx(9.80665 * GYRO[:, 2])
    assert record.streams[0].grid.rate == pytest.approx(200, rel=1e-12)
    np.testing.assert_array_equal(axes(sigmatau.from_frame(data["gyro"]), "gyro"), GYRO)
    whole = data["gyro"].rename(None).assign_coords(axis=[f"gyro_{axis}" for axis in "xyz"])
    np.testing.assert_array_equal(axes(sigmatau.from_frame(whole), "gyro"), GYRO)
    with pytest.raises(
        DataError, match=r"without the dimension time of the samples: mean. Select .*data\[\['gyro'\]\]"
    ):
        sigmatau.from_frame(labelled(gyro=(("time", "axis"), GYRO), mean=("axis", GYRO[0])))


def test_results_are_datasets_of_xarray():
    pytest.importorskip("xarray")
    record = sigmatau.Record.from_arrays(rate=200, gyro=np.tile(GYRO, (8, 1)) + RNG.normal(size=(8 * N, 3)))
    curves = sigmatau.allan(record)
    data = curves.to_xarray()
    assert dict(data.sizes) == {"channel": 3, "tau_s": len(curves["gyro_x"].tau)}
    np.testing.assert_array_equal(data.adev.sel(channel="gyro_y"), curves["gyro_y"].adev)
    fits = sigmatau.analyze(record).fits
    terms = fits.to_xarray()
    assert list(terms.channel.values) == ["gyro_x", "gyro_y", "gyro_z"]
    assert list(terms.term.values)[:2] == ["quantization", "random_walk"]
    assert float(terms.value.sel(channel="gyro_z", term="random_walk")) == fits["gyro_z"]["random_walk"].value


def test_a_frame_without_place_names_its_columns():
    with pytest.raises(OptionError, match=r"columns: 1 'a', 2 'b'.*arguments of sigmatau.from_frame"):
        sigmatau.analyze(Plain({"a": GYRO[:, 0], "b": GYRO[:, 1]}))
