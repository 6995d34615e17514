"""Test of the test suite by seeded bugs. ``python -m studies.mutations`` writes docs/study/mutations.md.

Each bug of mutations.toml is put into a copy of the tree, and tests run until one fails: first those named for the bug,
then those of its room and of the interfaces. A bug is found by a test that fails with it and passes without it. Results
are stored in .study/mutations.json, so that a stopped study can continue; a result is repeated if the bug or its tests
are edited. The exit code is 1 if a bug is not found.

    python -m studies.mutations                   # all bugs without a result
    python -m studies.mutations --check           # only check that every bug fits its file
    python -m studies.mutations gap-start         # repeat these bugs
"""

from __future__ import annotations

import datetime as dt
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / ".study" / "mutations.json"
PAGE = ROOT / "docs" / "study" / "mutations.md"
TARGET = ROOT / ".study" / "mutation-target"  # target folder of cargo, shared by the bugs in Rust

_COPIED = ("python", "tests", "docs", "benches", "studies", "crates", "scripts", "requirements")
_NOTHING_RUN = 5  # exit code of pytest


class Mutation(NamedTuple):
    """One seeded bug: replace `old`, which occurs once in `file`, by `new`; `tests` are tried first."""

    name: str
    bug: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    @property
    def room(self) -> str:
        """Folder of the package, or crate."""
        parts = self.file.split("/")
        return f"crates/{parts[1]}" if parts[0] == "crates" else parts[2].removesuffix(".py")

    @property
    def neighbours(self) -> tuple[str, ...]:
        """Tests that are tried if the named tests do not find the bug."""
        room = {"crates/formats": "io", "crates/core": "estimators"}.get(self.room, self.room)
        folders = dict.fromkeys((room, "quality", "cli"))
        paths = [f"tests/{name}" for name in folders if (ROOT / "tests" / name).is_dir()]
        return (*paths, *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").glob("test_*.py"))))


def mutations() -> list[Mutation]:
    """Read mutations.toml. Raises ValueError unless each bug fits exactly one place of its file."""
    table = tomllib.loads((ROOT / "studies" / "mutations.toml").read_text(encoding="utf-8"))
    every, wrong = [], []
    for name, row in table.items():
        mutation = Mutation(
            name, row["bug"], row["file"], row["old"], row["new"], tuple(f"tests/{t}" for t in row["tests"])
        )
        file = ROOT / mutation.file
        occurrences = file.read_text(encoding="utf-8").count(mutation.old) if file.exists() else 0
        missing = [test for test in mutation.tests if not (ROOT / test).exists()]
        if occurrences != 1 or missing:
            wrong.append(
                f"{name}: {mutation.file} has {occurrences} times {mutation.old!r}; tests that are missing: {missing}"
            )
        every.append(mutation)
    if wrong:
        raise ValueError("\n".join(wrong))
    return every


def main(arguments: Sequence[str] = ()) -> int:
    """Test every bug without a result, and write the page; return 1 if a bug is not found."""
    every = mutations()
    if "--check" in arguments:
        return 0
    if unknown := set(arguments) - {mutation.name for mutation in every}:
        raise ValueError(f"no such bug: {', '.join(sorted(unknown))}")
    stored: dict[str, Any] = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    done = {
        mutation.name: stored[mutation.name]
        for mutation in every
        if mutation.name not in arguments
        and stored.get(mutation.name, {}).get("of") == [*list(mutation)[2:5], list(mutation.tests)]
    }
    chosen = [
        mutation for mutation in every if mutation.name not in done and (not arguments or mutation.name in arguments)
    ]
    with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
        copy = Copy(Path(folder) / "copy") if chosen else None
        for mutation in chosen:
            assert copy is not None
            start = time.monotonic()
            test = copy.first_failure(mutation, mutation.tests) or copy.first_failure(mutation, mutation.neighbours)
            seconds = round(time.monotonic() - start, 1)
            done[mutation.name] = {"of": [*list(mutation)[2:5], list(mutation.tests)], "test": test, "seconds": seconds}
            RESULTS.parent.mkdir(exist_ok=True)
            RESULTS.write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")
            sys.stderr.write(f"mutations: {len(done)} {mutation.name}: {test or 'not found'} ({seconds:.0f} s)\n")
    if not arguments:
        _write_page([(mutation, done[mutation.name]) for mutation in every])
    missed = [name for name, result in done.items() if result["test"] is None]
    sys.stderr.write(f"mutations: {len(done) - len(missed)} of {len(done)} found\n")
    return 1 if missed else 0


class Copy:
    """A copy of the tree in which bugs are put and tests are run."""

    def __init__(self, root: Path) -> None:
        self.root = root
        root.mkdir()
        unused = shutil.ignore_patterns("__pycache__", "target", "corpus", "artifacts", "coverage", ".*_cache")
        for name in _COPIED:
            shutil.copytree(ROOT / name, root / name, ignore=unused)
        for file in ROOT.iterdir():
            if file.is_file():
                shutil.copy2(file, root / file.name)

    def first_failure(self, mutation: Mutation, tests: Sequence[str]) -> str | None:
        """First test that fails with a bug and passes without it, as ``file::test``; None if there is none."""
        file = self.root / mutation.file
        text = file.read_text(encoding="utf-8")
        red: set[str] = set()  # tests that also fail without the bug
        while True:
            file.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
            try:
                failure = (
                    self._in_rust(mutation, tests, red)
                    if mutation.room.startswith("crates/")
                    else self._failed(tests, red)
                )
            finally:
                file.write_text(text, encoding="utf-8")
            if failure is None or failure.startswith("crates/") or self._failed([failure], ()) is None:
                return failure
            sys.stderr.write(f"mutations: {failure} fails without a bug\n")
            red.add(failure)

    def _failed(self, tests: Sequence[str], but: Sequence[str] | set[str]) -> str | None:
        """First of some tests that fails."""
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            "--tb=no",
            "-r",
            "fE",
            "-x",
            "-n",
            "2",
        ]
        done = self._run([*command, *(f"--deselect={name}" for name in sorted(but)), *tests])
        if done.returncode in (0, _NOTHING_RUN):  # all tests are skipped, because a package is missing
            return None
        failed = re.search(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", done.stdout, re.M)
        if failed is None:
            raise RuntimeError(f"pytest {' '.join(tests)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return failed.group(1).strip()

    def _in_rust(self, mutation: Mutation, tests: Sequence[str], but: set[str]) -> str | None:
        """First failing test of the crate, or of some tests in Python with the rebuilt extension."""
        cargo = ("--release", "--locked", "--quiet", "-p")
        crate = mutation.room.removeprefix("crates/")
        if tests == mutation.tests and not but:
            done = self._run(["cargo", "test", *cargo, f"sigmatau-{crate}", "--lib", "--tests"])
            failed = re.search(r"^test (\S+) \.\.\. FAILED|^---- (\S+) stdout|^    (\w\S+::\w+)$", done.stdout, re.M)
            if done.returncode and failed:
                return f"crates/{crate}::{next(filter(None, failed.groups()))}"
        built = self._run(["cargo", "build", *cargo, "sigmatau-py"])
        if built.returncode:
            raise RuntimeError(f"{mutation.name}: cannot be built\n{built.stderr}")
        extension = next((self.root / "python" / "sigmatau").glob("_core*.so"))
        before = extension.read_bytes()
        library = next(p for p in (TARGET / "release").iterdir() if p.suffix in (".so", ".dylib"))
        try:
            extension.write_bytes(library.read_bytes())
            return self._failed(tests, but)
        finally:
            extension.write_bytes(before)

    def _run(self, command: Sequence[str]) -> subprocess.CompletedProcess[str]:
        environment = {
            **os.environ,
            "PYTHONPATH": str(self.root / "python"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "CARGO_TARGET_DIR": str(TARGET),
            "PYO3_PYTHON": sys.executable,
            "SIGMATAU_FIELD_DATA": os.environ.get("SIGMATAU_FIELD_DATA", str(ROOT.parent / "shared" / "data")),
        }
        nice = ["nice", "-n", "5"] if shutil.which("nice") else []
        return subprocess.run(
            [*nice, *command], cwd=self.root, env=environment, capture_output=True, text=True, check=False
        )


def _write_page(results: Sequence[tuple[Mutation, dict[str, Any]]]) -> None:
    """The table of all bugs."""
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.strip()
    count = sum(result["test"] is not None for _, result in results)
    lines = [_HEAD.format(date=dt.datetime.now(tz=dt.UTC).date(), commit=commit, found=count, count=len(results))]
    for mutation, result in results:
        # The page names a test without its folder and parameters.
        test = f"`{result['test'].removeprefix('tests/').split('[')[0]}`" if result["test"] else "not found"
        lines.append(f"| {mutation.room} | {mutation.bug} | {test} | {result['seconds']:.0f} |")
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


_HEAD = """# Does the test suite find bugs?

Made by `python -m studies.mutations` (studies/mutations.py) on {date}, commit {commit}.

Small, realistic bugs were put into the code, one at a time: a wrong sign, a lost factor 2, an index off by one, a wrong
unit, exchanged arguments, a finding without its channel. They were chosen before it was known which tests find them. The
table names the first test that fails with the bug and passes without it, and the time until it failed, compilation included.
First the tests of the same module run; if none fails, those of the room, `tests/quality`, `tests/cli` and `tests/test_*.py`.

{found} of {count} bugs were found. When they were chosen, 21 were missed by the tests of their module, and tests were added.

| room | bug | found by | time [s] |
|---|---|---|---|"""


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
