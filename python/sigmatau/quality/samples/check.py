"""All checks of samples that are not disturbances. Each takes a stream and returns findings."""

from dataclasses import replace

from sigmatau.findings.finding import Finding
from sigmatau.quality.motion.shocks_and_steps import not_static
from sigmatau.quality.samples.common import without_rounding_errors
from sigmatau.quality.samples.copied_stretches import copied_stretches
from sigmatau.quality.samples.disturbances import disturbances, masked_by
from sigmatau.quality.samples.interpolation import interpolated
from sigmatau.quality.samples.repeated_samples import repeated_samples
from sigmatau.quality.samples.resolution import coarse_resolution
from sigmatau.quality.samples.units import gravity, implausible_unit, mean_rate
from sigmatau.record.streams import Stream


def check(stream: Stream) -> list[Finding]:
    """Findings about samples that are not disturbances: at most one per kind and channel, or one for several channels."""
    disturbed = disturbances(stream)
    still = masked_by(stream, disturbed)
    unit = implausible_unit(still)
    shaken = masked_by(
        stream, (disturbance for disturbance in disturbed if disturbance.cause not in ("shocks", "spikes"))
    )
    moved = not_static(shaken, still=still)
    findings = [
        *(unit or mean_rate(still)),
        *gravity(still),
        *moved,
        *repeated_samples(masked_by(without_rounding_errors(stream), disturbed)),
    ]
    findings += [*copied_stretches(stream), *interpolated(still), *coarse_resolution(still)]
    # Without its channels, a finding about gyros may equal one about accelerometers.
    return [finding if finding.channels else replace(finding, channels=stream.channels) for finding in findings]
