"""Result of `sigmatau.tune`: whether innovations have the stated covariance, and the wrong noises of the filter with
their factors.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sigmatau.arrays import Bools, Floats, freeze
from sigmatau.digits import round_to_error, two_digits
from sigmatau.errors import OptionError
from sigmatau.exporting.tuning.filters import SLOW, WHITE
from sigmatau.exporting.tuning.motion import MotionEffect
from sigmatau.exporting.tuning.run import MEASUREMENT
from sigmatau.exporting.tuning.statements import UNIT_NIS, statements_of_tuning
from sigmatau.frozen import frozen
from sigmatau.record.record import stream_name
from sigmatau.results import ByChannel, Printed, aligned, duration_text, lines_text, plain, seconds, wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NoiseVerdict = Literal["consistent", "wrong", "ambiguous", "not explained", "inconsistent"]
Verdict = Literal[NoiseVerdict, "motion", "offset", "outliers"]

_NAMES = {MEASUREMENT: "measurement noise", WHITE: "white process noise", SLOW: "slow process noise"}
_RATE_UNITS = {"gyro": "rad/s", "accel": "m/s²"}
_LETTERS = {MEASUREMENT: "√R", WHITE: "N", SLOW: "K"}
_VAGUE = 3.0  # ratio of an end of an interval to its value above which the run does not determine the noise


@frozen
class NoiseFactor(Printed):
    """Factor on the standard deviation of a noise of a filter.

    Attributes
    ----------
    noise : str
        ``"measurement"``, ``"white"``, ``"slow"``, or the name of a matrix Q; of several measurements
        ``"measurement gnss"``.
    value : float
        Factor by which to multiply the standard deviation; the factor on the variance is its square. [1]
    low : float
        Lower end of its interval; 0 if the innovations do not show this noise. [1]
    high : float or None
        Upper end; None if it is not bounded. [1]
    assumed : float or None
        Value that the filter assumes: √R, N or K; None for a matrix. [SI]
    """

    noise: str
    value: float
    low: float
    high: float | None
    assumed: float | None = None

    @property
    def direction(self) -> Literal["too small", "too large"]:
        """Direction in which the noise of the filter is wrong, if it is."""
        return "too small" if self.value > 1 else "too large"

    @property
    def is_shown(self) -> bool:
        """Whether the innovations determine this noise: both ends are within a factor of 3."""
        return self.high is not None and self.high < _VAGUE * self.value and self.value < _VAGUE * self.low

    @property
    def has_error(self) -> bool:
        """Whether the interval excludes 1."""
        return self.low > 1 or (self.high is not None and self.high < 1)

    @property
    def text(self) -> str:
        """Factor and interval."""
        if self.high is None:
            return f"above {two_digits(self.low)}" if self.low else "not shown"
        if not self.low:
            return f"below {two_digits(self.high)}"
        return round_to_error(self.value, self.low, self.high).text

    @property
    def name(self) -> str:
        """Name of the noise in a sentence, with its letter."""
        if self.noise.startswith(f"{MEASUREMENT} "):
            measurement = self.noise if self.noise.split()[-1].isdigit() else self.noise.removeprefix(f"{MEASUREMENT} ")
            return f"{_NAMES[MEASUREMENT]} √R of {measurement}"
        return f"{_NAMES[self.noise]} {_LETTERS[self.noise]}" if self.noise in _NAMES else f"noise {self.noise!r}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "noise value low high assumed")


@frozen(eq=False)
class Whiteness(Printed):
    """Ratio of the Allan deviation of the normalised innovations to that of white noise with variance 1, 1/√m.

    Attributes
    ----------
    m : ndarray, shape (n_tau,)
        Number of innovations that are averaged. [1]
    tau : ndarray, shape (n_tau,)
        Averaging time. [s]
    ratio, low, high : ndarray, shape (n_tau,)
        Ratio, 1 for a consistent filter, with its interval from the χ² of white noise. [1]
    """

    m: Floats
    tau: Floats
    ratio: Floats
    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        freeze(self, "m", "tau", "ratio", "low", "high")

    @property
    def is_outside(self) -> Bools:
        """Mask of averaging times whose interval excludes 1."""
        return np.asarray((self.low > 1) | (self.high < 1))

    def to_dict(self) -> dict[str, Any]:
        """Plain columns."""
        return plain(self, "m tau_s=tau ratio low high")


@frozen(eq=False)
class Tuning(Printed):
    """Judgement of one channel of innovations.

    Attributes
    ----------
    channel : str
    n : int
        Number of innovations.
    duration : float
        Time from the first to the last innovation. [s]
    interval : float
        Median time between two innovations. [s]
    measurements : tuple of str
        Names of several measurements; empty for one.
    means : tuple of float
        Mean of the normalised innovations of each measurement. [1]
    has_offset : bool
        Whether one of the means is not 0.
    nis, nis_low, nis_high : float
        Mean of the squared normalised innovations (NIS), with an interval that allows for their correlation. 1 for a
        consistent filter. [1]
    whiteness : Whiteness
    factors : tuple of NoiseFactor
        Factors on each noise of the filter; empty without a filter.
    causes : tuple of NoiseFactor
        Noises that are wrong; with the noise verdict ``"ambiguous"``, candidates of which one is wrong.
    motion : tuple of MotionEffect
        Scale error and delay of each measurement; empty without the rate of motion, or without a filter.
    has_rate : bool
        Whether the innovations have the rate of motion.
    has_root_of_variance : bool
        Whether the stated variance seems to be a standard deviation.
    verdict : {"consistent", "wrong", "ambiguous", "not explained", "motion", "offset", "outliers", "inconsistent"}
        In this order: no error found; all `causes` are wrong; one of `causes` is wrong; no factors explain the
        innovations; the innovations follow the motion; their mean is not zero; some are outliers; they are not as stated,
        and the filter is unknown.
    noise_verdict : {"consistent", "wrong", "ambiguous", "not explained", "inconsistent"}
        Verdict on the noises alone, without the effects of the motion and of the mean.
    outliers : int
        Number of innovations beyond 7 standard deviations of the others.
    first_outlier : float or None
        Time of the first outlier. [s]
    p_value : float
        P-value of the innovations if the filter is correct. [1]
    p_misfit : float or None
        P-value of the innovations with the best factors. [1]
    level : float
        Confidence level of the intervals. [1]

    See Also
    --------
    tune : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> nu = 2 * np.random.default_rng(2).standard_normal(500)
    >>> data = st.Innovations(time=np.arange(500) / 5, innovation=nu, variance=np.ones(500))
    >>> judged = st.tune(data)["innovation"]
    >>> judged.verdict, round(judged.nis, 1)
    ('inconsistent', 4.1)
    """

    channel: str
    n: int
    duration: float
    interval: float
    measurements: tuple[str, ...]
    means: tuple[float, ...]
    has_offset: bool
    nis: float
    nis_low: float
    nis_high: float
    whiteness: Whiteness
    factors: tuple[NoiseFactor, ...]
    causes: tuple[NoiseFactor, ...]
    motion: tuple[MotionEffect, ...]
    has_rate: bool
    has_root_of_variance: bool
    verdict: Verdict
    noise_verdict: NoiseVerdict
    p_value: float
    p_misfit: float | None
    level: float
    outliers: int = 0
    first_outlier: float | None = None

    @property
    def mean(self) -> float:
        """Mean of the normalised innovations; with several measurements, the mean that is farthest from 0. [1]"""
        return max(self.means, key=abs)

    @property
    def common_factor(self) -> float | None:
        """Common factor that explains all wrong noises; None if they need different factors, or if none is wrong. [1]"""
        low = max((factor.low for factor in self.causes), default=0.0)
        high = min((factor.high or 0.0 for factor in self.causes), default=0.0)
        is_joint = self.noise_verdict == "wrong" and len(self.causes) == len(self.factors) > 1
        directions = {factor.direction for factor in self.causes}
        is_common = low <= high or (len(directions) == 1 and not 1 / UNIT_NIS < self.nis < UNIT_NIS)
        return math.sqrt(self.nis) if is_joint and is_common else None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, for JSON."""
        names = (
            "channel n duration_s=duration interval_s=interval measurements mean means has_offset nis nis_low nis_high"
        )
        return plain(
            self,
            names,
            "verdict noise_verdict p_value p_misfit level outliers common_factor causes factors motion whiteness",
        )

    def plot(self, ax: Axes | None = None) -> Figure:
        """Draw the Allan deviation of the normalised innovations, with that of white noise.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        return Tunings({self.channel: self}).plot(ax=ax)

    def statements(self) -> tuple[str, ...]:
        """Sentences on the errors of the filter, their direction and the action."""
        return statements_of_tuning(self)

    def __repr__(self) -> str:
        nis = round_to_error(self.nis, self.nis_low, self.nis_high).text
        span = duration_text(self.duration)
        several = f" of {len(self.measurements)} measurements" * bool(self.measurements)
        lines = [
            f"{self.channel}   {self.n} innovations{several}, one every {seconds(self.interval)} s, {span}",
            f"  NIS {nis} ({100 * self.level:g} % interval), in a consistent filter 1",
        ]
        if self.motion:
            unit = _RATE_UNITS.get(stream_name(self.channel), "in SI")
            deviations = ", ".join(f"{effect.motion:.3g}" for effect in self.motion if effect.effect == "scale")
            lines.append(f"  rate of motion: standard deviation {deviations} {unit}")
        table = [("noise of the filter", "assumed, SI", f"factor on it, {100 * self.level:g} % interval")]
        factors = self.factors if self.noise_verdict != "not explained" else ()
        for factor in factors:
            assumed = "" if factor.assumed is None else f"{factor.assumed:.3g}"
            mark = "  wrong" if factor in self.causes and self.noise_verdict == "wrong" else ""
            name = factor.name if factor.noise.split()[0] in _NAMES else factor.noise
            table.append((name, assumed, f"{factor.text}{mark}"))
        table += [(effect.name, "0", f"{effect.text}{'  not 0' if effect.has_error else ''}") for effect in self.motion]
        curve = self.whiteness
        ratios = [("averaging time", "deviation of the innovations over the stated one")]
        for k in range(len(curve.tau)):
            ratio = round_to_error(float(curve.ratio[k]), float(curve.low[k]), float(curve.high[k])).text
            ratios.append((f"{seconds(float(curve.tau[k]))} s", f"{ratio}{'  not 1' if curve.is_outside[k] else ''}"))
        tables = [*(aligned(table, right=(1,)) if len(table) > 1 else []), *aligned(ratios, right=(0,))]
        lines += [f"  {line}" for line in tables]
        return lines_text([*lines, *wrapped(f"  {text}." for text in self.statements())])


class Tunings(ByChannel[Tuning]):
    """Results of `sigmatau.tune` by channel.

    See Also
    --------
    tune : makes it.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> nu = np.random.default_rng(2).standard_normal(500)
    >>> data = st.Innovations(time=np.arange(500) / 5, innovation=nu, variance=np.ones(500))
    >>> [(channel, judged.verdict) for channel, judged in st.tune({"gyro_x": data}).items()]
    [('gyro_x', 'consistent')]
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values by channel, for JSON."""
        return {name: result.to_dict() for name, result in self.items()}

    def plot(self, channel: str | None = None, ax: Axes | None = None) -> Figure:
        """Draw the Allan deviations of the normalised innovations, with that of white noise.

        Parameters
        ----------
        channel : str, optional
            Default: all.
        ax : matplotlib axes, optional
            Default: a new figure.

        Returns
        -------
        matplotlib figure

        Raises
        ------
        OptionError
            For a channel without a result.
        """
        from sigmatau.plot.curves import COLOURS, MARKERS
        from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure

        if channel is not None and channel not in self:
            raise OptionError(f"{{option}} must be one of {', '.join(self)}, not {channel!r}", option="channel")
        tunings = dict(self) if channel is None else {channel: self[channel]}
        (panel,) = make_panels(ax, 1, columns=1, width=6.4, height=4.6)
        widest = max((tuning.whiteness for tuning in tunings.values()), key=lambda curve: float(curve.m[-1]))
        level = next(iter(tunings.values())).level
        white = 1 / np.sqrt(widest.m)
        # For white noise the deviation lies between these multiples of its expectation.
        band = (white * widest.ratio / widest.high, white * widest.ratio / widest.low)
        label = f"consistent filter, {100 * level:g} %"
        panel.fill_between(widest.tau, *band, color="0.5", alpha=0.2, linewidth=0, label=label)
        panel.loglog(widest.tau, white, color="0.4", linestyle="--", linewidth=1.0, label="consistent filter: 1/√m")
        for k, (name, tuning) in enumerate(tunings.items()):
            curve = tuning.whiteness
            look = {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
            panel.loglog(curve.tau, curve.ratio / np.sqrt(curve.m), **look, markersize=4, linewidth=1.2, label=name)
        label_axes(panel, "averaging time τ [s]", "Allan deviation of normalised innovations [1]")
        legend(panel)
        return parent_figure(panel)

    def __repr__(self) -> str:
        return "\n\n".join(map(repr, self.values()))
