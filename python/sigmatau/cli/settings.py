"""Options of an analysis."""

from sigmatau.analysis.options import AnalysisOptions
from sigmatau.cli.declared import DeclaredOptions, typed_options


@typed_options(AnalysisOptions)
class AnalysisSettings(DeclaredOptions):
    """Options of an analysis."""
