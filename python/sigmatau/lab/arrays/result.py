"""Result of an analysis of an array of sensors."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau import Analysis, ChannelModel, NoiseModel, Record, write
from sigmatau._version import __version__
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.lab.arrays.codeviation import AllanCovariance, HatCurve
from sigmatau.lab.arrays.components import Component
from sigmatau.lab.arrays.goodness import Goodness
from sigmatau.lab.arrays.intervals import Correlation, Estimate
from sigmatau.lab.arrays.virtual_sensor import VirtualSensor
from sigmatau.noise.terms import NOISE
from sigmatau.results import Tabular, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.plot.style import Panels, Style

_LARGEST_CORRELATION = 0.999  # largest correlation in `model`: filters need a positive definite covariance [1]


@frozen(eq=False)
class ArrayAnalysis(Tabular):
    """Result of `analyze_array`.

    Attributes
    ----------
    names : tuple of str
        Channels of the sensors.
    sources : tuple of str
        File of each channel, if they are from several logs.
    quantity, unit : str
    samples : int
        Number of rows that were used.
    filled : int
        Number of them that were filled, because a sensor had no usable sample.
    tau0 : float
        Sample interval. [s]
    common : bool
        Whether a disturbance that all sensors have in common was eliminated (N-cornered hat).
    level : float
        Confidence level of the intervals.
    components : tuple of Component
        Noise components of the model.
    coefficients : mapping of str to mapping of str to Estimate
        Coefficients by component and channel. [SI]
    correlations : mapping of str to mapping of (str, str) to Correlation
        Correlation of each pair of channels, by component; one without a value is not observable. Empty with `common`.
    covariances : tuple of AllanCovariance
        Allan covariance of each pair of channels, including the common disturbance.
    hat : tuple of HatCurve
        Allan deviations by the N-cornered hat; empty without `common`.
    goodness : Goodness
    virtual : VirtualSensor or None
        The weighted mean with the least noise; None if the record is too short for weights, see `no_weights`.
    no_weights : str
        Reason why there are no weights.
    analysis : Analysis
        Analysis of the sensors; with `common`, of their differences.
    fused : ndarray, shape (samples,)
        Samples of the virtual sensor. [unit]
    version : str
        Version of sigmatau that made the result.

    See Also
    --------
    analyze_array : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={f"gyro_{k}": {"random_walk": 1e-4} for k in "abc"})
    >>> array = st.analyze_array(st.simulate(model, duration=600, rate=10, rng=1))
    >>> array.correlations["random_walk"]["gyro_a", "gyro_b"].observed
    True
    >>> round(array.virtual.weights.gain.value, 1)
    1.7
    """

    names: tuple[str, ...]
    sources: tuple[str, ...]
    quantity: str
    unit: str
    samples: int
    filled: int
    tau0: float
    common: bool
    level: float
    components: tuple[Component, ...]
    coefficients: Mapping[str, Mapping[str, Estimate]]
    correlations: Mapping[str, Mapping[tuple[str, str], Correlation]]
    covariances: tuple[AllanCovariance, ...]
    hat: tuple[HatCurve, ...]
    goodness: Goodness
    virtual: VirtualSensor | None
    no_weights: str
    analysis: Analysis
    fused: Floats
    version: str = __version__

    @property
    def model(self) -> NoiseModel:
        """Noise model of the sensors with their significant correlations, for filters that support correlation."""
        channels = {name: self._channel_model(name) for name in self.names}
        correlation: dict[str, dict[tuple[str, str], float]] = {}
        for term in NOISE:
            pairs = {
                pair: float(np.clip(each.value or 0.0, -_LARGEST_CORRELATION, _LARGEST_CORRELATION))
                for pair, each in self.correlations.get(term, {}).items()
                if each.correlated and all(term in channels[name] for name in pair)
            }
            if pairs:
                correlation[term] = pairs
        return NoiseModel(channels=channels, correlation=correlation)

    def _channel_model(self, name: str) -> ChannelModel:
        if name in self.analysis.fits:
            return self.analysis[name].to_model()
        terms = {c.name: self.coefficients[c.name][name] for c in self.components if c.time is None}
        return ChannelModel(
            terms={term: each.value for term, each in terms.items() if each.value is not None},
            quantity=self.quantity,
            unit=self.unit,
            rate=1 / self.tau0,
            duration=self.samples * self.tau0,
        )

    def write_fused(self, path: str | Path) -> None:
        """Write the samples of the virtual sensor as a log.

        Parameters
        ----------
        path : str or Path
            The file; its ending selects the format, see `sigmatau.write`.

        Raises
        ------
        DataError
            If there are no weights, or the file cannot be written.
        """
        write(self.fused_record, path)

    @property
    def fused_record(self) -> Record:
        """The samples of the virtual sensor as a record.

        Raises
        ------
        DataError
            If there are no weights.
        """
        if self.virtual is None:
            raise DataError(f"there is no virtual sensor: {self.no_weights}")
        unit = {self.virtual.channel: self.unit} if self.quantity == "signal" else {}
        arrays: dict[str, Any] = {self.virtual.channel: self.fused}
        return Record.from_arrays(rate=1 / self.tau0, unit=unit, **arrays)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        times = {c.name: c.time for c in self.components if c.time is not None}
        return {
            "array": {
                "channels": list(self.names),
                "sources": list(self.sources),
                "common": self.common,
                "level": self.level,
                "samples": self.samples,
                "filled": self.filled,
                "sample_rate_hz": 1 / self.tau0,
                "quantity": self.quantity,
                "unit": self.unit,
            },
            "sigmatau": self.version,
            "correlation_time_s": times,
            "coefficients": {
                term: {name: each.to_dict() for name, each in by.items()} for term, by in self.coefficients.items()
            },
            "correlations": {
                term: [{"channels": list(pair), **each.to_dict()} for pair, each in by.items()]
                for term, by in self.correlations.items()
            },
            "allan_covariance": [each.to_dict() for each in self.covariances],
            "hat": [each.to_dict() for each in self.hat],
            "goodness": self.goodness.to_dict(),
            "virtual": None if self.virtual is None else self.virtual.to_dict(),
            **({"no_weights": self.no_weights} if self.no_weights else {}),
            "findings": [plain(finding, "code severity message") for finding in self.analysis.findings],
        }

    def columns(self) -> dict[str, list[Any]]:
        """One row per number: coefficients, correlations, weights, and Allan covariances by averaging time. [SI]"""
        rows: list[tuple[Any, ...]] = []

        def add(kind: str, first: str, second: str, term: str, tau: float | None, each: Estimate) -> None:
            rows.append((kind, first, second, term, tau, each.value, each.low, each.high, each.upper_limit, each.unit))

        for term, by_channel in self.coefficients.items():
            for name, each in by_channel.items():
                add("coefficient", name, "", term, None, each)
        for term, by_pair in self.correlations.items():
            for (a, b), each in by_pair.items():
                add("correlation", a, b, term, None, each)
        if self.virtual is not None:
            for name, each in zip(self.names, self.virtual.weights.values, strict=True):
                add("weight", name, "", self.virtual.target, None, each)
            for term, each in self.virtual.coefficients.items():
                add("coefficient", self.virtual.channel, "", term, None, each)
        square = f"({self.unit})^2"
        for curve in self.covariances:
            for tau, *values in zip(curve.tau, curve.covariance, curve.low, curve.high, strict=True):
                value, low, high = map(float, values)
                each = Estimate(value=value, low=low, high=high, unit=square)
                add("allan covariance", curve.first, curve.second, "", float(tau), each)
        for hat in self.hat:
            for tau, value, low, high, limit in zip(hat.tau, hat.adev, hat.low, hat.high, hat.upper_limit, strict=True):
                is_value = bool(np.isfinite(value))
                each = Estimate(
                    value=float(value) if is_value else None,
                    low=float(low) if is_value else None,
                    high=float(high) if is_value else None,
                    upper_limit=None if is_value else float(limit),
                    unit=self.unit,
                )
                add("hat deviation", hat.channel, "", "", float(tau), each)
        names = ("kind", "channel", "with", "term", "tau_s", "value", "low", "high", "upper_limit", "unit")
        return {name: list(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}

    def plot(self, ax: Panels = None, *, style: Style = "screen") -> Figure:
        """Draw the deviations of the sensors and of the virtual sensor, and the correlation of each pair.

        Parameters
        ----------
        ax : sequence of two matplotlib axes, optional
            Default: a new figure.
        style : {"screen", "paper"}
            ``"paper"`` fits a column of a two-column paper.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.lab.arrays.figure import draw_array
        from sigmatau.plot.style import styled

        with styled(style):
            return draw_array(self, ax=ax)

    def __repr__(self) -> str:
        from sigmatau.lab.arrays.text import array_text

        return array_text(self)
