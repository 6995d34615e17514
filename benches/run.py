"""Speed compared with other packages and the limits of the machine: ``make bench``.

Results are stored in .bench/results.json, so that the page can be rewritten (``--redraw``) or one part measured again
(``--only``).
"""

from __future__ import annotations

import argparse
import datetime as dt
import json
import sys
import time
from pathlib import Path
from typing import Any

from benches import page
from benches.measure import Settings, load, machine

ROOT = Path(__file__).parent.parent


def main() -> None:
    """Measure, store the results, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--billion", action="store_true", help="push 10⁹ samples as well")
    parser.add_argument("--only", nargs="+", choices=list(page.SECTIONS), metavar="PART", help=", ".join(page.SECTIONS))
    parser.add_argument("--redraw", action="store_true", help="measure nothing")
    parser.add_argument("--scale", type=float, default=1.0, help="of the numbers of samples, for a trial")
    parser.add_argument("--cache", type=Path, default=ROOT / ".bench")
    parser.add_argument(
        "--output", type=Path, help="folder of the page; by default docs, or --cache if it is not whole"
    )
    arguments = parser.parse_args()
    stored = arguments.cache / "results.json"
    measured: dict[str, Any] = {"sections": {}}
    if (arguments.only or arguments.redraw) and stored.exists():
        measured = json.loads(stored.read_text(encoding="utf-8"))
    if not arguments.redraw:
        settings = Settings(rounds=arguments.rounds, scale=arguments.scale, billion=arguments.billion)
        _measure(measured["sections"], arguments.only or list(page.SECTIONS), settings)
        arguments.cache.mkdir(parents=True, exist_ok=True)
        stored.write_text(json.dumps(measured, indent=1) + "\n", encoding="utf-8")
    # A part that was measured alone, or a trial with few samples, must not replace the page of docs.
    whole = measured["sections"].keys() >= page.SECTIONS.keys() and arguments.scale == 1
    output = arguments.output or (ROOT / "docs" if whole else arguments.cache)
    page.write(measured, output)
    print((output / "performance.md").read_text(encoding="utf-8"))
    sys.stderr.write(f"written: {output / 'performance.md'}\n")


def _measure(sections: dict[str, Any], names: list[str], settings: Settings) -> None:
    today = dt.datetime.now(dt.UTC).date().isoformat()
    same = names == list(page.SECTIONS)
    for name in names:
        start, ran = time.monotonic(), load()
        sys.stderr.write(f"{name} … ")
        sys.stderr.flush()
        result = page.SECTIONS[name].measure(settings)
        command = _command(settings) if same else f"{_command(settings)} PARTS={name}"
        about = {"command": command, "rounds": settings.rounds, "date": today, "load": ran, "machine": machine()}
        sections[name] = {**about, "found": result}
        sys.stderr.write(f"{time.monotonic() - start:.0f} s\n")


def _command(settings: Settings) -> str:
    words = ["make bench"]
    if settings.rounds != 9:
        words.append(f"ROUNDS={settings.rounds}")
    if settings.billion:
        words.append("BILLION=1")
    return " ".join(words)


if __name__ == "__main__":
    main()
