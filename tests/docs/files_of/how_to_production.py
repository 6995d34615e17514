"""The files of docs/how-to/production.md: the lot that the page speaks of."""

from pathlib import Path

from lot_logs import write_lot


def make(folder: Path) -> None:
    """Forty units of a shift; the specification is in the page."""
    write_lot(folder / "shift")
    (folder / "spec.toml").unlink()
    (folder / "units.txt").write_text("".join(f"unit{k:02}\n" for k in range(1, 41)))
