"""`export`: write a noise model as the file that a filter or a simulator reads.

The files of one or several targets are prepared completely before any is written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol, overload

from sigmatau._version import __version__
from sigmatau.errors import OptionError
from sigmatau.exporting.axes import three_axes
from sigmatau.exporting.choices import KINDS, Choices, Unplaced
from sigmatau.exporting.rates import filter_rate, filter_step
from sigmatau.exporting.source import Source, common_rate, have_several_rates, make_source, sensor_rates
from sigmatau.exporting.target import Target
from sigmatau.exporting.targets import target
from sigmatau.exporting.text import measured, with_head
from sigmatau.exporting.values import Numbers
from sigmatau.findings.exporting import (
    ChoiceWithoutPlace,
    FastestRate,
    MaternAsProcesses,
    NotAdequate,
    OnlyLimits,
    PoorTrust,
    WrittenForOtherRate,
)
from sigmatau.findings.finding import Finding
from sigmatau.frozen import frozen
from sigmatau.hints import Hint, worded
from sigmatau.io.atomic import atomic
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import stream_name
from sigmatau.results import Printed


class HasSource(Protocol):
    """An `Analysis`, which this package cannot import."""

    def to_source(self) -> Source: ...


@overload
def export(
    model: NoiseModel | Source | HasSource, *, to: str, path: None = None, choices: Choices | None = None
) -> str: ...


@overload
def export(
    model: NoiseModel | Source | HasSource, *, to: str, path: str | Path, choices: Choices | None = None
) -> str | bytes: ...


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
        Content of the file, with the unit and origin of each number in comments; bytes only for a `path` with the
        extension of a binary form. `prepare` also returns findings about the file.

    Raises
    ------
    OptionError
        For an unknown target, or a missing choice such as the value of a rate random walk that was not observed.
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


_RATE = 1000.0  # rate of the sum that is a Matérn process, if that of the filter is not stated [Hz]
_SAME_RATE = 1e-3  # largest relative difference of rates that count as equal
# Extensions of binary formats.
_BINARY = frozenset((".npz", ".npy", ".mat", ".h5", ".hdf5", ".pkl", ".parquet", ".bin", ".zip", ".gz", ".pdf", ".png"))


@frozen
class Prepared(Printed):
    """The content of a file for another program."""

    to: str  # Target
    path: Path | None  # File that `write` writes
    content: str | bytes
    findings: tuple[Finding, ...]  # Findings about the file, which its comments state too

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
    """Prepare the content and findings of the file that `export` writes; parameters and errors are those of `export`."""
    try:
        file = None if path is None else Path(path)
    except TypeError:
        raise OptionError(f"{{option}} must be the name of a file, not {path!r}", option="path") from None
    source, chosen = make_source(model), _chosen(choices)
    return prepare_placed(source, to=to, path=file, placed=place_choices(source, [to], chosen)[to])


@frozen
class Placed:
    """Choices that a target has a field for, and the other choices."""

    choices: Choices
    unplaced: tuple[Unplaced, ...]


def place_choices(model: object, names: Iterable[str], choices: Choices) -> dict[str, Placed]:
    """Sort the choices for each of several targets. Raises `OptionError` for a choice that no target has a field for."""
    source = make_source(model)
    unplaced = {name: find_unplaced(target(name), choices, source) for name in names}
    _refuse_everywhere(unplaced)
    return {name: Placed(choices=_without(choices, lost), unplaced=tuple(lost)) for name, lost in unplaced.items()}


def _without(choices: Choices, unplaced: Iterable[Unplaced]) -> Choices:
    for each in unplaced:
        choices = choices.without(each.choice, each.key)
    return choices


def _refuse_everywhere(unplaced: Mapping[str, Sequence[Unplaced]]) -> None:
    """Raise the error of the first choice that no target has a field for."""
    for refused in next(iter(unplaced.values()), ()):
        alike = (refused.choice, refused.key)
        if all(any((each.choice, each.key) == alike for each in choices) for choices in unplaced.values()):
            raise refused.error()


def prepare_placed(model: object, *, to: str, path: Path | None, placed: Placed) -> Prepared:
    """Like `prepare`, with the choices from `place_choices`; each choice without a field becomes a finding."""
    wanted = target(to)
    if path is not None:
        check_path(wanted, path)
    source = make_source(model)
    expanded: tuple[Finding, ...] = ()
    if wanted.name != "model" and (names := tuple(name for name, c in source.model.items() if c.matern)):
        rate = placed.choices.filter_rate or _RATE
        expanded = (Finding(severity="info", channels=names, details=MaternAsProcesses(rate=rate)),)
        head = (*source.head, expanded[0].message)
        source = replace(source, model=source.model.expand_matern(rate=rate), head=head)
    content, findings = _written(wanted, source, placed.choices, path)
    omitted = (
        ChoiceWithoutPlace(target=wanted.name, option=each.option, key=each.key or "") for each in placed.unplaced
    )
    notes = (Finding(severity="info", details=details) for details in omitted)
    return Prepared(to=to, path=path, content=content, findings=(*expanded, *findings, *notes))


_LACKING = {"both": 0, "either": 1, "any": 2}  # sensors that may be missing in a log


def check_record(files: Mapping[str, Path], choices: Choices, rates: Mapping[str, Mapping[str, float]]) -> None:
    """Raise an error before the analysis if a record lacks something that the targets need: a sensor, or the rate of the
    filter.

    Parameters
    ----------
    files : mapping of str to Path
        Files by target.
    choices : Choices
    rates : mapping of str to mapping of str to float
        By sensor, ``"gyro"`` and ``"accel"``: sampling rates by channel. [Hz]
    """
    channels = {name: rate for by_channel in rates.values() for name, rate in by_channel.items()}
    for name in files:
        try:
            _check_needs(target(name), choices, channels)
        except OptionError as error:
            raise error.about(name) from None


def _check_needs(wanted: Target, choices: Choices, rates: Mapping[str, float]) -> None:
    """Raise `OptionError` for a missing sensor, axis, rate or step that a target requires."""
    sensors = {stream_name(name) for name in rates}
    lacking = [kind for sensor, kind in KINDS.items() if sensor not in sensors]
    if len(lacking) > _LACKING[wanted.sensors]:
        requirement = (
            f"the log has no {' and no '.join(lacking)}, which this target requires; state-space takes any sensor"
        )
        raise OptionError(requirement, option="export")
    takes_fastest = wanted.has_rate_field and have_several_rates(sensor_rates(rates))
    if (wanted.needs_rate or wanted.may_need_rate) and not takes_fastest:
        filter_rate(rates, choices)
    if wanted.needs_axes and choices.axes == "each":
        for sensor in sensors & {*KINDS}:
            three_axes(sensor, rates)
    if wanted.needs_step:
        filter_step(rates, choices)


def check_all(names: Iterable[str], choices: Choices) -> None:
    """Raise `OptionError` for choices that apply to no target. No model is needed."""
    _refuse_everywhere({name: find_unplaced(target(name), choices) for name in names})


def find_unplaced(target: Target, choices: Choices, source: Source | None = None) -> list[Unplaced]:
    """List the choices that a target has no field for. Without a source, only those that do not depend on the source."""
    name, default = target.name, Choices()
    listed = ", ".join(target.names) or "none"
    unplaced = [
        Unplaced(choice="names", key=key, why=f"{name} has no name {key!r}; names: {listed}")
        for key in sorted(set(choices.names) - set(target.names))
    ]
    if choices.step is not None and not target.has_step:
        why = f"{Hint('step')} does not apply to {name}, whose file does not depend on a step"
        unplaced.append(Unplaced(choice="step", why=why))
    if choices.horizon is not None and not target.has_horizon and not _uses_horizon(target, choices):
        why = f"{Hint('horizon')} does not apply to {name} without {Hint('walk', 'gyro', 'horizon')}"
        unplaced.append(Unplaced(choice="horizon", why=why))
    if not target.has_walk:
        unplaced += [
            Unplaced(choice=choice, why=f"{Hint(choice)} does not apply to {name}, which is not a filter with N and K")
            for choice in ("consistent", *([] if target.has_unobserved else ["unobserved"]))
            if getattr(choices, choice) != getattr(default, choice)
        ]
        if "consistent" in choices.walk.values():
            consistent = Hint("walk", "gyro", "consistent")
            why = f"{consistent} does not apply to {name}, which is not a filter with N and K"
            unplaced.append(Unplaced(choice="walk", why=why))
    if choices.axes == "each" and not (target.per_axis or target.every_axis):
        why = f"{name} has one number for all axes: choose worst or mean, not each"
        unplaced.append(Unplaced(choice="axes", why=why))
    if choices.axes == "mean" and target.every_axis:
        why = f"{name} has every axis separately, and no mean: omit {Hint('axes')}"
        unplaced.append(Unplaced(choice="axes", why=why))
    for rule in target.unused:
        chosen = [choice for choice in rule.choices if getattr(choices, choice) != getattr(default, choice)]
        if chosen and (rule.when is None or (source is not None and _applies(rule.when, target, source, choices))):
            why = f"does not apply to {name}: {rule.why}"
            unplaced += [Unplaced(choice=choice, why=f"{Hint(choice)} {why}") for choice in chosen]
    return unplaced


def _uses_horizon(target: Target, choices: Choices) -> bool:
    """Whether a walk or a statement in the file depends on the horizon."""
    return target.has_walk or "horizon" in choices.walk.values()


def _applies(when: Callable[[Numbers], bool], target: Target, source: Source, choices: Choices) -> bool:
    fastest = _fastest_rate(target, source, choices)
    rated = choices if fastest is None else replace(choices, filter_rate=fastest.rate)
    return when(Numbers(source, rated, pair=target.has_walk))


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


def _written(
    wanted: Target, source: Source, choices: Choices, path: Path | None
) -> tuple[str | bytes, tuple[Finding, ...]]:
    write = wanted.write if path is None else wanted.binary.get(path.suffix.lower(), wanted.write)
    fastest = _fastest_rate(wanted, source, choices)
    if fastest is not None:
        choices = replace(choices, filter_rate=fastest.rate)
    numbers = Numbers(source, choices, pair=wanted.has_walk)
    for name in ("noise_factor", "walk_factor"):
        factor = getattr(choices, name)
        absent = [sensor for sensor in factor if not numbers.has(sensor)] if isinstance(factor, Mapping) else []
        if absent:
            raise OptionError(f"{Hint(name)} of {absent[0]}: the model has no {KINDS[absent[0]]}", option=name)
    if wanted.needs_rate:
        numbers.rate()
    content = write(numbers)
    if numbers.missing:
        (_, term), *_ = numbers.missing
        raise OptionError("; ".join(numbers.missing.values()), option=term)
    findings = [*_doubts(wanted, source), *numbers.limits_written(), *numbers.findings, *numbers.not_used()]
    rate = _other_rate(source, choices) if fastest is None else Finding(severity="info", details=fastest)
    if isinstance(content, str):
        rate_message = [rate.message] if rate else []
        first = f"Noise parameters for {wanted.name}, written by sigmatau {__version__}"
        content = with_head(worded(content), wanted.ending, [first, *source.head, *rate_message])
    return content, (*findings, *([rate] if rate else []))


def _doubts(wanted: Target, source: Source) -> list[Finding]:
    """Report the channels whose fit is not adequate, and other channels that should not be used: at most one finding
    each.
    """
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
    """Highest rate of the sensors, for a file with one field for the rate, if their rates differ and none was chosen.

    A filter reads both sensors at common times; drivers of cameras interpolate the slower sensor.
    """
    if choices.filter_rate is not None or not wanted.has_rate_field:
        return None
    rates = sensor_rates(source.rates)
    if not have_several_rates(rates):
        return None
    highest = float(measured(max(rates.values())))
    return FastestRate(rate=highest, rates=tuple(rates.items()))


def _other_rate(source: Source, choices: Choices) -> Finding | None:
    """Report a given rate that differs from that of the record."""
    if choices.filter_rate is None or not source.rates:
        return None
    recorded = common_rate(source.rates)
    if recorded is None or abs(choices.filter_rate / recorded - 1) <= _SAME_RATE:
        return None
    return Finding(severity="info", details=WrittenForOtherRate(rate=choices.filter_rate, record_rate=recorded))
