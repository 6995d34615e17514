"""Examples of findings for `test_words`."""

from dataclasses import replace

from sigmatau.findings.finding import Finding
from sigmatau.findings.spectrum import (
    Aliasing,
    AxisPair,
    BandLeftOut,
    CorrelatedAxes,
    GaussMarkovProcess,
    IdenticalAxes,
    LowPassFilter,
    Mains,
    ResonanceProcess,
    SpectralLine,
    SpectralLines,
)

STEADY = SpectralLine(frequency=23.30012, amplitude=1.234e-3, low=23.2998, high=23.3005)
BROAD = SpectralLine(frequency=0.55, amplitude=5e-3, low=0.53, high=0.57)
FAN = replace(STEADY, harmonics=(replace(STEADY, frequency=46.6, low=46.6, high=46.6),))
FOLDED = replace(STEADY, frequency=20.01, mains=Mains(frequency=60.0, multiple=2, folded=True))


def found(details, size, unit="rad/s"):
    return Finding(details=details, severity="info", channels=("gyro_x",), size=size, unit=unit)


LINES = found(SpectralLines(lines=(FAN,)), STEADY.amplitude)
FILTER = LowPassFilter(shape="butterworth", order=2, corner=30.0, low=29.8, high=30.2)
STATED = Aliasing(rate=100.0, bandwidth=30.0, order=None, second_order=1.012, rate_needed=271.0)
ALIASING = Finding(
    details=STATED,
    severity="warning",
    channels=("gyro_x", "gyro_y", "gyro_z"),
    size=1.131,
    factors=(("random_walk", 1.131),),
)
SLOW = (
    AxisPair(first="gyro_x", second="gyro_y", coefficient=-0.42, mean_length=64.0),
    AxisPair(first="gyro_x", second="gyro_z", coefficient=0.31, mean_length=16.0),
)
CORRELATED = Finding(
    details=CorrelatedAxes(pairs=SLOW, only_slow=True),
    severity="warning",
    channels=("gyro_x", "gyro_y", "gyro_z"),
    size=0.42,
)
EXAMPLES = [
    LINES,
    replace(LINES, details=SpectralLines(lines=(FOLDED, BROAD, STEADY))),
    found(FILTER, 30.0, "Hz"),
    found(replace(FILTER, order=1), 30.0, "Hz"),
    found(replace(FILTER, shape="smoothing", order=None), 30.0, "Hz"),
    found(replace(FILTER, shape="running_mean", order=4), 30.0, "Hz"),
    found(replace(FILTER, shape="low_pass", order=None), 30.0, "Hz"),
    found(replace(FILTER, shape="uneven", order=None, corner=None, low=None, high=None), None, "Hz"),
    found(BandLeftOut(highest=12.5), 12.5, "Hz"),
    found(GaussMarkovProcess(quantity="angular_rate", time=24.0, low=13.1, high=49.6), 9.7e-5),
    found(ResonanceProcess(quantity="acceleration", frequency=10.18, width=0.42), 4.7e-3, "m/s^2"),
    ALIASING,
    replace(ALIASING, details=replace(STATED, order=2, second_order=None), severity="info"),
    CORRELATED,
    replace(
        CORRELATED,
        channels=("gyro_x", "gyro_y"),
        details=CorrelatedAxes(pairs=(replace(SLOW[0], mean_length=0.0),), only_slow=False),
    ),
    replace(CORRELATED, severity="info"),
    Finding(details=IdenticalAxes(samples=100_000), severity="warning", channels=("gyro_x", "gyro_y")),
]
