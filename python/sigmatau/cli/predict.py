"""``sigmatau predict``: error growth of unaided inertial navigation at rest."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from sigmatau.analysis import Analysis
from sigmatau.analysis.inputs import is_result, require_model
from sigmatau.analysis.reading import read_analysis
from sigmatau.cli.datasheet import check_model
from sigmatau.cli.declared import Show
from sigmatau.cli.options import (
    check_outputs,
    check_style,
    drawing,
    say,
    working,
    write_figure,
    write_result,
)
from sigmatau.errors import OptionError
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.navigation.predict import predict
from sigmatau.navigation.prediction import Prediction
from sigmatau.noise.shown import check_units, set_shown
from sigmatau.record.record import stream_name
from sigmatau.typed.pairs import key_values

_RATE = 100.0  # Default number of steps per second, which only affects the velocity error of quantization noise. [Hz]
_SPAN, _POINTS = 1000.0, 50
"""Ratio of the last to the first time of a figure, and number of times in addition to those of ``--after``.
"""


def predict_command(
    source: Path,
    /,
    *,
    after: str,
    calibration: str | None = None,
    rate: float | None = None,
    turn_on: Annotated[list[str] | None, Parameter(negative=())] = None,
    earth: Literal["round", "flat"] = "round",
    channels: Annotated[list[str] | None, Parameter(negative=())] = None,
    plot: Path | None = None,
    style: Literal["screen", "paper"] = "screen",
    show: Show = None,
    json: Annotated[bool, Parameter(negative=())] = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Predict the error growth of unaided inertial navigation at rest: attitude, velocity, position, by noise term.

    Parameters
    ----------
    source
        A model file (.toml), or the JSON that analyze writes.
    after
        Times from the start, with units: 60s,10min.
    calibration
        Time at rest before the start, with its unit. The mean rate over this time is subtracted, which levels the unit
        and removes the bias. Default: no calibration; the initial state is known, and random walks and flicker noise
        start at 0. In simulated records only the first sample is 0, so their errors are larger by a factor that the
        result states.
    rate
        Steps per second in Hz. Default: the sampling rate of the result, or 100.
    turn_on
        Standard deviation of a constant bias, without --calibration: gyro="10 deg/h" or accel_x="1 mg".
        Default: none.
    earth
        Shape of the Earth: round, with Schuler feedback, or flat.
    channels
        Channels to use. Default: all.
    plot
        Draw the errors against time up to the last time of --after: .png, .svg or .pdf.
    style
        Style of figures: screen, or paper, for the width of a column or a page of a paper.
    json
        Print JSON instead of text.
    quiet
        Print only errors on standard error.
    """
    set_shown(show)
    check_style(style, plot)
    check_outputs([source], plot=plot)
    times = [_time(text, "after") for text in after.split(",")]
    average = None if calibration is None else _time(calibration, "calibration")
    check_model(source)
    analysis = read_analysis(source) if is_result(source) else None
    model = NoiseModel.read(source) if analysis is None else require_model(analysis, source)
    if channels:
        for name in channels:
            if name not in model.channels:
                raise OptionError(f"--channels {name}: {source} has {', '.join(model.channels)}", option="channels")
        model = model.of(channels)
    expanded = [name for name, channel in model.items() if channel.matern]
    if expanded:
        say(
            f"{', '.join(expanded)}: a Matérn process counts as the sum of Gauss-Markov processes that it is",
            quiet=quiet,
        )
    if analysis is not None:
        _warn_of_misfits(analysis, source, quiet=quiet)
    steps = rate if rate is not None else _highest_rate(analysis)
    biases = _turn_on(turn_on or [], model)
    if biases and average is not None:
        raise OptionError(
            "--turn-on: a calibration removes a constant bias; give --turn-on or --calibration", option="turn_on"
        )

    def predicted(seconds: Sequence[float]) -> Prediction:
        return predict(model, after=seconds, calibration=average, rate=steps, earth=earth, turn_on=biases)

    with working("predicting", quiet=quiet):
        prediction = predicted(times)
        check_units({name: [(error.unit, error.unit, None)] for name, error in prediction.items() if error.unit != "m"})
        if plot is not None:
            last = float(prediction.after[-1])
            first = max(min(float(prediction.after[0]), last / _SPAN), 1 / steps)
            curve = predicted([*prediction.after.tolist(), *np.geomspace(first, last, _POINTS).tolist()])
            with drawing(plot, style, quiet=True):
                write_figure(curve.plot(marked=prediction.after), plot)
    write_result(repr(prediction), prediction.to_dict(), Path("-") if json else None)
    return 0


def _time(text: str, option: str) -> float:
    try:
        return value_in_si(text, "s", f"--{option}")
    except OptionError:
        raise OptionError(
            f"--{option} {text!r}: must be a time with its unit, e.g. 60s or 10min", option=option
        ) from None


def _turn_on(values: Sequence[str], model: NoiseModel) -> dict[str, float]:
    """Return the bias of each channel. The name of a stream sets the bias of all its channels."""
    biases: dict[str, float] = {}
    for key, text in key_values(values, "turn-on", 'gyro="10 deg/h"').items():
        named = [name for name in model.channels if key in (name, stream_name(name))]
        if not named:
            raise OptionError(f"--turn-on {key}: the model has {', '.join(model.channels)}", option="turn_on")
        for name in named:
            if stream_name(name) not in ("gyro", "accel"):
                raise OptionError(f"--turn-on {key}: {name} is neither a gyro nor an accelerometer", option="turn_on")
            value = value_in_si(text, model.channels[name].unit, f"--turn-on {key}")
            if name not in biases or key == name:
                biases[name] = value
    return biases


def _warn_of_misfits(analysis: Analysis, source: Path, *, quiet: bool) -> None:
    """Warn of channels without an adequate model."""
    for name, fit in analysis.fits.items():
        if not fit.quantified:
            say(f"warning: {name}: {source} has no model that fits it, so the prediction is uncertain", quiet=quiet)


def _highest_rate(analysis: Analysis | None) -> float:
    """Return the highest sampling rate of a result; for a model file, the default rate. [Hz]"""
    return _RATE if analysis is None else max(1 / curve.tau0 for curve in analysis.curves.values())
