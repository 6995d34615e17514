"""Examples of findings for `test_words`."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.stretches import InStretches, PairsAcrossGaps

EXAMPLES = [
    Finding(details=InStretches(stretches=30, samples=10**9), severity="warning"),
    Finding(
        details=PairsAcrossGaps(missing=10**6, samples=10**9, longest=250000.0, fitted=8000.0),
        severity="warning",
        channels=("gyro_x",),
    ),
    Finding(
        details=PairsAcrossGaps(missing=9 * 10**8, samples=10**9, longest=10.0, fitted=0.0),
        severity="warning",
        channels=("gyro_x",),
    ),
]
