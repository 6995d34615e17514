"""Result of a temperature calibration: windows, polynomials, hysteresis and deviations by channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmatau import DeviationCurve
from sigmatau._version import __version__
from sigmatau.fitting import FittedTerm
from sigmatau.frozen import frozen
from sigmatau.io.atomic import atomic
from sigmatau.lab.temperature.bias_fit import Hysteresis
from sigmatau.lab.temperature.polynomial import BiasPolynomial
from sigmatau.results import Tabular, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels

TERMS = ("random_walk", "bias_instability", "rate_random_walk")
"""Noise coefficients that are estimated at each temperature."""


@frozen(eq=False)
class TemperatureWindow:
    """A channel at one temperature: a soak, a window of a ramp, or a run.

    Attributes
    ----------
    name : str
        Name of a run; empty for a part of a log.
    start, stop : float
        Times from the beginning of the log. [s]
    temperature : float
        Mean temperature. [°C]
    span : float
        Range of the temperature. [K]
    branch : {"rising", "falling", ""}
        Direction from which the temperature was reached; empty for a run.
    held : bool
        Whether the temperature was held.
    mean, low, high : float
        Mean of the channel with its interval, which does not include the change of the bias from one power-up to the
        next. [unit]
    terms : mapping of str to FittedTerm
        Random walk, bias instability and rate random walk; empty if the window is too short.
    """

    name: str
    start: float
    stop: float
    temperature: float
    span: float
    branch: str
    held: bool
    mean: float
    low: float | None
    high: float | None
    terms: Mapping[str, FittedTerm]

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(
            self,
            "name start_s=start stop_s=stop temperature_degc=temperature span_k=span branch held mean low high terms",
        )


@frozen(eq=False)
class ChannelCalibration:
    """Noise and bias of a channel over temperature.

    Attributes
    ----------
    channel, quantity, unit : str
        Name, quantity and SI unit of the channel.
    windows : tuple of TemperatureWindow
        Windows in order of time.
    polynomial : BiasPolynomial
    overall : mapping of str to FittedTerm
        Coefficients of the whole log without polynomial and hysteresis; empty for runs.
    hysteresis : Hysteresis or None
        None for runs, or if the temperature changed in only one direction.
    raw, compensated : DeviationCurve or None
        Allan deviation as recorded, and after the polynomial was subtracted; None for runs.
    run_spread : float or None
        Standard deviation of the bias from run to run; None for a log. [unit]
    """

    channel: str
    quantity: str
    unit: str
    windows: tuple[TemperatureWindow, ...]
    polynomial: BiasPolynomial
    overall: Mapping[str, FittedTerm] = field(default_factory=dict)
    hysteresis: Hysteresis | None = None
    raw: DeviationCurve | None = None
    compensated: DeviationCurve | None = None
    run_spread: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        curves = {
            name: plain(curve, "tau_s=tau adev", interval=[end.tolist() for end in curve.interval()])
            for name, curve in (("raw", self.raw), ("compensated", self.compensated))
            if curve is not None
        }
        return plain(self, "quantity unit windows overall polynomial hysteresis run_spread", curves=curves)


@frozen(eq=False)
class TemperatureCalibration(Mapping[str, ChannelCalibration], Tabular):
    """Noise and bias of a sensor over temperature: a mapping from channel to `ChannelCalibration`.

    Attributes
    ----------
    channels : mapping of str to ChannelCalibration
    source : str
        Name of the log, or of the folder of the runs.
    low, high : float
        Range of the observed temperatures. [°C]
    level : float
        Confidence level of the intervals.
    unit_name : str
        Serial number of the sensor; empty if not stated.
    remarks : tuple of str
        Facts that affect the numbers, in words.
    version : str
        Version of sigmatau that made the result.

    See Also
    --------
    calibrate_temperature : makes it from a log.
    calibrate_over_runs : makes it from runs at several temperatures.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={f"gyro_{axis}": {"random_walk": 1e-4} for axis in "xyz"})
    >>> rates = st.simulate(model, duration=3600, rate=2, rng=1).streams[0]
    >>> columns = {name: rates.column(name) for name in rates.channels}
    >>> log = st.Record.from_arrays(rate=2, temperature=np.linspace(0, 50, 7200), **columns)
    >>> result = st.calibrate_temperature(log, degree=1)
    >>> list(result), result["gyro_x"].hysteresis
    (['gyro_x', 'gyro_y', 'gyro_z'], None)
    >>> "TC_G0_X1_0" in result.export(to="px4")
    True
    """

    channels: Mapping[str, ChannelCalibration]
    source: str
    low: float
    high: float
    level: float
    unit_name: str = ""
    remarks: tuple[str, ...] = field(default=())
    version: str = __version__

    def __getitem__(self, channel: str) -> ChannelCalibration:
        try:
            return self.channels[channel]
        except KeyError:
            raise KeyError(f"no channel {channel!r}; channels: {', '.join(self.channels)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.channels)

    def plot(self, *channels: str, ax: Panels = None) -> Figure:
        """Draw the mean against temperature with its polynomial, and the Allan deviations as recorded and compensated.

        Parameters
        ----------
        *channels : str
            Names of the channels. Default: all.
        ax : sequence of matplotlib axes, optional
            Two axes for each channel of a log, one for each channel of runs. Default: a new figure.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.lab.temperature.figures import draw_calibration

        return draw_calibration(self, channels, ax=ax)

    def export(
        self, *, to: str, path: str | Path | None = None, instance: int | None = None, device_id: int = 0
    ) -> str:
        """Write the parameters of an autopilot: PX4 ``TC_*``, or ArduPilot ``INS_TCAL*``.

        Parameters
        ----------
        to : {"px4", "ardupilot"}
        path : str or Path, optional
            File to write. Default: none.
        instance : int, optional
            Number of the sensor in the autopilot. Default: the first, 0 of PX4 and 1 of ArduPilot.
        device_id : int
            ``device_id`` of the sensor, which PX4 compares with ``TC_G0_ID``. If it is 0, set it in the ground station.

        Returns
        -------
        str
            Content of the file.

        Raises
        ------
        OptionError
            For an unknown autopilot, an instance that it does not have, or a device id of more than 32 bits.
        DataError
            If a sensor lacks an axis, for a polynomial of a higher degree than 3, or if the file cannot be written.
        """
        from sigmatau.lab.temperature.firmware import parameter_file

        text = parameter_file(self, target=to, instance=instance, device_id=device_id)
        if path is not None:
            with atomic(Path(path)) as temporary:
                temporary.write_text(text, encoding="utf-8")
        return text

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, with units and version."""
        return {
            "sigmatau": self.version,
            "source": self.source,
            **({"unit": self.unit_name} if self.unit_name else {}),
            "low_degc": self.low,
            "high_degc": self.high,
            "level": self.level,
            "remarks": list(self.remarks),
            "channels": {name: result.to_dict() for name, result in self.items()},
        }

    def columns(self) -> dict[str, list[Any]]:
        """One row for each channel, window and coefficient in SI, see `Tabular.columns`."""
        names = (
            *("channel", "run", "temperature_degc", "branch", "start_s", "stop_s", "term"),
            *("value", "low", "high", "upper_limit", "unit"),
        )
        rows: list[tuple[Any, ...]] = []
        for channel, result in self.items():
            for window in result.windows:
                place = (channel, window.name, window.temperature, window.branch, window.start, window.stop)
                rows.append((*place, "mean", window.mean, window.low, window.high, None, result.unit))
                rows += [
                    (*place, name, term.value, term.low, term.high, term.upper_limit, term.unit)
                    for name, term in window.terms.items()
                ]
            rows += [
                (
                    channel,
                    "",
                    None,
                    "all",
                    None,
                    None,
                    name,
                    term.value,
                    term.low,
                    term.high,
                    term.upper_limit,
                    term.unit,
                )
                for name, term in result.overall.items()
            ]
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}

    def __repr__(self) -> str:
        from sigmatau.lab.temperature.text import printed

        return printed(self)
