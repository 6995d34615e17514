"""Names: which column is which channel, and in what unit."""

import pytest

from sigmatau.errors import OptionError
from sigmatau.findings.columns import IncompleteSensor, MixedUnits, UnitOverruled, UnreadSensor, UnusedColumns
from sigmatau.io.read import read
from sigmatau.io.read.columns import choose
from sigmatau.io.read.names import recognise, split_unit
from sigmatau.io.read.table import Column

# Channel and unit that a name says: names of the column.
NAMES_BY_MEANING = {
    ("gyro_x", None): [
        "gyro_x", "gyrox", "GyrX", "gyro.x", "Gyroscope x", "wx", "w_x", "omega_x", "angular_velocity.x",
        "angularVelocityX", "angular_rate_x", "w_RS_S_x", "field.angular_velocity.x", "/imu/data/angular_velocity/x",
        "imu_gyro_x", "xgyro", "gyro[0]", "X_GYRO_OUT", "GYRO_XOUT", "gyro_x [LSB]",
    ],
    ("gyro_y", None): ["gyr_y", "angular_velocity_y", "inertial-6253.76535:scaledGyroY"],
    ("gyro_z", None): ["GyroZ", "angular_velocity/z", "gyro[2]"],
    ("gyro_x", "rad/s"): [
        "rotationRateX(rad/s)", "sensor_gyro.x [rad/s]", "gyro_rad_s_x", "wx(rad/s)", "wx (rad/s)",
        "angular_velocity.x [rad/s]", "Gyroskop x (rad/s)", "Giroscopio x (rad/s)",
    ],
    ("gyro_x", "rad s^-1"): ["w_RS_S_x [rad s^-1]"],
    ("gyro_z", "rad/s"): ["Gyroscope (z) [rad/s]", "angular_velocity_z_radians_per_second"],
    ("accel_x", "m/s2"): ["Accelerometer (X) [m/s2]"],
    ("accel_y", None): ["acc (y)", "AccY"],
    ("gyro_x", "d/s"): ["Gyro-X (d/s)"],
    ("accel_x", "g"): ["gFx", "accel_x_g"],
    ("accel_x", None): ["GForceX", "ax", "a_x", "acc_x", "accX", "linear_acceleration_x", "acceleration_x", "f_x"],
    ("accel_z", None): ["ACCEL_ZOUT", "Z_ACCL_OUT", "IMU_ATTI(0):accelZ", "accel_z", "linear_acceleration.z"],
    ("time", None): [
        "Clock:offsetTime", "time", "t", "timestamp", "Timestamp", "stamp", "header.stamp", "t_host", "elapsed", "GPSTime",
        "HEADER_TIME_STAMP",
    ],
    ("time", "ms"): ["ts_ms", "tick_ms", "GPS_MS[ms]", "time_ms", "time (ms)"],
    ("time", "us"): ["hal_ticks_us", "timestamp_sample", "SampleUS", "time_us", "TimeUS"],
    ("gyro_y", "rad/s"): ["gyro_rad[1]", "gyro_rad[1] [rad/s]"],
    ("accel_z", "m/s^2"): [
        "sensor_accel_fifo.z [m/s^2]", "accelerometer_m_s2[2]", "linear_acceleration.z [m/s^2]", "Accélération z (m/s^2)",
    ],
    ("gyro_x", "deg/s"): ["gyro_x_dps", "gyro_dps_x"],
    ("gyro_x", "mdeg/s"): ["gyro_x_mdps"],
    ("gyro_x", "mrad/s"): ["gyro_mrad_s_x"],
    ("accel_x", "mg"): ["accel_x_mg"],
    ("accel_x", "ug"): ["accel_x_ug"],
    ("gyro_z", "deg/h"): ["wz_deg_h"],
    ("gyro_x", "deg"): ["gyro_x [deg]"],
    ("accel_x", "m s^-2"): ["a_RS_S_x [m s^-2]"],
    ("accel_x", "m/s^2"): ["ax_m_s2", "X_ACCELERATION_METERS_PER_SECOND_SQUARED"],
    ("accel_y", "g"): ["accel_g_y"],
    ("accel_x", "m/s²"): ["acc_x [m/s²]"],
    ("time", "ns"): ["timestamp [ns]", "field.header.stamp", "header.stamp [ns]", "log_time [ns]", "t_ns"],
    None: ["angular_velocity_covariance[0]"],
    ("time", "s"): ["time_s", "seconds_elapsed", "Zeit (s)", "Tiempo (s)"],
    ("gyro_y", "deg/s"): ["Gyro_Y_degrees_per_second"],
    ("accel_y", "m/s^2"): ["Beschleunigung y (m/s^2)"],
}  # fmt: skip
RECOGNISED = {name: meaning for meaning, names in NAMES_BY_MEANING.items() for name in names}

