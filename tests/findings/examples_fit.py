"""Examples of findings for `test_words`, with every reason of a fit."""

from dataclasses import replace

from sigmatau.findings.curves import (
    CheckedInPart,
    CheckedWithoutFit,
    ConstantChannel,
    CurvesNotKept,
    NoMap,
    OutOfRange,
    Strided,
    TooFewSamples,
)
from sigmatau.findings.finding import Finding
from sigmatau.findings.fit import (
    BeyondClass,
    ChangingLevel,
    CountedAngle,
    Disturbed,
    FewDegreesOfFreedom,
    NoAdequateModel,
    OtherAxesDisturbed,
    SecondExplanation,
    ShortTimesLeftOut,
    TooShort,
    Widened,
)
from sigmatau.findings.reasons import (
    BandsOff,
    CoarseValues,
    IncompleteRecord,
    Misfit,
    NoCovariance,
    ShortTimesDeviate,
    TooFewTimes,
    UnmodelledBand,
    VibrationPower,
    ZeroVariance,
)


def of_gyro(details, severity="warning", **more):
    return Finding(details=details, severity=severity, channels=("gyro_x",), **more)


COUNTED = CountedAngle(quantity="angular_rate", rate_unit="rad/s", step=4.24e-5, by_step=1.224e-5)
FEW = TooFewTimes(times=7, needed=8, samples=60000)
FILTER = UnmodelledBand(highest=12.5)
OFF = BandsOff(frequency=0.0033, ratio=1.34)

SHAKING = VibrationPower(lines=38, resonances=3, share=0.97, start=75.0, stop=87.5, quietest=5.8e-7)
SHAKEN = Disturbed(
    quantity="angular_rate",
    rate_unit="rad/s",
    lines=38,
    resonances=3,
    share=0.97,
    start=75.0,
    stop=87.5,
    quietest=5.8e-7,
)

CHANGING = ChangingLevel(
    quantity="angular_rate",
    rate_unit="rad/s",
    lowest=9.3e-5,
    highest=1.1e-4,
    next_lowest=8.4e-5,
    next_highest=1.2e-4,
    p_value=1e-9,
)

BIAS, WALK = ("bias_instability", 2.4e-5), ("rate_random_walk", 2.5e-6)
SECOND = SecondExplanation(
    quantity="angular_rate", rate_unit="rad/s", terms=(), processes=(), other_terms=(), other_processes=()
)

