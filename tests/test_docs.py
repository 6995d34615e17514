"""What the pages say beside their code, which tests/docs runs: links, lists, numbers."""

import re

import numpy as np

from conftest import ROOT
from sigmatau import NoiseModel, analyze, read

README, GUIDE, MODEL = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/guide.md", "docs/model.md")
)


def test_readme_is_short():
    assert len(README.splitlines()) <= 150


def test_functions_of_the_model_page_exist():
    import sigmatau
    from sigmatau.spectrum.result import Spectrum

    rows = [row.split("|")[2] for row in MODEL.splitlines() if row.startswith("| ")][1:]
    named = {name for row in rows for name in re.findall(r"`([\w.]+)`", row)}
    assert {"psd", "cross_spectrum", "transfer", "simulate_to", "state_space", "arma", "predict", "verify"} < named
    for name in named - {"Spectrum.over"}:
        found = sigmatau
        for part in name.split("."):
            found = getattr(found, part)
        assert callable(found), name
    assert callable(Spectrum.over)


def test_the_index_of_theory_leads_to_every_page():
    theory = ROOT / "docs" / "theory"
    index = (theory / "README.md").read_text(encoding="utf-8")
    for page in {*theory.glob("*.md")} - {theory / "README.md"}:
        assert f"({page.name})" in index, page.name
    assert "(docs/theory/README.md)" in README
    assert "(docs/glossary.md)" in README


def test_model():
    import tomllib

    (text,) = re.findall(r"^```toml\n(.*?)^```", GUIDE, flags=re.DOTALL | re.MULTILINE)
    assert set(NoiseModel.from_dict(tomllib.loads(text)).channels) == {"gyro_y", "accel_x"}


def test_links():
    for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]:
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if not target.startswith("https://"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_study_page_is_of_the_packages_rules():
    """docs/study/read-off.md marks the rules that are in force; a changed rule asks for ``make study``."""
    from sigmatau.fitting.read_off_regions import RULES

    page = (ROOT / "docs" / "study" / "read-off.md").read_text(encoding="utf-8")
    marked = re.findall(r"^\| (\w+) \| (\w+) \| \*\*([\d.]+)\*\* \| ([\d.]+) ", page, flags=re.MULTILINE)
    numbers = ("tolerance", "slope_error", "rest", "gain", "scatter")
    assert {(m[0], m[1]): float(m[2]) for m in marked} == {
        (term, number): getattr(rule, number) for term, rule in RULES.items() for number in numbers
    }
    assert all(float(m[3]) <= 5 for m in marked)


def test_record_prints_itself(tmp_path):
    y = np.random.default_rng(1).standard_normal((1000, 2))
    columns = np.column_stack([np.arange(1000) / 100, y])
    header = "time [s],gyro_x [deg/s],accel_x [g]"
    np.savetxt(tmp_path / "static.csv", columns, delimiter=",", header=header, comments="", fmt="%.9g")
    record = read(tmp_path / "static.csv")
    assert repr(record).startswith("Record of 2 streams\n  gyro: gyro_x [rad/s], 1000 samples at 100 Hz")
    head, gyro, *_ = repr(analyze(record, method="read-off")).split("\n\n")
    assert head == "static.csv: 2 axes at 100 Hz (time stamps), 10 s, at rest"
    assert gyro.startswith("gyro: 1 channel, 1000 samples at 100 Hz (time stamps in column 'time [s]'), 10 s")


def test_one_version():
    import tomllib

    from sigmatau import __version__

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    crates = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    assert project == crates == __version__


def test_every_finding_is_explained():
    """docs/findings.md has one row for each code of `sigmatau.findings`, and no other."""
    from sigmatau.findings import details_by_code

    page = (ROOT / "docs" / "findings.md").read_text(encoding="utf-8").partition("## Time stamps")[2]
    rows = re.findall(r"^\| `([a-z_]+)` \|", page, flags=re.MULTILINE)
    assert len(rows) == len(set(rows))
    lacking, extra = {*details_by_code()} - set(rows), set(rows) - {*details_by_code()}
    assert not lacking | extra, f"docs/findings.md: add rows for {sorted(lacking)}, remove those of {sorted(extra)}"
