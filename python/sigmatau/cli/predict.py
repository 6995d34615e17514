"""``sigmatau predict``: a model or a result in; errors of free inertial navigation at rest out."""

from __future__ import annotations

import json as json_module
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter

from sigmatau.cli.options import check_output, key_values, refuse_same, say, working
from sigmatau.errors import DataError, OptionError
from sigmatau.model.file import value_in_si
from sigmatau.model.noise_model import NoiseModel
from sigmatau.navigation.predict import predict
from sigmatau.navigation.prediction import Prediction
from sigmatau.record.record import stream_name

__all__ = ["predict_command"]

_RATE = 100.0
"""Steps a second where nothing says how many: for all but the velocity of quantization noise, any number does. [Hz]"""

_SPAN, _POINTS = 1000.0, 50
"""How far back from the last time a figure goes, and how many times it is drawn at besides those asked for."""


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
    json: bool = False,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Errors of free inertial navigation at rest, from a noise model: angles, velocity, position, each term's share.

    Parameters
    ----------
    source
        A model file (.toml), or the JSON that analyze writes.
    after
        Times since the start, with units: 60s,10min.
    calibration
        Length of time at rest before the start, with its unit: the mean of each rate over it is subtracted, which levels
        and takes away the bias. Default: none; the state at the start is known, walks and all that flicker noise is made of
        begin at 0. A simulated record, which has but its first sample at 0, then shows more: the answer says how much.
    rate
        Steps a second, in Hz. Default: the sampling rate of the result, or 100.
    turn_on
        Without a calibration, standard deviation of a constant bias: gyro="10 deg/h" or accel_x="1 mg".
    earth
        round, with Schuler's feedback, or flat.
    channels
        Which channels. Default: all.
    plot
        Draw the errors against time up to the last of `after`: .png, .svg or .pdf.
    json
        Print JSON in place of text.
    quiet
        Nothing on standard error but errors.
    """
    check_output(plot, (".png", ".svg", ".pdf"), "plot")
    refuse_same(source, plot=plot)
    times = [_time(text, "after") for text in after.split(",")]
    average = None if calibration is None else _time(calibration, "calibration")
    model = NoiseModel.read(source)
    if channels:
        for name in channels:
            if name not in model.channels:
                raise OptionError(f"--channels {name}: {source} has {', '.join(model.channels)}", option="channels")
        model = model.of(channels)
    found = _of_result(source, quiet=quiet) if source.suffix.lower() == ".json" else None
    steps = rate if rate is not None else found or _RATE
    biases = _turn_on(turn_on or [], model)
    if biases and average is not None:
        raise OptionError("--turn-on: a calibration takes a constant bias away; give one of the two", option="turn_on")

    def predicted(at: Sequence[float]) -> Prediction:
        return predict(model, after=at, calibration=average, rate=steps, earth=earth, turn_on=biases)

    with working("predicting", quiet=quiet):
        prediction = predicted(times)
        if plot is not None:
            from sigmatau.plot.curves import save

            last = float(prediction.after[-1])
            first = max(min(float(prediction.after[0]), last / _SPAN), 1 / steps)
            curve = predicted([*prediction.after.tolist(), *np.geomspace(first, last, _POINTS).tolist()])
            save(curve.plot(marked=prediction.after), str(plot))
    if json:
        sys.stdout.write(json_module.dumps(prediction.to_dict(), indent=1, allow_nan=False) + "\n")
    else:
        sys.stdout.write(repr(prediction) + "\n")
    return 0


def _time(text: str, option: str) -> float:
    try:
        return value_in_si(text, "s", f"--{option}")
    except OptionError:
        raise OptionError(f"--{option} {text!r}: want a time with its unit, e.g. 60s or 10min", option=option) from None


def _turn_on(values: Sequence[str], model: NoiseModel) -> dict[str, float]:
    """Biases by channel; a stream's name stands for all of its channels."""
    found: dict[str, float] = {}
    for key, text in key_values(values, "turn-on", 'gyro="10 deg/h"').items():
        named = [name for name in model.channels if key in (name, stream_name(name))]
        if not named:
            raise OptionError(f"--turn-on {key}: the model has {', '.join(model.channels)}", option="turn_on")
        for name in named:
            if stream_name(name) not in ("gyro", "accel"):
                raise OptionError(
                    f"--turn-on {key}: {name} is neither a gyro nor an accelerometer, and makes no error of navigation",
                    option="turn_on",
                )
            try:
                value = value_in_si(text, model.channels[name].unit, f"--turn-on {key}")
            except OptionError as error:
                message = str(error)
                raise OptionError(
                    message if message.startswith("--") else f"--turn-on {key}: {message}", option="turn_on"
                ) from None
            if name not in found or key == name:
                found[name] = value
    return found


def _of_result(source: Path, *, quiet: bool) -> float:
    """The highest sampling rate of a result; warns of channels without an adequate model."""
    try:
        content = json_module.loads(source.read_text(encoding="utf-8"))
        channels: Mapping[str, Mapping[str, object]] = content["channels"]
        rates = [float(str(channel["sample_rate_hz"])) for channel in channels.values()]
        for name, channel in channels.items():
            fitted = channel.get("fit")
            if isinstance(fitted, Mapping) and fitted["verdict"] != "adequate":
                say(f"warning: {name}: {source} has no adequate model of it; the answer is no better", quiet=quiet)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise DataError(f"{source}: not a result of sigmatau analyze ({error!r} is missing or wrong)") from None
    return max(rates)
