"""Words of findings about records that are summed in stretches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stretches import InStretches, PairsAcrossGaps
from sigmatau.findings.wording.phrases import Words
from sigmatau.results import duration_text


def _in_stretches(finding: Finding, it: InStretches) -> Words:
    return Words(
        f"{it.samples} samples were summed in {it.stretches} stretches; rest and disturbances were not checked",
        "Check a part: sigmatau analyze LOG --window 0s:3600s",
    )


def _pairs_across_gaps(finding: Finding, it: PairsAcrossGaps) -> Words:
    used = f"fitted to {duration_text(it.fitted)}" if it.fitted else "not fitted"
    return Words(
        f"{it.missing} of {it.samples} samples missing, pairs across gaps left out;"
        f" curve to {duration_text(it.longest)}, {used}",
        "Copy or record the file again for longer averaging times",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    InStretches: _in_stretches,
    PairsAcrossGaps: _pairs_across_gaps,
}
