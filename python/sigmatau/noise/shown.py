"""Units of printed and drawn values, if the user wants other units than the usual ones."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from typing import Literal

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.units import find_unit

_PREFIXES = {"": 1.0, "p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "h": 1e2, "k": 1e3, "M": 1e6, "G": 1e9}

_POWERS = {-12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
_READABLE = (0.01, 1e5)
"""Range in which the numbers of a column need no prefix: at most one zero after the point, and six digits."""

_ROUNDED = 1.005  # factor that includes 0.999 of a unit, which is printed as 1.0

# Units of other sensors: the SI unit of the same kind, and one such unit in SI.
_SIGNAL_UNITS = {
    "T": ("T", 1.0),
    "Pa": ("Pa", 1.0),
    "bar": ("Pa", 1e5),
    "V": ("V", 1.0),
    "A": ("A", 1.0),
    "W": ("W", 1.0),
    "ohm": ("ohm", 1.0),
    "K": ("K", 1.0),
    "degC": ("K", 1.0),  # unit of differences
    "°C": ("K", 1.0),
}

# Suffix of the unit of a signal in the unit of a coefficient, by spelling: the form in seconds, and its factor.
_ROOT_HOUR = math.sqrt(3600)
_TAILS = {
    "": ("", 1.0),
    "*s": ("*s", 1.0),
    "*sqrt(s)": ("*sqrt(s)", 1.0),
    "/sqrt(Hz)": ("*sqrt(s)", 1.0),
    "/sqrt(s)": ("/sqrt(s)", 1.0),
    "/sqrt(h)": ("/sqrt(s)", 1 / _ROOT_HOUR),
    "/s": ("/s", 1.0),
    "/h": ("/s", 1 / 3600),
    "/d": ("/s", 1 / 86400),
}
_SIDES = re.compile(r"[:\s]\s*(one|two)[- ]sided$")
_ROOT = re.compile(r"(?:√|\b(?:rt|root|sqrt)[ -]?)\(?(Hz|hz|s|h)\)?")
_KINDS = (  # SI units of coefficients of inertial sensors
    *("rad", "rad/sqrt(s)", "rad/s", "rad/s/sqrt(s)", "rad/s^2"),
    *("m/s", "m/s/sqrt(s)", "m/s^2", "m/s^2/sqrt(s)", "m/s^3"),
)
# examples by SI unit of a coefficient; those of rates and densities suffice if all coefficients are printed
_EXAMPLES = {
    "rad/s": "deg/h",
    "rad/sqrt(s)": "mdps/rtHz, deg/sqrt(h)",
    "rad": "arcsec",
    "rad/s/sqrt(s)": "deg/h/sqrt(h)",
    "rad/s^2": "deg/h/h",
    "m/s^2": "ug",
    "m/s/sqrt(s)": "ug/rtHz, m/s/sqrt(h)",
    "m/s": "mm/s",
    "m/s^2/sqrt(s)": "ug/sqrt(s)",
    "m/s^3": "ug/h",
}
_MANY = 2  # number of coefficients from which examples of rates and densities are given


@frozen
class ShownUnit:
    """A unit in which values are shown.

    Attributes
    ----------
    spelled : str
        Text as typed by the user.
    bare : str
        Text as it is printed, without the sides of a density.
    sided : {"", "one", "two"}
        Sides of a density.
    si : str
        SI unit of the same kind: that of a coefficient of an inertial sensor, or of another signal.
    factor : float
        One unit in SI.
    tail : str or None
        For another signal, the suffix after its unit: ``"*sqrt(s)"`` for a random walk. None for an inertial sensor.
    """

    spelled: str
    bare: str
    sided: Literal["", "one", "two"]
    si: str
    factor: float
    tail: str | None = None

    @property
    def text(self) -> str:
        """Printed form, with the sides of a density."""
        return f"{self.bare}, {self.sided}-sided" if self.sided else self.bare


SHOWN: ContextVar[tuple[ShownUnit, ...]] = ContextVar("SHOWN", default=())
"""The units that the user asked for."""


@contextmanager
def show_in(units: str | Sequence[str]) -> Iterator[None]:
    """Print and draw values in some units, within a ``with`` block.

    The units apply to printed results, reports, figures and the words of findings; numbers in JSON, CSV and attributes
    stay in SI. A unit applies to one coefficient; bias instability has the unit of curves. The bare unit of another
    signal, such as ``"nT"``, applies to all its coefficients. A unit that fits no channel changes nothing.

    Parameters
    ----------
    units : str or sequence of str
        ``"deg/h,mdps/rtHz,ug/rtHz"``. A density (per √Hz) is two-sided and equals the random walk N; with
        ``:one-sided`` it is √2·N. Signals in T, Pa, bar, V, A, W, ohm, K and °C have the prefixes p, n, u, m, h, k, M
        and G.

    Returns
    -------
    context manager
        It ends the use of the units.

    Raises
    ------
    OptionError
        For a unit that is not that of a coefficient.

    See Also
    --------
    Analysis.plot : draws curves in a unit.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> fitted = st.fit_channel(st.simulate(model, duration=600, rate=10, rng=1), "gyro_x")
    >>> with st.show_in("mdps/rtHz"):
    ...     fitted.texts("random_walk")[0][2]
    'mdeg/s/√Hz, two-sided'
    """
    token = SHOWN.set(parse_units(units))
    try:
        yield
    finally:
        SHOWN.reset(token)


def set_shown(units: str | None) -> None:
    """Show values in some units from now on in this context; None restores the usual units."""
    SHOWN.set(() if units is None else parse_units(units))


def parse_units(units: str | Sequence[str]) -> tuple[ShownUnit, ...]:
    """Parse units that are separated by commas.

    Raises
    ------
    OptionError
        For a unit that is not that of a coefficient.
    """
    spelled = units.split(",") if isinstance(units, str) else list(units)
    return tuple(_parse(text.strip()) for text in spelled)


def asked_unit(si: str, rate_unit: str, tail: str | None) -> tuple[str, float] | None:
    """The unit in which a coefficient is to be shown, and its size in the unit of the result; None if it is the usual one.

    Parameters
    ----------
    si : str
        SI unit of the coefficient of an inertial sensor.
    rate_unit : str
        Unit of the channel.
    tail : str or None
        Suffix that turns the unit of another signal into that of the coefficient: ``"*sqrt(s)"``. None for an inertial
        sensor.
    """
    asked = shown_unit(si, rate_unit, tail)
    return None if asked is None else (asked.text, asked.factor)


def shown_unit(si: str, rate_unit: str, tail: str | None) -> ShownUnit | None:
    """The unit in which a coefficient is to be shown, with its size in the unit of the result, see `asked_unit`."""
    asked = next(iter(_fitting(si, rate_unit, tail)), None)
    if asked is None or tail is None:
        return asked
    bare = asked.bare if asked.tail or not tail else asked.bare + _pretty(tail)
    return replace(asked, bare=bare, factor=asked.factor / _signal_unit(rate_unit)[1])


def prefixed_unit(rate_unit: str, tail: str, values: Iterable[float | None]) -> ShownUnit | None:
    """The unit of a coefficient of another signal with the prefix that its values need, and its size in the usual unit.

    Parameters
    ----------
    rate_unit : str
        Unit of the channel.
    tail : str
        Suffix that turns it into the unit of the coefficient. The density of a random walk, unit·√s, is written per
        √Hz.
    values : iterable of float or None
        Values to print, in the usual unit.

    Returns
    -------
    ShownUnit or None
        None if the numbers in the usual unit need no prefix, or if the signal's unit has no prefixes.
    """
    base, size = _signal_unit(rate_unit)
    largest = max((abs(value) for value in values if value and math.isfinite(value)), default=0.0)
    if not size or not largest or _READABLE[0] <= largest < _READABLE[1]:
        return None
    power = 3 * math.floor(math.log10(largest * size * _ROUNDED) / 3)
    prefix = _POWERS[min(max(power, min(_POWERS)), max(_POWERS))]
    is_density = tail == "*sqrt(s)"
    return ShownUnit(
        spelled=prefix + base,
        bare=_printed(prefix + base) + ("/√Hz" if is_density else _pretty(tail)),
        sided="two" if is_density else "",
        si=base,
        factor=_PREFIXES[prefix] / size,
        tail=tail,
    )


def error_unit(si: str) -> tuple[str, float]:
    """The unit in which an error of attitude, velocity or position is shown, and its size in SI."""
    usual = ("deg", math.pi / 180) if si == "rad" else (si, 1.0)
    return asked_unit(si, si, None) or usual


def check_units(channels: Mapping[str, Sequence[tuple[str, str, str | None]]]) -> None:
    """Refuse a unit that fits no channel, and two units for one coefficient.

    Parameters
    ----------
    channels : mapping of str to sequence
        By channel, the arguments of `asked_unit` for each printed coefficient.

    Raises
    ------
    OptionError
        Names the unit, and units that fit.
    """
    if not SHOWN.get():
        return
    used: set[str] = set()
    for name, coefficients in channels.items():
        for si, rate_unit, tail in coefficients:
            fitting = _fitting(si, rate_unit, tail)
            rivals = [unit.spelled for unit in fitting if unit.tail == fitting[0].tail]
            if len(rivals) > 1:
                raise OptionError(
                    f"{' and '.join(rivals)} are units of the same coefficient of {name}. Give one of them",
                    option="show",
                )
            used.update(unit.spelled for unit in fitting)
    for unit in SHOWN.get():
        if unit.spelled not in used:
            fitting_units = "; ".join(dict.fromkeys(map(_unit_examples, channels.values())))
            raise OptionError(
                f"{unit.spelled!r} fits no printed value of {', '.join(list(channels)[:6])}."
                f" Units that fit: {fitting_units}",
                option="show",
            )


def _unit_examples(coefficients: Sequence[tuple[str, str, str | None]]) -> str:
    """Units in which coefficients of a channel can be shown: ``"deg/h, mdps/rtHz"``."""
    if all(tail is None for *_, tail in coefficients):
        units = dict.fromkeys(si for si, *_ in coefficients)
        usual = [si for si in units if si.endswith(("rad/s", "m/s^2")) or si in ("rad/sqrt(s)", "m/s/sqrt(s)")]
        return ", ".join(_EXAMPLES[si] for si in (usual if len(units) > _MANY else units))
    unit = coefficients[0][1]
    base, factor = _signal_unit(unit)
    if not factor:
        return f"none, because the unit {unit!r} has no prefixes"
    tails = {tail for *_, tail in coefficients}
    return f"m{base}, u{base}/rtHz" if "*sqrt(s)" in tails else f"m{base}"


def _fitting(si: str, rate_unit: str, tail: str | None) -> list[ShownUnit]:
    """The units that fit a coefficient, see `asked_unit`; units of this coefficient alone come first."""
    if tail is None or not SHOWN.get():
        return [unit for unit in SHOWN.get() if unit.tail is None and unit.si == si]
    base, factor = _signal_unit(rate_unit)
    if not factor:
        return []
    units = [unit for unit in SHOWN.get() if unit.si == base and unit.tail in (tail, "")]
    return sorted(units, key=lambda unit: unit.tail != tail)


def _parse(spelled: str) -> ShownUnit:
    side = _SIDES.search(spelled)
    bare = _SIDES.sub("", spelled).strip()
    unit = find_unit(bare)
    if unit is not None and unit.si in _KINDS:
        is_density = "sqrt(Hz)" in unit.symbol
        text, si, factor, tail = unit.text, unit.si, unit.factor, None
    else:
        plain = (
            _ROOT.sub(lambda match: f"sqrt({match[1].replace('hz', 'Hz')})", bare).replace("·", "*").replace(" ", "")
        )
        end = min((k for k in (plain.find("*"), plain.find("/")) if k >= 0), default=len(plain))
        name, ending = plain[:end], plain[end:]
        si, factor = _signal_unit(name)
        if not factor or ending not in _TAILS:
            raise OptionError(
                f"{spelled!r} is not a unit of a coefficient. Give units such as deg/h, mdps/rtHz, ug, ug/rtHz, nT, nT/rtHz,"
                " hPa, uV or mK",
                option="show",
            )
        is_density = ending == "/sqrt(Hz)"
        tail, size = _TAILS[ending]
        text, factor = _printed(name) + _pretty(ending), factor * size
    if side and not is_density:
        raise OptionError(
            f"{spelled!r}: only a density is one- or two-sided. Leave the side out, or give a unit per √Hz such as"
            " mdps/rtHz:one-sided",
            option="show",
        )
    sided: Literal["", "one", "two"] = "" if not is_density else "one" if side and side[1] == "one" else "two"
    if sided == "one":
        factor /= math.sqrt(2)
    return ShownUnit(spelled=spelled, bare=text, sided=sided, si=si, factor=factor, tail=tail)


def _signal_unit(name: str) -> tuple[str, float]:
    """SI unit and size of a unit of a signal, ``("T", 1e-9)`` for ``"nT"``; size 0 for a unit without prefixes."""
    name = name.strip().replace("µ", "u").replace("μ", "u")
    for base, (si, factor) in _SIGNAL_UNITS.items():
        if name.endswith(base) and name.removesuffix(base) in _PREFIXES:
            return si, factor * _PREFIXES[name.removesuffix(base)]
    return name, 0.0


def _printed(name: str) -> str:
    return "µ" + name[1:] if name.startswith("u") else name


def _pretty(tail: str) -> str:
    return re.sub(r"sqrt\((\w+)\)", r"√\1", tail).replace("*", "·")
