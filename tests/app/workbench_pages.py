"""A workbench with requests like those of its page: its guard, its routes and its workers."""

import pytest
from workbench_logs import write_log

pytest.importorskip("starlette")
from live_ports import Port
from workbench_served import TOKEN, Page, serving

from sigmatau.app.files import Roots
from sigmatau.app.routes import Workbench

MAX_UPLOAD = 3_000_000


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("logs")
    write_log(place / "static.csv")
    return place


@pytest.fixture(scope="session")
def workbench(folder):
    made = Workbench(Roots([folder]), max_upload=MAX_UPLOAD)
    yield made
    made.close()


@pytest.fixture(scope="session")
def client(workbench):
    with serving(workbench) as asking:
        yield asking


@pytest.fixture(scope="session")
def page(client, folder):
    return Page(client, folder / "static.csv")


@pytest.fixture(scope="session")
def result(page):
    """The identifier of the result of the log, with no options."""
    return page.analysed()


@pytest.fixture(scope="session")
def address(client):
    """The address of the page."""
    return f"{str(client.base_url).rstrip('/')}/{TOKEN}/"


@pytest.fixture
def port(tmp_path):
    """A simulated serial port with a folder for its log."""
    return Port(tmp_path)
