"""Gain of a longer record: precision of the random walk, and the lengths at which other terms would be observed."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sigmatau._native.distributions import normal_quantile
from sigmatau.digits import significant
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.planning import needed_samples, relative_error
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text

ENOUGH = 0.05
"""Relative half width of the interval of the random walk at which a longer record improves no filter. [1] Judgement: the
covariance of a filter is then known to a tenth, and units and days differ by more.
"""

_HIDDEN = "bias_instability"  # the term that decides how long a record must be
_LONGEST = 30 * 86400.0  # longest record that is proposed [s]
_STEP = 1.02  # ratio of lengths at which the search ends: two digits suffice


@frozen
class Outlook:
    """What the fit of the worst axis of a sensor shows, and what a longer record would show.

    Attributes
    ----------
    quantity, rate_unit : str
        Quantity and unit of the sensor.
    width : float
        Relative half width of the interval of the random walk. [1]
    needed : float
        Length of record at which the half width is `ENOUGH`; length of this record if it is enough. [s]
    hidden : float or None
        Half of the present upper limit of bias instability; None if it is observed, or a month would not show it. [SI]
    visible_in : float or None
        Length of record that shows `hidden` with a probability of 50 %. [s]
    """

    quantity: str
    rate_unit: str
    width: float
    needed: float
    hidden: float | None = None
    visible_in: float | None = None

    def __str__(self) -> str:
        label = TERMS["random_walk"].label(self.quantity)
        verdict = "enough" if self.width <= ENOUGH else f"± {100 * ENOUGH:g} % in {duration_text(self.needed)}"
        text = f"{label} ± {significant(100 * self.width, 2)} %, {verdict}"
        if self.hidden is None or self.visible_in is None:
            return text
        unit, factor = display_units(_HIDDEN, self.quantity, self.rate_unit, [self.hidden])[-1]
        size = f"{TERMS[_HIDDEN].label(self.quantity)} of {significant(self.hidden / factor, 2)} {unit}"
        return f"{text}; a {size} would be visible in {duration_text(self.visible_in)}"


def outlook(fits: Mapping[str, NoiseFit]) -> Outlook | None:
    """Whether the record of a sensor is long enough, and what a longer one would show, on its worst axis.

    Parameters
    ----------
    fits : mapping of str to NoiseFit
        The channels of one sensor, fitted on their curves (`sigmatau.fit`), as of a live record.

    Returns
    -------
    Outlook or None
        None if no channel has a random walk with an interval.

    Examples
    --------
    >>> import sigmatau as st
    >>> record = st.simulate(st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}}), duration=600, rate=100, rng=1)
    >>> str(outlook(st.analyze(record).fits)).split(";")[0]
    'angle random walk ± 0.57 %, enough'
    """
    widths = {channel: width for channel, fitted in fits.items() if (width := _half_width(fitted)) is not None}
    if not widths:
        return None
    channel = max(widths, key=lambda name: widths[name])
    fitted, width = fits[channel], widths[channel]
    hidden, visible_in = _hidden_term(fitted)
    return Outlook(
        quantity=fitted.quantity,
        rate_unit=fitted.rate_unit,
        width=width,
        needed=_needed_length(fitted, width),
        hidden=hidden,
        visible_in=visible_in,
    )


def _half_width(fitted: NoiseFit) -> float | None:
    """Relative half width of the interval of the random walk; None without an interval."""
    term = fitted.get("random_walk")
    if term is None or not term.value or term.low is None or term.high is None:
        return None
    return (term.high - term.low) / (2 * term.value)


def _needed_length(fitted: NoiseFit, width: float) -> float:
    """Length of record at which the interval of the random walk is `ENOUGH`. [s]

    A short record does not separate the random walk from the other terms, so that its interval narrows faster than with the
    square root of the length: the covariance of a fit with all terms free gives the width.
    """
    length = fitted.n * fitted.tau0
    if width <= ENOUGH:
        return length
    observed = _observed(fitted)
    z = float(normal_quantile((1 + fitted.level) / 2))

    def predicted(n: int) -> float:
        return z * relative_error(observed, "random_walk", observed["random_walk"], n=n, tau0=fitted.tau0)

    # the interval of a model that does not fit exactly stays wider by the same factor
    target = ENOUGH / (max(width / predicted(fitted.n), 1.0) if fitted.verdict == "widened" else 1.0)
    low = high = fitted.n
    if predicted(low) <= target:
        return length * (width / ENOUGH) ** 2
    while predicted(high) > target:
        low, high = high, 2 * high
    while high / low > _STEP:
        middle = round(math.sqrt(low * high))
        low, high = (middle, high) if predicted(middle) > target else (low, middle)
    return high * fitted.tau0


def _hidden_term(fitted: NoiseFit) -> tuple[float, float] | tuple[None, None]:
    """Half of the present limit of bias instability, and the length of a record that shows this value. [SI, s]"""
    term = fitted.get(_HIDDEN)
    if term is None or term.value is not None or term.upper_limit is None:
        return None, None
    half = term.upper_limit / 2
    length = needed_samples(_observed(fitted), _HIDDEN, half, tau0=fitted.tau0) * fitted.tau0
    return (half, length) if length <= _LONGEST else (None, None)


def _observed(fitted: NoiseFit) -> dict[str, float]:
    """The noise of a fit, by term. [SI]"""
    return {key: each.value for key, each in fitted.items() if each.value is not None and TERMS[key].is_noise}
