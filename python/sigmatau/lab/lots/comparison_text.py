"""A comparison of runs in words: an overview for a screen of 24 lines, and the tables of the paper."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from sigmatau.digits import limit_text, round_to_error, significant, two_digits
from sigmatau.hints import Hint, command
from sigmatau.lab.lots.conditions import SUPPLY, TEMPERATURE
from sigmatau.lab.lots.repeatability import Judgement, RandomEffects
from sigmatau.lab.lots.runs import MEAN, SIGNED, Label
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.record import stream_name
from sigmatau.results import WIDTH, aligned, lines_text, wrapped

if TYPE_CHECKING:
    from sigmatau.lab.lots.comparison import RunComparison

_SCREEN = 23  # lines of the screen without the prompt
_LEAST_ROWS = 6  # smallest number of rows of a table of one group
_MOST_ROWS = 13  # largest number of rows of a table of many groups
_ALL_NAMED = 7  # number of runs up to which all are named in the first line, as the days of a week
_CSV = command("compare", Hint("csv", value="FILE"))
_MOST_NAMED = 4  # largest number of runs, groups or results that are named in a line
_STD = 3  # column STD %, which is only in --table if the table is too wide
_LARGEST = 1.0  # largest relative spread that is printed
VERDICTS: dict[Judgement, str] = {
    "repeatable": "repeatable",
    "varies": "varies",
    "outlier": "outlier",
    "too_alike": "too alike",
    "one_run": "one run",
    "without_errors": "not tested",
}
# shorter names of terms, for a table that is too wide
_SHORT_TERMS = {"bias instability": "bias instab.", "rate random walk": "rate walk"}
_ORDER: tuple[Judgement, ...] = ("outlier", "varies", "too_alike", "without_errors", "repeatable", "one_run")
# word for the compared results, by what they have in common: of one unit, runs are compared
COMPARED = {"unit": "run", "run": "unit", "axis": "result"}


def overview(comparison: RunComparison) -> str:
    """A summary of the variation between runs, for one screen. Unused results are not included."""
    lines = _single_group(comparison) if len(comparison.groups) == 1 else _many_groups(comparison)
    return lines_text([*lines, *wrapped(_conditions(comparison))])


def _conditions(comparison: RunComparison) -> list[str]:
    """Note that the runs were recorded under different conditions, and that only runs of the same condition are compared."""
    used = [run for run in comparison.runs if not run.problem]
    lines = []
    for factor, values in ((TEMPERATURE, [r.temperature for r in used]), (SUPPLY, [r.supply for r in used])):
        groups = Counter(filter(None, factor.groups(values)))
        if groups:
            what = f"{COMPARED[comparison.by]}s"
            listed = ", ".join(f"{count} {label}" for label, count in groups.items())
            if comparison.by == "unit":
                lines.append(f"! {what} {listed}: compared within each; a difference between them is no turn-on bias.")
            else:
                lines.append(f"! {what} {listed}: bias and noise depend on it; compare those of each.")
    return lines


def tables(comparison: RunComparison) -> str:
    """Tables I and III of the paper for every group, sensor and term: runs as rows, axes as columns."""
    judgements = comparison.judgements()
    by_table: dict[tuple[int, str, str], list[int]] = {}
    for row in range(len(comparison)):
        label = comparison.table.labels[comparison.cells.label[row]]
        if comparison.cells.valued[row]:
            key = (int(comparison.cells.group[row]), stream_name(label.channel), label.term)
            by_table.setdefault(key, []).append(row)
    order = [*TERMS, MEAN]
    keys = sorted(by_table, key=lambda key: (key[0], key[1] != "gyro", key[1], order.index(key[2])))
    parts = ["\n".join(_paper_table(comparison, key, by_table[key], judgements)) for key in keys]
    notes = []
    if np.isfinite(comparison.cells.delta).any():
        notes.append("δ: eq. (26) of the paper at the longest averaging time of the line, or as stated")
    if np.isfinite(comparison.cells.typical).any():
        notes.append(f"error: mean standard error of a {COMPARED[comparison.by]}")
    if notes:
        parts.append("\n".join(notes))
    return lines_text("\n\n".join(parts).splitlines())


def unused_lines(comparison: RunComparison) -> list[str]:
    """The results that are not compared, and wrong clocks, one per line."""
    lines = [f"not used: {place}: {problem}" for place, problem in comparison.unused.items()]
    lines += [f"{name}: {finding}" for name, finding in comparison.clocks_off.items()]
    return lines + [
        f"clocks not compared: {serial or 'the unit'} has too many runs" for serial in comparison.clocks_skipped
    ]


def term_name(label: Label) -> str:
    """Name of a term in a table."""
    return "mean" if label.term == MEAN else label.term.replace("_", " ")


def display_unit(label: Label, values: Iterable[float | None]) -> tuple[str, float]:
    """Unit in which values are printed, and its size in SI."""
    return usual_unit(label.term, label.quantity, label.rate_unit, values)


def usual_unit(term: str, quantity: str, rate_unit: str, values: Iterable[float | None]) -> tuple[str, float]:
    """Unit in which values of a coefficient or of a mean are printed, and its size in SI."""
    if term in (MEAN, "bias_instability"):
        return display_units("bias_instability", quantity, rate_unit, values)[-1]
    return display_units(term, quantity, rate_unit, values)[0]


def _single_group(comparison: RunComparison) -> list[str]:
    rows = [row for row in range(len(comparison)) if comparison.key(row)[1].term != MEAN]
    compared = [row for row in rows if comparison.cells.valued[row] > 1] or [
        row for row in rows if comparison.cells.valued[row]
    ]
    judgements = comparison.judgements()
    order = in_order(comparison, compared)
    notes = [*wrapped(_warnings(comparison, order, judgements)), *_turn_on(comparison)]
    room = max(
        _SCREEN - len(notes) - 4, _LEAST_ROWS
    )  # rows of the table: its heading, the first line and two lines about the columns need four
    if len(order) > room:
        worst = sorted(order, key=lambda row: _ORDER.index(judgements[row]))[: room - 1]
        order = [row for row in order if row in worst]
    lines = [_head(comparison), *_table(comparison, order, judgements)]
    if len(compared) > len(order):
        lines.append(f"{len(compared) - len(order)} more rows, none worse: {command('compare', Hint('table'))}")
    return lines + notes


def remarks(comparison: RunComparison) -> list[str]:
    """What was compared, and what stands out: rows that vary, runs that do not belong, the turn-on bias."""
    what, judgements = COMPARED[comparison.by], comparison.judgements()
    order = in_order(comparison, np.flatnonzero(comparison.cells.valued).tolist())
    has_groups = len(comparison.groups) > 1
    lines = [] if has_groups else [_head(comparison)]
    compared = 0
    for row in order:
        group, label = comparison.key(row)
        compared += judgements[row] in ("repeatable", "varies", "outlier", "too_alike")
        if judgements[row] == "varies":
            spread = spread_texts(label, comparison.row(row))[1]
            name = " ".join(filter(None, [group if has_groups else "", label.channel, term_name(label)]))
            lines.append(f"{name} varies between {what}s: spread {spread} %")
    if compared and not any(judgements[row] in ("varies", "outlier") for row in order):
        lines.append(f"No value differs between the {what}s by more than its error")
    lines += [line for line in _warnings(comparison, order, judgements) if not line.startswith("·")]
    if not has_groups:
        turn_on = " ".join(line.strip() for line in _turn_on(comparison))
        lines.append(turn_on[:1].upper() + turn_on[1:])
    return [line.removeprefix("! ") for line in lines if line]


def _head(comparison: RunComparison) -> str:
    used = [run for run in comparison.runs if not run.problem]
    what = COMPARED[comparison.by]
    names = [run.serial if comparison.by == "run" else run.name for run in used]
    unit_text = f" of {comparison.groups[0]}" if comparison.groups[0] else ""
    head = f"{len(used)} {what if len(used) == 1 else what + 's'}{unit_text}: "
    every = head + ", ".join(names)
    if len(names) <= _ALL_NAMED and len(every) <= WIDTH:
        return every
    brief = f"{head}{names[0]} … {names[-1]}"
    return brief if len(brief) <= WIDTH else f"{brief[: WIDTH - 1]}…"


def in_order(comparison: RunComparison, rows: Iterable[int]) -> list[int]:
    """Sort rows by channel, in the order of the results, and by term, in the order of slopes."""
    channels: dict[str, int] = {}
    for label in comparison.table.labels:
        channels.setdefault(label.channel, len(channels))
    order = [*TERMS, MEAN]

    def key(row: int) -> tuple[int, int]:
        label = comparison.key(row)[1]
        return channels[label.channel], order.index(label.term)

    return sorted(rows, key=key)


def _table(comparison: RunComparison, rows: Sequence[int], judgements: Sequence[Judgement]) -> list[str]:
    level = f"{100 * comparison.level:g}"
    what = COMPARED[comparison.by]
    cells: list[tuple[str, ...]] = [("", "", "mean", "STD %", f"between {what}s %", "next ± %", "")]
    for row in rows:
        label, effects = comparison.key(row)[1], comparison.row(row)
        unit, size = display_unit(label, [effects.mean])
        valued, looked = int(comparison.cells.valued[row]), int(comparison.cells.looked[row])
        verdict = VERDICTS[judgements[row]] if valued == looked else f"{valued} of {looked}"
        cells.append(
            (
                label.channel,
                term_name(label),
                f"{mean_text(effects, size)} {unit}",
                *spread_texts(label, effects),
                verdict,
            )
        )
    widths = _widths(cells)
    if sum(widths) + len(widths) - 1 > WIDTH:
        cells[0] = ("", "", "mean", "STD %", "between %", "next ± %", "")
        widths = _widths(cells)
    if sum(widths) + len(widths) - 1 > WIDTH:
        cells = [(texts[0], _SHORT_TERMS.get(texts[1], texts[1]), *texts[2:]) for texts in cells]
        widths = _widths(cells)
    if sum(widths) + len(widths) - 1 > WIDTH:
        cells = [(*texts[:_STD], *texts[_STD + 1 :]) for texts in cells]
        widths = _widths(cells)
    gap = 2 if sum(widths) + 2 * (len(widths) - 1) <= WIDTH else 1
    lines = []
    previous = ""
    for texts in cells:
        shown = (texts[0] if texts[0] != previous else "", *texts[1:])
        previous = texts[0]
        lines.append((" " * gap).join(text.ljust(width) for text, width in zip(shown, widths, strict=True)).rstrip())
    if all(comparison.cells.valued[row] < 2 for row in rows):
        return [*lines, _nothing(what)]
    is_tested = any(judgements[row] != "without_errors" for row in rows)
    spread = "the true values, errors removed" if is_tested else "the values, with their unknown errors"
    return [
        *lines,
        f"between {what}s: spread of {spread} [{level} % interval]",
        f"next ±: {level} % prediction interval of one more {what}, around the mean",
    ]


def _widths(cells: Sequence[Sequence[str]]) -> list[int]:
    return [max(map(len, column)) for column in zip(*cells, strict=True)]


def mean_text(effects: RandomEffects, size: float) -> str:
    """The mean of a row to the digits of its interval, in a unit of this size."""
    low, high = (None if end is None else end / size for end in (effects.low, effects.high))
    return round_to_error(effects.mean / size, low, high).value


def spread_texts(label: Label, effects: RandomEffects) -> tuple[str, str, str]:
    """STD, spread between runs, and half of the prediction interval, in per cent; for a signed term, relative to its
    mean.
    """
    if effects.std is None or effects.tau is None:
        return "", "", ""
    scale = 1.0 if label.term not in SIGNED else abs(effects.mean)

    def percent(x: float | None) -> str:
        if x is None or scale == 0:
            return ""
        return "0" if x == 0 else two_digits(100 * x / scale) if x < _LARGEST * scale else f"> {100 * _LARGEST:g}"

    std = "" if effects.std_relative is None else percent(effects.std_relative * scale)
    # If values differ by less than their errors, no spread may be consistent with them, and the interval is empty.
    if effects.tau_high == 0 or effects.tau_high is None or effects.tau_low is None:
        between = percent(effects.tau)
    elif effects.tau_high < _LARGEST * scale:
        between = round_to_error(
            *(100 * size / scale for size in (effects.tau, effects.tau_low, effects.tau_high))
        ).text
    else:
        between = f"{percent(effects.tau)} [{percent(effects.tau_low)}, {percent(effects.tau_high)}]"
    return std, between, percent(effects.next_error)


def _warnings(comparison: RunComparison, rows: Sequence[int], judgements: Sequence[Judgement]) -> list[str]:
    """Explanations of the verdicts: outlying runs by name, and terms that are not observed in all runs."""
    lines = []
    outliers = comparison.outliers()
    what = COMPARED[comparison.by]
    for row in rows:
        if row in outliers:
            label, run = comparison.key(row)[1], outliers[row]
            name = run.serial if comparison.by == "run" and run.serial else run.name
            value = next(value for run_shown, value, _ in comparison.values(row) if run_shown is run)
            mean = float(np.mean([v for run_shown, v, _ in comparison.values(row) if run_shown is not run]))
            if label.term in SIGNED:  # a ratio to a mean near zero says nothing
                unit, size = display_unit(label, [value])
                difference = f"{significant((value - mean) / size, sign='+')} {unit} from the mean of the others"
            else:
                difference = f"{_against(value, mean)} the others"
            lines.append(f"! {label.channel} {term_name(label)}: {what} {name} does not belong: {difference}")
    below = comparison.below()
    for row in rows:
        if row in below:
            label, runs = comparison.key(row)[1], below[row]
            smallest = min(comparison.table.limit[comparison.cells.limited(row)])
            unit, size = display_unit(label, [smallest])
            lines.append(
                f"! {label.channel} {term_name(label)}: {what} {runs[0].name} does not belong:"
                f" {limit_text(smallest / size)} {unit}, less than the others predict"
            )
    if len(lines) > _MOST_NAMED:
        lines = [
            *lines[:_MOST_NAMED],
            f"! {len(lines) - _MOST_NAMED} more rows with a {what} that does not belong: {_CSV}",
        ]
    alike = sum(judgements[row] == "too_alike" for row in rows)
    if alike:
        lines.append(
            f"! {alike} rows agree better than their errors allow: errors too large, or {what}s not independent"
        )
    if any(comparison.cells.valued[row] < comparison.cells.looked[row] for row in rows):
        lines.append(f"· m of n: m of the n {what}s show the term; the mean of these is too large.")
    return lines


def _against(value: float, mean: float) -> str:
    if mean == 0 or value * mean < 0:
        return "far from"
    ratio = value / mean
    if ratio > 2:
        return f"{two_digits(ratio)} times"
    return f"{two_digits(100 * abs(ratio - 1))} % {'above' if ratio > 1 else 'below'}"


def _turn_on(comparison: RunComparison) -> list[str]:
    """Standard deviations of the means over the runs."""
    by_sensor: dict[str, list[tuple[str, RandomEffects, str, float]]] = {}
    for row in in_order(comparison, range(len(comparison))):
        label = comparison.key(row)[1]
        if (
            label.term == MEAN
            and comparison.cells.valued[row] > 1
            and label.quantity in ("angular_rate", "acceleration")
        ):
            by_sensor.setdefault(stream_name(label.channel), []).append(
                (label.channel, comparison.row(row), *display_unit(label, ()))
            )
    if not by_sensor:
        return []
    parts = []
    for rows in by_sensor.values():
        values = ", ".join(f"{name} {significant((effects.std or 0.0) / size)}" for name, effects, _, size in rows)
        parts.append(f"{values} {rows[0][2]}")
    first = next(iter(by_sensor.values()))[0][1]
    factors = ""
    if first.tau and first.tau_low is not None and first.tau_high is not None:
        low, high = first.tau_low / first.tau, first.tau_high / first.tau
        factors = f" ({100 * comparison.level:g} % interval: × {two_digits(low)} to × {two_digits(high)})"
    start = "turn-on bias" if comparison.by == "unit" else "bias"
    return wrapped([f"{start}, STD: {'; '.join(parts)}{factors}"])


def _nothing(what: str) -> str:
    return f"Nothing to compare: each value is from one {what}. Give the results of two or more."


def _many_groups(comparison: RunComparison) -> list[str]:
    """Summary of many groups: how many are repeatable, by channel and term, and which have an outlying run."""
    judgements = comparison.judgements()
    used = sum(not run.problem for run in comparison.runs)
    what, group = COMPARED[comparison.by], comparison.by
    rows: dict[tuple[str, str], list[int]] = {}
    labels = comparison.table.labels
    order = [*TERMS]
    for row in np.flatnonzero(comparison.cells.valued > 1).tolist():
        label = labels[comparison.cells.label[row]]
        if label.term != MEAN:
            rows.setdefault((label.channel, label.term), []).append(row)
    if not (comparison.cells.valued > 1).any():
        return [f"{used} results of {len(comparison.groups)} {group}s", _nothing(what)]
    channels: dict[str, int] = {}
    for label in labels:
        channels.setdefault(label.channel, len(channels))
    head = ("", "", f"{group}s", "STD %", f"between {what}s %", "repeat", "vary", "outlier")
    cells: list[tuple[str, ...]] = [head]
    listed = sorted(rows, key=lambda key: (channels[key[0]], order.index(key[1])))
    for channel, term in listed[:_MOST_ROWS]:
        term_rows = rows[channel, term]
        counts = Counter(judgements[row] for row in term_rows)
        scale = np.abs(comparison.effects.mean[term_rows]) if term in SIGNED else 1.0
        tau = 100 * float(np.nanmedian(comparison.effects.tau[term_rows] / scale))
        level = comparison.effects.mean[term_rows] if term in SIGNED else np.exp(comparison.effects.mean[term_rows])
        std = 100 * float(np.nanmedian(comparison.cells.std[term_rows] / np.abs(level)))
        cells.append(
            (
                channel,
                term.replace("_", " "),
                str(len(term_rows)),
                two_digits(std),
                two_digits(tau) if tau else "0",
                str(counts["repeatable"] + counts["too_alike"]),
                str(counts["varies"]),
                str(counts["outlier"]),
            )
        )
    lines = [f"{used} results of {len(comparison.groups)} {group}s", *aligned(cells)]
    if len(listed) > _MOST_ROWS:
        lines.append(f"{len(listed) - _MOST_ROWS} more rows: {_CSV}")
    lines.append(f"STD and between {what}s: medians over the {group}s")
    outliers = comparison.outliers() if "outlier" in judgements else {}
    named: dict[str, list[str]] = {}
    for row, run in outliers.items():
        group_name, label = comparison.key(row)
        run_name = run.serial if comparison.by == "run" and run.serial else run.name
        named.setdefault(group_name, []).append(f"{run_name} ({label.channel} {term_name(label)})")
    for name, runs in list(named.items())[:_MOST_NAMED]:
        suffix = f" and {len(runs) - 1} more" if len(runs) > 1 else ""
        lines.append(f"! {name}: {what} {runs[0]}{suffix} does not belong")
    if len(named) > _MOST_NAMED:
        lines.append(f"! {len(named) - _MOST_NAMED} more {group}s have a {what} that does not belong: {_CSV}")
    return wrapped(lines)


def _paper_table(
    comparison: RunComparison, key: tuple[int, str, str], rows: Sequence[int], judgements: Sequence[Judgement]
) -> list[str]:
    group, _, term = key
    rows = in_order(comparison, rows)
    labels = [comparison.key(row)[1] for row in rows]
    unit, size = display_unit(labels[0], [comparison.row(row).mean for row in rows])
    what = COMPARED[comparison.by]
    values = [{id(run): value / size for run, value, _ in comparison.values(row)} for row in rows]
    runs = [run for run in comparison.runs if any(id(run) in by_run for by_run in values)]
    digits = _decimals([value for by_run in values for value in by_run.values()])
    name = " ".join(filter(None, [comparison.groups[group], term_name(labels[0]), f"[{unit}]"]))
    cells = [(what, *(label.channel for label in labels))]
    for run in runs:
        title = run.serial if comparison.by == "run" and run.serial else run.name
        cells.append((title, *(f"{by_run[id(run)]:.{digits}f}" if id(run) in by_run else "-" for by_run in values)))
    effects = [comparison.row(row) for row in rows]
    stds = (None if row.std is None else row.std / size for row in effects)
    cells.append(("STD", *("" if std is None else _std_text(std, digits) for std in stds)))
    if term != MEAN:
        spreads = [spread_texts(label, by_run) for label, by_run in zip(labels, effects, strict=True)]
        cells.append(("STD %", *(by_run[0] for by_run in spreads)))
        cells.append((f"between {what}s %", *(by_run[1] for by_run in spreads)))
        cells.append(("next ± %", *(by_run[2] for by_run in spreads)))
        cells.append(("verdict", *(VERDICTS[judgements[row]] for row in rows)))
        std = comparison.cells.std
        for title, symbol, errors in (
            ("paper: STD < δ", "δ", comparison.cells.delta),
            ("STD < error", "error", comparison.cells.typical),
        ):
            if np.isfinite(errors[rows]).any():
                texts = (_rule_text(float(std[row]), float(errors[row]), f"{symbol} = ", size) for row in rows)
                cells.append((title, *texts))
    return [name, *aligned(cells)]


def _std_text(std: float, digits: int) -> str:
    """A standard deviation with the decimals of its values, or with two digits if those show fewer."""
    return f"{std:.{digits}f}" if std >= 10.0 ** (1 - digits) else significant(std, 2, zeros=True)


def _rule_text(std: float, error: float, symbol: str, size: float) -> str:
    """Whether a standard deviation is below the error δ: ``"yes, δ = 0.074"``."""
    if not (np.isfinite(std) and np.isfinite(error)):
        return ""
    return f"{'yes' if std < error else 'no'}, {symbol}{significant(error / size, 2, zeros=True)}"


def _decimals(values: Sequence[float]) -> int:
    """Decimals that show four digits of the typical value."""
    middle = float(np.median(np.abs(values)))
    return 3 if middle == 0 else int(np.clip(3 - np.floor(np.log10(middle)), 0, 12))
