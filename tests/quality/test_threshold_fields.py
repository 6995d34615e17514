"""A threshold is a constant of its check; the comment above it has its meaning, its unit, and where its value comes from."""

import ast
import itertools
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "sigmatau"
MODULES = [*sorted((PACKAGE / "quality").rglob("*.py")), PACKAGE / "fitting" / "disturbance.py"]

DOCUMENTED = re.compile(
    r"\S.* \[[^\]]+\] (Study: docs/study/[\w-]+\.md|(Derived|Measured|Datasheets|Literature|Standard|Judgement): \S)",
    re.S,
)
"""A sentence about the limit, its unit in brackets, the kind of its source, and the source."""

CONSTANTS = {
    "counts.py": {"_ROUNDING": "exact variance of rounding", "_NOISE": "grid of a search"},
    "units.py": {"DEGREE": "definition", "_EARTH_RATE": "physical constant", "AXES": "axes of space"},
    "sensor_class.py": {"_DEGREE": "definition"},
    "tremor.py": {"_AXES": "axes of space"},
    "octave_means.py": {"NORMAL_MEDIAN": "quantile of the normal distribution"},
    "spike_scale.py": {"NORMAL_QUARTILE": "quantile of the normal distribution"},
    "dense_spikes.py": {"_GOLDEN": "a sequence that fills a step evenly"},
    "spikes.py": {"_MIDDLE": "coefficient of a fourth difference", "_BATCH": "memory"},
    "common.py": {"_SHORT_ROW": "speed of NumPy"},
    "copied_stretches.py": {"_CHUNK": "memory", "_MIX": "hashing", "_TURN": "hashing", "_HIGH": "hashing"},
    "quality/check.py": {
        "_PARTS": "length of a tuple",
        "LOOKED_AT": "memory, an argument of `check`",
        "LOOKED_AT_BOUNDED": "memory",
    },
    "inspection.py": {"FITTED": "time"},
    "exclusion.py": {"_LISTED": "length of a text"},
    "quality/samples/disturbances.py": {"_ROUNDING": "rounding of a time"},
    "time_text.py": {"_UNITS": "definition"},
}
"""Numbers of a module that limit nothing that is measured, and why."""


def is_numeric(node):
    """Whether an expression is made of numbers alone, and has one that is written out."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, int | float) and not isinstance(node.value, bool)
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Attribute | ast.Name) and any(map(is_numeric, node.args))
    if isinstance(node, ast.Dict):
        return any(map(is_numeric, node.values))
    if isinstance(node, ast.Tuple | ast.List):
        return any(map(is_numeric, node.elts)) and all(map(is_numeric, node.elts))
    if isinstance(node, ast.BinOp):
        return is_numeric(node.left) or is_numeric(node.right)
    return isinstance(node, ast.UnaryOp) and is_numeric(node.operand)


def numbers_of(tree):
    """Upper-case names of a module that stand for numbers, with the line where they are defined."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and is_numeric(node.value):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for name in target.elts if isinstance(target, ast.Tuple) else [target]:
                    if isinstance(name, ast.Name) and name.id.isupper():
                        yield name.id, node.lineno


def undocumented(source):
    """Names of numbers without a comment above them that says what they limit, their unit and their source."""
    lines = source.splitlines()
    for name, line in numbers_of(ast.parse(source)):
        above = itertools.takewhile(lambda text: text.startswith("# "), reversed(lines[: line - 1]))
        if not DOCUMENTED.match(" ".join(text[2:] for text in reversed([*above]))):
            yield name


SOURCES = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in MODULES}


def test_the_rules_find_what_breaks_them():
    source = (
        "# Limit of A. [s] Judgement: enough.\nA = 3\n_B, _C = 1.0, -2\n"
        "# Limit of D. Judgement: no unit.\nD: float = 2 * math.pi\n# Limit of E. [s]\nE = {'x': 1}\n"
        "# Limit of F.\n# [rad] Derived: a right angle.\nF = math.radians(90)\ng = 3\nH = 'text'\n"
    )
    assert [name for name, _ in numbers_of(ast.parse(source))] == ["A", "_B", "_C", "D", "E", "F"]
    assert list(undocumented(source)) == ["_B", "_C", "D", "E"]


@pytest.mark.parametrize("name", SOURCES)
def test_each_threshold_has_a_unit_and_a_source(name):
    source = SOURCES[name]
    assert sorted(undocumented(source)) == sorted(CONSTANTS.get(name, CONSTANTS.get(Path(name).name, {})))
    for study in re.findall(r"docs/study/[\w-]+\.md", source):
        assert (ROOT / study).exists()


def test_each_threshold_is_used():
    uses = Counter(re.findall(r"\w+", "\n".join(SOURCES.values())))
    for source in SOURCES.values():
        assert [constant for constant, _ in numbers_of(ast.parse(source)) if uses[constant] < 2] == []
