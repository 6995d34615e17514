"""One fault, one finding: single faults planted in 20 minutes of white noise and bias instability."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate

N, RATE = 1e-3, 100.0
SD = N * RATE**0.5
AT = 48_000
BIAS = 0.1  # rad/s, that of many MEMS gyros


def minutes(name):
    terms = {"random_walk": N, "bias_instability": N / 1 / 0.664}
    model = NoiseModel(channels={f"gyro_{axis}": terms for axis in "xyz"})
    record = simulate(model, duration=1200, rate=RATE, rng=seed_of(name))
    return np.stack([record.streams[0].column(channel) for channel in record.channels], axis=1)


def knock(x):
    t = np.arange(300) / RATE
    x[AT : AT + 300, 0] += 50 * SD * np.exp(-t / 0.5) * np.sin(2 * np.pi * 7 * t)


def dropout(x):
    x += BIAS
    x[AT : AT + 500, 0] = 0.0


def rail(x):
    x[AT : AT + 1000, 0] = 40 * SD


def step(x):
    x[AT:, 0] += 10 * SD


def stuck(x):
    x[AT : AT + 3000, 0] = x[AT, 0]


def clip(x):
    np.clip(x, -SD, SD, out=x)


def spikes(x):
    x[np.random.default_rng(seed_of("where spikes are")).integers(0, len(x), 200), 0] += 30 * SD


FAULTS = {
    "not_static": (knock, step),
    "dropout": (dropout,),
    "saturation": (rail, clip),
    "stuck_samples": (stuck,),
    "spikes": (spikes,),
}
CASES = [(code, fault) for code, faults in FAULTS.items() for fault in faults]


@pytest.mark.parametrize(("code", "fault"), CASES, ids=[fault.__name__ for _, fault in CASES])
def test_one_fault_is_one_finding(code, fault):
    x = minutes(f"one fault {fault.__name__}")
    fault(x)
    findings = analyze(Record.from_arrays(rate=RATE, gyro=x)).findings
    assert [f.code for f in findings if f.severity != "info" or f.left_out] == [code]
    (finding,) = (f for f in findings if f.code == code)
    assert bool(finding.left_out) == (fault not in (step, clip))


@pytest.mark.parametrize("share", [0.998, 0.999])
def test_a_fit_with_too_little_names_the_loss(share):
    x = np.random.default_rng(seed_of(f"too little {share}")).normal(size=(60_000, 3))
    lost = np.random.default_rng(seed_of(f"what is lost {share}")).random(60_000) < share
    x[lost, 1] = np.nan
    findings = analyze(Record.from_arrays(rate=RATE, gyro=x)).findings
    (finding,) = (f for f in findings if f.code in ("too_short", "too_few_samples"))
    assert finding.channel == "gyro_y"
    assert finding.details.missing == (lost.sum() if finding.code == "too_few_samples" else pytest.approx(lost.mean()))


def test_a_fifth_lost_at_random_is_no_warning_of_the_fit():
    x = minutes("a fifth lost")
    x[np.random.default_rng(seed_of("which fifth")).random(len(x)) < 0.2] = np.nan
    assert [f.code for f in analyze(Record.from_arrays(rate=RATE, gyro=x)).findings] == ["missing_values"]
