"""Take the pictures of docs/report.md: ``PYTHONPATH=python .venv/bin/python docs/reports.py``, where the field data are.

It analyses the demo and real logs, and opens their reports in chromium. With arguments, only the pictures of these names.
"""

from __future__ import annotations

import os
import shlex
import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from sigmatau.cli import main

HERE = Path(__file__).resolve().parent
DATA = Path(os.environ.get("SIGMATAU_FIELD_DATA", HERE.parents[1] / "shared" / "data"))
_VN100 = "--channels time=1,gyro=11:13,accel=8:10 --unit time=us,gyro=rad/s,accel=m/s^2"
_POSITIONS = "--channels accel=1:3,gyro=4:6 --rate 100 --unit accel=m/s^2,gyro=rad/s"

# Name, and command without --report
LOGS = {
    "demo": "analyze static.csv",
    "adis16405": f"analyze {DATA}/adis16405_static.csv.gz --rate 100",
    "vn100": f"analyze {DATA}/field/vn100_stationary.mat {_VN100}",
    "xdot": f"analyze {DATA}/field/xdot_2.csv.gz --unit gyro=deg/s,accel=m/s^2,time=s",
    "positions": f"analyze {DATA}/field/many_positions.log {_POSITIONS}",
}

# Picture: log, width of the window, height of the picture, options of the browser
PICTURES = {
    "desktop": ("demo", 1280, 1500, {}),
    "dark": ("demo", 1280, 1500, {"color_scheme": "dark"}),
    "phone": ("demo", 390, 1700, {"is_mobile": True, "has_touch": True}),
    "paper": ("demo", 720, 1500, {}),
    **{name: (name, 1280, 4300, {}) for name in LOGS if name != "demo"},
}


def take(browser: Browser, page: Path, name: str) -> None:
    """One picture of a page."""
    _, width, height, options = PICTURES[name]
    context = browser.new_context(viewport={"width": width, "height": 900}, **options)
    tab = context.new_page()
    tab.goto(page.as_uri())
    if name == "paper":
        tab.emulate_media(media="print")
    for _ in range(height // 400):  # charts are drawn when they are near
        tab.mouse.wheel(0, 400)
        tab.wait_for_timeout(80)
    tab.evaluate("scrollTo(0, 0)")
    tab.wait_for_timeout(300)
    whole = min(height, tab.evaluate("document.documentElement.scrollHeight"))
    clip = {"x": 0, "y": 0, "width": width, "height": whole}
    tab.screenshot(path=HERE / "figures" / f"report-{name}.jpg", type="jpeg", quality=72, full_page=True, clip=clip)
    context.close()


def run() -> None:
    """Take all pictures, or those that are named."""
    wanted = sys.argv[1:] or list(PICTURES)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        os.chdir(folder)
        main(["demo", "--output", ".", "--quiet"])
        program = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for log in {PICTURES[name][0] for name in wanted}:
            main([*shlex.split(LOGS[log]), "--report", f"{log}.html", "--quiet"])
        for name in wanted:
            take(browser, Path(folder) / f"{PICTURES[name][0]}.html", name)
        browser.close()


if __name__ == "__main__":
    run()
