"""A real unit: six axes of an Analog Devices ADIS16405, fitted as by `sigmatau analyze`.

The record (2.78 h at 100 Hz, static; SMAC-Group/imudata, imu1) is not distributed with the package: SIGMATAU_FIELD_DATA
is the folder of adis16405_static.csv.gz; without it this study is skipped.
"""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path

import sigmatau as st
from sigmatau.record.streams import Stream

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
    record = st.read(log, rate=100)
    analysis = st.analyze(record)
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
    lines += ["", *_halves(record.stream_of("accel_x")), "", "Findings:", ""]
    lines += [f"- {finding}" for finding in analysis.findings]
    lines += [f"- {channel}: {note}" for channel, fitted in analysis.fits.items() for note in fitted.notes()]
    Path("docs/study/adis16405.md").write_text("\n".join([*lines, "", _TAIL]) + "\n", encoding="utf-8")


Walk = tuple[float, float, float]
"""Value and interval of a random walk."""


def _halves(stream: Stream) -> list[str]:
    """Compare halves of the record, and of its halves, by intervals before and after the adjustment for a changing level."""
    n = stream.grid.n
    walks: dict[tuple[int, int, str], list[Walk]] = {}
    for parts in (2, 4):
        for k in range(parts):
            for channel in stream.channels:
                x = stream.column(channel)[k * n // parts : (k + 1) * n // parts]
                part = st.Record.from_arrays(rate=100, accel_x=x, unit={"accel": "m/s^2"})
                fitted = st.fit_channel(part, "accel_x")
                walk, causes = fitted["random_walk"], {change.cause: change for change in fitted.adjustments}
                value = walk.value or 0.0
                walks[parts, k, channel] = [(value, walk.low or 0.0, walk.high or 0.0)]
                if "changing_level" in causes:
                    ends = causes["changing_level"].changes[0].before
                    walks[parts, k, channel].insert(0, (value, ends.low or 0.0, ends.high or 0.0))
    lines = [
        "Halves of the record, and halves of these: the difference of the random walk in standard errors, by the intervals",
        "before and after the change of its level is allowed for:",
        "",
        "| axis | halves | first half | second half |",
        "|---|---|---|---|",
    ]
    pairs, deviates = ((2, 0), (4, 0), (4, 2)), []
    for channel in stream.channels:
        cells = []
        for parts, k in pairs:
            first, second = walks[parts, k, channel], walks[parts, k + 1, channel]
            both = [_deviate(first[i], second[i]) for i in (0, -1)]
            deviates.append(both)
            cells.append(f"{both[0]:+.1f}, {both[1]:+.1f}")
        lines.append(f"| {channel} | {' | '.join(cells)} |")
    before, after = (math.sqrt(sum(pair[i] ** 2 for pair in deviates) / len(deviates)) for i in (0, 1))
    return [*lines, "", f"Root mean square: {before:.1f} before, {after:.1f} after."]


def _deviate(first: Walk, second: Walk) -> float:
    """Difference of two random walks, in standard errors of the ends that face each other."""
    if first[0] > second[0]:
        return -_deviate(second, first)
    error = math.hypot(math.log(first[2] / first[0]), math.log(second[0] / second[1])) / 1.96
    return math.log(second[0] / first[0]) / error


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
