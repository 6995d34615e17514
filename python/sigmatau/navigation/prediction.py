"""Predicted navigation errors and how they are printed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import Floats
from sigmatau.digits import round_to_error
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, worded
from sigmatau.model.channel import alike_text
from sigmatau.navigation.error_covariance import EARTH_RADIUS, Earth
from sigmatau.noise.shown import error_unit
from sigmatau.noise.terms import TERMS
from sigmatau.record.record import stream_name
from sigmatau.results import WIDTH, Printed, duration_text, lines_text, wrapped
from sigmatau.units import STANDARD_GRAVITY, find

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from sigmatau.plot.style import Panels


_OTHER_LABELS = {
    "gauss_markov": "Gauss-Markov process",
    "resonance": "resonance",
    "sinusoid": "sinusoid",
    "turn_on": "turn-on bias",
}
_MIN_SHARE = 0.01
"""Smallest share that is printed."""

_SAME_LIMIT = 1.005
"""Ratio of a limit to the end of the interval up to which the limit is not printed."""

_MIN_SHARES = 32
"""Columns that the shares need next to the other cells of a row; with fewer columns they are printed below."""

_QUANTITIES = {"gyro": "angular_rate", "accel": "acceleration"}
_VALID_UP_TO = {"roll": 0.2, "pitch": 0.2, "velocity": 1000.0, "position": EARTH_RADIUS / 100}
"""Errors above which the equations, for small tilts near the start, do not hold. [rad, m/s, m]"""

_BIAS_UNITS = {"gyro": "deg/h", "accel": "mg"}
_ERRORS = {"rad": "angle", "m/s": "velocity", "m": "position"}


@frozen(eq=False)
class PredictedError(Printed):
    """One error against time.

    Attributes
    ----------
    name : str
        ``"heading"``, ``"roll"``, ``"pitch"``, ``"velocity_x"``, ``"position_x"`` …
    unit : str
        SI: rad, m/s, m.
    after : ndarray, shape (n_times,)
        [s]
    rms : ndarray, shape (n_times,)
        √(std² + mean²). [unit]
    std, mean : ndarray, shape (n_times,)
        Standard deviation from noise, and mean from ramps, with its sign. [unit]
    low, high : ndarray or None, shape (n_times,)
        Interval of the error from the errors of the coefficients, with the limits of terms that were not observed; None
        if the error of no coefficient is known. [unit]
    shares : mapping of (str, str) to ndarray, shape (n_times,)
        Parts of rms², by channel and term; they add up to 1. The part of correlated noise may be negative. [1]
    at_most : ndarray or None, shape (n_times,)
        Error with terms that were not observed or cannot be distinguished at their limits, and the others at the upper
        end of the interval; None if the model has no limits. [unit]
    tilt_without : str
        The gyro whose tilt is omitted because the model lacks it; empty otherwise.
    """

    name: str
    unit: str
    after: Floats
    rms: Floats
    std: Floats
    mean: Floats
    low: Floats | None
    high: Floats | None
    shares: Mapping[tuple[str, str], Floats]
    at_most: Floats | None = None
    tilt_without: str = ""

    def __post_init__(self) -> None:
        for array in (
            self.after,
            self.rms,
            self.std,
            self.mean,
            self.low,
            self.high,
            self.at_most,
            *self.shares.values(),
        ):
            if array is not None:
                array.setflags(write=False)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns in SI."""
        shares: dict[str, dict[str, list[float]]] = {}
        for (channel, part), share in self.shares.items():
            shares.setdefault(channel, {})[part] = share.tolist()
        content: dict[str, Any] = {
            "unit": self.unit,
            "rms": self.rms.tolist(),
            "std": self.std.tolist(),
            "mean": self.mean.tolist(),
            "shares": shares,
        }
        if self.low is not None and self.high is not None:
            content |= {"low": self.low.tolist(), "high": _finite(self.high)}
        if self.at_most is not None:
            content["at_most"] = _finite(self.at_most)
        if self.tilt_without:
            content["tilt_without"] = self.tilt_without
        return content

    def _limit_beyond(self, k: int) -> float | None:
        """The value of `at_most` at a time, if it is larger than the end of the interval."""
        if self.at_most is None or (self.high is not None and self.at_most[k] <= _SAME_LIMIT * self.high[k]):
            return None
        return float(self.at_most[k])

    @property
    def is_beyond(self) -> bool:
        """Whether `at_most` is larger than the end of the interval at any time."""
        return any(self._limit_beyond(k) is not None for k in range(len(self.after)))

    @property
    def large(self) -> NDArray[np.bool_]:
        """Whether the error is larger than the range of the equations; shape (n_times,)."""
        return self.rms > _VALID_UP_TO.get(self.name.partition("_")[0], math.inf)

    def rows(self, *, duration: float | None = None) -> list[tuple[str, ...]]:
        """Time, rms, interval, unit, upper limit, shares, mean and remarks of each time, as they are printed.

        Parameters
        ----------
        duration : float, optional
            Length of the record of the model; longer times are marked. [s]

        Returns
        -------
        list of tuple of str
        """
        unit, factor = error_unit(self.unit)
        rows: list[tuple[str, ...]] = []
        for k, after in enumerate(self.after.tolist()):
            edges = (None, None) if self.low is None or self.high is None else (self.low[k], self.high[k])
            value, interval = round_to_error(
                self.rms[k] / factor, *(None if edge is None else float(edge) / factor for edge in edges)
            ).cells
            causes = sorted(((float(share[k]), key) for key, share in self.shares.items()), reverse=True)
            parts = [f"{_label(*key)} {100 * s:.0f} %" for s, key in causes if abs(s) >= _MIN_SHARE]
            if self.mean[k]:
                parts.append(f"mean {self.mean[k] / factor:+.3g} {unit}")
            if self.tilt_without:
                parts.append(f"tilt left out: no {self.tilt_without}")
            if duration is not None and after > duration:
                parts.append(f"beyond the record of {duration_text(duration)}")
            if self.large[k]:
                parts.append("too large for these equations")
            beyond = self._limit_beyond(k)
            limit = "" if beyond is None else f"at most {float(f'{beyond / factor:.3g}'):g}"
            rows.append((duration_text(after), value, interval, unit, limit, ", ".join(parts)))
        return rows

    def __repr__(self) -> str:
        return lines_text(_table([("", "after", "rms", "", "", "", ""), *_named(self)]))


