"""Draw the figures of the theory pages: ``.venv/bin/python docs/figures.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sigmatau.terms import TERMS, avar

HERE = Path(__file__).parent / "figures"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")


def terms_figure() -> None:
    """Each of the five terms with coefficient 1 at τ₀ = 1 s, exact for samples, and where its line is read."""
    m = np.unique(np.round(np.geomspace(1, 1e4, 200)).astype(int))
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    ax = figure.subplots()
    for (name, term), colour in zip(TERMS.items(), COLOURS, strict=True):
        sigma = np.sqrt(avar(name, 1.0, m=m, tau0=1.0))
        ax.loglog(
            m, sigma, color=colour, label=f"{term.label('angular_rate')}, slope {term.slope:+g}".replace("+0", "0")
        )
        if term.read_at is not None:
            ax.plot([term.read_at], [1.0], "o", color=colour, markeredgecolor="white", zorder=4)
    ax.axhline(TERMS["bias_instability"].level, color=COLOURS[2], linewidth=0.8, linestyle=":")
    ax.text(1.5e3, 0.7, "0.664 B", color=COLOURS[2], fontsize=9)
    ax.set_ylim(1e-3, 1e3)
    ax.set_xlabel("averaging time τ [s]")
    ax.set_ylabel("Allan deviation σ(τ), coefficient 1 in SI")
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    ax.legend(fontsize=8.5)
    figure.savefig(HERE / "terms.svg", metadata={"Date": None})


if __name__ == "__main__":
    terms_figure()
