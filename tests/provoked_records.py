"""Calls that raise the documented errors of records, curves, spectra and reading."""

from dataclasses import replace

import numpy as np

import sigmatau as st
from provoking import (
    INF,
    LEVELS,
    NAN,
    ONE,
    PSD,
    WHITE,
    _long_with_holes,
    arrays,
    cross,
    curve,
    holes,
    inspected,
    log,
    pushed,
    record,
    rows,
    spectrum,
    text,
)
from sigmatau.noise.uncertainty import avar_covariance, chi2_factors, degrees_of_freedom, percentage_error

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
    "CrossSpectrum.significance": {st.OptionError: (lambda: cross().significance(**LEVELS),)},
    "CrossSpectrum.coherence_interval": {st.OptionError: (lambda: cross().coherence_interval(**LEVELS),)},
    "CrossSpectrum.gain_interval": {st.OptionError: (lambda: cross().gain_interval(**LEVELS),)},
    "CrossSpectrum.phase_interval": {st.OptionError: (lambda: cross().phase_interval(**LEVELS),)},
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
    "check": {
        st.OptionError: (
            lambda: st.check(record(), bandwidth={"gyro": -1.0}),
            lambda: st.check(record(), bandwidth={"baro": 1.0}),
            lambda: st.check(record(), looked_at=10),
        )
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
    "identify_noise": {
        TypeError: (lambda: st.identify_noise([1.0, 2.0]),),
        st.NonFiniteError: (lambda: st.identify_noise(holes()),),
        st.RecordTooShortError: (lambda: st.identify_noise(record(n=3)),),
        st.OptionError: (lambda: st.identify_noise(record(), taus=[150.0]),),
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
    "bandwidth": {
        st.OptionError: (
            lambda: st.bandwidth([]),
            lambda: st.bandwidth(record(), tolerance=0),
            lambda: st.bandwidth(record(), level=95),
            lambda: st.bandwidth(record(), channels=["gyro_q"]),
        ),
        st.DataError: (lambda: st.bandwidth(arrays(gyro_x=np.zeros(2000))),),
        st.RecordTooShortError: (lambda: st.bandwidth(record(n=100)),),
        TypeError: (lambda: st.bandwidth([np.zeros(10)]),),
    },
    "Bandwidths.plot": {st.OptionError: (lambda: st.bandwidth(record()).plot("gyro_q"),)},
    "psd": {
        st.OptionError: PSD,
        st.RecordTooShortError: (lambda: st.psd(record(n=50)),),
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
}
