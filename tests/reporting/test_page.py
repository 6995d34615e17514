"""The page in a browser: what it draws, what can be done with it, and that it asks nobody."""

import io
import json
import re

import numpy as np
import pytest
from report_records import DATE, HOSTILE, signals, six_axes

import sigmatau as st
from sigmatau.quality.selection.window import cut

CHARTS = ("deviation", "density", "residuals", "series", "map")


@pytest.fixture(scope="module")
def record():
    return six_axes()


@pytest.fixture(scope="module")
def analysis(record):
    return st.analyze(record)


@pytest.fixture(scope="module")
def page(record, analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "six axes.html"
    st.report(analysis, path, record=record, command="sigmatau analyze x.csv", date=DATE)
    return path


@pytest.fixture
def opened(browser):
    """Opens a page; at the end there were no errors and no requests."""
    contexts, told = [], []

    def open_page(path, **options):
        context = browser.new_context(**({"viewport": {"width": 1280, "height": 900}} | options))
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: told.append(f"{message.type}: {message.text}"))
        tab.on("pageerror", lambda error: told.append(f"error: {error}"))
        tab.on("request", lambda request: _asked(request.url, told))
        tab.goto(path.as_uri())
        return tab

    yield open_page
    for context in contexts:
        context.close()
    assert told == []


def _asked(url, told):
    if not url.startswith(("file:", "data:", "blob:")):
        told.append(f"request: {url}")


def figure(tab, chart, sensor="gyro"):
    found = tab.locator(f'[data-chart="{chart}"] figure[data-sensor="{sensor}"]')
    found.scroll_into_view_if_needed()
    found.locator("canvas").first.wait_for()
    return found


def ink(shown):
    """Pixels of saturated colour in a plot: curves, not the frame."""
    shown.page.mouse.move(0, 0)
    picture = _pixels(shown.screenshot())
    return int((picture.max(axis=2).astype(int) - picture.min(axis=2) > 60).sum())


def _pixels(png):
    from matplotlib.image import imread

    return (imread(io.BytesIO(png))[:, :, :3] * 255).astype(np.uint8)


def range_of(tab, chart, axis="y", sensor="gyro"):
    """What is seen of an axis, from the texts of the plot that is saved."""
    with tab.expect_download() as download:
        figure(tab, chart, sensor).get_by_role("button", name="SVG").click()
    return download.value.path().read_text(encoding="utf-8")


@pytest.mark.parametrize("chart", CHARTS)
def test_every_chart_is_drawn(opened, page, chart):
    tab = opened(page)
    for sensor in ("gyro",) if chart == "map" else ("gyro", "accel"):  # of noise that does not change, the map is empty
        assert ink(figure(tab, chart, sensor).locator(".plot").first) > 300


def test_axes_can_be_hidden_in_all_charts_of_a_sensor(opened, page):
    tab = opened(page)
    shown, accel = figure(tab, "deviation"), figure(tab, "deviation", "accel")
    before, other = ink(shown.locator(".plot")), ink(accel.locator(".plot"))
    shown.get_by_role("checkbox", name="y", exact=True).uncheck()
    assert ink(shown.locator(".plot")) < 0.9 * before
    assert ink(accel.locator(".plot")) == other
    assert not figure(tab, "series").get_by_role("checkbox", name="y", exact=True).is_checked()
    assert figure(tab, "series").locator(".plot").count() == 2
    for name in "xz":
        shown.get_by_role("checkbox", name=name).uncheck()
    assert "No axis is chosen" in shown.inner_text()
    shown.get_by_role("checkbox", name="x").check()
    assert shown.locator("canvas").count() == 1


def test_options_change_the_picture(opened, page):
    tab = opened(page)
    shown = figure(tab, "deviation")
    with_intervals = shown.locator(".plot").screenshot()
    shown.get_by_role("checkbox", name="Intervals").uncheck()
    assert shown.locator(".plot").screenshot() != with_intervals
    without = ink(shown.locator(".plot"))
    shown.get_by_role("checkbox", name="Terms").check()
    assert ink(shown.locator(".plot")) > without
    shown.get_by_role("checkbox", name="Slopes").check()
    assert ">−½<" not in range_of(tab, "deviation")
    assert range_of(tab, "deviation").count('stroke-dasharray="2 4"') >= 3


