"""``make bench-io``: time to read a two-hour log in each format, and content that is read from a damaged log.

``python -m benches.formats`` writes docs/formats.md. ``python -m benches.formats PATH OPTIONS`` reads one log.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benches import text
from benches.logs import CHANNELS, KINDS, Kind, Values, made
from benches.measure import status_bytes
from sigmatau import Record, read
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import damaged

ROOT = Path(__file__).parent.parent
PAGE = 4096
FLIPS, FLIPPED = 10, "a page flipped"
LONG, SHORT = 1_440_000, 20_000
AIMS = {"MCAP, zstd": 1.0, "CSV": 0.5, "PX4 ULog": 2.5, "ROS 1 bag, lz4": 12.0}  # [s]


@dataclass(frozen=True)
class Outcome:
    """Content that is read from a damaged log.

    `code`: exit code of `sigmatau analyze`; `right`: whether all rows that were read are rows of the log, in its order.
    """

    code: int
    rows: int = 0
    finding: str = ""
    right: bool = True


def outcome(path: Path, kind: Kind, values: Values) -> Outcome:
    """Read a log that may lack data, and compare it with the written data."""
    try:
        record = read(path, **kind.options)
    except OptionError:
        return Outcome(2, finding="asks for what is lost")
    except DataError:
        return Outcome(1, finding="refused")
    present = [k for k, channel in enumerate(CHANNELS) if channel in record.channels]
    rows = np.stack([record.stream_of(CHANNELS[k]).column(CHANNELS[k]) for k in present], axis=1)
    # Whole rows are compared, because single numbers occur twice.
    where = {tuple(row): k for k, row in enumerate(values[:, present].tolist())}
    positions = np.array([where.get(tuple(row), -1) for row in rows.tolist()])
    right = bool(
        (np.diff(positions) > 0).all()
        and (positions >= 0).all()
        and np.array_equal(rows, values[positions][:, present])
    )
    worst = [f.code for f in record.findings if f.severity == "error"]
    return Outcome(damaged(record.findings), len(rows), ", ".join(dict.fromkeys(worst)), right)


def _place_of_cut(data: bytes, share: int) -> int:
    """Place where a file is cut. A cut at the end of a message or of the last number of a line cannot be detected;
    therefore a text is cut in the first number of a line.
    """
    place = len(data) * share // 100 // 64 * 64 + 13
    line = data.rfind(b"\n", 0, place) + 1
    is_text = (
        line > 0 and data[line:place].isascii() and data[line:place].translate(None, b"\r\t").decode().isprintable()
    )
    return line + 13 if is_text else place


def damages(path: Path, flips: int = FLIPS) -> dict[str, bytes]:
    """Damaged copies of a file: cut off, or with all bits of a page inverted, at evenly spread places."""
    data = path.read_bytes()
    copies = {f"cut at {share} %": data[: _place_of_cut(data, share)] for share in (10, 50, 99)}
    for k in range(flips):
        place = len(data) * (2 * k + 1) // (2 * flips) // PAGE * PAGE
        flipped = bytes(byte ^ 0xFF for byte in data[place : place + PAGE])
        copies[f"{FLIPPED}, {k + 1}"] = data[:place] + flipped + data[place + PAGE :]
    return copies


def damage_outcomes(kind: Kind, folder: Path, n: int = SHORT, flips: int = FLIPS) -> dict[str, Outcome]:
    """Content of a log of `n` rows after each kind of damage."""
    stamps, values = made(n)
    path = kind.make(folder, stamps, values)
    outcomes = {}
    for name, data in damages(path, flips).items():
        path.write_bytes(data)
        outcomes[name] = outcome(path, kind, values)
    return outcomes


def _read_log(path: str, options: dict[str, Any]) -> None:
    # The peak that the system reports is at least that of the parent process.
    Path("/proc/self/clear_refs").write_text("5")
    before = status_bytes("VmHWM")
    start = time.perf_counter()
    record: Record = read(path, **options)
    seconds = time.perf_counter() - start
    grown = status_bytes("VmHWM") - before
    sums = [float(record.stream_of(c).column(c).sum()) for c in CHANNELS]
    print(json.dumps({"seconds": seconds, "grown": grown, "rows": record.provenance.rows, "sums": sums}))


def measure(name: str, n: int, rounds: int) -> dict[str, Any]:
    """Median time and memory of processes that read a long log; the values must equal the written ones."""
    kind = KINDS[name]
    stamps, values = made(min(n, kind.longest or n))
    with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
        path = kind.make(Path(folder), stamps, values)
        record = read(path, **kind.options)
        for k, channel in enumerate(CHANNELS):
            np.testing.assert_array_equal(record.stream_of(channel).column(channel), values[:, k], err_msg=name)
        del record
        command = [sys.executable, "-m", "benches.formats", str(path), json.dumps(dict(kind.options))]
        runs = []
        for _ in range(rounds):
            output = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout
            runs.append(json.loads(output))
        return {
            "bytes": path.stat().st_size,
            "seconds": statistics.median(run["seconds"] for run in runs),
            "grown": statistics.median(run["grown"] for run in runs),
        }


def _option(name: str) -> str:
    return {"unit": "units", "channels": "columns"}.get(name, f"the {name}")


def _outcome_words(outcomes: list[Outcome]) -> str:
    """Describe the outcomes for logs: rows read, findings, exit codes."""
    rows = sorted(o.rows for o in outcomes if o.code not in (1, 2))
    count = "" if not rows else f"{rows[0]} rows" if rows[0] == rows[-1] else f"{rows[0]} to {rows[-1]} rows"
    wrong = sum(not o.right for o in outcomes)
    some = "" if not wrong else "some wrong" if len(outcomes) == 1 else f"some wrong at {wrong}"
    words = ", ".join(filter(None, [count, *dict.fromkeys(o.finding for o in outcomes), some]))
    return f"{words} ({', '.join(map(str, sorted({o.code for o in outcomes})))})"


def page(times: dict[str, dict[str, Any]], damaged: dict[str, dict[str, Outcome]], n: int, machine: str) -> str:
    """The page as text."""
    rows = []
    for name, measured in times.items():
        aim = f" (target ≤ {AIMS[name]:g} s)" if name in AIMS else ""
        streams = "yes" if KINDS[name].streams else "no"
        rows.append(
            [
                name
                if KINDS[name].longest is None
                else f"{name}, {text.number(min(n, KINDS[name].longest or n))} rows",
                text.size(measured["bytes"]),
                "automatically" if not KINDS[name].options else "with " + ", ".join(map(_option, KINDS[name].options)),
                streams,
                f"**{text.seconds(measured['seconds'])}**{aim}",
                text.size(measured["grown"]),
            ]
        )
    lines = [
        "# Formats",
        "",
        *text.prose(
            f"Made by `make bench-io` on {machine}. Logs of {text.number(n)} rows, two hours at 200 Hz: time stamps,",
            "three gyro axes and three accelerometer axes. The files are written by libraries of other programs, or by the",
            "published layouts. All values are read exactly. Time and memory (growth of the process) are from",
            "file to record,",
            "medians, with the files in the system's cache. A streamed format is read in pieces, and only the",
            "needed columns are",
            'kept in memory. "With" names the options that the format needs. The commands are in',
            "[how-to/formats.md](how-to/formats.md).",
        ),
        *text.table(["format", "file", "opened", "streamed", "time", "memory"], rows),
        *text.prose(
            "Read too, and not in the tables: Zarr stores (a folder of one file a chunk, opened automatically and",
            "streamed; a missing chunk is a gap, with exit code 4, and a damaged one is refused), NovAtel RAWIMU",
            "logs (with `--input increments`, and `--scale` unless the log names the sensor), `.gcsv` of Gyroflow (a CSV",
            "with three scales in its head), and zip archives of text tables or NumPy arrays.",
        ),
        "## Damaged logs",
        "",
        *text.prose(
            f"{text.number(SHORT)} rows. The file is truncated, or all bits of one page of {PAGE} bytes are",
            f"inverted, at one of {FLIPS}",
            "evenly spaced places. The table gives the range of rows read, the findings of severity error, and",
            "the exit code:",
            "4 analysed as far as readable, 1 unusable, 2 required information was lost. The last column is the number of",
            "places where values changed without a finding, because the format has no checksum there.",
        ),
    ]
    names = [name for name in next(iter(damaged.values())) if not name.startswith(FLIPPED)]
    body = []
    for name, outcomes in damaged.items():
        flips = [o for kind, o in outcomes.items() if kind.startswith(FLIPPED)]
        silent = sum(o.code == 0 and not o.right for o in flips)
        body.append(
            [
                name,
                *(_outcome_words([outcomes[kind]]) for kind in names),
                _outcome_words(flips),
                f"{silent} of {len(flips)}",
            ]
        )
    names += [f"{FLIPPED}, at {FLIPS} places", "wrong without a finding"]
    return "\n".join([*lines, *text.table(["format", *names], body)]).rstrip() + "\n"


def main() -> None:
    """Measure and write the page, or read one log."""
    parser = argparse.ArgumentParser(prog="python -m benches.formats")
    parser.add_argument("path", nargs="?")
    parser.add_argument("options", nargs="?", default="{}")
    parser.add_argument("--rows", type=int, default=LONG)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "formats.md")
    arguments = parser.parse_args()
    if arguments.path is not None:
        _read_log(arguments.path, json.loads(arguments.options))
        return
    from benches.measure import machine

    m = machine()
    times, damaged = {}, {}
    for name, kind in KINDS.items():
        sys.stderr.write(f"{name} … ")
        sys.stderr.flush()
        times[name] = measure(name, arguments.rows, arguments.rounds)
        with tempfile.TemporaryDirectory(prefix="sigmatau-bench-") as folder:
            damaged[name] = damage_outcomes(kind, Path(folder))
        sys.stderr.write(f"{times[name]['seconds']:.2f} s\n")
    about = f"{m['processor']}, {m['cores']} cores, {m['system']}; Python {m.get('Python', sys.version.split()[0])}"
    arguments.output.write_text(page(times, damaged, arguments.rows, about), encoding="utf-8")
    print(arguments.output.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
