"""Examples of findings for `test_words`."""

import math
from dataclasses import replace

from sigmatau.findings.finding import Finding
from sigmatau.findings.units import Gravity, ImplausibleUnit, MeanRate
from sigmatau.findings.values import (
    CoarseResolution,
    CopiedStretch,
    Dropout,
    FilledOutages,
    FilledSamples,
    Interpolated,
    RepeatedSamples,
    Saturation,
    StuckSamples,
    Upsampled,
)
from sigmatau.noise.terms import TERMS

GYRO = ("gyro_x", "gyro_y", "gyro_z")
ACCEL = ("accel_x", "accel_y", "accel_z")

REPEATED = RepeatedSamples(
    pattern="held",
    copies=30_000,
    share=0.5,
    times=2.0,
    shortest=2,
    longest=2,
    log_rate=200.0,
    sensor_rate=100.0,
    rate_given=False,
    sigma_one_sample=0.5,
    right_from=8,
    walk_at_log_rate=math.sqrt(2),
    walk_at_sensor_rate=1.0,
)
COARSE = CoarseResolution(step=1e-3, noise=1.3e-4, unit="rad/s", rounding="quantization", added=2.89e-6)
GYRO_UNIT = ImplausibleUnit(
    evidence="noise", quantity="angular_rate", stated="rad/s", likely="deg/s", noise=0.33, times=19.0
)


def held(kind, channels, *, samples=500, runs=1, left=True):
    details = kind(samples=samples, runs=runs, share=0.0083, start=200.0, longest=5.0)
    severity = "info" if left else "warning"
    return Finding(details=details, severity=severity, channels=channels, size=0.0083, left_out=samples if left else 0)


def values(details, channels, factors=(), severity="warning", unit=""):
    return Finding(details=details, severity=severity, channels=channels, size=1.0, unit=unit, factors=factors)


def unit(details, channels, factor):
    return values(details, channels, tuple((term, factor) for term in TERMS))


EXAMPLES = [
    Finding(
        details=CopiedStretch(start=100.0, copy=400.0, duration=20.0, rows=2000),
        severity="warning",
        channels=("gyro_x", "gyro_y", "gyro_z"),
        spans=((400.0, 420.0),),
        size=20.0,
        unit="s",
    ),
    held(Dropout, ("gyro_y",)),
    held(Dropout, GYRO, samples=40, runs=40),
    held(Dropout, GYRO, samples=1, runs=1),
    held(StuckSamples, ("gyro_y",), left=False),
    held(StuckSamples, GYRO, runs=12),
    values(
        Saturation(
            strongest="gyro_z",
            samples=7200,
            share=0.18,
            low=-4.36332,
            high=4.36332,
            unit="rad/s",
            start=0.12,
            longest=0.0,
            spread=True,
        ),
        GYRO,
        (("random_walk", 0.85),),
    ),
    values(
        Saturation(
            strongest="accel_z",
            samples=40,
            share=0.001,
            low=None,
            high=156.906,
            unit="m/s^2",
            start=70.0,
            longest=0.4,
            spread=False,
        ),
        ("accel_z",),
    ),
    values(REPEATED, GYRO),
    values(
        replace(REPEATED, rate_given=True, log_rate=100.0, sensor_rate=50.0),
        GYRO,
        (
            ("quantization", 2.0),
            ("random_walk", math.sqrt(2)),
            ("rate_random_walk", math.sqrt(0.5)),
            ("rate_ramp", 0.5),
        ),
    ),
    values(replace(REPEATED, shortest=3, longest=4, times=3.17, sensor_rate=63.1, sigma_one_sample=0.32), GYRO),
    values(replace(REPEATED, pattern="irregular", share=0.3), GYRO, (("random_walk", 1.36),)),
    values(replace(REPEATED, pattern="rows", copies=192, share=0.0048), GYRO, (("random_walk", 1.0048),), "info"),
    values(
        Interpolated(
            strongest="gyro_x",
            share=0.4,
            upsampled=Upsampled(
                sensor_rate=63.0, log_rate=200.0, aligned=False, sigma_one_sample=0.1626, right_from=0.127
            ),
        ),
        GYRO,
        (("random_walk", 0.1626),),
    ),
    values(
        Interpolated(strongest="gyro_y", share=0.03, outages=FilledOutages(count=2, start=800.0, longest=60.0)), GYRO
    ),
    values(
        Interpolated(strongest="gyro_y", share=0.1, singles=FilledSamples(random_walk=1.083, sigma_one_sample=0.93)),
        GYRO,
        (("random_walk", 1.083),),
    ),
    values(CoarseResolution(step=8.73e-4, noise=1.1e-4, unit="rad/s", rounding="unknown", added=None), ("gyro_x",)),
    values(
        CoarseResolution(step=0.0327, noise=0.0196, unit="m/s^2", rounding="white", added=9.4e-4),
        ("accel_x",),
        (("random_walk", 1.17),),
    ),
    values(
        CoarseResolution(step=1e-3, noise=1e-3, unit="rad/s", rounding="white", added=2.9e-5),
        ("gyro_x",),
        (("random_walk", 1.042),),
        "info",
    ),
    values(COARSE, ("gyro_x",), severity="info"),
    values(replace(COARSE, summed=512), ("gyro_x",), severity="info"),
    *(
        values(replace(COARSE, summed=summed, needed=needed, passing=passing), ("gyro_x",))
        for summed, needed, passing in ((512, 1310.72, 0.0), (None, None, 3.125), (None, None, None))
    ),
    values(
        replace(COARSE, step=2e-3, noise=7e-4, unit="m/s^2", added=5.77e-6, summed=4), ("accel_x",), severity="info"
    ),
    unit(
        ImplausibleUnit(evidence="gravity", quantity="acceleration", stated="m/s^2", likely="g", mean=1.013),
        ACCEL,
        1 / 9.80665,
    ),
    unit(replace(GYRO_UNIT, evidence="step", step=1 / 131, sensitivity=131.0), GYRO, 180 / math.pi),
    unit(GYRO_UNIT, GYRO, 180 / math.pi),
    unit(replace(GYRO_UNIT, evidence="quiet", stated="deg/h", likely="deg/s", noise=1.2e-8), GYRO, 1 / 3600),
    unit(replace(GYRO_UNIT, evidence="earth", stated="", likely="", noise=4e-8, mean=2e-6), GYRO, 1.0),
    unit(replace(GYRO_UNIT, evidence="quiet", quantity="acceleration", likely="", noise=1e-8), ACCEL, 1.0),
    unit(replace(GYRO_UNIT, stated="", likely=""), GYRO, 1.0),
    unit(replace(GYRO_UNIT, likely="", by_file=True), GYRO, 1.0),
    unit(replace(GYRO_UNIT, evidence="bias", stated="deg/s", likely="rad/s", mean=0.0157), GYRO, math.pi / 180),
    values(Gravity(mean=10.2, deviation=0.04, low=9.75, high=9.85, cause="bias_or_scale"), ACCEL, severity="info"),
    values(Gravity(mean=0.374, deviation=-0.962, low=9.75, high=9.85, cause="removed"), ACCEL, severity="info"),
    values(Gravity(mean=4.0, deviation=-0.592, low=9.75, high=9.85, cause="unknown"), ACCEL),
    values(MeanRate(mean=math.radians(19.7), usual=math.radians(10)), GYRO),
]
