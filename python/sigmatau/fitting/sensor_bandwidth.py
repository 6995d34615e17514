"""Result of `sigmatau.bandwidth`: the filter of a sensor, N without aliasing, and the aliasing at each sampling rate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sigmatau.arrays import Floats, freeze
from sigmatau.digits import limit_text, round_to_error, significant, two_digits
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.fitted_values import Interval
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import ByChannel, Printed, aligned, lines_text, plain, wrapped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

PAPER_RATES = (3.0, 5.0)
"""Sampling rates that the paper recommends (section V), over the bandwidth."""

_NO_ALIASING = 0.01  # share of aliasing in N below which no digits are printed [%]

Verdict = Literal["adequate", "logs differ", "not explained", "rate too low"]


@frozen(eq=False)
class LoggedRate(Printed):
    """One log in the result.

    Attributes
    ----------
    name : str
    rate : float
        Sampling rate. [Hz]
    duration : float
        Duration of the samples that are used. [s]
    aliasing : Interval
        Factor by which sampling at this rate increases N. [1]
    random_walk : Interval
        N of these samples, including aliased noise, from this log alone with the fitted filter. [unit of N]
    p_value : float
        Goodness of the fit in the bins of this log. [1]
    lines : int
        Modes of lines that are left out.
    curve : DeviationCurve
        Its Allan deviation.
    """

    name: str
    rate: float
    duration: float
    aliasing: Interval
    random_walk: Interval
    p_value: float
    lines: int
    curve: DeviationCurve

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "name rate_hz=rate duration_s=duration aliasing random_walk p_value lines")


@frozen(eq=False)
class FilterResponse(Printed):
    """|H|² of a filter with its interval. The delay cannot be determined from a spectrum.

    Attributes
    ----------
    frequency : ndarray, shape (n_f,)
        [Hz]
    power, low, high : ndarray, shape (n_f,)
        |H|² of the best filter, and its range over the filters that explain the logs equally well. [1]
    """

    frequency: Floats
    power: Floats
    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        freeze(self, "frequency", "power", "low", "high", dtype=np.float64)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns."""
        return plain(self, "frequency_hz=frequency power low high")


