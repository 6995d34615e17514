"""Options of an analysis, for the commands that make one."""

from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, typed_options


@typed_options(AnalysisOptions)
class Settings(DeclaredOptions):
    """Options of an analysis."""


@typed_options(AnalysisOptions, without=("threads",))
class FleetSettings(DeclaredOptions):
    """Options of the analyses of a fleet, whose workers have one thread each."""


@typed_options(AnalysisOptions, only=("bandwidth", "leave_out", "keep"))
class CheckSettings(DeclaredOptions):
    """Options of the checks that an analysis makes before the fit."""