# Headers of loggers and programs, and the channel of each column, with its unit; None for a column that is not read.
HEADERS = {
    "PlotJuggler": {
        "__time": ("time", "s"),
        **{f"/imu/data_raw/angular_velocity/{a}": (f"gyro_{a}", "rad/s") for a in "xyz"},
        **{f"/imu/data_raw/linear_acceleration/{a}": (f"accel_{a}", "m/s^2") for a in "xyz"},
        "/imu/data_raw/orientation/x": None,
    },
    "Shimmer": {
        "Shimmer_0000_Timestamp_Unix_CAL": ("time", None),
        "Shimmer_0000_Accel_LN_X_CAL": ("accel_x", None),
        "Shimmer_AB1F_Gyro_Y_CAL": ("gyro_y", None),
        "Shimmer_0000_Mag_X_CAL": None,
    },
    "Kalibr": {
        "timestamp": ("time", "ns"),
        **{f"omega_{a}": (f"gyro_{a}", "rad/s") for a in "xyz"},
        **{f"alpha_{a}": (f"accel_{a}", "m/s^2") for a in "xyz"},
    },
    "alpha as an angular acceleration": {
        "t": ("time", None),
        **{f"omega_{a}": (f"gyro_{a}", None) for a in "xyz"},
        **{f"alpha_{a}": None for a in "xyz"},
    },
    "MAVLink SCALED_IMU": {"SCALED_IMU2.xgyro": ("gyro_x", "mrad/s"), "SCALED_IMU2.zacc": ("accel_z", "mg")},
    "MAVLink HIGHRES_IMU": {"HIGHRES_IMU.xgyro": ("gyro_x", "rad/s"), "HIGHRES_IMU.zacc": ("accel_z", "m/s^2")},
    "Betaflight": {
        "loopIteration": None,
        "time (us)": ("time", "us"),
        **{f"gyroADC[{k}] (deg/s)": (f"gyro_{'xyz'[k]}", "deg/s") for k in range(3)},
        **{f"accSmooth[{k}] (g)": (f"accel_{'xyz'[k]}", "g") for k in range(3)},
        "motor[0]": None,
    },
    "phyphox, axes only": {
        "Time (s)": ("time", "s"),
        **{f"{a} (rad/s)": (f"gyro_{a.lower()}", "rad/s") for a in "XYZ"},
    },
    "phyphox, without gravity": {f"Linear Acceleration {a} (m/s^2)": None for a in "xyz"},
    "ROS by hand": {
        "Angular Velocity X (rad/s)": ("gyro_x", "rad/s"),
        "Linear Acceleration X (m/s^2)": ("accel_x", "m/s^2"),
    },
    "axes by unit": {**{f"rate.{a} [deg/s]": (f"gyro_{a}", "deg/s") for a in "xyz"}, "mag.x [uT]": None},
    "free acceleration by unit": {f"free_{a} [m/s^2]": None for a in "xyz"},
    "two triples by unit": {f"{s}_{a} [rad/s]": None for s in ("left", "right") for a in "xyz"},
    "Xsens": {"PacketCounter": None, "Acc_X": ("accel_x", None), "Gyr_X": ("gyro_x", None), "FreeAcc_X": None},
    "ST": {
        "T [ms]": ("time", "ms"),
        **{f"A_{a} [mg]": (f"accel_{a.lower()}", "mg") for a in "XYZ"},
        **{f"G_{a} [mdps]": (f"gyro_{a.lower()}", "mdps") for a in "XYZ"},
    },
    "iOS": {
        "motionTimestamp_sinceReboot(s)": ("time", "s"),
        "motionRotationRateX(rad/s)": ("gyro_x", "rad/s"),
        "accelerometerAccelerationX(G)": ("accel_x", "G"),
        "motionUserAccelerationX(G)": None,
        "motionGravityX(G)": None,
    },
    "LPMS": {"AccX (g)": ("accel_x", "g"), "LinAccX (g)": None, "GyroX (deg/s)": ("gyro_x", "deg/s")},
    "MicroStrain": {"X Accel [x8004]": ("accel_x", "g"), "Z Gyro [x8005]": ("gyro_z", "rad/s"), "Roll [x800C]": None},
    "Inertial Sense": {**{f"pqr[{k}]": (f"gyro_{'xyz'[k]}", None) for k in range(3)}, "acc[0]": ("accel_x", None)},
    "Android": {
        "ACCELEROMETER X (m/s²)": ("accel_x", "m/s²"),
        "LINEAR ACCELERATION X (m/s²)": None,
        "GRAVITY X (m/s²)": None,
        "Time since start in ms": ("time", "ms"),
    },
    "part numbers": {"MPU6050_GYRO_X": ("gyro_x", None), "LSM6DSO_ACC_X [mg]": ("accel_x", "mg")},
    "a bias is no rate": {"/ekf/bias/gyro/x": None, "/imu/gyro/x": ("gyro_x", None)},
}


