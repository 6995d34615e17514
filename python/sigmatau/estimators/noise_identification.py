"""Type of the noise at each averaging time, from the lag-1 autocorrelation, and from B1 and R(n) where it is too short.

References
----------
.. [1] W. J. Riley, C. A. Greenhall, "Power law noise identification using the lag 1 autocorrelation," Proc. 18th European
   Frequency and Time Forum, 2004.
.. [2] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008, section 5.5.
.. [3] D. A. Howe, R. L. Beard, C. A. Greenhall, F. Vernotte, W. J. Riley, T. K. Peppler, "Enhancements to GPS operations and
   clock evaluations using a 'total' Hadamard deviation," IEEE Trans. UFFC 52(8), 2005.
"""

from __future__ import annotations

import itertools
import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.arrays import freeze
from sigmatau.errors import RecordTooShortError
from sigmatau.estimators.allan import refuse_missing
from sigmatau.estimators.deviation_kinds import Noise, TauGrid, cluster_sizes
from sigmatau.frozen import frozen
from sigmatau.record.record import Record, need_record
from sigmatau.results import ByChannel, Printed, plain

LEAST_MEANS = 30  # cluster means that the autocorrelation needs [1]_
LEAST_MEANS_B1 = 4  # cluster means that B1 needs: of two, it is 1 for any noise

Method = Literal["lag 1", "B1", "R(n)"]

# Terms by the power α of the density of the rate. Flicker noise of the phase, α = 1, is not a term.
TERM_BY_POWER = {2: "quantization", 0: "random_walk", -1: "bias_instability", -2: "rate_random_walk"}
# Power μ of the Allan variance, σ² ~ τ^μ, by α.
_AVAR_POWER = {2: -2, 1: -2, 0: -1, -1: 0, -2: 1, -3: 2}


@frozen(eq=False)
class NoiseIdentification(Printed):
    """Type of the noise of one channel at each averaging time.

    Attributes
    ----------
    channel : str
    m : ndarray of int, shape (n_tau,)
        Cluster sizes in samples.
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    alpha : ndarray of int, shape (n_tau,)
        Power of the density of the rate, f^α: 2 quantization, 1 flicker noise of the phase, 0 random walk, −1 bias
        instability, −2 rate random walk, −3 steeper.
    methods : tuple of str
        ``"lag 1"``, ``"B1"`` or ``"R(n)"``, for each averaging time.
    n_means : ndarray of int, shape (n_tau,)
        Number of cluster means. A time with fewer than 4 has the type of the longest time with 4.

    See Also
    --------
    identify_noise : makes it of a record.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> st.identify_noise(record, taus=[1, 10])["gyro_x"].terms
    ('random_walk', 'random_walk')
    """

    channel: str
    m: NDArray[np.int64]
    tau: NDArray[np.float64]
    alpha: NDArray[np.int64]
    methods: tuple[Method, ...]
    n_means: NDArray[np.int64]

    def __post_init__(self) -> None:
        freeze(self, "m", "tau", "alpha", "n_means")

    @property
    def terms(self) -> tuple[str | None, ...]:
        """Name of the noise term at each averaging time; None for α = 1 and α = −3, which no term has."""
        return tuple(TERM_BY_POWER.get(int(alpha)) for alpha in self.alpha)

    def terms_near(self, tau: ArrayLike) -> tuple[str, ...]:
        """Term for the interval of a deviation at each time: the type at the next averaging time, a random walk for α = 1,
        whose interval is wider, and a rate random walk for α = −3.

        Parameters
        ----------
        tau : array_like, shape (n_tau,)
            Averaging times. [s]

        Returns
        -------
        tuple of str
        """
        index = np.abs(np.log(self.tau) - np.log(np.atleast_1d(tau))[:, None]).argmin(axis=1)
        substitutes = {1: "random_walk", -3: "rate_random_walk"} | TERM_BY_POWER
        return tuple(substitutes[int(alpha)] for alpha in self.alpha[index])

    def to_dict(self) -> dict[str, object]:
        """Plain columns, for JSON or any data-frame library."""
        return plain(self, "m tau_s=tau alpha n_means") | {"methods": list(self.methods), "terms": list(self.terms)}

    def __repr__(self) -> str:
        rows = zip(self.tau, self.alpha, self.terms, self.methods, self.n_means, strict=True)
        return "\n".join(
            [
                f"{self.channel}: type of the noise",
                *(
                    f"  {tau:12.6g} s  α = {alpha:<2}  {(term or '-').replace('_', ' '):16}  {method}, {count} means"
                    for tau, alpha, term, method, count in rows
                ),
            ]
        )


