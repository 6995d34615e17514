"""Findings about the columns of a file, and their units. Columns count from 1."""

from __future__ import annotations

from sigmatau.findings.finding import Finding, Words
from sigmatau.findings.phrases import LONGEST_NAME, listed, plural, shortened
from sigmatau.findings.reading import InFile
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.units import needs_scale


@frozen
class ColumnsByGravity(InFile, code="columns_by_gravity"):
    """Columns without names, whose accelerometers are detected by gravity.

    Attributes
    ----------
    gyro, accel : (int, int)
        First and last column.
    time : int or None
        The time column.
    gravity, other : float
        Magnitude of the mean over the accelerometer's columns, and over the gyro's. [units of the file]
    """

    gyro: tuple[int, int]
    accel: tuple[int, int]
    time: int | None
    gravity: float
    other: float

    def words(self, finding: Finding) -> Words:
        time = {} if self.time is None else {"time": self.time}
        gyro, accel = f"{self.gyro[0]}:{self.gyro[1]}", f"{self.accel[0]}:{self.accel[1]}"
        return Words(
            f"columns have no names: {accel} read as accel (mean {self.gravity:.3g}, gravity), {gyro} as gyro"
            f" (mean {self.other:.2g})",
            f"Run with {Hint('channels', value=time | {'gyro': gyro, 'accel': accel})} to confirm, or name other columns",
        )


@frozen
class GravityOnGyro(InFile, code="gravity_on_gyro", alters_all=True):
    """Gravity is in the columns that are read as the gyro, and not in those of the accelerometer.

    Attributes
    ----------
    gyro, accel : float
        Magnitude of the mean of each. [unit of the file]
    """

    gyro: float
    accel: float

    def words(self, finding: Finding) -> Words:
        return Words(
            f"gravity is on the columns of the gyro (mean {self.gyro:.3g}), not on those of the accelerometer"
            f" ({self.accel:.2g})",
            f"Exchange the sensors in {Hint('channels')}",
        )


@frozen
class UnitOverruled(InFile, code="unit_overruled"):
    """The user gave a unit that differs from the unit in the file.

    Attributes
    ----------
    given, stated : str
        Unit given by the user, and unit in the file.
    known : bool
        Whether the unit in the file is a known unit of the quantity.
    scaled : bool
        Whether the user gave a scale.
    """

    given: str
    stated: str
    known: bool = True
    scaled: bool = False

    def words(self, finding: Finding) -> Words:
        stated = self.stated if self.known else f"{shortened(self.stated, 20)!r}, which is not a unit of this quantity"
        advice = (
            f"Give {Hint('scale')}: volts and counts need a scale"
            if needs_scale(self.stated)
            else "Check the unit of the file"
        )
        return Words(
            f"the file states {stated}; the given unit {self.given} is used",
            "" if self.known or self.scaled else advice,
        )


@frozen
class IncompleteSensor(InFile, code="incomplete_sensor"):
    """Two axes of a sensor are recognised, but not the third.

    Attributes
    ----------
    missing : str
        Channel without a column.
    column : str
        The column that is not used and has the most similar name; empty if there is none.
    number : int or None
        Its number, counted from 1.
    """

    missing: str
    column: str = ""
    number: int | None = None

    def words(self, finding: Finding) -> Words:
        if not self.column:
            return Words(
                f"{self.missing} is missing; no other column has a similar name", "Check the names of the columns"
            )
        column = shortened(self.column, LONGEST_NAME)
        column_hint = Hint("channels", self.missing, self.number)
        return Words(
            f"{self.missing} is missing; column {self.number} {column!r} has a similar name and is not used",
            f"Correct the name of the column, or name all columns: {column_hint} and the others",
        )


@frozen
class UnusedColumns(InFile, code="unused_columns"):
    """Numeric columns that are not read, because their names are unknown.

    Attributes
    ----------
    columns : tuple of str
        Their names.
    """

    columns: tuple[str, ...]

    def words(self, finding: Finding) -> Words:
        return Words(f"{plural(len(self.columns), 'columns')} not used: {listed(self.columns)}")


@frozen
class UnreadSensor(InFile, code="unread_sensor"):
    """A sensor that the names or units of some columns suggest, but none of these columns is read.

    Attributes
    ----------
    sensor : str
        ``"gyro"`` or ``"accel"``.
    columns : tuple of str
        Names of its columns.
    numbers : tuple of int
        Their numbers, counted from 1.
    """

    sensor: str
    columns: tuple[str, ...]
    numbers: tuple[int, ...]

    def words(self, finding: Finding) -> Words:
        what = {"gyro": "a gyro", "accel": "an accelerometer"}[self.sensor]
        first, last = self.numbers[0], self.numbers[-1]
        places = f"{first}:{last}" if self.numbers == (first, first + 1, first + 2) else "N:N"
        return Words(
            f"columns of {what} are not read, because their names are not known: {listed(self.columns)}",
            f"Give {Hint('channels', self.sensor, places)} and the other channels",
        )


@frozen
class MixedUnits(InFile, code="mixed_units"):
    """Axes of one sensor whose units the file states differently.

    Attributes
    ----------
    units : tuple of (str, str)
        Column and unit of each axis.
    """

    units: tuple[tuple[str, str], ...]

    def words(self, finding: Finding) -> Words:
        units = ", ".join(f"{shortened(name, LONGEST_NAME)} {shortened(unit, 12)}" for name, unit in self.units)
        return Words(
            f"axes of one sensor have different units: {units}",
            f"Correct the header, or give one unit with {Hint('unit')}",
        )