@pytest.mark.parametrize("program", HEADERS)
def test_headers(program):
    header = HEADERS[program]
    assert dict(zip(header, recognise([Column(name=name) for name in header]), strict=True)) == header


# Gravity or an azimuth without their other axes, temperatures, accelerations without gravity, and other quantities.
NOT_RECOGNISED = [
    "", "x", "gx", "gyro", "gyro_temp", "gyro_x_bias", "bias_gyro_x", "angular_velocity_covariance[0]",
    "linear_acceleration_covariance_0", "orientation.x", "orientation.w", "qw", "mag_x", "temp_c", "T [degC]", "T",
    "t (°C)", "temperature", "az", "fx", "vx", "gyro_x [g]", "accel_x [deg/s]", "timezone", "time_x", "uptime_gyro",
    "user_acceleration_x", "Lineare Beschleunigung x (m/s^2)", "angular_acceleration_x",
]  # fmt: skip


@pytest.mark.parametrize(("name", "expected"), RECOGNISED.items(), ids=RECOGNISED)
def test_recognised(name, expected):
    siblings = [Column(name=n) for n in ("ay", "az", "a_y", "a_z") if name in ("ax", "a_x")]
    assert recognise([Column(name=name), *siblings])[0] == expected


@pytest.mark.parametrize("name", NOT_RECOGNISED)
def test_not_recognised(name):
    assert recognise([Column(name=name)]) == [None]


@pytest.mark.parametrize("stem", ["g", "g_", "a", "a_", "G", "A"])
def test_short_names_need_all_three_axes(stem):
    sensor = {"g": "gyro", "a": "accel"}[stem[0].lower()]
    three = recognise([Column(name=stem + axis) for axis in "xyz"])
    assert three == [(f"{sensor}_{axis}", None) for axis in "xyz"]
    assert recognise([Column(name=stem + axis) for axis in "yz"]) == [None, None]


def names(*columns):
    return [Column(name=name) for name in columns]


def test_unit_row_and_brackets():
    assert split_unit(Column(name="wx", unit="deg/s")) == ("wx", "deg/s")
    assert split_unit(Column(name="wx [rad/s]", unit="deg/s")) == ("wx", "deg/s")
    assert split_unit(Column(name="wx [LSB]")) == ("wx", None)
    assert split_unit(Column(name="gyro[0]")) == ("gyro[0]", None)
    assert split_unit(Column(name="[deg/s]")) == ("[deg/s]", None)
    assert split_unit(Column(name="n (deg/sqrt(h))")) == ("n", "deg/sqrt(h)")


def test_sensors_in_order_and_the_rest_left():
    choice = choose(names("accel_x", "t", "temp", "gyro_y", "gyro_x"), None)
    assert list(choice.channels.items()) == [("gyro_x", 4), ("gyro_y", 3), ("accel_x", 0)]
    assert choice.time == 1


COLUMNS = names("t", "wx [deg/s]", "wy", "wz", "5", "ax", "ay", "az", "temp")


