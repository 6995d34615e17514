"""`Lot`: the units of a lot with their states, the distributions over them, and an exit code for a production line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau import __version__
from sigmatau.arrays import Floats
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.claims import MINIMUM
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.lab.datasheets.verdict import Verdict
from sigmatau.lab.lots.capability import BoundedNumber, estimate_capability, estimate_yield
from sigmatau.lab.lots.lot_bands import Band
from sigmatau.lab.lots.lot_remark import STATES, Remark, State
from sigmatau.lab.lots.lot_statistics import Distribution
from sigmatau.lab.lots.lot_unit import UnitResult
from sigmatau.lab.lots.lot_words import STATE_WORDS, what_text, what_unit
from sigmatau.noise.terms import TERMS, coefficient_unit
from sigmatau.results import Tabular, plain, plain_value, printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sigmatau.lab.lots.lot_plot import LotCurves

SCHEMA = 1
"""Version of the JSON form of a lot."""

_MOST_REASONS = 2  # largest number of reasons in a table

FAILED, OPEN = 3, 4
"""Exit codes: a unit failed; not all units are present, read and judged."""


@frozen
class JudgingOptions:
    """The options of a judgement, as for `sigmatau.judge_lot`.

    Attributes
    ----------
    level : float
        Confidence level.
    factor : float or None
        Factor from the typical value to the maximum, where the specification states no maximum.
    sided : {"one", "two"} or None
        Convention of noise densities.
    bias : {"minimum", "coefficient"} or None
        Convention of bias instabilities.
    undecided : {"not-judged", "pass", "fail"}
        State of a unit whose interval contains a maximum.
    fail_on : {"warning"} or None
        Whether a warning fails a unit.
    accept : tuple of str
        Codes that do not keep a unit from passing.
    """

    level: float = 0.95
    factor: float | None = None
    sided: str | None = None
    bias: str | None = None
    undecided: str = "not-judged"
    fail_on: str | None = None
    accept: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "level factor sided bias undecided fail_on accept")


@frozen(eq=False)
class JudgedUnit:
    """One unit of a lot.

    Attributes
    ----------
    name : str
    state : {"passed", "failed", "not_judged", "unreadable", "missing"}
    remarks : tuple of Remark
        Remarks; those that decide the state come first.
    result : UnitResult
    """

    name: str
    state: State
    remarks: tuple[Remark, ...]
    result: UnitResult

    @property
    def verdict(self) -> Verdict | None:
        """The comparison with the specification, number by number; None without a result or a specification."""
        return self.result.verdict

    @property
    def reasons(self) -> tuple[Remark, ...]:
        """The remarks that decided the state, the worst kind first."""
        if self.state == "passed":
            return ()
        deciding = tuple(remark for remark in self.remarks if remark.kind != "note")
        return deciding or tuple(remark for remark in self.remarks if remark.code == "no_specification")

    @property
    def reason(self) -> str:
        """Why the unit did not pass, in words; empty if it passed."""
        return "; ".join(dict.fromkeys(remark.text for remark in self.reasons))

    @property
    def brief(self) -> str:
        """The first reasons, and how many more there are."""
        texts = list(dict.fromkeys(remark.text for remark in self.reasons))
        surplus = len(texts) - _MOST_REASONS
        return "; ".join(texts[:_MOST_REASONS]) + (f"; and {surplus} more" if surplus > 0 else "")

    @property
    def notes(self) -> tuple[Remark, ...]:
        """Remarks that do not affect the state."""
        return tuple(remark for remark in self.remarks if remark.kind == "note" and remark.code != "no_specification")

    def __repr__(self) -> str:
        return ": ".join(filter(None, (printable(self.name), STATE_WORDS[self.state], self.reason)))

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        channels = {
            name: {
                "quantity": channel.quantity,
                "unit": channel.unit,
                "sample_rate_hz": channel.rate,
                "samples": channel.samples,
                "trust": channel.trust,
                "coefficients": {
                    what: {
                        key: number
                        for key in ("value", "low", "high", "limit")
                        if (number := getattr(coefficient, key)) is not None
                    }
                    for what, coefficient in channel.coefficients.items()
                },
            }
            for name, channel in self.result.channels.items()
        }
        claims = [] if self.verdict is None else [judged.to_dict() for judged in self.verdict.judged]
        return {
            "name": self.name,
            "state": self.state,
            "reason": self.reason,
            "remarks": [remark.to_dict() for remark in self.remarks],
            "path": self.result.path,
            "sha256": self.result.sha256,
            "channels": channels,
            "claims": claims,
        }


@frozen(eq=False)
class Lot(Tabular):
    """Result of `judge_lot`.

    Attributes
    ----------
    spec : Datasheet or None
    units : tuple of JudgedUnit
        Judged units in the given order, followed by missing units.
    distributions : tuple of Distribution
        Distributions of the coefficients that at least half of the units show, by channel.
    bands : tuple of Band
        The curves of all units by channel, with their median and range.
    sensors : tuple of Distribution
        Geometric means of the coefficients over the axes of each sensor, and Allan deviations at a long averaging time.
    expected : int or None
        Number of units that were expected.
    too_many : int
        Number of units beyond the expected number.
    settings : JudgingOptions

    See Also
    --------
    judge_lot : makes it.
    lot_report : writes it as a page.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> results = [st.analyze(st.simulate(model, duration=600, rate=10, rng=k)) for k in range(3)]
    >>> lot = st.judge_lot(results)
    >>> lot.counts["not_judged"], lot.exit_code  # without a specification
    (3, 4)
    """

    spec: Datasheet | None
    units: tuple[JudgedUnit, ...]
    distributions: tuple[Distribution, ...]
    bands: tuple[Band, ...]
    sensors: tuple[Distribution, ...] = ()
    expected: int | None = None
    too_many: int = 0
    settings: JudgingOptions = JudgingOptions()

    def of(self, state: State) -> tuple[JudgedUnit, ...]:
        """The units with a state.

        Parameters
        ----------
        state : {"passed", "failed", "not_judged", "unreadable", "missing"}

        Returns
        -------
        tuple of JudgedUnit
        """
        return tuple(unit for unit in self.units if unit.state == state)

    def __getitem__(self, name: str) -> JudgedUnit:
        for unit in self.units:
            if unit.name == name:
                return unit
        raise KeyError(f"no unit {name!r}")

    @property
    def counts(self) -> dict[str, int]:
        """Number of units by state."""
        return {state: len(self.of(state)) for state in STATES}

    @property
    def exit_code(self) -> int:
        """0: all passed; 3: a unit failed; 4: a unit is not judged, not read or missing, or there is no specification."""
        if self.of("failed"):
            return FAILED
        unfinished = self.of("not_judged") or self.of("unreadable") or self.of("missing") or self.too_many
        return OPEN if unfinished else 0

    @property
    def drifts(self) -> tuple[Distribution, ...]:
        """The distributions with a drift or a batch in the order of the units, those of the sensors first."""
        return tuple(part for part in (*self.sensors, *self.distributions) if part.order is not None)

    @property
    def passing(self) -> BoundedNumber | None:
        """Yield: the share of the units that passed, with its 95 % interval; None without a specification."""
        if self.spec is None or not self.units:
            return None
        return estimate_yield(len(self.of("passed")), len(self.units))

    def capability(self, distribution: Distribution) -> BoundedNumber | None:
        """Capability Cpk of a coefficient, with its 95 % interval.

        Parameters
        ----------
        distribution : Distribution
            One of `distributions`.

        Returns
        -------
        BoundedNumber or None
            None without a single maximum, or for fewer than ten units.
        """
        limits = self.limits(distribution.channel, distribution.what)
        return estimate_capability(distribution.values, limits[0]) if len(limits) == 1 else None

    def quantity_of(self, channel: str) -> tuple[str, str]:
        """Quantity and SI unit of a channel.

        Parameters
        ----------
        channel : str
            Name of the channel.

        Returns
        -------
        quantity, unit : str
        """
        band = next(band for band in self.bands if band.channel == channel)
        return band.quantity, band.unit

    def limits(self, channel: str, what: str) -> tuple[float, ...]:
        """Maxima of the specification for a coefficient; two if its convention is open. [SI]

        Parameters
        ----------
        channel : str
            Name of the channel.
        what : str
            The coefficient: a term, ``"means_10"`` or ``"means_100"``.

        Returns
        -------
        tuple of float
            Maxima. [SI]
        """
        maxima: set[float] = set()
        for claim in () if self.spec is None else self.spec.of(channel):
            maximum = claim.maximum
            if maximum is None and self.settings.factor is not None and claim.typical is not None:
                maximum = self.settings.factor * claim.typical
            if maximum is None:
                continue
            sided: Any = self.settings.sided
            bias: Any = self.settings.bias
            for meaning in claim.meanings(sided=sided, bias=bias):
                name = meaning.of if claim.average is None else f"means_{claim.average:g}"
                maxima |= {maximum * meaning.factor} if name == what else set()
        return tuple(sorted(maxima))

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, no NaN."""
        return {
            "lot": SCHEMA,
            "sigmatau": __version__,
            "exit_code": self.exit_code,
            "counts": self.counts,
            "yield": plain_value(self.passing),
            "expected": self.expected,
            "too_many": self.too_many,
            "specification": None if self.spec is None else self.spec.to_dict(),
            "settings": self.settings.to_dict(),
            "units": [unit.to_dict() for unit in self.units],
            "distributions": [
                distribution.to_dict()
                | {"capability": None if (number := self.capability(distribution)) is None else number.to_dict()}
                for distribution in self.distributions
            ],
            "sensors": [distribution.to_dict() for distribution in self.sensors],
        }

    def columns(self) -> dict[str, list[Any]]:
        """One row per unit, channel and coefficient, see `Tabular.columns`; a unit without a result has one row."""
        names = ("unit", "state", "reason", "channel", "coefficient", "value", "low", "high", "upper_limit", "unit_si")
        rows: list[tuple[Any, ...]] = []
        for unit in self.units:
            head = (unit.name, unit.state, unit.reason)
            before = len(rows)
            for channel, part in unit.result.channels.items():
                for what, coefficient in part.coefficients.items():
                    numbers = (coefficient.value, coefficient.low, coefficient.high, coefficient.limit)
                    rows.append((*head, channel, what, *numbers, _si_unit(what, part.quantity, part.unit)))
            if len(rows) == before:
                rows.append((*head, None, None, None, None, None, None, None))
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}

    def plot(self, *channels: str, ax: Any = None) -> Figure:  # noqa: ANN401  axes of matplotlib
        """Draw the curves of all units with the median and the range of the lot, a panel for each channel.

        Parameters
        ----------
        *channels : str
            Which channels. Default: all.
        ax : matplotlib axes, or sequence of them, optional
            One for each channel. Default: a new figure.

        Returns
        -------
        matplotlib figure

        Raises
        ------
        KeyError
            For an unknown channel.
        """
        from sigmatau.lab.lots.lot_plot import draw_lot

        for name in channels:
            if name not in (channel_names := [band.channel for band in self.bands]):
                raise KeyError(f"no channel {name!r}; channels: {', '.join(channel_names)}")
        panels = [self.curves_of(band) for band in self.bands if not channels or band.channel in channels]
        return draw_lot(panels, {name for band in self.bands for name in self.marked(band.channel)}, ax=ax)

    def marked(self, channel: str, *, most: int = 5) -> list[str]:
        """Units whose curve of a channel is drawn in colour: failed units and outliers.

        Parameters
        ----------
        channel : str
            Name of the channel.
        most : int
            Largest number of units.

        Returns
        -------
        list of str
        """
        names = []
        for unit in self.units:
            about = [r for r in unit.remarks if r.kind in ("limit", "lot") or r.code in ("outlier", "other_scale")]
            if any(not r.channels or channel in r.channels for r in about):
                names.append(unit.name)
        return names[:most]

    def curves_of(self, one: Band) -> LotCurves:
        """The curves of a channel in its display unit, with the maxima of the specification.

        Parameters
        ----------
        one : Band
            The curves of the channel, one of `bands`.

        Returns
        -------
        LotCurves
        """
        from sigmatau.lab.lots.lot_plot import LotCurves

        text, factor = what_unit("means_10", one.quantity, one.unit, one.median.tolist())
        return LotCurves(
            title=one.channel,
            unit=text,
            tau=one.tau,
            median=one.median / factor,
            low=one.low / factor,
            high=one.high / factor,
            units={name: curve / factor for name, curve in one.curves.items()},
            limits=[(label, line / factor) for label, line in self.limit_lines(one.channel, one.tau)],
        )

    def limit_lines(self, channel: str, tau: Floats) -> list[tuple[str, Floats]]:
        """Maxima of the specification as lines in the plot of the curves.

        Each term of a unit, drawn alone, must lie below its line; a curve is the sum of all terms.

        Parameters
        ----------
        channel : str
            Name of the channel.
        tau : ndarray, shape (n_tau,)
            Averaging times. [s]

        Returns
        -------
        list of (str, ndarray of shape (n_tau,))
            Name of the coefficient, and its line. [unit of the rate]
        """
        shapes = {name: term.deviation(tau) for name, term in TERMS.items()} | {MINIMUM: np.ones_like(tau)}
        quantity, _ = self.quantity_of(channel)
        return [
            ("Allan minimum" if what == MINIMUM else what_text(what, quantity), limit * shape)
            for what, shape in shapes.items()
            for limit in self.limits(channel, what)
        ]

    def __repr__(self) -> str:
        from sigmatau.lab.lots.lot_screen import screen

        return screen(self)


def _si_unit(what: str, quantity: str, unit: str) -> str:
    return coefficient_unit("bias_instability" if what.startswith("means_") else what, quantity, unit)
