"""Small results of `sigmatau analyze`."""

import functools
import json

import numpy as np

import sigmatau as st
from sigmatau.analysis.reading import result_of_dict
from sigmatau.lab.store.rows import Entry


@functools.cache
def _made(seed: int) -> str:
    rng = np.random.default_rng([seed, 23])
    rates = 1e-3 * rng.standard_normal((4000, 3))
    record = st.Record.from_arrays(rate=100, gyro=rates, unit={"gyro": "rad/s"})
    return json.dumps(st.analyze(record).to_dict())


def result(seed: int = 0, *, log: str = "", path: str = "day1.csv") -> dict:
    """A result of three gyros; `log` replaces the bytes of the log."""
    made = json.loads(_made(seed % 5))
    made["source"] |= {"path": path, "sha256": f"{hash_of(log or str(seed))}"}
    return made


def hash_of(text: str) -> str:
    import hashlib

    return hashlib.sha256(text.encode()).hexdigest()


def entry_of(content: dict, **names) -> Entry:
    """The entry of a result in its JSON form, as if read from a file."""
    return Entry(result=result_of_dict(content), content=content, **names)
