"""The facts of a certificate, ``lab.toml``: its keys, and what is refused.

The keys follow ISO/IEC 17025:2017, 7.8.2 to 7.8.4. A file that lacks one is refused, so that no incomplete page is signed.
"""

from __future__ import annotations

import difflib
import itertools
import os
import tomllib
from collections.abc import Mapping
from dataclasses import field, replace
from datetime import date, datetime
from pathlib import Path
from typing import Any, Literal

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.reporting.logo import Logo, read_logo, why_unreadable
from sigmatau.results import printable

_LARGEST = 1 << 16  # of the file [bytes]
_LONGEST = 600  # of a text [characters]
_LARGEST_FACTOR = 1e6  # from a typical value to a maximum [1]
CALIBRATION, TEST = "calibration certificate", "test report"
"""Kinds of a report."""


@frozen
class Field:
    """A key of the file.

    Attributes
    ----------
    label : str
        What the page calls it.
    required : bool
    kind : {"text", "date", "number"}
    choices : tuple of str
        Allowed texts; all if empty.
    """

    label: str
    required: bool = False
    kind: Literal["text", "date", "number"] = "text"
    choices: tuple[str, ...] = ()


FIELDS: Mapping[str, Mapping[str, Field]] = {
    "laboratory": {
        "name": Field(label="Laboratory", required=True),
        "address": Field(label="Address", required=True),
        "accreditation": Field(label="Accreditation"),
        "logo": Field(label="Logo"),
    },
    "customer": {
        "name": Field(label="Customer", required=True),
        "address": Field(label="Address", required=True),
    },
    "instrument": {
        "description": Field(label="Instrument", required=True),
        "manufacturer": Field(label="Manufacturer", required=True),
        "model": Field(label="Model", required=True),
        "serial": Field(label="Serial number", required=True),
        "condition": Field(label="Condition", required=True),
        "received": Field(label="Received", kind="date"),
    },
    "measurement": {
        "date": Field(label="Measured", kind="date"),
        "place": Field(label="Place", required=True),
        "temperature": Field(label="Temperature"),
        "humidity": Field(label="Humidity"),
        "pressure": Field(label="Pressure"),
        "supply": Field(label="Supply"),
        "mounting": Field(label="Mounting"),
    },
    "method": {
        "standard": Field(label="Standard", required=True),
        "description": Field(label="Procedure"),
        "deviations": Field(label="Deviations", required=True),
        "traceability": Field(label="Traceability"),
        "not_included": Field(label="Not included"),
    },
    "report": {
        "number": Field(label="Number", required=True),
        "kind": Field(label="Kind", choices=(TEST, CALIBRATION)),
        "issued": Field(label="Issued", kind="date"),
        "operator": Field(label="Measured by", required=True),
        "reviewer": Field(label="Reviewed by", required=True),
        "remarks": Field(label="Remarks"),
    },
    "decision": {
        "rule": Field(label="Rule", required=True),
        "specification": Field(label="Specification", required=True),
        "sided": Field(label="Convention of densities", choices=("one", "two")),
        "bias": Field(label="Convention of bias instabilities", choices=("minimum", "coefficient")),
        "factor": Field(label="Factor", kind="number"),
    },
}
"""All keys of the file by table. The table ``decision`` may be absent; if it is there, its required keys are needed."""

_UNIT_KEY = "instrument.serial"  # the key that a lot fills
_OPTIONAL_TABLES = ("decision",)
_DAY = len("2026-05-04")  # characters of the day of a date


