"""Draw the figures of the theory pages of single terms: ``PYTHONPATH=python python docs/figures_terms.py [NAME ...]``.

Left the Allan deviation: the formula, the point at which it is read, a simulated record with its 95 % band, and what looks
the same. Right the two-sided density of the same record and of the same formulas.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

import sigmatau as st
from sigmatau import ChannelModel, GaussMarkov, LowPass, Resonance, Sinusoid
from sigmatau.noise.terms import BIAS_LEVEL
from sigmatau.units import find, to_si

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HERE = Path(__file__).parent / "figures"
RATE = 10.0  # sampling rate of the records [Hz]
SAMPLES = 1 << 16
DURATION = SAMPLES / RATE  # [s]
TAU0 = 1 / RATE
UNIT = find("deg/h")
DEG_H = UNIT.factor
BLACK, RECORD, OTHERS = "black", "#0072B2", ("#D55E00", "#009E73")
PEAK = 1.892618  # τ/T at which the Allan deviation of a Gauss-Markov process is largest
PEAK_LEVEL = 0.617364  # and its height there, over σ

Alike = Sequence[tuple[str, ChannelModel]]


def panels(
    name: str,
    formula: str,
    model: ChannelModel,
    *,
    read: tuple[float, float, str] | None = None,
    alike: Alike = (),
    part: ChannelModel | None = None,
    extra: Callable[[Axes, Axes], None] | None = None,
    periodogram: bool = False,
) -> None:
    """One figure.

    Parameters
    ----------
    name : str
        Of the file: term-NAME.svg.
    formula : str
        Its legend.
    model : ChannelModel
        Of the record.
    read : tuple, optional
        Averaging time [s], deviation [SI] and text of the point that is read.
    alike : sequence of (str, ChannelModel)
        What looks the same.
    part : ChannelModel, optional
        What the formula is drawn of. Default: the model.
    extra : callable, optional
        Draws more into both panels.
    periodogram : bool
        The density by a plain periodogram, from which no slope is removed.
    """
    part = part or model
    record = st.simulate(st.NoiseModel(channels={"gyro_x": model}), duration=DURATION, rate=RATE, rng=1)
    curve = st.analyze(record).curves["gyro_x"]
    figure = Figure(figsize=(9.4, 4.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    m = np.unique(np.geomspace(1, SAMPLES / 2, 240).round().astype(np.int64))
    few = np.arange(1, 61)  # of a line: the first of its many dips
    low, high = curve.interval()
    left.fill_between(
        curve.tau, low / DEG_H, np.minimum(high, 5 * curve.adev) / DEG_H, color=RECORD, alpha=0.2, linewidth=0
    )
    left.loglog(
        curve.tau,
        curve.adev / DEG_H,
        "o",
        color=RECORD,
        markersize=3,
        label=f"simulated, {DURATION / 3600:.1f} h at {RATE:g} Hz, 95 % band",
    )
    left.loglog(m * TAU0, part.adev(m=m, tau0=TAU0) / DEG_H, color=BLACK, linewidth=1.6, label=formula)
    for (label, other), colour, dashes in zip(alike, OTHERS, ("--", "-."), strict=False):
        sizes = m if other.terms or not other.sinusoid else few
        left.loglog(
            sizes * TAU0, other.adev(m=sizes, tau0=TAU0) / DEG_H, dashes, color=colour, linewidth=1.2, label=label
        )
    if read is not None:
        left.plot(
            [read[0]],
            [read[1] / DEG_H],
            "D",
            color="#CC79A7",
            markeredgecolor=BLACK,
            markersize=7,
            zorder=5,
            label=read[2],
        )
    if periodogram:
        rate = record.streams[0].column("gyro_x")
        density = np.abs(np.fft.rfft(rate - rate.mean()))[1:-1] ** 2 * TAU0 / SAMPLES
        f = np.fft.rfftfreq(SAMPLES, TAU0)[1:-1]
        edges = np.unique(np.geomspace(1, len(f) + 1, 70).round().astype(int)) - 1
        counts = np.diff(edges)
        f, density = np.add.reduceat(f, edges[:-1]) / counts, np.add.reduceat(density, edges[:-1]) / counts
    else:
        spectrum = st.psd(record, segment=DURATION / 8)["gyro_x"].binned(per_octave=8)
        kept = spectrum.frequency >= spectrum.trusted
        low, high = (edge[kept] for edge in spectrum.interval())
        f, density = spectrum.frequency[kept], spectrum.density[kept]
        right.fill_between(f, low / DEG_H**2, high / DEG_H**2, color=RECORD, alpha=0.2, linewidth=0)
    right.loglog(f, density / DEG_H**2, "o", color=RECORD, markersize=2.5)
    fine = np.geomspace(1 / DURATION, 0.4999 * RATE, 1200)
    for one, colour, dashes, width in zip(
        (part, *(other for _, other in alike)), (BLACK, *OTHERS), ("-", "--", "-."), (1.6, 1.2, 1.2), strict=False
    ):
        shown = one.psd(fine, tau0=TAU0) / DEG_H**2
        if (shown > 0).any():  # a sinusoid and a ramp have no density
            right.loglog(fine, shown, dashes, color=colour, linewidth=width)
    top = max(density.max(), part.psd(fine, tau0=TAU0).max())
    heights = curve.adev[curve.adev > 0] / DEG_H
    left.set_ylim(heights.min() / 3, heights.max() * 6)
    right.set_ylim(density[density > 0].min() / DEG_H**2 / 10, top / DEG_H**2 * 10)
    if extra is not None:
        extra(left, right)
    left.set_xlabel("averaging time τ [s]")
    left.set_ylabel("Allan deviation σ(τ) [deg/h]")
    right.set_xlabel("frequency f [Hz]")
    right.set_ylabel("two-sided density S(f) [(deg/h)²/Hz]")
    for ax in (left, right):
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    left.legend(fontsize=8)
    figure.savefig(HERE / f"term-{name}.svg", metadata={"Date": None, "Creator": "docs/figures_terms.py"})


def quantization() -> None:
    """Against a line whose maxima fall with the same slope."""
    q, f = to_si(1, "arcsec"), 1.0
    line = Sinusoid(amplitude=np.sqrt(3) * q * np.pi * f, frequency=f)
    panels(
        "quantization",
        "quantization, Q = 1 arcsec: √3 Q/τ",
        ChannelModel(terms={"quantization": q}),
        read=(np.sqrt(3), q, "at τ = √3 s: 1 arcsec/s = 1 deg/h"),
        alike=[("a line of 1 Hz", ChannelModel(sinusoid=(line,)))],
        extra=lambda _, right: vertical(right, f, OTHERS[0]),
    )


def random_walk() -> None:
    """Against a fast Gauss-Markov process with the same density at low frequencies."""
    n = to_si(0.1, "deg/sqrt(h)")
    fast = GaussMarkov(sigma=n / np.sqrt(2 * 1.0), time=1.0)
    panels(
        "random-walk",
        "random walk, N = 0.1 deg/√h: N/√τ",
        ChannelModel(terms={"random_walk": n}),
        read=(1.0, n, "at τ = 1 s: 6 deg/h = 0.1 deg/√h · 60/√h"),
        alike=[("Gauss–Markov, T = 1 s, 2σ²T = N²", ChannelModel(gauss_markov=(fast,)))],
    )


def bias_instability() -> None:
    """Against a valley between N and K, and the top of a Gauss-Markov process."""
    b, valley = to_si(1, "deg/h"), 100.0
    n = BIAS_LEVEL * b * np.sqrt(valley / 2)  # N²/τ and K²τ/3 are half of the variance each at the valley
    k = BIAS_LEVEL * b * np.sqrt(1.5 / valley)
    top = GaussMarkov(sigma=BIAS_LEVEL * b / PEAK_LEVEL, time=valley / PEAK)
    panels(
        "bias-instability",
        "bias instability, B = 1 deg/h: 0.664 B",
        ChannelModel(terms={"bias_instability": b}),
        read=(valley, BIAS_LEVEL * b, "plateau: 0.664 deg/h"),
        alike=[
            ("N and K without B", ChannelModel(terms={"random_walk": n, "rate_random_walk": k})),
            ("Gauss–Markov, T = 53 s", ChannelModel(gauss_markov=(top,))),
        ],
    )


def rate_random_walk() -> None:
    """Against a slow Gauss-Markov process."""
    k = to_si(1, "deg/h/sqrt(h)")
    slow = GaussMarkov(sigma=k * np.sqrt(1000.0), time=2000.0)
    panels(
        "rate-random-walk",
        "rate random walk, K = 1 deg/h/√h: K √(τ/3)",
        ChannelModel(terms={"rate_random_walk": k}),
        read=(3.0, k, "at τ = 3 s: K · 1 √s = 0.0167 deg/h"),
        alike=[("Gauss–Markov, T = 2000 s, σ² = K²T/2", ChannelModel(gauss_markov=(slow,)))],
    )


def rate_ramp() -> None:
    """Against the random walk that has the same periodogram."""
    r, n = to_si(1, "deg/h^2"), to_si(0.003, "deg/sqrt(h)")
    walk = ChannelModel(terms={"rate_random_walk": r * np.sqrt(DURATION)})
    panels(
        "rate-ramp",
        "ramp, R = 1 deg/h²: R τ/√2",
        ChannelModel(terms={"rate_ramp": r, "random_walk": n}),
        part=ChannelModel(terms={"rate_ramp": r}),
        read=(1000.0, r * 1000 / np.sqrt(2), "at τ = 1000 s: R τ/√2 = 0.196 deg/h"),
        alike=[
            ("rate random walk, K = R √(record)", walk),
            ("the white noise of the record", ChannelModel(terms={"random_walk": n})),
        ],
        periodogram=True,
    )


def gauss_markov() -> None:
    """With its two limits."""
    sigma, time = to_si(1, "deg/h"), 20.0
    panels(
        "gauss-markov",
        "Gauss–Markov, σ = 1 deg/h, T = 20 s",
        ChannelModel(gauss_markov=(GaussMarkov(sigma=sigma, time=time),)),
        read=(PEAK * time, PEAK_LEVEL * sigma, "at τ = 1.893 T: 0.617 σ"),
        alike=[
            ("rate random walk, K = σ √(2/T)", ChannelModel(terms={"rate_random_walk": sigma * np.sqrt(2 / time)})),
            ("random walk, N = σ √(2T)", ChannelModel(terms={"random_walk": sigma * np.sqrt(2 * time)})),
        ],
    )


def sinusoid() -> None:
    """A line, and a resonance of the same power, beside white noise."""
    n, a, f = to_si(0.01, "deg/sqrt(h)"), to_si(2, "deg/h"), 0.1
    line = Sinusoid(amplitude=a, frequency=f)
    wide = Resonance(sigma=a / np.sqrt(2), frequency=f, width=0.01)
    panels(
        "sinusoid",
        "line, A = 2 deg/h, f₀ = 0.1 Hz, and N",
        ChannelModel(terms={"random_walk": n}, sinusoid=(line,)),
        read=(0.371 / f, 0.725 * a, "at τ = 0.371/f₀: 0.725 A"),
        alike=[
            (
                "resonance of the same power, half width 0.01 Hz, and N",
                ChannelModel(terms={"random_walk": n}, resonance=(wide,)),
            ),
            ("N = 0.01 deg/√h", ChannelModel(terms={"random_walk": n})),
        ],
        extra=lambda _, right: vertical(right, f, BLACK),
    )


def low_pass() -> None:
    """White noise behind filters of 1 Hz, against the white noise."""
    n = to_si(0.1, "deg/sqrt(h)")
    filtered = [ChannelModel(terms={"random_walk": n}, bandwidth=LowPass(order=order, corner=1.0)) for order in (2, 1)]
    panels(
        "filter",
        "N behind a Butterworth filter of 1 Hz, order 2",
        filtered[0],
        alike=[
            ("order 1 (a Gauss–Markov process)", filtered[1]),
            ("N = 0.1 deg/√h", ChannelModel(terms={"random_walk": n})),
        ],
        read=(1.0, n, "N is read at τ = 1 s on the line of slope −1/2"),
    )


def vertical(ax: Axes, frequency: float, colour: str) -> None:
    """A line of the spectrum."""
    ax.axvline(frequency, color=colour, linewidth=1, linestyle=":")


FIGURES = {
    "quantization": quantization,
    "random-walk": random_walk,
    "bias-instability": bias_instability,
    "rate-random-walk": rate_random_walk,
    "rate-ramp": rate_ramp,
    "gauss-markov": gauss_markov,
    "sinusoid": sinusoid,
    "filter": low_pass,
}

if __name__ == "__main__":
    mpl.rcParams["svg.hashsalt"] = "sigmatau"  # the same file for the same figure
    for chosen in sys.argv[1:] or FIGURES:
        FIGURES[chosen]()
