"""The page on files of every kind: questions, names of strangers, damage, motion, many channels, and small screens."""

import pytest

pytest.importorskip("starlette")

from page_tabs import PHONE, command, fragment, grave_findings, six_axes, tabs, wait_result, write_table

import sigmatau as st

HOSTILE = ["<img src=x onerror=document.title='run'>", "</script><script>document.title='run'</script>", "‮evil‬ ' & <b>"]

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


@pytest.fixture(scope="module")
def stored(folder):
    """A log and the result of its analysis."""
    log = write_table(folder / "short.csv", six_axes(), rows=6000)
    path = folder / "short.json"
    path.write_text(st.analyze(log).to_json(), encoding="utf-8")
    return log, path


def test_a_question_is_answered_by_its_buttons(opened, folder):
    log = write_table(folder / "headerless.csv", {k: (1e-2, 9.81 * (k == 5)) for k in range(6)})
    tab = opened(fragment=fragment(log), expected=["422", "400"])
    box = tab.get_by_role("group", name="A choice is needed")
    box.wait_for()
    assert tab.locator("#analyse").is_disabled()
    assert grave_findings(tab) == []
    assert "--" not in box.inner_text()  # the words of a page, not those of a command
    box.get_by_role("button", name="gyro in rad/s, accel in m/s^2").click()
    box.get_by_role("button", name="Unit of time: s", exact=True).click()
    tab.locator("#analyse:enabled").wait_for()
    assert box.count() == 0
    assert "gyro=rad/s,accel=m/s^2,time=s" in command(tab, "time=s")


def test_an_arduino_text_is_asked_for_columns_unit_and_rate(opened, folder):
    """Each question has one control; a unit of the gyroscope that is too large is seen before the analysis."""
    sizes = {k: (0.002, float(k == 2)) if k < 3 else (0.05, (0.4, -0.2, 0.1)[k - 3]) for k in range(6)}
    log = write_table(folder / "arduino.csv", sizes, time=False)
    tab = opened(fragment=fragment(log))
    box = tab.get_by_role("group", name="A choice is needed")
    box.get_by_role("button", name="accel in columns 1 to 3, gyro in columns 4 to 6").click()
    rate = box.get_by_label("Sampling rate [Hz]")
    rate.wait_for()
    assert rate.count() == 1
    rate.fill("100")
    rate.press("Enter")
    box.get_by_role("button", name="gyro in rad/s, accel in g").click()
    tab.locator("#analyse:enabled").wait_for()
    assert "large offset" in tab.locator(".rotation").inner_text()
    tab.get_by_label("Unit of gyro_x").fill("deg/s")
    tab.get_by_label("Unit of gyro_x").press("Enter")
    tab.locator(".rotation", has_text="is 0.4").wait_for()


def test_columns_are_changed_in_place(opened, stored):
    log, _ = stored
    tab = opened(fragment=fragment(log))
    tab.locator("#analyse:enabled").wait_for()
    unit = tab.get_by_label("Unit of gyro_x")
    unit.fill("deg/s")
    unit.press("Enter")
    assert "--unit gyro=deg/s" in command(tab, "--unit")  # of the whole sensor
    tab.locator("td", has_text="given by you").first.wait_for()
    assert tab.get_by_label("Unit of gyro_z").input_value() == "deg/s"
    tab.get_by_label("Use of accel_z").select_option("")
    words = command(tab, "--channels")
    assert "gyro_x=2" in words
    assert "accel_z" not in words
    tab.get_by_role("button", name="Undo").click()
    tab.locator("#command", has_not_text="--channels").wait_for()
    unit = tab.get_by_label("Unit of accel_x")
    unit.fill("g")
    unit.press("Enter")
    tab.locator(".gravity", has_text="The unit is probably m/s²").wait_for()
    # The address has the state: another tab shows the same.
    state = tab.evaluate("location.hash.slice(1)")
    again = opened(fragment=state)
    assert command(again, "--unit") == tab.locator("#command").text_content()


def test_names_of_strangers_are_text(opened, folder):
    names = {f"{name} [V]": (1.0, 0.0) for name in HOSTILE[:2]} | {"gyro_x [rad/s]": (1e-3, 0.0)}
    log = write_table(folder / f"{HOSTILE[0].replace('/', '')}.csv", names)
    tab = opened(fragment=fragment(log, channels={"gyro_x": 4, "signal": 2}))
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    assert HOSTILE[0] in tab.inner_text("h1")
    assert tab.evaluate("document.title") != "run"
    assert tab.evaluate("document.querySelectorAll('img, script:not([src])').length") == 0
    tab.locator("#step-columns").click()
    tab.locator("th", has_text=HOSTILE[1][:9]).first.wait_for()


