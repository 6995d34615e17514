"""Modified, Hadamard, total, time and other deviations of a record.

References
----------
.. [1] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.arrays import freeze
from sigmatau.errors import OptionError
from sigmatau.estimators import deviation_kinds, theo
from sigmatau.estimators.allan import Overlap, refuse_missing
from sigmatau.estimators.deviation_kinds import KINDS, Kind, Noise, TauGrid, estimator, sizes_for, tau_in_samples
from sigmatau.estimators.noise_identification import NoiseIdentifications, channel_noise
from sigmatau.frozen import frozen
from sigmatau.noise.uncertainty import chi2_factors
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream
from sigmatau.results import ByChannel, Printed, plain
from sigmatau.units import integral

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


@frozen(eq=False)
class Deviation(Printed):
    """A deviation of one channel against averaging time.

    Attributes
    ----------
    channel : str
    kind : str
        See `sigmatau.deviation`.
    quantity : str
        Quantity of the channel.
    unit : str
        Unit of the deviation; SI. The unit of the rate; for time, MTIE and TIE rms the unit of its integral: rad, m/s.
    m : ndarray of int, shape (n_tau,)
        Cluster sizes in samples.
    tau : ndarray, shape (n_tau,)
        Averaging times: m·tau0, for Theo1 and TheoBR 0.75·m·tau0, for TheoH the first of these up to a tenth of the record.
        [s]
    deviation : ndarray, shape (n_tau,)
        [unit]
    n_terms : ndarray of int, shape (n_tau,)
        Number of squares averaged, or of windows searched for the MTIE.
    n : int
        Rate samples in the record.
    tau0 : float
        Sample interval. [s]
    overlap : {"full", "none"}

    See Also
    --------
    deviation : makes the deviations of a record.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> record = st.Record.from_arrays(rate=1.0, gyro_x=np.arange(16.0))
    >>> st.deviation(record, kind="hadamard", taus=[1, 2])["gyro_x"].label
    'Hadamard deviation'
    """

    channel: str
    kind: Kind
    quantity: str
    unit: str
    m: NDArray[np.int64]
    tau: NDArray[np.float64]
    deviation: NDArray[np.float64]
    n_terms: NDArray[np.int64]
    n: int
    tau0: float
    overlap: Overlap = "full"

    def __post_init__(self) -> None:
        freeze(self, "m", "tau", "deviation", "n_terms")

    @property
    def label(self) -> str:
        """Name of the deviation, as it is printed."""
        overlapped = "non-overlapped " if self.overlap == "none" else ""
        return overlapped + KINDS[self.kind].label

    def edf(self, *, noise: Noise) -> NDArray[np.float64]:
        """Equivalent degrees of freedom of the squared deviations; see
        `sigmatau.estimators.deviation_kinds.degrees_of_freedom`.

        Parameters
        ----------
        noise : str, mapping of str to float, or tuple of str
            The name of a term, coefficients such as `NoiseFit.model`, or the name of a term for each averaging time, such as
            `NoiseIdentification.terms_near`. [SI]

        Returns
        -------
        ndarray, shape (n_tau,)
            Degrees of freedom.
        """
        return deviation_kinds.degrees_of_freedom(
            self.kind, noise, n=self.n, m=self.m, tau0=self.tau0, overlap=self.overlap
        )

    def bias(self, *, noise: str | Mapping[str, float]) -> NDArray[np.float64]:
        """Expected squared deviation over the variance that it estimates, for the total kinds and Theo1.

        See `sigmatau.estimators.deviation_kinds.bias`.

        Parameters
        ----------
        noise : str or mapping of str to float
            As in `Deviation.edf`.

        Returns
        -------
        ndarray, shape (n_tau,)
            Ratios.
        """
        return deviation_kinds.bias(self.kind, noise, n=self.n, m=self.m, tau0=self.tau0)

    def interval(self, *, noise: Noise, level: float = 0.95) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Confidence interval of the expected deviation of this kind, by χ² with `edf`.

        Parameters
        ----------
        noise : str, mapping of str to float, or tuple of str
            As in `Deviation.edf`.
        level : float
            Probability that the interval contains the true value.

        Returns
        -------
        low, high : ndarray, shape (n_tau,)
            [unit]
        """
        low, high = chi2_factors(self.edf(noise=noise), level=level)
        return self.deviation * low, self.deviation * high

    def to_dict(self, *, noise: Noise | None = None) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library.

        Parameters
        ----------
        noise : str, mapping of str to float, or tuple of str, optional
            As in `Deviation.edf`; the columns then have the 95 % interval too.

        Returns
        -------
        dict
        """
        columns = plain(self, "kind m tau_s=tau deviation n_terms overlap unit")
        if noise is not None:
            low, high = self.interval(noise=noise)
            columns |= {"low": low.tolist(), "high": high.tolist(), "edf": self.edf(noise=noise).tolist()}
        return columns

    def plot(self, ax: Axes | None = None, *, unit: str | None = None, noise: Noise | None = None) -> Figure:
        """Draw the curve, with its 95 % band if there is a `noise`.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.
        unit : str, optional
            Unit of the deviation. Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.
        noise : str, mapping of str to float, or tuple of str, optional
            As in `Deviation.edf`.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import draw_deviation
        from sigmatau.plot.style import parent_figure

        band = None if noise is None else self.interval(noise=noise)
        return parent_figure(draw_deviation(self, ax=ax, unit=unit, band=band))

    def __repr__(self) -> str:
        head = f"{self.channel}: {self.label}, {self.n} samples at {1 / self.tau0:.6g} Hz [{self.unit}]"
        rows = zip(self.tau, self.deviation, self.n_terms, strict=True)
        return "\n".join([head, *(f"  {tau:12.6g} s  {value:<12.6g} {terms} terms" for tau, value, terms in rows)])


