"""Files that hold several tables: which are read."""

import numpy as np
import pytest

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import Damaged
from sigmatau.io.read import assemble
from sigmatau.io.read.options import TableOptions
from sigmatau.io.read.table import Column, Loaded, Table

GYRO = tuple(f"gyro_{a} [rad/s]" for a in "xyz")
ACCEL = tuple(f"accel_{a} [m/s^2]" for a in "xyz")


def table(topic, names, rate=100.0, n=50, findings=(), late=(), times=None, zero=()):
    names = ("time [s]", *names)
    columns = {0: np.arange(n) / rate if times is None else times} | {
        i: np.full(n, 0.0 if names[i] in zero else float(i)) for i in range(1, len(names))
    }
    return Table(
        format="made",
        columns=tuple(Column(name=name) for name in names),
        notes=(),
        load=lambda wanted, exact: Loaded(columns={i: columns[i] for i in wanted}, findings=late),
        where=lambda row: f"row {row}",
        topic=topic,
        rows=n,
        findings=findings,
    )


def chosen(tables, *asked):
    return [t.topic for t in assemble.choose_tables(tables, asked)]


def options(**said):
    return TableOptions(
        **({"rate": None, "unit": None, "channels": None, "input": "rate", "scale": None, "offset": None} | said)
    ).checked()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "log"
    path.write_bytes(b"x")
    return path


class TestChoice:
    def test_the_only_one_with_both(self):
        tables = [table("/gps", ["lat", "lon"]), table("/imu", (*GYRO, *ACCEL)), table("/gyro", GYRO)]
        assert chosen(tables) == ["/imu"]

    def test_one_of_each(self):
        assert chosen([table("accel", ACCEL), table("baro", ["p"]), table("gyro", GYRO)]) == ["gyro", "accel"]
        assert chosen([table("baro", ["p"]), table("gyro", GYRO)]) == ["gyro"]

    def test_empty_ones_do_not_count(self):
        assert chosen([table("/imu0", (*GYRO, *ACCEL), n=0), table("/imu1", (*GYRO, *ACCEL))]) == ["/imu1"]

    @pytest.mark.parametrize(
        ("tables", "words"),
        [
            ([table("/imu0", (*GYRO, *ACCEL)), table("/imu1", (*GYRO, *ACCEL))], "several sensors: /imu0 .*50 rows"),
            ([table("gyro:0", GYRO), table("gyro:1", GYRO), table("accel", ACCEL)], "--topic gyro:0 --topic accel"),
            ([table("a", ["p"]), table("b", ["q"])], "has no IMU: none of its 2 topics"),
        ],
    )
    def test_doubt_is_asked_about(self, tables, words):
        with pytest.raises(OptionError, match=words):
            assemble.choose_tables(tables, ())

    def test_by_name(self):
        tables = [table("/a/imu", (*GYRO, *ACCEL)), table("/b/imu", (*GYRO, *ACCEL)), table("/b/Gyro", GYRO)]
        assert chosen(tables, "/b/imu") == ["/b/imu"]
        assert chosen(tables, "b/IMU", "/b/imu") == ["/b/imu"]
        assert chosen(tables, "gyro") == ["/b/Gyro"]
        flight = [table("sensor_gyro:0", GYRO), table("IMU[0]", GYRO), table("IMU[1]", GYRO)]
        assert chosen(flight, "IMU[1], sensor_gyro") == ["IMU[1]", "sensor_gyro:0"]
        assert chosen(flight, "sensor_gyro") == ["sensor_gyro:0"]
        with pytest.raises(OptionError, match="several topics match"):
            chosen(flight, "imu")
        with pytest.raises(OptionError, match="several topics match"):
            chosen(tables, "imu")
        with pytest.raises(OptionError, match="has no topic 'mag'; it has /a/imu"):
            chosen(tables, "mag")
        with pytest.raises(OptionError, match="one table and no topics"):
            chosen([table("", GYRO)], "imu")

    def test_an_empty_topic_is_not_preferred(self):
        imu = (*GYRO, *ACCEL)
        tables = [table("/cam0/imu", imu, n=0), table("/imu/data_raw", imu), table("/imu0", GYRO, n=0)]
        assert chosen(tables, "imu") == ["/imu/data_raw"]
        assert chosen(tables, "/cam0/imu") == chosen(tables, "cam0/imu") == ["/cam0/imu"]
        assert chosen(tables, "imu0") == ["/imu0"]
        with pytest.raises(OptionError, match="several topics match"):
            chosen([*tables, table("/imu/data", imu)], "imu")


