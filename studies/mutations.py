"""Seeded bugs: does the test suite find them? ``python -m studies.mutations`` writes docs/study/mutations.md.

The tree is copied to temporary folders. One bug at a time is put into a copy, tests run until one fails, and the file is
restored. A bug counts as found if a test fails with it and passes without it. First all bugs meet the tests named for them,
two bugs at a time; then those that are left meet all tests of the room and its neighbours. The bugs were chosen before it
was known which tests find them. Results are kept in .study/mutations.json, so that a stopped study goes on. A result is
repeated if the change or its test paths are edited. Exit code 1 if a bug is not found.

    python -m studies.mutations            # all bugs without a result
    python -m studies.mutations --check    # only whether every change still fits its file
    python -m studies.mutations --again gls-freedom lines-alternating
"""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / ".study" / "mutations.json"
PAGE = ROOT / "docs" / "study" / "mutations.md"
TARGET = ROOT / ".study" / "mutation-target"  # of cargo, kept between the bugs in Rust

_COPIED = ("python", "tests", "docs", "benches", "studies", "crates", "scripts", "requirements")
_LOCK = threading.Lock()  # for the results


class Mutation(NamedTuple):
    """One seeded bug: replace `old`, which occurs once in `file`, by `new`; `tests` are the paths to try first."""

    name: str
    bug: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    added: bool = False  # whether no test found it at first, so that one was added

    @property
    def room(self) -> str:
        """Folder of the package, or crate."""
        parts = self.file.split("/")
        return f"crates/{parts[1]}" if parts[0] == "crates" else parts[2].removesuffix(".py")

    @property
    def key(self) -> str:
        """Identifies the change and where it is looked for."""
        text = "\0".join((self.file, self.old, self.new, *self.tests))
        return hashlib.sha256(text.encode()).hexdigest()[:16]


_SRC = "python/sigmatau"

