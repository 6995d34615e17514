"""The result of an analysis: what it holds, prints, draws and writes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._version import __version__
from sigmatau.errors import OptionError, as_arguments
from sigmatau.estimators.allan import Curves
from sigmatau.findings.finding import Findings
from sigmatau.findings.wording import causes, words
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.overview import overview, overview_rows, trust
from sigmatau.fitting.read_off import ReadOff
from sigmatau.fitting.tables import fit_legend, fit_table, read_off_legend, read_off_table
from sigmatau.frozen import frozen
from sigmatau.model.noise_model import NoiseModel
from sigmatau.quality.means import ChannelMean
from sigmatau.quality.selection.rest import Rest
from sigmatau.record.record import Provenance, stream_name
from sigmatau.results import TablesByChannel, Tabular, duration_text, html_table, printable, wrapped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.estimators.stability import DynamicAllan
    from sigmatau.exporting.choices import Choices
    from sigmatau.exporting.source import Source
    from sigmatau.plot.style import Panels, Style

SCHEMA = 2
"""Version of the JSON form; a JSON Schema of it is in sigmatau/schema."""

_FIRST_COLUMNS = ("channel", "term", "value", "low", "high", "unit", "observed", "trust")


def failed_result(
    path: str | Path, message: str, *, exit_code: int, notes: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """The JSON form of an analysis that failed: why, and no channels."""
    return {
        "schema": SCHEMA,
        "sigmatau": __version__,
        "source": {"path": str(path)},
        **({"notes": dict(notes)} if notes else {}),
        "error": {"message": message, "exit_code": exit_code},
        "findings": [],
        "channels": {},
    }


_RESTING = {
    "at_rest": "at rest",
    "partly_at_rest": "at rest in part",
    "not_at_rest": "not at rest",
    "too_short_to_tell": "too short to tell whether at rest",
    "assumed": "taken as at rest",
}

WITHOUT_CURVE = ("out_of_range", "constant_channel", "too_few_samples")
"""Codes of findings of channels without a curve."""


_REAL = ("rate", "scale", "offset", "taus", "tau_min")


def _as_typed(name: str, value: Any) -> Any:  # noqa: ANN401  of any option
    """An option as the command line has it, so that 100 and 100.0 are the same."""
    if name not in _REAL or isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return {key: float(of) for key, of in value.items()}
    return [float(of) for of in value] if isinstance(value, Sequence) else float(value)


@frozen(eq=False)
class Analysis(Tabular):
    """Result of `analyze`.

    Attributes
    ----------
    source : Provenance
    findings : Findings
        A tuple of `Finding`: faults of the record and other facts that affect the results.
    curves : Curves
        Allan deviation by channel; a channel that cannot be analysed is absent and has a finding.
    fits : Fits
        Mapping of channel to `NoiseFit`, coefficients with intervals; empty if they were only read off.
        ``analysis["gyro_x"]`` is ``analysis.fits["gyro_x"]``; its `trust` is that of the findings.
    read_off : mapping of str to ReadOff
        Coefficients by the paper's method, by channel.
    grids : mapping of str to str
        Samples, rate and length by stream, in words.
    stability : mapping of str to DynamicAllan
        Dynamic Allan deviation by channel; empty if it was not requested.
    mean_stability : mapping of str to tuple of MeanStability
        Standard deviations of 10 s and 100 s means by channel, where the record has ten means or more.
    rate_source : str
        Where the sampling rate comes from: ``"given"``, ``"time stamps"`` …
    rest : Rest or None
        Whether the sensor is at rest. If it is not, there are curves but no coefficients. None for curves alone.
    used : mapping of str to ndarray, shape (n_spans, 2)
        By channel, beginnings and ends of the stretches that were analysed, from the beginning of the record. Samples
        between them are missing, or were left out. Empty for curves alone. [s]
    means : mapping of str to ChannelMean
        Mean of each channel, with its error where the noise averages out. Empty for curves alone.
    options : mapping
        Settings of `analyze` that are not the default and matter for the numbers, as plain values.
    notes : mapping of str to str
        Information about the record from the user: serial number, run, temperature …

    See Also
    --------
    analyze : makes it.
    report : writes it as a page.
    compare_runs : compares several.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> analysis = st.analyze(st.simulate(model, duration=600, rate=10, rng=1))
    >>> round(analysis["gyro_x"]["random_walk"].to("deg/sqrt(h)"), 2)
    0.34
    >>> analysis["gyro_x"].verdict, [finding.code for finding in analysis.findings]
    ('adequate', [])
    """

    source: Provenance
    findings: Findings
    curves: Curves
    fits: Fits
    read_off: Mapping[str, ReadOff]
    grids: Mapping[str, str]
    stability: Mapping[str, DynamicAllan] = field(default_factory=dict)
    mean_stability: Mapping[str, tuple[MeanStability, ...]] = field(default_factory=dict)
    rest: Rest | None = None
    rate_source: str = ""
    used: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    means: Mapping[str, ChannelMean] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    notes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        trusted = {name: replace(one, trust=trust(one, self.findings, name)) for name, one in self.fits.items()}
        object.__setattr__(self, "fits", Fits(trusted))

    def to_dict(self) -> dict[str, Any]:
        """The stable JSON form, schema 2: plain values, no NaN."""
        return {
            "schema": SCHEMA,
            "sigmatau": __version__,
            "source": self.source.to_dict(),
            **self._options_to_dict(),
            **({"notes": dict(self.notes)} if self.notes else {}),
            **({} if self.rest is None else {"rest": self.rest.to_dict()}),
            "findings": [finding.to_dict() for finding in self.findings],
            "channels": {
                channel: {
                    "quantity": curve.quantity,
                    "sample_rate_hz": 1 / curve.tau0,
                    "samples": curve.n,
                    **({"mean": self.means[channel].to_dict()} if channel in self.means else {}),
                    "curve": curve.to_dict(),
                    "read_off": self.read_off[channel].to_dict() if channel in self.read_off else {},
                    **self._fit_to_dict(channel),
                    **self._means_to_dict(channel),
                    **({"stability": self.stability[channel].to_dict()} if channel in self.stability else {}),
                }
                for channel, curve in self.curves.items()
            },
        }

    def _options_to_dict(self) -> dict[str, Any]:
        """What made the result, beside the log: the same log with the same options is the same run."""
        stated = {"reading": dict(self.source.options), "analysis": dict(self.options)}
        stated = {
            of: {name: _as_typed(name, value) for name, value in options.items()}
            for of, options in stated.items()
            if options
        }
        return {"options": stated} if stated else {}

    def _fit_to_dict(self, channel: str) -> dict[str, Any]:
        if channel not in self.fits:
            return {}
        fitted = self.fits[channel]
        return {"fit": fitted.to_dict(), "trust": fitted.trust}

    def _means_to_dict(self, channel: str) -> dict[str, Any]:
        found = self.mean_stability.get(channel, ())
        return {"mean_stability": [one.to_dict() for one in found]} if found else {}

    @property
    def model(self) -> NoiseModel:
        """The noise model of the channels that have one; see `NoiseModel.from_result`. Raises `DataError` if none has."""
        return NoiseModel.from_result(self.to_dict())

    def __getitem__(self, channel: str) -> NoiseFit:
        """The fit of a channel; the `KeyError` of any other says why there is none."""
        if channel in self.fits or channel not in self.curves:
            known = self.fits or self.curves
            if channel not in known:
                lost = [
                    words(one).message for one in self.findings if channel in one.channels and one.code in WITHOUT_CURVE
                ]
                why = f" ({lost[0]})" if lost else ""
                raise KeyError(f"no channel {channel!r}{why}; channels: {', '.join(known)}")
            return self.fits[channel]
        why = (
            self.rest.reason
            if self.rest is not None and self._moving
            else "the coefficients were read off: .read_off has them"
        )
        raise KeyError(f"no fit of {channel!r}: {why}")

    def __iter__(self) -> Iterator[str]:
        """The channels with a fit, so that ``"gyro_x" in analysis`` tells whether there is ``analysis["gyro_x"]``."""
        return iter(self.fits)

    def plot(self, *channels: str, ax: Panels = None, style: Style = "screen") -> Figure:
        """Draw the curves with their intervals and fits, with one panel for each stream.

        Parameters
        ----------
        *channels : str
            Which channels. Default: all. A panel with one channel has a line of each term, with its value.
        ax : matplotlib axes, or sequence of them, optional
            One a panel. Default: a new figure.
        style : {"screen", "paper"}
            ``"paper"``: for a column of a two-column paper.

        Returns
        -------
        matplotlib figure
        """
        from sigmatau.plot.curves import draw_analysis
        from sigmatau.plot.style import styled

        curves = {name: self.curves[name] for name in channels or self.curves}
        with styled(style):
            return draw_analysis(curves, self.read_off, self.fits, ax=ax)

    def plot_stability(self, ax: Panels = None) -> Figure:
        """Draw the dynamic Allan deviation of each channel, which must have been requested.

        Parameters
        ----------
        ax : matplotlib axes, or sequence of them, optional
            One a channel. Default: a new figure.

        Returns
        -------
        matplotlib figure

        Raises
        ------
        OptionError
            If it was not requested.
        """
        if not self.stability:
            raise OptionError(
                "no dynamic Allan deviation was asked for: analyze(…, stability=True)", option="stability"
            )
        from sigmatau.plot.stability import draw_all

        return draw_all(self.stability, ax=ax)

    def export(self, *, to: str, path: str | Path | None = None, choices: Choices | None = None) -> str | bytes:
        """Write the fitted model for another program; see `sigmatau.export`.

        The sampling rate is that of the record if `choices` has none.

        Parameters
        ----------
        to, path, choices
            See `sigmatau.export`.

        Returns
        -------
        str or bytes
            The content of the file.

        Raises
        ------
        OptionError
            As `sigmatau.export`.
        DataError
            As `sigmatau.export`.
        """
        from sigmatau.exporting.export import export

        return export(self.to_source(), to=to, path=path, choices=choices)

    def to_source(self) -> Source:
        """The input of an export: the model, the sampling rates and the filters."""
        from sigmatau.exporting.source import Source

        return Source.of_result(self.to_dict())

    def headline(self, *, name: bool = True, rest: bool = True) -> str:
        """The record in a line.

        Parameters
        ----------
        name : bool
            Whether the line begins with the name of the file.
        rest : bool
            Whether it says that the sensor is at rest, or not.

        Returns
        -------
        str
            Axes, rate and where that comes from, and length.
        """
        curves = list(self.curves.values())
        rates = dict.fromkeys(f"{1 / curve.tau0:.5g}" for curve in curves)
        source = f" ({self.rate_source.partition(' in ')[0].partition(',')[0]})" if self.rate_source else ""
        words = [
            f"{len(curves)} {'axis' if len(curves) == 1 else 'axes'} at {' and '.join(rates)} Hz{source}",
            duration_text(max(curve.n * curve.tau0 for curve in curves)),
        ]
        if rest and self.rest is not None:
            words.append(_RESTING["assumed" if self._moving and self.fits else self.rest.verdict])
        file = "" if self.source.path is None or not name else f"{Path(self.source.path).name}: "
        return printable(file + ", ".join(words))

    @property
    def _moving(self) -> bool:
        return self.rest is not None and not self.rest.is_usable

    def _without_coefficients(self) -> str:
        return f"{'not at rest' if self.rest is None else self.rest.reason or 'not at rest'}: no coefficients"

    def overview(self, *, width: int = 80, legend: bool = True) -> str:
        """One line on the record, and one row of main coefficients for each axis, as the command line prints them.

        Parameters
        ----------
        width : int
            Columns of the terminal.
        legend : bool
            Whether a line explains the trust.

        Returns
        -------
        str
        """
        if self.read_off and not self.fits:
            return self.summary()
        table = [overview(self.fits, self.findings, width=width, legend=legend)] if self.fits else []
        return "\n".join([self.headline(), *table])

    def summary(self) -> str:
        """The record in a line, the grid and all coefficients of each sensor, and what they are, as the command line prints
        them with ``--verbose``.
        """
        return "\n\n".join(filter(None, [self.headline(), *self.sections().values(), self.legend()]))

    def sections(self) -> dict[str, str]:
        """By sensor, its grid and the table of its coefficients."""
        sensors = dict.fromkeys([*self.grids, *map(stream_name, self.curves)])
        parts = {}
        for sensor in sensors:
            own = [channel for channel in self.curves if stream_name(channel) == sensor]
            grid = wrapped([self.grids.get(sensor, "")])
            parts[sensor] = "\n".join(filter(None, [*grid, self._table(own)]))
        return {sensor: text for sensor, text in parts.items() if text}

    def _table(self, channels: Sequence[str]) -> str:
        fits = {channel: self.fits[channel] for channel in channels if channel in self.fits}
        if fits:
            return fit_table(fits, self.read_off, self.mean_stability)
        return read_off_table({channel: self.read_off[channel] for channel in channels if channel in self.read_off})

    def legend(self) -> str:
        """What the numbers of `sections` are; or why there are none."""
        if not self.fits and not self.read_off:
            return self._without_coefficients()
        return fit_legend(self.fits, means=self.mean_stability) if self.fits else read_off_legend(self.read_off)

    def coefficients(self) -> str:
        """The table of all coefficients without their legend; or why there are none."""
        return self._table([*self.curves]) or self._without_coefficients()

    def columns(self) -> dict[str, list[Any]]:
        """A row a channel and term, with how far to trust it; see `Tabular.columns`."""
        if self.read_off and not self.fits:
            return TablesByChannel(self.read_off).columns()
        columns = self.fits.columns()
        columns["trust"] = [self.fits[name].trust for name in columns["channel"]]
        return {name: columns[name] for name in dict.fromkeys((*_FIRST_COLUMNS, *columns))}

    def _repr_html_(self) -> str:
        import html

        told = "".join(f"<li>{html.escape(line)}</li>" for line in self._causes())
        if not self.fits:
            return f"<p>{html.escape(self.headline())}</p><pre>{html.escape(self.coefficients())}</pre><ul>{told}</ul>"
        from sigmatau.plot.terminal import sparkline

        head, *rows = overview_rows(self.fits, self.findings)
        shown = [(*head, "σ(τ)")]
        for row in rows:
            curve = self.curves.get(row[0])
            shown.append((*row, "" if curve is None else sparkline(curve.tau, curve.adev)))
        return f"<p>{html.escape(self.headline())}</p>{html_table(shown, ready={len(head)})}<ul>{told}</ul>"

    def __repr__(self) -> str:
        return "\n".join([self.overview(), *self._causes()])

    def _causes(self) -> list[str]:
        return [as_arguments(line) for line in causes(self.findings, rest="analysis.findings")]
