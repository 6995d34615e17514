from .fitted_noise import QUANTIFIED
from .fitted_values import FittedTerm
from .mean_stability import AVERAGES, MeanStability
from .to_model import to_models

__all__ = [
    "AVERAGES",
    "QUANTIFIED",
    "FittedTerm",
    "MeanStability",
    "to_models",
]
