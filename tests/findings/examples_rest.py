"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.rest import AssumedAtRest, KeptOfStream, Motion, NotAtRest, PartlyAtRest, TooShortToTell

CARRIED = Motion(channel="gyro_y", quantity="angular_rate", kind="varies", size=14.7, times=23000.0, tau=0.97)
SHAKEN = Motion(channel="accel_x", quantity="acceleration", kind="varies", size=0.256, times=17.8, tau=0.5)
TURNED = Motion(channel="gyro_z", quantity="angular_rate", kind="turns", size=0.785, times=2.25, tau=40.0)
TILTED = Motion(channel="accel_x", quantity="acceleration", kind="tilts", size=0.31, times=3.6, tau=10.0)
LOUD = Motion(channel="gyro_y", quantity="angular_rate", kind="loud", size=0.0052, times=2.98, tau=1.0)
HELD = Motion(channel="gyro_y", quantity="angular_rate", kind="shakes", size=0.012, times=2.1, tau=0.05)


def kept(stream, start, stop, left_out, share):
    return KeptOfStream(stream=stream, start=start, stop=stop, left_out=left_out, share=share)


def of(details, severity="error"):
    return Finding(details=details, severity=severity)


EXAMPLES = [
    of(NotAtRest(motion=CARRIED, duration=242.6, still=((18.8, 70.1),))),
    of(NotAtRest(motion=SHAKEN, duration=3600.0, still=((1200.0, 1500.0), (0.0, 240.0), (2000.0, 2100.0)))),
    of(NotAtRest(motion=TURNED, duration=60.0)),
    of(PartlyAtRest(motion=CARRIED, moved=((1795.0, 1807.0),), kept=(kept("gyro", 0.0, 3600.0, 12.0, 0.997),)), "info"),
    of(
        PartlyAtRest(
            motion=CARRIED,
            moved=((1795.0, 1807.0), (2000.0, 2010.0)),
            kept=(kept("gyro", 0.0, 3600.0, 22.0, 0.994), kept("accel", 0.0, 1795.0, 0.0, 0.499)),
        ),
        "warning",
    ),
    of(
        PartlyAtRest(
            motion=CARRIED,
            moved=((3000.0, 3600.0),),
            kept=(kept("gyro", 0.0, 3000.0, 0.0, 0.833), kept("accel", 0.0, 3000.0, 0.0, 0.833)),
        ),
        "warning",
    ),
    of(NotAtRest(motion=TILTED, duration=60.0)),
    of(NotAtRest(motion=LOUD, duration=60.0)),
    of(NotAtRest(motion=HELD, duration=20.0)),
    of(TooShortToTell(duration=4.81, shortest=10.0)),
    of(TooShortToTell(duration=4.81, shortest=10.0), "info"),
    of(AssumedAtRest(motion=TURNED), "info"),
]
