"""Findings about samples: what is wrong with a record before anything is computed from it.

One module a kind of fault; each takes a stream and returns findings. `check` runs them all.
"""

from sigmatau.integrity.blank import blanked, rows
from sigmatau.integrity.interpolated import interpolated
from sigmatau.integrity.knocks import light_knocks
from sigmatau.integrity.plausible import earth_rate, gravity, implausible_unit
from sigmatau.integrity.repeated import repeated_samples
from sigmatau.integrity.resolution import coarse_resolution, quantization_mismatch, quantization_step
from sigmatau.integrity.samples import without_dust
from sigmatau.integrity.saturation import saturation
from sigmatau.integrity.spikes import find_spikes, mask_spikes, spikes
from sigmatau.integrity.start import start_transient
from sigmatau.integrity.static import not_static
from sigmatau.integrity.stuck import dropouts, stuck_samples, without_runs
from sigmatau.integrity.undisturbed import DISTURBANCES, undisturbed
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.streams import Stream

__all__ = [
    "CHECKS",
    "DISTURBANCES",
    "check",
    "coarse_resolution",
    "dropouts",
    "earth_rate",
    "find_spikes",
    "gravity",
    "implausible_unit",
    "interpolated",
    "mask_spikes",
    "not_static",
    "quantization_mismatch",
    "quantization_step",
    "repeated_samples",
    "saturation",
    "spikes",
    "start_transient",
    "stuck_samples",
    "undisturbed",
    "without_runs",
]

CHECKS = (
    implausible_unit,
    gravity,
    start_transient,
    not_static,
    spikes,
    dropouts,
    saturation,
    stuck_samples,
    repeated_samples,
    interpolated,
    coarse_resolution,
)
"""All checks of samples, in the order in which their findings are told: the gravest mistakes first."""

_EQUAL = (dropouts, saturation, stuck_samples, repeated_samples)
"""Checks that ask which samples are equal."""

_RUNS = (dropouts, saturation, stuck_samples, interpolated)


def check(stream: Stream) -> list[Finding]:
    """Everything that the samples of a stream alone show to be wrong with it.

    Parameters
    ----------
    stream : Stream
        Samples may be missing.

    Returns
    -------
    list of Finding
        At most one a kind and channel, or one for several channels of the stream.
    """
    begun = start_transient(stream)
    start = round(begun[0].size / stream.grid.tau0) if begun and begun[0].size else 0
    whole, stream = stream, blanked(stream, rows(stream, [(0, start)]))
    even = without_dust(stream)
    found = {one: one(even if one in _EQUAL else stream) for one in CHECKS if one is not start_transient}
    if found[spikes]:
        knocks = light_knocks(stream)
        masked = mask_spikes(Record(streams=(stream,)))[0].streams[0]
        if knocks:  # the largest samples of a knock are no spikes
            found[spikes] = spikes(blanked(stream, rows(stream, [(knock.start, knock.stop) for knock in knocks])))
        if found[not_static] or knocks:  # a single sample may move the mean of a window: that is no motion
            found[not_static] = not_static(stream, judged=masked, knocks=knocks)
    if found[not_static] and any(found[one] for one in _RUNS):  # and a level that is held is none of the sensor
        found[not_static] = not_static(without_runs(stream))
    found[start_transient] = begun if whole is not stream else []
    return [finding for one in CHECKS for finding in found[one]]
