"""White or flicker noise of the angle, told apart by the modified Allan deviation.

In the Allan deviation, both fall about as 1/τ. In the modified Allan deviation, white angle noise (quantization) falls as
τ^(-3/2), because the errors averaged over a cluster are independent; flicker angle noise still falls as 1/τ [1]_. The Allan
variance of flicker angle noise, proportional to (1.038 + 3 ln(2π f_h τ)) / τ², looks like quantization with a random walk,
which does not exist. The Allan and the modified Allan variances at short times are therefore fitted together by a
non-negative sum of quantization, flicker angle noise and random walk, and compared with the same sum without flicker.

References
----------
.. [1] D. W. Allan, J. A. Barnes, "A modified Allan variance with increased oscillator characterization ability," Proc.
   35th Annual Frequency Control Symposium, 1981, :doi:`10.1109/FREQ.1981.200514`; NIST SP 1065, sections 4.1 and 5.2.4.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sigmatau.arrays import Floats, Ints
from sigmatau.estimators.allan import DeviationCurve, allan
from sigmatau.estimators.deviation import deviation
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.fit import AngleNoiseUndetermined, FlickerAngleNoise, WhiteAngleNoise
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.non_negative import non_negative
from sigmatau.record.record import Record

__all__ = ["angle_noise", "undetermined"]

_SIZES = np.array([4, 8, 16, 32, 64], dtype=np.int64)  # cluster sizes [samples]
_LEAST_CLUSTERS = 12  # in the record, for a cluster size to be used
_MOST_SAMPLES = 1 << 20  # from the beginning; more do not improve the test at these short times

_LEAST_STEEPNESS = 5.0
"""Allan variance at 4 samples over that at 16: 4 for a random walk, 10.8 for flicker angle noise alone."""

_LEAST_IMPROVEMENT = 25.0  # flicker angle noise is present if it reduces the normalised sum of squares by so much
_MOST_RESIDUE = 0.2  # and if the sum of squares that is left is at most this share of the reduction
LEAST_FLICKER_SHARE = 0.3  # share of the variance from which on flicker angle noise is reported
_DOMINANT = 0.5  # share of the variance
_Q, _N, _FLICKER = range(3)


def angle_noise(
    record: Record, fitted: NoiseFit, *, least_share: float = LEAST_FLICKER_SHARE, threads: int | None = None
) -> Finding | None:
    """White or flicker noise of the angle at short averaging times, an info or a warning; None if neither dominates there.

    Of a record with missing samples, the longest run without a gap is used.

    Parameters
    ----------
    record, fitted : Record, NoiseFit
        The record that was fitted, and the fit of one channel.
    least_share : float
        See `LEAST_FLICKER_SHARE`.
    """
    stream = record.stream_of(fitted.channel).only(fitted.channel).longest_run()
    sizes = _SIZES[stream.grid.n >= _LEAST_CLUSTERS * _SIZES]
    if len(sizes) < 3:
        return None
    rates = stream.samples.read(0, 0, min(stream.grid.n, _MOST_SAMPLES))
    one = Record.from_arrays(rate=1.0, x=rates)
    plain = allan(one, taus=sizes, threads=threads)["x"].avar
    if plain[0] < _LEAST_STEEPNESS * plain[2]:
        return None
    modified = deviation(one, kind="modified", taus=sizes, threads=threads)["x"].deviation ** 2
    if not min(plain.min(), modified.min()) > 0:  # periodic samples
        return None
    taus = sizes * fitted.tau0
    with_flicker, shares, without_flicker = _decomposed(sizes, plain, modified, len(rates))
    at = int(np.argmax(shares[_FLICKER]))
    improvement = without_flicker - with_flicker
    if improvement >= _LEAST_IMPROVEMENT and with_flicker <= _MOST_RESIDUE * improvement:
        if shares[_FLICKER, at] < least_share:
            return None
        flicker = FlickerAngleNoise(
            quantity=fitted.quantity,
            share=float(shares[_FLICKER, at]),
            tau=float(taus[at]),
            quantization_fitted="quantization" in fitted.model,
        )
        return Finding(details=flicker, severity="warning", channels=(fitted.channel,))
    at = int(np.argmax(sizes * (shares[_Q] >= _DOMINANT)))
    if shares[_Q, at] < _DOMINANT or without_flicker > 2 * len(_SIZES) * _MOST_RESIDUE * _LEAST_IMPROVEMENT:
        return None
    white = WhiteAngleNoise(quantity=fitted.quantity, share=float(shares[_Q, at]), tau=float(taus[at]))
    return Finding(details=white, severity="info", channels=(fitted.channel,))


def _decomposed(m: Ints, plain: Floats, modified: Floats, n: int) -> tuple[float, Floats, float]:
    """Misfit of three terms, their shares of the Allan variance by term and size, and the misfit without flicker.

    A variance has about n/m degrees of freedom. Correlations are neglected; the thresholds are far above their effect.
    """
    size = m.astype(np.float64)
    of_plain = np.stack([3 / size**2, 1 / size, (1.038 + 3 * np.log(np.pi * size)) / size**2], axis=1)
    of_modified = np.stack([3 / size**3, (size**2 + 1) / (2 * size**3), 3.37 / size**2], axis=1)
    weight = np.sqrt(np.tile(n / size / 2, 2)) / np.concatenate([plain, modified])
    terms = np.concatenate([of_plain, of_modified]) * weight[:, np.newaxis]
    target = np.concatenate([plain, modified]) * weight
    misfit, parts = _fitted(terms, target, [_Q, _N, _FLICKER])
    without_flicker, _ = _fitted(terms, target, [_Q, _N])
    found = (of_plain * parts).T
    return misfit, found / found.sum(axis=0), without_flicker


def _fitted(terms: Floats, target: Floats, columns: Sequence[int]) -> tuple[float, Floats]:
    """Misfit and coefficients of the non-negative least squares fit of some of the terms."""
    found = np.zeros(terms.shape[1])
    found[columns] = non_negative(terms[:, columns], target)
    return float(np.sum((terms @ found - target) ** 2)), found


def undetermined(curve: DeviationCurve) -> Finding | None:
    """The finding for a curve without its samples: one of the two kinds dominates, and the curve cannot tell which."""
    at = {int(m): float(avar) for m, avar in zip(curve.m, curve.avar, strict=True)}
    if not (4 in at and 16 in at) or at[4] < _LEAST_STEEPNESS * at[16]:
        return None
    details = AngleNoiseUndetermined(quantity=curve.quantity)
    return Finding(details=details, severity="info", channels=(curve.channel,))
