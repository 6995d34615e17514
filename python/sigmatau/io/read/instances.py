"""Detection of a column of instances, with rows of several sensors, as opposed to a flag, a counter or a signal."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import median_and_spread

SENSORS = {
    "gyro": r"(?i)gyr|ang(?:ular)?[ _]?(?:vel|rate)",
    "accel": r"(?i)acc(?!ur|ount|ess|ept|um)|specific[ _]?force",
}
"""Patterns of words that name the sensor of a row."""

# Names of a column of instances; a lower-case i may be an index of samples.
_NAMES = (
    r"(?:.*_)?(?:imu|inst|instance|sensor|device|dev|node|board|chip|source|src|topic|frame|addr|address|tag|kind|type|unit|label)"
    r"(?:_?(?:id|no|nr|num|number|index|idx|name))?|frame_?id|id"
)
_DEVICES = r"I|(?i:.*(?:imu|inst|sensor|dev|node|board|chip|addr).*)"
# Names of columns that cycle for other reasons: counters, phases and flags.
_NOT_INSTANCES = (
    r"(?:.*_)?(?:seq|sequence|count|counter|cnt|parity|phase|status|state|flags?|valid|ok|new|fresh|sync|trigger|sample|samples"
    r"|index|idx|n|k|row|packet|frame_?(?:no|nr|num|number|count|counter|index|idx)|second|sec|secs|minute|ms|time|temp.*|gain|range"
    r"|batt.*|volt.*|fix|sats?|pps)"
)
_SENSOR_WORDS = (
    # the same words as parts of a longer word
    r"(?i)imu|gyr|acc|mag|baro|temp|press|sensor|left|right|front|rear|back|top|bottom|head|torso"
)
_MIN_RUNS = 5  # smallest number of runs of rows of each kind in the head
_REGULAR_RUNS = 0.95  # share of the runs up to twice the median: a fair random flag has 0.88
_SMALLEST_SHIFT = 0.3  # smallest difference of two means, over the scatter of the rows of one kind
# smallest shift in standard errors; from differences of neighbours, the error is 1.4 times too small
_SHIFT_ERRORS = 8.0
_MIN_DISTINCT = 5  # smallest number of distinct values of a signal in the rows of one kind
_MIN_COLUMNS = 2  # smallest number of columns whose means or scatters must differ
_SCATTERS = 2.0  # smallest ratio of the scatters of two sensors: 8 standard errors for 100 rows of a kind
# standard error of the logarithm of such a ratio, times the root of the number of rows of a kind
_SCATTER_ERROR = 1.17 * 2**0.5
_SCATTER_ERRORS = 4.0  # smallest ratio in standard errors: relevant for fewer than 100 rows of a kind
_ROWS_OF_BLOCK = 20  # smallest mean length of a block of one sensor [rows]
_TOGETHER = 0.25  # longest interval between rows of one instant, over the mean interval
_GROUPED = 0.2  # smallest share of such intervals if several sensors are sampled together
# number of parts of the head in which the difference must have one sign: the beat of a line changes its sign
_PARTS = 4


_single_sensor = ContextVar("single_sensor", default=False)


@contextmanager
def state_single_sensor(*, single: bool) -> Iterator[None]:
    """State whether all rows are of a single sensor, even if a column looks like its number, for the readers in the
    block.
    """
    token = _single_sensor.set(single)
    try:
        yield
    finally:
        _single_sensor.reset(token)


def is_single_sensor_stated() -> bool:
    """Whether all rows are stated to be of a single sensor."""
    return _single_sensor.get()


def find_sensor(label: str) -> str | None:
    """The sensor that a word names, ``gyro`` or ``accel``; None if it names none, or both."""
    named = [sensor for sensor, pattern in SENSORS.items() if re.search(pattern, label)]
    return named[0] if len(named) == 1 else None


def has_instance_name(name: str) -> bool:
    """Whether a column has the name of an instance or a kind, such as ``I``, ``imu``, ``sensor_id`` or ``frame_id``."""
    key = re.sub(r"[\s./:\-]+", "_", name.strip()).strip("_")
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", key).lower()
    return key == "I" or (re.fullmatch(_NAMES, snake) is not None and not re.fullmatch(_NOT_INSTANCES, snake))


def has_device_name(name: str) -> bool:
    """Whether a column has the name of a device. Labels and types do not count, because they may name a part of a log."""
    return has_instance_name(name) and re.fullmatch(_DEVICES, name.strip()) is not None


def may_be_instance(name: str) -> bool:
    """Whether a name is not that of a counter, a phase or a flag."""
    key = re.sub(r"[\s./:\-]+", "_", name.strip()).strip("_")
    snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", key).lower()
    return re.fullmatch(_NOT_INSTANCES, snake) is None


def shows_kinds(
    name: str, labels: Sequence[str], order: Sequence[str], values: Callable[[], NDArray[np.float64]], *, words: bool
) -> bool:
    """Whether a column of few words or integers distinguishes the kinds of rows.

    `name`: name of the column, empty if it has none; `labels`: its distinct values; `order`: its value in each row, shape
    (n,); `values`: returns the numbers of these rows, shape (n, columns), with NaN for missing ones.
    """
    if words and (by_sensor := words_show_sensors(labels, order)) is not None:
        return by_sensor
    if is_single_sensor_stated():
        return False
    if not cycles_with_rows(order):
        return has_device_name(name) and comes_in_blocks(order)
    is_named = has_instance_name(name)
    if words and (is_named or any(re.search(_SENSOR_WORDS, label) for label in labels)):
        return True
    if has_device_name(name) or not may_be_instance(name):
        return is_named
    samples = values()
    codes = {label: k for k, label in enumerate(labels)}
    row_codes = np.array([codes[label] for label in order])
    if len(samples) != len(row_codes):  # the columns have several lengths
        return is_named
    if is_named:  # such a name may also be that of a counter, for example of frames
        return not has_single_sensor(samples, row_codes)
    return means_differ(samples, row_codes) or (words and scatters_differ(samples, row_codes))


def words_show_sensors(labels: Sequence[str], order: Sequence[str]) -> bool | None:
    """Whether the words in `order` name sensors and distinguish the rows; None if no word names a sensor.

    A table of results, axis after axis, also has consecutive rows with the word of one sensor.
    """
    sensors = [sensor for label in labels if (sensor := find_sensor(label)) is not None]
    if not sensors:
        return None
    return len(set(sensors)) == len(sensors) or sum(map(str.__ne__, order[1:], order[:-1])) >= len(labels)


def cycles_with_rows(labels: Sequence[str]) -> bool:
    """Whether each label comes in runs of about the same length and distance, as for sensors with fixed rates.

    Random flags, coarse signals and clocks do not.
    """
    names, codes = np.unique(np.array(labels), return_inverse=True)
    if len(names) < 2:
        return False
    for code in range(len(names)):
        same = codes == code
        ends = np.flatnonzero(np.diff(same)) + 1
        lengths = np.diff(np.concatenate(([0], ends, [len(same)])))
        runs, pauses = lengths[0 if same[0] else 1 :: 2], lengths[1 if same[0] else 0 :: 2]
        if len(runs) < _MIN_RUNS:
            return False
        for some in (runs, pauses):
            if np.mean(some <= 2 * np.median(some) + 1) < _REGULAR_RUNS:
                return False
    return True


def comes_in_blocks(labels: Sequence[str]) -> bool:
    """Whether each label comes in blocks of rows, as for sensors that are logged one after the other for many rows."""
    names, codes = np.unique(np.array(labels), return_inverse=True)
    blocks = int(np.count_nonzero(np.diff(codes))) + 1
    return len(names) > 1 and len(labels) >= _ROWS_OF_BLOCK * blocks


def scatters_differ(values: NDArray[np.float64], codes: NDArray[np.intp]) -> bool:
    """Whether the noise of several signals depends on the kind of the row, as for different sensors. Arguments as in
    `means_differ`.
    """
    ratios = []
    fewest = int(np.bincount(codes).min())
    smallest = max(_SCATTERS, float(np.exp(_SCATTER_ERRORS * _SCATTER_ERROR / max(fewest, 1) ** 0.5)))
    for column in values.T:
        by_kind = [column[codes == code] for code in range(codes.max() + 1)]
        if not all(np.isfinite(x).all() and len(np.unique(x)) >= _MIN_DISTINCT for x in by_kind):
            continue
        steps = [median_and_spread(np.diff(x))[1] for x in by_kind]
        if min(steps) > 0 and not any(np.mean(np.diff(x) >= 0) > _REGULAR_RUNS for x in by_kind):
            ratios.append(max(steps) / min(steps))
    return sum(ratio >= smallest for ratio in ratios) >= _MIN_COLUMNS


def means_differ(values: NDArray[np.float64], codes: NDArray[np.intp]) -> bool:
    """Whether the means of several signals depend on the kind of the row. `values`: shape (n, columns), NaN where there is
    no number; `codes`: shape (n,), the kind of each row.

    Rows of one sensor under any label have one mean. Neighbouring rows are compared, so that motion and drift cancel.
    """
    pairs = np.stack((codes[:-1], codes[1:]), axis=1)
    lowest, highest = pairs.min(axis=1), pairs.max(axis=1)
    different = lowest != highest
    if not different.any():
        return False
    keys, counts = np.unique(lowest[different] * (codes.max() + 1) + highest[different], return_counts=True)
    chosen = np.flatnonzero(different & (lowest * (codes.max() + 1) + highest == keys[np.argmax(counts)]))
    sign = np.where(codes[chosen] < codes[chosen + 1], 1.0, -1.0)
    shifted = 0
    for column in values.T:
        kind_values = column[codes == codes[chosen[0]]]
        if not np.isfinite(column).all() or len(np.unique(kind_values)) < _MIN_DISTINCT:
            continue
        if np.mean(np.diff(kind_values) >= 0) > _REGULAR_RUNS:
            continue  # a time or a counter
        shifted += _is_shifted(sign * (column[chosen + 1] - column[chosen]))
    return shifted >= _MIN_COLUMNS


def has_single_sensor(values: NDArray[np.float64], codes: NDArray[np.intp]) -> bool:
    """Whether rows of all kinds look like those of a single sensor: equal means, equal scatters, no rows of one instant.
    Arguments as in `means_differ`.
    """
    return not (means_differ(values, codes) or scatters_differ(values, codes) or _has_simultaneous_rows(values))


def _has_simultaneous_rows(values: NDArray[np.float64]) -> bool:
    """Whether a column that never decreases, the time, has groups of rows of one instant."""
    for column in values.T:
        intervals = np.diff(column)
        if len(intervals) == 0 or not np.isfinite(column).all() or intervals.min() < 0:
            continue
        mean = float(np.mean(intervals))
        if mean > 0 and np.mean(intervals < _TOGETHER * mean) > _GROUPED:
            return True
    return False


def _is_shifted(differences: NDArray[np.float64]) -> bool:
    """Whether differences of neighbouring rows have a significant mean, the same in all parts."""
    middle, scatter = median_and_spread(differences)
    scatter = scatter or float(np.std(differences))
    if not abs(middle) > max(_SHIFT_ERRORS / len(differences) ** 0.5, _SMALLEST_SHIFT * 2**0.5) * scatter:
        return False
    return all(float(np.median(part)) / middle > 0.5 for part in np.array_split(differences, _PARTS) if len(part))
