"""Allan variance of a record.

References
----------
.. [1] N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance,"
   IEEE Trans. Instrum. Meas., vol. 57, no. 1, 2008, :doi:`10.1109/TIM.2007.908635`.
.. [2] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau._native.distributions import normal_quantile
from sigmatau.arrays import freeze
from sigmatau.digits import round_to_error
from sigmatau.errors import NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.deviation_kinds import TauGrid, check_coefficients, cluster_sizes
from sigmatau.frozen import frozen
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom, percentage_error
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.results import TablesByChannel, Tabular, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels, Style

Overlap = Literal["full", "none"]
Counting = Literal["standard", "paper"]

_COLUMNS = ("m", "tau", "avar", "n_pairs", "ramp", "edf", "stride")

_MAX_SAMPLES_WITH_GAPS = 100_000  # longest record with gaps for `taus="all"`: half a minute [samples]

# Grids with parts of an octave are printed completely, up to eighths of an octave for a record of 10⁸ samples.
_PRINTED_ROWS = 200


def scale_by_pairs(curve: DeviationCurve, edf: NDArray[np.float64]) -> NDArray[np.float64]:
    """Degrees of freedom with missing samples: those of a complete record, scaled by the share of pairs."""
    if not curve.missing:
        return edf
    starts = curve.n_pairs if curve.stride is None else curve.n_pairs * curve.stride
    return np.maximum(edf * starts / (curve.n + 1 - 2 * curve.m), np.minimum(edf, 1.0))


@frozen(eq=False)
class DeviationCurve(Tabular):
    """Allan deviation of one channel against averaging time.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Quantity and unit of the rate; SI.
    m : ndarray of int, shape (n_tau,)
        Cluster sizes in samples (the paper's n).
    tau : ndarray, shape (n_tau,)
        Averaging times m·tau0 (the paper's T). [s]
    avar : ndarray, shape (n_tau,)
        Allan variance. [unit²]
    n_pairs : ndarray of int, shape (n_tau,)
        Number of squared differences averaged.
    ramp : ndarray, shape (n_tau,)
        Estimated ramp of the rate at this averaging time: the mean of all overlapping second differences of the phase,
        over tau²; with missing samples, a least-squares fit with the actual distances between clusters. [unit/s]
    n : int
        Rate samples in the record.
    tau0 : float
        Sample interval. [s]
    overlap : {"full", "none"}
    counting : {"standard", "paper"}
    edf : ndarray or None, shape (n_tau,)
        Equivalent degrees of freedom of each variance for the fitted noise; None without a fit.
    stride : ndarray of int or None, shape (n_tau,)
        Distance of the starts of clusters in samples; None if they begin at every sample, or with `overlap` "none".
    missing : int
        Samples that are missing.
    digitising : ndarray or None, shape (n_tau, n_tau)
        Covariance of the relative errors of `adev` from reading a figure; None for a computed curve.

    See Also
    --------
    allan : makes the curves of a record.
    read_figure : makes the curves of a figure.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> record = st.Record.from_arrays(rate=1.0, gyro_x=np.array([0.0, 1.0] * 8))
    >>> curve = st.allan(record, taus=[1, 2])["gyro_x"]
    >>> curve.avar
    array([0.5, 0. ])
    """

    _dimensions = ("channel", "tau_s")

    channel: str
    quantity: str
    unit: str
    m: NDArray[np.int64]
    tau: NDArray[np.float64]
    avar: NDArray[np.float64]
    n_pairs: NDArray[np.int64]
    ramp: NDArray[np.float64]
    n: int
    tau0: float
    overlap: Overlap = "full"
    counting: Counting = "standard"
    edf: NDArray[np.float64] | None = None
    stride: NDArray[np.int64] | None = None
    missing: int = 0
    digitising: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        freeze(self, *_COLUMNS, "digitising")

    @property
    def adev(self) -> NDArray[np.float64]:
        """Allan deviation, the root of `avar`; shape (n_tau,). [unit]"""
        return np.sqrt(self.avar)

    @property
    def error(self) -> NDArray[np.float64]:
        """Relative standard error of `adev` by the paper's eq. (26), with the error of reading a figure; shape (n_tau,).

        See `sigmatau.noise.uncertainty.percentage_error`.
        """
        error = percentage_error(self.n, self.m)
        return error if self.digitising is None else np.hypot(error, np.sqrt(np.diag(self.digitising)))

    def interval(
        self, *, noise: str | Mapping[str, float] | None = None, level: float = 0.95
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Confidence interval of each deviation, by χ²; without `edf` and `noise` one standard error by eq. (26).

        Parameters
        ----------
        noise : str or mapping of str to float, optional
            The name of a term, or coefficients such as `NoiseFit.model`; the degrees of freedom are exact for this
            noise and overlapping clusters. Default: `edf`, which curves of `sigmatau.analyze` have. [SI]
        level : float
            Probability that the interval contains the true value.

        Returns
        -------
        low, high : ndarray, shape (n_tau,)
            [unit]

        Raises
        ------
        OptionError
            For an unknown noise, for `noise` with ``overlap="none"``, or for another level with eq. (26).

        Examples
        --------
        >>> import sigmatau as st
        >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
        >>> curve = st.allan(st.simulate(model, duration=600, rate=10, rng=1))["gyro_x"]
        >>> low, high = curve.interval(noise=st.fit(curve).model, level=0.99)
        """
        edf = self.edf if noise is None else self._freedom(noise)
        if edf is None:
            if level != 0.95:
                raise OptionError(
                    "{option} needs the noise, interval(noise='random_walk') or interval(noise=sigmatau.fit(curve).model):"
                    " without it the interval is one standard error by eq. (26)",
                    option="level",
                )
            return self.adev * np.maximum(1 - self.error, 0), self.adev * (1 + self.error)
        low, high = chi2_factors(edf, level=level)
        if self.digitising is not None:
            read = normal_quantile(0.5 + 0.5 * level) * np.sqrt(np.diag(self.digitising))
            low, high = np.exp(-np.hypot(np.log(low), read)), np.exp(np.hypot(np.log(high), read))
        return self.adev * low, self.adev * high

    def _freedom(self, noise: str | Mapping[str, float]) -> NDArray[np.float64]:
        if self.overlap != "full":
            raise OptionError("{option} needs a curve of overlapping clusters, overlap='full'", option="noise")
        return scale_by_pairs(self, degrees_of_freedom(check_coefficients(noise), n=self.n, m=self.m, tau0=self.tau0))

    def at(self, sizes: NDArray[np.int64]) -> DeviationCurve:
        """Select some of the cluster sizes.

        Parameters
        ----------
        sizes : ndarray of int, shape (n_chosen,)
            Cluster sizes that the curve has.

        Returns
        -------
        DeviationCurve
        """
        chosen = np.isin(self.m, sizes)
        columns = {name: getattr(self, name) for name in _COLUMNS}
        selected: dict[str, Any] = {name: None if c is None else c[chosen] for name, c in columns.items()}
        if self.digitising is not None:
            selected["digitising"] = self.digitising[np.ix_(chosen, chosen)]
        return replace(self, **selected)

    @property
    def interval_text(self) -> str:
        """Description of the intervals that `interval` returns."""
        if self.edf is None:
            read = "" if self.digitising is None else " and the error of reading the figure"
            return f"eq. (26){read}, one standard error"
        return "95 % confidence"

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = self.interval()
        optional = [name for name in ("edf", "stride") if getattr(self, name) is not None]
        optional += ["missing"] if self.missing else []
        read = {} if self.digitising is None else {"digitising_error": np.sqrt(np.diag(self.digitising))}
        estimator = "overlapped" if self.overlap == "full" else "non-overlapped"
        fields = "m tau_s=tau adev interval=interval_text n_pairs counting unit"
        return plain(self, fields, *optional, low=low, high=high, estimator=estimator, **read)

    def columns(self) -> dict[str, list[Any]]:
        """One row per averaging time, see `Tabular.columns`."""
        low, high = (edge.tolist() for edge in self.interval())
        rows = {"tau_s": self.tau.tolist(), "adev": self.adev.tolist(), "low": low, "high": high}
        same = {"channel": [self.channel] * len(self.m), "unit": [self.unit] * len(self.m)}
        return {"channel": same["channel"], **rows, "n_pairs": self.n_pairs.tolist(), "unit": same["unit"]}

    def plot(self, ax: Axes | None = None, *, unit: str | None = None, style: Style = "screen") -> Figure:
        """Draw the curve with its band, see `interval`.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.
        unit : str, optional
            Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.
        style : {"screen", "paper"}
            ``"paper"``: the size of a column of a two-column paper.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import draw_curve
        from sigmatau.plot.style import parent_figure, styled

        with styled(style):
            return parent_figure(draw_curve(self, ax=ax, unit=unit))

    def __repr__(self) -> str:
        missing = f" ({self.missing} missing)" if self.missing else ""
        head = f"{self.channel}: Allan deviation, {self.n} samples{missing} at {1 / self.tau0:.6g} Hz [{self.unit}]"
        low, high = self.interval()
        columns = np.stack([self.tau, self.adev, low, high], axis=1)
        left_out = len(columns) - _PRINTED_ROWS
        if left_out > 0:
            columns = np.delete(columns, np.s_[_PRINTED_ROWS // 2 : -_PRINTED_ROWS // 2], axis=0)
        rows = [f"  {tau:12.6g} s  {'  '.join(round_to_error(*value).cells)}" for tau, *value in columns.tolist()]
        if left_out > 0:
            rows.insert(_PRINTED_ROWS // 2, f"  {'…':>12}    {left_out} more")
        return "\n".join([head, f"  [ ]: {self.interval_text}", *rows])


class Curves(TablesByChannel[DeviationCurve]):
    """Curves by channel: an immutable mapping in the record's order.

    See Also
    --------
    allan : makes the curves of a record.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> curves = st.allan(st.Record.from_arrays(rate=100, gyro=np.zeros((100, 3))))
    >>> list(curves)
    ['gyro_x', 'gyro_y', 'gyro_z']
    """

    __slots__ = ()
    _dimensions = ("channel", "tau_s")

    def to_dict(self) -> dict[str, Any]:
        """Each curve as plain columns, by channel."""
        return {channel: curve.to_dict() for channel, curve in self.items()}

    def plot(self, ax: Panels = None, *, style: Style = "screen") -> Figure:
        """Draw all curves with their error bands, one panel per stream.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.
        style : {"screen", "paper"}
            ``"paper"``: the size of a column of a two-column paper.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import draw_analysis
        from sigmatau.plot.style import styled

        with styled(style):
            return draw_analysis(self, {channel: {} for channel in self}, ax=ax)


@overload
def allan(
    record: Record,
    *,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    threads: int | None = None,
) -> Curves: ...


@overload
def allan(
    record: ArrayLike,
    *,
    rate: float,
    unit: str | None = None,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    threads: int | None = None,
) -> DeviationCurve: ...


def allan(
    record: Record | ArrayLike,
    *,
    rate: float | None = None,
    unit: str | None = None,
    taus: TauGrid | ArrayLike = "half",
    overlap: Overlap = "full",
    counting: Counting = "standard",
    threads: int | None = None,
) -> Curves | DeviationCurve:
    """Allan variance of every channel of a record, or of one array.

    Averages the squares of all N+1−2m overlapping second differences of the phase, eq. (10) of [1]_ on the N+1 phase
    points that N rate samples make.

    Parameters
    ----------
    record : Record or array_like, shape (n,)
        Static data, or the samples of one signal with its `rate`. With missing samples, clusters are averaged over
        their present samples, and a pair counts if both clusters are at least half full; sizes without such a pair are
        omitted. The expected variance of such a curve is larger than that of a complete record: for a random walk by
        the share of missing samples, for quantization noise at long times by much more. `analyze` fits the samples
        instead.
    rate : float, optional
        Sampling rate of an array. [Hz]
    unit : str, optional
        Unit of an array, such as ``"deg/s"``.
    taus : {"octave", "half", "quarter", "eighth", "all"} or array_like, shape (n_tau,)
        Grid of averaging times from one sample up to half the record, by parts of an octave or every whole number of
        samples; or a list of times, rounded to whole samples (the result contains the rounded times). [s]
    overlap : {"full", "none"}
        Clusters that are averaged: all, eq. (10), or only those without common samples.
    counting : {"standard", "paper"}
        N+1−2m terms (NIST SP 1065 [2]_), or N−2m terms, eq. (6) applied literally to N rate samples.
    threads : int, optional
        Default: all cores. Results do not depend on it, bit for bit.

    Returns
    -------
    Curves or DeviationCurve
        A mapping from channel to `DeviationCurve`; for an array, a single curve.

    Raises
    ------
    RecordTooShortError
        If no cluster size is left.
    OptionError
        For a time that is not positive, below half a sample or above half the record, or an unknown grid; for "all" with
        missing samples in a long record, which would take hours.

    See Also
    --------
    deviation : modified, Hadamard, total and other deviations.
    Accumulator : Allan variance of a stream.
    fit : coefficients from a record.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`
    .. [2] NIST Special Publication 1065, eq. (11).

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> st.allan(record, taus=[0.01, 1])["gyro_x"].n_pairs
    array([59999, 59801])
    >>> st.allan([0.0, 1.0] * 8, rate=1.0, taus=[1, 2]).avar
    array([0.5, 0. ])
    """
    if not isinstance(record, Record):
        single = _as_record(record, rate, unit)
        return allan(single, taus=taus, overlap=overlap, counting=counting, threads=threads)["signal"]
    if rate is not None or unit is not None:
        raise OptionError(
            "{option} is for an array; a record has its own", option="rate" if rate is not None else "unit"
        )
    curves: dict[str, DeviationCurve] = {}
    for stream in record.streams:
        chosen = curves_of_stream(stream, taus=taus, overlap=overlap, counting=counting, threads=threads)
        _refuse_without_pairs(stream, chosen, stream.channels)
        curves.update(chosen)
    return Curves(curves)


def _as_record(samples: Any, rate: float | None, unit: str | None) -> Record:  # noqa: ANN401
    """A record of one signal; raises `TypeError` for anything but a one-dimensional array of numbers."""
    if hasattr(samples, "columns") or isinstance(samples, str | Mapping):
        raise TypeError(
            f"`record` must be a Record or an array, not a {type(samples).__name__}: see sigmatau.read for files and"
            " sigmatau.from_frame for data frames"
        )
    array = np.asarray(samples)
    if array.ndim != 1:
        raise TypeError(
            f"`record` must be a Record or an array of shape (n,), not {array.shape or type(samples).__name__}; several"
            " axes have names: sigmatau.Record.from_arrays(rate=100, gyro=array)"
        )
    if rate is None:
        raise OptionError("an array needs {option}, its sampling rate in Hz: allan(x, rate=100)", option="rate")
    return Record.from_arrays(rate=rate, signal=array, unit=None if unit is None else {"signal": unit})


def channel_curve(
    record: Record,
    channel: str,
    *,
    taus: TauGrid | ArrayLike,
    counting: Counting = "standard",
    threads: int | None = None,
) -> DeviationCurve:
    """Overlapped Allan variance of one channel of a record; see `allan`."""
    stream = next(stream for stream in record.streams if channel in stream.channels)
    computed = curves_of_stream(stream, (channel,), taus=taus, overlap="full", counting=counting, threads=threads)
    _refuse_without_pairs(stream, computed, (channel,))
    return computed[channel]


def curves_of_stream(
    stream: Stream,
    channels: tuple[str, ...] | None = None,
    *,
    taus: TauGrid | ArrayLike,
    overlap: Overlap,
    counting: Counting,
    threads: int | None,
) -> dict[str, DeviationCurve]:
    """Allan variances of some or all channels; channels with too many missing samples for a single pair are omitted."""
    channels = stream.channels if channels is None else channels
    # The paper's counting has one term less, thus none at m = n/2.
    terms_lost = 1 if counting == "paper" and overlap == "full" else 0
    sizes = cluster_sizes(taus, n=stream.grid.n - terms_lost, tau0=stream.grid.tau0)
    gaps = {channel: _missing(stream, channel) for channel in channels}
    whole = tuple(channel for channel in channels if gaps[channel] is None)
    curves: dict[str, DeviationCurve] = {}
    if whole:
        columns = [stream.column(channel) for channel in whole]
        variances, ramps, pairs = kernels.allan_variances(
            columns, sizes, overlap=overlap, counting=counting, threads=threads, names=whole
        )
        for channel, avar, ramp in zip(whole, variances, ramps, strict=True):
            curves[channel] = _curve(stream, channel, sizes, avar, ramp, pairs, overlap=overlap, counting=counting)
    for channel, missing in gaps.items():
        if missing is None:
            continue
        if isinstance(taus, str) and taus == "all" and stream.grid.n > _MAX_SAMPLES_WITH_GAPS:
            raise OptionError(
                f"{{option}} 'all' is for at most {_MAX_SAMPLES_WITH_GAPS} samples where some are missing; take a grid",
                option="taus",
            )
        avar, ramp, pairs = kernels.masked_variances(
            stream.column(channel), sizes, overlap=overlap, counting=counting, threads=threads, name=channel
        )
        has_pairs = pairs > 0
        if not has_pairs.any():
            continue
        used = missing[:-1] if terms_lost else missing
        curve = _curve(
            stream,
            channel,
            sizes[has_pairs],
            avar[has_pairs],
            ramp[has_pairs],
            pairs[has_pairs],
            overlap=overlap,
            counting=counting,
        )
        curves[channel] = replace(curve, missing=int(used.sum()))
    return {channel: curves[channel] for channel in channels if channel in curves}


def _refuse_without_pairs(stream: Stream, computed: Mapping[str, DeviationCurve], channels: tuple[str, ...]) -> None:
    """Raise `RecordTooShortError` for the first channel without a curve."""
    for channel in channels:
        if channel not in computed:
            gaps = _missing(stream, channel)
            missing = 0 if gaps is None else int(gaps.sum())
            raise RecordTooShortError(
                f"`{channel}` misses {missing} of {stream.grid.n} samples: no two neighbouring clusters of the averaging"
                " times are half full",
                need=2,
                got=stream.grid.n - missing,
            )


def _missing(stream: Stream, channel: str) -> NDArray[np.bool_] | None:
    """The missing samples of a channel; None if no sample is missing."""
    if stream.mask is None:
        return None
    missing = stream.mask[:, stream.channels.index(channel)]
    return missing if missing.any() else None


def _curve(
    stream: Stream,
    channel: str,
    sizes: NDArray[np.int64],
    avar: NDArray[np.float64],
    ramp: NDArray[np.float64],
    pairs: NDArray[np.int64],
    *,
    overlap: Overlap,
    counting: Counting,
) -> DeviationCurve:
    return DeviationCurve(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        m=sizes,
        tau=np.asarray(sizes * stream.grid.tau0, dtype=np.float64),
        avar=avar,
        n_pairs=pairs,
        ramp=ramp / stream.grid.tau0,
        n=stream.grid.n,
        tau0=stream.grid.tau0,
        overlap=overlap,
        counting=counting,
    )


def refuse_missing(stream: Stream, what: str, *, instead: str = "take the Allan deviation") -> None:
    """Raise `NonFiniteError` for a missing sample. `what` needs all samples; `instead` names an alternative that does
    not.
    """
    if stream.mask is None:
        return
    row, column = (int(i) for i in np.argwhere(stream.mask)[0])
    missing = int(stream.mask.any(axis=1).sum())
    raise NonFiniteError(
        f"`{stream.channels[column]}` has missing samples ({missing} rows, the first at index {row},"
        f" t = {row * stream.grid.tau0:.6g} s); {what} needs every one: {instead}, or the longest run"
        " without a gap, `Record.longest_run`",
        channel=stream.channels[column],
        index=row,
    )
