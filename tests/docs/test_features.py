"""docs/coming-from/features.md: every cell of sigmatau has evidence, and the columns of two programs are tried."""

import re

import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT

PAGE = ROOT / "docs" / "coming-from" / "features.md"
Y = np.random.default_rng(1).standard_normal(300)


def rows():
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    table = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    head = next(row for row in table if row[0] == "feature")
    return [dict(zip(head, row, strict=True)) for row in table if len(row) == len(head) and row[1] != "sigmatau"]


@pytest.mark.parametrize("row", rows(), ids=lambda row: row["feature"])
def test_evidence(row):
    """A link to a page of the documentation, whose blocks run, or –."""
    cell = row["sigmatau"]
    if cell == "–":
        assert row["feature"] in ("ITU masks",)
        assert f"- **{row['feature']}**" in PAGE.read_text(encoding="utf-8")
        return
    link = re.fullmatch(r"\[(yes|part)\]\(([^)]+)\)", cell)
    assert link is not None, cell
    assert (PAGE.parent / link[2]).is_file(), link[2]
    assert all(row[name] in ("yes", "–", "part") for name in row if name not in ("feature", "sigmatau"))


def test_all_kinds_are_in_the_table():
    """Every kind is computed under the word of its row."""
    kinds = {
        "Modified Allan, Hadamard, time": ("modified", "hadamard", "time"),
        "Total": ("total",),
        "Modified, Hadamard and time total": ("modified_total", "hadamard_total", "time_total"),
        "Parabolic": ("parabolic",),
        "Theo1": ("theo1",),
        "TheoBR, TheoH": ("theobr", "theoh"),
        "MTIE, TIE rms": ("mtie", "tie_rms"),
    }
    features = {row["feature"] for row in rows()}
    assert set(kinds) <= features
    from sigmatau.estimators.deviation_kinds import KINDS

    assert {kind for names in kinds.values() for kind in names} == set(KINDS)
    record = st.Record.from_arrays(rate=1, y=Y)
    for kind in KINDS:
        assert np.isfinite(st.deviation(record, kind=kind)["y"].deviation).all()


# What is called for a cell of allantools: functions of a record, or a call. Without an entry, a function of such a name is
# looked for, and there is none.
FUNCTIONS = {
    "Allan deviation, overlapped": ("oadev",),
    "Allan deviation, disjoint clusters": ("adev",),
    "Modified Allan, Hadamard, time": ("mdev", "hdev", "ohdev", "tdev"),
    "Total": ("totdev",),
    "Modified, Hadamard and time total": ("mtotdev", "htotdev", "ttotdev"),
    "Parabolic": ("pdev",),
    "Theo1": ("theo1",),
    "MTIE, TIE rms": ("mtie", "tierms"),
    "Interval of a deviation": (lambda peer: peer.ci.confidence_interval(1.0, 10.0)[0],),
    "Noise identification: lag 1, B1, R(n)": (
        lambda peer: peer.ci.autocorr_noise_id(Y, 1, data_type="freq")[1],
        lambda peer: peer.ci.b1(np.cumsum(Y), 4, 1),
        lambda peer: peer.ci.rn(np.cumsum(Y), 4, 1),
    ),
    "Hat of three or more sensors": (
        lambda peer: peer.three_cornered_hat_phase(Y, Y[::-1], -Y - Y[::-1], 1.0, [1], peer.oadev)[1],
    ),
    "Groslambert codeviation": (lambda peer: peer.gcodev(Y, Y, taus=[1])[1],),
    "Deviation of a record with gaps": (lambda peer: peer.gradev(np.cumsum(Y), taus=[1])[1],),
    "Allan deviation of a given density": (
        lambda peer: peer.psd2allan(np.ones(100), f=np.linspace(0.005, 0.5, 100), kind="adev")[1],
    ),
    "Simulation of power-law noise": (lambda peer: peer.noise.white(100), lambda peer: peer.noise.brown(100)),
    "Deviations of live samples": (lambda peer: peer.realtime.oadev_realtime,),
    "ITU masks": (lambda peer: peer.mask,),
}
# Words in the names of functions that would offer a feature.
WORDS = {
    "TheoBR, TheoH": ("theobr", "theoh"),
    "Bias of total, modified total, Hadamard total, Theo1": ("bias",),
    "Deviation against time of day (DAVAR)": ("dynamic", "davar"),
    "Power spectral density": ("welch", "periodogram"),
    "Curve of a file read, fitted, compared": ("curve", "read_"),
    "Curve of a datasheet's figure (SVG, PDF, clicked points)": ("digit", "figure", "svg"),
    "Matérn process simulated and fitted": ("matern", "markov"),
    "Fit of the noise terms": ("fit", "estimate"),
    "Interval or limit of every coefficient": ("fit", "estimate", "limit"),
    "Logs and bags read": ("bag", "read_"),
    "Files for filters": ("kalibr", "export"),
}


@pytest.mark.parametrize("row", rows(), ids=lambda row: row["feature"])
def test_allantools(row):
    import allantools

    feature, cell = row["feature"], row["allantools"]
    if cell == "–":
        names = [name.lower() for module in (allantools, allantools.ci) for name in dir(module)]
        assert not [name for name in names for word in WORDS[feature] if word in name]
        return
    for function in FUNCTIONS[feature]:
        if callable(function):
            result = function(allantools)
            assert callable(result) or not isinstance(result, (float, np.ndarray)) or np.isfinite(result).all()
        else:
            tau, values, _, _ = getattr(allantools, function)(Y, data_type="freq", taus=[2, 10])
            assert len(tau)
            assert np.isfinite(values).all()


def test_allan_variance():
    """The overlapped Allan variance, the fit of a curve without intervals, and simulated noise; nothing else."""
    peer = pytest.importorskip("allan_variance")
    assert {name for name in dir(peer) if not name.startswith("_")} == {
        "avar", "compute_avar", "estimate_parameters", "generate_noise", "noise",
    }  # fmt: skip
    tau, avar = peer.compute_avar(Y, 1.0)
    parameters, _ = peer.estimate_parameters(tau, avar)
    assert np.isfinite(np.asarray(parameters, dtype=float)).all()
    assert np.asarray(parameters).ndim == 1, "no intervals"
    assert np.isfinite(peer.generate_noise(1.0, 100, rng=1)).all()
    offered = {row["feature"] for row in rows() if row["allan-variance"] != "–"}
    assert offered == {
        "Allan deviation, overlapped",
        "Curve of a file read, fitted, compared",
        "Fit of the noise terms",
        "Simulation of power-law noise",
    }
