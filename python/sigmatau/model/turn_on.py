"""Turn-on bias: change of the bias of a channel from one power-up to the next."""

from __future__ import annotations

from typing import Any

from sigmatau.digits import round_to_error
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.model.processes import LARGEST, SMALLEST, real
from sigmatau.noise.terms import display_units

_MIN_POWER_UPS = 2  # smallest number of power-ups with a spread


@frozen
class TurnOn:
    """Spread of the bias of a channel between power-ups, about their mean.

    Attributes
    ----------
    sigma : float
        Standard deviation between power-ups; 0 if the biases differ by no more than their errors. [unit of the rate]
    low, high : float or None
        Confidence interval of `sigma`; None if `sigma` was stated and not measured. [unit of the rate]
    level : float
        Probability of the interval.
    power_ups : int or None
        Number of measured power-ups; None if `sigma` was stated.

    Raises
    ------
    DataError
        For a spread that is not positive or outside its interval, or fewer than two power-ups.

    See Also
    --------
    measure_turn_on : measures it.
    NoiseModel.with_turn_on : adds it to a model.

    Examples
    --------
    >>> from sigmatau import TurnOn
    >>> TurnOn(sigma=1e-4, low=4.5e-5, high=3.2e-3, power_ups=2).prior
    0.0001
    """

    sigma: float
    low: float | None = None
    high: float | None = None
    level: float = 0.95
    power_ups: int | None = None

    def __post_init__(self) -> None:
        measured = (self.low, self.high, self.power_ups)
        if any(each is None for each in measured) != all(each is None for each in measured):
            raise DataError("a measured turn-on bias has low, high and power_ups; a stated one has only sigma")
        for name, value in (("sigma", self.sigma), ("low", self.low), ("high", self.high)):
            if value is None:
                continue
            if not 0 <= real(value) <= LARGEST:
                raise DataError(f"{name} of a turn-on bias must be positive, at most {LARGEST:g} in SI, not {value!r}")
            object.__setattr__(self, name, float(value))
        if self.prior < SMALLEST:
            raise DataError(f"sigma of a turn-on bias must be positive, not {self.sigma!r}")
        if not 0 < real(self.level) < 1:
            raise DataError(f"level of a turn-on bias must be between 0 and 1, not {self.level!r}")
        if self.low is None or self.high is None:
            return
        if not (0 <= self.low <= self.sigma <= self.high):
            raise DataError(f"sigma of a turn-on bias must be between low and high, not {self.sigma!r}")
        whole = isinstance(self.power_ups, int) and not isinstance(self.power_ups, bool)
        if not whole or self.power_ups is None or self.power_ups < _MIN_POWER_UPS:
            raise DataError(f"power_ups must be a whole number of at least {_MIN_POWER_UPS}, not {self.power_ups!r}")

    @property
    def prior(self) -> float:
        """Standard deviation for the initial bias of a filter: `sigma`, or the upper end if no spread was seen.
        [unit of the rate]
        """
        return self.sigma or (self.high or 0.0)

    def scaled(self, factor: float) -> TurnOn:
        """The spread for a signal that is multiplied by a factor.

        Parameters
        ----------
        factor : float
            Positive. [1]

        Returns
        -------
        TurnOn
        """
        low, high = (None if end is None else factor * end for end in (self.low, self.high))
        return TurnOn(sigma=factor * self.sigma, low=low, high=high, level=self.level, power_ups=self.power_ups)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        content: dict[str, Any] = {"sigma": self.sigma}
        if self.power_ups is not None:
            content |= {"low": self.low, "high": self.high, "level": self.level, "power_ups": self.power_ups}
        return content

    def text(self, quantity: str, unit: str) -> str:
        """``21 [9.2, 660] deg/h (95 %), 2 power-ups``.

        Parameters
        ----------
        quantity, unit : str
            Those of the channel.

        Returns
        -------
        str
        """
        shown, size = display_units("bias_instability", quantity, unit)[-1]
        if self.low is None or self.high is None:
            return f"{self.sigma / size:.4g} {shown}, stated"
        number = f"{100 * self.level:.4g} %"
        if not self.sigma:
            return f"below {self.high / size:.3g} {shown} ({number}), {self.power_ups} power-ups"
        value = round_to_error(self.sigma / size, self.low / size, self.high / size).with_unit(shown)
        return f"{value} ({number}), {self.power_ups} power-ups"


def is_wide(spread: TurnOn) -> bool:
    """Whether the upper end is far above the estimate, as after a few power-ups."""
    return spread.high is not None and spread.high > _WIDE * spread.sigma


_WIDE = 3.0
"""Upper end over estimate, from which a file warns: up to four power-ups at 95 %. Derived: √(3/χ²(0.025, 3)) is 3.7 for
four, √(4/χ²(0.025, 4)) 2.9 for five. [1]"""
