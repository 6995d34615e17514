"""Take the pictures of docs/how-to/workbench.md: ``PYTHONPATH=python .venv/bin/python docs/workbench.py``.

It starts the workbench, and gives the log of the demo to its page in chromium.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from playwright.sync_api import Locator, Page, sync_playwright

from sigmatau.cli import main

HERE = Path(__file__).resolve().parent
WIDTH, HEIGHT = 1280, 1000


def take(tab: Page, name: str) -> None:
    """One picture of what is on screen."""
    tab.evaluate("scrollTo(0, 0)")
    tab.wait_for_timeout(500)
    tab.screenshot(path=HERE / "figures" / f"workbench-{name}.jpg", type="jpeg", quality=62)


def wait(place: Locator) -> None:
    """Wait until a place has a chart."""
    place.locator("figure canvas").first.wait_for()


def walk(tab: Page) -> None:
    """Go from the columns to the exported files, and compare the first hour with the whole record and a datasheet."""
    tab.locator("#chooser").set_input_files("static.csv")
    tab.locator("#analyse:enabled").wait_for()
    wait(tab.locator("#view"))
    tab.locator("#command", has_text="analyze").wait_for()
    take(tab, "columns")
    tab.locator("#analyse").click()
    wait(tab.locator("#part-deviation"))
    tab.locator("#part-series figure").first.wait_for(state="attached")
    take(tab, "result")
    tab.locator(".head").get_by_role("button", name="Export").click()
    tab.locator("input[value=kalibr]").check()
    tab.get_by_role("region", name="kalibr.yaml").wait_for()
    take(tab, "take-away")
    tab.locator("#step-result").click()
    tab.get_by_label("Window").fill("0s:1h")
    tab.get_by_label("Window").press("Enter")
    tab.locator("#command", has_text="--window").wait_for()
    tab.locator("#part-left-out", has_text="the window").wait_for()
    tab.locator("#step-compare").click()
    tab.get_by_text("Datasheets", exact=True).click()
    tab.get_by_role("combobox", name="Datasheet").select_option("hg1700")
    tab.get_by_role("button", name="Add the datasheet").click()
    tab.get_by_role("region", name="Differences").wait_for()
    tab.locator("figure canvas").first.wait_for()
    take(tab, "compare")


def click_figure(tab: Page, folder: Path) -> None:
    """Click the ticks and the curve of a drawn figure, whose axes end at labelled ticks."""
    drawing = Figure(figsize=(6.4, 4.8))
    axes = drawing.add_subplot(xscale="log", yscale="log", xlabel="averaging time [s]", ylabel="Allan deviation [°/h]")
    tau = np.geomspace(0.01, 3000, 40)
    values = np.hypot(np.hypot(18 / np.sqrt(tau), 8.0), 0.58 * np.sqrt(tau))
    axes.plot(tau, values, color="black")
    axes.grid(which="both", alpha=0.4)
    axes.set(xlim=(0.01, 1e4), ylim=(1, 1e3))
    drawing.savefig(folder / "datasheet.png", dpi=100)
    tab.locator("#step-open").click()
    tab.locator("#chooser").set_input_files(folder / "datasheet.png")
    tab.locator(".figure-step:not([hidden])").wait_for()
    tab.wait_for_timeout(500)
    box = tab.locator(".holder").bounding_box() or {}
    zoom = box["width"] / 640

    def click(time: float, value: float) -> None:
        x, y = axes.transData.transform((time, value))
        tab.mouse.click(box["x"] + zoom * x, box["y"] + zoom * (480 - y))

    for place, text in (((0.01, 1), "0.01"), ((1e4, 1), "10^4"), ((0.01, 1), "1"), ((0.01, 1e3), "1000")):
        click(*place)
        tab.keyboard.type(text)
        tab.keyboard.press("Enter")
    for k in range(0, len(tau), 2):
        click(tau[k], values[k])
    tab.locator("#command", has_text="sigmatau curve").wait_for()
    take(tab, "figure")


def run() -> None:
    """Take all pictures."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        os.chdir(folder)
        main(["demo", "--output", ".", "--quiet"])
        Path("opened").mkdir()
        command = [sys.executable, "-m", "sigmatau", "app", "opened", "--no-browser"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                address = next(word for line in server.stdout or () for word in line.split() if word.startswith("http"))
                browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
                tab = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
                tab.set_default_timeout(120_000)
                tab.goto(address)
                walk(tab)
                click_figure(tab, Path(folder))
                browser.close()
            finally:
                server.terminate()


if __name__ == "__main__":
    run()
