"""`compare_runs`: repeatability of every channel and term over runs, units or axes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import Finding
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.group_effects import GroupEffects
from sigmatau.lab.lots.grouping import Cells, estimate_effects, holm, sort_into_cells
from sigmatau.lab.lots.options import By, CompareOptions
from sigmatau.lab.lots.preparing import collect_runs, drop_other_units, mark_copies, name_by_place, split_by_condition
from sigmatau.lab.lots.repeatability import Judgement, RandomEffects, Scale, judge_groups, one_group
from sigmatau.lab.lots.runs import SIGNED, ComparedRun, Label, RunTable
from sigmatau.options import keywords_of
from sigmatau.quality import compare_clocks
from sigmatau.results import Tabular

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau import Analysis
    from sigmatau.plot.style import Panels

_MOST_CLOCKS = 100  # largest number of runs of a unit whose clocks are compared pair by pair
_NUMBERS = (
    "mean", "low", "high", "std", "error", "q", "p_value", "p_low", "tau", "tau_low", "tau_high",
    "next_low", "next_high", "next_error",
)  # fmt: skip


@frozen(eq=False)
class RunComparison(Tabular):
    """Result of `compare_runs`.

    ``comparison["gyro_x", "random_walk"]`` is the `RandomEffects` of a term; with several groups
    ``comparison["A123", "gyro_x", "random_walk"]``.

    Attributes
    ----------
    by : {"unit", "run", "axis"}
        How results are grouped: by unit (the runs of a unit are compared), by run (the units of a run are compared), or all
        in one group (axis).
    level : float
        Confidence level of tests and intervals.
    runs : tuple of ComparedRun
        All results, in order: those with a `problem` are not compared.
    groups : tuple of str
        Names of the groups; one empty name if there is one group without a name.
    clocks_off : mapping of str to Finding
        Runs whose lines and filters all have other frequencies than in the other runs of the unit.
    clocks_skipped : tuple of str
        Units whose clocks are not compared, because they have too many runs.

    See Also
    --------
    compare_runs : makes it.
    random_effects : the estimates of one row.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = [st.analyze(st.simulate(model, duration=600, rate=10, rng=day)) for day in range(3)]
    >>> compared = st.compare_runs(days, names=["day 1", "day 2", "day 3"])
    >>> [run.name for run in compared.runs]
    ['day 1', 'day 2', 'day 3']
    >>> compared["gyro_x", "random_walk"].k
    3
    """

    by: By
    level: float
    runs: tuple[ComparedRun, ...]
    groups: tuple[str, ...]
    clocks_off: Mapping[str, Finding]
    clocks_skipped: tuple[str, ...]
    table: RunTable
    cells: Cells
    effects: GroupEffects

    @property
    def unused(self) -> dict[str, str]:
        """The results that are not compared, with reasons, by file or name."""
        return {run.place or run.name: run.problem for run in self.runs if run.problem}

    def __len__(self) -> int:
        return len(self.cells.label)

    def key(self, at: int) -> tuple[str, Label]:
        """Group and label of a row.

        Parameters
        ----------
        at : int
            Number of the row, from 0.

        Returns
        -------
        group : str
        label : Label
            Channel and term.
        """
        return self.groups[self.cells.group[at]], self.table.labels[self.cells.label[at]]

    def __iter__(self) -> Iterator[tuple[str, str, str]]:
        """Group, channel and term of each row."""
        for row in range(len(self)):
            group, label = self.key(row)
            yield group, label.channel, label.term

    def __getitem__(self, key: tuple[str, ...]) -> RandomEffects:
        """The random effects of a group, channel and term; the group may be omitted if there is only one."""
        if not (isinstance(key, tuple) and len(key) in (2, 3)) or (len(key) == 2 and len(self.groups) != 1):
            raise KeyError(f"a key is (group, channel, term), or (channel, term) of one group; not {key!r}")
        full_key = key if len(key) == 3 else (self.groups[0], *key)
        for row, row_key in enumerate(self):
            if row_key == full_key:
                return self.row(row)
        raise KeyError(f"no values of {' '.join(full_key).strip()}")

    def row(self, at: int) -> RandomEffects:
        """The random effects of a row.

        Parameters
        ----------
        at : int
            Number of the row, from 0.

        Returns
        -------
        RandomEffects
        """
        _, label = self.key(at)
        scale: Scale = "absolute" if label.term in SIGNED else "relative"
        return one_group(self.effects, at, scale=scale, level=self.level, std=float(self.cells.std[at]))

    def values(self, at: int) -> list[tuple[ComparedRun, float, float]]:
        """Run, value and standard error of each value of a row.

        Parameters
        ----------
        at : int
            Number of the row, from 0.

        Returns
        -------
        list of (ComparedRun, float, float)
            The error is relative, or in SI for a signed term. [SI]
        """
        table = self.table
        return [(self.runs[table.run[k]], float(table.value[k]), float(table.error[k])) for k in self.cells.rows(at)]

    def judgements(self) -> list[Judgement]:
        """Outcome of the tests of each row. P-values are corrected for the number of rows of the group (Holm): if the runs
        of a group do not differ, the probability of any false outcome is at most 1 - `level`.
        """
        e = self.effects
        p, low, outlier = (holm(x, self.cells.group) for x in (e.p_value, e.p_low, e.outlier_p))
        return judge_groups(e.k, p, low, outlier, level=self.level)

    def outliers(self) -> dict[int, ComparedRun]:
        """The outlying run of each row."""
        outliers = {}
        for row, judgement in enumerate(self.judgements()):
            if judgement == "outlier":
                outliers[row] = self.runs[self.table.run[self.cells.rows(row)[self.effects.outlier[row]]]]
        return outliers

    def below(self) -> dict[int, list[ComparedRun]]:
        """Runs, by row, that should show a term but do not: their upper limit is below the prediction interval of another
        run. The limit of a ramp is that of its absolute value.
        """
        runs_below: dict[int, list[ComparedRun]] = {}
        for row in np.flatnonzero((self.cells.valued > 1) & (self.cells.looked > self.cells.valued)).tolist():
            effects = self.row(row)
            if effects.next_low is None or effects.next_high is None or effects.next_low < 0 < effects.next_high:
                continue
            smallest = min(abs(effects.next_low), abs(effects.next_high))
            runs = [self.runs[self.table.run[k]] for k in self.cells.limited(row) if self.table.limit[k] < smallest]
            if runs:
                runs_below[row] = runs
        return runs_below

    def columns(self) -> dict[str, list[Any]]:
        """One row per group, channel and term, see `Tabular.columns`. Numbers are in SI, spreads relative or in SI."""
        labels = [self.table.labels[k] for k in self.cells.label]
        signed = [label.term in SIGNED for label in labels]
        outliers = self.outliers()
        columns: dict[str, list[Any]] = {
            "group": [self.groups[k] for k in self.cells.group],
            "channel": [label.channel for label in labels],
            "term": [label.term for label in labels],
            "unit": [label.unit for label in labels],
            "scale": ["absolute" if is_signed else "relative" for is_signed in signed],
            "runs": self.cells.valued.tolist(),
            "of_runs": self.cells.looked.tolist(),
            "largest_limit": _none_if_nan(self.cells.limit),
        }
        for name, values in self._numbers(np.array(signed, dtype=bool)).items():
            columns[name] = _none_if_nan(values)
        for prefix, verdict, errors in (
            ("paper_delta", "paper_accepts", self.cells.delta),
            ("mean_error", "std_below_error", self.cells.typical),
        ):
            columns[prefix] = _none_if_nan(errors)
            columns[verdict] = [
                None if np.isnan(e) or np.isnan(s) else bool(s < e) for s, e in zip(self.cells.std, errors, strict=True)
            ]
        columns["judgement"] = list(self.judgements())
        columns["outlier"] = [outliers[row].name if row in outliers else None for row in range(len(self))]
        below = self.below()
        columns["runs_below"] = [" ".join(run.name for run in below.get(row, ())) or None for row in range(len(self))]
        return columns

    def _numbers(self, signed: NDArray[np.bool_]) -> dict[str, NDArray[np.float64]]:
        e = self.effects
        ends = {
            "mean": e.mean,
            "low": e.mean - e.mean_error,
            "high": e.mean + e.mean_error,
            "next_low": e.mean - e.next_error,
            "next_high": e.mean + e.next_error,
        }
        with np.errstate(over="ignore"):
            numbers = {name: np.where(signed, x, np.exp(x)) for name, x in ends.items()}
        for name in ("error", "q", "p_value", "p_low", "tau", "tau_low", "tau_high", "next_error"):
            numbers[name] = getattr(e, name)
        numbers["std"] = self.cells.std
        return {name: numbers[name] for name in _NUMBERS}

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI without NaN: runs, rows by column, clocks, results that are not used."""
        return {
            "by": self.by,
            "level": self.level,
            "runs": [
                {"name": run.name, "serial": run.serial, "place": run.place, "notes": dict(run.notes)}
                for run in self.runs
                if not run.problem
            ],
            "rows": self.columns(),
            "values": self._values(),
            "clocks_off": {name: finding.to_dict() for name, finding in self.clocks_off.items()},
            "not_used": self.unused,
        }

    def _values(self) -> dict[str, list[Any]]:
        """All compared values, with run, channel and term."""
        rows = [(row, *value) for row in range(len(self)) for value in self.values(row)]
        labels = [self.key(row)[1] for row, *_ in rows]
        return {
            "run": [run.name for _, run, _, _ in rows],
            "serial": [run.serial for _, run, _, _ in rows],
            "channel": [label.channel for label in labels],
            "term": [label.term for label in labels],
            "value": [value for *_, value, _ in rows],
            "error": [None if np.isnan(error) else error for *_, error in rows],
        }

    def plot(self, *channels: str, ax: Panels = None) -> Figure:
        """Forest plot: the value of each run with its interval, the mean, and the prediction interval of one more run.

        Parameters
        ----------
        *channels : str
            Which channels. Default: all of the first group.
        ax : matplotlib axes, or sequence of them, optional
            One for each term. Default: a new figure.

        Returns
        -------
        matplotlib figure

        Raises
        ------
        OptionError
            For an unknown channel.
        """
        from sigmatau.lab.lots.forest import draw_forests

        return draw_forests(self, channels, ax=ax)

    def __repr__(self) -> str:
        from sigmatau.lab.lots.comparison_text import overview

        return overview(self)


