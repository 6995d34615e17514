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

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.digits import round_to_error
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off_by_hand import lay_by_hand, slope_of_curve
from sigmatau.fitting.read_off_lines import Span, as_span, lay, points_between, points_in
from sigmatau.fitting.read_off_regions import RULES, Refusal, Rule, regions
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, coefficient_unit, display_units
from sigmatau.results import Printed, Tabular, plain, seconds
from sigmatau.units import find

if TYPE_CHECKING:
    from sigmatau.fitting.noise_fit import NoiseFit

Source = Literal["rules", "given", "fit"]


@frozen
class ReadOffCoefficient:
    """One coefficient, read off.

    Attributes
    ----------
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    value, error : float
        Coefficient, and one standard error by eq. (26). [unit]
    unit : str
        SI.
    tau_min, tau_max : float
        Averaging times whose points determine the line. [s]
    slope : float or None
        Slope of the curve there in log σ over log τ; None if a given range has a single point. [1]
    percentage : float
        Error over value, a ratio.
    range_from : {"rules", "given", "fit"}
        Origin of the range: the rules, given by hand, or where the fitted model says that the term dominates.
    slope_error : float or None
        Standard error of the slope by eq. (26). [1]
    forced : bool
        Whether the line is drawn although the curve has another slope.
    """

    term: str
    value: float
    error: float
    unit: str
    tau_min: float
    tau_max: float
    slope: float | None
    percentage: float
    range_from: Source = "rules"
    slope_error: float | None = None
    forced: bool = False

    @property
    def region(self) -> str:
        """Origin and range of the line, in words: ``"τ 1 … 10 s, given"``."""
        suffix = ", given" if self.range_from == "given" else ""
        forced = ", forced: not the slope of the curve" if self.forced else ""
        return f"τ {seconds(self.tau_min)} … {seconds(self.tau_max)} s{suffix}{forced}"

    def to(self, unit: str) -> float:
        """The value in another unit: ``c.to("deg/sqrt(h)")``.

        Parameters
        ----------
        unit : str
            A unit of the same quantity, such as ``"deg/sqrt(h)"``.

        Returns
        -------
        float
            [unit]

        Raises
        ------
        OptionError
            For a unit that does not fit.
        """
        return self.value / find(unit, si=self.unit).factor

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        forced = {"forced": True} if self.forced else {}
        return plain(
            self, "value error unit slope slope_error range_from", tau_s=[self.tau_min, self.tau_max], **forced
        )


