"""Pages of the Python reference: an index by task, and a page for each public class and function."""

from __future__ import annotations

import functools
import importlib
import inspect
import re
import sys
import typing
from collections.abc import Iterator, Sequence
from typing import Any

import sigmatau
from website.rst import heading

EXPORTED = tuple(name for name in sigmatau.__all__ if not name.startswith("__"))

# Title, purpose and names of each group: names of `sigmatau`, or with a dot of a module below it.
GROUPS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    (
        "Read and write records",
        "A log, a data frame or arrays as a record, and a record as a log.",
        ("read", "from_frame", "write", "inspect", "Record", "Stream"),
    ),
    (
        "Analyse",
        "From a record to coefficients with intervals, findings and figures in one call.",
        ("analyze", "Analysis", "check", "Finding"),
    ),
    (
        "Curves",
        "Allan variance and other deviations.",
        (
            "allan",
            "Curves",
            "DeviationCurve",
            "deviation",
            "Deviations",
            "identify_noise",
            "NoiseIdentification",
            "NoiseIdentifications",
            "Deviation",
            "dynamic_allan",
            "read_curves",
            "read_figure",
            "Accumulator",
            "plot_overlay",
            "show_in",
        ),
    ),
    (
        "Spectra",
        "Two-sided power spectral densities, with intervals.",
        (
            "psd",
            "Spectrum",
            "avar_from_psd",
            "AvarFromPsd",
            "fit_psd",
            "PsdFit",
            "cross_spectrum",
            "CrossSpectrum",
            "transfer",
            "bandwidth",
            "Bandwidths",
            "SensorBandwidth",
        ),
    ),
    (
        "Fit",
        "Coefficients from a record or a curve, and the length of a record that shows them.",
        (
            "fit_channel",
            "fit",
            "fit_jointly",
            "read_off",
            "fit_slope",
            "CurveSlope",
            "NoiseFit",
            "JointFit",
            "JointChannel",
            "ReadOff",
            "plan",
            "Plan",
        ),
    ),
    (
        "Noise models",
        "What a sensor's noise is expected to be at any averaging time and frequency.",
        ("NoiseModel", "ChannelModel", "GaussMarkov", "Matern", "Resonance", "Sinusoid", "LowPass", "TurnOn"),
    ),
    ("Simulate", "Records with known noise.", ("simulate", "simulate_to", "Imperfections")),
    (
        "Filters and prediction",
        "Kalman matrices, ARIMA processes, and the error growth of unaided navigation.",
        (
            "state_space",
            "arma",
            "verify",
            "predict",
            "tune",
            "Innovations",
            "BiasFilter",
            "FilterMatrices",
            "Tunings",
            "Tuning",
        ),
    ),
    ("Export", "Files of other programs, in their units.", ("export", "Choices")),
    (
        "Datasheets",
        "Published values, and whether a sensor meets them.",
        ("datasheet", "list_datasheets", "Datasheet", "compare_with", "Verdict"),
    ),
    (
        "Runs and lots",
        "Several runs of a unit, and many units.",
        ("compare_runs", "RunComparison", "random_effects", "RandomEffects", "measure_turn_on", "judge_lot", "Lot"),
    ),
    (
        "Arrays",
        "Several sensors of one axis, and the virtual sensor that they make.",
        ("analyze_array", "ArrayAnalysis"),
    ),
    (
        "Temperature",
        "Noise and bias over temperature, from a log or several runs.",
        (
            "calibrate_temperature",
            "TemperatureCalibration",
            "calibrate_over_runs",
            "TemperatureRun",
            "temperature_matrix",
            "TemperatureMatrix",
            "temperature_report",
        ),
    ),
    ("Reports", "One page with everything, to read offline, print and hand on.", ("report", "certify", "lot_report")),
    ("Store", "Results in a database.", ("Store",)),
    (
        "Errors",
        "What is raised for data and options.",
        ("DataError", "NonFiniteError", "OptionError", "RecordTooShortError"),
    ),
    (
        "Formulas and units",
        "The five noise terms in closed form, their errors, and conversion of units.",
        (
            "noise.terms.TERMS",
            "noise.terms.avar",
            "noise.terms.psd",
            "noise.terms.aliasing_inflation",
            "noise.uncertainty.percentage_error",
            "noise.uncertainty.degrees_of_freedom",
            "statespace.flicker.flicker_poles",
            "units.to_si",
            "units.find",
            "units.Unit",
        ),
    ),
)

