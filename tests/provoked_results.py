"""Calls that raise the documented errors of fits, results, datasheets, lots and stores."""

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np

import sigmatau as st
from known import seed_of
from provoking import (
    MODEL,
    NAN,
    analysis,
    arrays,
    compared,
    curve,
    fitted,
    holes,
    jointly,
    lot,
    open_sheet,
    record,
    sheet,
    store,
    text,
    without,
)
from sigmatau.lab.store.naming import Naming
from sigmatau.lab.store.rows import Entry


def ramp():
    """A log of a gyro from 0 to 50 °C."""
    rates = np.random.default_rng(seed_of("provoked ramp")).normal(size=7200)
    return st.Record.from_arrays(rate=2, gyro_x=1e-4 * rates, temperature=np.linspace(0, 50, 7200))


def curve_not_kept():
    """A curve whose points a store did not keep."""
    none, integers = np.zeros(0), np.zeros(0, dtype=int)
    return replace(curve(), m=integers, tau=none, avar=none, n_pairs=integers, ramp=none, edf=None, stride=None)


@functools.cache
def calibrated():
    """Its calibration."""
    return st.calibrate_temperature(ramp(), degree=1)


def gyro_samples(number=0, n=5000):
    """White noise of a gyro of an array."""
    return 1e-3 * np.random.default_rng(number).standard_normal(n)


def gyros(count, *, n=5000, rate=10.0):
    """An array of gyros."""
    return st.Record.from_arrays(rate=rate, **{f"gyro_{k}": gyro_samples(k, n) for k in range(count)})


def without_virtual():
    """An analysis of an array that has no virtual sensor."""
    return replace(st.analyze_array(gyros(3)), virtual=None, no_weights="the record is too short")


