"""`frozen`: a decorator for dataclasses that are frozen and have slots, at a tenth of the standard library's cost.

`dataclasses` compiles six methods of each class on import, 0.8 ms a class in Python 3.11; for hundreds of classes that was a
fifth of the start-up of the program. Here the classes share five of them, and ``__init__`` is compiled on first use.
`fields`, `replace`, `asdict`, pickling and pattern matching work as usual.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import MISSING, FrozenInstanceError, dataclass, field, fields
from typing import Any, TypeVar, cast, dataclass_transform, overload

_T = TypeVar("_T")


@overload
def frozen(cls: type[_T], /) -> type[_T]: ...


@overload
def frozen(*, kw_only: bool = True, eq: bool = True) -> Callable[[type[_T]], type[_T]]: ...


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
def frozen(
    cls: type[_T] | None = None, /, *, kw_only: bool = True, eq: bool = True
) -> type[_T] | Callable[[type[_T]], type[_T]]:
    """``dataclass(frozen=True, slots=True, kw_only=True)``; its bases must be made by this decorator too."""
    if cls is None:
        return functools.partial(_make_dataclass, kw_only=kw_only, eq=eq)
    return _make_dataclass(cls, kw_only=kw_only, eq=eq)


def _make_dataclass(cls: type[_T], *, kw_only: bool, eq: bool) -> type[_T]:
    attributes = set(cls.__dict__)
    made = dataclass(init=False, repr=False, eq=False, slots=True, kw_only=kw_only)(cls)
    shared: dict[str, object] = {
        "__init__": _Init(made),
        "__repr__": _repr,
        "__setattr__": _refuse_setting,
        "__delattr__": _refuse_deleting,
        "__getstate__": _get_state,
        "__setstate__": _set_state,
    }
    if eq and "__eq__" not in attributes:
        shared |= {"__eq__": _eq, "__hash__": _hash}
    for name, method in shared.items():
        if name not in attributes:
            setattr(made, name, method)
    return made


class _Init:
    """Placeholder for the ``__init__`` of a class; on first use it compiles the method and replaces itself."""

    def __init__(self, cls: type) -> None:
        self._cls = cls

    def __get__(self, instance: object, owner: type) -> Callable[..., None]:
        method = _initializer(self._cls)
        cast(Any, self._cls).__init__ = method
        return cast(Callable[..., None], method if instance is None else method.__get__(instance, owner))


class _Default:
    """Default of an argument whose value is made anew for each instance, as `inspect.signature` shows it."""

    def __repr__(self) -> str:
        return "<factory>"


_DEFAULT = _Default()


def _initializer(cls: Any) -> Any:  # noqa: ANN401  a class, and a function of its own signature
    """``__init__`` of a class, as `dataclasses` writes it."""
    scope: dict[str, Any] = {"_put": object.__setattr__, "_DEFAULT": _DEFAULT}
    positional, keyword, body = ["self"], ["*"], []
    for each in fields(cls):
        name, default = each.name, f"_default_{each.name}"
        argument, value = name, name
        if each.default is not MISSING:
            scope[default] = each.default
            argument, made = f"{name}={default}", default
        elif each.default_factory is not MISSING:
            scope[default] = each.default_factory
            argument, made = f"{name}=_DEFAULT", f"{default}()"
            value = f"{made} if {name} is _DEFAULT else {name}"
        elif not each.init:  # for ``__post_init__``
            continue
        if each.init:
            (keyword if each.kw_only else positional).append(argument)
        body.append(f"_put(self, {name!r}, {value if each.init else made})")
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    arguments = ", ".join([*positional, *(keyword if len(keyword) > 1 else ())])
    exec(f"def __init__({arguments}):\n " + ("; ".join(body) or "pass"), scope)
    method = scope["__init__"]
    method.__qualname__, method.__module__ = f"{cls.__qualname__}.__init__", cls.__module__
    method.__annotations__ = {each.name: each.type for each in fields(cls) if each.init} | {"return": None}
    return method


def _repr(self: Any) -> str:  # noqa: ANN401  any instance
    shown = (f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
    return f"{type(self).__qualname__}({', '.join(shown)})"


@functools.cache
def _compared_names(cls: Any) -> tuple[str, ...]:  # noqa: ANN401  any class
    return tuple(each.name for each in fields(cls) if each.compare)


def _compared(instance: object) -> tuple[object, ...]:
    return tuple([getattr(instance, name) for name in _compared_names(cast(Any, type(instance)))])


def _eq(self: object, other: object) -> bool:
    return _compared(self) == _compared(other) if type(self) is type(other) else NotImplemented


def _hash(self: object) -> int:
    return hash(_compared(self))


def _refuse_setting(self: object, name: str, value: object) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _refuse_deleting(self: object, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _get_state(self: Any) -> list[object]:  # noqa: ANN401  any instance
    return [getattr(self, each.name) for each in fields(self)]


def _set_state(self: Any, state: list[object]) -> None:  # noqa: ANN401  any instance
    for each, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, each.name, value)
