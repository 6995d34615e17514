"""The pages of a comparison and of a trend: their numbers, in a browser without errors, and safe with any name."""

import json
import re
from datetime import UTC, datetime

import pytest

import sigmatau as st
from known import seed_of
from sigmatau.cli import main
from sigmatau.lab.pages.comparison_html import comparison_page

DATE = datetime(2026, 5, 4, 12, 0, tzinfo=UTC)
HOSTILE = "</script><img src=x onerror=document.title=1>\u202e"


@pytest.fixture(scope="module")
def results():
    """Four runs of two axes; the noise of the first axis rises by 5 % from run to run."""
    made = {}
    for k in range(4):
        channels = {"gyro_x": {"random_walk": 1e-4 * 1.05**k}, "gyro_y": {"random_walk": 1e-4}}
        record = st.simulate(st.NoiseModel(channels=channels), duration=600, rate=20, rng=seed_of(f"values page {k}"))
        made[f"day {k}"] = st.analyze(record, at_rest=True)
    return made


def charts(page):
    return json.loads(re.search(r'<script[^>]*id="charts"[^>]*>(.*?)</script>', page, flags=re.DOTALL)[1])


def test_the_page_of_a_comparison_has_its_numbers(results):
    compared = st.compare_runs([*results.values()], names=[*results])
    page = comparison_page(compared, command=None, date=DATE)
    assert "gyro_x random walk varies between runs: spread" in page
    panel = next(panel for panel in charts(page)["panels"] if panel["title"] == "gyro random walk")
    assert panel["places"] == [*results]
    series = next(series for series in panel["series"] if series["name"] == "gyro_x")
    for k, (low, value, high) in enumerate(zip(series["low"], series["values"], series["high"], strict=True)):
        term = results[f"day {k}"].fits["gyro_x"]["random_walk"]
        assert value == pytest.approx(term.value * 60 * 57.29577951308232, rel=1e-5)
        assert low < value < high
        assert high / low == pytest.approx(term.high / term.low, rel=0.02)


def test_both_pages_in_a_browser(results, tmp_path, monkeypatch, capsys, browser):
    monkeypatch.chdir(tmp_path)
    for k, (name, analysis) in enumerate(results.items()):
        (tmp_path / f"{name}.json").write_text(json.dumps(analysis.to_dict()))
        assert (
            main(
                ["store", "add", f"{name}.json", "--store", "lab.db", "--unit", f"A{k}", "--date", f"2026-0{k + 1}-03"]
            )
            == 0
        )
    assert main(["compare", *(f"{name}.json" for name in results), "--report", "compared.html", "-q"]) == 0
    assert main(["store", "trend", "--store", "lab.db", "--report", "trend.html"]) == 0
    assert main(["store", "trend", "--store", "lab.db", "--report", "trend.pdf"]) == 2
    assert "must end in .html" in capsys.readouterr().err
    page = browser.new_page(viewport={"width": 390, "height": 900})
    wrong, asked = [], []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    page.on("request", lambda request: asked.append(request.url))
    for file in ("compared.html", "trend.html"):
        page.goto(f"file://{tmp_path / file}")
        first = page.locator("figure").first
        first.scroll_into_view_if_needed()
        first.locator("canvas").wait_for()
        # The legend hides and shows the values of a channel.
        entry = first.locator("button.swatch").first
        before = first.locator("canvas").screenshot()
        entry.click()
        assert entry.get_attribute("aria-pressed") == "false"
        assert first.locator("canvas").screenshot() != before
        entry.click()
        assert entry.get_attribute("aria-pressed") == "true"
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert len(page.pdf(format="A4")) > 10_000
    page.close()
    assert wrong == []
    assert len(asked) == 2
    assert "2026-03" in (tmp_path / "trend.html").read_text()


def test_a_name_cannot_run(results, tmp_path, browser):
    compared = st.compare_runs([*results.values()][:2], names=[HOSTILE, "day 1"])
    (tmp_path / "page.html").write_text(comparison_page(compared, command=HOSTILE, date=DATE))
    page = browser.new_page()
    page.goto(f"file://{tmp_path / 'page.html'}")
    assert page.title() != "1"
    assert page.locator("img").count() == 0
    page.close()


def test_the_password_of_a_store_is_not_in_a_page(monkeypatch):
    from sigmatau.cli.options import command_line

    place = "postgresql://lab:secret@host/db?password=secret&x=1"
    monkeypatch.setattr("sys.argv", ["sigmatau", "lot", "--store", place, "-o", "a:b@c.html"])
    assert command_line() == "sigmatau lot --store 'postgresql://lab:…@host/db?password=…&x=1' -o a:b@c.html"
