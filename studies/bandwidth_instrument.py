"""`sigmatau.bandwidth` on simulated sensors: filters of four kinds, 2 to 6 logs at 10 Hz to 2 kHz, and single logs.

The logs are simulated in the time domain at a high rate, at least 64 times the bandwidth and 16 times the rate of the
log: white noise passes the differential equation or the taps of the filter, then every k-th sample is used. The fitted
spectra are not used.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from studies.runner import run

Floats = NDArray[np.float64]

SENSORS = 1000
PART = 25
"""Number of sensors in a cell."""

SINGLE = 100
"""Numbers of single logs that are too slow, and of fast single logs."""

KINDS = ("one pole", "Butterworth", "two poles", "running mean", "FIR")
RATES = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
SAMPLES = (3000, 9000)
OVER_BANDWIDTH, OVER_RATE = 64.0, 16.0
MEMORY = 4.0
"""Memory of poles, over the inverse of the bandwidth: earlier noise has an amplitude of 1e-5."""
HALF_POWER_OF_MEAN = 0.44294647
"""Frequency of half the power of a running mean, times its length: sin²x = x²/2 at x = 1.391557."""
STEPS = (1e-3, 1.0)
"""Steps of the values, over the standard deviation of their differences."""

LEVEL = 0.95
DENSITY = 1e-4
"""N of all sensors. [rad/√s]"""


class Sensor:
    """A filter with random parameters, as a difference equation at any high rate."""

    def __init__(self, kind: str, rng: np.random.Generator, *, lowest: float, highest: float) -> None:
        self.kind = kind
        self.corner = float(np.exp(rng.uniform(math.log(lowest), math.log(highest))))
        self.damping = math.sqrt(0.5) if kind == "Butterworth" else float(rng.uniform(0.45, 1.3))
        self.sharpness = float(rng.uniform(0.7, 3.0))
        self.slow_passes = bool(rng.integers(2))

    def taps(self, rate: float) -> tuple[Floats, Floats]:
        """Numerator and denominator of the filter at a high rate."""
        from scipy.signal import cont2discrete

        w = 2 * math.pi * self.corner
        if self.kind == "one pole":
            p = math.exp(-w / rate)
            return np.array([0.0, 1 - p]), np.array([1.0, -p])
        if self.kind in ("Butterworth", "two poles"):
            system = (np.array([w * w]), np.array([1.0, 2 * self.damping * w, w * w]))
            num, den, _ = cont2discrete(system, 1 / rate, method="zoh")
            return np.asarray(num).ravel(), np.asarray(den).ravel()
        if self.kind == "running mean":
            length = HALF_POWER_OF_MEAN * rate / self.corner  # the ends have part of the weight
            whole = math.floor(length / 2 - 0.5)
            end = 0.5 * (length - 2 * whole - 1)
            taps = np.concatenate(([end], np.ones(2 * whole + 1), [end]))
        else:
            duration = self.sharpness / self.corner
            half = math.floor(duration * rate / 2)
            t = np.arange(-half, half + 1) / rate
            taps = (0.54 + 0.46 * np.cos(2 * np.pi * t / duration)) * np.sinc(2 * self.corner * t)
        return taps / taps.sum(), np.ones(1)

    def samples(self, rate: float, n: int, rng: np.random.Generator) -> Floats:
        """White noise after the filter, sampled without an anti-alias filter, with slow noise and rounding; shape (n,)."""
        from scipy.signal import lfilter

        over = math.ceil(max(OVER_RATE, OVER_BANDWIDTH * self.corner / rate))
        fast = rate * over
        if self.kind == "running mean":
            y = self._running_mean(rate, over, n, rng)
            return _rounded(y + self._slow(rate, n, rng), rng)
        num, den = self.taps(fast)
        # Only the noise within the memory of the filter affects a sample.
        memory = len(num) if len(den) == 1 else round(MEMORY * fast / self.corner)
        sigma = DENSITY * math.sqrt(fast)
        if over >= memory:
            white = sigma * rng.standard_normal((n, memory))
        elif len(den) == 1:
            white = np.lib.stride_tricks.sliding_window_view(sigma * rng.standard_normal(n * over + memory), memory)
            white = white[::over][:n]
        else:
            white = sigma * rng.standard_normal((1, n * over + memory))
        y = white @ num if len(den) == 1 else lfilter(num, den, white)
        y = y if y.ndim == 1 else y[:, -1] if len(y) == n else y[0, memory::over]
        return _rounded(y + self._slow(rate, n, rng), rng)

    def _running_mean(self, rate: float, over: int, n: int, rng: np.random.Generator) -> Floats:
        """Means of continuous white noise over a time that is not a whole number of fast samples, from its integral."""
        length = HALF_POWER_OF_MEAN / self.corner
        if length * rate <= 1:
            return np.asarray(DENSITY / math.sqrt(length) * rng.standard_normal(n))
        step = 1 / (rate * over)
        whole = math.floor(length / step)
        rest = length / step - whole
        cells = n * over + whole + 1
        # Part of each cell that is in a mean that begins in the cell, and the part before it.
        within = DENSITY * math.sqrt(rest * step) * rng.standard_normal(cells)
        integral = np.cumsum(within + DENSITY * math.sqrt((1 - rest) * step) * rng.standard_normal(cells))
        ends = whole + 1 + over * np.arange(n)
        return np.asarray((integral[ends] - integral[ends - whole] + within[ends - whole]) / length)

    def _slow(self, rate: float, n: int, rng: np.random.Generator) -> Floats:
        """Flicker and a random walk that cross the white noise far below the bandwidth and half the rate."""
        from scipy.signal import freqz

        long = 2 * n  # half of it is used, so that its ends do not join
        f = np.fft.rfftfreq(long, 1 / rate)
        crossing = np.exp(rng.uniform(math.log(1e-3), math.log(0.03), 2)) * min(rate / 2, self.corner)
        density = np.zeros(len(f))
        density[1:] = DENSITY**2 * (crossing[0] / f[1:] + (crossing[1] / f[1:]) ** 2)
        if self.slow_passes:
            fast = OVER_BANDWIDTH * max(self.corner, rate)
            density *= np.abs(freqz(*self.taps(fast), worN=2 * math.pi * f / fast)[1]) ** 2
        parts = rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f))
        return np.asarray(np.fft.irfft(np.sqrt(density * rate * long / 2) * parts, long)[:n])

    def truth(self) -> float:
        """Frequency of −3 dB, from the difference equation at a very high rate. [Hz]"""
        from scipy.optimize import brentq
        from scipy.signal import freqz

        if self.kind in ("one pole", "Butterworth", "running mean"):
            return self.corner
        fast = 1024 * self.corner
        num, den = self.taps(fast)

        def excess(f: float) -> float:
            return float(abs(freqz(num, den, worN=[2 * math.pi * f / fast])[1][0]) ** 2 - 0.5)

        return float(brentq(excess, 0.1 * self.corner, 1.8 * self.corner))


def _rounded(y: Floats, rng: np.random.Generator) -> Floats:
    """Round values to steps of up to the standard deviation of their differences; the error of coarser steps is not
    white.
    """
    step = float(np.diff(y).std()) * float(np.exp(rng.uniform(*np.log(STEPS))))
    return np.asarray(np.round(y / step) * step)


def logs_of(sensor: Sensor, rates: Floats, rng: np.random.Generator) -> dict[str, st.Record]:
    """Independent logs of a sensor."""
    records = {}
    for k, rate in enumerate(rates.tolist()):
        n = int(rng.integers(*SAMPLES))
        y = sensor.samples(rate, n, rng)
        records[f"log {k}, {rate:g} Hz"] = st.Record.from_arrays(rate=rate, gyro_x=y)
    return records


def sensors(seed: int, kind: str, count: int) -> list[dict[str, Any]]:
    """Results for some sensors of a kind, with 2 to 6 logs each."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        logs = int(rng.integers(2, 7))
        rates = np.sort(rng.choice(RATES, size=logs, replace=False))
        # From a bandwidth that the fastest log resolves to one that no log resolves.
        sensor = Sensor(kind, rng, lowest=0.03 * rates[-1], highest=0.6 * rates[-1])
        rows.append(judged(sensor, logs_of(sensor, rates, rng)) | {"logs": logs})
    return rows


