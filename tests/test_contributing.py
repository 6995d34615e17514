"""CONTRIBUTING.md is complete: a check, a format and a target are added to a copy of the package by the files that it names.

The tests of the copy then cover what was added. No other file of the package or of the tests is touched.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

from conftest import ROOT

TARGET = '''"""Acme: lines of its settings."""

from sigmatau.exporting.template import template

TARGET = template(
    "acme",
    program="Acme",
    summary="Acme settings: N and K, continuous, one number for three axes",
    text="""\\
# Continuous-time densities.
{omitted}
acme:
  acc_noise: {accel N}
  gyr_noise: {gyro N}
  acc_walk: {accel K}
  gyr_walk: {gyro K}
""",
)
'''

CHECK = '''"""Samples of one sign."""

from sigmatau.findings.finding import Finding
from sigmatau.findings.values import OneSign
from sigmatau.record.streams import Stream


def one_sign(stream: Stream) -> list[Finding]:
    """A finding for each channel all of whose samples are negative."""
    largest = {channel: float(stream.column(channel).max()) for channel in stream.channels}
    return [
        Finding(details=OneSign(largest=value), severity="warning", channels=(channel,))
        for channel, value in largest.items()
        if value < 0
    ]
'''

KIND = '''

@frozen
class OneSign(Details, code="one_sign"):
    """All samples are negative.

    Attributes
    ----------
    largest : float
        Largest sample. [rate_unit]
    """

    largest: float

    def words(self, finding: Finding) -> Words:
        return Words(f"all samples are negative, up to {self.largest:.3g}", "Check the sign of the scale")
'''

FORMAT = '''"""Acme logs: a mark, then rows of time, rates and accelerations."""

from pathlib import Path

import numpy as np

from sigmatau.io.read.table import Column, Head, Loaded, Table

_COLUMNS = ("time [s]", *(f"gyro_{axis} [rad/s]" for axis in "xyz"), *(f"accel_{axis} [m/s^2]" for axis in "xyz"))


def sniff(head: bytes, path: Path) -> bool:
    """Whether the file begins with the mark."""
    return head.startswith(b"ACME")


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The table of a log."""
    rows = np.loadtxt(path, skiprows=1)
    columns = tuple(Column(name=name) for name in _COLUMNS)
    return (
        Table(
            format="acme", columns=columns, notes=(), load=lambda wanted, _: Loaded(columns={k: rows[:, k] for k in wanted})
        ),
    )
