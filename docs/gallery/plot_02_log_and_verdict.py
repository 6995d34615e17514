"""
Read a log and its verdict
==========================

A log with a knock and lost samples: what is found, what is left out, and whether the numbers can be trusted.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import sigmatau as st

model = st.NoiseModel(channels={f"gyro_{axis}": {"random_walk": 8e-5, "bias_instability": 2e-5} for axis in "xyz"})
simulated = st.simulate(model, duration=1800, rate=100, rng=1, imperfections=st.Imperfections(lost=0.002))
rates = np.column_stack([simulated.streams[0].column(name) for name in simulated.channels])
rates[90_000:90_060] += 0.05 * np.random.default_rng(2).standard_normal((60, 3))  # somebody touches the table

log = Path(tempfile.mkdtemp()) / "static.csv"
st.write(st.Record.from_arrays(rate=100, gyro=rates), log)

# %%
# The log is read and analysed. The findings say what was found and what was done.

analysis = st.analyze(log)
for finding in analysis.findings:
    print(f"{finding.severity}: {finding.message}")

# %%
# The result: a value with its interval if the record shows the term, otherwise an upper limit.

analysis

# %%
# A fit has a verdict, and each term is observed or not.

fit = analysis["gyro_x"]
print(fit.verdict, f"p = {fit.p_value:.2f}")
for name, term in fit.terms.items():
    print(f"{name:18} {'observed' if term.observed else 'not observed'}")

# %%
figure, ax = plt.subplots(layout="constrained")
_ = analysis.plot(ax=ax)
