"""Declared options as parameters of commands: how each form is typed, and the groups of the help; see `sigmatau.options`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar, cast, get_args

from cyclopts import Group, Parameter

from sigmatau.cli.options import averaging_times, bandwidths, factors, key_numbers, key_values
from sigmatau.cli.ranges import read_off_ranges
from sigmatau.cli.rates import parse_rate
from sigmatau.hints import SPELLED, as_options, worded
from sigmatau.options import Form, GroupName, Option
from sigmatau.quality.selection.time_text import parse_seconds, parse_time

if TYPE_CHECKING:
    from dataclasses import Field

MAIN = Group("Main options", sort_key=1)
"""What a newcomer needs; the other groups have the rest."""

GROUPS: Mapping[GroupName, Group] = {name: Group(name, sort_key=2 + k) for k, name in enumerate(get_args(GroupName))}

InMain: Parameter = Parameter(group=MAIN)
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
"""Every command that prints a coefficient, deviation or density has it: `set_shown`, then `check_shown` of its channels."""
Verbose = Annotated[bool, Parameter(name=["--verbose", "-v"]), Flag, InMain]


class Typed(NamedTuple):
    """How a form is typed: the type for the parser, what makes the value of it, and whether it may begin with a minus."""

    kind: Any
    convert: Callable[[Any, str, str], Any]
    with_minus: bool = False


_TIME = "want a value with its unit, e.g. 10s, 5min, 2h"


def _as_it_is(typed: Any, name: str, example: str) -> Any:  # noqa: ANN401  of any form
    return typed


FORMS: Mapping[Form, Typed] = {
    "text": Typed(str, _as_it_is),
    "texts": Typed(list[str], _as_it_is),
    "flag": Typed(bool, _as_it_is),
    "count": Typed(int, _as_it_is),
    "number": Typed(float, _as_it_is),
    "seconds": Typed(str, lambda text, name, _: parse_seconds(text, option=name), with_minus=True),
    "time": Typed(str, lambda text, name, _: parse_time(text, text, option=name, forms=_TIME)),
    "times": Typed(str, lambda text, *_: averaging_times(text)),
    "ranges": Typed(list[str], lambda texts, *_: read_off_ranges(texts)),
    "span": Typed(str, _as_it_is, with_minus=True),
    "spans": Typed(list[str], _as_it_is, with_minus=True),
    "names": Typed(str, lambda text, *_: [name.strip() for name in text.split(",")]),
    "rates": Typed(list[str], lambda texts, *_: parse_rate(texts), with_minus=True),
    "pairs": Typed(list[str], key_values),
    "numbers": Typed(list[str], key_numbers),
    "factors": Typed(str, factors),
    "bandwidths": Typed(list[str], lambda texts, *_: bandwidths(texts)),
}

T = TypeVar("T", bound="DeclaredOptions")


class DeclaredOptions:
    """Base of declared options as they are typed; None for those that are not."""

    def arguments(self) -> dict[str, Any]:
        """The options by name, as Python takes them; those that were not typed have their default."""
        values = {}
        for each in fields(cast("Any", self)):  # a dataclass by `typed_options`
            about: Option = each.metadata[Option]
            typed = getattr(self, each.name)
            if typed is not None:
                convert = _as_it_is if about.form is None else FORMS[about.form].convert
                values[each.name] = convert(typed, spelled(each.name), about.example)
            elif each.metadata["default"] is not MISSING:
                values[each.name] = each.metadata["default"]
        return values


def spelled(name: str) -> str:
    """The option of an argument, without its hyphens in front."""
    return SPELLED.get(name, name).replace("_", "-")


def typed_options(
    options: Any,  # noqa: ANN401  a class of options
    *,
    only: Collection[str] = (),
    without: Collection[str] = (),
) -> Callable[[type[T]], type[T]]:
    """A class of options as one of the same options as they are typed: all, `only` some, or all `without` some."""

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
    """The annotation of a declared option."""
    about: Option = each.metadata[Option]
    form = Typed(Literal[about.choices], _as_it_is) if about.form is None else FORMS[about.form]
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
