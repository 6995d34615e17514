"""The certificate: page 1 of a report, which a laboratory signs. Its facts are in a TOML file, see `certificate_file`."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.reporting.certificate_file import FIELDS, TEST, CertificateFile
from sigmatau.reporting.logo import Logo
from sigmatau.results import printable

if TYPE_CHECKING:
    from sigmatau.analysis import Analysis

_MOST_DAYS = 1  # largest difference between the date of the file and that of the log: time zones [d]


@frozen
class LimitRow:
    """One judged maximum, in words.

    Attributes
    ----------
    axis, what, measured, maximum, outcome, consumer, producer : str
        Channel; specified value; measured value with its interval; maximum; outcome; risks in per cent.
    """

    axis: str
    what: str
    measured: str
    maximum: str
    outcome: str
    consumer: str
    producer: str


@frozen
class Certificate:
    """The first page of a report, in words.

    Attributes
    ----------
    title : str
        ``"Test report"`` or ``"Calibration certificate"``.
    number : str
        Of the report; every page has it.
    item : str
        Model and serial number of the instrument.
    laboratory : tuple of str
        Name, address and accreditation.
    logo : Logo or None
    facts : tuple of (str, tuple of (str, str))
        Groups of names and texts: customer, instrument, measurement, method.
    statements : tuple of (str, str)
        Headings and paragraphs: results, uncertainty, decision rule, remarks.
    limits : tuple of LimitRow
        Judged maxima.
    signatures : tuple of (str, str)
        Roles and names.
    """

    title: str
    number: str
    item: str
    laboratory: tuple[str, ...]
    logo: Logo | None
    facts: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    statements: tuple[tuple[str, str], ...]
    limits: tuple[LimitRow, ...] = ()
    signatures: tuple[tuple[str, str], ...] = ()


def fill_certificate(
    file: CertificateFile,
    analysis: Analysis,
    *,
    issued: str,
    named: str = "",
    decision: Sequence[tuple[str, str]] = (),
    limits: Sequence[LimitRow] = (),
) -> Certificate:
    """The first page of the report of an analysis. Date and temperature come from the file, or else from the log; the
    date at last from the name of the log.

    Parameters
    ----------
    file : CertificateFile
    analysis : Analysis
    issued : str
        Date of the report, if the file states none.
    named : str
        Day in the name of the log, for a log without dates.
    decision : sequence of (str, str)
        Headings and paragraphs about the decision rule.
    limits : sequence of LimitRow

    Returns
    -------
    Certificate

    Raises
    ------
    DataError
        If neither the file nor the log states the date or the temperature, or if their dates contradict each other.
    """
    check_stated(file, analysis.source.started, named, has_thermometer=analysis.source.temperature is not None)
    measured, temperature = _date(file, analysis, named), _temperature(file, analysis)
    kind = (file.text("report", "kind") or TEST).lower()
    laboratory = [file.text("laboratory", name) for name in ("name", "address", "accreditation")]
    record = [("Measured", measured), *_listed(file, "measurement", ("place",)), ("Temperature", temperature)]
    record += _listed(file, "measurement", ("humidity", "pressure", "supply", "mounting"))
    issue = file.text("report", "issued") or issued[:10]
    source = analysis.source
    return Certificate(
        title=kind[0].upper() + kind[1:],
        number=file.text("report", "number"),
        item=f"{file.text('instrument', 'model')} {file.text('instrument', 'serial')}",
        laboratory=tuple(filter(None, laboratory)),
        logo=file.logo,
        facts=(
            ("Customer", tuple(_listed(file, "customer"))),
            ("Instrument", tuple(_listed(file, "instrument"))),
            ("Measurement", tuple(record)),
            (
                "Method",
                (
                    *_listed(file, "method", ("standard", "description", "deviations", "traceability")),
                    ("Software", f"sigmatau {analysis.version or __version__}"),
                    ("Log", printable(source.path or "in memory")),
                    ("SHA-256", source.sha256 or "not known"),
                    ("Issued", issue),
                ),
            ),
        ),
        statements=(
            *decision,
            ("Uncertainty", _uncertainty(file, analysis)),
            ("Scope", _SCOPE),
            *((("Remarks", file.text("report", "remarks")),) if file.text("report", "remarks") else ()),
        ),
        limits=tuple(limits),
        signatures=(
            ("Measured by", file.text("report", "operator")),
            ("Reviewed and authorised by", file.text("report", "reviewer")),
        ),
    )


_SCOPE = (
    "The results relate only to the instrument named above, as it was received, and to the conditions of the measurement."
    " This report may be reproduced only in full."
)


def _listed(file: CertificateFile, table: str, names: Sequence[str] | None = None) -> list[tuple[str, str]]:
    """Labels and texts of the keys of a table that have one."""
    keys = FIELDS[table] if names is None else names
    return [(FIELDS[table][name].label, file.text(table, name)) for name in keys if file.text(table, name)]


def check_stated(file: CertificateFile, started: str | None, named: str, *, has_thermometer: bool) -> None:
    """Raise `DataError` unless the file or the log states date and temperature, and the dates agree.

    Parameters
    ----------
    file : CertificateFile
    started : str or None
        Time of the first sample by the log, as in ISO 8601.
    named : str
        Day in the name of the log; empty without one.
    has_thermometer : bool
        Whether the log has a temperature.

    Raises
    ------
    DataError
    """
    stated = file.text("measurement", "date")
    if not (stated or started or named):
        raise DataError("lacks measurement.date, and the log has no date; add it").about(str(file.path))
    if stated and started is not None:
        days = abs((date.fromisoformat(stated[:10]) - date.fromisoformat(started[:10])).days)
        if days > _MOST_DAYS:
            raise DataError(
                f"measurement.date {stated[:10]} is not that of the log, {started[:10]}; correct it, or leave it out"
            ).about(str(file.path))
    issued, day = file.text("report", "issued")[:10], stated or (started or "")[:10]
    if issued and day and (date.fromisoformat(day[:10]) - date.fromisoformat(issued)).days > _MOST_DAYS:
        raise DataError(f"report.issued, {issued}, is before the date of the log, {day[:10]}; correct it").about(
            str(file.path)
        )
    if not file.text("measurement", "temperature") and not has_thermometer:
        raise DataError("lacks measurement.temperature, and the log has no thermometer; add it").about(str(file.path))


def _date(file: CertificateFile, analysis: Analysis, named: str) -> str:
    stated, started = file.text("measurement", "date"), analysis.source.started
    by_log = "" if started is None else f"{started[:10]} {started[11:16]}"
    if not stated:
        return f"{by_log} (by the log)" if by_log else f"{named} (by the name of the log)"
    return f"{stated} (log: {by_log})" if by_log else stated


def _temperature(file: CertificateFile, analysis: Analysis) -> str:
    stated, measured = file.text("measurement", "temperature"), analysis.source.temperature
    sensor = "" if measured is None else f"{measured.mean:.1f} °C, {measured.low:.1f} to {measured.high:.1f} °C"
    if not stated:
        return f"{sensor} (sensor, by the log)"
    return f"{stated}; sensor {sensor}" if sensor else stated


def _uncertainty(file: CertificateFile, analysis: Analysis) -> str:
    from statistics import NormalDist

    if not analysis.fits:
        raise DataError("no coefficient was fitted: nothing to certify; write the report without a certificate")
    levels = {fit.level for fit in analysis.fits.values()}
    if len(levels) > 1:
        raise OptionError("{option}: the intervals have several levels; analyse with one", option="certificate")
    level = levels.pop()
    k = NormalDist().inv_cdf((1 + level) / 2)
    extra = file.text("method", "not_included")
    return (
        f"± and [low, high] are expanded uncertainties: they contain the true value with a probability of {100 * level:g} %"
        f" (coverage factor k = {k:.2f} where an interval is symmetric). They are the likelihood intervals of the fitted"
        " noise model. Included: the random error of a record of this length, the choice of the terms, and what the model"
        " cannot distinguish. Not included: the scale factor of the instrument, the reference of its clock (sampling rate),"
        " other temperatures, supplies and mountings, and changes from turn-on to turn-on or after the measurement"
        + (f"; {extra}." if extra else ".")
    )
