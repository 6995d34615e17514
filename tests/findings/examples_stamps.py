"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import ClockOff, ImplausibleRate, RateChange, RateDrift, RateMismatch, RateNotNominal
from sigmatau.findings.stamps import (
    BadStamps,
    CoarseStamps,
    CounterOverflows,
    Gap,
    Gaps,
    HostStamps,
    IrregularStamps,
    Jitter,
    LongPauses,
    MissingValues,
)

MINUTE = Gap(samples=6000, start=3000.0, length=60.0, place="line 300002")
SECOND = Gap(samples=100, start=5012.3, length=1.0, place="line 501232")
FACTORS = (("quantization", 1 / 1.2), ("random_walk", 1.2**-0.5), ("rate_random_walk", 1.2**0.5))


def info(details, **more):
    return Finding(details=details, severity="info", **more)


def warning(details, **more):
    return Finding(details=details, severity="warning", **more)


EXAMPLES = [
    warning(ImplausibleRate(rate=0.05, unit="s", other_rate=50.0, other_unit="ms"), size=0.05, unit="Hz"),
    warning(ImplausibleRate(rate=0.5, unit="s", other_rate=500.0, other_unit="ms", stride=2), size=0.5, unit="Hz"),
    info(RateNotNominal(rate=99.3, nominal=100.0), size=-0.007),
    warning(RateMismatch(used=120.0, other=100.0), size=0.2, factors=FACTORS),
    warning(RateMismatch(used=101.0, other=100.0), size=0.01, factors=(("random_walk", 1.01**-0.5),)),
    warning(RateMismatch(used=120.0, other=100.0)),
    warning(RateMismatch(used=100.0, other=50.0, stated=True)),
    warning(ClockOff(factor=0.97, low=0.9694, high=0.9706, marks=9, others=5), size=0.97),
    warning(RateDrift(lowest=99.75, highest=100.25), size=0.005, spans=((900.0, 1000.0),)),
    warning(RateChange(before=50.0, after=100.0, grid=100.0, place="line 30002"), size=2.0, spans=((600.0, 900.0),)),
    warning(
        RateChange(before=100.0, after=80.0, grid=89.0),
        size=1.25,
        spans=((600.0, 900.0),),
        factors=(("random_walk", 1.12),),
    ),
    info(Gaps(samples=1001, gaps=1, longest=(MINUTE,), rate=100.0), size=1, spans=((5.0, 5.01),)),
    warning(Gaps(samples=726_000, gaps=2, longest=(MINUTE, SECOND), rate=100.0), size=6100),
    warning(Gaps(samples=56_000, gaps=1, longest=(MINUTE,), rate=100.0, estimated=True), size=6000),
    warning(Gaps(samples=59_999, gaps=11_999, longest=(SECOND,), rate=100.0, period=4, even_rate=80.0), size=11_999),
    warning(
        LongPauses(pauses=1, longest=36_000.0, place="row 18000", used=18_000, total=30_000), size=36_000.0, unit="s"
    ),
    warning(IrregularStamps(interval=0.01, longest=75_000.0, place="line 12345"), size=75_000.0, unit="s"),
    warning(IrregularStamps(interval=0.01, leaps=3)),
    info(CoarseStamps(step=0.01, rate=400.0, hidden=5), size=0.01, unit="s"),
    info(CoarseStamps(step=0.01, rate=99.0, period=100, lost=1), size=0.01, unit="s"),
    warning(
        CoarseStamps(step=128.0, rate=100.0, rate_error=0.021, hidden=12_801, single_precision=True),
        size=128.0,
        unit="s",
    ),
    warning(
        CoarseStamps(step=128.0, rate=100.0, rate_error=None, hidden=12_801, single_precision=True),
        size=128.0,
        unit="s",
    ),
    warning(HostStamps(rate=100.012, median_rate=1000.0), size=0.75),
    warning(HostStamps(rate=15.72, median_rate=15.8), size=0.0),
    info(CoarseStamps(step=1.0, rate=100.0, rate_error=5e-4, hidden=101), size=1.0, unit="s"),
    info(CounterOverflows(period=65536.0, column="t", place="line 5001"), size=2),
    info(Jitter(sigma=1e-3, interval=0.01), size=1e-3, unit="s"),
    info(Jitter(sigma=5e-4, interval=0.01, added=4.9e-3, unit="m/s"), channels=("accel_z",), size=5e-4, unit="s"),
    warning(BadStamps(what="missing", rows=2000, place="line 51"), size=2),
    warning(BadStamps(what="late", rows=5000, place="line 1002"), size=5),
    warning(BadStamps(what="wrong", rows=5000, place="line 1235"), size=1),
    warning(BadStamps(what="repeated", rows=10_000, place="line 3"), size=5000),
    info(
        MissingValues(
            total=4000, counts=(2, 1), strongest="gyro_x", place="line 5", runs=2, longest=1, longest_place="line 5"
        ),
        channels=("gyro_x", "gyro_y"),
        size=2,
    ),
    warning(
        MissingValues(
            total=20_000,
            counts=(7900,),
            strongest="gyro_y",
            place="index 1000 (t = 10 s)",
            runs=1,
            longest=7900,
            longest_place="index 1000 (t = 10 s)",
            unit="samples",
        ),
        channels=("gyro_y",),
        spans=((10.0, 89.0),),
        size=7900,
    ),
    warning(
        MissingValues(
            total=20_000,
            counts=(910,),
            strongest="gyro_y",
            place="line 7",
            runs=12,
            longest=800,
            longest_place="line 4002",
        ),
        channels=("gyro_y",),
        size=910,
    ),
    Finding(
        details=MissingValues(
            total=20_000,
            counts=(12_000,),
            strongest="gyro_y",
            place="line 2",
            runs=1,
            longest=12_000,
            longest_place="line 2",
            dropped=True,
        ),
        severity="error",
        channels=("gyro_y",),
        size=12_000,
    ),
]