@frozen(eq=False)
class Prediction(Mapping[str, PredictedError], Printed):
    """Errors of free inertial navigation at rest: a mapping from error to `PredictedError`.

    Attributes
    ----------
    errors : mapping of str to PredictedError
    after : ndarray, shape (n_times,)
        [s]
    calibration : float or None
        Length of the time before the start whose mean rates are subtracted. [s]
    rate : float
        [Hz]
    earth : {"round", "flat"}
    turn_on : mapping of str to float
        Standard deviations of constant biases, by channel. [unit of the rate]
    level : float
        Probability of the intervals.
    flicker_error : float
        Largest relative error of the Allan deviation of the flicker noise.
    flicker_in_records : tuple of float or None
        Without a calibration: smallest and largest ratio of the errors by flicker noise in a record of `simulate`,
        where only its first sample is 0, to those predicted here, where all its processes are 0 at the start. [1]
    as_known : tuple of (str, str)
        Channels and parts whose errors are unknown or not in the model. The intervals contain no error for them.
    not_seen : tuple of (str, str)
        Channels and terms that were not observed: 0 in `rms`, at their limits in `at_most`.
    undecided : tuple of (str, str)
        Channels and terms of which the record shows at least one, but not which.
    alike_from : mapping of str to float
        Channels whose record shows a rate random walk or a Gauss-Markov process with at least this correlation time,
        but not which; the intervals include both. [s]
    duration : float or None
        Length of the shortest record of the model; None if the model is not from a record. [s]
    limit_level : float
        Probability of the limits in `at_most`.
    """

    errors: Mapping[str, PredictedError]
    after: Floats
    calibration: float | None
    rate: float
    earth: Earth
    turn_on: Mapping[str, float] = field(default_factory=dict)
    level: float = 0.95
    flicker_error: float = 0.0
    flicker_in_records: tuple[float, float] | None = None
    as_known: tuple[tuple[str, str], ...] = ()
    not_seen: tuple[tuple[str, str], ...] = ()
    undecided: tuple[tuple[str, str], ...] = ()
    alike_from: Mapping[str, float] = field(default_factory=dict)
    duration: float | None = None
    limit_level: float = 0.95

    def __getitem__(self, error: str) -> PredictedError:
        try:
            return self.errors[error]
        except KeyError:
            raise KeyError(f"no error {error!r}; predicted: {', '.join(self.errors)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.errors)

    def __len__(self) -> int:
        return len(self.errors)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns in SI, by error."""
        return {
            "after_s": self.after.tolist(),
            "calibration_s": self.calibration,
            "rate_hz": self.rate,
            "earth": self.earth,
            "turn_on": dict(self.turn_on),
            "level": self.level,
            "flicker_in_records": None if self.flicker_in_records is None else list(self.flicker_in_records),
            "as_known": [list(key) for key in self.as_known],
            "not_seen": [list(key) for key in self.not_seen],
            "undecided": [list(key) for key in self.undecided],
            "alike_from_s": dict(self.alike_from),
            "record_s": self.duration,
            "errors": {name: error.to_dict() for name, error in self.errors.items()},
        }

    def plot(self, ax: Panels = None, *, marked: ArrayLike | None = None) -> Figure:
        """Draw the errors against time, with one panel each for angles, velocities and positions.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.
        marked : array_like, shape (n_marked,), optional
            Times to mark with a dot; the nearest computed ones are marked. Default: all. [s]

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import COLOURS
        from sigmatau.plot.style import label_axes, legend, make_panels, parent_figure, whole_decades

        times = self.after if marked is None else np.atleast_1d(np.asarray(marked, float))
        units = [unit for unit in _ERRORS if any(error.unit == unit for error in self.values())]
        panels = make_panels(ax, len(units), columns=len(units), width=4.6, height=4.2)
        for panel, unit in zip(panels, units, strict=True):
            text, factor = error_unit(unit)
            shown = [(name, error) for name, error in self.items() if error.unit == unit]
            for k, (name, error) in enumerate(shown):
                look: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)]}
                if error.low is not None and error.high is not None:
                    panel.fill_between(
                        error.after, error.low / factor, error.high / factor, **look, alpha=0.2, linewidth=0
                    )
                look["markevery"] = sorted({int(np.argmin(np.abs(np.log(error.after / time)))) for time in times})
                panel.loglog(error.after, error.rms / factor, **look, marker="o", markersize=4, label=name)
                if error.at_most is not None:
                    panel.loglog(error.after, error.at_most / factor, "--", color=look["color"], linewidth=1)
            if any(error.at_most is not None for _, error in shown):
                panel.plot([], [], "--", color="0.4", linewidth=1, label="at most, with terms that were not observed")
            whole_decades(panel)
            label_axes(panel, "time since the start [s]", f"error of the {_ERRORS[unit]}, rms [{text}]")
            legend(panel)
        return parent_figure(panels[0])

    def notes(self) -> list[str]:
        """Sentences with the assumptions of the prediction."""
        if self.calibration is not None:
            lines = [
                f"The mean rates of the {duration_text(self.calibration)} before the start are subtracted;"
                " level accelerometers are levelled instead.",
                "Roll and pitch do not contain the error of levelling: the bias of an accelerometer over g.",
            ]
        else:
            lines = ["The initial state is assumed to be known: walks and flicker noise begin at 0."]
            lines.append(
                "Biases at turn-on: "
                + ", ".join(_bias(name, value) for name, value in self.turn_on.items())
                + " (standard deviations)."
                if self.turn_on
                else worded(
                    f"A bias at turn-on, which no record at rest shows, is not included: give it ({Hint('turn_on')}),"
                    " or calibrate."
                )
            )
        if self.flicker_in_records is not None:
            smallest, largest = (f"{ratio:.2g}" for ratio in self.flicker_in_records)
            lines += [
                "Flicker noise that begins at 0 causes the smallest error. In simulated records only its first sample is 0,"
                f" and its part of these errors is {smallest if smallest == largest else f'{smallest} to {largest}'} times"
                " as large; after a calibration, records and prediction agree.",
            ]
        if self.earth == "flat":
            lines.append("Flat Earth: without Schuler's feedback.")
        if self.flicker_error:
            lines.append(
                f"Bias instability is approximated: its Allan deviation is correct to {100 * self.flicker_error:.2g} %."
            )
        if any(error.low is not None for error in self.errors.values()):
            names = ", ".join(_label(*key) for key in self.as_known)
            limits = (
                f" and the {100 * self.limit_level:g} % limits of terms that were not observed" if self.not_seen else ""
            )
            lines.append(
                f"[ ]: {100 * self.level:g} % interval by the errors of the coefficients{limits}"
                + (f"; assumed to be known: {names}." if names else ".")
            )
        lines += [f"{name}: {alike_text(time)}; the interval includes both." for name, time in self.alike_from.items()]
        if self.not_seen:
            lines.append("Not observed in the record, and 0 in the rms: " + _by_channel(self.not_seen) + ".")
        if self.undecided:
            lines.append(
                "Not distinguished from other noise; the rms contains the best fit: "
                + ", ".join(_label(*key) for key in self.undecided)
                + "."
            )
        if self.undecided or any(error.is_beyond for error in self.errors.values()):
            lines.append(f"At most: the rms with each of these terms at its {100 * self.limit_level:g} % limit.")
        if self.duration is not None and self.after[-1] > self.duration:
            lines.append(
                f"Beyond the {duration_text(self.duration)} of the record, the noise was not measured: slower noise may"
                " make the errors larger, and no interval accounts for it."
            )
        upwards = self.errors.get("position_z")
        growth = math.sqrt(EARTH_RADIUS / (2 * STANDARD_GRAVITY))
        if upwards is not None and self.earth == "round" and self.after[-1] > growth:
            lines.append(f"Height is unstable: without an aid, its error grows e-fold every {duration_text(growth)}.")
        if any(error.large.any() for error in self.errors.values()):
            lines.append(
                "Too large for the equations, valid for tilts below 0.2 rad, speeds below 1 km/s, distances below 64 km."
            )
        return lines

    def __repr__(self) -> str:
        head = f"error of unaided inertial navigation at rest, steps of {1 / self.rate:g} s"
        rows: list[tuple[str, ...]] = [("", "after", "rms", "", "", "", "shares of the mean square")]
        for error in self.errors.values():
            rows += _named(error, duration=self.duration)
        return lines_text([head, *_table(rows), *wrapped(self.notes())])


