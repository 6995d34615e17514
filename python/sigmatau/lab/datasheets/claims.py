"""Datasheet files, and `Claim`: a number of a datasheet and its possible meanings.

A density may be one-sided (√2 times N) or two-sided (N); an "in-run bias stability" may be the minimum of the Allan
deviation or the coefficient B, 1/0.664 of a plateau. A number whose convention is not stated has two meanings, and the
status is decided only if both meanings lead to the same one.

A file is TOML in which each value has a unit and a stated convention.

.. code-block:: toml

    name = "ISM330DHCX"
    maker = "STMicroelectronics"
    kind = "MEMS, industrial"
    source = "DS13012 revision 6, table 2"
    confirmed = "https://…, page 9"            # where the values were looked up

    [gyro]
    axes = ["x", "y", "z"]                                                # axes of a unit; default: all three
    noise_density = { typical = "5 mdeg/s/sqrt(Hz)", sided = "one" }      # or "two", or "unknown"
    random_walk = { typical = "0.21 deg/sqrt(h)" }
    bias_instability = { typical = "3 deg/h", as = "minimum" }            # or "coefficient", or "unknown"
    bias_stability = { maximum = "0.05 deg/h", average = "10 s" }         # STD of 10 s means, or of "100 s" ones
    rate_random_walk = { one_sigma = "4 deg/h/sqrt(h)" }                  # stated as 1 σ in place of typical
    full_scale = ["125 deg/s", "2000 deg/s"]                              # several values, or a range
    bandwidth = ["300 Hz"]
    output_rate = ["12.5 Hz to 6.66 kHz"]
    beside_noise = ["zero-rate level 1 deg/s"]                            # not visible in a record at rest

    [accel_z]                                                             # one axis, replaces [accel]
    noise_density = { typical = "60 ug/sqrt(Hz)", maximum = "100 ug/sqrt(Hz)", sided = "one" }
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from sigmatau.errors import DataError, OptionError
from sigmatau.fitting import AVERAGES
from sigmatau.frozen import frozen
from sigmatau.model import LARGEST, SMALLEST, value_in_si
from sigmatau.noise.terms import RANKED, TERMS, coefficient_unit, display_units
from sigmatau.results import plain
from sigmatau.units import find

Sided = Literal["one", "two"]
Bias = Literal["minimum", "coefficient"]

MINIMUM = "minimum"  # value of `Meaning.of` for the minimum of the Allan deviation; other values are terms
MEANS = "bias_stability"
KEYS = {"noise_density": "random_walk", **{term: term for term in RANKED}, MEANS: MEANS}
"""Keys of a datasheet and their terms. A bias stability, the standard deviation of means, depends on all terms."""

QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}  # Quantity and SI unit by sensor


_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*")


@frozen
class Meaning:
    """An interpretation of a claim.

    Attributes
    ----------
    of : str
        The quantity of the result to compare with: a term, or ``"minimum"`` of the Allan deviation.
    factor : float
        Factor on the number of the datasheet before the comparison.
    words : str
        ``"one-sided"``; empty if there is only one interpretation.
    """

    of: str
    factor: float
    words: str


_ONE_SIDED = Meaning(of="random_walk", factor=math.sqrt(0.5), words="one-sided")
_TWO_SIDED = Meaning(of="random_walk", factor=1.0, words="two-sided")
_MINIMUM = Meaning(of=MINIMUM, factor=1.0, words="Allan minimum")
_COEFFICIENT = Meaning(of="bias_instability", factor=1.0, words="coefficient B")
_STD = Meaning(of=MEANS, factor=1.0, words="")

_MEANINGS = {
    "noise_density": {"one": (_ONE_SIDED,), "two": (_TWO_SIDED,), "unknown": (_ONE_SIDED, _TWO_SIDED)},
    "bias_instability": {"minimum": (_MINIMUM,), "coefficient": (_COEFFICIENT,), "unknown": (_MINIMUM, _COEFFICIENT)},
}


def check_meanings(sided: str | None, bias: str | None) -> None:
    """Raise `OptionError` for an invalid convention."""
    if sided not in (None, "one", "two"):
        raise OptionError(f"{{option}} must be 'one' or 'two', not {sided!r}", option="sided")
    if bias not in (None, "minimum", "coefficient"):
        raise OptionError(f"{{option}} must be 'minimum' or 'coefficient', not {bias!r}", option="bias")


@frozen
class Claim:
    """Specification of one term of one sensor.

    Attributes
    ----------
    sensor : str
        ``"gyro"``, ``"accel"``, or one axis, ``"accel_z"``.
    key : str
        A key of the datasheet file, such as ``"noise_density"``.
    typical, maximum : float or None
        Numbers of the datasheet; at least one of them. [unit, SI]
    typical_text, maximum_text : str
        These numbers in the unit of the datasheet.
    convention : str
        For a noise density ``"one"``, ``"two"`` (sided) or ``"unknown"``; for a bias instability ``"minimum"`` (of the
        Allan deviation), ``"coefficient"`` (B) or ``"unknown"``; otherwise empty.
    note : str
        Conditions, or the reason for the convention.
    one_sigma : bool
        Whether the datasheet states `typical` as a 1 σ value.
    average : float or None
        Averaging time of a bias stability. [s]
    """

    sensor: str
    key: str
    typical: float | None = None
    maximum: float | None = None
    typical_text: str = ""
    maximum_text: str = ""
    convention: str = ""
    note: str = ""
    one_sigma: bool = False
    average: float | None = None

    @property
    def term(self) -> str:
        """Key of the term in `sigmatau.noise.terms.TERMS`."""
        return KEYS[self.key]

    @property
    def quantity(self) -> str:
        """``"angular_rate"`` or ``"acceleration"``."""
        return QUANTITIES[self.sensor.partition("_")[0]][0]

    @property
    def unit(self) -> str:
        """SI unit of `typical` and `maximum`."""
        return coefficient_unit(_unit_term(self.key), *QUANTITIES[self.sensor.partition("_")[0]])

    @property
    def usual(self) -> str:
        """Name of `typical` in the datasheet: ``"typical"`` or ``"1 σ"``."""
        return "1 σ" if self.one_sigma else "typical"

    @property
    def label(self) -> str:
        """Name of the claim: ``"noise density"``, ``"angle random walk"``, ``"STD of 10 s means"``."""
        if self.average is not None:
            return f"STD of {self.average:g} s means"
        return "noise density" if self.key == "noise_density" else TERMS[self.term].label(self.quantity)

    def display(self) -> tuple[str, float]:
        """Display unit (that of the typical value if the datasheet has one), and its factor to SI."""
        text = self.typical_text or self.maximum_text
        if text:
            unit = find(_NUMBER.sub("", text, count=1))
            return unit.text, unit.factor
        # A claim built in Python has no texts. Accelerometer biases are in µg, as in most datasheets.
        units = display_units(_unit_term(self.key), self.quantity, QUANTITIES[self.sensor.partition("_")[0]][1])
        return units[-1] if _unit_term(self.key) == "bias_instability" else units[0]

    def meanings(self, *, sided: Sided | None = None, bias: Bias | None = None) -> tuple[Meaning, ...]:
        """The interpretations; two if neither the datasheet nor `sided` or `bias` states the convention.

        Parameters
        ----------
        sided : {"one", "two"}, optional
            Convention of a noise density if the datasheet does not state it.
        bias : {"minimum", "coefficient"}, optional
            Convention of a bias instability if the datasheet does not state it.

        Returns
        -------
        tuple of Meaning
        """
        if self.key == MEANS:
            return (_STD,)
        if self.key not in _MEANINGS:
            return (Meaning(of=self.term, factor=1.0, words=""),)
        chosen = sided if self.key == "noise_density" else bias
        convention = chosen if self.convention == "unknown" and chosen is not None else self.convention
        return _MEANINGS[self.key][convention]

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        numbers = [name for name in ("typical", "maximum") if getattr(self, name) is not None]
        texts = [name for name in ("convention", "note", "one_sigma") if getattr(self, name)]
        return plain(self, "sensor key term unit", *numbers, *texts, *(["average_s=average"] if self.average else []))


def _unit_term(key: str) -> str:
    """Term whose unit the values of a key have."""
    return "bias_instability" if key == MEANS else KEYS[key]


AXES = ("x", "y", "z")

TEXTS = ("name", "maker", "kind", "source", "confirmed", "note")
SENSORS = (*QUANTITIES, *(f"{sensor}_{axis}" for sensor in QUANTITIES for axis in AXES))

_NEEDED = ("name", "maker", "source")
_LONGEST_TEXT = 400  # largest text [characters]
_LARGEST_FILE = 1 << 20  # largest file; a datasheet has a few hundred bytes [bytes]
_CONVENTIONS = {
    "noise_density": ("sided", ("one", "two", "unknown"), "a one-sided density is √2 times the two-sided one"),
    "bias_instability": (
        "as",
        ("minimum", "coefficient", "unknown"),
        "the minimum of the Allan deviation is 0.664 times the coefficient B",
    ),
}
_LISTS = ("full_scale", "bandwidth", "output_rate", "beside_noise")


def parsed(path: Path) -> dict[str, Any]:
    """Parse the TOML of a file. Raises `DataError` with the name of the file."""
    try:
        with path.open("rb") as file:
            raw = file.read(_LARGEST_FILE + 1)
        if len(raw) > _LARGEST_FILE:
            raise DataError(f"{path}: not a datasheet: more than {_LARGEST_FILE >> 20} MiB")
        return tomllib.loads(raw.decode("utf-8-sig"))
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}") from None
    except DataError:
        raise
    except (ValueError, RecursionError) as error:
        raise DataError(f"{path}: not a TOML file: {error}") from None


def parse_texts(content: Mapping[str, Any]) -> dict[str, str]:
    """Parse the text fields: name, maker, source and others. Raises `DataError` for an unknown or a missing key."""
    unknown = next((key for key in content if key not in TEXTS and key not in SENSORS), None)
    if unknown is not None:
        raise DataError(f"unknown key {unknown!r}; a datasheet has {', '.join(TEXTS)} and [{'], ['.join(SENSORS)}]")
    missing = [key for key in _NEEDED if key not in content]
    if missing:
        example = ", ".join(f'{key} = "…"' for key in missing)
        raise DataError(f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; write e.g. {example}")
    return {key: _text(content[key], key) for key in TEXTS if key in content}


def parse_claims(content: Mapping[str, Any]) -> tuple[Claim, ...]:
    """Parse the noise specifications. Raises `DataError` with sensor and key."""
    claims = []
    for sensor in SENSORS:
        for key in KEYS:
            table = _table(content, sensor).get(key)
            # Bias stabilities at several averaging times form a list.
            tables = table if key == MEANS and isinstance(table, list) else [] if table is None else [table]
            sensor_claims = [_claim(sensor, key, table_) for table_ in tables]
            if len({claim.average for claim in sensor_claims}) < len(sensor_claims):
                raise DataError(f"{sensor}: {key}: two tables have the same average; write one")
            claims += sensor_claims
    return tuple(claims)


def parse_data(content: Mapping[str, Any]) -> dict[str, dict[str, tuple[str, ...]]]:
    """Parse other specifications by sensor, as text: full scale, bandwidth, output rates, biases."""
    data: dict[str, dict[str, tuple[str, ...]]] = {}
    for sensor in SENSORS:
        table = _table(content, sensor)
        allowed = (*KEYS, *_LISTS, *(("axes",) if sensor in QUANTITIES else ()))
        unknown = next((key for key in table if key not in allowed), None)
        if unknown is not None:
            raise DataError(f"{sensor}: unknown key {unknown!r}; keys: {', '.join(allowed)}")
        for key in _LISTS:
            if key in table:
                data.setdefault(sensor, {})[key] = _listed(sensor, key, table[key])
    return data


def parse_axes(content: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Parse the axes of a unit by sensor, if the file states them."""
    axes_by_sensor = {}
    for sensor in QUANTITIES:
        axes = _table(content, sensor).get("axes")
        if axes is None:
            continue
        if not isinstance(axes, list) or not axes or any(axis not in AXES for axis in axes) or len({*axes}) < len(axes):
            raise DataError(f'{sensor}: axes = {axes!r}; list the axes of a unit, axes = ["x", "y", "z"]')
        contradiction = next((axis for axis in AXES if axis not in axes and f"{sensor}_{axis}" in content), None)
        if contradiction is not None:
            raise DataError(f"{sensor}: axes = {axes!r} contradicts [{sensor}_{contradiction}]")
        axes_by_sensor[sensor] = tuple(axis for axis in AXES if axis in axes)
    return axes_by_sensor


