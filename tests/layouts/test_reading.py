"""The grades of the layouts, by reading alone: ``grades.txt`` is the table of ``python tests/layouts/run.py``.

Each line is a name, a grade, and the last options of an owner. Rates, channels and means are checked here; random walks and
motion need an analysis, which `run.py` does.
"""

import math
import re
import shlex
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from generator import LAYOUTS

from run import MEAN_TOLERANCE, RATE_TOLERANCE, SUGGESTIONS, find_suggestion, merge_options
from sigmatau import DataError, OptionError, read

TABLE = Path(__file__).with_name("grades.txt")
ROW = re.compile(r"(?P<name>\w+) +(?P<grade>at once|suggested|asked)(?: +(?P<options>.*))?")
GRADES = {match["name"]: match for line in TABLE.read_text().splitlines() if (match := ROW.fullmatch(line.rstrip()))}
BY_NAME = {described.name: described for described in LAYOUTS}


def arguments(options):
    """Options of the command line as arguments of `read`."""
    words: dict[str, object] = {}
    for name, value in zip(options[::2], options[1::2], strict=True):
        key = name.removeprefix("--")
        if key in ("channels", "unit"):
            words.setdefault(key, {}).update(pair.split("=", 1) for pair in value.split(","))
        elif key in ("scale", "offset"):
            words[key] = {k: float(Fraction(v)) for k, v in (pair.split("=") for pair in value.split(","))}
        else:
            words[key] = float(value) if key == "rate" else int(value) if key == "skip" else value
    return words


def check_record(described, record):
    """The channels of a layout, their rates, and their means if the sensor does not move."""
    sensors = {c for c in record.channels if c.startswith(("gyro", "accel"))}
    assert sensors <= set(described.channels)
    if sensors < set(described.channels):  # the acceleration without gravity of a watch that moves
        assert described.motion
        assert {"unused_columns", "unread_sensor"} & {finding.code for finding in record.findings}
    for channel in sensors:
        stream = record.stream_of(channel)
        assert stream.grid.rate == pytest.approx(described.rate_of(channel), rel=RATE_TOLERANCE)
        if described.motion:
            continue
        right = described.mean(channel)
        step = described.gyro_step if channel.startswith("gyro") else described.accel_step
        room = (
            6 * described.random_walk(channel) / math.sqrt(described.seconds) + MEAN_TOLERANCE * abs(right) + 0.1 * step
        )
        assert float(np.nanmean(stream.column(channel))) == pytest.approx(right, abs=room)


def follow(path, options):
    """Read as `run.py` does: with what the questions propose, until they propose nothing new."""
    for _ in range(SUGGESTIONS + 1):
        try:
            return read(path, **arguments(options)), options
        except (OptionError, DataError) as error:
            proposed = find_suggestion(str(error)) if isinstance(error, OptionError) else ()
            if set(proposed) <= set(options):
                return None, options
            options = merge_options(options, proposed)
    return None, options


def test_every_layout_has_a_grade():
    assert list(GRADES) == [described.name for described in LAYOUTS]


@pytest.mark.parametrize("name", GRADES)
def test_a_layout_is_read_as_its_grade_says(name, tmp_path):
    described, grade = BY_NAME[name], GRADES[name]["grade"]
    options = tuple(shlex.split(GRADES[name]["options"] or ""))
    path = described.save(tmp_path)
    record, proposed = follow(path, described.options)
    if not described.readable:
        assert record is None or not any(c.startswith(("gyro", "accel")) for c in record.channels)
        return
    if grade == "asked":
        assert record is None
        assert set(proposed) <= set(options), "the question proposes something else than the answer"
        if not options:
            assert described.asks
            return
        record = read(path, **arguments(options))
    else:
        assert proposed == (options if grade == "suggested" else described.options)
    check_record(described, record)
