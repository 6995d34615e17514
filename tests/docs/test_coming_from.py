"""docs/coming-from: the comparison with allantools, and the conversions of the other pages."""

import re

import numpy as np
import pytest

import sigmatau as st
from conftest import ROOT

PAGES = ROOT / "docs" / "coming-from"


def blocks(name, language):
    text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


def test_the_index_leads_to_every_page():
    index = (PAGES / "README.md").read_text(encoding="utf-8")
    for page in PAGES.glob("*.md"):
        assert page.name == "README.md" or f"({page.name})" in index


@pytest.mark.parametrize("page", sorted(PAGES.glob("[!R]*.md")), ids=lambda page: page.stem)
def test_facts_of_others_have_a_source_and_a_date(page):
    """A page on a program names where its facts are from, and when they were read."""
    text = page.read_text(encoding="utf-8")
    assert re.search(r"\]\(https://", text)
    assert re.search(r"20\d\d-\d\d-\d\d|NIST SP 1065", text)


class TestAllantools:
    """The comparison on the page for users of allantools."""

    def test_the_page(self, capsys):
        scope = {}
        for code, shown in zip(blocks("allantools", "python")[:2], blocks("allantools", "text")[:2], strict=True):
            exec(compile(code, "allantools.md", "exec"), scope)
            difference = "largest difference"  # its last digits are rounding
            found = [line for line in capsys.readouterr().out.splitlines() if difference not in line]
            assert found == [line for line in shown.splitlines() if difference not in line]
        np.testing.assert_allclose(scope["adev"], scope["curve"].adev, rtol=1e-12)

    @pytest.mark.parametrize(
        ("theirs", "kind"),
        [
            ("mdev", "modified"),
            ("ohdev", "hadamard"),
            ("totdev", "total"),
            ("tdev", "time"),
            ("mtie", "mtie"),
            ("tierms", "tie_rms"),
            ("pdev", "parabolic"),
        ],
    )
    def test_the_table(self, theirs, kind):
        import allantools

        y = np.random.default_rng(1).standard_normal(3000) + 1.0
        rates = y - y.mean() if kind in ("mtie", "tie_rms") else y
        ours = st.deviation(st.Record.from_arrays(rate=100, y=rates), kind=kind)["y"]
        tau, found = getattr(allantools, theirs)(y, rate=100, data_type="freq", taus=ours.tau)[:2]
        np.testing.assert_allclose(tau, ours.tau)
        np.testing.assert_allclose(found, ours.deviation, rtol=1e-12)

    def test_one_missing_sample(self):
        import allantools

        y = np.random.default_rng(1).standard_normal(3000)
        y[100] = np.nan
        assert np.isnan(allantools.oadev(y, rate=100, data_type="freq", taus=[0.1])[1]).all()
        assert np.isfinite(st.allan(st.Record.from_arrays(rate=100, y=y), taus=[0.1])["y"].adev).all()


def test_conversions_of_gmwm():
    """Their processes in samples have the Allan variance of our terms in seconds."""
    tau0, m = 0.01, np.array([1, 2, 8, 64])
    model = st.ChannelModel(
        terms={"quantization": 1e-5, "random_walk": 1e-4, "rate_random_walk": 1e-3, "rate_ramp": 1e-2},
        gauss_markov=(st.GaussMarkov(sigma=2e-3, time=0.1),),
    )
    q2, sigma2, gamma2, omega = (1e-5 / tau0) ** 2, 1e-4**2 / tau0, 1e-3**2 * tau0, 1e-2 * tau0
    phi, variance = np.exp(-tau0 / 0.1), 2e-3**2
    expected = []
    for size in m.tolist():
        weights = np.concatenate([np.full(size, -1.0), np.full(size, 1.0)]) / size
        lags = abs(np.subtract.outer(np.arange(2 * size), np.arange(2 * size)))
        white = sigma2 * np.sum(weights**2)
        quantized = q2 * np.sum(np.diff(weights, prepend=0, append=0) ** 2)
        walk = gamma2 * np.sum(np.cumsum(weights[::-1])[:-1] ** 2)
        ramp = (omega * weights @ np.arange(2 * size)) ** 2
        markov = variance * weights @ phi**lags @ weights
        expected.append((white + quantized + walk + ramp + markov) / 2)
    np.testing.assert_allclose(model.avar(m=m, tau0=tau0), expected, rtol=1e-9)
