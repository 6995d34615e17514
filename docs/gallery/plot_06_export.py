"""
From a record to a filter's file
================================

The noise of an IMU in the units of Kalibr, and the matrices of a Kalman filter.
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st

gyro = {"random_walk": 1e-4, "rate_random_walk": 1e-5}
accel = {"random_walk": 1.2e-3, "rate_random_walk": 1e-4}
truth = {f"gyro_{axis}": gyro for axis in "xyz"} | {f"accel_{axis}": accel for axis in "xyz"}
record = st.simulate(st.NoiseModel(channels=truth), duration=3600, rate=100, rng=1)
analysis = st.analyze(record)

# %%
# Kalibr takes continuous-time densities: N and K, without a factor √rate. `Choices` has what you decide: here the root mean
# square of the axes instead of the worst axis.

print(analysis.export(to="kalibr", choices=st.Choices(axes="mean")))

# %%
# The same sensor as the system of a Kalman filter with steps of 10 ms: the bias is a random walk with covariance K²·dt, the
# noise of a measured rate has the variance N²/dt.

system = st.state_space(analysis.model.channels["gyro_x"], dt=0.01)
system

# %%
# The Allan deviation of that system lies on the curve of the record.

curve = analysis.curves["gyro_x"]
figure, ax = plt.subplots(layout="constrained")
curve.plot(ax)
degrees_per_hour = np.degrees(np.sqrt(system.avar(curve.m))) * 3600
ax.loglog(curve.tau, degrees_per_hour, "k--", label="system of the Kalman filter")
_ = ax.legend()
