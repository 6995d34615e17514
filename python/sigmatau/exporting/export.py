"""`export`: write a noise model as the file that a filter or a simulator reads.

The files of one or several targets are prepared completely before any is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import KINDS, Choices, NoPlaceError, NotChosenError, given
from sigmatau.exporting.source import Source, have_several_rates, one_rate, sensor_rates, source_of
from sigmatau.exporting.targets import target
from sigmatau.exporting.text import measured, with_head
from sigmatau.exporting.values import Numbers, Target
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.exporting import (
    ChoiceWithoutPlace,
    FastestRate,
    NotAdequate,
    OnlyLimits,
    OtherRate,
    PoorTrust,
)
from sigmatau.findings.wording import words
from sigmatau.io.atomic import atomic
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import stream_name
from sigmatau.results import Printed


class HasSource(Protocol):
    """An `Analysis`, which this package cannot import."""

    def to_source(self) -> Source: ...


def export(
    model: NoiseModel | Source | HasSource, *, to: str, path: str | Path | None = None, choices: Choices | None = None
) -> str | bytes:
    """Write the parameters of a noise model for another program.

    Parameters
    ----------
    model : NoiseModel, Analysis or Source
        `sigmatau.analysis.inputs.read_source` reads a source from a file.
    to : str
        The target, one of `NAMES`, in any case.
    path : str or Path, optional
        File to write, atomically. Its extension selects the form if the target has several.
    choices : Choices, optional
        Options of the export.

    Returns
    -------
    str or bytes
        The content of the file, with unit and origin of each number in comments. `prepare` also returns findings about
        it.

    Raises
    ------
    OptionError
        For an unknown target, or a missing choice, such as the value of a rate random walk that was not observed.
    DataError
        If the model lacks data that the target needs, or the file cannot be written.

    See Also
    --------
    Choices : options that no record can determine.
    NoiseModel.write : the model as a file of this package.

    Examples
    --------
    >>> import sigmatau as st
    >>> names = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    >>> model = st.NoiseModel(channels={name: {"random_walk": 1e-4} for name in names})
    >>> walk = {"gyro": 1e-6, "accel": 1e-5}
    >>> text = st.export(model, to="kalibr", choices=st.Choices(filter_rate=200, walk=walk))
    >>> [line.split("  #")[0] for line in text.splitlines() if line.startswith("gyroscope")]
    ['gyroscope_noise_density: 0.0001', 'gyroscope_random_walk: 1.0e-06']
    """
    prepared = prepare(model, to=to, path=path, choices=choices)
    if prepared.path is not None:
        prepared.write()
    return prepared.content


Failure = TypeVar("Failure", OptionError, DataError, OptionError | DataError)

_SAME_RATE = 1e-3  # relative difference
# Extensions of binary formats.
_BINARY = frozenset((".npz", ".npy", ".mat", ".h5", ".hdf5", ".pkl", ".parquet", ".bin", ".zip", ".gz", ".pdf", ".png"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Prepared(Printed):
    """The content of a file for another program."""

    to: str  # The target
    path: Path | None  # File that `write` writes
    content: str | bytes
    findings: tuple[Finding, ...]  # Findings about the file; comments in the file state them too

    def write(self) -> None:
        """Write the file atomically; raises `DataError` if it cannot be written."""
        if self.path is None:
            raise OptionError(f"{self.to}: no {{option}} to write to", option="path")
        with atomic(self.path) as temporary:
            if isinstance(self.content, bytes):
                temporary.write_bytes(self.content)
            else:
                temporary.write_text(self.content, encoding="utf-8")

    def __repr__(self) -> str:
        text = self.content if isinstance(self.content, str) else f"{len(self.content)} bytes for {self.to}"
        return "\n".join([text, *map(str, self.findings)])


def prepare(model: object, *, to: str, path: str | Path | None = None, choices: Choices | None = None) -> Prepared:
    """Content and findings of the file that `export` writes; parameters and errors as there."""
    try:
        file = None if path is None else Path(path)
    except TypeError:
        raise OptionError(f"{{option}} must be the name of a file, not {path!r}", option="path") from None
    return prepare_all(model, {to: file}, choices=choices)[0]


def prepare_all(
    model: object,
    files: Mapping[str, Path | None],
    *,
    choices: Choices | None = None,
    named: bool = False,
    failures: list[OptionError | DataError] | None = None,
) -> list[Prepared]:
    """The same for several targets. A choice that does not apply to one of them is ignored there, with a finding.
    `named`: whether errors begin with the name of the target; `failures`: takes the errors, and the other targets are
    prepared.
    """
    source, chosen = source_of(model), _chosen(choices)

    def one(to: str, used: Choices) -> Prepared:
        wanted, path = target(to), files[to]
        check_choices(wanted, used)
        if path is not None:
            check_path(wanted, path)
        content, findings = _written(wanted, source, used, path)
        return Prepared(to=to, path=path, content=content, findings=findings)

    return _placed(list(files), chosen, one, named=named, failures=failures)


_CHECKED = {"random_walk": 1e-3, "bias_instability": 1e-4, "rate_random_walk": 1e-5}  # any: the numbers are not used


def check_record(files: Mapping[str, Path], choices: Choices, rates: Mapping[str, Mapping[str, float]]) -> None:
    """Raise an error for what the targets need and a record lacks, before the analysis: a sensor, or the rate of the filter.

    Parameters
    ----------
    files : mapping of str to Path
        Files by target.
    choices : Choices
    rates : mapping of str to mapping of str to float
        Sampling rates by channel, by sensor: ``"gyro"`` and ``"accel"``. [Hz]
    """
    channels = {name: rate for of_sensor in rates.values() for name, rate in of_sensor.items()}
    source = Source(model=NoiseModel(channels=dict.fromkeys(channels, _CHECKED)), rates=channels)
    failures: list[OptionError | DataError] = []
    prepare_all(source, files, choices=choices, named=True, failures=failures)
    for error in failures:
        if isinstance(error, DataError):
            lacking = " and no ".join(kind for sensor, kind in KINDS.items() if sensor not in rates)
            what = (
                f"the log has no {lacking}, which this target requires; state-space takes any sensor"
                if lacking
                else error.message
            )
            raise OptionError(what, option="export").about(error.source)
        if error.option in ("axes", "filter_rate", "step"):
            raise error


def check_all(names: Iterable[str], choices: Choices) -> None:
    """Raise `OptionError` for choices that apply to none of the targets; needs no model."""

    def one(name: str, used: Choices) -> Prepared:
        check_choices(target(name), used)
        return Prepared(to=name, path=None, content="", findings=())

    _placed(list(names), choices, one, named=False)


def check_choices(target: Target, choices: Choices) -> None:
    """Raise `OptionError` for choices that do not apply to a target; needs no model."""
    for key in sorted(set(choices.names) - set(target.names)):
        listed = ", ".join(target.names) or "none"
        raise NoPlaceError(f"{target.name} has no name {key!r}; names: {listed}", choice="names", key=key)
    if choices.step is not None and not target.has_step:
        raise NoPlaceError(
            f"{{@step}} does not apply to {target.name}, whose file does not depend on a step", choice="step"
        )
    if choices.horizon is not None and not target.has_horizon and "horizon" not in choices.walk.values():
        raise NoPlaceError(
            f"{{@horizon}} does not apply to {target.name} without {given('walk', 'horizon', 'gyro')}", choice="horizon"
        )
    if choices.axes == "each" and not (target.per_axis or target.every_axis):
        raise NoPlaceError(f"{target.name} has one number for all axes: choose worst or mean, not each", choice="axes")
    if choices.axes == "mean" and target.every_axis:
        raise NoPlaceError(f"{target.name} has every axis separately, and no mean: omit {{@axes}}", choice="axes")


def check_path(target: Target, path: str | Path) -> None:
    """Raise `OptionError` for the extension of a binary format that a target does not write."""
    ending = Path(path).suffix.lower()
    if ending in _BINARY and ending not in target.binary:
        endings = ", ".join((target.ending, *target.binary))
        raise OptionError(
            f"{Path(path).name!r}: {target.name} has no form for {ending}, a binary format; extensions: {endings}",
            option="path",
        )


def _chosen(choices: object) -> Choices:
    if choices is None:
        return Choices()
    if not isinstance(choices, Choices):
        raise OptionError(
            f"{{option}} must be a sigmatau.exporting.choices.Choices, e.g. Choices(filter_rate=100), not {choices!r}",
            option="choices",
        )
    return choices


def _placed(
    names: list[str],
    choices: Choices,
    attempt: Callable[[str, Choices], Prepared],
    *,
    named: bool,
    failures: list[OptionError | DataError] | None = None,
) -> list[Prepared]:
    """Apply `attempt` to each target, with the choices that apply to it."""

    def of(name: str, error: Failure) -> Failure:
        return error.about(name) if named else error

    made: list[Prepared] = []
    found: Prepared | None
    dropped: list[dict[tuple[str, str | None], NoPlaceError]] = []
    for name in names:
        used, without = choices, dict[tuple[str, str | None], NoPlaceError]()
        while True:
            try:
                found = attempt(name, used)
                break
            except NoPlaceError as error:
                without[error.choice, error.key] = error
                used = used.without(error.choice, error.key)
            except (OptionError, DataError) as error:
                # Of one target, the refused choice is the first error.
                first = next(iter(without.values())) if without and len(names) == 1 else error
                if failures is None:
                    raise of(name, first) from None
                failures.append(of(name, first))
                found = None
                break
        if found is None:
            continue
        omitted = tuple(
            Finding(
                severity="info",
                details=ChoiceWithoutPlace(target=name, option=error.option or error.choice, key=error.key or ""),
            )
            for error in without.values()
        )
        made.append(replace(found, findings=(*found.findings, *omitted)))
        dropped.append(without)
    for key, refused in dropped[0].items() if dropped else ():
        if all(key in without for without in dropped):
            raise of(names[0], refused)
    return made


def _written(
    wanted: Target, source: Source, choices: Choices, path: Path | None
) -> tuple[str | bytes, tuple[Finding, ...]]:
    write = wanted.write if path is None else wanted.binary.get(path.suffix.lower(), wanted.write)
    fastest = _fastest_rate(wanted, source, choices)
    if fastest is not None:
        choices = replace(choices, filter_rate=fastest.rate)
    numbers = Numbers(source, choices)
    if wanted.needs_rate:
        numbers.rate()
    try:
        content = write(numbers)
    except NotChosenError as error:
        raise _not_chosen(write, source, choices, error) from None
    findings = [*_doubts(wanted, source), *numbers.limits_written(), *numbers.findings, *numbers.not_used()]
    rate = _other_rate(source, choices) if fastest is None else Finding(severity="info", details=fastest)
    if isinstance(content, str):
        of_rate = [words(rate).message] if rate else []
        first = f"Noise parameters for {wanted.name}, written by sigmatau {__version__}"
        content = with_head(content, wanted.ending, [first, *source.head, *of_rate])
    return content, (*findings, *([rate] if rate else []))


def _not_chosen(
    write: Callable[[Numbers], str | bytes], source: Source, choices: Choices, first: NotChosenError
) -> OptionError:
    """One error for all missing choices of all sensors."""
    found = [first]
    while True:
        last = found[-1]
        more: Any = {
            last.choice: {**getattr(choices, last.choice), last.sensor: 1.0}
        }  # to find further missing choices
        choices = replace(choices, **more)
        try:
            write(Numbers(source, choices))
        except NotChosenError as error:
            found.append(error)
            continue
        except ValueError:  # the next attempt reports it
            pass
        if len(found) == 1:
            return first
        return OptionError("; ".join(error.message for error in found), option=first.option)


def _doubts(wanted: Target, source: Source) -> list[Finding]:
    """A finding for all channels whose fit is not adequate, and one for the others that are not to be used."""
    every = wanted.every_axis or wanted.name == "model"
    written = {
        name: channel
        for name, channel in source.model.channels.items()
        if every or stream_name(name) in ("gyro", "accel")
    }
    limited = tuple(name for name, channel in written.items() if channel.has_only_limits)
    unfit = tuple(name for name, channel in written.items() if not channel.adequate and name not in limited)
    poor = tuple(name for name in written if name in source.poor and name not in (*unfit, *limited))
    doubts = ((limited, OnlyLimits()), (unfit, NotAdequate()), (poor, PoorTrust()))
    return [Finding(severity="warning", channels=names, details=details) for names, details in doubts if names]


def _fastest_rate(wanted: Target, source: Source, choices: Choices) -> FastestRate | None:
    """The highest rate of the sensors, for a file that has one field for it, if their rates differ and none was chosen.

    A filter takes both sensors at common times. Drivers of cameras interpolate the slower sensor for that.
    """
    if choices.filter_rate is not None or not wanted.has_rate_field:
        return None
    rates = sensor_rates(source.rates)
    if not have_several_rates(rates):
        return None
    highest = float(measured(max(rates.values())))
    return FastestRate(rate=highest, rates=tuple(rates.items()))


def _other_rate(source: Source, choices: Choices) -> Finding | None:
    """A finding if the given rate is not that of the record."""
    if choices.filter_rate is None or not source.rates:
        return None
    try:
        of_record = one_rate(source.rates)
    except OptionError:  # channels with several rates
        return None
    if of_record is None or abs(choices.filter_rate / of_record - 1) <= _SAME_RATE:
        return None
    return Finding(severity="info", details=OtherRate(rate=choices.filter_rate, record_rate=of_record))
