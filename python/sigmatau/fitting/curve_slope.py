"""A power law with a free exponent over a stretch of a curve, as a test of the slopes of the five terms."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_quantile
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.arguments import check_level
from sigmatau.fitting.read_off_by_hand import Slope, slope_gain, slope_of_curve
from sigmatau.fitting.read_off_lines import as_span, points_in
from sigmatau.frozen import frozen
from sigmatau.noise.terms import NOISE, TERMS, avar
from sigmatau.noise.uncertainty import avar_covariance
from sigmatau.results import Printed, plain, seconds

# difference of the slope of a curve from that of a term above which other noise is present too [standard errors]
_MIXED = 3.0


@frozen
class CurveSlope(Printed):
    """Slope of a curve over a stretch of averaging times, and the terms with this slope.

    Attributes
    ----------
    channel, quantity : str
        Name of the channel.
    tau_min, tau_max : float
        First and last averaging time used. [s]
    points : int
        Averaging times used, at most eight per octave.
    value : float
        Slope of log σ over log τ. [1]
    error : float
        Standard error of the slope. The largest of the exact errors for curves of the terms in `terms`; for a ramp, or if
        clusters do not overlap, that of eq. (26). [1]
    terms : tuple of str
        Terms whose line may be fitted there: their slope differs from `value` by at most the tolerance of
        `sigmatau.read_off` plus two standard errors. "mostly" is printed before the terms if the
        difference is more than three errors, because other noise is then present too.

    See Also
    --------
    fit_slope : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> curve = st.allan(st.simulate(model, duration=600, rate=100, rng=1))["gyro_x"]
    >>> slope = st.fit_slope(curve, tau_min=0.1, tau_max=10)
    >>> slope.terms, round(slope.exponent, 1)
    (('random_walk',), 0.0)
    """

    channel: str
    quantity: str
    tau_min: float
    tau_max: float
    points: int
    value: float
    error: float
    terms: tuple[str, ...]

    @property
    def exponent(self) -> float:
        """Exponent of the density of such noise, -1 - 2·slope; meaningful for slopes between -1 and 1. [1]"""
        return -1 - 2 * self.value

    def interval(self, *, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval of the slope.

        Parameters
        ----------
        level : float
            Probability, 0.5 to 0.999.

        Returns
        -------
        low, high : float
            [1]

        Raises
        ------
        OptionError
            For a level outside 0.5 … 0.999.
        """
        check_level(level)
        half = float(normal_quantile((1 + level) / 2)) * self.error
        return self.value - half, self.value + half

    def to_dict(self) -> dict[str, Any]:
        """Plain values, with the 95 % interval."""
        low, high = self.interval()
        return plain(
            self, "channel value error", low=low, high=high, tau_s=[self.tau_min, self.tau_max], terms=self.terms
        )

    def __repr__(self) -> str:
        names = " or ".join(TERMS[term].label(self.quantity) for term in self.terms)
        if self.terms and all(abs(self.value - TERMS[term].slope) > _MIXED * self.error for term in self.terms):
            names = f"mostly {names}"
        slope = Slope(value=self.value, error=self.error, source="curve")
        return (
            f"{self.channel}, τ {seconds(self.tau_min)} … {seconds(self.tau_max)} s: slope {slope.text()}:"
            f" {names or 'no term has this slope'}"
        )


def fit_slope(curve: DeviationCurve, *, tau_min: float, tau_max: float) -> CurveSlope:
    """Fit a power law with a free exponent to a curve between two averaging times; return its slope and the error.

    Parameters
    ----------
    curve : DeviationCurve
        Allan deviations of one channel.
    tau_min, tau_max : float
        Stretch of averaging times, at least two of the curve. [s]

    Returns
    -------
    CurveSlope

    Raises
    ------
    TypeError
        If `curve` is not a curve of one channel.
    OptionError
        For times that are not positive or not in order, or with fewer than two averaging times between them.

    See Also
    --------
    read_off : refuses a line in a given range by this slope.
    fit : finds the terms of a curve; needs no stretch with a single term.

    Notes
    -----
    A straight line is fitted to log σ over log τ with the weights 1/δ², δ by eq. (26) of [1]_. `read_off` refuses lines
    by the same slope. Its error for a curve of each noise term is that of the exact covariance of Allan variances
    (`sigmatau.noise.uncertainty.avar_covariance`). A curve that bends in the stretch has a slope between those of its
    terms. Sampled bias instability and rate random walk are higher in the first ten samples (by 44 % and 22 % at one
    sample): begin the stretch after these.

    References
    ----------
    .. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
       IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`, Section II-C.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> curve = st.allan(st.simulate(model, duration=600, rate=100, rng=1))["gyro_x"]
    >>> st.fit_slope(curve, tau_min=0.1, tau_max=10)
    gyro_x, τ 0.12 … 7.68 s: slope -0.5016 ± 0.0092: angle random walk
    """
    if not isinstance(curve, DeviationCurve):
        raise TypeError(
            f"`curve` must be a DeviationCurve, e.g. sigmatau.allan(record)['gyro_x'], not a {type(curve).__name__}"
        )
    try:
        used = points_in(curve, as_span((tau_min, tau_max)))
    except OptionError as error:
        raise error.named("tau_min") from None
    if len(used) < 2:
        raise OptionError(
            f"{{option}}: the curve of {curve.channel} has one averaging time from {tau_min:g} s to {tau_max:g} s,"
            f" {curve.tau[used[0]]:g} s; a slope needs two",
            option="tau_min",
        )
    slope = slope_of_curve(curve, used)
    errors = _exact_errors(curve, used) if curve.overlap == "full" else {}
    by_term = {term: replace(slope, error=errors.get(term, slope.error)) for term in TERMS}
    terms = tuple(term for term, tested in by_term.items() if not tested.differs(term))
    nearest = min(TERMS, key=lambda term: abs(TERMS[term].slope - slope.value))
    return CurveSlope(
        channel=curve.channel,
        quantity=curve.quantity,
        tau_min=float(curve.tau[used[0]]),
        tau_max=float(curve.tau[used[-1]]),
        points=len(used),
        value=slope.value,
        error=max(by_term[term].error for term in terms or (nearest,)),
        terms=terms,
    )


def _exact_errors(curve: DeviationCurve, used: NDArray[np.intp]) -> dict[str, float]:
    """Standard error of the slope for a curve of each noise term."""
    m = curve.m[used]
    gain = slope_gain(curve.tau[used], curve.error[used], np.ones(len(used)))
    errors = {}
    for term in NOISE:
        expected = avar(term, 1.0, m=m, tau0=curve.tau0)
        covariance = avar_covariance({term: 1.0}, n=curve.n, m=m, tau0=curve.tau0) / np.outer(expected, expected)
        errors[term] = math.sqrt(float(gain @ covariance @ gain)) / 2
    return errors
