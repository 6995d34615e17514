"""Ratio of a measured density to a model's, by band."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau._native.distributions import chi2_above, chi2_below, chi2_quantile_above
from sigmatau.arrays import Floats, freeze
from sigmatau.frozen import frozen
from sigmatau.results import Printed, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@frozen(eq=False)
class ModelComparison(Printed):
    """Ratio of a measured density to a model's; 1 if the model is right.

    Attributes
    ----------
    channel : str
    frequency : ndarray, shape (n_bands,)
        Mean frequency of each band. [Hz]
    ratio : ndarray, shape (n_bands,)
        Measured over modelled density; the square of the ratio of amplitudes per √Hz. [1]
    dof : ndarray, shape (n_bands,)
        Degrees of freedom of each ratio.
    method : str
        Method of the measured density.
    highest : float or None
        Frequency up to which the model was fitted; None for all. [Hz]
    left_out : tuple of str
        Parts of the model that have no density: its sinusoids, its ramp.
    beside_lines : tuple of (float, float)
        Bands that are not compared, because a line of the model shows there. [Hz]

    See Also
    --------
    sigmatau.Spectrum.over : makes it.

    Notes
    -----
    The errors of the model's coefficients are not included. The ratios to a fit of the same record therefore scatter
    less.
    """

    channel: str
    frequency: Floats
    ratio: Floats
    dof: Floats
    method: str
    highest: float | None = None
    left_out: tuple[str, ...] = ()
    beside_lines: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "frequency", "ratio", "dof", dtype=np.float64)

    def interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Confidence interval of the true ratio, by χ².

        Parameters
        ----------
        level : float
            Probability, between 0 and 1.

        Returns
        -------
        low, high : ndarray, shape (n_bands,)
            Ratios.
        """
        low, high = chi2_quantile_above(self.dof, (1 - level) / 2), chi2_quantile_above(self.dof, (1 + level) / 2)
        return self.ratio * self.dof / low, self.ratio * self.dof / high

    @property
    def p_values(self) -> Floats:
        """Two-sided p-value of each ratio; shape (n_bands,)."""
        x = self.ratio * self.dof
        return np.asarray(np.minimum(2 * np.minimum(chi2_below(self.dof, x), chi2_above(self.dof, x)), 1.0))

    @property
    def p_value(self) -> float:
        """Smallest p-value times the number of bands; below 0.05, the model does not describe the density."""
        return float(min(1.0, self.p_values.min() * len(self.ratio)))

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = self.interval()
        fields = "channel frequency_hz=frequency ratio dof p_values p_value method left_out highest_hz=highest"
        fields += " beside_lines_hz=beside_lines"
        return plain(self, fields, low=low, high=high, level=0.95)

    def plot(self, ax: Axes | None = None) -> Figure:
        """Draw the ratios with their 95 % intervals, in new or given axes.

        Parameters
        ----------
        ax : matplotlib axes, optional
            Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS
        from sigmatau.plot.style import label_axes, make_panels, parent_figure

        (panel,) = make_panels(ax, 1, columns=1, width=7, height=3.2)
        low, high = self.interval()
        errors = np.array([self.ratio - low, high - self.ratio])
        panel.errorbar(self.frequency, self.ratio, errors, fmt="o", markersize=3, linewidth=1, color=COLOURS[0])
        panel.axhline(1.0, color="0.4", linewidth=0.8)
        panel.set_xscale("log")
        label_axes(panel, "frequency [Hz]", f"density of {self.channel} over the model's")
        return parent_figure(panel)

    def statement(self) -> str:
        """Result of the comparison, as a sentence."""
        low, high = self.interval()
        outside = int(((low > 1) | (high < 1)).sum())
        chance = 0.05 * len(self.ratio)
        begin = f"{self.channel}: {outside} of {len(self.ratio)} bands differ from the model's density by more"
        begin += f" than their 95 % interval, {chance:.1f} expected by chance"
        if self.highest is not None:
            begin += f" (up to {self.highest:.4g} Hz, as the model was fitted)"
        if self.beside_lines:
            bands = ", ".join(f"{low:.4g} Hz to {high:.4g} Hz" for low, high in self.beside_lines)
            begin += f" ({bands} left out: the model's lines)"
        if self.p_value >= 0.05:
            return f"{begin}; the model describes it (p = {self.p_value:.2g})"
        k = int(np.argmin(self.p_values))
        how = f"{self.ratio[k]:.3g} times the model's at {self.frequency[k]:.3g} Hz"
        return f"{begin}; the model does not describe it: {how} (p = {self.p_value:.1g})"

    def notes(self) -> str:
        """Parts of the model that are not in the ratios, as a sentence; empty if there are none."""
        if not self.left_out:
            return ""
        return f"omitted, because they have no density: {', '.join(self.left_out)}"

    def __repr__(self) -> str:
        low, high = self.interval()
        rows = zip(self.frequency, self.ratio, low, high, strict=True)
        head = [
            self.statement(),
            *filter(None, [self.notes()]),
            "   frequency  measured density over the model's, 95 % interval",
        ]
        return "\n".join([*head, *(f"  {f:10.4g} Hz  {r:7.4f}  [{a:.4f}, {b:.4f}]" for f, r, a, b in rows)])
