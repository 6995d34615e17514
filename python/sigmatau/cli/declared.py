"""Declared options as parameters of commands: their typed forms and the groups of the help; see `sigmatau.options`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast, get_args

from cyclopts import Group, Parameter

from sigmatau.hints import SPELLED, as_options, worded
from sigmatau.options import GroupName, Option
from sigmatau.typed.forms import convert, spelled, typed_form

if TYPE_CHECKING:
    from dataclasses import Field

MAIN = Group("Main options", sort_key=1)
"""Group of the options for a first use; the other options are in other groups."""

GROUPS: Mapping[GroupName, Group] = {name: Group(name, sort_key=2 + k) for k, name in enumerate(get_args(GroupName))}

FIGURE = Group("Figure", sort_key=1.5)
"""Group of the options for curves that are read from a figure."""

InMain: Parameter = Parameter(group=MAIN)
InFigure: Parameter = Parameter(group=FIGURE)
InMethod: Parameter = Parameter(group=GROUPS["Method"])
InOutput: Parameter = Parameter(group=GROUPS["Output"])
Flag: Parameter = Parameter(negative=(), show_default=False)
Texts: Parameter = Parameter(negative=())
MayBeMinus: Parameter = Parameter(allow_leading_hyphen=True)

Quiet = Annotated[bool, Parameter(name=["--quiet", "-q"]), Flag, InOutput]
Show = Annotated[
    str | None,
    InOutput,
    Parameter(
        help="Units of printed and drawn values, with commas between them: deg/h,mdps/rtHz,ug/rtHz. A density (/rtHz) is"
        " two-sided, or mdps/rtHz:one-sided; other sensors with a prefix: nT, hPa, uV/rtHz. Numbers of JSON and CSV stay in"
        " SI. Default: the usual units."
    ),
]
"""For every command that prints a coefficient, deviation or density, which calls `set_shown`, then `check_shown`."""
Verbose = Annotated[bool, Parameter(name=["--verbose", "-v"]), Flag, InMain]


T = TypeVar("T", bound="DeclaredOptions")


class DeclaredOptions:
    """Base of declared options in typed form. Options that were not typed are None."""

    def table(self) -> dict[str, Any]:
        """Options that were typed, by name, in typed form."""
        typed = {each.name: getattr(self, each.name) for each in fields(cast("Any", self))}
        defaults = {each.name: each.default for each in fields(cast("Any", self))}
        stated = {name: value for name, value in typed.items() if value is not None and value != defaults[name]}
        return {
            name: value[0] if isinstance(value, list) and len(value) == 1 else value for name, value in stated.items()
        }

    def arguments(self) -> dict[str, Any]:
        """Options by name, as Python arguments; options that were not typed have their defaults."""
        values = {}
        for each in fields(cast("Any", self)):  # a dataclass by `typed_options`
            typed = getattr(self, each.name)
            if typed is not None:
                values[each.name] = convert(each.name, each.metadata[Option], typed)
            elif each.metadata["default"] is not MISSING:
                values[each.name] = each.metadata["default"]
        return values


def typed_options(
    options: Any,  # noqa: ANN401  a class of options
    *,
    only: Collection[str] = (),
    without: Collection[str] = (),
) -> Callable[[type[T]], type[T]]:
    """Build a class of options in typed form: all options of a class, `only` some of them, or all `without` some."""

    def decorate(cls: type[T]) -> type[T]:
        cls.__annotations__ = {}
        for each in fields(options):
            about: Option = each.metadata[Option]
            typable = about.form is not None or about.choices
            if typable and each.name not in without and (not only or each.name in only):
                cls.__annotations__[each.name] = parameter(each)
                setattr(cls, each.name, _field(each))
        return Parameter(name="*")(dataclass(frozen=True, kw_only=True)(cls))

    return decorate


def parameter(each: Field[Any]) -> Any:  # noqa: ANN401  a type for cyclopts
    """Annotation of a declared option."""
    about: Option = each.metadata[Option]
    form = typed_form(about)
    how = Parameter(
        name=f"--{spelled(each.name)}" if each.name in SPELLED else None,
        group=MAIN if about.main else GROUPS[about.group],
        help=worded(" ".join(filter(None, [about.text, about.typed, about.otherwise])), as_options),
        negative=(),
        allow_leading_hyphen=form.with_minus,
        show_default=_has_default(each) and about.form != "flag",
    )
    return Annotated[form.kind if _has_default(each) else form.kind | None, how]


def _has_default(each: Field[Any]) -> bool:
    """Whether the help shows the default: a word, a number, or a flag that is off."""
    return isinstance(each.default, str | bool | int | float)


def _field(each: Field[Any]) -> Any:  # noqa: ANN401  a field
    metadata = {**each.metadata, "default": each.default}
    return field(default=each.default if _has_default(each) else None, metadata=metadata)
