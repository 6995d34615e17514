"""Values that a fit states about the noise of one channel, and the curve of its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native.arguments import whole_sizes
from sigmatau._native.likelihood import FittedModel
from sigmatau.findings.reasons import Reason
from sigmatau.fitting.adjustment import Adjustment, Verdict
from sigmatau.fitting.fitted_matern import FittedMatern
from sigmatau.fitting.fitted_values import (
    MIN_P_VALUE,
    FittedGaussMarkov,
    FittedResonance,
    FittedSinusoid,
    FittedTerm,
    FittedWarmUp,
    Interval,
    SecondModel,
)
from sigmatau.fitting.response import FittedFilter
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Covariance

Trust = Literal["good", "partial", "poor"]
QUANTIFIED: tuple[Verdict, ...] = ("adequate", "adequate_with", "widened")
"""Verdicts of fits whose coefficients have intervals."""


@frozen(eq=False)
class FittedNoise:
    """The values of a `NoiseFit`, with the same meaning, and the curve of the model."""

    channel: str
    quantity: str
    rate_unit: str
    n: int
    tau0: float
    terms: Mapping[str, FittedTerm]
    gauss_markov: tuple[FittedGaussMarkov, ...] = ()
    sinusoid: tuple[FittedSinusoid, ...] = ()
    resonance: tuple[FittedResonance, ...] = ()
    response: FittedFilter | None = None
    warm_up: FittedWarmUp | None = None
    regressors: Mapping[str, Interval] = field(default_factory=dict)
    highest: float | None = None
    alike_from: float | None = None
    alike_sigma: float | None = None
    matern: FittedMatern | None = None
    second: tuple[SecondModel, ...] = ()
    discrepancy: tuple[tuple[float, float], ...] = ()
    model: Mapping[str, float]
    verdict: Verdict
    reasons: tuple[Reason, ...] = ()
    unclear: tuple[str, ...] = ()
    tau_min: float | None = None
    tau_max: float | None = None
    p_value: float | None = None
    covariance: Covariance = field(default_factory=Covariance)
    level: float = 0.95
    method: str = "gls"
    runs: tuple[float, ...] = ()
    adjustments: tuple[Adjustment, ...] = ()
    trust: Trust | None = None

    @property
    def observed(self) -> dict[str, float]:
        """Coefficients of the observed terms, by name; empty if the model is not adequate. [SI]"""
        return {name: term.value for name, term in self.terms.items() if term.observed and term.value is not None}

    def avar(self, *, m: ArrayLike) -> NDArray[np.float64]:
        """Expected Allan variance of the fitted model.

        Parameters
        ----------
        m : array_like of int, shape (n_tau,)
            Cluster sizes in samples of this record.

        Returns
        -------
        ndarray, shape (n_tau,)
            [(rate unit)²]
        """
        return self._curve().avar(whole_sizes(m))

    def filtered_psd(self, f: NDArray[np.float64]) -> NDArray[np.float64]:
        """Two-sided density of the noise that the filter acts on, before the filter.

        Parameters
        ----------
        f : ndarray, shape (n_f,)
            Frequencies. [Hz]

        Returns
        -------
        ndarray, shape (n_f,)
            [(rate unit)²/Hz]
        """
        return self._curve().psd_before_filter(np.ascontiguousarray(f, dtype=np.float64))

    def psd(self, f: ArrayLike) -> NDArray[np.float64]:
        """Two-sided density of the fitted model after its filter.

        Lines, the ramp and the warm-up have no density and are omitted.

        Parameters
        ----------
        f : array_like, shape (n_f,)
            Frequencies up to half the rate. [Hz]

        Returns
        -------
        ndarray, shape (n_f,)
            [(rate unit)²/Hz]
        """
        return self._curve().psd(np.atleast_1d(np.ascontiguousarray(f, dtype=np.float64)))

    def _curve(self) -> FittedModel:
        """The model as a curve."""
        response, warm_up = self.response, self.warm_up
        return FittedModel(
            self.tau0,
            self.n,
            list(self.model.items()),
            gauss_markov=[(process.sigma.value, process.time.value) for process in self.gauss_markov],
            resonance=[(band.sigma.value, band.frequency.value, band.width.value) for band in self.resonance],
            sinusoid=[(line.amplitude.value, line.frequency.value) for line in self.sinusoid],
            filter=None if response is None else response.native(),
            highest=self.highest,
            warm_up=None if warm_up is None else (warm_up.amplitude.value, warm_up.time),
        )

    @property
    def has_limits(self) -> bool:
        """Whether terms that were not observed have upper limits: they do if the fit is quantified or disturbed."""
        return self.quantified or self.verdict == "disturbed"

    @property
    def quantified(self) -> bool:
        """Whether the coefficients have intervals."""
        return self.verdict in QUANTIFIED

    @property
    def is_misfit(self) -> bool:
        """Whether p < 1e-6: at most the random walk has an interval, and the other terms are unknown."""
        return self.quantified and self.p_value is not None and self.p_value < MIN_P_VALUE

    def degrees_of_freedom(self, *, m: ArrayLike) -> NDArray[np.float64] | None:
        """Degrees of freedom of overlapped Allan variances for the fitted model.

        Exact for up to 100 sizes; for more, interpolated between 100 sizes.

        Parameters
        ----------
        m : array_like of int, shape (n_tau,)
            Cluster sizes in samples of this record.

        Returns
        -------
        ndarray or None, shape (n_tau,)
            Degrees of freedom; None for a model without noise.
        """
        return self._curve().degrees_of_freedom(whole_sizes(m))

    @property
    def line_ranges(self) -> Mapping[str, tuple[float, float] | None]:
        """Averaging times at which each observed term is at least half of the variance, so that its line can be read off;
        None if other noise hides it everywhere. [s]
        """
        return self._ranges(self.observed)

    @property
    def model_ranges(self) -> Mapping[str, tuple[float, float] | None]:
        """Averaging times of `line_ranges`, and of terms of the model that are not observed because another model
        explains the record equally well. [s]
        """
        spans = self._ranges(self.model)
        return {name: span for name, span in spans.items() if span is not None or self.terms[name].observed}

    def _ranges(self, terms: Mapping[str, float]) -> dict[str, tuple[float, float] | None]:
        """Averaging times at which each term is at least half of the variance; None if there are none."""
        if not terms or not self.quantified or self.tau_min is None:
            return {}
        return dict(zip(terms, self._curve().line_ranges(list(terms.items()), self.tau_min), strict=True))

    @property
    def is_fitted(self) -> bool:
        """Whether there is a fit. If not, `reason` states why."""
        return self.verdict != "too_short" and self.tau_min is not None and self.tau_max is not None
