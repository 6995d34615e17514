"""What a target declares to need is what its file cannot be written without."""

import re

import pytest

from sigmatau import ChannelModel, Choices, DataError, GaussMarkov, NoiseModel, OptionError, Sinusoid, export
from sigmatau.exporting.export import check_record, prepare
from sigmatau.exporting.source import Source
from sigmatau.exporting.targets import NAMES, target
from sigmatau.noise.terms import SLOW, TERMS

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


ALL_NOISE = {
    "terms": dict.fromkeys(TERMS, 1e-5),
    "sinusoid": (Sinusoid(amplitude=1e-3, frequency=7.0),),
    "gauss_markov": (GaussMarkov(sigma=1e-4, time=30.0),),
}


OWN_NAMES = {"matlab": {"bias_instability", "rate_random_walk"}, "ros": {"quantization"}, "state-space": {*TERMS}}
"""Terms that a file has under the names of its program."""


@pytest.mark.parametrize("name", NAMES)
def test_no_noise_is_left_out_without_a_word(name):
    """Each term is in the file or its findings by its name, or slow and part of what the file approximates or judges."""
    channels = {
        f"{sensor}_{axis}": ChannelModel(**ALL_NOISE, quantity=UNITS[sensor][0], unit=UNITS[sensor][1])
        for sensor in ("gyro", "accel")
        for axis in "xyz"
    }
    rated = target(name).needs_rate or target(name).may_need_rate or target(name).needs_step
    prepared = prepare(NoiseModel(channels=channels), to=name, choices=Choices(filter_rate=100.0) if rated else None)
    text = " ".join([str(prepared.content), *(finding.message for finding in prepared.findings)]).lower()
    has = {"random_walk", *OWN_NAMES.get(name, ()), *(SLOW if "a filter states" in text else ())}
    for term in TERMS.values():
        assert term.name in has or term.label("signal").lower() in text or term.name in text, term.name
    assert re.search("sinusoid|line", text)
