"""HTML built from elements whose text is always escaped, so that text from a file can be read but not executed."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


_EXPONENT = re.compile(r"(?<=[a-zA-Z)])\^(\{[^}]{1,5}\}|[-−]?\d(?:\.\d+)?)")
_VOID = ("meta", "link", "br", "hr", "img", "input")


def element(name: str, /, *children: str | Iterable[str], **attributes: str | bool) -> Markup:
    """An element. Text among its children is escaped; of the names of attributes, ``class_`` is ``class``, ``data_x`` is
    ``data-x``. An attribute that is False is absent.

    Examples
    --------
    >>> element("td", "<script>", class_="value")
    '<td class="value">&lt;script&gt;</td>'
    """
    written = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{html.escape(str(value))}"')
        for key, value in attributes.items()
        if value is not False
    )
    if name in _VOID:
        return Markup(f"<{name}{written}>")
    return Markup(f"<{name}{written}>{joined(*children)}</{name}>")


def joined(*children: str | Iterable[str]) -> Markup:
    """Children one after the other, text among them escaped."""
    parts = (part for child in children for part in ([child] if isinstance(child, str) else child))
    return Markup("".join(part if isinstance(part, Markup) else html.escape(part) for part in parts))


def raised(text: str) -> Markup:
    """Text with the exponents of its units raised: ``m/s/h^{3/2}``, ``m/s^2``."""
    parts = _EXPONENT.split(text)
    return joined(element("sup", part.strip("{}")) if k % 2 else part for k, part in enumerate(parts))


def prose(text: str) -> Markup:
    """Mark text between backticks as code."""
    return joined(element("code", part) if k % 2 else part for k, part in enumerate(text.split("`")))


def name(text: str) -> Markup:
    """Isolate a name from a file, so that it does not change the text direction around it."""
    return element("bdi", text)


def css_string(text: str) -> str:
    r"""A text as a string of a style sheet, which no character in it can end.

    Examples
    --------
    >>> css_string('95 % "')
    '"95 \\25  \\22 "'
    """
    plain = (c if c.isalnum() or c in " .-_" else f"\\{ord(c):x} " for c in text)
    return f'"{"".join(plain)}"'


def data(content: object, *, id_: str) -> Markup:
    r"""Plain values for scripts of the page, which no text in them can end.

    Examples
    --------
    >>> data({"name": "</script>"}, id_="content")
    '<script type="application/json" id="content">{"name":"\\u003c/script\\u003e"}</script>'
    """
    text = json.dumps(content, allow_nan=False, separators=(",", ":"), ensure_ascii=True)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(f'<script type="application/json" id="{html.escape(id_)}">{text}</script>')


def script(source: str) -> Markup:
    """A script of ours."""
    if "</script" in source.lower():
        raise ValueError("a script must not contain </script")
    return Markup(f"<script>{source}</script>")


def style(source: str) -> Markup:
    """A style sheet of ours."""
    if "</style" in source.lower():
        raise ValueError("a style sheet must not contain </style")
    return Markup(f"<style>{source}</style>")