def single_logs(seed: int, fast: bool, count: int) -> list[dict[str, Any]]:  # noqa: FBT001  as a cell calls it
    """Results for single logs: at 3 to 20 times the bandwidth, or at a tenth to a third of it."""
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        rate = float(rng.choice(RATES))
        over = np.exp(rng.uniform(*np.log((4.0, 20.0) if fast else (0.1, 0.33))))
        sensor = Sensor(str(rng.choice(KINDS)), rng, lowest=rate / over, highest=rate / over)
        rows.append(judged(sensor, logs_of(sensor, np.array([rate]), rng)) | {"logs": 1})
    return rows


def judged(sensor: Sensor, records: Mapping[str, st.Record]) -> dict[str, Any]:
    """Whether the intervals contain the truth."""
    try:
        result = st.bandwidth(records, level=LEVEL)["gyro_x"]
    except st.DataError as error:
        return {"kind": sensor.kind, "verdict": "refused", "why": str(error)}
    truth = {"bandwidth": sensor.truth(), "random_walk": DENSITY}
    row: dict[str, Any] = {"kind": sensor.kind, "verdict": result.verdict, "shape": result.shape}
    row["shapes"] = [result.shape, *result.alternatives]
    for name, value in truth.items():
        interval = getattr(result, name)
        low, high = interval.low or 0.0, math.inf if interval.high is None else interval.high
        row[name] = {
            "inside": low <= value <= high,
            "below": value < low,
            "half": None if math.isinf(high) or low == 0 else 0.5 * math.log(high / low),
            "error": math.log(interval.value / value),
        }
    return row