MUTATIONS = (
    # Estimators
    Mutation(
        "total-bias",
        "digits of a constant exchanged: bias of the total deviation, flicker noise",
        f"{_SRC}/estimators/deviation_kinds.py",
        '"bias_instability": 0.481',
        '"bias_instability": 0.841',
        ("tests/estimators/test_deviations.py", "tests/estimators/test_deviation_curves.py"),
    ),
    Mutation(
        "gaps-walk",
        "sign in the variance of a random walk beyond the computed correlation times",
        f"{_SRC}/estimators/gaps.py",
        "* 6 * size / (2 * float(size) ** 2 + 1)",
        "* 6 * size / (2 * float(size) ** 2 - 1)",
        ("tests/estimators/test_gaps.py",),
    ),
    Mutation(
        "dynamic-middle",
        "times of the dynamic Allan variance are beginnings, not middles, of the windows",
        f"{_SRC}/estimators/stability.py",
        "(np.arange(count) * stride + n / 2) * tau0",
        "(np.arange(count) * stride) * tau0",
        ("tests/estimators/test_stability.py",),
    ),
    # Noise
    Mutation(
        "percentage-error",
        "eq. (26) without its −1",
        f"{_SRC}/noise/uncertainty.py",
        "1 / np.sqrt(2 * (n / sizes - 1))",
        "1 / np.sqrt(2 * n / sizes)",
        ("tests/noise/test_uncertainty.py",),
    ),
    Mutation(
        "chi2-sides",
        "ends of an interval exchanged",
        f"{_SRC}/noise/uncertainty.py",
        "for side in (1, -1)]",
        "for side in (-1, 1)]",
        ("tests/noise/test_uncertainty.py",),
    ),
    # State space
    Mutation(
        "sinusoid-power",
        "initial covariance of a sinusoid is A², not A²/2",
        f"{_SRC}/statespace/state_space.py",
        "p0 = amplitude**2 / 2 * np.eye(2)",
        "p0 = amplitude**2 * np.eye(2)",
        ("tests/statespace/test_state_space.py",),
    ),
    Mutation(
        "increments-noise",
        "white noise of increments scaled by dt instead of dt²",
        f"{_SRC}/statespace/state_space.py",
        'white if output == "rate" else white * dt**2',
        'white if output == "rate" else white * dt',
        ("tests/statespace/test_state_space.py",),
    ),
    Mutation(
        "arma-drift",
        "drift of an ARMA process without the factor of its autoregressive part",
        f"{_SRC}/statespace/arma.py",
        "drift=ramp * dt * float(np.prod(1 - ar_roots).real)",
        "drift=ramp * dt",
        ("tests/statespace/test_arma.py",),
    ),
    # Spectrum
    Mutation(
        "welch-half-rate",
        "degrees of freedom halved at half the rate for odd instead of even segments",
        f"{_SRC}/spectrum/estimate.py",
        "if length % 2 == 0:",
        "if length % 2 == 1:",
        ("tests/spectrum/test_spectrum.py", "tests/spectrum/test_coverage.py"),
        added=True,
    ),
    Mutation(
        "coherence-pairs",
        "significance of the coherence counts degrees of freedom instead of pairs",
        f"{_SRC}/spectrum/cross.py",
        "law.significance(self.dof / 2, level=level)",
        "law.significance(self.dof, level=level)",
        ("tests/spectrum/test_cross.py",),
    ),
    Mutation(
        "cross-sign",
        "sign of the phase of a cross-spectrum (Welch)",
        f"{_SRC}/spectrum/cross.py",
        "crossed += (of_x.conj() * of_y).sum(axis=0)",
        "crossed += (of_x * of_y.conj()).sum(axis=0)",
        ("tests/spectrum/test_cross.py", "tests/spectrum/test_transfer.py"),
    ),
    # Navigation
    Mutation(
        "tilt-sign",
        "sign of the tilt's acceleration on the y axis",
        f"{_SRC}/navigation/error_covariance.py",
        '"accel_y": ("gyro_x", -1.0)',
        '"accel_y": ("gyro_x", 1.0)',
        ("tests/navigation/test_predict.py",),
        added=True,
    ),
    Mutation(
        "vertical-gravity",
        "decrease of gravity with height is g/R, not 2g/R",
        f"{_SRC}/navigation/error_covariance.py",
        "2 * GRAVITY * curvature if axis",
        "GRAVITY * curvature if axis",
        ("tests/navigation/test_predict.py",),
    ),
    Mutation(
        "correlated-axes",
        "errors of correlated sensors are counted twice",
        f"{_SRC}/navigation/predict.py",
        "correlation * (both - apart)",
        "correlation * both",
        ("tests/navigation/test_predict.py",),
    ),
    # Simulation
    Mutation(
        "day-length",
        "temperature swings with a period of two days",
        f"{_SRC}/simulation/imperfections.py",
        "np.sin(2 * math.pi * t / _DAY)",
        "np.sin(math.pi * t / _DAY)",
        ("tests/simulation/test_imperfections.py",),
    ),
    Mutation(
        "correlation-root",
        "square root of a correlation matrix without the columns before",
        f"{_SRC}/simulation/rows.py",
        "left = matrix[j:, j] - root[j:, :j] @ root[j, :j]",
        "left = matrix[j:, j]",
        ("tests/simulation/test_generators.py", "tests/simulation/test_simulation.py"),
    ),
    # Readers
    Mutation(
        "suffix-mdps",
        "columns named ..._mdps read as deg/s",
        f"{_SRC}/io/read/names.py",
        '**dict.fromkeys(("mdps", "mdeg_s"), "mdeg/s")',
        '**dict.fromkeys(("mdps", "mdeg_s"), "deg/s")',
        ("tests/io/test_columns.py",),
        added=True,
    ),
    Mutation(
        "layout-half",
        "a row of which exactly half are numbers is taken for text",
        f"{_SRC}/io/read/formats/layout.py",
        "2 * (numbers + missing) >= len(fields)",
        "2 * (numbers + missing) > len(fields)",
        ("tests/io/test_text_tables.py", "tests/io/test_dialects.py"),
        added=True,
    ),
    Mutation(
        "layout-skip",
        "the first row of numbers is skipped",
        f"{_SRC}/io/read/formats/layout.py",
        "skip_lines=first.number - 1,",
        "skip_lines=first.number,",
        ("tests/io/test_text_tables.py",),
    ),
    Mutation(
        "novatel-week",
        "digits exchanged in the length of a GPS week",
        f"{_SRC}/io/read/formats/novatel.py",
        "_WEEK_NS = 604_800_000_000_000",
        "_WEEK_NS = 608_400_000_000_000",
        ("tests/io/test_novatel.py",),
        added=True,
    ),
    Mutation(
        "novatel-scale",
        "angle of the ISA-100C ten times too large",
        f"{_SRC}/io/read/formats/novatel.py",
        '26: ("ISA-100C", 1e-9, 2e-8)',
        '26: ("ISA-100C", 1e-8, 2e-8)',
        ("tests/io/test_novatel.py",),
        added=True,
    ),
    Mutation(
        "rate-mismatch",
        "sign of the effect of a wrong rate on the random walk",
        f"{_SRC}/io/read/time/stamps.py",
        '"random_walk": -0.5,',
        '"random_walk": 0.5,',
        ("tests/io/test_stamps.py",),
    ),
    Mutation(
        "dataflash-hundredths",
        "one of ArduPilot's types in hundredths is read as whole numbers",
        f"{_SRC}/io/read/formats/dataflash.py",
        '_HUNDREDTHS = "cCeE"',
        '_HUNDREDTHS = "cCe"',
        ("tests/io/test_dataflash.py",),
        added=True,
    ),
    Mutation(
        "gap-start",
        "a gap begins one sample too early",
        f"{_SRC}/io/read/time/stamps.py",
        "start=float(found.places[k] + 1) * tau0",
        "start=float(found.places[k]) * tau0",
        ("tests/io/test_stamp_losses.py", "tests/io/test_stamps.py"),
    ),
    Mutation(
        "jitter-factor",
        "quantization noise by jitter of the smallest mean",
        f"{_SRC}/io/read/time/timing.py",
        "np.max(means)",
        "np.min(means)",
        ("tests/io/test_stamp_jitter.py",),
    ),
    Mutation(
        "range-axes",
        "gyro=2:4 names the axes in the order x, z, y",
        f"{_SRC}/io/read/columns.py",
        'for k, axis in enumerate("xyz")]',
        'for k, axis in enumerate("xzy")]',
        ("tests/io/test_columns.py", "tests/io/test_text_tables.py"),
    ),
    # Checks
    Mutation(
        "rounding-variance",
        "variance of rounding is S²/6, not S²/12",
        f"{_SRC}/quality/samples/resolution.py",
        "square = found.step**2 * tau0 / 12",
        "square = found.step**2 * tau0 / 6",
        ("tests/quality/test_resolution.py",),
    ),
    Mutation(
        "saturation-channel",
        "finding of saturation without a channel",
        f"{_SRC}/quality/samples/saturation.py",
        "channels=(channel,),",
        "channels=(),",
        ("tests/quality/test_stuck_samples.py", "tests/quality/test_findings.py"),
    ),
    Mutation(
        "steps-walk",
        "rate random walk of steps divided by samples instead of seconds",
        f"{_SRC}/quality/samples/shocks_and_steps.py",
        "for change in changes) / stream.grid.duration",
        "for change in changes) / stream.grid.n",
        ("tests/quality/test_shocks_and_steps.py",),
    ),
    Mutation(
        "cusum-place",
        "change of the noise is told one block too early",
        f"{_SRC}/quality/drift/stationarity.py",
        "at=int((keep[k] + 1) * length)",
        "at=int(keep[k] * length)",
        ("tests/quality/test_stationarity.py",),
        added=True,
    ),
    Mutation(
        "warm-up-sign",
        "a warm-up is added to the samples that are tested for steps, not taken off",
        f"{_SRC}/quality/drift/without_drifts.py",
        "x - fitted.warm_up.amplitude.value",
        "x + fitted.warm_up.amplitude.value",
        ("tests/quality/test_fit_findings.py",),
    ),
    Mutation(
        "leave-out-lead",
        "sign of the time by which a stream begins later than the record",
        f"{_SRC}/quality/selection/exclusion.py",
        "(time - stream.grid.lead) / stream.grid.tau0",
        "(time + stream.grid.lead) / stream.grid.tau0",
        ("tests/quality/test_exclusion.py",),
    ),
    Mutation(
        "shock-of-one",
        "a shock is left out of the sensor that shows it only",
        f"{_SRC}/quality/check.py",
        "mask |= samples(name)",
        "mask &= samples(name)",
        ("tests/quality/test_exclusion.py",),
    ),
    # Exports
    Mutation(
        "kf-gins-time",
        "correlation time for KF-GINS in minutes instead of hours",
        f"{_SRC}/exporting/targets/kf_gins.py",
        "digits(time / 3600)",
        "digits(time / 60)",
        ("tests/exporting/test_export_simulators.py",),
    ),
    Mutation(
        "process-density",
        "driving noise of a Gauss-Markov process without √2",
        f"{_SRC}/exporting/gauss_markov.py",
        "self.sigma * math.sqrt(2 / self.time)",
        "self.sigma * math.sqrt(1 / self.time)",
        ("tests/exporting/test_export_process.py", "tests/exporting/test_export_simulators.py"),
    ),
    Mutation(
        "ros-quantization",
        "variance of quantization noise in ROS messages halved",
        f"{_SRC}/exporting/targets/ros.py",
        "return 2 * (q * numbers.rate()) ** 2",
        "return (q * numbers.rate()) ** 2",
        ("tests/exporting/test_export_ros.py",),
    ),
    Mutation(
        "axes-mean",
        "root mean square over axes is not divided by their number",
        f"{_SRC}/exporting/values.py",
        "for number in by_axis.values()) / len(by_axis))",
        "for number in by_axis.values()))",
        ("tests/exporting/test_export_doubts.py", "tests/exporting/test_export_simulators.py"),
    ),
    Mutation(
        "gtsam-walk",
        "GTSAM: the walk of single accelerometer axes is their white noise",
        f"{_SRC}/exporting/targets/gtsam.py",
        '"accel", numbers.walk, numbers.walk_of,',
        '"accel", numbers.walk, numbers.noise_of,',
        ("tests/exporting/test_vio_files.py", "tests/exporting/test_vio_propagation.py"),
    ),
    # Findings
    Mutation(
        "window-rounding",
        "an advised window begins before the place that it should leave out",
        f"{_SRC}/findings/wording/phrases.py",
        "_in_seconds(start, math.ceil)",
        "_in_seconds(start, math.floor)",
        ("tests/findings/test_words.py",),
        added=True,
    ),
    Mutation(
        "largest-factor",
        "of the effects of a line only increases count",
        f"{_SRC}/findings/wording/spectrum.py",
        "max(one[1], 1 / one[1])",
        "one[1]",
        ("tests/findings/test_words.py",),
        added=True,
    ),
    Mutation(
        "severity-order",
        "a model that is not adequate is named last of the warnings",
        f"{_SRC}/findings/finding.py",
        "finding.code != _FIRST",
        "finding.code == _FIRST",
        ("tests/test_results.py",),
        added=True,
    ),
    # Command line
    Mutation(
        "plan-hours",
        "--hours of plan counts minutes",
        f"{_SRC}/cli/plan.py",
        "else 3600 * hours",
        "else 60 * hours",
        ("tests/fitting/test_planning.py", "tests/cli/test_cli.py"),
    ),
    Mutation(
        "compare-exit",
        "exit code of a failed unit hides files that cannot be used",
        f"{_SRC}/cli/compare.py",
        "return _UNUSABLE if errors else _OUT if failed else 0",
        "return _OUT if failed else _UNUSABLE if errors else 0",
        ("tests/datasheets/test_commands.py",),
    ),
    Mutation(
        "turn-on-order",
        "--turn-on of one channel does not overrule that of its sensor",
        f"{_SRC}/cli/predict.py",
        "if name not in found or key == name:",
        "if name not in found:",
        ("tests/navigation/test_predict_command.py",),
        added=True,
    ),
    # Fitting
    Mutation(
        "gls-freedom",
        "goodness of fit counts no fitted coefficients in its degrees of freedom",
        f"{_SRC}/fitting/gls.py",
        "freedom = max(len(self.avar) - int((theta > 0).sum()), 1)",
        "freedom = max(len(self.avar), 1)",
        ("tests/fitting/test_inference.py", "tests/fitting/test_fit.py"),
        added=True,
    ),
    Mutation(
        "gls-misfit",
        "goodness of fit takes the larger of two misfits",
        f"{_SRC}/fitting/gls.py",
        "misfit = min(self._squares(covariance",
        "misfit = max(self._squares(covariance",
        ("tests/fitting/test_inference.py", "tests/fitting/test_fit.py"),
    ),
    Mutation(
        "inference-gamma-shape",
        "shape of the gamma law of a skewed statistic is halved",
        f"{_SRC}/fitting/inference.py",
        "shape = 4 / skewness**2",
        "shape = 2 / skewness**2",
        ("tests/fitting/test_inference.py",),
    ),
    Mutation(
        "components-pairs",
        "covariance of two different terms counted once instead of twice",
        f"{_SRC}/fitting/components.py",
        "(1 if p == q else 2) * tensors[p, q]",
        "1 * tensors[p, q]",
        ("tests/fitting/test_components.py",),
    ),
    Mutation(
        "ramp-one-sided",
        "p-value of a ramp is one-sided",
        f"{_SRC}/fitting/ramp.py",
        "p_value = 2 * float(stdtr(",
        "p_value = float(stdtr(",
        ("tests/fitting/test_fit.py", "tests/fitting/test_inference.py"),
        added=True,
    ),
    Mutation(
        "tau-min-least-times",
        "one averaging time more than the minimum is required of a later start",
        f"{_SRC}/fitting/tau_min.py",
        "len(data.m) - k >= LEAST_TIMES]",
        "len(data.m) - k > LEAST_TIMES]",
        ("tests/fitting/test_fit.py",),
        added=True,
    ),
    Mutation(
        "read-off-error",
        "error of a value read off is that of the shortest averaging time",
        f"{_SRC}/fitting/read_off.py",
        "delta = float(points.delta[j])",
        "delta = float(points.delta[i])",
        ("tests/fitting/test_read_off.py",),
    ),
    Mutation(
        "plan-relative-error",
        "relative error of a planned coefficient is that of its square",
        f"{_SRC}/fitting/planning.py",
        "[k, k]) / (2 * theta[k]))",
        "[k, k]) / theta[k])",
        ("tests/fitting/test_planning.py",),
        added=True,
    ),
    # Rust
    Mutation(
        "rust-walk-avar",
        "sign in the Allan variance of a sampled rate random walk",
        "crates/core/src/terms.rs",
        "(2.0 * size * size + 1.0) / (6.0 * size)",
        "(2.0 * size * size - 1.0) / (6.0 * size)",
        ("tests/noise/test_terms.py",),
    ),
    Mutation(
        "rust-paper-counting",
        "the counting of the paper includes the last term",
        "crates/core/src/allan.rs",
        "Counting::Paper => phase.samples(),",
        "Counting::Paper => phase.samples() + 1,",
        ("tests/estimators/test_allan.py",),
    ),
    Mutation(
        "rust-flicker-psd",
        "density of sampled flicker noise twice too large",
        "crates/core/src/psd.rs",
        "b * b * tau0 / (2.0 * (PI * f * tau0).sin().abs())",
        "b * b * tau0 / (PI * f * tau0).sin().abs()",
        ("tests/noise/test_terms.py",),
    ),
    Mutation(
        "rust-ramp-scale",
        "ramp of the second differences divided by n instead of n²",
        "crates/core/src/trend.rs",
        "mean / size / size",
        "mean / size",
        ("tests/estimators/test_allan.py",),
    ),
    Mutation(
        "rust-time-zone",
        "sign of the time zone of a date",
        "crates/formats/src/date.rs",
        "if sign == b'-' { -ahead } else { ahead }",
        "if sign == b'-' { ahead } else { -ahead }",
        ("tests/io/test_stamp_text.py",),
    ),
    Mutation(
        "rust-dataflash-undo",
        "the message before a damaged place is counted though it is given up",
        "crates/formats/src/dataflash.rs",
        "Undo::Row(place, instance) => counts[place][usize::from(instance)] -= 1,",
        "Undo::Row(_, _) => {}",
        ("tests/io/test_dataflash.py",),
    ),
)


