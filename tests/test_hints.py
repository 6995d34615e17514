"""Hints: options that messages name, as data, which each face words; below the command line nobody types one."""

import ast
import re

import pytest

import sigmatau
from package_trees import MODULES, nodes, tree
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import Hint, as_arguments, as_options, command, hints_in, speaking, worded

BELOW_CLI = [name for name in MODULES if not name.startswith(("app/", "cli/", "typed/"))]
"""Below the faces and the texts that are typed into them."""

OPTION = re.compile(r"(?<![\w-])--[a-z]|(?<=[\s(])--$")
FOREIGN = {"io/read/formats/text_programs.py": "ros2 topic echo --csv"}
"""Commands of other programs."""


@pytest.mark.parametrize(
    ("hints", "python", "typed"),
    [
        ([Hint("walk")], "`walk`", "--rate-random-walk"),
        ([Hint("axes", value="worst")], '`axes="worst"`', "--axes worst"),
        ([Hint("rate", value="HZ")], "`rate=HZ`", "--rate HZ"),
        ([Hint("horizon", value=10)], "`horizon=10`", "--horizon 10s"),
        ([Hint("at_rest", value=True)], "`at_rest=True`", "--at-rest"),
        ([Hint("unit", "time", "ms")], '`unit={"time": "ms"}`', "--unit time=ms"),
        (
            [Hint("unit", "gyro", "deg/s", "2 deg/s")],
            '`unit={"gyro": "deg/s"}` (2 deg/s)',
            "--unit gyro=deg/s (2 deg/s)",
        ),
        (
            [Hint("rate", value={"gyro": 400, "accel": 200})],
            '`rate={"gyro": 400, "accel": 200}`',
            "--rate gyro=400,accel=200",
        ),
        ([Hint("topic", value=["/a", "b c"])], '`topic=["/a", "b c"]`', '--topic /a --topic "b c"'),
        ([Hint("topic", value="imu[0]")], '`topic="imu[0]"`', '--topic "imu[0]"'),
        ([Hint("topic", value="$x")], '`topic="$x"`', "--topic '$x'"),
        (
            [Hint("channels", "time", "none"), Hint("rate", value=100.5)],
            '`channels={"time": "none"}, rate=100.5`',
            "--channels time=none --rate 100.5",
        ),
    ],
)
def test_each_face_has_its_words(hints, python, typed):
    text = f"give {' '.join(map(str, hints))}, or not"
    assert hints_in(text) == tuple(hints)
    assert worded(text) == worded(text, as_arguments) == f"give {python}, or not"
    assert worded(text, as_options) == f"give {typed}, or not"
    assert DataError(text).hints == tuple(hints)


def test_a_face_of_another_kind():
    """A page in a browser may make buttons of hints: it gets them as data."""
    with speaking(lambda hints: "".join(f"<button>{hint.option}</button>" for hint in hints)):
        assert str(OptionError("give {option}", option="rate").about("a.csv")) == "a.csv: give <button>rate</button>"
    assert str(OptionError("give {option}", option="rate")) == "give `rate`"


def test_a_command_is_typed_in_both_faces():
    assert command("analyze", "LOG", Hint("json", value="r.json")) == "sigmatau analyze LOG --json r.json"


def test_marks_of_others_are_left_alone():
    assert worded("a \ue000name\ue001 of a column, \ue000") == "a \ue000name\ue001 of a column, \ue000"


def test_findings_have_hints():
    accel = {f"accel_{axis}": [mean, mean + 0.001] * 50 for axis, mean in (("x", 0.0), ("y", 0.0), ("z", 1.0))}
    record = sigmatau.Record.from_arrays(rate=100, **accel)
    (finding,) = (one for one in sigmatau.check(record) if one.code == "implausible_unit")
    assert finding.hints == (Hint("unit", "accel", "g"),)
    assert 'unit={"accel": "g"}' in finding.action
    assert "--unit accel=g" in finding.to_dict()["action"]


def texts(code):
    """The texts of a module that are no docstrings, nor cells of a table of the pages: `columns` of a target."""
    bodies = (node.body for node in nodes(code) if isinstance(getattr(node, "body", None), list))
    docstrings = {one.value for body in bodies for one in body if isinstance(one, ast.Expr)}
    tables = [node.value for node in nodes(code) if isinstance(node, ast.keyword) and node.arg == "columns"]
    cells = {cell for table in tables for cell in ast.walk(table)}
    for node in nodes(code):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in docstrings | cells:
            yield node


def test_no_option_is_typed_below_the_command_line():
    typed = [
        f"{name}, line {text.lineno}: {text.value!r}"
        for name in BELOW_CLI
        for text in texts(tree(name))
        if OPTION.search(text.value.replace(FOREIGN.get(name, "\n"), ""))
    ]
    assert not typed, "\n".join(typed)


def test_a_typed_option_is_found():
    code = ast.parse('"""--rate is fine in a docstring."""\nraise DataError(f"{n} rows; give --rate HZ or a --- line")')
    assert [bool(OPTION.search(one.value)) for one in texts(code)] == [True]
    assert not OPTION.search("a -- b, x--y, --- and -- ")