def main() -> None:
    """Run the study and write docs/study/bandwidth-instrument.md."""
    cells: dict[str, tuple[Any, tuple[Any, ...]]] = {}
    for part in range(SENSORS // PART):
        kind = KINDS[part % len(KINDS)]
        cells[f"{kind} {part}"] = (sensors, (kind, PART))
        if part < SINGLE // PART:
            cells[f"slow log alone {part}"] = (single_logs, (False, PART))
            cells[f"fast log alone {part}"] = (single_logs, (True, PART))
    settings = repr((KINDS, RATES, SAMPLES, OVER_BANDWIDTH, OVER_RATE, MEMORY, STEPS, LEVEL, DENSITY))
    results = run("bandwidth-instrument", cells, settings=settings)
    several = [row for name, rows in results.items() if "alone" not in name for row in rows]
    slow = [row for name, rows in results.items() if name.startswith("slow") for row in rows]
    fast = [row for name, rows in results.items() if name.startswith("fast") for row in rows]
    Path("docs/study/bandwidth-instrument.md").write_text(page(several, slow, fast), encoding="utf-8")


def page(several: list[dict[str, Any]], slow: list[dict[str, Any]], fast: list[dict[str, Any]]) -> str:
    """Page of the study, for the finished sensors."""
    gates = Gates()
    lines = [_HEAD.format(sensors=len(several), planned=SENSORS, level=100 * LEVEL)]
    lines.append(_row("all", several, gates))
    lines += [_row(kind, [row for row in several if row["kind"] == kind]) for kind in KINDS]
    lines += [_row(f"{logs} logs", [row for row in several if row["logs"] == logs]) for logs in range(2, 7)]
    lines += ["", _ON_FORMS, ""]
    lines += [
        "| sensor | sensors | its form is the best or as likely | logs differ | refused | not explained |",
        "|---|---|---|---|---|---|",
    ]
    for kind in KINDS:
        rows = [row for row in several if row["kind"] == kind]
        forms = sum(_is_named(row) for row in rows)
        counts = [_count(rows, verdict) for verdict in ("logs differ", "refused", "not explained")]
        lines.append(f"| {kind} | {len(rows)} | {_share(forms, len(rows))} | {' | '.join(map(str, counts))} |")
    false = sum(_count(several, verdict) for verdict in ("logs differ", "refused"))
    gates.at_most("consistent logs that are refused or reported to differ", false, len(several), FALSE_ALARMS)
    lines += ["", "## One log alone", "", _SINGLE, ""]
    lines += [
        "| rate | logs | bandwidth not shown | limit or interval contains the bandwidth | N |",
        "|---|---|---|---|---|",
    ]
    for name, rows in (("a tenth to a third of the bandwidth", slow), ("4 to 20 times the bandwidth", fast)):
        judged_rows = [row for row in rows if "bandwidth" in row]
        inside = [
            _share(sum(row[q]["inside"] for row in judged_rows), len(judged_rows)) for q in ("bandwidth", "random_walk")
        ]
        unknown = _count(rows, "rate too low")
        lines.append(f"| {name} | {len(rows)} | {_share(unknown, len(rows))} | {inside[0]} | {inside[1]} |")
    gates.at_most("slow logs alone with a bandwidth", len(slow) - _count(slow, "rate too low"), len(slow), FALSE_ALARMS)
    return "\n".join([*lines, "", "## Gates", "", *gates.lines]) + "\n"


FALSE_ALARMS = 0.01
"""Share of consistent logs that may be refused, and of slow logs that may have a bandwidth: ten times the level of the
tests.
"""


class Gates:
    """Gates: stated limits ± 3 standard errors, one line of the page each."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def near_level(self, quantity: str, inside: int, count: int) -> None:
        """Gate for coverage at the level."""
        share, error = inside / count, math.sqrt(LEVEL * (1 - LEVEL) / count)
        verdict = "held" if abs(share - LEVEL) <= 3 * error else "**missed**"
        self.lines.append(f"- {quantity}: {100 * share:.1f} %, stated {100 * LEVEL:g} ± {300 * error:.1f} %: {verdict}")

    def at_most(self, quantity: str, number: int, count: int, limit: float) -> None:
        """Gate for a share below a limit."""
        highest = limit + 3 * math.sqrt(limit * (1 - limit) / count)
        verdict = "held" if number / count <= highest else "**missed**"
        self.lines.append(f"- {quantity}: {number} of {count}, at most {100 * highest:.1f} %: {verdict}")


def _row(name: str, rows: list[dict[str, Any]], gates: Gates | None = None) -> str:
    """Coverage and width in a group of sensors; refused sensors have no interval."""
    with_intervals = [row for row in rows if "bandwidth" in row]
    cells = [f"| {name} | {len(rows)} | {_count(rows, 'rate too low')}"]
    for quantity in ("bandwidth", "random_walk"):
        inside = sum(row[quantity]["inside"] for row in with_intervals)
        halves = [row[quantity]["half"] for row in with_intervals if row[quantity]["half"] is not None]
        width = f"{100 * float(np.median(halves)):.1f} %" if halves else "-"
        cells.append(f"{_share(inside, len(with_intervals))} | {width}")
        if gates is not None:
            gates.near_level(f"coverage of the {quantity.replace('_', ' ')}", inside, len(with_intervals))
    return " | ".join(cells) + " |"


def _count(rows: list[dict[str, Any]], verdict: str) -> int:
    return sum(row["verdict"] == verdict for row in rows)


def _share(number: int, count: int) -> str:
    """A share with its standard error."""
    if not count:
        return "-"
    share = number / count
    return f"{100 * share:.1f} ± {100 * math.sqrt(share * (1 - share) / count):.1f} %"


def _is_named(row: dict[str, Any]) -> bool:
    """Whether the form of the sensor is among those of the result. Two poles of any damping include the Butterworth
    filter.
    """
    names = {"Butterworth": ("Butterworth, 2 poles", "two poles"), "FIR": ("FIR, Hamming taper", "FIR, Blackman taper")}
    return any(shape in names.get(row["kind"], (row["kind"],)) for shape in row.get("shapes", ()))


_HEAD = """# Bandwidth from several rates: coverage

Made by `make study` (studies/bandwidth_instrument.py): `sigmatau.bandwidth` on {sensors} simulated sensors of {planned}
planned ones, with 2 to 6 logs each at 10 Hz to 2 kHz. A sensor is one pole, two Butterworth poles, two poles with a damping
of 0.45 to 1.3, a running mean, or a FIR filter with a Hamming taper. Its bandwidth is 0.03 to 0.6 times the fastest rate.
A log has 3000 to 9000 samples of white noise, made in the time domain at 64 times the bandwidth and at 16 times the rate or
more, filtered, and every k-th sample taken; flicker and a random walk of its own, in front of the filter or behind it; and
rounded values.

Shares are those of intervals that contain the truth, ± a standard error, out of the sensors that were not refused;
{level:g} % are stated. "Open": the logs do not show the bandwidth, and the interval is a lower limit. The widths are medians
of half the interval over the value.

| sensors | number | open | bandwidth inside | ± | N without aliasing inside | ± |
|---|---|---|---|---|---|---|"""

_ON_FORMS = """The form of the filter is a result too. With some thousand samples at rates near the bandwidth several forms
are as likely, and the intervals contain all of them."""

_SINGLE = """A log at a tenth to a third of the bandwidth is white: any bandwidth above a limit explains it. A log at
four times the bandwidth or more shows its filter alone."""


if __name__ == "__main__":
    main()
