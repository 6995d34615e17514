"""Comparison of the results of two checkouts of the package: the JSON of `analyze` for simulated logs and real records.

    git switch --detach BEFORE && make build && python -m benches.same_results /tmp/before
    git switch AFTER && make build && python -m benches.same_results /tmp/after --base /tmp/before

A folder has one JSON file per case; existing files are reused, so that an interrupted run continues. A case that takes
longer than `--seconds` is omitted, also in the comparison. Numbers are compared to 1e-12, findings by code, channels,
size, spans and details, and all other values except words, which are strings with a space. Differences are printed; the
exit code is then 1. New fields are counted separately. Arguments after the folder select cases whose name contains one of
them.
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
import os
import re
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from studies.real_records import RECORDS

import sigmatau as st
from sigmatau import Record
from sigmatau.analysis import Analysis

DATA = Path(os.environ.get("SIGMATAU_FIELD_DATA", Path(__file__).parents[2] / "shared" / "data"))
NOT_LOGS = {".md", ".py", ".json", ".yaml", ".toml", ".sh", ".db.gz"}
ATTEMPTS: tuple[dict[str, Any], ...] = (
    {},
    {"rate": 100, "unit": {"gyro": "deg/s", "accel": "g"}},
    {"rate": 100, "unit": {"gyro": "deg/s", "accel": "g"}, "channels": {"gyro": "1:3", "accel": "4:6"}},
    {"rate": 1, "channels": {"x": "1"}, "unit": {"x": 1}},
)
"""Options that are tried until a log can be read."""
TOLERANCE = 1e-12
_ADDED = ": only after"  # a field that the earlier version did not write does not count as a difference
SHOWN = 12
"""Number of printed differences per case."""

Case = Callable[[], Analysis]
Floats = np.ndarray[Any, np.dtype[np.float64]]
Change = Callable[[Floats, np.random.Generator], Floats]
"""Change of the samples of a log, shape (n, 6)."""


def spiked(x: Floats, rng: np.random.Generator) -> Floats:
    x[rng.integers(0, len(x), 12)] += 50 * x.std(axis=0)
    return x


def knocked(x: Floats, rng: np.random.Generator) -> Floats:
    start = len(x) // 3
    x[start : start + 40] += 30 * x.std() * rng.standard_normal((40, x.shape[1]))
    return x


def stuck(x: Floats, rng: np.random.Generator) -> Floats:
    x[len(x) // 2 : len(x) // 2 + 150] = x[len(x) // 2]
    return x


def gapped(x: Floats, rng: np.random.Generator) -> Floats:
    x[rng.random(len(x)) < 0.03] = np.nan
    x[len(x) // 4 : len(x) // 4 + 200] = np.nan
    return x


def with_line(x: Floats, rng: np.random.Generator) -> Floats:
    x += 2 * x.std(axis=0) * np.sin(2 * np.pi * 0.0713 * np.arange(len(x)))[:, None]
    return x


def with_drift(x: Floats, rng: np.random.Generator) -> Floats:
    x += 3 * x.std(axis=0) * (np.arange(len(x)) / len(x))[:, None]
    return x


def with_step(x: Floats, rng: np.random.Generator) -> Floats:
    x[len(x) // 2 :, 0] += 2 * x[:, 0].std()
    return x


def warming(x: Floats, rng: np.random.Generator) -> Floats:
    x += 4 * x.std(axis=0) * np.exp(-8 * np.arange(len(x)) / len(x))[:, None]
    return x


def rounded(x: Floats, rng: np.random.Generator) -> Floats:
    step = 1.5 * x.std(axis=0)
    return np.asarray(np.round(x / step) * step)


def constant(x: Floats, rng: np.random.Generator) -> Floats:
    x[:, 1] = 0.25
    return x


def repeated(x: Floats, rng: np.random.Generator) -> Floats:
    return x[np.arange(len(x)) // 2]


def smoothed(x: Floats, rng: np.random.Generator) -> Floats:
    return np.asarray(sum(np.roll(x, k, axis=0) for k in range(4)) / 4)


def clipped(x: Floats, rng: np.random.Generator) -> Floats:
    limit = 2.2 * x.std(axis=0)
    return np.asarray(np.clip(x, -limit, limit))


def turning(x: Floats, rng: np.random.Generator) -> Floats:
    x[len(x) // 2 :, 2] += 0.7 * np.sin(np.arange(len(x) - len(x) // 2) / 37)
    return x


def bursts(x: Floats, rng: np.random.Generator) -> Floats:
    x[:, 3] *= np.where(np.arange(len(x)) % 4000 < 1500, 4, 1)
    return x


def unchanged(x: Floats, rng: np.random.Generator) -> Floats:
    return x


CHANGES: tuple[Change, ...] = (
    *(
        unchanged,
        spiked,
        knocked,
        stuck,
        gapped,
        with_line,
        with_drift,
        with_step,
        warming,
        rounded,
        constant,
        repeated,
    ),
    *(smoothed, clipped, turning, bursts),
)
LENGTHS = ((100, 600), (20, 900), (400, 60))
"""Rates and lengths of the logs. [Hz], [s]"""
OPTIONS: dict[str, dict[str, Any]] = {
    "gls": {"method": "gls"},
    "gls_tau_min": {"method": "gls", "tau_min": 0.5, "terms": ("random_walk", "bias_instability")},
    "read_off": {"method": "read-off", "read_off_at": {"random_walk": (0.5, 5)}},
    "window": {"window": "100s:400s"},
    "most_stable": {"window": "most-stable=200s"},
    "leave_out": {"leave_out": "50s:60s,120s:121s"},
    "keep": {"keep": "all"},
    "strided": {"long": "strided"},
    "octave": {"taus": "octave", "overlap": "none"},
    "stability": {"stability": True},
    "at_rest": {"at_rest": True},
    "terms": {"terms": ("random_walk", "rate_random_walk")},
}
NOISE = {
    "gyro": {"quantization": 2e-6, "random_walk": 1e-4, "bias_instability": 2e-5, "rate_random_walk": 1e-6},
    "accel": {"random_walk": 1e-3, "bias_instability": 3e-4},
}


def log(rate: float, seconds: float, change: Change, seed: int) -> Record:
    """A simulated log of six axes, with a change of its samples."""
    model = st.NoiseModel(channels={f"{sensor}_{axis}": NOISE[sensor] for sensor in NOISE for axis in "xyz"})
    record = st.simulate(model, duration=seconds, rate=rate, rng=seed)
    columns = [stream.column(name) for stream in record.streams for name in stream.channels]
    x = change(np.array(np.column_stack(columns)), np.random.default_rng(seed))
    return Record.from_arrays(rate=rate, gyro=x[:, :3], accel=x[:, 3:])


def analyse_log(rate: float, seconds: float, change: Change, seed: int, options: dict[str, Any]) -> Analysis:
    return st.analyze(log(rate, seconds, change, seed), **options)


def simulated() -> Iterator[tuple[str, Case]]:
    for i, change in enumerate(CHANGES):
        for k, (rate, seconds) in enumerate(LENGTHS):
            yield f"simulated_{change.__name__}_{rate}_hz", partial(analyse_log, rate, seconds, change, 100 * i + k, {})
    for name, options in OPTIONS.items():
        yield f"simulated_option_{name}", partial(analyse_log, 100, 600, with_line, 7, options)
        yield f"simulated_option_{name}_spiked", partial(analyse_log, 100, 600, spiked, 8, options)


def analyse_file(path: Path, attempts: tuple[dict[str, Any], ...]) -> Analysis:
    *first_attempts, last = attempts
    for stated in first_attempts:
        with suppress(st.OptionError):
            return st.analyze(st.read(path, **stated))
    return st.analyze(st.read(path, **last))


def recorded() -> Iterator[tuple[str, Case]]:
    for path in sorted(DATA.rglob("*")):
        name = path.relative_to(DATA).as_posix()
        if path.is_file() and not name.endswith(tuple(NOT_LOGS)):
            yield name.replace("/", "_"), partial(analyse_file, path, (RECORDS[name],) if name in RECORDS else ATTEMPTS)


def result(case: Case) -> dict[str, Any]:
    """JSON form of a case; for an error of the log or of an option, its class."""
    try:
        return dict(case().to_dict())
    except (st.DataError, st.OptionError) as error:
        return {"error": type(error).__name__, "message": str(error)}


def make(folder: Path, chosen: list[str], seconds: int) -> None:
    """Write the missing results, each in a separate process with a time limit."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, case in [*simulated(), *recorded()]:
        file = folder / f"{name}.json.gz"
        if file.exists() or (chosen and not any(part in name for part in chosen)):
            continue
        child = os.fork()
        if child == 0:
            signal.alarm(seconds)
            text = json.dumps(result(case))
            part_file = file.with_suffix(".part")
            part_file.write_bytes(gzip.compress(text.encode(), mtime=0))
            part_file.rename(file)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status:
            sys.stderr.write(f"same_results: {name} is left out: {'time' if os.WIFSIGNALED(status) else 'it failed'}\n")


