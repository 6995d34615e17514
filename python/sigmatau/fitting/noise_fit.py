"""Result of a fit of one channel: coefficients with intervals, upper limits of terms not observed, and a verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.findings.fit import added_parts_text, filter_text, misfit_text, verdict_text
from sigmatau.findings.reasons import MAX_LINES, CoarseCounts, reasons_text
from sigmatau.fitting.fitted_noise import FittedNoise
from sigmatau.fitting.fitted_values import FittedTerm, Interval, SecondModel
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import (
    TablesByChannel,
    Tabular,
    duration_text,
    html_table,
    plain,
    seconds,
)

if TYPE_CHECKING:
    from sigmatau.model.channel import ChannelModel

_TERM_COLUMNS = ("term", "observed", "value", "low", "high", "upper_limit", "p_value", "unit")
_MAX_LINES = 3  # number of lines that are printed individually


@frozen(eq=False)
class NoiseFit(FittedNoise, Mapping[str, FittedTerm], Tabular):
    """Fit of one channel: a mapping from term to `FittedTerm`, empty if the record is too short.

    Attributes
    ----------
    channel, quantity, rate_unit : str
    n : int
        Samples in the record.
    tau0 : float
        Sample interval. [s]
    terms : mapping of str to FittedTerm
    gauss_markov : tuple of GaussMarkov
    sinusoid : tuple of Sinusoid
        Lines of the spectrum. A likelihood fit leaves them out; their frequencies are then the excluded bands.
    resonance : tuple of Resonance
    response : FittedFilter or None
        Filter that acts on all noise except quantization.
    warm_up : WarmUp or None
    regressors : mapping of str to Interval
        Coefficients of the regressors of the mean, by name.
    highest : float or None
        Frequency from which the spectrum was left out, because no model describes it there. [Hz]
    alike_from : float or None
        If a rate random walk was observed: a Gauss-Markov process with this or a longer correlation time explains the
        record equally well. [s]
    alike_sigma : float or None
        Standard deviation of the process with this correlation time. [rate unit]
    matern : FittedMatern or None
        A model with one Matérn process in place of all slow noise, if `fit_channel` was asked for it. It is not part of the
        other values, nor of `to_model`.
    second : tuple of SecondModel
        Other models that explain the record equally well, with processes in place of terms or terms in place of
        processes. The intervals and limits include them.
    discrepancy : tuple of (float, float)
        Discrepancy of the model that the intervals allow for: frequency in Hz, and standard deviation of the logarithm
        of the density.
    model : mapping of str to float
        The coefficients that together describe the curve: the observed ones, and those of `unclear`. [SI]
    verdict : {"adequate", "adequate_with", "widened", "disturbed", "descriptive", "too_short"}
        "adequate": the terms describe the record. "adequate_with": the terms together with filters, lines or processes
        describe it. "widened": the model does not fit exactly, and the intervals are wider. "disturbed": vibration has
        most of the power of the record, or the rounding of increments hides the noise, and all terms are upper limits.
        "descriptive": a least-squares fit that does not describe the curve from tau_min to tau_max; its values have no
        intervals.
    reasons : tuple of Reason
        Why short averaging times are left out, why the model is not adequate, or why there is no fit; see
        `sigmatau.findings.reasons`. `reason` has them in words.
    unclear : tuple of str
        Terms that are not significant together, although at least one of them is present, and terms whose interval
        contains 0 after an adjustment.
    tau_min, tau_max : float or None
        Range of averaging times used; for a likelihood fit, the range in which the resulting noise model describes the
        curve. [s]
    p_value : float or None
        P-value of the goodness of fit.
    covariance : Covariance
        Covariance of the observed coefficients, of those in `unclear`, and of the numbers of processes. [SI]
    level : float
        Confidence level of the intervals and limits.
    method : str
    runs : tuple of float
        Lengths of the runs of a joint fit, in which `n` is that of the longest run; otherwise empty. [s]
    adjustments : tuple of Adjustment
        Changes of the intervals by checks of the record, in the order in which they were applied; see ``docs/numbers.md``.
    trust : {"good", "partial", "poor"} or None
        How far to trust the coefficients of a channel of an analysis. "poor": the fit has no intervals or p < 1e-6, or a
        finding states that a coefficient is wrong by half or more. "partial": the intervals are wider, or there is a
        warning about the channel. None for a fit alone, because its record was not checked.

    See Also
    --------
    analyze, fit, fit_channel : make it.
    NoiseFit.to_model : the model for simulations and filters.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> found = st.fit_channel(st.simulate(model, duration=600, rate=10, rng=1), "gyro_x")
    >>> walk = found["random_walk"]
    >>> walk.low < 1e-4 < walk.high, walk.unit
    (True, 'rad/sqrt(s)')
    >>> found["bias_instability"].observed, found["bias_instability"].upper_limit is not None
    (False, True)
    """

    _dimensions = ("channel", "term")

    def __getitem__(self, term: str) -> FittedTerm:
        try:
            return self.terms[term]
        except KeyError:
            raise KeyError(f"no coefficient {term!r}; fitted: {', '.join(self.terms) or 'none'}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.terms)

    def __len__(self) -> int:
        return len(self.terms)

    @property
    def reason(self) -> str:
        """The reasons in words; empty if there is none."""
        return reasons_text(self.reasons)

    def to_model(self) -> ChannelModel:
        """The model for simulations, filters and exports, with intervals, limits and covariance.

        Returns
        -------
        ChannelModel

        Raises
        ------
        DataError
            If the fit has no model.
        """
        from sigmatau.fitting.to_model import to_model

        return to_model(self)

    def texts(self, term: str) -> list[tuple[str, str, str]]:
        """Value, interval and unit in each of the field's units; limits as ``("below 21", "", "deg/h/√h")``.

        Parameters
        ----------
        term : str
            A key of `sigmatau.noise.terms.TERMS`.

        Returns
        -------
        list of (str, str, str)
        """
        t = self[term]
        result = []
        for text, factor in display_units(term, self.quantity, self.rate_unit, (t.value, t.upper_limit)):
            if t.value is None:
                limit = "" if t.upper_limit is None else limit_text(t.upper_limit / factor)
                result.append((limit, "", text))
            else:
                result.append((*round_to_error(t.value, t.low, t.high, size=factor).cells, text))
        return result

    def why_not(self, term: str) -> str:
        """Reason why a term was not observed.

        Parameters
        ----------
        term : str
            A key of `sigmatau.noise.terms.TERMS`.

        Returns
        -------
        str
        """
        t = self[term]
        if self.verdict == "disturbed":
            return f"hidden by the {'rounding' if self._is_coarse else 'vibration'}"
        if self.is_misfit:
            return "unknown: the model does not fit"
        if t.p_value is None:
            hidden = "the filter hides the short times" if self.response is not None else "the short times"
            return f"unknown: {hidden} that would show it{'' if self.response is not None else ' are left out'}"
        if t.p_value < 1 - t.level:
            return "indistinguishable from a rate ramp"
        if (replacement := self._replacement(term)) is not None:
            return f"a {_replacing(replacement)} explains the record as well"
        if self.runs:
            return f"not seen in {duration_text(sum(self.runs))} together"
        return f"not seen in {duration_text(self.n * self.tau0)}"

    def _replacement(self, term: str) -> SecondModel | None:
        """First other model that replaces this term by another part."""
        alternatives = (second for second in self.second if term in self.model and term not in second.terms)
        if term == "bias_instability":  # the term is in the model with another exponent
            alternatives = (second for second in alternatives if second.exponent is None)
        return next((second for second in alternatives if second.gauss_markov or second.warm_up is not None), None)

    def headline(self, *, method: bool = True) -> str:
        """Method, averaging times and p-value in one line.

        Parameters
        ----------
        method : bool
            Whether the line begins with the method; otherwise it begins with the verdict.

        Returns
        -------
        str
        """
        if self.tau_min is None or self.tau_max is None or not self.is_fitted:
            return f"no fit: {self.reason}"
        if self.verdict == "descriptive":
            return verdict_text(self.verdict)
        if self.verdict == "disturbed":
            return (
                "hidden by the rounding: upper limits only"
                if self._is_coarse
                else verdict_text("disturbed", self.parts_text)
            )
        if self.method == "likelihood":
            return f"{self.verdict_words}, p = {self.p_value:.2g}"
        times = f"τ from {seconds(self.tau_min)} s to {seconds(self.tau_max)} s"
        how = "generalised least squares" if method else verdict_text(self.verdict)
        return f"{how}, {times}, p = {self.p_value:.2g}"

    @property
    def _is_coarse(self) -> bool:
        """Whether the rounding of increments hides all terms."""
        return any(isinstance(reason, CoarseCounts) and reason.hidden for reason in self.reasons)

    @property
    def verdict_words(self) -> str:
        """The verdict with the parts of the model in words."""
        return misfit_text(walk=bool(self.observed)) if self.is_misfit else verdict_text(self.verdict, self.parts_text)

    @property
    def parts_text(self) -> str:
        """The filter, lines, processes and warm-up of the model in words; empty if there are none."""
        return added_parts_text(
            response=self.response is not None,
            lines=len(self.sinusoid),
            processes=len(self.gauss_markov),
            resonances=len(self.resonance),
            warm_up=self.warm_up is not None,
        )

    def notes(self) -> list[str]:
        """Gauss-Markov processes and sinusoids, and terms that the record cannot distinguish, in words."""
        sizes = [process.sigma.value for process in self.gauss_markov]
        sizes += [peak.sigma.value for peak in self.resonance]
        sizes += [line.amplitude.value for line in self.sinusoid]
        sizes += [deviation for second in self.second for deviation, _ in second.gauss_markov]
        sizes += [] if self.warm_up is None else [self.warm_up.amplitude.value]
        unit, factor = display_units("bias_instability", self.quantity, self.rate_unit, sizes)[-1]
        texts = []
        for process in self.gauss_markov:
            sigma = _interval_text(process.sigma, factor, unit)
            texts.append(f"Gauss-Markov process of {sigma}, correlation time {_interval_text(process.time, 1.0, 's')}")
        if self.matern is not None:
            sizes = [self.matern.sigma.value]
            symbol, size = display_units("bias_instability", self.quantity, self.rate_unit, sizes)[-1]
            texts.append(self.matern.text(size, symbol))
        for resonance in self.resonance:
            sigma, frequency = (
                _interval_text(resonance.sigma, factor, unit),
                _interval_text(resonance.frequency, 1.0, "Hz"),
            )
            texts.append(
                f"resonance of {sigma} at {frequency}, half width {_interval_text(resonance.width, 1.0, 'Hz')}"
            )
        for line in self.sinusoid[:_MAX_LINES]:
            amplitude = _interval_text(line.amplitude, factor, unit)
            texts.append(f"line of amplitude {amplitude} at {_interval_text(line.frequency, 1.0, 'Hz')}")
        if len(self.sinusoid) > _MAX_LINES:
            count = f"{len(self.sinusoid) - _MAX_LINES} weaker lines"
            texts.append(f"at least {count}" if len(self.sinusoid) >= MAX_LINES else count)
        if self.response is not None and self.response.corner is not None:
            corner = Interval(value=self.response.corner, low=self.response.low, high=self.response.high, unit="Hz")
            texts.append(
                f"{filter_text(self.response.shape, self.response.order)} at {_interval_text(corner, 1.0, 'Hz')}"
            )
        if self.warm_up is not None:
            amplitude = _interval_text(self.warm_up.amplitude, factor, unit)
            texts.append(f"warm-up of {amplitude}, time constant about {duration_text(self.warm_up.time)}")
        if self.alike_from is not None:
            texts.append(
                f"a Gauss-Markov process of {duration_text(self.alike_from)} or more explains the walk as well"
            )
        for second in self.second:
            replaced = [name for name in self.unclear if self._replacement(name) is second]
            if replaced:
                labels = " and ".join(TERMS[name].label(self.quantity) for name in replaced)
                explained_by = _replacing(second)
                if second.warm_up is not None:
                    explained_by += f", time constant about {duration_text(second.warm_up)}"
                elif second.exponent is None:
                    explained_by += " of " + " and ".join(
                        f"{two_digits(deviation / factor)} {unit}, correlation time {duration_text(time)}"
                        for deviation, time in second.gauss_markov
                    )
                texts.append(f"{labels}, or a {explained_by}")
        changes = (change for adjustment in self.adjustments for change in adjustment.changes)
        # Findings explain terms that an adjustment hides.
        hidden = {change.parameter.part for change in changes if change.before.upper_limit is None}
        unclear = [name for name in self.unclear if self._replacement(name) is None and name not in hidden]
        if len(unclear) == 1:
            label = TERMS[unclear[0]].label(self.quantity)
            texts.append(f"{label}: not significant, but the model does not fit without it")
        elif unclear:
            either = " or ".join(TERMS[name].label(self.quantity) for name in unclear)
            texts.append(f"{either}: at least one is present, the record does not show which")
        return texts

    def columns(self) -> dict[str, list[Any]]:
        """One row per term, see `Tabular.columns`."""
        every = list(self.terms.values())
        rows: dict[str, list[Any]] = {name: [getattr(term, name) for term in every] for name in _TERM_COLUMNS}
        same = len(every)
        return {"channel": [self.channel] * same, **rows, "verdict": [self.verdict] * same}

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI without NaN: the ``fit`` of the JSON form."""
        ranges = self.line_ranges
        terms = {
            **{name: self._term_to_dict(name, ranges) for name in self.terms},
            "gauss_markov": self.gauss_markov,
            "sinusoid": self.sinusoid,
        }
        fields = "method verdict reason tau_min_s=tau_min tau_max_s=tau_max p_value model unclear"
        if self.method == "likelihood":
            terms["resonance"] = self.resonance
            fields += " filter=response warm_up regressors highest_hz=highest"
            fields += " alike_from_s=alike_from alike_sigma second discrepancy"
        seldom: dict[str, Any] = {
            "matern": self.matern,
            "runs_s": self.runs,
            "adjustments": self.adjustments,
            "reasons": self.reasons,
        }
        seldom = {key: value for key, value in seldom.items() if value}
        return plain(self, fields, terms=terms, covariance=self.covariance, **seldom)

    def _term_to_dict(self, name: str, ranges: Mapping[str, tuple[float, float] | None]) -> dict[str, Any]:
        term = self.terms[name]
        extra: dict[str, Any] = {"reason": self.why_not(name)} if term.observed is False else {}
        if name in ranges:
            span = ranges[name]
            extra["tau_s"] = None if span is None else list(span)
        return {**term.to_dict(), **extra}

    def _repr_html_(self) -> str:
        from html import escape

        rows = [(TERMS[name].label(self.quantity), *self.texts(name)[-1]) for name in self.terms]
        table = html_table([(self.channel, "value", f"{100 * self.level:g} % interval", "unit"), *rows])
        notes = "".join(f"<li>{escape(text)}</li>" for text in self.notes())
        return f"{table}<p>{escape(self.headline())}</p><ul>{notes}</ul>"

    def __repr__(self) -> str:
        rows = []
        for name, term in self.terms.items():
            label = TERMS[name].label(self.quantity)
            value, interval, unit = self.texts(name)[0]
            if term.value is not None:
                rows.append((label, value, interval, unit))
            elif self.has_limits:
                limit = f"{value} {unit}: " if value else ""
                rows.append((label, limit + self.why_not(name), "", ""))
        widths = [max((len(row[k]) for row in rows if row[3] or k == 0), default=0) for k in range(3)]
        lines = [f"{self.channel}   {self.headline()}"]
        for label, value, interval, unit in rows:
            if unit:
                value, interval = value.ljust(widths[1]), interval.ljust(widths[2])
            lines.append(f"  {label.ljust(widths[0])}   {'  '.join(c for c in (value, interval, unit) if c)}".rstrip())
        if self.reason and self.verdict != "too_short":
            lines.append(f"  {self.reason}")
        return "\n".join([*lines, *(f"  {text}" for text in self.notes())])


class Fits(TablesByChannel[NoiseFit]):
    """Fits by channel: an immutable mapping in the record's order."""

    __slots__ = ()
    _dimensions = ("channel", "term")

    def columns(self) -> dict[str, list[Any]]:
        """The rows of all channels, see `Tabular.columns`; without channels, the same columns without rows."""
        return super().columns() or {name: [] for name in ("channel", *_TERM_COLUMNS, "verdict")}


def _interval_text(interval: Interval, factor: float, unit: str) -> str:
    return round_to_error(interval.value, interval.low, interval.high, size=factor).with_unit(unit)


def _replacing(second: SecondModel) -> str:
    """The parts of another model that replace a term, in words."""
    if second.exponent is not None:
        return f"bias instability with the density f^-{second.exponent:.2f}"
    return "Gauss-Markov process" if second.warm_up is None else "warm-up"
