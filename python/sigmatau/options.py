"""Options, declared once: a field of a dataclass is an argument in Python, an option of the command line, a key of the JSON,
and an entry of the pages.

    @frozen
    class AnalysisOptions:
        tau_min: float | None = field(
            default=None, metadata=option("Method", "Shortest averaging time of least squares.", form="seconds")
        )

    @keywords_of(AnalysisOptions)
    def analyze(record: Record, options: AnalysisOptions) -> Analysis: ...

`analyze` then has the argument `tau_min` in its signature and in its docstring. `stated` returns the values for the
JSON, and `sigmatau.cli.declared` makes the option ``--tau-min``, with its text in its group of the help.
"""

from __future__ import annotations

import functools
import inspect
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, fields
from typing import Any, Concatenate, Literal, NamedTuple, ParamSpec, TypeVar, cast

from sigmatau.errors import OptionError
from sigmatau.results import plain

P = ParamSpec("P")
Argument = TypeVar("Argument")
Options = TypeVar("Options")
Result = TypeVar("Result")

GroupName = Literal["Input", "Selection", "Method", "Output", "Export"]

Form = Literal[
    "text", "texts", "flag", "count", "number", "seconds", "times", "ranges", "span", "spans", "names", "rates", "pairs",
    "numbers", "bandwidths", "time", "factors",
]  # fmt: skip
"""How a value is typed on the command line; see `sigmatau.typed.forms`."""

_NUMBERS: tuple[Form, ...] = ("number", "seconds", "times", "rates", "numbers")
_WIDTH = 120  # of docstrings


class Option(NamedTuple):
    """Description of an option, besides its name, its type and its default.

    `text` is for Python and the command line alike, as is `otherwise`: the effect of omitting the option. Between these
    two stands `python` or `typed`, a text for one of the two faces. An option without a form can only be given in
    Python. An option that does not `matter` changes no number of the result.
    """

    group: GroupName
    text: str
    otherwise: str
    form: Form | None
    choices: tuple[str, ...]
    unit: str
    kind: str
    example: str
    python: str
    typed: str
    main: bool
    matters: bool


def option(
    group: GroupName,
    text: str,
    otherwise: str = "",
    *,
    form: Form | None = None,
    choices: Sequence[str] = (),
    unit: str = "",
    kind: str = "",
    example: str = "",
    python: str = "",
    typed: str = "",
    main: bool = False,
    matters: bool = True,
) -> dict[type[Option], Option]:
    """The metadata of a field that is an option.

    Parameters
    ----------
    group : str
        Group of the help.
    text : str
        One sentence for Python and for the command line.
    otherwise : str
        Effect of omitting it, if the default does not show it: ``"Default: all."``
    form : str, optional
        How it is typed; None for an option of Python only. An option with `choices` needs none.
    choices : sequence of str
        All values, if they are few; of pairs, the words for a value.
    unit : str
        Unit of numbers, in Python.
    kind : str
        Type in the docstring. Default: the choices.
    example : str
        A value as it is typed, for messages.
    python, typed : str
        More sentences for Python, or for the command line.
    main : bool
        Whether the help lists it among the main options.
    matters : bool
        Whether it changes numbers of the result, so that the JSON states it.
    """
    about = Option(
        group=group, text=text, otherwise=otherwise, form=form, choices=tuple(choices), unit=unit, kind=kind,
        example=example, python=python, typed=typed, main=main, matters=matters,
    )  # fmt: skip
    return {Option: about}


def same_option(options: Any, name: str) -> Any:  # noqa: ANN401  a field of the option's own type
    """A field with the same option as another class."""
    (same,) = (each for each in fields(options) if each.name == name)
    return field(default=same.default, metadata=same.metadata)


def declared(options: Any) -> dict[str, Option]:  # noqa: ANN401  a class of options, or an instance
    """The options of a class, by name."""
    return {each.name: each.metadata[Option] for each in fields(options)}


def check_choices(options: Any) -> None:  # noqa: ANN401  any options
    """Raise `OptionError` for a value that is not one of the choices."""
    for name, about in declared(options).items():
        value = getattr(options, name)
        if about.choices and value not in about.choices:
            raise OptionError(f"{{option}} must be one of {', '.join(about.choices)}, not {value!r}", option=name)


