"""Units: one closed table, SI inside.

Values in other units occur only where they are read, printed, drawn or written. There is no unit algebra: a unit that is not
in the table is an error, because a refused unit is better than a misread one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen

STANDARD_GRAVITY = 9.80665
"""Conventional value of the acceleration of free fall, exact (CGPM 1901). [m/s²]"""

_DEG = math.pi / 180
_ARCSEC = _DEG / 3600
_HOUR = 3600.0
_FOOT = 0.3048  # international foot, exact


@frozen(kw_only=False)
class Unit:
    """A unit of the table.

    Attributes
    ----------
    symbol : str
        As it is typed in options and files, ASCII: ``"deg/sqrt(h)"``.
    si : str
        The SI unit of the same kind, which also names the kind: ``"rad/sqrt(s)"``.
    factor : float
        One unit in SI.
    text : str
        As it is printed and drawn: ``"deg/√h"``.
    """

    symbol: str
    si: str
    factor: float
    text: str


def _pretty(symbol: str) -> str:
    text = symbol.replace("sqrt(h)", "√h").replace("sqrt(s)", "√s").replace("sqrt(Hz)", "√Hz")
    text = text.replace("*", "·").replace("^(3/2)", "^{3/2}").replace("^2", "²").replace("^3", "³")
    return re.sub(r"\bu(?=g|rad|s|deg|m\b)", "µ", text)


def _table() -> dict[str, Unit]:
    g = STANDARD_GRAVITY
    root_hour = math.sqrt(_HOUR)
    rows: dict[str, dict[str, float]] = {
        # kind (its SI unit): symbol -> one unit in SI
        "rad/s": {
            "rad/s": 1.0,
            "mrad/s": 1e-3,
            "urad/s": 1e-6,
            "nrad/s": 1e-9,
            "deg/s": _DEG,
            "mdeg/s": _DEG / 1e3,
            "deg/h": _DEG / _HOUR,
            "deg/min": _DEG / 60,
            "rad/min": 1 / 60,
            "arcsec/s": _ARCSEC,
            "rpm": 2 * math.pi / 60,
        },
        "m/s^2": {
            "m/s^2": 1.0,
            "g": g,
            "mg": g * 1e-3,
            "ug": g * 1e-6,
            "ng": g * 1e-9,
            "cm/s^2": 1e-2,
            "mm/s^2": 1e-3,
            "um/s^2": 1e-6,
            "Gal": 1e-2,
            "mGal": 1e-5,
            "ft/s^2": _FOOT,
            "m/s/h": 1 / _HOUR,
        },
        "rad": {"rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": _DEG, "arcmin": 60 * _ARCSEC, "arcsec": _ARCSEC},
        "m/s": {
            "m/s": 1.0,
            "mm/s": 1e-3,
            "um/s": 1e-6,
            "km/h": 1 / 3.6,
            "ft/s": _FOOT,
            "g*s": g,
            "mg*s": g * 1e-3,
            "ug*s": g * 1e-6,
        },
        "rad/sqrt(s)": {
            "rad/sqrt(s)": 1.0,
            "rad/s/sqrt(Hz)": 1.0,
            "mrad/s/sqrt(Hz)": 1e-3,
            "urad/s/sqrt(Hz)": 1e-6,
            "nrad/s/sqrt(Hz)": 1e-9,
            "mrad/sqrt(s)": 1e-3,
            "urad/sqrt(s)": 1e-6,
            "nrad/sqrt(s)": 1e-9,
            "rad/sqrt(h)": 1 / root_hour,
            "mrad/sqrt(h)": 1e-3 / root_hour,
            "urad/sqrt(h)": 1e-6 / root_hour,
            "arcsec/sqrt(s)": _ARCSEC,
            "arcsec/s/sqrt(Hz)": _ARCSEC,
            "arcsec/sqrt(h)": _ARCSEC / root_hour,
            "mdeg/sqrt(s)": _DEG / 1e3,
            "mdeg/sqrt(h)": _DEG / 1e3 / root_hour,
            "udeg/s/sqrt(Hz)": _DEG / 1e6,
            "deg/sqrt(s)": _DEG,
            "deg/s/sqrt(Hz)": _DEG,
            "mdeg/s/sqrt(Hz)": _DEG / 1e3,
            "deg/sqrt(h)": _DEG / root_hour,
            "deg/h/sqrt(Hz)": _DEG / _HOUR,
        },
        "m/s/sqrt(s)": {
            "m/s/sqrt(s)": 1.0,
            "m/s^2/sqrt(Hz)": 1.0,
            "m/s/sqrt(h)": 1 / root_hour,
            "mm/s/sqrt(s)": 1e-3,
            "mm/s/sqrt(h)": 1e-3 / root_hour,
            "mm/s^2/sqrt(Hz)": 1e-3,
            "um/s/sqrt(s)": 1e-6,
            "um/s/sqrt(h)": 1e-6 / root_hour,
            "um/s^2/sqrt(Hz)": 1e-6,
            "ng/sqrt(Hz)": g * 1e-9,
            "ft/s/sqrt(h)": _FOOT / root_hour,
            "g/sqrt(Hz)": g,
            "mg/sqrt(Hz)": g * 1e-3,
            "ug/sqrt(Hz)": g * 1e-6,
        },
        "rad/s/sqrt(s)": {
            "rad/s/sqrt(s)": 1.0,
            "rad/s^2/sqrt(Hz)": 1.0,
            "mdeg/s/sqrt(s)": _DEG / 1e3,
            "mdeg/s/sqrt(h)": _DEG / 1e3 / root_hour,
            "deg/s/sqrt(s)": _DEG,
            "deg/s^2/sqrt(Hz)": _DEG,
            "deg/s/sqrt(h)": _DEG / root_hour,
            "deg/h/sqrt(s)": _DEG / _HOUR,
            "deg/h/sqrt(h)": _DEG / _HOUR / root_hour,
        },
        "m/s^2/sqrt(s)": {
            "m/s^2/sqrt(s)": 1.0,
            "m/s^3/sqrt(Hz)": 1.0,
            "m/s^2/sqrt(h)": 1 / root_hour,
            "m/s/h^(3/2)": 1 / (_HOUR * root_hour),
            "m/s/h/sqrt(h)": 1 / (_HOUR * root_hour),
            "g/sqrt(s)": g,
            "mg/sqrt(s)": g * 1e-3,
            "ug/sqrt(s)": g * 1e-6,
            "g/sqrt(h)": g / root_hour,
            "mg/sqrt(h)": g * 1e-3 / root_hour,
            "ug/sqrt(h)": g * 1e-6 / root_hour,
        },
        "rad/s^2": {
            "rad/s^2": 1.0,
            "deg/s^2": _DEG,
            "deg/s/h": _DEG / _HOUR,
            "deg/h^2": _DEG / _HOUR**2,
            "deg/h/h": _DEG / _HOUR**2,
        },
        "m/s^3": {
            "m/s^3": 1.0,
            "m/s^2/h": 1 / _HOUR,
            "m/s/h^2": 1 / _HOUR**2,
            "mg/h": g * 1e-3 / _HOUR,
            "ug/h": g * 1e-6 / _HOUR,
        },
        "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": _HOUR, "d": 24 * _HOUR},
        "Hz": {"Hz": 1.0, "kHz": 1e3},
    }
    return {
        symbol: Unit(symbol, si, factor, _pretty(symbol))
        for si, units in rows.items()
        for symbol, factor in units.items()
    }


_UNITS = _table()

FIGURE_UNITS: Mapping[str, tuple[str, ...]] = {
    "angular_rate": ("deg/h", "deg/s", "mdeg/s", "rad/s"),
    "acceleration": ("ug", "mg", "m/s^2", "mGal"),
}
"""Units of rates in figures, and the others that a page offers.

