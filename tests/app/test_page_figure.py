"""The step in which the curve of a figure is clicked: by mouse, by finger and by keys, on a phone, from an address."""

import json
import re
import shlex

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("starlette")

from clicked_figures import ENDS, Picture, covered, truths
from page_tabs import PHONE, grave_findings, press, six_axes, tabs, wait_result, write_table

from drawn_curves import drawn
from known import seed_of
from sigmatau.cli import main

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture(scope="module")
def figures(folder):
    place = folder / "datasheet"
    place.mkdir()
    return place


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


def choose_folder(tab, folder):
    """Show the files of a folder in the first step."""
    if not tab.locator("#step-open[aria-current]").count():
        tab.locator("#step-open").click()
    tab.get_by_role("button", name=f"{folder.name}/").click()


def open_figure(tab, path):
    """Open a figure of the folder."""
    choose_folder(tab, path.parent)
    tab.get_by_role("button", name=re.compile(f"^{re.escape(path.name)}")).click()
    tab.locator(".figure-step:not([hidden])").wait_for()


def settled(tab):
    """The rectangle of the picture on screen, after a scroll has ended."""
    holder, before = tab.locator(".holder"), None
    while (box := holder.bounding_box()) != before:
        before = box
        tab.wait_for_timeout(20)
    return box


def on_screen(tab, picture, place):
    """The point of the screen of a place of the picture without a turn."""
    box = settled(tab)
    zoom = box["width"] / picture.size[0]
    return box["x"] + zoom * place[0], box["y"] + zoom * place[1]


def click(tab, picture, place, rng=None, *, touch=False):
    """Click a place with an error of a pixel of the screen."""
    x, y = np.add(on_screen(tab, picture, place), 0 if rng is None else rng.standard_normal(2))
    (tab.touchscreen.tap if touch else tab.mouse.click)(float(x), float(y))


def click_ticks(tab, picture, rng=None, *, touch=False):
    """Click the ticks and type their values; after each the next one is expected."""
    for key, place in picture.ticks().items():
        click(tab, picture, place, rng, touch=touch)
        assert tab.evaluate("document.activeElement.dataset.tick") == key
        tab.keyboard.type(f"{ENDS[key]:g}")
        tab.keyboard.press("Enter")


def table(tab):
    """The rows of the coefficients on screen: label, value, interval and unit."""
    rows = tab.locator(".figure-result tbody tr")
    rows.first.wait_for()
    tab.locator(".figure-result:not([aria-busy])").wait_for()
    result = []
    for row in rows.all():
        label, value, unit, interval = row.locator("th, td").all_inner_texts()
        result.append((label, value, interval, unit))
    return result


def marks(tab):
    """Names of the marks of the points."""
    return [mark.get_attribute("aria-label") for mark in tab.locator(".mark.point").all()]


def test_from_a_picture_to_a_model(opened, figures, tmp_path, monkeypatch, capsys):
    picture, rng = Picture(figures / "gyro.png"), np.random.default_rng(seed_of("page figure"))
    tab = opened()
    open_figure(tab, picture.path)
    assert "Click a tick at the left end of the x axis" in tab.locator(".figure-prompt").inner_text()
    click_ticks(tab, picture, rng)
    for k, place in enumerate(picture.points(22)):
        click(tab, picture, place, rng)
        tab.locator(".figure-prompt", has_text=f"{k + 1} of 10" if k < 9 else "further points").wait_for()
    rows = table(tab)
    assert covered(rows) == dict.fromkeys(truths(), True)
    assert tab.locator(".figure-result", has_text="the shortest possible one is assumed").count() == 1
    assert grave_findings(tab) == []
    # The saved table and the command give the same coefficients.
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Save clicks.csv").click()
    download.value.save_as(tmp_path / "clicks.csv")
    monkeypatch.chdir(tmp_path)
    command = shlex.split(tab.locator("#command").inner_text())
    assert command[:3] == ["sigmatau", "curve", "clicks.csv"]
    assert main([*command[1:], "--json", "r.json"]) == 0
    fitted = json.loads((tmp_path / "r.json").read_text())["channels"]["gyro"]["fit"]["terms"]["random_walk"]
    shown = float({label: value for label, value, _, _ in rows}["angle random walk"])
    assert 60 * np.degrees(fitted["value"]) == pytest.approx(shown, rel=1e-2)
    # The clicking error is a pixel of the screen at the zoom of the picture.
    zoom = tab.locator(".holder").bounding_box()["width"] / 640
    assert float(command[command.index("--point-error") + 1]) == pytest.approx(max(1 / zoom, 0.5), rel=0.02)
    # A reload of the address shows the same.
    tab.reload()
    assert table(tab) == rows
    # The length of the record narrows the intervals.
    tab.get_by_label("Sampling rate of the record").fill("100")
    tab.get_by_label("Length of the record").fill("100")
    tab.get_by_label("Length of the record").press("Enter")
    tab.locator("#command", has_text="--rate 100 --hours 100").wait_for()
    assert covered(table(tab)) == dict.fromkeys(truths(), True)


