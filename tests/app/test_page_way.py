"""The whole way in a browser, by mouse and by keys alone: from a file to the exported files."""

import csv
import json
import tomllib

import pytest

pytest.importorskip("starlette")

from page_tabs import NAME_OF_FOCUS, command, fragment, press, six_axes, tabs, wait_result, write_table

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture(scope="module")
def log(folder):
    """A log with two spikes on an axis."""
    return write_table(folder / "spikes.csv", six_axes(), rows=20_000, spikes=[(5000, 0, 0.3), (12_000, 0, -0.4)])


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


def dragged(tab, place, start, end):
    """Drag over a plot, from a share of its width to another."""
    place.scroll_into_view_if_needed()
    box = place.bounding_box()
    tab.mouse.move(box["x"] + start * box["width"], box["y"] + 20)
    tab.mouse.down()
    tab.mouse.move(box["x"] + end * box["width"], box["y"] + 30, steps=4)
    tab.mouse.up()


def test_by_mouse(opened, log):
    tab = opened()
    tab.get_by_role("button", name=log.name).click()
    assert tab.get_by_label("Use of accel_z").input_value() == "accel_z"
    assert "gravity" in tab.locator(".gravity").inner_text()
    tab.locator("#view figure canvas").first.wait_for()
    tab.get_by_role("button", name="Analyse", exact=True).click()
    wait_result(tab)
    assert "At rest" in tab.locator(".headline").inner_text()
    assert "2 × spike" in tab.locator("#part-left-out").inner_text()
    # A part is chosen by dragging, and left out.
    tab.get_by_role("button", name="Time series").click()
    dragged(tab, tab.locator("#part-series .u-over").first, 0.5, 0.75)
    assert float(tab.get_by_label("From, in seconds").input_value()) == pytest.approx(100, abs=3)
    tab.get_by_role("button", name="Zoom to it").click()
    tab.get_by_role("button", name="Leave this part out").click()
    assert "--leave-out" in command(tab, "--leave-out")
    tab.locator("#part-left-out", has_text="left out by you").wait_for()
    listed = tab.locator("#part-left-out .scrolled")
    assert listed.evaluate("one => one.scrollWidth <= one.clientWidth")  # its buttons are seen without scrolling
    # It is restored; then a spike.
    tab.get_by_role("row", name="left out by you").get_by_role("button").click()
    tab.locator("#part-left-out", has_text="2 × spike").wait_for()
    assert "--leave-out" not in tab.locator("#command").text_content()
    tab.get_by_role("button", name="Restore 50 s").click()
    assert "--keep 50s:50.01s" in command(tab, "--keep")
    tab.locator("#part-left-out", has_text="1 × spike").wait_for()
    # Undone and redone.
    tab.get_by_role("button", name="Undo").click()
    tab.locator("#part-left-out", has_text="2 × spike").wait_for()
    tab.get_by_role("button", name="Redo").click()
    tab.locator("#part-left-out", has_text="Restored: 50s:50.01s").wait_for()
    # Taken away: a file of a filter, the curves, and a configuration that says the same.
    tab.locator(".head").get_by_role("button", name="Export").click()
    tab.locator("input[value=kalibr]").check()
    tab.get_by_role("region", name="kalibr.yaml").wait_for()
    assert "gyroscope_noise_density" in tab.get_by_role("region", name="kalibr.yaml").inner_text()
    # An option of the file: preview, command line and session follow, and it is undone.
    tab.get_by_label("Horizon").fill("10")
    tab.get_by_label("Horizon").press("Enter")
    tab.get_by_role("region", name="kalibr.yaml").get_by_text("of its error after 10 s").first.wait_for()
    assert command(tab, "--horizon").endswith("--export kalibr=kalibr.yaml --horizon 10s")
    tab.get_by_role("button", name="Set “Consistent: bias”").first.click()
    command(tab, "--consistent bias")
    assert tab.get_by_label("Consistent").input_value() == "bias"
    assert "--" not in tab.locator(".preview .findings").inner_text()
    tab.get_by_role("button", name="Undo").click()
    tab.locator("#command", has_not_text="--consistent").wait_for()
    assert tab.get_by_label("Consistent").input_value() == "horizon"
    with tab.expect_download() as download:
        tab.get_by_role("button", name="Save kalibr.yaml").click()
    assert "gyroscope_noise_density" in download.value.path().read_text(encoding="utf-8")
    with tab.expect_download() as download:
        tab.get_by_role("link", name="Curves, CSV").click()
    assert len(list(csv.reader(download.value.path().read_text(encoding="utf-8").splitlines()))) > 50
    stated = tomllib.loads(tab.get_by_role("region", name="session.toml").text_content())
    assert stated["keep"] == ["50s:50.01s"]
    assert (stated["export"], stated["horizon"]) == (["kalibr=kalibr.yaml"], "10s")


