from .entry import STAGE_NAMES, analyze, analyze_in_stages, of_curves
from .failed import FailedAnalysis
from .forms import BriefResultForm, CoefficientsForm
from .json import stated_options
from .options import AnalysisOptions, parse_options
from .reading import as_analysis, as_result, read_result, result_of_dict
from .result import Analysis

__all__ = [
    "STAGE_NAMES",
    "Analysis",
    "AnalysisOptions",
    "BriefResultForm",
    "CoefficientsForm",
    "FailedAnalysis",
    "analyze",
    "analyze_in_stages",
    "as_analysis",
    "as_result",
    "of_curves",
    "parse_options",
    "read_result",
    "result_of_dict",
    "stated_options",
]