class NoiseIdentifications(ByChannel[NoiseIdentification]):
    """Types of noise by channel: an immutable mapping in the record's order.

    See Also
    --------
    identify_noise : makes them of a record.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> record = st.Record.from_arrays(rate=100, gyro=np.random.default_rng(1).standard_normal((100, 3)))
    >>> list(st.identify_noise(record))
    ['gyro_x', 'gyro_y', 'gyro_z']
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, object]:
        """Plain columns, by channel."""
        return {channel: identification.to_dict() for channel, identification in self.items()}


def channel_noise(noise: Noise | NoiseIdentifications, channel: str, tau: NDArray[np.float64]) -> Noise:
    """The noise of a channel for the intervals of a deviation at the times `tau`."""
    return noise[channel].terms_near(tau) if isinstance(noise, NoiseIdentifications) else noise


def identify_noise(record: Record, *, taus: TauGrid | ArrayLike = "octave") -> NoiseIdentifications:
    """Type of the noise of every channel at each averaging time, as Stable32 does before it chooses a confidence interval.

    The lag-1 autocorrelation r of the means of at least 30 clusters, without their slope, gives α = −2(δ + d),
    δ = r/(1 + r), after d differences, until δ < 1/4 or d = 2 [1]_. For fewer means, the ratio B1 of their sample variance
    to the Allan variance is compared with its expectation for each α, and, where these agree, the ratio R(n) of the modified
    to the Allan variance [2]_. The type is a label of the slope and has no interval; `analyze` gives intervals.

    Parameters
    ----------
    record : Record
        Static data, no sample missing.
    taus : {"octave", "half", "quarter", "eighth"} or array_like, shape (n_tau,)
        As in `sigmatau.allan`. [s]

    Returns
    -------
    NoiseIdentifications
        A mapping from channel to `NoiseIdentification`.

    Raises
    ------
    TypeError
        If `record` is not a record.
    NonFiniteError
        If a sample is missing.
    RecordTooShortError
        For fewer than 4 samples.
    OptionError
        For a time that is too short or longer than half the record.

    See Also
    --------
    analyze : fits all terms together.

    References
    ----------
    .. [1] W. J. Riley, C. A. Greenhall, "Power law noise identification using the lag 1 autocorrelation," Proc. 18th EFTF,
       2004.
    .. [2] NIST Special Publication 1065, section 5.5.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"rate_random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=10, rng=1)
    >>> st.identify_noise(record, taus=[1, 3])["gyro_x"].alpha
    array([-2, -2])
    """
    need_record(record)
    identifications: dict[str, NoiseIdentification] = {}
    for stream in record.streams:
        refuse_missing(stream, "the type of the noise")
        n, tau0 = stream.grid.n, stream.grid.tau0
        sizes = cluster_sizes(taus, n=n, tau0=tau0)
        if n < LEAST_MEANS_B1:
            raise RecordTooShortError(
                f"{n} samples are too few for the type of the noise: at least {LEAST_MEANS_B1} are needed",
                need=LEAST_MEANS_B1,
                got=n,
            )
        used = np.minimum(sizes, n // LEAST_MEANS_B1)
        for channel in stream.channels:
            results = [_identify(stream.column(channel), int(m), channel) for m in used]
            identifications[channel] = NoiseIdentification(
                channel=channel,
                m=sizes,
                tau=np.asarray(sizes * tau0, dtype=np.float64),
                alpha=np.array([alpha for alpha, _ in results], dtype=np.int64),
                methods=tuple(method for _, method in results),
                n_means=n // used,
            )
    return NoiseIdentifications(identifications)


def _identify(rate: NDArray[np.float64], m: int, name: str) -> tuple[int, Method]:
    means = rate[: len(rate) // m * m].reshape(-1, m).mean(axis=1)
    if len(means) >= LEAST_MEANS:
        return lag_1_power(means), "lag 1"
    size = np.array([m])
    (avar,), _, _ = kernels.allan_variances([rate], size, overlap="none", counting="standard", threads=1, names=[name])
    alpha = b1_power(float(np.var(means, ddof=1) / avar[0]) if avar[0] > 0 else 1.0, len(means))
    if alpha < 2 or m == 1 or 3 * m > len(rate) + 1:
        return alpha, "B1"
    (mdev,), _ = kernels.deviations("modified", [rate], size, overlap="full", threads=1, names=[name])
    return rn_power(float(mdev[0] ** 2 / avar[0]), m), "R(n)"


def lag_1_power(means: NDArray[np.float64]) -> int:
    """α of cluster means by their lag-1 autocorrelation; they lose their slope first."""
    steps = np.arange(len(means)) - (len(means) - 1) / 2
    series = means - means.mean() - steps * (steps @ means) / (steps @ steps)
    for differences in range(3):
        centred = series - series.mean()
        power = float(centred @ centred)
        r = float(centred[:-1] @ centred[1:]) / power if power > 0 else 0.0
        delta = r / (1 + r)
        if delta < 0.25 or differences == 2:
            break
        series = np.diff(series)
    return int(np.clip(-round(2 * delta) - 2 * differences, -3, 2))


def b1_power(ratio: float, count: int) -> int:
    """α by B1; 2 stands for 2 and 1, which have the same expectation. Limits are geometric means of expectations."""
    expected = {alpha: _b1(count, _AVAR_POWER[alpha]) for alpha in (2, 0, -1, -2, -3)}
    powers = list(expected)
    for alpha, steeper in itertools.pairwise(powers):
        if ratio < math.sqrt(expected[alpha] * expected[steeper]):
            return alpha
    return powers[-1]


def _b1(count: int, mu: int) -> float:
    """Expected sample variance of `count` means over the Allan variance τ^μ [3]_."""
    if mu == 0:
        return count * math.log(count) / (2 * (count - 1) * math.log(2))
    return count * (1 - float(count) ** mu) / (2 * (count - 1) * (1 - 2.0**mu))


def rn_power(ratio: float, m: int) -> int:
    """α = 2 or 1 by the ratio of the modified to the Allan variance: 1/m for white noise of the phase."""
    allan = 1.038 + 3 * math.log(math.pi * m)
    flicker = 1.5 * math.log(256 / 27) / allan
    return 2 if ratio < math.sqrt(flicker / m) else 1
