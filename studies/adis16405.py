"""A real unit: six axes of an Analog Devices ADIS16405, fitted as `sigmatau analyze` does it.

The record (2.78 h at 100 Hz, static; SMAC-Group/imudata, imu1) is not ours to ship: the folder that holds
adis16405_static.csv.gz is named by SIGMATAU_FIELD_DATA; without it this study is skipped.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import sigmatau as st

DATASHEET = {
    "random_walk": {"gyro": "2", "accel": "0.2"},
    "bias_instability": {"gyro": "25", "accel": "0.2 mg = 7.1"},
}
"""deg/√h and m/s/√h; deg/h and m/s/h: Analog Devices, ADIS16400/ADIS16405 data sheet, typical."""


def main() -> None:
    """Run the study and write docs/study/adis16405.md."""
    log = Path(os.environ.get("SIGMATAU_FIELD_DATA", "../shared/data")) / "adis16405_static.csv.gz"
    if not log.exists():
        sys.stderr.write(f"adis16405: skipped, {log} is absent\n")
        return
    analysis = st.analyze(st.read(log, rate=100))
    lines = [_HEAD]
    for channel, fitted in analysis.fits.items():
        stream = channel.partition("_")[0]
        tau_min = "" if fitted.tau_min is None else f"{fitted.tau_min:.3g}"
        p = "" if fitted.p_value is None else f"{fitted.p_value:.2g}"
        row = f"| {channel} | {fitted.verdict} | {tau_min} | {p}"
        for term in ("random_walk", "bias_instability", "rate_random_walk"):
            value, interval, unit = fitted.texts(term)[0]
            sheet = DATASHEET.get(term, {}).get(stream, "")
            row += (
                f" | {' '.join(x for x in (value, interval, unit) if x)} | {sheet}"
                if sheet
                else f" | {value} {interval}"
            )
        lines.append(row + " |")
    lines += ["", "Findings:", ""]
    lines += [f"- {finding}" for finding in analysis.findings]
    lines += [f"- {channel}: {note}" for channel, fitted in analysis.fits.items() for note in fitted.notes()]
    Path("docs/study/adis16405.md").write_text("\n".join([*lines, "", _TAIL]) + "\n", encoding="utf-8")


_HEAD = """# A real unit: ADIS16405

Made by `make study` (studies/adis16405.py) from imu1 of the [imudata](https://github.com/SMAC-Group/imudata) collection,
2.78 h at 100 Hz, at rest, analysed with the defaults of `sigmatau analyze`. The columns "sheet" are the typical values of
the manufacturer's datasheet.

| axis | verdict | τ_min [s] | p | random walk | sheet | bias instability | sheet | rate random walk |
|---|---|---|---|---|---|---|---|---|"""

_TAIL = """The gyros have an internal low-pass filter, which is part of the fit. Published values from spectra of six such
units are N = 2.30 … 2.77 deg/√h and B = 24 … 41 deg/h. The accelerometers have a line at 0.565 Hz with its
third harmonic, and weaker lines. These are left out of the fit, and every axis has a model that fits."""

if __name__ == "__main__":
    main()