@frozen(kw_only=False)
class ReadOff(Mapping[str, ReadOffCoefficient], Tabular):
    """Coefficients read off one channel: a mapping from term to `ReadOffCoefficient`, without terms that have no region.

    Attributes
    ----------
    channel : str
    quantity : str
        ``"angular_rate"``, ``"acceleration"`` or ``"signal"``.
    rate_unit : str
        SI unit of the channel.
    coefficients : mapping of str to ReadOffCoefficient
        By term.
    refused : tuple of Refusal
        Regions that have the slope of a term but another cause, and refused lines of given ranges.

    See Also
    --------
    read_off : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> rates = 1e-3 * np.random.default_rng(1).standard_normal(100_000)
    >>> curve = st.allan(st.Record.from_arrays(rate=100, gyro_x=rates))["gyro_x"]
    >>> found = st.read_off(curve)
    >>> walk = found["random_walk"]
    >>> abs(walk.value - 1e-4) < 2 * walk.error, walk.unit
    (True, 'rad/sqrt(s)')
    """

    channel: str
    quantity: str
    rate_unit: str
    coefficients: Mapping[str, ReadOffCoefficient]
    refused: tuple[Refusal, ...] = ()

    def __getitem__(self, term: str) -> ReadOffCoefficient:
        try:
            return self.coefficients[term]
        except KeyError:
            names = ", ".join(self.coefficients) or "none"
            raise KeyError(f"no coefficient {term!r} was read off {self.channel}; read: {names}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.coefficients)

    def __len__(self) -> int:
        return len(self.coefficients)

    def texts(self, term: str) -> list[tuple[str, str]]:
        """A coefficient in each of the field's units: ``[("0.973 ± 0.074", "arcsec")]``.

        Parameters
        ----------
        term : str
            A term that was read off.

        Returns
        -------
        list of (str, str)
        """
        c = self[term]
        return [
            (round_to_error(c.value, error=c.error, size=factor).text, text)
            for text, factor in display_units(term, self.quantity, self.rate_unit, [c.value])
        ]

    def columns(self) -> dict[str, list[Any]]:
        """One row per coefficient, see `Tabular.columns`. ``plus_minus`` is the error by eq. (26), not a standard error."""
        lines = list(self.coefficients.values())
        rows: dict[str, list[Any]] = {name: [getattr(line, name) for line in lines] for name in ("term", "value")}
        rows |= {"plus_minus": [line.error for line in lines], "unit": [line.unit for line in lines]}
        return {"channel": [self.channel] * len(lines), **rows}

    _repr_html_ = Printed._repr_html_  # in the field's units

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, by term."""
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


_FEW_MISSING = 0.01  # share of missing samples: read-offs of N are then 0.5 % too large, of Q 5 %


def read_off(
    curve: DeviationCurve,
    *,
    quantization: Span | None = None,
    random_walk: Span | None = None,
    bias_instability: Span | None = None,
    rate_random_walk: Span | None = None,
    rate_ramp: Span | None = None,
    rules: Mapping[str, Rule] = RULES,
    force: bool = False,
) -> ReadOff:
    """Read the coefficients of the five terms off an Allan deviation curve.

    The line of a term is fitted in a range of averaging times. Ranges may be given; rules find the others. The region of
    a term is the longest range in which

    - the fitted line has the slope of the term within the tolerance of the rule, and its standard error by eq. (26) is at
      most the slope error of the rule;
    - the slope over one octave is everywhere that of the term within the tolerance and twice its error;
    - every point lies on the line of the term's slope within the tolerance in log σ and 2.5 times its error;
    - the slopes of the two halves differ by at most twice the tolerance plus the error of the difference;
    - the longest averaging time is at least `span` times the shortest, with an error by eq. (26) of at most 35 %.

    A flat or rising region after which the curve falls below the line, or a region of slope −1 that begins below the
    line, is refused with a reason: the five terms cannot cause such a curve, but a filter, a line or correlated noise
    can. A region that the other terms together explain as well, such as the crossing of two terms, is refused too.

    A line in a given range is refused, with the measured slope and its error, if the slope of the remainder after the
    other lines differs from that of the term by more than the tolerance of its rule and twice the error, or if the
    remainder is smaller than the error of the curve. It does not change the lines of other terms that are found by rules.

    Parameters
    ----------
    curve : DeviationCurve
        Allan deviations of one channel.
    quantization, random_walk, bias_instability, rate_random_walk, rate_ramp : tuple of float, optional
        Shortest and longest averaging time of the line of the term, in place of its region by the rules.
        Default: by the rules. [s]
    rules : mapping of str to Rule
        Rules by term; terms without a rule are read off only in a given range. With ``rules={}`` only terms with a
        given range are read off.
    force : bool
        Draw refused lines of given ranges too; they are marked, see `ReadOffCoefficient.forced`.

    Returns
    -------
    ReadOff

    Raises
    ------
    TypeError
        If `curve` is not a curve of one channel.
    OptionError
        For a range that is not two positive times in order, or in which the curve has no averaging time.

    See Also
    --------
    analyze : reads off every channel of a record; its `read_off_at` takes such ranges.

    Notes
    -----
    A grid of more than 8 averaging times per octave is thinned to 8. The lines are fitted together: in the range of
    each line, the sum of the variances of all lines agrees with the curve on average, with the weights 1/δ² and the
    share of the line. The error is that of eq. (26) at the longest averaging time of the range.

    Incomplete clusters have larger variances: with 1 % of missing samples the read-off of a random walk is 0.5 % too
    large, and that of quantization noise up to 5 %. With more missing samples, the rules find no lines.

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
    if not isinstance(curve, DeviationCurve):
        raise TypeError(
            f"`curve` must be a DeviationCurve, e.g. sigmatau.allan(record)['gyro_x'], not a {type(curve).__name__};"
            " sigmatau.analyze(record, method='read-off') reads off every channel of a record"
        )
    stated = _points_by_hand(
        curve,
        quantization=quantization,
        random_walk=random_walk,
        bias_instability=bias_instability,
        rate_random_walk=rate_random_walk,
        rate_ramp=rate_ramp,
    )
    wanted = {} if _reason_to_refuse(curve) else rules
    refused = [_refuse_everywhere(curve, name, _reason_to_refuse(curve)) for name in rules if name not in wanted]
    by_rules, without_region = regions(curve, wanted)
    return _lay_lines(curve, by_rules, "rules", stated, [*refused, *without_region], force=force)


def read_off_with_fit(
    curve: DeviationCurve, fitted: NoiseFit, stated: Mapping[str, Span], *, force: bool = False
) -> ReadOff:
    """Read off the terms of a fitted model where they dominate the variance, and other terms in given ranges.

    A term of the model also has a line if a process explains the record equally well, because the paper has only the five
    terms. A fit without intervals, or one that does not fit, gives no ranges; the rules then find them.
    """
    spans: Any = stated
    if not fitted.quantified or fitted.is_misfit:
        return read_off(curve, **spans, force=force)
    lines, refused = {}, []
    for name, span in fitted.model_ranges.items():
        why = _reason_to_refuse(curve)
        points = np.empty(0, dtype=np.intp) if why or span is None else points_between(curve, span)
        if len(points):
            lines[name] = points
        else:
            refused.append(_refuse_everywhere(curve, name, why))
    return _lay_lines(curve, lines, "fit", _points_by_hand(curve, **spans), refused, force=force)


_HIDDEN = "other noise hides it at all averaging times"  # reason for a fitted term that dominates nowhere


def _refuse_everywhere(curve: DeviationCurve, name: str, why: str) -> Refusal:
    """Refuse a term at all averaging times. Default reason: other noise hides it."""
    ends = float(curve.tau[0]), float(curve.tau[-1])
    return Refusal(term=name, tau_min=ends[0], tau_max=ends[1], reason=why or _HIDDEN, hidden=not why)


def _reason_to_refuse(curve: DeviationCurve) -> str:
    """Reason against all lines without a given range; empty if there is none."""
    if curve.missing <= _FEW_MISSING * curve.n:
        return ""
    return f"{100 * curve.missing / curve.n:.2g} % of the samples are missing"


def _lay_lines(
    curve: DeviationCurve,
    ranges: Mapping[str, NDArray[np.intp]],
    source: Source,
    stated: Mapping[str, NDArray[np.intp]],
    refused: list[Refusal],
    *,
    force: bool,
) -> ReadOff:
    """Compute the coefficients of lines through points of a curve. Lines in given ranges replace those of their terms,
    and do not change the other lines.
    """
    values, hidden = lay(curve, ranges)
    held = {name: value for name, value in values.items() if name not in stated}
    by_hand, reasons = lay_by_hand(curve, stated, held, force=force) if stated else ({}, {})
    error = curve.error
    lines = {name: _coefficient(curve, error, name, value, ranges[name], source) for name, value in held.items()}
    for name, line in by_hand.items():
        lines[name] = _coefficient(curve, error, name, line.value, stated[name], "given", forced=line.forced)
    refused = [refusal for refusal in refused if refusal.term not in stated]
    refused += [_refusal(curve, name, ranges[name], why) for name, why in hidden.items() if name not in stated]
    refused += [_refusal(curve, name, stated[name], why, by_hand=True) for name, why in reasons.items()]
    ordered = {name: lines[name] for name in TERMS if name in lines}
    return ReadOff(curve.channel, curve.quantity, curve.unit, ordered, tuple(refused))


def _refusal(
    curve: DeviationCurve, name: str, points: NDArray[np.intp], reason: str, *, by_hand: bool = False
) -> Refusal:
    tau = curve.tau[points]
    slope = slope_of_curve(curve, points) if by_hand and len(points) > 1 else None
    return Refusal(
        term=name,
        tau_min=float(tau[0]),
        tau_max=float(tau[-1]),
        reason=reason,
        by_hand=by_hand,
        slope=None if slope is None else slope.value,
        slope_error=None if slope is None else slope.error,
    )


def _coefficient(
    curve: DeviationCurve,
    error: NDArray[np.float64],
    name: str,
    value: float,
    points: NDArray[np.intp],
    source: Source,
    *,
    forced: bool = False,
) -> ReadOffCoefficient:
    """The coefficient of a line, with the error of eq. (26) at its longest averaging time."""
    delta = float(error[points[-1]])
    slope = slope_of_curve(curve, points) if len(points) > 1 else None
    return ReadOffCoefficient(
        term=name,
        value=value,
        error=value * delta,
        unit=coefficient_unit(name, curve.quantity, curve.unit),
        tau_min=float(curve.tau[points[0]]),
        tau_max=float(curve.tau[points[-1]]),
        slope=None if slope is None else slope.value,
        slope_error=None if slope is None else slope.error,
        percentage=delta,
        range_from=source,
        forced=forced,
    )


def _points_by_hand(curve: DeviationCurve, **spans: Span | None) -> dict[str, NDArray[np.intp]]:
    """The points of given ranges, by term."""
    points = {}
    for name, span in spans.items():
        if span is not None:
            try:
                points[name] = points_in(curve, as_span(span))
            except OptionError as error:
                raise error.named(name) from None
    return points
