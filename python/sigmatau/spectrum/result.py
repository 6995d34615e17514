"""Spectra as results."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.results import ByChannel, Printed

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Method", "Spectra", "Spectrum"]

Floats = NDArray[np.float64]
Method = Literal["welch", "multitaper"]

# Correlation of the powers of neighbouring bins under a Hann taper: (2/3)² and (1/6)².
_NEIGHBOURS = (4 / 9, 1 / 36)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Spectrum(Printed):
    """Two-sided power spectral density of one channel.

    Attributes
    ----------
    channel : str
    quantity, unit : str
        Of the rate; SI.
    frequency : ndarray, shape (n_f,)
        Positive, up to half the sampling rate. [Hz]
    density : ndarray, shape (n_f,)
        Two-sided: white noise of random walk N has N² at every frequency. [unit²/Hz]
    dof : ndarray, shape (n_f,)
        Degrees of freedom of each density, of which dof·density/truth has a χ² law.
    resolution : float
        Width of what one frequency sees. [Hz]
    segments : int
        Segments averaged, or tapers.
    n, tau0 : int, float
        Samples in the record, and their interval. [s]
    method : {"welch", "multitaper"}
    """

    channel: str
    quantity: str
    unit: str
    frequency: Floats
    density: Floats
    dof: Floats
    resolution: float
    segments: int
    n: int
    tau0: float
    method: Method = "welch"

    def __post_init__(self) -> None:
        for name in ("frequency", "density", "dof"):
            array = np.asarray(getattr(self, name), dtype=np.float64).view()
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def density_unit(self) -> str:
        """Unit of the density, two-sided."""
        return f"({self.unit})^2/Hz" if "/" in self.unit else f"{self.unit}^2/Hz"

    def interval(self, *, level: float = 0.95) -> tuple[Floats, Floats]:
        """Between which densities the true one lies, by χ².

        Returns
        -------
        low, high : ndarray, shape (n_f,)
            [unit²/Hz]
        """
        from scipy.special import chdtri

        # chdtri(v, p) is the x that χ² exceeds with probability p.
        low, high = chdtri(self.dof, (1 - level) / 2), chdtri(self.dof, (1 + level) / 2)
        return self.density * self.dof / low, self.density * self.dof / high

    def binned(self, *, per_octave: int = 8) -> Spectrum:
        """The same with neighbouring frequencies averaged, as many bins an octave: what a figure or a fit needs.

        The density of a bin is the mean of its densities, its frequency the mean of their frequencies.
        """
        edges = self.frequency[0] * 2.0 ** (
            np.arange(int(np.log2(self.frequency[-1] / self.frequency[0]) * per_octave) + 2) / per_octave
        )
        starts = np.unique(np.searchsorted(self.frequency, edges * (1 - 1e-9)))
        starts = starts[starts < len(self.frequency)]
        count = np.diff(np.append(starts, len(self.frequency)))
        if self.method == "welch":
            shared = 2 * sum(c * np.maximum(1 - k / count, 0) for k, c in enumerate(_NEIGHBOURS, 1))
        else:  # tapers of one record see about `segments` + 1 half-bins in common
            shared = (self.resolution / (self.frequency[1] - self.frequency[0]) - 1) * (1 - 1 / count)
        dof = np.add.reduceat(self.dof, starts) / (1 + np.maximum(shared, 0))
        return replace(
            self,
            frequency=np.add.reduceat(self.frequency, starts) / count,
            density=np.add.reduceat(self.density, starts) / count,
            dof=dof,
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain columns, for JSON or any data-frame library."""
        low, high = self.interval()
        return {
            "channel": self.channel,
            "frequency_hz": self.frequency.tolist(),
            "density": self.density.tolist(),
            "low": low.tolist(),
            "high": high.tolist(),
            "dof": self.dof.tolist(),
            "sided": "two",
            "method": self.method,
            "segments": self.segments,
            "resolution_hz": self.resolution,
            "unit": self.density_unit,
        }

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the density, two-sided, with its 95 % band; returns the axes."""
        from matplotlib.figure import Figure

        if ax is None:
            ax = Figure(figsize=(7, 4.6), layout="constrained").subplots()
        binned = self.binned()
        low, high = binned.interval()
        ax.fill_between(binned.frequency, low, high, alpha=0.25, linewidth=0)
        ax.loglog(binned.frequency, binned.density, linewidth=1, label=self.channel)
        ax.set_xlabel("frequency [Hz]")
        ax.set_ylabel(f"two-sided power spectral density [{self.density_unit}]")
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        return ax

    def __repr__(self) -> str:
        kind = "sine tapers" if self.method == "multitaper" else "segments"
        head = (
            f"{self.channel}: two-sided power spectral density, {self.segments} {kind}, resolution "
            f"{self.resolution:.3g} Hz [{self.density_unit}]"
        )
        octaves = self.binned(per_octave=1)
        low, high = octaves.interval()
        rows = zip(octaves.frequency, octaves.density, low, high, strict=True)
        return "\n".join([head, *(f"  {f:10.4g} Hz  {p:.4g}  [{a:.4g}, {b:.4g}]" for f, p, a, b in rows)])


class Spectra(ByChannel[Spectrum]):
    """Spectra by channel: an immutable mapping in the record's order."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Each spectrum as plain columns, by channel."""
        return {channel: spectrum.to_dict() for channel, spectrum in self.items()}
