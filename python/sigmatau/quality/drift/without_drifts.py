"""Search for steps of the mean in samples without the fitted drift, which hides steps or was fitted to them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.findings.finding import Finding
from sigmatau.fitting.channel import TEMPERATURE, follows_temperature, sample_temperatures
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.motion.shocks_and_steps import step_finding
from sigmatau.quality.motion.windows import mean_steps, summarise_windows
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream


def has_drift(fitted: NoiseFit | None) -> bool:
    """Whether a fit contains a warm-up or a drift with the temperature."""
    return fitted is not None and (fitted.warm_up is not None or follows_temperature(fitted))


def subtract_drifts(record: Record, stream: Stream, fits: Mapping[str, NoiseFit]) -> Stream:
    """Subtract the drifts of the fits from a stream of the record, or from its beginning; the same object if there are no
    drifts.
    """
    if not any(has_drift(fits.get(channel)) for channel in stream.channels):
        return stream
    degrees = sample_temperatures(record, record.stream_of(stream.channels[0]))
    return stream.with_rates([_without(stream, channel, fits.get(channel), degrees) for channel in stream.channels])


def _without(stream: Stream, channel: str, fitted: NoiseFit | None, degrees: Floats | None) -> Floats:
    x = stream.column(channel)
    if fitted is None:
        return x
    if fitted.warm_up is not None:
        seconds = (np.arange(len(x)) + 0.5) * stream.grid.tau0
        x = x - fitted.warm_up.amplitude.value * np.exp(-seconds / fitted.warm_up.time)
    if degrees is not None and follows_temperature(fitted):
        x = x - fitted.regressors[TEMPERATURE].value * degrees[: len(x)]
    return np.asarray(x)


def steps_beside_drifts(stream: Stream, fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Report the steps of the mean that remain without the drift: one finding ``not_static`` for each channel with a drift.

    Parameters
    ----------
    stream : Stream
        Stream from `subtract_drifts`, without disturbances, because a spike at either end looks like a drift.
    fits : mapping of str to NoiseFit
    """
    if stream.quantity not in ("angular_rate", "acceleration"):
        return []
    findings = []
    for channel in stream.channels:
        if has_drift(fits.get(channel)):
            steps = [step for step in mean_steps(stream, summarise_windows(stream, channel)) if not step.gradual]
            if steps:
                findings.append(step_finding(stream, channel, steps, beside_drift=True))
    return findings
