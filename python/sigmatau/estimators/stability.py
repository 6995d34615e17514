"""Dynamic Allan variance: changes of the noise within a record.

The Allan variance of a sliding window is drawn as a map over time and averaging time, which shows changing noise, shocks and
temporary vibration. For a statistical test see `sigmatau.quality.drift.stationarity.non_stationary`.

References
----------
.. [1] L. Galleani, P. Tavella, "The characterization of clock behavior with the dynamic Allan variance," Proc. IEEE FCS and
   EFTF, 2003, pp. 239-244.
.. [2] L. Galleani, P. Tavella, "The dynamic Allan variance," IEEE Trans. Ultrason. Ferroelectr. Freq. Control, vol. 56,
   no. 3, 2009, :doi:`10.1109/TUFFC.2009.1064`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.arrays import freeze
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.estimators.allan import allan
from sigmatau.estimators.deviation_kinds import TauGrid, cluster_sizes
from sigmatau.frozen import frozen
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream
from sigmatau.results import Printed, duration_text, plain, seconds

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DEFAULT_WINDOWS = 10
_MIN_SAMPLES = 16
MIN_SAMPLES_OF_MAP = _DEFAULT_WINDOWS * _MIN_SAMPLES
"""Samples that a dynamic Allan deviation with windows of the default length needs."""
_MAX_WINDOWS = 2000
_PRINTED_ROWS = 12
_MAX_MISSING = 0.1  # largest share of missing samples in a window


@frozen(eq=False)
class DynamicAllan(Printed):
    """Allan deviation of one channel over time and averaging time.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Quantity and unit of the rate; SI.
    times : ndarray, shape (n_times,)
        Middle of each window, from the beginning of the whole record. [s]
    tau : ndarray, shape (n_tau,)
        Averaging times. [s]
    adev : ndarray, shape (n_times, n_tau)
        Overlapped Allan deviation of each window; NaN where a window misses more than a tenth of its samples. [unit]
    n : int
        Samples in a window.
    window, step : float
        Length of a window, and distance between the beginnings of neighbouring windows. [s]

    See Also
    --------
    sigmatau.dynamic_allan : makes it.
    """

    channel: str
    quantity: str
    unit: str
    times: NDArray[np.float64]
    tau: NDArray[np.float64]
    adev: NDArray[np.float64]
    n: int
    window: float
    step: float

    def __post_init__(self) -> None:
        freeze(self, "times", "tau", "adev")

    @property
    def spread(self) -> NDArray[np.float64]:
        """Ratio of the largest to the smallest deviation of all windows, by averaging time; shape (n_tau,).

        NaN if no window has a deviation.
        """
        complete = self.adev[np.isfinite(self.adev).all(axis=1)]
        if len(complete) == 0:
            return np.full(len(self.tau), np.nan)
        low = complete.min(axis=0)
        return np.asarray(np.where(low > 0, complete.max(axis=0) / np.where(low > 0, low, 1.0), np.nan))

    def to_dict(self) -> dict[str, Any]:
        """Plain values for JSON; None for a window without a deviation."""
        fields = "channel quantity unit window_s=window step_s=step samples_in_window=n time_s=times tau_s=tau"
        adev = [row.tolist() if np.isfinite(row).all() else None for row in self.adev]
        return plain(self, fields, estimator="overlapped", adev=adev)

    def plot(self, ax: Axes | None = None, *, unit: str | None = None) -> Figure:
        """Draw the map with its colour bar, in new or given axes.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.
        unit : str, optional
            Unit of the deviation. Default: deg/h for gyros, µg for accelerometers, the unit of any other signal.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.stability import draw_dynamic
        from sigmatau.plot.style import parent_figure

        return parent_figure(draw_dynamic(self, ax=ax, unit=unit))

    def __repr__(self) -> str:
        complete = np.isfinite(self.adev).all(axis=1)
        lines = [
            f"{self.channel}: dynamic Allan deviation [{self.unit}], {len(self.times)} windows of"
            f" {duration_text(self.window)}, one every {duration_text(self.step)}"
        ]
        missing = int((~complete).sum())
        if missing:
            lines.append(f"  {missing} windows miss more than a tenth of their samples and have no deviation")
        if complete.any():
            lines.append(f"  {'τ':>10}    median     smallest   largest    largest at t")
            chosen = np.unique(np.round(np.linspace(0, len(self.tau) - 1, _PRINTED_ROWS)).astype(int))
            adev = self.adev[complete]
            for k in chosen:
                when = seconds(float(self.times[complete][int(np.argmax(adev[:, k]))]))
                values = "  ".join(f"{v:<9.4g}" for v in (np.median(adev[:, k]), adev[:, k].min(), adev[:, k].max()))
                lines.append(f"  {seconds(float(self.tau[k])):>8} s    {values}  {when} s")
        return "\n".join(lines)


