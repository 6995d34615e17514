"""Unit, time, temperature and supply voltage of a result: from options, its notes, or names of files and folders."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from sigmatau.analysis import FailedAnalysis
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.lab.lots.conditions import KELVIN, SUPPLY_NOTES, TEMPERATURE_NOTES, celsius, volts
from sigmatau.lab.lots.dates import DATE_NOTES, date_in_name, iso_date
from sigmatau.lab.lots.runs import RUN_NOTES
from sigmatau.lab.lots.unit_pattern import FOLDER, LOG_FOLDER, check_unit_pattern, unit_in_path
from sigmatau.lab.store.rows import Entry, in_utc
from sigmatau.results import noted_unit

if TYPE_CHECKING:
    from sigmatau import Analysis

IN_NAME = "name"
"""Value of `Naming.date`: the first date in the path of the log."""

_HIGHEST_SUPPLY = 1000.0  # supply voltage above which no inertial sensor works [V]; a larger number is in mV
_HIGHEST = 1000.0  # temperature above which no inertial sensor works [degC]; a larger number is a slip


class UnknownUnitError(DataError):
    """Neither an option nor a note names the unit of a result."""


@frozen
class Naming:
    """Rules for the names of results.

    Attributes
    ----------
    unit : str or None
        Name of the unit of all results.
    unit_from : str or None
        ``"folder"`` of the file, ``"log-folder"`` of its log, or a regular expression for the path of the log, whose first
        group is the unit. Default: the note "serial number" or "unit", see `sigmatau.results.SERIAL_NOTES`.
    folders : bool
        Whether a result without such a note gets the name of its folder as its unit.
    model : str
        Sensor model.
    date : str or None
        Beginning of the records, ISO 8601, or ``"name"``: the first date in the path of the log. Default: the note. A
        time without a time zone is UTC.
    temperature : float or None
        Temperature. [degC] Default: the note.
    supply : float or None
        Supply voltage. [V] Default: the note.
    """

    unit: str | None = None
    unit_from: str | None = None
    folders: bool = False
    model: str = ""
    date: str | None = None
    temperature: float | None = None
    supply: float | None = None

    def check(self) -> None:
        """Check the options.

        Raises
        ------
        OptionError
            For two names of the unit, an empty name, a date that is not ISO 8601, a temperature or a supply voltage at
            which there are no sensors, or an expression for the unit that `check_unit_pattern` refuses.
        """
        if self.unit is not None and self.unit_from is not None:
            raise OptionError(f"{Hint('unit')} and {{option}} both name the unit; give one of them", option="unit_from")
        if self.unit is not None and not self.unit.strip():
            raise OptionError("{option} is empty; give the serial number", option="unit")
        if self.date not in (None, IN_NAME):
            time = iso_date(str(self.date))
            if time is None:
                raise OptionError(f"{{option}} {self.date}: must be like 2026-05-01T12:00, or name", option="date")
            in_utc(time)
        if self.temperature is not None:
            check_range(self.temperature)
        if self.supply is not None:
            check_supply(self.supply)
        check_unit_pattern(self.unit_from)

    def entry(
        self, result: Analysis | FailedAnalysis, file: Path, *, content: Mapping[str, Any] | None = None
    ) -> Entry:
        """Add unit, time, temperature and supply voltage to a result.

        Parameters
        ----------
        result : Analysis or FailedAnalysis
            A result, whose notes and path of the log are used.
        file : Path
            File of the result.
        content : mapping, optional
            JSON from which the result was read.

        Returns
        -------
        Entry

        Raises
        ------
        DataError
            If the unit is unknown, or a date, a temperature or a supply voltage cannot be read.
        """
        notes = {key.strip().lower(): text.strip() for key, text in result.notes.items()}
        log = result.path if isinstance(result, FailedAnalysis) else result.source.path or ""
        return Entry(
            result=result,
            unit=self._unit(notes, log, file),
            model=self.model or notes.get("model", ""),
            name=next((notes[key] for key in RUN_NOTES if notes.get(key)), PurePath(log).name or file.stem),
            recorded=self._recorded(notes, log),
            temperature=self._temperature(notes),
            supply=self._supply(notes),
            content=content,
        )

    def _unit(self, notes: Mapping[str, str], log: str, file: Path) -> str:
        if self.unit is not None:
            return self.unit
        if self.unit_from is None:
            unit = noted_unit(notes)
            unit = unit or (file.absolute().parent.name if self.folders else "")
        elif self.unit_from == FOLDER:
            unit = file.absolute().parent.name
        elif self.unit_from == LOG_FOLDER:
            unit = PurePath(log).parent.name
        else:
            unit = unit_in_path(self.unit_from, log)
            if not unit:
                raise UnknownUnitError(
                    f"{Hint('unit_from')} {self.unit_from!r} finds no unit in the path of the log"
                ).about(log)
        if not unit:
            raise UnknownUnitError(
                f"its unit is not known; give {Hint('unit', value='NAME')}, {Hint('unit_from', value='folder')}, or a note:"
                f" {command('analyze', 'LOG', Hint('note', 'serial number', 'A123'))}"
            )
        return unit

    def _recorded(self, notes: Mapping[str, str], log: str) -> datetime | None:
        if self.date == IN_NAME:
            return _in_name(log)
        if self.date is not None:
            return iso_date(self.date)
        for key in DATE_NOTES:
            if text := notes.get(key):
                date = iso_date(text)
                if date is None:
                    raise DataError(
                        f"the note {key} {text!r:.40} is not a date like 2026-05-01T12:00; give {Hint('date')}"
                    )
                return date
        return None

    def _temperature(self, notes: Mapping[str, str]) -> float | None:
        if self.temperature is not None:
            return self.temperature
        for key in TEMPERATURE_NOTES:
            if text := notes.get(key):
                degrees = celsius(text)
                if degrees is None:
                    raise DataError(
                        f"the note {key} {text!r:.40} is not a temperature like 25 degC; give {Hint('temperature')}"
                    )
                if degrees < -KELVIN:
                    raise DataError(f"the note {key} {text!r:.40} is below absolute zero; give {Hint('temperature')}")
                return degrees
        return None

    def _supply(self, notes: Mapping[str, str]) -> float | None:
        if self.supply is not None:
            return self.supply
        for key in SUPPLY_NOTES:
            if text := notes.get(key):
                voltage = volts(text)
                if voltage is None:
                    raise DataError(f"the note {key} {text!r:.40} is not a voltage like 3.3V; give {Hint('supply')}")
                return voltage
        return None


def stated_supply(text: str | None) -> float | None:
    """Parse a supply voltage of the command line to V. Raises `OptionError` for forms other than 3.3, 3.3V or 3300mV."""
    if text is None:
        return None
    voltage = volts(text)
    if voltage is None:
        raise OptionError(f"{{option}} {text!r:.40} is not a voltage like 3.3V", option="supply")
    check_supply(voltage)
    return voltage


def check_supply(voltage: float) -> None:
    """Raise `OptionError` for a supply voltage at which there are no sensors."""
    if not 0 < voltage <= _HIGHEST_SUPPLY:
        raise OptionError(
            f"{{option}} {voltage:g} V is not above 0 and at most {_HIGHEST_SUPPLY:g} V; give it like 3.3V or 3300mV",
            option="supply",
        )


def stated_temperature(text: str | None) -> float | None:
    """Parse a temperature of the command line: 25, 25degC or 298K. [degC] Raises `OptionError` for other forms, and for a
    temperature outside -273 … 1000 °C.
    """
    if text is None:
        return None
    degrees = celsius(text)
    if degrees is None:
        raise OptionError(f"{{option}} {text!r:.40} is not a temperature like 25degC", option="temperature")
    check_range(degrees)
    return degrees


def check_range(degrees: float) -> None:
    """Raise `OptionError` for a temperature outside -273 … 1000 °C."""
    if not -KELVIN <= degrees <= _HIGHEST:
        raise OptionError(
            f"{{option}} {degrees:g} °C is outside {-KELVIN:g} to {_HIGHEST:g} °C; give it like 85degC or 358K",
            option="temperature",
        )


def _in_name(log: str) -> datetime:
    """Find the first date in the path of a log. Raises `DataError` without a date."""
    date = date_in_name(log)
    if date is None:
        raise DataError(f"no date in the name of the log; give {Hint('date', value='2026-05-01')}").about(log)
    return date
