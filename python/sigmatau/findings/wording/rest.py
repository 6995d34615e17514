"""Words of findings about a sensor that does not rest, or rests for a part of the record."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding, Span
from sigmatau.findings.kinds.rest import AssumedAtRest, KeptOfStream, Motion, NotAtRest, PartlyAtRest, TooShortToTell
from sigmatau.findings.wording.phrases import LONGEST, Words, clock, keep_option, number, percent, while_short
from sigmatau.results import duration_text, two_digits

_UNITS = {"angular_rate": ("deg/s", math.degrees(1.0))}


def _motion(motion: Motion) -> str:
    unit, factor = _UNITS.get(motion.quantity, ("m/s^2", 1.0))
    size = f"{number(factor * motion.size)} {unit}"
    if motion.kind == "turns":
        return f"{motion.channel} turns at {size}"
    if motion.kind == "loud":
        sensor = "gyro" if motion.quantity == "angular_rate" else "accelerometer"
        return f"{motion.channel} has noise of {size}/√Hz, more than any {sensor}"
    if motion.kind == "tilts":
        angle = number(math.degrees(motion.size))
        return f"gravity changes direction by {angle} deg in {two_digits(motion.tau)} s"
    if motion.kind == "shakes":
        return f"tremor of {size} at {number(0.5 / motion.tau)} Hz on all gyros"
    return f"{motion.channel} changes by {size} in {two_digits(motion.tau)} s"


def _not_at_rest(_: Finding, details: NotAtRest) -> Words:
    in_doubt = details.motion.kind in ("turns", "loud")
    unit = " or the unit is wrong" if in_doubt else ""
    message = f"not at rest{unit}: {_motion(details.motion)}; no coefficients are given"
    if not details.still:
        remedy = "Record the sensor at rest, check the unit," if in_doubt else "Record the sensor at rest,"
        return Words(message, f"{remedy} or run with --at-rest to analyse the motion as noise")
    options = [f"{keep_option(span)} ({duration_text(span[1] - span[0])} at rest)" for span in details.still]
    return Words(message, while_short(f"Run with {options[0]}", options[1:], between=" or ", longest=LONGEST))


def _too_short_to_tell(finding: Finding, details: TooShortToTell) -> Words:
    got, need = duration_text(details.duration), duration_text(details.shortest)
    if finding.severity == "info":
        return Words(f"{got} are too short to tell rest from motion ({need} needed); analysed as at rest, as requested")
    message = f"too short to tell rest from motion: {got}, {need} needed; no coefficients are given"
    return Words(message, "Record for longer, or run with --at-rest if the sensor was at rest")


def _partly_at_rest(_: Finding, details: PartlyAtRest) -> Words:
    whole = [one for one in details.kept if one.left_out > 0]
    cut = [one for one in details.kept if one not in whole]
    said = []
    if whole:
        said.append(f"{_moved(details.moved)} left out{'' if not cut else f' of {_names(whole)}'}")
    if cut:
        name = f"{_names(cut)} " if whole else "partly at rest: "
        span, share = f"{clock(cut[0].start)} to {clock(cut[0].stop)}", percent(cut[0].share)
        said.append(f"{name}analysed from {span}, {share} of the record")
    return Words("; ".join(said))


def _moved(spans: tuple[Span, ...]) -> str:
    total = duration_text(sum(stop - start for start, stop in spans))
    if len(spans) == 1:
        return f"motion at {clock(spans[0][0])} for {total}"
    return f"{len(spans)} periods of motion, {total} in total,"


def _names(kept: list[KeptOfStream]) -> str:
    return " and ".join(one.stream for one in kept)


def _assumed_at_rest(_: Finding, details: AssumedAtRest) -> Words:
    return Words(f"not at rest: {_motion(details.motion)}; analysed as noise, as requested")


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    NotAtRest: _not_at_rest,
    TooShortToTell: _too_short_to_tell,
    PartlyAtRest: _partly_at_rest,
    AssumedAtRest: _assumed_at_rest,
}