def dynamic_allan(
    data: Record | Stream,
    channel: str,
    *,
    window: float | None = None,
    step: float | None = None,
    taus: TauGrid | ArrayLike = "half",
    threads: int | None = None,
) -> DynamicAllan:
    """Dynamic Allan variance of a channel: the overlapped Allan deviation of sliding windows [1]_ [2]_.

    Parameters
    ----------
    data : Record or Stream
        A window with more than a tenth of its samples missing has no deviation.
    channel : str
        Name of the channel.
    window : float, optional
        Length of a window. Default: a tenth of the record. [s]
    step : float, optional
        Distance from one window to the next. Default: half a window. [s]
    taus : {"octave", "half", "quarter", "eighth", "all"} or array_like, shape (n_tau,)
        As in `sigmatau.allan`, for a record as long as a window. Default: up to a third of the window; longer times
        have fewer than three degrees of freedom. [s]
    threads : int, optional
        Default: all cores. Results do not depend on it.

    Returns
    -------
    DynamicAllan

    Raises
    ------
    KeyError
        For an unknown channel.
    OptionError
        For a window longer than the record or shorter than 16 samples, a step that is not positive or makes more than
        2000 windows, or times that do not fit into a window.
    RecordTooShortError
        If a tenth of the record has fewer than 16 samples and no window is given.

    See Also
    --------
    allan : Allan variance of the whole record.
    check : tests whether the noise is stationary.

    References
    ----------
    .. [1] Proc. IEEE FCS and EFTF, 2003.
    .. [2] :doi:`10.1109/TUFFC.2009.1064`

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> st.dynamic_allan(record, "gyro_x", window=100, taus=[1.0]).adev.shape
    (11, 1)
    """
    need_record(data, name="data", stream=True)
    stream = data.stream_of(channel) if isinstance(data, Record) else data
    if channel not in stream.channels:
        raise KeyError(f"no channel {channel!r}; the stream has {', '.join(stream.channels)}")
    tau0, total = stream.grid.tau0, stream.grid.n
    n = _samples("window", window, tau0) if window is not None else total // _DEFAULT_WINDOWS
    if n > total:
        raise OptionError(f"a window of {window:g} s is longer than the record ({total * tau0:.6g} s)", option="window")
    if n < _MIN_SAMPLES:
        if window is None:
            raise RecordTooShortError(
                f"{total} samples do not make ten windows of {_MIN_SAMPLES}", need=MIN_SAMPLES_OF_MAP, got=total
            )
        raise OptionError(
            f"a window of {window:g} s has {n} samples; at least {_MIN_SAMPLES} are needed", option="window"
        )
    stride = _samples("step", step, tau0) if step is not None else max(n // 2, 1)
    count = (total - n) // stride + 1
    if count > _MAX_WINDOWS:
        raise OptionError(f"{{option}} makes {count} windows; at most {_MAX_WINDOWS} can be asked for", option="step")
    sizes = cluster_sizes(taus, n=n, tau0=tau0)
    if isinstance(taus, str):
        sizes = sizes[sizes <= n // 3]
    single = stream.only(channel)
    adev = np.full((count, len(sizes)), np.nan)
    for k in range(count):
        part = single.cut(k * stride, k * stride + n)
        if part.mask is not None and part.mask.mean() > _MAX_MISSING:
            continue
        curve = allan(Record(streams=(part,)), taus=sizes * tau0, threads=threads)[channel]
        adev[k, np.isin(sizes, curve.m)] = curve.adev
    return DynamicAllan(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        times=np.array([stream.grid.time(k * stride + n / 2) for k in range(count)], dtype=np.float64),
        tau=np.asarray(sizes * tau0, dtype=np.float64),
        adev=adev,
        n=n,
        window=n * tau0,
        step=stride * tau0,
    )


def _samples(name: str, value: float, tau0: float) -> int:
    if not (math.isfinite(value) and value >= tau0 / 2):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {value!r}", option=name)
    return max(round(value / tau0), 1)
