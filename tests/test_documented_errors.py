"""Every error in the docstring of a public name is provoked, in each way that the docstring states.

`PROVOKED` has, by name and error, the calls that raise it. A Raises section without an entry here fails the test, and so
does an entry without a Raises section.
"""

import functools
import importlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import sigmatau as st
from docstring_sections import Sections
from known import seed_of
from public_names import function_of, public, public_functions
from sigmatau.model.transform import avar_from_psd
from sigmatau.noise import terms
from sigmatau.noise.uncertainty import avar_covariance, chi2_factors, degrees_of_freedom, percentage_error
from sigmatau.simulation.imperfections import Outage, Temperature, WarmUp
from sigmatau.store.naming import Naming
from sigmatau.units import to_si

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
    for one in analyses:
        made.add(one, **options)
    return made


def without(module, call):
    """A call in a process that does not have a library."""
    with pytest.MonkeyPatch.context() as patch:
        for name in [one for one in sys.modules if one == module or one.startswith(f"{module}.")]:
            patch.delitem(sys.modules, name)
        patch.setitem(sys.modules, module, None)
        return call()


def inspected(**options):
    return st.inspect(log(rows()), **options)


def imperfect(**options):
    return st.Imperfections(**options).check(["gyro_x"], 0.1, 100.0)


def planned(others=WHITE, term="rate_random_walk", **options):
    known = {"channel": "gyro_x", "quantity": "angular_rate", "rate_unit": "rad/s", "rate": 10.0, "duration": 1000.0}
    return st.plan(others, term, **(known | options))


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