'''

WRITER = """

def _acme(folder: Path, stamps: Stamps, values: Values) -> Path:
    path = folder / "log.acme"
    seconds = np.asarray(stamps, dtype=float)[:, None]
    np.savetxt(path, np.hstack([seconds * (1e-9 if seconds[-1] > 1e6 else 1.0), values]), header="ACME", comments="")
    return path


KINDS["Acme"] = Kind(_acme)
"""

# by section of CONTRIBUTING.md: new files, and files in which text is inserted (a pattern, and what follows its match)
ADDED = {
    "Add a check": (
        {"quality/samples/one_sign.py": CHECK},
        {
            "findings/values.py": (r"\Z", KIND),
            "quality/samples/check.py": (
                r"(?m)^    findings = \[\n",
                "        *one_sign(stream),\n",
                r"(?m)^from sigmatau.quality.samples.repeated_samples",
                "from sigmatau.quality.samples.one_sign import one_sign\n",
            ),
            "tests/findings/examples_values.py": (
                r"\Z",
                "from sigmatau.findings.values import OneSign\n\n"
                'EXAMPLES.append(Finding(details=OneSign(largest=-1.0), severity="warning"))\n',
            ),
            "docs/findings.md": (r"\Z", "\n| `one_sign` | warning | all samples are negative |\n"),
        },
    ),
    "Add a format": (
        {"io/read/formats/acme.py": FORMAT},
        {
            "io/read/registry.py": (
                r"(?m)^_FORMATS = \(\n",
                '    _Format("acme", "an Acme log", _begins(b"ACME"), binary=False),\n',
            ),
            "io/read/table.py": (r'(?m)^FORMATS = \(\n    "', "Acme, "),
            "benches/logs.py": (r"\Z", WRITER),
        },
    ),
    "Add an export target": (
        {"exporting/targets/acme.py": TARGET},
        {
            "tests/exporting/test_vio_propagation.py": (
                r"(?m)^TARGETS = \{\n",
                '    "acme": (okvis2, False, True),\n',
            ),
        },
    ),
}
NAMED_AS = {
    "quality/samples/one_sign.py": "quality/samples/",
    "findings/values.py": "findings/SUBJECT.py",
    "tests/findings/examples_values.py": "tests/findings/examples_SUBJECT.py",
    "io/read/formats/acme.py": "io/read/formats/NAME.py",
    "exporting/targets/acme.py": "exporting/targets/NAME.py",
}
PAGE = "docs/how-to/acme.md"


def place(folder, name):
    return folder / name if name.startswith(("tests", "docs", "benches")) else folder / "python" / "sigmatau" / name


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory):
    """A copy of the repository with all three additions."""
    folder = tmp_path_factory.mktemp("sandbox")
    without = shutil.ignore_patterns("__pycache__", "frozen", "target")
    for name in ("python", "tests", "benches", "docs/how-to"):
        shutil.copytree(ROOT / name, folder / name, ignore=without)
    for name in ("README.md", "CONTRIBUTING.md", "pyproject.toml", "Cargo.toml", "docs/findings.md"):
        shutil.copy(ROOT / name, folder / name)
    for files, insertions in ADDED.values():
        for name, text in files.items():
            assert not place(folder, name).exists()
            place(folder, name).write_text(text, encoding="utf-8")
        for name, edits in insertions.items():
            text = place(folder, name).read_text(encoding="utf-8")
            for pattern, insertion in zip(edits[::2], edits[1::2], strict=True):
                begin = next(re.finditer(pattern, text))
                at = begin.start() if pattern.startswith("(?m)^from") else begin.end()
                text = text[:at] + insertion + text[at:]
            place(folder, name).write_text(text, encoding="utf-8")
    page = (folder / "docs" / "how-to" / "lio-sam.md").read_text(encoding="utf-8")
    (folder / PAGE).write_text(page.replace("lio-sam", "acme"), encoding="utf-8")
    run(folder, "tests/docs/pages.py", "--write", PAGE)
    return folder


QUIET = ("-q", "-n", "0", "-p", "no:cacheprovider", "--no-header")


def run(folder, *words, **environment):
    paths = os.pathsep.join(map(str, (folder / "python", folder, folder / "tests")))
    made = subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False,
        env=os.environ | environment | {"PYTHONPATH": paths},
    )  # fmt: skip
    assert made.returncode == 0, made.stdout[-3000:] + made.stderr[-3000:]
    return made.stdout


@pytest.mark.parametrize("section", ADDED)
def test_contributing_names_the_files(section):
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition(f"## {section}\n")[2].partition("\n## ")[0]
    for name in (*ADDED[section][0], *ADDED[section][1]):
        assert f"`{NAMED_AS.get(name, name)}`" in text, name


def test_the_tests_cover_what_was_added(sandbox):
    """The page, the propagation and the file of the target; the words of the finding; the detection of the format."""
    files = ("exporting/test_how_to", "exporting/test_vio_propagation", "findings/test_words", "analysis/test_schema",
             "io/test_registry")  # fmt: skip
    out = run(sandbox, "-m", "pytest", *QUIET, *(f"tests/{file}.py" for file in files), "-k",
              "acme or Acme or tables or every_kind or propagated or golden or schema", UPDATE_WORDS="1")  # fmt: skip
    assert out.count(".") > 30


def test_what_was_added_works(sandbox):
    """The check finds, the format is read, and the target is listed."""
    program = (
        "import numpy as np, sigmatau as st\n"
        "from sigmatau.exporting.targets import NAMES\n"
        "rows = [f'{k / 100} -1 0 0 0 0 {9.8 + k % 7 / 100}' for k in range(2000)]\n"
        "open('log.acme', 'w').write('\\n'.join(['ACME', *rows]))\n"
        "noise = np.random.default_rng(1).standard_normal(2000)\n"
        "record = st.Record.from_arrays(rate=100, gyro_x=1e-3 * noise - 1)\n"
        "print(st.read('log.acme').provenance.format, 'one_sign' in [f.code for f in st.check(record)], 'acme' in NAMES)\n"
    )
    assert run(sandbox, "-c", program).split() == ["acme", "True", "True"]
