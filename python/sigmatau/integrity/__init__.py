"""Findings about samples: what is wrong with a record before anything is computed from it.

One module a kind of fault; each takes a stream and returns findings. `check` runs them all.
"""

from dataclasses import replace

from sigmatau.integrity.copies import copies, copy_masks
from sigmatau.integrity.interpolated import interpolated
from sigmatau.integrity.masking import leave_out_option, masked
from sigmatau.integrity.plausible import earth_rate, gravity, implausible_unit
from sigmatau.integrity.repeated import repeated_samples
from sigmatau.integrity.resolution import coarse_resolution, quantization_mismatch, quantization_step, too_coarse
from sigmatau.integrity.samples import without_dust
from sigmatau.integrity.saturation import saturation
from sigmatau.integrity.spikes import find_spikes, mask_spikes, spikes
from sigmatau.integrity.static import not_static
from sigmatau.integrity.stuck import dropouts, stuck_samples, without_runs
from sigmatau.integrity.zeros import dropout_masks, lost_rows, stuck_masks
from sigmatau.record import Record
from sigmatau.results import Finding
from sigmatau.streams import Stream

__all__ = [
    "CHECKS",
    "check",
    "coarse_resolution",
    "copies",
    "copy_masks",
    "dropout_masks",
    "dropouts",
    "earth_rate",
    "find_spikes",
    "gravity",
    "implausible_unit",
    "interpolated",
    "leave_out_option",
    "lost_rows",
    "mask_spikes",
    "masked",
    "not_static",
    "quantization_mismatch",
    "quantization_step",
    "repeated_samples",
    "saturation",
    "spikes",
    "stuck_masks",
    "stuck_samples",
    "too_coarse",
    "without_runs",
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
    copies,
    interpolated,
    coarse_resolution,
)
"""All checks of samples, in the order in which their findings are told: the gravest mistakes first."""

_EQUAL = (dropouts, saturation, stuck_samples, repeated_samples, copies)
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
    lost, stream = lost_rows(stream)  # which are no samples of the sensor, whatever else would be said of them
    even = without_dust(stream)
    found = {one: one(even if one in _EQUAL else stream) for one in CHECKS}
    if found[spikes] and found[not_static]:  # a single sample may move the mean of a window: that is no motion
        masked, _ = mask_spikes(Record(streams=(stream,)))
        found[not_static] = not_static(masked.streams[0])
    if found[not_static] and any(found[one] for one in _RUNS):  # and a level that is held is none of the sensor
        found[not_static] = not_static(without_runs(stream))
    if any(
        not finding.channel for finding in found[implausible_unit]
    ):  # then the mean is no rotation, but the unit's fault
        found[not_static] = [finding for finding in found[not_static] if finding.where]
    return [_named(finding, stream) for finding in (*lost, *(one for several in found.values() for one in several))]


def _named(finding: Finding, stream: Stream) -> Finding:
    """A finding of several axes says which sensor's: gyros and accelerometers may have the same to be told."""
    if finding.channel is not None or any(name in finding.message for name in (stream.name, *stream.channels)):
        return finding
    return replace(finding, message=f"{stream.name}: {finding.message}")
