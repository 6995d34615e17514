"""Options of an analysis: arguments of `analyze`, options of the command line, and keys of a result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.errors import OptionError
from sigmatau.estimators.allan import Counting, Overlap
from sigmatau.estimators.deviation_kinds import TauGrid
from sigmatau.fitting.arguments import wanted_terms
from sigmatau.fitting.read_off_lines import Span
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.noise.terms import TERMS
from sigmatau.options import check_choices, declared, option, with_attributes
from sigmatau.quality.options import CheckOptions

Method = Literal["likelihood", "gls", "read-off"]
Long = Literal["auto", "exact", "strided"]


@with_attributes
@frozen
class AnalysisOptions(CheckOptions):
    """Options of `sigmatau.analyze`."""

    taus: TauGrid | ArrayLike = field(
        default="half",
        metadata=option(
            "Method",
            "Averaging times of the curve: octave, half, quarter, eighth (of an octave), all, or a list.",
            form="times",
            unit="s",
            kind="str or array_like",
            python="See `sigmatau.allan`.",
            typed="The times of a list are in seconds or have units: 0.1,1,10min.",
        ),
    )
    overlap: Overlap = field(
        default="full",
        metadata=option(
            "Method",
            "Average overlapping clusters (full), or disjoint clusters only (none).",
            choices=get_args(Overlap),
        ),
    )
    counting: Counting = field(
        default="standard",
        metadata=option(
            "Method",
            "Number of terms for N rates: N+1-2n (standard), or N-2n as in the paper's eq. (6) (paper).",
            choices=get_args(Counting),
        ),
    )
    method: Method = field(
        default="likelihood",
        metadata=option(
            "Method",
            "Fit the coefficients to the spectrum (likelihood) or to the Allan variances (gls), or read them off the curve,"
            " as in the paper (read-off): each line where the fitted model says that its term dominates.",
            choices=get_args(Method),
            python="The likelihood's model includes the filters, lines and processes that were detected. Coefficients"
            " are always read off the curve too. Channels with very few samples are fitted by least squares, which"
            " always uses overlapping clusters on half octaves, for any grid of the curve.",
        ),
    )
    terms: Sequence[str] | None = field(
        default=None,
        metadata=option(
            "Method",
            "Noise terms that may be present.",
            "Default: all five. A term that is left out is assumed to be absent; if it is present, the others are wrong.",
            form="names",
            kind="sequence of str, optional",
            python="Keys of `sigmatau.noise.terms.TERMS`.",
            typed="Example: random_walk,bias_instability.",
        ),
    )
    tau_min: float | None = field(
        default=None,
        metadata=option(
            "Method",
            "Shortest averaging time of least squares, e.g. beyond a filter or a line.",
            "Default: by goodness of fit.",
            form="seconds",
            unit="s",
            kind="float, optional",
            typed=f"In seconds or with a unit, 500ms. Needs {Hint('method', value='gls')}.",
        ),
    )
    read_off_at: Mapping[str, Span] | None = field(
        default=None,
        metadata=option(
            "Method",
            "Averaging times between which lines are read off, by term, or by channel or sensor and term.",
            "Default: where the term dominates in the fitted model, by rules if there is none. A line is refused where the"
            " curve has another slope; the other lines do not change.",
            form="ranges",
            unit="s",
            kind="mapping of str to tuple of float, optional",
            python='Example: ``{"random_walk": (1, 10), "gyro_x.quantization": (0.01, 2)}``; see `sigmatau.read_off`.',
            typed="Examples: random_walk=1s:10s for all channels, gyro_x.random_walk=1s:10s for one, gyro.random_walk=… for"
            " a sensor (ms, s, min, h, d); may be repeated.",
        ),
    )
    force: bool = field(
        default=False,
        metadata=option(
            "Method",
            f"Draw a line of {Hint('read_off_at')} although the curve has another slope there; it is marked.",
            "Default: such a line is refused, with the slope and its error.",
            form="flag",
            kind="bool",
        ),
    )
    long: Long = field(
        default="auto",
        metadata=option(
            "Method",
            "Pairs of clusters longer than 4096 samples: all pairs (exact), or at most every 64th pair, in bounded memory"
            " (strided). auto is strided if the record does not fit in memory, and exact otherwise; a finding reports"
            " strided.",
            choices=get_args(Long),
            python="See `sigmatau.Accumulator`.",
        ),
    )
    window: str | None = field(
        default=None,
        metadata=option(
            "Selection",
            "Part of the record to analyse: 600s:7800s from its beginning (ms, s, min, h, d), or most-stable=2h.",
            "Default: all.",
            form="span",
            kind="str, optional",
            main=True,
        ),
    )
    at_rest: bool = field(
        default=False,
        metadata=option(
            "Selection",
            "Analyse motion, such as that of a turntable or a shaker, as noise.",
            "Default: a log that is partly at rest is cut to its longest part at rest, and one that is not at rest or too"
            " short to tell gets no coefficients (exit code 5).",
            form="flag",
            kind="bool",
            main=True,
        ),
    )
    stability: bool = field(
        default=False,
        metadata=option(
            "Output",
            "Compute the dynamic Allan deviation of every channel, see `sigmatau.dynamic_allan`.",
            kind="bool",
            matters=False,
        ),
    )
    notes: Mapping[str, str] | None = field(
        default=None,
        metadata=option(
            "Output",
            'Information about the record for the result: ``{"serial number": "A123", "run": "day 1"}``. `compare_runs`'
            " groups results by these notes.",
            kind="mapping of str to str, optional",
            matters=False,
        ),
    )
    threads: int | None = field(
        default=None,
        metadata=option(
            "Output",
            "Number of threads. The result does not depend on it.",
            "Default: all cores.",
            form="count",
            kind="int, optional",
            matters=False,
        ),
    )

    def __post_init__(self) -> None:
        check_choices(self)
        if self.terms is not None:
            if self.method == "read-off":
                raise OptionError(
                    "{option} apply to fitted coefficients; the read-off uses a fit for the ranges of its lines only",
                    option="terms",
                )
            wanted = wanted_terms(self.terms)
            object.__setattr__(self, "terms", [name for name in TERMS if name in wanted])
        if self.tau_min is not None:
            _check_time(self.tau_min, self.method)
        if self.long == "strided" and (self.overlap, self.counting) != ("full", "standard"):
            raise OptionError("{option} 'strided' is for overlapping clusters in the standard counting", option="long")
        CheckOptions.__post_init__(self)


def parse_options(stated: Mapping[str, Any]) -> AnalysisOptions:
    """Parse the options of a result. Raises `OptionError`. Options that this version lacks are ignored."""
    names = declared(AnalysisOptions)
    return AnalysisOptions(**{name: value for name, value in stated.items() if name in names})


def _check_time(tau_min: object, method: Method) -> None:
    """Raise `OptionError` for a shortest averaging time that is not positive, or without least squares."""
    if isinstance(tau_min, bool) or not (isinstance(tau_min, int | float | np.number) and 0 < tau_min < np.inf):
        raise OptionError(f"{{option}} must be a positive number of seconds, not {tau_min!r}", option="tau_min")
    if method != "gls":
        raise OptionError(f"{{option}} needs least squares: {Hint('method', value='gls')}", option="tau_min")
