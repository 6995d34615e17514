"""
Five noise terms apart
======================

Quantization, random walk, bias instability, rate random walk and ramp in one record, and what the fit makes of them.
"""

import matplotlib.pyplot as plt

import sigmatau as st
from sigmatau.units import to_si

truth = {
    "quantization": to_si(2.0, "arcsec"),
    "random_walk": to_si(0.02, "deg/sqrt(h)"),
    "bias_instability": to_si(1.0, "deg/h"),
    "rate_random_walk": to_si(8.0, "deg/h/sqrt(h)"),
    "rate_ramp": to_si(25.0, "deg/h^2"),
}
model = st.NoiseModel(channels={"gyro_x": truth})
record = st.simulate(model, duration=4 * 3600, rate=20, rng=1)
analysis = st.analyze(record)

figure, ax = plt.subplots(figsize=(7.2, 5.6), layout="constrained")
_ = analysis.plot("gyro_x", ax=ax)

# %%
# Each interval beside the value that was simulated. A term that is not observed has an upper limit.

for name, value in truth.items():
    term = analysis["gyro_x"][name]
    found = f"[{term.low:.3g}, {term.high:.3g}]" if term.observed else f"below {term.upper_limit:.3g}"
    print(f"{name:18} simulated {value:.3g}   found {found} {term.unit}")
