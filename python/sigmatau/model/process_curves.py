"""Curves, values and texts of the processes of a model, by the kind of process: what a new kind has to add."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.model import covariance as covariances
from sigmatau.model.matern import Matern
from sigmatau.model.processes import GaussMarkov, Resonance, Sinusoid

Process: TypeAlias = GaussMarkov | Matern | Resonance | Sinusoid
AnyProcess = TypeVar("AnyProcess", GaussMarkov, Matern, Resonance, Sinusoid)

_KEYS = {"time": "time_s", "frequency": "frequency_hz", "width": "width_hz"}  # keys of fields with a unit


def process_avar(process: Process, sizes: NDArray[Any], tau0: float) -> Floats:
    """Expected Allan variance of the samples for cluster sizes."""
    if isinstance(process, GaussMarkov):
        return kernels.gauss_markov_avar(process.sigma, process.time, sizes, tau0)
    if isinstance(process, Matern):
        return np.asarray(sum(process_avar(part, sizes, tau0) for part in process.gauss_markov(tau0)))
    if isinstance(process, Resonance):
        return kernels.resonance_avar(process.sigma, process.frequency, process.width, sizes, tau0)
    return kernels.sinusoid_avar(process.amplitude, process.frequency, sizes, tau0)


def process_psd(process: Process, frequency: Floats, tau0: float | None) -> Floats:
    """Two-sided density before sampling, or of samples with aliasing; 0 for a sinusoid, which has none."""
    if isinstance(process, GaussMarkov):
        return kernels.gauss_markov_psd(process.sigma, process.time, frequency, tau0)
    if isinstance(process, Matern):
        if tau0 is None:
            return process.psd(frequency)
        return np.asarray(sum(process_psd(part, frequency, tau0) for part in process.gauss_markov(tau0)))
    if isinstance(process, Resonance):
        if tau0 is None:
            return kernels.resonance_psd(process.sigma, process.frequency, process.width, frequency)
        return covariances.resonance(process, tau0).psd(frequency, tau0)
    return np.zeros(frequency.shape)


def process_size(process: Process) -> float:
    """Standard deviation of a process, amplitude of a sinusoid. [unit of the rate]"""
    return process.amplitude if isinstance(process, Sinusoid) else process.sigma


def scaled(process: AnyProcess, factor: float) -> AnyProcess:
    """The process with its size multiplied by a factor."""
    changed: dict[str, Any] = {fields(process)[0].name: factor * process_size(process)}
    return replace(process, **changed)


def process_values(process: Process) -> dict[str, float]:
    """Plain values in SI; keys state the unit of a time or frequency."""
    return {_KEYS.get(field.name, field.name): getattr(process, field.name) for field in fields(process)}


def process_text(process: Process, unit: str, factor: float) -> str:
    """The process with its size in a display unit of `factor` SI units."""
    size = f"{process_size(process) / factor:.4g} {unit}"
    if isinstance(process, GaussMarkov):
        return f"Gauss-Markov {size} over {process.time:.4g} s"
    if isinstance(process, Matern):
        return f"Matérn {size} over {process.time:.4g} s, smoothness {process.smoothness:.3g}"
    if isinstance(process, Resonance):
        return f"resonance {size} at {process.frequency:.4g} Hz, half width {process.width:.4g} Hz"
    return f"sinusoid {size} at {process.frequency:.4g} Hz"
