"""A rule decides by a value, not by an error of the package: one that is caught below the faces is raised again."""

import ast

import pytest

import package_trees
import sigmatau.errors

MODULES = [name for name in package_trees.MODULES if not name.startswith(("app/", "cli/", "io/read/formats/"))]
"""Below the faces, which show errors; a format of files is tried, and its error is why it is another one."""

OURS = {name for name, value in vars(sigmatau.errors).items() if isinstance(value, type)}

UNREADABLE = "one of many files cannot be read: its row has the reason"
UNLOADABLE = "columns cannot be loaded: the error is raised again when the record is read"
UNDECIDED = "a question of a table is asked again when it is read, or is a line of the inspection"
TOO_SHORT = "a part is too short for an estimator"
JUSTIFIED = {
    "estimators/gapped.py _rows": TOO_SHORT,
    "analysis/stretches.py too_large": UNLOADABLE,
    "io/follow.py _read_all": "an error of the reading thread is raised by the loop that takes its pieces",
    "io/live.py _detect_layout": UNDECIDED,
    "io/read/column_values.py load_columns": UNLOADABLE,
    "io/read/column_samples.py samples": UNLOADABLE,
    "io/read/gravity.py unit_of_gravity": UNLOADABLE,
    "io/read/figure/pdf_process.py _main": "an error goes to the process that started this one, which raises it",
    "io/read/figure/titles.py _units": "a word of a title that is not the unit of a rate is not compared",
    "io/read/inspection.py _count_rows": UNLOADABLE,
    "io/read/inspection.py _look_into": UNDECIDED,
    "io/read/inspection.py _named_places": UNDECIDED,
    "io/read/inspection.py inspect": UNDECIDED,
    "io/read/instance_tables.py _values": UNLOADABLE,
    "io/read/instance_tables.py separate_instances": UNLOADABLE,
    "io/read/repeated_clocks.py separate_clocks": UNLOADABLE,
    "io/read/suggestions.py by_gravity": UNLOADABLE,
    "io/read/table_streams.py _loaded": UNLOADABLE,
    "io/read/table_streams.py part": UNDECIDED,
    "io/read/table_streams.py temperature_stream": UNLOADABLE,
    "io/read/thermometers.py thermometer_part": "a topic of temperatures that cannot be read is not a channel of the record",
    "io/read/turn_tables.py _check_turns": UNDECIDED,
    "io/read/turn_tables.py refuse_shared_times": UNLOADABLE,
    "io/read/unit_question.py _noise_of_gyro": UNLOADABLE,
    "lab/lots/lot.py examine": UNREADABLE,
    "lab/lots/preparing.py collect_runs": UNREADABLE,
    "lab/lots/reading.py _read": UNREADABLE,
    "lab/store/migrating.py _conditions": "a result that cannot be read shows no condition, and is updated without",
    "lab/store/store.py read": "a result that cannot be read is a failed run",
    "lab/store/store.py units_latest": "a result that cannot be read is a failed unit",
    "lab/lots/runs.py add_result": UNREADABLE,
    "quality/inspection.py _against_fits": TOO_SHORT,
    "reporting/charts.py _density": TOO_SHORT,
    "reporting/charts.py _map": TOO_SHORT,
    "reporting/content.py filter_files": "the writer of a target refuses what it cannot hold: the report names the first",
    "lab/store/from_files.py _read": UNREADABLE,
    "lab/temperature/noise_by_window.py noise_terms": TOO_SHORT,
    "lab/pages/temperature_pdf.py autopilot_files": "an autopilot refuses what it cannot hold: the page has the reason",
}


def rules(tree):
    """The functions of a module that go on after an error of the package."""
    for function in package_trees.nodes(tree):
        if isinstance(function, ast.FunctionDef) and any(map(goes_on, ast.walk(function))):
            yield function.name


def goes_on(node):
    """Whether a handler catches an error of the package and does not end in `raise`, or a call suppresses it."""
    if isinstance(node, ast.ExceptHandler):
        return node.type is not None and is_ours(node.type) and not isinstance(node.body[-1], ast.Raise)
    if not isinstance(node, ast.Call):
        return False
    name = getattr(node.func, "attr", getattr(node.func, "id", ""))
    return name == "suppress" and any(map(is_ours, node.args))


def is_ours(kind):
    return any(ast.unparse(inner).rpartition(".")[2] in OURS for inner in ast.walk(kind))


def test_no_rule_is_driven_by_an_error():
    places = {f"{name} {rule}" for name in MODULES for rule in rules(package_trees.tree(name))}
    assert places == JUSTIFIED.keys()


@pytest.mark.parametrize(
    "offence",
    [
        "try:\n        x = find(y)\n    except OptionError:\n        return False",
        "try:\n        x = find(y)\n    except (KeyError, errors.DataError) as error:\n        say(error.reason)",
        "with contextlib.suppress(DataError):\n        find(y)",
    ],
)
def test_an_offence_is_found(offence):
    assert list(rules(ast.parse(f"def decide(y):\n    {offence}"))) == ["decide"]


@pytest.mark.parametrize(
    "handler",
    [
        "except OptionError as error:\n        raise error.about(y) from None",
        "except OSError:\n        return False",
    ],
)
def test_an_error_that_is_raised_again_is_no_offence(handler):
    assert not list(rules(ast.parse(f"def read(y):\n    try:\n        x = find(y)\n    {handler}")))
