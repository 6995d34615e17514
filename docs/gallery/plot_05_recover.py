"""
Simulate and recover
====================

Forty records of one sensor: how often does the 95 % interval contain the simulated value? A term that is not observed has
the interval from 0 to its upper limit.
"""

import matplotlib.pyplot as plt

import sigmatau as st

truth = {"random_walk": 1e-4, "rate_random_walk": 1e-5}
model = st.NoiseModel(channels={"gyro_x": truth})
fits = [st.fit_channel(st.simulate(model, duration=1800, rate=10, rng=seed), "gyro_x") for seed in range(40)]

figure, axes = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
for ax, (name, value) in zip(axes, truth.items(), strict=True):
    terms = [fit[name] for fit in fits]
    intervals = [(term.low, term.high) if term.observed else (0, term.upper_limit) for term in terms]
    inside = [low <= value <= high for low, high in intervals]
    for k, (low, high) in enumerate(intervals):
        ax.plot([k, k], [low, high], color="C0" if inside[k] else "C3", linewidth=2)
    ax.axhline(value, color="grey", linestyle="--")
    ax.set_ylabel(f"{name}\n[{terms[0].unit}]")
    ax.set_title(f"{sum(inside)} of {len(fits)} intervals contain the simulated value", fontsize=10)
_ = axes[1].set_xlabel("record")
