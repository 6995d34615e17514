"""``sigmatau simulate``: a log from a noise model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from sigmatau.cli.imperfections import imperfections_of
from sigmatau.cli.options import check_output, say, working
from sigmatau.errors import OptionError
from sigmatau.io.write import RECORD_ENDINGS
from sigmatau.model.noise_model import NoiseModel
from sigmatau.simulation.to_file import simulate_to

_Values = Annotated[list[str] | None, Parameter(negative=())]


def simulate_command(
    model: Path,
    /,
    *,
    hours: float,
    rate: float,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    seed: int = 0,
    input: Literal["rate", "increments", "accumulated"] = "rate",  # noqa: A002  the option of `analyze`
    level: _Values = None,
    warm_up: _Values = None,
    temperature: _Values = None,
    sensitivity: _Values = None,
    saturation: _Values = None,
    lsb: _Values = None,
    gaps: _Values = None,
    jitter: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    flicker: Literal["poles", "exact"] = "poles",
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Simulate a sensor at rest from its noise model, and write the log.

    Parameters
    ----------
    model
        A model file (.toml): tables [channels.gyro_x] with values and units, random_walk = "0.3 deg/sqrt(h)".
    hours
        Length of the record in hours. The record may be larger than the memory.
    rate
        Sampling rate in Hz.
    output
        The log to write: .csv, .csv.gz, .npy, .npz, .parquet or .h5; time and channels in SI.
    seed
        The same seed gives the same log.
    input
        Content of the columns: rates, increments per sample, or accumulated angle and velocity. Readers of the log need the
        same --input. Increments and accumulated values are for gyros and accelerometers only.
    level
        Constant level by channel or sensor: accel_z=1g.
    warm_up
        Exponential warm-up, amplitude:time constant: gyro=20deg/h:10min.
    temperature
        Temperature of the sensor, written as a column: start=20degC,end=35degC,time=20min (or start=293.15K). Optional:
        swing=3K for a daily cycle, resolution=0.0625K for the thermometer.
    sensitivity
        Sensitivity to temperature: gyro=5deg/h/K.
    saturation
        Largest rate of the output: gyro=250deg/s.
    lsb
        Resolution: gyro=0.01deg/s; for increments and accumulated values that of the sum, gyro=0.1arcsec.
    gaps
        Missing rows: a random share, 0.1%, and outages as start:length, 600s:2s.
    jitter
        Standard deviation of the time stamps: 20us.
    flicker
        Generator of bias instability: poles, with an Allan deviation within 0.002 %, or exact, which needs memory.
    quiet
        Print only errors on standard error.
    """
    check_output(output, RECORD_ENDINGS, "output")
    if output.exists() and model.exists() and output.samefile(model):
        raise OptionError(f"--output {output} is the model itself; name another file", option="output")
    noise = NoiseModel.read(model)
    given = imperfections_of(
        noise,
        output=input,
        level=level or (),
        warm_up=warm_up or (),
        temperature=temperature or (),
        sensitivity=sensitivity or (),
        saturation=saturation or (),
        lsb=lsb or (),
        gaps=gaps or (),
        jitter=jitter,
    )
    with working(f"simulating {hours:g} h into {output}", quiet=quiet) as done:
        made = simulate_to(
            output,
            noise,
            duration=hours * 3600,
            rate=rate,
            rng=seed,
            imperfections=given,
            flicker=flicker,
            progress=done,
        )
    lost = f", {made.lost} rows lost" if made.lost else ""
    count = len(made.channels)
    channels = "1 channel" if count == 1 else f"{count} channels"
    say(f"{output}: {made.samples} samples of {channels}{lost}, seed {seed}", quiet=quiet)
    return 0
