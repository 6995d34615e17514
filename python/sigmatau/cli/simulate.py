"""``sigmatau simulate``: a model file in, a log out."""

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

__all__ = ["simulate_command"]

_Values = Annotated[list[str] | None, Parameter(negative=())]


def simulate_command(
    model: Path,
    /,
    *,
    hours: float,
    rate: float,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    seed: int = 0,
    input: Literal["rate", "increments", "accumulated"] = "rate",  # noqa: A002  as `analyze` is to be told
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
        TOML: tables [channels.gyro_x] with random_walk = "0.3 deg/sqrt(h)" and so on, each value with its unit.
    hours
        Length of the record. It need not fit in memory.
    rate
        Sampling rate in Hz.
    output
        .csv, .csv.gz, .npy, .npz, .parquet or .h5; time and channels in SI.
    seed
        The same seed gives the same log.
    input
        What the columns hold, as the readers of the log will have to say by their own --input: rates, increments per
        sample, or accumulated angle and velocity. Of a model of gyros and accelerometers alone if not rates.
    level
        A constant by channel or sensor: accel_z=1g.
    warm_up
        A level that dies away, amplitude:time to 1/e: gyro=20deg/h:10min.
    temperature
        Of the sensor, which becomes a column: start=20degC,end=35degC,time=20min (or start=293.15K), and if you like
        swing=3K by day and night and resolution=0.0625K of the thermometer.
    sensitivity
        To the temperature: gyro=5deg/h/K.
    saturation
        The largest rate that is shown: gyro=250deg/s.
    lsb
        Step of the numbers: gyro=0.01deg/s; of increments and accumulated output that of the running sum, gyro=0.1arcsec.
    gaps
        Rows that are lost: a part of them by chance, 0.1%, and outages as start:length, 600s:2s.
    jitter
        Standard deviation of the time stamps about the regular times of the samples: 20us.
    flicker
        How bias instability is made: by poles, whose Allan deviation is within 0.002 % of the exact one, or exactly, in
        memory.
    quiet
        Nothing on standard error but errors.
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
