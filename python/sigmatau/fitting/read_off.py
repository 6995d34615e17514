"""Coefficients read off the curve by the slope method of the paper, with explicit rules.

Where a region of the log-log curve has the slope of a noise term, a line of that slope is fitted to it and read at the
term's averaging time; the error is the paper's eq. (26) at the longest averaging time of the region. The method makes the
reading of a plot by eye repeatable. It is biased where two terms meet, and its errors are those of the paper, not standard
errors: ``docs/theory/read-off.md`` quantifies both.

References
----------
.. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
   IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`, Section IV.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.gls import non_negative
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off_lines import Span, lay, points_in, span_of, thinned
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, Term, avar, coefficient_unit, display_units
from sigmatau.results import Printed, Tabular, plain, seconds, value_error_text
from sigmatau.units import find

LARGEST_ERROR = 0.35
"""Largest error by eq. (26) of the averaging times that are used: those up to a fifth of the record."""


@frozen
class Rule:
    """Conditions for a region of a term."""

    tolerance: float = 0.1  # Largest difference of its slope from that of the term
    slope_error: float = 0.1  # Largest standard error of its slope by eq. (26).
    span: float = 4.0  # Smallest ratio of its longest to its shortest averaging time


# From Monte Carlo: in each of 20 cases an absent term is reported in at most 5 % of the records (studies/read_off.py,
# results in docs/study/read-off.md). The rule of the plateau is stricter, because the valley between a random walk and a
# rate random walk looks like one; those of the rising terms are looser, because few other effects rise.
RULES: Mapping[str, Rule] = {
    "quantization": Rule(),
    "random_walk": Rule(),
    "bias_instability": Rule(tolerance=0.06, slope_error=0.06),
    "rate_random_walk": Rule(tolerance=0.15),
    "rate_ramp": Rule(slope_error=0.2),
}

# A bend below the line of more than 0.1 in log σ cannot come from the five terms, whose sum is convex in the log-log plot.
_BEND = 0.1
_SIGMAS = 2.5  # errors by eq. (26) that a point may deviate in addition
_SMALLEST_ERROR = 0.02  # relative error of a deviation in the comparison with the other terms

GAIN = 6.0  # Smallest reduction of the misfit by the term of a region, in squared errors by δ (at least 2 %) per octave


@frozen
class Coefficient:
    """One coefficient, read off."""

    term: str  # Key of `sigmatau.noise.terms.TERMS`
    value: float  # Coefficient and its error by eq. (26), one standard error. [unit]
    error: float
    unit: str  # SI
    tau_min: float  # The region. [s]
    tau_max: float
    slope: float | None  # Slope of the curve in the region; None if a given range has one point
    percentage: float  # error / value
    given: bool = False  # Whether the range was given, not found by the rules

    @property
    def region(self) -> str:
        """Where the line was laid, in words: ``"τ 1 … 10 s, given"``."""
        return f"τ {seconds(self.tau_min)} … {seconds(self.tau_max)} s{', given' if self.given else ''}"

    def to(self, unit: str) -> float:
        """The value in another unit: ``c.to("deg/sqrt(h)")``; raises `OptionError` for a unit that does not fit."""
        return self.value / find(unit, si=self.unit).factor

    def to_dict(self) -> dict[str, Any]:
        return plain(self, "value error unit slope given", tau_s=[self.tau_min, self.tau_max])


@frozen
class Refusal:
    """A region that has the slope of a term but is not that term."""

    term: str
    tau_min: float
    tau_max: float
    reason: str


@frozen(kw_only=False)
class ReadOff(Mapping[str, Coefficient], Tabular):
    """Coefficients read off one channel: a mapping from term to `Coefficient`, without terms that have no region."""

    channel: str
    quantity: str
    rate_unit: str
    coefficients: Mapping[str, Coefficient]
    refused: tuple[Refusal, ...] = ()

    def __getitem__(self, term: str) -> Coefficient:
        try:
            return self.coefficients[term]
        except KeyError:
            found = ", ".join(self.coefficients) or "none"
            raise KeyError(f"no coefficient {term!r} was read off {self.channel}; read: {found}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.coefficients)

    def __len__(self) -> int:
        return len(self.coefficients)

    def texts(self, term: str) -> list[tuple[str, str]]:
        """A coefficient in each of the field's units: ``[("0.973 ± 0.074", "arcsec")]``."""
        c = self[term]
        return [
            (value_error_text(c.value / factor, c.error / factor), text)
            for text, factor in display_units(term, self.quantity, self.rate_unit)
        ]

    def columns(self) -> dict[str, list[Any]]:
        """A row a coefficient, see `Tabular.columns`."""
        every = list(self.coefficients.values())
        rows = {name: [getattr(one, name) for one in every] for name in ("term", "value", "error", "unit")}
        return {"channel": [self.channel] * len(every), **rows}

    _repr_html_ = Printed._repr_html_  # in the field's units

    def to_dict(self) -> dict[str, Any]:
        return {term: c.to_dict() for term, c in self.coefficients.items()}

    def __repr__(self) -> str:
        lines = [f"{self.channel}: read off" + ("" if self.coefficients else ", no term has a region")]
        for term, c in self.coefficients.items():
            texts = " = ".join(f"{value} {unit}" for value, unit in self.texts(term))
            lines.append(f"  {TERMS[term].label(self.quantity):24} {texts}   ({c.region})")
        lines += [
            f"  not {TERMS[r.term].label(self.quantity)} (τ {seconds(r.tau_min)} … {seconds(r.tau_max)} s): {r.reason}"
            for r in self.refused
        ]
        return "\n".join(lines)


