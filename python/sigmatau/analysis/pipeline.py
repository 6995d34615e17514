"""The stages from a record to its `Analysis`: each takes the state and returns the next state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from sigmatau.analysis import stages
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.analysis.result import Analysis
from sigmatau.analysis.state import State
from sigmatau.process import trim
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.record.record import Record
from sigmatau.record.streams import rates_size

STAGES = (stages.choose, stages.check, stages.mask, stages.curves, stages.fit, stages.judge)
"""Stages from the record to the state from which `stages.assemble` makes an `Analysis`."""

# Size of the samples above which memory that the checks freed is returned before the curves. [bytes] Measured: the peak of a
# record of 0.83 GB is 0.15 GB lower; a smaller record is faster with the memory of the checks.
_LARGE = 1 << 28


def run(source: object, options: AnalysisOptions, *, begin: Callable[[str], None] | None = None) -> Analysis:
    """Analyse a record, a path or a data frame. If memory is insufficient, the analysis is repeated in bounded memory.

    `begin` is called with the name of each stage before it starts.
    """
    record = stages.read(source)
    try:
        return _through_stages(record, options, begin)
    except MemoryError:
        if options.long != "auto" or any(stream.mask is not None for stream in record.streams):
            raise
    return _through_stages(record, replace(options, long="strided"), begin)


@keep_facts()
def _through_stages(record: Record, options: AnalysisOptions, begin: Callable[[str], None] | None) -> Analysis:
    record = from_the_start(record)
    state = State(options=options, record=record, whole=record, findings=tuple(record.findings))
    for stage in STAGES:
        if begin is not None:
            begin(stage.__name__)
        state = stage(state)
        if stage is stages.mask and rates_size(record.streams) > _LARGE:
            trim()
    return stages.assemble(state)
