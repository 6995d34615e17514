"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import BrokenOff, Damaged, Place

EXAMPLES = [
    Finding(
        details=Damaged(
            what="variable wx", place=Place("byte", 128), reason="2000 numbers for the shape (1073741824, 1)"
        ),
        severity="error",
    ),
    Finding(
        details=BrokenOff(what="variable acc", place=Place("byte", 72340), got=8124, expected=48000), severity="error"
    ),
]