PROVOKED = {
    "Accumulator": {
        st.OptionError: (
            lambda: pushed(rate=0.0),
            lambda: pushed(unit={"gyro": "furlong"}),
            lambda: pushed(taus="all"),
            lambda: pushed(start=-1),
            lambda: pushed(channels=()),
        )
    },
    "Accumulator.push": {
        st.NonFiniteError: (lambda: pushed(NAN), lambda: pushed(INF), lambda: pushed(1e131)),
        ValueError: (lambda: pushed([1.0, 2.0]), lambda: pushed().push({"gyro_y": [1.0]})),
    },
    "Accumulator.merge": {
        TypeError: (lambda: pushed().merge(curve()),),
        ValueError: (
            lambda: pushed().merge(pushed(channels=("gyro_y",))),
            lambda: pushed().merge(pushed(rate=20.0)),
            lambda: pushed().merge(pushed(taus="octave")),
            lambda: pushed(1.0, 2.0).merge(pushed(start=3)),
        ),
    },
    "Accumulator.snapshot": {
        st.RecordTooShortError: (lambda: pushed(1.0).snapshot(), lambda: pushed(1.0, 2.0, taus=[10.0]).snapshot())
    },
    "Analysis.plot_stability": {st.OptionError: (lambda: analysis().plot_stability(),)},
    "Analysis.from_dict": {st.DataError: (lambda: st.Analysis.from_dict({}), lambda: st.Analysis.from_dict(3))},
    "Analysis.from_json": {
        st.DataError: (lambda: st.Analysis.from_json("missing.json"), lambda: st.Analysis.from_json("{}"))
    },
    "Analysis.mask": {
        KeyError: (lambda: analysis().mask("gyro_q"),),
        st.DataError: (lambda: replace(analysis(), masks={}).mask("gyro_x"),),
    },
    "Analysis.model": {st.DataError: (lambda: st.analyze(record(), method="read-off").model,)},
    "NoiseModel.from_result": {
        st.DataError: (lambda: st.NoiseModel.from_result(st.analyze(record(), method="read-off")),)
    },
    "NoiseFit.to_model": {st.DataError: (lambda: replace(analysis()["gyro_x"], verdict="too_short").to_model(),)},
    "Analysis.export": {
        st.OptionError: (lambda: analysis().export(to="nothing"),),
        st.DataError: (lambda: analysis().export(to="kalibr"),),
    },
    "Tabular.to_dataframe": {ImportError: (lambda: without("pandas", curve().to_dataframe),)},
    "ChannelModel": {
        st.DataError: (
            lambda: st.ChannelModel(terms={"drift": 1.0}),
            lambda: st.ChannelModel(terms={"random_walk": -1.0}),
            lambda: st.ChannelModel(),
            lambda: st.ChannelModel(terms={"bias_instability": 1e-5}, bandwidth=st.LowPass(order=1, corner=10.0)),
        )
    },
    "ChannelModel.avar": {
        ValueError: (lambda: ONE.avar(m=[0], tau0=0.1), lambda: ONE.avar(m=[1], tau0=0.0)),
    },
    "ChannelModel.adev": {
        st.OptionError: (
            lambda: ONE.adev(),
            lambda: ONE.adev([-1.0]),
            lambda: ONE.adev(m=[1]),
            lambda: ONE.adev([1.0], m=[1]),
        ),
    },
    "ChannelModel.psd": {
        st.OptionError: (
            lambda: QUANTIZED.psd([1.0]),
            lambda: ONE.psd([0.0]),
            lambda: ONE.psd([6.0], tau0=0.1),
        )
    },
    "ChannelModel.autocovariance": {
        st.DataError: tuple(
            functools.partial(st.ChannelModel(terms={term: 1e-6}).autocovariance, [0], tau0=0.1)
            for term in ("bias_instability", "rate_random_walk", "rate_ramp")
        ),
        st.OptionError: (lambda: ONE.autocovariance([0.5], tau0=0.1), lambda: ONE.autocovariance([0], tau0=0.0)),
    },
    "ChannelModel.phase_autocovariance": {
        st.OptionError: (
            lambda: ONE.phase_autocovariance([0.5], tau0=0.1),
            lambda: ONE.phase_autocovariance([0], tau0=-1.0),
        )
    },
    "ChannelModel.scaled": {st.DataError: (lambda: ONE.scaled(0.0), lambda: ONE.scaled(-1.0))},
    "Choices": {
        st.OptionError: (
            lambda: st.Choices(axes="first"),
            lambda: st.Choices(filter_rate=-1.0),
            lambda: st.Choices(walk={"gyro": "much"}),
            lambda: st.Choices(noise_factor=0.0),
        )
    },
    "CrossSpectrum.significance": {st.OptionError: (lambda: cross().significance(**LEVELS),)},
    "CrossSpectrum.coherence_interval": {st.OptionError: (lambda: cross().coherence_interval(**LEVELS),)},
    "CrossSpectrum.gain_interval": {st.OptionError: (lambda: cross().gain_interval(**LEVELS),)},
    "CrossSpectrum.phase_interval": {st.OptionError: (lambda: cross().phase_interval(**LEVELS),)},
    "Datasheet.read": {st.DataError: (lambda: st.Datasheet.read("missing.toml"),)},
    "Datasheet.from_dict": {
        st.DataError: (
            lambda: sheet(gyro={"noise": "1 deg/h"}),
            lambda: sheet(gyro={"noise_density": {"typical": "much"}}),
        )
    },
    "Datasheet.model": {
        st.OptionError: (lambda: open_sheet().model(), lambda: open_sheet().model(use="mean")),
        st.DataError: (lambda: sheet(gyro={"full_scale": ["300 deg/s"]}).model(),),
    },
    "GaussMarkov": {
        st.DataError: (lambda: st.GaussMarkov(sigma=-1.0, time=1.0), lambda: st.GaussMarkov(sigma=1.0, time=0.0))
    },
    "Imperfections": {
        st.OptionError: (
            lambda: st.Imperfections(lost=0.6),
            lambda: st.Imperfections(jitter=-1.0),
            lambda: st.Imperfections(output="angles"),
        )
    },
    "Imperfections.check": {
        st.OptionError: (
            lambda: imperfect(level={"accel_z": 9.8}),
            lambda: st.Imperfections(temperature=Temperature(start=20.0, end=30.0)).check(["temperature"], 0.1, 100.0),
            lambda: imperfect(outages=(Outage(start=200.0, length=1.0),)),
            lambda: imperfect(outages=(Outage(start=0.0, length=100.0),)),
            lambda: imperfect(jitter=0.02),
        )
    },
    "Lot.plot": {KeyError: (lambda: lot().plot("accel_x"),)},
    "LowPass": {st.DataError: (lambda: st.LowPass(order=10, corner=1.0), lambda: st.LowPass(order=1, corner=0.0))},
    "NoiseModel": {
        st.DataError: (
            lambda: st.NoiseModel(channels={}),
            lambda: st.NoiseModel(channels={"gyro_x": {"drift": 1.0}}),
            lambda: st.NoiseModel(channels={"gyro_x": WHITE}, correlation={"random_walk": {("gyro_x", "gyro_y"): 0.5}}),
        )
    },
    "NoiseModel.read": {
        st.DataError: (
            lambda: st.NoiseModel.read("missing.toml"),
            lambda: st.NoiseModel.read(text("model.toml", "[channels.gyro_x]\nrandom_walk = 'much'\n")),
        )
    },
    "NoiseModel.from_dict": {
        st.DataError: (
            lambda: st.NoiseModel.from_dict({"channels": {"gyro_x": {"drift": "1 deg/h"}}}),
            lambda: st.NoiseModel.from_dict({"channels": {"gyro_x": {"random_walk": "1 deg"}}}),
        )
    },
    "NoiseModel.write": {st.DataError: (lambda: MODEL.write("missing/model.toml"),)},
    "Record.stream_of": {KeyError: (lambda: record().stream_of("gyro_z"),)},
    "Record.from_arrays": {
        TypeError: (lambda: arrays(unit="deg/s", gyro_x=np.zeros(10)),),
        st.OptionError: (
            lambda: st.Record.from_arrays(rate=0.0, gyro_x=np.zeros(10)),
            lambda: st.Record.from_arrays(rate=1e10, gyro_x=np.zeros(10)),
            lambda: arrays(unit={"gyro": "furlong"}, gyro_x=np.zeros(10)),
        ),
        st.DataError: (
            lambda: arrays(),
            lambda: arrays(gyro_x=np.zeros(10), gyro_y=np.zeros(11)),
            lambda: arrays(gyro_x=[0.0, 1.0, INF, 0.0]),
            lambda: arrays(gyro_x=np.zeros(3)),
        ),
    },
    "Resonance": {
        st.DataError: (
            lambda: st.Resonance(sigma=0.0, frequency=1.0, width=0.1),
            lambda: st.Resonance(sigma=1.0, frequency=1.0, width=1.0),
        )
    },
    "RunComparison.plot": {st.OptionError: (lambda: compared().plot("accel_x"),)},
    "Sinusoid": {st.DataError: (lambda: st.Sinusoid(amplitude=0.0, frequency=1.0),)},
    "Spectrum.interval": {st.OptionError: (lambda: spectrum().interval(level=0.0),)},
    "Spectrum.expected": {
        st.DataError: (
            lambda: spectrum().expected(st.NoiseModel(channels={"gyro_y": WHITE})),
            lambda: spectrum().expected(replace(ONE, quantity="acceleration", unit="m/s^2")),
            lambda: spectrum().expected(st.ChannelModel(terms={"rate_ramp": 1e-6})),
        )
    },
    "Spectrum.over": {
        st.DataError: (
            lambda: spectrum().over(st.NoiseModel(channels={"gyro_y": WHITE})),
            lambda: st.psd(record(n=100), segment=0.8)["gyro_x"].over(ONE, per_octave=1),
        )
    },
    "Store": {
        st.OptionError: (lambda: st.Store("mysql://host/name"),),
        st.DataError: (lambda: st.Store(text("lab.db", "no store")), lambda: st.Store("missing.db", create=False)),
        ImportError: (lambda: without("sqlalchemy", lambda: st.Store("lab.db")),),
    },
    "Store.add": {
        st.DataError: (
            lambda: store().add(st.store.rows.Entry(result=analysis(), unit=" ")),
            lambda: store().add(analysis()),
        ),
        st.OptionError: (lambda: store().add(analysis(), batch=0),),
        TypeError: (lambda: store().add(5),),
    },
    "Store.trend": {
        st.DataError: (lambda: store().trend(),),
        st.OptionError: (
            lambda: store().trend("drift"),
            lambda: store().trend(by="hour"),
            lambda: store().trend(level=1.5),
        ),
    },
    "Store.compare": {st.DataError: (lambda: store().compare(),)},
    "Store.latest": {
        st.DataError: (
            lambda: store().latest("A1"),
            lambda: store(analysis(), unit="A1").latest("A1", run="day 2"),
        )
    },
    "DeviationCurve.interval": {
        st.OptionError: (
            lambda: curve().interval(noise="red"),
            lambda: curve().interval(level=0.99),
            lambda: st.allan(record(), overlap="none")["gyro_x"].interval(noise="random_walk", level=0.99),
        )
    },
    "Stream.column": {KeyError: (lambda: record().streams[0].column("gyro_z"),)},
    "Stream.of": {KeyError: (lambda: record().streams[0].of(["gyro_z"]),)},
    "Stream.only": {KeyError: (lambda: record().streams[0].only("gyro_z"),)},
    "Verdict.fails": {
        st.OptionError: (lambda: st.compare_with(MODEL, "icm42688p", sided="one", bias="minimum").fails("perhaps"),)
    },
    "allan": {
        st.RecordTooShortError: (lambda: st.allan([1.0], rate=1.0),),
        st.OptionError: (
            lambda: st.allan(record(), taus=[-1.0]),
            lambda: st.allan(record(), taus=[0.01]),
            lambda: st.allan(record(), taus=[150.0]),
            lambda: st.allan(record(), taus="third"),
            lambda: st.allan(_long_with_holes(), taus="all"),
        ),
    },
    "analyze": {
        st.DataError: (
            lambda: st.analyze(arrays(gyro_x=np.zeros(1000))),
            lambda: st.analyze(holes(), long="strided"),
        ),
        st.OptionError: (lambda: st.analyze(record(), method="eye"), lambda: st.analyze(record(), terms=["drift"])),
    },
    "arma": {
        st.OptionError: (lambda: st.arma(MODEL, dt=0.1), lambda: st.arma(ONE, dt=0.0)),
        st.DataError: (
            lambda: st.arma(st.ChannelModel(sinusoid=(st.Sinusoid(amplitude=1.0, frequency=1.0),)), dt=0.1),
            lambda: st.arma(st.ChannelModel(terms={"rate_ramp": 1e-6}), dt=0.1),
        ),
    },
    "check": {
        st.OptionError: (
            lambda: st.check(record(), bandwidth={"gyro": -1.0}),
            lambda: st.check(record(), bandwidth={"baro": 1.0}),
            lambda: st.check(record(), looked_at=10),
        )
    },
    "compare_runs": {
        st.DataError: (lambda: st.compare_runs(["missing.json"]),),
        st.OptionError: (
            lambda: st.compare_runs([analysis()], names=["a", "b"]),
            lambda: st.compare_runs([analysis()], by="day"),
            lambda: st.compare_runs([analysis()], level=2.0),
        ),
    },
    "compare_with": {
        st.OptionError: (
            lambda: st.compare_with(MODEL, "no sensor"),
            lambda: st.compare_with(MODEL, "icm42688p", level=0.1),
            lambda: st.compare_with(MODEL, "icm42688p", factor=0.5),
            lambda: st.compare_with(MODEL, "icm42688p", sided="three"),
        ),
        st.DataError: (lambda: st.compare_with({}, "icm42688p"), lambda: st.compare_with(MODEL, "missing.toml")),
    },
    "cross_spectrum": {
        st.OptionError: (
            lambda: st.cross_spectrum(record("gyro_x", "gyro_y"), "gyro_x", "gyro_y", method="fft"),
            lambda: st.cross_spectrum(record(), "gyro_x", "gyro_x"),
        ),
        st.DataError: (
            lambda: st.cross_spectrum(record().streams[0], "gyro_x", "gyro_y"),
            lambda: st.cross_spectrum(arrays(gyro_x=np.arange(200.0), accel_x=np.arange(300.0)), "gyro_x", "accel_x"),
        ),
        KeyError: (lambda: st.cross_spectrum(record(), "gyro_x", "gyro_y"),),
        st.RecordTooShortError: (lambda: st.cross_spectrum(record("gyro_x", "gyro_y", n=20), "gyro_x", "gyro_y"),),
    },
    "datasheet": {
        st.OptionError: (lambda: st.datasheet("no sensor"),),
        st.DataError: (lambda: st.datasheet("missing.toml"),),
    },
    "deviation": {
        TypeError: (lambda: st.deviation([1.0, 2.0], kind="total"),),
        st.NonFiniteError: (lambda: st.deviation(holes(), kind="total"),),
        st.RecordTooShortError: (lambda: st.deviation(record(n=8), kind="theo1"),),
        st.OptionError: (
            lambda: st.deviation(record(), kind="partial"),
            lambda: st.deviation(record(), kind="modified", taus=[150.0]),
            lambda: st.deviation(record(), kind="total", overlap="none"),
        ),
    },
    "dynamic_allan": {
        KeyError: (lambda: st.dynamic_allan(record(), "gyro_z"),),
        st.OptionError: (
            lambda: st.dynamic_allan(record(), "gyro_x", window=1000.0),
            lambda: st.dynamic_allan(record(), "gyro_x", window=1.0),
            lambda: st.dynamic_allan(record(), "gyro_x", step=0.0),
            lambda: st.dynamic_allan(record(n=5000), "gyro_x", window=2.0, step=0.1),
            lambda: st.dynamic_allan(record(), "gyro_x", window=10.0, taus=[20.0]),
        ),
        st.RecordTooShortError: (lambda: st.dynamic_allan(record(n=100), "gyro_x"),),
    },
    "export": EXPORT,
    "fit": {
        TypeError: (lambda: st.fit(st.allan(record())),),
        st.OptionError: (
            lambda: st.fit(st.allan(record(), overlap="none")["gyro_x"]),
            lambda: st.fit(curve(), level=0.3),
            lambda: st.fit(curve(), terms=["drift"]),
            lambda: st.fit(curve(), terms=[]),
            lambda: st.fit(curve(), tau_min=50.0),
        ),
    },
    "fit_channel": {
        st.OptionError: (
            lambda: fitted(method="eye"),
            lambda: fitted(terms=["drift"]),
            lambda: fitted(method="gls", processes=[1.0]),
            lambda: fitted(processes=[0.0]),
            lambda: fitted(regressors={"supply": [1.0, 2.0]}),
            lambda: fitted(regressors={"supply": np.full(2000, NAN)}),
            lambda: fitted(regressors={"supply": np.ones(2000)}),
            lambda: fitted(level=0.3),
        ),
        st.DataError: (lambda: st.fit_channel(arrays(gyro_x=np.zeros(1000)), "gyro_x"),),
        KeyError: (lambda: st.fit_channel(record(), "gyro_z"),),
    },
    "fit_jointly": {
        st.OptionError: (
            lambda: jointly(record()),
            lambda: jointly(record(), record("gyro_y")),
            lambda: jointly(common=["drift"]),
            lambda: jointly(names=["one"]),
            lambda: jointly(*[record(n=1000)] * 101),
        ),
        st.DataError: (
            lambda: jointly(record(), record(rate=20.0)),
            lambda: jointly(arrays(gyro_x=np.zeros(1000)), record()),
            lambda: jointly(record(), record()),
        ),
    },
    "from_frame": {
        st.OptionError: (
            lambda: st.from_frame({"gyro_x [rad/s]": np.zeros(10)}),
            lambda: st.from_frame({"gyro_x [rad/s]": np.zeros(10)}, rate=-1.0),
        ),
        st.DataError: (
            lambda: st.from_frame({"gyro_x [rad/s]": np.zeros(10), "gyro_y [rad/s]": np.zeros(9)}, rate=1.0),
            lambda: st.from_frame({"gyro_x [rad/s]": ["a"] * 10}, rate=1.0),
            lambda: st.from_frame({"time [s]": [0.0, 0.1, 0.05, 0.2, 0.3], "gyro_x [rad/s]": np.zeros(5)}),
        ),
        st.NonFiniteError: (
            lambda: st.from_frame({"time [s]": [0.0, 0.1, NAN, NAN, NAN], "gyro_x [rad/s]": np.zeros(5)}),
        ),
        st.RecordTooShortError: (lambda: st.from_frame({"gyro_x [rad/s]": np.zeros(3)}, rate=1.0),),
        TypeError: (lambda: st.from_frame(1.0),),
    },
    "inspect": {
        st.DataError: (lambda: st.inspect("missing.csv"),),
        st.OptionError: (lambda: inspected(keep="everything"), lambda: inspected(topic="/imu")),
    },
    "judge_lot": {
        st.OptionError: (
            lambda: st.judge_lot([]),
            lambda: st.judge_lot([analysis()], level=0.1),
            lambda: st.judge_lot([analysis()], undecided="perhaps"),
        ),
        st.DataError: (lambda: st.judge_lot([analysis()], "missing.toml"),),
    },
    "lot_report": {
        st.OptionError: (lambda: st.lot_report(lot(), "lot.doc"),),
        st.DataError: (lambda: st.lot_report(lot(), "missing/lot.json"),),
        ImportError: (lambda: without("typst", lambda: st.lot_report(lot(), "lot.pdf")),),
    },
    "plan": {
        st.OptionError: (
            lambda: planned(duration=None),
            lambda: planned(term="drift"),
            lambda: planned(others={}),
            lambda: planned(rate=0.0),
            lambda: planned(value=0.0),
            lambda: planned(duration=-1.0),
            lambda: planned(duration=1.0),
        )
    },
    "plot_overlay": {
        st.OptionError: (
            lambda: st.plot_overlay({}),
            lambda: st.plot_overlay({"a": {"x": curve()}, "b": {"x": replace(curve(), unit="m/s^2")}}),
            lambda: st.plot_overlay({"a": {"x": curve()}}, ax=[]),
        )
    },
    "predict": {
        st.OptionError: (
            lambda: predicted(ONE),
            lambda: predicted(after=[-1.0]),
            lambda: predicted(earth="hollow"),
            lambda: predicted(turn_on={"gyro_z": 1e-5}),
            lambda: predicted(turn_on={"gyro_x": 1e-5}, calibration=10.0),
        ),
        st.DataError: (
            lambda: predicted(
                st.NoiseModel(channels={"baro": st.ChannelModel(terms=WHITE, quantity="signal", unit="Pa")})
            ),
        ),
    },
    "psd": {
        st.OptionError: PSD,
        st.RecordTooShortError: (lambda: st.psd(record(n=50)),),
    },
    "random_effects": {
        st.DataError: (
            lambda: st.random_effects([1.0, NAN], [0.1, 0.1]),
            lambda: st.random_effects([1.0, -1.0], [0.1, 0.1]),
            lambda: st.random_effects([1.0, 1.0], [0.1, 0.0]),
            lambda: st.random_effects([], []),
        ),
        st.OptionError: (
            lambda: st.random_effects([1.0, 1.1], None, level=2.0),
            lambda: st.random_effects([1.0, 1.1], None, scale="cubic"),
        ),
    },
    "read": {
        st.OptionError: (
            lambda: st.read(log([row.split(",")[1] for row in rows()], "gyro_x [rad/s]")),
            lambda: st.read(log(rows(), "time [s],gyro_x")),
            lambda: st.read(log(rows(), "time [s],value")),
            lambda: st.read(log(rows()), rate=-1.0),
        ),
        st.DataError: (
            lambda: st.read("missing.csv"),
            lambda: st.read(text("log.csv", "")),
            lambda: st.read(log(rows(damaged="10,1,2,3"))),
            lambda: st.read(log([*rows(damaged="10,a"), *rows()])),
            lambda: st.read(log([*rows(), *rows()])),
        ),
        st.NonFiniteError: (lambda: st.read(log([*rows(9), *["nan,1"] * 10])),),
        st.RecordTooShortError: (lambda: st.read(log(rows(3))),),
    },
    "read_off": {
        st.OptionError: (
            lambda: st.read_off(curve(), random_walk=(10.0, 1.0)),
            lambda: st.read_off(curve(), random_walk=(1e4, 2e4)),
        ),
        TypeError: (lambda: st.read_off(record()),),
    },
    "report": {
        st.OptionError: (
            lambda: st.report(analysis(), "report.doc"),
            lambda: st.report(analysis(), "report.html", record=record(n=1000)),
        ),
        st.DataError: (lambda: st.report(analysis(), "missing/report.html"),),
        ImportError: (lambda: without("typst", lambda: st.report(analysis(), "report.pdf")),),
    },
    "simulate": {st.OptionError: SIMULATE},
    "simulate_to": {
        st.OptionError: (lambda: simulated_to(rate=0.0), lambda: simulated_to("log.doc")),
        st.DataError: (
            lambda: simulated_to("missing/log.csv"),
            lambda: without("pyarrow", lambda: simulated_to("log.parquet")),
        ),
    },
    "state_space": {st.OptionError: (*STATE_SPACE, lambda: st.state_space(ONE, dt=0.1, output="angles"))},
    "transfer": {
        st.OptionError: (
            lambda: st.transfer(st.psd(record(), method="multitaper")["gyro_x"]),
            lambda: st.transfer(spectrum(), random_walk=0.0),
            lambda: st.transfer(spectrum(), taps=0),
        ),
        st.DataError: (lambda: st.transfer(st.psd(arrays(gyro_x=np.zeros(2000)))["gyro_x"]),),
    },
    "verify": {
        st.OptionError: (
            lambda: st.verify(replace(ONE, quantity="acceleration", unit="m/s^2"), curve()),
            lambda: st.verify(ONE, st.allan(record(), overlap="none")["gyro_x"]),
            lambda: st.verify(ONE, st.allan(record(), taus=[0.1])["gyro_x"]),
            lambda: st.verify(ONE, curve(), level=1.5),
            lambda: st.verify(ONE, curve(), tau_min=-1.0),
        ),
        st.DataError: (
            lambda: st.verify(ONE, st.allan(holes())["gyro_x"]),
            lambda: st.verify(st.ChannelModel(terms={"rate_ramp": 1e-6}), curve()),
            lambda: st.verify(
                st.ChannelModel(terms=WHITE, sinusoid=(st.Sinusoid(amplitude=1.0, frequency=0.01),)), curve()
            ),
        ),
    },
    "write": {
        st.OptionError: (lambda: st.write(record(), "log.doc"),),
        st.DataError: (
            lambda: st.write(arrays(gyro_x=np.zeros(20), accel_x=np.zeros(30)), "log.csv"),
            lambda: st.write(record(), "missing/log.csv"),
            lambda: without("pyarrow", lambda: st.write(record(), "log.parquet")),
        ),
    },
    "sigmatau.units.to_si": {st.OptionError: (lambda: to_si(1.0, "furlong"),)},
    "sigmatau.noise.terms.avar": {
        ValueError: (
            lambda: terms.avar("drift", 1.0, m=[1], tau0=1.0),
            lambda: terms.avar("random_walk", 1.0, m=[0], tau0=1.0),
            lambda: terms.avar("random_walk", 1.0, m=[1], tau0=0.0),
            lambda: terms.avar("bias_instability", 1.0, m=[1], tau0=1.0, cutoff=0.0),
        )
    },
    "sigmatau.noise.terms.psd": {
        ValueError: (lambda: terms.psd("drift", 1.0, [1.0]), lambda: terms.psd("quantization", 1.0, [1.0]))
    },
    "sigmatau.noise.uncertainty.degrees_of_freedom": {
        ValueError: (
            lambda: degrees_of_freedom({"drift": 1.0}, n=100, m=[1], tau0=1.0),
            lambda: degrees_of_freedom({"random_walk": INF}, n=100, m=[1], tau0=1.0),
            lambda: degrees_of_freedom(WHITE, n=100, m=[1.5], tau0=1.0),
            lambda: degrees_of_freedom(WHITE, n=100, m=[0], tau0=1.0),
            lambda: degrees_of_freedom(WHITE, n=100, m=[51], tau0=1.0),
        )
    },
    "sigmatau.noise.uncertainty.percentage_error": {
        ValueError: (lambda: percentage_error(100, [0]), lambda: percentage_error(100, [100]))
    },
    "sigmatau.noise.uncertainty.avar_covariance": {
        ValueError: (
            lambda: avar_covariance({"drift": 1.0}, n=100, m=[1], tau0=1.0),
            lambda: avar_covariance(WHITE, n=100, m=[51], tau0=1.0),
            lambda: avar_covariance(WHITE, n=100, m=[1], tau0=0.0),
        )
    },
    "sigmatau.noise.uncertainty.chi2_factors": {
        ValueError: (lambda: chi2_factors([0.0]), lambda: chi2_factors([10.0], level=1.5))
    },
    "sigmatau.model.transform.avar_from_psd": {
        st.DataError: (
            lambda: avar_from_psd(lambda f: f**-3.0, [1.0]),
            lambda: avar_from_psd(lambda f: f**2, [1.0]),
            lambda: avar_from_psd(lambda f: -1.0 + 0 * f, [1.0]),
            lambda: avar_from_psd(lambda f: NAN * f, [1.0]),
        ),
        st.OptionError: (
            lambda: avar_from_psd(lambda f: 1.0 + 0 * f, [0.0]),
            lambda: avar_from_psd(lambda f: 1.0 + 0 * f, [0.15], tau0=0.1),
        ),
    },
    "sigmatau.statespace.state_space.StateSpace.avar": {
        st.OptionError: (
            lambda: st.state_space(ONE, dt=0.1).avar([0]),
            lambda: st.state_space(ONE, dt=0.1).avar([1.5]),
        )
    },
    "sigmatau.statespace.arma.Arma.ar": {st.DataError: (lambda: st.arma(SLOW_RESONANCE, dt=0.01).ar,)},
    "sigmatau.statespace.arma.Arma.ma": {st.DataError: (lambda: st.arma(SLOW_RESONANCE, dt=0.01).ma,)},
    "sigmatau.statespace.arma.Arma.sections": {st.DataError: (lambda: st.arma(SLOW_RESONANCE, dt=0.01).sections,)},
    "sigmatau.simulation.imperfections.WarmUp": {
        st.OptionError: (lambda: WarmUp(amplitude=NAN, time=1.0), lambda: WarmUp(amplitude=1.0, time=0.0))
    },
    "sigmatau.simulation.imperfections.Temperature": {
        st.OptionError: (
            lambda: Temperature(start=-300.0, end=20.0),
            lambda: Temperature(start=20.0, end=20.0, time=0.0),
            lambda: Temperature(start=20.0, end=20.0, resolution=-1.0),
        )
    },
    "sigmatau.simulation.imperfections.Outage": {
        st.OptionError: (lambda: Outage(start=-1.0, length=1.0), lambda: Outage(start=0.0, length=0.0))
    },
    "sigmatau.store.naming.Naming.check": {
        st.OptionError: (
            lambda: Naming(unit="A1", unit_from="folder").check(),
            lambda: Naming(unit=" ").check(),
            lambda: Naming(date="yesterday").check(),
            lambda: Naming(unit_from="SN").check(),
        )
    },
    "sigmatau.store.naming.Naming.entry": {
        st.DataError: (
            lambda: Naming().entry(analysis(), Path("result.json")),
            lambda: Naming(unit="A1").entry(replace(analysis(), notes={"date": "yesterday"}), Path("result.json")),
            lambda: Naming(unit="A1").entry(replace(analysis(), notes={"temperature": "warm"}), Path("result.json")),
        )
    },
    "sigmatau.fitting.read_off.Coefficient.to": {
        st.OptionError: (lambda: st.read_off(curve(), random_walk=(1.0, 10.0))["random_walk"].to("deg/h"),)
    },
    "sigmatau.fitting.fitted_values.FittedTerm.to": {
        ValueError: (lambda: analysis()["gyro_x"]["rate_random_walk"].to("deg/h/sqrt(h)"),),
        st.OptionError: (lambda: analysis()["gyro_x"]["random_walk"].to("deg/h"),),
    },
}


def _long_with_holes():
    y = np.zeros(1_000_000)
    y[::1000] = NAN
    return arrays(gyro_x=y)


def errors_of(documented):
    return {error for entry in Sections(documented.__doc__).entries("Raises") for error in entry.names}


def test_every_error_that_is_told_is_provoked():
    documented = {**public(), **{name: function_of(member) for name, (_, member) in public_functions().items()}}
    for name in PROVOKED.keys() - documented.keys():  # of a module that pages may import from
        module, _, function = name.rpartition(".")
        documented[name] = getattr(importlib.import_module(module), function)
    told = {name: errors for name, one in documented.items() if (errors := errors_of(one))}
    assert {name: {error.__name__ for error in cases} for name, cases in PROVOKED.items()} == told


@pytest.mark.parametrize(
    ("error", "call"),
    [
        pytest.param(error, call, id=f"{name}-{error.__name__}-{k}")
        for name, cases in PROVOKED.items()
        for error, calls in cases.items()
        for k, call in enumerate(calls)
    ],
)
def test_error(error, call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error):
        call()
