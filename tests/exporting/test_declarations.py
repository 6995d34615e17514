"""What a target declares to need is what its file cannot be written without."""

import pytest

from sigmatau import ChannelModel, Choices, DataError, NoiseModel, OptionError, export
from sigmatau.exporting.export import check_record
from sigmatau.exporting.source import Source
from sigmatau.exporting.targets import NAMES, target

NOISE = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}
UNITS = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2"), "pressure": ("signal", "Pa")}
RECORDS = {
    "both": ("gyro_x gyro_y gyro_z accel_x accel_y accel_z", 100.0, 100.0),
    "gyros": ("gyro_x gyro_y gyro_z", 100.0, 100.0),
    "accelerometers": ("accel_x accel_y accel_z", 100.0, 100.0),
    "a signal": ("pressure", 100.0, 100.0),
    "two axes": ("gyro_x gyro_y accel_x accel_y accel_z", 100.0, 100.0),
    "two rates": ("gyro_x gyro_y gyro_z accel_x accel_y accel_z", 100.0, 50.0),
}


def is_refused(call):
    try:
        call()
    except (DataError, OptionError):
        return True
    return False


# A target with one number for all axes has no choice of each.
CASES = [
    (name, axes)
    for name in NAMES
    for axes in ("worst", "each")
    if axes == "worst" or target(name).per_axis or target(name).every_axis
]


@pytest.mark.parametrize("record", RECORDS)
@pytest.mark.parametrize(("name", "axes"), CASES)
def test_a_record_is_refused_before_its_analysis_if_its_model_would_be(name, record, axes):
    channels, fast, slow = RECORDS[record]
    rates = {one: slow if one.startswith("accel") else fast for one in channels.split()}
    models = {
        one: ChannelModel(terms=NOISE, quantity=UNITS[one.partition("_")[0]][0], unit=UNITS[one.partition("_")[0]][1])
        for one in rates
    }
    source = Source(model=NoiseModel(channels=models), rates=rates)
    by_sensor = {}
    for one, rate in rates.items():
        by_sensor.setdefault(one.partition("_")[0], {})[one] = rate
    before = is_refused(lambda: check_record({name: None}, Choices(axes=axes), by_sensor))
    assert before == is_refused(lambda: export(source, to=name, choices=Choices(axes=axes)))
