"""Small logs of common instruments, with the answers that are right."""

import pytest

from sigmatau import analyze
from sigmatau.errors import OptionError
from sigmatau.io.live import Live
from sigmatau.io.read import read
from sigmatau.io.read.options import TableOptions

SI = {"gyro": "rad/s", "accel": "m/s^2"}
# File, options, rate, axes, and random walk of the gyro: the answer must hold the truth.
CASES = [
    ("labview_comma.lvm", {}, 10, 1, 0.02),
    ("xsens_mt_empty_columns.txt", {}, 100, 6, 0.300),
    ("shimmer_units_row.csv", {}, 100, 6, 0.300),
]


@pytest.mark.parametrize(("name", "options", "rate", "axes", "truth"), CASES)
def test_the_random_walk_is_in_its_interval(field_data, name, options, rate, axes, truth):
    record = read(field_data / "cases" / name, **options)
    assert len(record.channels) == axes
    assert record.streams[0].grid.rate == pytest.approx(rate, rel=1e-4)
    fits = analyze(record, at_rest=True).fits  # some are too short to tell motion
    gyros = [channel for channel in record.channels if channel.startswith("gyro")]
    for channel in gyros:
        value = fits[channel]["random_walk"].to("deg/sqrt(h)")
        # Four standard errors of a white noise of so many samples, 1/√(2n) each.
        assert value == pytest.approx(truth, rel=4 / (2 * record.streams[0].grid.n) ** 0.5)


@pytest.mark.parametrize("name", ["six-no-header.txt", "arduino-no-header.txt"])
def test_live_samples_without_names_are_asked_about_as_a_file_is(field_data, name):
    path = field_data / "cases" / name
    with pytest.raises(OptionError) as of_file:
        read(path)
    with pytest.raises(OptionError) as of_live:
        Live(TableOptions().checked()).push(path.read_bytes(), last=True)
    assert str(of_live.value) == str(of_file.value).removeprefix(f"{path}: ")
