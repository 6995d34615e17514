"""`Datasheet`: specifications of a sensor, from a file or from the library of public values."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from dataclasses import field
from importlib import resources
from pathlib import Path
from typing import Any, Literal, Self

from sigmatau import NoiseModel
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.lab.datasheets import claims
from sigmatau.lab.datasheets.claims import MEANS, MINIMUM, Bias, Claim, Sided, check_meanings
from sigmatau.noise.terms import BIAS_LEVEL
from sigmatau.record import stream_name
from sigmatau.results import Printed

_WORDS = {"one": "one-sided", "two": "two-sided", "minimum": "Allan minimum", "coefficient": "coefficient B"}
_LONGEST_NAME = 100  # longest name for which a file is suggested [characters]
_NOT_STATED = {
    "noise_density": "one- or two-sided: not stated",
    "bias_instability": "Allan minimum or coefficient B: not stated",
}


@frozen(eq=False)
class Datasheet(Printed):
    """Specifications of a sensor.

    Attributes
    ----------
    name, maker, kind : str
        Name, maker and kind of the sensor; the kind may be empty.
    source : str
        Document, revision, page or table.
    confirmed : str
        Place where the numbers were confirmed; may be empty.
    note : str
    claims : tuple of Claim
        Noise specifications.
    data : mapping of str to mapping of str to tuple of str
        Other specifications by sensor: full scale, bandwidth, output rates, and properties not visible at rest.
    axes : mapping of str to tuple of str
        Axes of a unit by sensor; x, y and z if not stated.

    See Also
    --------
    datasheet : reads a datasheet of the library, or from a file.
    compare_with : compares a result with a datasheet.

    Examples
    --------
    >>> import sigmatau as st
    >>> sheet = st.datasheet("icm42688p")
    >>> sheet.headline()
    'ICM-42688-P (TDK InvenSense), MEMS, consumer'
    >>> round(sheet.model(sided="one", bias="minimum")["gyro_x"]["random_walk"], 7)
    3.46e-05
    """

    name: str
    maker: str
    kind: str = ""
    source: str
    confirmed: str = ""
    note: str = ""
    claims: tuple[Claim, ...]
    data: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    axes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read the datasheet of a TOML file; see docs/how-to/datasheets.md.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Datasheet

        Raises
        ------
        DataError
            If the file cannot be read; the error names file, sensor, key and value.
        """
        content = claims.parsed(Path(path))
        try:
            return cls.from_dict(content)
        except DataError as error:
            raise DataError(f"{path}: {error}") from None

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """Build the datasheet of a parsed file.

        Parameters
        ----------
        content : mapping
            Content of a TOML file as in docs/how-to/datasheets.md.

        Returns
        -------
        Datasheet

        Raises
        ------
        DataError
            For an unknown key or a wrong value; the error names sensor and key.
        """
        texts = claims.parse_texts(content)
        data, axes = claims.parse_data(content), claims.parse_axes(content)
        return cls(**texts, data=data, axes=axes, claims=claims.parse_claims(content))

    def of(self, channel: str) -> tuple[Claim, ...]:
        """The claims for a channel: those for its axis if there are any, otherwise those for its sensor.

        Parameters
        ----------
        channel : str
            Name of the channel, such as ``"gyro_x"``.

        Returns
        -------
        tuple of Claim
        """
        sensor = stream_name(channel)
        axis = f"{sensor}_{channel.rpartition('_')[2]}"
        axis_claims = {(claim.key, claim.average): claim for claim in self.claims if claim.sensor == axis}
        common = {(claim.key, claim.average): claim for claim in self.claims if claim.sensor == sensor}
        return tuple({**common, **axis_claims}.values())

    def channels(self, sensor: str) -> tuple[str, ...]:
        """The channels of a sensor with claims: ``("gyro_x", …)``.

        Parameters
        ----------
        sensor : {"gyro", "accel"}
            Kind of the sensor.

        Returns
        -------
        tuple of str
        """
        names = (f"{sensor}_{axis}" for axis in self.axes.get(sensor, claims.AXES))
        return tuple(name for name in names if self.of(name))

    def model(
        self, *, use: Literal["typical", "maximum"] = "typical", sided: Sided | None = None, bias: Bias | None = None
    ) -> NoiseModel:
        """A noise model with the numbers of the datasheet for each axis of a unit, for `simulate` and `plan`.

        A random walk takes precedence over a noise density. The minimum of an Allan deviation is divided by 0.664 to
        give the bias instability; this is an upper bound, because other terms add to the minimum. A bias stability, the
        standard deviation of means, depends on all terms and is omitted.

        Parameters
        ----------
        use : {"typical", "maximum"}
            Which of the numbers to use; if the datasheet has only one, it is used.
        sided : {"one", "two"}, optional
            Convention of noise densities if not stated.
        bias : {"minimum", "coefficient"}, optional
            Convention of bias instabilities if not stated.

        Returns
        -------
        NoiseModel

        Raises
        ------
        OptionError
            If a convention is stated neither in the datasheet nor by `sided` or `bias`.
        DataError
            If the datasheet has no noise specification.
        """
        check_meanings(sided, bias)
        if use not in ("typical", "maximum"):
            raise OptionError(f"{{option}} must be 'typical' or 'maximum', not {use!r}", option="use")
        channels = {
            channel: {claim.term: self._number(claim, use, sided, bias) for claim in chosen}
            for channel in self._channels_with_claims()
            if (chosen := _chosen(self.of(channel)))
        }
        if not channels:
            raise DataError(f"{self.name}: the datasheet has no noise specification")
        return NoiseModel(channels=channels)

    def origins(
        self, *, use: Literal["typical", "maximum"] = "typical", sided: Sided | None = None, bias: Bias | None = None
    ) -> tuple[str, ...]:
        """Origin of each number of `model`, one line per number: typical or maximum value, and its convention.

        Parameters
        ----------
        use, sided, bias
            As in `Datasheet.model`.

        Returns
        -------
        tuple of str
        """
        lines = []
        for claim in dict.fromkeys(
            claim for channel in self._channels_with_claims() for claim in _chosen(self.of(channel))
        ):
            used = _used(claim, use)
            text = claim.typical_text if used == "typical" else claim.maximum_text
            words = [meaning.words for meaning in claim.meanings(sided=sided, bias=bias) if meaning.words]
            convention = f"{'taken as ' if claim.convention == 'unknown' else ''}{' or '.join(words)}" if words else ""
            substitution = "" if used == use else f"the datasheet has no {use} value"
            kind = claim.usual if used == "typical" else used
            lines.append(
                f"{claim.sensor} {claim.label}: {', '.join(filter(None, (f'{kind} {text}', convention, substitution)))}"
            )
        return tuple(lines)

    def _channels_with_claims(self) -> tuple[str, ...]:
        return (*self.channels("gyro"), *self.channels("accel"))

    def _number(self, claim: Claim, use: str, sided: Sided | None, bias: Bias | None) -> float:
        meanings = claim.meanings(sided=sided, bias=bias)
        if len(meanings) > 1:
            option = "sided" if claim.key == "noise_density" else "bias"
            choices = "one or two" if option == "sided" else "minimum or coefficient"
            raise OptionError(
                f"{self.name}: {claim.sensor}: the datasheet does not state the convention of the {claim.label}"
                f" ({', '.join(m.words for m in meanings)}): choose {Hint(option)} {choices}",
                option=option,
            )
        value = claim.maximum if _used(claim, use) == "maximum" else claim.typical
        assert value is not None  # a claim has at least one of them
        return value * meanings[0].factor / (BIAS_LEVEL if meanings[0].of == MINIMUM else 1.0)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return {
            **{key: getattr(self, key) for key in claims.TEXTS if getattr(self, key)},
            "claims": [claim.to_dict() for claim in self.claims],
            **({"axes": {sensor: list(axes) for sensor, axes in self.axes.items()}} if self.axes else {}),
            "data": {sensor: {k: list(v) for k, v in table.items()} for sensor, table in self.data.items()},
        }

    def headline(self) -> str:
        """Name, maker and kind in one line."""
        return ", ".join(text for text in (f"{self.name} ({self.maker})", self.kind) if text)

    def __repr__(self) -> str:
        lines = [self.headline(), f"  source: {self.source}"]
        lines += [f"  confirmed: {self.confirmed}"] if self.confirmed else []
        lines += [f"  {self.note}"] if self.note else []
        rows = [_row(claim) for claim in self.claims]
        rows += [
            (sensor, key.replace("_", " "), ", ".join(values), "")
            for sensor, table in self.data.items()
            for key, values in table.items()
        ]
        rows += [(sensor, "axes", ", ".join(axes), "") for sensor, axes in self.axes.items()]
        widths = [max((len(row[k]) for row in rows), default=0) for k in range(2)]
        lines += [
            f"  {row[0].ljust(widths[0])}  {row[1].ljust(widths[1])}   {'; '.join(filter(None, row[2:]))}"
            for row in rows
        ]
        if not self.claims:
            lines.append("  no noise specification")
        return "\n".join(lines)


