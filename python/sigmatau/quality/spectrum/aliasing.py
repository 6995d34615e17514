"""Aliasing: noise that sampling without an anti-alias filter adds to the random walk, for a stated bandwidth."""

from __future__ import annotations

import math

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.spectrum import Aliasing
from sigmatau.noise.terms import aliasing_inflation
from sigmatau.record.streams import Stream

# Factor of the random walk above which aliasing is a warning. [1] Judgement: the usual interval is 5 %.
_INFLATION_WARNED = 1.05
# Factor at the sampling rate that the action recommends. [1] Judgement: less than half of `_INFLATION_WARNED`.
_INFLATION_ADVISED = 1.02
# Largest bandwidth. [Hz] Judgement: piezoelectric shock sensors resonate at some hundred kHz; no inertial sensor is
# faster.
_LARGEST_BANDWIDTH = 1e6


def aliasing(stream: Stream, bandwidth: tuple[float, int | None]) -> list[Finding]:
    """Report ``aliasing`` of a stream: a warning or an info.

    Parameters
    ----------
    stream : Stream
    bandwidth : (float, int or None)
        Bandwidth of the sensor from its datasheet, and the order of its filter if known. Without an order the finding
        states both the first and the second, and the first decides. [Hz]

    Raises
    ------
    OptionError
        For a bandwidth that is not positive, an order outside 1 … 8.
    """
    hertz, order = bandwidth
    if not 0 < hertz <= _LARGEST_BANDWIDTH:
        raise OptionError(
            f"the bandwidth must be a positive number of hertz, at most {_LARGEST_BANDWIDTH:g}, not {hertz!r}",
            option="bandwidth",
        )
    if order is not None and order not in range(1, 9):
        raise OptionError(f"the order of a filter must be 1 to 8, not {order!r}", option="bandwidth")
    rate = stream.grid.rate
    details = Aliasing(
        rate=rate,
        bandwidth=hertz,
        order=order,
        second_order=aliasing_inflation(rate=rate, bandwidth=hertz, order=2) if order is None else None,
        rate_needed=_rate_needed(hertz, order or 1),
    )
    return [_aliased(details, stream.channels)]


def _aliased(details: Aliasing, channels: tuple[str, ...]) -> Finding:
    inflation = aliasing_inflation(rate=details.rate, bandwidth=details.bandwidth, order=details.order or 1)
    return Finding(
        details=details,
        severity="warning" if inflation > _INFLATION_WARNED else "info",
        channels=channels,
        size=inflation,
        factors=(("random_walk", inflation),),
    )


def _rate_needed(corner: float, order: int) -> float:
    """Sampling rate at which folded noise adds little to the random walk. [Hz]"""
    low, high = 0.5 * corner, 64 * corner
    for _ in range(40):
        middle = math.sqrt(low * high)
        if aliasing_inflation(rate=middle, bandwidth=corner, order=order) > _INFLATION_ADVISED:
            low = middle
        else:
            high = middle
    return high
