"""What docs/decisions/0006-versions.md calls public is not removed or renamed unnoticed.

tests/release/frozen/public.txt has the names of the last release: of Python, with parameters and members, and of the command
line. ``UPDATE_FROZEN=1`` writes it anew: at a release, and after a removal that the changelog announces.
"""

import inspect
import os
from collections.abc import Iterator

from scripts_of import script

import sigmatau
from conftest import ROOT
from sigmatau.cli.app import app
from sigmatau.exporting.targets import NAMES
from sigmatau.findings import details_by_code

FILE = ROOT / "tests" / "release" / "frozen" / "public.txt"
manual = script("manual")


def parameters(name: str, of: object) -> Iterator[str]:
    for one in inspect.signature(of).parameters.values():
        if not one.name.startswith("_") and one.name not in ("self", "cls"):
            yield f"{name}({one.name}{'' if one.default is one.empty else '='})"


def of_python() -> Iterator[str]:
    for name in sigmatau.__all__:
        public = getattr(sigmatau, name)
        yield name
        if inspect.isclass(public):
            own = [vars(kind) for kind in public.__mro__ if kind.__module__.startswith("sigmatau")]
            members = {member for each in own for member in (*each, *each.get("__dataclass_fields__", ()))}
            for member in sorted(member for member in members if not member.startswith("_")):
                yield f"{name}.{member}"
                if inspect.isroutine(method := getattr(public, member, None)):
                    yield from parameters(f"{name}.{member}", method)
        elif callable(public):
            yield from parameters(name, public)


def of_command_line() -> Iterator[str]:
    for words in manual.commands():
        yield " ".join(("sigmatau", *words))
        command = app
        for word in words:
            command = command[word]
        if command.default_command:
            for one in command.assemble_argument_collection(parse_docstring=False):
                yield from (f"{' '.join(('sigmatau', *words))} {name}" for name in one.names if name.startswith("-"))
    yield from (f"export --to {name}" for name in NAMES)


def now() -> list[str]:
    return sorted({*of_python(), *of_command_line(), *(f"finding {code}" for code in details_by_code())})


def missing(frozen: list[str], found: list[str]) -> list[str]:
    """Names that are gone, and parameters that a call of the frozen interface does not give."""
    gone = sorted(set(frozen) - set(found))
    functions = {line.partition("(")[0] for line in frozen if "(" in line}
    asked = [line for line in found if line.endswith(")") and not line.endswith("=)") and line not in frozen]
    return gone + [line for line in asked if line.partition("(")[0] in functions]


def test_no_public_name_is_gone():
    found = now()
    if os.environ.get("UPDATE_FROZEN"):
        FILE.write_text("\n".join(found) + "\n", encoding="utf-8")
    assert missing(FILE.read_text(encoding="utf-8").splitlines(), found) == []


def test_a_removal_is_found():
    frozen = FILE.read_text(encoding="utf-8").splitlines()
    assert len(frozen) > 500
    for line in (
        "analyze",
        "analyze(method=)",
        "Analysis.to_dict",
        "sigmatau analyze --json",
        "export --to kalibr",
        "finding gaps",
    ):
        assert missing(frozen, [one for one in frozen if one != line]) == [line]
    assert missing(frozen, [*frozen, "analyze(mood)"]) == ["analyze(mood)"]
    assert missing(frozen, [*frozen, "analyze(mood=)", "nothing(mood)", "sigmatau analyze --mood"]) == []
