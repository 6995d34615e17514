"""`judge_lot`: compares the units of a lot with a specification and with each other. Every unit gets exactly one state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from sigmatau import Analysis
from sigmatau.analysis import FailedAnalysis, as_result
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.datasheets.claims import Bias, Sided
from sigmatau.lab.datasheets.compare import check_options, compare_with
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.lab.lots.expected import match_expected
from sigmatau.lab.lots.lot_conditions import comparable_units
from sigmatau.lab.lots.lot_findings import CODES, Missing, NoSpecification, NotExpected, OtherScale, Unreadable
from sigmatau.lab.lots.lot_judging import remarks_on_findings, remarks_on_verdict
from sigmatau.lab.lots.lot_others import compare_units
from sigmatau.lab.lots.lot_remark import Remark, State, remark
from sigmatau.lab.lots.lot_result import JudgedUnit, JudgingOptions, Lot
from sigmatau.lab.lots.lot_series import collect_distributions
from sigmatau.lab.lots.lot_unit import UnitResult, summarize_unit, without_result

Undecided = Literal["not-judged", "pass", "fail"]
FailOn = Literal["warning"]
Result: TypeAlias = "Analysis | FailedAnalysis | Mapping[str, Any] | str | Path | Exception"

# codes of remarks that explain all others of a unit
_CAUSES = ("not_at_rest", "too_short_to_tell", "other_scale", "orientation", "implausible_unit")
# codes of remarks whose effect the option `undecided` sets
_UNDECIDED = ("undecided", "not_measured", "no_model")


def examine(
    result: Result,
    sheet: Datasheet | None,
    *,
    name: str = "unit",
    level: float = 0.95,
    factor: float | None = None,
    sided: Sided | None = None,
    bias: Bias | None = None,
) -> UnitResult:
    """Examine one unit, for `judge_lot`. An error, passed or raised, becomes the reason why the unit has no result."""
    if isinstance(result, Exception):
        return without_result(str(result))
    path = str(result) if isinstance(result, str | Path) else ""
    try:
        analysis = as_result(result)
        unit = summarize_unit(analysis)
        if path and not unit.path:
            unit = replace(unit, path=path)
        if isinstance(analysis, FailedAnalysis) or unit.reason or sheet is None:
            return unit
        verdict = compare_with(analysis, sheet, unit=name, level=level, factor=factor, sided=sided, bias=bias)
    except DataError as error:
        absent = bool(path) and not Path(path).exists()
        return without_result(error.without(path), path=path, absent=absent)
    return replace(unit, verdict=verdict)


def judge_lot(
    results: Mapping[str, Result | UnitResult] | Sequence[Result],
    spec: Datasheet | str | Path | None = None,
    *,
    expect: int | Sequence[str] | None = None,
    level: float = 0.95,
    factor: float | None = None,
    sided: Sided | None = None,
    bias: Bias | None = None,
    undecided: Undecided = "not-judged",
    fail_on: FailOn | None = None,
    accept: Sequence[str] = (),
) -> Lot:
    """Judge a lot of units against a specification, and find outlying units.

    Each unit is passed, failed, not judged, failed to read, or missing. A unit passes if every value of the specification
    has a maximum and the interval of the measured value lies below it, and if neither a warning about its record nor the
    comparison with the other units casts doubt on it.

    Parameters
    ----------
    results : mapping of str to result, or sequence of results
        By the name of the unit, in the order of production: an `Analysis`, its JSON form, the path of its JSON file, or the
        exception that prevented it. A sequence is named by its files, or by numbers.
    spec : Datasheet, str or Path, optional
        A name of the library or the path of a file; see `sigmatau.datasheet`. Without it the units are described, and
        compared with each other.
    expect : int or sequence of str, optional
        Expected number of units, or their names; absent units are missing. A name also matches a serial number inside the
        name of a unit, ``"SN7"`` in ``"SN7_2026-05-04.csv"``.
    level : float
        Confidence level of "above" and "below" a maximum, see `sigmatau.compare_with`.
    factor : float, optional
        Factor from the typical (or 1 σ) value to the maximum, where the specification states no maximum. Default: such a
        value is not judged.
    sided : {"one", "two"}, optional
        Convention of noise densities if the specification does not state it.
    bias : {"minimum", "coefficient"}, optional
        Convention of bias instabilities if not stated.
    undecided : {"not-judged", "pass", "fail"}
        State of a unit whose interval contains a maximum, or that lacks an axis or a model.
    fail_on : {"warning"}, optional
        Whether a warning about the record, or an implausible value, fails a unit. Default: the unit is not judged.
    accept : sequence of str
        Codes of findings and remarks that do not keep a unit from passing, such as ``"spectral_line"``.

    Returns
    -------
    Lot

    Raises
    ------
    OptionError
        For an invalid option, or if there are no results and none are expected.
    DataError
        If the file of the specification cannot be read.

    See Also
    --------
    compare_with : one unit against a datasheet, in full.

    References
    ----------
    ISO 14253-1:2017, section 5; JCGM 106:2012, section 8.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> records = [st.simulate(model, duration=600, rate=10, rng=k) for k in range(3)]
    >>> lot = st.judge_lot({f"unit {k}": st.analyze(record) for k, record in enumerate(records, 1)}, expect=4)
    >>> lot.counts
    {'failed': 0, 'not_judged': 3, 'unreadable': 0, 'missing': 1, 'passed': 0}
    >>> lot.exit_code
    4
    """
    check_choices(undecided, fail_on, accept)
    check_options(level=level, factor=factor, sided=sided, bias=bias)
    sheet = spec if isinstance(spec, Datasheet) or spec is None else find_datasheet(spec)
    options: dict[str, Any] = {"level": level, "factor": factor, "sided": sided, "bias": bias}
    named = _named(results)
    examined = {
        name: result if isinstance(result, UnitResult) else examine(result, sheet, name=name, **options)
        for name, result in named.items()
    }
    expected = match_expected(examined, expect)
    if not examined and not expected.absent:
        raise OptionError("{option}: no units; give results or the number of units to expect", option="results")
    remarks: dict[str, list[Remark]] = {name: [] for name in examined}
    compared = comparable_units(examined, remarks)
    distributions = collect_distributions(compared)
    compare_units(examined, compared, distributions, remarks, judged=sheet is not None)
    settings = JudgingOptions(undecided=undecided, fail_on=fail_on, accept=tuple(accept), **options)
    units = [
        _judged(
            name,
            unit,
            remarks.get(name, ()),
            settings,
            with_spec=sheet is not None,
            expected=name in expected.listed,
        )
        for name, unit in examined.items()
    ]
    missing = [
        JudgedUnit(
            name=name,
            state="missing",
            remarks=(remark(Missing(), "data"),),
            result=UnitResult(absent=True),
        )
        for name in expected.absent
    ]
    return Lot(
        spec=sheet,
        units=(*units, *missing),
        distributions=distributions.values,
        sensors=(*distributions.sensors, *distributions.slow),
        bands=distributions.bands,
        expected=None if expect is None else expect if isinstance(expect, int) else len(expect),
        too_many=expected.surplus,
        settings=settings,
    )


def check_choices(undecided: object, fail_on: object, accept: object) -> None:
    """Raise `OptionError` for invalid choices."""
    if undecided not in get_args(Undecided):
        raise OptionError(
            f"{{option}} must be one of {', '.join(get_args(Undecided))}, not {undecided!r}", option="undecided"
        )
    if fail_on not in (None, *get_args(FailOn)):
        raise OptionError(f"{{option}} must be warning, not {fail_on!r}", option="fail_on")
    if isinstance(accept, str) or not isinstance(accept, Sequence):
        raise OptionError("{option} must be a list of codes", option="accept")
    codes = {*CODES, *_finding_codes()} - {"above_maximum", "unreadable", "missing", "no_specification", "no_maximum"}
    for code in accept:
        if code not in codes:
            raise OptionError(
                f"{{option}}: unknown code {code!r}; codes are those of docs/findings.md, and"
                f" {', '.join(sorted(codes & {*CODES}))}",
                option="accept",
            )


def _finding_codes() -> set[str]:
    from sigmatau.findings import details_by_code

    return set(details_by_code())


def _named(results: Mapping[str, Result | UnitResult] | Sequence[Result]) -> dict[str, Result | UnitResult]:
    """Results by the name of their unit."""
    if isinstance(results, Mapping):
        return {str(name): result for name, result in results.items()}
    if isinstance(results, str | Path | Analysis):
        raise OptionError("{option} must be a sequence of results, or a mapping by name", option="results")
    names = []
    for k, result in enumerate(results, 1):
        if isinstance(result, str | Path):
            names.append(Path(result).name.removesuffix(".json"))
            continue
        source = result.source.path if isinstance(result, Analysis) else None
        if isinstance(result, Mapping) and isinstance(result.get("source"), Mapping):
            source = result["source"].get("path")
        names.append(Path(source).name if source else f"unit {k}")
    repeated = {name for name in names if names.count(name) > 1}
    unique = [f"{name} ({k})" if name in repeated else name for k, name in enumerate(names, 1)]
    return dict(zip(unique, results, strict=True))


def _judged(
    name: str,
    result: UnitResult,
    comparison: Sequence[Remark],
    settings: JudgingOptions,
    *,
    with_spec: bool,
    expected: bool,
) -> JudgedUnit:
    if result.error:
        state: State = "missing" if result.absent else "unreadable"
        details = Missing() if result.absent else Unreadable(reason=result.error)
        return JudgedUnit(name=name, state=state, remarks=(remark(details, "data"),), result=result)
    remarks = [] if result.verdict is None else remarks_on_verdict(result.verdict)
    remarks += [*comparison, *remarks_on_findings(result)]
    if not expected:
        remarks.append(remark(NotExpected(), "data"))
    remarks = [_accepted(remark_, settings) for remark_ in remarks]
    if not with_spec:
        remarks.append(remark(NoSpecification(), "note"))
    state = _state(remarks, settings, with_spec=with_spec)
    order = {"limit": 1, "lot": 2, "data": 3, "judging": 4, "note": 5}
    remarks.sort(key=lambda remark_: 0 if _is_cause(remark_) else order[remark_.kind])
    return JudgedUnit(name=name, state=state, remarks=tuple(remarks), result=result)


def _is_cause(remark_: Remark) -> bool:
    """Whether a remark explains all others: motion, exchanged axes, a mistaken unit, or a wrong scale."""
    details = remark_.details
    if isinstance(details, OtherScale) and details.likely is None and details.gravity is None:
        return False  # all curves are high or low, and no mistake explains it: a bad unit
    return remark_.code in _CAUSES and remark_.kind != "note"


def _state(remarks: Sequence[Remark], settings: JudgingOptions, *, with_spec: bool) -> State:
    """The state of a unit with a result."""
    doubts = [remark_ for remark_ in remarks if remark_.kind in ("judging", "data", "lot")]
    warned = settings.fail_on == "warning" and any(remark_.kind != "judging" for remark_ in doubts)
    fails_undecided = settings.undecided == "fail" and any(remark_.code in _UNDECIDED for remark_ in doubts)
    if warned or fails_undecided or any(remark_.kind == "limit" for remark_ in remarks):
        return "failed"
    return "not_judged" if doubts or not with_spec else "passed"


def _accepted(remark_: Remark, settings: JudgingOptions) -> Remark:
    """Turn a remark that the options accept into a note."""
    passes = settings.undecided == "pass" and remark_.code in _UNDECIDED
    return (
        replace(remark_, kind="note")
        if remark_.kind != "limit" and (remark_.code in settings.accept or passes)
        else remark_
    )