class Deviations(ByChannel[Deviation]):
    """Deviations by channel: an immutable mapping in the record's order.

    See Also
    --------
    deviation : makes the deviations of a record.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> list(st.deviation(st.Record.from_arrays(rate=100, gyro=np.zeros((100, 3))), kind="modified"))
    ['gyro_x', 'gyro_y', 'gyro_z']
    """

    __slots__ = ()

    def to_dict(self, *, noise: Noise | NoiseIdentifications | None = None) -> dict[str, Any]:
        """Each deviation as plain columns, by channel.

        Parameters
        ----------
        noise : str, mapping of str to float, or tuple of str, optional
            As in `Deviation.edf`, or the `NoiseIdentifications` of the record; the columns then have the 95 % interval too.

        Returns
        -------
        dict
        """
        return {
            channel: deviation.to_dict(noise=None if noise is None else channel_noise(noise, channel, deviation.tau))
            for channel, deviation in self.items()
        }

    def plot(self, ax: Panels = None, *, noise: Noise | NoiseIdentifications | None = None) -> Figure:
        """Draw all deviations, one panel per quantity and unit.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.
        noise : str, mapping of str to float, or tuple of str, optional
            As in `Deviation.edf`, or the `NoiseIdentifications` of the record; each curve then has its 95 % band.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import draw_deviations

        bands = (
            {}
            if noise is None
            else {name: curve.interval(noise=channel_noise(noise, name, curve.tau)) for name, curve in self.items()}
        )
        return draw_deviations(self, bands, ax=ax)


def deviation(
    record: Record,
    *,
    kind: Kind,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap | None = None,
    threads: int | None = None,
    progress: Callable[[float], object] | None = None,
) -> Deviations:
    """Modified, Hadamard, parabolic, total, time, Theo1, MTIE or TIE rms deviation of every channel of a record.

    The estimators use the N+1 phase points x of N rate samples, as defined in NIST SP 1065 [1]_ and, for parabolic, in [2]_:

    ================== ======================================================================== ============
    kind               average of                                                               m
    ================== ======================================================================== ============
    ``modified``       second differences of the phase averaged over m points; N+2−3m terms     ≤ (N+1)/3
    ``hadamard``       third differences of the phase; N+1−3m terms. Blind to a ramp            ≤ N/3
    ``parabolic``      differences of slopes fitted to m points of the phase; N+1−2m terms      ≤ N/2
    ``total``          second differences of the phase reflected at both ends; N−1 terms        < N
    ``modified_total`` modified, of each 3m points without slope, reflected; N+2−3m stretches   ≤ (N+1)/3
    ``hadamard_total`` Hadamard, of each 3m rates without slope, reflected; N+1−3m stretches    ≤ N/3
    ``time``           τ/√3 times the modified deviation                                        ≤ (N+1)/3
    ``time_total``     τ/√3 times the modified total deviation                                  ≤ (N+1)/3
    ``theo1``          differences of differences over all steps up to m/2; τ is 0.75 m τ₀      10 … N, even
    ``theobr``         Theo1 times its mean ratio to Allan up to a tenth of the record          10 … N, even
    ``theoh``          the Allan deviation up to a tenth of the record, then TheoBR             1 … N
    ``mtie``           largest range of the phase in any window of m+1 points                   ≤ N
    ``tie_rms``        root mean square of the phase's movement in m samples                    ≤ N
    ================== ======================================================================== ============

    Time, time total, MTIE and TIE rms have the unit of the integral of the rate; all others have the unit of the rate. A
    constant rate affects only MTIE and TIE rms. The total kinds and Theo1 have a bias, see `Deviation.bias`.

    Parameters
    ----------
    record : Record
        Static data, no sample missing.
    kind : str
        The estimator, a name of the table. Theo1 takes N·m steps for every m, minutes for a million samples; modified, time
        and Hadamard total take 20 times as long. TheoBR and TheoH take up to 50 000 samples. The other kinds take N steps.
    taus : {"octave", "half", "quarter", "eighth"} or array_like, shape (n_tau,)
        As in `sigmatau.allan`, up to the longest time of the kind (total: half the record by default). [s]
    overlap : {"full", "none"}, optional
        Only for the Hadamard deviation: all terms (default), or those of disjoint clusters.
    threads : int, optional
        Default: all cores. Results do not depend on it, bit for bit.
    progress : callable, optional
        Called from time to time with the completed fraction of the work, 0 to 1; an exception that it raises ends the
        work.

    Returns
    -------
    Deviations
        A mapping from channel to `Deviation`.

    Raises
    ------
    TypeError
        If `record` is not a record.
    NonFiniteError
        If a sample is missing.
    RecordTooShortError
        If no cluster size is left.
    OptionError
        For an unknown kind, a time outside its range, or an option that the kind does not have.

    See Also
    --------
    allan : Allan variance, on which fits are based.

    References
    ----------
    .. [1] NIST Special Publication 1065, sections 5.2.4 to 5.2.17.
    .. [2] F. Vernotte, M. Lenczner, P.-Y. Bourgeois, E. Rubiola, "The parabolic variance (PVAR), a wavelet variance based
       on the least-square fit," IEEE Trans. UFFC 63(4), 2016.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> st.deviation(record, kind="hadamard", taus=[0.01, 1])["gyro_x"].n_terms
    array([59998, 59701])
    """
    need_record(record)
    estimator(kind)
    if overlap is not None and kind != "hadamard":
        raise OptionError(
            f"{{option}} is an option of the Hadamard deviation; the {KINDS[kind].label} has one form only: omit it",
            option="overlap",
        )
    for stream in record.streams:
        refuse_missing(stream, f"the {KINDS[kind].label}")
    sizes = [sizes_for(kind, taus, n=stream.grid.n, tau0=stream.grid.tau0) for stream in record.streams]
    bar = _Bar(progress, sum(_work(kind, stream, m) for stream, m in zip(record.streams, sizes, strict=True)))
    deviations: dict[str, Deviation] = {}
    for stream, m in zip(record.streams, sizes, strict=True):
        deviations.update(_stream_deviations(stream, kind, m, overlap=overlap or "full", threads=threads, bar=bar))
    return Deviations(deviations)


class _Bar:
    """Progress of the work."""

    def __init__(self, tell: Callable[[float], object] | None, whole: float) -> None:
        self._tell, self._whole, self._done = tell, whole, 0.0

    def add(self, work: float) -> None:
        self._done += work
        if self._tell is not None:
            self._tell(min(self._done / self._whole, 1.0))


def _work(kind: Kind, stream: Stream, m: NDArray[np.int64]) -> float:
    """Approximate number of terms."""
    n, steps = float(stream.grid.n), KINDS[kind].steps
    if kind in ("theobr", "theoh"):
        return len(stream.channels) * theo.steps(stream.grid.n, m, hybrid=kind == "theoh")
    return len(stream.channels) * float(np.sum((n - m) * m * steps if steps else np.full(len(m), n)))


def _stream_deviations(
    stream: Stream, kind: Kind, sizes: NDArray[np.int64], *, overlap: Overlap, threads: int | None, bar: _Bar
) -> dict[str, Deviation]:
    chosen, tau0 = KINDS[kind], stream.grid.tau0
    columns = [stream.column(channel) for channel in stream.channels]
    if kind in ("theobr", "theoh"):
        values, terms = theo.theo_deviations(
            columns, sizes, stream.channels, hybrid=kind == "theoh", threads=threads, tell=bar.add
        )
    else:
        # Some kinds take N·m steps. One size is computed at a time, so that progress is visible and it can be stopped.
        parts = [sizes[i : i + 1] for i in range(len(sizes))] if chosen.steps else [sizes]
        results = []
        for m in parts:
            results.append(
                kernels.deviations(chosen.kernel, columns, m, overlap=overlap, threads=threads, names=stream.channels)
            )
            bar.add(_work(kind, stream, m))
        values = [np.concatenate([part[c] for part, _ in results]) for c in range(len(columns))]
        terms = np.concatenate([part for _, part in results])
    tau = np.asarray(tau_in_samples(kind, stream.grid.n, sizes) * tau0, dtype=np.float64)
    factor: NDArray[np.float64] | float = 1.0
    if kind in ("time", "time_total"):
        factor = tau / np.sqrt(3.0)
    elif chosen.has_phase_unit:
        factor = tau0
    return {
        channel: Deviation(
            channel=channel,
            kind=kind,
            quantity=stream.quantity,
            unit=_phase_unit(stream.unit) if chosen.has_phase_unit else stream.unit,
            m=sizes,
            tau=tau,
            deviation=factor * value,
            n_terms=terms,
            n=stream.grid.n,
            tau0=tau0,
            overlap=overlap,
        )
        for channel, value in zip(stream.channels, values, strict=True)
    }


def _phase_unit(unit: str) -> str:
    """Unit of the integral of a rate; the rate of a phase in seconds has the unit 1."""
    if unit in ("rad/s", "m/s^2"):
        return integral(unit)
    return "s" if unit == "1" else unit.removesuffix("/s") if unit.endswith("/s") else f"{unit}·s"