# Ancestors whose members are not repeated.
_BEYOND = "object, Mapping, Exception, ValueError, BaseException, Protocol"
_MODULE = (".. currentmodule:: sigmatau", "")  # module of names without a module


def object_of(name: str) -> Any:  # noqa: ANN401  a class, a function or a constant
    """Object of a dotted name below `sigmatau`."""
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(f"sigmatau.{module}") if module else sigmatau, last)


@functools.cache
def groups() -> tuple[tuple[str, str, tuple[str, ...]], ...]:
    """`GROUPS`, extended by the classes of arguments and results of their names."""
    named = [name for _, _, names in GROUPS for name in names]
    if set(EXPORTED) != (exported := {name for name in named if "." not in name}) or len(named) != len(set(named)):
        odd = sorted(set(EXPORTED) ^ exported) or sorted({name for name in named if named.count(name) > 1})
        raise ValueError(f"GROUPS of docs/website/api.py: each public name must be in one group, see {', '.join(odd)}")
    listed = [object_of(name) for name in named]
    made = []
    for title, purpose, names in GROUPS:
        further: list[str] = []
        waiting = [object_of(name) for name in names]
        while waiting:
            for cls in _classes(waiting.pop()):
                if not any(cls is each for each in listed):
                    listed.append(cls)
                    waiting.append(cls)
                    further.append(f"{cls.__module__}.{cls.__qualname__}".removeprefix("sigmatau."))
        made.append((title, purpose, (*names, *sorted(further, key=lambda name: name.rpartition(".")[2]))))
    return tuple(made)


def _classes(described: Any) -> Iterator[type]:  # noqa: ANN401  a class or a function
    """Public classes of sigmatau in the annotations of arguments, results and fields."""
    if inspect.isclass(described):
        yield from _in_annotations(
            described, {k: v for k, v in vars(described).get("__annotations__", {}).items() if k[0] != "_"}
        )
        members = [member for name, member in vars(described).items() if name[0] != "_"]
        for member in members:
            function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
            if inspect.isfunction(function):
                yield from _in_annotations(described, function.__annotations__)
    elif inspect.isfunction(described):
        yield from _in_annotations(inspect.unwrap(described), described.__annotations__)


def _in_annotations(described: Any, annotations: dict[str, Any]) -> Iterator[type]:  # noqa: ANN401
    module = sys.modules[described.__module__]
    for annotation in annotations.values():
        for name in re.findall(r"[A-Z]\w+", str(annotation)):
            value = getattr(module, name, None)
            candidates = [value, *typing.get_args(value)] if value is not None else [_imported(module.__name__, name)]
            for candidate in candidates:
                if inspect.isclass(candidate) and _is_public(candidate):
                    yield candidate


def _is_public(cls: type) -> bool:
    path = f"{cls.__module__}.{cls.__qualname__}"
    is_exported = path.startswith("sigmatau.") and "._" not in path and not getattr(cls, "_is_protocol", False)
    return is_exported and not _is_finding_kind(cls.__module__)  # finding kinds have a separate page


def _is_finding_kind(module: str) -> bool:
    return module.startswith("sigmatau.findings.") and module != "sigmatau.findings.finding"


