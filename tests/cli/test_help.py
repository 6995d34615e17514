"""The help of every command: a line that says what it does, examples, and each option with its default and its unit."""

import re

import pytest

from sigmatau.cli.app import EXAMPLES, app

# Options that add something if they are given; without them nothing is done, so that there is no default to tell.
ADDING = {
    *(
        "--accept",
        "--export",
        "--from-datasheet",
        "--inflate",
        "--name",
        "--note",
        "--read-off-at",
        "--serial",
        "--spec",
    ),
    *("--store", "--to", "NAME", "SOURCE"),
}
NUMBER = re.compile(r"\b(float|int)\b")
UNIT = re.compile(
    r"\b(Hz|seconds|hours|GB|degC|factor|FACTOR|ratio|probability|confidence level|number of|seed|same log)\b|°C",
    re.IGNORECASE,
)


def commands(parent=app, path=()):
    """Every command and part of a command that a user can call, by its words."""
    for name in parent:
        if not name.startswith("-"):
            one = parent[name]
            yield from commands(one, (*path, name))
            if one.default_command is not None:
                yield " ".join((*path, name)), one


COMMANDS = dict(commands())


def options(command):
    """The arguments and options of a command that its help shows: name, type, whether required, default, text."""
    for one in command.assemble_argument_collection(parse_docstring=True):
        shown = one.parameter.show is not False and one.names != ("*",)
        if shown:
            default = one.field_info.default
            yield one.names[0], one.hint, one.required, default, one.parameter.help or ""


def test_the_commands_are_found():
    assert {"analyze", "export", "fleet", "store trend"} <= set(COMMANDS)
    assert set(EXAMPLES) == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_summary_and_examples(name):
    summary = COMMANDS[name].help
    assert re.fullmatch(r"[A-Z].{10,118}\.", summary), summary
    lines = EXAMPLES[name].splitlines()
    assert lines
    assert all(f"sigmatau {name}" in line for line in lines), lines
    assert EXAMPLES[name] in COMMANDS[name].help_epilogue


@pytest.mark.parametrize("name", COMMANDS)
def test_options(name):
    """A default is shown by the program, or told in the text."""
    problems = []
    for option, hint, required, default, text in options(COMMANDS[name]):
        if not re.match(r"[A-Z$a-z].*\.", text, flags=re.DOTALL):
            problems.append(f"{option}: no text")
        if NUMBER.search(str(hint)) and not UNIT.search(text):
            problems.append(f"{option}: a number without a unit")
        writes = "Path" in str(hint) and re.search(r"\b(Write|Draw|Folder|JSON|Model file)\b", text)
        told = re.search(r"[Dd]efault|[Rr]equired|\bOnly\b|[Ww]ith --store", text)
        if not required and default in (None, "") and not told and not writes and option not in ADDING:
            problems.append(f"{option}: no default: {text}")
    assert not problems, "\n".join([name, *problems])


def test_help_pages_show_them(capsys):
    """What the tests above read is what is printed."""
    with pytest.raises(SystemExit) as done:
        app(["psd", "--help"])
    assert done.value.code in (0, None)
    out = " ".join(capsys.readouterr().out.split())
    assert COMMANDS["psd"].help.split(",")[0] in out
    for option, *_ in options(COMMANDS["psd"]):
        assert option in out
    for line in EXAMPLES["psd"].splitlines():
        assert line.split("   ")[0] in out


def test_adding_options_exist():
    every = {option for command in COMMANDS.values() for option, *_ in options(command)}
    assert every >= ADDING
