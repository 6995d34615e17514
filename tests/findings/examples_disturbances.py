"""Examples of findings for `test_words`."""

from sigmatau.findings.disturbances import (
    ChosenWindow,
    LeftOut,
    LeftOutOfStream,
    LevelStep,
    MotionBurst,
    NotStatic,
    Spikes,
    StartTransient,
    WindowChosen,
)
from sigmatau.findings.finding import Finding

GYROS = ("gyro_x", "gyro_y", "gyro_z")


def burst(start, stop, ratio, *, departure=0.0, shock=True):
    return MotionBurst(start=start, stop=stop, channels=GYROS, ratio=ratio, departure=departure, shock=shock)


def step(time, size, *, gradual=False):
    return LevelStep(time=time, uncertainty=2.0, size=size, ratio=45.6, window=16.0, gradual=gradual)


def moved(*bursts, channels=GYROS, left=0):
    spans = tuple((burst.start, burst.stop) for burst in bursts)
    return Finding(
        details=NotStatic(quantity="angular_rate", unit="rad/s", bursts=bursts),
        severity="info" if left else "warning",
        channels=channels,
        spans=spans,
        size=bursts[0].ratio,
        left_out=left,
    )


def stepped(*steps, quantity="angular_rate", unit="rad/s", **more):
    return Finding(
        details=NotStatic(quantity=quantity, unit=unit, steps=steps, added_walk=8.3e-6, **more),
        severity="warning",
        channels=("gyro_x",),
        spans=tuple((step_.time, step_.time) for step_ in steps),
        size=abs(steps[0].size),
        unit=unit,
    )


def spikes(count, height, *, left=True, more_below=False, **readings):
    return Finding(
        details=Spikes(
            unit="rad/s",
            count=count,
            samples=60_000,
            share=count / 60_000,
            height=height,
            time=228.53,
            more_below=more_below,
            **readings,
        ),
        severity="info" if left else "warning",
        channels=("gyro_x",),
        spans=((3.39, 3.39),),
        size=abs(height),
        unit="rad/s",
        left_out=count if left else 0,
    )


def left_out(*streams, spans=((300.0, 301.0), (5.0, 6.0))):
    streams_ = tuple(LeftOutOfStream(stream=s, count=c, samples=n, duration=c / 100) for s, c, n in streams)
    return Finding(details=LeftOut(streams=streams_), severity="info", spans=spans, size=2.0, unit="s")


def chosen(*windows):
    told = tuple(
        ChosenWindow(stream=s, start=start, criterion=criterion, by=by, block=60.0, relative=0.8)
        for s, start, criterion, by in windows
    )
    spans = tuple((window.start, window.start + 7200) for window in told)
    return Finding(
        details=WindowChosen(length=7200.0, windows=told), severity="info", spans=spans, size=7200.0, unit="s"
    )


def transient(channels, left):
    return Finding(
        details=StartTransient(settled=1.1),
        severity="info" if left else "warning",
        channels=channels,
        spans=((0.0, 1.1),),
        size=1.1,
        unit="s",
        left_out=left,
    )


EXAMPLES = [
    moved(burst(300.0, 301.0, 34.3), left=300),
    moved(burst(300.004, 300.996, 34.3), channels=("gyro_x",)),
    moved(burst(12_345.0, 12_405.0, 6.29, shock=False), left=6200),
    moved(*(burst(65.0 * k, 65.0 * k + 1.5, 30.0 + k) for k in range(1, 15)), left=4900),
    moved(burst(184.0, 216.0, 137.0, departure=0.0015, shock=False), burst(264.0, 272.0, 80.0, shock=False), left=8000),
    stepped(step(300.0, 2.95e-3), keep=(None, 298.0)),
    stepped(step(300.0, 2.95e-3), step(450.0, -3e-3), leave_out=((298.0, 452.0),)),
    stepped(step(1500.0, -2e-3), beside_drift=True, keep=(None, 1436.25)),
    stepped(step(275.0, 9.14e-3, gradual=True), quantity="acceleration", unit="m/s^2", keep=(291.0, None)),
    stepped(step(275.0, 9.14e-3), keep=(291.0, None)),
    spikes(1, -0.00418),
    spikes(300, 0.00663),
    spikes(5, 0.643, more_below=True),
    spikes(263, 0.0259, more_below=True, tail_factor=1.088, tail_error=0.0082),
    spikes(263, 0.0259, left=False, more_below=True, tail_factor=1.088, tail_error=0.0082),
    spikes(6, 0.00596, small_factor=1.0047),
    spikes(12, 0.643, left=False),
    transient(("accel_x", "accel_y"), 110),
    transient(("accel_x",), 0),
    left_out(("gyro", 200, 60_000), ("accel", 200, 60_000)),
    left_out(("gyro", 150, 60_000), ("accel", 1200, 480_000)),
    left_out(spans=()),
    chosen(("gyro", 5280.0, "own", "gyro")),
    chosen(("gyro", 1200.0, "other", "accel"), ("accel", 9000.0, "other", "gyro")),
    chosen(("gyro", 5400.0, "temperature", "temperature"), ("mag", 60.0, "temperature", "temperature")),
]
