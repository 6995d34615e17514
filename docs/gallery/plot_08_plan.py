"""
How long to record
==================

The smallest bias instability that a record shows, by its length, for three grades of gyro. Below a line, the record gives an
upper limit.
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st
from sigmatau.units import to_si

hours = np.array([0.5, 1, 2, 5, 10, 24, 100])
deg_per_hour = to_si(1.0, "deg/h")

figure, ax = plt.subplots(layout="constrained")
for walk in (0.003, 0.1, 0.5):
    others = {"random_walk": to_si(walk, "deg/sqrt(h)")}
    plans = [
        st.plan(
            others,
            "bias_instability",
            channel="gyro_x",
            quantity="angular_rate",
            rate_unit="rad/s",
            rate=10,
            duration=3600 * length,
        )
        for length in hours
    ]
    ax.loglog(hours, [plan.most / deg_per_hour for plan in plans], marker="o", label=f"random walk {walk} deg/√h")
ax.set(xlabel="length of the record [h]", ylabel="bias instability shown by nine of ten records [deg/h]")
ax.grid(visible=True, which="both", alpha=0.3)
_ = ax.legend()

# %%
# The length that shows a given value: 1 deg/h beside an angle random walk of 0.1 deg/√h.

st.plan(
    {"random_walk": to_si(0.1, "deg/sqrt(h)")},
    "bias_instability",
    channel="gyro_x",
    quantity="angular_rate",
    rate_unit="rad/s",
    rate=10,
    value=deg_per_hour,
)
