"""Lines in ranges given by hand: fitted to the remainder after the other lines, and refused if the slope is wrong."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.digits import round_to_error
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off_lines import HIDDEN, lay, sum_of_lines
from sigmatau.fitting.read_off_regions import RULES
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, avar

_SLOPE_ERRORS = 2.0
"""Standard errors of the slope that are allowed in addition to the tolerance of the term's rule, as in the rules."""

_CORRELATION = 0.5
"""Correlation of overlapping Allan variances an octave apart: 0.4 for quantization, 0.53 for white and 0.88 for red noise (N
= 1000). The error of a slope decreases with it, so a value is chosen that does not make the error too small for red noise.
"""

_DOMINANT_SHARE = 0.95  # smallest mean share of a line in the variance for its slope to be that of the curve


@frozen
class Slope:
    """Measured slope of a curve, or of the remainder after other lines.

    Attributes
    ----------
    value, error : float
        Slope of log σ over log τ. [1]
    source : {"curve", "rest"}
    """

    value: float
    error: float
    source: Literal["curve", "rest"]

    def differs(self, term: str) -> bool:
        """Whether the slope differs from that of a term, given the tolerance of its rule and the error of the curve."""
        return abs(self.value - TERMS[term].slope) > RULES[term].tolerance + _SLOPE_ERRORS * self.error

    def against(self, term: str) -> str:
        """The slope compared with that of a term: ``"the slope +1.00 ± 0.31, not -0.5"``."""
        slope = f"{TERMS[term].slope:+g}" if TERMS[term].slope else "0"
        if not math.isfinite(self.error):
            return f"one point, no slope of {slope}"
        return f"the slope {self.text()}, not {slope}"

    def text(self) -> str:
        """The slope with its error: ``"+1.00 ± 0.31"``."""
        return round_to_error(self.value, error=self.error, sign="+").text


@frozen
class HandLine:
    """A line in a range given by hand.

    Attributes
    ----------
    value : float
        Coefficient. [SI]
    forced : bool
        Whether it is drawn although the slope of the curve is different.
    """

    value: float
    forced: bool = False


def lay_by_hand(
    curve: DeviationCurve, ranges: Mapping[str, NDArray[np.intp]], held: Mapping[str, float], *, force: bool
) -> tuple[dict[str, HandLine], dict[str, str]]:
    """Fit lines in given ranges together with fixed lines; return the lines, and the refused lines with reasons.

    A line is refused if the slope of the remainder after the other lines differs from that of the term by more than the
    tolerance of its rule and twice its error, or if the remainder is smaller than the error of the curve. With `force` it
    is drawn nevertheless: through the curve itself if there is no remainder.
    """
    remaining, refused = dict(ranges), dict[str, str]()
    while True:
        values, hidden = lay(curve, remaining, held=held)
        worst, reason, excess = "", "", 0.0
        for name, points in remaining.items():
            if name in hidden:
                worst, reason = name, _hidden(curve, points, name)
                break
            lines = {**held, **values}
            remainder = {term: value for term, value in lines.items() if term != name}
            if not _exceeds_error(curve, points, name, values[name], remainder):
                worst, reason = name, _hidden(curve, points, name)
                break
            slope = slope_of_rest(curve, points, name, values[name], remainder)
            if slope is not None and slope.differs(name):
                size = abs(slope.value - TERMS[name].slope) / (RULES[name].tolerance + _SLOPE_ERRORS * slope.error)
                if size > excess:
                    cause = "the curve" if slope.source == "curve" else "the remainder after the other lines"
                    worst, reason, excess = name, f"{cause} has {slope.against(name)}", size
        if not worst:
            break
        refused[worst] = reason
        del remaining[worst]
    laid = {name: HandLine(value=value) for name, value in values.items()}
    if not force:
        return laid, refused
    for name in refused:
        value = lay(curve, {name: ranges[name]}, held=held)[0] or lay(curve, {name: ranges[name]})[0]
        laid[name] = HandLine(value=value[name], forced=True)
    return laid, {}


def _hidden(curve: DeviationCurve, points: NDArray[np.intp], term: str) -> str:
    """Reason to refuse a line if the remainder after the other lines is smaller than the error of the curve."""
    return f"{HIDDEN}, which has {slope_of_curve(curve, points).against(term)}"


def slope_of_curve(curve: DeviationCurve, points: NDArray[np.intp]) -> Slope:
    """Slope of a straight line through points of a curve, with weights 1/δ²; NaN for one point."""
    constant = np.ones(len(points))
    value, error = _free_slope(curve, points, np.log(curve.avar[points]), constant)
    return Slope(value=value, error=error, source="curve")


def slope_of_rest(
    curve: DeviationCurve, points: NDArray[np.intp], term: str, value: float, lines: Mapping[str, float]
) -> Slope | None:
    """Slope of the remainder of a curve after other lines, in the range of a line, from one Gauss-Newton step; None for
    one point.
    """
    if len(points) < 2:
        return None
    line = avar(term, value, m=curve.m[points], tau0=curve.tau0)
    total = line + sum_of_lines(curve, lines, points)
    share = line / total
    change, error = _free_slope(curve, points, np.log(curve.avar[points] / total), share)
    weight = curve.error[points] ** -2.0
    dominates = float(np.average(share, weights=weight)) > _DOMINANT_SHARE
    return Slope(value=TERMS[term].slope + change, error=error, source="curve" if dominates else "rest")


def _free_slope(
    curve: DeviationCurve, points: NDArray[np.intp], log_variance: NDArray[np.float64], share: NDArray[np.float64]
) -> tuple[float, float]:
    """Slope of half a log variance over log τ for a line with a share of the variance, and its standard error."""
    if len(points) < 2:
        return math.nan, math.inf
    error = curve.error[points]
    gain = slope_gain(curve.tau[points], error, share)
    variance = float(gain @ _covariance(curve.tau[points], error) @ gain)
    return float(gain @ log_variance) / 2, math.sqrt(max(variance, 0.0)) / 2


def slope_gain(tau: NDArray[np.float64], error: NDArray[np.float64], share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of log variances whose weighted sum is their slope over log τ, for a line with a share of the variance."""
    x, weight = np.log(tau), error**-2.0
    design = np.stack([share, share * (x - x.mean())], axis=1)
    gain: NDArray[np.float64] = (np.linalg.pinv(design.T @ (weight[:, None] * design)) @ (design.T * weight))[1]
    return gain


def _exceeds_error(
    curve: DeviationCurve, points: NDArray[np.intp], term: str, value: float, lines: Mapping[str, float]
) -> bool:
    """Whether the mean share of a line in its range exceeds the error of the mean log variance there."""
    line = avar(term, value, m=curve.m[points], tau0=curve.tau0)
    error = curve.error[points]
    weight = error**-2.0
    weight /= weight.sum()
    share = float(weight @ (line / (line + sum_of_lines(curve, lines, points))))
    mean_error = math.sqrt(float(weight @ _covariance(curve.tau[points], error) @ weight))
    return share > min(mean_error, _DOMINANT_SHARE)


def _covariance(tau: NDArray[np.float64], error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Covariance of log variances by eq. (26)."""
    delta, octave = 2 * error, np.log2(tau)
    covariance: NDArray[np.float64] = np.outer(delta, delta) * _CORRELATION ** np.abs(octave[:, None] - octave)
    return covariance
