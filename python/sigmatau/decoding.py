"""Decodes JSON values into the types that annotations declare: dataclasses, tuples, mappings, arrays; errors name the
place.

Libraries that do this (msgspec, cattrs) either have no union of several dataclasses, or take ``"5"`` for a number; results
have unions, distinguished by the field ``kind``, and null where a number is not finite.
"""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Callable, Mapping
from dataclasses import MISSING, field, fields, is_dataclass
from typing import Any, Literal, NamedTuple, NoReturn, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from sigmatau.errors import DataError

T = TypeVar("T")
Decoder = Callable[[Any], Any]

_LARGEST_INTEGER = 10**300  # a float can represent it, though not exactly
_SHOWN = 40  # characters of a wrong value
_NUMBERS = (frozenset({float, int, type(None)}), frozenset({int}))


class WrongValueError(ValueError):
    """A value of another type than declared; `path` is its place, the innermost key first."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.path: list[str | int] = []

    def __str__(self) -> str:
        place = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in reversed(self.path))
        return f"{place.lstrip('.')}: {self.args[0]}".removeprefix(": ")


class Key(NamedTuple):
    """Description of a key in the JSON Schema beside its type: meaning, when it is present, and bounds of its numbers."""

    about: str
    always: bool
    null: bool
    bounds: Mapping[str, Any]


def key(
    about: str = "",
    *,
    default: Any = MISSING,  # noqa: ANN401  of any type
    factory: Any = MISSING,  # noqa: ANN401  of any type
    always: bool = False,
    null: bool = False,
    read: bool = True,
    **bounds: Any,  # noqa: ANN401  of JSON Schema
) -> Any:  # noqa: ANN401  a field
    """A field of a JSON form.

    Parameters
    ----------
    about : str
        Its meaning, for the schema.
    default, factory
        Value if the key is absent, as in files from older versions or written by hand. Without either, the key is
        required.
    always : bool
        Whether this version always writes it.
    null : bool
        Whether it may be null; otherwise a key whose default is None is absent instead.
    read : bool
        Whether it is read back; the other keys are computed from those.
    **bounds
        Bounds of its numbers, as keywords of JSON Schema: ``minimum=0``.
    """
    needed = read and default is MISSING and factory is MISSING
    metadata = {Key: Key(about=about, always=always or needed, null=null, bounds=bounds)}
    if factory is not MISSING:
        return field(default_factory=factory, metadata=metadata)
    return field(default=default if read else None, init=read, metadata=metadata)


def decode(kind: Callable[..., T], value: object) -> T:
    """A value of a declared type; raises `WrongValueError`. Keys that the type lacks are ignored."""
    decoded: T = _decoder(kind, null=False)(value)
    return decoded


def decode_details(kind: Callable[..., T], value: object) -> T:
    """Decode the details of a finding, where null stands for a number that is not finite."""
    decoded: T = _decoder(kind, null=True)(value)
    return decoded


def _refuse(value: object, wanted: str) -> NoReturn:
    shown = repr(value)
    raise WrongValueError(f"{shown if len(shown) <= _SHOWN else shown[:_SHOWN] + '…'} is not {wanted}")


@functools.cache
def _decoder(kind: Any, *, null: bool) -> Decoder:  # noqa: ANN401  any annotation
    if kind in _SCALARS:
        return _float_or_null if null and kind is float else _SCALARS[kind]
    if is_dataclass(kind):
        return _dataclass(kind, null=null)
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Literal:
        return functools.partial(_choice, arguments)
    if origin in (Union, types.UnionType):
        return _union(arguments, null=null)
    if origin is tuple:
        if arguments[-1] is Ellipsis:
            return functools.partial(_items, _decoder(arguments[0], null=null))
        return functools.partial(_tuple, [_decoder(argument, null=null) for argument in arguments])
    if origin is np.ndarray:
        return functools.partial(_array, get_args(arguments[1])[0])
    if origin is not None and issubclass(origin, Mapping):
        return functools.partial(_mapping, _decoder(arguments[1], null=null))
    raise TypeError(f"no decoder for {kind!r}")


def _float(value: Any) -> float:  # noqa: ANN401  of JSON
    if isinstance(value, float):
        if math.isfinite(value):
            return value
    elif type(value) is int and abs(value) <= _LARGEST_INTEGER:
        return value
    _refuse(value, "a number")


def _float_if_any(value: Any) -> float | None:  # noqa: ANN401  of JSON
    """Decode a float or null. The usual types are checked first, without a further call."""
    return value if value is None or (type(value) is float and math.isfinite(value)) else _float(value)


def _float_or_null(value: Any) -> float:  # noqa: ANN401  of JSON
    return math.nan if value is None else _float(value)


def _int(value: Any) -> int:  # noqa: ANN401  of JSON
    if type(value) is int:
        return value
    if type(value) is float and value.is_integer():
        return int(value)
    _refuse(value, "a whole number")


def _bool(value: object) -> bool:
    return value if isinstance(value, bool) else _refuse(value, "true or false")


def _str(value: object) -> str:
    return value if isinstance(value, str) else _refuse(value, "a text")


_SCALARS: Mapping[Any, Decoder] = {float: _float, int: _int, bool: _bool, str: _str, Any: lambda value: value}


def _choice(values: tuple[object, ...], value: object) -> object:
    return value if isinstance(value, str) and value in values else _refuse(value, " or ".join(map(str, values)))


def _union(kinds: tuple[Any, ...], *, null: bool) -> Decoder:
    several = [member for member in kinds if member is not type(None)]
    if len(several) == 1:
        inner = _decoder(several[0], null=null)
        if inner is _float:
            return _float_if_any
        return lambda value: None if value is None else inner(value)
    by_tag = {_tag(member): _decoder(member, null=null) for member in several}

    def decode_tagged(value: Any) -> object:  # noqa: ANN401  of JSON
        tag = value.get("kind") if isinstance(value, dict) else None
        return by_tag[tag](value) if tag in by_tag else _refuse(value, f"of a kind {', '.join(by_tag)}")

    return decode_tagged


def _tag(kind: Any) -> str:  # noqa: ANN401  a dataclass
    return str(next(member.default for member in fields(kind) if member.name == "kind"))


def _decode_place(key: str | int, decoder: Decoder, value: object) -> object:
    try:
        return decoder(value)
    except WrongValueError as error:
        error.path.append(key)
        raise


def _items(decoder: Decoder, value: object) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        _refuse(value, "a list")
    return tuple([_decode_place(k, decoder, item) for k, item in enumerate(value)]) if value else ()


def _tuple(decoders: list[Decoder], value: object) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple) or len(value) != len(decoders):
        _refuse(value, f"a list of {len(decoders)}")
    return tuple(
        [_decode_place(k, decoder, item) for k, (decoder, item) in enumerate(zip(decoders, value, strict=True))]
    )


def _mapping(decoder: Decoder, value: object) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        _refuse(value, "an object")
    return {str(key): _decode_place(str(key), decoder, item) for key, item in value.items()}


def _array(kind: type[np.generic], value: object) -> np.ndarray[Any, Any]:
    """Numbers of a list; null is NaN."""
    whole = issubclass(kind, np.integer)
    if not isinstance(value, list | tuple) or not set(map(type, value)) <= _NUMBERS[whole]:
        _refuse(value, "a list of whole numbers" if whole else "a list of numbers")
    try:
        array = np.array(value, dtype=kind)
    except OverflowError:
        _refuse(value, "a list of numbers")
    if not whole and np.isinf(array).any():
        _refuse(value, "a list of finite numbers")
    return array


def _dataclass(kind: Any, *, null: bool) -> Decoder:  # noqa: ANN401  a class
    parts: list[tuple[str, Decoder, bool]] = []

    def decode_fields(value: Any) -> object:  # noqa: ANN401  of JSON
        if type(value) is not dict and not isinstance(value, Mapping):  # `isinstance` with Mapping is slow
            _refuse(value, "an object")
        if not parts:  # made at the first value, because a class may have fields of its own type
            hints = get_type_hints(kind)
            parts.extend(
                (
                    member.name,
                    _decoder(hints[member.name], null=null),
                    member.default is member.default_factory is MISSING,
                )
                for member in fields(kind)
                if member.init
            )
        decoded = {}
        for name, decoder, needed in parts:
            if name in value:
                try:
                    decoded[name] = decoder(value[name])
                except WrongValueError as error:
                    error.path.append(name)
                    raise
            elif needed:
                raise WrongValueError(f"{name} is missing")
        try:
            return kind(**decoded)
        except DataError as error:
            raise WrongValueError(error.message) from None

    return decode_fields
