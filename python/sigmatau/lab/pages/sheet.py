"""Templates of pages that typst typesets, and texts that fit into them."""

from __future__ import annotations

from functools import cache
from importlib import resources

from sigmatau.results import printable


@cache
def sheet(name: str) -> bytes:
    """The template of a page: fonts, margins and tables of all pages, and its own parts."""
    assets = resources.files(__package__).joinpath("assets")
    return b"\n".join(assets.joinpath(part).read_bytes() for part in ("sheet.typ", name))


def cut_text(text: str, longest: int) -> str:
    """A text of at most this number of characters, with its end."""
    text = printable(text)
    return text if len(text) <= longest else f"{text[: longest - longest // 3 - 1]}…{text[-(longest // 3) :]}"