def test_units(opened, page, analysis):
    tab = opened(page)
    shown = figure(tab, "deviation")
    shown.get_by_label("Unit").select_option("deg/s")
    assert figure(tab, "series").get_by_label("Unit").input_value() == "deg/s"
    rows = csv_of(tab, "deviation")
    assert rows[0][2] == "Allan deviation σ(τ) [deg/s]"
    first = next(row for row in rows if row[0] == "x")
    assert float(first[2]) == pytest.approx(np.degrees(analysis.curves["gyro_x"].adev[0]), rel=1e-4)
    assert float(first[3]) < float(first[2]) < float(first[4])


def csv_of(tab, chart, sensor="gyro"):
    import csv

    with tab.expect_download() as download:
        figure(tab, chart, sensor).get_by_role("button", name="CSV").click()
    return list(csv.reader(download.value.path().read_text(encoding="utf-8").splitlines()))


def test_zoom_and_back(opened, page):
    tab = opened(page)
    shown = figure(tab, "deviation")
    box = shown.locator(".u-over").bounding_box()
    whole = range_of(tab, "deviation")
    tab.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 0.2 * box["height"])
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.6 * box["height"], steps=5)
    tab.mouse.up()
    assert range_of(tab, "deviation") != whole
    tab.mouse.dblclick(box["x"] + 50, box["y"] + 50)
    assert _without_clips(range_of(tab, "deviation")) == _without_clips(whole)
    shown.get_by_role("button", name="+", exact=True).click()
    zoomed = range_of(tab, "deviation")
    assert _without_clips(zoomed) != _without_clips(whole)
    shown.get_by_role("button", name="Reset").click()
    assert _without_clips(range_of(tab, "deviation")) == _without_clips(whole)


# A key pressed many times; `test_reading_by_mouse_and_by_keys` has a real keyboard.
PRESSED = """(plot, [key, times]) => {
    plot.focus();
    for (let k = 0; k < times; k++) plot.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
}"""


def test_no_zoom_breaks_a_chart(opened, tmp_path):
    rng = np.random.default_rng(22)
    columns = {name: 1e9 * (name == "accel_x") + 1e-3 * rng.standard_normal(12_000) for name in ("gyro_x", "accel_x")}
    record = st.Record.from_arrays(rate=100.0, **columns)
    st.report(st.analyze(record, at_rest=True), tmp_path / "x.html", record=record)
    tab = opened(tmp_path / "x.html")
    for sensor in ("gyro", "accel"):
        for chart in CHARTS:
            shown, drawn = figure(tab, chart, sensor), set()
            for key in ("-", "+"):
                shown.locator(".plot").evaluate(PRESSED, [key, 120])
                svg = range_of(tab, chart, sensor=sensor)
                ticks = re.findall(r'<text[^>]*text-anchor="middle"[^>]*>([^<]+)</text>', svg)
                assert len(set(ticks)) > 2, (sensor, chart, key)
                assert "NaN" not in svg
                drawn.add(_without_clips(svg))
                if key == "-" and chart != "map":
                    assert ink(shown.locator(".plot")) > 50
            assert len(drawn) == 2, (sensor, chart)  # the keys were heard


def test_whole_intervals_are_saved(opened, page, analysis):
    """The longest one reaches over more than the factor of ten that is drawn."""
    tab = opened(page)
    figure(tab, "deviation").get_by_label("Unit").select_option("rad/s")
    rows = csv_of(tab, "deviation")
    for axis in "xyz":
        curve = analysis.curves[f"gyro_{axis}"]
        low, high = (float(ends[-1]) for ends in curve.interval())
        assert high > 10 * curve.adev[-1]
        saved = [row for row in rows if row[0] == axis][-1]
        assert [float(x) for x in saved[1:]] == pytest.approx([curve.tau[-1], curve.adev[-1], low, high], rel=1e-4)


def _without_clips(svg):
    return re.sub(r"clip\d+", "", svg)