@pytest.mark.parametrize(
    ("asked", "channels", "time"),
    [
        ({"gyro_x": "wx"}, {"gyro_x": 1}, 0),
        ({"gyro_x": "wx [deg/s]"}, {"gyro_x": 1}, 0),
        ({"gyro_x": "WX"}, {"gyro_x": 1}, 0),
        ({"gyro_x": 2, "time": 9}, {"gyro_x": 1}, 8),
        ({"gyro_x": " 2 "}, {"gyro_x": 1}, 0),
        ({"gyro": "2:4"}, {"gyro_x": 1, "gyro_y": 2, "gyro_z": 3}, 0),
        ({"accel": "6:8", "gyro_z": "5"}, {"gyro_z": 4, "accel_x": 5, "accel_y": 6, "accel_z": 7}, 0),
        ({"phase": "temp"}, {"phase": 8}, 0),
        ({"phase": "t"}, {"phase": 0}, None),
        ({"gyro": 3}, {"gyro": 2}, 0),
        ({"b": 3, "a": 3}, {"b": 2, "a": 2}, 0),
    ],
)
def test_asked(asked, channels, time):
    choice = choose(COLUMNS, asked)
    assert list(choice.channels.items()) == list(channels.items())
    assert choice.time == time


def test_a_name_that_looks_like_a_number_wins():
    assert choose(names("3", "1", "2"), {"gyro_x": "3"}).channels == {"gyro_x": 0}
    assert choose(names("3", "1", "2"), {"gyro_x": 3}).channels == {"gyro_x": 2}


def test_time_alone_leaves_the_sensors_to_be_recognised():
    choice = choose(names("time", "seconds", "gyro_x"), {"time": "seconds"})
    assert (choice.channels, choice.time) == ({"gyro_x": 2}, 1)


def test_the_sensors_own_stamp_before_that_of_arrival():
    choice = choose(names("time", "field.header.stamp", "wx"), None)
    assert choice.time == 1
    assert choice.notes == ("time from 'field.header.stamp', not from 'time'",)


def test_the_g_force_of_a_phone_before_its_acceleration_without_gravity():
    columns = names("time", "gFx", "gFy", "gFz", "ax", "ay", "az", "wx", "wy", "wz")
    channels = choose(columns, None).channels
    assert [channels[f"accel_{axis}"] for axis in "xyz"] == [1, 2, 3]
    assert [channels[f"gyro_{axis}"] for axis in "xyz"] == [7, 8, 9]


@pytest.mark.parametrize(
    ("name", "clock"), {"Device clock [ms]": True, "Zeitmarke (us)": True, "dt [ms]": False}.items()
)
def test_a_unit_of_time_makes_a_clock_but_not_of_an_interval(name, clock):
    columns = names(name, "gyro_x [rad/s]", "gyro_y [rad/s]", "gyro_z [rad/s]")
    assert choose(columns, None).time == (0 if clock else None)


def test_a_desired_velocity_is_an_increment_only_beside_increments_of_angle():
    velocity = [Column(name=f"DVel{axis} [m/s]") for axis in "XYZ"]
    angle = [Column(name=f"DAngle{axis} [rad]") for axis in "XYZ"]
    assert recognise(velocity) == [None] * 3
    assert [match[0] for match in recognise([*angle, *velocity])][3:] == ["accel_x", "accel_y", "accel_z"]


@pytest.mark.parametrize("word", ["Vel", "Pos", "Err", "Bias", "Cov", "Ref", "Target", "Innov"])
@pytest.mark.parametrize("name", ["Gyr{}X", "gyro_{}_x", "Acc{}_x", "accel_x_{}"])
def test_words_of_another_quantity_are_no_samples(word, name):
    assert recognise([Column(name=name.format(word))]) == [None]


