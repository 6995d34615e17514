"""Two pages of one workbench at once: neither changes what the other shows."""

import pytest

pytest.importorskip("starlette")

from page_tabs import command, fragment, six_axes, tabs, wait_result, write_table
from workbench_logs import write_long

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


def test_each_has_its_log_its_options_and_its_analysis(opened, folder):
    short = write_table(folder / "short_of_two.csv", six_axes())
    long = write_long(folder / "long_of_two.npy")
    reading = {"rate": 100, "unit": {"gyro": "rad/s"}, "channels": {"gyro": "1:3"}}
    first, second = opened(fragment=fragment(short)), opened(fragment=fragment(long, **reading))
    for tab in (first, second):
        tab.locator("#analyse:enabled").wait_for()
    # The second analysis is cancelled; the first one goes on.
    first.locator("#analyse").click()
    second.locator("#analyse").click()
    second.get_by_role("button", name="Cancel").click()
    second.locator("#status", has_text="cancelled").wait_for(state="attached")
    wait_result(first)
    assert second.locator("#step-result").is_disabled()
    assert short.name in first.inner_text("h1")
    assert long.name in second.inner_text("h1")
    # Both change their options; undo is of each page alone.
    first.get_by_label("Window").fill("0s:40s")
    first.get_by_label("Window").press("Enter")
    assert "--window 0s:40s" in command(first, "--window")
    second.locator("#analyse").click()
    wait_result(second)
    before = first.locator("#command").text_content(), first.evaluate("location.hash")
    second.get_by_label("Analyse motion as noise").check()
    command(second, "--at-rest")
    second.get_by_role("button", name="Undo").click()
    second.locator("#command", has_not_text="--at-rest").wait_for()
    assert (first.locator("#command").text_content(), first.evaluate("location.hash")) == before
    first.get_by_role("button", name="Undo").click()
    first.locator("#command", has_not_text="--window").wait_for()
    # A comparison has the results of its page.
    first.locator("#step-compare").click()
    items = first.get_by_role("group", name="In the figure").get_by_role("listitem")
    assert items.count() >= 1
    assert all("short_of_two" in item.inner_text() for item in items.all())
