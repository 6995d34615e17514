"""`Store`: a database of the results of many units and runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import compress
from pathlib import Path
from types import NoneType, TracebackType
from typing import TYPE_CHECKING, Any, Self

from sigmatau.errors import DataError, OptionError
from sigmatau.fitting import QUANTIFIED
from sigmatau.lab.store.choosing import Chosen, StoreTable, conditions
from sigmatau.lab.store.ingest import BATCH, Added
from sigmatau.lab.store.packing import READ, contents
from sigmatau.lab.store.rows import Entry

if TYPE_CHECKING:
    from sqlalchemy import Select
    from sqlalchemy.engine import Connection

    from sigmatau import Analysis
    from sigmatau.analysis import FailedAnalysis
    from sigmatau.lab.lots.comparison import RunComparison
    from sigmatau.lab.lots.options import By
    from sigmatau.lab.store.from_files import FilesAdded
    from sigmatau.lab.store.keeping import KeepCurves
    from sigmatau.lab.store.naming import Naming
    from sigmatau.lab.store.trend import Period, Trend


class Store:
    """A database of results.

    Parameters
    ----------
    place : str or Path
        A SQLite file, or the URL of a PostgreSQL database, ``postgresql://USER@HOST/NAME``.
    create : bool
        Whether a missing file is created.

    Raises
    ------
    OptionError
        For a URL of another database.
    DataError
        For a place that is not a store, or cannot be reached.
    ImportError
        Without SQLAlchemy and orjson.

    See Also
    --------
    compare_runs : makes the same comparison without a store.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = [st.analyze(st.simulate(model, duration=600, rate=20, rng=day)) for day in range(3)]
    >>> with st.Store("lab.db") as store:
    ...     added = [store.add(day, unit="A1") for day in days]
    ...     print(store.compare()["gyro_x", "random_walk"].judgement)
    repeatable
    """

    def __init__(self, place: str | Path, *, create: bool = True) -> None:
        from sigmatau.lab.store.connect import open_engine

        self._engine = open_engine(place, create=create)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._engine.dispose()

    def add(
        self, entries: Iterable[Entry | Analysis] | Entry | Analysis, *, unit: str | None = None, batch: int = BATCH
    ) -> Added:
        """Add results. A result that is already stored is not added again; a different result of the same log and options
        is a new revision.

        Parameters
        ----------
        entries : Entry or Analysis, or iterable of them
            Results, as an `Entry` with unit and run, or as an `Analysis`.
        unit : str, optional
            Serial number for each `Analysis`. Default: its note "serial number".
        batch : int
            Number of results per transaction. Committed results remain if the process is killed.

        Returns
        -------
        Added
            Numbers of new, revised, and already stored results.

        Raises
        ------
        DataError
            If an entry is not a result, its unit is unknown, or the database refuses it; earlier batches remain.
        OptionError
            For a batch smaller than 1.
        TypeError
            If an entry is neither an `Entry` nor an `Analysis`.
        """
        from sigmatau import Analysis
        from sigmatau.analysis import FailedAnalysis
        from sigmatau.lab.store.ingest import add
        from sigmatau.lab.store.naming import Naming

        if batch < 1:
            raise OptionError(f"{{option}} must be at least 1, not {batch}", option="batch")
        naming = Naming(unit=unit)

        def entry(result: Entry | Analysis) -> Entry:
            if isinstance(result, Entry):
                return result
            if not isinstance(result, Analysis | FailedAnalysis):
                raise TypeError(
                    f"`entries` must be Entry or Analysis, or several of them, not {type(result).__name__};"
                    " for the content of a JSON file use Analysis.from_dict(content)"
                )
            return naming.entry(
                result, Path(result.path if isinstance(result, FailedAnalysis) else result.source.path or "")
            )

        is_sequence = isinstance(entries, Iterable) and not isinstance(entries, Mapping | Analysis)
        return add(self._engine, map(entry, entries if is_sequence else [entries]), batch=batch)  # type: ignore[arg-type]

    def add_files(
        self,
        files: Sequence[Path],
        naming: Naming,
        *,
        jobs: int = 1,
        keep_curves: KeepCurves = "all",
        done: Callable[[int], None] = lambda _: None,
    ) -> FilesAdded:
        """Add the JSON files of results.

        Parameters
        ----------
        files : sequence of Path
            Files written by ``sigmatau analyze --json``.
        naming : Naming
            Rules for the names of units and runs.
        jobs : int
            Number of processes that read the files.
        keep_curves : {"failed", "all", "none"}
            Results that keep their Allan deviations: those without a fit, with an error, or with a fit whose trust is not
            good; all; or none. Coefficients, findings and intervals are stored in any case.
        done : callable, optional
            Called with the number of finished files. Default: not called.

        Returns
        -------
        FilesAdded
            Numbers of added results, and the files that were not added.
        """
        from sigmatau.lab.store.from_files import add_files

        return add_files(self._engine, files, naming, jobs=jobs, keep_curves=keep_curves, done=done)

    def versions(self, options_key: str) -> dict[str, str]:
        """Logs that have a current result with these options.

        Parameters
        ----------
        options_key : str
            Checksum of the options of `sigmatau.analyze`, see `sigmatau.lab.store.rows.options_key`.

        Returns
        -------
        dict of str to str
            Version of the analysed file, by path of the log.
        """
        from sigmatau.lab.store import queries

        with self._read() as connection:
            return {row[0]: row[1] for row in connection.execute(queries.versions(options_key))}

    @contextmanager
    def _read(self) -> Iterator[Connection]:
        from sqlalchemy.exc import SQLAlchemyError

        from sigmatau.lab.store.connect import reason

        try:
            with self._engine.connect() as connection:
                yield connection
        except DataError:
            raise
        except (SQLAlchemyError, ValueError, TypeError) as error:  # a value of the wrong type
            raise DataError(f"the store cannot be read: {reason(error)}") from None

    def _table(self, query: Select[Any]) -> StoreTable:
        with self._read() as connection:
            result = connection.execute(query)
            names, rows = list(result.keys()), result.all()
        columns = [list(column) for column in zip(*rows, strict=True)] if rows else [[] for _ in names]
        for name, column, selected in zip(names, columns, query.selected_columns, strict=True):
            # SQLite keeps values of any type in a column.
            expected = selected.type.python_type
            wrong = {type(value) for value in column} - {expected, NoneType, int if expected is float else expected}
            if wrong:
                types = ", ".join(sorted(kind.__name__ for kind in wrong))
                raise DataError(f"the store cannot be read: {name} has values of type {types}; restore it from a copy")
        return StoreTable(dict(zip(names, columns, strict=True)))

    def units(self, chosen: Chosen | None = None) -> StoreTable:
        """One row per unit: name, sensor model, runs by state, first and last time.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.

        Returns
        -------
        StoreTable
        """
        from sigmatau.lab.store import queries

        return self._table(queries.units(chosen))

    def runs(self, chosen: Chosen | None = None) -> StoreTable:
        """One row per run: unit, name, time, state, and reason of a failure.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.

        Returns
        -------
        StoreTable
        """
        from sigmatau.lab.store import queries

        return self._table(queries.runs(chosen))

    def coefficients(
        self, chosen: Chosen | None = None, *, term: str | None = None, channels: Sequence[str] = ()
    ) -> StoreTable:
        """One row per run, channel and term: value with interval, or limit, in SI.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.
        term : str, optional
            A key of `sigmatau.noise.terms.TERMS`. Default: all terms.
        channels : sequence of str
            Default: every channel.

        Returns
        -------
        StoreTable
        """
        from sigmatau.lab.store import queries

        return self._table(queries.coefficients(chosen, term=term, channels=channels))

    def trend(
        self,
        term: str = "random_walk",
        *,
        channels: Sequence[str] = (),
        by: Period = "month",
        chosen: Chosen | None = None,
        level: float = 0.95,
    ) -> Trend:
        """Drift of a coefficient over time: median and spread by period, slopes between and within units.

        Values of models that do not fit, and runs without a time, are not used.

        Parameters
        ----------
        term : str
            A key of `sigmatau.noise.terms.TERMS`, or ``"mean"``.
        channels : sequence of str
            Default: every channel.
        by : {"day", "week", "month", "quarter", "year"}
        chosen : Chosen, optional
            Selected runs. Default: all current runs.
        level : float
            Confidence level of intervals and tests.

        Returns
        -------
        Trend

        Raises
        ------
        DataError
            If no value has a time.
        OptionError
            For an unknown term or period, or a level outside 0 to 1.
        """
        from sigmatau.lab.lots.runs import MEAN
        from sigmatau.lab.store.trend import estimate_trend
        from sigmatau.noise.synonyms import unknown_term
        from sigmatau.noise.terms import TERMS

        if term not in (*TERMS, MEAN):
            raise OptionError(f"{{option}}: {unknown_term(term, terms=(*TERMS, MEAN))}", option="term")
        rows = self.coefficients(chosen, term=term, channels=channels).columns()
        if channels and not rows["unit"]:
            raise DataError(f"no trend of {term}: no selected run has it in {', '.join(channels)}")
        usable = [term == MEAN or verdict in QUANTIFIED for verdict in rows["verdict"]]
        return estimate_trend(
            {key: list(compress(column, usable)) for key, column in rows.items()}, term=term, by=by, level=level
        )

    def compare(self, chosen: Chosen | None = None, *, by: By = "unit", level: float = 0.95) -> RunComparison:
        """Repeatability of every channel and term over the runs of each unit; see `sigmatau.compare_runs`.

        If a log has results with several options, the latest result is compared. The clocks of the runs are not
        compared.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.
        by, level
            As in `sigmatau.compare_runs`.

        Returns
        -------
        RunComparison

        Raises
        ------
        DataError
            If no run has coefficients.
        """
        from sigmatau.lab.lots.comparison import compare_table
        from sigmatau.lab.lots.options import CompareOptions
        from sigmatau.lab.store.run_table import run_table

        options = CompareOptions(by=by, level=level)
        with self._read() as connection:
            table = run_table(connection, conditions(chosen))
        if not table.runs:
            raise DataError("the store has no run with coefficients of this kind")
        return compare_table(table, options)

    def latest(self, unit: str, *, run: str | None = None) -> tuple[Mapping[str, Any], Analysis | FailedAnalysis]:
        """The latest run of a unit that has coefficients, otherwise its latest run, with the result.

        Parameters
        ----------
        unit : str
            Name of the unit.
        run : str, optional
            Name of the run. Default: the latest one.

        Returns
        -------
        row : mapping
            The row of the run, as in `runs`.
        result : Analysis or FailedAnalysis

        Raises
        ------
        DataError
            If there is no such unit, or no such run, or if its result cannot be read.
        """
        from sigmatau.analysis import result_of_dict

        rows = _rows(self.runs(Chosen(units=(unit,), pattern=False)))
        if not rows:
            raise DataError(f"the store has no unit {unit!r}; sigmatau store list shows its units")
        named = [row for row in rows if run in (None, row["run"])]
        if not named:
            raise DataError(f"unit {unit} has no run {run!r}; its runs: {', '.join(row['run'] for row in rows[:10])}")
        row = max(named, key=_order)
        return row, result_of_dict(self.content(row["id"]))

    def content(self, run_id: int) -> dict[str, Any]:
        """The JSON form of a result as it was added, including keys of other versions.

        Parameters
        ----------
        run_id : int
            The column `id` of `runs`.

        Returns
        -------
        dict

        Raises
        ------
        DataError
            If there is no such run, or if its content is damaged.
        """
        with self._read() as connection:
            for _, content in contents(connection, [run_id]):
                return content
        raise DataError(f"the store has no run with the number {run_id}")

    def units_latest(self, chosen: Chosen | None = None) -> dict[str, Analysis | FailedAnalysis]:
        """The latest result of each unit, in the order of the first records of the units.

        A failure counts as a result, because an earlier measurement does not describe the current unit. Results without a
        time get the time at which they were added.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.

        Returns
        -------
        dict of str to (Analysis or FailedAnalysis)
            Results by unit. A result that cannot be read is a failure.
        """
        from sigmatau.analysis import FailedAnalysis, result_of_dict
        from sigmatau.lab.store import queries

        def read(content: dict[str, Any]) -> Analysis | FailedAnalysis:
            try:
                return result_of_dict(content)
            except DataError as error:
                return FailedAnalysis.of(error, "")

        with self._read() as connection:
            latest = {name: key for key, name, _ in connection.execute(queries.in_order(chosen))}
            results = {key: read(content) for key, content in contents(connection, [*latest.values()])}
        return {name: results[key] for name, key in latest.items()}

    def findings(self, run_id: int) -> list[tuple[str, str]]:
        """Severity and message of the findings of a run.

        Parameters
        ----------
        run_id : int
            The column `id` of `runs`.

        Returns
        -------
        list of (str, str)
        """
        from sigmatau.lab.store import queries

        with self._read() as connection:
            return [(severity, message) for severity, message in connection.execute(queries.findings(run_id))]

    def results(self, chosen: Chosen | None = None) -> Iterator[tuple[Mapping[str, Any], Analysis | FailedAnalysis]]:
        """Each run, as in `runs`, with its result.

        Parameters
        ----------
        chosen : Chosen, optional
            Selected runs. Default: all current runs.

        Yields
        ------
        row : mapping
            The row of the run, as in `runs`.
        result : Analysis or FailedAnalysis
        """
        from sigmatau.analysis import result_of_dict

        rows = _rows(self.runs(chosen))
        for start in range(0, len(rows), READ):
            part = rows[start : start + READ]
            with self._read() as connection:
                content_by_id = dict(contents(connection, [row["id"] for row in part]))
            for row in part:
                yield row, result_of_dict(content_by_id[row["id"]])


def _rows(table: StoreTable) -> list[dict[str, Any]]:
    columns = table.columns()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def _order(row: Mapping[str, Any]) -> tuple[bool, str, int]:
    """Sort key of runs: those with coefficients last, then by time."""
    recorded = row["recorded"]
    return row["state"] == "fitted", "" if recorded is None else recorded.isoformat(), row["id"]