_FEW_MISSING = 0.01  # share of missing samples that makes a random walk read 0.5 % larger, and quantization noise 5 %


def read_off(
    curve: DeviationCurve,
    *,
    quantization: Span | None = None,
    random_walk: Span | None = None,
    bias_instability: Span | None = None,
    rate_random_walk: Span | None = None,
    rate_ramp: Span | None = None,
    rules: Mapping[str, Rule] = RULES,
) -> ReadOff:
    """Read the coefficients of the five terms off an Allan deviation curve.

    The line of a term is laid in a range of averaging times. Ranges may be given; the others are found by the rules: the
    region of a term is the longest in which

    - the fitted line has the slope of the term within the tolerance of the rule, and its standard error by eq. (26) is at
      most the slope error of the rule;
    - the slope over one octave is everywhere that of the term within the tolerance and twice its error;
    - every point lies on the line of the term's slope within the tolerance in log σ and 2.5 times its error;
    - the slopes of the two halves differ by at most twice the tolerance plus the error of the difference;
    - the longest averaging time is at least `span` times the shortest, with an error by eq. (26) of at most 35 %.

    A flat or rising region after which the curve falls below the line, or a region of slope −1 that begins below the line,
    is refused with a reason: the five terms cannot make such a curve; a filter, a line or correlated noise can. A region
    that the other terms together explain as well, such as the crossing of two, is refused too. No rule refuses a range that
    is given.

    Parameters
    ----------
    curve : DeviationCurve
    quantization, random_walk, bias_instability, rate_random_walk, rate_ramp : tuple of float, optional
        Shortest and longest averaging time through which the line of the term is laid, whatever the curve does there.
        Default: by the rules. [s]
    rules : mapping of str to Rule
        By term; terms without a rule are read off only where a range is given: ``rules={}`` for nothing but those.

    Returns
    -------
    ReadOff

    Raises
    ------
    OptionError
        For a range that is not two positive times in order, or in which the curve has no averaging time.

    See Also
    --------
    analyze : reads off every channel of a record; its `read_off_at` are such ranges.

    Notes
    -----
    A grid of more than 8 averaging times per octave is thinned to 8. The lines are laid together: in the range of each, the
    sum of the variances of all lines lies on the curve on average, with the weights 1/δ² and the share of the line. A
    single line goes through the curve. The error is that of eq. (26) at the longest averaging time of the range.

    Incomplete clusters have larger variances: 1 % of missing samples makes a random walk read 0.5 % larger, and quantization
    noise up to 5 %. With more, the rules find nothing.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`, Section IV

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> rates = 1e-3 * np.random.default_rng(1).standard_normal(100_000)
    >>> curve = st.allan(st.Record.from_arrays(rate=100, gyro_x=rates, unit={"gyro": "rad/s"}))["gyro_x"]
    >>> st.read_off(curve, random_walk=(1, 10))
    gyro_x: read off
      angle random walk        0.341 ± 0.021 deg/√h   (τ 1.28 … 7.68 s, given)
    """
    given = _given(
        curve,
        quantization=quantization,
        random_walk=random_walk,
        bias_instability=bias_instability,
        rate_random_walk=rate_random_walk,
        rate_ramp=rate_ramp,
    )
    ranges = dict(given)
    slopes = {name: _slope(curve, at) for name, at in given.items()}
    refused = []
    left = {name: rule for name, rule in rules.items() if name not in given}
    if curve.missing > _FEW_MISSING * curve.n:
        why = f"{100 * curve.missing / curve.n:.2g} % of the samples are missing"
        ends = {"tau_min": float(curve.tau[0]), "tau_max": float(curve.tau[-1])}
        refused += [Refusal(term=name, **ends, reason=why) for name in left]
        left = {}
    points = _Points.of(curve)
    for name, rule in left.items():
        term = TERMS[name]
        found = points.longest(term.slope, rule)
        if found is None:
            continue
        i, j, slope = found
        height = points.height(i, j, term.slope, rule.tolerance)
        reason = points.bend(i, j, height, term) or points.explained(i, j, term)
        if reason is None:
            ranges[name], slopes[name] = points.at[i : j + 1], slope
        else:
            refused.append(
                Refusal(term=name, tau_min=float(points.tau[i]), tau_max=float(points.tau[j]), reason=reason)
            )
    values, without = lay(curve, ranges, given=given)
    for name, reason in without.items():
        tau = curve.tau[ranges[name]]
        refused.append(Refusal(term=name, tau_min=float(tau[0]), tau_max=float(tau[-1]), reason=reason))
    coefficients = {}
    for name in TERMS:
        if name in values:
            last = ranges[name][-1]
            coefficients[name] = Coefficient(
                term=name,
                value=values[name],
                error=values[name] * float(curve.error[last]),
                unit=coefficient_unit(name, curve.quantity, curve.unit),
                tau_min=float(curve.tau[ranges[name][0]]),
                tau_max=float(curve.tau[last]),
                slope=slopes[name],
                percentage=float(curve.error[last]),
                given=name in given,
            )
    return ReadOff(curve.channel, curve.quantity, curve.unit, coefficients, tuple(refused))


