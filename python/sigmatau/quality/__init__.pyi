from .clocks import Mark, compare_clocks, marks_of
from .selection.rest import reason_without_fits

__all__ = ["Mark", "compare_clocks", "marks_of", "reason_without_fits"]
