from .file import NOT_ADEQUATE, ONLY_LIMITS, value_in_si
from .minimum import min_adev, processes_avar
from .processes import LARGEST, SMALLEST

__all__ = [
    "LARGEST",
    "NOT_ADEQUATE",
    "ONLY_LIMITS",
    "SMALLEST",
    "min_adev",
    "processes_avar",
    "value_in_si",
]
