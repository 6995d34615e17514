"""Names of the code are those of docs/decisions/vocabulary.md: refused words, and one meaning for each class name.

What the package still has of both is counted room by room. The numbers may only shrink.
"""

import ast
import functools
import inspect
import re
from collections import Counter, defaultdict

import public_names
from conftest import ROOT
from package_trees import MODULES, PACKAGE, nodes, tree

PAGE = ROOT / "docs" / "decisions" / "vocabulary.md"
REFUSED = frozenset(
    [
        "one",
        "ones",
        "other",
        "others",
        "found",
        "told",
        "said",
        "own",
        "there",
        "at",
        "of",
        "known",
        "given",
        "kept",
        "left",
        "seen",
        "beside",
        "around",
        "near",
        "far",
        "few",
        "most",
        "least",
        "more",
        "much",
        "thing",
        "things",
    ]
)
STANDING = {"read_off_at", "leave_out", "at_most", "at_rest", "of_curves"}  # names that users have, wherever they stand
JSON_KEYS = {"of_white", "own"}  # of `sigmatau.analysis.forms`
OPERATORS = frozenset({"__eq__", "__ne__", "__lt__", "__le__", "__gt__", "__ge__", "__add__", "__or__", "__and__"})

# Names that the package still has, by room. Lower a number when names are mended; never raise one.
LEFT_BY_ROOM = {
    "(top)": 3,
    "_native": 3,
    "findings": 4,
    "lab": 4,
    "quality": 4,
}
LEFT_IN_RUST = 381
SHARED_CLASS_NAMES = 0


def is_refused(name):
    """Whether a name is one of the refused words, ends in one, or begins with "of"."""
    words = name.strip("_").lower().split("_")
    return words[-1] in REFUSED or words[0] == "of"


def room_of(path):
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else "(top)"


def trees():
    return {path: tree(name) for name, path in MODULES.items()}


@functools.cache
def standing():
    """Names that users have, by the class or function that has them: attributes, methods and arguments."""
    names = {}
    for public in public_names.public().values():
        if isinstance(public, type):
            has = {*public_names.members(public), *public_names.public_fields(public)}
            functions = [public_names.function_of(member) for _, member in public_names.members(public).values()]
        else:
            has, functions = {public.__name__}, [public]
        has.update(
            name for function in functions if function is not None for name in inspect.signature(function).parameters
        )
        names[public.__name__] = names.get(public.__name__, frozenset()) | has
    return names


def defined(node, stands=frozenset()):
    """Names that a syntax tree defines, with their lines, without those that stand."""
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        stands = standing().get(node.name, frozenset()) | stands
        stands |= {"other"} if node.name in OPERATORS else JSON_KEYS if node.name.endswith("Form") else set()
    if isinstance(node, ast.ClassDef) and any(
        each.arg == "code" for each in node.keywords
    ):  # details of a finding: keys of JSON
        stands |= {part.target.id for part in node.body if isinstance(part, ast.AnnAssign)}
    names = []
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        names.append(node.name)
    elif isinstance(node, ast.arg):
        names.append(node.arg)
    elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
        names.append(node.id if isinstance(node, ast.Name) else node.attr)
    yield from ((node.lineno, name) for name in names if name not in stands | STANDING)
    inside = frozenset() if isinstance(node, ast.FunctionDef) else stands
    for child in ast.iter_child_nodes(node):
        yield from defined(child, stands if isinstance(child, ast.arguments | ast.arg) else inside)


def test_names_are_nouns():
    """A name says what it holds; "found" and "other" say it of nothing."""
    refused = defaultdict(list)
    for path, code in trees().items():
        refused[room_of(path)] += [
            f"{path.relative_to(ROOT)}:{line}: {name}" for line, name in defined(code) if is_refused(name)
        ]
    too_many = {room: names for room, names in refused.items() if len(names) > LEFT_BY_ROOM.get(room, 0)}
    listed = "\n".join(name for names in too_many.values() for name in names)
    counts = {room: len(names) for room, names in refused.items()}
    assert not too_many, f"{counts}; see {PAGE.relative_to(ROOT)}\n{listed}"


def test_names_in_rust():
    declared = re.compile(r"\b(?:let(?: mut)?|fn|struct|enum|const) +([A-Za-z_0-9]+)")
    sources = [path for path in (ROOT / "crates").rglob("*.rs") if "tests" not in path.parts]
    refused = [name for path in sources for name in declared.findall(path.read_text()) if is_refused(name)]
    assert len(refused) <= LEFT_IN_RUST, Counter(refused).most_common(20)


def test_a_class_name_has_one_meaning():
    classes = defaultdict(set)
    for path, code in trees().items():
        for node in nodes(code):
            if isinstance(node, ast.ClassDef):
                classes[node.name].add(str(path.relative_to(PACKAGE)))
    shared = {name: sorted(paths) for name, paths in classes.items() if len(paths) > 1}
    assert len(shared) <= SHARED_CLASS_NAMES, shared


def test_the_page_lists_every_refused_word():
    refused = PAGE.read_text(encoding="utf-8").partition("## Refused names")[2]
    assert not [word for word in sorted(REFUSED) if f"`{word}`" not in refused]


def test_an_alias_is_defined_once():
    alias = re.compile(r"^(?:Floats|Ints|Bools|STANDARD_GRAVITY) = ", flags=re.MULTILINE)
    defined = [path for path in trees() if room_of(path) != "lab" and alias.search(path.read_text(encoding="utf-8"))]
    assert {path.name for path in defined} == {"arrays.py", "units.py"}