def _table(content: Mapping[str, Any], sensor: str) -> Mapping[str, Any]:
    table = content.get(sensor, {})
    if not isinstance(table, Mapping):
        raise DataError(f"{sensor} = {table!r}; write a table, [{sensor}]")
    return table


def _claim(sensor: str, key: str, table: object) -> Claim:
    no_convention: tuple[str, tuple[str, ...], str] = ("", (), "")
    convention_key, choices, why = _CONVENTIONS.get(key, no_convention)
    third = ', average = "10 s"' if key == MEANS else f', {convention_key} = "{choices[0]}"' if convention_key else ""
    example = f'{key} = {{ typical = "…", maximum = "…"{third} }}'
    if not isinstance(table, Mapping):
        raise DataError(f"{sensor}: {key} = {table!r}; write e.g. {example}")
    allowed = ("typical", "one_sigma", "maximum", "note", convention_key, *(("average",) if key == MEANS else ()))
    unknown = next((k for k in table if k not in allowed), None)
    if unknown is not None:
        raise DataError(f"{sensor}: {key}: unknown key {unknown!r}; write e.g. {example}")
    if "typical" in table and "one_sigma" in table:
        raise DataError(f"{sensor}: {key} has typical and one_sigma; keep one of them, and maximum")
    usual = "one_sigma" if "one_sigma" in table else "typical"
    if usual not in table and "maximum" not in table:
        raise DataError(f"{sensor}: {key} has neither typical nor maximum; write e.g. {example}")
    convention = ""
    if convention_key:
        convention = table.get(convention_key, "")
        if convention not in choices:
            listed = ", ".join(f'{convention_key} = "{choice}"' for choice in choices)
            got = f"; got {table[convention_key]!r}" if convention_key in table else ""
            raise DataError(f"{sensor}: {key} needs one of {listed}, because {why}{got}; write e.g. {example}")
    si = coefficient_unit(_unit_term(key), *QUANTITIES[sensor.partition("_")[0]])
    values = {k: _value(sensor, key, k, table[k], si) for k in (usual, "maximum") if k in table}
    if len(values) > 1 and values[usual] > values["maximum"]:
        raise DataError(f"{sensor}: {key}: {usual} {table[usual]} is above maximum {table['maximum']}")
    return Claim(
        sensor=sensor,
        key=key,
        typical=values.get(usual),
        maximum=values.get("maximum"),
        typical_text=table.get(usual, ""),
        maximum_text=table.get("maximum", ""),
        convention=convention,
        note=_text(table.get("note", ""), f"{sensor}: note of {key}", empty=True),
        one_sigma=usual == "one_sigma",
        average=_average(sensor, table.get("average")) if key == MEANS else None,
    )


