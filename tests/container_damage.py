"""Damage to binary logs: cuts, an inverted page, random mutations; and checks of a reader with them."""

import math
import os
import random
import re
import resource
import time
from pathlib import Path

import known
from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import read

PAGE = 4096
SECONDS = 30.0  # longest time for one small file: a hang, not a slow machine [s]
MUTANTS = float(os.environ.get("SIGMATAU_MUTANTS", "0.4"))  # factor on the number of mutants; 10 in `make fuzz`
SPACE = 6 << 30  # limit of the further address space, so that excessive allocations fail [bytes]


def mutants(count):
    """Range of mutants, longer in `make fuzz`."""
    return range(math.ceil(count * MUTANTS))


def cut(raw, share):
    return raw[: int(len(raw) * share)]


def flipped(raw, at):
    """Invert the bits of one page."""
    return raw[:at] + bytes(b ^ 0xFF for b in raw[at : at + PAGE]) + raw[at + PAGE :]


def mutated(raw, rng):
    """Change, insert or remove a few bytes, or cut off the end; more often at the beginning, where headers are."""
    data = bytearray(raw)
    for _ in range(rng.choice((1, 1, 2, 4))):
        if not data:
            break
        place = rng.randrange(len(data) if rng.random() < 0.5 else min(len(data), 1024))
        chance = rng.random()
        if chance < 0.5:
            data[place] = rng.choice((0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)))
        elif chance < 0.7:
            data[place : place + 4] = rng.choice((b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\0", b"\0\0\1\0"))
        elif chance < 0.8:
            data[place:place] = rng.randbytes(rng.randrange(1, 9))
        elif chance < 0.9:
            del data[place : place + rng.randrange(1, 9)]
        else:
            del data[place:]
    return bytes(data)


ODD_NUMBERS = (
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1",
    "0",
    "1e-320",
    "1e308",
    "9" * 400,
    "0x7",
    "1_0",
    "true",
    '""',
    "[]",
    "{}",
)


def mutated_text(raw, rng):
    """Change a text: an odd number, a line removed, repeated or moved, a word in another place, or bytes as in `mutated`."""
    if rng.random() < 0.3:
        return mutated(raw, rng)
    for _ in range(rng.choice((1, 1, 2, 3))):
        text = raw.decode("utf-8", "surrogateescape")
        lines = text.splitlines(keepends=True) or [""]
        numbers = list(re.finditer(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text))
        words = list(re.finditer(r"[A-Za-z_]+", text))
        kind = rng.choice(("number", "number", "word", "remove", "repeat", "move"))
        if kind in ("number", "word") and numbers and words:
            match = rng.choice(numbers if kind == "number" else words)
            new = rng.choice(ODD_NUMBERS) if kind == "number" or rng.random() < 0.3 else rng.choice(words)[0]
            text = text[: match.start()] + new + text[match.end() :]
        else:
            place = rng.randrange(len(lines))
            line = lines[place] if kind == "repeat" else lines.pop(place)
            if kind != "remove":
                lines.insert(rng.randrange(len(lines) + 1), line)
            text = "".join(lines)
        raw = text.encode("utf-8", "surrogateescape")
    return raw


def survives(name, raw, path, count, *, place=None, **options):
    """Read `count` mutants: each must give a record or a documented error in time. Returns the number of records.

    `path` is changed; `place` is read, where it is the folder of several files.
    """
    rng = random.Random(known.seed_of(name))
    old = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0]) if Path("/proc/self/statm").exists() else 0
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + SPACE, old[1]))
    good = 0
    try:
        for number in mutants(count):
            path.write_bytes(mutated(raw, rng))
            start = time.perf_counter()
            words = ""
            try:
                good += len(read(place or path, **options).streams) > 0
            except (DataError, OptionError) as error:
                words = str(error)
            assert "does not fit in memory" not in words, number
            assert "\n" not in words, number
            assert time.perf_counter() - start < SECONDS, number
    finally:
        resource.setrlimit(resource.RLIMIT_AS, old)
    return good


def outcomes(rng, logs, path, topics=(None,), count=800):
    """Read mutants of some small logs in turn; return the outcomes: "read", "told" and the names of documented errors."""
    kinds = set()
    begin = time.perf_counter()
    for trial in mutants(count):
        log = bytearray(logs[trial % len(logs)])
        for _ in range(rng.integers(1, 4)):
            place = int(rng.integers(len(log)))
            match rng.integers(4):
                case 0:
                    log[place] ^= 1 << int(rng.integers(8))
                case 1:
                    log[place] = int(rng.integers(256))
                case 2:
                    del log[place : place + int(rng.integers(1, 9))]
                case _:
                    log[place:place] = log[place : place + int(rng.integers(1, 60))]
        path.write_bytes(log)
        try:
            record = read(path, topic=topics[trial % len(topics)])
            kinds.add("told" if record.findings else "read")
        except (DataError, OptionError) as error:
            kinds.add(type(error).__name__)
    assert time.perf_counter() - begin < 100 * max(1, MUTANTS)  # seconds; some 1 are usual
    return kinds
