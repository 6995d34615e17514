"""The page and the document of a lot: small with 400 units, offline, without errors in a browser, and safe with any name."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from lot_logs import SPEC, rates
from sigmatau.lab.lots.lot_screen import screen
from sigmatau.lab.pages.lot_content import claim_rows

_MOST = 3e6  # bytes of the page of 400 units, to be sent by mail


@pytest.fixture(scope="module")
def spec(tmp_path_factory):
    path = tmp_path_factory.mktemp("spec") / "spec.toml"
    path.write_text(SPEC, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def many(spec):
    """400 units of all axes: one analysis, whose numbers are scaled from unit to unit; the fifth is six times noisier."""
    units = {"gyro": "rad/s", "accel": "m/s^2"}
    x = rates(1, kind="page", duration=1200)
    record = st.Record.from_arrays(rate=5, unit=units, gyro=x[:, :3], accel=x[:, 3:])
    content = json.loads(json.dumps(st.analyze(record).to_dict()))
    rng = np.random.default_rng(seed_of("page of 400"))
    lot = {}
    for k in range(1, 401):
        one = json.loads(json.dumps(content))
        for channel in one["channels"].values():
            f = float(np.exp(0.03 * rng.standard_normal())) * (6 if k == 5 else 1)
            channel["curve"]["adev"] = [f * value for value in channel["curve"]["adev"]]
            fit = channel["fit"]
            fit["model"] = {name: f * value for name, value in fit["model"].items()}
            for term in fit["terms"].values():
                if isinstance(term, dict):
                    term.update({key: f * term[key] for key in ("value", "low", "high", "upper_limit") if key in term})
            for row in channel["mean_stability"]:
                row.update({key: f * row[key] for key in ("value", "low", "high") if key in row})
        lot[f"unit {k}"] = one
    return st.judge_lot(lot, spec, expect=401)


def test_400_units_are_a_page_of_less_than_3_mb(many, tmp_path):
    assert many.counts == {"failed": 1, "not_judged": 0, "unreadable": 0, "missing": 1, "passed": 399}
    st.lot_report(many, tmp_path / "lot.html")
    text = (tmp_path / "lot.html").read_text(encoding="utf-8")
    assert len(text.encode()) <= _MOST
    assert "https://" not in re.sub(r"https://github.com/leeoniya/uPlot\S*", "", text)
    assert text.count("<tr>") >= 400
    assert len(screen(many).splitlines()) <= 24


def test_the_convention_that_an_option_chose(many, tmp_path):
    """Of a specification that leaves it open; a stated one stays."""
    path = tmp_path / "open.toml"
    path.write_text(
        'name = "a"\nmaker = "b"\nsource = "c"\n[gyro]\n'
        'noise_density = { maximum = "1 deg/s/sqrt(Hz)", sided = "unknown" }\n'
        'bias_instability = { maximum = "20 deg/h", as = "unknown" }\n'
        '[accel]\nnoise_density = { maximum = "1 mg/sqrt(Hz)", sided = "two" }\n'
    )
    lot = replace(many, spec=st.Datasheet.read(path))
    assert [row[-1] for row in claim_rows(lot)] == ["not stated", "not stated", "two-sided"]
    chosen = replace(lot, settings=replace(lot.settings, sided="one", bias="minimum"))
    assert [row[-1] for row in claim_rows(chosen)] == ["one-sided (chosen)", "Allan minimum (chosen)", "two-sided"]


def test_the_workbook_has_a_row_for_each_unit(many, tmp_path):
    """A name that looks like a formula stays text."""
    calamine = pytest.importorskip("python_calamine")
    named = replace(many, units=(replace(many.units[0], name='=HYPERLINK("x")'), *many.units[1:]))
    st.lot_report(named, tmp_path / "lot.xlsx")
    book = calamine.CalamineWorkbook.from_path(str(tmp_path / "lot.xlsx"))
    assert book.sheet_names == ["Units", "Distribution", "What was done"]
    head, *rows = book.get_sheet_by_name("Units").to_python()
    assert len(rows) == 401
    assert rows[0][:2] == ['=HYPERLINK("x")', "passed"]
    k = head.index("gyro_x angle random walk [deg/√h]")
    value = many.units[0].result.channels["gyro_x"].coefficients["random_walk"].value
    assert rows[0][k] == pytest.approx(value * 60 * 180 / np.pi, rel=1e-12)
    assert rows[0][k + 1] < rows[0][k] < rows[0][k + 2]
    assert book.get_sheet_by_name("Distribution").to_python()[0][:2] == ["Axis", "Coefficient"]


def test_the_page_in_a_browser(many, tmp_path, browser):
    st.lot_report(many, tmp_path / "lot.html", reports={"unit 5": "reports/unit 5.html"})
    page = browser.new_page(viewport={"width": 1200, "height": 900})
    wrong, asked = [], []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    page.on("request", lambda request: asked.append(request.url))
    page.goto(f"file://{tmp_path / 'lot.html'}")
    # Figures are drawn when they come near the window.
    figures = page.locator("figure").all()
    assert page.locator("figure canvas").count() < len(figures)
    for figure in figures:
        figure.scroll_into_view_if_needed()
        figure.locator("canvas").wait_for()
    assert len(figures) == 6 + len({(one.channel[:4], one.what) for one in many.distributions})
    # The table is sorted by state, worst first; by a click by name, and by numbers, largest first at the second.
    first = "document.querySelector('table.units tbody tr th').textContent"
    assert page.evaluate(first) == "unit 5"
    page.locator("table.units th", has_text="Unit").first.click()
    assert page.evaluate(first) in ("(missing 1)", "unit 1")
    head = page.locator("table.units th", has_text="gyro random walk")
    head.click()
    head.click()
    assert page.evaluate(first) == "unit 5"
    # Only the units that have all words are shown; the unit that has a report is a link to it.
    page.locator("#search input").fill("UNIT failed")
    assert page.locator("table.units tbody tr:visible").count() == 1
    assert page.locator("#search output").text_content() == "1 of 401 units"
    (address,) = [link.get_attribute("href") for link in page.locator("table.units a").all()]
    assert address == "reports/unit%205.html"
    page.locator("#search input").fill("")
    page.emulate_media(color_scheme="dark")
    page.locator("#theme").click()
    assert page.evaluate("document.documentElement.scrollWidth") <= 1200
    assert len(page.pdf(format="A4")) > 10_000
    page.close()
    assert wrong == []
    assert len(asked) == 1


def test_the_page_is_no_wider_than_a_phone(many, tmp_path, browser):
    st.lot_report(many, tmp_path / "lot.html")
    page = browser.new_page(viewport={"width": 390, "height": 800})
    page.goto(f"file://{tmp_path / 'lot.html'}")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.close()


def test_a_name_cannot_run(spec, tmp_path, browser):
    x = rates(2, kind="page", duration=120)
    result = st.analyze(st.Record.from_arrays(rate=5, gyro=x[:, :3], unit={"gyro": "rad/s"})).to_dict()
    name = "</script><img src=x onerror=document.title=1>&lt;\u202e"
    lot = st.judge_lot({name: result, "#box $x$": result}, spec)
    for ending in ("html", "pdf", "xml", "csv", "json"):
        st.lot_report(lot, tmp_path / f"lot.{ending}", title="<b>T</b>")
    page = browser.new_page()
    page.goto(f"file://{tmp_path / 'lot.html'}")
    assert page.title() == "<b>T</b> – Unit 7"
    assert page.locator("img").count() == 0
    page.close()


def test_an_empty_lot_and_one_without_curves(tmp_path):
    for lot in (st.judge_lot({}, expect=2), st.judge_lot({"a": st.DataError("is empty")})):
        for ending in ("html", "pdf", "xml", "csv", "json"):
            st.lot_report(lot, tmp_path / f"lot.{ending}")
            assert (tmp_path / f"lot.{ending}").stat().st_size > 0


def test_a_report_that_cannot_be_written(many, tmp_path):
    with pytest.raises(st.OptionError, match=r"must end in \.html"):
        st.lot_report(many, tmp_path / "lot.doc")
    with pytest.raises(st.DataError, match="no directory"):
        st.lot_report(many, tmp_path / "none" / "lot.csv")
    assert list(tmp_path.iterdir()) == []
