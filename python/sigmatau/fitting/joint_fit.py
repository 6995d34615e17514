"""Result of a joint fit: the model of all runs, how much they differ, and which runs are outliers."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import field
from typing import Any

from sigmatau.digits import round_to_error, two_digits
from sigmatau.findings.phrases import percent
from sigmatau.fitting.fitted_values import Interval
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, display_units
from sigmatau.results import Plain, TablesByChannel, Tabular, duration_text, plain

ALPHA = 0.01
"""Corrected p-value below which a run is an outlier, and below which runs differ."""


@frozen
class Spread(Plain):
    """Variation of a coefficient from run to run.

    Attributes
    ----------
    relative : float
        Relative standard deviation over the runs.
    p_value : float
        P-value of equal coefficients in all runs.
    """

    relative: float
    p_value: float


@frozen(eq=False)
class RunOfJoint:
    """One run of a joint fit.

    Attributes
    ----------
    name : str
    fit : NoiseFit
        Name of this run alone.
    values : mapping of str to Interval
        Coefficients that differ from run to run. [SI]
    own : mapping of str to Interval
        Common coefficients fitted to this run alone. Their intervals are symmetric about the squared coefficient. [SI]
    p_value : float
        P-value of the run among the others, corrected for the number of runs and tests. Small for an outlier.
    cause : str
        Largest difference of the run: a term, or ``"all"`` for the shape of the spectrum with its filter.
    factor : float or None
        The coefficient of `cause` over that of the other runs; None if one of them does not show it. [1]
    """

    name: str
    fit: NoiseFit
    values: Mapping[str, Interval]
    own: Mapping[str, Interval]
    p_value: float
    cause: str
    factor: float | None

    @property
    def belongs(self) -> bool:
        """Whether the run is not an outlier."""
        return self.p_value >= ALPHA

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "name belongs p_value cause factor values own", duration_s=self.duration)

    @property
    def duration(self) -> float:
        """Length of the run. [s]"""
        return self.fit.n * self.fit.tau0

    def text(self, quantity: str) -> str:
        """Why a run is an outlier, in words.

        Parameters
        ----------
        quantity : str
            ``"angular_rate"``, ``"acceleration"`` or ``"signal"``, for the name of the term.

        Returns
        -------
        str
        """
        if self.cause in TERMS and self.factor is None:
            label = TERMS[self.cause].label(quantity)
            return f"{self.name}: {label}, which the other runs do not show, p = {self.p_value:.1g}"
        if self.cause not in TERMS or self.factor is None:
            return f"{self.name}: its spectrum differs from that of the other runs, p = {self.p_value:.1g}"
        label = TERMS[self.cause].label(quantity)
        return f"{self.name}: {label} {two_digits(self.factor)} times that of the other runs, p = {self.p_value:.1g}"


@frozen(eq=False)
class JointChannel(Tabular):
    """Joint fit of one channel over several runs.

    Attributes
    ----------
    fit : NoiseFit
        The model of all runs. Coefficients in `common` are the same in all runs; the others are means over runs.
    common : tuple of str
        Terms that are the same in all runs.
    spreads : mapping of str to Spread
        Variation of the terms that differ from run to run, for those that the runs show.
    homogeneity : mapping of str to float
        P-value of equal coefficients in all runs, for each common term that the runs show. A term with p < 0.01 is in
        `spreads` instead, unless most single runs do not show it.
    runs : tuple of RunOfJoint

    See Also
    --------
    fit_jointly : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = [st.simulate(model, duration=300, rate=10, rng=day) for day in range(3)]
    >>> joint = st.fit_jointly(days)["gyro_x"]
    >>> joint.pooled(), joint.outliers
    ('3 runs, 15 min together', ())
    """

    fit: NoiseFit
    common: tuple[str, ...]
    spreads: Mapping[str, Spread]
    homogeneity: Mapping[str, float]
    runs: tuple[RunOfJoint, ...] = field(repr=False)

    @property
    def channel(self) -> str:
        """Name of the channel."""
        return self.fit.channel

    @property
    def outliers(self) -> tuple[str, ...]:
        """Names of outlying runs, the worst first."""
        return tuple(run.name for run in self._outliers())

    def _outliers(self) -> list[RunOfJoint]:
        return sorted((run for run in self.runs if not run.belongs), key=lambda run: run.p_value)

    def statements(self) -> list[str]:
        """Differences between the runs, and outlying runs, in words."""
        quantity = self.fit.quantity
        rows = []
        for term, spread in self.spreads.items():
            label = TERMS[term].label(quantity)
            if spread.p_value < ALPHA:
                rows.append(f"{label}: differs by {percent(spread.relative)} from run to run")
        for term, p_value in self.homogeneity.items():
            if p_value < ALPHA:
                label = TERMS[term].label(quantity)
                rows.append(f"{label}: not the same in all runs, p = {p_value:.1g}; the interval is too narrow")
        return rows + [run.text(quantity) for run in self._outliers()]

    def to_dict(self) -> dict[str, Any]:
        """The ``joint`` of a channel in the JSON form: plain values in SI without NaN."""
        return plain(self, "common spreads homogeneity runs outliers")

    def columns(self) -> dict[str, list[Any]]:
        """One row per run and coefficient, see `Tabular.columns`; the joint coefficients first."""
        rows: list[dict[str, Any]] = []
        for name, term in self.fit.items():
            line = {"run": "all", "term": name, "value": term.value, "low": term.low, "high": term.high}
            rows.append({**line, "unit": term.unit, "p_value": term.p_value, "belongs": None})
        for run in self.runs:
            for name, value in {**run.values, **run.own}.items():
                line = {"run": run.name, "term": name, "value": value.value, "low": value.low, "high": value.high}
                rows.append({**line, "unit": value.unit, "p_value": run.p_value, "belongs": run.belongs})
        names = ("run", "term", "value", "low", "high", "unit", "p_value", "belongs")
        return {"channel": [self.channel] * len(rows), **{name: [row[name] for row in rows] for name in names}}

    def __repr__(self) -> str:
        lines = [repr(self.fit), f"  {self.pooled()}", *(f"  {text}" for text in self.statements())]
        shown = [*self.spreads, *self.homogeneity]
        for run in self.runs:
            cells = [text for name in shown if (text := self._cell(run, name))]
            lines.append(f"  {run.name}: {', '.join(cells) or 'no term observed'}")
        return "\n".join(lines)

    def _cell(self, run: RunOfJoint, name: str) -> str:
        value = run.values.get(name) or run.own.get(name)
        if value is None:
            return ""
        unit, factor = display_units(name, self.fit.quantity, self.fit.rate_unit, [value.value])[0]
        rounded = round_to_error(value.value, value.low, value.high, size=factor)
        return f"{TERMS[name].label(self.fit.quantity)} {rounded.with_unit(unit)}"

    def pooled(self) -> str:
        """Description of the pooled data: ``"7 runs, 14 h together"``."""
        return f"{len(self.runs)} runs, {duration_text(sum(self.fit.runs))} together"

    def _repr_html_(self) -> str:
        notes = "".join(f"<li>{html.escape(text)}</li>" for text in (self.pooled(), *self.statements()))
        return f"{self.fit._repr_html_()}<ul>{notes}</ul>"


class JointFit(TablesByChannel[JointChannel]):
    """Joint fits by channel: an immutable mapping in the order of the records.

    See Also
    --------
    fit_jointly : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> days = [st.simulate(model, duration=300, rate=10, rng=day) for day in range(3)]
    >>> list(st.fit_jointly(days).fits)
    ['gyro_x']
    """

    __slots__ = ()

    @property
    def fits(self) -> dict[str, NoiseFit]:
        """The models of all runs, by channel."""
        return {channel: joint.fit for channel, joint in self.items()}

    @property
    def outliers(self) -> dict[str, tuple[str, ...]]:
        """Outlying runs by channel; channels without outliers are omitted."""
        return {channel: joint.outliers for channel, joint in self.items() if joint.outliers}
