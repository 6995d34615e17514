"""What makers state of a sensor's noise, and whether a sensor keeps to it."""

from sigmatau.datasheet.claims import Claim
from sigmatau.datasheet.judging import Fitted, compare_with
from sigmatau.datasheet.measured import Measured
from sigmatau.datasheet.sheet import Datasheet, Library, datasheet, datasheets
from sigmatau.datasheet.verdict import Comparison, Judged, Reading, Verdict

__all__ = [
    "Claim",
    "Comparison",
    "Datasheet",
    "Fitted",
    "Judged",
    "Library",
    "Measured",
    "Reading",
    "Verdict",
    "compare_with",
    "datasheet",
    "datasheets",
]
