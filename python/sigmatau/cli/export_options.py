"""Options of ``export`` and ``analyze --export``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import Annotated

from cyclopts import Parameter

from sigmatau.cli.options import finding_lines, key_values, say
from sigmatau.errors import OptionError
from sigmatau.exporting.choices import Axes, Choices
from sigmatau.findings.finding import Finding
from sigmatau.quality.selection.time_text import time_of

__all__ = ["Choosing", "as_typed", "print_findings"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Choosing:
    """Options of an export.

    Parameters
    ----------
    axes
        How to combine three axes: worst (the largest), mean (root mean square), or each, for targets with a field per axis.
    rate_random_walk
        Rate random walk to write if none was observed: gyro=upper-limit, gyro="1e-6 rad/s/sqrt(s)", or gyro=horizon, which
        matches the Allan variance of the model at --horizon, observed or not.
    random_walk
        Random walk to write if none was observed: accel=upper-limit, or a value with unit.
    horizon
        Averaging time for gyro=horizon and Gauss-Markov biases, e.g. 10s (ms, s, min, h, d).
    noise_factor
        Factor on the random walk; the file states estimate and factor (default 1).
    walk_factor
        Factor on slow noise: rate random walk, bias instability and Gauss-Markov processes (default 1).
    step
        Step of the filter in seconds, for targets that need one.
    name
        Other fields of a target: topic=/imu0, gravity=9.81.
    """

    axes: Axes = "worst"
    rate_random_walk: Annotated[list[str] | None, Parameter(negative=())] = None
    random_walk: Annotated[list[str] | None, Parameter(negative=())] = None
    horizon: str | None = None
    noise_factor: float = 1.0
    walk_factor: float = 1.0
    step: float | None = None
    name: Annotated[list[str] | None, Parameter(negative=())] = None

    def choices(self, rate: float | None) -> Choices:
        """The `Choices` of these options; raises `OptionError`."""
        walks = key_values(self.rate_random_walk or [], "rate-random-walk", "gyro=upper-limit")
        noises = key_values(self.random_walk or [], "random-walk", "gyro=upper-limit")
        with as_typed():
            return self._choices(rate, walks, noises)

    def _choices(self, rate: float | None, walks: dict[str, str], noises: dict[str, str]) -> Choices:
        return Choices(
            axes=self.axes,
            walk=walks,
            noise=noises,
            horizon=None if self.horizon is None else _time(self.horizon),
            noise_factor=self.noise_factor,
            walk_factor=self.walk_factor,
            rate=rate,
            step=self.step,
            names=key_values(self.name or [], "name", "topic=/imu0"),
        )

    def given(self) -> str | None:
        """An option that was given, in the form of the command line; None if none was."""
        for field in fields(self):
            if getattr(self, field.name) != field.default:
                return f"--{field.name.replace('_', '-')}"
        return None


def _time(text: str) -> float:
    return time_of(text, text, option="horizon", forms="want a value with its unit, e.g. 10s, 5min, 2h")


_NAMES = {"walk": "rate-random-walk", "noise": "random-walk", "names": "name"}
_UNITS = {"horizon": "s"}


@contextmanager
def as_typed(before: str = "", after: str = "") -> Iterator[None]:
    """Translate errors of an export to options of the command line."""
    try:
        yield
    except OptionError as error:
        raise OptionError(f"{before}{error.for_command_line(_NAMES, _UNITS)}{after}", option=error.option) from None


def print_findings(findings: Iterable[Finding], *, quiet: bool) -> None:
    """Print findings of an export, each once."""
    for line in finding_lines(list(dict.fromkeys(findings))):
        say(line, quiet=quiet)
