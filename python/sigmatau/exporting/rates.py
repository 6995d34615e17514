"""Rate and step of the filter, given by the user or derived from the record."""

from __future__ import annotations

from collections.abc import Mapping

from sigmatau.errors import OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.source import common_rate, have_several_rates, sensor_rates
from sigmatau.hints import Hint


def filter_rate(rates: Mapping[str, float], choices: Choices) -> float:
    """Rate of the filter, given by the user or that of the record. Raises `OptionError` if it is unknown or ambiguous.
    [Hz]
    """
    rate = known_filter_rate(rates, choices)
    if rate is None:
        listed = ", ".join(f"{name} {hertz:.6g} Hz" for name, hertz in sensor_rates(rates).items())
        why = (
            f"the channels have several sampling rates ({listed})"
            if rates
            else ("the rate of the filter is needed; a model file has none")
        )
        raise OptionError(f"{why}: give {{option}} in Hz", option="filter_rate")
    return rate


def known_filter_rate(rates: Mapping[str, float], choices: Choices) -> float | None:
    """Rate of the filter, given by the user or that of the record; None if it is unknown or ambiguous. [Hz]"""
    return common_rate(rates) if choices.filter_rate is None else choices.filter_rate


def filter_step(rates: Mapping[str, float], choices: Choices) -> float:
    """Step of the filter, given by the user or the inverse of the rate of all channels. Raises `OptionError` if it is
    unknown. [s]
    """
    if choices.step is not None:
        return choices.step
    if choices.filter_rate is None and (not rates or have_several_rates(rates)):
        rate_words = ", ".join(f"{name} {rate:.6g} Hz" for name, rate in rates.items())
        reason = f"; the channels have several rates ({rate_words})" if rates else ""
        raise OptionError(
            f"the step of the filter is needed: give {{option}} in seconds, or {Hint('filter_rate')} in Hz{reason}",
            option="step",
        )
    return 1 / filter_rate(rates, choices)
