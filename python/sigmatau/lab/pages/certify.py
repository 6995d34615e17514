"""`certify`: the first page of a report that a laboratory signs, with decisions by a named rule and their risks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast, get_args

from sigmatau import Analysis, Record
from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.errors import DataError, OptionError
from sigmatau.lab.datasheets.compare import compare_with
from sigmatau.lab.datasheets.decision import RULE_WORDS, LimitDecision, Outcome, Rule, decisions
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.lab.lots.dates import day_of_log
from sigmatau.reporting.certificate import Certificate, LimitRow, check_stated, fill_certificate
from sigmatau.reporting.certificate_file import CertificateFile, read_certificate
from sigmatau.results import printable

_MOST_LIMITS = 24  # largest number of limits on the first page
_NEGLIGIBLE = 1e-4  # risk below which only this bound is printed [1]


def certify(
    analysis: Analysis, certificate: str | Path | CertificateFile, *, date: datetime | None = None
) -> Certificate:
    """The first page of a report as in ISO/IEC 17025: laboratory, item, date, method, uncertainty and decision rule.

    Parameters
    ----------
    analysis : Analysis
        A result with fits.
    certificate : str, Path or CertificateFile
        A TOML file with the facts that no log states; docs/how-to/certificate.md has an example with all keys.
    date : datetime, optional
        Date of issue, if the file states none. Default: now.

    Returns
    -------
    Certificate
        Argument `certificate` of `sigmatau.report`.

    Raises
    ------
    DataError
        If the file lacks a key, has an unknown key or an invalid value, or contradicts the date of the log; or if the result
        has no fits.

    See Also
    --------
    report : writes it as page 1.
    compare_with : the comparison with the specification.

    References
    ----------
    ISO/IEC 17025:2017, 7.8; ISO 14253-1:2017; JCGM 106:2012.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> analysis = st.analyze(st.simulate(model, duration=600, rate=100, rng=1))
    >>> page = st.certify(analysis, "lab.toml")  # doctest: +SKIP
    >>> st.report(analysis, "certificate.pdf", certificate=page)  # doctest: +SKIP
    """
    file = certificate if isinstance(certificate, CertificateFile) else read_certificate(certificate)
    moment = datetime.now(tz=UTC) if date is None else date
    decision: list[tuple[str, str]] = []
    limits: list[LimitRow] = []
    basis = read_decision(file)
    if basis is not None:
        rule, sheet = basis
        conventions: dict[str, Any] = {name: file.text("decision", name).lower() or None for name in ("sided", "bias")}
        verdict = compare_with(analysis, sheet, factor=file.factor, **conventions)
        made = decisions(verdict, rule)
        if not made:
            raise DataError(f"{sheet.name} has no maximum of a measured value; state one, or decision.factor").about(
                str(file.path)
            )
        decision.append(("Statement of conformity", _conformity(made, verdict.missing, sheet.name)))
        decision.append(("Decision rule", f"{RULE_WORDS[rule]} {_RISKS}"))
        limits = [_row(each) for each in sorted(made, key=_badness)][:_MOST_LIMITS]
        if len(made) > _MOST_LIMITS:
            decision.append(
                ("Limits", f"{len(made) - _MOST_LIMITS} more limits are not listed; the listed ones are the worst.")
            )
    named = day_of_log({}, analysis.source.path or "")
    return fill_certificate(file, analysis, issued=f"{moment:%Y-%m-%d}", named=named, decision=decision, limits=limits)


_RISKS = (
    "Consumer's risk: probability that the true value is above the maximum if it is accepted; producer's risk: that it is"
    " not above if it is rejected (JCGM 106:2012, specific risks, flat prior)."
)


def check_certificate(file: CertificateFile, record: Record | None = None) -> None:
    """Raise the errors of a certificate that need no result, before a long analysis.

    Parameters
    ----------
    file : CertificateFile
    record : Record, optional
        The log. Default: only the file is checked.

    Raises
    ------
    DataError
        For an unknown rule or specification, or a specification without a maximum; if date or temperature are stated neither
        by the file nor by the log, or contradict it.
    """
    basis = read_decision(file)
    if basis is not None and file.factor is None and all(claim.maximum is None for claim in basis[1].claims):
        raise DataError(f"{basis[1].name} states no maximum; state one, or decision.factor").about(str(file.path))
    if record is not None:
        has_thermometer = any(stream.quantity == "temperature" for stream in record.streams)
        named = day_of_log({}, record.provenance.path or "")
        check_stated(file, record.provenance.started, named, has_thermometer=has_thermometer)


def read_decision(file: CertificateFile) -> tuple[Rule, Datasheet] | None:
    """The decision rule and the specification; None for a certificate without a decision.

    Raises `DataError` for an unknown rule, or a specification that cannot be read.
    """
    return (_rule(file), _specification(file)) if "decision" in file.texts else None


def _rule(file: CertificateFile) -> Rule:
    text = file.text("decision", "rule").lower().replace("-", " ")
    if text not in get_args(Rule):
        listed = " or ".join(repr(rule) for rule in get_args(Rule))
        raise DataError(f"decision.rule {text!r:.40} must be {listed}").about(str(file.path))
    return cast(Rule, text)


def _specification(file: CertificateFile) -> Datasheet:
    """Find the specification: a file in the folder of the certificate, or a name of the library."""
    text = file.text("decision", "specification")
    is_file = file.specification in file.files
    unknown = DataError(
        f"decision.specification {text!r:.40} is neither a file beside it nor in 'sigmatau datasheet list'"
    ).about(str(file.path))
    if not is_file and text.lower().endswith(".toml"):
        raise unknown
    try:
        return find_datasheet(file.specification if is_file else text)
    except OptionError:  # the name is in a file, not in an option
        raise unknown from None


def _badness(decision: LimitDecision) -> tuple[int, float]:
    order = {"does not conform": 0, "not decided": 1, "conforms": 2}
    return order[decision.outcome], -(decision.consumer_risk or 0.0)


def _conformity(made: Sequence[LimitDecision], missing: Sequence[str], name: str) -> str:
    """The statement of conformity: all values conform, or the numbers of those that do not."""
    counts = Counter(each.outcome for each in made)
    lacking = f" Not measured, and not decided: {', '.join(map(printable, missing))}." if missing else ""
    if counts["conforms"] == len(made):
        return f"All {len(made)} judged values conform to {name}.{lacking}"
    words: dict[Outcome, tuple[str, str]] = {
        "does not conform": ("does not conform", "do not conform"),
        "not decided": ("is not decided", "are not decided"),
        "conforms": ("conforms", "conform"),
    }
    parts = [f"{counts[key]} {verbs[counts[key] > 1]}" for key, verbs in words.items() if counts[key]]
    return f"Of {len(made)} judged values against {name}: {', '.join(parts)}.{lacking}"


def _row(decision: LimitDecision) -> LimitRow:
    risk = decision.consumer_risk
    if decision.value is None:
        measured = "not measured" if decision.high is None else f"{limit_text(decision.high)} {decision.unit}"
    else:
        measured = round_to_error(decision.value, decision.low, decision.high).with_unit(decision.unit)
    accepted, rejected = decision.outcome == "conforms", decision.outcome == "does not conform"
    return LimitRow(
        axis=decision.channel,
        what=decision.what,
        measured=measured,
        maximum=f"{decision.maximum:.4g} {decision.unit}",
        outcome=decision.outcome,
        consumer="–" if risk is None or rejected else _percent(risk, at_most=decision.at_most),
        producer="–" if risk is None or accepted else _percent(1 - risk),
    )


def _percent(probability: float, *, at_most: bool = False) -> str:
    if probability < _NEGLIGIBLE:
        return f"< {100 * _NEGLIGIBLE:g} %"
    if probability > 1 - _NEGLIGIBLE:
        return f"> {100 * (1 - _NEGLIGIBLE):g} %"
    return f"{'≤ ' if at_most else ''}{two_digits(100 * probability)} %"
