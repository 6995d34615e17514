"""Tables I to V of the paper as they are printed, and the noise models of its units by day.

N. El-Sheimy, H. Hou, X. Niu, "Analysis and modeling of inertial sensors using Allan variance", IEEE Trans. Instrum. Meas.
57(1), 2008, doi 10.1109/TIM.2007.908635. The row of accelerometer Z of the CIMU is not legible in our copy of Table II.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from importlib import resources
from pathlib import Path

from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.units import to_si

__all__ = ["DAYS", "NAMES", "PAGES", "PRINTED", "RATES", "STD", "TABLES", "Cell", "day_model", "model", "truth"]

PAGES = Path(__file__).resolve().parents[2] / "docs" / "paper"

NAMES = {"cimu": "CIMU", "hg1700": "HG1700", "motionpak2": "MotionPak II"}
TITLES = {"cimu": "II", "hg1700": "IV", "motionpak2": "V"}
RATES = {"cimu": 200.0, "hg1700": 100.0, "motionpak2": 100.0}  # [Hz]; for the CIMU see the page on errata
HOURS = 2.0

_QUANTITY_UNITS = {
    ("gyro", "quantization"): "arcsec",
    ("gyro", "random_walk"): "deg/sqrt(h)",
    ("gyro", "bias_instability"): "deg/h",
    ("accel", "quantization"): "m/s/h",  # as printed; the number is the line at √3 s, see `Cell.si`
    ("accel", "random_walk"): "m/s/sqrt(h)",
    ("accel", "bias_instability"): "m/s/h",
    ("accel", "rate_random_walk"): "m/s/h^(3/2)",
    ("accel", "rate_ramp"): "m/s/h^2",
}


@dataclass(frozen=True, slots=True)
class Cell:
    """A coefficient of Tables II, IV and V: value and error as printed."""

    unit: str  # key of `NAMES`
    channel: str
    term: str
    printed: str
    printed_error: str

    @property
    def value(self) -> float:
        return float(self.printed)

    @property
    def error(self) -> float:
        return float(self.printed_error)

    @property
    def decimals(self) -> int:
        """Digits after the point of the printed error."""
        exponent = Decimal(self.printed_error).as_tuple().exponent
        assert isinstance(exponent, int)
        return -exponent

    @property
    def printed_unit(self) -> str:
        return _QUANTITY_UNITS[self.channel.split("_")[0], self.term]

    @property
    def si_factor(self) -> float:
        """Factor of the printed unit to SI. Quantization of an accelerometer is a velocity: the printed number / 3600 in
        m/s.
        """
        if self.term == "quantization" and self.channel.startswith("accel"):
            return 1 / 3600
        return to_si(1.0, self.printed_unit)

    @property
    def samples(self) -> int:
        return round(HOURS * 3600 * RATES[self.unit])


def _cells(unit: str, *rows: tuple[str, str, str, str]) -> tuple[Cell, ...]:
    return tuple(Cell(unit, *row) for row in rows)


PRINTED: tuple[Cell, ...] = (
    *_cells(
        "cimu",
        ("gyro_x", "quantization", "0.973", "0.074"),
        ("gyro_y", "quantization", "0.517", "0.020"),
        ("gyro_z", "quantization", "0.577", "0.016"),
        ("gyro_x", "random_walk", "0.0015", "0.0005"),
        ("gyro_y", "random_walk", "0.0019", "0.0006"),
        ("gyro_z", "random_walk", "0.0018", "0.0006"),
        ("accel_x", "quantization", "1.680", "0.128"),
        ("accel_y", "quantization", "1.298", "0.099"),
        ("accel_x", "rate_ramp", "2.64", "0.88"),
        ("accel_y", "rate_ramp", "0.89", "0.30"),
    ),
    *_cells(
        "hg1700",
        ("gyro_x", "quantization", "5.1154", "0.068"),
        ("gyro_y", "quantization", "1.2742", "0.0032"),
        ("gyro_z", "quantization", "1.2316", "0.0028"),
        ("gyro_x", "random_walk", "0.094", "0.031"),
        ("gyro_y", "random_walk", "0.088", "0.030"),
        ("gyro_z", "random_walk", "0.075", "0.026"),
        ("accel_x", "quantization", "2.119", "0.067"),
        ("accel_y", "quantization", "2.199", "0.118"),
        ("accel_z", "quantization", "2.185", "0.058"),
        ("accel_x", "rate_random_walk", "0.76", "0.25"),
        ("accel_y", "rate_random_walk", "1.16", "0.39"),
        ("accel_z", "rate_random_walk", "3.35", "1.12"),
    ),
    *_cells(
        "motionpak2",
        ("gyro_x", "random_walk", "0.512", "0.007"),
        ("gyro_y", "random_walk", "0.486", "0.007"),
        ("gyro_z", "random_walk", "0.489", "0.007"),
        ("gyro_x", "bias_instability", "13.6", "1.4"),
        ("gyro_y", "bias_instability", "11.7", "1.2"),
        ("gyro_z", "bias_instability", "16.8", "1.7"),
        ("accel_x", "random_walk", "0.0166", "0.00003"),
        ("accel_y", "random_walk", "0.0159", "0.00003"),
        ("accel_z", "random_walk", "0.0161", "0.00003"),
        ("accel_x", "bias_instability", "4.36", "0.04"),
        ("accel_y", "bias_instability", "4.09", "0.08"),
        ("accel_z", "bias_instability", "4.36", "0.08"),
    ),
)

TABLES: Mapping[str, Mapping[tuple[str, str], tuple[float, float]]] = {
    unit: {(c.channel, c.term): (c.value, c.error) for c in PRINTED if c.unit == unit} for unit in NAMES
}
"""Value and ± by unit, channel and term."""

# Tables I and III: quantization noise of the gyros by day [arcsec], and the printed row of standard deviations.
DAYS: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "cimu": {
        "gyro_x": (0.973, 0.960, 0.919, 0.947, 0.958, 0.959, 0.945),
        "gyro_y": (0.517, 0.536, 0.506, 0.498, 0.499, 0.507, 0.507),
        "gyro_z": (0.577, 0.602, 0.575, 0.569, 0.559, 0.562, 0.579),
    },
    "hg1700": {
        "gyro_x": (5.115, 5.112, 5.111, 5.124, 5.031, 5.105, 5.049),
        "gyro_y": (1.274, 1.284, 1.280, 1.307, 1.286, 1.305, 1.295),
        "gyro_z": (1.232, 1.203, 1.223, 1.226, 1.219, 1.207, 1.223),
    },
}
STD: Mapping[str, Mapping[str, str]] = {
    "cimu": {"gyro_x": "0.017", "gyro_y": "0.013", "gyro_z": "0.014"},
    "hg1700": {"gyro_x": "0.037", "gyro_y": "0.012", "gyro_z": "0.010"},
}


def model(unit: str) -> NoiseModel:
    """Model of a unit from its Table II, IV or V."""
    with resources.as_file(resources.files("sigmatau.data").joinpath(f"{unit}.toml")) as path:
        return NoiseModel.read(path)


def day_model(unit: str, day: int) -> NoiseModel:
    """Model on day 1 … 7: quantization noise of the gyros from Table I or III, other values from Table II, IV or V."""
    by_day = DAYS.get(unit, {})
    channels: dict[str, ChannelModel | dict[str, float]] = {}
    for name, channel in model(unit).channels.items():
        terms = dict(channel.items())
        if name in by_day:
            terms["quantization"] = to_si(by_day[name][day - 1], "arcsec")
        channels[name] = terms
    return NoiseModel(channels=channels)


def truth(cell: Cell, day: int) -> float:
    """The simulated coefficient of a cell on a day, in the printed unit."""
    return float(dict(day_model(cell.unit, day).channels[cell.channel].items())[cell.term]) / cell.si_factor
