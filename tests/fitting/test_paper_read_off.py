"""The paper's tables read off simulated records, a fast version of studies/paper_read_off.py."""

import pytest
from studies import paper_read_off as paper

from known import PLUS_MINUS, seed_of

RECORDS = 1  # of each unit; the study has 12
COUNTED = [key for key in paper.PRINTED if key not in paper.UNEXPLAINED]


@pytest.fixture(scope="module")
def results():
    return {
        f"{unit} {k}": paper.cell(seed_of(f"paper read off, fast, {unit} {k}"), unit)
        for unit in paper.RATES
        for k in range(RECORDS)
    }


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(paper, "SEEDS", RECORDS)


@pytest.mark.parametrize(("way", "share"), [("by hand", 0.97), ("by the rules", 0.91), ("beside the fit", 0.95)])
def test_share_of_the_coefficients_within_the_printed_error(results, way, share):
    """The shares are those of the 12 records of the study; 30 readings: three standard errors are 9 % to 16 %."""
    inside = sum(len(paper.within(results, key, way)) for key in COUNTED)
    total = RECORDS * len(COUNTED)
    assert inside / total >= share - 3 * (share * (1 - share) / total) ** 0.5


def test_lines_alone_hold_the_other_term(results):
    """Each line alone misses every bias instability of Table V: the random walk is in it too."""
    for key in COUNTED:
        if key[2] == "bias_instability":
            assert not paper.within(results, key, "alone")
            values = [one[0] / paper.true_value(key) for one in paper.readings(results, key, "alone")]
            assert min(values) > 1.1


def test_quantization_ends_where_the_paper_ends_it(results):
    """By the rules, within a factor of four of the averaging times that the printed ± reveal; before, 1311 s of 82 s."""
    for key, (*_, longest) in paper.PRINTED.items():
        if key[2] == "quantization" and key not in paper.UNEXPLAINED:
            for one in paper.readings(results, key, "by the rules"):
                assert longest / 4.1 <= one[3] <= 4 * longest, key


def test_table_is_that_of_the_known_answers():
    names = {"quantization": "quantization", "random_walk": "random walk", "rate_ramp": "ramp"}
    names["rate_random_walk"] = "rate random walk"
    seen = 0
    for (unit, channel, term), (value, error, _, _, longest) in paper.PRINTED.items():
        sensor, axis = channel.split("_")
        known = PLUS_MINUS.get(f"{paper.UNITS[unit]} {sensor} {axis.upper()} {names.get(term)}")
        if known is not None:
            seen += 1
            assert known[:2] == (value, error)
            assert known[3] == round(longest * paper.RATES[unit])
    assert seen == len(PLUS_MINUS)
