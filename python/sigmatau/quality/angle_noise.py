"""Is it white angle noise? Quantization and flicker angle noise fall alike in the Allan deviation, about as 1/τ; not in the
modified one.

White angle noise, which quantization is, falls as τ^(-3/2) in the modified Allan deviation, because the average over a
cluster has independent errors; flicker angle noise still falls as 1/τ [1]_. The Allan variance alone cannot tell them: that
of flicker angle noise, (1.038 + 3 ln(2π f_h τ)) / τ² but for a factor, looks like quantization with some random walk, which
is not there. So Allan and modified Allan variances of short times are taken together, as a sum of quantization, flicker
angle noise and random walk, none of them negative, and held against the same without flicker.

References
----------
.. [1] D. W. Allan, J. A. Barnes, "A modified Allan variance with increased oscillator characterization ability," Proc.
   35th Annual Frequency Control Symposium, 1981, :doi:`10.1109/FREQ.1981.200514`; NIST SP 1065, sections 4.1 and 5.2.4.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from sigmatau.estimators.allan import DeviationCurve, allan
from sigmatau.estimators.deviation import deviation
from sigmatau.findings.finding import Finding
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.record.record import Record
from sigmatau.results import seconds

__all__ = ["angle_noise", "untold"]

_SIZES = np.array([4, 8, 16, 32, 64], dtype=np.int64)
_LEAST_CLUSTERS = 12
_ENOUGH = 1 << 20  # samples, of which short times show all that can be told
# Steeper than a random walk, of which the Allan variance at 4 samples is 4 times that at 16; of pure flicker 10.8 times.
_STEEP = 5.0
# Of the sum of squares over its expectation: flicker is there if it explains so much, and this part of what was there.
_EXPLAINED, _LEFT = 25.0, 0.2
_SHARE = 0.3  # of the variance, for it to matter
_RULES = 0.5  # share from which on a term is said to rule
_NAMES = {"angular_rate": "angle noise", "acceleration": "velocity noise"}
_Q, _N, _FLICKER = range(3)


def angle_noise(record: Record, fitted: NoiseFit, *, threads: int | None = None) -> Finding | None:
    """What short times hold, by the modified Allan deviation; None where neither kind of angle noise rules there.

    Parameters
    ----------
    record : Record
        The one that was fitted; where samples are missing, its longest run without a gap is looked at.
    fitted : NoiseFit
    threads : int, optional

    Returns
    -------
    Finding or None
        ``"white_angle_noise"``, an info, or ``"flicker_angle_noise"``, a warning.
    """
    stream = record.stream_of(fitted.channel).only(fitted.channel).longest_run()
    sizes = _SIZES[stream.grid.n >= _LEAST_CLUSTERS * _SIZES]
    if len(sizes) < 3:
        return None
    rates = stream.samples.read(0, 0, min(stream.grid.n, _ENOUGH))
    one = Record.from_arrays(rate=1.0, x=rates)
    plain = allan(one, taus=sizes, threads=threads)["x"].avar
    if plain[0] < _STEEP * plain[2]:
        return None
    modified = deviation(one, kind="modified", taus=sizes, threads=threads)["x"].deviation ** 2
    if not min(plain.min(), modified.min()) > 0:  # samples that repeat themselves
        return None
    taus = sizes * fitted.tau0
    with_flicker, shares, beside = _told_apart(sizes, plain, modified, len(rates))
    at = int(np.argmax(shares[_FLICKER]))
    noise = _NAMES.get(fitted.quantity, "noise of the sum")
    tau = f"τ = {seconds(float(taus[at]))} s"
    if beside - with_flicker >= _EXPLAINED and with_flicker <= _LEFT * (beside - with_flicker):
        if shares[_FLICKER, at] < _SHARE:
            return None
        quantized = "quantization" in fitted.model
        return Finding(
            code="flicker_angle_noise",
            severity="warning",
            channel=fitted.channel,
            message=(
                f"by the modified deviation, {shares[_FLICKER, at]:.0%} of the variance at {tau} is flicker {noise},"
                " not quantization"
            ),
            effect=(
                "it is no term of the model: "
                + ("the quantization coefficient describes the Allan deviation there and no more" if quantized else "")
                + (", and " if quantized else "")
                + "a random walk that is seen may be several times too large"
            ),
        )
    at = int(np.argmax(sizes * (shares[_Q] >= _RULES)))
    if shares[_Q, at] < _RULES or beside > 2 * len(_SIZES) * _LEFT * _EXPLAINED:
        return None
    return Finding(
        code="white_angle_noise",
        severity="info",
        channel=fitted.channel,
        message=(
            f"by the modified deviation, {shares[_Q, at]:.0%} of the variance at τ = {seconds(float(taus[at]))} s is white"
            f" {noise}, as quantization makes, and no flicker"
        ),
    )


def _told_apart(
    m: NDArray[np.int64], plain: NDArray[np.float64], modified: NDArray[np.float64], n: int
) -> tuple[float, NDArray[np.float64], float]:
    """Misfit of three terms, their shares of the Allan variance by term and size, and the misfit without flicker.

    Variances have some n/m degrees of freedom; that those of neighbours and of the two kinds go together is left out,
    and the thresholds are far from what that could do.
    """
    size = m.astype(np.float64)
    of_plain = np.stack([3 / size**2, 1 / size, (1.038 + 3 * np.log(np.pi * size)) / size**2], axis=1)
    of_modified = np.stack([3 / size**3, (size**2 + 1) / (2 * size**3), 3.37 / size**2], axis=1)
    weight = np.sqrt(np.tile(n / size / 2, 2)) / np.concatenate([plain, modified])
    terms = np.concatenate([of_plain, of_modified]) * weight[:, np.newaxis]
    target = np.concatenate([plain, modified]) * weight
    misfit, parts = _not_negative(terms, target, (_Q, _N, _FLICKER))
    beside, _ = _not_negative(terms, target, (_Q, _N))
    found = (of_plain * parts).T
    return misfit, found / found.sum(axis=0), beside


def _not_negative(
    terms: NDArray[np.float64], target: NDArray[np.float64], allowed: tuple[int, ...]
) -> tuple[float, NDArray[np.float64]]:
    """Least squares over all choices of terms of which none comes out negative: the smallest misfit, and the parts."""
    best, parts = float("inf"), np.zeros(terms.shape[1])
    for count in range(1, len(allowed) + 1):
        for chosen in combinations(allowed, count):
            columns = list(chosen)
            scale = np.linalg.norm(terms[:, columns], axis=0)
            found = np.linalg.lstsq(terms[:, columns] / scale, target, rcond=None)[0]
            misfit = float(np.sum((terms[:, columns] / scale @ found - target) ** 2))
            if (found >= 0).all() and misfit < best:
                best, parts = misfit, np.zeros(terms.shape[1])
                parts[columns] = found / scale
    return best, parts


def untold(curve: DeviationCurve) -> Finding | None:
    """What is to be said of a curve without its samples: that one of the two may rule, and which does not show."""
    at = {int(m): float(avar) for m, avar in zip(curve.m, curve.avar, strict=True)}
    if not (4 in at and 16 in at) or at[4] < _STEEP * at[16]:
        return None
    noise = _NAMES.get(curve.quantity, "noise of the sum")
    return Finding(
        code="angle_noise_untold",
        severity="info",
        channel=curve.channel,
        message=f"short times hold quantization or flicker {noise}: the curve alone does not tell which",
        effect="`sigmatau analyze` tells it from the log, by the modified deviation",
    )