class TestRecord:
    def test_two_rates(self, file):
        lost = Finding(details=Damaged(what="file"), severity="error")
        tables = [table("g", GYRO, rate=100, n=60, findings=(lost,)), table("a", ACCEL, rate=50, n=40, late=(lost,))]
        record = assemble.assemble(tables, file, options(unit={"gyro": "deg/s"}))
        gyro, accel = record.streams
        assert (gyro.grid.n, round(gyro.grid.rate), accel.grid.n, round(accel.grid.rate)) == (60, 100, 40, 50)
        assert record.provenance.topics == ("g", "a")
        assert record.provenance.rows == 60
        # Once, though both tables say it; and the unit that was given is not that of the file.
        assert sorted(f.code for f in record.findings) == ["damaged", *["unit_overruled"] * 3]
        assert gyro.column("gyro_x")[0] == pytest.approx(np.pi / 180)
        assert any(note.startswith("g: gyro_x: deg/s") for note in record.provenance.conversions)

    def test_times_count_from_the_first_sample_of_all_topics(self, file):
        """The second sensor begins 20 s later and loses a second after 3 s."""
        times = 20 + np.delete(np.arange(1000), np.s_[300:400]) / 100
        tables = [table("g", GYRO, n=5000), table("a", ACCEL, n=len(times), times=times)]
        (gaps,) = assemble.assemble(tables, file, options()).findings
        assert gaps.spans == (pytest.approx((23.0, 24.0)),)
        assert gaps.details.longest[0].start == gaps.spans[0][0]

    def test_findings_name_the_topic(self, file):
        """Not those that all topics have, which are about the file, nor any in a file of one topic."""
        lost = Finding(details=Damaged(what="file"), severity="error")
        times = np.delete(np.arange(1000), np.s_[300:400]) / 100
        gappy = table("/imu/a", ACCEL, n=len(times), times=times, findings=(lost,))
        tables = [table("/imu/g", GYRO, n=1000, findings=(lost,)), gappy]
        found = assemble.assemble(tables, file, options()).findings
        assert [(one.code, one.topic) for one in found] == [("damaged", ""), ("gaps", "/imu/a")]
        assert str(found[1]).startswith("warning: /imu/a: 100 of 1000 samples")
        assert found[1].to_dict()["topic"] == "/imu/a"
        assert [one.topic for one in assemble.assemble([gappy], file, options()).findings] == ["", ""]

    def test_a_slip_of_the_pen_is_seen(self, file):
        tables = [table("g", GYRO), table("a", ACCEL)]
        with pytest.raises(OptionError, match="no such channel"):
            assemble.assemble(tables, file, options(unit={"gyor": "deg/s"}))

    def test_the_same_sensor_twice(self, file):
        with pytest.raises(OptionError, match="g and h both have gyro"):
            assemble.assemble([table("g", GYRO), table("h", GYRO)], file, options())

    def test_each_with_the_fields_of_both(self, file):
        """A depth camera: two topics of one type, each with zeros for the other sensor."""
        gyro, accel = (
            table(name, (*GYRO, *ACCEL), rate=r, zero=z) for name, r, z in (("g", 200, ACCEL), ("a", 63, GYRO))
        )
        record = assemble.assemble([gyro, accel], file, options())
        assert [(stream.name, round(stream.grid.rate)) for stream in record.streams] == [("gyro", 200), ("accel", 63)]
        assert "g: accel: zero in all rows, and in another topic too" in record.provenance.ignored
        off = table("a", (*GYRO, *ACCEL), zero=(*GYRO, *ACCEL))
        with pytest.raises(OptionError, match="g and a both have gyro"):
            assemble.assemble([gyro, off], file, options())
        both = table("b", (*GYRO, *ACCEL))
        with pytest.raises(OptionError, match="g and b both have gyro"):
            assemble.assemble([gyro, both], file, options())

    def test_columns_are_of_one_topic(self, file):
        with pytest.raises(OptionError, match="--channels applies to one topic"):
            assemble.assemble([table("g", GYRO), table("a", ACCEL)], file, options(channels={"gyro_x": 2}))

    @pytest.mark.parametrize("topic", [3, [1], {"a": 1}])
    def test_no_name(self, topic):
        with pytest.raises(OptionError, match="--topic"):
            options(topic=topic)


class TestDevices:
    """A gyro and an accelerometer of one device are read together, by the names of their topics."""

    @pytest.mark.parametrize(
        ("gyro", "accel"),
        [
            ("/camera/gyro/sample", "/camera/accel/sample"),
            ("/camera/camera/gyro/sample", "/camera/camera/accel/sample"),
            ("/device_0/sensor_2/Gyro_0/imu/data", "/device_0/sensor_2/Accel_0/imu/data"),
            ("sensor_gyro:0", "sensor_accel:0"),
            ("vehicle_angular_velocity", "vehicle_acceleration"),
            ("imu/angular_velocity", "imu/linear_acceleration"),
            ("phone/gyroscope", "phone/accelerometer"),
            ("T265/gyr", "T265/acc"),
        ],
    )
    def test_each_with_the_fields_of_both(self, gyro, accel):
        tables = [table(accel, (*GYRO, *ACCEL)), table("baro", ["p"]), table(gyro, (*GYRO, *ACCEL))]
        assert chosen(tables) == [gyro, accel]

    def test_a_topic_with_both_comes_first(self):
        tables = [table("sensor_gyro:0", GYRO), table("sensor_accel:0", ACCEL), table("combined", (*GYRO, *ACCEL))]
        assert chosen(tables) == ["combined"]

    @pytest.mark.parametrize(
        ("topics", "words"),
        [
            (
                ("left/gyro", "left/accel", "right/gyro", "right/accel"),
                r"e\.g\. --topic left/gyro --topic left/accel, or --topic right/gyro --topic right/accel",
            ),
            (("cam/gyro", "cam/accel", "gyro"), "e.g. --topic cam/gyro --topic cam/accel$"),
        ],
    )
    def test_several_devices_are_proposed(self, topics, words):
        with pytest.raises(OptionError, match=words):
            chosen([table(name, GYRO if "gyro" in name else ACCEL) for name in topics])

    def test_names_of_no_device(self):
        tables = [table(name, (*GYRO, *ACCEL)) for name in ("imu/accel_gyro", "imu/gyro_accel_raw")]
        with pytest.raises(OptionError, match="several sensors"):
            chosen(tables)
