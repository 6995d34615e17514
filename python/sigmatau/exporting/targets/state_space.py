"""State-space matrices of each channel for any filter, as JSON, ``.npz`` or ``.mat``.

x' = F·x + G·w, cov w = Qd; y = H·x + v, var v = R; cov x₀ = P0, with the step dt; flicker noise is a sum of a few
Gauss-Markov states.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, cast, get_args

import numpy as np
from numpy.typing import NDArray

from sigmatau._version import __version__
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.choices import KINDS
from sigmatau.exporting.consistent import HORIZON, judge_third_state, third_state
from sigmatau.exporting.rates import filter_step
from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.values import Numbers
from sigmatau.hints import Hint
from sigmatau.model.channel import ChannelModel, alike_text
from sigmatau.model.file import doubt_text
from sigmatau.model.process_curves import scaled
from sigmatau.model.unobserved import Unobserved, assume_terms, find_unobserved, unobserved_text
from sigmatau.noise.terms import SLOW, TERMS
from sigmatau.record.record import stream_name
from sigmatau.statespace.state_space import Output, StateSpace, state_space

MATRICES = ("F", "G", "H", "Qd", "R", "P0")

_MAT_TEXT = 116  # length of the header text of a .mat file, fixed by the format [bytes]
_ABOUT = "x' = F x + G w, cov w = Qd; y = H x + v, var v = R; cov x0 = P0; every dt_s seconds"


def write(numbers: Numbers) -> str:
    """The text of the JSON, one matrix row per line; numbers read back to the same bits."""
    systems = []
    for name, content in _content(numbers).items():
        keys = ",\n".join(f"    {json.dumps(key)}: {_json(value)}" for key, value in content.items())
        systems.append(f"  {json.dumps(name)}: {{\n{keys}\n  }}")
    about = json.dumps(f"{_ABOUT}; SI; written by sigmatau {__version__}")
    return f'{{\n "about": {about},\n "systems": {{\n' + ",\n".join(systems) + "\n }\n}\n"


def write_npz(numbers: Numbers) -> bytes:
    """Arrays ``gyro_x.F`` … and ``gyro_x.states``, without pickles."""
    arrays: dict[str, Any] = {}
    for name, content in _content(numbers).items():
        if "/" in name or "\\" in name:
            raise DataError(f"channel {name!r}: a slash is a path separator in this format; write JSON")
        arrays |= {f"{name}.{key}": value for key, value in content.items()}
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def write_mat(numbers: Numbers) -> bytes:
    """One structure of matrices per channel; version 5, which MATLAB, Octave and SciPy read."""
    from scipy.io import savemat

    structures: dict[str, dict[str, Any]] = {}
    for name, content in _content(numbers).items():
        if not (name.isascii() and name.isidentifier() and name[0] != "_" and len(name) <= 31):
            raise DataError(f"channel {name!r} is not a MATLAB variable name: up to 31 letters, digits and _")
        # Lists of strings become cell arrays.
        structures[name] = {
            key: np.array(value.tolist(), dtype=object)
            if isinstance(value, np.ndarray) and value.dtype.kind == "U"
            else value
            for key, value in content.items()
        }
    buffer: Any = io.BytesIO()
    savemat(buffer, structures, long_field_names=True)
    head = f"MATLAB 5.0 MAT-file, written by sigmatau {__version__}".encode().ljust(_MAT_TEXT)
    return head + bytes(buffer.getvalue()[_MAT_TEXT:])


def _json(value: object) -> str:
    if not isinstance(value, np.ndarray):
        return json.dumps(value, allow_nan=False)
    if value.ndim < 2:
        return json.dumps(value.tolist())
    return "[" + ",\n      ".join(json.dumps(row, allow_nan=False) for row in value.tolist()) + "]"


_FORMS = ("channels", "joint", "third-state")
"""Contents of a file: a system for each channel, one for all channels, or one with a third state."""


def _content(numbers: Numbers) -> dict[str, dict[str, Any]]:
    """Content of each system: one per channel, or ``joint`` of all."""
    form = numbers.name("form", "channels")
    if form not in _FORMS:
        raise OptionError(f"{{option}} form={form!r}: want channels, joint or third-state", option="name")
    if form == "third-state":
        return {name: _with_third_state(numbers, name) for name in numbers.model.channels}
    systems = _systems(numbers)
    if form == "channels":
        return {name: _plain(system) | _noted(numbers, [name]) for name, system in systems.items()}
    return {"joint": _joint(numbers, systems) | _noted(numbers, list(systems))}


def _noted(numbers: Numbers, channels: list[str]) -> dict[str, str]:
    """Notes by system: its coefficients are from a fit that is not adequate, or another model explains its walk."""
    doubts = {name: doubt_text(numbers.model.channels[name]) for name in channels}
    notes = [f"{name}: {doubt}" for name, doubt in doubts.items() if doubt]
    alike = {name: numbers.model.channels[name].alike_from for name in channels}
    notes += [f"{name}: {alike_text(process.time)}" for name, process in alike.items() if process is not None]
    for name in channels:
        # Chosen processes need no note.
        terms = set(_chosen_terms(numbers, name))
        lacking = [term for term in find_unobserved(numbers.model.channels[name]) if term not in terms]
        notes += [f"{name}: {unobserved_text(lacking, _policy(numbers))}"] if lacking else []
    return {"note": "; ".join(notes)} if notes else {}


def _systems(numbers: Numbers) -> dict[str, StateSpace]:
    return {name: _make_system(numbers, _chosen(numbers, name)) for name in numbers.model.channels}


def _make_system(numbers: Numbers, model: ChannelModel) -> StateSpace:
    """Build the system of a model for the chosen step and output."""
    rates = {name: numbers.source.rates[name] for name in numbers.whole.channels if name in numbers.source.rates}
    dt = filter_step(rates, numbers.choices)
    output = numbers.name("output", "rate")
    if output not in get_args(Output):
        raise OptionError(f"{{option}} output={output!r}: want rate, increments or integrated", option="name")
    return state_space(model, dt=dt, output=cast(Output, output), tau_max=numbers.choices.horizon)


def _chosen(numbers: Numbers, name: str) -> ChannelModel:
    """The model of a channel with the chosen coefficients and both factors."""
    model = numbers.model.channels[name]
    white_factor = numbers.factor("random_walk", stream_name(name))
    slow_factor = numbers.factor("rate_random_walk", stream_name(name))
    terms: dict[str, float] = {}
    for term, value in assume_terms(model, _policy(numbers)).items():
        terms[term] = (slow_factor if term in SLOW else white_factor) * value
    terms |= _chosen_terms(numbers, name)
    processes = tuple(scaled(g, slow_factor) for g in model.gauss_markov)
    resonances = tuple(scaled(r, slow_factor) for r in model.resonance)
    return replace(model, terms=terms, gauss_markov=processes, resonance=resonances)


def _policy(numbers: Numbers) -> Unobserved:
    """How the systems include terms that were not observed."""
    return "absent" if numbers.choices.strict else numbers.choices.unobserved


def _chosen_terms(numbers: Numbers, name: str) -> dict[str, float]:
    """Chosen values of coefficients that were not observed, with their factors."""
    model, choices = numbers.model.channels[name], numbers.choices
    sensor = stream_name(name)
    terms: dict[str, float] = {}
    if sensor in choices.walk and "rate_random_walk" not in model:
        if choices.walk[sensor] == "horizon":
            raise OptionError(
                f"a state space contains the flicker noise itself, so no walk approximates it: omit"
                f" {Hint('walk')}, or give upper-limit"
                " or a value",
                option="rate_random_walk",
            )
        terms["rate_random_walk"] = numbers.channel_walk(name).value
    if sensor in choices.noise and "random_walk" not in model:
        terms["random_walk"] = numbers.channel_noise(name).value
    return terms


def _with_third_state(numbers: Numbers, name: str) -> dict[str, Any]:
    """A system with a walk and a Gauss-Markov process, for a filter that states its errors correctly up to the horizon."""
    sensor = stream_name(name)
    if sensor not in KINDS:
        raise OptionError(
            f"{{option}} form=third-state: {name} is neither a gyro nor an accelerometer; form=channels has all its noise",
            option="name",
        )
    model, horizon = _chosen(numbers, name), numbers.choices.horizon or HORIZON
    if "random_walk" not in model.terms:
        label = TERMS["random_walk"].label(model.quantity)
        raise DataError(f"{name}: the model has no {label}, which form=third-state needs")
    chosen = third_state(model, sensor=sensor, horizon=horizon)
    judged = judge_third_state(model, chosen, sensor=sensor, horizon=horizon)
    reduced = ChannelModel(
        terms={"random_walk": chosen.noise, "rate_random_walk": chosen.walk},
        gauss_markov=(chosen.process,) if chosen.process else (),
        quantity=model.quantity,
        unit=model.unit,
    )
    system = _make_system(numbers, reduced)
    note = _noted(numbers, [name]).get("note", "")
    return _plain(system) | {"note": "; ".join(filter(None, [f"{name}: {judged.text('with a third state')}", note]))}


def _unit_of_y(system: StateSpace) -> str:
    return system.unit if system.output == "rate" else f"({system.unit})*s"


def _plain(system: StateSpace) -> dict[str, Any]:
    return {
        **{key: getattr(system, key) for key in MATRICES},
        "states": np.array(system.states, dtype=np.str_),
        "inputs": np.array(system.inputs, dtype=np.str_),
        "dt_s": system.dt,
        "output": system.output,
        "unit_of_y": _unit_of_y(system),
        **_flicker_error([system]),
    }


def _flicker_error(systems: Sequence[StateSpace]) -> dict[str, float]:
    """Error of the approximation of flicker noise, and the averaging time up to which it holds."""
    times = [system.tau_max for system in systems if system.tau_max is not None]
    return {"flicker_error": max(s.flicker_error for s in systems), "tau_max_s": max(times)} if times else {}


_TERMS = {
    "filter": "random_walk",
    "flicker": "bias_instability",
    "angle_error": "quantization",
    "angle_error_before": "quantization",
    "bias": "rate_random_walk",
}


def _term(name: str) -> str:
    """The term of a state or an input."""
    kind = re.sub(r"_\d+$", "", name)
    return _TERMS.get(kind, kind)


def _joint(numbers: Numbers, systems: Mapping[str, StateSpace]) -> dict[str, Any]:
    """Combine all channels in one system, with the covariance of correlated noise. A term has the same dynamics in all
    channels with the same step, so that the cross-covariance is ρ·(c_b/c_a) times the covariance of the first.
    """
    names = list(systems)
    every = list(systems.values())
    blocks = {key: _diagonal([getattr(system, key) for system in every]) for key in MATRICES}
    starts = {key: np.cumsum([0, *(getattr(s, key).shape[0] for s in every)]) for key in ("Qd", "R", "P0")}
    chosen = {name: _chosen(numbers, name) for name in names}
    for term, pairs in numbers.model.correlation.items():
        for (first, second), rho in pairs.items():
            a, b = names.index(first), names.index(second)
            share = rho * chosen[second][term] / chosen[first][term]
            measured = "quantization" if every[a].output == "integrated" else "random_walk"
            first_rows = {
                "Qd": [_term(name) == term for name in every[a].inputs],
                "P0": [_term(name) == term for name in every[a].states],
                "R": [term == measured],
            }
            second_rows = {
                "Qd": [_term(name) == term for name in every[b].inputs],
                "P0": [_term(name) == term for name in every[b].states],
                "R": [term == measured],
            }
            for key, start in starts.items():
                rows = start[a] + np.flatnonzero(first_rows[key])
                columns = start[b] + np.flatnonzero(second_rows[key])
                if not rows.size:
                    continue
                shared = share * blocks[key][np.ix_(rows, rows)]
                blocks[key][np.ix_(rows, columns)] = shared
                blocks[key][np.ix_(columns, rows)] = shared.T
    return {
        **blocks,
        "states": np.array([f"{n}.{state}" for n, s in systems.items() for state in s.states], dtype=np.str_),
        "inputs": np.array([f"{n}.{name}" for n, s in systems.items() for name in s.inputs], dtype=np.str_),
        "measurements": np.array(names, dtype=np.str_),
        "dt_s": every[0].dt,
        "output": every[0].output,
        "unit_of_y": np.array([_unit_of_y(system) for system in every], dtype=np.str_),
        **_flicker_error(every),
    }


def _diagonal(blocks: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    rows, columns = zip(*(block.shape for block in blocks), strict=True)
    result = np.zeros((sum(rows), sum(columns)))
    row = column = 0
    for block in blocks:
        result[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    return result


def _is_without_slow_noise(numbers: Numbers) -> bool:
    models = numbers.model.channels.values()
    return not numbers.choices.walk and not any(
        set(model) - {"quantization", "random_walk"} or model.gauss_markov or model.resonance for model in models
    )


def _is_without_flicker(numbers: Numbers) -> bool:
    if numbers.choices.names.get("form") == "third-state":
        return False  # flicker noise is fitted up to the horizon
    return not any("bias_instability" in _chosen(numbers, name).terms for name in numbers.model.channels)


TARGET = Target(
    name="state-space",
    program="any filter",
    columns=("matrices", "`--filter-rate` or `--step`"),
    summary="F, G, H, Qd, R, P0 of every channel for any filter: JSON, .npz or .mat by the ending",
    ending=".json",
    write=write,
    sensors="any",
    needs_step=True,
    has_step=True,
    has_horizon=True,
    has_unobserved=True,
    every_axis=True,
    unused=(
        Unused(choices=("walk_factor",), why="the model has no slow noise", when=_is_without_slow_noise),
        Unused(choices=("horizon",), why="the model has no flicker noise", when=_is_without_flicker),
    ),
    binary={".npz": write_npz, ".mat": write_mat},
    names={"output": "rate", "form": "channels"},
    name_values={"output": get_args(Output), "form": _FORMS},
)
