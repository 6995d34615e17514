"""Summary of one unit of a lot: only the parts of a result of `analyze` that comparisons need, so that the summaries of
thousands of units fit in memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from sigmatau import Analysis, Finding
from sigmatau.analysis import FailedAnalysis
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.fitting import FittedTerm
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.verdict import Verdict
from sigmatau.lab.lots.conditions import run_supply, run_temperature
from sigmatau.lab.lots.dates import day_of_log
from sigmatau.quality import reason_without_fits


@frozen
class UnitCoefficient:
    """A coefficient, or the standard deviation of means, in SI; of a ramp, its absolute value.

    Attributes
    ----------
    value : float or None
        None if it was not observed. [SI]
    low, high : float or None
        Its interval; None without one. [SI]
    limit : float or None
        Upper limit if it was not observed. [SI]
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    limit: float | None = None


@frozen(eq=False)
class UnitChannel:
    """One channel of a unit.

    Attributes
    ----------
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    unit : str
        SI unit of the rate.
    rate : float
        Sampling rate. [Hz]
    samples : int
        Samples in the record.
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    adev : ndarray, shape (n_tau,)
        Allan deviation. [unit]
    coefficients : mapping of str to UnitCoefficient
        Coefficients by term, and by ``"means_10"`` and ``"means_100"``.
    trust : str
        ``"good"``, ``"partial"`` or ``"poor"``; empty if not known.
    mean : float or None
        Mean of the samples. [unit]
    """

    quantity: str
    unit: str
    rate: float
    samples: int
    tau: Floats
    adev: Floats
    coefficients: Mapping[str, UnitCoefficient]
    trust: str = ""
    mean: float | None = None

    @property
    def duration(self) -> float:
        """Length of the record. [s]"""
        return self.samples / self.rate


@frozen(eq=False)
class UnitResult:
    """The result of one unit, or why it has no result.

    Attributes
    ----------
    path : str
        File of the result; empty if it came from memory.
    sha256 : str
        Checksum of the log; empty if not known.
    day : str
        Day of the record, ``"2026-05-07"``, from its notes or the name of its log; empty if not known.
    channels : mapping of str to UnitChannel
        By name.
    findings : tuple of Finding
        Findings of the analysis.
    rest : str
        Verdict about rest, as in `Analysis.rest`; empty if not known.
    reason : str
        Why the result has no coefficients: the unit was not at rest, or the record is too short; otherwise empty.
    error : str
        Why the unit has no result, without the name of the file; empty if it has a result.
    absent : bool
        Whether there is no file at all.
    verdict : Verdict or None
        Comparison with the specification; None without a result or a specification.
    temperature : float or None
        Temperature in the notes, otherwise the mean of the thermometer of the log. [degC]
    supply : float or None
        Supply voltage in the notes, otherwise that of a channel of the log, or in its name. [V]
    """

    path: str = ""
    sha256: str = ""
    day: str = ""
    channels: Mapping[str, UnitChannel] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    rest: str = ""
    reason: str = ""
    error: str = ""
    absent: bool = False
    verdict: Verdict | None = None
    temperature: float | None = None
    supply: float | None = None


def without_result(error: str, *, path: str = "", absent: bool = False) -> UnitResult:
    """A unit whose log or result cannot be read."""
    return UnitResult(error=error, path=path, absent=absent)


def summarize_unit(result: Analysis | FailedAnalysis) -> UnitResult:
    """Summarise a result for a lot."""
    if isinstance(result, FailedAnalysis):
        return without_result(result.reason, path=result.path)
    if not result.curves:
        raise DataError("not a result of sigmatau analyze: it has no channels")
    return UnitResult(
        path=result.source.path or "",
        sha256=result.source.sha256 or "",
        day=day_of_log(result.notes, result.source.path or ""),
        channels={name: _channel(result, name) for name in result.curves},
        findings=result.findings,
        rest="" if result.rest is None else result.rest.verdict,
        reason="" if result.fits else reason_without_fits(result.rest),
        temperature=run_temperature(result),
        supply=run_supply(result),
    )


def _channel(result: Analysis, name: str) -> UnitChannel:
    curve, fit = result.curves[name], result.fits.get(name)
    terms = {} if fit is None else fit.terms
    coefficients = {term: _coefficient(fitted) for term, fitted in terms.items()}
    for row in result.mean_stability.get(name, ()):
        coefficients[f"means_{row.average:.3g}"] = UnitCoefficient(value=row.value, low=row.low, high=row.high)
    return UnitChannel(
        quantity=curve.quantity,
        unit=curve.unit,
        rate=1 / curve.tau0,
        samples=curve.n,
        tau=curve.tau,
        adev=curve.adev,
        coefficients=coefficients,
        trust="" if fit is None or fit.trust is None else fit.trust,
        mean=None if name not in result.means else result.means[name].value,
    )


def _coefficient(term: FittedTerm) -> UnitCoefficient:
    value, low, high = (None if number is None else abs(number) for number in (term.value, term.low, term.high))
    if low is not None and high is not None:
        contains_zero = (term.low or 0.0) < 0 < (term.high or 0.0)
        low, high = 0.0 if contains_zero else min(low, high), max(low, high)
    return UnitCoefficient(value=value, low=low, high=high, limit=term.upper_limit)
