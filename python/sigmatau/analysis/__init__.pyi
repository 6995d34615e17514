from .entry import analyze, of_curves
from .json import failed_result
from .result import Analysis

__all__ = ["Analysis", "analyze", "failed_result", "of_curves"]
