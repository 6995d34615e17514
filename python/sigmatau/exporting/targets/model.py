"""sigmatau's own model file, from a result or from another program's file."""

from __future__ import annotations

from sigmatau.exporting.axes import refuse
from sigmatau.exporting.target import Target
from sigmatau.exporting.values import Numbers

__all__ = ["TARGET"]


def write(numbers: Numbers) -> str:
    """The text of the file; raises `OptionError` for choices that are a filter's, because a model is what was found."""
    why = "a model file holds what was found: no factor, and nothing in the place of what was not observed"
    refuse(numbers, "model", why, "walk", "noise", "walk_factor", "noise_factor")
    return numbers.model.to_toml()


TARGET = Target(
    name="model",
    summary="sigmatau's own model file (TOML), for simulate, plan and export: every term as it is, in SI, by channel",
    ending=".toml",
    write=write,
    per_axis=True,
)