def test_half_a_stamp_is_no_time():
    assert choose(names("sec", "nanosec", "imu_sec", "imu_nanosec", "wx"), None).time is None
    assert choose(names("sec", "wx"), None).time == 0


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (("sec", "nanosec", "wx"), (0, 1, 10**9)),
        (("wx", "header.stamp.nsecs", "header.stamp.secs"), (2, 1, 10**9)),
        (("tv_sec", "tv_usec", "wx"), (0, 1, 10**6)),
        (("stamp [s]", "stamp [ns]", "wx"), (0, 1, 10**9)),
        (("field.header.stamp.sec", "field.header.stamp.nanosec", "wx"), (0, 1, 10**9)),
        (("t", "header.stamp.sec", "header.stamp.nanosec", "wx"), (1, 2, 10**9)),  # before that of the receiver
        (("timestamp_s", "timestamp_ms", "wx"), (0, 1, 10**3)),
        (("sec", "usec", "nsec", "wx"), None),
        (("gps_sec", "nanosec", "wx"), None),
    ],
)
def test_two_halves_are_a_stamp(columns, expected):
    split = choose(names(*columns), None).split
    assert (None if split is None else (split.seconds, split.part, split.per_second)) == expected


@pytest.mark.parametrize(
    ("columns", "asked", "words"),
    [
        (COLUMNS, {"gyro_x": "wq"}, ["no column 'wq'", "2 'wx [deg/s]'", "9 'temp'"]),
        (COLUMNS, {"gyro_x": 10}, ["no column 10", "9 'temp'"]),
        (COLUMNS, {"gyro_x": 0}, ["no column 0"]),
        (COLUMNS, {"gyro_x": -1}, ["no column '-1'"]),
        (COLUMNS, {"gyro": "2:5"}, ["range", "gyro=2:4"]),
        (COLUMNS, {"gyro": "8:10"}, ["no column 10"]),
        (COLUMNS, {"time": "1:3"}, ["time is one column"]),
        (COLUMNS, {"gyro": "2:4", "gyro_x": 2}, ["gyro_x is given twice"]),
        (COLUMNS, {" ": 2}, ["without a name"]),
        (names("a", "b", "a"), {"gyro_x": "a"}, ["columns 1 and 3", "--channels gyro_x=1"]),
        (names("wx", "gyro_x"), None, ["1 'wx'", "2 'gyro_x'", "both look like gyro_x", "--channels"]),
        (names("wx", "wx"), None, ["1 'wx' and 2 'wx'"]),
        (names("time", "t", "wx"), None, ["1 'time' and 2 't'", "look like time", "--channels time=1"]),
        (names("a", "b", "c"), None, ["no column with a known name", "1 'a'", "--channels"]),
        (names("", ""), None, ["no column names", "--channels"]),
        (names(*(f"c{i}" for i in range(300))), None, ["'c11'", "300 in all"]),
    ],
)
def test_refused(columns, asked, words):
    with pytest.raises(OptionError) as caught:
        choose(columns, asked)
    assert caught.value.option == "channels"
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 800
    for word in words:
        assert word in message


def test_increments_by_name_are_not_taken_for_rates(saved):
    path = saved("delta_theta_x [arcsec],dv_z [m/s]\n" + "1.5,2.5\n2.5,1.0\n" * 4)
    with pytest.raises(OptionError, match="contains increments according to its name; give --input increments"):
        read(path, rate=10)
    record = read(path, rate=10, input="increments")
    assert record.channels == ("gyro_x", "accel_z")


def test_everything_missing_is_asked_for_at_once(saved):
    path = saved("gyro_x,accel_x\n" + "1.5,2.5\n2.5,1.0\n" * 4)
    with pytest.raises(OptionError, match=r"give e\.g\. --unit gyro=deg/s,accel=UNIT --rate HZ"):
        read(path)


def test_counts_of_another_sensor_are_asked_for_beside_a_scale(saved):
    path = saved("gyro_x,accel_x\n" + "15,250\n25,100\n" * 4)
    with pytest.raises(OptionError, match=r"unit of gyro_x.*whole numbers may be counts: then add --scale gyro=FACTOR"):
        read(path, rate=10, unit={"accel": "g"}, scale={"accel": 0.001})
    with pytest.raises(OptionError, match="unit of gyro_x") as asked:
        read(path, rate=10, unit={"accel": "g"}, scale={"accel": 0.001, "gyro": 0.01})
    assert "may be counts" not in str(asked.value)


