"""Examples of findings for `test_words`."""

from sigmatau.findings.drift import NoiseChange, NonStationary, SegmentSpread, TemperatureDrift, WarmUpDrift
from sigmatau.findings.finding import Finding

SEGMENTS = SegmentSpread(
    ratio=1.523, tau=0.02, tau_min=0.02, tau_max=5.12, largest_at=600.0, smallest_at=450.0, length=150.0
)
CHANGE = NoiseChange(time=599.04, ratio=1.501)

EXAMPLES = [
    Finding(
        details=WarmUpDrift(quantity="angular_rate", time_constant=80.0, low=1.95e-3, high=2.05e-3), severity="info",
        channels=("gyro_x",), spans=((0.0, 400.0),), size=2e-3, unit="rad/s",
    ),
    Finding(
        details=TemperatureDrift(quantity="angular_rate", rate_unit="rad/s", low=2.96e-4, high=3.04e-4),
        severity="info", channels=("gyro_z",), size=3e-4, unit="rad/s/K",
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
