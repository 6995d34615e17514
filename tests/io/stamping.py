"""Time stamps in the form of the reader, for their tests."""

import numpy as np

import sigmatau
from sigmatau.io.read.time import stamps
from sigmatau.io.read.time.rows import in_order


def where(row):
    return f"line {row + 1}"


def ordered(t, *samples):
    return in_order(np.asarray(t), samples, where, "'t'")


def found(t, second=1.0, **more):
    return stamps.fit(ordered(t), second, where, "'t'", **more)


def codes(fit_or_record, *, least="info"):
    wanted = {"info": ("info", "warning", "error"), "warning": ("warning", "error")}[least]
    return [f.code for f in fit_or_record.findings if f.severity in wanted]


def record_of(t, x=None, **options):
    x = np.arange(len(t)) % 7.0 if x is None else x
    return sigmatau.from_frame({"t": np.asarray(t), "wx": x}, unit={"gyro": "rad/s", "time": "s"}, **options)
