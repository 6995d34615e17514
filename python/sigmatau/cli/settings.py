"""Options of an analysis, for the commands that run one."""

from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, typed_options
from sigmatau.io.read.options import ReadOptions
from sigmatau.lab.lots.options import CompareOptions
from sigmatau.quality.options import InspectOptions


@typed_options(AnalysisOptions)
class AnalysisSettings(DeclaredOptions):
    """Options of an analysis."""


@typed_options(AnalysisOptions, without=("threads",))
class FleetSettings(DeclaredOptions):
    """Options of the analyses of a fleet, whose workers have one thread each."""


@typed_options(AnalysisOptions, only=("taus", "threads"))
class DeviationSettings(DeclaredOptions):
    """Options of an analysis that apply to deviations other than Allan's."""


@typed_options(AnalysisOptions, only=("at_rest",))
class WatchSettings(DeclaredOptions):
    """Options of an analysis that apply to live samples."""


@typed_options(InspectOptions)
class InspectSettings(DeclaredOptions):
    """Options of reading, and of the checks that an analysis runs before the fit."""


@typed_options(ReadOptions, only=("rate", "unit", "channels", "input", "scale", "offset", "skip", "interleaved"))
class WatchReading(DeclaredOptions):
    """Options of reading live lines of text."""


@typed_options(CompareOptions)
class Comparing(DeclaredOptions):
    """Options of a comparison of runs."""


@typed_options(CompareOptions, only=("level",))
class LevelSettings(DeclaredOptions):
    """The confidence level of a trend, as in a comparison."""
