"""Is it white angle noise? Quantization and flicker angle noise fall alike in the Allan deviation, about as 1/τ; not in the
modified one.

White angle noise, which quantization is, falls as τ^(-3/2) in the modified Allan deviation, because the average over a
cluster has independent errors; flicker angle noise still falls as 1/τ [1]_. So where a fit puts its short times down to
quantization, the modified deviations that it expects there are held against those of the record.

References
----------
.. [1] D. W. Allan, J. A. Barnes, "A modified Allan variance with increased oscillator characterization ability," Proc.
   35th Annual Frequency Control Symposium, 1981, :doi:`10.1109/FREQ.1981.200514`; NIST SP 1065, section 5.2.4.
"""

from __future__ import annotations

import numpy as np

from sigmatau import _kernels
from sigmatau.deviations import deviation
from sigmatau.fitting import NoiseFit
from sigmatau.record import Record
from sigmatau.results import Finding, seconds
from sigmatau.terms import avar
from sigmatau.uncertainty import chi2_factors

__all__ = ["angle_noise"]

_SIZES = np.array([4, 8, 16, 32, 64], dtype=np.int64)
_RULES = 0.5  # share of quantization in the Allan variance, from which on it can be told what it is
_LEVEL = 0.999  # of the interval that has to leave what is expected out
_WHITE = 1.25  # times the deviation expected, at most: flicker angle noise has 1.4 times it at m = 4, and more beyond
_NAMES = {"angular_rate": "angle noise", "acceleration": "velocity noise"}


def angle_noise(record: Record, fitted: NoiseFit, *, threads: int | None = None) -> Finding | None:
    """What the modified Allan deviation says of the quantization noise of a fit; None where that does not rule.

    Parameters
    ----------
    record : Record
        The one that was fitted, no sample missing.
    fitted : NoiseFit
    threads : int, optional

    Returns
    -------
    Finding or None
        ``"white_angle_noise"``, an info, or ``"flicker_angle_noise"``, a warning.
    """
    quantization = fitted.model.get("quantization", 0.0)
    sizes = _SIZES[fitted.n >= 3 * _SIZES]
    if not quantization or not sizes.size:
        return None
    share = avar("quantization", quantization, m=sizes, tau0=fitted.tau0) / fitted.avar(m=sizes)
    sizes = sizes[share >= _RULES]
    if not sizes.size:
        return None
    # The longest time at which it rules: there the two kinds are furthest apart.
    m = sizes[-1:]
    linear = {name: value for name, value in fitted.model.items() if isinstance(value, float)}
    stream = next(stream for stream in record.streams if fitted.channel in stream.channels)
    one = Record(streams=(stream.only(fitted.channel),))
    found = deviation(one, kind="modified", taus=m * fitted.tau0, threads=threads)[fitted.channel]
    expected, edf = _kernels.stationary_moments(
        "modified", overlap="full", n=fitted.n, m=m, coefficients=linear, tau0=fitted.tau0
    )
    ratio = float(found.deviation[0] / np.sqrt(expected[0]))
    low = ratio * float(chi2_factors(edf, level=_LEVEL)[0][0])
    noise = _NAMES.get(fitted.quantity, "noise of the sum")
    said = f"the modified deviation at τ = {seconds(float(m[0] * fitted.tau0))} s is {ratio:.3g} times that of white {noise}"
    if ratio > _WHITE and low > 1:
        return Finding(
            code="flicker_angle_noise",
            severity="warning",
            channel=fitted.channel,
            message=f"{said}: short times hold flicker {noise}, not quantization",
            effect="the quantization coefficient describes the Allan deviation there and no more",
        )
    if ratio < _WHITE and fitted.verdict == "adequate":
        return Finding(
            code="white_angle_noise",
            severity="info",
            channel=fitted.channel,
            message=f"{said}: short times hold white {noise}, as quantization makes, and no flicker",
        )
    return None
