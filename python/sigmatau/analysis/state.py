"""`State`: data of an analysis after a stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING

from sigmatau.analysis.options import AnalysisOptions
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.findings.finding import Finding
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.read_off import ReadOff
from sigmatau.frozen import frozen
from sigmatau.quality.check import Examination
from sigmatau.quality.means import ChannelMean
from sigmatau.quality.selection.rest import Rest
from sigmatau.record.mask import Exclusion
from sigmatau.record.record import Record

if TYPE_CHECKING:
    from sigmatau.estimators.stability import DynamicAllan


@frozen(eq=False)
class State:
    """Data of an analysis after a stage.

    Attributes
    ----------
    options : AnalysisOptions
    record : Record
        Samples for the next stage.
    whole : Record
        Record before the first stage.
    findings : tuple of Finding
        Names of the finished stages, in order.
    excluded : tuple of Exclusion
        Samples that the stages removed, in order.
    rest : Rest or None
        Verdict on the record; None before `check`.
    examined : Examination or None
        The record without its disturbances, for `mask`; None if it was not searched, or is in motion.
    bounded : frozenset of str
        Streams that are analysed in bounded memory.
    curves, fitted_on : mapping of str to DeviationCurve
        Curves by channel; those in `fitted_on` are fitted in place of the others.
    models : mapping of str to NoiseFit
        Fits that only contain the ranges of the lines if ``method="read-off"``.
    fits, read_off, means, mean_stability, stability : mapping
        Values by channel, see `Analysis`.
    """

    options: AnalysisOptions
    record: Record
    whole: Record
    findings: tuple[Finding, ...] = ()
    excluded: tuple[Exclusion, ...] = ()
    rest: Rest | None = None
    examined: Examination | None = None
    bounded: frozenset[str] = frozenset()
    curves: Mapping[str, DeviationCurve] = field(default_factory=dict)
    fitted_on: Mapping[str, DeviationCurve] = field(default_factory=dict)
    fits: Mapping[str, NoiseFit] = field(default_factory=dict)
    models: Mapping[str, NoiseFit] = field(default_factory=dict)
    read_off: Mapping[str, ReadOff] = field(default_factory=dict)
    means: Mapping[str, ChannelMean] = field(default_factory=dict)
    mean_stability: Mapping[str, tuple[MeanStability, ...]] = field(default_factory=dict)
    stability: Mapping[str, DynamicAllan] = field(default_factory=dict)

    @property
    def moves(self) -> bool:
        """Whether the record has no coefficients, because it moves or is too short to tell."""
        return self.rest is not None and not self.rest.is_usable and not self.options.at_rest
