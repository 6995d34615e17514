"""Words of findings about disturbances (motion, shocks, steps of the mean, spikes, start transients) and excluded parts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.disturbances import (
    ChosenWindow,
    LeftOut,
    LevelStep,
    MotionBurst,
    NotStatic,
    Spikes,
    StartTransient,
    WindowChosen,
)
from sigmatau.findings.wording.phrases import (
    LONGEST,
    Words,
    axes_text,
    clock,
    keep_option,
    leave_out_option,
    number,
    percent,
    while_short,
)
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import duration_text, seconds

_GRAVITY = 9.80665  # m/s²
_WALK = "rate_random_walk"


def _not_static(finding: Finding, details: NotStatic) -> Words:
    effects = [_walk_text(details), _tilt(details)] if details.steps else []
    said = [_bursts(details.bursts), _steps(details)]
    message = " and ".join(filter(None, said)) + (", in addition to a drift" if details.beside_drift else "")
    return Words(while_short(message, effects), _left_or_kept(details))


def _left_or_kept(details: NotStatic) -> str:
    if details.leave_out:
        return f"Run with {leave_out_option(details.leave_out, longest=LONGEST - len('Run with '))}"
    if details.keep is not None:
        return f"Run with {keep_option(details.keep)} to keep the longest part without a step"
    return ""


def _bursts(bursts: Sequence[MotionBurst]) -> str:
    if not bursts:
        return ""
    strongest = max(bursts, key=lambda burst: burst.ratio)
    shocks = all(burst.shock for burst in bursts)
    if len(bursts) == 1:
        lasting = duration_text(strongest.stop - strongest.start)
        return f"{'shock' if shocks else 'motion'} at {clock(strongest.start)} for {lasting}"
    total = duration_text(sum(burst.stop - burst.start for burst in bursts))
    what = f"{len(bursts)} shocks" if shocks else f"{len(bursts)} periods of motion"
    return f"{what}, {total} in total, the strongest at {clock(strongest.start)}"


def _steps(details: NotStatic) -> str:
    if not details.steps:
        return ""
    steps, largest = details.steps, max(details.steps, key=lambda step: abs(step.size))
    size = f"{number(largest.size, sign='+')} {details.unit}"
    if len(steps) > 1:
        return f"{len(steps)} steps of the mean, the largest {size} {_about(largest)}"
    return f"{'drift' if largest.gradual else 'step'} of the mean by {size} {_about(largest)}"


def _tilt(details: NotStatic) -> str:
    if details.quantity != "acceleration" or details.bursts:
        return ""
    angle = math.degrees(max(abs(step.size) for step in details.steps) / _GRAVITY)
    return f"a tilt of {number(angle)} deg if the sensor is level"


def _about(step: LevelStep) -> str:
    return f"{'around' if step.gradual else 'at'} {clock(step.time)}"


def _walk_text(details: NotStatic) -> str:
    text, scale = display_units(_WALK, details.quantity, details.unit)[0]
    return f"adds {number(details.added_walk / scale)} {text} of {TERMS[_WALK].label(details.quantity)}"


def _spikes(finding: Finding, details: Spikes) -> Words:
    height = f"{number(details.height, sign='+')} {details.unit}"
    found = f"1 spike of {height} at {clock(details.time)}"
    if details.count > 1:
        share = percent(details.share)
        found = f"{details.count} spikes ({share}), the largest {height} at {clock(details.time)}"
    if not details.more_below:
        return Words(found)
    return Words(
        f"{found}, beside smaller ones in the noise",
        "Run again with --keep spikes: the random walk is between the two results" if finding.left_out else "",
    )


def _start_transient(finding: Finding, details: StartTransient) -> Words:
    return Words(f"the record starts near zero and settles within {duration_text(details.settled)}")


def _left_out(finding: Finding, details: LeftOut) -> Words:
    streams = details.streams
    if not streams:
        return Words("no samples excluded: the option matches no samples")
    first = streams[0]
    if len({(one.count, one.samples) for one in streams}) == 1:
        lasting = f"{percent(first.count / first.samples)}, {duration_text(first.duration)}"
        names = axes_text([one.stream for one in streams])
        return Words(f"{first.count} of {first.samples} samples of {names} excluded as requested ({lasting})")
    said = [f"{one.count} samples of {one.stream} ({duration_text(one.duration)})" for one in streams]
    return Words(while_short(f"excluded as requested: {said[0]}", said[1:], between=", "))


def _window_chosen(finding: Finding, details: WindowChosen) -> Words:
    said = [_window(one) for one in details.windows]
    message = while_short(f"most stable window of {duration_text(details.length)}: {said[0]}", said[1:], between=", ")
    if not any(one.criterion == "own" for one in details.windows):
        return Words(message)
    return Words(
        message, "Analyse the whole record: a window chosen by its noise underestimates the noise of the sensor"
    )


def _window(window: ChosenWindow) -> str:
    by = "its scatter" if window.criterion == "own" else window.by
    return f"{window.stream} from {seconds(window.start)} s (chosen by {by})"


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    NotStatic: _not_static,
    Spikes: _spikes,
    StartTransient: _start_transient,
    LeftOut: _left_out,
    WindowChosen: _window_chosen,
}
