"""One fault, one warning: single faults planted in 20 minutes of white noise and bias instability."""

from dataclasses import replace

import numpy as np
import pytest
from sigmatau.quality.causes import one_cause

from known import seed_of
from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.findings.finding import Cause, Finding
from sigmatau.findings.kinds.drift import NonStationary
from sigmatau.findings.kinds.fit import NoAdequateModel
from sigmatau.findings.kinds.spectrum import Line, SpectralLines
from sigmatau.findings.kinds.values import Saturation

N, RATE = 1e-3, 100.0
SD = N * RATE**0.5
AT = 48_000


def minutes(name):
    terms = {"random_walk": N, "bias_instability": N / 1 / 0.664}
    model = NoiseModel(channels={f"gyro_{axis}": terms for axis in "xyz"})
    record = simulate(model, duration=1200, rate=RATE, rng=seed_of(name))
    return np.stack([record.streams[0].column(channel) for channel in record.channels], axis=1)


def knock(x):
    t = np.arange(300) / RATE
    x[AT : AT + 300, 0] += 50 * SD * np.exp(-t / 0.5) * np.sin(2 * np.pi * 7 * t)


def dropout(x):
    x += 30 * SD
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
def test_one_fault_is_one_warning(code, fault):
    x = minutes(f"one fault {fault.__name__}")
    fault(x)
    findings = analyze(Record.from_arrays(rate=RATE, gyro=x)).findings
    assert [f.code for f in findings if f.severity != "info"] == [code]
    for finding in findings:
        if finding.code in ("no_adequate_model", "spectral_line"):
            assert finding.cause.code == code


def test_what_is_elsewhere_stays_a_warning():
    def of(kind, channel, *spans):
        # one_cause looks at the kind, not at the fields of it.
        return Finding(details=object.__new__(kind), severity="warning", channels=(channel,), spans=spans)

    fault = of(Saturation, "a", (1440.0, 1440.0))
    near, far = of(NonStationary, "a", (1350.0, 1350.0)), of(NonStationary, "a", (450.0, 450.0))
    other = of(NoAdequateModel, "b")
    steady = Line(frequency=7.0, amplitude=1.0, width=0.0, ratio=100.0, low=6.9, high=7.1)
    lines = SpectralLines(lines=(replace(steady, width=0.4),), factor=2.0, tau=1.0, clear_from=4.0)
    broad = Finding(details=lines, severity="warning", channels=("a",))
    sharp = replace(broad, details=replace(lines, lines=(*lines.lines, steady)))
    said = one_cause([fault, near, far, other, broad, sharp], ["a", "b"], 3600.0)
    assert [f.severity for f in said] == ["warning", "info", "warning", "warning", "info", "warning"]
    cause = Cause(code="saturation", spans=((1440.0, 1440.0),))
    assert [f.cause for f in said] == [None, cause, None, None, cause, None]


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
