from .block_temperature import mean_temperatures
from .fitted_noise import QUANTIFIED
from .fitted_values import FittedTerm
from .mean_stability import AVERAGES, MeanStability
from .to_model import to_models

__all__ = [
    "AVERAGES",
    "QUANTIFIED",
    "FittedTerm",
    "MeanStability",
    "mean_temperatures",
    "to_models",
]
