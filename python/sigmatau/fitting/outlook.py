"""What more recording would show: how well a fit knows the random walk, and when the other terms come into view."""

from __future__ import annotations

import math
from collections.abc import Mapping

from sigmatau.digits import significant
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.planning import needed_samples
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text

ENOUGH = 0.05
"""Relative half width of the interval of the random walk from which on more recording changes no filter. [1] Judgement: the
covariance of a filter is then known to a tenth, and units and days differ by more.
"""

_LONGEST = 30 * 86400.0  # longest record that is proposed [s]


def outlook(fits: Mapping[str, NoiseFit]) -> str:
    """One sentence on the worst axis of a sensor: is the record long enough, and what would a longer one show?

    Parameters
    ----------
    fits : mapping of str to NoiseFit
        The channels of one sensor.

    Returns
    -------
    str
        Empty if no channel has a random walk with an interval.

    Examples
    --------
    >>> import sigmatau as st
    >>> record = st.simulate(st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}}), duration=600, rate=100, rng=1)
    >>> outlook(st.analyze(record).fits).split(";")[0]
    'angle random walk ± 0.57 %, enough'
    """
    widths = {channel: width for channel, fitted in fits.items() if (width := _half_width(fitted)) is not None}
    if not widths:
        return ""
    channel = max(widths, key=lambda name: widths[name])
    fitted, width = fits[channel], widths[channel]
    label = TERMS["random_walk"].label(fitted.quantity)
    length = fitted.n * fitted.tau0
    needed = length * (width / ENOUGH) ** 2  # the interval narrows with the square root of the length
    verdict = "enough" if width <= ENOUGH else f"± {100 * ENOUGH:g} % in {duration_text(needed)}"
    return "; ".join([f"{label} ± {significant(100 * width, 2)} %, {verdict}", *_hidden_terms(fitted)])


def _half_width(fitted: NoiseFit) -> float | None:
    """Relative half width of the interval of the random walk; None without one."""
    term = fitted.get("random_walk")
    if term is None or not term.value or term.low is None or term.high is None:
        return None
    return (term.high - term.low) / (2 * term.value)


def _hidden_terms(fitted: NoiseFit) -> list[str]:
    """When a bias instability of half its present limit would be seen."""
    name = "bias_instability"
    term = fitted.get(name)
    if term is None or term.value is not None or term.upper_limit is None:
        return []
    observed = {key: each.value for key, each in fitted.items() if each.value is not None and TERMS[key].is_noise}
    half = term.upper_limit / 2
    samples = needed_samples(observed, name, half, tau0=fitted.tau0)
    if not math.isfinite(samples) or samples * fitted.tau0 > _LONGEST:
        return []
    unit, factor = display_units(name, fitted.quantity, fitted.rate_unit, [half])[-1]
    label, size = TERMS[name].label(fitted.quantity), significant(half / factor, 2)
    return [f"a {label} of {size} {unit} would be visible in {duration_text(samples * fitted.tau0)}"]
