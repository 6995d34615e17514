"""The result of an analysis, with its figures and exports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast, overload

import numpy as np
from numpy.typing import NDArray

from sigmatau._version import __version__
from sigmatau.analysis import json, text
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves
from sigmatau.findings.finding import Findings
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.overview import trust
from sigmatau.fitting.read_off import ReadOff
from sigmatau.frozen import frozen
from sigmatau.quality.means import ChannelMean
from sigmatau.quality.selection.rest import Rest, reason_without_fits
from sigmatau.record.mask import ChannelMask
from sigmatau.record.record import Provenance
from sigmatau.record.sampling import Sampling
from sigmatau.results import TablesByChannel, Tabular

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.estimators.stability import DynamicAllan
    from sigmatau.exporting.choices import Choices
    from sigmatau.exporting.source import Source
    from sigmatau.model.noise_model import NoiseModel
    from sigmatau.plot.style import Panels, Style

_FIRST_COLUMNS = ("channel", "term", "value", "low", "high", "unit", "observed", "trust")


WITHOUT_CURVE = ("out_of_range", "constant_channel", "too_few_samples")
"""Codes of findings of channels without a curve."""


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
    grids : mapping of str to Sampling
        Samples, rate, its source and missing samples by stream; empty for a result that was read.
    stability : mapping of str to DynamicAllan
        Dynamic Allan deviation by channel; empty if it was not requested.
    mean_stability : mapping of str to tuple of MeanStability
        Standard deviations of 10 s and 100 s means by channel, if the record has ten means or more.
    rest : Rest or None
        Whether the sensor is at rest. If it is not, there are curves but no coefficients. None for curves alone.
    masks : mapping of str to ChannelMask
        Excluded samples by channel, see `mask`. Empty for curves alone, and for results of earlier versions.
    means : mapping of str to ChannelMean
        Mean of each channel, with its error if the noise averages out. Empty for curves alone.
    options : AnalysisOptions
        Options of `analyze` that affect the numbers; those of curves alone are the defaults.
    notes : mapping of str to str
        Information about the record from the user: serial number, run, temperature …
    version : str
        Version of sigmatau that made the result.

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

    _dimensions = ("channel", "term")

    source: Provenance
    findings: Findings
    curves: Curves
    fits: Fits
    read_off: Mapping[str, ReadOff]
    grids: Mapping[str, Sampling]
    stability: Mapping[str, DynamicAllan] = field(default_factory=dict)
    mean_stability: Mapping[str, tuple[MeanStability, ...]] = field(default_factory=dict)
    rest: Rest | None = None
    masks: Mapping[str, ChannelMask] = field(default_factory=dict)
    means: Mapping[str, ChannelMean] = field(default_factory=dict)
    options: AnalysisOptions = field(default_factory=AnalysisOptions)
    notes: Mapping[str, str] = field(default_factory=dict)
    version: str = __version__

    def __post_init__(self) -> None:
        trusted = {
            name: fitted if fitted.trust is not None else replace(fitted, trust=trust(fitted, self.findings, name))
            for name, fitted in self.fits.items()
        }
        object.__setattr__(self, "fits", Fits(trusted))

    to_dict = json.to_dict
    to_json = json.to_json
    headline = text.headline
    overview = text.overview
    summary = text.summary
    sections = text.sections
    legend = text.legend
    coefficients = text.coefficients
    __repr__ = text.printed
    _repr_html_ = text.html

    @classmethod
    def from_json(cls, source: str | bytes | Path) -> Self:
        """Read the JSON of an analysis from any version of sigmatau.

        `grids` are not in the JSON.

        Parameters
        ----------
        source : str, bytes or Path
            JSON, as a text that begins with a brace or as bytes; or the name of a file.

        Returns
        -------
        Analysis

        Raises
        ------
        DataError
            If the file cannot be read or is not a result; the error names the place of a wrong value.

        See Also
        --------
        Analysis.to_json : writes it.

        Examples
        --------
        >>> import sigmatau as st
        >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
        >>> analysis = st.analyze(st.simulate(model, duration=600, rate=10, rng=1))
        >>> st.Analysis.from_json(analysis.to_json())["gyro_x"].verdict
        'adequate'
        """
        from sigmatau.analysis.reading import read_analysis

        return cast(Self, read_analysis(source))

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """Read an analysis from parsed JSON, such as `to_dict`.

        Parameters
        ----------
        content : mapping
            ``Analysis.to_dict()``, or parsed JSON of ``sigmatau analyze``.

        Returns
        -------
        Analysis

        Raises
        ------
        DataError
            If the content is not a result; the error names the place of a wrong value.
        """
        from sigmatau.analysis.reading import as_analysis, result_of_dict

        return cast(Self, as_analysis(result_of_dict(content)))

    def mask(self, channel: str) -> ChannelMask:
        """Samples of the record that were not used, by reason: missing, left out by the user, moving, spikes and so on.

        Parameters
        ----------
        channel : str
            Channel of the record.

        Returns
        -------
        ChannelMask
            `excluded` is an array with True for each sample of the record that was not used.

        Raises
        ------
        KeyError
            If the record has no such channel.
        DataError
            If the result lacks the samples: it is of curves alone, or from JSON of an earlier version.

        Examples
        --------
        >>> import numpy as np
        >>> import sigmatau as st
        >>> rates = 1e-3 * np.random.default_rng(1).standard_normal(60_000)
        >>> rates[5000], rates[100:110] = 1.0, np.nan
        >>> mask = st.analyze(st.Record.from_arrays(rate=100, gyro_x=rates)).mask("gyro_x")
        >>> mask
        gyro_x: 11 of 60000 samples not used, in 2 stretches
        >>> mask.spans[1]
        ExcludedSpan(start=5000, stop=5001, reason='spikes')
        >>> rates[~mask.excluded].size
        59989
        """
        if channel in self.masks:
            return self.masks[channel]
        if self.masks and channel not in self.curves:
            raise KeyError(f"no channel {channel!r}; channels: {', '.join(self.masks)}")
        raise DataError(
            f"this result does not list the samples of {channel} that were left out; analyze the record again"
        )

    @property
    def used(self) -> dict[str, NDArray[np.float64]]:
        """Beginnings and ends of the stretches that were analysed, by channel with a curve; shape (n_spans, 2). [s]"""
        return {channel: self.masks[channel].used for channel in self.curves if channel in self.masks}

    @property
    def model(self) -> NoiseModel:
        """The noise model of the channels that have one; see `NoiseFit.to_model`.

        Raises
        ------
        DataError
            If no channel has one.
        """
        from sigmatau.fitting.to_model import to_models
        from sigmatau.model.noise_model import NoiseModel

        models = to_models(self.fits)
        if models:
            return NoiseModel(channels=models)
        raise DataError(self.reason_without_fits or "no channel of this result has a model")

    @property
    def reason_without_fits(self) -> str:
        """Reason why there is no fit: motion, a record that is too short to tell, or a method that reads off; empty with
        fits.
        """
        return "" if self.fits else reason_without_fits(self.rest, has_read_off=any(self.read_off.values()))

    def __getitem__(self, channel: str) -> NoiseFit:
        """The fit of a channel. For a channel without a fit, the `KeyError` has the reason."""
        if channel in self.fits or channel not in self.curves:
            available = self.fits or self.curves
            if channel not in available:
                lost = [
                    finding.message
                    for finding in self.findings
                    if channel in finding.channels and finding.code in WITHOUT_CURVE
                ]
                why = f" ({lost[0]})" if lost else ""
                raise KeyError(f"no channel {channel!r}{why}; channels: {', '.join(available)}")
            return self.fits[channel]
        why = (
            self.rest.reason
            if self.rest is not None and text.is_moving(self)
            else "the coefficients were read off: .read_off has them"
        )
        raise KeyError(f"no fit of {channel!r}: {why}")

    def __iter__(self) -> Iterator[str]:
        """Iterate over the channels with a fit; ``"gyro_x" in analysis`` is true if there is ``analysis["gyro_x"]``."""
        return iter(self.fits)

    def plot(self, *channels: str, ax: Panels = None, style: Style = "screen") -> Figure:
        """Draw the curves with their intervals and fits, with one panel for each stream.

        Parameters
        ----------
        *channels : str
            Names of the channels. Default: all. A panel with one channel has a line for each term, with its value.
        ax : matplotlib axes, or sequence of them, optional
            One per panel. Default: a new figure.
        style : {"screen", "paper"}
            ``"paper"`` fits a column of a two-column paper.

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
            One per channel. Default: a new figure.

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

    @overload
    def export(self, *, to: str, path: None = None, choices: Choices | None = None) -> str: ...

    @overload
    def export(self, *, to: str, path: str | Path, choices: Choices | None = None) -> str | bytes: ...

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
        from sigmatau.exporting.of_analysis import source_of_analysis

        return source_of_analysis(
            self.model,
            fits=self.fits,
            curves=self.curves,
            findings=self.findings,
            origin=self.source,
            version=self.version,
        )

    def columns(self) -> dict[str, list[Any]]:
        """One row per channel and term, with the trust of each value; see `Tabular.columns`."""
        if self.read_off and not self.fits:
            return TablesByChannel(self.read_off).columns()
        columns = self.fits.columns()
        columns["trust"] = [self.fits[name].trust for name in columns["channel"]]
        keys = zip(columns["channel"], columns["term"], strict=True)
        lines = (self.read_off.get(name, {}).get(term) for name, term in keys)
        columns["plus_minus"] = [None if line is None else line.error for line in lines]
        return {name: columns[name] for name in dict.fromkeys((*_FIRST_COLUMNS, *columns))}
