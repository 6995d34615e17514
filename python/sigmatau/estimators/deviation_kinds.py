"""Table of the estimators: names, units, requirements, averaging times; degrees of freedom and bias for a given noise.

References
----------
.. [1] C. A. Greenhall, W. J. Riley, "Uncertainty of stability variances based on finite differences," Proc. 35th PTTI,
   2003.
.. [2] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.estimators import theo
from sigmatau.frozen import frozen
from sigmatau.noise.synonyms import unknown_term
from sigmatau.noise.terms import NOISE, TERMS

Noise = str | Mapping[str, float] | tuple[str, ...]

_MAX_SAMPLES = 20_000  # number of samples up to which every averaging time is computed separately

Kind = Literal[
    "modified", "hadamard", "parabolic", "total", "modified_total", "hadamard_total", "time", "time_total",
    "theo1", "theobr", "theoh", "mtie", "tie_rms",
]  # fmt: skip


@frozen
class Estimator:
    """An entry of `KINDS`."""

    label: str  # printed name
    kernel: str  # Kernel of the core that computes it
    has_phase_unit: bool = False  # whether it has the unit of the phase (rad, m/s) instead of the rate
    tau_per_m: float = 1.0  # Averaging time over the cluster size in samples
    steps: float = 0.0  # steps of a cluster size over N·m; 0 if they do not depend on m


KINDS: Mapping[str, Estimator] = {
    "modified": Estimator(label="modified Allan deviation", kernel="modified"),
    "hadamard": Estimator(label="Hadamard deviation", kernel="hadamard"),
    "parabolic": Estimator(label="parabolic deviation", kernel="parabolic"),
    "total": Estimator(label="total deviation", kernel="total"),
    "modified_total": Estimator(label="modified total deviation", kernel="modified_total", steps=20),
    "hadamard_total": Estimator(label="Hadamard total deviation", kernel="hadamard_total", steps=20),
    "time": Estimator(label="time deviation", kernel="modified", has_phase_unit=True),
    "time_total": Estimator(label="time total deviation", kernel="modified_total", has_phase_unit=True, steps=20),
    "theo1": Estimator(label="Theo1 deviation", kernel="theo1", tau_per_m=0.75, steps=1),
    "theobr": Estimator(label="TheoBR deviation", kernel="theo1", tau_per_m=0.75, steps=1),
    "theoh": Estimator(label="TheoH deviation", kernel="theo1", steps=1),
    "mtie": Estimator(label="MTIE", kernel="mtie", has_phase_unit=True),
    "tie_rms": Estimator(label="TIE rms", kernel="tie_rms", has_phase_unit=True),
}
"""Estimators by name; section 5.2 of [2]_."""

# Names in other programs
_ALLAN_NAMES = ("allan", "adev", "oadev", "avar", "overlapping")
_OTHER_NAMES = {
    **dict.fromkeys(("mdev", "mvar", "mod"), "modified"),
    **dict.fromkeys(("hdev", "ohdev"), "hadamard"),
    **dict.fromkeys(("totdev", "tot"), "total"),
    **dict.fromkeys(("tdev", "tvar"), "time"),
    **dict.fromkeys(("pdev", "pvar"), "parabolic"),
    **dict.fromkeys(("mtotdev", "mtot", "mtotvar"), "modified_total"),
    **dict.fromkeys(("htotdev", "htot", "htotvar"), "hadamard_total"),
    **dict.fromkeys(("ttotdev", "ttot"), "time_total"),
    **dict.fromkeys(("theobrdev", "theo1br"), "theobr"),
    "theohdev": "theoh",
    "tierms": "tie_rms",
}


def estimator(kind: str) -> Estimator:
    """The estimator of a name; raises `OptionError` for an unknown one."""
    if not isinstance(kind, str) or kind not in KINDS:
        if kind in _ALLAN_NAMES:
            raise OptionError(
                f"{{option}} {kind!r}: the Allan deviation is sigmatau.allan, or sigmatau analyze on the command line;"
                f" kinds: {', '.join(KINDS)}",
                option="kind",
            )
        meant = f"write {_OTHER_NAMES[kind]}" if kind in _OTHER_NAMES else "unknown"
        raise OptionError(f"{{option}} {kind!r}: {meant}; kinds: {', '.join(KINDS)}", option="kind")
    return KINDS[kind]


def sizes_for(kind: str, taus: TauGrid | ArrayLike, *, n: int, tau0: float) -> NDArray[np.int64]:
    """Cluster sizes in samples for a record of `n` samples, increasing; see `sigmatau.deviation`."""
    chosen = estimator(kind)
    smallest, largest, needed = kernels.deviation_limits(chosen.kernel, n)
    if kind in ("theobr", "theoh"):
        theo.check_length(chosen.label, n)
        needed = theo.SHORTEST
        largest = largest if n >= needed else 0
    if largest < smallest:
        raise RecordTooShortError(
            f"{n} samples are too few for the {chosen.label}: at least {needed} are needed", need=needed, got=n
        )
    longest = _MAX_SAMPLES if chosen.steps <= 1 else _MAX_SAMPLES // 4
    if isinstance(taus, str) and taus == "all" and n > longest:
        raise OptionError(
            f"{{option}} 'all' of {n} samples takes some N{'³' if chosen.steps else '²'} steps for the {chosen.label};"
            f" at most {longest} are allowed: take a grid such as 'eighth'",
            option="taus",
        )
    factor = 2 if chosen.kernel == "theo1" else 1
    if isinstance(taus, str):
        # Beyond half the record the total deviation has fewer than three degrees of freedom, so that such
        # sizes are only taken on request.
        reach = min(largest, max(n // 2, 1)) if kind == "total" else largest
        sizes = cluster_sizes(taus, n=2 * reach, tau0=tau0)
        long_sizes = sizes[(sizes >= smallest) & (sizes % factor == 0)]
        if kind == "theoh":
            last = theo.last_allan_size(n)
            return np.concatenate([sizes[sizes <= last], long_sizes[tau_in_samples(kind, n, long_sizes) > last]])
        return long_sizes if long_sizes.size else np.array([smallest], dtype=np.int64)
    times = averaging_times(taus)
    rounded = factor * np.rint(times / (factor * (0.75 if kind == "theoh" else chosen.tau_per_m) * tau0))
    if kind == "theoh":
        allan_sizes = np.rint(times / tau0)
        rounded = np.where(allan_sizes <= theo.last_allan_size(n), allan_sizes, rounded)
        smallest = 1
    outside = times[(rounded < smallest) | (rounded > largest)]
    if outside.size:
        low, high = (float(tau_in_samples(kind, n, np.array([size]))[0]) * tau0 for size in (smallest, largest))
        raise OptionError(
            f"τ = {outside[0]:.6g} s is out of reach of the {chosen.label}: {n} samples at {1 / tau0:.6g} Hz give"
            f" {low:.6g} s to {high:.6g} s",
            option="taus",
        )
    return np.unique(rounded).astype(np.int64)


def tau_in_samples(kind: str, n: int, m: NDArray[np.int64]) -> NDArray[np.float64]:
    """Averaging times of cluster sizes, in samples."""
    return np.asarray(m * (theo.tau_over_m(n, m) if kind == "theoh" else KINDS[kind].tau_per_m))


# a in E[TOTVAR]/AVAR = 1 − a·τ/T: NIST SP 1065, section 5.2.11; white noise has no bias.
_TOTAL_BIAS = {"random_walk": 0.0, "bias_instability": 0.481, "rate_random_walk": 0.750}


def check_coefficients(noise: str | Mapping[str, float]) -> dict[str, float]:
    """Convert the name of a term, or coefficients in SI, to coefficients; raises `OptionError` for anything else."""
    if isinstance(noise, str):
        noise = {noise: 1.0}
    if (channels := getattr(noise, "channels", None)) is not None:
        example = next(iter(channels))
        raise OptionError(
            f"{{option}} must be that of one channel: model[{example!r}], not the whole model", option="noise"
        )
    if not isinstance(noise, Mapping):
        raise OptionError(
            f"{{option}} must be the name of a term or a mapping from terms to coefficients, not {noise!r}",
            option="noise",
        )
    unknown = [name for name in noise if name not in TERMS]
    if unknown:
        raise OptionError(f"{{option}}: {unknown_term(unknown[0])}", option="noise")
    if not all(math.isfinite(value) for value in noise.values()):
        raise OptionError(f"the coefficients of {{option}} must be finite numbers, got {dict(noise)}", option="noise")
    if not any(noise.get(name) for name in NOISE):
        raise OptionError(f"{{option}} has no noise: want one of {', '.join(NOISE)}", option="noise")
    return dict(noise)


def degrees_of_freedom(
    kind: str, noise: Noise, *, n: int, m: NDArray[np.int64], tau0: float, overlap: str = "full"
) -> NDArray[np.float64]:
    """Equivalent degrees of freedom of each variance, 2·E²/Var, for Gaussian noise of the given coefficients.

    Modified Allan, time and Hadamard: exact, the sum over all lags of the squared autocovariance of the terms [1]_.
    All others: exact for records up to 384 samples; a longer record is approximated by a short one with the same
    ratio of m to n, with errors of 0.1 % for the total variance and 3 % for the others. A ramp counts in the modified Allan
    variance, does not affect the Hadamard and the Hadamard total variance, and is refused for the others. MTIE, TIE rms,
    TheoBR and TheoH have no known distribution: the ratio in TheoBR is uncertain too.

    `noise`: a term's name, coefficients in SI, as in `sigmatau.noise.terms.TERMS`, or a tuple of a term's name for each
    size; `tau0`: sample interval [s].
    """
    kernel = estimator(kind).kernel
    if kind in ("theobr", "theoh", "mtie", "tie_rms"):
        raise OptionError(
            f"the distribution of the {estimator(kind).label} is not known: no degrees of freedom and no interval",
            option="noise",
        )
    if isinstance(noise, tuple):
        edf = np.empty(len(m))
        for term in set(noise):
            same = np.array([term == name for name in noise])
            edf[same] = degrees_of_freedom(kind, term, n=n, m=m[same], tau0=tau0, overlap=overlap)
        return edf
    coefficients = check_coefficients(noise)
    if kernel in ("modified", "hadamard"):
        return _stationary(kernel, coefficients, n=n, m=m, tau0=tau0, overlap=overlap)[1]
    if kernel == "hadamard_total":
        coefficients.pop("rate_ramp", None)
    if coefficients.get("rate_ramp"):
        raise OptionError(
            f"the degrees of freedom of the {estimator(kind).label} do not allow for a ramp: leave `rate_ramp` out of"
            " {option}, or take the Hadamard deviation, which ignores it",
            option="noise",
        )
    return kernels.quadratic_edf(kernel, n=n, m=m, coefficients=coefficients, tau0=tau0)


def bias(
    kind: str, noise: str | Mapping[str, float], *, n: int, m: NDArray[np.int64], tau0: float
) -> NDArray[np.float64]:
    """Expected variance of a kind over that of the estimator that it extends, at the same averaging time: the Allan
    variance for ``"total"`` and ``"theo1"``, the modified Allan variance for ``"modified_total"`` and ``"time_total"``,
    the Hadamard variance for ``"hadamard_total"``.

    Total: 1 − a·τ/T with the a of [2]_, for one term, accurate to 0.1 %, including the reflected ends of the record.
    All others: exact for the sampled noise of any mixture without a ramp; beyond m = 64, to 0.1 %.
    """
    coefficients = {name: value for name, value in check_coefficients(noise).items() if value}
    kernel = estimator(kind).kernel
    if kernel in ("modified_total", "hadamard_total"):
        return kernels.total_bias(kernel, m, {**coefficients, "rate_ramp": 0.0}, tau0)
    if kind == "total":
        if len(coefficients) != 1 or next(iter(coefficients)) not in _TOTAL_BIAS:
            raise OptionError(
                f"the bias of the total deviation is known for one of {', '.join(_TOTAL_BIAS)} alone,"
                f" not for {', '.join(coefficients)}",
                option="noise",
            )
        return np.asarray(1 - _TOTAL_BIAS[next(iter(coefficients))] * m / n)
    if kind != "theo1":
        biased = [name for name in KINDS if "total" in name or name == "theo1"]
        raise OptionError(f"only {', '.join(biased)} have a bias, not {kind!r}", option="kind")
    expected = kernels.theo1_expectation(m, coefficients, tau0)
    # 0.75 m is a half-integer for every other even m; it is interpolated on a power law between its neighbours.
    low, high = np.floor(0.75 * m).astype(np.int64), np.ceil(0.75 * m).astype(np.int64)
    share = np.log(0.75 * m / low) / np.log(np.maximum(high / low, 1 + 1e-9))
    avar = [_stationary("allan", coefficients, n=2 * int(m.max()), m=size, tau0=tau0)[0] for size in (low, high)]
    return np.asarray(expected / (avar[0] ** (1 - share) * avar[1] ** share))


def _stationary(
    kernel: str, coefficients: Mapping[str, float], *, n: int, m: NDArray[np.int64], tau0: float, overlap: str = "full"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Expected variances and degrees of freedom."""
    return kernels.stationary_moments(kernel, overlap=overlap, n=n, m=m, coefficients=coefficients, tau0=tau0)


