"""The files of docs/how-to/production.md: the lot of the page."""

from pathlib import Path

from lot_logs import rates, write_log, write_lot


def make(folder: Path) -> None:
    """Forty units of a shift, three of them hot; the specification is in the page."""
    write_lot(folder / "shift")
    (folder / "hot").mkdir()
    for unit in range(1, 4):
        write_log(folder / "hot" / f"unit{unit:02}.csv", rates(unit, kind="hot"))
    (folder / "spec.toml").unlink()
    (folder / "units.txt").write_text("".join(f"unit{k:02}\n" for k in range(1, 41)))