def _given(curve: DeviationCurve, **spans: Span | None) -> dict[str, NDArray[np.intp]]:
    """The points of given ranges, by term."""
    found = {}
    for name, span in spans.items():
        if span is not None:
            try:
                found[name] = points_in(curve, span_of(span))
            except OptionError as error:
                raise OptionError(error.message, option=name) from None
    return found


def _slope(curve: DeviationCurve, at: NDArray[np.intp]) -> float | None:
    """Slope of a straight line through some points of a curve; None for one point."""
    if len(at) == 1:
        return None
    weight = 1 / curve.error[at]
    return float(np.polyfit(np.log(curve.tau[at]), np.log(curve.adev[at]), 1, w=weight)[0])


@frozen(kw_only=False)
class _Points:
    """The usable points of a curve: log τ, log σ and δ of eq. (26). A region i … j includes both points."""

    at: NDArray[np.intp]  # indices in the curve
    m: NDArray[np.int64]
    tau0: float
    tau: NDArray[np.float64]
    lt: NDArray[np.float64]
    ls: NDArray[np.float64]
    delta: NDArray[np.float64]

    @classmethod
    def of(cls, curve: DeviationCurve) -> _Points:
        at = thinned(curve, curve.error <= LARGEST_ERROR)  # the search goes over all pairs
        tau = curve.tau[at]
        return cls(at, curve.m[at], curve.tau0, tau, np.log(tau), np.log(curve.adev[at]), curve.error[at])

    def octave_slopes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Slope over about an octave around each point, and its standard error by eq. (26)."""
        n = len(self.lt)
        half = 0.5 * math.log(2) * 1.01
        i = np.searchsorted(self.lt, self.lt - half)
        j = np.searchsorted(self.lt, self.lt + half, side="right") - 1
        alone = j <= i
        at = np.arange(n)
        i, j = np.where(alone, np.maximum(at - 1, 0), i), np.where(alone, np.minimum(at + 1, n - 1), j)
        length = self.lt[j] - self.lt[i]
        with np.errstate(divide="ignore", invalid="ignore"):  # a single point
            return (self.ls[j] - self.ls[i]) / length, np.hypot(self.delta[i], self.delta[j]) / length

    def longest(self, slope: float, rule: Rule) -> tuple[int, int, float] | None:
        """First point, last point and fitted slope of the longest region of a slope; of equal ones, that at shorter τ."""
        octave_slope, octave_error = self.octave_slopes()
        near = np.abs(octave_slope - slope) <= rule.tolerance + 2 * octave_error
        length = self.lt[None, :] - self.lt[:, None]
        far = np.cumsum(~near)
        error = np.hypot(self.delta[:, None], self.delta[None, :])
        possible = (length > math.log(rule.span) - 1e-9) & (error <= rule.slope_error * length)
        possible &= (far[None, :] == far[:, None]) & near[:, None]
        i, j = np.nonzero(possible)
        for k in np.lexsort((i, -np.round(length[i, j], 9))):
            first, last = int(i[k]), int(j[k])
            fitted = self.slope(first, last, rule.tolerance)
            if (
                abs(fitted - slope) <= rule.tolerance
                and self.straight(first, last, rule.tolerance)
                and self.on_line(first, last, slope, rule.tolerance)
            ):
                return first, last, fitted
        return None

    def slope(self, i: int, j: int, tolerance: float) -> float:
        """Slope of the line fitted to a region."""
        weights = 1 / (self.delta[i : j + 1] ** 2 + (tolerance / 5) ** 2)
        lt, ls = self.lt[i : j + 1], self.ls[i : j + 1]
        from_mean = lt - float(weights @ lt) / float(weights.sum())
        return float((weights * from_mean) @ ls) / float((weights * from_mean) @ from_mean)

    def straight(self, i: int, j: int, tolerance: float) -> bool:
        """Whether the slopes of the two halves of a region agree."""
        lt, ls, delta = self.lt, self.ls, self.delta
        k = int(np.argmin(np.abs(lt[i : j + 1] - (lt[i] + lt[j]) / 2))) + i
        if not i < k < j:
            return True
        first, second = lt[k] - lt[i], lt[j] - lt[k]
        change = (ls[j] - ls[k]) / second - (ls[k] - ls[i]) / first
        error = math.hypot(delta[i] / first, delta[k] * (1 / first + 1 / second), delta[j] / second)
        return bool(abs(change) <= 2 * tolerance + error)

    def height(self, i: int, j: int, slope: float, tolerance: float) -> float:
        """Log σ at τ = 1 s of the line of a given slope fitted to a region."""
        weights = 1 / (self.delta[i : j + 1] ** 2 + (tolerance / 5) ** 2)
        return float(np.average(self.ls[i : j + 1] - slope * self.lt[i : j + 1], weights=weights))

    def on_line(self, i: int, j: int, slope: float, tolerance: float) -> bool:
        """Whether every point lies on the line within its error and the tolerance in log σ."""
        off = self.ls[i : j + 1] - slope * self.lt[i : j + 1] - self.height(i, j, slope, tolerance)
        return bool((np.abs(off) <= tolerance + _SIGMAS * self.delta[i : j + 1]).all())

    def bend(self, i: int, j: int, height: float, term: Term) -> str | None:
        """Reason against the region if the curve lies below its line before or after it."""
        if term.name == "random_walk":
            return None  # white noise stays white after a filter
        below = height + term.slope * self.lt - self.ls > _SIGMAS * self.delta + _BEND
        if below[:i].any():
            return "the curve rises into it (filter, line or correlated noise)"
        if below[j + 1 :].any():
            return "the curve falls below it later (filter, line or correlated noise)"
        return None

    def explained(self, i: int, j: int, term: Term) -> str | None:
        """Reason against the region if the other terms together explain it, as at the crossing of two lines. The
        variances of the region and of a factor of 8 on either side are fitted by all terms and by all but this one,
        with weights from δ; the term must reduce the misfit by more than `GAIN` per octave of points.
        """
        near = (self.lt >= self.lt[i] - math.log(8)) & (self.lt <= self.lt[j] + math.log(8))
        m, variance = self.m[near], np.exp(2 * (self.ls[near] - self.ls[i]))  # the unit does not matter
        weight = 1 / (2 * variance * np.hypot(self.delta[near], _SMALLEST_ERROR))
        columns = {name: weight * avar(name, 1.0, m=m, tau0=self.tau0) for name in TERMS}
        others = [column for name, column in columns.items() if name != term.name]
        per_octave = max(len(m) - 1, 1) * math.log(2) / (self.lt[near][-1] - self.lt[near][0])
        gain = (_misfit(others, weight * variance) - _misfit(list(columns.values()), weight * variance)) / per_octave
        return None if gain > GAIN else "the other terms together explain it"


def _misfit(columns: list[NDArray[np.float64]], target: NDArray[np.float64]) -> float:
    """Smallest sum of squares of ``target`` minus a non-negative combination of the columns."""
    design = np.stack(columns, axis=1)
    rest = target - design @ non_negative(design, target)
    return float(rest @ rest)
