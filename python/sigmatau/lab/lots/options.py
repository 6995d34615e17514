"""The options of a comparison of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import Literal, get_args

from sigmatau.frozen import frozen
from sigmatau.options import check_choices, option, with_attributes

By = Literal["unit", "run", "axis"]


@with_attributes
@frozen
class CompareOptions:
    """Options of `sigmatau.compare_runs`."""

    names: Sequence[str] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Names of the runs, one for each result.",
            'Default: the note "run", or the name of the file.',
            kind="sequence of str, optional",
        ),
    )
    units: Sequence[str] | None = field(
        default=None,
        metadata=option(
            "Input",
            "Names of the units, one for each result.",
            'Default: the note "serial number" or "unit", or the folder if there are several.',
            kind="sequence of str, optional",
        ),
    )
    by: By = field(
        default="unit",
        metadata=option(
            "Method",
            "Compare the runs of each unit (unit), the units of each run (run), or all results of an axis (axis).",
            choices=get_args(By),
        ),
    )
    level: float = field(
        default=0.95,
        metadata=option("Method", "Confidence level of tests and intervals.", form="number", kind="float"),
    )
    jobs: int | None = field(
        default=None,
        metadata=option(
            "Input",
            "Number of processes that read many files.",
            "Default: all cores.",
            form="count",
            kind="int, optional",
            matters=False,
        ),
    )

    def __post_init__(self) -> None:
        check_choices(self)
        from sigmatau.lab.lots.repeatability import check_level

        check_level(self.level)
