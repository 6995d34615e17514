"""Compare on the page: runs of a store, a new log, a datasheet and a model, by mouse and by keys."""

import re

import pytest

pytest.importorskip("starlette")
pytest.importorskip("sqlalchemy", reason="the store needs it")

from page_tabs import PHONE, grave_findings, press, six_axes, tabs, wait_result, write_table

import sigmatau as st

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture(scope="module")
def lab(folder):
    """A folder with a store of two runs, a noise model, and a log of today."""
    place = folder / "lab"
    place.mkdir()
    with st.Store(place / "lab.db") as store:
        for name in ("march.csv", "april.csv"):
            store.add(st.analyze(write_table(place / name, six_axes())), unit="A1")
            (place / name).unlink()
    write_table(place / "today.csv", six_axes())
    (place / "walk.toml").write_text('[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n', encoding="utf-8")
    return place


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


def legend(tab):
    """What is compared."""
    return tab.get_by_role("group", name="In the figure").get_by_role("listitem")


def open_file(tab, lab, name):
    """Open a file of the folder."""
    tab.locator("#step-open").click()
    tab.get_by_role("button", name=f"{lab.name}/").click()
    tab.get_by_role("button", name=re.compile(f"^{name}")).click()


def picture(tab):
    """The first figure."""
    return tab.locator("#view figure canvas").first.evaluate("canvas => canvas.toDataURL()")


def test_by_mouse(opened, lab):
    tab = opened()
    open_file(tab, lab, "today.csv")
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    open_file(tab, lab, "lab.db")
    row = tab.get_by_role("row", name="march")
    row.get_by_role("button").click()
    row.get_by_role("button", disabled=True).wait_for()
    legend(tab).nth(1).wait_for()
    # Is it the same as last year? The difference of every coefficient has an interval.
    difference = tab.get_by_role("region", name="Differences").get_by_role("row", name="gyro_x random walk")
    assert "±" in difference.inner_text()
    assert "do not show a change" in tab.locator(".verdicts").inner_text()
    assert "STD" in tab.get_by_role("region", name="Tables I and III").inner_text()
    # A third result: the pair of the difference is chosen.
    tab.get_by_role("row", name="april").get_by_role("button").click()
    legend(tab).nth(2).wait_for()
    second = tab.get_by_label("New", exact=True)
    second.locator("option").nth(2).wait_for(state="attached")
    values = [option.inner_text() for option in second.get_by_role("option").all()]
    assert [value[0] for value in values] == ["1", "2", "3"]
    second.select_option(label=values[1])
    tab.get_by_text(f"New minus old: {values[1]} minus {values[0]}").wait_for()
    tab.get_by_role("button", name="Exchange").click()
    tab.get_by_text(f"New minus old: {values[0]} minus {values[1]}").wait_for()
    tab.get_by_role("region", name="Repeatability").get_by_text("3 runs").wait_for()
    # A curve is switched off, and on again.
    before = picture(tab)
    box = legend(tab).nth(2).get_by_role("checkbox")
    box.uncheck()
    assert picture(tab) != before
    box.check()
    # A model and a datasheet are curves in the same figure.
    open_file(tab, lab, "walk.toml")
    legend(tab).nth(3).wait_for()
    assert "walk" in legend(tab).nth(3).inner_text()
    tab.get_by_text("Datasheets", exact=True).click()
    tab.get_by_role("combobox", name="Datasheet").select_option("adis16405")
    tab.get_by_label("Noise densities").select_option("one")
    tab.get_by_label("Bias instability").select_option("minimum")
    tab.get_by_role("button", name="Add the datasheet").click()
    legend(tab).nth(4).wait_for()
    assert "ADIS16405" in legend(tab).nth(4).inner_text()
    with_datasheet = picture(tab)
    tab.get_by_role("button", name="Remove ADIS16405").click()
    assert picture(tab) != with_datasheet
    assert legend(tab).count() == 4


def add_file(tab, lab, name):
    """Add a file of the folder in place."""
    tab.get_by_text("Files in the opened folders").click()
    tab.get_by_role("button", name=f"{lab.name}/").click()
    tab.get_by_role("button", name=re.compile(f"^{name}")).click()


def test_files_are_added_in_place(opened, lab):
    """The answer, new minus old, stands above the figures; the address and the commands repeat the comparison."""
    write_table(lab / "noisy.csv", {name: (2 * size, mean) for name, (size, mean) in six_axes().items()})
    tab = opened()
    tab.locator("#step-compare").click()
    for name in ("today.csv", "noisy.csv"):
        add_file(tab, lab, name)
        tab.locator("#status", has_text=f"{name} was added").wait_for(state="attached")
    answer = tab.locator(".verdicts", has_text="coefficients changed")
    answer.wait_for()
    tab.get_by_text("New minus old: 2: noisy.csv minus 1: today.csv").wait_for()
    row = tab.get_by_role("region", name="Differences").get_by_role("row", name="gyro_x random walk").inner_text()
    assert re.search(r"\+[\d.]+ ± [\d.]+ deg/√h\s+changed", row), row
    assert answer.bounding_box()["y"] < tab.locator("#view figure").first.bounding_box()["y"]
    lines = tab.locator("#command").text_content().splitlines()
    assert lines[0] == f"sigmatau analyze {lab / 'today.csv'} --json today.json"
    assert lines[-1] == "sigmatau compare today.json noisy.json"
    legend(tab).first.get_by_role("checkbox").uncheck()
    legend(tab).first.get_by_role("checkbox").check()
    legend(tab).nth(1).get_by_role("checkbox").uncheck()
    tab.reload()
    legend(tab).nth(1).wait_for()
    assert [legend(tab).nth(k).get_by_role("checkbox").is_checked() for k in range(2)] == [True, False]
    legend(tab).nth(1).get_by_role("checkbox").check()
    answer.wait_for()