def _none_if_nan(values: NDArray[np.float64]) -> list[float | None]:
    return [x if ok else None for x, ok in zip(values.tolist(), np.isfinite(values).tolist(), strict=True)]


@keywords_of(CompareOptions)
def compare_runs(
    results: Sequence[str | Path | Mapping[str, Any] | Analysis] | str | Path, options: CompareOptions
) -> RunComparison:
    """Repeatability of every channel and term over several results.

    For each channel and term, `random_effects` is applied to the values of a group: the runs of a unit, unless `by`
    selects other groups. A term that only some runs show is compared over these runs, which have the larger values; the
    result states how many runs show it, of how many. Means of channels give the repeatability of the bias from
    turn-on to turn-on.

    Parameters
    ----------
    results : sequence of path, dict or Analysis
        Results of `analyze`: objects, their ``to_dict()``, JSON or CSV files, or folders of these; or tables of typed
        values with the columns ``run, channel, term, value, unit`` and ``error`` (see docs/how-to/repeatability.md).

    Returns
    -------
    RunComparison

    Raises
    ------
    DataError
        If no result can be used. Single results that cannot be used are in `RunComparison.unused`.
    OptionError
        For invalid options.

    See Also
    --------
    random_effects : makes the same estimates from numbers.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = [st.analyze(st.simulate(model, duration=600, rate=20, rng=day)) for day in range(3)]
    >>> compared = st.compare_runs(days, names=["day 1", "day 2", "day 3"])
    >>> compared["gyro_x", "random_walk"].judgement
    'repeatable'
    """
    table = collect_runs(results, options.names, options.units, options.jobs)
    runs = name_by_place(mark_copies(table))
    return compare_table(replace(table, runs=split_by_condition(runs) if options.by == "unit" else runs), options)


