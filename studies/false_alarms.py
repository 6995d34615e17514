"""Share of clean records with a warning or an error."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import sigmatau as st
from studies.runner import run

RECORDS, A_CELL = 300, 6
LIMIT = 0.05

# Terms of the gyros and of the accelerometers, by grade.
GRADES: dict[str, tuple[dict[str, str], dict[str, str]]] = {
    "consumer MEMS": (
        {"random_walk": "0.3 deg/sqrt(h)", "bias_instability": "10 deg/h", "rate_random_walk": "20 deg/h/sqrt(h)"},
        {"random_walk": "0.06 m/s/sqrt(h)", "bias_instability": "0.04 mg", "rate_random_walk": "3 m/s/h^(3/2)"},
    ),
    "industrial MEMS": (
        {"random_walk": "2 deg/sqrt(h)", "bias_instability": "25 deg/h"},
        {"random_walk": "0.2 m/s/sqrt(h)", "bias_instability": "0.2 mg"},
    ),
    "tactical, integrating": (
        {"quantization": "1.2742 arcsec", "random_walk": "0.088 deg/sqrt(h)"},
        {"quantization": "6.1e-4 m/s", "rate_random_walk": "1.16 m/s/h^(3/2)"},
    ),
    "navigation": (
        {"quantization": "0.97 arcsec", "random_walk": "0.0015 deg/sqrt(h)", "bias_instability": "0.003 deg/h"},
        {"quantization": "4.7e-4 m/s", "random_walk": "0.004 m/s/sqrt(h)"},
    ),
    "drifting": (
        {"random_walk": "0.1 deg/sqrt(h)", "rate_random_walk": "60 deg/h/sqrt(h)", "rate_ramp": "3 deg/h^2"},
        {"random_walk": "0.05 m/s/sqrt(h)", "rate_random_walk": "60 m/s/h^(3/2)"},
    ),
    "white": ({"random_walk": "0.5 deg/sqrt(h)"}, {"random_walk": "0.1 m/s/sqrt(h)"}),
}
# Length [h] and rate [Hz].
LENGTHS = {"20 min at 50 Hz": (1 / 3, 50.0), "1 h at 100 Hz": (1.0, 100.0), "2 h at 25 Hz": (2.0, 25.0)}


def record(seed: int, grade: str, length: str, *, gravity: bool) -> st.Record:
    """Six axes, with gravity on the third accelerometer or without."""
    gyro, accel = GRADES[grade]
    hours, rate = LENGTHS[length]
    channels = {f"gyro_{axis}": gyro for axis in "xyz"} | {f"accel_{axis}": accel for axis in "xyz"}
    clean = st.simulate(
        st.NoiseModel.from_dict({"channels": channels}),
        duration=3600 * hours,
        rate=rate,
        rng=np.random.default_rng(seed),
    )
    if not gravity:
        return clean
    columns = {name: clean.stream_of(name).column(name) for name in clean.channels}
    columns["accel_z"] = columns["accel_z"] + 9.80665
    return st.Record.from_arrays(rate=rate, **columns)  # type: ignore[arg-type]  # names of channels


def cell(seed: int, grade: str, length: str) -> list[list[str]]:
    """Codes of the warnings and errors of each record."""
    rng = np.random.default_rng(seed)
    codes = []
    for k in range(A_CELL):
        clean = record(int(rng.integers(1 << 62)), grade, length, gravity=k % 2 == 0)
        findings = st.analyze(clean, threads=1).findings
        codes.append(sorted({f.code for f in findings if f.severity != "info"}))
    return codes


def cells() -> dict[str, tuple[Any, tuple[Any, ...]]]:
    """Enough cells for all records."""
    kinds = [(grade, length) for grade in GRADES for length in LENGTHS]
    return {
        f"{grade}, {length}, {k}": (cell, (grade, length))
        for k in range(math.ceil(RECORDS / A_CELL / len(kinds)))
        for grade, length in kinds
    }


def main() -> None:
    """Run the study and write docs/study/false-alarms.md."""
    every = cells()
    results = run("false_alarms", every, settings=repr((A_CELL, GRADES, LENGTHS)))
    by_name = {name: results[name] for name in every}
    total = sum(map(len, by_name.values()))
    warned = sum(bool(codes) for records in by_name.values() for codes in records)
    error = math.sqrt(max(warned, 1)) / total
    lines = [_HEAD.format(total=total, warned=warned, share=100 * warned / total, error=100 * error)]
    for grade in GRADES:
        row = [f"| {grade}"]
        for length in LENGTHS:
            records = [codes for name in by_name if name.startswith(f"{grade}, {length}, ") for codes in by_name[name]]
            codes = Counter(code for record in records for code in record)
            listed = ", ".join(f"{code} {count}" for code, count in codes.most_common())
            row.append(f"{sum(map(bool, records))} of {len(records)}" + (f": {listed}" if listed else ""))
        lines.append(" | ".join(row) + " |")
    verdict = "holds" if warned / total <= LIMIT + 3 * error else "does NOT hold"
    lines.append(f"\nThe limit of {100 * LIMIT:g} % {verdict}.\n")
    Path("docs/study/false-alarms.md").write_text("\n".join(lines), encoding="utf-8")


_HEAD = """# False alarms in clean records

Made by `make study` (studies/false_alarms.py): {total} simulated records of six axes were analysed with
`sigmatau.analyze`. Half of them have gravity on the third accelerometer. The seeds are derived from the names of the
cells. **{warned} of them ({share:.1f} ± {error:.1f} %) have a finding with severity warning or error**; the limit is 5 %.

Number of records with such a finding, and their codes:

| grade | 20 min at 50 Hz | 1 h at 100 Hz | 2 h at 25 Hz |
|---|---|---|---|"""


if __name__ == "__main__":
    main()