def test_points_are_moved_removed_and_undone(opened, figures):
    picture = Picture(figures / "moved.png")
    tab = opened()
    open_figure(tab, picture.path)
    click_ticks(tab, picture)
    places = picture.points(16)
    for k, place in enumerate(places):
        click(tab, picture, np.add(place, (0, -60 if k == 6 else 0)))
    # The wrong click is off the fitted curve, and is named.
    tab.locator(".figure-result .box", has_text="gyro: 7").wait_for()
    wrong = tab.locator(".mark.point.off")
    assert "off the curve" in wrong.get_attribute("aria-label")
    # It is dragged to the curve.
    box = wrong.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    zoom = tab.locator(".holder").bounding_box()["width"] / 640
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x, y + 20)
    tab.mouse.move(x, y + 60 * zoom)
    tab.mouse.up()
    wrong.wait_for(state="detached")
    assert covered(table(tab)) == dict.fromkeys(truths(), True)
    # Arrow keys move it by a pixel of the screen, and are undone together.
    moved = tab.get_by_role("button", name=re.compile("^Point 7 of 16"))
    before = moved.get_attribute("aria-label")
    moved.focus()
    for _ in range(3):
        tab.keyboard.press("Shift+ArrowUp")
    assert moved.get_attribute("aria-label") != before
    tab.get_by_role("button", name="Undo").click()
    assert moved.get_attribute("aria-label") == before
    # Delete removes it, and the focus goes to the point before it.
    moved.focus()
    tab.keyboard.press("Delete")
    assert len(marks(tab)) == 15
    assert "Point 6 of 15" in tab.evaluate("document.activeElement.ariaLabel")
    tab.keyboard.press("Control+z")
    assert len(marks(tab)) == 16
    tab.get_by_role("button", name="Redo").click()
    assert len(marks(tab)) == 15
    # A drag of the picture moves the picture, and sets no point.
    for _ in range(3):
        tab.get_by_role("button", name="Zoom in").click()
    stage = tab.locator(".stage").bounding_box()
    scrolled = tab.evaluate("document.querySelector('.stage').scrollLeft")
    tab.mouse.move(stage["x"] + 200, stage["y"] + 30)
    tab.mouse.down()
    tab.mouse.move(stage["x"] + 120, stage["y"] + 30, steps=4)
    tab.mouse.up()
    assert tab.evaluate("document.querySelector('.stage').scrollLeft") == pytest.approx(scrolled + 80, abs=2)
    assert len(marks(tab)) == 15


