"""Test of whether a filter with the exported N and K states its errors as the file claims: six sensors, five process models.

    python -m studies.consistent

writes docs/study/consistent.md. The simulator is independent: it generates flicker noise from its spectrum, not from
Gauss-Markov processes, and runs the covariance recursion of each target at its step, with the numbers of the written
files.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau import ChannelModel, Choices, GaussMarkov, NoiseModel, Record, analyze, export
from sigmatau.exporting.export import prepare
from sigmatau.findings.exporting import PairConsistency
from sigmatau.model.unobserved import Unobserved
from sigmatau.navigation.reference_filter import AIDING, FilterModel, TrueNoise, find_third_state, judge_filter
from studies.runner import run

Floats = NDArray[np.float64]

RUNS = 200
STEP = 0.2  # interval between two measurements [s]
WARM_UP = 8000.0  # [s]
WINDOWS = 10  # number of starts of coasting in a run
SPACING = 200.0  # interval between these starts [s]
TIMES = (10.0, 60.0, 600.0)
RECORD = 10800.0  # length of a fitted record [s]
RECORDS = 40  # number of fitted records per sensor
RATE = 100.0  # rate of filters without a fixed step [Hz]
_DEG_H = math.radians(1) / 3600
_DEG_SQRT_H = math.radians(1) / 60
_UG = 9.80665e-6
_LARGEST_NUMBER_OF_STEPS = 200_000  # limit of a recursion of the covariance


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """True noise of a sensor, in the units of its kind; `limit`: upper limit of a K that was not observed."""

    n: float
    b: float = 0.0
    k: float = 0.0
    sigma: float = 0.0
    time: float = 0.0
    limit: float = 0.0


# Gyro: deg/√h, deg/h, deg/h/√h, deg/h, s. Accelerometer: m/s/√h, µg, µg/√h, µg, s.
SENSORS: Mapping[str, Mapping[str, Sensor]] = {
    "gyro": {
        "consumer MEMS": Sensor(n=0.55, b=8, k=24.8, sigma=5, time=300),
        "N only": Sensor(n=0.3, limit=20),
        "flicker": Sensor(n=0.3, b=10),
        "K": Sensor(n=0.3, k=60),
        "Gauss-Markov": Sensor(n=0.1, b=0.5, sigma=3, time=1000),
        "FOG": Sensor(n=0.002, b=0.006, k=0.004),
    },
    "accel": {
        "consumer MEMS": Sensor(n=0.09, b=60, k=70, sigma=50, time=300),
        "N only": Sensor(n=0.03, limit=50),
        "flicker": Sensor(n=0.03, b=40),
        "K": Sensor(n=0.03, k=200),
        "Gauss-Markov": Sensor(n=0.02, b=5, sigma=30, time=1000),
        "quartz": Sensor(n=0.003, b=3, k=1),
    },
}
KINDS = {"gyro": "Gyro", "accel": "Accelerometer"}
UNITS = {"gyro": (_DEG_SQRT_H, _DEG_H), "accel": (1 / 60, _UG)}
QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}
TARGETS = ("kalibr", "vins", "fast-lio", "px4", "ardupilot")


def model_of(kind: str, sensor: Sensor) -> ChannelModel:
    """Model from an analysis of a long record of the sensor."""
    unit_of_n, unit_of_b = UNITS[kind]
    quantity, unit = QUANTITIES[kind]
    terms = {
        "random_walk": sensor.n * unit_of_n,
        "bias_instability": sensor.b * unit_of_b,
        "rate_random_walk": sensor.k * unit_of_b / 60,
    }
    processes = (GaussMarkov(sigma=sensor.sigma * unit_of_b, time=sensor.time),) if sensor.sigma else ()
    limits = {"rate_random_walk": sensor.limit * unit_of_b / 60} if sensor.limit else {}
    return ChannelModel(terms=terms, gauss_markov=processes, limits=limits, quantity=quantity, unit=unit)


# The simulator


def flicker_rates(b: float, rng: np.random.Generator, steps: int, runs: int) -> Floats:
    """Mean rates over the steps of flicker noise of density B²/(2πf), by its folded spectrum; shape (runs, steps)."""
    n = 2 ** math.ceil(math.log2(2 * steps))  # twice the length: the series of the spectrum is periodic
    frequency = np.arange(n // 2 + 1) / (n * STEP)
    frequency[0] = 0.25 * frequency[1]
    density = np.zeros_like(frequency)
    for fold in range(-4, 5):
        f = np.abs(frequency + fold / STEP)
        density += b**2 / (2 * np.pi * f) * np.sinc(f * STEP) ** 2
    size = np.sqrt(density * n / STEP / 2)
    rates = np.empty((runs, steps))
    for k in range(runs):
        drawn = rng.standard_normal((2, len(size)))
        rates[k] = np.fft.irfft(size * (drawn[0] + 1j * drawn[1]), n)[:steps]
    return rates


def simulated(kind: str, sensor: Sensor, rng: np.random.Generator, steps: int, runs: int) -> tuple[Floats, Floats]:
    """Increments of the integral of the rate, and the bias at the end of each step; shape (runs, steps)."""
    unit_of_n, unit_of_b = UNITS[kind]
    bias, increments = np.zeros((runs, steps)), np.zeros((runs, steps))
    if sensor.b:
        rates = flicker_rates(sensor.b * unit_of_b, rng, steps, runs)
        increments += rates * STEP
        bias += rates
    walks = sensor.k if sensor.k else sensor.limit * rng.uniform(size=(runs, 1))  # flat up to the limit
    if np.any(walks):
        walk = np.cumsum(walks * unit_of_b / 60 * math.sqrt(STEP) * rng.standard_normal((runs, steps)), axis=1)
        increments += STEP * (walk + np.pad(walk, ((0, 0), (1, 0)))[:, :-1]) / 2
        bias += walk
    if sensor.sigma:
        decay = math.exp(-STEP / sensor.time)
        drive = sensor.sigma * unit_of_b * math.sqrt(1 - decay**2) * rng.standard_normal((runs, steps))
        before = sensor.sigma * unit_of_b * rng.standard_normal(runs)
        process = np.empty((runs, steps))
        for k in range(steps):
            process[:, k] = decay * before + drive[:, k]
            increments[:, k] += STEP * (before + process[:, k]) / 2
            before = process[:, k]
        bias += process
    increments += sensor.n * unit_of_n * math.sqrt(STEP) * rng.standard_normal((runs, steps))
    return increments, bias


# The filters


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Filter:
    """A filter of the integral and one or two biases, given by the matrices of one step."""

    step: float  # [s]
    transition: Floats
    noise: Floats

    def between(self) -> tuple[Floats, Floats]:
        """Transition and noise between two measurements."""
        whole, added = np.eye(len(self.noise)), np.zeros_like(self.noise)
        for _ in range(round(STEP / self.step)):
            whole, added = self.transition @ whole, self.transition @ added @ self.transition.T + self.noise
        return whole, added

    def stationary(self, r: float) -> tuple[Floats, Floats]:
        """Gain and covariance after a measurement of standard deviation r, from the recursion."""
        transition, added = self.between()
        p = np.diag([r**2, *[1e4 * self.noise[0, 0] / self.step**2] * (len(added) - 1)])
        for k in range(_LARGEST_NUMBER_OF_STEPS):
            before = transition @ p @ transition.T + added
            gain = before[:, 0] / (before[0, 0] + r**2)
            after = before - np.outer(gain, before[0])
            after = (after + after.T) / 2
            if k % 500 == 0 and np.all(np.abs(np.diag(after) / np.diag(p) - 1) < 1e-9):
                return gain, after
            p = after
        return gain, after


def filter_of(target: str, kind: str, text: str) -> Filter:
    """Process model of a target with the numbers of its file, as in the source of the target (see docs/how-to)."""
    keys = {
        "kalibr": (
            "gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density", "accelerometer_random_walk",
        ),
        "vins": ("gyr_n", "gyr_w", "acc_n", "acc_w"),
        "fast-lio": ("gyr_cov", "b_gyr_cov", "acc_cov", "b_acc_cov"),
        "px4": ("EKF2_GYR_NOISE", "EKF2_GYR_B_NOISE", "EKF2_ACC_NOISE", "EKF2_ACC_B_NOISE"),
        "ardupilot": ("EK3_GYRO_P_NSE", "EK3_GBIAS_P_NSE", "EK3_ACC_P_NSE", "EK3_ABIAS_P_NSE"),
    }[target]  # fmt: skip
    noise, walk = (
        float(re.findall(rf"^(?:1\t1\t|\s*){key}[:,\t]\s*([-+.\de]+)", text, flags=re.MULTILINE)[0])
        for key in (keys[:2] if kind == "gyro" else keys[2:])
    )
    dt = {"px4": 0.01, "ardupilot": 0.0125}.get(target, 1 / RATE)
    q = {
        "kalibr": (noise**2 * dt, walk**2 * dt),  # values in the file are densities
        "vins": (2 * (dt / 2) ** 2 * noise**2, (dt * walk) ** 2),  # two independent halves of a step
        "fast-lio": (dt**2 * noise, dt**2 * walk),  # variances of a sample
        "px4": ((dt * noise) ** 2, (dt * walk) ** 2),
        "ardupilot": ((dt * noise) ** 2, (dt**2 * walk) ** 2 / dt**2),  # the state is the bias times dt
    }[target]
    return Filter(step=dt, transition=np.array([[1.0, dt], [0.0, 1.0]]), noise=np.diag(q))


def third_state(kind: str, model: ChannelModel, noise: float) -> Filter:
    """A filter with a walk and a Gauss-Markov process, exactly discretised."""
    terms = dict(model.terms) | {term: limit / math.sqrt(3) for term, limit in model.limits.items()}
    truth = TrueNoise(terms=terms, gauss_markov=model.gauss_markov)
    chosen = find_third_state(truth, noise=noise, aiding=AIDING[kind], horizon=60.0)
    process = chosen.process
    assert process is not None
    decay = math.exp(-STEP / process.time)
    reach = process.time * (1 - decay)
    transition = np.array([[1.0, STEP, reach], [0.0, 1.0, 0.0], [0.0, 0.0, decay]])
    # Noise of a step: the sum over many short steps.
    fine = 200
    dt = STEP / fine
    short = np.array([[1.0, dt, dt], [0.0, 1.0, 0.0], [0.0, 0.0, math.exp(-dt / process.time)]])
    added = np.zeros((3, 3))
    q = np.diag([noise**2 * dt, chosen.walk**2 * dt, process.sigma**2 * (1 - math.exp(-2 * dt / process.time))])
    for _ in range(fine):
        added = short @ added @ short.T + q
    return Filter(step=STEP, transition=transition, noise=added)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """A ratio over the runs, and its standard error."""

    value: float
    error: float


def ratios(
    filters: list[Filter], kind: str, increments: Floats, bias: Floats, rng: np.random.Generator
) -> list[list[Ratio]]:
    """NEES of the bias, and ratio of the real to the stated error after the times, for filters that run in parallel."""
    r = AIDING[kind].deviation
    runs = len(increments)
    gains, lines, decays, stated = [], [], [], []
    for each in filters:
        gain, p = each.stationary(r)
        transition, added = each.between()
        pad = [0.0] * (3 - len(gain))
        gains.append([*gain, *pad])
        lines.append([*transition[0, 1:], *pad])
        decays.append([transition[1, 1], transition[2, 2] if len(gain) == 3 else 1.0])
        variances, now, done = [p[1:, 1:].sum()], p, 0
        for time in TIMES:
            while done < round(time / STEP):
                now, done = transition @ now @ transition.T + added, done + 1
            variances.append(now[0, 0])
        stated.append(variances)
    gain, line, decay = (np.array(values).T[:, :, None] for values in (gains, lines, decays))
    starts = [round((WARM_UP + k * SPACING) / STEP) for k in range(WINDOWS)]
    angle = np.zeros(runs)
    estimate, slow, fast = (
        np.zeros((len(filters), runs)),
        np.tile(bias[:, 0], (len(filters), 1)),
        np.zeros((len(filters), runs)),
    )
    travelled = np.cumsum(increments, axis=1)
    squares = np.zeros((len(filters), 1 + len(TIMES), runs))
    for k in range(starts[-1] + 1):
        angle = travelled[:, k]
        estimate = estimate + line[0] * slow + line[1] * fast
        slow, fast = decay[0] * slow, decay[1] * fast
        innovation = angle + r * rng.standard_normal(runs) - estimate
        estimate, slow, fast = estimate + gain[0] * innovation, slow + gain[1] * innovation, fast + gain[2] * innovation
        if k in starts:
            squares[:, 0] += (bias[:, k] - slow - fast) ** 2
            coasted, first, second, done = estimate, slow, fast, 0
            for j, time in enumerate(TIMES, 1):
                while done < round(time / STEP):
                    coasted, first, second = (
                        coasted + line[0] * first + line[1] * second,
                        decay[0] * first,
                        decay[1] * second,
                    )
                    done += 1
                squares[:, j] += (travelled[:, k + done] - coasted) ** 2
    squares /= WINDOWS
    results = []
    for errors_of_filter, variances in zip(squares, stated, strict=True):
        relative = errors_of_filter / np.array(variances)[:, None]
        mean, error = relative.mean(axis=1), relative.std(axis=1, ddof=1) / math.sqrt(runs)
        roots = [
            Ratio(value=math.sqrt(m), error=e / (2 * math.sqrt(m))) for m, e in zip(mean[1:], error[1:], strict=True)
        ]
        results.append([Ratio(value=mean[0], error=error[0]), *roots])
    return results


def judge_sensor(seed: int, kind: str, name: str) -> dict[str, list[list[float]]]:
    """Ratios with errors by filter, and the statement of the file; NEES, then the error after the times."""
    rng = np.random.default_rng(seed)
    sensor = SENSORS[kind][name]
    model = model_of(kind, sensor)
    noise = model.terms["random_walk"]
    increments, bias = simulated(kind, sensor, rng, round((WARM_UP + WINDOWS * SPACING + TIMES[-1]) / STEP) + 2, RUNS)
    # The files need both sensors; the second one is arbitrary.
    whole = {sensor_: model_of(sensor_, SENSORS[sensor_][name if sensor_ == kind else "K"]) for sensor_ in SENSORS}
    whole = {f"{sensor_}_x": channel for sensor_, channel in whole.items()}
    files = {
        target: export(
            NoiseModel(channels=whole),
            to=target,
            choices=Choices(filter_rate=None if target in ("px4", "ardupilot") else RATE),
        )
        for target in TARGETS
    }  # fmt: skip
    filters = {target: filter_of(target, kind, str(text)) for target, text in files.items()}
    filters["third state"] = third_state(kind, model, noise)
    chosen = filters["kalibr"]
    walk = math.sqrt(chosen.noise[1, 1] / chosen.step)
    if (kind, name) == ("gyro", "consumer MEMS"):
        dt = chosen.step
        tau = np.geomspace(1, 3e4, 400).round().astype(int)
        minimum = float(np.sqrt(model.avar(m=tau, tau0=1.0)).min())
        bare = sensor.k * _DEG_H / 60
        matched = export(
            NoiseModel(channels=whole), to="kalibr",
            choices=Choices(filter_rate=RATE, walk={"gyro": "horizon"}, horizon=60.0),
        )  # fmt: skip
        filters |= {
            "K": replace(chosen, noise=np.diag([noise**2, bare**2]) * dt),
            "horizon": filter_of("kalibr", kind, str(matched)),
            "OpenVINS": replace(chosen, noise=np.diag([(2 * noise) ** 2, (10 * bare) ** 2]) * dt),
            "imu_utils": replace(chosen, noise=np.diag([noise**2, minimum**2]) * dt),
        }
    estimates = ratios(list(filters.values()), kind, increments, bias, rng)
    result = {name_: [[each.value, each.error] for each in row] for name_, row in zip(filters, estimates, strict=True)}
    prepared = prepare(NoiseModel(channels=whole), to="kalibr", choices=Choices(filter_rate=RATE))
    statements = [
        f.details for f in prepared.findings if isinstance(f.details, PairConsistency) and f.details.sensor == kind
    ]
    # Without a finding, the filter is consistent.
    stated = [statements[0].nees, *(1 / each.share for each in statements[0].stated)] if statements else [1.0] * 4
    result["file"] = [[value, 0.0] for value in stated]
    result["walk"] = [[walk, 0.0]]
    return result


POLICIES: tuple[Unobserved, ...] = ("mean", "upper-limit", "absent")


def judge_fits(seed: int, kind: str, name: str) -> dict[str, list[list[float]]]:
    """NEES and ratio of the real to the stated error after 60 s, for filters with files of fitted models; a pair per
    record.
    """
    rng = np.random.default_rng(seed)
    sensor = SENSORS[kind][name]
    # The true K is drawn from the prior.
    sensor = replace(sensor, k=sensor.k or sensor.limit * rng.uniform(), limit=0.0)
    truth = model_of(kind, sensor)
    noise = TrueNoise(terms=truth.terms, gauss_markov=truth.gauss_markov)
    increments, _ = simulated(kind, sensor, rng, round(RECORD / STEP), RECORDS)
    results: dict[str, list[list[float]]] = {policy: [] for policy in ("observed or limit", *POLICIES)}
    for samples in increments / STEP:
        arrays: dict[str, Any] = {f"{kind}_x": samples}
        fitted = analyze(Record.from_arrays(rate=1 / STEP, **arrays), threads=1).model[f"{kind}_x"]
        second = "accel" if kind == "gyro" else "gyro"
        whole = NoiseModel(channels={f"{kind}_x": fitted, f"{second}_x": model_of(second, SENSORS[second]["K"])})
        bare = "observed" if "rate_random_walk" in fitted else "upper-limit"
        chosen: dict[str, Choices] = {policy: Choices(filter_rate=RATE, unobserved=policy) for policy in POLICIES}
        chosen["observed or limit"] = Choices(filter_rate=RATE, walk={kind: bare})
        for rule, choices in chosen.items():
            q = filter_of("kalibr", kind, str(export(whole, to="kalibr", choices=choices)))
            written = FilterModel(noise=math.sqrt(q.noise[0, 0] / q.step), walk=math.sqrt(q.noise[1, 1] / q.step))
            judged = judge_filter([noise], written, aiding=AIDING[kind], times=TIMES)
            results[rule].append([judged.nees, *(each.ratio for each in judged.coasting)])
    return results


def is_met(value: float, error: float, expected: float, limit: float) -> bool:
    """Whether a ratio is within a relative limit of its expectation, up to 3 standard errors."""
    return abs(value - expected) <= limit * expected + 3 * error


def main() -> None:
    """Run the study and write its page."""
    cells = {
        f"consistent {kind} {name}": (judge_sensor, (kind, name))
        for kind, sensors in SENSORS.items()
        for name in sensors
    }
    cells |= {
        f"fits {kind} {name}": (judge_fits, (kind, name)) for kind, sensors in SENSORS.items() for name in sensors
    }
    done = run("consistent", cells, settings=f"{RUNS} {WARM_UP} {WINDOWS} {SPACING} {SENSORS}")
    lines, failed, judged = [_HEAD.format(runs=RUNS, windows=WINDOWS)], 0, 0
    for kind, sensors in SENSORS.items():
        lines += [
            f"## {KINDS[kind]}", "",
            "| sensor | process model | bias NEES | error after 10 s | 60 s | 10 min |", "|---|---|---|---|---|---|",
        ]  # fmt: skip
        for name in sensors:
            result = done[f"consistent {kind} {name}"]
            stated = [value for value, _ in result["file"]]
            walk = result["walk"][0][0] * 60 / UNITS[kind][1]
            lines.append(
                f"| {name}, K = {walk:.3g} | *the file states* | "
                + " | ".join(f"{value:.2f}" for value in stated)
                + " |"
            )
            rows: dict[str, list[str]] = {}
            for target in TARGETS:
                texts = []
                for j, (value, error) in enumerate(result[target]):
                    good = is_met(value, error, 1.0 if j == 2 else stated[j], 0.10 if j == 2 else 0.15)
                    judged, failed = judged + 1, failed + (not good)
                    texts.append(f"{value:.2f} ± {error:.2f}" + ("" if good else " **missed**"))
                rows.setdefault(" | ".join(texts), []).append(target)
            lines += [f"| | {', '.join(targets)} | {row} |" for row, targets in rows.items()]
            texts = []
            for j, (value, error) in enumerate(result["third state"]):
                good = j > 0 or 0.8 - 3 * error <= value <= 1.25 + 3 * error
                judged, failed = judged + (j == 0), failed + (not good)
                texts.append(f"{value:.2f} ± {error:.2f}" + ("" if good else " **missed**"))
            lines.append("| | third state | " + " | ".join(texts) + " |")
        lines.append("")
    lines += [
        f"{judged - failed} of {judged} gates are met.",
        "",
        *_rules(done["consistent gyro consumer MEMS"]),
        *_fits(done),
    ]
    Path("docs/study/consistent.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _rules(result: Mapping[str, list[list[float]]]) -> list[str]:
    """Table of rules for K, for the consumer gyro."""
    rows = {
        "K": "N and K of the model",
        "horizon": "`--rate-random-walk gyro=horizon`, 60 s", "kalibr": "**consistent, the default**",
        "third state": "consistent, third state", "OpenVINS": "OpenVINS' rule: 2 N, 10 K",
        "imu_utils": "imu_utils: the lowest point of the Allan deviation as K",
    }  # fmt: skip
    lines = [_RULES, "| rule | bias NEES | error after 10 s | 60 s | 10 min |", "|---|---|---|---|---|"]
    for key, text in rows.items():
        lines.append(f"| {text} | " + " | ".join(f"{value:.2f}" for value, _ in result[key]) + " |")
    return lines


def _fits(done: Mapping[str, Mapping[str, list[list[float]]]]) -> list[str]:
    """Table of files of fitted models: medians, and the range of the error after 60 s."""
    lines = [_ON_FITS.format(records=RECORDS, hours=RECORD / 3600)]
    lines += ["| sensor | K of the file | bias NEES | error after 60 s | range |", "|---|---|---|---|---|"]
    texts: dict[str, str] = {"observed or limit": "observed, or the upper limit"}
    texts |= {policy: f"consistent, `{policy}`" for policy in POLICIES}
    for kind, sensors in SENSORS.items():
        for name in sensors:
            for rule, text in texts.items():
                values = np.array(done[f"fits {kind} {name}"][rule])
                nees, at_horizon = np.median(values[:, 0]), values[:, 2]
                first = f"{KINDS[kind].lower()}, {name}" if rule == "observed or limit" else ""
                lines.append(
                    f"| {first} | {text} | {nees:.2f} | {np.median(at_horizon):.2f} |"
                    f" {at_horizon.min():.2f} to {at_horizon.max():.2f} |"
                )
    return lines


_ON_FITS = """
## With fitted models

