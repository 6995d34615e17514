"""Stores that cannot be written, in part or at all."""

import os
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import pytest
from store_results import entry_of, result

from sigmatau.errors import DataError
from sigmatau.lab.store.store import Store

NOBODY = 65534


@pytest.fixture
def shared():
    with tempfile.TemporaryDirectory(prefix="store-") as name:
        yield Path(name)


@pytest.mark.parametrize("writable", ["folder", "nothing"])
def test_store_that_may_only_be_read(shared, writable):
    place = shared / "lab 100% #1.db"
    with Store(place) as store:
        store.add([entry_of(result(0), unit="A")])
    place.chmod(0o444)
    shared.chmod(0o777 if writable == "folder" else 0o555)
    as_root = os.geteuid() == 0
    if as_root:
        os.seteuid(NOBODY)
    try:
        with Store(place) as store:
            assert len(store.runs()) == 1
            with pytest.raises(DataError, match="readonly"):
                store.add([entry_of(result(1), unit="A")])
        if writable == "nothing":
            with pytest.raises(DataError, match="unable to open"):
                Store(shared / "new.db")
    finally:
        if as_root:
            os.seteuid(0)
        shared.chmod(0o777)


FULL = textwrap.dedent(
    """
    import resource, signal, sys
    from sigmatau.errors import DataError
    from sigmatau.lab.store.store import Store
    from store_results import entry_of, result

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    with Store(sys.argv[1]) as store:
        resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))
        done = 0
        try:
            for k in range(2000):
                store.add([entry_of(result(k, log=str(k)), unit="A")])
                done += 1
        except DataError as error:
            print(done, error)
    """
)


def test_full_disk(tmp_path):
    """What was committed before the disk is full stays, and the store goes on when there is room."""
    place = tmp_path / "x.db"
    ran = subprocess.run(
        [sys.executable, "-c", FULL, str(place)],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    assert ran.stderr == ""
    done, _, told = ran.stdout.partition(" ")
    assert told.startswith("the results cannot be added to the store: ")
    assert "\n" not in told.strip()
    with Store(place) as store:
        assert len(store.runs()) == int(done) > 0
        assert len(store.coefficients(term="random_walk")) == 3 * int(done)
        store.add([entry_of(result(1, log="later"), unit="A")])


@pytest.mark.skipif(sys.platform == "win32", reason="a file that is open cannot be removed")
@pytest.mark.parametrize("replaced", [False, True])
def test_store_that_is_removed_meanwhile(tmp_path, replaced):
    place = tmp_path / "lab.db"
    with Store(place) as store:
        store.add([entry_of(result(0), unit="A")])
        for file in tmp_path.iterdir():
            file.rename(tmp_path / f"old {file.name}")
        if replaced:
            Store(place).close()
        with pytest.raises(DataError, match="was removed or replaced"):
            store.add([entry_of(result(1), unit="A")])
    assert place.exists() == replaced
