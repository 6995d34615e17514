"""`frozen` against `dataclasses.dataclass(frozen=True, slots=True)`, whose cheaper twin it is."""

import copy
import inspect
import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, is_dataclass, replace
from typing import Any

import pytest

from sigmatau.frozen import frozen


def described(decorator: Any) -> type:
    @decorator
    class Sample:
        """All kinds of fields."""

        first: int
        second: str = "two"
        third: list[int] = field(default_factory=list)
        hidden: float = field(default=1.5, repr=False, compare=False)
        kind: str = field(default="fixed", init=False)
        double: int = field(init=False)

        def __post_init__(self) -> None:
            object.__setattr__(self, "double", 2 * self.first)

    return Sample


@frozen
class Base:
    """A base."""

    a: int = 1


@frozen
class Derived(Base):
    """A class with a base."""

    b: tuple[int, ...]

    def __repr__(self) -> str:
        return "own"


@frozen(kw_only=False)
class Pair:
    """With positional arguments."""

    x: float
    y: float = 2.0


@frozen(eq=False)
class Unequal:
    """Compared by identity."""

    x: float


@pytest.mark.parametrize("kw_only", [True, False])
def test_behaves_as_a_frozen_dataclass(kw_only):
    ours = described(frozen(kw_only=kw_only))
    theirs = described(dataclass(frozen=True, slots=True, kw_only=kw_only))
    assert is_dataclass(ours)
    parameters = [inspect.signature(cls).parameters.values() for cls in (ours, theirs)]
    of = [[(one.name, one.kind, repr(one.default), one.annotation) for one in each] for each in parameters]
    assert of[0] == of[1]
    assert [f.name for f in fields(ours)] == [f.name for f in fields(theirs)]
    mine, other = ours(first=3, third=[1]), theirs(first=3, third=[1])
    assert repr(mine) == repr(other)
    assert asdict(mine) == asdict(other)
    assert mine.double == 6
    assert replace(mine, first=4).double == 8
    assert mine == ours(first=3, third=[1], hidden=7.0)
    assert mine != ours(first=4, third=[1])
    assert mine != other
    assert ours(first=1).third is not ours(first=1).third
    assert ours.__match_args__ == theirs.__match_args__
    for cls in (ours, theirs):
        for wrong in ({}, {"first": 1, "kind": "x"}, {"first": 1, "fourth": 2}):
            with pytest.raises(TypeError):
                cls(**wrong)
    assert not hasattr(mine, "__dict__")


def test_is_frozen():
    pair = Pair(1.0)
    for name in ("x", "z"):
        with pytest.raises(FrozenInstanceError, match=name):
            setattr(pair, name, 2.0)
    with pytest.raises(FrozenInstanceError, match="x"):
        del pair.x
    assert pair == Pair(1.0, 2.0)


def test_equality_and_hash():
    assert len({Pair(1.0), Pair(1, 2), Pair(2.0)}) == 2
    assert Unequal(x=1.0) != Unequal(x=1.0)
    assert len({Unequal(x=1.0), Unequal(x=1.0)}) == 2
    assert Base(a=1) != Derived(a=1, b=())


def test_inheritance_pickling_and_copies():
    one = Derived(b=(1, 2))
    assert (one.a, one.b, repr(one)) == (1, (1, 2), "own")
    for again in (pickle.loads(pickle.dumps(one)), copy.copy(one), copy.deepcopy(one)):
        assert again == one
        assert again is not one


def test_the_initializer_is_made_on_first_use():
    kind = "type(NoMap.__dict__['__init__']).__name__"
    code = f"from sigmatau.findings.curves import NoMap; before = {kind}; NoMap(samples=1, needed=2)"
    code += f"; print(before, {kind})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["_Init", "function"]