def test_dates_as_stamps_do_not_bar_a_file_whose_rate_is_given(saved):
    path = saved("timestamp,gyro_x [deg/s]\n" + "2026-01-01T00:00:00Z,2.5\n2026-01-01T00:00:01Z,1.0\n" * 4)
    record = read(path, rate=10)
    assert record.streams[0].grid.n == 8
    assert any("are not numbers and not used" in note for note in record.provenance.conversions)


def test_a_unit_of_no_rate_is_said(saved):
    path = saved("gyro_x [V],gyro_y [LSB]\n" + "2.5,512\n2.6,513\n" * 20)
    with pytest.raises(OptionError, match=r"the file has gyro_x in 'V', gyro_y in 'LSB': give --scale too"):
        read(path, rate=10)
    record = read(path, rate=10, unit={"gyro": "deg/s"})
    assert [f.code for f in record.findings] == ["unit_overruled"] * 2
    assert record.findings[0].details == UnitOverruled(given="deg/s", stated="V", known=False)


def test_counts_are_thought_of(saved):
    path = saved("gyro_x,gyro_y\n" + "12,-7\n13,5\n" * 20)
    with pytest.raises(OptionError, match=r"whole numbers may be counts: then add --scale gyro=FACTOR"):
        read(path, rate=10)


def test_axes_of_two_units_are_no_sensor():
    with pytest.raises(OptionError, match=r"the columns of gyro belong to several IMUs \(imu1, imu2\)"):
        choose(names("t", "imu1_gyro_x", "imu2_gyro_y", "imu2_gyro_z"), None)
    assert len(choose(names("imu1_gyro_x", "imu1_gyro_y", "imu2_accel_x"), None).channels) == 3


def test_one_column_without_a_name_is_a_signal(saved):
    path = saved("# PHASE.DAT, from elsewhere\n#\n" + "".join(f"{k % 7}.5e-9\n" for k in range(40)), "PHASE.DAT")
    record = read(path, rate=1, unit={"x": "s"}, input="accumulated")
    assert record.channels == ("x",)
    with pytest.raises(OptionError, match="--unit x=1 --rate HZ"):
        read(path)


BAD_STAMPS = {
    "backwards": [*range(20), *range(20)],
    "still": [0] * 40,
    "words": [f"12h{k}" for k in range(40)],
    "a wrap": [(2**32 - 20_000 + k * 1000 + 9000 * (k >= 20)) % 2**32 for k in range(40)],  # with lost samples
}


@pytest.mark.parametrize("stamps", BAD_STAMPS.values(), ids=BAD_STAMPS)
def test_wrong_stamps_are_left_out_by_none(saved, stamps):
    path = saved("time,gyro_x [deg/s],b\n" + "".join(f"{t},{k},1\n" for k, t in enumerate(stamps)))
    with pytest.raises(ValueError, match=r"--channels time=none --rate HZ") as caught:
        read(path, unit={"time": "us"})
    assert ("add 2^32" in str(caught.value)) == (stamps is BAD_STAMPS["a wrap"])
    for channels in ({"time": "none"}, {"time": " None", "gyro_x": 2}):
        record = read(path, rate=10, channels=channels)
        assert record.channels == ("gyro_x",)
        assert "no time stamps, as asked" in record.provenance.conversions
    with pytest.raises(OptionError, match="--rate HZ"):
        read(path, channels={"time": "none"})


def test_two_accelerometers_are_asked_about_with_a_command():
    columns = names("t", *(f"Accel_{k}_{a}" for k in ("LN", "WR") for a in "XYZ"), "Gyro_X", "Gyro_Y", "Gyro_Z")
    with pytest.raises(OptionError, match=r"both look like accel_x; .* --channels time=1,accel=2:4,gyro=8:10$"):
        choose(columns, None)


def test_a_damaged_name_is_told(saved):
    path = saved("gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s1_000\n" + "1,2,3\n2,1,4\n" * 20)
    (finding,) = read(path, rate=10).findings
    assert finding.details == IncompleteSensor(missing="gyro_z", column="gyro_z [rad/s1_000", number=3)
    path.write_text("gyro_x [rad/s],gyro_y [rad/s],pressure [hPa]\n" + "1,2,3\n2,1,4\n" * 20)  # a sensor of two axes
    (unused,) = read(path, rate=10).findings
    assert unused.details == UnusedColumns(columns=("pressure [hPa]",))
    path.write_text("gyro_z [rad/s]\n" + "1\n2\n" * 20)  # one axis is a sensor of its own
    assert read(path, rate=10).findings == ()


