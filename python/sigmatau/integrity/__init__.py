"""Findings about samples: what is wrong with a record before anything is computed from it.

One module a kind of fault; each takes a stream and returns findings. `check` runs them all.
"""

from sigmatau.integrity.interpolated import interpolated
from sigmatau.integrity.plausible import earth_rate, gravity, implausible_unit
from sigmatau.integrity.repeated import repeated_samples
from sigmatau.integrity.resolution import coarse_resolution, quantization_mismatch, quantization_step
from sigmatau.integrity.samples import without_dust
from sigmatau.integrity.saturation import saturation
from sigmatau.integrity.spikes import find_spikes, mask_spikes, spikes, without_spikes
from sigmatau.integrity.static import not_static
from sigmatau.integrity.stuck import dropouts, stuck_samples, without_runs
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.streams import Stream

__all__ = [
    "CHECKS",
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
    "stuck_samples",
    "without_runs",
    "without_spikes",
]

CHECKS = (
    implausible_unit,
    gravity,
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

_RUNS = (dropouts, saturation, stuck_samples)


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
    even = without_dust(stream)
    found = {one: one(even if one in _EQUAL else stream) for one in CHECKS}
    if found[spikes] and found[not_static]:  # a single sample may move the mean of a window: that is no motion
        masked, _ = mask_spikes(Record(streams=(stream,)))
        found[not_static] = not_static(masked.streams[0])
    if any(found[one] for one in _RUNS):  # a level that is held is none of the sensor, nor are its samples copies
        left = without_runs(even)
        if found[spikes]:
            found[spikes] = spikes(left)
        if found[not_static]:
            found[not_static] = not_static(left)
        if found[repeated_samples]:
            found[repeated_samples] = repeated_samples(left)
    return [finding for findings in found.values() for finding in findings]
