from .entry import analyze, of_curves
from .failed import FailedAnalysis
from .result import Analysis

__all__ = ["Analysis", "FailedAnalysis", "analyze", "of_curves"]
