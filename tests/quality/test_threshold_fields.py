"""A threshold is a field of the dataclass of its check, with what it limits, its unit, and where its value comes from."""

import ast
import re
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
    "units.py": {"DEGREE": "definition", "_EARTH_RATE": "physical constant", "_AXES": "axes of space"},
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
    "exclusion.py": {"_LISTED": "length of a text", "_TO_ROUNDING": "rounding of a time"},
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
    """Upper-case names of a module, without those of its classes, that stand for numbers."""
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and is_numeric(node.value):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                for name in target.elts if isinstance(target, ast.Tuple) else [target]:
                    if isinstance(name, ast.Name) and name.id.isupper():
                        yield name.id


def undocumented(cls):
    """Fields of a class without a string behind them that says what they limit, their unit and their source."""
    for field, text in zip(cls.body, [*cls.body[1:], None], strict=True):
        if isinstance(field, ast.AnnAssign) and not ast.unparse(field.annotation).endswith("Thresholds"):
            is_text = isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
            words = " ".join(text.value.value.split()) if is_text else ""
            if not DOCUMENTED.match(words):
                yield field.target.id


def threshold_classes(tree):
    return [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name.endswith("Thresholds")]


TREES = {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text(encoding="utf-8")) for path in MODULES}
WITH_THRESHOLDS = [name for name, tree in TREES.items() if threshold_classes(tree)]


def test_the_rules_find_what_breaks_them():
    tree = ast.parse(
        "A = 3\n_B, _C = 1.0, -2\nD: float = 2 * math.pi\nE = {'x': 1}\nF = math.radians(5)\ng = 3\nH = 'text'\n"
        "class XThresholds:\n"
        "    a: float = 1.0\n"
        "    b: float = 1.0\n    '''Limit of b. [s] Judgement: enough.'''\n"
        "    c: float = 1.0\n    '''Limit of c. Judgement: no unit.'''\n"
        "    d: float = 1.0\n    '''Limit of d. [s]'''\n"
    )
    assert list(numbers_of(tree)) == ["A", "_B", "_C", "D", "E", "F"]
    (cls,) = threshold_classes(tree)
    assert list(undocumented(cls)) == ["a", "c", "d"]
    assert len(WITH_THRESHOLDS) > 25


@pytest.mark.parametrize("name", TREES)
def test_no_threshold_is_a_constant_of_a_module(name):
    assert sorted(numbers_of(TREES[name])) == sorted(CONSTANTS.get(name, CONSTANTS.get(Path(name).name, {})))


@pytest.mark.parametrize("name", WITH_THRESHOLDS)
def test_each_threshold_has_a_unit_and_a_source(name):
    for cls in threshold_classes(TREES[name]):
        assert list(undocumented(cls)) == []
        for study in re.findall(r"docs/study/[\w-]+\.md", ast.unparse(cls)):
            assert (ROOT / study).exists()


@pytest.mark.parametrize("name", WITH_THRESHOLDS)
def test_each_threshold_is_used(name):
    used = {node.attr for other in TREES.values() for node in ast.walk(other) if isinstance(node, ast.Attribute)}
    for cls in threshold_classes(TREES[name]):
        assert {node.target.id for node in cls.body if isinstance(node, ast.AnnAssign)} - used == set()
