"""The figures of docs/paper: Figs. 1 to 5 from our formulas, Figs. 8 to 11 from simulated units, Fig. 12 from one sensor."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import sigmatau as st
from sigmatau.noise.terms import TERMS, avar
from sigmatau.plot.curves import COLOURS, save
from sigmatau.plot.style import new_figure
from studies.paper.tables import HOURS, RATES, model

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FIG_12_RATES", "HERE", "draw", "fig_12_logs", "fig_12_sensor", "term_figure", "unit_figure"]

HERE = Path(__file__).resolve().parents[2] / "docs" / "figures"

TERM_FIGURES: Mapping[int, str] = {
    1: "quantization",
    2: "random_walk",
    3: "bias_instability",
    4: "rate_random_walk",
    5: "rate_ramp",
}
_SAMPLES = 4096

UNIT_FIGURES: Mapping[int, tuple[str, str]] = {
    8: ("cimu", "gyro"),
    9: ("cimu", "accel"),
    10: ("hg1700", "gyro"),
    11: ("hg1700", "accel"),
}

FIG_12_RATES = (10, 50, 100, 500, 1000, 2000)
FIG_12_MINUTES = 10.0


def term_figure(number: int) -> Figure:
    """Figs. 1 to 5: σ(τ) of a term with coefficient 1, its read-off point, and a simulated record."""
    name = TERM_FIGURES[number]
    term = TERMS[name]
    m = np.unique(np.geomspace(1, _SAMPLES / 2, 160).round().astype(np.int64))
    tau = m.astype(float)
    figure = new_figure(5.6, 3.9)
    ax = figure.subplots()
    if number == 3:
        fine = np.unique(np.geomspace(1, 20 * _SAMPLES, 400).round().astype(np.int64))
        cut = np.sqrt(avar(name, 1.0, m=fine, tau0=0.05, cutoff=1.0))
        ax.loglog(0.05 * fine, cut, color="0.35", linewidth=1, linestyle="--", label="eq. (19), f₀ = 1 Hz")
    ax.loglog(tau, np.sqrt(avar(name, 1.0, m=m, tau0=1.0)), color=COLOURS[0], linewidth=1.4, label=_FORMULAS[name])
    model = st.NoiseModel(channels={"gyro_x": {name: 1.0}})
    record = st.simulate(model, duration=_SAMPLES, rate=1.0, rng=number)
    curve = st.allan(record)["gyro_x"]
    band = ""
    if name != "rate_ramp":  # a ramp has no scatter
        low, high = curve.interval()
        ax.fill_between(curve.tau, low, np.minimum(high, 5 * curve.adev), color=COLOURS[1], alpha=0.18, linewidth=0)
        band = ", 95 % band"
    label = f"simulated, {_SAMPLES} samples{band}"
    ax.loglog(curve.tau, curve.adev, "o", color=COLOURS[1], markersize=3.2, label=label)
    if term.read_at is None:
        ax.axhline(term.level, color=COLOURS[2], linewidth=0.9, linestyle=":")
        ax.text(1.2, term.level * 0.9, "0.664 B", color=COLOURS[2], fontsize=9, va="top")
    else:
        ax.plot([term.read_at], [1.0], "D", color=COLOURS[2], markersize=7, zorder=4, label=_READ[name])
    ax.set_xlabel("averaging time τ, in samples")
    ax.set_ylabel("Allan deviation σ(τ), coefficient 1")
    ax.set_title(f"{term.label('angular_rate').capitalize()}, slope {_SLOPES[term.slope]}", fontsize=10)
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    ax.legend(fontsize=8)
    return figure


_FORMULAS = {
    "quantization": "√3 Q/τ, eq. (15)",
    "random_walk": "N/√τ, eq. (17)",
    "bias_instability": "sampled flicker noise",
    "rate_random_walk": "K √(τ/3), eq. (21), sampled",
    "rate_ramp": "R τ/√2, eq. (23)",
}
_SLOPES = {-1.0: "−1", -0.5: "−1/2", 0.0: "0", 0.5: "+1/2", 1.0: "+1"}
_READ = {
    "quantization": "read at √3",
    "random_walk": "read at 1",
    "rate_random_walk": "read at 3",
    "rate_ramp": "read at √2",
}


def unit_figure(number: int) -> Figure:
    """Figs. 8 to 11: the curves of `sigmatau demo --unit`, gyros or accelerometers, with the fitted models."""
    unit, sensor = UNIT_FIGURES[number]
    record = st.simulate(model(unit), duration=HOURS * 3600, rate=RATES[unit], rng=0)
    analysis = st.analyze(record)
    return analysis.plot(*(channel for channel in analysis.curves if channel.startswith(sensor)))


def fig_12_sensor() -> st.NoiseModel:
    """The X gyro of Table V after a first-order filter with the 30 Hz of section III."""
    terms = dict(model("motionpak2").channels["gyro_x"].items())
    channel = st.ChannelModel(terms=terms, bandwidth=st.LowPass(order=1, corner=30.0))
    return st.NoiseModel(channels={"gyro_x": channel})


def fig_12_logs(minutes: float = FIG_12_MINUTES) -> dict[int, st.Record]:
    """Logs by rate: every 200th, 40th … sample of one record at 2000 Hz, without a filter, so that higher frequencies are
    aliased.
    """
    fastest = max(FIG_12_RATES)
    record = st.simulate(fig_12_sensor(), duration=60 * minutes, rate=fastest, rng=12)
    rates = record.streams[0].column("gyro_x")
    return {
        rate: st.Record.from_arrays(rate=rate, gyro_x=rates[:: fastest // rate], unit={"gyro": "rad/s"})
        for rate in FIG_12_RATES
    }


def overlay_figure() -> Figure:
    """Fig. 12."""
    return st.plot_overlay({f"{rate} Hz": st.allan(record) for rate, record in fig_12_logs().items()})


def draw() -> None:
    """Draw all figures into docs/figures."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "sigmatau"}):  # makes the file reproducible
        for number in TERM_FIGURES:
            save(term_figure(number), str(HERE / f"paper-{number}.svg"))
    for number in UNIT_FIGURES:
        save(unit_figure(number), str(HERE / f"paper-{number}.png"))
    save(overlay_figure(), str(HERE / "paper-12.png"))
