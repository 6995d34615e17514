from ._version import __version__
from .analysis import Analysis, analyze
from .errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from .estimators.accumulator import Accumulator
from .estimators.allan import Curves, DeviationCurve, allan
from .estimators.curve_table import read_curves
from .estimators.deviation import Deviation, Deviations, deviation
from .estimators.figure import read_figure
from .estimators.noise_identification import NoiseIdentification, NoiseIdentifications, identify_noise
from .estimators.stability import dynamic_allan
from .exporting.choices import Choices
from .exporting.export import export
from .exporting.tuning.filters import BiasFilter, FilterMatrices
from .exporting.tuning.innovations import Innovations
from .exporting.tuning.result import Tuning, Tunings
from .exporting.tuning.tune import tune
from .findings.finding import Finding
from .fitting.bandwidth import bandwidth
from .fitting.channel import fit_channel
from .fitting.curve_slope import CurveSlope, fit_slope
from .fitting.fit import fit
from .fitting.joint import fit_jointly
from .fitting.joint_fit import JointChannel, JointFit
from .fitting.noise_fit import NoiseFit
from .fitting.planning import Plan, plan
from .fitting.psd_fit import PsdFit, fit_psd
from .fitting.read_off import ReadOff, read_off
from .fitting.sensor_bandwidth import Bandwidths, SensorBandwidth
from .io.read import read
from .io.read.frame import from_frame
from .io.write import write
from .lab.arrays.analyze import analyze_array
from .lab.arrays.result import ArrayAnalysis
from .lab.datasheets.compare import compare_with
from .lab.datasheets.sheet import Datasheet, datasheet, list_datasheets
from .lab.datasheets.verdict import Verdict
from .lab.lots.comparison import RunComparison, compare_runs
from .lab.lots.lot import judge_lot
from .lab.lots.lot_result import Lot
from .lab.lots.repeatability import RandomEffects, random_effects
from .lab.lots.turn_on import measure_turn_on
from .lab.pages.certify import certify
from .lab.pages.lot_report import lot_report
from .lab.pages.temperature_report import temperature_report
from .lab.store.store import Store
from .lab.temperature.calibrate import calibrate_temperature
from .lab.temperature.matrix import TemperatureMatrix, temperature_matrix
from .lab.temperature.over_runs import TemperatureRun, calibrate_over_runs
from .lab.temperature.result import TemperatureCalibration
from .model.channel import ChannelModel
from .model.matern import Matern
from .model.noise_model import NoiseModel
from .model.processes import GaussMarkov, LowPass, Resonance, Sinusoid
from .model.psd_avar import AvarFromPsd, avar_from_psd
from .model.turn_on import TurnOn
from .navigation.predict import predict
from .noise.shown import show_in
from .plot.overlay import plot_overlay
from .quality.check import check
from .quality.inspection import inspect
from .record.record import Record
from .record.streams import Stream
from .reporting.report import report
from .simulation.imperfections import Imperfections
from .simulation.in_memory import simulate
from .simulation.to_file import simulate_to
from .spectrum.cross import CrossSpectrum, cross_spectrum
from .spectrum.estimate import psd
from .spectrum.result import Spectrum
from .spectrum.transfer import transfer
from .statespace.arma import arma
from .statespace.state_space import state_space
from .statespace.verify import verify

__all__ = [
    "Accumulator",
    "Analysis",
    "ArrayAnalysis",
    "AvarFromPsd",
    "Bandwidths",
    "BiasFilter",
    "ChannelModel",
    "Choices",
    "CrossSpectrum",
    "CurveSlope",
    "Curves",
    "DataError",
    "Datasheet",
    "Deviation",
    "DeviationCurve",
    "Deviations",
    "FilterMatrices",
    "Finding",
    "GaussMarkov",
    "Imperfections",
    "Innovations",
    "JointChannel",
    "JointFit",
    "Lot",
    "LowPass",
    "Matern",
    "NoiseFit",
    "NoiseIdentification",
    "NoiseIdentifications",
    "NoiseModel",
    "NonFiniteError",
    "OptionError",
    "Plan",
    "PsdFit",
    "RandomEffects",
    "ReadOff",
    "Record",
    "RecordTooShortError",
    "Resonance",
    "RunComparison",
    "SensorBandwidth",
    "Sinusoid",
    "Spectrum",
    "Store",
    "Stream",
    "TemperatureCalibration",
    "TemperatureMatrix",
    "TemperatureRun",
    "Tuning",
    "Tunings",
    "TurnOn",
    "Verdict",
    "__version__",
    "allan",
    "analyze",
    "analyze_array",
    "arma",
    "avar_from_psd",
    "bandwidth",
    "calibrate_over_runs",
    "calibrate_temperature",
    "certify",
    "check",
    "compare_runs",
    "compare_with",
    "cross_spectrum",
    "datasheet",
    "deviation",
    "dynamic_allan",
    "export",
    "fit",
    "fit_channel",
    "fit_jointly",
    "fit_psd",
    "fit_slope",
    "from_frame",
    "identify_noise",
    "inspect",
    "judge_lot",
    "list_datasheets",
    "lot_report",
    "measure_turn_on",
    "plan",
    "plot_overlay",
    "predict",
    "psd",
    "random_effects",
    "read",
    "read_curves",
    "read_figure",
    "read_off",
    "report",
    "show_in",
    "simulate",
    "simulate_to",
    "state_space",
    "temperature_matrix",
    "temperature_report",
    "transfer",
    "tune",
    "verify",
    "write",
]