def _average(sensor: str, text: object) -> float:
    """The averaging time of a bias stability."""
    choices = " or ".join(f'average = "{average:g} s"' for average in AVERAGES)
    if text is None:
        raise DataError(f"{sensor}: {MEANS} needs {choices}: the standard deviation of means depends on it")
    value = _value(sensor, MEANS, "average", text, "s")
    matching = next((average for average in AVERAGES if math.isclose(value, average, rel_tol=1e-6)), None)
    if matching is None:
        raise DataError(f"{sensor}: {MEANS}: average = {text!r}; an analysis has {choices}")
    return matching


def _value(sensor: str, key: str, which: str, text: object, si: str) -> float:
    what = f"{sensor}: {which} of {key}"
    try:
        value = value_in_si(_text(text, what), si, what)
    except OptionError as error:
        raise DataError(str(error)) from None
    if not (math.isfinite(value) and value > 0):
        raise DataError(f"{what} must be positive, not {text}")
    if not SMALLEST <= value <= LARGEST:
        raise DataError(f"{what} must be from {SMALLEST:g} to {LARGEST:g} in SI, not {text}")
    return value


def _listed(sensor: str, key: str, values: object) -> tuple[str, ...]:
    if not isinstance(values, list) or not values:
        raise DataError(f'{sensor}: {key} = {values!r}; write a list, {key} = ["…"]')
    texts = tuple(_text(value, f"{sensor}: {key}") for value in values)
    if key != "beside_noise":
        si = QUANTITIES[sensor.partition("_")[0]][1] if key == "full_scale" else "Hz"
        for text in texts:
            ends = [_value(sensor, key, "value", part, si) for part in text.split(" to ")]
            if len(ends) > 2 or ends != sorted(ends):
                raise DataError(f"{sensor}: {key}: {text!r} is not a range; write e.g. 1 Hz to 2 Hz")
    return texts


def _text(value: object, what: str, *, empty: bool = False) -> str:
    """Check that a text is one printable line, for terminals and files."""
    if not isinstance(value, str):
        raise DataError(f'{what} = {value!r} is not text; write it in quotes, "…"')
    if not value and empty:
        return value
    if not value.strip() or not value.isprintable() or len(value) > _LONGEST_TEXT:
        raise DataError(f"{what} must be one line of up to {_LONGEST_TEXT} printable characters, not {value[:60]!r}")
    return value
