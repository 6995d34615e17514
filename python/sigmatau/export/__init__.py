"""From a noise model to the file that a filter or a simulator reads."""

from __future__ import annotations

from pathlib import Path

from sigmatau.errors import OptionError
from sigmatau.export.numbers import Axes, Choices, Number, Numbers
from sigmatau.export.target import Target
from sigmatau.export.targets import NAMES, target
from sigmatau.io.write import atomic
from sigmatau.model import NoiseModel

__all__ = ["NAMES", "Axes", "Choices", "Number", "Numbers", "Target", "check_choices", "check_path", "export", "target"]

# What readers take for binary by the ending alone.
_BINARY = frozenset((".npz", ".npy", ".mat", ".h5", ".hdf5", ".pkl", ".parquet", ".bin", ".zip", ".gz", ".pdf", ".png"))


def export(
    model: NoiseModel, *, to: str, path: str | Path | None = None, choices: Choices | None = None
) -> str | bytes:
    """Write the parameters of a noise model for another program.

    Parameters
    ----------
    model : NoiseModel
    to : str
        The target, one of `NAMES`.
    path : str or Path, optional
        Where to write; whole or not at all. Its ending chooses the form where the target has several.
    choices : Choices, optional
        What no record decides; see there.

    Returns
    -------
    str or bytes
        The content of the file, with the origin and the unit of each number beside it.

    Raises
    ------
    OptionError
        For an unknown target, or something that has to be chosen and was not, such as what to write for a rate random walk
        that was not observed.
    DataError
        If the model lacks what the target needs, or the file cannot be written.
    """
    chosen = Choices() if choices is None else choices
    wanted = target(to)
    check_choices(wanted, chosen)
    if path is not None:
        check_path(wanted, path)
    if wanted.needs_rate and chosen.rate is None:
        raise OptionError(f"{to} needs the sampling rate of the sensor: give `rate` in Hz", option="rate")
    write = wanted.write if path is None else wanted.binary.get(Path(path).suffix.lower(), wanted.write)
    content = write(Numbers(model, chosen))
    if path is not None:
        with atomic(path) as temporary:
            if isinstance(content, bytes):
                temporary.write_bytes(content)
            else:
                temporary.write_text(content, encoding="utf-8")
    return content


def check_path(target: Target, path: str | Path) -> None:
    """Refuse, with an `OptionError`, the ending of a binary format that a target does not write."""
    ending = Path(path).suffix.lower()
    if ending in _BINARY and ending not in target.binary:
        endings = ", ".join((target.ending, *target.binary))
        raise OptionError(
            f"{Path(path).name!r}: {target.name} has no form for {ending}, which is a binary format's; it has {endings}",
            option="path",
        )


def check_choices(target: Target, choices: Choices) -> None:
    """Refuse, with an `OptionError`, what a target has no place for; no model is needed for that."""
    unknown = sorted(set(choices.names) - set(target.names))
    if unknown:
        listed = ", ".join(target.names) or "none"
        raise OptionError(f"{target.name} has no name {unknown[0]!r}; it has: {listed}", option="name")
    if choices.step is not None and not target.has_step:
        raise OptionError(f"--step has no place in {target.name}: it has no step of its own", option="step")
    if choices.horizon is not None and not target.has_horizon and "horizon" not in choices.walk.values():
        raise OptionError(
            f"--horizon has no place in {target.name} but with --rate-random-walk SENSOR=horizon", option="horizon"
        )
    if choices.axes == "each" and not (target.per_axis or target.every_axis):
        raise OptionError(f"{target.name} has one number for all axes: choose worst or mean, not each", option="axes")
    if choices.axes == "mean" and target.every_axis:
        raise OptionError(
            f"{target.name} has every axis by itself, and no mean of them: leave `axes` out", option="axes"
        )
