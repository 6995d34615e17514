"""The page of the details of findings, from its classes in `sigmatau.findings` and the comments of their fields."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

from sigmatau.findings import details_by_code
from sigmatau.findings.finding import Details
from website.rst import heading

_FIELD = re.compile(r"^    (?P<name>[a-z]\w*): [^#\n]*(?:# (?P<about>.*))?$", flags=re.MULTILINE)


def page() -> str:
    """Every kind of finding with its fields, in reStructuredText."""
    lines = [
        *heading("Details of findings", "="),
        "``details`` of a `Finding <sigmatau.Finding>`, and of a finding in JSON, has the parameters of what was found.",
        ":doc:`Findings <findings>` says what each code means. In Python the details are objects of these classes.",
        "",
    ]
    modules = sorted({kind.__module__ for kind in details_by_code().values()})
    for module in modules:
        kinds = [kind for kind in details_by_code().values() if kind.__module__ == module]
        lines += [*heading(module.rpartition(".")[2].capitalize(), "-"), f"Module ``{module}``.", ""]
        for kind in sorted(kinds, key=lambda kind: kind.code):
            summary = " ".join((kind.__doc__ or "").partition("Attributes\n")[0].split())
            lines += [
                f".. describe:: {kind.code}",
                "",
                f"   ``{kind.__name__}``: {summary}",
                "",
            ]
            lines += [f"   - ``{name}``: {type_}{f'; {about}' if about else ''}" for name, type_, about in fields(kind)]
            lines.append("")
    return "\n".join(lines) + "\n"


def fields(kind: type[Details]) -> Iterator[tuple[str, str, str]]:
    """Name, type and meaning of each field of a kind, starting with those of its bases."""
    for owner in reversed(kind.__mro__):
        if issubclass(owner, Details) and owner is not Details:
            about = {line["name"]: line["about"] or "" for line in _FIELD.finditer(inspect.getsource(owner))}
            about |= _described(vars(owner).get("__doc__") or "")
            for name, type_ in vars(owner).get("__annotations__", {}).items():
                yield name, type_.replace(" | ", " or "), about.get(name, "").removesuffix(".")


def _described(docstring: str) -> dict[str, str]:
    """Meanings of the attributes in a docstring, by name."""
    meanings: dict[str, str] = {}
    names: list[str] = []
    for line in inspect.cleandoc(docstring).partition("Attributes\n----------\n")[2].splitlines():
        if line[:1].strip():
            names = line.partition(" : ")[0].split(", ")
        else:
            meanings |= {name: f"{meanings.get(name, '')} {line.strip()}".strip() for name in names}
    return meanings
