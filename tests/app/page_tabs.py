"""Tabs of a browser that show the workbench, and actions of its tests in them."""

import contextlib
import json
import urllib.parse

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe

from known import seed_of

AXES = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
PHONE = {"viewport": {"width": 390, "height": 844}, "is_mobile": True, "has_touch": True}
LIMIT = 60_000  # longest time of an analysis in a tab [ms]


def write_table(path, columns, *, rows=6000, rate=100.0, spikes=(), time=True):
    """Write a table of time and white noise, with size and mean of each column by name; a column named by a number has no
    header.
    """
    noise = np.random.default_rng(seed_of(path.name)).standard_normal((rows, len(columns)))
    sizes, means = np.array(list(columns.values())).T
    noise = noise * sizes + means
    for row, column, size in spikes:
        noise[row, column] += size
    names = [name for name in columns if isinstance(name, str)]
    header = ",".join(["time [s]", *(f'"{name}"' for name in names)]) if names else ""
    np.savetxt(
        path,
        np.column_stack([np.arange(rows) / rate, noise]) if time else noise,
        delimiter=",",
        header=header,
        comments="",
        fmt="%.7g",
    )
    return path


def six_axes(units=("rad/s", "m/s^2")):
    """Columns of a table of six axes at rest."""
    return {
        f"{name} [{units[name.startswith('accel')]}]": (
            (1e-2, 9.81 * (name == "accel_z")) if "accel" in name else (1e-3, 0.0)
        )
        for name in AXES
    }


@contextlib.contextmanager
def tabs(browser, address):
    """Open tabs on the workbench; at the end, check that there were no errors in them and no requests to other hosts."""
    contexts, complaints = [], []

    def open_tab(*, expected=(), fragment=None, **options):
        context = browser.new_context(**({"viewport": {"width": 1280, "height": 900}} | options))
        contexts.append(context)
        tab = context.new_page()
        tab.set_default_timeout(LIMIT)
        tab.on("console", lambda message: note(f"{message.type}: {message.text}"))
        tab.on("pageerror", lambda error: note(f"error: {error}"))
        tab.on(
            "request",
            lambda request: (
                None if request.url.startswith((address, "blob:", "data:")) else note(f"request: {request.url}")
            ),
        )

        def note(text):
            if not any(word in text for word in expected):
                complaints.append(text)

        tab.goto(address + ("" if fragment is None else f"#{fragment}"))
        return tab

    try:
        yield open_tab
    finally:
        for context in contexts:
            context.close()
    assert complaints == [], complaints


def grave_findings(tab):
    """Serious and critical findings of axe-core on the page as it is, contrast of texts included."""
    violations = Axe().run(tab, options={"resultTypes": ["violations"]}).response["violations"]
    return [
        f"{found['id']}: {node['target']} {node['html'][:120]}"
        for found in violations
        if found["impact"] in ("serious", "critical")
        for node in found["nodes"]
    ]


def fragment(path, *, step="columns", **options):
    """URL fragment of a state: a file, options and a step."""
    parts = {"path": str(path)} | ({"options": json.dumps(options)} if options else {}) | {"step": step}
    return urllib.parse.urlencode(parts)


def wait_result(tab):
    """Wait for the result of an analysis on screen, with its charts of the samples."""
    tab.locator("#part-summary").wait_for()
    tab.locator("#part-series figure").first.wait_for(state="attached")
    tab.locator("#part-map figure, #part-map .none").first.wait_for(state="attached")


def command(tab, text):
    """Wait until the command line on screen has a text."""
    tab.locator("#command", has_text=text).wait_for()
    return tab.locator("#command").text_content()


def press(tab, keys, until=None, most=80):
    """Press a key until an element with this name has the focus."""
    for _ in range(most):
        tab.keyboard.press(keys)
        if until is None or until in tab.evaluate(NAME_OF_FOCUS):
            return
    pytest.fail(f"{until}: not reached by {keys}")


NAME_OF_FOCUS = """() => {
    const one = document.activeElement;
    return [one.getAttribute("aria-label"), one.textContent.slice(0, 60), one.closest("label")?.textContent].join("|");
}"""
