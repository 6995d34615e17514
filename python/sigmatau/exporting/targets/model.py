"""The model file of sigmatau, from a result or a file of another program."""

from __future__ import annotations

from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.values import Numbers


def write(numbers: Numbers) -> str:
    """The text of the file."""
    return numbers.model.to_toml()


TARGET = Target(
    name="model",
    summary="model file of sigmatau (TOML), for simulate, plan and export: every term of every channel, in SI",
    ending=".toml",
    write=write,
    sensors="any",
    per_axis=True,
    unused=(
        Unused(
            choices=("walk", "noise", "walk_factor", "noise_factor"),
            why="a model file has what was found, without factors and replacements",
        ),
    ),
)