def _finite(values: Floats) -> list[float | None]:
    """Plain values; None for infinite ones, which JSON does not have."""
    return [value if math.isfinite(value) else None for value in values.tolist()]


def _label(channel: str, part: str) -> str:
    """Name of a part of a channel, as printed by `analyze`; for correlated channels of different kinds, their common
    name.
    """
    quantity = _QUANTITIES.get(stream_name(channel), "signal") if " " not in channel else "signal"
    return f"{channel} {TERMS[part].label(quantity) if part in TERMS else _OTHER_LABELS[part]}"


def _by_channel(keys: Iterable[tuple[str, str]]) -> str:
    """``"gyro_x quantization, rate ramp; accel_x rate ramp"``: gyros first."""
    parts: dict[str, list[str]] = {}
    for channel, part in sorted(keys, key=lambda key: (stream_name(key[0]) != "gyro", key[0])):
        parts.setdefault(channel, []).append(_label(channel, part).removeprefix(f"{channel} "))
    return "; ".join(f"{channel} {', '.join(labels)}" for channel, labels in parts.items())


def _bias(channel: str, value: float) -> str:
    unit = find(_BIAS_UNITS[stream_name(channel)])
    return f"{channel} {value / unit.factor:.3g} {unit.text}"


def _named(error: PredictedError, *, duration: float | None = None) -> list[tuple[str, ...]]:
    return [(error.name if k == 0 else "", *row) for k, row in enumerate(error.rows(duration=duration))]


def _table(rows: list[tuple[str, ...]]) -> list[str]:
    """Align rows; last cells that do not fit in the line are printed below."""
    shown = [k for k in range(len(rows[0])) if k == len(rows[0]) - 1 or any(row[k] for row in rows)]
    rows = [tuple(row[k] for k in shown) for row in rows]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]) - 1)]
    indent = sum(widths) + 2 * len(widths)
    lines = []
    for row in rows:
        line = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False))
        if WIDTH - indent >= _MIN_SHARES:
            lines += wrapped([f"{line}  {row[-1]}".rstrip()], indent=indent)
        else:
            below = widths[0] + 2
            lines += [line.rstrip(), *(wrapped([" " * below + row[-1]], indent=below) if row[-1] else [])]
    return lines
