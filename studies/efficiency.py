"""Bias, spread and efficiency of the coefficients: generalised least squares compared with common methods."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import sigmatau as st
from sigmatau._native.gls import Components, Gls, non_negative
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.deviation_kinds import TauGrid, cluster_sizes
from sigmatau.fitting.components import power_of_interval
from sigmatau.noise.terms import NOISE
from studies.gmwm import gmwm
from studies.mixtures import GRADES, crb
from studies.runner import run

RECORDS = 400
GMWM_RECORDS = 96
PARTS = 8
WELL = 0.15
"""Relative standard deviation, by the theory of the estimator, below which a cell is well determined."""

Floats = NDArray[np.float64]
GRIDS: dict[str, TauGrid] = {"MEMS": "half", "tactical": "half", "navigation": "eighth"}
METHODS = (
    "likelihood, terms known",
    "likelihood, as analyze does it",
    "GLS, terms known",
    "wavelet moments",
    "GMWM, full weights",
    "diagonal weights",
    "unweighted log fit",
    "read off",
)


def cell(seed: int, name: str) -> list[dict[str, dict[str, float]]]:
    """Coefficients of each record by every method: ``[{method: {term: value}}]``; a term that was not observed is absent."""
    mixture = GRADES[name]
    model = st.NoiseModel(channels={mixture.channel: mixture.truth})
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(RECORDS // PARTS):
        record = st.simulate(model, duration=mixture.n / mixture.rate, rate=mixture.rate, rng=rng)
        curve = st.allan(record, taus=GRIDS[name], threads=1)[mixture.channel]
        analysis = st.analyze(record, threads=1)
        read = st.read_off(analysis.curves[mixture.channel])  # read off by the rules, without the fit
        likelihood = st.fit_channel(record, mixture.channel, terms=list(mixture.truth), processes=[], threads=1)
        octaves = st.allan(record, taus="octave", threads=1)[mixture.channel]
        results.append(
            {
                "likelihood, terms known": _values(likelihood, mixture.truth),
                "likelihood, as analyze does it": analysis.fits[mixture.channel].observed,
                "GLS, terms known": _with_known_terms(curve, mixture.truth),
                "wavelet moments": _diagonal(octaves, mixture.truth),
                "diagonal weights": _diagonal(analysis.curves[mixture.channel], mixture.truth),
                "unweighted log fit": _logarithmic(analysis.curves[mixture.channel], mixture.truth),
                "read off": {term: read[term].value for term in mixture.truth if term in read},
            }
        )
    return results


def gmwm_cell(seed: int, name: str) -> list[dict[str, float]]:
    """Coefficients of other records of the same mixture by the generalised method of wavelet moments."""
    mixture = GRADES[name]
    model = st.NoiseModel(channels={mixture.channel: mixture.truth})
    rng = np.random.default_rng(seed)
    results = []
    for _ in range(GMWM_RECORDS // PARTS):
        record = st.simulate(model, duration=mixture.n / mixture.rate, rate=mixture.rate, rng=rng)
        samples = record.stream_of(mixture.channel).column(mixture.channel)
        results.append(gmwm(samples, list(mixture.truth), 1 / mixture.rate))
    return results


def main() -> None:
    """Run the study and write docs/study/efficiency.md."""
    settings = repr((RECORDS, GRADES, GRIDS))
    cells = {f"{name} {k}": (cell, (name,)) for name in GRADES for k in range(PARTS)}
    results = run("efficiency", cells, settings=settings)
    moments = run(
        "efficiency-gmwm",
        {f"gmwm {name} {k}": (gmwm_cell, (name,)) for name in GRADES for k in range(PARTS)},
        settings=repr((GMWM_RECORDS, GRADES)),
    )
    lines = [_HEAD.format(records=RECORDS, gmwm_records=GMWM_RECORDS, well=100 * WELL)]
    failures = []
    for name, mixture in GRADES.items():
        records = [record for k in range(PARTS) for record in results[f"{name} {k}"]]
        by_moments = [record for k in range(PARTS) for record in moments[f"gmwm {name} {k}"]]
        bound, theory = _theory(name)
        for k, (term, truth) in enumerate(mixture.truth.items()):
            for method in METHODS:
                found = by_moments if method == "GMWM, full weights" else [record[method] for record in records]
                values = np.array([record[term] for record in found if term in record]) / truth
                row, failed = _row(name, term, method, values, bound[k], theory[k])
                lines.append(row)
                failures += failed
    lines += ["", "## Gates", "", *(failures or ["All gates are met."])]
    Path("docs/study/efficiency.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _row(name: str, term: str, method: str, values: Floats, bound: float, theory: float) -> tuple[str, list[str]]:
    if len(values) < 2:
        return f"| {name} | {term} | {method} | {len(values)} | | | | | |", []
    bias, sd = values.mean() - 1, values.std(ddof=1)
    share = 100 * len(values) / (GMWM_RECORDS if method == "GMWM, full weights" else RECORDS)
    failed = []
    terms_known = method == "GLS, terms known"
    if terms_known and theory < WELL:
        error = sd / math.sqrt(2 * (len(values) - 1))
        if abs(sd - theory) > 3 * error:
            failed.append(f"- {name} {term}: sd {100 * sd:.3g} % is not the theory's {100 * theory:.3g} %")
        if abs(bias) > 0.1 * sd + 3 * sd / math.sqrt(len(values)):
            failed.append(f"- {name} {term}: bias {100 * bias:.3g} % beside sd {100 * sd:.3g} %")
        if (bound / theory) ** 2 < 0.7:
            failed.append(f"- {name} {term}: efficiency {100 * (bound / theory) ** 2:.0f} %")
    in_theory = f"{100 * theory:.3g}" if terms_known else ""
    efficiency_of_theory = f"{100 * (bound / theory) ** 2:.0f}" if terms_known else ""
    efficiency = (bound / math.hypot(sd, bias)) ** 2
    if (
        method == "likelihood, terms known"
        and bound < WELL
        and efficiency < 0.9 - 3 * efficiency * math.sqrt(2 / len(values))
    ):
        failed.append(f"- {name} {term}, likelihood: efficiency {100 * efficiency:.0f} %")
    return (
        f"| {name} | {term} | {method} | {share:.0f} | {100 * bias:+.2g} | {100 * sd:.3g} | {in_theory} |"
        f" {100 * efficiency:.0f} | {efficiency_of_theory} |"
    ), failed


def _theory(name: str) -> tuple[Floats, Floats]:
    """Relative standard deviations: the Cramér-Rao bound, and that of this estimator."""
    mixture = GRADES[name]
    tau0 = 1 / mixture.rate
    sizes = cluster_sizes(GRIDS[name], n=mixture.n, tau0=tau0)
    parts = Components(mixture.n, tuple(int(m) for m in sizes if m <= mixture.n // 3))
    theta = _theta(mixture.truth, tau0)
    active = [int(p) for p in np.flatnonzero(theta)]
    covariance = Gls(parts, parts.design @ theta).covariance_of_theta(theta, active)
    return crb(parts.spectra, parts.modes, theta), np.sqrt(np.diag(covariance)) / (2 * theta[active])


def _theta(truth: Mapping[str, float], tau0: float) -> Floats:
    return np.array([truth.get(name, 0.0) ** 2 * tau0 ** (power_of_interval(name) - 2) for name in NOISE])


def _parts(curve: DeviationCurve) -> tuple[Components, Floats]:
    used = curve.m <= curve.n // 3
    return Components(curve.n, tuple(int(m) for m in curve.m[used])), curve.avar[used]


def _coefficients(theta: Floats, terms: Collection[str], tau0: float) -> dict[str, float]:
    return {
        name: math.sqrt(theta[p]) * tau0 ** (1 - power_of_interval(name) / 2)
        for p, name in enumerate(NOISE)
        if name in terms
    }


def _relative_fit(columns: Floats, avar: Floats, errors: Floats) -> Floats:
    """Non-negative θ fitted to a curve with independent relative errors."""
    weights = 1 / (errors * avar)
    return non_negative(columns * weights[:, None], avar * weights)


def _values(fit: st.NoiseFit, terms: Collection[str]) -> dict[str, float]:
    """The values of all terms, observed or not."""
    return {term: value for term in terms if (value := fit.terms[term].value) is not None}


def _with_known_terms(curve: DeviationCurve, terms: Collection[str]) -> dict[str, float]:
    parts, avar = _parts(curve)
    active = [p for p, name in enumerate(NOISE) if name in terms]
    return _coefficients(Gls(parts, avar, active).fit(), terms, curve.tau0)


def _diagonal(curve: DeviationCurve, terms: Collection[str]) -> dict[str, float]:
    """Fit with each variance weighted by its degrees of freedom for the fitted model, as if neighbours were independent."""
    parts, avar = _parts(curve)
    active = [p for p, name in enumerate(NOISE) if name in terms]
    theta = np.zeros(len(NOISE))
    theta[active] = _relative_fit(parts.design[:, active], avar, np.ones(len(avar)))
    for _ in range(8):
        errors = np.sqrt(2 / parts.degrees_of_freedom(theta, ramp=0.0))
        expected = parts.design @ theta
        theta[active] = _relative_fit(parts.design[:, active], avar, errors * expected / avar)
    return _coefficients(theta, terms, curve.tau0)


def _logarithmic(curve: DeviationCurve, terms: Collection[str]) -> dict[str, float]:
    """Least squares on log σ with the same weight for every averaging time, as in most scripts."""
    from scipy.optimize import least_squares

    parts, avar = _parts(curve)
    active = [p for p, name in enumerate(NOISE) if name in terms]
    design = parts.design[:, active]
    begin = np.maximum(_relative_fit(design, avar, np.ones(len(avar))), 1e-12 * avar.min() / design.max(axis=0))

    def residuals(x: Floats) -> Floats:
        return np.asarray(np.log(design @ np.exp(x)) - np.log(avar))

    solution = least_squares(residuals, np.log(begin), max_nfev=200)
    theta = np.zeros(len(NOISE))
    theta[active] = np.exp(solution.x)
    return _coefficients(theta, terms, curve.tau0)


_HEAD = """# Bias, spread and efficiency of the coefficients

