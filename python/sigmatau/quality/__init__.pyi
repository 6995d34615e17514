from .clocks import Mark, collect_marks, compare_clocks
from .selection.rest import reason_without_fits

__all__ = ["Mark", "collect_marks", "compare_clocks", "reason_without_fits"]