def test_by_keys(opened, log):
    """Every step has the focus where it is seen, and no mouse is needed."""
    tab = opened()
    tab.get_by_role("button", name=log.name).wait_for()
    press(tab, "Tab", log.name)
    assert tab.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    tab.keyboard.press("Enter")
    tab.locator("#analyse:enabled").wait_for()
    tab.locator("#view figure").first.wait_for()
    press(tab, "Tab", "Analyse")
    tab.keyboard.press("Enter")
    wait_result(tab)
    # A line is laid by hand and moved by the arrow keys.
    press(tab, "Tab", "Line of slope −½")
    tab.keyboard.press("Space")
    press(tab, "Shift+Tab", "slope −½")
    handle = tab.get_by_role("slider")
    place = int(handle.get_attribute("aria-valuenow"))
    tab.keyboard.press("ArrowRight")
    assert int(handle.get_attribute("aria-valuenow")) == place + 1
    tab.locator('[role=slider][aria-valuetext*="error"]').wait_for()
    # A part is typed.
    press(tab, "Tab", "From, in seconds")
    tab.keyboard.type("10")
    press(tab, "Tab", "To, in seconds")
    tab.keyboard.type("150")
    press(tab, "Tab", "Analyse only this part")
    tab.keyboard.press("Enter")
    assert "--window 10s:150s" in command(tab, "--window")
    tab.locator("#part-left-out", has_text="the window").wait_for()
    tab.keyboard.press("Control+z")
    tab.locator("#command", has_not_text="--window").wait_for()
    press(tab, "Shift+Tab", "Export")
    tab.keyboard.press("Enter")
    tab.get_by_role("radio").first.wait_for()
    assert tab.locator(".targets :checked").count() == 0  # no program is chosen in advance
    tab.get_by_text("Choose a program").wait_for()
    press(tab, "Tab", "ardupilot")
    tab.keyboard.press("ArrowDown")
    tab.get_by_role("region", name="basalt.json").wait_for()
    # An option of the file keeps the focus; the file is saved.
    press(tab, "Tab", "Axes")
    tab.keyboard.press("End")
    assert "--axes each" in command(tab, "--axes")
    assert "Axes" in tab.evaluate(NAME_OF_FOCUS)
    tab.locator(".preview:not([aria-busy])").wait_for()  # the new file replaces the old one and its buttons
    press(tab, "Shift+Tab", "Save basalt.json")
    with tab.expect_download() as download:
        tab.keyboard.press("Enter")
    assert download.value.suggested_filename == "basalt.json"


def test_lines_by_hand_are_those_of_the_analysis(opened, log, page):
    """The value beside a handle is that of the interface, and a line that is wrong is refused with the slope."""
    tab = opened(fragment=fragment(log, step="result"))
    wait_result(tab)
    tab.get_by_role("button", name="By hand").click()
    tab.get_by_label("Line of slope −½").check()
    shown = tab.locator("td.read", has_text="±")
    shown.wait_for()
    tau = float(shown.locator(".tau").inner_text().split()[2])
    read = page.post(
        f"api/results/{page.analysed(path=str(log))}/read-off", channel="gyro_x", term="random_walk", tau_s=tau
    ).json()
    assert read["text"] in shown.inner_text()
    tab.get_by_label("Line of slope +1").check()
    tab.locator("td.read .refusal", has_text="slope").wait_for()
    assert tab.locator(".handle.refused").count() == 1
    # The line becomes an option, and the analysis reads it off there.
    shown.get_by_role("button", name="Use").click()
    assert "gyro_x.random_walk=" in command(tab, "--read-off-at")


def test_terms_are_switched(opened, log):
    tab = opened(fragment=fragment(log, step="result", window="0s:100s"))
    wait_result(tab)
    tab.get_by_role("button", name="By hand").click()
    picture = tab.locator("#part-by-hand canvas")
    before = picture.evaluate("canvas => canvas.toDataURL()")
    box = tab.get_by_label("angle random walk in the model")
    box.uncheck()
    assert picture.evaluate("canvas => canvas.toDataURL()") != before
    tab.locator(".skip").press("Enter")
    assert tab.evaluate("document.activeElement.id") == "view"
    assert "path=" in tab.evaluate("location.hash")  # the link to the content leaves the state alone
    # Without a term the analysis is made again, and the address has the state.
    tab.get_by_role("group", name="Terms that may be present").get_by_label("rate ramp").uncheck()
    assert "--terms quantization,random_walk,bias_instability,rate_random_walk" in command(tab, "--terms")
    state = tab.evaluate("new URLSearchParams(location.hash.slice(1)).get('options')")
    assert json.loads(state) == {
        "window": "0s:100s",
        "terms": "quantization,random_walk,bias_instability,rate_random_walk",
    }


def test_an_analysis_is_cancelled(opened, log):
    tab = opened(fragment=fragment(log, **{"leave-out": ["1s:2s"]}))
    tab.locator("#analyse:enabled").click()
    tab.get_by_role("button", name="Cancel").click()
    tab.locator("#status", has_text="cancelled").wait_for(state="attached")
    assert tab.locator("#progress").is_hidden()
    assert tab.locator("#step-result").is_disabled()
