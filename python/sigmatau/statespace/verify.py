"""Comparison of a linear model with the curve of a record."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import chi2_above, gamma_above, gamma_below, normal_quantile
from sigmatau.arrays import Floats, freeze
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import real
from sigmatau.noise import terms
from sigmatau.noise.uncertainty import chi2_factors
from sigmatau.results import ByChannel, Printed, plain, seconds
from sigmatau.statespace.avar_scatter import check_noise, check_phases, covariance_of_model
from sigmatau.statespace.state_space import state_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels


_MAX_TIMES = 64  # largest number of averaging times compared; longer grids are thinned evenly on a logarithmic axis
_MIN_CLUSTERS = 3
"""Smallest number of clusters per record for the misfit; with fewer, a variance has about one degree of freedom."""


@frozen(eq=False)
class Verification(Printed):
    """Ratio of the Allan deviation of a linear model to that of a record.

    Attributes
    ----------
    curve : DeviationCurve
        Curve of the record at the averaging times compared, with the degrees of freedom of the model.
    avar : ndarray, shape (n_tau,)
        Allan variance of the linear model. [unit²]
    ratio : ndarray, shape (n_tau,)
        Deviation of the model over that of the record, a ratio.
    low, high : ndarray, shape (n_tau,)
        Band that contains the ratio with probability `level` if the model is true, by χ².
    used : ndarray of bool, shape (n_tau,)
        Whether the averaging time is one of the octaves of the misfit.
    misfit : float
        uᵀC⁻¹u, see `verify`. [1]
    freedom : int
        Expected misfit if the model is true.
    p_value : float
        Probability of a larger misfit if the model is true.
    worst : int
        Index of the octave with the least likely ratio.
    tau_min : float
        Shortest averaging time of the misfit. [s]
    of_fit : bool
        Whether `tau_min` comes from the fit of the model.
    states : int
        Number of states of the linear model.
    flicker_error : float
        Largest relative error of the model's Allan deviation of flicker noise.
    level : float
        Probability of the bands.

    See Also
    --------
    sigmatau.verify : makes it.
    """

    curve: DeviationCurve
    avar: Floats
    ratio: Floats
    low: Floats
    high: Floats
    used: NDArray[np.bool_]
    misfit: float
    freedom: int
    p_value: float
    worst: int
    tau_min: float
    of_fit: bool
    states: int
    flicker_error: float
    level: float

    def __post_init__(self) -> None:
        freeze(self, "avar", "ratio", "low", "high", "used")

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Mask of the ratios outside their band; shape (n_tau,)."""
        return (self.ratio < self.low) | (self.ratio > self.high)

    def to_dict(self) -> dict[str, Any]:
        """Plain values and columns."""
        fields = "misfit freedom p_value tau_min_s=tau_min states flicker_error level ratio low high used"
        worst = {"ratio": self.ratio[self.worst], "tau_s": self.curve.tau[self.worst]}
        curve = plain(self.curve, "channel m tau_s=tau adev unit")
        return plain(self, fields, worst=worst, model_adev=np.sqrt(self.avar), **curve)

    def plot(self, ax: Axes | None = None, *, unit: str | None = None) -> Figure:
        """Draw the record's curve with its band, and the model's, in new or given axes.

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
        from sigmatau.plot.curves import COLOURS, curve_unit, draw_curve
        from sigmatau.plot.style import legend, parent_figure

        panel, (factor, _) = draw_curve(self.curve, ax=ax, unit=unit), curve_unit(self.curve, unit)
        label = f"model, {_p(self.p_value)}"
        panel.plot(self.curve.tau, np.sqrt(self.avar) / factor, color=COLOURS[1], linewidth=1.3, zorder=3, label=label)
        label = "band by χ² if the model is true"
        panel.fill_between([], [], [], color=COLOURS[0], alpha=0.18, linewidth=0, label=label)
        legend(panel)
        return parent_figure(panel)

    def __repr__(self) -> str:
        tau, k = self.curve.tau, self.worst
        lines = [
            f"{self.curve.channel}: linear model of {self.states} states every {self.curve.tau0:g} s,"
            f" misfit {self.misfit:.3g} of {self.freedom} octaves, {_p(self.p_value)}",
            f"  least likely: σ of the model is {self.ratio[k]:.3g} times that of the record at {seconds(tau[k])} s"
            f" ({self.low[k]:.3g} to {self.high[k]:.3g} if it is true)",
        ]
        if not self.used[0]:
            why = ", where the fit of the model begins" if self.of_fit else ""
            lines.append(f"  misfit of averaging times from {seconds(self.tau_min)} s on{why}")
        if self.flicker_error:
            lines.append(f"  flicker noise: within {100 * self.flicker_error:.2g} % of its Allan deviation")
        lines.append(f"  {'τ [s]':>10}  model/record  {100 * self.level:g} % band")
        for j in np.flatnonzero(self.used):
            mark = "  outside" if self.outside[j] else ""
            lines.append(
                f"  {seconds(tau[j]):>10}  {self.ratio[j]:<12.4g}  {self.low[j]:.4g} … {self.high[j]:.4g}{mark}"
            )
        return "\n".join(lines)


class Verifications(ByChannel[Verification]):
    """Verifications by channel: an immutable mapping in the record's order."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Each verification as plain columns, by channel."""
        return {channel: verification.to_dict() for channel, verification in self.items()}

    def plot(self, ax: Panels = None) -> Figure:
        """Draw all verifications, one panel each.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.style import make_panels, parent_figure

        panels = make_panels(ax, len(self), columns=3, width=5.2, height=4.2)
        for panel, verification in zip(panels, self.values(), strict=True):
            verification.plot(panel)
        return parent_figure(panels[0])


@overload
def verify(
    model: ChannelModel,
    curves: DeviationCurve,
    *,
    tau_min: float | None = None,
    flicker_error: float = 0.01,
    level: float = 0.95,
) -> Verification: ...
@overload
def verify(
    model: NoiseModel,
    curves: Mapping[str, DeviationCurve],
    *,
    tau_min: float | Mapping[str, float] | None = None,
    flicker_error: float = 0.01,
    level: float = 0.95,
) -> Verifications: ...
def verify(
    model: ChannelModel | NoiseModel,
    curves: DeviationCurve | Mapping[str, DeviationCurve],
    *,
    tau_min: float | Mapping[str, float] | None = None,
    flicker_error: float = 0.01,
    level: float = 0.95,
) -> Verification | Verifications:
    """Compare the linear model, as `sigmatau.state_space` builds it, with the Allan deviation of a record.

    Parameters
    ----------
    model : ChannelModel or NoiseModel
        Noise of one channel, or of several.
    curves : DeviationCurve, or mapping of str to DeviationCurve
        One curve for a `ChannelModel`, curves by channel for a `NoiseModel`: overlapped, of a record in which no sample
        is missing.
    tau_min : float, optional
        Shortest averaging time of the misfit, for sensors with a filter. Default: `ChannelModel.tau_min`, the
        shortest averaging time of the fit. [s]
    flicker_error : float
        As in `sigmatau.state_space`.
    level : float
        Probability of the bands.

    Returns
    -------
    Verification or Verifications
        A verification, or verifications by channel.

    Raises
    ------
    OptionError
        For a curve in another unit, of clusters that do not overlap, or with fewer than two octaves; for a level outside
        0 … 1, a `tau_min` that is negative or not a number.
    DataError
        For a curve of a record with gaps; for a model without noise, or with a sinusoid that has so few periods in the
        record that its phase hides the noise.

    See Also
    --------
    state_space : the linear system.
    fit : the model of a record.

    Notes
    -----
    The misfit uses the octaves from `tau_min` to a third of the record. Each variance is converted to the
    normal deviate u of equal probability, by its χ² with 2·AVAR²/Var degrees of freedom. C is the correlation of the
    variances, so that uᵀC⁻¹u equals rᵀV⁻¹r for many degrees of freedom. For few degrees of freedom rᵀV⁻¹r has p < 0.2 %
    in 1.1 to 1.4 % of records, uᵀC⁻¹u in 0.1 to 0.3 % (1500 records of 4096 samples each; N, K, and N + B + K). C
    includes the error of the states that approximate flicker noise, at most `flicker_error`, which is not a misfit of
    the model.

    V is exact (`sigmatau.noise.uncertainty.avar_covariance`, `sigmatau.statespace.avar_scatter`) except for a sinusoid.
    For a sinusoid, V includes its product with the noise at its frequency, taken as equal at all averaging times, and the
    effect of its phase to first order. The p-value is too small if a sinusoid dominates some octaves: with 0.7 Hz and ten
    times the standard deviation of the white noise in 100 s at 100 Hz, 27 % of 60 true records had p < 5 %; with an equal
    standard deviation, 10 %. Far below the time constant of a steep filter, neighbouring variances are almost
    identical: of 150 true records with order 9 at 1 Hz, sampled at 100 Hz, 7 % had p < 5 %, but the mean of p is 0.60.
    Strided curves are treated as if their clusters began at every sample.

    References
    ----------
    docs/theory/state-space.md derives the Allan variance of a linear system.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6}})
    >>> record = st.simulate(model, duration=600, rate=100, rng=1)
    >>> st.verify(model, st.allan(record))["gyro_x"].p_value > 0.05
    True
    """
    if isinstance(model, ChannelModel):
        if not isinstance(curves, DeviationCurve):
            raise OptionError("{option} of a model of one channel must be a DeviationCurve", option="curves")
        if isinstance(tau_min, Mapping):
            raise OptionError("{option} of a model of one channel must be a number", option="tau_min")
        return _verify_channel(model, curves, tau_min=tau_min, flicker_error=flicker_error, level=level)
    if not isinstance(model, NoiseModel):
        kind = type(model).__name__
        raise OptionError(f"{{option}} must be a ChannelModel or a NoiseModel, not {kind}", option="model")
    if not isinstance(curves, Mapping):
        raise OptionError("{option} of a NoiseModel must be a mapping of channels to curves", option="curves")
    for name in curves:
        if name not in model.channels:
            raise OptionError(
                f"{{option}} has {name}, which the model lacks; give those of {', '.join(model.channels)}",
                option="curves",
            )
    return Verifications(
        {
            name: _verify_channel(
                model.channels[name],
                curve,
                tau_min=tau_min.get(name) if isinstance(tau_min, Mapping) else tau_min,
                flicker_error=flicker_error,
                level=level,
            )
            for name, curve in curves.items()
        }
    )


def _verify_channel(
    model: ChannelModel,
    curve: DeviationCurve,
    *,
    tau_min: float | None = None,
    flicker_error: float = 0.01,
    level: float = 0.95,
) -> Verification:
    if not 0 < real(level) < 1:
        raise OptionError(f"{{option}} must lie between 0 and 1, not {level!r}", option="level")
    if tau_min is not None and not (math.isfinite(real(tau_min)) and tau_min >= 0):
        raise OptionError(f"{{option}} must be a number of seconds, 0 or more, not {tau_min!r}", option="tau_min")
    if curve.unit != model.unit:
        raise OptionError(
            f"{{option}} of {curve.channel} is in {curve.unit}, the model in {model.unit}", option="curve"
        )
    if curve.overlap != "full":
        raise OptionError("{option} must be of overlapping clusters, overlap='full'", option="curve")
    if curve.missing:
        raise DataError(
            f"`curve` of {curve.channel} has gaps, {curve.missing} of {curve.n} samples missing, and their effect is"
            " unknown; take the longest run without a gap, `Record.longest_run`"
        )
    check_noise(model, curve)
    is_fitted = tau_min is None
    tau_min = model.tau_min if tau_min is None else tau_min
    sizes = curve.m[2 * curve.m <= curve.n]
    if len(sizes) > _MAX_TIMES:
        sizes = sizes[np.unique(np.round(np.geomspace(1, len(sizes), _MAX_TIMES)).astype(int)) - 1]
    octaves = _octaves(
        [int(m) for m in sizes if m * curve.tau0 >= tau_min * (1 - 1e-9) and _MIN_CLUSTERS * m <= curve.n]
    )
    if len(octaves) < 2:
        raise OptionError(
            f"{{option}} of {curve.channel} has {len(octaves)} octaves from {tau_min:g} s to a third of the record; the"
            " misfit needs two",
            option="curve",
        )
    used = np.isin(sizes, octaves)
    system = state_space(model, dt=curve.tau0, tau_max=float(sizes[-1]) * curve.tau0, flicker_error=flicker_error)
    expected = system.avar(sizes)
    covariance = covariance_of_model(model, n=curve.n, m=sizes, tau0=curve.tau0, together=used)
    check_phases(model, curve, sizes[used], np.diag(covariance)[used])
    edf = 2 * model.avar(m=sizes, tau0=curve.tau0) ** 2 / np.diag(covariance)
    chosen = replace(curve.at(sizes), edf=edf)
    low, high = chi2_factors(edf, level=level)
    u = _deviates(chosen.avar[used] / expected[used], edf[used])
    correlation = covariance[np.ix_(used, used)]
    sd = np.sqrt(np.diag(correlation))
    # The difference between flicker noise and its few linear states is not a misfit of the model.
    flicker = terms.avar("bias_instability", model.terms.get("bias_instability", 0.0), m=sizes[used], tau0=curve.tau0)
    approximated = (2 * system.flicker_error * flicker / expected[used]) ** 2 * edf[used] / 2
    misfit = float(u @ np.linalg.solve(correlation / np.outer(sd, sd) + np.diag(approximated), u))
    if not math.isfinite(misfit):
        raise DataError(
            f"the misfit of {curve.channel} is not a number: the noise is too small relative to the rest of the model;"
            f" variances have up to {edf.max():.2g} degrees of freedom"
        )
    return Verification(
        curve=chosen,
        avar=expected,
        ratio=np.sqrt(expected / chosen.avar),
        low=low,
        high=high,
        used=used,
        misfit=misfit,
        freedom=len(octaves),
        p_value=float(chi2_above(len(octaves), misfit)),
        worst=int(np.flatnonzero(used)[np.argmax(np.abs(u))]),
        tau_min=tau_min,
        of_fit=is_fitted,
        states=len(system.states),
        flicker_error=system.flicker_error,
        level=level,
    )


def _octaves(sizes: list[int]) -> list[int]:
    """Cluster sizes, each at least twice the previous one."""
    octaves: list[int] = []
    for size in sizes:
        if not octaves or size >= 2 * octaves[-1]:
            octaves.append(size)
    return octaves


def _deviates(ratio: Floats, edf: Floats) -> Floats:
    """Normal deviates with the probability of χ²/edf = ratio."""
    below, above = gamma_below(edf / 2, edf * ratio / 2), gamma_above(edf / 2, edf * ratio / 2)
    tiny = np.finfo(float).tiny
    return np.asarray(
        np.where(below < 0.5, normal_quantile(np.maximum(below, tiny)), -normal_quantile(np.maximum(above, tiny)))
    )


def _p(value: float) -> str:
    return f"p = {value:.2g}" if value >= 1e-12 else "p < 1e-12"