def _row(claim: Claim) -> tuple[str, str, str, str]:
    values = [f"{claim.usual} {claim.typical_text}"] if claim.typical is not None else []
    values += [f"maximum {claim.maximum_text}"] if claim.maximum is not None else []
    words = "".join(f" ({convention})" for convention in _conventions(claim))
    return claim.sensor, claim.label, ", ".join(values) + words, claim.note


def _conventions(claim: Claim) -> tuple[str, ...]:
    """Words ``("one-sided",)``, or that the convention is not stated; empty if there is only one interpretation."""
    words = _NOT_STATED[claim.key] if claim.convention == "unknown" else _WORDS.get(claim.convention, "")
    return (words,) if words else ()


def _used(claim: Claim, use: str) -> Literal["typical", "maximum"]:
    """Which number of a claim is used: the requested one, or the only one that the datasheet states."""
    requested = claim.typical if use == "typical" else claim.maximum
    return "typical" if (use == "typical") == (requested is not None) else "maximum"


def _chosen(claims: tuple[Claim, ...]) -> tuple[Claim, ...]:
    """One claim per term; a random walk takes precedence over a noise density."""
    by_term: dict[str, Claim] = {}
    claims = tuple(claim for claim in claims if claim.key != MEANS)
    for claim in sorted(claims, key=lambda claim: claim.key == "noise_density"):
        by_term.setdefault(claim.term, claim)
    return tuple(by_term.values())


