"""
Predict the drift of a navigation system
========================================

How the errors of an unaided inertial navigation system grow, from the noise of its sensors alone.
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st
from sigmatau.units import to_si

gyro = {
    "random_walk": to_si(0.1, "deg/sqrt(h)"),
    "bias_instability": to_si(1.0, "deg/h"),
}
accel = {
    "random_walk": to_si(0.05, "m/s/sqrt(h)"),
    "bias_instability": to_si(20, "ug"),
}
axes = {f"gyro_{axis}": gyro for axis in "xyz"} | {f"accel_{axis}": accel for axis in "xyz"}
model = st.NoiseModel(channels=axes)

after = np.geomspace(1, 600, 25)
prediction = st.predict(model, after=after, calibration=300, rate=50)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
left.loglog(after, np.degrees(prediction["heading"].rms), label="heading [deg]")
left.loglog(after, np.degrees(prediction["roll"].rms), label="roll [deg]")
right.loglog(after, prediction["position_x"].rms, color="C2", label="horizontal position [m]")
for ax in (left, right):
    ax.set(xlabel="time since the start [s]", ylabel="rms error")
    ax.grid(visible=True, which="both", alpha=0.3)
    ax.legend()

# %%
# After a minute, by noise term:

st.predict(model, after=[60], calibration=300, rate=50)
