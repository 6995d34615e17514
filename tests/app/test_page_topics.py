"""A file with several topics: one is chosen on the page, by mouse and by keys, and its columns by number."""

import pytest

pytest.importorskip("starlette")

from page_tabs import command, fragment, press, tabs, wait_result
from workbench_logs import write_bag

pytest_plugins = ["workbench_pages"]  # the fixtures

TOPICS = {"/front/imu": 1e-3, "/rear/imu": 4e-3}


@pytest.fixture(scope="module")
def bag(folder):
    return write_bag(folder / "two.bag", TOPICS)


@pytest.fixture
def opened(browser, address):
    with tabs(browser, address) as open_tab:
        yield open_tab


def test_columns_of_a_chosen_topic_are_chosen_by_number(page, bag):
    asked = page.post("api/open", path=str(bag)).json()
    assert asked["question"]["option"] == "topic"
    assert "--" not in asked["question"]["message"]
    assert [topic["name"] for topic in asked["topics"]] == list(TOPICS)
    numbers = {column["channel"]: column["number"] for column in asked["columns"]}
    channels = {"gyro_x": numbers["gyro_y"], "gyro_y": numbers["gyro_x"], "time": numbers["time"]}
    chosen = {"topic": "/rear/imu", "channels": channels, "unit": {"gyro": "rad/s"}}
    usual = page.post("api/open", path=str(bag), options={"topic": "/rear/imu"}).json()
    swapped = page.post("api/open", path=str(bag), options=chosen).json()
    assert swapped["question"] is None
    assert {column["topic"] for column in swapped["columns"]} == {"/rear/imu"}
    means = [{column["channel"]: column["mean_si"] for column in opened["columns"]} for opened in (usual, swapped)]
    assert (means[0]["gyro_x"], means[0]["gyro_y"]) == (means[1]["gyro_y"], means[1]["gyro_x"])
    assert [channel["channel"] for channel in swapped["channels"]] == ["gyro_x", "gyro_y"]


def test_by_mouse(opened, bag):
    tab = opened(fragment=fragment(bag))
    box = tab.get_by_role("group", name="A choice is needed")
    box.get_by_role("button", name="Read topic /rear/imu").click()
    tab.locator("#analyse:enabled").wait_for()
    assert tab.get_by_label("Topic").input_value() == "/rear/imu"
    assert command(tab, "--topic").endswith("--topic /rear/imu")
    # The use of a column is changed: the topic stays.
    tab.get_by_label("Use of linear_acceleration.z").select_option("")
    words = command(tab, "--channels")
    assert "--topic /rear/imu" in words
    assert "accel_z" not in words
    tab.locator("#analyse:enabled").click()
    wait_result(tab)
    assert tab.locator("#part-coefficients article").count() == 5
    # Another topic has columns of its own.
    tab.locator("#step-columns").click()
    tab.get_by_label("Topic").select_option("/front/imu")
    assert command(tab, "/front/imu").endswith("--topic /front/imu")
    tab.locator("#analyse:enabled").wait_for()


def test_a_column_that_is_changed_chooses_its_topic(opened, bag):
    tab = opened(fragment=fragment(bag))
    tab.get_by_label("Use of angular_velocity.z").select_option("")
    words = command(tab, "--channels")
    assert "--topic /front/imu" in words
    tab.locator("#analyse:enabled").wait_for()
    assert tab.get_by_label("Use of angular_velocity.y").input_value() == "gyro_y"
    assert tab.get_by_label("Use of angular_velocity.z").count() == 0  # folded with the columns that are not used


def test_by_keys(opened, bag):
    tab = opened(fragment=fragment(bag))
    tab.get_by_role("group", name="A choice is needed").wait_for()
    press(tab, "Tab", "Read topic /front/imu")
    tab.keyboard.press("Enter")
    tab.locator("#analyse:enabled").wait_for()
    tab.keyboard.press("Control+Enter")
    wait_result(tab)
