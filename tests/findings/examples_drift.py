"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.drift import LateDrift, NoiseChange, NonStationary, SegmentSpread, TemperatureDrift, WarmUp

WALKS = (("random_walk", 0.93), ("rate_random_walk", 6.2))


def warm_up(settled, factors=WALKS, **more):
    details = WarmUp(
        quantity="angular_rate", error=2.7e-5, time_constant=settled / 5, settled=settled, duration=1200.0, **more
    )
    return Finding(
        details=details, severity="warning", channels=("gyro_x",), spans=((0.0, min(settled, 1200.0)),), size=2e-3,
        unit="rad/s", factors=factors,
    )  # fmt: skip


def late_drift(begins, **more):
    details = LateDrift(
        quantity="acceleration", error=3.5e-5, time_constant=(1200 - begins) / 5, duration=1200.0, **more
    )
    return Finding(
        details=details, severity="warning", channels=("accel_y",), spans=((begins, 1200.0),), size=0.0031, unit="m/s^2",
        factors=(("rate_random_walk", 26.43),),
    )  # fmt: skip


SEGMENTS = SegmentSpread(
    ratio=1.523, tau=0.02, tau_min=0.02, tau_max=5.12, largest_at=600.0, smallest_at=450.0, length=150.0
)
CHANGE = NoiseChange(time=599.04, ratio=1.501)

EXAMPLES = [
    warm_up(400.0, lower_bounds=("rate_random_walk",)),
    warm_up(800.0, with_steps=True),
    warm_up(2500.0, factors=(), undetermined=("rate_random_walk",)),
    warm_up(410.0, factors=()),
    late_drift(688.3, lower_bounds=("rate_random_walk",)),
    late_drift(20.0, with_steps=True),
    Finding(
        details=TemperatureDrift(
            quantity="angular_rate", rate_unit="rad/s", low=2.96e-4, high=3.04e-4, temperature_range=6.02, share=0.98,
            tau=150.0, lower_bounds=("rate_random_walk",),
        ),
        severity="warning", channels=("gyro_z",), size=3e-4, unit="rad/s/K", factors=WALKS,
    ),
    Finding(
        details=NonStationary(segments=SEGMENTS), severity="warning", channels=("gyro_x",), spans=((600.0, 750.0),),
        size=1.523,
    ),
    Finding(
        details=NonStationary(change=CHANGE), severity="info", channels=("gyro_x",), spans=((599.04, 599.04),),
        size=1.501,
    ),
    Finding(
        details=NonStationary(segments=SEGMENTS, change=CHANGE), severity="warning", channels=("gyro_x",),
        spans=((599.04, 599.04),), size=1.523,
    ),
]  # fmt: skip
