"""Files of docs/how-to/temperature-calibration.md."""

from pathlib import Path

from temperature_cycle import write_cycle


def make(folder: Path) -> None:
    """A ramp from -40 to 85 °C and back with a hysteresis, and runs of three units at four temperatures."""
    write_cycle(folder)