PROVOKED = {
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
    "NoiseFit.to_model": {st.DataError: (lambda: replace(analysis()["gyro_x"], verdict="too_short").to_model(),)},
    "Analysis.export": {
        st.OptionError: (lambda: analysis().export(to="nothing"),),
        st.DataError: (lambda: analysis().export(to="kalibr"),),
    },
    "Tabular.to_dataframe": {ImportError: (lambda: without("pandas", curve().to_dataframe),)},
    "Tabular.to_xarray": {ImportError: (lambda: without("xarray", curve().to_xarray),)},
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
    "Lot.plot": {KeyError: (lambda: lot().plot("accel_x"),)},
    "RunComparison.plot": {st.OptionError: (lambda: compared().plot("accel_x"),)},
    "Store": {
        st.OptionError: (lambda: st.Store("mysql://host/name"),),
        st.DataError: (lambda: st.Store(text("lab.db", "no store")), lambda: st.Store("missing.db", create=False)),
        ImportError: (lambda: without("sqlalchemy", lambda: st.Store("lab.db")),),
    },
    "Store.add": {
        st.DataError: (
            lambda: store().add(Entry(result=analysis(), unit=" ")),
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
    "Store.content": {st.DataError: (lambda: store().content(1),)},
    "Store.latest": {
        st.DataError: (
            lambda: store().latest("A1"),
            lambda: store(analysis(), unit="A1").latest("A1", run="day 2"),
        )
    },
    "Verdict.fails": {
        st.OptionError: (lambda: st.compare_with(MODEL, "icm42688p", sided="one", bias="minimum").fails("perhaps"),)
    },
    "analyze": {
        st.DataError: (
            lambda: st.analyze(arrays(gyro_x=np.zeros(1000))),
            lambda: st.analyze(holes(), long="strided"),
        ),
        st.OptionError: (lambda: st.analyze(record(), method="eye"), lambda: st.analyze(record(), terms=["drift"])),
    },
    "compare_runs": {
        st.DataError: (lambda: st.compare_runs(["missing.json"]),),
        st.OptionError: (
            lambda: st.compare_runs([analysis()], names=["a", "b"]),
            lambda: st.compare_runs([analysis()], by="day"),
            lambda: st.compare_runs([analysis()], level=2.0),
        ),
    },
    "measure_turn_on": {
        st.DataError: (lambda: st.measure_turn_on(st.compare_runs([analysis()])),),
        st.OptionError: (
            lambda: st.measure_turn_on(st.compare_runs([analysis()], by="axis")),
            lambda: st.measure_turn_on(st.compare_runs([analysis()]), unit="B7"),
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
    "datasheet": {
        st.OptionError: (lambda: st.datasheet("no sensor"),),
        st.DataError: (lambda: st.datasheet("missing.toml"),),
    },
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
    "sigmatau.fitting.fitted_matern.FittedMatern.to_process": {
        st.DataError: (lambda: fitted(processes="matern").matern.to_process(),)
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
    "analyze_array": {
        st.OptionError: (
            lambda: st.analyze_array(gyros(3), axes=["gyro_q"]),
            lambda: st.analyze_array(gyros(3), axes=["gyro_0"]),
            lambda: st.analyze_array(gyros(2), common=True),
            lambda: st.analyze_array(gyros(3), target="drift"),
            lambda: st.analyze_array(gyros(3), target=-1.0),
            lambda: st.analyze_array(gyros(3), target=1e9),
            lambda: st.analyze_array(gyros(3), invert=["gyro_q"]),
            lambda: st.analyze_array(gyros(3), level=95),
        ),
        st.DataError: (
            lambda: st.analyze_array([gyros(1), gyros(1, rate=20.0)]),
            lambda: st.analyze_array(gyros(2, n=100)),
            lambda: st.analyze_array(arrays(gyro_0=np.zeros(5000), gyro_1=gyro_samples())),
            lambda: st.analyze_array(arrays(gyro_0=gyro_samples(), gyro_1=gyro_samples())),
        ),
    },
    "ArrayAnalysis.fused_record": {st.DataError: (lambda: without_virtual().fused_record,)},
    "ArrayAnalysis.write_fused": {
        st.DataError: (
            lambda: without_virtual().write_fused("fused.csv"),
            lambda: st.analyze_array(gyros(3)).write_fused("missing/fused.csv"),
        )
    },
    "judge_lot": {
        st.OptionError: (
            lambda: st.judge_lot([]),
            lambda: st.judge_lot([analysis()], level=0.1),
            lambda: st.judge_lot([analysis()], undecided="perhaps"),
        ),
        st.DataError: (lambda: st.judge_lot([analysis()], "missing.toml"),),
    },
    "certify": {st.DataError: (lambda: st.certify(analysis(), "missing.toml"),)},
    "lot_report": {
        st.OptionError: (lambda: st.lot_report(lot(), "lot.doc"),),
        st.DataError: (lambda: st.lot_report(lot(), "missing/lot.json"),),
        ImportError: (lambda: without("typst", lambda: st.lot_report(lot(), "lot.pdf")),),
    },
    "calibrate_temperature": {
        st.DataError: (lambda: st.calibrate_temperature(record()),),
        st.OptionError: (lambda: st.calibrate_temperature(ramp(), degree=9),),
    },
    "calibrate_over_runs": {
        st.DataError: (lambda: st.calibrate_over_runs([]),),
        st.OptionError: (lambda: st.calibrate_over_runs([], degree=9), lambda: st.calibrate_over_runs([], level=2)),
    },
    "temperature_matrix": {st.DataError: (lambda: st.temperature_matrix([]),)},
    "temperature_report": {
        st.OptionError: (lambda: st.temperature_report(calibrated(), "page.doc"),),
        st.DataError: (lambda: st.temperature_report(calibrated(), "missing/page.html"),),
        ImportError: (lambda: without("typst", lambda: st.temperature_report(calibrated(), "page.pdf")),),
    },
    "TemperatureCalibration.export": {
        st.OptionError: (lambda: calibrated().export(to="kalibr"),),
        st.DataError: (lambda: calibrated().export(to="px4"),),
    },
    "sigmatau.lab.temperature.polynomial.BiasPolynomial.values": {
        st.OptionError: (lambda: calibrated()["gyro_x"].polynomial.values(200.0),),
    },
    "show_in": {
        st.OptionError: (lambda: st.show_in("furlongs").__enter__(), lambda: st.show_in("deg/h:one-sided").__enter__())
    },
    "plot_overlay": {
        st.OptionError: (
            lambda: st.plot_overlay({}),
            lambda: st.plot_overlay({"a": {"x": curve()}, "b": {"x": replace(curve(), unit="m/s^2")}}),
            lambda: st.plot_overlay({"a": {"x": curve()}}, ax=[]),
        ),
        st.DataError: (lambda: st.plot_overlay({"a": {"x": curve_not_kept()}}),),
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
    "sigmatau.lab.store.naming.Naming.check": {
        st.OptionError: (
            lambda: Naming(unit="A1", unit_from="folder").check(),
            lambda: Naming(unit=" ").check(),
            lambda: Naming(date="yesterday").check(),
            lambda: Naming(unit_from="SN").check(),
        )
    },
    "sigmatau.lab.store.naming.Naming.entry": {
        st.DataError: (
            lambda: Naming().entry(analysis(), Path("result.json")),
            lambda: Naming(unit="A1").entry(replace(analysis(), notes={"date": "yesterday"}), Path("result.json")),
            lambda: Naming(unit="A1").entry(replace(analysis(), notes={"temperature": "warm"}), Path("result.json")),
        )
    },
    "sigmatau.fitting.read_off.ReadOffCoefficient.to": {
        st.OptionError: (lambda: st.read_off(curve(), random_walk=(1.0, 10.0))["random_walk"].to("deg/h"),)
    },
    "sigmatau.fitting.fitted_values.FittedTerm.to": {
        ValueError: (lambda: analysis()["gyro_x"]["rate_random_walk"].to("deg/h/sqrt(h)"),),
        st.OptionError: (lambda: analysis()["gyro_x"]["random_walk"].to("deg/h"),),
    },
}
