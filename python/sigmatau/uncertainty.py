"""How sure a deviation is.

References
----------
.. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
   IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["percentage_error"]


def percentage_error(n: int, m: ArrayLike) -> NDArray[np.float64]:
    """The paper's relative standard error of an Allan deviation, δ = 1/√(2(N/n − 1)), eq. (26) of [1]_.

    It counts independent clusters and knows neither the noise nor the overlap. Measured against the true error of the
    overlapped deviation it is about right for rate random walk, some 20 % too large for white noise, several times too
    large for quantization noise, and its symmetric interval is too short beyond a tenth of the record; see
    ``docs/theory/read-off.md``.

    Parameters
    ----------
    n : int
        Samples in the record (the paper's N).
    m : array_like of int
        Cluster sizes in samples (the paper's n), below `n`.

    Returns
    -------
    ndarray
        Relative error of the deviation, one standard error.

    Raises
    ------
    ValueError
        If a cluster size is below 1 or not below `n`.

    Examples
    --------
    >>> percentage_error(2000, [10, 500]).round(4)
    array([0.0501, 0.4082])
    """
    sizes = np.atleast_1d(np.asarray(m, dtype=float))
    if sizes.size and (sizes.min() < 1 or sizes.max() >= n):
        raise ValueError(f"`m` must lie in 1 … {n - 1} (below the {n} samples of the record)")
    return np.asarray(1 / np.sqrt(2 * (n / sizes - 1)))
