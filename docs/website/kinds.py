"""The page of the details of findings, from the classes of `sigmatau.findings.kinds` and the comments of their fields."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator

from sigmatau.findings.finding import Details
from sigmatau.findings.wording import SUBJECTS
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
    for subject in SUBJECTS:
        module = importlib.import_module(f"sigmatau.findings.kinds.{subject}")
        kinds = [one for one in vars(module).values() if inspect.isclass(one) and issubclass(one, Details)]
        kinds = [one for one in kinds if one.code and one.__module__ == module.__name__]
        lines += heading(module.__name__, "-")
        for kind in sorted(kinds, key=lambda one: one.code):
            lines += [
                f".. describe:: {kind.code}",
                "",
                f"   ``{kind.__name__}``: {' '.join((kind.__doc__ or '').split())}",
                "",
            ]
            lines += [f"   - ``{name}``: {type_}{f'; {about}' if about else ''}" for name, type_, about in fields(kind)]
            lines.append("")
    return "\n".join(lines) + "\n"


def fields(kind: type[Details]) -> Iterator[tuple[str, str, str]]:
    """Name, type and comment of each field of a kind, those of its bases first."""
    for owner in reversed(kind.__mro__):
        if issubclass(owner, Details) and owner is not Details:
            about = {line["name"]: line["about"] or "" for line in _FIELD.finditer(inspect.getsource(owner))}
            for name, type_ in vars(owner).get("__annotations__", {}).items():
                yield name, type_.replace(" | ", " or "), about.get(name, "")