@pytest.mark.parametrize("kind", ["moving", "damaged", "sixty"])
def test_odd_logs(opened, folder, kind):
    path, options = folder / f"{kind}.csv", {}
    if kind == "moving":
        write_table(
            path,
            {"gyro_x [rad/s]": (1e-3, 0.0)},
            rows=8000,
            spikes=[(slice(k, None), 0, 0.3) for k in range(0, 8000, 90)],
        )
    elif kind == "damaged":
        text = write_table(path, six_axes()).read_bytes()
        path.write_bytes(text[:100_000] + b"\x00\xff broken\n1,2\n" + text[100_000:-9])
    else:
        write_table(path, {f"s{k} [V]": (1.0, 0.0) for k in range(60)}, rows=2000)
        options = {"channels": {"time": 1} | {f"s{k}": k + 2 for k in range(60)}}
    tab = opened(fragment=fragment(path, step="result", **options))
    wait_result(tab)
    if kind == "moving":
        assert "not at rest" in tab.locator("#part-summary").inner_text()
        assert grave_findings(tab) == []
        tab.get_by_label("Analyse motion as noise").check()
        assert "--at-rest" in command(tab, "--at-rest")
        tab.locator("#part-summary table").wait_for()
    elif kind == "damaged":
        assert tab.locator("#part-findings .chip.error, #part-findings .chip.warning").count() > 0
    else:
        tab.locator("#part-deviation").get_by_label("Sensor").select_option("s41")
        tab.locator('#part-deviation figure[data-sensor="s41"]').wait_for()
    assert tab.evaluate("document.documentElement.scrollWidth") <= 1280


def test_a_stored_result_and_a_comparison(opened, stored):
    log, path = stored
    tab = opened(fragment=fragment(path))
    tab.locator("#part-coefficients article").first.wait_for()
    assert tab.locator("#part-series").count() == 0
    assert tab.locator("#step-columns").is_disabled()
    tab.locator("#step-open").click()
    tab.get_by_role("button", name=log.name).click()
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    tab.locator("#step-compare").click()
    tab.get_by_role("region", name="Repeatability").wait_for()
    row = tab.get_by_role("row", name="gyro_x angle random walk")
    assert row.locator(".value").nth(0).inner_text() == row.locator(".value").nth(1).inner_text()
    assert tab.locator("#view figure").count() == 2
    assert grave_findings(tab) == []


def test_a_session_is_opened(opened, stored, tmp_path):
    """The configuration that the page saves opens the log with its options."""
    log, _ = stored
    session = tmp_path / "session.toml"
    session.write_text(f'log = "{log}"\nwindow = "5s:50s"\nunit = {{ gyro = "deg/s" }}\n', encoding="utf-8")
    tab = opened()
    tab.locator("#chooser").set_input_files(session)
    assert command(tab, "--window").endswith(f"{log} --window 5s:50s --unit gyro=deg/s")
    tab.locator("#analyse:enabled").wait_for()


def test_a_session_with_a_file(opened, stored, tmp_path):
    """The file of the session is shown with its options; results of the comparison are offered as those at rest."""
    log, path = stored
    session = tmp_path / "session.toml"
    session.write_text(f'log = "{log}"\nexport = ["kalibr=kalibr.yaml"]\naxes = "mean"\n', encoding="utf-8")
    tab = opened(fragment=fragment(path))
    tab.locator("#part-coefficients article").first.wait_for()
    tab.locator("#step-open").click()
    tab.locator("#chooser").set_input_files(session)
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    tab.locator("#step-files").click()
    assert command(tab, "--export").endswith(f"{log} --export kalibr=kalibr.yaml --axes mean")
    tab.get_by_role("region", name="kalibr.yaml").wait_for()
    rest = tab.get_by_label("Inflate", exact=True)
    rest.select_option(index=1)
    tab.locator(".preview code", has_text="--inflate").wait_for()
    # What was removed from the comparison is not offered.
    tab.locator("#step-compare").click()
    tab.get_by_role("button", name="Remove").first.click()
    tab.locator("#step-files").click()
    tab.locator(".preview code", has_not_text="--inflate").wait_for()
    assert rest.count() == 0


def test_a_file_is_uploaded(opened, stored):
    log, _ = stored
    tab = opened()
    tab.locator("#chooser").set_input_files(log)
    tab.locator("#analyse:enabled").wait_for()
    assert log.name in tab.inner_text("h1")
    assert "file=" in tab.evaluate("location.hash")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_phone(opened, stored, scheme):
    log, _ = stored
    tab = opened(color_scheme=scheme, **PHONE)
    for step in ("open", "columns", "result", "files"):
        if step == "columns":
            tab.get_by_role("button", name=log.name).tap()
            tab.locator("#analyse:enabled").wait_for()
            tab.locator("#view figure").first.wait_for()
        elif step == "result":
            tab.locator("#analyse").tap()
            wait_result(tab)
        elif step == "files":
            tab.locator("#step-files").tap()
            tab.locator(".file-preview pre").first.wait_for()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390, step
        assert grave_findings(tab) == [], step


def test_paper(opened, stored):
    log, _ = stored
    tab = opened(fragment=fragment(log, step="result"), color_scheme="dark")
    wait_result(tab)
    tab.emulate_media(media="print")
    tab.locator("#part-density canvas").first.wait_for()
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert tab.locator("aside").is_hidden()
    assert tab.locator("#command").is_visible()
