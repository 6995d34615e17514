"""Facts about a stream, each computed once and used by every check.

A fact is a function of a stream, or of one of its channels, that several checks need: the spikes, the resolution, the
periodogram, the stream without held values. Within `keep_facts` each fact is computed once for the same samples, even if
they are in different stream objects. Outside it, a fact is an ordinary function.
"""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from typing import Any, TypeVar, cast

from sigmatau.record.on_disk import FileColumn
from sigmatau.record.streams import Stream

T = TypeVar("T")

_FACTS: ContextVar[dict[Hashable, tuple[object, object]] | None] = ContextVar("facts", default=None)


@contextmanager
def keep_facts() -> Iterator[None]:
    """Keep the facts of all streams until the end of the block, or of an outer block of this kind."""
    if _FACTS.get() is not None:
        yield
        return
    token = _FACTS.set({})
    try:
        yield
    finally:
        _FACTS.reset(token)


def forget(stream: Stream) -> None:
    """Drop the facts of a stream that is no longer needed; they keep its samples in memory."""
    facts, arrays = _FACTS.get(), set(map(id, stream.samples.raw))
    for key, (stream_of_fact, _) in list((facts or {}).items()):
        if facts is not None and not arrays.isdisjoint(map(id, cast("Stream", stream_of_fact).samples.raw)):
            facts.pop(key, None)


def in_threads(function: Callable[[str], T], names: Sequence[str], threads: int | None = None) -> dict[str, T]:
    """Compute results by name in parallel, with shared facts. If several fail, the error of the first name is raised.

    The kernels and the larger NumPy operations release the interpreter's lock.
    """
    workers = min(len(names), threads or os.cpu_count() or 1)
    if workers < 2:
        return {name: function(name) for name in names}
    waiting, results, errors = iter(names), dict[str, T](), dict[str, BaseException]()

    def work() -> None:
        for name in waiting:
            try:
                results[name] = function(name)
            except BaseException as error:
                errors[name] = error

    workers_started = [threading.Thread(target=copy_context().run, args=(work,)) for _ in range(workers - 1)]
    with suppress(RuntimeError):  # without memory for another thread, the existing threads continue
        for thread in workers_started:
            thread.start()
    work()
    for thread in workers_started:
        if thread.ident is not None:
            thread.join()
    for name in names:
        if isinstance(errors.get(name), MemoryError):  # there may be enough memory without the other threads
            results[name] = function(name)
        elif name in errors:
            raise errors[name]
    return {name: results[name] for name in names}


def stream_fact(function: Callable[[Stream], T]) -> Callable[[Stream], T]:
    """Make a function of a stream a fact, shared by all its channels."""

    @functools.wraps(function)
    def fact(stream: Stream) -> T:
        channels = tuple(_channel_key(stream, channel) for channel in stream.channels)
        return _remember(lambda: function(stream), stream, (function, stream.name, stream.channels, channels))

    return fact


def channel_fact(function: Callable[[Stream, str], T]) -> Callable[[Stream, str], T]:
    """Make a function of one channel of a stream a fact."""

    @functools.wraps(function)
    def fact(stream: Stream, channel: str) -> T:
        key = function, channel, _channel_key(stream, channel)
        return _remember(lambda: function(stream, channel), stream, key)

    return fact


def _remember(compute: Callable[[], T], stream: Stream, key: Hashable) -> T:
    facts = _FACTS.get()
    if facts is None:
        return compute()
    if key not in facts:
        # the entry includes the stream, so that the addresses in the key are not reused
        facts[key] = stream, compute()
    return cast("T", facts[key][1])


def _channel_key(stream: Stream, channel: str) -> Hashable:
    """Key of the samples of a channel: the addresses of their arrays, and how they are read."""
    k = stream.channels.index(channel)
    raw, missing = stream.samples.raw[k], stream.samples.missing
    grid, transform = stream.grid, stream.samples.transforms[k]
    return (
        (*_address(raw), raw.dtype.str),
        (transform.scale, transform.offset, transform.factor, transform.kind),
        stream.quantity,
        stream.unit,
        (grid.n, grid.tau0, grid.start, grid.source.kind, grid.source.confirmed, grid.jitter, grid.lead),
        None if missing is None else _address(missing[:, k]),
        None if stream.mask is None else _address(stream.mask[:, k]),
    )


def _address(array: Any) -> tuple[object, ...]:  # noqa: ANN401
    if isinstance(array, FileColumn):
        return array.key
    return array.__array_interface__["data"][0], array.shape, array.strides
