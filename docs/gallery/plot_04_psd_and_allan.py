"""
Power spectral density beside the Allan deviation
=================================================

The same record in both pictures: a line and a filter are clear in the spectrum, slow noise in the Allan deviation.
"""

import matplotlib.pyplot as plt

import sigmatau as st

model = st.NoiseModel(
    channels={
        "gyro_x": st.ChannelModel(
            terms={"random_walk": 1e-4, "rate_random_walk": 2e-5},
            sinusoid=(st.Sinusoid(amplitude=1e-4, frequency=7.0),),
            bandwidth=st.LowPass(order=1, corner=25.0),
        )
    }
)
record = st.simulate(model, duration=600, rate=100, rng=1)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
st.psd(record)["gyro_x"].plot(left, model=model)
st.allan(record)["gyro_x"].plot(right)
right.set_title("gyro_x: Allan deviation")

# %%
# The fit finds all of it. Densities of sigmatau are two-sided: N² is the height of the flat part of the spectrum.

fit = st.analyze(record)["gyro_x"]
print(fit)
