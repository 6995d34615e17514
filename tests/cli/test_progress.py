"""Progress of reading: the bytes that the compiled readers have taken, and the bar that follows them."""

import contextlib
import gzip
import sys
import time

import pytest

from sigmatau import read
from sigmatau._native import formats
from sigmatau.cli import reading

TEXT = "time [s],gyro_x [rad/s]\n" + "".join(f"{k / 100:.2f},{k % 7}\n" for k in range(50_000))


@pytest.mark.parametrize("name", ["log.csv", "log.csv.gz"])
def test_every_byte_of_the_file_is_counted(tmp_path, name):
    log = tmp_path / name
    log.write_bytes(gzip.compress(TEXT.encode()) if name.endswith("gz") else TEXT.encode())
    before = formats.bytes_read()
    read(log)
    taken = formats.bytes_read() - before
    # The head is looked at as well.
    assert log.stat().st_size <= taken + (1 << 18)
    assert taken >= log.stat().st_size - 2


def test_the_bar_follows_the_reader_and_begins_anew_with_a_second_pass(tmp_path, monkeypatch):
    log = tmp_path / "log"
    log.write_bytes(bytes(reading._MIN_PROGRESS + 1))
    size = log.stat().st_size
    counts = iter([1000, 1000 + size // 4, 1000 + size // 2, 1000 + size + size // 4])
    last = [1000]

    def counted():
        last[0] = next(counts, last[0])
        return last[0]

    shown = []

    @contextlib.contextmanager
    def working(what, *, quiet):
        yield shown.append

    monkeypatch.setattr(formats, "bytes_read", counted)
    monkeypatch.setattr(reading, "working", working)
    monkeypatch.setattr(reading, "_PROGRESS_INTERVAL", 0.001)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with reading.reading_shown(log):
        end = time.monotonic() + 60
        while len(shown) < 3 and time.monotonic() < end:
            time.sleep(0.001)
    assert shown[:3] == pytest.approx([0.25, 0.5, 0.25], abs=1e-6)


def test_nothing_is_followed_where_nobody_looks(tmp_path, monkeypatch):
    log = tmp_path / "log"
    log.write_bytes(bytes(reading._MIN_PROGRESS + 1))
    monkeypatch.setattr(reading.threading, "Thread", None)  # would be an error to start
    with reading.reading_shown(log, quiet=True):
        pass
