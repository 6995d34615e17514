"""Repeatability of a coefficient over runs: homogeneity, spread between runs, prediction of another run, outlying run.

The paper calls a sensor repeatable if the standard deviation over seven days is below the error δ of eq. (26). This rule is
not a statistical test: it accepts only 58 % of perfectly repeatable sets, and nearly every set if δ is stated too large.
Here Cochran's test compares the values with their errors, and the spread beyond the errors is estimated with an interval.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats, Ints
from sigmatau.digits import round_to_error, two_digits
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.group_effects import GroupEffects, group_effects
from sigmatau.results import Printed, plain

Scale = Literal["relative", "absolute"]
Judgement = Literal["repeatable", "varies", "outlier", "too_alike", "one_run", "without_errors"]


@frozen
class RandomEffects(Printed):
    """Result of `random_effects`.

    Attributes
    ----------
    k : int
        Number of runs.
    scale : {"relative", "absolute"}
        Whether spreads are relative (computed on logarithms) or in the unit of the values.
    level : float
        Confidence level of the intervals.
    mean, low, high : float
        Mean over the runs, which is geometric for relative spreads, with its interval. [unit of the values]
    std : float or None
        Standard deviation of the values, ddof = 1. [unit of the values]
    error : float or None
        Standard error of a run, as a root mean square over the runs; None if unknown. [1, or unit of the values]
    q, p_value, p_low : float or None
        Cochran's Q, and the probability of a larger and of a smaller Q if all runs have the same true value. If `p_low`
        is small, the errors are too large, or the runs are not independent.
    tau, tau_low, tau_high : float or None
        Standard deviation between runs beyond the errors, and its interval. [1, or unit of the values]
    next_low, next_high : float or None
        Prediction interval of another run with the same error. [unit of the values]
    next_error : float or None
        Half of the prediction interval. [1, or unit of the values]
    outlier : int or None
        Position of the run that differs most from the others; None with fewer than three runs.
    outlier_p : float or None
        P-value of this run, corrected for the number of runs.

    See Also
    --------
    random_effects : makes it.
    compare_runs : makes the same estimates from results of analyses.

    Examples
    --------
    >>> import sigmatau as st
    >>> found = st.random_effects([1.00, 1.02, 0.98], [0.02, 0.02, 0.02])
    >>> round(found.mean, 3), found.tau, found.judgement
    (1.0, 0.0, 'repeatable')
    """

    k: int
    scale: Scale
    level: float
    mean: float
    low: float | None
    high: float | None
    std: float | None
    error: float | None
    q: float | None
    p_value: float | None
    p_low: float | None
    tau: float | None
    tau_low: float | None
    tau_high: float | None
    next_low: float | None
    next_high: float | None
    next_error: float | None
    outlier: int | None
    outlier_p: float | None

    @property
    def std_relative(self) -> float | None:
        """Standard deviation of the values relative to their mean; None if the mean is 0 or there is one run."""
        return None if self.std is None or self.mean == 0 else self.std / abs(self.mean)

    @property
    def judgement(self) -> Judgement:
        """Outcome of the tests, at the level of the intervals."""
        p = (np.array([math.nan if x is None else x]) for x in (self.p_value, self.p_low, self.outlier_p))
        return judge_groups(np.array([self.k]), *p, level=self.level)[0]

    def accepted_by_paper(self, delta: float | None = None) -> bool | None:
        """Whether the paper's rule calls the runs repeatable: their standard deviation is below the error δ.

        Parameters
        ----------
        delta : float, optional
            δ. Default: the error of one run. [unit of the values]

        Returns
        -------
        bool or None
            None if there is only one run, or no error.
        """
        if delta is None:
            delta = None if self.error is None else self.error * (abs(self.mean) if self.scale == "relative" else 1.0)
        return None if self.std is None or delta is None else self.std < delta

    def to_dict(self) -> dict[str, Any]:
        """Plain values; None for absent values."""
        values = plain(
            self,
            "k scale level mean low high std error q p_value p_low tau tau_low tau_high",
            "next_low next_high next_error outlier outlier_p judgement",
        )
        return {name: None if value != value else value for name, value in values.items()}

    def __repr__(self) -> str:
        mean = round_to_error(self.mean, self.low, self.high).text
        lines = [f"{self.k} {'run' if self.k == 1 else 'runs'}: mean {mean}"]
        if self.std is not None and self.tau is not None and self.tau_low is not None and self.tau_high is not None:
            lines.append(f"  standard deviation   {self._size(self.std_relative if self._percent else self.std)}")
            ends = (None, None) if self.tau_high == 0 else (self.tau_low, self.tau_high)
            scale = 100 if self._percent else 1
            spread = round_to_error(scale * self.tau, *(None if end is None else scale * end for end in ends))
            text = spread.with_unit("%" if self._percent else "") if self.tau_high > 0 else self._size(0.0)
            lines.append(f"  between runs         {text}")
            lines.append(f"  next run             within ±{self._size(self.next_error)}")
        if self.p_value is not None:
            lines.append(f"  homogeneity          p {p_text(self.p_value)}")
        return "\n".join([*lines, f"  {JUDGEMENTS[self.judgement].format(run=self.outlier)}"])

    @property
    def _percent(self) -> bool:
        return self.scale == "relative"

    def _size(self, value: float | None) -> str:
        if value is None:
            return "unknown"
        return f"{two_digits(100 * value)} %" if self._percent else f"{value:.3g}"


JUDGEMENTS: dict[Judgement, str] = {
    "repeatable": "repeatable within the errors",
    "varies": "varies between runs",
    "outlier": "run {run} does not belong to the others",
    "too_alike": "more alike than their errors allow: errors too large, or runs not independent",
    "one_run": "one run: nothing to compare",
    "without_errors": "the errors are not known: no test",
}


def p_text(p: float) -> str:
    """``= 0.41``, or ``< 0.0001``."""
    return f"= {p:.2g}" if p >= 1e-4 else "< 0.0001"


_CODES: tuple[Judgement, ...] = ("one_run", "outlier", "without_errors", "varies", "too_alike", "repeatable")


def judge_groups(k: Ints, p_value: Floats, p_low: Floats, outlier_p: Floats, *, level: float) -> list[Judgement]:
    """Outcome of the tests of many groups; an outlying run takes precedence. P-values are NaN without a test."""
    conditions = [
        k < 2,
        outlier_p < 1 - level,
        np.isnan(p_value),
        p_value < 1 - level,
        p_low < (1 - level) / 2,
    ]
    codes = np.select(conditions, range(len(conditions)), default=len(conditions))
    return [_CODES[code] for code in codes.tolist()]


def random_effects(
    values: ArrayLike,
    errors: ArrayLike | None,
    *,
    level: float = 0.95,
    scale: Scale = "relative",
) -> RandomEffects:
    """Repeatability of values of one quantity over runs.

    The value of a run is the mean, plus a deviation of the run with standard deviation τ, plus its error. Homogeneity
    (τ = 0) is tested by Cochran's Q, χ² with k - 1 degrees of freedom. τ is estimated after Paule and Mandel [1]_, its
    interval by inverting Q(τ²) [2]_. Mean and prediction interval use Student's t with k - 1 degrees of freedom, and a
    standard error that is not below the one that the errors alone imply (Knapp and Hartung [3]_, modified).
    docs/study/repeatability.md has the measured coverage.

    Parameters
    ----------
    values : array_like, shape (k,)
        Positive values if `scale` is "relative".
    errors : array_like, shape (k,), or None
        Standard errors (1 σ). [unit of the values] None if they are unknown: homogeneity is then not tested, and the spread
        between runs is that of the values.
    level : float
        Confidence level of the intervals.
    scale : {"relative", "absolute"}
        Compare logarithms, as for coefficients of noise, or the values themselves, as for ramps and biases, which may have
        either sign.

    Returns
    -------
    RandomEffects

    Raises
    ------
    DataError
        If a value is not finite or, with relative spreads, not positive; if an error is not positive; if there is no value.
    OptionError
        For a level outside 0 to 1, or an unknown scale.

    See Also
    --------
    compare_runs : makes the same estimates from results of analyses.

    References
    ----------
    .. [1] R. C. Paule, J. Mandel, "Consensus values and weighting factors," J. Res. NBS, vol. 87, no. 5, 1982,
       :doi:`10.6028/jres.087.022`.
    .. [2] W. Viechtbauer, "Confidence intervals for the amount of heterogeneity in meta-analysis," Statistics in Medicine,
       vol. 26, no. 1, 2007, :doi:`10.1002/sim.2514`.
    .. [3] G. Knapp, J. Hartung, "Improved tests for a random effects meta-regression with a single covariate," Statistics in
       Medicine, vol. 22, no. 17, 2003, :doi:`10.1002/sim.1482`.

    Examples
    --------
    The X gyro of Table I of the paper, with the error of a fit to two hours at 200 Hz:

    >>> import sigmatau as st
    >>> days = [0.973, 0.960, 0.919, 0.947, 0.958, 0.959, 0.945]
    >>> st.random_effects(days, [0.00066] * 7)
    7 runs: mean 0.951 ± 0.016
      standard deviation   1.8 %
      between runs         1.81 [1.16, 3.98] %
      next run             within ±4.7 %
      homogeneity          p < 0.0001
      varies between runs
    """
    check_level(level)
    if scale not in ("relative", "absolute"):
        raise OptionError(f"{{option}} must be relative or absolute, not {scale!r}", option="scale")
    c = _numbers(values, "values")
    if not len(c):
        raise DataError("`values` is empty: one value per run is needed")
    if not np.isfinite(c).all():
        raise DataError(f"`values` contains a value that is not finite, at position {int(np.argmin(np.isfinite(c)))}")
    if scale == "relative" and not (c > 0).all():
        position = int(np.argmin(c > 0))
        raise DataError(
            f"`values` must be positive, not {c[position]:.6g} (position {position});"
            " for values with a sign scale='absolute'"
        )
    s = None if errors is None else _numbers(errors, "errors")
    if s is not None:
        if len(s) != len(c):
            raise DataError(f"`errors` must have one error per value: {len(s)} errors, {len(c)} values")
        good = np.isfinite(s) & (s > 0)
        if not good.all():
            position = int(np.argmin(good))
            raise DataError(
                f"`errors` must be positive, not {s[position]:.6g} (position {position}); errors=None if they are not known"
            )
    if scale == "relative":
        effects = group_effects(np.log(c)[None], None if s is None else (s / c)[None], level=level)
    else:
        effects = group_effects(c[None], None if s is None else s[None], level=level)
    std = float(c.std(ddof=1)) if len(c) > 1 else math.nan
    return one_group(effects, 0, scale=scale, level=level, std=std)


def one_group(effects: GroupEffects, row: int, *, scale: Scale, level: float, std: float) -> RandomEffects:
    """Select one of many groups, in the unit of its values. `std`: standard deviation of the values."""

    def number(name: str) -> float | None:
        value = float(getattr(effects, name)[row])
        return value if math.isfinite(value) else None

    middle = float(effects.mean[row])
    to_value = math.exp if scale == "relative" else float

    def interval(name: str) -> tuple[float | None, float | None]:
        half = number(name)
        return (None, None) if half is None else (to_value(middle - half), _finite(to_value, middle + half))

    (low, high), (next_low, next_high) = interval("mean_error"), interval("next_error")
    outlier = int(effects.outlier[row])
    return RandomEffects(
        k=int(effects.k[row]),
        scale=scale,
        level=level,
        mean=to_value(middle),
        low=low,
        high=high,
        std=std if math.isfinite(std) else None,
        next_low=next_low,
        next_high=next_high,
        outlier=None if outlier < 0 else outlier,
        **{name: number(name) for name in ("error", "q", "p_value", "p_low", "tau", "tau_low", "tau_high")},
        next_error=number("next_error"),
        outlier_p=None if outlier < 0 else number("outlier_p"),
    )


def _finite(to_value: Any, x: float) -> float | None:  # noqa: ANN401  exp or float
    """Convert a number; None if the result overflows, as the upper end of an interval from two runs may."""
    try:
        return float(to_value(x))
    except OverflowError:
        return None


def _numbers(array_like: ArrayLike, name: str) -> Floats:
    try:
        array = np.asarray(array_like, dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(f"`{name}` must be numbers, not {array_like!r:.60}") from None
    if array.ndim != 1:
        raise DataError(f"`{name}` must have one dimension, not the shape {array.shape}")
    return array


def check_level(level: float) -> None:
    """Raise `OptionError` for a confidence level outside 0 to 1."""
    if not (isinstance(level, int | float) and 0 < level < 1):
        raise OptionError(f"{{option}} must be between 0 and 1, not {level!r}", option="level")
