"""Printed deviations of other programs, and how many of them are ours: the counts of docs/coming-from/features.md."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import known
from sigmatau import Record, allan, deviation

# Factors by which Stable32 divides a variance for each noise type, α = 2 … −2: NIST SP 1065, section 5.2.12 and table 10.
MODIFIED_TOTAL = {2: 0.94, 1: 0.83, 0: 0.73, -1: 0.70, -2: 0.69}
HADAMARD_TOTAL = {0: 0.995, -1: 0.851, -2: 0.771}
# The value of its file for Theo1 with flicker noise of the phase; it is the same at all averaging times.
THEO1_FLICKER_PHASE = 0.602785


@dataclass(frozen=True)
class Cell:
    """A printed number."""

    kind: str
    overlap: str
    m: int
    printed: str
    bias: float = 1.0  # of the variance, removed by the program and not by us

    @property
    def unit(self) -> float:
        """Of the last digit."""
        mantissa, _, exponent = self.printed.lower().partition("e")
        return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def agreeing(record: Record, cells: list[Cell]) -> list[bool]:
    """Whether our number rounds to the printed one, with a tenth of a unit for the rounding of the program itself."""
    groups: dict[tuple[str, str], list[Cell]] = {}
    for cell in cells:
        groups.setdefault((cell.kind, cell.overlap), []).append(cell)
    ours = {key: _deviations(record, *key, sorted({cell.m for cell in group})) for key, group in groups.items()}
    return [
        abs(ours[cell.kind, cell.overlap][cell.m] / math.sqrt(cell.bias) - float(cell.printed)) <= 0.6 * cell.unit
        for cell in cells
    ]


def _deviations(record: Record, kind: str, overlap: str, sizes: list[int]) -> dict[int, float]:
    tau0 = record.streams[0].grid.tau0
    if kind == "allan":
        curve = allan(record, taus=np.multiply(sizes, tau0), overlap=overlap)["y"]
        return dict(zip(curve.m.tolist(), curve.adev, strict=True))
    options = {"overlap": overlap} if kind == "hadamard" else {}
    factor = 0.75 if kind.startswith("theo") else 1.0
    result = deviation(record, kind=kind, taus=np.multiply(sizes, factor * tau0), **options)["y"]
    return dict(zip(result.m.tolist(), result.deviation, strict=True))


@cache
def nbs14_record() -> Record:
    return Record.from_arrays(rate=1, y=known.nbs14())


def nbs14() -> list[Cell]:
    """Table 31 of NIST SP 1065; the total deviations there have the bias of white noise removed."""
    table = {
        ("allan", "none"): "2.922319e-01 9.965736e-02 3.897804e-02",
        ("allan", "full"): "2.922319e-01 9.159953e-02 3.241343e-02",
        ("modified", "full"): "2.922319e-01 6.172376e-02 2.170921e-02",
        ("time", "full"): "1.687202e-01 3.563623e-01 1.253382e+00",
        ("hadamard", "none"): "2.943883e-01 1.052754e-01 3.910860e-02",
        ("hadamard", "full"): "2.943883e-01 9.581083e-02 3.237638e-02",
        ("total", "full"): "2.922319e-01 9.134743e-02 3.406530e-02",
        ("hadamard_total", "full"): "2.943883e-01 9.614787e-02 3.058103e-02",
        ("modified_total", "full"): "2.418528e-01 6.499161e-02 2.287774e-02",
        ("time_total", "full"): "1.396338e-01 3.752293e-01 1.320847e+00",
    }
    sizes = (1, 10, 100)
    return [
        Cell(kind, overlap, m, printed, _removed(kind, m, 0))
        for (kind, overlap), row in table.items()
        for m, printed in zip(sizes, row.split(), strict=True)
    ]


def nine_points() -> list[Cell]:
    """Table 30 of NIST SP 1065: nine frequencies."""
    table = {
        ("allan", "none"): "91.22945 115.8082",
        ("allan", "full"): "91.22945 85.95287",
        ("modified", "full"): "91.22945 74.78849",
        ("time", "full"): "52.67135 86.35831",
        ("hadamard", "none"): "70.80607 116.7980",
        ("hadamard", "full"): "70.80607 85.61487",
        ("total", "full"): "91.22945 93.90379",
        ("modified_total", "full"): "75.50203 75.83606",
        ("time_total", "full"): "43.59112 87.56794",
        ("hadamard_total", "full"): "70.80607 91.16396",
    }
    return [
        Cell(kind, overlap, m, printed, _removed(kind, m, 0))
        for (kind, overlap), row in table.items()
        for m, printed in zip((1, 2), row.split(), strict=True)
    ]


def sigmatheta() -> list[Cell]:
    """Parabolic deviations of the 1000-point set by SigmaTheta 3.0, in the tests of allantools: pdev_nbs14.txt there."""
    printed = (
        "2.9223187810675200e-01 2.1445233564252639e-01 1.5618112158618463e-01 1.1709745745448434e-01 "
        "6.9029585189839343e-02 4.9749707730398392e-02 3.8947417330713739e-02 3.0862392741372108e-02 "
        "1.2447414341332683e-02 9.3531187831254377e-04"
    )
    sizes = (1, 2, 4, 8, 16, 32, 64, 128, 256, 500)
    # Ten digits: the rest of theirs is rounding.
    return [
        Cell("parabolic", "full", m, f"{float(value):.9e}") for m, value in zip(sizes, printed.split(), strict=True)
    ]


def stable32_theo1() -> list[Cell]:
    """Theo1 of the 1000-point set, and total deviations without removal of the bias, in the tests of allantools."""
    rows = {
        "theo1": ((10, 100, 1000), "1.0757e-01 3.1789e-02 5.0524e-03"),
        "modified_total": ((1, 10, 100), "2.0664e-01 5.5529e-02 1.9547e-02"),
        "time_total": ((1, 10, 100), "1.1930e-01 3.2060e-01 1.1285e+00"),
    }
    return [
        Cell(kind, "full", m, printed)
        for kind, (sizes, row) in rows.items()
        for m, printed in zip(sizes, row.split(), strict=True)
    ]


# Files of Stable32's results for PHASE.DAT: estimator, overlap, column.
FILES = {
    "adev": ("allan", "none", 5),
    "oadev": ("allan", "full", 5),
    "mdev": ("modified", "full", 5),
    "hdev": ("hadamard", "none", 5),
    "ohdev": ("hadamard", "full", 5),
    "totdev": ("total", "full", 5),
    "tdev": ("time", "full", 5),
    "mtie": ("mtie", "full", 3),
    "tierms": ("tie_rms", "full", 3),
    "theo1": ("theo1", "full", 5),
    "mtotdev": ("modified_total", "full", 5),
    "ttotdev": ("time_total", "full", 5),
    "htotdev": ("hadamard_total", "full", 5),
}
# Files in which the bias is not removed, as their numbers show.
_WITH_BIAS = ("mtotdev_decade", "mtotdev_octave", "mtotdev_octave_alpha0", "ttotdev_decade", "ttotdev_octave")


def stable32(path: Path) -> list[Cell]:
    """Rows of a file, also those that the tests of allantools leave out by a # in front."""
    name = path.stem.removeprefix("phase_dat_")
    kind, overlap, column = FILES[name.partition("_")[0]]
    cells = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.lstrip("#").split()
        if len(words) < column + 1 or not (words[0].isdigit() and "e" in words[1]):
            continue
        m, printed = int(words[0]), words[column]
        removed = 1.0
        if name == "theo1":
            removed = 1 / THEO1_FLICKER_PHASE
        elif name not in _WITH_BIAS and "nobias" not in name and column == 5:
            removed = _removed(kind, m, int(words[3]))
        cells.append(Cell(kind, overlap, m, printed, removed))
    return cells


def phase_record(folder: Path) -> Record:
    phase = np.loadtxt(folder / "PHASE.DAT")
    return Record.from_arrays(rate=1, y=phase, unit={"y": "s"}, input="accumulated")


def _removed(kind: str, m: int, alpha: int) -> float:
    if kind in ("modified_total", "time_total"):
        return MODIFIED_TOTAL[alpha]
    # For one sample it is the Hadamard deviation, without bias.
    return HADAMARD_TOTAL.get(alpha, 1.0) if kind == "hadamard_total" and m > 1 else 1.0