Made by `make study` (studies/efficiency.py) with {records} simulated records of each mixture; the seeds are derived from
the names of the cases. Bias and standard deviation are in per cent of the true coefficient. Efficiency is the squared
ratio of the Cramér-Rao bound to the root mean square error. In the last column it is the squared ratio of the bound to
the standard deviation by the theory of the estimator, which follows from the covariance of the Allan variances and the
weights without simulation. A term is well determined if its theoretical standard deviation is below {well:.0f} %. For
such terms, theory and simulation must agree within 3 standard errors, the bias must be below a tenth of the standard
deviation (plus 3 standard errors), and the efficiency must be at least 70 %.

- "likelihood, terms known": `fit_channel` with the terms of the mixture and no process.
- "likelihood, as analyze does it": the fit chooses terms and processes.
- In both, a term that is not observed has a limit and no value. It counts only in the records in which it is observed
  ("found"), so the mean of weak terms is too large.
- "GLS, terms known": least squares on the Allan variances with their covariance, all averaging times.
- "wavelet moments": variances of octave averaging times (twice those of Haar wavelets), each weighted by its inverse
  variance, as the generalized method of wavelet moments does ([10.1080/01621459.2013.799920](https://doi.org/10.1080/01621459.2013.799920)).
- "GMWM, full weights": the same with the inverse of the full covariance, written apart from the package
  (studies/gmwm.py); {gmwm_records} other records.
- "diagonal weights": "wavelet moments" with the averaging times of `analyze`.
- "unweighted log fit": least squares on log σ, each averaging time the same weight.
- The gates apply to the rows "GLS, terms known", and the efficiency also to "likelihood, terms known". Efficiencies above
  100 % are due to the scatter of {records} records, to the bound at zero or, for terms observed in a part of them, to the
  selection of records.
- The bound of the navigation-grade random walk is 1.71 %. It is computed from independent modes, which is exact for this
  mixture.

| mixture | term | method | found [%] | bias [%] | sd [%] | sd, theory [%] | efficiency [%] | in theory [%] |
|---|---|---|---|---|---|---|---|---|"""

if __name__ == "__main__":
    main()