All figures have the first one: deviations in deg/h and µg, densities in its square per hertz. It is the family of the
coefficients in tables: deg/h beside deg/√h and deg/h/√h, µg beside µg/√Hz.
"""

# The integral of a rate, kind by kind: what an increment or an accumulated output is measured in.
_INTEGRAL = {"rad/s": "rad", "m/s^2": "m/s"}

# The most usual spelling of each kind of unit, for examples, because users copy these.
_USUAL = {
    "rad/s": "deg/h",
    "m/s^2": "ug",
    "rad": "arcsec",
    "rad/sqrt(s)": "deg/sqrt(h)",
    "m/s/sqrt(s)": "m/s/sqrt(h)",
    "rad/s/sqrt(s)": "deg/h/sqrt(h)",
    "m/s^2/sqrt(s)": "m/s/h^(3/2)",
    "rad/s^2": "deg/h^2",
    "m/s^3": "m/s/h^2",
}

_WORDS = (
    # Patterns count superscripts as letters, so that sec² would not end a word.
    (r"⁻([¹²³])", r"^-\1"),
    (r"⁻", "-"),
    (r"(?<=-)¹", "1"),
    (r"(?<=-)²", "2"),
    (r"(?<=-)³", "3"),
    (r"¹", ""),
    (r"²", "^2"),
    (r"³", "^3"),
    (r"[°º]|\bdegrees?\b|\bdegs\b", "deg"),
    (r"[µμ]|\bmicro\b", "u"),
    (r"\barc ?sec(onds?)?\b|″", "arcsec"),
    (r"\barc ?min(utes?)?\b|′", "arcmin"),
    (r"\bradians?\b|\brads\b", "rad"),
    (r"\bmet(er|re)s?\b", "m"),
    (r"\bmilliseconds?\b|\bmsec\b", "ms"),
    (r"\bmicroseconds?\b|\busec\b", "us"),
    (r"\bnanoseconds?\b|\bnsec\b", "ns"),
    (r"\bseconds?\b|\bsecs?\b", "s"),
    (r"\bminutes?\b", "min"),
    (r"\bhours?\b|\bhrs?\b", "h"),
    (r"^days?$", "d"),
    (r"\bhertz\b", "hz"),
    (r"\bg's\b|\bgs\b|\bgn\b|\bg0\b", "g"),
    (r"\bmilli[ -]", "m"),
    (r"\bu-(?=g\b)", "u"),
    (r"\bfps\b", "ft/s"),
    (r"\bper\b", "/"),
    (r"^[\[(]([^()\[\]]+)[\])](?=\s*[/·* ])", r"\1"),  # (deg/s)/√Hz
    (r"[·* ]\s*(hz|h|s)\s*\^?\(?-(?:½|0?\.5|1/2)\)?", r"/sqrt(\1)"),  # deg·h^-1/2
    (r"(?<=/)(hz|h|s)(?:\^?½|\^\(?(?:0?\.5|1/2)\)?)", r"sqrt(\1)"),  # deg/h^0.5
    (r"√\(?(hz|h|s)\)?", r"sqrt(\1)"),
    (r"\b(?:rt|root|sqrt)[ -]?\(?(hz|h|s)\)?(?!\w)", r"sqrt(\1)"),
    (r"\*\*", "^"),
    (r"\^\{3/2\}|\^1\.5|(?<=[sh])\^3/2$", "^(3/2)"),
    (r"(?<=[sh])\^\(?-(?:1\.5|\(?3/2\)?)\)?$", r"^-(3/2)"),
    (r"[·* ](s|h)\^-\(3/2\)$", r"/\1^(3/2)"),
    (r"(deg|rad)/h\^\(3/2\)$", r"\1/h/sqrt(h)"),  # m/s/h^(3/2) of accelerometers has a separate row in the table
    (r"(?<=g)\s*[·* ]\s*s$", "*s"),
    (r"/s\^\(3/2\)$", "/s/sqrt(s)"),
    (r"/s\^\(5/2\)$|/s\^2\.5$", "/s^2/sqrt(s)"),
    (r"(?<=[sh])\^?\(?-([123])\)?", r"^-\1"),
    (r"\b(s|h)([23])\b", r"\1^\2"),
    (r"\b(deg|rad|m|ft)\s*[·* ]\s*(s|h)\^-([123])", r"\1/\2^\3"),
    (r"\^1\b", ""),
    (r"m/s/s\b(?!/(?!sqrt)|\^)", "m/s^2"),
    (r"\bdps\b", "deg/s"),
    (r"\bdph\b", "deg/h"),
    (r"\bmdps\b", "mdeg/s"),
    (r"\brps\b", "rad/s"),
    (r"\bmps2\b", "m/s^2"),
)

# Spellings of loggers that the patterns do not cover, in the form of `_compact`. To add one, add it to the line of its unit
# and to the table in ``tests/test_units.py``.
_SPELLINGS = {
    "rad/s": "rad/s rad.s-1 rads-1 rads radps rad/s-1 rad_s radiansps",
    "deg/s": "deg/s deg.s-1 degs-1 degps deg/s-1 °s-1 °.s-1 °ps deg_s degree/s dps(deg/s) d/s",
    "mdeg/s": "mdeg/s mdps mdegps mdeg.s-1 mdegs-1 m°/s millidps millidegreespersecond millidegree/s",
    "mrad/s": "mrad/s mradps mrad.s-1 mrads-1",
    "deg/h": "deg/h deg.h-1 degh-1 °h-1",
    "m/s^2": (
        "m/s2 m.s-2 ms-2 m/ss m/s.s m/s/s mps2 mpss m_s2 m/sec2 m.sec-2 msec-2 m/s-2 meterspersecondsquared"
        " meterpersecondsquared metrespersecondsquared metrepersecondsquared meters/second2"
    ),
    "cm/s^2": "cm/s2 cm.s-2 cms-2",
    "mm/s^2": "mm/s2 mm.s-2 mms-2",
    "g": "gee gees gforce g-force gravities g's",
    "mg": "milligee milligees millig milligs milli-g milli-gs mgee mgees",
    "ug": "microgee microgees microg micro-g",
    "s": "sec. secs. seconds.",
    "ms": "msecs millis millisec millisecs",
    "us": "usecs micros microsec microsecs",
    "ns": "nsecs nanos nanosec nanosecs",
}
_COMPACTED = str.maketrans("·⋅∙×*⁻¹²³−", "....." + "-123-", "^ˆ˄(){} ")

COUNTS = frozenset(
    {"lsb", "lsbs", "count", "counts", "cts", "digit", "digits", "raw", "adc", "adu", "bit", "bits", "step", "steps"}
    | {"nounits", "no_units", "unitless"}
)
"""Spellings of the counts of a converter, and of no unit: they need a scale."""

VOLTS = frozenset({"v", "mv", "uv", "volt", "volts", "millivolts"})
"""Spellings of voltages: they need a scale."""

_BY_SPELLING = {symbol.lower(): unit for symbol, unit in _UNITS.items()}
_BY_COMPACT = {spelling: _UNITS[symbol] for symbol, line in _SPELLINGS.items() for spelling in line.split()}


def _compact(spelling: str) -> str:
    """A spelling without powers, brackets and blanks: ``m/(s^2)`` as ``m/s2``."""
    return spelling.strip().lower().replace("µ", "u").replace("**", "").translate(_COMPACTED)


def _normalise(spelling: str) -> str:
    text = " ".join(spelling.lower().split())  # the patterns would take seconds on long runs of blanks
    for pattern, replacement in _WORDS:
        text = re.sub(pattern, replacement, text)
    return text.replace(" ", "")


def symbols(si: str | None = None) -> tuple[str, ...]:
    """Symbols of the table; of one kind if its SI unit is given."""
    return tuple(symbol for symbol, unit in _UNITS.items() if si is None or unit.si == si)


def figure_unit(quantity: str, unit: str) -> str | None:
    """The unit of `FIGURE_UNITS` in which figures draw a rate; None for other quantities, and for integrals of rates."""
    names = FIGURE_UNITS.get(quantity)
    return names[0] if names and find(names[0]).si == unit else None


def density_text(text: str) -> str:
    """How a density is written whose root has the unit `text` times 1/√Hz.

    Examples
    --------
    >>> density_text("deg/h"), density_text("µg"), density_text("V"), density_text("1")
    ('(deg/h)²/Hz', '(µg)²/Hz', 'V²/Hz', '1/Hz')
    """
    if text == "1":
        return "1/Hz"
    return f"{text}²/Hz" if len(text) == 1 else f"({text})²/Hz"


def usual(si: str) -> str:
    """The unit that datasheets use for the SI unit `si`.

    Examples
    --------
    >>> usual("rad/sqrt(s)")
    'deg/sqrt(h)'
    """
    return _USUAL.get(si, si)


def find_unit(spelling: str) -> Unit | None:
    """The unit that a spelling means; None if it is unknown."""
    # A symbol of the table means itself; the patterns of the words take longer to compile than the head of a log to read.
    unit = _BY_SPELLING.get(spelling.strip().lower()) or _BY_SPELLING.get(_normalise(spelling))
    return unit or _BY_COMPACT.get(_compact(spelling))


def needs_scale(spelling: str) -> bool:
    """Whether a spelling means counts or volts, which need a scale.

    Examples
    --------
    >>> needs_scale("LSB"), needs_scale("m/s^2"), needs_scale("furlongs")
    (True, False, False)
    """
    return _compact(spelling) in COUNTS | VOLTS


def find(spelling: str, *, si: str | tuple[str, ...] | None = None) -> Unit:
    """The unit that a spelling means.

    Parameters
    ----------
    spelling : str
        ``"deg/s"``, ``"°/s"``, ``"rad s^-1"``, ``"m/s²"``, ``"deg/√h"``, ``"ug/sqrt(Hz)"`` …; case does not matter.
    si : str or tuple of str, optional
        Kinds that are allowed, by their SI unit.

    Raises
    ------
    OptionError
        If the unit is unknown, or of another kind.

    See Also
    --------
    to_si : converts a value.

    Examples
    --------
    >>> find("°/√h").symbol
    'deg/sqrt(h)'
    """
    unit = find_unit(spelling)
    kinds = (si,) if isinstance(si, str) else si
    if unit is not None and (not kinds or unit.si in kinds):
        return unit
    choices = ", ".join(symbol for kind in kinds for symbol in symbols(kind)) if kinds else ", ".join(symbols())
    if unit is None:
        raise OptionError(f"unknown unit {spelling!r}; known units: {choices}", option="unit")
    raise OptionError(f"the unit {spelling!r} does not fit here; units that do: {choices}", option="unit")


def to_si(value: float, unit: str) -> float:
    """A value in SI.

    Parameters
    ----------
    value : float
        The number. [`unit`]
    unit : str
        A spelling that `find` knows, such as ``"deg/s"``.

    Returns
    -------
    float
        [SI]

    Raises
    ------
    OptionError
        For an unknown unit.

    See Also
    --------
    find : the unit that a spelling means.

    Examples
    --------
    >>> to_si(180.0, "deg/s")
    3.141592653589793
    """
    return value * find(unit).factor


def integral(si: str) -> str:
    """SI unit of the integral over time of a quantity in the SI unit `si`: rad/s gives rad, m/s² gives m/s.

    Examples
    --------
    >>> integral("m/s^2")
    'm/s'
    """
    return _INTEGRAL[si]
