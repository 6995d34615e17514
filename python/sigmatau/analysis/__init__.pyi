from .json import failed_result
from .pipeline import analyze, of_curves
from .result import Analysis

__all__ = ["Analysis", "analyze", "failed_result", "of_curves"]