EXAMPLES = [
    *(
        of_gyro(replace(COUNTED, **seen), "info", size=1.224e-5)
        for seen in (
            {"value": 1.216e-5, "low": 1.17e-5, "high": 1.26e-5},
            {"value": 2.4e-5, "low": 2.3e-5, "high": 2.5e-5},
            {"value": 0.7e-5, "low": 0.6e-5, "high": 0.8e-5},
            {"value": 0.7e-5},
            {"limit": 1.4e-5},
            {},
        )
    ),
    Finding(
        details=replace(
            COUNTED,
            quantity="acceleration",
            rate_unit="m/s^2",
            step=7.62e-4,
            by_step=2.2e-4,
            value=2.1e-4,
            low=1.9e-4,
            high=2.3e-4,
        ),
        severity="info",
        channels=("accel_x",),
        size=2.2e-4,
    ),
    of_gyro(TooShort(reasons=(FEW,))),
    of_gyro(TooShort(reasons=(FEW,), missing=0.9996), size=0.9996),
    of_gyro(TooShort(reasons=(ZeroVariance(),))),
    of_gyro(TooShort(reasons=(IncompleteRecord(missing=12, samples=5000),))),
    of_gyro(TooShort(reasons=(IncompleteRecord(missing=12, samples=300, suits_likelihood=False),))),
    *(
        of_gyro(NoAdequateModel(reasons=(reason,)))
        for reason in (
            Misfit(p_value=2e-5, tau_min=2.56, tau=41.0, ratio=1.39),
            Misfit(p_value=1e-40, tau_min=0.02, tau=0.02, ratio=0.68),
            Misfit(p_value=None, tau_min=0.02, tau=15.36, ratio=9.4),
            NoCovariance(),
            CoarseValues(),
            FILTER,
        )
    ),
    *(
        of_gyro(ShortTimesLeftOut(tau_min=0.32, reasons=reasons), "info")
        for reasons in (
            (),
            (ShortTimesDeviate(cluster_size=1, ratio=0.41),),
            (ShortTimesDeviate(cluster_size=4, ratio=1.27),),
            (IncompleteRecord(missing=12, samples=5000),),
            (FILTER,),
        )
    ),
    of_gyro(Widened(frequency=0.0033, ratio=1.34, allowed=0.2), "warning", size=0.03),
    of_gyro(Widened(frequency=0.2, ratio=0.8, allowed=0.2, lines=100), "warning", size=0.03),
    of_gyro(Widened(frequency=0.2, ratio=0.8, allowed=0.2, lines=100, crowded=0.35), "warning", size=0.2),
    of_gyro(Widened(frequency=0.2, ratio=1.8, allowed=0.6, only_walk=True), "warning", size=0.2),
    of_gyro(Widened(frequency=0.2, ratio=1.8, allowed=0.6, only_walk=True), "warning"),
    of_gyro(
        Widened(frequency=0.2, ratio=0.8, allowed=0.2, lines=100, crowded=0.35, only_walk=True), "warning", size=0.2
    ),
    of_gyro(CHANGING, "info", size=1.18),
    of_gyro(replace(CHANGING, quantity="acceleration", rate_unit="m/s^2"), "info", size=1.18),
    of_gyro(SHAKEN, size=0.97),
    of_gyro(replace(SHAKEN, start=0.0, stop=0.0, quietest=None), size=0.97),
    of_gyro(replace(SHAKEN, start=0.0, stop=20.0, quietest=None), size=0.97),
    of_gyro(OtherAxesDisturbed(disturbed=("gyro_y", "gyro_z"))),
    of_gyro(BeyondClass(quantity="angular_rate", times=2.1, frequency=0.8), size=0.0037),
    of_gyro(BeyondClass(quantity="acceleration", times=17.0, frequency=None), size=0.085),
    of_gyro(FewDegreesOfFreedom(freedom=11.3, duration=6.0), size=11.3),
    of_gyro(NoAdequateModel(reasons=(SHAKING,)), "warning"),
    of_gyro(NoAdequateModel(reasons=(OFF,)), "warning"),
    of_gyro(OutOfRange(largest=3.1e130, rate_unit="rad/s"), "error"),
    of_gyro(OutOfRange(largest=2e-83, rate_unit="rad/s"), "error"),
    of_gyro(ConstantChannel(samples=60000, value=3.0, rate_unit="rad/s"), "error"),
    of_gyro(ConstantChannel(samples=60000), "error"),
    of_gyro(TooFewSamples(missing=59998, samples=60000), "error"),
    of_gyro(Strided(tau=122.88, samples=8_000_000_000, out_of_memory=True), "info"),
    Finding(details=Strided(tau=122.88, samples=60000), severity="info"),
    Finding(details=CurvesNotKept(), severity="info"),
    *(
        of_gyro(replace(SECOND, **fields), "info")
        for fields in (
            {"terms": (BIAS, WALK), "other_processes": ((3.5e-5, 98.6),)},
            {"terms": (WALK,), "other_warm_up": 900.0},
            {"terms": (BIAS, WALK), "other_exponent": 1.24},
            {"processes": ((2.3e-5, 19.0),), "other_terms": (("bias_instability", 1.4e-5),)},
        )
    ),
    of_gyro(NoMap(samples=30, needed=160), "info"),
    of_gyro(CheckedInPart(checked=16_777_216, samples=100_000_000, duration=131072.0), "info"),
    Finding(details=CheckedWithoutFit(samples=12_000_000), severity="info"),
]
