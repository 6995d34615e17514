"""Tables of column names: stems of sensors, time stamps, programs with their units, and names that are not a sensor's.

To add a name, add it to a line here and to the table in ``tests/io/test_columns.py``. Names are compared as
`sigmatau.io.read.names.name_key` writes them: in lower case, with ``_`` for spaces, dots, slashes, colons and hyphens,
``[0]`` as ``_x``, and without the decorations below. Only unambiguous names are listed, because a wrong column gives a wrong
result.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import field

from sigmatau.frozen import frozen

# Prefixes that do not change the meaning of a name.
PREFIXES = r"field|data|msgs?|message|imu\d*|imu_data|imu_raw|sensors?|sensor_combined|values?"

# Prefixes that do not change the name of a sensor or a time.
SENSOR_PREFIXES = (
    r"raw|cal|calibrated|uncalibrated",
    r"shimmer_[0-9a-f]{4}",  # Shimmer: serial number of the device
    # name of the part
    r"(?:lsm|ism|iis|asm|lis|mpu|icm|iim|bmi|bma|bmx|bno|adis|adxl|fxos|fxas|mma|l3g|itg|kmx|scha)\d[0-9a-z]{2,8}",
)

# Suffixes that do not change the name of a sensor or a time.
SUFFIXES = r"cal|uncal|raw|calibrated|uncalibrated|out"  # Shimmer: CAL in units, RAW in counts; Analog Devices: OUT

# Stems before an axis, with or without an underscore: ``gyro_x``, ``gyrox``.
STEMS = {
    "gyro": (
        "gyros?",
        "gyr",
        "gyr(?:o|oscope)?_?reading",
        "gyroscope",
        "gyroscope_?uncalibrated",
        "gyroskop|giroscopio|giroscópio",  # phyphox in other languages
        "gyro_fifo",  # PX4
        "gyro_?raw|gyr_?raw",
        "gyro_?adc|gyro_?unfilt",  # Betaflight
        "gyro_?rate|gyro_?data",
        "(?:motion|gyro)_?rotation_?rate|gyro_?rotation",  # iOS
        "uncomp_?(?:gyro|angular_?rate)",  # VectorNav
        "scaled_?gyro",  # MicroStrain
        "angular_?velocity",
        "angular_?speed",
        "angular_?rate",
        "ang_?vel",
        "ang_?rate",
        "rotation_?rate",
        "rotation(?:al)?_?velocity",
        "rate_?of_?turn|turn_?rate",  # Xsens
        "omega",
        "pqr",  # Inertial Sense
        "rot",
        "w",
        "w_rs_s",  # EuRoC
        "g",  # see `names`: only if all three axes exist
        "d_?theta|delta_?theta|d_?angle|delta_?angle",  # increments, see INCREMENTS
    ),
    "accel": (
        "accel",
        "accl?",
        "acc(?:el|elerometer)?_?reading",
        "accelerometer",
        "accelerometer_?uncalibrated",
        "accel_fifo",  # PX4
        "acc_?raw|accel_?raw",
        "acc(?:el)?_?data",
        "accel_channel",  # OpenBCI
        "acc_?smooth|acc_?adc",  # Betaflight
        "accel_?ln|accel_?wr|low_noise_accelerometer|wide_range_accelerometer",  # Shimmer: two accelerometers
        "accelerometer_?acceleration",  # iOS
        "scaled_?accel",  # MicroStrain
        "g_?force",
        "uncomp_?acc(?:el)?",  # VectorNav
        "total_?acceleration",  # Sensor Logger
        "acceleration_?including_?gravity",  # browsers
        "acceleration",
        "beschleunigung|accélération|aceleración|accelerazione|aceleração",
        "linear_?acceleration",  # ROS, with gravity; see WITHOUT_GRAVITY
        "linear_?accel",
        "lin_?acc",
        "specific_?force",
        "a",  # see `names`: only if all three axes exist
        "a_rs_s",  # EuRoC
        "f(?=_)",  # specific force, but not ``fx``
        "d_?vel|delta_?vel|d_?velocity|delta_?velocity|dv|delta_?v",  # increments
    ),
}

# Stems after an axis: ``xgyro`` (MAVLink), ``X Accel`` (MicroStrain).
AFTER_AXIS = {"gyro": "gyro|gyr|gyroscope|angular_?rate", "accel": "accel|accl?|accelerometer|acceleration"}

# Names that both ROS (with gravity) and phones (without gravity) use. Names with a space between the words are a
# phone's, unless the log also has an angular velocity. A plain accelerometer in the log has priority.
WITHOUT_GRAVITY = re.compile(r"(?:linear_?acc(?:el|eleration)?|lin_?acc(?:el)?)_?[xyz]")
PHONE_NAMES = re.compile(r"(?i)linear acceleration [xyz]\b")

# Names of increments.
INCREMENTS = re.compile(r"^(?:delta_?(?:theta|angle|vel|velocity|v)|d_?(?:theta|angle|vel|velocity)|dv)_?[xyz]")

ANGLE_INCREMENTS = re.compile(r"(?:delta|d)_?(?:theta|angle)_?[xyz]")

# This may be a desired velocity (ArduPilot NTUN.DVelX). It counts as an increment only beside increments of angle.
DESIRED_VELOCITY = re.compile(r"d_?vel(?:ocity)?_?[xyz]")

# Time columns by priority: the time stamp of the sensor before that of the receiver.
TIMES = (
    r"sample_?us|time_?stamp_sample",  # ArduPilot, PX4: when the sensor sampled
    r"(?:header_)?stamp|(?:clock_)?offset_?time|seconds_elapsed|elapsed(?:_time|_seconds)?|time_elapsed",
    r"timeus|time_?usec|time_boot_ms",  # before T, which is a temperature in ArduPilot's messages
    r"t|ts|time|time_?stamps?|t_(?:host|imu|sensor|sys|rel|mcu)|(?:unix|epoch|sys|system|sensor|host|imu|ros)_?time(?:stamp)?"
    r"|time_(?:boot|since_start|since_boot|startup)|timestartup|seconds|secs?|epoch|date_?time|date_?time_utc|time_?utc"
    r"|utc_?time|date_and_time|time_?stamp_(?:unix|sync)|(?:motion|gyro|accelerometer)_?timestamp_since_?reboot"
    r"|(?:gps_?)?tow|gps_?time(?:_?stamp)?|header_?time_?stamp|time_?of_?week|zeit|temps|tiempo|tempo",
    r"sample_?time_?fine",  # Xsens
    r"log_time",  # of the recorder of an MCAP file or a bag
)
SECONDS = re.compile(r"^(?:seconds_elapsed|elapsed_seconds|seconds)$")

# One half of a time stamp that is split into two columns.
SPLIT_STAMP = re.compile(r"(?:^|_)(?:n?secs?|nanosec(?:onds)?|usecs?)$")

# Words in names of columns with a unit of time that are not clocks: intervals, delays, a time of flight of light.
NOT_A_CLOCK = re.compile(
    r"(?:^|_)(?:dt|delta[a-z]*|diff|period|interval|duration|latency|delay|lag|age|exposure|integration|flight|tof|jitter|error|bias"
    r"|std|sigma|week|uncertainty|accuracy|width|pulse|gate|load|processing|shutter|readout)(?=_|$)"
)

# Units as the last part of a name: ``gyro_x_dps``, ``t_ns``, ``time in ms``.
UNIT_ENDS = {
    **dict.fromkeys(("dps", "deg_s", "degps", "deg_per_s", "deg_per_sec", "deg_sec"), "deg/s"),
    **dict.fromkeys(("degrees_per_second", "degree_per_second", "deg_per_second"), "deg/s"),
    **dict.fromkeys(("mdps", "mdeg_s"), "mdeg/s"),
    **dict.fromkeys(("rad_s", "radps", "rads", "rps", "rad_per_s", "rad_per_sec", "rad_sec"), "rad/s"),
    **dict.fromkeys(("radians_per_second", "radian_per_second", "rad_per_second"), "rad/s"),
    **dict.fromkeys(("mrad_s", "mradps"), "mrad/s"),
    **dict.fromkeys(("dph", "deg_h", "deg_hr", "deg_per_h", "deg_per_hr", "deg_per_hour"), "deg/h"),
    "g": "g",
    "mg": "mg",
    "ug": "ug",
    **dict.fromkeys(("m_s2", "m_s_2", "m_ss", "m_s_s", "mps2", "ms2", "mss", "m_per_s2", "m_s^2", "m_s²"), "m/s^2"),
    **dict.fromkeys(("meters_per_second_squared", "metres_per_second_squared", "meters_per_second2"), "m/s^2"),
    **dict.fromkeys(("meters_per_second_per_second", "metres_per_second_per_second", "m_per_sec2"), "m/s^2"),
    **dict.fromkeys(("s", "sec", "secs", "seconds"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "milliseconds"), "ms"),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanoseconds"), "ns"),
}

# Units by the descriptor in brackets: ``X Accel [x8004]`` (MicroStrain, MIP data communications protocol, 0x80).
DESCRIPTORS = {"x8004": "g", "x8005": "rad/s", "x8007": "rad", "x8008": "g*s"}

# Names whose unit is part of a published format.
WITH_UNIT = {
    r"gyro_rad_([xyz])": ("gyro", "rad/s"),  # PX4, sensor_combined: "in rad/s"
    r"time_?us(?:ec)?": ("time", "us"),  # ArduPilot TimeUS, MAVLink time_usec
    r"sample_?us": ("time", "us"),  # ArduPilot SampleUS
    r"time_?stamp_sample": ("time", "us"),  # PX4
    r"time_(?:boot_)?ms|timems": ("time", "ms"),  # MAVLink time_boot_ms
    r"(?:time_?of_?week|(?:gps_?)?i?tow|gps)_?ms": ("time", "ms"),  # Inertial Sense, Aceinna
    r"millis|ms|(?:\w+_)?ticks?_?ms": ("time", "ms"),  # millis() of Arduino, ticks_ms() of MicroPython
    r"micros|us|(?:\w+_)?ticks?_?us": ("time", "us"),
    r"gf_?([xyz])": ("accel", "g"),  # Physics Toolbox: g-force
}

# Units by the message in the path of a name: ``SCALED_IMU2.xgyro`` (MAVLink common messages), as whole columns' names.
BY_MESSAGE = {
    r"(?i)(?:.*[./])?scaled_imu[23]?[./].*": {"gyro": "mrad/s", "accel": "mg", "time": "ms"},
    r"(?i)(?:.*[./])?highres_imu[./].*": {"gyro": "rad/s", "accel": "m/s^2", "time": "us"},
    r"__time": {"time": "s"},  # PlotJuggler
}

# A message with this covariance is a sensor_msgs/Imu, in SI; ``rostopic echo -p`` writes stamps in nanoseconds.
ROS_IMU = "field.angular_velocity_covariance0"
ROSTOPIC_STAMP = re.compile(r"field\.(?:[\w.]+\.)?header\.stamp")
ROS_UNITS = {"gyro": "rad/s", "accel": "m/s^2"}

# Both vectors of a sensor_msgs/Imu as paths, ``/imu/angular_velocity/x`` or ``angular_velocity.x``: in SI too.
ROS_PATH = re.compile(r"(?:.*[./])?(?P<vector>angular_velocity|linear_acceleration)[./](?P<axis>[xyz])")


@frozen
class Program:
    """A program whose log is identified by the names of all its columns."""

    keys: frozenset[str]  # All names of the log, as keys
    units: Mapping[str, str]  # Unit by sensor, and of the time
    channels: Mapping[str, str] = field(
        default_factory=dict
    )  # Channel by key, for names that mean something else in other logs


def _program(names: str, units: Mapping[str, str], **channels: str) -> Program:
    return Program(keys=frozenset(names.split()), units=units, channels={key: name for name, key in channels.items()})


PROGRAMS = (
    _program(
        "index time accl0 accl1 accl2 rot0 rot1 rot2 x y z w",
        {"accel": "g", "gyro": "rad/s", "time": "s"},
    ),
    _program(  # Kalibr's CSV of an IMU (kalibr_bagcreater): alpha is the specific force
        "timestamp omega_x omega_y omega_z alpha_x alpha_y alpha_z",
        {"gyro": "rad/s", "accel": "m/s^2", "time": "ns"},
        accel_x="alpha_x",
        accel_y="alpha_y",
        accel_z="alpha_z",
    ),
)

# Words in the path before a vector that mean it is not the sensor's: ``/filter/bias/gyro/x``.
OTHER_VECTORS = (
    r"(?i)(?:^|[\W_])(?:bias\w*|cov\w*|std\w*|sigma|noise|errors?|estimat\w*|setpoints?|targets?|desired|odom\w*|pose|twist"
    r"|ref\w*|gt|truth)(?=[\W_]|$)"
)

# Words of an inertial quantity, also of those that `NOT_A_SENSOR` excludes: increments of velocity, gravity.
INERTIAL = re.compile(r"(?i)acc|vel|grav|force|^d?v[_\[ ]?[xyz012]")

# Words in names that probably belong to samples of a sensor, even if the whole name is not known.
SENSOR_WORDS = {
    "gyro": re.compile(r"(?i)gyr|ang\w*[_ ]?(?:rate|vel)|rot\w*[_ ]?(?:rate|vel)|omega"),
    "accel": re.compile(r"(?i)acc(?:el|l|\b|_|[xyz])|g[_ -]?force"),
}

# Words in names of columns that are not samples of a gyro or accelerometer, whatever their values.
NOT_A_SENSOR = (
    r"(?i)mag|compass|quat|orient|euler|roll|pitch|yaw|heading|attitude|temp|press|baro|alt|lat|lon|gps|gnss|cov|bias|std"
    r"|sigma|noise|grav|user|free|lin_?acc|linear acc|seq|count|tick|index|frame|status|flag|volt|batt|current|vel|pos|speed"
    r"|motor|rpm|target|setpoint|desired|cmd|odom|humid|light|step"
)