@functools.cache
def _library() -> dict[str, Datasheet]:
    folder = resources.files("sigmatau.data").joinpath("datasheets")
    names = sorted(entry.name for entry in folder.iterdir() if entry.name.endswith(".toml"))
    sheets = {}
    for name in names:
        with resources.as_file(folder.joinpath(name)) as path:
            sheets[name.removesuffix(".toml")] = Datasheet.read(path)
    return sheets


class Library(Mapping[str, Datasheet], Printed):
    """Datasheets by name: an immutable mapping that prints one line per datasheet.

    Parameters
    ----------
    sheets : mapping of str to Datasheet
        Datasheets by the name that `datasheet` takes.

    See Also
    --------
    sigmatau.list_datasheets : the library of the package.
    """

    __slots__ = ("_sheets",)

    def __init__(self, sheets: Mapping[str, Datasheet]) -> None:
        self._sheets = dict(sheets)

    def __getitem__(self, name: str) -> Datasheet:
        return self._sheets[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._sheets)

    def __len__(self) -> int:
        return len(self._sheets)

    def __repr__(self) -> str:
        width = max(map(len, self._sheets), default=0)
        return "\n".join(f"{name.ljust(width)}   {sheet.headline()}" for name, sheet in self._sheets.items())


def list_datasheets() -> Library:
    """The library: public datasheet values of common sensors, by name.

    Returns
    -------
    Library
        A mapping from name to `Datasheet`; printed, one line per datasheet.

    See Also
    --------
    datasheet : one datasheet of the library.

    Examples
    --------
    >>> import sigmatau as st
    >>> "icm42688p" in st.list_datasheets()
    True
    """
    return Library(_library())


def datasheet(name: str | Path) -> Datasheet:
    """A datasheet of the library by its name, or a datasheet from a TOML file.

    Parameters
    ----------
    name : str or Path
        ``"icm42688p"``, ``"ICM-42688-P"`` (case and hyphens do not matter), or the path of a file that ends in ``.toml``.

    Returns
    -------
    Datasheet

    Raises
    ------
    OptionError
        For an unknown name; the message suggests a similar name, or lists all.
    DataError
        If the file cannot be read.

    See Also
    --------
    list_datasheets : the names of the library.
    compare_with : compares a result with a datasheet.

    Examples
    --------
    >>> import sigmatau as st
    >>> st.datasheet("ICM-42688-P").maker
    'TDK InvenSense'
    """
    if not isinstance(name, str | Path):
        raise OptionError(
            f"{{option}} must be a name of the library or the path of a .toml file, not {name!r}", option="datasheet"
        )
    if isinstance(name, Path) or name.lower().endswith(".toml"):
        return Datasheet.read(name)
    library = _library()
    plain_name = _letters_and_digits(name)
    for key, sheet in library.items():
        if plain_name in (_letters_and_digits(key), _letters_and_digits(sheet.name)):
            return sheet
    if len(name) < _LONGEST_NAME and Path(f"{name}.toml").is_file():
        raise OptionError(f"unknown datasheet {name!r}; is the file {name}.toml meant?", option="datasheet")
    from difflib import get_close_matches

    if close := get_close_matches(name.lower(), library, n=1):
        raise OptionError(
            f"unknown datasheet {name!r}; is {close[0]} meant? sigmatau datasheet list has all", option="datasheet"
        )
    raise OptionError(
        f"unknown datasheet {name!r}; known: {', '.join(library)}; or give a .toml file", option="datasheet"
    )


def _letters_and_digits(name: str) -> str:
    return "".join(c for c in name.lower() if c.isalnum())