def main(arguments: Sequence[str] = ()) -> int:
    """Put in every bug that has no result yet, and write the page; 1 if one is not found."""
    check_changes(ROOT)
    if "--check" in arguments:
        return 0
    results: dict[str, Any] = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    again = set(arguments) - {"--again"}
    for one in MUTATIONS:
        if one.name in again:
            results.pop(one.key, None)
    if not all(_finished(results.get(one.key)) for one in MUTATIONS):
        with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
            copies = [Copy(Path(folder) / str(k)) for k in range(2)]
            while left := [one for one in MUTATIONS if one.key not in results]:
                _try_named_tests(copies, left, results)
                _forget_red(copies, results)
            if left := [one for one in MUTATIONS if not _finished(results[one.key])]:
                every = dict.fromkeys(path for one in left for path in _neighbours(one))
                copies[0].red |= copies[0].red_of(tuple(every))
                for one in left:
                    _try(copies[0], one, results, neighbours=True)
    _write_page(results)
    missed = [one.name for one in MUTATIONS if results[one.key]["test"] is None]
    sys.stderr.write(f"mutations: {len(MUTATIONS) - len(missed)} of {len(MUTATIONS)} found\n")
    for name in missed:
        sys.stderr.write(f"mutations: not found: {name}\n")
    return 1 if missed else 0


