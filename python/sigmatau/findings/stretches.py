"""Findings about records that are summed in stretches, by several processes."""

from __future__ import annotations

from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.results import duration_text


@frozen
class InStretches(Details, code="in_stretches"):
    """A record that was too large for one process: its curve is complete, and its samples were not checked.

    Attributes
    ----------
    stretches : int
        Number of stretches.
    samples : int
        Samples of the record.
    """

    stretches: int
    samples: int

    def words(self, finding: Finding) -> Words:
        return Words(
            f"{self.samples} samples were summed in {self.stretches} stretches; rest and disturbances were not checked",
            f"Check a part: {Hint('window', value='0s:3600s')}",
        )


@frozen
class PairsAcrossGaps(Details, code="pairs_across_gaps"):
    """Samples of a record that is summed in stretches are missing: pairs of clusters across a gap are left out.

    Attributes
    ----------
    missing, samples : int
        Samples.
    longest : float
        Longest averaging time of the curve. [s]
    fitted : float
        Longest averaging time of the curve that the fit uses: at least 9 of 10 pairs are complete [s]; 0 without a fit.
    """

    missing: int
    samples: int
    longest: float
    fitted: float

    def words(self, finding: Finding) -> Words:
        used = f"fitted to {duration_text(self.fitted)}" if self.fitted else "not fitted"
        return Words(
            f"{self.missing} of {self.samples} samples missing, pairs across gaps left out;"
            f" curve to {duration_text(self.longest)}, {used}",
            "Copy or record the file again for longer averaging times",
        )
