"""Draw the figures of the theory pages: ``PYTHONPATH=. .venv/bin/python docs/figures.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from studies.bandwidth import BANDWIDTH, RATES, filtered_white
from studies.consistent import SENSORS, model_of
from studies.selection_bias import selection_bias

from sigmatau import NoiseModel, Record, allan, analyze, predict, simulate, verify
from sigmatau._native import kernels
from sigmatau.estimators.stability import dynamic_allan
from sigmatau.exporting.consistent import HORIZON, assume_noise, consistent_walk
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.navigation.reference_filter import AIDING, FilterModel, judge_filter
from sigmatau.noise.terms import TERMS, aliasing_inflation, avar
from sigmatau.spectrum.estimate import psd
from sigmatau.statespace.flicker import flicker_poles
from sigmatau.statespace.state_space import state_space
from sigmatau.units import to_si

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


def fit_figure() -> None:
    """A simulated tactical-grade gyro: the curve with its χ² band, the fitted model, and each term of it."""
    truth = {"quantization": "1 arcsec", "random_walk": "0.1 deg/sqrt(h)", "bias_instability": "1 deg/h"}
    model = NoiseModel.from_dict({"channels": {"gyro_x": truth}})
    analysis = analyze(simulate(model, duration=7200, rate=100, rng=1))
    curve, fitted = analysis.curves["gyro_x"], analysis.fits["gyro_x"]
    factor = to_si(1, "deg/h")
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    ax = figure.subplots()
    low, high = curve.interval()
    ax.fill_between(curve.tau, low / factor, np.minimum(high, 10 * curve.adev) / factor, color="0.75", linewidth=0)
    ax.loglog(curve.tau, curve.adev / factor, "o", color="black", markersize=3, label="measured, 95 % by χ²")
    ax.loglog(curve.tau, np.sqrt(fitted.avar(m=curve.m)) / factor, color="black", linewidth=1, label="fitted model")
    for (name, term), colour in zip(TERMS.items(), COLOURS, strict=True):
        if name in fitted.model:
            sigma = np.sqrt(avar(name, fitted.model[name], m=curve.m, tau0=curve.tau0)) / factor
            value, interval, unit = fitted.texts(name)[0]
            label = f"{term.label('angular_rate')} {value} {interval} {unit}"
            ax.loglog(curve.tau, sigma, color=colour, linewidth=1, linestyle="--", label=label)
    ax.set_ylim(curve.adev.min() / factor / 5, curve.adev.max() / factor * 2)
    ax.set_xlabel("averaging time τ [s]")
    ax.set_ylabel("Allan deviation σ(τ) [deg/h]")
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    ax.legend(fontsize=8.5)
    figure.savefig(HERE / "fit.svg", metadata={"Date": None})


def bandwidth_figure() -> None:
    """Fig. 12 of the paper: a sensor of 30 Hz, first order, at six sampling rates; points measured, lines exact."""
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    ax = figure.subplots()
    for k, rate in enumerate(RATES):
        colour = (*COLOURS, "#56B4E9")[k]
        y = filtered_white(round(600 * rate), rate=rate, bandwidth=BANDWIDTH, order=1, rng=np.random.default_rng(12))
        curve = allan(Record.from_arrays(rate=rate, gyro_x=y), taus="octave")["gyro_x"]
        shown = curve.tau <= 60
        ax.loglog(curve.tau[shown], curve.adev[shown], "o", color=colour, markersize=3.5)
        m = np.unique(np.geomspace(1, 3 * rate, 120).astype(int))
        inflation = aliasing_inflation(rate=rate, bandwidth=BANDWIDTH)
        exact = np.sqrt(kernels.band_limited_avar(1.0, "first_order", BANDWIDTH, m, 1 / rate))
        ax.loglog(m / rate, exact, color=colour, linewidth=1, label=f"{rate:g} Hz, N × {inflation:.3f}")
    ax.loglog([1e-3, 60], [1e-3**-0.5, 60**-0.5], color="black", linewidth=0.8, linestyle=":", label="N alone")
    ax.set_xlabel("averaging time τ [s]")
    ax.set_ylabel("Allan deviation σ(τ), N = 1")
    ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    ax.legend(fontsize=8.5)
    figure.savefig(HERE / "bandwidth.svg", metadata={"Date": None})


def stability_figure() -> None:
    """A gyro whose noise doubles for half an hour and that is knocked once: the dynamic Allan deviation; and what choosing
    the calmest two of four hours leaves of the Allan variance of stationary noise.
    """
    terms = {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "10 deg/h", "rate_random_walk": "20 deg/h/sqrt(h)"}
    model = NoiseModel.from_dict({"channels": {"gyro_x": terms}})
    rates = simulate(model, duration=4 * 3600, rate=10, rng=1).streams[0].column("gyro_x").copy()
    other = np.random.default_rng(2).standard_normal(18_000)
    rates[72_000:90_000] += np.sqrt(3) * np.std(np.diff(rates)) / np.sqrt(2) * other
    rates[115_000:115_040] += to_si(1500, "deg/h")
    dynamic = dynamic_allan(Record.from_arrays(rate=10, gyro_x=rates), "gyro_x", window=900, step=225)
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    dynamic.plot(left)
    for (name, noise), colour in zip(CHOSEN.items(), COLOURS, strict=False):
        bias = selection_bias({"x": noise}, n=14_400, window=7200, tau0=1.0)["x"]
        right.semilogx(bias.tau, bias.ratio, "o-", markersize=3, color=colour, label=name)
    right.axhline(1.0, color="0.5", linewidth=0.8)
    right.set_ylim(0, 1.1)
    right.set_xlabel("averaging time τ [s]")
    right.set_ylabel("AVAR of the calmest 2 of 4 h, over the true one")
    right.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
    right.legend(fontsize=8.5)
    figure.savefig(HERE / "stability.svg", metadata={"Date": None})


def state_space_figure() -> None:
    """Flicker noise by Gauss-Markov processes: each of them, their sum, and by how much it is off."""
    m = np.unique(np.round(2 ** np.linspace(0, 21, 253)).astype(int))
    figure = Figure(figsize=(9, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    exact = np.sqrt(avar("bias_instability", 1.0, m=m, tau0=0.01))
    left.loglog(m * 0.01, exact, color="black", linewidth=2.5, alpha=0.35, label="flicker noise, B = 1")
    poles = flicker_poles(dt=0.01, tau_max=3600.0, error=0.01)
    for k, (time, variance) in enumerate(zip(poles.times, poles.variances, strict=True)):
        one = ChannelModel(gauss_markov=(GaussMarkov(sigma=float(np.sqrt(variance)), time=float(time)),))
        label = "its Gauss-Markov processes" if k == 0 else None
        left.loglog(m * 0.01, one.adev(m=m, tau0=0.01), color=COLOURS[2], linewidth=0.9, label=label)
    flicker = ChannelModel(terms={"bias_instability": 1.0})
    for error, colour in zip((0.012, 0.001), COLOURS, strict=False):
        system = state_space(flicker, dt=0.01, tau_max=3600.0, flicker_error=error)
        adev = np.sqrt(system.avar(m))
        states = f"{len(system.states)} states"
        left.loglog(m * 0.01, adev, "--", color=colour, linewidth=1.1, label=states)
        right.semilogx(m * 0.01, 100 * (adev / exact - 1), color=colour, label=states)
    left.set_ylim(0.05, 1.2)
    left.set_ylabel("Allan deviation σ(τ)")
    right.axvline(3600, color="0.5", linewidth=0.8)
    right.set_ylim(-5, 2)
    right.set_ylabel("off by [%]")
    for ax in (left, right):
        ax.set_xlabel("averaging time τ [s]")
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        ax.legend(fontsize=8.5)
    figure.savefig(HERE / "state-space.svg", metadata={"Date": None})


def prediction_figure() -> None:
    """A tactical-grade unit: error of the position by its parts, and with calibrations."""
    model = NoiseModel.from_dict(
        {
            "channels": {
                "gyro_y": {
                    "random_walk": "0.1 deg/sqrt(h)",
                    "bias_instability": "0.5 deg/h",
                    "rate_random_walk": "1 deg/h/sqrt(h)",
                },
                "accel_x": {"random_walk": "0.03 m/s/sqrt(h)", "bias_instability": "40 ug"},
            }
        }
    )
    after = np.geomspace(1, 7200, 60)
    figure = Figure(figsize=(9, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    found = predict(model, after=after, calibration=300.0, rate=10.0)["position_x"]
    left.loglog(found.after, found.rms, color="black", linewidth=1.8, label="position, 5 min of calibration")
    for (key, share), colour in zip(found.shares.items(), COLOURS, strict=True):
        channel, part = key
        name = TERMS[part].label("signal")
        left.loglog(found.after, found.rms * np.sqrt(share), color=colour, linewidth=1, label=f"{channel} {name}")
    left.set_ylim(1e-3, 3e5)
    left.set_ylabel("error of the position, rms [m]")
    known = predict(model, after=after, rate=10.0)["position_x"]
    cases = {"1 min": 60.0, "5 min": 300.0, "30 min": 1800.0}
    for (name, calibration), colour in zip(cases.items(), COLOURS, strict=False):
        error = predict(model, after=after, calibration=calibration, rate=10.0)["position_x"]
        right.semilogx(error.after, error.rms / known.rms, color=colour, label=f"{name} of calibration")
    flat = predict(model, after=after, rate=10.0, earth="flat")["position_x"]
    right.semilogx(flat.after, flat.rms / known.rms, ":", color="black", label="no calibration, flat Earth")
    right.set_ylim(0.8, 4)
    right.set_ylabel("over the error from a known state")
    for ax in (left, right):
        ax.set_xlabel("time since the start [s]")
        ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        ax.legend(fontsize=8.5)
    figure.savefig(HERE / "prediction.svg", metadata={"Date": None})


def verification_figure() -> None:
    """A record's curve and the linear models of two coefficients' sets: the true one, and one without its random walk."""
    truth = {"random_walk": "0.1 deg/sqrt(h)", "bias_instability": "1 deg/h", "rate_random_walk": "10 deg/h/sqrt(h)"}
    wrong = {name: value for name, value in truth.items() if name != "rate_random_walk"}
    models = [NoiseModel.from_dict({"channels": {"gyro_x": terms}}) for terms in (truth, wrong)]
    curves = allan(simulate(models[0], duration=7200, rate=100, rng=1))
    figure = Figure(figsize=(9, 4), layout="constrained")
    for ax, model, title in zip(figure.subplots(1, 2), models, ("N, B, K", "N, B"), strict=True):
        verify(model, curves)["gyro_x"].plot(ax=ax)
        ax.set_title(title)
    figure.savefig(HERE / "verification.svg", metadata={"Date": None})


def psd_figure() -> None:
    """A simulated gyro: the two-sided density with its band, and the model; at the low end what a taper lets through."""
    truth = {"random_walk": "0.1 deg/sqrt(h)", "bias_instability": "5 deg/h", "rate_random_walk": "60 deg/h/sqrt(h)"}
    model = NoiseModel.from_dict({"channels": {"gyro_y": truth}})
    record = simulate(model, duration=7200, rate=100, rng=1)
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    ax = figure.subplots()
    for method, colour in (("welch", COLOURS[0]), ("multitaper", COLOURS[1])):
        spectrum = psd(record, method=method)["gyro_y"]
        spectrum.plot(ax, model=model, unit="deg/h")
        for line in ax.lines[-3:]:
            line.set_color(colour if line.get_linestyle() != "--" else "black")
        ax.collections[-1].set_color(colour)
        ax.lines[-2].set_label(method)
    ax.plot([], [], "--", color="black", label="model")
    ax.plot([], [], ":", color="0.4", label="where a red density is not to be trusted")
    ax.legend(fontsize=8.5)
    figure.savefig(HERE / "psd.svg", metadata={"Date": None})


def inflation_figure() -> None:
    """Gyros of four kinds: what a filter with the exported pair states, if its K or its N is multiplied; exact."""
    factors = np.geomspace(0.1, 100, 61)
    figure = Figure(figsize=(9.5, 6), layout="constrained")
    axes = figure.subplots(2, 3, sharex=True, sharey="col")
    for name, colour in zip(("N only", "flicker", "K", "Gauss-Markov"), COLOURS, strict=False):
        model = model_of("gyro", SENSORS["gyro"][name])
        truth = assume_noise(model, "mean")
        noise = model.terms["random_walk"]
        walk = consistent_walk(truth, sensor="gyro", noise=noise, horizon=HORIZON, criterion="horizon").walk
        for row, (of_noise, of_walk) in zip(axes, ((0, 1), (1, 0)), strict=True):
            judged = [
                judge_filter(
                    [truth.noise],
                    FilterModel(noise=noise * factor**of_noise, walk=walk * factor**of_walk),
                    aiding=AIDING["gyro"],
                    times=(HORIZON, 10 * HORIZON),
                )
                for factor in factors
            ]
            series = [[each.nees for each in judged]]
            series += [[each.coasting[k].ratio for each in judged] for k in range(2)]
            for ax, values in zip(row, series, strict=True):
                ax.loglog(factors, values, color=colour, label=name)
    for letter, row in zip("KN", axes, strict=True):
        for ax, title in zip(row, ("bias: NEES", "error after 60 s", "error after 10 min"), strict=True):
            ax.axhline(1.0, color="0.4", linewidth=0.8)
            ax.axvline(1.0, color="0.4", linewidth=0.8, linestyle=":")
            ax.set_title(title, fontsize=10)
            ax.set_xlabel(f"factor on {letter} of the file")
            ax.grid(visible=True, which="major", linewidth=0.5, alpha=0.5)
        row[0].set_ylabel("actual over stated variance")
        row[1].set_ylabel("actual over stated deviation")
    axes[0, 0].legend(fontsize=8.5, title="dominant slow noise", title_fontsize=8.5)
    axes[0, 0].set_ylim(0.1, 100)
    axes[0, 1].set_ylim(0.03, 10)
    axes[0, 2].set_ylim(0.03, 10)
    figure.savefig(HERE / "inflation.svg", metadata={"Date": None})


CHOSEN = {
    "N, B, K": {"random_walk": 0.005, "bias_instability": 0.0028, "rate_random_walk": 1e-4},
    "K alone": {"rate_random_walk": 1e-4},
    "B alone": {"bias_instability": 0.0028},
    "N alone": {"random_walk": 0.005},
}

if __name__ == "__main__":
    terms_figure()
    fit_figure()
    bandwidth_figure()
    stability_figure()
    state_space_figure()
    verification_figure()
    prediction_figure()
    psd_figure()
    inflation_figure()
