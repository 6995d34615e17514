"""Allan variance and noise models of inertial sensors.

>>> import sigmatau as st
>>> record = st.read("static.csv", unit={"gyro": "deg/s", "accel": "g"})  # doctest: +SKIP
>>> st.analyze(record)  # doctest: +SKIP

Importing the package loads nothing else: each name is imported when it is first used, with NumPy and no more than it needs;
SciPy when something is fitted, matplotlib when something is drawn. A new name goes into `__init__.pyi` too.
"""

import sys
from importlib import import_module
from types import ModuleType

from sigmatau._version import __version__

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

_HOMES = {
    "Accumulator": "sigmatau.accumulate",
    "Analysis": "sigmatau.analysis",
    "ChannelModel": "sigmatau.model",
    "CrossSpectrum": "sigmatau.spectrum",
    "Curves": "sigmatau.allan",
    "DataError": "sigmatau.errors",
    "Datasheet": "sigmatau.datasheet",
    "Deviation": "sigmatau.deviations",
    "DeviationCurve": "sigmatau.allan",
    "Deviations": "sigmatau.deviations",
    "Finding": "sigmatau.results",
    "GaussMarkov": "sigmatau.model",
    "LowPass": "sigmatau.model",
    "Imperfections": "sigmatau.model",
    "NoiseFit": "sigmatau.fitting",
    "NoiseModel": "sigmatau.model",
    "NonFiniteError": "sigmatau.errors",
    "OptionError": "sigmatau.errors",
    "ReadOff": "sigmatau.readoff",
    "Record": "sigmatau.record",
    "RecordTooShortError": "sigmatau.errors",
    "Sinusoid": "sigmatau.model",
    "Spectrum": "sigmatau.spectrum",
    "Stream": "sigmatau.streams",
    "Verdict": "sigmatau.datasheet",
    "allan": "sigmatau.allan",
    "analyze": "sigmatau.analysis",
    "arma": "sigmatau.model",
    "avar_from_psd": "sigmatau.model",
    "check": "sigmatau.diagnose",
    "cross_spectrum": "sigmatau.spectrum",
    "compare_with": "sigmatau.datasheet",
    "datasheet": "sigmatau.datasheet",
    "datasheets": "sigmatau.datasheet",
    "detectable": "sigmatau.planning",
    "deviation": "sigmatau.deviations",
    "dynamic_allan": "sigmatau.stability",
    "fit": "sigmatau.fitting",
    "from_frame": "sigmatau.io",
    "inspect": "sigmatau.inspection",
    "percentage_error": "sigmatau.uncertainty",
    "predict": "sigmatau.model",
    "psd": "sigmatau.spectrum",
    "read": "sigmatau.io",
    "read_off": "sigmatau.readoff",
    "simulate": "sigmatau.model",
    "state_space": "sigmatau.model",
    "transfer": "sigmatau.spectrum",
    "simulate_to": "sigmatau.model",
}


_MODULES = (
    "accumulate",
    "analysis",
    "deviations",
    "diagnose",
    "errors",
    "export",
    "fitting",
    "integrity",
    "io",
    "model",
    "planning",
    "readoff",
    "record",
    "results",
    "spectrum",
    "stability",
    "streams",
    "tables",
    "terms",
    "uncertainty",
    "units",
    "window",
)


def __getattr__(name: str) -> object:
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    elif name in _MODULES:
        value = import_module(f"sigmatau.{name}")
    else:
        raise AttributeError(f"module 'sigmatau' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    # Neither what this file imports nor the modules that others happen to have imported.
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__, *_MODULES})


class _Package(ModuleType):
    """The package, in which `allan` and `datasheet` are functions, not the modules that an import would put there."""

    @property
    def allan(self) -> object:
        return import_module("sigmatau.allan").allan

    @allan.setter
    def allan(self, module: object) -> None:
        pass

    @property
    def datasheet(self) -> object:
        return import_module("sigmatau.datasheet").datasheet

    @datasheet.setter
    def datasheet(self, module: object) -> None:
        pass


sys.modules[__name__].__class__ = _Package
