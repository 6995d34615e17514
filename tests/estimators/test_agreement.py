"""How many printed numbers of other programs are ours: the counts of docs/coming-from/features.md."""

import re

import pytest
from tests.estimators import agreement

import known
from conftest import ROOT
from sigmatau import Record

PAGE = ROOT / "docs" / "coming-from" / "features.md"


def counted(name):
    """Agreeing and compared cells of a row of the page."""
    row = re.search(
        rf"^\| {re.escape(name)} \| .* \| (\d+) of (\d+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    return int(row[1]), int(row[2])


def count(record, cells):
    results = agreement.agreeing(record, cells)
    return sum(results), len(results)


def test_sp_1065():
    assert count(agreement.nbs14_record(), agreement.nbs14()) == counted("NIST SP 1065, table 31")
    nine = Record.from_arrays(rate=1, y=known.NINE_POINTS)
    assert count(nine, agreement.nine_points()) == counted("NIST SP 1065, table 30")


def test_tests_of_allantools():
    """Their expected values for the 1000-point set that are not in table 31."""
    assert count(agreement.nbs14_record(), agreement.sigmatheta()) == counted("SigmaTheta 3.0")
    assert count(agreement.nbs14_record(), agreement.stable32_theo1()) == counted("Stable32 1.60, NBS14")


def test_phase_dat(field_data):
    """All files of Stable32's results for PHASE.DAT."""
    folder = field_data / "phasedat"
    record = agreement.phase_record(folder)
    files = sorted(folder.glob("phase_dat_*.txt"))
    counts = [count(record, agreement.stable32(file)) for file in files]
    assert (sum(a for a, _ in counts), sum(b for _, b in counts)) == counted("Stable32, PHASE.DAT")
    assert f"{len(files)} files" in PAGE.read_text(encoding="utf-8")


def test_a_wrong_digit_is_counted():
    cells = agreement.nbs14()
    wrong = agreement.Cell("modified", "full", 10, "6.172396e-02")
    assert agreement.agreeing(agreement.nbs14_record(), [cells[7], wrong]) == [True, False]


@pytest.mark.parametrize("overlap", ["none", "full"])
def test_the_unit_of_a_cell(overlap):
    assert agreement.Cell("allan", overlap, 1, "91.22945").unit == pytest.approx(1e-5)
    assert agreement.Cell("allan", overlap, 1, "1.2e-02").unit == pytest.approx(1e-3)
