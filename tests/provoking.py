"""Small records, models and results for the calls that raise documented errors."""

import functools
import sys
from pathlib import Path

import numpy as np
import pytest

import sigmatau as st
from known import seed_of

NAN, INF = float("nan"), float("inf")
WHITE = {"random_walk": 1e-4}
ONE = st.ChannelModel(terms=WHITE)
MODEL = st.NoiseModel(channels={"gyro_x": WHITE})
SIX_AXES = st.NoiseModel(channels={f"{sensor}_{axis}": WHITE for sensor in ("gyro", "accel") for axis in "xyz"})
FLICKER = st.ChannelModel(terms={"bias_instability": 1e-5})
QUANTIZED = st.ChannelModel(terms={"quantization": 1e-6})
SLOW_RESONANCE = st.ChannelModel(terms=WHITE, resonance=(st.Resonance(sigma=1e-4, frequency=1e-5, width=1e-6),))


@functools.cache
def record(*channels, n=2000, rate=10.0):
    """White noise on one grid; NaN in `holes`."""
    rng = np.random.default_rng(seed_of("documented errors"))
    return st.Record.from_arrays(rate=rate, **{name: 1e-3 * rng.standard_normal(n) for name in channels or ("gyro_x",)})


def arrays(**channels):
    return st.Record.from_arrays(rate=10.0, **channels)


@functools.cache
def holes():
    y = np.array(record().streams[0].column("gyro_x"))
    y[500:505] = NAN
    return arrays(gyro_x=y)


@functools.cache
def curve():
    return st.allan(record())["gyro_x"]


@functools.cache
def analysis():
    return st.analyze(record())


@functools.cache
def spectrum():
    return st.psd(record())["gyro_x"]


@functools.cache
def cross():
    return st.cross_spectrum(record("gyro_x", "gyro_y"), "gyro_x", "gyro_y")


def pushed(*samples, channels=("gyro_x",), rate=10.0, **options):
    accumulator = st.Accumulator(*channels, rate=rate, **options)
    if samples:
        accumulator.push(np.array(samples))
    return accumulator


@functools.cache
def lot():
    return st.judge_lot([analysis()])


@functools.cache
def compared():
    return st.compare_runs([analysis(), analysis()], names=["a", "b"])


def sheet(**content):
    return st.Datasheet.from_dict({"name": "S", "maker": "M", "source": "page 1", **content})


def open_sheet():
    """A noise density without a convention."""
    return sheet(gyro={"noise_density": {"typical": "0.01 deg/s/sqrt(Hz)", "sided": "unknown"}})


def text(name, content):
    Path(name).write_text(content, encoding="utf-8")
    return name


def log(rows, head="time [s],gyro_x [rad/s]"):
    return text("log.csv", "\n".join([head, *rows, ""]))


def rows(n=100, damaged=""):
    return [*(f"{k / 10},{k * 7 % 11}" for k in range(n)), *([damaged] if damaged else [])]


def store(*analyses, **options):
    made = st.Store("lab.db")
    for analysis_ in analyses:
        made.add(analysis_, **options)
    return made


def without(module, call):
    """A call in a process without a library."""
    with pytest.MonkeyPatch.context() as patch:
        for name in [loaded for loaded in sys.modules if loaded == module or loaded.startswith(f"{module}.")]:
            patch.delitem(sys.modules, name)
        patch.setitem(sys.modules, module, None)
        return call()


def inspected(**options):
    return st.inspect(log(rows()), **options)


def imperfect(**options):
    return st.Imperfections(**options).check(["gyro_x"], 0.1, 100.0)


def planned(others=WHITE, term="rate_random_walk", **options):
    arguments = {
        "channel": "gyro_x",
        "quantity": "angular_rate",
        "rate_unit": "rad/s",
        "rate": 10.0,
        "duration": 1000.0,
    }
    return st.plan(others, term, **(arguments | options))


def simulated(**options):
    return st.simulate(MODEL, **({"duration": 10.0, "rate": 10.0, "rng": 1} | options))


def simulated_to(path="log.csv", **options):
    return st.simulate_to(path, MODEL, **({"duration": 10.0, "rate": 10.0, "rng": 1} | options))


def predicted(model=MODEL, **options):
    return st.predict(model, **({"after": [10.0], "rate": 10.0} | options))


def fitted(**options):
    return st.fit_channel(record(), "gyro_x", **options)


def jointly(*records, **options):
    return st.fit_jointly(records or (record(), record(n=2001)), **options)


EXPORT = {
    st.OptionError: (
        lambda: st.export(MODEL, to="nothing"),
        lambda: st.export(SIX_AXES, to="kalibr", choices=st.Choices(filter_rate=100, strict=True)),
    ),
    st.DataError: (
        lambda: st.export(MODEL, to="kalibr", choices=st.Choices(filter_rate=100)),
        lambda: st.export(MODEL, to="ieee952", path="missing/model.txt"),
    ),
}
PSD = (
    lambda: st.psd(record(), method="fft"),
    lambda: st.psd(record(), segment=1000.0),
    lambda: st.psd(record(), segment=0.5),
    lambda: st.psd(record(), method="multitaper", tapers=0),
)
STATE_SPACE = (
    lambda: st.state_space(MODEL, dt=0.1),
    lambda: st.state_space(ONE, dt=0),
    lambda: st.state_space(FLICKER, dt=0.1, tau_max=-1.0),
    lambda: st.state_space(FLICKER, dt=0.1, flicker_error=1e-9),
)
SIMULATE = (
    lambda: simulated(rate=0.0),
    lambda: simulated(duration=-1.0),
    lambda: simulated(duration=0.2),
    lambda: simulated(imperfections=st.Imperfections(level={"accel": 9.8})),
)
LEVELS = {"level": 1.5}


def _long_with_holes():
    y = np.zeros(1_000_000)
    y[::1000] = NAN
    return arrays(gyro_x=y)
