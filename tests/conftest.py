"""Fixtures for several tests, such as the field data if they exist."""

import contextlib
import gc
import importlib.util
import os
import shutil
import tempfile
import time
import uuid
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

import pytest

from sigmatau.hints import as_options, speaking

os.environ["LC_ALL"] = "C.UTF-8"  # in the locale C symbols are written in ASCII
ROOT = Path(__file__).resolve().parent.parent
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "gw0")
COLLECTED = Path(tempfile.gettempdir(), f"sigmatau-tests-{os.environ.get('PYTEST_XDIST_TESTRUNUID', os.getpid())}")
IS_COMPILED = (ROOT / "tests" / "io" / "__pycache__").exists()
LATE_BROWSER = 9  # exit code, for scripts/test.sh
FAILED = dict[str, bool]()  # failed tests, and whether each is in a browser
LONGEST_COLLECTION = 120.0  # longest wait of the other workers [s]
gc.disable()  # no garbage collection while ten thousand tests are collected, none of which can be freed


def skip_without(package: str, reason: str) -> None:
    """Skip a module of tests if a package is not installed. It is not imported: every worker collects all modules."""
    if importlib.util.find_spec(package) is None:
        pytest.skip(reason, allow_module_level=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    """`--long` runs the tests of long.txt too; `--cpu-times` shows which belong there."""
    parser.addoption("--long", action="store_true", help="run also the tests of tests/long.txt: every night")
    parser.addoption("--cpu-times", type=Path, help="append the CPU time of each test to this file, as in long.txt [s]")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Write the CPU time of a test and its child processes, if a file is given."""
    start = sum(os.times()[:4])
    try:
        return (yield)
    finally:
        if file := item.config.getoption("--cpu-times"):
            with file.open("a", encoding="utf-8") as stream:
                stream.write(f"{sum(os.times()[:4]) - start:5.1f} {item.nodeid}\n")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the tests in a browser and the long tests. Deselect these, except with `--long` and where they are named."""
    lines = (ROOT / "tests" / "long.txt").read_text(encoding="utf-8").splitlines()
    names = {line.split(maxsplit=1)[1] for line in lines if not line.startswith("#")}
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
        if item.nodeid in names:
            item.add_marker("long")
    if any("::" in argument for argument in config.args):
        return
    # Of files that are collected in part, as with --last-failed, nothing shows whether a test exists.
    if not any(config.getoption(option, None) for option in ("lf", "keyword", "markexpr", "ignore", "deselect")):
        collected = {item.nodeid for item in items}
        files = {name.split("::")[0] for name in collected}
        if removed := {name for name in names - collected if name.split("::")[0] in files}:
            raise pytest.UsageError(f"tests/long.txt names tests that do not exist: {', '.join(sorted(removed))}")
    if config.getoption("--long"):
        return
    long = [item for item in items if item.get_closest_marker("long")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if not item.get_closest_marker("long")]


def pytest_sessionstart() -> None:
    """In a new clone the first worker compiles the tests and their imports; the others wait for it."""
    until = time.monotonic() + LONGEST_COLLECTION
    while WORKER != "gw0" and not (IS_COMPILED or COLLECTED.exists()) and time.monotonic() < until:
        time.sleep(0.1)


def pytest_collection_finish() -> None:
    """Let the other workers begin, and exclude the tests from garbage collection."""
    if WORKER == "gw0":
        COLLECTED.touch()
    gc.freeze()
    gc.enable()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note which tests failed, and whether each is in a browser."""
    if report.failed:
        FAILED[report.nodeid] = "browser" in report.keywords


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Remove the mark of this run. The exit code is `LATE_BROWSER` if only tests in a browser failed."""
    if WORKER == "gw0":
        COLLECTED.unlink(missing_ok=True)
    if session.exitstatus == pytest.ExitCode.TESTS_FAILED and FAILED and all(FAILED.values()):
        session.exitstatus = LATE_BROWSER


@pytest.fixture(autouse=True)
def all_digits(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exports have all digits, so that tests check their formulas to 1e-12, except with the marker ``as_written``."""
    if request.path.parent.name == "exporting" and not request.node.get_closest_marker("as_written"):
        monkeypatch.setattr("sigmatau.exporting.text.DIGITS", None)


@pytest.fixture(autouse=True, scope="session")
def options_assembled_once() -> Iterator[None]:
    """The parser collects the options of a command once: it takes 12 ms of each call of `main` in a process."""
    from cyclopts import App
    from cyclopts.argument import ArgumentCollection

    assemble, collected = App.assemble_argument_collection, dict[tuple[object, str], ArgumentCollection]()

    def copy_of_known(self: App, **how: object) -> ArgumentCollection:
        key = (self.default_command, repr(how))
        if key not in collected:
            collected[key] = assemble(self, **how)
        fresh = collected[key].copy(reset_tokens=True)
        copies = {id(first): second for first, second in zip(collected[key], fresh, strict=True)}
        for argument in fresh:
            argument.children = ArgumentCollection(copies[id(child)] for child in argument.children)
        return fresh

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(App, "assemble_argument_collection", copy_of_known)
        yield


@pytest.fixture(autouse=True, scope="session")
def figures_without_layout() -> Iterator[None]:
    """Figures of commands are drawn, but their margins are not fitted: half the time of a figure."""
    from sigmatau.plot import curves

    save = curves.save

    def drawn(figure: Any, path: str) -> None:
        figure.set_layout_engine("none")
        save(figure, path)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curves, "save", drawn)
        yield


@pytest.fixture(autouse=True)
def as_typed(request: pytest.FixtureRequest) -> Iterator[None]:
    """Messages of readers are tested in the words of the command line; `test_errors` tests those of Python."""
    with speaking(as_options) if request.path.parent.name in ("io", "layouts") else contextlib.nullcontext():
        yield


@pytest.fixture
def saved(tmp_path: Path) -> Callable[..., Path]:
    """Saves a text under a name, and returns its path."""

    def save(text: str, name: str = "log.csv") -> Path:
        path = tmp_path / name
        path.write_text(text)
        return path

    return save


@pytest.fixture(scope="session")
def field_data() -> Path:
    """Folder of records by other parties, which are not distributed with the package."""
    folder = Path(os.environ.get("SIGMATAU_FIELD_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no field data: {folder} is absent; SIGMATAU_FIELD_DATA names another folder")
    return folder


@pytest.fixture(scope="session")
def browser():
    """Debian's chromium-headless-shell, which `make test` installs, or a whole browser, which takes twice the CPU time."""
    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    program = next(filter(None, map(shutil.which, names)), None)
    if program is None:
        assert not os.environ.get("CI"), "chromium is not installed, and CI must not skip the tests of the page"
        pytest.skip("no chromium: apt-get install chromium-headless-shell")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield made
        made.close()


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    """URL of an empty PostgreSQL for the tests; `make test` installs it."""
    from lab.store.postgresql import programs, server

    if programs() is None:
        assert not os.environ.get("CI"), (
            "PostgreSQL is not installed, and CI must not skip the tests of the store on it"
        )
        pytest.skip("no PostgreSQL: apt-get install postgresql")
    with server() as url:
        yield url


@pytest.fixture(params=["sqlite", "postgres"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty database, a file or a URL."""
    if request.param == "sqlite":
        return str(tmp_path / "results.db")
    import sqlalchemy

    url = request.getfixturevalue("postgres")
    name = f"t{uuid.uuid4().hex[:12]}"
    admin = url.replace("postgresql://", "postgresql+psycopg://") + "postgres"
    engine = sqlalchemy.create_engine(admin, isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.exec_driver_sql(f"CREATE DATABASE {name}")
    engine.dispose()
    return f"{url}{name}"