def _finished(result: dict[str, Any] | None) -> bool:
    return result is not None and (result["test"] is not None or result["neighbours"])


def _try_named_tests(copies: Sequence[Copy], bugs: Sequence[Mutation], results: dict[str, Any]) -> None:
    """Try the tests named for some bugs, in several copies at the same time; the first one compiles all of Rust."""
    rust = [one for one in bugs if one.file.startswith("crates/")]
    others = [one for one in bugs if one not in rust]

    def work(copy: Copy, own: list[Mutation]) -> None:
        while own or others:
            _try(copy, own.pop(0) if own else others.pop(0), results, neighbours=False)

    with ThreadPoolExecutor(len(copies)) as pool:
        done = [pool.submit(work, copy, rust if k == 0 else []) for k, copy in enumerate(copies)]
    for one in done:
        one.result()


def _try(copy: Copy, one: Mutation, results: dict[str, Any], *, neighbours: bool) -> None:
    """Put in a bug, run tests, and keep the result."""
    start = time.monotonic()
    test = copy.first_failure(one, neighbours=neighbours)
    spent = time.monotonic() - start + results.get(one.key, {"seconds": 0.0})["seconds"]
    with _LOCK:
        results[one.key] = {"name": one.name, "test": test, "seconds": round(spent, 1), "neighbours": neighbours}
        _keep(results)
    sys.stderr.write(f"mutations: {len(results)} {one.name}: {test or 'not found'} ({spent:.0f} s)\n")


