"""Kinds of findings about files: damage, leftovers, columns, units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = ["BrokenOff", "Damage", "Damaged", "InFile", "Place"]


@dataclass(frozen=True, slots=True)
class Place:
    """A place in a file.

    Attributes
    ----------
    unit : str
        What is counted: ``"byte"``, ``"line"``, ``"row"``, ``"message"``, ``"batch"``, ``"row group"`` or ``"segment"``.
        Bytes and rows count from 0, the others from 1.
    number : int
    of : int or None
        How many of them the file has.
    byte : int or None
        Where the unit begins. [bytes]
    """

    unit: str
    number: int
    of: int | None = None
    byte: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class InFile(Details):
    """Base of findings about a file.

    Attributes
    ----------
    part : str
        Name of the file, if the log is split into several.
    """

    part: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage(InFile):
    """Base of findings about damage after which the file is not read further.

    Attributes
    ----------
    what : str
        What is damaged: ``"file"``, ``"array"``, ``"variable acc"`` …
    place : Place or None
    inside : str
        What the place lies in: ``"message"``, ``"line"``, ``"row"``, ``"number"``; empty if that is not known.
    reason : str
        The fault, as the decoder or a library calls it; may be empty.
    got, expected : int or None
        How many of the bytes, rows or samples are there, and how many should be.
    measured : str
        What `got` and `expected` count.
    kept : int or None
        How many rows or messages are read.
    declared : int or None
        How many the file declares.
    counted : str
        What `kept` and `declared` count.
    topic : str
    """

    what: str = "file"
    place: Place | None = None
    inside: str = ""
    reason: str = ""
    got: int | None = None
    expected: int | None = None
    measured: str = "bytes"
    kept: int | None = None
    declared: int | None = None
    counted: str = "rows"
    topic: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Damaged(Damage):
    """A file that is damaged at a place, and is read up to it."""

    code: ClassVar[str] = "damaged"


@dataclass(frozen=True, slots=True, kw_only=True)
class BrokenOff(Damage):
    """A file that ends too early."""

    code: ClassVar[str] = "broken_off"
