"""``sigmatau psd``: power spectral densities of a log, and their comparison with a noise model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from sigmatau._version import __version__
from sigmatau.analysis.inputs import read_model
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.declared import InMain, InMethod, InOutput, MayBeMinus, Quiet, Show, Texts
from sigmatau.cli.options import (
    check_outputs,
    check_style,
    drawing,
    say,
    with_noise,
    working,
    write_figure,
    write_result,
)
from sigmatau.cli.reading import ReadingOptions, read_log
from sigmatau.digits import round_to_error
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import damaged
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.shown import set_shown
from sigmatau.noise.terms import asked_density, check_shown, coefficient_unit, display_units
from sigmatau.record.record import Record, channel_quantities, stream_name
from sigmatau.spectrum.comparison import ModelComparison
from sigmatau.spectrum.estimate import psd
from sigmatau.spectrum.result import Method, Spectra, Spectrum
from sigmatau.units import find

_DATASHEET = {"angular_rate": "mdeg/s/sqrt(Hz)", "acceleration": "ug/sqrt(Hz)"}


def psd_command(
    log: Path,
    /,
    *,
    reading: ReadingOptions | None = None,
    method: Annotated[Method, InMethod] = "welch",
    segment: Annotated[str | None, InMethod] = None,
    tapers: Annotated[int | None, InMethod] = None,
    f_max: Annotated[str | None, InMethod] = None,
    axes: Annotated[list[str] | None, Texts, InMethod] = None,
    model: Annotated[Path | None, InMethod] = None,
    plot: Annotated[Path | None, InMain] = None,
    style: Annotated[Literal["screen", "paper"], InOutput] = "screen",
    json: Annotated[Path | None, MayBeMinus, InMain] = None,
    show: Show = None,
    quiet: Quiet = False,
) -> int:
    """Compute power spectral densities of every axis of a log of a sensor at rest.

    Parameters
    ----------
    log
        A log of any supported format, see sigmatau inspect.
    method
        Averaged segments for all frequencies (welch), or sine tapers of the record for low frequencies (multitaper).
    segment
        Length of the segments of welch, e.g. 40s. Longer segments reach lower frequencies with more scatter.
        Default: at most 4096 samples, and at least 15 segments in the record.
    tapers
        Number of tapers of multitaper (default 8). More tapers reduce the scatter and the frequency resolution.
    f_max
        Highest frequency of multitaper, e.g. 5Hz. Default: the band contains 4096 frequencies.
    axes
        Channels to use: gyro_x,accel_z, or gyro for all its axes. Default: all but temperatures.
    model
        Model file (.toml) or JSON of analyze for comparison: adds its density, and the ratio of the measured density to
        it by frequency band.
    plot
        Draw all axes: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Write the two-sided densities in thirds of an octave as JSON; - writes it to standard output.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_style(style, plot)
    check_outputs([log], plot=plot, json=json)
    options = _options(method, segment=segment, tapers=tapers, f_max=f_max)
    named = None if axes is None else [name.strip() for text in axes for name in text.split(",")]
    if model is not None:
        check_model(model)
    expected = None if model is None else read_model(model)
    record = read_log(log, reading, quiet=quiet)
    check_shown(channel_quantities(record), ["random_walk"])
    for finding in record.findings:
        say(str(finding), quiet=quiet)
    with working("computing densities", quiet=quiet):
        spectra = psd(_select_channels(record, named), method=method, **options)
    names = with_noise({name: spectra[name].density for name in spectra}, "power spectral density", quiet=quiet)
    spectra = Spectra({name: spectra[name] for name in names})
    compared = {} if expected is None else _compared(spectra, expected, model, quiet=quiet)
    if plot is not None:
        shown = None if expected is None else expected.of([name for name in expected.channels if name in spectra])
        with drawing(plot, style, quiet=quiet):
            write_figure(spectra.plot(model=shown), plot)
    tables = "\n\n".join(_table(spectra[name], compared.get(name)) for name in spectra)
    write_result(tables, _content(spectra, compared), json)
    return damaged(record.findings)


def _options(method: Method, *, segment: str | None, tapers: int | None, f_max: str | None) -> dict[str, Any]:
    """Collect the arguments of `sigmatau.psd`. Raises `OptionError` for an option of the other method."""
    asked = {
        "segment": (segment, "welch", "s"),
        "tapers": (tapers, "multitaper", ""),
        "f_max": (f_max, "multitaper", "Hz"),
    }
    arguments: dict[str, Any] = {}
    for name, (value, needed, unit) in asked.items():
        option = f"--{name.replace('_', '-')}"
        if value is not None and needed != method:
            raise OptionError(f"{option} needs --method {needed}, not {method}", option=name)
        if value is not None:
            arguments[name] = value_in_si(value, unit, option) if isinstance(value, str) else value
    return arguments


