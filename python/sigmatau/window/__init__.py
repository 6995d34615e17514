"""The part of a record that is analysed, and what it does to the result to choose it by its own calm.

`parts` reads and cuts (``600s:7800s``, ``most-stable=2h``), `left_out` takes stretches for missing (``720s:722s``),
`selection` computes the bias of a choice.
"""

from sigmatau.window.left_out import from_the_start, leave_out
from sigmatau.window.parts import choose, criterion, cut, most_stable
from sigmatau.window.selection import SelectionBias, bias_finding, selection_bias

__all__ = [
    "SelectionBias",
    "bias_finding",
    "choose",
    "criterion",
    "cut",
    "from_the_start",
    "leave_out",
    "most_stable",
    "selection_bias",
]