def stated(options: Any) -> dict[str, Any]:  # noqa: ANN401  any options
    """The options that matter and are not the default, as plain values: 100 and 100.0 are the same."""
    about = declared(options)
    values = {name: value for name, value in options_that_differ(options) if about[name].matters}
    return plain(None, **{n: _as_numbers(v) if about[n].form in _NUMBERS else v for n, v in values.items()})


def options_that_differ(options: Any) -> list[tuple[str, Any]]:  # noqa: ANN401  any options
    """The options that are not the default, and their values."""
    values = ((each.name, getattr(options, each.name), each.default) for each in fields(options))
    return [(name, value) for name, value, default in values if _differs(value, default)]


def _differs(value: Any, default: object) -> bool:  # noqa: ANN401  of any option
    if _is_single(value):
        return value is not None and bool(value != default)
    return len(value) > 0


def _is_single(value: object) -> bool:
    """Whether a value is a single word or number, including those of NumPy."""
    return isinstance(value, str) or not hasattr(value, "__len__") or getattr(value, "shape", None) == ()


def _as_numbers(value: Any) -> Any:  # noqa: ANN401  a number, or several
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return {key: float(number) for key, number in value.items()}
    return float(value) if _is_single(value) else [float(number) for number in value]


def keywords_of(
    options: Callable[P, Options],
) -> Callable[[Callable[[Argument, Options], Result]], Callable[Concatenate[Argument, P], Result]]:
    """Turn a function of an argument and an options object into a function that takes each option by keyword.

    Its signature and its docstring list the options after the parameter that the docstring describes.
    """

    def decorate(function: Callable[[Argument, Options], Result]) -> Callable[Concatenate[Argument, P], Result]:
        first, _ = inspect.signature(function).parameters.values()
        keywords = [
            inspect.Parameter(each.name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=each.type)
            for each in fields(cast(Any, options))
        ]
        signature = inspect.signature(function).replace(parameters=[first, *keywords])

        @functools.wraps(function)
        def call(*args: Any, **stated_options: Any) -> Result:  # noqa: ANN401
            if len(args) == 1 and stated_options.keys() <= names:
                return function(args[0], cast(Any, options)(**stated_options))
            bound = signature.bind(*args, **stated_options)
            argument = bound.arguments.pop(first.name)
            return function(argument, cast(Any, options)(**bound.arguments))

        names = {each.name for each in keywords}
        cast(Any, call).__signature__ = signature
        call.__annotations__ = {name: parameter.annotation for name, parameter in signature.parameters.items()}
        call.__annotations__["return"] = signature.return_annotation
        del call.__wrapped__  # the wrapped function has another signature
        call.__doc__ = _with_options(function.__doc__ or "", declared(options))
        return cast("Callable[Concatenate[Argument, P], Result]", call)

    return decorate


def with_attributes(options: type[Options]) -> type[Options]:
    """Add the description of each option to the docstring of a class."""
    entries = "".join(_entry(name, about) for name, about in declared(options).items())
    before, raises, after = str(options.__doc__).partition("\n    Raises\n")
    options.__doc__ = f"{before.rstrip()}\n\n    Attributes\n    ----------\n{entries}{raises or '    '}{after}"
    return options


def _with_options(docstring: str, options: Mapping[str, Option]) -> str:
    """A docstring with entries for the options at the end of its parameters."""
    before, returns, after = docstring.partition("\n    Returns\n")
    entries = "".join(_entry(name, about) for name, about in options.items())
    return f"{before.rstrip()}\n{entries}\n{returns.lstrip(chr(10))}{after}" if returns else docstring


def _entry(name: str, about: Option) -> str:
    """The entry of an option in a docstring."""
    kind = about.kind or "{" + ", ".join(f'"{choice}"' for choice in about.choices) + "}"
    sentences = " ".join(
        filter(None, [about.text, about.python, about.otherwise, f"[{about.unit}]" if about.unit else ""])
    )
    lines = textwrap.wrap(sentences, _WIDTH - 8, break_long_words=False, break_on_hyphens=False)
    return f"    {name} : {kind}\n" + "".join(f"        {line}\n" for line in lines)
