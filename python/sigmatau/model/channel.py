"""Noise model of one channel: coefficients of the five terms, further processes, and the bandwidth."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.model import covariance as covariances
from sigmatau.model.matern import Matern, filter_processes
from sigmatau.model.parameters import Covariance
from sigmatau.model.process_curves import process_avar, process_psd, process_size, process_text, process_values, scaled
from sigmatau.model.processes import (
    LARGEST,
    SMALLEST,
    GaussMarkov,
    LowPass,
    Resonance,
    Sinusoid,
    as_processes,
    check_coefficients,
    check_sample_interval,
    check_sampling_rate,
    real,
)
from sigmatau.model.turn_on import TurnOn
from sigmatau.noise import terms
from sigmatau.noise.terms import SLOW, TERMS, coefficient_unit, display_units
from sigmatau.results import Printed, duration_text

_SAMPLES_WITHOUT_RATE = 1000  # samples in the shortest averaging time, if no rate is known

# Terms that have an autocovariance. Only differences of the other terms are stationary.
STATIONARY = tuple(name for name in TERMS if name not in SLOW)
PROCESSES: Mapping[str, type] = {
    "gauss_markov": GaussMarkov,
    "matern": Matern,
    "resonance": Resonance,
    "sinusoid": Sinusoid,
}
"""Parts of a model other than terms: the type by field."""


@frozen(eq=False)
class ChannelModel(Mapping[str, float], Printed):
    """The noise of one channel in SI and continuous form: a mapping from term to coefficient, with further processes.

    Coefficients of 0 are omitted.

    Attributes
    ----------
    terms : mapping of str to float
        Coefficients by term, as in `sigmatau.noise.terms.TERMS`; positive, a ramp may be negative. [SI]
    gauss_markov : tuple of GaussMarkov
    matern : tuple of Matern
        Linear systems, exports and predictions use `expand_matern`.
    resonance : tuple of Resonance
    sinusoid : tuple of Sinusoid
    bandwidth : LowPass or None
        Low-pass filter in front of the sampler, which acts on the white noise.
    quantity, unit : str
        Quantity and unit of the rate: ``"angular_rate"`` in ``"rad/s"``, ``"acceleration"`` in ``"m/s^2"``, or
        ``"signal"``.
    intervals : mapping of str to (float, float)
        Confidence intervals of coefficients, if the model comes from a fit. [SI]
    limits : mapping of str to float
        Upper limits of terms that were not observed, if the model comes from a fit. They are not part of the model.
        [SI]
    covariance : Covariance
        Covariance of the coefficients and of the numbers of processes, if the model comes from a fit. [SI]
    alike_from : GaussMarkov or None
        If the model comes from a fit with a rate random walk: the process with the shortest correlation time that
        explains the record as well as the walk does. Every slower process does so too.
    alternatives : tuple of ChannelModel
        Models with other terms and Gauss-Markov processes, but the same resonances and lines, that explain the record
        equally well.
    turn_on : TurnOn or None
        Spread of the bias between power-ups, which a single record cannot show. It is not part of `avar`, `psd` and
        simulated records.
    level : float
        Probability of the intervals and limits.
    tau_min : float
        Shortest averaging time of the fit, if the model comes from a fit. At shorter times a filter or interpolation,
        which is not in the model, shapes the curve. [s]
    duration : float
        Length of the record, if the model comes from a fit; else 0. [s]
    rate : float
        Sampling rate of the record, if the model comes from a fit; else 0. [Hz]
    adequate : bool
        False if the model comes from a fit that does not describe its curve. Its coefficients then have no interval.
    highest : float or None
        Frequency up to which a fit used the spectrum; None for all, or without a fit. [Hz]

    Raises
    ------
    DataError
        For an unknown term, a coefficient that is not positive or outside 1e-100 … 1e100, no term at all, or a
        bandwidth without a random walk.

    See Also
    --------
    NoiseModel : the channels of a sensor.
    sigmatau.state_space, sigmatau.arma : the model as a linear system.

    Examples
    --------
    >>> from sigmatau import ChannelModel, GaussMarkov
    >>> model = ChannelModel(terms={"random_walk": 1e-4}, gauss_markov=(GaussMarkov(sigma=1e-5, time=100.0),))
    >>> model["random_walk"]
    0.0001
    >>> model.adev(m=[1, 100], tau0=0.01).round(7)
    array([0.001 , 0.0001])
    """

    terms: Mapping[str, float] = field(default_factory=dict)
    gauss_markov: tuple[GaussMarkov, ...] = ()
    matern: tuple[Matern, ...] = ()
    resonance: tuple[Resonance, ...] = ()
    sinusoid: tuple[Sinusoid, ...] = ()
    bandwidth: LowPass | None = None
    quantity: str = "angular_rate"
    unit: str = "rad/s"
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    limits: Mapping[str, float] = field(default_factory=dict)
    covariance: Covariance = field(default_factory=Covariance)
    alike_from: GaussMarkov | None = None
    alternatives: tuple[ChannelModel, ...] = ()
    turn_on: TurnOn | None = None
    level: float = 0.95
    tau_min: float = 0.0
    duration: float = 0.0
    rate: float = 0.0
    adequate: bool = True
    highest: float | None = None

    @property
    def has_only_limits(self) -> bool:
        """Whether the terms are upper limits, because vibration or rounding hides the noise."""
        return not self.adequate and bool(self.terms) and self.terms.items() <= self.limits.items()

    def __post_init__(self) -> None:
        nonzero = {name: value for name, value in check_coefficients("terms", self.terms).items() if value}
        for name, value in nonzero.items():
            if not SMALLEST <= abs(value) <= LARGEST:
                raise DataError(f"{name} must be from {SMALLEST:g} to {LARGEST:g} in SI, not {value!r}")
        object.__setattr__(self, "terms", nonzero)
        object.__setattr__(self, "limits", check_coefficients("limits", self.limits))
        bounds = [*self.limits.items(), *((name, end) for name, ends in self.intervals.items() for end in ends)]
        for name, value in bounds:
            if abs(value) > LARGEST:
                raise DataError(f"{name}: {value!r}, of its limit or interval, is more than {LARGEST:g} in SI")
        for field_, kind in PROCESSES.items():
            object.__setattr__(self, field_, as_processes(field_, kind, getattr(self, field_)))
        if self.bandwidth is not None and not isinstance(self.bandwidth, LowPass):
            raise DataError(f"`bandwidth` must be a LowPass, not {self.bandwidth!r}")
        if not (nonzero or any(getattr(self, kind) for kind in PROCESSES)):
            raise DataError(f"no term; terms: {', '.join((*TERMS, *PROCESSES))}")
        if self.bandwidth is not None and "random_walk" not in nonzero:
            raise DataError("a bandwidth is that of white noise, and there is no random_walk")
        if self.turn_on is not None and not isinstance(self.turn_on, TurnOn):
            raise DataError(f"`turn_on` must be a TurnOn, not {self.turn_on!r}")
        if self.alike_from is not None and "rate_random_walk" not in nonzero:
            raise DataError("`alike_from` replaces a rate random walk, and there is no rate_random_walk")

    def __getitem__(self, term: str) -> float:
        try:
            return self.terms[term]
        except KeyError:
            raise KeyError(f"no coefficient {term!r}; the model has: {', '.join(self.terms) or 'none'}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.terms)

    def __len__(self) -> int:
        return len(self.terms)

    def avar(self, *, m: ArrayLike, tau0: float) -> Floats:
        """Expected Allan variance, exact for sampled data.

        Parameters
        ----------
        m : array_like of int, shape (n_tau,)
            Cluster sizes in samples.
        tau0 : float
            Sample interval. [s]

        Returns
        -------
        ndarray, shape (n_tau,)
            [(unit of the rate)²]

        Raises
        ------
        ValueError
            For a size below 1, a tau0 that is not positive.

        References
        ----------
        Eqs. (15), (17), (19), (21) and (23) of :doi:`10.1109/TIM.2007.908635` in their sampled forms, see
        `sigmatau.noise.terms.avar`; IEEE Std 952, annex C, for Gauss-Markov processes and sinusoids.
        """
        return np.asarray(sum(self.avar_of_parts(m=m, tau0=tau0).values()))

    def avar_of_parts(self, *, m: ArrayLike, tau0: float) -> dict[str, Floats]:
        """Expected Allan variance of each part of the model.

        Parameters
        ----------
        m, tau0
            As in `ChannelModel.avar`.

        Returns
        -------
        dict of str to ndarray, shape (n_tau,)
            By term, and by ``"gauss_markov"``, ``"matern"``, ``"resonance"``, ``"sinusoid"``. [(unit of the rate)²]
        """
        sizes = np.atleast_1d(np.asarray(m))
        parts: dict[str, Floats] = {}
        for term, value in self.terms.items():
            if term == "random_walk" and self.bandwidth is not None:
                terms.avar(term, value, m=sizes, tau0=tau0)  # checks the arguments
                shape, before = f"butterworth{self.bandwidth.order}", self.bandwidth.before_sampling(value)
                parts[term] = kernels.band_limited_avar(before, shape, self.bandwidth.corner, sizes, tau0)
            else:
                parts[term] = terms.avar(term, value, m=sizes, tau0=tau0)
        if not parts:
            terms.avar("random_walk", 1.0, m=sizes, tau0=tau0)  # checks the arguments
        for kind in PROCESSES:
            for process in getattr(self, kind):
                parts[kind] = parts.get(kind, 0.0) + process_avar(process, sizes, tau0)
        return parts

    def adev(self, tau: ArrayLike | None = None, *, m: ArrayLike | None = None, tau0: float | None = None) -> Floats:
        """Expected Allan deviation, the root of `avar`.

        Parameters
        ----------
        tau : array_like, shape (n_tau,), optional
            Averaging times, rounded to whole samples at the sampling rate of a model from a fit. [s]
        m : array_like of int, shape (n_tau,), optional
            Cluster sizes in samples, in place of `tau`.
        tau0 : float, optional
            Sample interval, needed with `m`. [s]

        Returns
        -------
        ndarray, shape (n_tau,)
            [unit of the rate]

        Raises
        ------
        OptionError
            For neither `tau` nor `m` with `tau0`, for both, or for times that are not positive.
        """
        if tau is None:
            if m is None or tau0 is None:
                raise OptionError("give {option} in s, or `m` and `tau0`", option="tau")
            return np.sqrt(self.avar(m=m, tau0=tau0))
        times = np.atleast_1d(np.asarray(tau, dtype=np.float64))
        if m is not None or tau0 is not None or not (np.isfinite(times).all() and times.min(initial=np.inf) > 0):
            raise OptionError("{option} must be positive times in s, without `m` and `tau0`", option="tau")
        step = 1 / self.rate if self.rate else float(times.min()) / _SAMPLES_WITHOUT_RATE
        return np.sqrt(self.avar(m=np.maximum(np.round(times / step), 1).astype(np.int64), tau0=step))

    def psd(self, f: ArrayLike, *, tau0: float | None = None) -> Floats:
        """Two-sided power spectral density of the noise. Sinusoids and the ramp have no density and are omitted.

        Parameters
        ----------
        f : array_like, shape (n_f,)
            Frequencies, positive. [Hz]
        tau0 : float, optional
            Sample interval. The result is then the exact spectrum of the samples, with aliasing, below 1/(2·tau0).
            Required for quantization, whose density depends on it. Default: the continuous forms of the paper. [s]

        Returns
        -------
        ndarray, shape (n_f,)
            [(unit of the rate)²/Hz, two-sided]

        Raises
        ------
        OptionError
            For a model with quantization without `tau0`; for frequencies that are not positive, or with `tau0` above
            1/(2·tau0).

        References
        ----------
        Eqs. (14), (16), (18) and (20) of :doi:`10.1109/TIM.2007.908635`.
        """
        frequency = np.atleast_1d(np.asarray(f, dtype=np.float64))
        if frequency.size and not (np.isfinite(frequency).all() and frequency.min() > 0):
            raise OptionError("{option} must be positive frequencies", option="f")
        if tau0 is None and "quantization" in self.terms:
            raise OptionError("the density of quantization noise needs the sample interval {option}", option="tau0")
        if tau0 is not None:
            nyquist = 0.5 / check_sample_interval("tau0", tau0)
            if frequency.size and frequency.max() > nyquist * (1 + 1e-9):
                raise OptionError(
                    f"{{option}} must be at most 1/(2·tau0), {nyquist:g} Hz, not {frequency.max():g}: sampling"
                    " folds higher frequencies back",
                    option="f",
                )
        total = np.zeros(frequency.shape)
        for term, value in self.terms.items():
            if term == "random_walk" and self.bandwidth is not None:
                order, corner = self.bandwidth.order, self.bandwidth.corner
                before = self.bandwidth.before_sampling(value)
                # Far above the corner the sum over the poles is rounding error of either sign, 1e-16 of N².
                total += np.maximum(kernels.band_limited_psd(before, order, corner, frequency, tau0), 0.0)
            elif term != "rate_ramp":
                total += terms.psd(term, value, frequency, tau0=tau0)
        for kind in PROCESSES:
            for process in getattr(self, kind):
                total += process_psd(process, frequency, tau0)
        return total

    def autocovariance(self, lags: ArrayLike, *, tau0: float) -> Floats:
        """Autocovariance of the samples, E[y(k)·y(k + l)]; its Fourier transform is the density, eq. (1).

        Parameters
        ----------
        lags : array_like of int, any shape
            Lags in samples; of either sign.
        tau0 : float
            Sample interval. [s]

        Returns
        -------
        ndarray, shape of `lags`
            [(unit of the rate)²]

        Raises
        ------
        DataError
            For a model with bias instability, a rate random walk or a ramp: their rate is not stationary, and only its
            differences have a covariance, see `phase_autocovariance`.
        OptionError
            For lags that are not whole, a tau0 that is not positive.

        References
        ----------
        Eq. (1) of :doi:`10.1109/TIM.2007.908635`: S(f) = τ₀·Σ r(l)·exp(−j2πflτ₀), `psd` with its `tau0`.
        """
        moving = [term for term in self.terms if term not in STATIONARY]
        if moving:
            raise DataError(
                f"{' and '.join(moving)} {'has' if len(moving) == 1 else 'have'} no autocovariance: the rate is not"
                " stationary, only its differences are; use phase_autocovariance, or omit them"
            )
        shape, size, step = np.shape(lags), covariances.whole_lags(lags), check_sample_interval("tau0", tau0)
        total = np.zeros(size.shape)
        for term, value in self.terms.items():
            if term != "random_walk" or self.bandwidth is None:
                total += covariances.rate_autocovariance(term, value, size, step)
        for part in self.damped(step):
            total += part.autocovariance(size)
        for line in self.sinusoid:
            turns = np.fmod(size * math.fmod(line.frequency * step, 1.0), 1.0)
            total += line.amplitude**2 / 2 * np.cos(2 * math.pi * turns)
        return total.reshape(shape or (1,))

    def phase_autocovariance(self, l: ArrayLike, *, tau0: float) -> Floats:  # noqa: E741  the lag of the formulas
        """Generalised autocovariance s(l) of the integral of the rate, for all terms.

        Its fourth differences equal those of the covariance of the angle (velocity). Only these enter an Allan variance
        and the covariance of Allan variances: AVAR(n) = [6·s(0) − 8·s(n) + 2·s(2n)]/(2T²).

        Parameters
        ----------
        l : array_like of int, any shape
            Lags in samples; of either sign.
        tau0 : float
            Sample interval. [s]

        Returns
        -------
        ndarray, shape of `l`
            [(unit of the rate · s)²]

        Raises
        ------
        OptionError
            For lags that are not whole, a tau0 that is not positive.

        Notes
        -----
        A stationary rate has s(l) = −Var(x(l) − x(0))/2; a ramp counts as one of random slope with the mean square R².
        The sum of three terms above loses digits where a process hardly changes within n samples: the relative error of
        the Allan variance is about 1e-15·T/(n·τ₀) for a Gauss-Markov process, and 1e-15/(f·n·τ₀)² for a filter with the
        corner f.
        """
        shape, size, step = np.shape(l), covariances.whole_lags(l), check_sample_interval("tau0", tau0)
        total = np.zeros(size.shape)
        for term, value in self.terms.items():
            if term != "random_walk" or self.bandwidth is None:
                total += covariances.phase_autocovariance_of_term(term, value, size, step)
        for part in self.damped(step):
            total += part.phase(size, step)
        for line in self.sinusoid:
            total += covariances.phase_of_sinusoid(line.amplitude, line.frequency, size, step)
        return total.reshape(shape or (1,))

    def damped(self, tau0: float) -> list[covariances.Damped]:
        """The parts whose autocovariance is a sum of damped exponentials.

        Parameters
        ----------
        tau0 : float
            Sample interval. [s]

        Returns
        -------
        list of Damped
        """
        summed = (gm for process in self.matern for gm in process.gauss_markov(tau0))
        parts = [covariances.gauss_markov(process, tau0) for process in (*self.gauss_markov, *summed)]
        parts += [covariances.resonance(resonance, tau0) for resonance in self.resonance]
        if self.bandwidth is not None:
            n = self.bandwidth.before_sampling(self.terms["random_walk"])
            parts.append(covariances.band_limited(n, self.bandwidth, tau0))
        return parts

    def parts(self) -> dict[str, ChannelModel]:
        """Each part of the noise as a separate model; keys are terms and `PROCESSES`."""
        parts = {
            term: replace(
                self._bare(), terms={term: value}, bandwidth=self.bandwidth if term == "random_walk" else None
            )
            for term, value in self.terms.items()
        }
        for kind in PROCESSES:
            if processes := getattr(self, kind):
                changed: dict[str, Any] = {kind: processes}
                parts[kind] = replace(self._bare(), terms={}, **changed)
        return parts

    def scaled(self, factor: float) -> ChannelModel:
        """The model with all coefficients and amplitudes multiplied by `factor`, without intervals.

        Parameters
        ----------
        factor : float
            Factor on all coefficients and amplitudes.

        Returns
        -------
        ChannelModel

        Raises
        ------
        DataError
            For a factor that is not positive.
        """
        if not (math.isfinite(real(factor)) and factor > 0):
            raise DataError(f"a factor must be a positive number, not {factor!r}")
        processes: dict[str, Any] = {
            kind: tuple(scaled(process, factor) for process in getattr(self, kind)) for kind in PROCESSES
        }
        return ChannelModel(
            terms={term: factor * value for term, value in self.terms.items()},
            **processes,
            bandwidth=self.bandwidth,
            quantity=self.quantity,
            unit=self.unit,
            alike_from=None if self.alike_from is None else scaled(self.alike_from, factor),
            alternatives=tuple(alternative.scaled(factor) for alternative in self.alternatives),
            turn_on=None if self.turn_on is None else self.turn_on.scaled(factor),
            tau_min=self.tau_min,
            rate=self.rate,
            adequate=self.adequate,
        )

    def expand_matern(self, *, rate: float) -> ChannelModel:
        """The model with Gauss-Markov processes in place of Matérn processes, as linear systems have it.

        About three processes per decade of time, from a tenth of the sample interval to the correlation time. What is faster
        becomes random walk, or one more process in front of a bandwidth. The densities differ by at most 0.01 %.

        Parameters
        ----------
        rate : float
            Sampling rate of the samples or of the filter. [Hz]

        Returns
        -------
        ChannelModel

        Raises
        ------
        OptionError
            For a rate that is not positive.

        Examples
        --------
        >>> from sigmatau import ChannelModel, Matern, state_space
        >>> model = ChannelModel(matern=(Matern(sigma=1e-5, time=100.0, smoothness=0.25),)).expand_matern(rate=10.0)
        >>> len(state_space(model, dt=0.1).states)
        14
        """
        tau0 = 1 / check_sampling_rate(rate)
        if not self.matern:
            return self
        processes, white = filter_processes(self.matern, tau0)
        terms_ = dict(self.terms)
        if self.bandwidth is None:
            terms_["random_walk"] = math.hypot(terms_.get("random_walk", 0.0), math.sqrt(white * tau0))
        elif white:
            processes.append(GaussMarkov(sigma=math.sqrt(white), time=tau0 / 10))
        return replace(self, terms=terms_, gauss_markov=(*self.gauss_markov, *processes), matern=())

    def _bare(self) -> ChannelModel:
        """A channel with unit white noise, as a base for `replace`."""
        return ChannelModel(terms={"random_walk": 1.0}, quantity=self.quantity, unit=self.unit)

    def unit_of(self, term: str) -> str:
        """SI unit of a coefficient.

        Parameters
        ----------
        term : str
            A key of `sigmatau.noise.terms.TERMS`.

        Returns
        -------
        str
        """
        return coefficient_unit(term, self.quantity, self.unit)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, each with its unit."""
        content: dict[str, Any] = {
            "quantity": self.quantity,
            "unit": self.unit,
            "terms": {term: {"value": value, "unit": self.unit_of(term)} for term, value in self.terms.items()},
        }
        for term, (low, high) in self.intervals.items():
            content["terms"][term] |= {"low": low, "high": high, "level": self.level}
        if self.limits:
            content["limits"] = {t: {"upper_limit": v, "unit": self.unit_of(t)} for t, v in self.limits.items()}
        fit_values = (("tau_min_s", self.tau_min), ("duration_s", self.duration), ("sample_rate_hz", self.rate))
        content |= {key: value for key, value in fit_values if value}
        content |= {} if self.adequate else {"adequate": False}
        for kind in PROCESSES:
            if processes := getattr(self, kind):
                content[kind] = [process_values(process) for process in processes]
        if self.bandwidth is not None:
            content["bandwidth"] = {"order": self.bandwidth.order, "corner_hz": self.bandwidth.corner}
            if self.bandwidth.rate is not None:
                content["bandwidth"]["rate_hz"] = self.bandwidth.rate
        if self.alike_from is not None:
            content["alike_from"] = process_values(self.alike_from)
        if self.alternatives:
            content["alternatives"] = [
                {key: alternative.to_dict()[key] for key in ("terms", "gauss_markov") if getattr(alternative, key)}
                for alternative in self.alternatives
            ]
        if self.turn_on is not None:
            content["turn_on"] = self.turn_on.to_dict()
        return content

    def __repr__(self) -> str:
        rows = []
        for term, value in self.terms.items():
            text, factor = display_units(term, self.quantity, self.unit, [value])[-1]
            rows.append(f"{TERMS[term].label(self.quantity)} {value / factor:.6g} {text}")
        processes = [process for kind in PROCESSES for process in getattr(self, kind)]
        sizes = [process_size(process) for process in processes]
        text, factor = display_units("bias_instability", self.quantity, self.unit, sizes)[-1]
        rows += [process_text(process, text, factor) for process in processes]
        if self.bandwidth is not None:
            rows.append(f"white noise up to {self.bandwidth.corner:.4g} Hz, order {self.bandwidth.order}")
        if self.alike_from is not None:
            rows.append(alike_text(self.alike_from.time))
        rows += [f"or {alternative!r}" for alternative in self.alternatives]
        if self.turn_on is not None:
            rows.append(f"turn-on bias {self.turn_on.text(self.quantity, self.unit)}")
        if not self.adequate:
            rows.append("no model fits this axis: no intervals")
        return ", ".join(rows)


def alike_text(time: float) -> str:
    """A line about the alternative to a rate random walk."""
    return f"a Gauss-Markov process of {duration_text(time)} or more explains the rate random walk as well"
