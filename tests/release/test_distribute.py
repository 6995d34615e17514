"""The checks of what is released find what they are for. Files themselves are made and checked by ``make wheel``."""

import io
import re
import struct
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from scripts_of import script

from conftest import ROOT

distribute = script("distribute")
NAME = f"{distribute.NAME}-cp311-abi3-manylinux_2_17_x86_64.manylinux2014_x86_64.whl"


def elf(*, symbols=False, glibc="2.17"):
    """A library with nothing but a table of sections."""
    sections = [0, 11, *([2] if symbols else [])]
    table = b"".join(struct.pack("<II56x", 0, kind) for kind in sections)
    head = bytearray(64)
    head[:4] = b"\x7fELF"
    struct.pack_into("<Q", head, 0x28, 64)
    struct.pack_into("<HH", head, 0x3A, 64, len(sections))
    return bytes(head) + table + b"\0GLIBC_2.2.5\0GLIBC_" + glibc.encode() + b"\0"


GOOD = {
    **dict.fromkeys(distribute.NEEDED, b"content"),
    "sigmatau/_core.abi3.so": elf(),
    f"{distribute.NAME}.dist-info/METADATA": b"Name: sigmatau\n\n[a](https://b)\n",
}


def faults(folder, contents, name=NAME):
    with zipfile.ZipFile(folder / name, "w") as archive:
        for member, content in contents.items():
            archive.writestr(member, content)
    return list(distribute.faults_of_wheel(folder / name))


def test_a_good_wheel(tmp_path):
    assert faults(tmp_path, GOOD) == []


WRONG = {
    "a missing file": ({"sigmatau/py.typed": None}, "sigmatau/py.typed is missing"),
    "no man page": ({distribute.NEEDED[9]: None}, "sigmatau.1 is missing"),
    "no licence": (
        {f"{distribute.NAME}.dist-info/licenses/THIRD_PARTY_LICENSES": None},
        "THIRD_PARTY_LICENSES is missing",
    ),
    "a test": ({"tests/test_x.py": b""}, "tests/test_x.py does not belong"),
    "a cache": ({"sigmatau/__pycache__/x.pyc": b""}, "does not belong"),
    "a path": ({"sigmatau/x.py": f"{Path.home()}/x".encode()}, f"contains the path {Path.home()}"),
    "symbols": ({"sigmatau/_core.abi3.so": elf(symbols=True)}, "not stripped"),
    "a new glibc": ({"sigmatau/_core.abi3.so": elf(glibc="2.34")}, "needs glibc 2.34"),
    "two libraries": ({"sigmatau/other.so": elf()}, "one library"),
    "a relative link": ({f"{distribute.NAME}.dist-info/METADATA": b"[a](docs/b.md)"}, "relative links"),
}


@pytest.mark.parametrize("change", WRONG)
def test_a_fault_is_found(change, tmp_path):
    contents, words = WRONG[change]
    found = faults(tmp_path, {name: content for name, content in (GOOD | contents).items() if content is not None})
    assert len(found) == 1
    assert words in found[0]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (f"{distribute.NAME}-cp311-abi3-linux_x86_64.whl", "not a manylinux wheel"),
        (f"{distribute.NAME}-cp311-cp311-win_amd64.whl", "the name is not"),
    ],
)
def test_a_wrong_name(name, words, tmp_path):
    (found,) = faults(tmp_path, GOOD, name)
    assert words in found


def test_a_source_distribution(tmp_path):
    own = [
        name.replace("sigmatau/", "python/sigmatau/", 1) for name in distribute.NEEDED if name.startswith("sigmatau/")
    ]
    needed = [*own, "sigmatau.data/data/share/man/man1/sigmatau.1", distribute.BILL, *distribute.NEEDED_OF_SOURCE]
    path = tmp_path / f"{distribute.NAME}.tar.gz"

    def check(names):
        with tarfile.open(path, "w:gz") as archive:
            for name in names:
                archive.addfile(tarfile.TarInfo(f"{distribute.NAME}/{name}"), io.BytesIO())
        return list(distribute.faults_of_source(path))

    assert check(needed) == []
    assert check(needed[1:]) == [f"{needed[0]} is missing"]
    assert check([*needed, "python/sigmatau/_core.abi3.so"]) == [
        f"{distribute.NAME}/python/sigmatau/_core.abi3.so does not belong into a source distribution"
    ]


def test_what_a_wheel_must_have_is_in_the_tree():
    for name in distribute.NEEDED:
        if name.startswith("sigmatau/"):
            assert (ROOT / "python" / name).is_file(), name
    for name in distribute.NEEDED_OF_SOURCE:
        assert (ROOT / name).is_file(), name


def test_the_package_needs_at_run_time_only_what_it_states():
    """Modules that are imported at the beginning of a module, and are not Python's own, are core dependencies."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    stated = {re.split(r"[>=<\[]", one)[0].replace("-", "_") for one in project["dependencies"]}
    # Modules of these rooms are imported when a store is opened, and when the workbench starts.
    of_rooms = {"store": {"sqlalchemy", "orjson"}, "app": {"starlette", "uvicorn", "anyio"}}
    for path in (ROOT / "python" / "sigmatau").rglob("*.py"):
        for line in path.read_text(encoding="utf-8").splitlines():
            if found := re.match(r"(?:import|from) (\w+)", line):
                name = found[1]
                allowed = stated.union(*(of_rooms.get(part, ()) for part in path.parts))
                assert name in sys.stdlib_module_names or name == "sigmatau" or name in allowed, f"{path}: {line}"
