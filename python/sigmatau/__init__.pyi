"""What the package offers, for type checkers: the names that `__init__.py` imports when they are used."""

from sigmatau._version import __version__
from sigmatau.accumulate import Accumulator
from sigmatau.allan import Curves, DeviationCurve, allan
from sigmatau.analysis import Analysis, analyze
from sigmatau.datasheet import Datasheet, Verdict, compare_with, datasheet, datasheets
from sigmatau.deviations import Deviation, Deviations, deviation
from sigmatau.diagnose import check
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.fitting import NoiseFit, fit
from sigmatau.inspection import inspect
from sigmatau.io import from_frame, read
from sigmatau.model import (
    ChannelModel,
    GaussMarkov,
    Imperfections,
    LowPass,
    NoiseModel,
    Sinusoid,
    arma,
    avar_from_psd,
    predict,
    simulate,
    simulate_to,
    state_space,
)
from sigmatau.planning import detectable
from sigmatau.readoff import ReadOff, read_off
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.spectrum import CrossSpectrum, Spectrum, cross_spectrum, psd, transfer
from sigmatau.stability import dynamic_allan
from sigmatau.streams import Stream
from sigmatau.uncertainty import percentage_error

__all__ = [
    "Accumulator",
    "Analysis",
    "ChannelModel",
    "CrossSpectrum",
    "Curves",
    "DataError",
    "Datasheet",
    "Deviation",
    "DeviationCurve",
    "Deviations",
    "Finding",
    "GaussMarkov",
    "Imperfections",
    "LowPass",
    "NoiseFit",
    "NoiseModel",
    "NonFiniteError",
    "OptionError",
    "ReadOff",
    "Record",
    "RecordTooShortError",
    "Sinusoid",
    "Spectrum",
    "Stream",
    "Verdict",
    "__version__",
    "allan",
    "analyze",
    "arma",
    "avar_from_psd",
    "check",
    "compare_with",
    "cross_spectrum",
    "datasheet",
    "datasheets",
    "detectable",
    "deviation",
    "dynamic_allan",
    "fit",
    "from_frame",
    "inspect",
    "percentage_error",
    "predict",
    "psd",
    "read",
    "read_off",
    "simulate",
    "simulate_to",
    "state_space",
    "transfer",
]