@functools.cache
def _imports(module: str) -> dict[str, tuple[str, str]]:
    """Names that a module imports only for type checkers, with their origin."""
    source = inspect.getsource(sys.modules[module])
    imports = re.findall(r"^\s+from (sigmatau[\w.]*) import ([\w, ]+)$", source, flags=re.MULTILINE)
    return {name.strip(): (path, name.strip()) for path, names in imports for name in names.split(",")}


def _imported(module: str, name: str) -> object:
    path, attribute = _imports(module).get(name, ("", ""))
    return getattr(importlib.import_module(path), attribute, None) if path else None


def pages() -> dict[str, str]:
    """The pages in reStructuredText, by name: an index, a page for each group, for each name, and for results."""
    index = [*heading("Python", "="), ".. currentmodule:: sigmatau", ""]
    index += ["``import sigmatau as st``. Values are in SI units, spectral densities are two-sided.", ""]
    pages_by_name = {}
    for title, purpose, names in groups():
        page = _slug(title)
        documented = [name for name in names if name in _named()]
        parts = [name for name in names if name not in documented]
        index += [
            f":doc:`{title} <{page}>`",
            f"   {purpose}",
            "",
            f"   {' · '.join(f'`{name}`' for name in documented)}",
            "",
        ]
        lines = [*heading(title, "="), ".. currentmodule:: sigmatau", "", purpose, "", *_table(documented)]
        entries = [f"{name.rpartition('.')[2]} <{_file(name)}>" for name in documented]
        if parts:
            lines += [*heading("What they take and return", "-"), *_table(parts)]
            entries.append(f"{title}: results <{page}-results>")
            shown = [line for name in parts for line in (*heading(name, "-"), *_members(name))]
            pages_by_name[f"api/{page}-results"] = (
                "\n".join([*heading(f"{title}: results", "="), *_MODULE, *shown]) + "\n"
            )
        lines += [".. toctree::", "   :hidden:", "", *(f"   {entry}" for entry in entries)]
        pages_by_name[f"api/{page}"] = "\n".join(lines) + "\n"
        for name in documented:
            lines = [*heading(name.rpartition(".")[2], "="), *_MODULE, *_members(name)]
            pages_by_name[f"api/{_file(name)}"] = "\n".join(lines) + "\n"
    index += [".. toctree::", "   :hidden:", "", *(f"   {_slug(title)}" for title, _, _ in GROUPS)]
    return {"api/index": "\n".join(index) + "\n", **pages_by_name}


def _slug(title: str) -> str:
    """Name of the page of a group; no public name of the package has this form."""
    return "group-" + re.sub(r"\W+", "-", title.lower())


def _file(name: str) -> str:
    """File of the page of a name; `Plan` and `plan` differ even on file systems that ignore case."""
    return f"class-{name}" if inspect.isclass(object_of(name)) else name


def _named() -> set[str]:
    return {name for _, _, names in GROUPS for name in names}


def _table(names: Sequence[str]) -> list[str]:
    lines = [".. list-table::", "   :class: names", "   :widths: 30 70", ""]
    for name in names:
        lines += [f"   * - `{name}`", f"     - {_summary(name)}"]
    return [*lines, ""]


def _summary(name: str) -> str:
    """First sentence of a docstring."""
    described = object_of(name)
    if not callable(described):
        return "constant"
    first = " ".join((inspect.getdoc(described) or "").partition("\n\n")[0].split())
    return re.sub(r" *\[\d+\]_", "", re.split(r"(?<=[a-z0-9`)\]])[.:] (?=[A-Z`])", first)[0]).replace("|", r"\|")


def _members(name: str) -> list[str]:
    """Directive that documents a class with its members, a function or a constant."""
    described = object_of(name)
    if inspect.isclass(described):
        return [f".. autoclass:: sigmatau.{name}", "   :members:", f"   :inherited-members: {_BEYOND}", ""]
    if callable(described):
        return [f".. autofunction:: sigmatau.{name}", ""]
    return [f".. autodata:: sigmatau.{name}", "   :no-value:", ""]
