"""Planning of a record: the smallest coefficient that a record of a given length shows, and the length that shows a given
value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.gls import Components, Gls
from sigmatau.digits import significant
from sigmatau.errors import OptionError
from sigmatau.fitting.alternatives import Modes, least_ramp_beside_walk, process_excluded
from sigmatau.fitting.components import LONGEST_SHARE, MIN_TIMES, coefficient, half_octaves, linear_powers
from sigmatau.frozen import frozen
from sigmatau.model.channel import ChannelModel
from sigmatau.model.process_curves import process_text, process_values
from sigmatau.model.processes import GaussMarkov
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import NOISE, TERMS, coefficient_unit, display_units
from sigmatau.results import Printed, duration_text, lines_text, plain, wrapped

LONGEST_RECORD = 10**13  # Longest record that is considered. [samples]
_SHORTEST = 64  # shortest record that is considered, over the smallest cluster size [1]
_EVEN_DETECTION = 0.5  # probability that a coefficient is detected: even odds
_LIKELY_DETECTION = 0.9  # probability of a likely detection
_LARGEST_RATIO = 1e4  # largest ratio of the value to the smallest significant one that is searched [1]
_LARGEST_ERROR = 0.5  # relative standard error above which a coefficient counts as not determined
_STEP = 1.01  # ratio of values at which a search ends: two digits suffice


@frozen
class Plan(Printed):
    """The smallest coefficient of a term that a record shows, and the length of a record that shows a given value.

    Attributes
    ----------
    channel, quantity, rate_unit, term, unit : str
        `unit` is that of the values, in SI.
    others : mapping of str to float
        The other noise of the channel. [SI]
    tau0 : float
        Sample interval. [s]
    duration : float or None
        Length of the record. [s]
    half, most : float or None
        Smallest value that is detected in 50 % and in 90 % of such records; None if there is none. [unit]
    value : float or None
        The value for which lengths were computed. [unit]
    half_in, most_in : float or None
        Length of a record that shows that value with a probability of 50 % and of 90 %; None if there is none. [s]
    error : float or None
        Relative standard error of the value in a record of that duration.
    level : float
        Confidence level of the test.
    gauss_markov : tuple of GaussMarkov
        The Gauss-Markov process of the channel, if any.

    See Also
    --------
    plan : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> kind = {"channel": "gyro_x", "quantity": "angular_rate", "rate_unit": "rad/s"}
    >>> found = st.plan({"random_walk": 1e-4}, "rate_random_walk", rate=100, duration=3600, **kind)
    >>> found.half < found.most, found.unit
    (True, 'rad/s/sqrt(s)')
    """

    channel: str
    quantity: str
    rate_unit: str
    term: str
    unit: str
    others: Mapping[str, float]
    tau0: float
    duration: float | None
    half: float | None
    most: float | None
    value: float | None
    half_in: float | None
    most_in: float | None
    error: float | None = None
    level: float = 0.95
    gauss_markov: tuple[GaussMarkov, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        processes = [process_values(process) for process in self.gauss_markov]
        fields = "channel term unit others record_s=duration found_in_half=half found_in_nine_of_ten=most value"
        times = "half_find_it_in_s=half_in nine_of_ten_find_it_in_s=most_in relative_error=error level"
        return plain(self, fields, times, gauss_markov=processes, sample_rate_hz=1 / self.tau0)

    def __repr__(self) -> str:
        label = TERMS[self.term].label(self.quantity)
        sizes = (self.value, self.half, self.most)
        text, factor = display_units(self.term, self.quantity, self.rate_unit, sizes)[-1]
        terms = []
        for name, value in self.others.items():
            unit, size = display_units(name, self.quantity, self.rate_unit, [value])[-1]
            terms.append(f"{TERMS[name].label(self.quantity)} {value / size:.4g} {unit}")
        sigmas = [process.sigma for process in self.gauss_markov]
        unit, size = display_units("bias_instability", self.quantity, self.rate_unit, sigmas)[-1]
        terms += [process_text(process, unit, size) for process in self.gauss_markov]
        lines = [f"{self.channel}: {label} beside {', '.join(terms)}; {1 / self.tau0:.6g} Hz"]
        absent = [t for t in TERMS if t not in self.others and t not in (self.term, "rate_ramp")]
        if absent:
            names = ", ".join(TERMS[name].label(self.quantity) for name in absent)
            lines.append(f"  assumed to be absent: {names}")
        if self.duration is not None:
            head = f"  a record of {duration_text(self.duration)} shows"
            if self.half is None or self.most is None:
                lines.append(f"{head} no value, however large")
            else:
                half, nine_of_ten = (significant(size / factor, 2, zeros=True) for size in (self.half, self.most))
                lines.append(f"{head} {half} {text} (50 % probability) or {nine_of_ten} {text} (90 %)")
        if self.value is not None:
            head = f"  {self.value / factor:.4g} {text} needs a record"
            if self.half_in is None or self.most_in is None:
                lines.append(f"{head} longer than {duration_text(LONGEST_RECORD * self.tau0)}")
            else:
                half, nine_of_ten = duration_text(self.half_in), duration_text(self.most_in)
                lines.append(f"{head} of {half} (50 % probability) or {nine_of_ten} (90 %)")
            if self.error is not None and self.duration is not None:
                what = f"{'an' if label[0] in 'aeiou' else 'a'} {label} of {self.value / factor:.4g} {text}"
                how = f"determines {what} to ± {significant(100 * self.error, 2, zeros=True)} %, one standard error"
                how = (
                    how
                    if self.error < _LARGEST_ERROR
                    else f"does not determine {what}: its standard error exceeds 50 %"
                )
                lines.append(f"  a record of {duration_text(self.duration)} {how}")
        return lines_text(wrapped(lines, indent=4))


def smallest_detectable(
    background: Mapping[str, float],
    term: str,
    *,
    n: int,
    tau0: float,
    tau_min: float = 0.0,
    power: float = 0.5,
    level: float = 0.95,
) -> float:
    """The smallest coefficient that a record shows with a given probability.

    The term must be significant, and the record must not be explained as well without it: a bias instability by a
    Gauss-Markov process, a ramp by a rate random walk.

    Notes
    -----
    The variance of a Gauss-Markov process of `background` is a free parameter, like the other coefficients; its correlation
    time is known.

    `background`: the other noise of the channel, by key of `sigmatau.noise.terms.TERMS`, or a model, which may have one
    Gauss-Markov process [SI]; `term`: the term to be detected; its entry in `background` is ignored; `tau0`: sample interval
    [s]; `tau_min`: shortest averaging time that can be used, for example because of a filter [s]; `power`: probability that
    the term is detected; `level`: confidence level of the test: an absent term is detected in 1 − level of all records. The
    result is in SI; inf if no value is detected with that probability.
    """
    smallest = smallest_significant(background, term, n=n, tau0=tau0, tau_min=tau_min, power=power, level=level)
    if not math.isfinite(smallest):
        return math.inf
    modes, processes = Modes(n, tau0, tau_min), _processes(background)
    if term == "rate_ramp":
        return max(smallest, least_ramp_beside_walk(modes, background, processes, power))
    if term != "bias_instability" or process_excluded(modes, background, processes, smallest, power):
        return smallest
    low, high = smallest, 2 * smallest
    while not process_excluded(modes, background, processes, high, power):
        low, high = high, 2 * high
        if high > _LARGEST_RATIO * smallest:
            return math.inf
    while high / low > _STEP:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if process_excluded(modes, background, processes, middle, power) else (middle, high)
    return high


def smallest_significant(
    background: Mapping[str, float],
    term: str,
    *,
    n: int,
    tau0: float,
    tau_min: float = 0.0,
    power: float = 0.5,
    level: float = 0.95,
) -> float:
    """The smallest coefficient that a test of the term on the Allan deviation detects; parameters and errors are those of
    `smallest_detectable`.
    """
    if term not in TERMS:
        raise OptionError(unknown_term(term), option="term")
    unknown = sorted(set(background) - set(TERMS))
    if unknown:
        raise OptionError(unknown_term(unknown[0]), option="model")
    if not (math.isfinite(tau0) and tau0 > 0):
        raise OptionError(f"`tau0` must be a positive number of seconds, not {tau0!r}", option="rate")
    theta = _theta(background, tau0)
    if term in NOISE:
        theta[NOISE.index(term)] = 0.0
    if not theta.any():
        raise OptionError(
            f"there is no noise besides {term}, so any value is detected. Give the other terms", option="model"
        )
    parts = _parts(n, tau_min / tau0, _times(background, tau0))
    scale = float(np.median(parts.design @ theta))
    theta /= scale
    if term == "rate_ramp":
        return parts.least_ramp(theta, level=level, power=power) * math.sqrt(scale) / tau0
    detectable = parts.detectable(NOISE.index(term), theta, level=level, power=power)
    return coefficient(detectable * scale, term, tau0) if math.isfinite(detectable) else math.inf


def needed_samples(
    background: Mapping[str, float],
    term: str,
    value: float,
    *,
    tau0: float,
    tau_min: float = 0.0,
    power: float = 0.5,
    level: float = 0.95,
) -> float:
    """Samples of the shortest record that shows `value` with probability `power`; inf above `LONGEST_RECORD`.
    Parameters and errors are those of `smallest_detectable`.
    """
    if not (math.isfinite(value) and value != 0):
        raise OptionError(f"the value must be a number other than 0, not {value!r}", option="value")

    def shows(n: int) -> bool:
        smallest = smallest_significant(background, term, n=n, tau0=tau0, tau_min=tau_min, power=power, level=level)
        if smallest > abs(value):
            return False
        modes, processes = Modes(n, tau0, tau_min), _processes(background)
        if term == "rate_ramp":
            return least_ramp_beside_walk(modes, background, processes, power) <= abs(value)
        return term != "bias_instability" or process_excluded(modes, background, processes, abs(value), power)

    low = round(_SHORTEST * max(tau_min / tau0, 1))
    if shows(low):
        return float(low)
    high = 4 * low
    while not shows(high):
        low, high = high, 4 * high
        if high > LONGEST_RECORD:
            return math.inf
    # Two digits suffice: the longest averaging time of the grid changes in steps.
    while high / low > 1.02:
        middle = round(math.sqrt(low * high))
        low, high = (low, middle) if shows(middle) else (middle, high)
    return float(high)


def relative_error(
    background: Mapping[str, float], term: str, value: float, *, n: int, tau0: float, tau_min: float = 0.0
) -> float:
    """Relative standard error of a coefficient if all terms are free; parameters as in `smallest_detectable`.

    It comes from the covariance of the Allan variances. Above 0.5 it is only an order of magnitude.
    """
    theta = _theta(background, tau0)
    k = NOISE.index(term)
    theta[k] = _theta({term: value}, tau0)[k]
    parts = _parts(n, tau_min / tau0, _times(background, tau0))
    theta /= float(np.median(parts.design @ theta))
    gls = Gls(parts, parts.design @ theta)
    return float(np.sqrt(gls.covariance_of_theta(theta, gls.candidates)[k, k]) / (2 * theta[k]))


def plan(
    others: Mapping[str, float],
    term: str,
    *,
    channel: str,
    quantity: str,
    rate_unit: str,
    rate: float,
    tau_min: float = 0.0,
    duration: float | None = None,
    value: float | None = None,
) -> Plan:
    """The smallest coefficient that a record of `duration` shows, and the length of record that shows `value`.

    Parameters
    ----------
    others : mapping of str to float, or ChannelModel
        The noise of the channel, see `smallest_detectable`; the entry of the term itself is ignored. [SI]
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    channel, quantity, rate_unit : str
        For the units of the result.
    rate : float
        Sampling rate. [Hz]
    tau_min : float
        Shortest averaging time that can be used. [s]
    duration : float, optional
        Length of a record. [s]
    value : float, optional
        A coefficient. [SI]

    Returns
    -------
    Plan

    Raises
    ------
    OptionError
        For the reasons of `smallest_detectable`, and if neither a duration nor a value is given.

    See Also
    --------
    analyze : the terms that a record shows.

    References
    ----------
    docs/theory/fit.md; the test of a term is that of `sigmatau.fit`. docs/study/planning.md: how often the default fit shows
    the planned values.

    Examples
    --------
    >>> import sigmatau as st
    >>> kind = {"channel": "gyro_x", "quantity": "angular_rate", "rate_unit": "rad/s"}
    >>> found = st.plan({"random_walk": 1e-4}, "bias_instability", rate=10, value=2e-5, **kind)
    >>> round(found.half_in), round(found.most_in)  # seconds, to see it with 50 % and with 90 %
    (5164, 14766)
    """
    if duration is None and value is None:
        raise OptionError("give the length of a record, a value, or both", option="hours")
    if not (math.isfinite(rate) and rate > 0):
        raise OptionError(f"the rate must be a positive number of hertz, not {rate!r}", option="rate")
    tau0 = 1 / rate
    half = nine_of_ten = half_in = most_in = None
    if duration is not None:
        if not (math.isfinite(duration) and duration > 0):
            raise OptionError(f"the length must be a positive number of seconds, not {duration!r}", option="hours")
        n = round(duration * rate)
        half, nine_of_ten = (
            _finite(smallest_detectable(others, term, n=n, tau0=tau0, tau_min=tau_min, power=p))
            for p in (_EVEN_DETECTION, _LIKELY_DETECTION)
        )
    if value is not None:
        samples = [
            _finite(needed_samples(others, term, value, tau0=tau0, tau_min=tau_min, power=p))
            for p in (_EVEN_DETECTION, _LIKELY_DETECTION)
        ]
        half_in, most_in = (None if n is None else n * tau0 for n in samples)
    error = None
    if duration is not None and value is not None and term != "rate_ramp":
        error = relative_error(others, term, value, n=round(duration * rate), tau0=tau0, tau_min=tau_min)
    return Plan(
        channel=channel,
        quantity=quantity,
        rate_unit=rate_unit,
        term=term,
        unit=coefficient_unit(term, quantity, rate_unit),
        others={name: others[name] for name in TERMS if others.get(name) and name not in (term, "rate_ramp")},
        tau0=tau0,
        duration=duration,
        half=half,
        most=nine_of_ten,
        value=value,
        half_in=half_in,
        most_in=most_in,
        error=error,
        gauss_markov=_processes(others),
    )


def _processes(noise: Mapping[str, float]) -> tuple[GaussMarkov, ...]:
    """The Gauss-Markov process of a model, if any. Raises OptionError for parts that are not supported."""
    if not isinstance(noise, ChannelModel):
        return ()
    parts = {
        "a sinusoid": bool(noise.sinusoid),
        "a resonance": bool(noise.resonance),
        "a Matérn process": bool(noise.matern),
        "a bandwidth": noise.bandwidth is not None,
        "several Gauss-Markov processes": len(noise.gauss_markov) > 1,
    }
    if any(parts.values()):
        what = " and ".join(name for name, is_present in parts.items() if is_present)
        raise OptionError(
            f"the model has {what}, which planning does not count; leave it out with dataclasses.replace",
            option="model",
        )
    return noise.gauss_markov


def _times(noise: Mapping[str, float], tau0: float) -> tuple[float, ...]:
    """Correlation times of the Gauss-Markov processes. [samples]"""
    return tuple(process.time / tau0 for process in _processes(noise))


def _theta(noise: Mapping[str, float], tau0: float) -> NDArray[np.float64]:
    """Squared coefficients in samples, followed by the variance of a Gauss-Markov process."""
    return np.array(linear_powers(noise, tau0) + [process.sigma**2 for process in _processes(noise)])


def _parts(n: int, smallest: float, times: tuple[float, ...]) -> Components:
    if n > LONGEST_RECORD:
        raise OptionError(f"a record of {n:g} samples is too long", option="hours")
    sizes = half_octaves(max(math.ceil(smallest * (1 - 1e-9)), 1), n // LONGEST_SHARE)
    if len(sizes) < MIN_TIMES:
        raise OptionError(f"a record of {n} samples is too short to fit a model to", option="hours")
    return Components(n, sizes, correlation_time=times[0] if times else None)


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
