"""Parse the XML of an SVG file. Entities are bounded, and nothing outside the file is read."""

from __future__ import annotations

from dataclasses import field

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.drawing import MAX_BYTES, MAX_DEPTH, MAX_OBJECTS, TOO_COMPLEX

COMMENT = "#comment"
"""Tag of a comment; its text is the only child."""

_MAX_ENTITY = 200  # longest text of an entity; Illustrator writes addresses of namespaces as entities [characters]
_UNREADABLE = "is damaged: {}. Export the figure again"
_ENTITIES = "defines entities that a figure does not need. Export the figure again as plain SVG"


@frozen(eq=False)
class Node:
    """An element: its name and attributes without prefixes of namespaces, its texts and elements."""

    tag: str
    attributes: dict[str, str]
    children: list[Node | str] = field(default_factory=list)

    @property
    def elements(self) -> list[Node]:
        """The children without texts."""
        return [child for child in self.children if isinstance(child, Node)]

    @property
    def text(self) -> str:
        """The texts directly in the element."""
        return "".join(child for child in self.children if isinstance(child, str))


def parse(data: bytes) -> Node:
    """The root of the tree. Raises `DataError` for text that is not XML, for an attack, and for an excessive size."""
    from xml.parsers import expat  # in the call: few users have a figure

    root = Node(tag="", attributes={})
    stack, count, length = [root], 0, 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > MAX_OBJECTS or len(stack) > MAX_DEPTH:
            raise DataError(TOO_COMPLEX)
        local = {key.rpartition(":")[2]: value for key, value in attributes.items()}
        node = Node(tag=name.rpartition(":")[2], attributes=local)
        stack[-1].children.append(node)
        stack.append(node)

    def entity(name: str, is_parameter: int, value: str | None, *external: str | None) -> None:
        if is_parameter or value is None or "&" in value or len(value) > _MAX_ENTITY:
            raise DataError(_ENTITIES)

    def write(text: str) -> None:
        nonlocal length
        length += len(text)
        if length > MAX_BYTES:
            raise DataError(TOO_COMPLEX)
        stack[-1].children.append(text)

    def comment(text: str) -> None:
        stack[-1].children.append(Node(tag=COMMENT, attributes={}, children=[text]))

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler = start
    parser.EndElementHandler = lambda name: stack.pop()
    parser.CharacterDataHandler = write
    parser.CommentHandler = comment
    parser.EntityDeclHandler = entity
    try:
        parser.Parse(data, True)  # noqa: FBT003  it has no name
    except expat.ExpatError as error:
        raise DataError(_UNREADABLE.format(f"{expat.ErrorString(error.code)} in line {error.lineno}")) from None
    except (ValueError, LookupError) as error:  # an encoding that Python does not have
        if isinstance(error, DataError):
            raise
        raise DataError(_UNREADABLE.format("its encoding is unknown")) from None
    (svg,) = [node for node in root.elements if node.tag != COMMENT]
    if svg.tag != "svg":
        raise DataError(f"is XML, but not SVG: its root is {svg.tag[:40]!r}. Give an SVG or PDF file")
    return svg
