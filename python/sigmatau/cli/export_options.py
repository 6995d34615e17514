"""What is chosen for an export, because no record decides it: the options of ``export`` and ``analyze --export``."""

from __future__ import annotations

import re
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

__all__ = ["Choosing", "as_typed", "said", "typed"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Choosing:
    """Options of an export.

    Parameters
    ----------
    axes
        Where a target has one number for three axes, the worst of them or the root of the mean of the squares; each, where
        it has a place for each.
    rate_random_walk
        What to write where no rate random walk was observed: gyro=upper-limit, gyro="1e-6 rad/s/sqrt(s)", or
        gyro=horizon, which with the random walk has the model's Allan variance at --horizon, observed or not.
    random_walk
        What to write where no random walk was observed, as where quantization covers it: accel=upper-limit, or a value with
        its unit.
    horizon
        Averaging time of gyro=horizon, e.g. 10s (ms, s, min, h, d).
    noise_factor
        What is written for the random walk is so many times what was found; both stand in the file.
    walk_factor
        The same for slow noise: the rate random walk and, where a target has them, bias instability and Gauss-Markov
        processes.
    step
        Step of the filter in seconds, for a target that has one of its own.
    name
        Names and constants that a target has beside the numbers: topic=/imu0, gravity=9.81.
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
        """As `sigmatau.exporting` takes them; raises `OptionError`."""
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
        """An option that was given, as it is typed; None if none was."""
        for field in fields(self):
            if getattr(self, field.name) != field.default:
                return f"--{field.name.replace('_', '-')}"
        return None


def _time(text: str) -> float:
    return time_of(text, text, option="horizon", forms="want a value with its unit, e.g. 10s, 5min, 2h")


_NAMES = {"walk": "rate-random-walk", "noise": "random-walk", "names": "name"} | {
    name: name.replace("_", "-") for name in ("axes", "horizon", "noise_factor", "walk_factor", "rate", "step")
}
_UNITS = {"horizon": "s"}
_BY_SENSOR = re.compile(r'`(walk|noise)=\{"(\w+)": "?([^"`}]*)"?\}`')
_ONE = re.compile(r'`(axes|horizon|noise_factor|walk_factor|rate|step)="?([^"`]*)"?`')
_BARE = re.compile(rf"`({'|'.join(_NAMES)})`")


def typed(message: str) -> str:
    """The words of an export with each option as it is typed here, where they have a function's argument in backticks."""

    def by_sensor(match: re.Match[str]) -> str:
        pair = f"{match[2]}={match[3]}"
        return f"--{_NAMES[match[1]]} " + (f'"{pair}"' if " " in pair else pair)

    message = _BY_SENSOR.sub(by_sensor, message)
    message = _ONE.sub(lambda match: f"--{_NAMES[match[1]]} {match[2]}{_UNITS.get(match[1], '')}", message)
    return _BARE.sub(lambda match: f"--{_NAMES[match[1]]}", message)


@contextmanager
def as_typed(before: str = "", after: str = "") -> Iterator[None]:
    """Say errors of an export in the words of the command line."""
    try:
        yield
    except OptionError as error:
        raise OptionError(f"{before}{typed(str(error))}{after}", option=error.option) from None


def said(findings: Iterable[Finding], *, quiet: bool) -> None:
    """Findings of an export for the terminal, each once."""
    for line in finding_lines(list(dict.fromkeys(findings))):
        say(line, quiet=quiet)
