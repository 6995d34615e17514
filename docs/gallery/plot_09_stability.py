"""
Does the noise change?
======================

The Allan deviation of sliding windows shows when the noise of a record changed. One curve of the whole record hides it.
"""

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st

rng = np.random.default_rng(1)
y = 1e-3 * rng.standard_normal(360_000)  # an hour at 100 Hz
y[200_000:240_000] *= 1.6  # a pump runs nearby for some minutes
record = st.Record.from_arrays(rate=100, gyro_x=y)

figure, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
_ = st.dynamic_allan(record, "gyro_x", window=180).plot(ax)

# %%
# The analysis tests whether the noise is stationary, and warns.

for finding in st.analyze(record).findings:
    print(f"{finding.severity}: {finding.message}")
    print(f"   {finding.action}")

# %%
# ``window="most-stable=20min"`` analyses the most stable part.

st.analyze(record, window="most-stable=20min")
