"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.live import LinesLost

EXAMPLES = [
    Finding(details=LinesLost(lines=1, last="x,y,z"), severity="warning"),
    Finding(details=LinesLost(lines=1600, last="9x9,7777.5,3,1,0.0012,0.0034,17"), severity="warning"),
]