def differences(a: Any, b: Any, place: str = "") -> Iterator[str]:
    """Differences between two JSON values, except words."""
    if isinstance(a, dict) and isinstance(b, dict):
        if not place:
            a, b = ({key: value for key, value in content.items() if key != "sigmatau"} for content in (a, b))
        if place == ".source":
            a, b = ({key: value for key, value in content.items() if key != "path"} for content in (a, b))
        for key in dict.fromkeys([*a, *b]):
            if key in a and key in b:
                yield from differences(a[key], b[key], f"{place}.{key}")
            else:
                yield f"{place}.{key}{': only before' if key in a else _ADDED}"
    elif isinstance(a, list) and isinstance(b, list):
        if place == ".findings":
            a, b = (sorted(findings, key=_finding_key) for findings in (a, b))
            if [_finding_key(f) for f in a] != [_finding_key(f) for f in b]:
                yield from _compare_findings(a, b)
                return
        if len(a) != len(b):
            yield f"{place}: {len(a)} entries, now {len(b)}"
            return
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from differences(x, y, f"{place}[{k}]")
    elif (
        isinstance(a, str) and isinstance(b, str) and (" " in a or " " in b or place.endswith((".action", ".message")))
    ):
        return
    elif _is_number(a) and _is_number(b):
        if abs(a - b) > TOLERANCE * max(abs(a), abs(b)):
            yield f"{place}: {a!r}, now {b!r} (relative {(b - a) / max(abs(a), abs(b)):.2g})"
    elif a != b:
        yield f"{place}: {a!r}, now {b!r}"


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _finding_key(finding: dict[str, Any]) -> str:
    return json.dumps([finding["code"], finding["channels"], finding.get("topic", "")])


