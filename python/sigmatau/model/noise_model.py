"""Noise models of the channels of a sensor, from a file, from a fit, or by hand."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any, Protocol, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, command
from sigmatau.io.atomic import atomic
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import read_channels, read_correlation, toml
from sigmatau.model.turn_on import TurnOn
from sigmatau.noise.terms import NOISE
from sigmatau.record.record import stream_name
from sigmatau.results import Printed, lines_text

Correlation = Mapping[str, Mapping[tuple[str, str], float]]

_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}


class _WithModel(Protocol):
    @property
    def model(self) -> NoiseModel: ...


@frozen(eq=False)
class NoiseModel(Mapping[str, ChannelModel], Printed):
    """The noise of the channels of a sensor, in SI and continuous form: a mapping from channel to `ChannelModel`.

    Attributes
    ----------
    channels : mapping of str to ChannelModel
        A plain mapping from term to coefficient is accepted: ``{"gyro_x": {"random_walk": 8.7e-5}}``; terms as in
        `sigmatau.noise.terms.TERMS`. Names that begin with ``gyro_`` or ``accel_`` are rates of rotation and accelerations.
    correlation : mapping of str to mapping of (str, str) to float
        Correlation of the noise of two channels, by term, −1 … 1: ``{"random_walk": {("gyro_x", "gyro_y"): 0.3}}``.
        All other pairs are independent.

    Raises
    ------
    DataError
        If there is no channel, a channel is not a model, or a correlation names an unknown term or channel.

    See Also
    --------
    ChannelModel : the noise of one channel.
    sigmatau.simulate : a record with this noise.
    sigmatau.predict : navigation errors caused by this noise.

    Examples
    --------
    >>> from sigmatau import NoiseModel
    >>> NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}, "accel_x": {"random_walk": 1e-3}})
    gyro_x: angle random walk 0.343775 deg/√h
    accel_x: velocity random walk 0.06 m/s/√h
    """

    channels: Mapping[str, ChannelModel]
    correlation: Correlation = field(default_factory=dict)

    def __init__(
        self, *, channels: Mapping[str, ChannelModel | Mapping[str, float]], correlation: Correlation | None = None
    ) -> None:
        if not channels:
            raise DataError("the model has no channel; give at least one, e.g. [channels.gyro_x]")
        object.__setattr__(self, "channels", {name: _channel(name, model) for name, model in channels.items()})
        object.__setattr__(self, "correlation", {term: dict(pairs) for term, pairs in (correlation or {}).items()})
        self._check_correlation()

    def __getitem__(self, channel: str) -> ChannelModel:
        return self._require_channel(channel)

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.channels)

    def _check_correlation(self) -> None:
        for term, pairs in self.correlation.items():
            if term not in NOISE:
                raise DataError(f"correlation of {term!r}: only {', '.join(NOISE)} may be correlated")
            for (a, b), value in pairs.items():
                for name in (a, b):
                    if term not in self.channels.get(name, {}):
                        raise DataError(f"correlation of {term}: the model has no {term} of a channel {name!r}")
                if a == b or (b, a) in pairs:
                    raise DataError(f"correlation of {term} between {a} and {b}: give each pair of two channels once")
                if self.channels[a].bandwidth != self.channels[b].bandwidth and term == "random_walk":
                    raise DataError(f"correlation of {term}: {a} and {b} have different bandwidths")
                if not (math.isfinite(value) and -1 <= value <= 1):
                    raise DataError(f"correlation of {term} between {a} and {b} must be −1 to 1, not {value!r}")
            if np.linalg.eigvalsh(self.correlation_matrix(term)).min() < -1e-9:
                raise DataError(f"correlations of {term} contradict each other: no noise has all of them")

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """The model of a model file. The model of a result is ``Analysis.from_json(path).model``.

        Parameters
        ----------
        path : str or Path
            The file, in TOML.

        Returns
        -------
        NoiseModel

        Raises
        ------
        DataError
            If the file cannot be read or is invalid; names channel, key and value.
        """
        import tomllib

        path = Path(path)
        if path.suffix.lower() == ".json":
            raise DataError(f"{path}: not a model file (.toml). If this is a result: Analysis.from_json(path).model")
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8-sig"))  # Windows editors write a byte order mark
        except OSError as error:
            raise DataError(f"{path}: {error.strerror or error}") from None
        except (ValueError, RecursionError) as error:  # errors of TOML and Unicode are kinds of ValueError
            if path.suffix.lower() == ".toml":
                raise DataError(f"{path}: not a TOML file: {error}") from None
            raise DataError(
                f"{path}: not a model file (.toml), result (.json) or, for sigmatau export, YAML (.yaml). If this is a log:"
                f" first {command('analyze', str(path), Hint('json', value=path.with_suffix('.json')))}"
            ) from None
        try:
            return cls.from_dict(content)
        except ValueError as error:
            raise DataError(f"{path}: {error}") from None

    @classmethod
    def from_result(cls, result: _WithModel) -> NoiseModel:
        """The model of a result of `sigmatau.analyze`: ``result.model``.

        Parameters
        ----------
        result : Analysis
            A result with fits.

        Returns
        -------
        NoiseModel

        Raises
        ------
        DataError
            If no channel has a fit.
        """
        return result.model

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """The model of a parsed model file.

        Parameters
        ----------
        content : mapping
            ``{"channels": {"gyro_x": {"random_walk": "0.3 deg/sqrt(h)"}}}``.

        Returns
        -------
        NoiseModel

        Raises
        ------
        DataError
            For an unknown key or a wrong value; names channel and key.
        """
        unknown = sorted(set(content) - {"channels", "correlation"})
        if unknown:
            raise DataError(
                f"unknown key {unknown[0]!r}; a model file has tables [channels.NAME] and [correlation.TERM]"
            )
        return cls(channels=read_channels(content), correlation=read_correlation(content))

    def correlation_matrix(self, term: str) -> NDArray[np.float64]:
        """Correlation of the noise of one term between the channels.

        Parameters
        ----------
        term : str
            A key of `sigmatau.noise.terms.TERMS`.

        Returns
        -------
        ndarray, shape (n_channels, n_channels)
            Correlations, −1 to 1.
        """
        names = list(self.channels)
        matrix = np.eye(len(names))
        for (a, b), value in self.correlation.get(term, {}).items():
            i, j = names.index(a), names.index(b)
            matrix[i, j] = matrix[j, i] = value
        return matrix

    def of(self, channels: Iterable[str]) -> NoiseModel:
        """A model of some of the channels.

        Parameters
        ----------
        channels : iterable of str
            Names of the channels.

        Returns
        -------
        NoiseModel
        """
        names = list(channels)
        for name in names:
            self._require_channel(name)
        pairs_inside = {
            term: {pair: value for pair, value in pairs.items() if set(pair) <= set(names)}
            for term, pairs in self.correlation.items()
        }
        return NoiseModel(
            channels={n: self.channels[n] for n in names}, correlation={t: p for t, p in pairs_inside.items() if p}
        )

    def expand_matern(self, *, rate: float) -> NoiseModel:
        """The model with Gauss-Markov processes in place of Matérn processes, see `ChannelModel.expand_matern`.

        Parameters
        ----------
        rate : float
            Sampling rate of the samples or of the filter. [Hz]

        Returns
        -------
        NoiseModel

        Raises
        ------
        OptionError
            For a rate that is not positive.
        """
        channels = {name: channel.expand_matern(rate=rate) for name, channel in self.channels.items()}
        return replace(self, channels=channels)

    def with_turn_on(self, spreads: Mapping[str, TurnOn]) -> NoiseModel:
        """The model with the turn-on bias of some channels, for exports that have a field for it.

        Parameters
        ----------
        spreads : mapping of str to TurnOn
            By channel, as `measure_turn_on` returns them.

        Returns
        -------
        NoiseModel

        Raises
        ------
        DataError
            If the model lacks a channel.

        See Also
        --------
        measure_turn_on : measures the spread between power-ups.

        Examples
        --------
        >>> import sigmatau as st
        >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
        >>> model.with_turn_on({"gyro_x": st.TurnOn(sigma=1e-3)})
        gyro_x: angle random walk 0.343775 deg/√h, turn-on bias 206.3 deg/h, stated
        """
        lacking = [name for name in spreads if name not in self.channels]
        if lacking:
            raise DataError(f"turn-on bias of {', '.join(lacking)}: the model has no such channel")
        channels = {
            name: replace(channel, turn_on=spreads[name]) if name in spreads else channel
            for name, channel in self.channels.items()
        }
        return NoiseModel(channels=channels, correlation=self.correlation)

    def avar(self, channel: str, *, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
        """Expected Allan variance of a channel.

        Parameters
        ----------
        channel : str
            Name of the channel.
        m, tau0
            As in `ChannelModel.avar`.

        Returns
        -------
        ndarray, shape (n_tau,)
            [(rate unit)²]
        """
        return self._require_channel(channel).avar(m=m, tau0=tau0)

    @overload
    def adev(  # type: ignore[overload-overlap]  # a text is an ArrayLike
        self,
        channel: str,
        /,
        tau: ArrayLike | None = None,
        *,
        m: ArrayLike | None = None,
        tau0: float | None = None,
    ) -> NDArray[np.float64]: ...

    @overload
    def adev(self, tau: ArrayLike, /) -> dict[str, NDArray[np.float64]]: ...

    def adev(
        self, channel: Any, /, tau: Any = None, *, m: Any = None, tau0: Any = None
    ) -> NDArray[np.float64] | dict[str, NDArray[np.float64]]:
        """Expected Allan deviation of a channel, or at averaging times by channel: ``model.adev([0.1, 1, 10])``.

        Parameters
        ----------
        channel : str or array_like
            Name of the channel; or the averaging times, for all channels.
        tau, m, tau0
            As in `ChannelModel.adev`.

        Returns
        -------
        ndarray, shape (n_tau,), or dict of them by channel
            [rate unit]
        """
        if isinstance(channel, str):
            return self._require_channel(channel).adev(tau, m=m, tau0=tau0)
        return {name: model.adev(channel) for name, model in self.channels.items()}

    def psd(self, channel: str, f: ArrayLike, *, tau0: float | None = None) -> NDArray[np.float64]:
        """Two-sided power spectral density of a channel.

        Parameters
        ----------
        channel : str
            Name of the channel.
        f, tau0
            As in `ChannelModel.psd`.

        Returns
        -------
        ndarray, shape (n_f,)
            [(rate unit)²/Hz]
        """
        return self._require_channel(channel).psd(f, tau0=tau0)

    def _require_channel(self, channel: str) -> ChannelModel:
        try:
            return self.channels[channel]
        except KeyError:
            raise KeyError(f"no channel {channel!r}; channels: {', '.join(self.channels)}") from None

    def to_toml(self) -> str:
        """The model as text of a model file, in SI. The coefficients read back to the same bits.

        For a model from a result, intervals and limits are written as comments, because the file has no key for them.
        Comments are not read back.
        """
        return toml(self.channels, self.correlation)

    def write(self, path: str | Path) -> None:
        """Write a model file.

        Parameters
        ----------
        path : str or Path
            The file; an existing one is replaced.

        Raises
        ------
        DataError
            If it cannot be written.
        """
        with atomic(path) as temporary:
            temporary.write_text(self.to_toml(), encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, by channel."""
        correlation = {
            term: [{"channels": list(pair), "value": value} for pair, value in pairs.items()]
            for term, pairs in self.correlation.items()
        }
        return {
            "channels": {name: channel.to_dict() for name, channel in self.channels.items()},
            **({"correlation": correlation} if correlation else {}),
        }

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NoiseModel) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash(tuple(self.channels))

    def __repr__(self) -> str:
        lines = [f"{name}: {channel!r}" for name, channel in self.channels.items()]
        for term, pairs in self.correlation.items():
            shown = itertools.islice(pairs.items(), 15)
            lines.append(f"correlation of {term}: " + ", ".join(f"{a} {b} {value:+.2g}" for (a, b), value in shown))
        return lines_text(lines)


def _channel(name: str, model: ChannelModel | Mapping[str, float]) -> ChannelModel:
    quantity = _QUANTITIES.get(stream_name(name))
    try:
        if not isinstance(model, ChannelModel):
            if quantity is None:
                raise DataError("names begin with gyro_ or accel_; give another signal as a ChannelModel with its unit")
            return ChannelModel(terms=model, quantity=quantity[0], unit=quantity[1])
    except DataError as error:
        raise DataError(f"channel {name!r}: {error}") from None
    if quantity is not None and (model.quantity, model.unit) != quantity:
        raise DataError(
            f"channel {name!r}: such a name means {quantity[0].replace('_', ' ')} in {quantity[1]}, not"
            f" {model.quantity.replace('_', ' ')} in {model.unit}"
        )
    return model
