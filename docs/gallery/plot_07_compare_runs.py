"""
Compare runs of a unit
======================

Seven days of one gyro, one of them an outlier: the spread between days without the errors of the runs.
"""

import matplotlib.pyplot as plt

import sigmatau as st

days = []
for day, walk in enumerate([1.00, 1.01, 0.99, 1.30, 1.00, 1.01, 1.00]):
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4 * walk}})
    days.append(st.analyze(st.simulate(model, duration=600, rate=100, rng=day)))

compared = st.compare_runs(days, names=[f"day {day}" for day in range(1, 8)])
print(compared)

# %%
figure, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
_ = compared.plot("gyro_x", ax=axes)
