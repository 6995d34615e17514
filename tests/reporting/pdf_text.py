"""The text of a PDF written by typst with ``pretty``, page by page; only the required part of the format."""

import re

_OBJECT = re.compile(rb"^(\d+) 0 obj\n(.*?)^endobj", re.S | re.M)
_INNER = rb"(?:\\.|[^\\()])*"  # content of a string; balanced parentheses are not escaped
_STRING = rb"\((%b(?:\(%b(?:\(%b\)%b)*\)%b)*)\)" % ((_INNER,) * 5)
_SHOWN = re.compile(
    rb"/(f\d+) [\d.]+ Tf|" + _STRING + rb"|/ActualText <FEFF([0-9A-F]*)>|<([0-9A-F]+)>|^(ET)$|^(EMC)$", re.S | re.M
)
_ESCAPES = {b"n": b"\n", b"r": b"\r", b"t": b"\t", b"b": b"\b", b"f": b"\f"}


def pages_of(pdf: bytes) -> list[str]:
    """The text of each page, with runs of one style on separate lines."""
    objects = {int(number): body for number, body in _OBJECT.findall(pdf)}
    kids = re.search(rb"/Type /Pages.*?/Kids \[(.*?)\]", pdf, re.S).group(1)
    return [_page(objects, objects[int(number)]) for number in re.findall(rb"(\d+) 0 R", kids)]


def _page(objects, page):
    keys = (b"Resources", b"Contents")
    resources, contents = (objects[int(re.search(rb"/%b (\d+) 0 R" % key, page).group(1))] for key in keys)
    fonts = re.search(rb"/Font <<(.*?)>>", resources, re.S).group(1)
    numbers = dict(re.findall(rb"/(f\d+) (\d+) 0 R", fonts))
    encodings = {name: _characters(objects, objects[int(number)]) for name, number in numbers.items()}
    text, font, is_replaced = "", {}, False
    for name, literal, actual, digits, ended, closed in _SHOWN.findall(contents):
        if name:
            font = encodings[name]
        elif actual:
            text, is_replaced = text + bytes.fromhex(actual.decode()).decode("utf-16-be"), True
        elif closed:
            is_replaced = False
        elif ended:
            text += "\n"
        elif not is_replaced:
            codes = (
                bytes.fromhex(digits.decode()) if digits else re.sub(rb"\\(\d{3}|.)", _unescaped, literal, flags=re.S)
            )
            text += "".join(font.get(codes[k : k + 2], "") for k in range(0, len(codes), 2))
    return text


def _unescaped(match):
    code = match.group(1)
    return bytes([int(code, 8)]) if len(code) == 3 else _ESCAPES.get(code, code)


def _characters(objects, font):
    """Text by code of a font."""
    table = objects[int(re.search(rb"/ToUnicode (\d+) 0 R", font).group(1))]
    pairs = re.findall(rb"^<([0-9A-F]{4})> <([0-9A-F]+)>$", table, re.M)
    return {bytes.fromhex(code.decode()): bytes.fromhex(text.decode()).decode("utf-16-be") for code, text in pairs}
