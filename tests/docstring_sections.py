"""Sections of a docstring in the form of numpydoc, and the required description of a number or an array."""

import inspect
import re
from typing import NamedTuple


class Entry(NamedTuple):
    """An entry of a section: ``names : type`` and the indented text below."""

    names: tuple[str, ...]
    type: str
    text: str


class Sections:
    """A docstring, cut at its underlined headings."""

    def __init__(self, doc):
        lines = inspect.cleandoc(doc or "").splitlines()
        heads = [k for k, line in enumerate(lines) if k and line and set(line) == {"-"} and len(line) >= 3]
        ends = [*(k - 1 for k in heads), len(lines)]
        self.text = "\n".join(lines)
        self.opening = "\n".join(lines[: ends[0]]).strip()
        self.summary = self.opening.split("\n\n")[0]
        self.by_name = {lines[k - 1]: lines[k + 1 : end] for k, end in zip(heads, ends[1:], strict=True)}
        self.underlined = all(len(lines[k]) == len(lines[k - 1]) for k in heads)

    def __contains__(self, section):
        return any(line.strip() for line in self.by_name.get(section, ()))

    def entries(self, section):
        """The entries of a section, in order."""
        parsed = []
        for line in self.by_name.get(section, ()):
            if line and not line.startswith(" "):
                names, _, kind = line.partition(" : ")
                parsed.append(Entry(tuple(part.strip().lstrip("*") for part in names.split(",")), kind.strip(), ""))
            elif parsed and line.strip():
                parsed[-1] = parsed[-1]._replace(text=f"{parsed[-1].text} {line.strip()}".strip())
        return parsed

    def described(self, section):
        """The names of a section, each with its entry."""
        return {name: entry for entry in self.entries(section) for name in entry.names}


UNIT = re.compile(r"\[[^\[\]\n]*[A-Za-z0-9°µ][^\[\]\n]*\](?!_)")  # [s], [(rad/s)²/Hz], [1]; but no reference [1]_
# Words that describe numbers without a unit.
BARE = re.compile(
    r"(?i)\b(probability|p-values?|ratios?|relative|shares?|factors?|confidence level|correlations?\b.*1|coherence|in SI"
    r"|degrees of freedom|numbers? of|per octave|logarithm)\b"
)


def wanting(annotation, kind, text):
    """Missing parts of a description of a value: the shape of an array, the unit of a number."""
    lacks = []
    annotation = re.sub(r"Callable\[\[.*?\], .*?\]", "", annotation)
    is_array = re.search(r"ArrayLike|NDArray|\bFloats\b|\bInts\b|\bComplexes\b", annotation)
    if is_array and "shape" not in f"{kind} {text}":
        lacks.append("shape")
    whole = r"NDArray\[np\.(int64|bool_)\]|\bInts\b|(ndarray|array_like) of (int|bool)"
    is_number = re.search(r"\bfloat\b", annotation) or (is_array and not re.search(whole, f"{annotation} {kind}"))
    if is_number and not UNIT.search(f"{kind} {text}") and not BARE.search(f"{kind} {text}"):
        lacks.append("unit")
    return lacks