@frozen(eq=False)
class AliasingCurve(Printed):
    """Factor of aliasing on N at any sampling rate, with its interval.

    Attributes
    ----------
    rate : ndarray, shape (n_rates,)
        [Hz]
    factor, low, high : ndarray, shape (n_rates,)
        Factor with the best filter, and its range over the filters that explain the logs equally well. [1]
    """

    rate: Floats
    factor: Floats
    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        freeze(self, "rate", "factor", "low", "high", dtype=np.float64)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns."""
        return plain(self, "rate_hz=rate factor low high")


@frozen(eq=False)
class SensorBandwidth(Printed):
    """The filter between the white noise of a sensor and its sampler, of one channel.

    Attributes
    ----------
    channel, quantity, unit : str
        `unit` is that of the rate, SI.
    shape : str
        Filter that explains the logs best: ``"one pole"``, ``"Butterworth, 2 poles"``, ``"running mean"``, ``"FIR, Hamming
        taper"`` …
    order : int
        Poles, or running means in series; 0 of a FIR filter.
    alternatives : tuple of str
        Other filters that explain the logs equally well; all intervals include them.
    bandwidth : Interval
        Frequency of −3 dB. An end that the logs do not determine is None. [Hz]
    equivalent : Interval
        Noise-equivalent bandwidth, one-sided. [Hz]
    random_walk : Interval
        N without aliasing: its square is the two-sided density before the sampler. [unit of N]
    rate_needed : Interval
        Lowest sampling rate above which aliasing increases N by less than `tolerance`. [Hz]
    tolerance : float
        [1]
    logs : tuple of LoggedRate
        By rate.
    response : FilterResponse
    aliasing : AliasingCurve
        Aliasing at other sampling rates.
    level : float
        Confidence level of the intervals.
    p_value : float
        Goodness of the joint fit. [1]
    verdict : {"adequate", "logs differ", "not explained", "rate too low"}
        ``"logs differ"``: they differ slightly, but by more than chance; ``"not explained"``: no filter fits. The
        intervals are then wider by the excess of the deviance. ``"rate too low"``: the bandwidth has no upper limit.
    differing : str
        Log that differs from the others; empty unless the verdict is ``"logs differ"``.
    repeated : tuple of str
        Logs that were not used, because their samples are in another log.

    See Also
    --------
    sigmatau.bandwidth : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> white = np.random.default_rng(1).standard_normal(20_000)
    >>> record = st.Record.from_arrays(rate=100, gyro_x=(white[3:] + white[2:-1] + white[1:-2] + white[:-3]) / 4)
    >>> result = st.bandwidth(record)["gyro_x"]
    >>> result.shape, result.bandwidth.low < 11.074 < result.bandwidth.high  # 0.44295 / (4 · 10 ms)
    ('running mean', True)
    """

    channel: str
    quantity: str
    unit: str
    shape: str
    order: int
    alternatives: tuple[str, ...]
    bandwidth: Interval
    equivalent: Interval
    random_walk: Interval
    rate_needed: Interval
    tolerance: float
    logs: tuple[LoggedRate, ...]
    response: FilterResponse
    aliasing: AliasingCurve
    level: float
    p_value: float
    verdict: Verdict
    differing: str = ""
    repeated: tuple[str, ...] = ()

    @property
    def record_at(self) -> float | None:
        """Sampling rate that would show the bandwidth, if these logs do not. [Hz]"""
        return 10 * max(log.rate for log in self.logs) if self.verdict == "rate too low" else None

    @property
    def paper_rates(self) -> tuple[float, float]:
        """Three and five times the bandwidth. [Hz]"""
        low, high = PAPER_RATES
        return low * self.bandwidth.value, high * self.bandwidth.value

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, for JSON."""
        names = "channel quantity unit shape order alternatives bandwidth equivalent random_walk rate_needed tolerance"
        judged = "verdict differing repeated level p_value record_at_hz=record_at logs response aliasing"
        return plain(self, names, judged, sided="two")

    def plot(self, ax: Panels = None, *, unit: str | None = None) -> Figure:
        """Draw Fig. 12 of the paper: Allan deviations at all rates, and N against the sampling rate.

        Parameters
        ----------
        ax : sequence of two matplotlib axes, optional
            Default: a new figure.
        unit : str, optional
            Unit of the Allan deviation. Default: deg/h for gyros, µg for accelerometers.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS, MARKERS, curve_unit, draw_line
        from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

        curves, rates = make_panels(ax, 2, columns=2, width=5.25, height=4.6)
        for k, log in enumerate(self.logs):
            factor, text = curve_unit(log.curve, unit)
            colour, marker = COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
            draw_line(curves, f"{log.rate:.6g} Hz", log.curve.tau, log.curve.adev / factor, colour, marker)
            curves.set_ylabel(f"Allan deviation σ(τ) [{text}]")
        curves.set_title(self.channel)
        legend(curves)
        n, aliasing = self.random_walk, self.aliasing
        walks = [n.value, *(log.random_walk.value for log in self.logs)]
        text, factor = display_units("random_walk", self.quantity, self.unit, walks)[0]
        if n.low is not None and n.high is not None:
            low, high = (n.value * end / factor for end in (aliasing.low, aliasing.high))
            rates.fill_between(aliasing.rate, low, high, color=COLOURS[0], alpha=0.25, linewidth=0)
            label = f"N with aliasing, {self.shape}"
            rates.plot(aliasing.rate, n.value * aliasing.factor / factor, color=COLOURS[0], linewidth=1.3, label=label)
            label = "N without aliasing, 95 %"
            rates.axhspan(n.low / factor, n.high / factor, color=COLOURS[2], alpha=0.3, linewidth=0, label=label)
            label = "the paper: 3 to 5 times the bandwidth"
            rates.axvspan(*self.paper_rates, color="0.5", alpha=0.15, linewidth=0, label=label)
            label = f"aliasing adds {100 * self.tolerance:.3g} %: {two_digits(self.rate_needed.value)} Hz"
            rates.axvline(self.rate_needed.value, color=COLOURS[1], linestyle="--", linewidth=1.1, label=label)
        for k, log in enumerate(self.logs):
            value, begin, end = log.random_walk.value, log.random_walk.low, log.random_walk.high
            error = None if begin is None or end is None else np.array([[value - begin], [end - value]]) / factor
            style: dict[str, Any] = {"fmt": MARKERS[k % len(MARKERS)], "color": COLOURS[k % len(COLOURS)]}
            rates.errorbar([log.rate], [value / factor], error, **style, markersize=5, linewidth=1.2)
        rates.set_xscale("log")
        rates.set_ylim(bottom=0)
        label_axes(rates, "sampling rate [Hz]", f"random walk N in the log [{text}]")
        if n.low is not None:
            legend(rates)
        return parent_figure(curves)

    def statements(self) -> tuple[str, ...]:
        """Sentences on the limits of the result; empty if there are none."""
        texts = []
        if self.verdict == "rate too low":
            texts.append(
                f"{self.channel}: these logs do not show the bandwidth: no filter is visible below half the rate."
                f" Record at {float(f'{self.record_at:.3g}'):g} Hz or more"
            )
        if self.verdict == "logs differ":
            texts.append(
                f"{self.channel}: {self.differing} differs from the other logs by more than chance."
                " The intervals are wider by this difference"
            )
        if self.verdict == "not explained":
            texts.append(
                f"{self.channel}: no filter explains the spectra (p = {self.p_value:.2g})."
                " The intervals are wider by the misfit"
            )
        if self.repeated:
            texts.append(
                f"{self.channel}: not used, because another log has the same samples: {', '.join(self.repeated)}"
            )
        return tuple(texts)

    def __repr__(self) -> str:
        walks = [self.random_walk.value, *(log.random_walk.value for log in self.logs)]
        text, factor = display_units("random_walk", self.quantity, self.unit, walks)[0]
        label = TERMS["random_walk"].label(self.quantity)
        name = f"{self.channel}   filter: {self.shape}"
        if self.alternatives:
            name += f"; equally likely: {'; '.join(self.alternatives)}"
        if self.verdict == "rate too low":
            name = f"{self.channel}   filter: not shown by these logs"
        rows = [
            ("bandwidth, -3 dB", self.bandwidth, 1.0, "Hz"),
            ("noise-equivalent bandwidth", self.equivalent, 1.0, "Hz"),
            (f"{label} without aliasing", self.random_walk, factor, text),
            (f"rate for aliasing < {100 * self.tolerance:.3g} %", self.rate_needed, 1.0, "Hz"),
        ]
        cells = [("", f"{100 * self.level:g} % interval")]
        cells += [(label, f"{_text(interval, size)} {unit}") for label, interval, size, unit in rows]
        if self.verdict != "rate too low":
            low, high = (f"{rate:.3g}" for rate in self.paper_rates)
            cells.append(("the paper: 3 to 5 times the bandwidth", f"{low} to {high} Hz"))
        table = [("log", "rate [Hz]", f"random walk in it [{text}]", "added by aliasing")]
        table += [
            (log.name[-20:], f"{log.rate:.4g}", _text(log.random_walk, factor), _excess_text(log.aliasing))
            for log in self.logs
        ]
        lines = [
            *wrapped([name], indent=4),
            *(f"  {line}" for line in (*aligned(cells), *aligned(table, right=(1, 2, 3)))),
        ]
        return lines_text([*lines, *wrapped(f"  {text}" for text in self.statements())])


def _text(interval: Interval, factor: float) -> str:
    """Value and interval; a limit alone if the interval is open."""
    low, high = (None if x is None else x / factor for x in (interval.low, interval.high))
    if low is not None and high is not None:
        return round_to_error(interval.value / factor, low, high).text
    if low is not None:
        return f"above {significant(low, 2, zeros=True)}"
    return limit_text(high) if high is not None else "not known"


def _excess_text(factor: Interval) -> str:
    """The contribution of aliasing to N, in per cent."""
    low, high = (None if x is None else 100 * (x - 1) for x in (factor.low, factor.high))
    if low is None or high is None:
        return "not known"
    if high < _NO_ALIASING:
        return f"below {_NO_ALIASING} %"
    return round_to_error(100 * (factor.value - 1), low, high).with_unit("%")


class Bandwidths(ByChannel[SensorBandwidth]):
    """Results of `sigmatau.bandwidth` by channel.

    See Also
    --------
    sigmatau.bandwidth : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> record = st.Record.from_arrays(rate=100, gyro=np.random.default_rng(1).standard_normal((2000, 3)))
    >>> [(channel, found.verdict) for channel, found in st.bandwidth(record).items()]
    [('gyro_x', 'rate too low'), ('gyro_y', 'rate too low'), ('gyro_z', 'rate too low')]
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values by channel, for JSON."""
        return {name: result.to_dict() for name, result in self.items()}

    def plot(self, channel: str | None = None, ax: Panels = None, *, unit: str | None = None) -> Figure:
        """Draw Fig. 12 of the paper for one channel, see `SensorBandwidth.plot`.

        Parameters
        ----------
        channel : str, optional
            Default: the first.
        ax : sequence of two matplotlib axes, optional
            Default: a new figure.
        unit : str, optional
            Unit of the Allan deviation. Default: deg/h for gyros, µg for accelerometers.

        Returns
        -------
        matplotlib figure

        Raises
        ------
        OptionError
            For a channel without a result.
        """
        name = next(iter(self)) if channel is None else channel
        if name not in self:
            raise OptionError(f"{{option}} must be one of {', '.join(self)}, not {channel!r}", option="channel")
        return self[name].plot(ax=ax, unit=unit)

    def __repr__(self) -> str:
        return "\n\n".join(map(repr, self.values()))
