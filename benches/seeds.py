"""``python -m benches.seeds FOLDER``: initial small logs for the fuzzer, with a folder for each target."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benches.logs import KINDS, made

# The first two bytes of a text table select the dialect: commas, seven columns, no line before the table.
TARGETS = {
    "CSV": ("text", bytes([1 << 6, 6])),
    "CSV, decimal comma": ("text", bytes([1 << 6 | 8 | 1, 6])),
    "CSV, UTF-16": ("text", bytes([1 << 6 | 1 << 4 | 2, 6])),
    "VectorNav ASCII": ("sentences", b""),
    "PX4 ULog": ("ulog", b""),
    "ArduPilot DataFlash": ("dataflash", b""),
    "MCAP, zstd": ("mcap", b""),
    "ROS 1 bag, lz4": ("bag", b""),
}


def main(folder: Path) -> None:
    """Write the logs."""
    for n in (5, 40):
        stamps, values = made(n)
        for name, (target, before) in TARGETS.items():
            with tempfile.TemporaryDirectory() as made_in:
                data = KINDS[name].make(Path(made_in), stamps, values).read_bytes()
            place = folder / target
            place.mkdir(parents=True, exist_ok=True)
            (place / f"{name.replace(' ', '-').replace(',', '')}-{n}").write_bytes(before + data)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
