"""Allan variance and noise models of inertial sensors.

>>> import sigmatau as st
>>> record = st.read("static.csv", unit={"gyro": "deg/s", "accel": "g"})  # doctest: +SKIP
>>> st.analyze(record)  # doctest: +SKIP

Importing the package loads NumPy and nothing heavier; matplotlib is imported when something is drawn.
"""

from sigmatau._version import __version__
from sigmatau.allan import Curves, DeviationCurve, allan
from sigmatau.analysis import Analysis, analyze
from sigmatau.deviations import Deviation, Deviations, deviation
from sigmatau.errors import DataError, NonFiniteError, OptionError, RecordTooShortError
from sigmatau.fitting import NoiseFit, fit
from sigmatau.io import read
from sigmatau.model import NoiseModel, simulate
from sigmatau.planning import detectable
from sigmatau.readoff import ReadOff, read_off
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.streams import Stream
from sigmatau.uncertainty import percentage_error

__all__ = [
    "Analysis",
    "Curves",
    "DataError",
    "Deviation",
    "DeviationCurve",
    "Deviations",
    "Finding",
    "NoiseFit",
    "NoiseModel",
    "NonFiniteError",
    "OptionError",
    "ReadOff",
    "Record",
    "RecordTooShortError",
    "Stream",
    "__version__",
    "allan",
    "analyze",
    "detectable",
    "deviation",
    "fit",
    "percentage_error",
    "read",
    "read_off",
    "simulate",
]
