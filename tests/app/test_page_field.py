"""The whole way on a recorded sensor: a million rows of six axes without time stamps. Skipped where the data are absent."""

import shutil

import pytest

pytest.importorskip("starlette")

from page_tabs import command, fragment, tabs, wait_result

pytest_plugins = ["workbench_pages"]  # the fixtures


def test_a_million_rows(browser, address, folder, field_data):
    log = shutil.copy(field_data / "adis16405_static.csv.gz", folder)
    with tabs(browser, address) as open_tab:
        tab = open_tab(fragment=fragment(log))
        box = tab.get_by_role("group", name="A choice is needed")
        box.get_by_label("Sampling rate [Hz]").fill("100")
        box.get_by_label("Sampling rate [Hz]").press("Enter")
        tab.locator("#view figure canvas").first.wait_for()
        assert "1,000,000 rows · 2.78 h · 100 Hz" in tab.locator(".head").inner_text()
        assert "gravity" in tab.locator(".gravity .chip").inner_text()
        # Twenty minutes of it are analysed.
        tab.get_by_label("From, in seconds").fill("600")
        tab.get_by_label("To, in seconds").fill("1800")
        tab.get_by_role("button", name="Analyse only this part").click()
        command(tab, "--window 600s:1800s")
        tab.locator("#analyse:enabled").click()
        wait_result(tab)
        assert "At rest" in tab.locator(".headline").inner_text()
        row = tab.locator("#part-summary").get_by_role("row", name="gyro_x")
        noise = float(row.locator(".value").first.inner_text().split()[0])
        assert noise == pytest.approx(2.4, rel=0.2)  # deg/√h; the whole record has 2.43
        assert tab.evaluate(HEIGHT_OF_CURVE) <= 900  # the curve is in sight beside the coefficients
        tab.locator("#step-files").click()
        tab.get_by_role("radio", name="kalibr").check()
        tab.get_by_role("region", name="kalibr.yaml").get_by_text("update_rate: 100").wait_for()


HEIGHT_OF_CURVE = "document.querySelector('#part-deviation .plot').getBoundingClientRect().bottom + scrollY"
