"""Calls that raise the documented errors of models, simulation and exports."""

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np

import sigmatau as st
from provoking import (
    EXPORT,
    MODEL,
    NAN,
    ONE,
    QUANTIZED,
    SIMULATE,
    SLOW_RESONANCE,
    STATE_SPACE,
    WHITE,
    arrays,
    curve,
    holes,
    imperfect,
    planned,
    predicted,
    record,
    simulated_to,
    spectrum,
    text,
    without,
)
from sigmatau.noise import terms
from sigmatau.simulation.imperfections import Outage, Temperature, WarmUp
from sigmatau.units import to_si


def pdf_figure():
    """Read a figure of a PDF file."""
    Path("f.pdf").write_bytes(b"%PDF-1.4")
    return st.read_figure("f.pdf", unit="deg/h")


def innovations(n=200, **changed):
    """White innovations with their variance."""
    arrays_ = {"time": np.arange(float(n)), "innovation": np.sin(np.arange(n) ** 2), "variance": np.ones(n)} | changed
    return st.Innovations(**arrays_)


PROVOKED = {
    "NoiseModel.from_result": {
        st.DataError: (lambda: st.NoiseModel.from_result(st.analyze(record(), method="read-off")),)
    },
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
    "Matern": {
        st.DataError: (
            lambda: st.Matern(sigma=-1.0, time=1.0, smoothness=0.3),
            lambda: st.Matern(sigma=1.0, time=1.0, smoothness=0.6),
        )
    },
    "NoiseModel.expand_matern": {st.OptionError: (lambda: MODEL.expand_matern(rate=0.0),)},
    "ChannelModel.expand_matern": {st.OptionError: (lambda: ONE.expand_matern(rate=0.0),)},
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
    "NoiseModel.with_turn_on": {
        st.DataError: (lambda: MODEL.with_turn_on({"gyro_q": st.TurnOn(sigma=1e-4)}),),
    },
    "TurnOn": {
        st.DataError: (
            lambda: st.TurnOn(sigma=0.0),
            lambda: st.TurnOn(sigma=1.0, low=0.5, high=2.0),
            lambda: st.TurnOn(sigma=3.0, low=0.5, high=2.0, power_ups=3),
            lambda: st.TurnOn(sigma=1.0, low=0.5, high=2.0, power_ups=1),
            lambda: st.TurnOn(sigma=1.0, low=0.5, high=2.0, power_ups=2, level=1.0),
        )
    },
    "NoiseModel.write": {st.DataError: (lambda: MODEL.write("missing/model.toml"),)},
    "Resonance": {
        st.DataError: (
            lambda: st.Resonance(sigma=0.0, frequency=1.0, width=0.1),
            lambda: st.Resonance(sigma=1.0, frequency=1.0, width=1.0),
        )
    },
    "Sinusoid": {st.DataError: (lambda: st.Sinusoid(amplitude=0.0, frequency=1.0),)},
    "arma": {
        st.OptionError: (lambda: st.arma(MODEL, dt=0.1), lambda: st.arma(ONE, dt=0.0)),
        st.DataError: (
            lambda: st.arma(st.ChannelModel(sinusoid=(st.Sinusoid(amplitude=1.0, frequency=1.0),)), dt=0.1),
            lambda: st.arma(st.ChannelModel(terms={"rate_ramp": 1e-6}), dt=0.1),
        ),
    },
    "export": EXPORT,
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
    "Innovations": {
        st.DataError: (lambda: innovations(variance=np.zeros(200)), lambda: innovations(time=np.zeros(200))),
        st.RecordTooShortError: (lambda: innovations(n=99),),
    },
    "BiasFilter": {
        st.OptionError: (lambda: st.BiasFilter(noise=0.0, walk=1.0), lambda: st.BiasFilter(noise=1.0, walk=NAN))
    },
    "BiasFilter.matrices": {
        st.OptionError: (
            lambda: st.BiasFilter(noise=1.0, walk=1.0).matrices(interval=1.0, stated=1.0),
            lambda: st.BiasFilter(noise=1.0, walk=1.0, deviation=1.0).matrices(interval=1.0, stated=1.0),
        )
    },
    "FilterMatrices": {
        st.OptionError: (
            lambda: st.FilterMatrices(F=[[1.0, 0.0]], H=[1.0], Q={"q": [[1.0]]}, R=1.0),
            lambda: st.FilterMatrices(F=[[1.0]], H=[1.0], Q={"q": [[1.0]]}, R=0.0),
        )
    },
    "FilterMatrices.covariance": {
        st.OptionError: (lambda: st.FilterMatrices(F=[[1.0]], H=[1.0], Q={"q": [[1.0]]}).covariance,)
    },
    "FilterMatrices.matrices": {
        st.OptionError: (
            lambda: st.FilterMatrices(F=[[1.0]], H=[1.0], Q={"q": [[1.0]]}, R=1.0).matrices(interval=1.0, stated=100.0),
        )
    },
    "tune": {
        st.OptionError: (
            lambda: st.tune(1.0),
            lambda: st.tune(innovations(), filters="mine"),
            lambda: st.tune(innovations(), skip=-1.0),
            lambda: st.tune(innovations(), level=95),
        ),
        st.DataError: (
            lambda: st.tune(
                innovations(variance=np.arange(201.0, 1.0, -1.0)), filters=st.BiasFilter(noise=0.1, walk=0.01)
            ),
        ),
        st.RecordTooShortError: (lambda: st.tune(innovations(), skip=150.0),),
    },
    "Tunings.plot": {st.OptionError: (lambda: st.tune(innovations()).plot("gyro_q"),)},
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
    "simulate": {st.OptionError: SIMULATE},
    "simulate_to": {
        st.OptionError: (lambda: simulated_to(rate=0.0), lambda: simulated_to("log.doc")),
        st.DataError: (
            lambda: simulated_to("missing/log.csv"),
            lambda: without("pyarrow", lambda: simulated_to("log.parquet")),
        ),
    },
    "state_space": {st.OptionError: (*STATE_SPACE, lambda: st.state_space(ONE, dt=0.1, output="angles"))},
    "avar_from_psd": {
        st.DataError: (
            lambda: st.avar_from_psd([2.0, 1.0], [1.0, 1.0], sided="two"),
            lambda: st.avar_from_psd([1.0, 2.0], [1.0, -1.0], sided="two"),
            lambda: st.avar_from_psd([1.0, 2.0], [1.0, NAN], sided="two"),
            lambda: st.avar_from_psd((0, 1), lambda f: f**-3.0, 10.0, sided="two"),
        ),
        st.OptionError: (
            lambda: st.avar_from_psd([1.0, 2.0], [1.0, 1.0], 1e6, sided="two"),
            lambda: st.avar_from_psd([1.0, 2.0], [1.0, 1.0], sided="two", slope_below=-3.0),
        ),
    },
    "read_curves": {
        st.DataError: (lambda: st.read_curves("absent.csv", rate=1, duration=100),),
        st.OptionError: (lambda: st.read_curves("absent.csv", rate=0, duration=100),),
    },
    "read_figure": {
        st.DataError: (lambda: st.read_figure("absent.svg", unit="deg/h"),),
        st.OptionError: (
            lambda: st.read_figure("absent.svg", unit="deg/h", rate=0),
            lambda: st.read_figure("absent.svg", unit="deg/sqrt(h)"),
        ),
        ImportError: (lambda: without("pypdfium2", pdf_figure),),
    },
    "CurveSlope.interval": {
        st.OptionError: (lambda: st.fit_slope(curve(), tau_min=0.1, tau_max=10).interval(level=1.5),)
    },
    "fit_psd": {
        st.DataError: (
            lambda: st.fit_psd([1.0, 2.0], [1.0, 1.0], dof=10, sided="two"),
            lambda: st.fit_psd([2.0, 1.0], [1.0, 1.0], dof=10, sided="two"),
        ),
        st.OptionError: (
            lambda: st.fit_psd(np.arange(1.0, 20.0), np.ones(19), dof=0, sided="two"),
            lambda: st.fit_psd(np.arange(1.0, 20.0), np.ones(19), dof=2, sided="both"),
            lambda: st.fit_psd(np.arange(1.0, 20.0), np.ones(19), dof=2, sided="two", tau0=-1.0),
        ),
        TypeError: (lambda: st.fit_psd(np.arange(1.0, 20.0), np.ones(19), dof=2, sided="two", unit=None),),
    },
    "fit_slope": {
        TypeError: (lambda: st.fit_slope("curve", tau_min=1, tau_max=2),),
        st.OptionError: (
            lambda: st.fit_slope(curve(), tau_min=2, tau_max=1),
            lambda: st.fit_slope(curve(), tau_min=1e9, tau_max=2e9),
        ),
    },
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
}
