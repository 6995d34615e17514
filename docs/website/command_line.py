"""The page of the command line, from the application that prints ``--help``."""

from __future__ import annotations

import re

from sigmatau.cli.app import EXAMPLES, app
from website.rst import escaped, heading

_HEADING = re.compile(r"^# ", flags=re.MULTILINE)
_ITEM = re.compile(r"^\* `(?P<names>[^`]+)`(?:: | )?(?P<text>.*(?:\n(?:    ).*)*)", flags=re.MULTILINE)
_MARKS = re.compile(r" ?(?:\*\[default: False\]\*|\*\*\[required\]\*\*)")
_NOTE = re.compile(r" ?\*\[(choices|default): ([^\]]*)\]\*")


def page() -> str:
    """All commands with their examples, arguments and options, in reStructuredText."""
    text = app.generate_docs(output_format="markdown", flatten_commands=True)
    first, *commands = _HEADING.split(text)[1:]
    commands.sort(key=lambda command: command.startswith("sigmatau --"))
    parts = [
        *heading("Command line", "="),
        escaped(first.partition("```\n\n")[2].partition("\n")[0]),
        "This page is made from the application that prints ``sigmatau COMMAND --help``.",
        "",
        *heading("Exit codes", "-"),
        _exit_codes(),
    ]
    for command in commands:
        parts += _command(command)
    return "\n".join(parts) + "\n"


def _exit_codes() -> str:
    codes, _, rest = str(app.help_epilogue).removeprefix("Exit codes: ").partition(". ")
    rows = [code.strip().partition(" ") for code in codes.split(" · ")]
    return "\n".join([*(f"- **{code}**: {escaped(meaning)}" for code, _, meaning in rows), "", escaped(rest), ""])


def _command(text: str) -> list[str]:
    name, _, rest = text.partition("\n")
    usage, _, rest = rest.partition("```console\n")[2].partition("```\n")
    if not usage:  # a group of commands
        return [*heading(name, "-"), escaped(rest or text.partition("\n")[2]), ""]
    words = name.removeprefix("sigmatau ")
    usage = usage.replace(f"{name} {words} ", f"{name} ", 1)  # the library repeats the name before a given usage
    summary, _, rest = rest.strip().partition("\n**")
    parts = [*heading(name, "-"), escaped(summary), "", ".. code-block:: text", "", f"   {usage.strip()}", ""]
    if examples := EXAMPLES.get(words):
        parts += [".. code-block:: sh", "", *(f"   {line}" for line in examples.splitlines()), ""]
    parts += [f".. program:: {name}", ""]
    for item in _ITEM.finditer(rest):
        parts += _option(item["names"], item["text"])
    return parts


def _option(names: str, text: str) -> list[str]:
    """An option or an argument; `names` are ``--output, -o PATH``, or ``LOGS``."""
    required = "**[required]**" in text
    notes = _NOTE.findall(_MARKS.sub("", text))
    text = escaped(_NOTE.sub("", _MARKS.sub("", text)))
    for kind, values in notes:
        shown = ", ".join(f"``{value}``" for value in values.split(", "))
        text += f" {kind.capitalize()}: {shown}."
    if required:
        text += " Required."
    if names.startswith("-"):
        spelled, _, value = names.partition(" ") if ", " not in names else _several(names)
        head = f".. option:: {', '.join(f'{name} {value}'.strip() for name in spelled.split(', '))}"
    else:
        head = f".. describe:: {names}"
    return [head, "", f"   {text}", ""]


def _several(names: str) -> tuple[str, str, str]:
    words = names.split(" ")
    value = "" if words[-1].startswith("-") else words.pop()
    return " ".join(words), " ", value
