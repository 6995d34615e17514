"""Examples of findings for `test_words`."""

from sigmatau.findings import exporting as kinds
from sigmatau.findings.finding import Finding

_WALK = tuple(
    kinds.OmittedTerm(channel=f"gyro_{axis}", term=term, value=5e-5)
    for axis in "xyz"
    for term in ("bias_instability", "rate_ramp", "gauss_markov")
)

EXAMPLES = [
    Finding(severity="info", details=kinds.ChoiceWithoutPlace(target="gnss-ins-sim", option="noise_factor")),
    Finding(severity="info", details=kinds.ChoiceWithoutPlace(target="kalibr", option="name", key="gravity")),
    Finding(severity="warning", details=kinds.ChoiceNotUsed(sensor="accel", term="rate_random_walk", observed=True)),
    Finding(severity="warning", details=kinds.ChoiceNotUsed(sensor="gyro", term="random_walk", observed=False)),
    Finding(
        severity="warning",
        channels=("gyro_x",),
        details=kinds.SlowNoiseLeftOut(sensor="gyro", ratio=1.4567, tau=3210.0),
    ),
    Finding(
        severity="warning",
        channels=("gyro_x", "gyro_y", "gyro_z"),
        details=kinds.SlowNoiseLeftOut(sensor="gyro", omitted=_WALK),
    ),
    Finding(severity="info", channels=("gyro_x", "accel_y"), details=kinds.LimitWritten(term="rate_random_walk")),
    Finding(
        severity="info",
        details=kinds.PairConsistency(
            sensor="gyro",
            walk=6.456e-6,
            horizon=60.0,
            nees=3.62,
            stated=tuple(kinds.StatedError(time=t, share=s) for t, s in ((10.0, 0.874), (60.0, 1.0), (600.0, 1.937))),
        ),
    ),
    Finding(
        severity="info",
        details=kinds.PairConsistency(
            sensor="accel",
            walk=1e-5,
            horizon=10.0,
            nees=1.02,
            stated=tuple(kinds.StatedError(time=t, share=1.3) for t in (1.7, 10.0, 100.0)),
        ),
    ),
    Finding(severity="warning", channels=("gyro_x",), details=kinds.QuantizationInSamples(ratio=412.3)),
    Finding(severity="warning", channels=("accel_x",), details=kinds.WideTurnOn(power_ups=2, ratio=31.9)),
    Finding(severity="warning", channels=("gyro_x", "gyro_y"), details=kinds.WideTurnOn(power_ups=3)),
    Finding(severity="warning", channels=("accel_z",), details=kinds.NotAdequate()),
    Finding(severity="warning", channels=("gyro_x",), details=kinds.OnlyLimits()),
    Finding(severity="warning", channels=("accel_x", "accel_z"), details=kinds.PoorTrust()),
    Finding(severity="info", channels=("gyro_x",), details=kinds.MaternAsProcesses(rate=100.0)),
    Finding(severity="info", details=kinds.FastestRate(rate=399.66, rates=(("gyro", 399.66), ("accel", 199.83)))),
    Finding(severity="info", details=kinds.WrittenForOtherRate(rate=200.0, record_rate=98.7654)),
    Finding(
        severity="warning",
        channels=("gyro_x",),
        details=kinds.CorrelatedSamples(ratio=0.3123, independent_variance=2.1931e-6, corner=36.21),
    ),
    Finding(
        severity="warning",
        channels=("gyro_x",),
        details=kinds.CorrelatedSamples(ratio=1.452, independent_variance=2.1931e-6, corner=None),
    ),
    Finding(
        severity="warning",
        channels=("gyro_x",),
        details=kinds.CorrelatedSamples(ratio=None, independent_variance=2.1931e-6, corner=36.21),
    ),
    Finding(severity="info", details=kinds.KeysNotRead(keys=("temperature", "serial"))),
    Finding(severity="info", details=kinds.KeysNotRead(keys=tuple("a" * 300 for _ in range(9)))),
    Finding(severity="info", details=kinds.ImportedWithoutIntervals()),
    Finding(severity="warning", size=200**0.5, details=kinds.DeviationAsDensity(rate=200.0)),
    Finding(severity="warning", details=kinds.MinimumAsWalk(keys=("gyr_w", "acc_w"))),
]
