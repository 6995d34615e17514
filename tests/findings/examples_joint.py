"""Examples of findings for `test_words`."""

from typing import get_args

from sigmatau.findings.finding import Finding
from sigmatau.findings.joint import RunDiffers, RunLeftOut, RunsDiffer, Unfit


def differs(term, factor):
    details = RunDiffers(run="day4.csv", runs=7, term=term, factor=factor, p_value=3.2e-5)
    return Finding(details=details, severity="warning", channels=("gyro_x",), size=factor)


EXAMPLES = [
    differs("rate_random_walk", 3.127),
    differs("bias_instability", None),
    differs(None, None),
    Finding(
        details=RunsDiffer(runs=7, term="rate_random_walk", p_value=0.0023), severity="warning", channels=("gyro_x",)
    ),
    *(
        Finding(details=RunLeftOut(run="day2.csv", reason=reason), severity="warning", channels=("gyro_x",))
        for reason in (*get_args(Unfit), "a text of an earlier version")
    ),
]