TauGrid = Literal["octave", "half", "quarter", "eighth", "all"]

# First cluster sizes, which are doubled repeatedly: 2^j alone; also 3·2^j; also 5·2^j and 7·2^j, and so on. In such
# grids the double of most sizes is a size too, so that the kernel can share work.
_SEEDS: Mapping[str, tuple[int, ...]] = {
    "octave": (8,),
    "half": (8, 12),
    "quarter": (8, 10, 12, 14),
    "eighth": tuple(range(8, 16)),
}


def cluster_sizes(taus: TauGrid | ArrayLike, *, n: int, tau0: float) -> NDArray[np.int64]:
    """Cluster sizes in samples for a record of `n` samples, increasing, each at most n/2; see `allan`."""
    largest = n // 2
    if largest < 1:
        raise RecordTooShortError(f"{n} samples have no two clusters to compare", need=2, got=n)
    if isinstance(taus, str):
        if taus == "all":
            return np.arange(1, largest + 1, dtype=np.int64)
        if taus not in _SEEDS:
            grids = ", ".join((*_SEEDS, "all"))
            raise OptionError(f"{{option}} {taus!r}: unknown grid; grids: {grids}, or times in s", option="taus")
        seeds = _SEEDS[taus]
        sizes = {seed << j for seed in seeds for j in range(largest.bit_length())}
        sizes |= {size // step for size in sizes for step in (2, 4, 8) if size % step == 0}
        return np.array(sorted(size for size in sizes if size <= largest), dtype=np.int64)
    times = averaging_times(taus)
    multiples = np.rint(times / tau0)
    if multiples.min() < 1:
        raise OptionError(
            f"τ = {times.min():.6g} s is shorter than half a sample interval ({tau0:.6g} s); the shortest is {tau0:.6g} s",
            option="taus",
        )
    if multiples.max() > largest:
        raise OptionError(
            f"τ = {times.max():.6g} s is longer than half the record; the longest is {largest * tau0:.6g} s",
            option="taus",
        )
    return np.unique(multiples).astype(np.int64)


def averaging_times(taus: ArrayLike) -> NDArray[np.float64]:
    """Averaging times as an array of shape (n_tau,); `OptionError` unless all of them are positive. [s]"""
    times = np.atleast_1d(np.asarray(taus, dtype=float))
    if times.ndim != 1 or times.size == 0:
        raise OptionError("{option} must be a list of averaging times in s", option="taus")
    bad = times[~(np.isfinite(times) & (times > 0))]
    if bad.size:
        raise OptionError(f"averaging times must be positive, got {float(bad[0])!r}", option="taus")
    return times
