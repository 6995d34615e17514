"""
Simulate and recover
====================

Sixty records of one sensor: how often does the 95 % interval contain the simulated value?
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st

truth = {"random_walk": 1e-4, "rate_random_walk": 5e-6}
model = st.NoiseModel(channels={"gyro_x": truth})
fits = [st.fit_channel(st.simulate(model, duration=1800, rate=10, rng=seed), "gyro_x") for seed in range(60)]

figure, axes = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
for ax, (name, value) in zip(axes, truth.items(), strict=True):
    terms = [fit[name] for fit in fits]
    inside = np.array([term.low <= value <= term.high for term in terms])
    for k, term in enumerate(terms):
        ax.plot([k, k], [term.low, term.high], color="C0" if inside[k] else "C3", linewidth=2)
    ax.axhline(value, color="grey", linestyle="--")
    ax.set_ylabel(f"{name}\n[{terms[0].unit}]")
    ax.set_title(f"{inside.sum()} of {len(fits)} intervals contain the simulated value", fontsize=10)
_ = axes[1].set_xlabel("record")
