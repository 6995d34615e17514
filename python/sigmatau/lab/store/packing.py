"""Compact form of a result: curves as packed numbers, and all other content as compressed JSON."""

from __future__ import annotations

import hashlib
import json
import sys
import zlib
from array import array
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings import details_by_code
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen

if TYPE_CHECKING:
    from sqlalchemy.engine import Connection

_LEVEL = 1  # level of zlib; level 6 is 8 % smaller and three times slower
_HEAD = ("schema", "sigmatau", "source")  # keys that may differ between results with equal numbers
_INTEGERS = {"i": "<i4", "q": "<i8"}  # codes of integer types of `array`, the smallest type first
_FLOATS = "<f8"

NUMBERS = np.dtype(
    [
        ("label", "<i4"),  # key of `sigmatau.lab.store.tables.label`
        ("fits", "<i4"),  # whether the model of the channel fits, so that values have intervals
        ("value", "<f8"),  # NaN where the table has NULL
        ("low", "<f8"),
        ("high", "<f8"),
        ("limit", "<f8"),
        ("level", "<f8"),
    ]
)
"""Row of `tables.coefficient` in the array of a run. As arrays, a million rows are read in 0.1 s instead of 2 s."""


@frozen
class Packed:
    """A result as it is stored."""

    content: bytes  # everything except the curves
    # Curves of all channels in order, not compressed, because compression does not shorten numbers; empty if not kept.
    curves: bytes
    digest: str  # checksum of the statements of the result, without the version of the program and the place of the log


def pack(result: Mapping[str, Any]) -> Packed:
    """Convert a result to its stored form."""
    curves, channels = [], {}
    for name, channel in result["channels"].items():
        heads: dict[str, list[Any]] = {}
        rest: dict[str, Any] = {}
        curve = channel["curve"]
        for key, value in curve.items():
            if isinstance(value, list):
                kind, raw = _number_bytes(value)
                heads[key] = [kind, len(value)]
                curves.append(raw)
            else:
                rest[key] = value
        channels[name] = {**channel, "curve": {"arrays": heads, "order": [*curve], "rest": rest}}
    compared = {**result, "channels": channels}
    numbers = b"".join(curves)
    # The version of the program, and the path of a log with a known checksum, are stored but not part of the checksum.
    head = {name: compared.pop(name) for name in _HEAD if name in compared}
    content = _json(compared)[1:]
    source = head.get("source")
    if isinstance(source, Mapping) and source.get("sha256"):
        source = {name: value for name, value in source.items() if name != "path"}
    checksum = hashlib.sha256(_json(source))
    checksum.update(content)
    checksum.update(numbers)
    whole = _json(head)[:-1] + b"," + content
    return Packed(content=zlib.compress(whole, _LEVEL), curves=numbers, digest=checksum.hexdigest())


def _number_bytes(values: list[Any]) -> tuple[str, bytes]:
    """Type and bytes of numbers."""
    if type(values[0] if values else 0) is int:
        for code, kind in _INTEGERS.items():
            with suppress(TypeError, OverflowError):
                return kind, _little_endian(array(code, values))
    try:
        return _FLOATS, _little_endian(array("d", values))
    except TypeError:  # None, because JSON of a result has no NaN
        return _FLOATS, _little_endian(array("d", [np.nan if value is None else value for value in values]))


def _little_endian(values: array[Any]) -> bytes:
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def _json(content: object) -> bytes:
    import orjson

    try:
        return orjson.dumps(content)
    except orjson.JSONEncodeError:  # file names whose bytes are not UTF-8
        return json.dumps(content).encode()


def loads(data: bytes) -> Any:  # noqa: ANN401  anything that JSON has
    """Parse JSON, also with file names whose bytes are not UTF-8. Raises `ValueError`."""
    import orjson

    try:
        return orjson.loads(data)
    except orjson.JSONDecodeError:
        if b"\\ud" not in data:
            raise
        return json.loads(data)


def unpack(content: bytes, curves: bytes) -> dict[str, Any]:
    """Restore a packed result; its curves have no points if they were not kept. Raises `DataError` for damaged content."""
    try:
        result: dict[str, Any] = loads(zlib.decompress(content))
        offset, has_lost_points = 0, False
        for channel in result["channels"].values():
            head = channel["curve"]
            curve = dict(head["rest"])
            for key, (kind, count) in head["arrays"].items():
                if curves:
                    numbers = np.frombuffer(curves, dtype=kind, count=count, offset=offset)
                    curve[key] = _values(numbers)
                    offset += numbers.nbytes
                else:  # not kept
                    curve[key] = []
            channel["curve"] = {key: curve[key] for key in head["order"]}
            has_lost_points |= not curves and any(count for _, count in head["arrays"].values())
        if has_lost_points:
            result["findings"] = [
                *result.get("findings", ()),
                Finding(details=details_by_code()["curves_not_kept"](), severity="info").to_dict(),
            ]
    except (zlib.error, ValueError, KeyError, TypeError, AttributeError) as error:
        raise DataError(f"a result in the store is damaged: {error}") from None
    return result


def _values(numbers: NDArray[Any]) -> list[Any]:
    """Convert to plain numbers. NaN becomes None, because JSON of a result has no NaN."""
    values: list[Any] = numbers.tolist()
    return [None if value != value else value for value in values] if np.isnan(numbers).any() else values


READ = 100
"""Number of results that are read at a time."""


def contents(
    connection: Connection, keys: Sequence[int], *, without_damaged: bool = False
) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield keys of runs with their results. Damaged content raises `DataError`, or is omitted."""
    from sqlalchemy import select

    from sigmatau.errors import DataError
    from sigmatau.lab.store.tables import result

    query = select(result.c.run_id, result.c.content, result.c.curves)
    for start in range(0, len(keys), READ):
        for key, content, curves in connection.execute(query.where(result.c.run_id.in_(keys[start : start + READ]))):
            try:
                result_as_added = unpack(content, curves)
            except DataError:
                if without_damaged:
                    continue
                raise
            yield key, result_as_added
