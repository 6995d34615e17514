"""Check whether a sensor meets its datasheet, term by term, with the error of the measurement.

A value is *above* a limit if a sensor exactly at the limit would have such a large value in at most 1 − level of its
records; *below* is defined likewise for small values. Any other value is *undecided*: the record is too short to decide.
This is the decision rule of ISO 14253-1.

Standard errors are those of the intervals. They allow for terms that were not observed, and are larger than the errors
for the chosen model alone. With the smaller errors, a K exactly at its limit, with an unobserved B, would be outside in
24 % of 183 simulated records instead of 5 %.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from numbers import Real
from pathlib import Path
from statistics import NormalDist
from typing import Protocol

from sigmatau import ChannelModel, NoiseFit, NoiseModel
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting import MeanStability, to_models
from sigmatau.lab.datasheets.claims import AXES, MEANS, QUANTITIES, Bias, Claim, Meaning, Sided, check_meanings
from sigmatau.lab.datasheets.doubts import Doubt
from sigmatau.lab.datasheets.measured import Measured, measured, measured_means, stability
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.lab.datasheets.sheet import datasheet as find_datasheet
from sigmatau.lab.datasheets.verdict import ClaimReading, Judged, LimitComparison, Status, Verdict
from sigmatau.model import LARGEST
from sigmatau.record import stream_name

_EQUAL = 1e-9  # largest relative difference of equal numbers without errors
_MOST_SIGMAS = 1e6  # largest distance in standard errors; that of an interval without width


class Fitted(Protocol):
    """An `Analysis`, or another object with `fits`."""

    @property
    def fits(self) -> Mapping[str, NoiseFit]:
        """Fit of each channel."""
        ...


def compare_with(
    result: NoiseModel | Fitted,
    datasheet: Datasheet | str | Path,
    *,
    unit: str = "result",
    level: float = 0.95,
    factor: float | None = None,
    sided: Sided | None = None,
    bias: Bias | None = None,
) -> Verdict:
    """Compare a result with a datasheet, term by term.

    Parameters
    ----------
    result : NoiseModel or Analysis
        A `NoiseModel` without intervals is compared without statistics.
    datasheet : Datasheet, str or Path
        A name of the library or the path of a file; see :func:`sigmatau.datasheet`.
    unit : str, optional
        Name of the unit, for printing.
    level : float, optional
        Confidence level of the status ``"out"``: a value exactly at its limit is ``"out"`` in at most 1 − level of the
        records.
    factor : float, optional
        Factor from the typical value to the maximum, if the datasheet has no maximum. Default: no maximum; a value above
        the typical one is reported, but is not ``"out"``.
    sided : {"one", "two"}, optional
        Convention of noise densities if the datasheet does not state it. Default: try both; the status is undecided if they
        differ.
    bias : {"minimum", "coefficient"}, optional
        Convention of bias instabilities if not stated: the minimum of the Allan deviation, or B.

    Returns
    -------
    Verdict

    Raises
    ------
    OptionError
        For an unknown datasheet, or an invalid level, factor or convention.
    DataError
        If `result` is not a result, or the datasheet file cannot be read.

    See Also
    --------
    datasheet : the datasheets.
    judge_lot : compares many units with a specification.

    References
    ----------
    ISO 14253-1:2017, section 5; JCGM 106:2012, section 8.

    Examples
    --------
    >>> import sigmatau as st
    >>> measured = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-5}})
    >>> verdict = st.compare_with(measured, "icm42688p", sided="one", bias="minimum", factor=2)
    >>> [(one.claim.key, one.status) for one in verdict.judged if one.channel == "gyro_x"]
    [('noise_density', 'within')]
    """
    check_options(level=level, factor=factor, sided=sided, bias=bias)
    sheet = datasheet if isinstance(datasheet, Datasheet) else find_datasheet(datasheet)
    models, without, means = _models(result)
    judged, unspecified = [], []
    for channel, model in models.items():
        claims = sheet.of(channel)
        for claim in claims:
            readings = tuple(
                _reading(claim, meaning, model, means.get(channel, {}), level, factor)
                for meaning in claim.meanings(sided=sided, bias=bias)
            )
            status, doubt = _status(readings) if model.adequate else ("undecided", _model_doubt(model))
            judged.append(Judged(channel=channel, claim=claim, readings=readings, status=status, doubt=doubt))
        stated_terms = {claim.term for claim in claims}
        unspecified += [
            (channel, term) for term in model.terms if term not in stated_terms and term not in model.limits
        ]
    absent = _absent(sheet, [*models, *without])
    return Verdict(
        unit=unit,
        datasheet=sheet.name,
        judged=tuple(judged),
        unsaid=tuple(unspecified),
        missing=(*(name for name in without if sheet.of(name)), *absent),
        absent=absent,
        level=level,
        factor=factor,
    )


def check_options(*, level: float, factor: float | None, sided: str | None, bias: str | None) -> None:
    """Raise `OptionError` for invalid options of a comparison."""
    check_meanings(sided, bias)
    if not (_is_number(level) and 0.5 <= level < 1):
        raise OptionError(f"{{option}} must be a number from 0.5 to below 1, not {level!r}", option="level")
    if factor is not None and not (_is_number(factor) and 1 <= factor <= LARGEST):
        raise OptionError(f"{{option}} must be a number from 1 to {LARGEST:g}, not {factor!r}", option="factor")


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _absent(datasheet: Datasheet, channels: Sequence[str]) -> tuple[str, ...]:
    """Sensors and axes of the datasheet that are not in the result. A channel with the name of a sensor counts for all
    its axes.
    """
    absent = {claim.sensor for claim in datasheet.claims}
    absent -= {*channels, *map(stream_name, channels)}
    for sensor in QUANTITIES:
        if sensor not in channels and any(f"{sensor}_{axis}" in channels for axis in AXES):
            absent |= {*datasheet.channels(sensor)} - {*channels}
    return tuple(sorted(absent))


Means = Mapping[str, Mapping[float, Measured]]  # standard deviations of means by channel and averaging time in s


def _models(result: NoiseModel | Fitted) -> tuple[dict[str, ChannelModel], list[str], Means]:
    """Collect the models by channel, the channels without a model, and the standard deviations of means."""
    if isinstance(result, NoiseModel):
        return dict(result.channels), [], {}
    fits: Mapping[str, NoiseFit] | None = getattr(result, "fits", None)
    if fits is None:
        hint = "; read its JSON with Analysis.from_dict(content)" if isinstance(result, Mapping) else ""
        raise DataError(f"{type(result).__name__} is not a result: give an Analysis or a NoiseModel{hint}")
    if not fits and (reason := getattr(result, "reason_without_fits", "")):
        raise DataError(reason)
    for name, fit in fits.items():
        if not name.isprintable():
            raise DataError(f"channel {name!r}: not a printable name")
        measures = (fit.quantity, fit.rate_unit)
        if QUANTITIES.get(stream_name(name), measures) != measures:
            raise DataError(f"channel {name!r}: this name does not fit {' in '.join(measures)}")
    models = to_models(fits)
    means: Mapping[str, Sequence[MeanStability]] = getattr(result, "mean_stability", {})
    by_channel = {name: measured_means(rows) for name, rows in means.items() if name in fits}
    return models, [name for name in fits if name not in models], by_channel


def _reading(
    claim: Claim,
    meaning: Meaning,
    model: ChannelModel,
    means: Mapping[float, Measured],
    level: float,
    factor: float | None,
) -> ClaimReading:
    value = stability(means, claim.average or 0.0) if meaning.of == MEANS else measured(model, meaning.of)
    maximum = claim.maximum
    if maximum is None and factor is not None and claim.typical is not None:
        maximum = factor * claim.typical
    return ClaimReading(
        meaning=meaning,
        measured=value,
        typical=_compared(value, claim.typical, meaning.factor, level, adequate=model.adequate),
        maximum=_compared(value, maximum, meaning.factor, level, adequate=model.adequate),
    )


def _compared(
    value: Measured, stated: float | None, factor: float, level: float, *, adequate: bool
) -> LimitComparison | None:
    if stated is None:
        return None
    limit = factor * stated
    if not adequate:  # the error of the values is unknown
        return LimitComparison(limit=limit, side="undecided")
    if value.value is None:
        # A limit at a level of 95 % does not decide at 99 %.
        decides = level <= value.level
        below = decides and value.upper_limit is not None and value.upper_limit < limit
        above = decides and value.lower_limit is not None and value.lower_limit > limit * (1 + _EQUAL)
        return LimitComparison(limit=limit, side="above" if above else "below" if below else "undecided")
    if value.low is None or value.high is None:
        if math.isclose(value.value, limit, rel_tol=_EQUAL):
            return LimitComparison(limit=limit, side="undecided")
        return LimitComparison(limit=limit, side="above" if value.value > limit else "below")
    sigmas = _sigmas(value.value, value.low, value.high, limit, value.level)
    enough = NormalDist().inv_cdf(level)
    return LimitComparison(
        limit=limit, side="above" if sigmas > enough else "below" if sigmas < -enough else "undecided", sigmas=sigmas
    )


def _sigmas(value: float, low: float, high: float, limit: float, level: float) -> float:
    """Distance of a value from a limit in standard errors, from the end of the interval on the side of the limit.

    It is computed from logarithms, because a coefficient is a scale parameter and its interval need not be symmetric.
    """
    reach = NormalDist().inv_cdf((1 + level) / 2)
    end = low if value > limit else high
    if end <= 0:  # linear for an interval that starts at 0
        return reach * (value - limit) / value
    width = abs(math.log(value / end))
    distance = reach * math.log(value / limit)
    if not width and not distance:
        return 0.0
    return math.copysign(min(abs(distance) / width, _MOST_SIGMAS) if width else _MOST_SIGMAS, distance)


def _model_doubt(model: ChannelModel) -> Doubt:
    """The doubt about a model that does not fit."""
    return Doubt(kind="only_limits" if model.has_only_limits else "not_adequate")


def _status(readings: tuple[ClaimReading, ...]) -> tuple[Status, Doubt | None]:
    """Common status of all meanings; otherwise ``"undecided"`` with the reason."""
    statuses = {_reading_status(reading) for reading in readings}
    if len(statuses) == 1:
        status = statuses.pop()
        return status, readings[0].measured.doubt if status == "undecided" else None
    conventions = tuple(reading.meaning.words for reading in readings)
    is_typical_only = statuses <= {"within", "above typical"}
    return "undecided", Doubt(
        kind="convention_of_typical" if is_typical_only else "convention", conventions=conventions
    )


def _reading_status(reading: ClaimReading) -> Status:
    typical, maximum = reading.typical, reading.maximum
    if not reading.measured.anything:
        return "undecided"
    if maximum is not None and maximum.side == "above":
        return "out"
    if maximum is not None and maximum.side == "undecided":
        return "undecided"
    if typical is not None and typical.side == "above":
        return "above typical"
    # A value close to the typical one is within; a term that was not observed may have any value up to its limit.
    if maximum is None and typical is not None and typical.side == "undecided" and reading.measured.value is None:
        return "undecided"
    return "within"
