"""Axes beside those whose noise is hidden by vibration: it shakes the body of the whole sensor."""

from __future__ import annotations

from collections.abc import Iterable

from sigmatau.findings.finding import Finding
from sigmatau.findings.fit import OtherAxesDisturbed
from sigmatau.findings.reasons import VibrationPower
from sigmatau.fitting.noise_fit import NoiseFit


def other_axes_disturbed(fits: Iterable[NoiseFit]) -> list[Finding]:
    """The quantified axes of a sensor whose other axes are disturbed: at most one finding.

    Which axes are disturbed beyond use is chance where all are shaken: see docs/study/rest.md.
    """
    fits = tuple(fits)
    disturbed = tuple(
        fitted.channel for fitted in fits if any(isinstance(reason, VibrationPower) for reason in fitted.reasons)
    )
    quantified = tuple(fitted.channel for fitted in fits if fitted.quantified and fitted.channel not in disturbed)
    if not disturbed or not quantified:
        return []
    return [Finding(details=OtherAxesDisturbed(disturbed=disturbed), severity="warning", channels=quantified)]
