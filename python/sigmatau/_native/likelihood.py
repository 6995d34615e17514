"""The likelihood of a channel: one pass over its samples, and the fit of its summary."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from sigmatau import _core
from sigmatau._core import MAX_LINES as MAX_LINES
from sigmatau._core import OUTLIER_ALPHA as OUTLIER_ALPHA
from sigmatau._core import ChannelFit as ChannelFit
from sigmatau._core import Estimate as Estimate
from sigmatau._core import FilterEstimate as FilterEstimate
from sigmatau._core import FittedModel as FittedModel
from sigmatau._core import GaussMarkovEstimate as GaussMarkovEstimate
from sigmatau._core import JointChannelFit as JointChannelFit
from sigmatau._core import LikelihoodSummary as LikelihoodSummary
from sigmatau._core import LineEstimate as LineEstimate
from sigmatau._core import MaternEstimate as MaternEstimate
from sigmatau._core import Parameter as Parameter
from sigmatau._core import ResonanceEstimate as ResonanceEstimate
from sigmatau._core import TermEstimate as TermEstimate
from sigmatau._core import WarmUpEstimate as WarmUpEstimate
from sigmatau._core import fit_jointly as fit_jointly
from sigmatau.arrays import Floats

MIN_SAMPLES = 256

_MIN_TAPER = 0.2  # shortest taper; below it, all weights of a run are 1 [samples]


def summarize(pieces: Iterable[Floats], *, samples: int, tau0: float) -> LikelihoodSummary:
    """One pass over the samples of a channel, given in consecutive pieces of any length.

    Parameters
    ----------
    pieces : iterable of ndarray, shape (n,)
    samples : int
        Samples of all pieces together.
    tau0 : float
        Sample interval. [s]

    Raises
    ------
    ValueError
        For fewer than `MIN_SAMPLES`, for a sample that is not finite or larger than 1e130.
    """
    return _walked(_core.LikelihoodPass(samples, tau0), pieces)


def summarize_masked(
    pieces: Callable[[], Iterable[Floats]], *, present: NDArray[np.bool_], tau0: float
) -> LikelihoodSummary:
    """Summarize a channel with missing samples in one pass, or in two with quantization noise or strong slow noise.

    Parameters
    ----------
    pieces : callable
        Returns the consecutive pieces on each call; missing samples may have any value.
    present : ndarray of bool, shape (n,)
        False where a sample is missing.
    tau0 : float
        Sample interval. [s]

    Raises
    ------
    ValueError
        As for `summarize`, and if the recorded samples are too few or too concentrated; see `enough`.
    """
    mask = np.ascontiguousarray(present, dtype=np.bool_)
    summary = _walked(_core.LikelihoodPass.masked(mask, tau0), pieces())
    taper, differences = summary.weighting()
    if taper < _MIN_TAPER and differences is None:
        return summary
    return _walked(_core.LikelihoodPass.masked(mask, tau0, taper, differences), pieces())


def enough(present: NDArray[np.bool_]) -> bool:
    """Whether a record with missing samples has enough samples, spread widely enough, to be summarised."""
    try:
        _core.LikelihoodPass.masked(np.ascontiguousarray(present, dtype=np.bool_), 1.0)
    except ValueError:
        return False
    return True


def _walked(walk: _core.LikelihoodPass, pieces: Iterable[Floats]) -> LikelihoodSummary:
    for piece in pieces:
        walk.push(np.ascontiguousarray(piece, dtype=np.float64))
    return walk.finish()