@frozen
class CertificateFile:
    """The content of ``lab.toml``.

    Attributes
    ----------
    path : Path
    texts : mapping of str to mapping of str to str
        Texts by table and key; dates as in ISO 8601.
    factor : float or None
        Factor of the decision from typical to maximum values.
    logo : Logo or None
    """

    path: Path
    texts: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    factor: float | None = None
    logo: Logo | None = None

    def text(self, table: str, name: str) -> str:
        """The text of a key; empty if it is absent.

        Parameters
        ----------
        table : str
            Table of the file.
        name : str
            Key of the table.

        Returns
        -------
        str
        """
        return self.texts.get(table, {}).get(name, "")

    def of_unit(self, unit: str) -> CertificateFile:
        """The file for a unit of a lot: its serial number, and the number of its report.

        Parameters
        ----------
        unit : str
            Serial number.

        Returns
        -------
        CertificateFile
        """
        serial = printable(unit)
        added = {"instrument": {"serial": serial}, "report": {"number": f"{self.text('report', 'number')}-{serial}"}}
        texts = {table: {**names, **added.get(table, {})} for table, names in self.texts.items()}
        return replace(self, texts=texts)

    @property
    def specification(self) -> Path:
        """The place of the specification, if it is a file and not a name of the library."""
        return self.path.parent / self.text("decision", "specification")

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that are read: this one, its logo and its specification."""
        logo = self.text("laboratory", "logo")
        files = [self.path, *([self.path.parent / logo] if logo else [])]
        if os.path.isfile(self.specification):  # noqa: PTH113  False for a name that is too long
            files.append(self.specification)
        return tuple(files)


def read_certificate(path: str | Path, *, each_unit: bool = False) -> CertificateFile:
    """Read ``lab.toml``.

    Parameters
    ----------
    path : str or Path
    each_unit : bool
        Whether it is for all units of a lot, which have their own serial numbers, see `CertificateFile.of_unit`.

    Returns
    -------
    CertificateFile

    Raises
    ------
    DataError
        If the file or its logo cannot be read, lacks a required key, has an unknown key, or a value of another type.
    """
    file = Path(path)
    content = _content(file)
    problems = [*_unknown(content), *_missing(content, except_for=_UNIT_KEY if each_unit else "")]
    if problems:
        raise DataError("; ".join(problems)).about(str(file))
    if each_unit and "serial" in content["instrument"]:
        raise DataError(f"{_UNIT_KEY} of a lot is the name of each unit; leave it out").about(str(file))
    texts = {
        table: {name: _text(table, name, value, file) for name, value in values.items() if name != "factor"}
        for table, values in content.items()
    }
    try:
        _check_order(texts)
    except DataError as error:
        raise error.about(str(file)) from None
    kind = texts["report"].get("kind", TEST)
    if kind.lower() == CALIBRATION and not texts["method"].get("traceability"):
        raise DataError("lacks method.traceability; a calibration certificate states it").about(str(file))
    logo = texts["laboratory"].get("logo")
    factor = content.get("decision", {}).get("factor")
    if factor is not None and (
        isinstance(factor, bool) or not isinstance(factor, int | float) or not 1 <= factor <= _LARGEST_FACTOR
    ):
        raise DataError(f"decision.factor {factor!r:.40} must be a number from 1 to {_LARGEST_FACTOR:g}").about(
            str(file)
        )
    return CertificateFile(
        path=file,
        texts=texts,
        factor=None if factor is None else float(factor),
        logo=None if not logo else read_logo(file.parent / logo),
    )


def _content(file: Path) -> dict[str, Any]:
    try:
        with file.open("rb") as stream:
            raw = stream.read(_LARGEST + 1)
    except OSError as error:
        raise DataError(f"{why_unreadable(error)}; docs/how-to/certificate.md has an example").about(
            str(file)
        ) from None
    if len(raw) > _LARGEST:
        raise DataError(f"more than {_LARGEST >> 10} KiB; this is no certificate file").about(str(file))
    try:
        content = tomllib.loads(raw.decode("utf-8-sig"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise DataError(f"not TOML: {error}; docs/how-to/certificate.md has an example").about(str(file)) from None
    for name, table in content.items():
        if name in FIELDS and not isinstance(table, dict):
            raise DataError(f"{name} must be a table, [{name}]; docs/how-to/certificate.md has an example").about(
                str(file)
            )
    return content


def _unknown(content: Mapping[str, Any]) -> list[str]:
    """Name the unknown keys, with the most similar known one."""
    every = [f"{table}.{name}" for table, names in FIELDS.items() for name in names]
    unknown = [name for name in content if name not in FIELDS]
    unknown += [
        f"{table}.{name}" for table, values in content.items() if table in FIELDS
        for name in values if name not in FIELDS[table]
    ]  # fmt: skip
    words = []
    for name in unknown:
        similar = difflib.get_close_matches(name, [*every, *FIELDS], n=1)
        words.append(printable(name) + (f" (meant: {similar[0]}?)" if similar else ""))
    return [f"unknown key {', '.join(words)}"] if words else []


def _missing(content: Mapping[str, Any], *, except_for: str) -> list[str]:
    missing = [
        f"{table}.{name}"
        for table, names in FIELDS.items()
        if table in content or table not in _OPTIONAL_TABLES
        for name, about in names.items()
        if about.required and _is_blank(content.get(table, {}).get(name)) and f"{table}.{name}" != except_for
    ]
    return [f"lacks {', '.join(missing)}"] if missing else []


def _is_blank(value: object) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def _check_order(texts: Mapping[str, Mapping[str, str]]) -> None:
    """Raise `DataError` unless the instrument was received, measured and the report issued in this order."""
    dates = [
        (f"{table}.{name}", texts.get(table, {}).get(name, "")[:_DAY])
        for table, name in (("instrument", "received"), ("measurement", "date"), ("report", "issued"))
    ]
    stated = [(name, day) for name, day in dates if day]
    for (earlier, first), (later, second) in itertools.pairwise(stated):
        if second < first:
            raise DataError(f"{later}, {second}, is before {earlier}, {first}. Correct one of them")


def _text(table: str, name: str, value: object, file: Path) -> str:
    about = FIELDS[table][name]
    if about.kind == "date":
        if isinstance(value, datetime):
            return f"{value:%Y-%m-%d %H:%M}"
        if isinstance(value, date):
            return f"{value:%Y-%m-%d}"
        raise DataError(f"{table}.{name} {value!r:.40} must be a date, {name} = 2026-05-07").about(str(file))
    if not isinstance(value, str) or len(value) > _LONGEST:
        raise DataError(f"{table}.{name} must be a text in quotes, at most {_LONGEST} characters").about(str(file))
    text = printable(value.strip().replace("\n", ", "))
    if about.choices and text.lower() not in about.choices:
        listed = " or ".join(map(repr, about.choices))
        raise DataError(f"{table}.{name} {text!r:.40} must be {listed}").about(str(file))
    return text
