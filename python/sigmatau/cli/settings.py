"""Options of an analysis, for the commands that make one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from sigmatau.cli.options import averaging_times, bandwidths
from sigmatau.cli.ranges import read_off_ranges
from sigmatau.quality.selection.time_text import seconds_of


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Settings:
    """Options of an analysis.

    Parameters
    ----------
    method
        Fit the coefficients to the spectrum (likelihood) or to the Allan variances (gls), or only read them off the curve,
        as in the paper (read-off).
    taus
        Averaging times: octave, half, quarter, eighth (of an octave), all, or a list in seconds or with units, 0.1,1,10min.
    overlap
        Average overlapping clusters (full), or disjoint clusters only (none).
    counting
        Number of terms for N rates: N+1-2n (standard), or N-2n as in the paper's eq. (6) (paper).
    terms
        Noise terms that may be present: random_walk,bias_instability. Default: all five. A term that is left out is
        assumed to be absent; if it is present, the others are wrong.
    tau_min
        Shortest averaging time of the fit in seconds or with a unit, 500ms, e.g. beyond a filter or a line. Needs --method
        gls. Default: by goodness of fit.
    read_off_at
        Averaging times between which a line is read off: random_walk=1s:10s for all channels, gyro_x.random_walk=1s:10s for
        one, gyro.random_walk=… for a sensor (ms, s, min, h, d); may be repeated. Default: by rules.
    long
        Pairs of clusters longer than 4096 samples: all pairs (exact), or at most every 64th pair, in bounded memory
        (strided). auto is strided if the record does not fit in memory, and exact otherwise; a finding reports strided.
    window
        Part of the record to analyse: 600s:7800s from its beginning (ms, s, min, h, d), or most-stable=2h.
        Default: all.
    leave_out
        Times to treat as missing, 720s:722s,1080s:1083s from the beginning of the log. Default: none.
    keep
        Disturbances to keep in the analysis: dropouts, saturation, stuck, interpolated, copies, start, shocks, spikes (with
        commas between), or all. Default: none; they are treated as missing.
    at_rest
        Analyse motion, such as that of a turntable or a shaker, as noise. Default: a log that is partly at rest is cut to
        its longest part at rest, and one that is not at rest or too short to tell gets no coefficients (exit code 5).
    bandwidth
        Bandwidth of the sensor from its datasheet: gyro=30Hz, or gyro=30Hz/2 for a second-order filter. A finding then
        reports the random walk that aliasing adds. Default: unknown.
    """

    method: Literal["likelihood", "gls", "read-off"] = "likelihood"
    taus: str = "half"
    overlap: Literal["full", "none"] = "full"
    counting: Literal["standard", "paper"] = "standard"
    terms: str | None = None
    tau_min: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    read_off_at: Annotated[list[str] | None, Parameter(negative=())] = None
    long: Literal["auto", "exact", "strided"] = "auto"
    window: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    leave_out: Annotated[list[str] | None, Parameter(negative=(), allow_leading_hyphen=True)] = None
    keep: Annotated[list[str] | None, Parameter(negative=())] = None
    at_rest: Annotated[bool, Parameter(negative=())] = False
    bandwidth: Annotated[list[str] | None, Parameter(negative=())] = None

    def arguments(self) -> dict[str, Any]:
        """Arguments of `sigmatau.analyze`."""
        return {
            "taus": averaging_times(self.taus),
            "overlap": self.overlap,
            "counting": self.counting,
            "method": self.method,
            "terms": None if self.terms is None else [name.strip() for name in self.terms.split(",")],
            "tau_min": None if self.tau_min is None else seconds_of(self.tau_min, option="tau_min"),
            "read_off_at": read_off_ranges(self.read_off_at or []),
            "long": self.long,
            "window": self.window,
            "leave_out": self.leave_out or None,
            "keep": self.keep or (),
            "at_rest": self.at_rest,
            "bandwidth": bandwidths(self.bandwidth or []),
        }
