"""CONTRIBUTING.md is complete: a check, a format, a target and a term are added to copies of the package by the files that
it names.

The tests of the copy then cover what was added. No other file of the package or of the tests is touched. The crate is not
built anew: of a term it has the name alone, and the copy has a Python form of its Allan variance.
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

TERM = """        Term(
            name="acme_walk",
            symbols=("A", "A"),
            slope=0.5,
            read_at=1.0,
            level=1.0,
            labels={"signal": "acme walk"},
            short_name="acme",
            times="/sqrt(s)",
            si_units={"angular_rate": "rad/s/sqrt(s)", "acceleration": "m/s^2/sqrt(s)"},
            usual_units={"angular_rate": ("deg/h/sqrt(h)",), "acceleration": ("m/s/h^(3/2)",)},
            synonyms="acme noise",
        ),
"""
PHASE = """    if term == "acme_walk":
        return value**2 * tau0**3 / 4 * (lags**3 - lags)
"""
# In place of the compiled forms.
KERNELS = """    if term == "acme_walk":
        return coefficient**2 * tau0 * (np.asarray(m) + 0.5 / np.asarray(m))
"""
DENSITY = """    if term == "acme_walk":
        return 3 * (coefficient / (2 * np.pi * f)) ** 2
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
    "Add a noise term": (
        {},
        {
            "crates/core/src/terms.rs": (
                r'(?m)^ +Self::RateRandomWalk => "rate_random_walk",\n',
                '            Self::AcmeWalk => "acme_walk",\n',
            ),
            "noise/terms.py": (r'(?m)^(?= {8}Term\(\n {12}name="rate_ramp")', TERM),
            "model/covariance.py": (r'(?m)^(?= +if term == "rate_ramp":\n)', PHASE),
            "fitting/read_off_regions.py": (r"(?m)^RULES: .*\n", '    "acme_walk": Rule(),\n'),
            "fitting/rounding.py": (r"(?m)^    errors = \{\n", '        "acme_walk": error / math.sqrt(duration),\n'),
            "fitting/read_off.py": (
                r"(?m)^    rate_random_walk: Span.*\n",
                "    acme_walk: Span | None = None,\n",
                r"rate_random_walk, (?=rate_ramp : tuple)",
                "acme_walk, ",
                r"(?m)^        rate_random_walk=rate_random_walk,\n",
                "        acme_walk=acme_walk,\n",
            ),
            "quality/sensor_class.py": (
                r"(?m)^        noisiest=\{\n",
                '            "acme_walk": 1.0,\n',
                r"        noisiest=\{(?=.)",
                '"acme_walk": 1.0, ',
            ),
            "exporting/targets/ieee952.py": (
                r'(?m)^    "angular_rate": \{\n',
                '        "acme_walk": (("rad/s/√s", 1.0),),\n',
                r'(?m)^    "acceleration": \{\n',
                '        "acme_walk": (("m/s²/√s", 1.0),),\n',
            ),
            "analysis/forms.py": (
                r"(?m)^    rate_random_walk: TermForm.*\n",
                "    acme_walk: TermForm | None = key(default=None)\n",
            ),
            "cli/plan.py": (r"rate_random_walk (?=or rate_ramp)", "or acme_walk "),
            "cli/store.py": (r"rate_random_walk, (?=rate_ramp, or mean)", "acme_walk, "),
            "cli/deviation.py": (r"or rate_random_walk", " or acme_walk"),
            "docs/glossary.md": (r"\Z", "\n| also called | acme noise |\n"),
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
    return (
        folder / name
        if name.startswith(("tests", "docs", "benches", "crates"))
        else folder / "python" / "sigmatau" / name
    )


def copy_with(folder, *sections):
    """A copy of the repository with the additions of some sections."""
    without = shutil.ignore_patterns("frozen", "target")  # with what is compiled, which is as new as its source
    for name in ("python", "tests", "benches", "docs/how-to"):
        shutil.copytree(ROOT / name, folder / name, ignore=without)
    (folder / "crates" / "core" / "src").mkdir(parents=True)
    files = ("README.md", "CONTRIBUTING.md", "pyproject.toml", "Cargo.toml", "docs/findings.md", "docs/glossary.md")
    for name in (*files, "crates/core/src/terms.rs"):
        shutil.copy(ROOT / name, folder / name)
    for section in sections:
        files, insertions = ADDED[section]
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


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory):
    """A copy with a check, a format and a target."""
    folder = tmp_path_factory.mktemp("sandbox")
    copy_with(folder, "Add a check", "Add a format", "Add an export target")
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


@pytest.fixture(scope="module")
def with_term(tmp_path_factory):
    """A copy with a noise term, whose compiled forms are in Python."""
    folder = tmp_path_factory.mktemp("with term")
    copy_with(folder, "Add a noise term")
    kernels = folder / "python" / "sigmatau" / "_native" / "kernels.py"
    text = kernels.read_text(encoding="utf-8")
    for name, form in (("avar", KERNELS), ("psd", DENSITY)):
        head, call, tail = text.partition(f"    return _core.term_{name}(")
        text = head + form + call + tail
    kernels.write_text(text, encoding="utf-8")
    return folder


def test_no_list_lacks_the_term(with_term):
    """The lists of the package and of the crate, the glossary, and the schema of a result."""
    files = ("noise/test_one_table", "noise/test_synonyms", "analysis/test_schema")
    out = run(with_term, "-m", "pytest", *QUIET, *(f"tests/{file}.py" for file in files), "-k", "not every_example",
              UPDATE_WORDS="1")  # fmt: skip
    assert out.count(".") > 8


def test_a_model_has_the_term(with_term):
    """A model file states it, and the sum of its parts has it; linear systems refuse it."""
    program = """
import numpy as np, sigmatau as st
from sigmatau.navigation.reference_filter import TrueNoise
open("imu.toml", "w").write('[channels.gyro_x]\\nrandom_walk = "0.1 deg/sqrt(h)"\\nacme_walk = "3 deg/h/sqrt(h)"\\n')
model = st.NoiseModel.read("imu.toml")
gyro = model["gyro_x"]
m, tau0 = np.array([1, 8, 64]), 0.01
s = lambda l: gyro.phase_autocovariance(l, tau0=tau0)
np.testing.assert_allclose((6 * s(0 * m) - 8 * s(m) + 2 * s(2 * m)) / (2 * (m * tau0) ** 2), gyro.avar(m=m, tau0=tau0))
assert gyro.psd([1e-3])[0] > gyro["random_walk"] ** 2
assert "acme_walk" in model.to_toml() and "acme walk" in st.export(model, to="ieee952")
matrices = lambda _, dt: st.export(model, to="state-space", choices=st.Choices(step=dt))
for refused in (st.state_space, st.arma, matrices, lambda noise, dt: TrueNoise(terms=noise.terms)):
    try:
        refused(gyro, dt=tau0)
    except st.DataError as error:
        print(str(error).count("acme_walk"))
"""
    assert run(with_term, "-c", program).split() == ["1"] * 4


def test_no_target_leaves_the_term_out_without_a_word(with_term):
    """Its file has the term or says that it has no field for it, or it refuses the model."""
    program = """
import sigmatau as st
from sigmatau.exporting.targets import NAMES, target
terms = {"random_walk": 1e-4, "bias_instability": 1e-5, "acme_walk": 1e-6}
model = st.NoiseModel(channels={f"{sensor}_{axis}": terms for sensor in ("gyro", "accel") for axis in "xyz"})
for name in NAMES:
    rated = target(name).needs_rate or target(name).may_need_rate or target(name).needs_step
    choices = st.Choices(filter_rate=100.0, horizon=10.0) if name in ("gazebo", "gnss-ins-sim", "matlab") else None
    try:
        text = st.export(model, to=name, choices=choices or (st.Choices(filter_rate=100.0) if rated else None))
    except st.DataError as error:
        text = str(error)
    if "acme" not in text:
        print(name)
"""
    assert run(with_term, "-c", program) == ""