def test_a_question_about_a_log_is_asked_in_place(opened, lab):
    write_table(lab / "counts.csv", {1: (1e-3, 0.0), 2: (1e-3, 0.0), 3: (1e-3, 0.0)})
    tab = opened()
    tab.locator("#step-compare").click()
    add_file(tab, lab, "counts.csv")
    box = tab.get_by_role("group", name="A choice is needed")
    box.get_by_label("time=N, gyro=N:N, accel=N:N").fill("time=1,gyro=2:4")
    box.get_by_role("button", name="Set").click()
    box.get_by_role("button", name="gyro in rad/s").click()
    box.get_by_role("button", name="Unit of time: s", exact=True).click()
    legend(tab).first.wait_for()
    assert "counts" in legend(tab).first.inner_text()
    assert tab.locator("#step-compare").get_attribute("aria-current") == "step"
    assert grave_findings(tab) == []


def test_a_store_and_a_model_of_an_address(opened, lab):
    """Runs of a store, its list and a model are there again after a reload."""
    tab = opened()
    open_file(tab, lab, "lab.db")
    tab.get_by_role("row", name="march").get_by_role("button").click()
    legend(tab).first.wait_for()
    open_file(tab, lab, "walk.toml")
    legend(tab).nth(1).wait_for()
    tab.reload()
    legend(tab).nth(1).wait_for()
    assert tab.get_by_role("row", name="march").get_by_role("button").is_disabled()
    tab.get_by_role("row", name="april").get_by_role("button").click()
    tab.locator("#command", has_text="sigmatau compare").wait_for()
    lines = tab.locator("#command").text_content().splitlines()
    assert lines[0].startswith(f"sigmatau store show A1 --store {lab / 'lab.db'} --run march.csv --json ")


def test_by_keys(opened, lab):
    tab = opened()
    tab.get_by_role("button", name=f"{lab.name}/").wait_for()
    press(tab, "Tab", f"{lab.name}/")
    tab.keyboard.press("Enter")
    tab.get_by_role("button", name="lab.db").wait_for()
    press(tab, "Tab", "lab.db")
    tab.keyboard.press("Enter")
    tab.get_by_role("row", name="march").wait_for()
    press(tab, "Tab", "|Unit")
    tab.keyboard.type("A*")
    listed = tab.get_by_role("row", name="march").element_handle()
    tab.keyboard.press("Enter")
    listed.wait_for_element_state("hidden")  # the list is made anew, and takes the focus
    tab.get_by_role("row", name="march").wait_for()
    for name in ("Add A1 april", "Add A1 march"):
        press(tab, "Tab", name)
        tab.keyboard.press("Enter")
        tab.locator("#status", has_text=f"{name.removeprefix('Add ')}.csv was added").wait_for(state="attached")
    tab.get_by_role("region", name="Differences").wait_for()
    press(tab, "Shift+Tab", "1: A1")
    tab.keyboard.press("Space")
    assert not legend(tab).first.get_by_role("checkbox").is_checked()
    tab.get_by_role("region", name="Differences").wait_for(state="hidden")


def test_a_datasheet_that_leaves_its_convention_open(opened, lab):
    """The page says which choice is missing, in its words."""
    (lab / "sheet.toml").write_text(
        'name = "S"\nmaker = "M"\nsource = "a test"\n'
        '[gyro]\nnoise_density = { typical = "5 mdeg/s/sqrt(Hz)", sided = "unknown" }\n',
        encoding="utf-8",
    )
    tab = opened(expected=["400"])
    open_file(tab, lab, "sheet.toml")
    assert tab.get_by_role("combobox", name="Datasheet").input_value() == "file sheet.toml"
    tab.get_by_role("button", name="Add the datasheet").click()
    message = tab.get_by_role("alert").inner_text()
    assert "“Noise densities” one or two" in message
    tab.get_by_label("Noise densities").select_option("two")
    tab.get_by_role("button", name="Add the datasheet").click()
    legend(tab).first.wait_for()
    assert tab.get_by_role("alert").count() == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_phone(opened, lab, scheme):
    tab = opened(color_scheme=scheme, **PHONE)
    open_file(tab, lab, "lab.db")
    for name in ("march", "april"):
        tab.get_by_role("row", name=name).get_by_role("button").tap()
        tab.locator("#status", has_text=name).wait_for(state="attached")
    tab.get_by_role("region", name="Tables I and III").wait_for()
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    assert grave_findings(tab) == []


def test_a_store_is_the_file_of_the_command(browser, lab):
    """``sigmatau app lab.db`` begins with its runs."""
    from workbench_served import TOKEN, serving

    from sigmatau.app.files import Roots
    from sigmatau.app.routes import Workbench

    workbench = Workbench(Roots([lab / "lab.db"]), max_upload=10**6)
    try:
        with serving(workbench) as client, tabs(browser, f"{str(client.base_url).rstrip('/')}/{TOKEN}/") as open_tab:
            tab = open_tab()
            tab.get_by_role("row", name="march").wait_for()
            assert tab.locator("#step-compare").get_attribute("aria-current") == "step"
    finally:
        workbench.close()
