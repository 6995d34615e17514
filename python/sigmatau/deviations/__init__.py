"""Deviations other than the Allan deviation: modified Allan, Hadamard, total, time, Theo1, MTIE and TIE rms."""

from sigmatau.deviations.deviation import Deviation, Deviations, deviation
from sigmatau.deviations.kinds import KINDS, Kind

__all__ = ["KINDS", "Deviation", "Deviations", "Kind", "deviation"]