def test_an_axis_that_is_lost_beside_a_complete_sensor_is_told(tmp_path):
    path = tmp_path / "log.csv"
    header = ",".join([*(f"accel_{a} [g]" for a in "xyz"), "gyro_x [rad/s]", "gyro_z [rad/s]"])
    path.write_text(f"{header}\n" + "1,2,3,4,5\n2,1,4,3,2\n" * 20)
    (finding,) = read(path, rate=10).findings
    assert (finding.severity, finding.details) == ("warning", IncompleteSensor(missing="gyro_y"))
    path.write_text(path.read_text().replace("gyro_z", "gyro_y"))
    (finding,) = read(path, rate=10).findings  # there are sensors of two axes
    assert (finding.severity, finding.details) == ("info", IncompleteSensor(missing="gyro_z"))


def test_mixed_units_are_told(saved):
    path = saved("gyro_x [deg/s],gyro_y [°/s],gyro_z [rad/s]\n" + "1,2,3\n2,1,4\n" * 20)
    (finding,) = read(path, rate=10).findings
    assert finding.details == MixedUnits(units=(("gyro_x", "deg/s"), ("gyro_y", "°/s"), ("gyro_z", "rad/s")))
    path.write_text("gyro_x [deg/s],gyro_y [°/s],gyro_z [dps]\n" + "1,2,3\n2,1,4\n" * 20)
    assert read(path, rate=10).findings == ()


def test_another_clock_for_stamps_that_are_zero(tmp_path):
    path = tmp_path / "log.csv"
    rows = "".join(f"{10**18 + k * 10**7},0,{k % 5}\n" for k in range(40))
    path.write_text(f"time_ns,header.stamp,gyro_z [rad/s]\n{rows}")
    record = read(path)
    assert record.streams[0].grid.rate == pytest.approx(100)
    assert "time from 'time_ns': all stamps in 'header.stamp' are 0" in record.provenance.conversions


def test_an_unknown_unit_is_no_reason_for_a_scale(saved):
    path = saved("gyro_x [furlong/s]\n" + "2.5\n2.6\n" * 20)
    with pytest.raises(OptionError, match=r"the unit 'furlong/s' of gyro_x is not known") as caught:
        read(path, rate=10)
    assert "deg/s" not in str(caught.value)  # which would be a wrong unit


def test_a_single_column_may_be_a_gyro(saved):
    path = saved("0.5\n0.25\n0.75\n" * 9, "log.txt")
    with pytest.raises(OptionError) as asked:
        read(path)
    assert "unit of x; give e.g. --unit x=1 --rate HZ" in asked.value.for_command_line()
    assert asked.value.for_command_line().endswith("if it is a gyro, give --channels gyro=1 --unit gyro=deg/s")
    assert read(path, rate=10, channels={"gyro": 1}, unit={"gyro": "deg/s"}).channels == ("gyro",)


def test_an_accelerometer_of_unknown_names_beside_a_gyro_is_told(tmp_path):
    """Its names say the sensor and not the axes: not read, but never without a word."""
    path = tmp_path / "log.csv"
    head = "time [s],gx [deg/s],gy [deg/s],gz [deg/s],Accel East,Accel North,Accel Up\n"
    path.write_text(head + "".join(f"{k / 100},1,2,{k % 7},0,{k % 5},9.8\n" for k in range(200)))
    (finding,) = (f for f in read(path).findings if f.code == "unread_sensor")
    assert finding.severity == "warning"
    assert finding.details == UnreadSensor(
        sensor="accel", columns=("Accel East", "Accel North", "Accel Up"), numbers=(5, 6, 7)
    )


def test_a_suggestion_of_signals_does_not_drop_a_sensor(tmp_path):
    path = tmp_path / "log.csv"
    head = "time [s],Rate 1st [rad/s],Rate 2nd [rad/s],Rate 3rd [rad/s],board [degC]\n"
    path.write_text(head + "".join(f"{k / 100},{k % 3},2,{k % 7},25\n" for k in range(200)))
    with pytest.raises(OptionError, match="name the columns by --channels time=N,gyro=N:N"):
        read(path)