def _select_channels(record: Record, axes: list[str] | None) -> Record:
    """Select the named channels; by default all but temperatures, which drift."""
    if axes is None:
        chosen = [stream.channels if stream.quantity != "temperature" else () for stream in record.streams]
    else:
        for name in axes:
            if not any(name in (channel, stream_name(channel)) for channel in record.channels):
                raise OptionError(f"--axes {name}: the log has {', '.join(record.channels)}", option="axes")
        chosen = [tuple(c for c in s.channels if c in axes or stream_name(c) in axes) for s in record.streams]
    streams = [s.of(names) for s, names in zip(record.streams, chosen, strict=True) if names]
    if not streams:
        raise DataError("the log has temperatures only; name them with --axes to get their densities")
    return replace(record, streams=tuple(streams))


def _compared(spectra: Spectra, expected: NoiseModel, path: Path | None, *, quiet: bool) -> dict[str, ModelComparison]:
    modelled = [name for name in spectra if name in expected.channels]
    if not modelled:
        raise DataError(
            f"{path}: its channels are {', '.join(expected.channels)}, those of the log {', '.join(spectra)}"
        )
    compared: dict[str, ModelComparison] = {}
    for name in modelled:
        try:
            compared[name] = spectra[name].over(expected)
        except DataError as error:
            if len(modelled) == 1:
                raise
            say(f"warning: {error}", quiet=quiet)
    for name in spectra:
        if name not in modelled:
            say(f"warning: {name}: {path} has no model of it", quiet=quiet)
    return compared


def _table(spectrum: Spectrum, compared: ModelComparison | None) -> str:
    """Format one line per third of an octave: the density, its root in the unit of the random walk, and its root in the
    datasheet's unit.
    """
    bands = spectrum.binned(per_octave=3)
    low, high = bands.interval()
    middle = math.sqrt(float(np.median(bands.density)))
    asked = asked_density(spectrum.quantity, spectrum.unit, [middle])
    unit, factor = display_units("random_walk", spectrum.quantity, spectrum.unit, [middle])[0]
    root = "√S two-sided" if asked is None or asked.sided != "one" else "√(2S) one-sided"
    heading = f"{root} [{unit if asked is None else asked.bare}], 95 % interval"
    sheet = _DATASHEET.get(spectrum.quantity)
    # A signal without a datasheet unit is shown in its unit, with a prefix.
    datasheet_unit = (
        find(sheet, si=coefficient_unit("random_walk", spectrum.quantity, spectrum.unit)) if sheet else None
    )
    one_unit, one_factor = (
        (f"{spectrum.unit}/√Hz", 1.0) if datasheet_unit is None else (datasheet_unit.text, datasheet_unit.factor)
    )
    if datasheet_unit is None and asked is not None and asked.sided == "two":
        one_unit, one_factor = asked.bare, asked.factor
    kind = "sine tapers" if spectrum.method == "multitaper" else "segments"
    lines = [
        f"{spectrum.channel}: two-sided density S, {spectrum.segments} {kind}, resolution {spectrum.resolution:.3g} Hz",
        f"  {'f [Hz]':>10}  {f'S two-sided [{spectrum.density_unit}]':>30}  {heading:>42}"
        f"  {f'√(2S) one-sided [{one_unit}]':>30}",
    ]
    ratios = {} if compared is None else _ratios(compared)
    if ratios:
        lines[-1] += f"  {'S over the model, 95 % interval':>32}"
    for f, s, a, b in zip(bands.frequency, bands.density, low, high, strict=True):
        interval = " ".join(round_to_error(*(math.sqrt(x) / factor for x in (s, a, b))).cells)
        # Leakage of steep spectra biases these densities, see `Spectrum.trusted`.
        mark = " " if f >= spectrum.trusted else "~"
        power = round_to_error(s, a, b).value
        single = round_to_error(*(math.sqrt(2 * x) / one_factor for x in (s, a, b))).value
        line = f" {mark}{f:10.4g}  {power:>30}  {interval:>42}  {single:>30}"
        lines.append(f"{line}  {ratios.get(float(f), '-'):>32}" if ratios else line)
    without = "; bands that begin below this frequency have no ratio" if ratios else ""
    lines.append(f"  ~ below {spectrum.trusted:.3g} Hz a density that falls as steeply as 1/f² is biased{without}")
    if compared is not None:
        lines += [f"  {text}" for text in (compared.statement(), compared.notes()) if text]
    return "\n".join(lines)


def _ratios(compared: ModelComparison) -> dict[float, str]:
    """Format the ratio of each band, keyed by the frequency of the band."""
    low, high = compared.interval()
    rows = zip(compared.frequency, compared.ratio, low, high, strict=True)
    return {float(f): " ".join(round_to_error(*ends).cells) for f, *ends in rows}


def _content(spectra: Spectra, compared: Mapping[str, ModelComparison]) -> dict[str, Any]:
    channels: dict[str, Any] = {}
    for name, spectrum in spectra.items():
        channels[name] = spectrum.binned(per_octave=3).to_dict() | {"trusted_from_hz": spectrum.trusted}
        if name in compared:
            channels[name]["over_model"] = compared[name].to_dict()
    return {"sigmatau": __version__, "sided": "two", "channels": channels}
