"""Styles of SVG elements: attributes, style sheets with simple selectors, and inheritance."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from sigmatau.frozen import frozen
from sigmatau.io.read.figure.svg_tree import Node

_INHERITED = ("stroke", "fill", "stroke-width", "color", "visibility", "font-size", "text-anchor")
_OPACITIES = ("opacity", "stroke-opacity", "fill-opacity")
_NAMES = {*_INHERITED, *_OPACITIES, "display", "clip-path", "baseline-shift"}

_UNITS = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0}  # in px
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-z%]*)")
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
_SELECTOR = re.compile(r"(\*|[\w-]*)(?:([.#])([\w-]+))?")
_COLORS = {
    "black": "#000000",
    "white": "#ffffff",
    "red": "#ff0000",
    "green": "#008000",
    "blue": "#0000ff",
    "gray": "#808080",
    "grey": "#808080",
    "orange": "#ffa500",
    "purple": "#800080",
    "magenta": "#ff00ff",
    "cyan": "#00ffff",
    "brown": "#a52a2a",
}

Sheet = dict[str, dict[str, str]]
"""Declarations by selector, such as ``path``, ``.a`` or ``#b``."""


@frozen
class Style:
    """The computed style of an element."""

    stroke: str = "none"
    fill: str = "#000000"
    stroke_width: float = 1.0
    color: str = "#000000"
    is_visible: bool = True
    font_size: float = 16.0
    anchor: str = "start"
    opacity: float = 1.0
    stroke_opacity: float = 1.0
    fill_opacity: float = 1.0

    @property
    def is_stroked(self) -> bool:
        """Whether the line of a path is visible."""
        return self.is_visible and self.stroke != "none" and self.opacity * self.stroke_opacity > 0

    @property
    def is_filled(self) -> bool:
        """Whether the inside of a path is visible."""
        return self.is_visible and self.fill != "none" and self.opacity * self.fill_opacity > 0


def length(text: str, default: float, *, percent: float = 0.0) -> float:
    """A length in px; `percent`: that of 100 %."""
    match = _LENGTH.match(text)
    if match is None:
        return default
    number, unit = float(match[1]), match[2]
    if unit in ("%", "em"):
        return number * percent / (100 if unit == "%" else 1)
    return number * _UNITS.get(unit, 1.0)


def collect_sheet(root: Node) -> Sheet:
    """The declarations of all style elements."""
    sheet: Sheet = {}
    stack = [root]
    while stack:
        node = stack.pop()
        stack += node.elements
        if node.tag == "style":
            text = re.sub(r"/\*.*?\*/", "", node.text, flags=re.DOTALL)
            for selectors, body in _RULE.findall(text):
                for selector in selectors.split(","):
                    if _SELECTOR.fullmatch(selector.strip()):
                        sheet.setdefault(selector.strip(), {}).update(_declarations(body))
    return sheet


def _declarations(text: str) -> dict[str, str]:
    pairs = (part.partition(":") for part in text.split(";"))
    values_by_name = {name.strip(): value.strip().removesuffix("!important").strip() for name, _, value in pairs}
    return {name: value for name, value in values_by_name.items() if name in _NAMES}


def declared(node: Node, sheet: Sheet) -> dict[str, str]:
    """The declarations for an element, the stronger ones over the weaker."""
    result = {name: value.strip() for name, value in node.attributes.items() if name in _NAMES}
    classes = node.attributes.get("class", "").split()
    names = ["*", node.tag, *(f"{tag}.{name}" for tag in ("", node.tag) for name in classes)]
    for selector in [*names, f"#{node.attributes.get('id', '')}"] if sheet else ():
        result |= sheet.get(selector, {})
    return result | _declarations(node.attributes.get("style", ""))


def computed(parent: Style, values: Mapping[str, str]) -> Style:
    """The style of an element within a parent."""
    color = _color(values.get("color", ""), parent.color, parent.color)
    visibility = values.get("visibility")
    anchor = values.get("text-anchor", parent.anchor)
    return replace(
        parent,
        color=color,
        stroke=_color(values.get("stroke", ""), parent.stroke, color),
        fill=_color(values.get("fill", ""), parent.fill, color),
        stroke_width=length(values.get("stroke-width", ""), parent.stroke_width),
        is_visible=parent.is_visible if visibility is None else visibility == "visible",
        font_size=length(values.get("font-size", ""), parent.font_size, percent=parent.font_size),
        anchor=anchor if anchor in ("start", "middle", "end") else parent.anchor,
        opacity=parent.opacity * _opacity(values, "opacity", 1.0),
        stroke_opacity=_opacity(values, "stroke-opacity", parent.stroke_opacity),
        fill_opacity=_opacity(values, "fill-opacity", parent.fill_opacity),
    )


def _opacity(values: Mapping[str, str], name: str, default: float) -> float:
    return length(values.get(name, ""), default, percent=1.0)


def _color(text: str, inherited: str, current: str) -> str:
    """A color as ``#rrggbb``; an unknown word stays as it is."""
    text = text.strip().lower()
    if not text or text == "inherit":
        return inherited
    if text == "currentcolor":
        return current
    if text in ("none", "transparent"):
        return "none"
    if re.fullmatch(r"#[0-9a-f]{3}", text):
        return "#" + "".join(2 * digit for digit in text[1:])
    match = re.fullmatch(r"rgba?\(([^)]*)\)", text)
    if match:
        parts = re.split(r"[\s,/]+", match[1].strip())
        if len(parts) == 4 and length(parts[3], 1.0, percent=1.0) == 0:
            return "none"
        levels = [round(min(max(length(part, 0.0, percent=255.0), 0.0), 255.0)) for part in parts[:3]]
        return "#" + "".join(f"{level:02x}" for level in levels)
    return _COLORS.get(text, text)
