"""Sentences about a filter for `tune`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from sigmatau.digits import two_digits
from sigmatau.exporting.tuning.motion import MotionEffect
from sigmatau.results import seconds

if TYPE_CHECKING:
    from sigmatau.exporting.tuning.result import NoiseFactor, Tuning

UNIT_NIS = 100.0
"""NIS, or its inverse, above which a unit is wrong: all noises are too small or too large by a factor of 10."""

ROOT_OF_VARIANCE = "looks like a standard deviation. Give its square S, or name the column std"
"""Advice for a variance that is a standard deviation."""


def statements_of_tuning(tuning: Tuning) -> tuple[str, ...]:
    """Sentences on the errors of the filter, their direction and the action."""
    if tuning.verdict == "outliers":
        number = f"{tuning.outliers} innovations are" if tuning.outliers > 1 else "One innovation is"
        return (
            f"{number} beyond 7 deviations of the others, the first at {seconds(tuning.first_outlier or 0.0)} s."
            " No factor describes them: reject such measurements in the filter, or remove these rows",
        )
    effects = [_effect_statement(effect) for effect in tuning.motion if effect.has_error]
    texts = [*effects, *_offset_statements(tuning), *_noise_statements(tuning, follows_motion=bool(effects))]
    limit = _limit_of_motion(tuning)
    return (*texts, *([limit] if limit else []))


def _offset_statements(tuning: Tuning) -> list[str]:
    if not tuning.has_offset:
        return []
    places = [f" of {name}" for name in tuning.measurements] or [""]
    place = places[tuning.means.index(tuning.mean)]
    return [
        f"The mean of the innovations{place} is {two_digits(tuning.mean)} stated deviations, not 0."
        " The measurement has an offset that the filter does not estimate"
    ]


def _noise_statements(tuning: Tuning, *, follows_motion: bool) -> list[str]:
    """Sentences on the noises, from the spectrum."""
    if tuning.has_root_of_variance:
        return [f"S {ROOT_OF_VARIANCE}"]
    hidden = [factor.name for factor in tuning.factors if not factor.is_shown and factor not in tuning.causes]
    remarks = [f"The run does not show the {' and the '.join(hidden)}, whose factor is uncertain"] * bool(hidden)
    if tuning.noise_verdict == "consistent" and not tuning.factors:
        return ["Give N and K of the filter: the NIS and whiteness alone show large errors only"]
    if tuning.noise_verdict == "consistent":
        rest = "else " if tuning.has_offset or follows_motion else ""
        return [f"Nothing {rest}is wrong: the innovations are as the filter states", *remarks]
    if (common := tuning.common_factor) is not None:
        unit = " A factor of 57.3 is degrees instead of radians." if 55 < max(common, 1 / common) < 60 else ""
        return [
            f"All noises are {tuning.causes[0].direction} by one factor, {two_digits(common)}: innovation and S are in"
            f" different units, or all of S is scaled.{unit} Check both before you change a noise"
        ]
    if tuning.noise_verdict == "wrong":
        return [*(_cause(factor) for factor in tuning.causes), *remarks]
    if tuning.noise_verdict == "ambiguous":
        names = " or ".join(f"the {factor.name} {factor.direction}" for factor in tuning.causes)
        return [f"The filter is wrong, and the run does not show the cause: {names}. Use a longer run"]
    if tuning.noise_verdict == "not explained":
        action = "Check the model of the filter, and vibration"
        if not 1 / UNIT_NIS < tuning.nis < UNIT_NIS:
            action = "The NIS is far from 1: check the units of innovation and S first"
        elif not tuning.has_rate:
            action = "Add the rate of motion to the table: it shows whether a delay or a scale error is the cause"
        return [f"No factors on the noises explain the innovations (p = {tuning.p_misfit:.2g}). {action}"]
    return [_place(tuning), "Give N and K of the filter to find the noise that is wrong"]


def _limit_of_motion(tuning: Tuning) -> str:
    """Sentence on the scale errors and delays that the motion does not determine, and on the required motion."""
    hidden = [effect for effect in tuning.motion if not effect.has_error and not effect.is_shown]
    if not hidden:
        return ""
    if not all(math.isfinite(effect.value) for effect in hidden):
        return "The rate hardly changes, so neither a scale error nor a delay is shown. Turn the sensor back and forth"
    limits = " and ".join(f"a {effect.name} below {effect.limit}" for effect in hidden)
    needed = max(effect.needed for effect in hidden)
    goals = " and ".join(dict.fromkeys({"scale": "0.1 %", "delay": "1 ms"}[effect.effect] for effect in hidden))
    return f"The motion does not show {limits}. For {goals}, move {two_digits(needed)} times as fast, or record longer"


def _place(tuning: Tuning) -> str:
    """Averaging times at which the innovations are not as stated, without a filter."""
    curve = tuning.whiteness
    places = [(k, "larger") for k in np.flatnonzero(curve.low > 1)] + [
        (k, "smaller") for k in np.flatnonzero(curve.high < 1)
    ]
    if not places:
        return "The innovations are not as the filter states"
    texts = []
    for word in ("larger", "smaller"):
        times = [float(curve.tau[k]) for k, side in places if side == word]
        if times:
            texts.append(f"{word} than stated at averaging times from {seconds(min(times))} to {seconds(max(times))} s")
    return f"The innovations are {' and '.join(texts)}"


def _effect_statement(effect: MotionEffect) -> str:
    if effect.effect == "delay":
        place = f"measurement {effect.measurement}".strip()
        direction = "late" if effect.value > 0 else "early"
        return f"The {place} is {direction}: its delay is {effect.text}. Correct its time; no factor on a noise describes it"
    direction = "too large" if effect.value > 0 else "too small"
    place = f" against {effect.measurement}" if effect.measurement else ""
    return (
        f"The scale of the sensor is {direction}{place}: its error is {effect.text}. Calibrate it; no factor on a noise"
        " describes it"
    )


def _cause(factor: NoiseFactor) -> str:
    less = f"less than {two_digits(factor.high)}" if factor.high is not None and not factor.low else factor.text
    text = f"The {factor.name} is {factor.direction}: multiply it by {less}"
    if factor.assumed is None or not factor.low:
        return text
    return f"{text}, to {factor.assumed * factor.value:.3g} in SI"
