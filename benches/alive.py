"""Speed of the theory page in Chromium: ``python -m benches.alive``, after `make alive`.

Prints, for a still page and for a slider that moves in each frame, the frames per second, and the processor time of the page
in a frame, which has 16.7 ms at 60 frames per second; and the time of the estimate of 10⁵ samples in its worker.
"""

from __future__ import annotations

import shutil
import sys
import time
from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parents[1] / "target" / "alive" / "index.html"
FRAMES = 120
SLIDERS = ("N", "B", "K", "time", "hours")
ESTIMATES = 5
_MOVE = """async ([id, frames]) => {
    const slider = document.getElementById(`slider-${id}`), begun = performance.now();
    for (let k = 0; k < frames; k++) {
        slider.value = String(Math.round(240 + 80 * Math.sin(k / 20)));
        slider.dispatchEvent(new Event("input"));
        await new Promise(requestAnimationFrame);
    }
    return 1000 * frames / (performance.now() - begun);
}"""
_STILL = """async (frames) => {
    const begun = performance.now();
    for (let k = 0; k < frames; k++) await new Promise(requestAnimationFrame);
    return 1000 * frames / (performance.now() - begun);
}"""
_SETTINGS = """() => {
    Object.assign(alive.settings.value, {rate: 100, hours: 1e5 / 100 / 3600});
    alive.settings.seed++;
    alive.change();
}"""


def _until(tab: Any, condition: str) -> None:
    """Wait for a condition on the page."""
    end = time.monotonic() + 60
    while not tab.evaluate(f"Boolean({condition})"):
        if time.monotonic() > end:
            raise TimeoutError(condition)
        time.sleep(0.02)


def _processor_time(session: Any) -> float:
    """Processor time of the thread of the page so far. [s]"""
    metrics = session.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in metrics if each["name"] == "TaskDuration"))


def main() -> int:
    """Measure, and print a line for each slider and one for the estimate."""
    from playwright.sync_api import sync_playwright

    if not PAGE.exists():
        sys.stderr.write("There is no target/alive/index.html. Run make alive first.\n")
        return 1
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        tab = browser.new_page(viewport={"width": 1440, "height": 900})
        tab.goto(PAGE.as_uri())
        _until(tab, "window.alive && alive.shown.fit")
        session = tab.context.new_cdp_session(tab)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        tab.evaluate("alive.settings.on.sigma = true")
        sys.stdout.write(f"nothing moves  {tab.evaluate(_STILL, FRAMES):5.1f} frames/s: what this machine allows\n")
        for name in SLIDERS:
            before = _processor_time(session)
            rate = tab.evaluate(_MOVE, [name, FRAMES])
            spent = 1e3 * (_processor_time(session) - before) / FRAMES
            sys.stdout.write(f"slider {name:6} {rate:5.1f} frames/s, processor time {spent:4.1f} ms a frame\n")
            _until(tab, "alive.shown.fit")
        times = []
        for _ in range(ESTIMATES):
            tab.evaluate(_SETTINGS)
            time.sleep(0.1)
            _until(tab, "alive.shown.fit")
            times.append(tab.evaluate("alive.shown.fit.time"))
        samples = tab.evaluate("alive.shown.samples")
        sys.stdout.write(f"estimate of {samples} samples: {', '.join(f'{each:.0f}' for each in times)} ms\n")
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
