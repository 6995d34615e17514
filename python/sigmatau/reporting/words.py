"""Words that the page and the document share: verdicts, trust, severities."""

from __future__ import annotations

from sigmatau.fitting.overview import Overview, SensorCoefficients

VERDICTS = {
    "at_rest": ("At rest", "good"),
    "partly_at_rest": ("At rest in part", "partial"),
    "not_at_rest": ("Not at rest", "poor"),
    "too_short_to_tell": ("Too short to tell", "poor"),
    "assumed": ("Taken as at rest", "partial"),
}
"""Name of each verdict on a record, and the trust whose colour it has."""

WITHOUT_COEFFICIENTS = {
    "not_at_rest": "the sensor is not at rest",
    "too_short_to_tell": "the record is too short to tell rest from motion",
}
"""Why a record has no coefficients, by verdict."""

TRUST = {
    "good": "intervals hold as they are",
    "partial": "usable with the limits in the warnings",
    "poor": "do not use",
}

SEVERITIES = {"error": "Error", "warning": "Warning", "info": "Note"}


def explain_trust(overview: Overview) -> dict[str, str]:
    """Explain each grade of trust that occurs in the overview."""
    return {word: text for word, text in TRUST.items() if word in overview.grades}


def length_text(sensor: SensorCoefficients) -> str:
    """Length of the record of a sensor, or the number of runs that were fitted together."""
    return f"{sensor.runs} runs" if sensor.runs else f"over {sensor.length}"