The same sensors, known from one record each of {hours:.0f} h at 5 Hz: what do filters with the files of {records} fits state
of their errors? Actual over stated, by the stationary analysis that the tables above confirm: medians over the records, and
the range after 60 s. The rows are rules for K: that of the fit (observed, or its upper limit), and consistent with terms
that were not observed at the mean variance (the default), at their upper limits, or absent. No gate: a fit of one record is
not exact.
"""

_HEAD = """# Is a filter with the exported N and K honest?

Made by `make study` (studies/consistent.py). A filter that has fields for N and K only states its error right after one
time, and [the file states](../how-to/README.md#what-you-have-to-choose) the error at other times. Here such filters run. The
truth is simulated apart from the program: flicker noise by its spectrum, walks and processes in time. Each filter is aided
every 0.2 s with an angle of 10⁻⁴ rad, or a velocity of 0.01 m/s. Its covariance follows from the numbers of its written
file by the recursion of the target. "Third state" is a filter with a walk and a Gauss–Markov process, by
`find_third_state`. The other targets have the process model of one of the rows:

| row | process model: what a step dt adds | targets |
|---|---|---|
| kalibr | densities: N²·dt to the angle, K²·dt to the bias | Kalibr, GTSAM, OpenVINS, EuRoC, LIO-SAM, ORB-SLAM3 |
| | the same | OKVIS2, Basalt, cuVSLAM, robot_localization |
| vins | two independent halves of a step | VINS-Mono, VINS-Fusion |
| fast-lio | variances of a sample | FAST-LIO |
| px4, ardupilot | parameters of a step of 10 or 12.5 ms | PX4 EKF2, ArduPilot EK3 |

OKVIS2 adds dt·σ² in each sample, as Kalibr's model does. Basalt and cuVSLAM make numbers of a sample from the rate in the
file, which is that of the samples; Basalt adds the walk once between two frames. In 0.2 s this leaves out K²·dt³/3 of the
angle, at most 0.02 % of N²·dt for these gyros. Hence their row is that of kalibr.

Cells are actual over stated: variance of the bias (NEES), and standard deviation of the angle or velocity without aiding;
more than 1 is overconfident. {runs} runs of {windows} times each, ± one standard error. Gates: after 60 s within 10 % of 1,
all others within 15 % of the file's statement, NEES with a third state from 0.8 to 1.25; each ± 3 standard errors. Targets
with the same digits share a row. K in deg/h/√h and µg/√h is the written one. That of *N only* was not observed: the truth
is drawn from 0 to its upper limit (20 and 50), which is what the file assumes.
"""

_RULES = """## Rules for K

The consumer gyro again: what does a filter with the K of other rules state? Actual over stated.
"""


if __name__ == "__main__":
    main()