def test_reading_by_mouse_and_by_keys(opened, page, analysis):
    tab = opened(page)
    shown = figure(tab, "deviation")
    plot, readout = shown.locator(".plot"), shown.locator(".readout")
    plot.focus()
    tab.keyboard.press("ArrowRight")
    assert "τ = 0.01 s" in readout.inner_text()
    value = analysis.curves["gyro_x"].adev[0] * 180 / np.pi * 3600
    assert f"{float(f'{value:.4g}'):g}" in readout.inner_text()
    assert "[" in readout.inner_text()
    tab.keyboard.press("ArrowRight")
    assert "τ = 0.02 s" in readout.inner_text()
    tab.keyboard.press("+")
    tab.keyboard.press("0")
    tab.keyboard.press("Tab")
    assert "Point to read" in readout.inner_text()
    box = figure(tab, "map").locator(".u-over").bounding_box()
    tab.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert "times the median" in figure(tab, "map").locator(".readout").inner_text()


def test_the_crosshair_is_on_a_point(opened, page):
    """Not where the mouse is: it is where the arrow keys put it, which move from point to point."""
    tab = opened(page)
    shown = figure(tab, "deviation")
    plot, across, down = shown.locator(".u-over"), shown.locator(".u-cursor-x"), shown.locator(".u-cursor-y")

    def place():
        boxes = across.bounding_box(), down.bounding_box()
        return boxes[0]["x"] - plot.bounding_box()["x"], boxes[1]["y"] - plot.bounding_box()["y"]

    box = plot.bounding_box()
    tab.mouse.move(box["x"] + 0.37 * box["width"], box["y"] + 0.03 * box["height"])
    by_mouse, tau = place(), shown.locator(".readout b").first.inner_text()
    assert by_mouse[1] > 0.1 * box["height"]
    tab.mouse.move(0, 0)
    shown.locator(".plot").focus()
    for _ in range(40):
        tab.keyboard.press("ArrowRight")
        if shown.locator(".readout b").first.inner_text() == tau:
            break
    assert place()[0] == pytest.approx(by_mouse[0], abs=1)