def compare_table(table: RunTable, options: CompareOptions) -> RunComparison:
    """`compare_runs` for a table, such as one from a `Store`, in which units are named and copies of a log are marked."""
    by, level = options.by, options.level
    usable = np.array([not run.problem for run in table.runs], dtype=bool)
    if not usable.any():
        reasons = [f"{run.place or run.name}: {run.problem}" for run in table.runs]
        raise DataError(reasons[0] if len(reasons) == 1 else f"no result can be used; the first: {reasons[0]}")
    table = drop_other_units(table)
    group_names = ["" if by == "axis" else run.serial if by == "unit" else run.name for run in table.runs]
    groups = sorted({name for name, ok in zip(group_names, usable, strict=True) if ok})
    position = {name: k for k, name in enumerate(groups)}
    group_of_run = np.array([position.get(name, 0) for name in group_names], dtype=np.int64)
    cells = sort_into_cells(table, group_of_run, usable)
    off, skipped = _clocks(table.runs)
    return RunComparison(
        by=by,
        level=level,
        runs=table.runs,
        groups=tuple(groups),
        clocks_off=off,
        clocks_skipped=skipped,
        table=table,
        cells=cells,
        effects=estimate_effects(table, cells, level=level),
    )


def _clocks(runs: Sequence[ComparedRun]) -> tuple[dict[str, Finding], tuple[str, ...]]:
    by_unit: dict[str, dict[str, ComparedRun]] = {}
    for run in runs:
        if not run.problem and run.marks:
            by_unit.setdefault(run.serial, {})[run.name] = run
    findings: dict[str, Finding] = {}
    skipped = []
    for serial, unit_runs in by_unit.items():
        if len(unit_runs) > _MOST_CLOCKS:
            skipped.append(serial)
            continue
        off = compare_clocks({name: run.marks for name, run in unit_runs.items()})
        findings |= {f"{serial} {name}".strip(): finding for name, finding in off.items()}
    return findings, tuple(skipped)
