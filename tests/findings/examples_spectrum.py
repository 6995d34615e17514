"""Examples of findings for `test_words`."""

from dataclasses import replace

from sigmatau.findings.finding import Cause, Finding, FitEffect
from sigmatau.findings.kinds.spectrum import (
    Aliasing,
    AxisPair,
    CorrelatedAxes,
    Line,
    LowPassFilter,
    Mains,
    Resampled,
    SpectralLines,
)

FIT = FitEffect(
    channel="gyro_x",
    tau_min_s=0.08,
    compared_from_s=0.08,
    without=("spectral_line",),
    verdict="adequate",
    verdict_without="adequate",
)
STEADY = Line(frequency=23.30012, amplitude=1.234e-3, width=0.0, ratio=5000.0, low=23.2998, high=23.3005)
BROAD = Line(frequency=0.55, amplitude=5e-3, width=0.0213, ratio=40.0, low=0.53, high=0.57)
FAN = replace(STEADY, harmonics=(replace(STEADY, frequency=46.6, low=46.6, high=46.6),))
FOLDED = replace(STEADY, frequency=20.01, mains=Mains(frequency=60.0, multiple=2, folded=True))

LINES = Finding(
    details=SpectralLines(lines=(FAN,), factor=1.24, tau=0.02, clear_from=0.64, tau_min=0.64),
    severity="warning",
    channels=("gyro_x",),
    size=STEADY.amplitude,
    unit="rad/s",
)
FILTER = Finding(
    details=LowPassFilter(
        shape="digital4",
        order=4,
        corner=30.0,
        error=0.21,
        alike=("butterworth4",),
        alike_corners=(29.4,),
        misfit=1.1,
        tau0=0.005,
        sigma_one_sample=0.52,
        right_from=0.12,
        tau_min=0.24,
    ),
    severity="warning",
    channels=("gyro_x",),
    size=30.0,
    unit="Hz",
    factors=(("random_walk", 0.52),),
)
STATED = Aliasing(rate=100.0, bandwidth=30.0, order=None, stated=True, second_order=1.012, rate_needed=271.0)
ALIASING = Finding(
    details=STATED,
    severity="warning",
    channels=("gyro_x", "gyro_y", "gyro_z"),
    size=1.131,
    factors=(("random_walk", 1.131),),
)
RESAMPLED = Finding(
    details=Resampled(kind="held", rate=63.0, log_rate=200.0, sigma_one_sample=0.16, right_from=0.635, depth=1.3),
    severity="warning",
    channels=("gyro_x",),
    size=63.0,
    unit="Hz",
    factors=(("random_walk", 0.16),),
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
FACTORS = (("random_walk", 1.12), ("bias_instability", 2.31))
EXAMPLES = [
    LINES,
    replace(LINES, factors=FACTORS, fit_effect=FIT),
    replace(LINES, details=replace(LINES.details, lines=(FOLDED, BROAD, STEADY), tau_min=0.0), severity="info"),
    replace(LINES, details=replace(LINES.details, lines=(BROAD,), factor=1.0, tau=None, clear_from=None)),
    replace(
        LINES,
        details=replace(LINES.details, lines=(BROAD,)),
        severity="info",
        cause=Cause(code="not_static", spans=((1440.0, 1443.0),)),
    ),
    FILTER,
    replace(FILTER, factors=(), fit_effect=FIT),
    replace(FILTER, factors=(), fit_effect=replace(FIT, hidden=("random_walk",), verdict="descriptive")),
    replace(FILTER, factors=(("random_walk", 0.87),), fit_effect=FIT),
    ALIASING,
    replace(ALIASING, details=replace(STATED, order=2, second_order=None), severity="info"),
    replace(ALIASING, details=replace(STATED, order=1, stated=False, error=0.3, second_order=None)),
    RESAMPLED,
    replace(RESAMPLED, factors=(), fit_effect=FIT),
    CORRELATED,
    replace(CORRELATED, details=CorrelatedAxes(pairs=(replace(SLOW[0], mean_length=0.0),), only_slow=False)),
    replace(CORRELATED, severity="info", cause=Cause(code="warm_up", spans=((0.0, 600.0),))),
]
