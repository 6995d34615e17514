"""The live step of the page: a port or a growing file is chosen, and the record ends in the log with its analysis."""

import pytest

pytest.importorskip("starlette")
pytest.importorskip("serial", reason="pyserial reads the port")
pytest.importorskip("pty", reason="no simulated ports")

from live_ports import WORDS, lines, noise, recorded, served
from page_tabs import PHONE, command, grave_findings, press, tabs, wait_result
from workbench_served import TOKEN

pytest_plugins = ["workbench_pages"]  # the fixtures


def page_address(page):
    """The address of the page of a client."""
    return f"{str(page.client.base_url).rstrip('/')}/{TOKEN}/"


def test_a_record_of_the_command_line(browser, port):
    rows = lines(9000)
    with recorded(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        port.write(rows[:1000])
        tab.locator(".wait", has_text="Too short to tell: coefficients in").wait_for()
        tab.locator("#live-series canvas").first.wait_for()
        port.write(rows[1000:])
        tab.locator("#live-summary table").wait_for()
        tab.locator("#live-deviation canvas").wait_for()
        tab.locator(".outlooks", has_text="gyro: angle random walk ±").wait_for()
        tab.locator(".headline", has_text="9000 samples").wait_for()
        tab.get_by_role("button", name="Stop and analyse").click()
        wait_result(tab)
        assert command(tab, "saved.csv") == f"sigmatau analyze {port.saved} {' '.join(WORDS)}"
        tab.get_by_role("button", name="Live").click()
        tab.locator("#open-saved").wait_for()
        assert tab.locator("#stop-live").count() == 0


def connect(tab, port):
    """Choose the port, its speed and the log by mouse."""
    tab.locator(".drop").wait_for()
    tab.locator("#step-live").click()
    tab.get_by_label("Port", exact=True).fill(port.name)
    tab.get_by_label("Baud [bit/s]").fill("57600")
    tab.get_by_label("Save as").fill(port.saved.name)
    tab.get_by_role("button", name="Connect").click()
    tab.locator("#stop-live").wait_for()
    port.begin()


def test_by_mouse(browser, port):
    """What the lines do not state is asked for, and the samples so far are read again with the answer."""
    rows = lines(9000)
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        connect(tab, port)
        port.write(rows[:4000])
        box = tab.get_by_role("group", name="A choice is needed")
        box.wait_for()
        assert "--" not in box.inner_text()
        assert tab.locator(".last-line").inner_text().count(",") == 2
        tab.get_by_label("Use of column 1").select_option("gyro x, y, z (3 columns)")
        tab.get_by_label("Unit of gyro_z").wait_for()
        assert tab.get_by_label("Use of column 3").input_value() == "gyro_z"
        assert grave_findings(tab) == []
        box.get_by_label("Sampling rate [Hz]").fill("100")
        box.get_by_role("button", name="Set").click()
        box.get_by_label("Sampling rate [Hz]").wait_for(state="detached")
        box.get_by_role("button", name="gyro in rad/s").click()
        tab.get_by_text("The mean of the gyroscope is").wait_for()
        tab.locator(".headline", has_text="4000 samples at 100 Hz").wait_for()
        port.write(rows[4000:])
        tab.locator(".headline", has_text="9000 samples").wait_for()
        tab.locator("#live-summary table").wait_for()
        words = command(tab, "--serial")
        assert words.startswith(f"sigmatau watch --serial {port.name} --baud 57600")
        assert words.endswith(f"--save {port.saved}")
        tab.locator("#stop-live").click()
        wait_result(tab)
        assert tab.locator("h1", has_text=port.saved.stem).count() == 1
        assert port.saved.read_bytes() == b"".join(rows)


def test_by_keys(browser, port):
    rows = lines(3000)
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        tab.locator(".drop").wait_for()
        press(tab, "Shift+Tab", "Live")
        tab.keyboard.press("Enter")
        tab.get_by_role("button", name="Look again").wait_for()
        press(tab, "Tab", "|Port")
        tab.keyboard.type(port.name)
        press(tab, "Tab", "|Save as")
        tab.keyboard.press("Control+a")
        tab.keyboard.type(port.saved.name)
        tab.keyboard.press("Enter")
        tab.locator("#stop-live").wait_for()
        port.begin()
        port.write(rows)
        tab.get_by_label("Use of column 1").wait_for()
        press(tab, "Tab", "Use of column 1")
        tab.keyboard.type("gyro x, y")
        tab.get_by_label("Unit of gyro_x").wait_for()
        press(tab, "Tab", "Unit of gyro_x")
        tab.keyboard.type("rad/s")
        press(tab, "Shift+Tab", "|Sampling rate")
        tab.locator("#command", has_text="--unit gyro=rad/s").wait_for()
        tab.keyboard.type("100")
        tab.keyboard.press("Enter")
        tab.locator(".headline", has_text="3000 samples").wait_for()
        press(tab, "Tab", "Stop and analyse")
        tab.keyboard.press("Enter")
        wait_result(tab)


def test_options_after_the_stop(browser, port):
    """The question stays, and its answers analyse the saved log."""
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        tab.locator(".drop").wait_for()
        assert grave_findings(tab) == []
        connect(tab, port)
        port.write(lines(3000))
        tab.get_by_label("Use of column 1").wait_for()
        tab.locator("#stop-live").click()
        tab.locator("#open-saved").wait_for()
        assert grave_findings(tab) == []
        tab.get_by_label("Use of column 1").select_option("gyro")
        tab.locator("#step-columns[aria-current]").wait_for()
        assert tab.get_by_label("Use of column 3").input_value() == "gyro_z"


def test_a_port_that_is_lost(browser, port):
    """The page says it in words, and the log is there."""
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        connect(tab, port)
        port.write(lines(500))
        port.unplug()
        message = tab.get_by_role("alert").filter(has_text="the serial port is gone")
        message.wait_for()
        assert "Check its cable" in message.inner_text()
        tab.locator("#open-saved").wait_for()
        tab.locator("#record-again").click()
        tab.get_by_label("Port", exact=True).wait_for()


def test_a_wrong_speed(browser, port):
    """Bytes that are no text: the page says what to check."""
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        connect(tab, port)
        port.write([noise()])
        tab.get_by_role("alert").filter(has_text="Check the baud rate").wait_for()


def test_a_file_that_grows(browser, port, tmp_path):
    log, rows = tmp_path / "growing.csv", lines(6000)
    head = b"gyro_x [rad/s],gyro_y [rad/s],gyro_z [rad/s]\r\n"
    log.write_bytes(head + b"".join(rows[:2000]))
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab()
        tab.locator(".drop").wait_for()
        tab.locator("#step-live").click()
        tab.get_by_role("button", name=log.name).click()
        box = tab.get_by_role("group", name="A choice is needed")
        box.get_by_label("Sampling rate [Hz]").fill("100")
        box.get_by_label("Sampling rate [Hz]").press("Enter")
        tab.locator(".headline", has_text="2000 samples").wait_for()
        with log.open("ab") as file:
            file.write(b"".join(rows[2000:]))
        tab.locator(".headline", has_text="6000 samples").wait_for()
        assert command(tab, "--rate") == f"sigmatau watch {log} --rate 100"
        tab.locator("#stop-live").click()
        wait_result(tab)
        assert command(tab, "analyze") == f"sigmatau analyze {log} --rate 100"


def test_a_late_state_of_the_record(browser, port, tmp_path):
    """Until it comes, the files of the last step are not on screen, and it replaces no step that was chosen meanwhile."""
    (tmp_path / "still.csv").write_bytes(b"".join(lines(200)))
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab, held = open_tab(), []
        tab.get_by_role("button", name="still.csv").wait_for()
        tab.route("**/api/live", lambda route: held.append(route))  # a built-in function is refused
        tab.locator("#step-live").click()
        tab.get_by_text("Looking for a live record…").wait_for()
        assert tab.get_by_role("button", name="still.csv").count() == 0
        tab.locator("#step-open").click()
        tab.get_by_role("button", name="still.csv").wait_for()
        with tab.expect_response("**/api/live"):
            held.pop().continue_()
        tab.get_by_role("button", name="still.csv").click()
        tab.locator("#step-columns[aria-current]").wait_for()
        tab.get_by_label("Use of column 1").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_phone(browser, port, scheme):
    with served(port) as page, tabs(browser, page_address(page)) as open_tab:
        tab = open_tab(color_scheme=scheme, **PHONE)
        connect(tab, port)
        port.write(lines(200))
        tab.get_by_role("group", name="A choice is needed").wait_for()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390
        assert grave_findings(tab) == []
        tab.locator("#stop-live").tap()
        tab.locator("#record-again").tap()
        tab.get_by_role("button", name="Connect").wait_for()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390
        assert grave_findings(tab) == []
