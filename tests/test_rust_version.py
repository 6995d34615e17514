"""The code compiles with the Rust of Debian 12, which is older than that of CI."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
OLDEST = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["rust-version"]
_LET = re.compile(r"\b(?:if|while)\s+let\b|&&\s*let\b")


def chains(code):
    """Lines of `if let … && …`, which are an error before Rust 1.88."""
    code = re.sub(r"//.*", "", code)
    found = []
    for match in _LET.finditer(code):
        depth = 0
        for at in range(match.start(), len(code)):
            depth += (code[at] in "([") - (code[at] in ")]")
            if depth < 0 or (depth == 0 and code[at] in "{;"):
                break
            if depth == 0 and code.startswith("&&", at):
                found.append(match.group())
                break
    return found


def test_scripts_and_manifest_ask_for_the_same_rust():
    common = (ROOT / "scripts" / "common.sh").read_text()
    assert re.findall(r"^RUST_MIN=(\d+)", common, re.MULTILINE) == [OLDEST.partition(".")[2]]


def test_chains_are_found():
    assert chains("if let Some(a) = b\n    && let Ok(c) = d(a)\n{")
    assert chains("while let Some(a) = b.next() && a > 3 {")
    assert not chains("if let Some(a) = b.filter(|x| x.y && x.z) {\n    if c && d {")


@pytest.mark.skipif(tuple(map(int, OLDEST.split("."))) >= (1, 88), reason="this Rust has them")
def test_no_chains_of_let():
    files = sorted((ROOT / "crates").rglob("*.rs"))
    assert len(files) > 20
    bad = [file.name for file in files if chains(file.read_text())]
    assert not bad