def _compare_findings(a: list[dict[str, Any]], b: list[dict[str, Any]]) -> Iterator[str]:
    before, after = [_finding_key(finding) for finding in a], [_finding_key(finding) for finding in b]
    for key in dict.fromkeys([*before, *after]):
        if before.count(key) != after.count(key):
            yield f".findings: {key} {before.count(key)} times, now {after.count(key)}"


def compare(folder: Path, base: Path, chosen: list[str]) -> int:
    """Print the differences; return the number of cases that differ."""
    different = equal = same_bytes = 0
    added: Counter[str] = Counter()
    for file in sorted(base.glob("*.json.gz")):
        if (chosen and not any(part in file.name for part in chosen)) or not (folder / file.name).exists():
            continue
        before, after = (json.loads(gzip.decompress((place / file.name).read_bytes())) for place in (base, folder))
        lines = list(differences(before, after))
        added.update(re.sub(r"channels\.\w+|\[\d+\]", "*", line) for line in lines if line.endswith(_ADDED))
        if lines := [line for line in lines if not line.endswith(_ADDED)]:
            different += 1
            print(f"{file.name.removesuffix('.json.gz')}: {len(lines)} differences", *lines[:SHOWN], sep="\n    ")
        else:
            equal += 1
            before["sigmatau"] = after["sigmatau"] = ""
            same_bytes += before == after
    for line, count in added.most_common():
        print(f"{count} times {line}")
    print(f"{equal} cases are equal, {same_bytes} of them to the bit and the word; {different} differ")
    return different


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path, help="where the results of this checkout are, or are written")
    parser.add_argument("cases", nargs="*", help="only cases whose name contains one of these")
    parser.add_argument("--base", type=Path, help="folder of the earlier checkout's results")
    parser.add_argument("--seconds", type=int, default=60, help="limit of a case (default 60)")
    stated = parser.parse_args()
    make(stated.folder, stated.cases, stated.seconds)
    return 1 if stated.base and compare(stated.folder, stated.base, stated.cases) else 0


if __name__ == "__main__":
    sys.exit(main())
