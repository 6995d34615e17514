"""
An Allan deviation with its band
================================

The overlapped Allan deviation of an array, with 95 % intervals, and the coefficients that were fitted to the record.
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st

rates = 0.05 * np.random.default_rng(1).standard_normal(200_000)  # deg/s, 100 Hz

curve = st.allan(rates, rate=100, unit="deg/s")
figure, ax = plt.subplots(layout="constrained")
curve.plot(ax)

# %%
# The curve as numbers: averaging times, deviations, and the lower and upper limits.

low, high = curve.interval()
for k in range(0, len(curve.tau), 8):
    print(f"{curve.tau[k]:8.2f} s  {curve.adev[k]:.4g} {curve.unit}  [{low[k]:.4g}, {high[k]:.4g}]")

# %%
# A record is fitted by the likelihood of its spectrum. White noise of 0.05 deg/s at 100 Hz is an angle random walk of
# 0.05/√100 deg/s/√Hz, which is 0.3 deg/√h.

record = st.Record.from_arrays(rate=100, gyro_x=rates, unit={"gyro_x": "deg/s"})
st.fit_channel(record, "gyro_x")