def _keep(results: dict[str, Any]) -> None:
    RESULTS.parent.mkdir(exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    _write_page(results)


def _forget_red(copies: Sequence[Copy], results: dict[str, Any]) -> None:
    """Forget the results that are a test that fails without the bug too; it is not run again."""
    new = {r["test"] for r in results.values() if r["test"] and not r.get("clean")}
    red = copies[0].red_of(sorted(new))
    for copy in copies:
        copy.red |= red
    for key, result in list(results.items()):
        if result["test"] in red:
            sys.stderr.write(f"mutations: {result['test']} fails without a bug\n")
            del results[key]
        elif result["test"]:
            result["clean"] = True
    _keep(results)


def check_changes(root: Path) -> None:
    """Raise ValueError unless every change fits exactly one place of its file, and names are unique."""
    wrong = [
        f"{one.name}: {one.file} has {found} times {one.old!r}"
        for one in MUTATIONS
        if (found := (root / one.file).read_text(encoding="utf-8").count(one.old) if (root / one.file).exists() else 0)
        != 1
    ]
    if len({one.name for one in MUTATIONS}) < len(MUTATIONS):
        wrong.append("two mutations have one name")
    if wrong:
        raise ValueError("; ".join(wrong))


class Copy:
    """A copy of the tree in which bugs are put and tests are run."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.red: set[str] = set()  # tests that fail without a bug
        root.mkdir()
        unused = shutil.ignore_patterns("__pycache__", "target", "corpus", "artifacts", "coverage", ".*_cache")
        for name in _COPIED:
            shutil.copytree(ROOT / name, root / name, ignore=unused)
        for file in ROOT.iterdir():
            if file.is_file():
                shutil.copy2(file, root / file.name)

    def first_failure(self, one: Mutation, *, neighbours: bool) -> str | None:
        """The first test that finds a bug, as ``file::test``; None if none does.

        The tests are those named for the bug, or those of the room and its neighbours.
        """
        paths = _neighbours(one) if neighbours else one.tests
        workers = 2 if neighbours else 0
        file = self.root / one.file
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(one.old, one.new), encoding="utf-8")
        try:
            if one.file.startswith("crates/"):
                return self._in_rust(one, paths, workers)
            return next(iter(self._failed(paths, workers)), None)
        finally:
            file.write_text(text, encoding="utf-8")

    def red_of(self, tests: Sequence[str]) -> set[str]:
        """Those of some tests that fail without a bug."""
        return set(self._failed([name for name in tests if name.startswith("tests/")], 2, stop=False))

    def _failed(self, paths: Sequence[str], workers: int, *, stop: bool = True) -> list[str]:
        """Tests that fail, up to the first one or all."""
        if not paths:
            return []
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--tb=no", "-r", "fE"]
        command += ["-n", str(workers), *["-x"] * stop]
        command += [f"--deselect={name}" for name in sorted(self.red)]
        done = self._run([*command, *paths])
        failed = [re.sub(r"^(?:FAILED|ERROR) ", "", row) for row in done.stdout.splitlines() if row[:6] in _FAILURE]
        if done.returncode == _NOTHING_RUN:  # all of them are skipped, for want of a package
            return []
        if done.returncode not in (0, 1, 2) or (done.returncode and not failed):
            raise RuntimeError(f"pytest {' '.join(paths)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return [_node(row) for row in failed]

    def _in_rust(self, one: Mutation, paths: Sequence[str], workers: int) -> str | None:
        crate = one.file.split("/")[1]
        if not workers and (failed := self._failed_in_crate(crate)):
            return failed
        extension = next((self.root / "python" / "sigmatau").glob("_core*.so"))
        before = extension.read_bytes()
        built = self._run(["cargo", "build", "--release", "--locked", "--quiet", "-p", "sigmatau-py"])
        if built.returncode:
            raise RuntimeError(f"{one.name}: cannot be built\n{built.stderr}")
        library = next(p for p in (TARGET / "release").iterdir() if p.suffix in (".so", ".dylib"))
        try:
            extension.write_bytes(library.read_bytes())
            found = self._failed(paths, workers)
        finally:
            extension.write_bytes(before)
        return found[0] if found else None

    def _failed_in_crate(self, crate: str) -> str | None:
        command = ["cargo", "test", "--release", "--locked", "--quiet", "-p", f"sigmatau-{crate}", "--lib", "--tests"]
        done = self._run(command)
        if not done.returncode:
            return None
        failed = re.search(r"^test (\S+) \.\.\. FAILED|^---- (\S+) stdout|^    (\w\S+::\w+)$", done.stdout, re.M)
        if failed is None:
            raise RuntimeError(f"{crate}: cargo test ended without a failed test\n{done.stdout}{done.stderr}")
        return f"crates/{crate}::{next(filter(None, failed.groups()))}"

    def _run(self, command: Sequence[str]) -> subprocess.CompletedProcess[str]:
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.root / "python"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "CARGO_TARGET_DIR": str(TARGET),
            "CARGO_BUILD_JOBS": "2",
            "PYO3_PYTHON": sys.executable,
            "SIGMATAU_FIELD_DATA": os.environ.get("SIGMATAU_FIELD_DATA", str(ROOT.parent / "shared" / "data")),
        }
        nice = ["nice", "-n", "5"] if shutil.which("nice") else []
        return subprocess.run(
            [*nice, *command], cwd=self.root, env=environment, capture_output=True, text=True, check=False
        )


_FAILURE = ("FAILED", "ERROR ")  # first words of a line of pytest's summary
_NOTHING_RUN = 5  # exit code of pytest


def _node(row: str) -> str:
    """``file::test`` of a row of pytest's summary, whose message follows after a dash."""
    return row.split(" - ")[0].strip()


def _neighbours(one: Mutation) -> list[str]:
    """Tests that are tried if those named do not find a bug."""
    room = "io" if one.room == "crates/formats" else "estimators" if one.room == "crates/core" else one.room
    folders = dict.fromkeys((room, "quality", "cli"))
    found = [f"tests/{name}" for name in folders if (ROOT / "tests" / name).is_dir()]
    return found + [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").glob("test_*.py"))]


def _write_page(results: dict[str, Any]) -> None:
    """The table of all bugs with a result."""
    known = [(one, results[one.key]) for one in MUTATIONS if one.key in results]
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.strip()
    found = sum(result["test"] is not None for _, result in known)
    added = sum(one.added for one, _ in known)
    lines = [_HEAD.format(date=dt.datetime.now(tz=dt.UTC).date(), commit=commit)]
    lines.append(f"{found} of {len(known)} bugs were found.")
    if added:
        lines[-1] += (
            f' {added} were missed at first by the tests of their module (no others ran); "test added" marks the new tests.'
        )
    lines += ["", "| room | bug | found by | time [s] |", "|---|---|---|---|"]
    for one, result in known:
        test = "not found" if result["test"] is None else f"`{_short(result['test'])}`"
        more = " (test added)" if one.added else ""
        lines.append(f"| {one.room} | {one.bug} | {test}{more} | {result['seconds']:.0f} |")
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _short(test: str) -> str:
    """A test without the folder of all tests and without its parameters."""
    return test.removeprefix("tests/").split("[")[0]


_HEAD = """# Does the test suite find bugs?

Made by `python -m studies.mutations` (studies/mutations.py) on {date}, commit {commit}.

Small, realistic bugs were put into the code, one at a time: a wrong sign, a lost factor 2, an index off by one, a wrong
unit, exchanged arguments, a finding without its channel. They were chosen before it was known which tests find them. The
table names the first test that fails with the bug and passes without it, and the time until it failed, compilation included.
First the tests of the same module run; if none fails, those of the room, `tests/quality`, `tests/cli` and `tests/test_*.py`.
"""


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
