"""All checks of samples: one module per kind of fault; each takes a stream and returns findings."""

from dataclasses import replace

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.disturbances import NotStatic
from sigmatau.quality.samples.common import without_dust
from sigmatau.quality.samples.duplicate_rows import copies
from sigmatau.quality.samples.interpolation import interpolated
from sigmatau.quality.samples.light_shocks import light_shocks
from sigmatau.quality.samples.lost_rows import lost_rows
from sigmatau.quality.samples.masking import mask_of, masked
from sigmatau.quality.samples.repeated_samples import repeated_samples
from sigmatau.quality.samples.resolution import coarse_resolution
from sigmatau.quality.samples.saturation import saturation
from sigmatau.quality.samples.shocks_and_steps import not_static
from sigmatau.quality.samples.spikes import spikes, spikes_missing
from sigmatau.quality.samples.start_transient import start_transient
from sigmatau.quality.samples.stuck_samples import dropouts, stuck_samples, without_runs
from sigmatau.quality.samples.units import earth_rate, gravity, implausible_unit
from sigmatau.record.streams import Stream

__all__ = ["CHECKS", "check"]

CHECKS = (
    implausible_unit,
    gravity,
    earth_rate,
    start_transient,
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
"""All checks of samples, in the order of their findings: the gravest faults first."""

_EQUAL = (dropouts, saturation, stuck_samples, repeated_samples, copies)  # checks that compare samples for equality

_RUNS = (dropouts, saturation, stuck_samples, interpolated)


def check(stream: Stream) -> list[Finding]:
    """Findings of all checks that need only the samples: at most one per kind and channel, or one for several channels."""
    lost, stream = lost_rows(stream)  # not samples of the sensor
    begun = start_transient(stream)
    start = round(begun[0].size / stream.grid.tau0) if begun and begun[0].size else 0
    whole, stream = stream, masked(stream, mask_of(stream.grid.n, [(0, start)]))
    even = without_dust(stream)
    found = {one: one(even if one in _EQUAL else stream) for one in CHECKS if one is not start_transient}
    if found[spikes]:
        shocks = light_shocks(stream)
        alone = spikes_missing(stream)
        if shocks:  # the largest samples of a shock are not spikes
            still = masked(stream, mask_of(stream.grid.n, [(shock.start, shock.stop) for shock in shocks]))
            found[spikes] = spikes(still)
        if found[not_static] or shocks:  # a spike may move the mean of a window: that is not motion
            found[not_static] = not_static(stream, judged=alone, shocks=shocks)
        if found[implausible_unit]:  # spikes are not the noise of the sensor
            found[implausible_unit] = implausible_unit(alone)
    if any(found[one] for one in _RUNS):  # a held value is not a step, and its samples are not copies
        left = without_runs(even)
        if found[spikes]:
            found[spikes] = spikes(left)
        if found[not_static]:
            found[not_static] = not_static(left)
        if found[repeated_samples]:
            found[repeated_samples] = repeated_samples(left)
    if found[implausible_unit] or found[not_static]:  # the mean is not that of a sensor at rest
        found[earth_rate] = []
    found[start_transient] = begun if whole is not stream else []
    if any(len(one.channels) != 1 or one.channels == stream.channels for one in found[implausible_unit]):
        # the unit explains the mean, not a rotation
        found[not_static] = [one for one in found[not_static] if not _rotates(one)]
    told = (finding for one in CHECKS for finding in found[one])
    # Without its channels a finding of the gyros may equal one of the accelerometers.
    return [one if one.channels else replace(one, channels=stream.channels) for one in (*lost, *told)]


def _rotates(finding: Finding) -> bool:
    return isinstance(finding.details, NotStatic) and finding.details.rotation is not None
