"""MCAP files: ROS 2 messages in CDR, or ROS 1 messages, decoded by compiled code."""

from __future__ import annotations

from pathlib import Path

from sigmatau.errors import DataError
from sigmatau.io.read import roslog
from sigmatau.io.read.table import Head, Table

__all__ = ["read", "sniff"]

_MAGIC = b"\x89MCAP"


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file begins as MCAP files do."""
    return head.startswith(_MAGIC)


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """A table for each topic: the numbers of its messages by the paths of their fields, stamps in nanoseconds.

    Parameters
    ----------
    path : Path
    head : Head

    Raises
    ------
    DataError
        If no topic can be read.
    """
    if head.gzip:
        raise DataError("is an MCAP file compressed by gzip; decompress it first")
    return roslog.tables_of(path, "mcap")