def test_by_keys_alone(opened, figures):
    picture = Picture(figures / "keys.png")
    tab = opened()
    open_figure(tab, picture.path)
    tab.locator(".stage").focus()
    zoom = tab.locator(".holder").bounding_box()["width"] / 640
    position = np.array([320.0, 240.0]) * zoom

    def go(place):
        """Move the cross to a place and set it."""
        nonlocal position
        for k, names in enumerate((("ArrowLeft", "ArrowRight"), ("ArrowUp", "ArrowDown"))):
            steps = round(place[k] * zoom - position[k])
            name = names[steps > 0]
            for _ in range(abs(steps) // 20):
                tab.keyboard.press(f"Shift+{name}")
            for _ in range(abs(steps) % 20):
                tab.keyboard.press(name)
            position[k] += steps
        tab.keyboard.press("Enter")

    for key, place in picture.ticks().items():
        go(place)
        tab.keyboard.type(f"{ENDS[key]:g}")
        tab.keyboard.press("Enter")
        assert tab.evaluate("document.activeElement.className") == "stage"
    for place in picture.points(10):
        go(place)
    assert covered(table(tab)) == dict.fromkeys(truths(), True)
    press(tab, "Tab", until="Point 10 of 10")
    tab.keyboard.press("PageUp")
    assert "Point 9 of 10" in tab.evaluate("document.activeElement.ariaLabel")
    assert "at" in tab.locator("#status").text_content()


def test_on_a_phone_in_the_dark(opened, figures):
    picture, rng = Picture(figures / "phone.jpg", size=(400, 300), quality=60), np.random.default_rng(seed_of("phone"))
    tab = opened(**PHONE, color_scheme="dark")
    open_figure(tab, picture.path)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    tab.locator(".stage").scroll_into_view_if_needed()
    click_ticks(tab, picture, rng, touch=True)
    tab.locator(".stage").scroll_into_view_if_needed()
    for place in picture.points(10):
        click(tab, picture, place, rng, touch=True)
    assert covered(table(tab)) == dict.fromkeys(truths(), True)
    zoom = tab.locator(".holder").bounding_box()["width"] / 400
    assert float(tab.locator("#command").inner_text().split("--point-error ")[1].split()[0]) == pytest.approx(
        3 / zoom, rel=0.02
    )
    assert grave_findings(tab) == []
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_turned_photo_is_levelled(opened, figures):
    picture, rng = Picture(figures / "photo.jpg", turn=2.3, quality=80), np.random.default_rng(seed_of("photo"))
    tab = opened()
    open_figure(tab, picture.path)
    click_ticks(tab, picture, rng)
    for place in picture.points(20):
        click(tab, picture, place, rng)
    tab.get_by_role("button", name="Level the axes").click()
    assert float(tab.get_by_label("Turn of the picture").input_value()) == pytest.approx(-2.3, abs=0.4)
    tab.locator("#command", has_text="sigmatau curve").wait_for()
    assert covered(table(tab)) == dict.fromkeys(truths(), True)
    # A click on the turned picture sets the place below it, which is on the curve.
    turn = np.radians(float(tab.get_by_label("Turn of the picture").input_value()))
    c, s = np.cos(turn), np.sin(turn)
    dx, dy = np.mean(picture.points(20)[1:3], axis=0) - np.array(picture.size) / 2
    box = settled(tab)
    zoom = box["width"] / (picture.size[0] * abs(c) + picture.size[1] * abs(s))
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.click(middle[0] + zoom * (c * dx - s * dy), middle[1] + zoom * (s * dx + c * dy))
    assert len(marks(tab)) == 21
    assert covered(table(tab)) == dict.fromkeys(truths(), True)
    assert tab.locator(".mark.off").count() == 0


def test_a_page_of_a_pdf_is_asked_for(opened, figures):
    pytest.importorskip("pypdfium2")
    from matplotlib.backends.backend_pdf import PdfPages

    from drawn_curves import DEGREES_PER_HOUR, deviation, figure, times

    path = figures / "pages.pdf"
    with PdfPages(path) as pages:
        for has_curve in (False, True):
            drawing, axes = figure()
            if has_curve:
                axes.plot(times(), DEGREES_PER_HOUR * deviation(times()))
            pages.savefig(drawing)
    tab = opened(expected=["400"])
    choose_folder(tab, figures)
    tab.get_by_role("button", name=re.compile("^pages.pdf")).click()
    question = tab.get_by_role("group", name="A choice is needed")
    question.get_by_label("Page").fill("2")
    question.get_by_label("Page").press("Enter")
    tab.locator(".figure-step:not([hidden])").wait_for()
    assert "a line that can be read without clicks" in tab.locator(".figure-note").inner_text()
    assert "--page 2 --list" in tab.locator(".figure-note").inner_text()
    assert tab.locator(".stage img").evaluate("image => image.naturalWidth") == pytest.approx(1920, abs=2)


def test_errors_say_what_to_do(opened, figures):
    (figures / "broken.png").write_bytes(Picture(figures / "whole.png").path.read_bytes()[:900])
    tab = opened(expected=["422", "400"])
    choose_folder(tab, figures)
    tab.get_by_role("button", name=re.compile("^broken.png")).click()
    assert "is damaged. Download it" in tab.get_by_role("alert").inner_text()
    picture = Picture(figures / "scale.png")
    open_figure(tab, picture.path)
    click_ticks(tab, picture)
    for place in picture.points(12):
        click(tab, picture, place)
    table(tab)
    tab.get_by_label("Value of tick y₁").fill("0")
    tab.get_by_label("Value of tick y₁").press("Enter")
    assert "a logarithmic axis has no value 0" in tab.get_by_role("alert").inner_text()
    tab.get_by_label("Value of tick y₁").fill("1")
    tab.get_by_label("Unit of the rate").fill("deg/sqrt(h)")
    tab.get_by_label("Unit of the rate").press("Enter")
    tab.get_by_role("alert", name="").get_by_text("is not the unit of a rate").wait_for()
    tab.get_by_label("Sensor").select_option("accel")
    table(tab)
    assert "--unit ug" in tab.locator("#command").inner_text()


def test_a_datasheet_beside_a_log(opened, figures, folder):
    """A dropped picture with two curves; their model is compared with the curves of a log."""
    write_table(figures / "today.csv", six_axes())
    path = drawn(figures / "texts.svg")
    tab = opened()
    choose_folder(tab, figures)
    tab.get_by_role("button", name=re.compile("^today.csv")).click()
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    tab.locator("#step-compare").click()
    tab.locator("#compare-chooser").set_input_files(path)
    tab.locator(".figure-step:not([hidden])").wait_for()
    assert "can be read without clicks" in tab.locator(".figure-note").inner_text()
    # The limits of the axes of this drawing are those of Matplotlib: any two ticks calibrate an axis.
    box = settled(tab)
    for x, y, value in ((0.2, 0.89, "0.1"), (0.8, 0.89, "100"), (0.125, 0.8, "1"), (0.125, 0.2, "100")):
        tab.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
        tab.keyboard.type(value)
        tab.keyboard.press("Enter")
    tab.get_by_role("button", name="Add a curve").click()
    for k, name in enumerate(("gyro_x", "gyro_y")):
        tab.get_by_label(f"Name of curve {k + 1}").fill(name)
        tab.get_by_label(f"Name of curve {k + 1}").press("Enter")
        tab.get_by_role("button", name=re.compile(f"Points of {name}")).click()
        box = settled(tab)
        for j in range(12):
            share = j / 11
            tab.mouse.click(
                box["x"] + box["width"] * (0.2 + 0.5 * share), box["y"] + box["height"] * (0.3 + 0.1 * k + 0.3 * share)
            )
    tab.locator("#command", has_text="--columns x=1,gyro_x=2,gyro_y=3").wait_for()
    table(tab)
    assert tab.locator(".figure-result article").count() == 2
    tab.get_by_role("button", name="Add to the comparison").click()
    legend = tab.get_by_role("group", name="In the figure").get_by_role("listitem")
    legend.nth(1).wait_for()
    assert "texts" in legend.nth(1).inner_text()
    # The points are still there.
    tab.locator("#step-figure").click()
    tab.locator(".mark.point").nth(23).wait_for()


def test_a_name_with_a_quote_is_quoted_in_the_command(opened, figures):
    drawn(figures / "texts.svg").rename(figures / "it's.svg")
    tab = opened()
    open_figure(tab, figures / "it's.svg")
    command = tab.locator(".figure-note code").inner_text()
    assert shlex.split(command)[2].endswith("it's.svg")


def test_a_picture_that_was_replaced_is_noticed(opened, figures):
    """The clicks of the address belong to the picture that was clicked."""
    picture = Picture(figures / "replaced.png")
    tab = opened()
    open_figure(tab, picture.path)
    click_ticks(tab, picture)
    for place in picture.points(12):
        click(tab, picture, place)
    rows = table(tab)
    tab.reload()
    assert table(tab) == rows
    assert tab.locator(".figure-note").inner_text() == ""
    Picture(picture.path, size=(1280, 960))
    tab.reload()
    note = tab.locator(".figure-note").get_by_role("alert")
    note.wait_for()
    assert "had 640 × 480 pixels, this one has 1280 × 960" in note.inner_text()
