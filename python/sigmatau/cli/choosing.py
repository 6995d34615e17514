"""What is chosen for an export, because no record decides it: the options of ``export`` and ``analyze --export``."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Annotated

from cyclopts import Parameter

from sigmatau.cli.options import key_values
from sigmatau.errors import OptionError
from sigmatau.export import Axes, Choices
from sigmatau.model import value_in_si
from sigmatau.terms import coefficient_unit

__all__ = ["Choosing"]

_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}


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
        Averaging time of gyro=horizon, e.g. 10s.
    noise_factor
        What is written for the random walk is so many times what was found; both stand in the file.
    walk_factor
        The same for the rate random walk.
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
        """As `sigmatau.export` takes them; raises `OptionError`."""
        walks = key_values(self.rate_random_walk or [], "rate-random-walk", "gyro=upper-limit")
        noises = key_values(self.random_walk or [], "random-walk", "gyro=upper-limit")
        return Choices(
            axes=self.axes,
            walk={s: _value(s, text, "rate_random_walk", ("upper-limit", "horizon")) for s, text in walks.items()},
            noise={s: _value(s, text, "random_walk", ("upper-limit",)) for s, text in noises.items()},
            horizon=None if self.horizon is None else value_in_si(self.horizon, "s", "--horizon"),
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


def _value(sensor: str, text: str, term: str, words: tuple[str, ...]) -> str | float:
    if text in words or sensor not in _QUANTITIES:  # which Choices refuses
        return text
    try:
        return value_in_si(text, coefficient_unit(term, *_QUANTITIES[sensor]), f"--{term.replace('_', '-')}")
    except OptionError as error:
        others = ", ".join(f"{sensor}={word}" for word in words)
        raise OptionError(f"{error}; or {others}", option=term) from None
