"""Clean records of any mixture of the five terms, for which a check must not report a finding."""

import math

import numpy as np

from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.samples.check import check
from sigmatau.quality.samples.disturbances import disturbances

CHANNELS = tuple(f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz")


def mixture(rng, *, tau0, duration):
    """Coefficients of one channel: terms that cross the white noise anywhere between a sample and ten records, or a
    single term.
    """

    def between(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    n = between(1e-6, 1e-3)
    tau_b = between(1, duration)
    terms = {
        "quantization": n * math.sqrt(between(tau0 / 10, 100 * tau0) / 3),
        "random_walk": n,
        "bias_instability": n / math.sqrt(tau_b) / 0.664,
        "rate_random_walk": n * math.sqrt(3) / between(1, 10 * duration),
        "rate_ramp": rng.choice([-1.0, 1.0]) * n * math.sqrt(2) / between(duration / 30, 10 * duration) ** 1.5,
    }
    chosen = [term for term in terms if rng.random() < 0.6]
    if not chosen or rng.random() < 0.2:
        chosen = [("quantization", "random_walk", "bias_instability", "rate_random_walk")[rng.integers(4)]]
    return {term: float(terms[term]) for term in chosen}


def record(rng, *, most=150_000, shortest=600.0, longest=4 * 3600.0):
    """Six axes, 10 min to 4 h at 10 to 400 Hz, `most` samples."""
    rate = float(rng.choice([10, 20, 50, 100, 125, 200, 400]))
    duration = min(math.exp(rng.uniform(math.log(shortest), math.log(longest))), most / rate)
    duration = max(duration, 4 / rate)
    channels = {c: mixture(rng, tau0=1 / rate, duration=duration) for c in CHANNELS}
    return simulate(NoiseModel(channels=channels), duration=duration, rate=rate, rng=int(rng.integers(1 << 62)))


def rounded(stream, rng):
    """The stream rounded to steps of 1/30 to 3 times the size of the noise; samples as arrays by channel."""
    columns = {}
    for channel in stream.channels:
        x = np.asarray(stream.column(channel))
        step = float(np.std(np.diff(x))) / math.sqrt(2) * math.exp(rng.uniform(math.log(1 / 30), math.log(3)))
        columns[channel] = np.round(x / step + rng.uniform()) * step
    return columns


def pairs(name, count):
    """Mixtures with random corner times, 10 to 400 Hz, 10 to 40 min; two channels per record."""
    rng = np.random.default_rng(seed_of(name))
    for _ in range(count):
        rate = float(np.exp(rng.uniform(np.log(10), np.log(400))))
        truth = {"random_walk": 1e-3}
        for term, exponent in (("bias_instability", 0.5), ("rate_random_walk", 1.0), ("rate_ramp", 1.5)):
            if rng.random() < 0.5:
                truth[term] = 1e-3 / (10 ** rng.uniform(-1, 3)) ** exponent
        if rng.random() < 0.5:
            truth["quantization"] = 1e-3 * math.sqrt(10 ** rng.uniform(-2.5, 1))
        if len(truth) > 2 and rng.random() < 0.3:
            del truth["random_walk"]
        model = NoiseModel(channels={"gyro_x": truth, "gyro_y": truth})
        duration = min(600 * 4 ** rng.random(), max(2**17 / rate, 600))
        yield simulate(model, duration=duration, rate=rate, rng=rng).streams[0]


@keep_facts()
def check_samples(stream):
    """Findings of the disturbances, and of the other checks of samples."""
    return [*(disturbance.finding for disturbance in disturbances(stream)), *check(stream)]
