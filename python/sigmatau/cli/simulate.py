"""``sigmatau simulate``: a model file in, a log out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from sigmatau.cli.options import check_output, say, working
from sigmatau.errors import OptionError
from sigmatau.io.write import RECORD_ENDINGS, write_record
from sigmatau.model import NoiseModel, simulate

__all__ = ["simulate_command"]


def simulate_command(
    model: Path,
    /,
    *,
    hours: float,
    rate: float,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    seed: int = 0,
    quiet: Annotated[bool, Parameter(name=["--quiet", "-q"], negative=())] = False,
) -> int:
    """Simulate a sensor at rest from its noise model, and write the log.

    Parameters
    ----------
    model
        TOML: tables [channels.gyro_x] with random_walk = "0.3 deg/sqrt(h)" and so on, each value with its unit.
    hours
        Length of the record.
    rate
        Sampling rate in Hz.
    output
        .csv, .csv.gz or .npz; time and rates in SI.
    seed
        The same seed gives the same log.
    quiet
        Nothing on standard error but errors.
    """
    check_output(output, RECORD_ENDINGS, "output")
    if output.exists() and model.exists() and output.samefile(model):
        raise OptionError(f"--output {output} is the model itself; name another file", option="output")
    noise = NoiseModel.read(model)
    with working(f"simulating {hours:g} h", quiet=quiet):
        record = simulate(noise, duration=hours * 3600, rate=rate, rng=seed)
    with working(f"writing {output}", quiet=quiet):
        write_record(record, output)
    say(f"{output}: {record.provenance.rows} samples of {len(record.channels)} channels, seed {seed}", quiet=quiet)
    return 0