def test_a_range_of_the_time_series_is_an_option(opened, page, record):
    """Dragged over a quarter of the record; the text is that of `analyze --window`."""
    tab = opened(page)
    shown = figure(tab, "series")
    plot = shown.locator(".u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    tab.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 20)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 25, steps=4)
    tab.mouse.up()
    text = shown.locator(".window code").inner_text()
    start, stop = (float(end) for end in re.fullmatch(r"--window ([\d.]+)s:([\d.]+)s", text).groups())
    length = record.streams[0].grid.duration
    assert (start, stop) == (
        pytest.approx(0.5 * length, rel=0.02),
        pytest.approx(0.75 * length, rel=0.02),
    )
    shown.locator(".window button").click()
    # The clipboard takes a moment.
    shown.locator(".window button", has_text=re.compile("^(Copied|Selected)$")).wait_for()
    part = cut(record, text.removeprefix("--window "))
    assert part.streams[0].grid.duration == pytest.approx(stop - start, abs=0.1)


def test_saved_pictures(opened, page):
    tab = opened(page)
    for chart in CHARTS:
        with tab.expect_download() as download:
            figure(tab, chart).get_by_role("button", name="PNG").click()
        assert download.value.suggested_filename == f"six-axes-{chart}-gyro.png".replace("six-axes", "Record-in-memory")
        picture = _pixels(download.value.path().read_bytes())
        assert picture.shape[1] == 1520
        assert (picture.max(axis=2).astype(int) - picture.min(axis=2) > 60).sum() > 1000
        svg = range_of(tab, chart)
        from xml.etree import ElementTree as ET

        assert ET.fromstring(svg).tag.endswith("svg")
    rows = csv_of(tab, "series")
    assert rows[0][:3] == ["series", "time [min]", "x [deg/h]"]


def test_values_for_filters_are_copied(opened, page):
    tab = opened(page, permissions=["clipboard-read", "clipboard-write"])
    shown = tab.locator(".files details").first
    shown.get_by_role("button", name="Copy").click()
    shown.get_by_role("button", name="Copied").wait_for()
    assert tab.evaluate("navigator.clipboard.readText()") == shown.locator("pre").text_content()


def until(tab, condition):
    """Wait for a condition. The page allows no `eval`, by which the browser would wait itself."""
    for _ in range(100):
        if tab.evaluate(condition):
            return
        tab.wait_for_timeout(50)
    pytest.fail(condition)


def test_paper_has_all_charts(opened, page):
    tab = opened(page, color_scheme="dark")
    tab.emulate_media(media="print")
    until(tab, "document.querySelectorAll('figure canvas').length >= 14")
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not tab.get_by_role("button", name="PNG").first.is_visible()
    tab.emulate_media(media="screen")
    until(tab, "getComputedStyle(document.body).backgroundColor === 'rgb(18, 22, 28)'")


def test_the_curve_is_beside_the_summary(opened, page):
    tab = opened(page, viewport={"width": 1280, "height": 900})
    summary, curve = (tab.locator(f"#{name}").bounding_box() for name in ("summary", "deviation"))
    assert curve["y"] == summary["y"]
    assert curve["x"] >= summary["x"] + summary["width"]
    table = tab.locator("#summary .scrolled")
    assert table.evaluate("(element) => element.scrollWidth <= element.clientWidth")


def test_phone(opened, page):
    tab = opened(page, viewport={"width": 390, "height": 844}, is_mobile=True, has_touch=True)
    # After a tap the mouse of chromium-headless-shell leaves to the corner of the page; that of a phone stays.
    tab.evaluate("document.addEventListener('mouseleave', event => event.stopImmediatePropagation(), true)")
    figure(tab, "deviation").locator(".u-over").tap()
    figure(tab, "deviation").locator(".readout", has_text="τ =").wait_for()
    for chart in CHARTS:
        assert ink(figure(tab, chart).locator(".plot").first) > 200
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_moving_record(opened, tmp_path):
    rng = np.random.default_rng(3)
    record = st.Record.from_arrays(rate=100.0, gyro_x=np.cumsum(rng.standard_normal(20_000)) * 0.05)
    st.report(st.analyze(record), tmp_path / "m.html", record=record)
    tab = opened(tmp_path / "m.html")
    assert "Not at rest" in tab.inner_text("header")
    assert figure(tab, "deviation").get_by_role("checkbox", name="Model").count() == 0
    assert tab.locator('[data-chart="residuals"]').count() == 0
    assert ink(figure(tab, "series").locator(".plot")) > 300


@pytest.mark.parametrize("names", [["gyro_x"], [f"gyro_{k}" for k in range(20)], [f"s{k}" for k in range(60)]])
def test_one_and_sixty_channels(opened, tmp_path, names):
    record = signals(names, 2000)
    st.report(st.analyze(record), tmp_path / "x.html", record=record)
    assert (tmp_path / "x.html").stat().st_size < 2_000_000
    tab = opened(tmp_path / "x.html")
    sensor = "gyro" if names[0].startswith("gyro") else "s0"
    assert ink(figure(tab, "deviation", sensor).locator(".plot")) > 300
    if sensor == "s0":
        tab.get_by_label("Sensor").first.select_option("s41")
        assert ink(figure(tab, "deviation", "s41").locator(".plot")) > 300
    elif len(names) > 1:
        shown = figure(tab, "deviation")
        shown.get_by_role("button", name="None").click()
        assert "No axis is chosen" in shown.inner_text()
        shown.get_by_role("button", name="All").click()
        assert figure(tab, "series").locator(".plot").count() == 20


def test_hostile_names_are_text(opened, tmp_path):
    from dataclasses import replace

    record = signals([f"gyro_{text}" for text in HOSTILE.values()])
    analysis = st.analyze(record)
    path = "/" + "a" * 5000 + HOSTILE["script"] + "b" * 5000
    source = replace(analysis.source, path=path)
    st.report(replace(analysis, source=source), tmp_path / "x.html", record=record, command=HOSTILE["ends"])
    tab = opened(tmp_path / "x.html")
    assert tab.title() != "run"
    assert tab.evaluate("document.querySelectorAll('script').length") == 2
    shown = figure(tab, "deviation").inner_text()
    for text in HOSTILE.values():
        assert text.replace("  ", " ") in shown, text
    assert HOSTILE["script"] in tab.inner_text("h1") + tab.inner_text("#done")
    assert tab.evaluate("document.documentElement.scrollWidth") <= 1280
    svg = range_of(tab, "deviation")
    from xml.etree import ElementTree as ET

    assert HOSTILE["script"] in "".join(ET.fromstring(svg).itertext())
    rows = csv_of(tab, "deviation")
    assert {HOSTILE["quotes"], HOSTILE["ends"]} <= {row[0] for row in rows}
    json.dumps(rows)
