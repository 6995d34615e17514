"""Coefficients of many results as one table: a row for each run, channel and term."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import Analysis, NoiseFit, ReadOff
from sigmatau._native.distributions import normal_quantile
from sigmatau.analysis import FailedAnalysis, as_analysis
from sigmatau.arrays import Floats, Ints
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.conditions import run_supply, run_temperature
from sigmatau.quality import Mark, collect_marks, reason_without_fits
from sigmatau.results import noted_unit

MEAN = "mean"
"""Name of the mean of a channel, used like the keys of `sigmatau.noise.terms.TERMS`: turn-on bias plus rate or gravity."""

LEVEL = 0.95
"""Confidence level of an interval whose level is not stated, in a table of coefficients or of a mean: that of `analyze`."""

SIGNED = ("rate_ramp", MEAN)
"""Terms whose values have a sign. They are compared directly, and all others by their logarithms."""

OBSERVED, LIMITED, WITHOUT_ERROR, WITHOUT_INTERVAL = range(4)
"""Status of a row: value with a standard error; upper limit; value with an unknown error, such as a read-off, whose δ is
not a standard error; value of a model that does not fit."""

RUN_NOTES = ("run", "day", "test", "date")
"""Notes of `analyze` that name the run; the first of them that exists is used."""


@frozen
class Label:
    """Channel and term of a row.

    Attributes
    ----------
    channel : str
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    term : str
        A key of `sigmatau.noise.terms.TERMS`, or ``"mean"``.
    unit : str
        Unit of the values; SI.
    rate_unit : str
        SI unit of the channel.
    """

    channel: str
    quantity: str
    term: str
    unit: str
    rate_unit: str


@frozen
class ComparedRun:
    """A result that is compared, or why it is not.

    Attributes
    ----------
    name : str
    serial : str
        Serial number of the unit; empty if nothing states it.
    place : str
        File of the result; empty if it came from memory.
    notes : mapping of str to str
        The user's notes on the record.
    sha256 : str or None
        Checksum of the log.
    marks : tuple of Mark
        Frequencies that show the clock of the unit.
    problem : str
        Why the result is not used; empty if it is used.
    typed : bool
        Whether it comes from a table that may have been typed, with few digits.
    temperature : float or None
        Temperature in the notes, otherwise the mean of the thermometer of the log. [degC]
    supply : float or None
        Supply voltage in the notes, otherwise in the name of the log. [V]
    """

    name: str
    serial: str
    place: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)
    sha256: str | None = None
    marks: tuple[Mark, ...] = ()
    problem: str = ""
    typed: bool = False
    temperature: float | None = None
    supply: float | None = None


@frozen(eq=False)
class RunTable:
    """Rows of all runs. Arrays have one entry per row."""

    runs: tuple[ComparedRun, ...]
    labels: tuple[Label, ...]
    run: Ints  # position in `runs`
    label: Ints  # position in `labels`
    value: Floats  # [SI]
    error: Floats  # standard error, NaN if not known; relative, or in SI for a term in `SIGNED`
    limit: Floats  # upper limit of a term that was not observed [SI]
    delta: Floats  # δ of the paper's rule: by eq. (26) for a read-off, or as stated [SI]
    status: NDArray[np.int8]


class RunsBuilder:
    """Collects runs and rows, and builds the table."""

    def __init__(self) -> None:
        self._runs: list[ComparedRun] = []
        self._labels: dict[tuple[str, str, str, str, str], int] = {}
        self._places = array("q")  # run, label and status of each row
        self._numbers = array("d")  # its value, error, limit and delta

    @contextmanager
    def whole(self) -> Iterator[None]:
        """Remove the rows that the block added if it raises an error, so that no incomplete file is compared."""
        runs, places, numbers = len(self._runs), len(self._places), len(self._numbers)
        try:
            yield
        except BaseException:
            del self._runs[runs:], self._places[places:], self._numbers[numbers:]
            raise

    def add_run(self, run: ComparedRun) -> int:
        """Add a run and return its position, to which `add_row` refers."""
        self._runs.append(run)
        return len(self._runs) - 1

    def add_row(
        self,
        run: int,
        label: tuple[str, str, str, str, str],
        status: int,
        *,
        value: float = math.nan,
        error: float = math.nan,
        limit: float = math.nan,
        delta: float = math.nan,
    ) -> None:
        """Add a row; `label` has the fields of `Label`."""
        position = self._labels.setdefault(label, len(self._labels))
        self._places.extend((run, position, status))
        self._numbers.extend((value, error, limit, delta))

    def add_result(
        self, result: Analysis | FailedAnalysis, *, name: str, place: str = "", serial: str | None = None
    ) -> None:
        """Add a result. `serial` names its unit and has priority over its notes."""
        run_name, unit = _named(name, result.notes, serial)
        run = ComparedRun(name=run_name, serial=unit, place=place, notes=result.notes)
        try:
            analysis = as_analysis(result)
            rows = _rows(analysis)
        except DataError as error:
            self.add_run(replace(run, problem=str(error)))
            return
        position = self.add_run(
            replace(
                run,
                sha256=analysis.source.sha256,
                marks=collect_marks(analysis.fits),
                temperature=run_temperature(analysis),
                supply=run_supply(analysis),
            )
        )
        for label, status, value, spread, limit, delta in rows:
            self.add_row(position, label, status, value=value, error=spread, limit=limit, delta=delta)

    def table(self) -> RunTable:
        """The table of all rows so far."""
        run, label, status = np.array(self._places, dtype=np.int64).reshape(-1, 3).T.copy()
        value, error, limit, delta = np.array(self._numbers, dtype=np.float64).reshape(-1, 4).T.copy()
        labels = (Label(channel=c, quantity=q, term=t, unit=u, rate_unit=r) for c, q, t, u, r in self._labels)
        return RunTable(
            runs=tuple(self._runs),
            labels=tuple(labels),
            run=run,
            label=label,
            value=value,
            error=error,
            limit=limit,
            delta=delta,
            status=status.astype(np.int8),
        )


def joined(tables: Sequence[RunTable]) -> RunTable:
    """Join several tables."""
    if len(tables) == 1:
        return tables[0]
    labels: dict[Label, int] = {}
    runs: list[ComparedRun] = []
    run, label = [], []
    for table in tables:
        places = np.array([labels.setdefault(label_, len(labels)) for label_ in table.labels], dtype=np.int64)
        label.append(places[table.label] if len(places) else table.label)
        run.append(table.run + len(runs))
        runs += table.runs

    def concatenated(name: str) -> Any:  # noqa: ANN401  an array of any kind
        return np.concatenate([getattr(table, name) for table in tables])

    return RunTable(
        runs=tuple(runs),
        labels=tuple(labels),
        run=np.concatenate(run),
        label=np.concatenate(label),
        value=concatenated("value"),
        error=concatenated("error"),
        limit=concatenated("limit"),
        delta=concatenated("delta"),
        status=concatenated("status"),
    )


_Row = tuple[tuple[str, str, str, str, str], int, float, float, float, float]


def _rows(analysis: Analysis) -> list[_Row]:
    """The rows of an analysis; raises `DataError` if no coefficient has an interval or a limit, or was read off."""
    if not analysis.fits and (reason := reason_without_fits(analysis.rest)):
        raise DataError(reason)
    rows: list[_Row] = []
    for name in dict.fromkeys([*analysis.curves, *analysis.read_off]):
        lines = analysis.read_off.get(name)
        if name in analysis.fits:
            rows += _rows_of_fit(name, analysis.fits[name], lines)
        elif lines is not None and not analysis.fits:
            rows += _rows_of_lines(name, lines)
        if name in analysis.means:
            mean, read_off = analysis.means[name], analysis.read_off.get(name)
            curve = analysis.curves.get(name)
            if curve is not None:
                label = (name, curve.quantity, MEAN, mean.unit, curve.unit)
            elif read_off is not None:
                label = (name, read_off.quantity, MEAN, mean.unit, read_off.rate_unit)
            else:
                continue
            rows.append((label, WITHOUT_ERROR, mean.value, math.nan, math.nan, math.nan))
    if not any(row[1] in (OBSERVED, LIMITED) or (row[1] == WITHOUT_ERROR and not math.isnan(row[-1])) for row in rows):
        raise DataError("no coefficient has an interval or was read off: no model fits")
    return rows


def _rows_of_lines(name: str, lines: ReadOff) -> Iterable[_Row]:
    for term, line in lines.items():
        label = (name, lines.quantity, term, line.unit, lines.rate_unit)
        yield label, WITHOUT_ERROR, line.value, math.nan, math.nan, line.error


def _rows_of_fit(name: str, fit: NoiseFit, lines: ReadOff | None) -> Iterable[_Row]:
    for term, fitted in fit.terms.items():
        label = (name, fit.quantity, term, fitted.unit, fit.rate_unit)
        if fitted.value is None:
            if fitted.observed is False and fitted.upper_limit is not None:
                yield label, LIMITED, math.nan, math.nan, fitted.upper_limit, math.nan
            continue
        error = math.nan
        if fit.quantified and fitted.low is not None and fitted.high is not None:
            error = standard_error(term, fitted.value, fitted.low, fitted.high, level=fitted.level)
        delta = lines[term].error if lines is not None and term in lines else math.nan
        yield label, WITHOUT_INTERVAL if math.isnan(error) else OBSERVED, fitted.value, error, math.nan, delta


def standard_error(term: str, value: float, low: float, high: float, *, level: float) -> float:
    """Standard error from an interval: relative for logarithms, absolute for a signed value; NaN without an interval.

    For a coefficient the upper half is used. The lower half of an interval of a fit includes terms that the record does not
    show, which are the same in all runs: errors from it would be 1.5 times the scatter of simulated runs.
    """
    if not (low <= value <= high and low < high):
        return math.nan
    z = _z(level)
    if term in SIGNED:
        return (high - low) / (2 * z)
    return math.log(high / value) / z if 0 < value < high else math.nan


@lru_cache
def _z(level: float) -> float:
    return float(normal_quantile((1 + level) / 2))


def _named(name: str, notes: Mapping[str, str], serial: str | None) -> tuple[str, str]:
    """Name of the run and of the unit."""
    by_key = {key.strip().lower(): text for key, text in notes.items()}
    run = next((by_key[key] for key in RUN_NOTES if by_key.get(key)), name)
    if serial is not None:
        return run, serial
    return run, noted_unit(notes)
