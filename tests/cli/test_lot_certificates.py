"""`sigmatau lot --certificate`: a signed page for each unit of a lot, its serial number, and who gets none."""

import re
from pathlib import Path

import numpy as np
import pytest

from lot_logs import SPEC, rates, write_log
from reporting.pdf_text import pages_of
from sigmatau.cli import batch, main
from sigmatau.reporting import pdf

PAGE = Path(__file__).parents[2] / "docs/how-to/certificate.md"
EXAMPLE = re.search(r"<!-- save: lab.toml -->\n```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
UNITS, MOVED = 4, 3


@pytest.fixture(scope="module")
def shift(tmp_path_factory):
    """Logs of four units with days in their names; the third one moved."""
    folder = tmp_path_factory.mktemp("certificates") / "shift"
    folder.mkdir()
    for unit in range(1, UNITS + 1):
        x = rates(unit + 30, duration=200)
        if unit == MOVED:
            x[:, :3] += 0.5 * np.sin(np.arange(len(x))[:, None] / 30)
        write_log(folder / f"SN{unit}_2026-05-0{unit}.csv", x)
    return folder


@pytest.fixture
def lab(tmp_path, shift, monkeypatch):
    """Writes the facts for all units, beside logo and specification; logs are analysed in this process."""

    def run(logs, work, *, jobs, keep=None):
        for log in logs:
            yield batch._outcome(log, work, keep)

    def document(content):
        return pdf.typeset(pdf._template(), pdf._values(content), format="pdf", pretty=True)  # with text to read

    monkeypatch.setattr(batch, "run", run)
    monkeypatch.setattr(pdf, "document", document)
    monkeypatch.chdir(tmp_path)
    Path("shift").symlink_to(shift)
    Path("logo.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"/>')
    Path("spec.toml").write_text(SPEC)

    def write(*removed, each=("serial", "date", "received", "issued")):
        text = EXAMPLE
        for key in (*each, *removed):
            text = re.sub(rf"^{key} = .*\n", "", text, flags=re.MULTILINE)
        Path("lab.toml").write_text(text, encoding="utf-8")

    return write


WORDS = ("lot", "shift", "--unit-from", "(SN[0-9])", "--certificate", "lab.toml", "--reports", "pages")


def squeezed(path):
    return [re.sub(r"[\s\u200b]", "", text) for text in pages_of(path.read_bytes())]


def test_each_unit_has_its_certificate(lab, capsys):
    pytest.importorskip("typst", reason="a PDF needs typst")
    lab()
    Path("pages").mkdir()
    Path("pages/SN3.pdf").write_bytes(b"%PDF-1.7\n/Creator (sigmatau 0.1.0)")  # of an earlier run
    assert main([*WORDS, "--spec", "spec.toml", "-o", "lot.html"]) == 4
    assert sorted(page.name for page in Path("pages").iterdir()) == ["SN1.pdf", "SN2.pdf", "SN4.pdf"]
    for unit in (1, 2, 4):
        pages = squeezed(Path(f"pages/SN{unit}.pdf"))
        assert f"SerialnumberSN{unit}" in pages[0]
        assert f"Measured2026-05-0{unit}(bythenameofthelog)" in pages[0]
        assert "Statementofconformity" in pages[0]
        assert all(f"2026-0042-SN{unit}" in page for page in pages)
        assert f'href="pages/SN{unit}.pdf"' in Path("lot.html").read_text()
    assert "pages/SN3.pdf" not in Path("lot.html").read_text()
    errors = capsys.readouterr().err
    assert "no certificate: SN3: the sensor was not at rest, so the result has no coefficients" in errors
    judged = re.search(r"certificates of units that are not judged: (.*)\. Read their reasons before you sign", errors)
    assert judged is None or "SN3" not in judged[1]


def test_a_file_that_fits_no_log_ends_the_lot(lab, capsys):
    lab("temperature")
    assert main([*WORDS, "-o", "lot.html"]) == 1
    assert "lab.toml: lacks measurement.temperature, and the log has no thermometer" in capsys.readouterr().err
    assert not Path("lot.html").exists()
    assert not [*Path("pages").iterdir()]


@pytest.mark.parametrize(
    ("words", "each", "reason", "code"),
    [
        (WORDS[:6], ("serial", "date"), "--certificate needs --reports FOLDER", 2),
        ((*WORDS[:2], *WORDS[4:]), ("serial", "date"), "--certificate needs --unit-from", 2),
        (WORDS, ("date",), "instrument.serial of a lot is the name of each unit; leave it out", 1),
        ((*WORDS, "--spec", "icm42688p"), ("serial",), "--spec is not decision.specification of lab.toml", 2),
        (("lot", "--store", "x.db", *WORDS[4:6]), ("serial",), "--certificate needs logs", 2),
    ],
)
def test_options(words, each, reason, code, lab, capsys):
    lab(each=each)
    assert main([*words]) == code
    assert reason in capsys.readouterr().err


def test_inputs_are_protected(lab, capsys):
    lab()
    Path("units.csv").write_text("SN1\n")
    assert main(["lot", "shift", "--expect", "units.csv", "-o", "units.csv"]) == 2
    assert "--output units.csv is the file that is read" in capsys.readouterr().err
    assert Path("units.csv").read_text() == "SN1\n"


@pytest.mark.parametrize(
    "words",
    [
        ("--results", "r", "-o", "r/SN1.json"),
        ("--results", "r", "-o", "r/../r/SN2.json"),
        ("--reports", "r", "-o", "r/SN1.html"),
    ],
)
def test_no_output_replaces_a_file_of_a_unit(words, lab, capsys):
    Path("r").mkdir()
    Path("r/SN1.json").write_text('{"schema": 1, "sigmatau": "0.1.0"}')
    assert main(["lot", "shift", "--unit-from", "(SN[0-9])", *words]) == 2
    assert "is also a file of a unit; name another file" in capsys.readouterr().err
    assert Path("r/SN1.json").exists()


def test_a_unit_is_not_a_path(lab, shift, capsys):
    assert main(["lot", "shift", "--unit-from", "(.*)", "--results", "r"]) == 2
    assert "a unit is a name without /" in capsys.readouterr().err
    assert not [*shift.glob("*.json")]


def test_a_result_has_no_certificate(lab, capsys):
    lab()
    Path("SN9.json").write_text("{}")
    assert main(["lot", "SN9.json", *WORDS[2:]]) == 1
    assert "SN9.json: is a result. A certificate needs the log" in capsys.readouterr().err
