"""docs/paper: its tables are those of the code, and a day again gives the stored numbers; tests/docs runs its blocks."""

import ast
import json
import re

import numpy as np
import pytest
from studies.paper import days, rows
from studies.paper.decoding import (
    DECODED,
    Decoded,
    decoded,
    expected_hits,
    longest_time,
    reproducing_share,
    reproducing_sizes,
    reproducing_times,
    significant_digits,
    undecoded,
)
from studies.paper.figures import FIG_12_RATES, fig_12_logs, term_figure
from studies.paper.notebook import NOTEBOOK
from studies.paper.tables import DAYS, NAMES, PAGES, PRINTED, STD, day_model, model, truth
from studies.paper.write import made
from studies.runner import seed_of

import sigmatau as st
from conftest import ROOT
from sigmatau.cli import main

FOUND = days.load()
TEXTS = {path.name: path.read_text(encoding="utf-8") for path in sorted(PAGES.glob("*.md"))}


@pytest.mark.parametrize("name", TEXTS)
def test_tables_are_those_of_the_code(name):
    assert made(TEXTS[name], FOUND) == TEXTS[name]


def test_every_item_of_the_paper_is_there():
    text = "".join(TEXTS.values())
    assert {name.removesuffix(".md") for name in TEXTS} == {
        "README", "authors-day", "equations", "errata", "noise-terms", "repeatability", "sampling", "units",
    }  # fmt: skip
    heads = re.findall(r"^## (.*)$", TEXTS["equations.md"], flags=re.MULTILINE)
    named = set()
    for head in heads:
        ends = [int(x) for x in re.findall(r"\((\d+)\)", head)]
        named |= set(range(ends[0], ends[-1] + 1))
    assert named == set(range(1, 30))
    for number in range(1, 13):
        assert re.search(rf"Fig(ure|s\.|ures)? [\d to,]*\b{number}\b", text) or number in (3, 4, 7), number
        assert number in (6, 7) or list((ROOT / "docs" / "figures").glob(f"paper-{number}.*")), number
    for table in ("I", "II", "III", "IV", "V"):
        assert re.search(rf"Tables?\b[^.]*\b{table}\b", text), table


LINKS = {(name, *link) for name, text in TEXTS.items() for link in re.findall(r"\]\(([\w./-]*)#([^)]+)\)", text)}


@pytest.mark.parametrize("anchor", sorted(LINKS))
def test_links_lead_to_a_heading(anchor):
    name, page, target = anchor
    text = (PAGES / (page or name)).read_text(encoding="utf-8")
    heads = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    assert target in {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


class TestTables:
    def test_the_first_row_of_tables_i_and_iii_is_in_tables_ii_and_iv(self):
        for unit, axes in DAYS.items():
            for channel, values in axes.items():
                (cell,) = [c for c in PRINTED if (c.unit, c.channel, c.term) == (unit, channel, "quantization")]
                assert values[0] == round(cell.value, 3)

    def test_models_are_the_printed_numbers(self):
        for cell in PRINTED:
            given = model(cell.unit).channels[cell.channel][cell.term] / cell.si_factor
            assert given == pytest.approx(cell.value, rel=2e-4)  # four digits of the files' m/s

    def test_a_day_has_the_quantization_of_its_row(self):
        assert truth(PRINTED[0], 3) == pytest.approx(0.919)
        assert (
            day_model("hg1700", 5).channels["gyro_x"]["random_walk"]
            == model("hg1700").channels["gyro_x"]["random_walk"]
        )
        assert day_model("motionpak2", 5).channels == model("motionpak2").channels

    def test_std_rows_have_ddof_1(self):
        """To the printed digit, but for Table III Y. With ddof = 0 four of the six are wrong."""
        wrong = {
            ddof: [
                (unit, channel)
                for unit, axes in DAYS.items()
                for channel, values in axes.items()
                if f"{np.std(values, ddof=ddof):.3f}" != STD[unit][channel]
            ]
            for ddof in (1, 0)
        }
        assert wrong[1] == [("hg1700", "gyro_y")]
        assert wrong[0] == [("cimu", "gyro_x"), ("cimu", "gyro_y"), ("cimu", "gyro_z"), ("hg1700", "gyro_x")]


class TestPlusMinus:
    @pytest.mark.parametrize("cell", [c for c in PRINTED if decoded(c)], ids=lambda c: f"{c.unit} {c.channel} {c.term}")
    def test_decoded_to_the_printed_digit(self, cell):
        assert decoded(cell)[2] == cell.printed_error
        assert DECODED[cell.unit, cell.channel, cell.term] in reproducing_sizes(cell)

    def test_the_same_cells_as_the_known_answers(self):
        import known

        names = {"CIMU": "cimu", "HG1700": "hg1700"}
        for name, (value, printed, n, m, rounded, _) in known.PLUS_MINUS.items():
            unit, sensor, axis, term = name.split(" ", 3)
            key = names[unit], f"{sensor}_{axis.lower()}", "rate_ramp" if term == "ramp" else term.replace(" ", "_")
            cell = next(c for c in PRINTED if (c.unit, c.channel, c.term) == key)
            assert (cell.value, cell.error, cell.samples) == (value, printed, n)
            if m & (m - 1):  # between two powers of 2: no more than chance
                assert Decoded(m, rounded) in reproducing_sizes(cell, per_octave=2)
                assert key not in DECODED
                continue
            assert DECODED[key].size == m
            assert Decoded(m, rounded) in reproducing_sizes(cell)

    def test_the_others_have_none(self):
        assert len(DECODED) == 25
        assert len(list(undecoded())) == 9
        assert not any(reproducing_sizes(cell) for cell in undecoded())
        for cell in undecoded():
            low, high = reproducing_times(cell)
            assert low < longest_time(cell) < high

    @pytest.mark.parametrize("cell", PRINTED, ids=lambda c: f"{c.unit} {c.channel} {c.term}")
    def test_share_of_octaves_that_give_the_error(self, cell):
        """Without rounding it is the length of `reproducing_times` in octaves, up to half the record."""
        low, high = reproducing_times(cell)
        octaves = min(np.log2(min(high, 3600) / low), 1)
        assert reproducing_share(cell, rounding=False) == pytest.approx(octaves, abs=3e-3)
        assert reproducing_share(cell, rounding=True) >= reproducing_share(cell, rounding=False)

    def test_chance(self):
        """The powers of 2 are no chance; sizes between them, and ± with one digit, are."""
        found = expected_hits(PRINTED, rounding=False)
        assert (found.hits, found.cells) == (22, 34)
        assert found.mean == pytest.approx(8.75, abs=0.1)
        assert found.p_value < 1e-8
        coarse = expected_hits([c for c in PRINTED if significant_digits(c) == 1], rounding=True)
        assert coarse.hits - coarse.mean < 3 * coarse.std


class TestDays:
    def test_the_gates(self):
        """Counts of the page: 91 % of all cells, and all STD rows within a last digit."""
        every = rows.covered(FOUND)
        assert every.total == 7 * len(PRINTED) == 238
        assert every.good >= rows.MIN_INSIDE * every.total
        assert all(abs(row.fits - row.used) <= rows.LAST_DIGIT for row in rows.std_rows(FOUND))
        assert f"**{every}** intervals" in TEXTS["repeatability.md"]

    @pytest.mark.parametrize("unit", NAMES)
    def test_a_day_again(self, unit):
        """Fits to 1e-6: a search ends there on another processor. Lines are sums."""
        day = 1 + seed_of(f"day again {unit}") % 7
        again = days.again(unit, day)
        stored = FOUND[days.cell_name(unit, day)]
        for channel, terms in stored.items():
            for term, found in terms.items():
                for key in ("value", "low", "high"):
                    assert again[channel][term][key] == pytest.approx(found[key], rel=1e-4)
                for key in ("read", "laid"):
                    if found[key] is None:
                        assert again[channel][term][key] is None
                    else:
                        assert again[channel][term][key] == pytest.approx(found[key], rel=1e-6)

    def test_two_short_days_of_one_unit(self):
        """The whole way on records of half an hour with other seeds: intervals hold, STD is found."""
        short = {
            days.cell_name("hg1700", day): days.analysed_day(seed_of(f"short day {day}"), "hg1700", day, hours=0.5)
            for day in (3, 5)
        }
        cells = [c for c in PRINTED if c.unit == "hg1700" and c.channel.startswith("gyro")]
        found = rows.covered(short, cells, on=(3, 5))
        assert found.total == 12
        assert found.good >= 9  # 95 % of 12, less 3 standard errors of a count
        used = np.std([DAYS["hg1700"]["gyro_x"][day - 1] for day in (3, 5)], ddof=1)
        values = [short[days.cell_name("hg1700", day)]["gyro_x"]["quantization"]["value"] for day in (3, 5)]
        spread = np.std(np.array(values) / np.pi * 180 * 3600, ddof=1)
        assert spread == pytest.approx(used, abs=3 * 5.1 / np.sqrt(2 * 180_000))  # of a difference / √2

    def test_lines_by_hand_are_laid_where_the_errors_say(self):
        ranges = {(c.unit, c.channel, c.term): days.hand_range(c) for c in PRINTED}
        assert ranges["cimu", "gyro_x", "random_walk"] == pytest.approx(
            (350.6, 1310.72), rel=1e-3
        )  # THEORY: T_x = 351 s
        assert ranges["cimu", "accel_x", "rate_ramp"][0] == pytest.approx(74.9, rel=1e-3)
        assert ranges["hg1700", "gyro_x", "quantization"] == pytest.approx((0.01, 2.56))


class TestFigures:
    def test_subsampling_folds(self):
        """Every 200th sample is as white as independent samples of the same variance: N grows by √(x coth x) = 3.07."""
        logs = fig_12_logs(minutes=2)
        assert list(logs) == list(FIG_12_RATES)
        assert [len(log.streams[0].column("gyro_x")) for log in logs.values()] == [120 * rate for rate in FIG_12_RATES]
        y = logs[10].streams[0].column("gyro_x")
        true = model("motionpak2").channels["gyro_x"]["random_walk"]
        variance = np.mean(np.diff(y) ** 2) / 2  # bias instability adds 0.1 %
        assert np.sqrt(variance / 10) / true == pytest.approx(3.070, rel=3 / np.sqrt(2 * 1200 / 1.5))

    def test_a_term(self):
        (ax,) = term_figure(1).axes
        formula, simulated, read = ax.lines
        np.testing.assert_allclose(formula.get_ydata(), np.sqrt(3) / formula.get_xdata())
        assert list(read.get_xdata()) == [pytest.approx(np.sqrt(3))]
        assert simulated.get_ydata()[0] == pytest.approx(np.sqrt(3), rel=0.05)


@pytest.mark.parametrize("unit", NAMES)
def test_files_of_a_demo(unit, tmp_path, monkeypatch, capsys):
    """And what is said of the axis that is left out. docs/paper/units.md shows two hours."""
    monkeypatch.setattr("sigmatau.cli.demo._HOURS", 0.05)
    assert main(["demo", "--unit", unit, "--output", str(tmp_path)]) == 0
    assert ("accel_z is left out" in capsys.readouterr().err) == (unit == "cimu")
    assert sorted(f.name for f in tmp_path.iterdir()) == sorted(
        [f"{unit}.toml", "report.html", "result.json", "static.csv"]
    )


def test_a_demo_of_no_unit_of_the_paper(tmp_path, capsys):
    assert main(["demo", "--unit", "vn100", "--output", str(tmp_path / "b")]) == 2
    assert "motionpak2" in capsys.readouterr().err
    assert not (tmp_path / "b").exists()


def test_the_notebook():
    import matplotlib as mpl

    mpl.use("Agg")
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    scope, displays, texts = {}, [], []
    for cell in (cell for cell in cells if cell["cell_type"] == "code"):
        assert max(len(line.rstrip()) for line in cell["source"]) <= 100
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, "notebook", "exec"), scope)
        if last is not None:
            displays.append(eval(compile(ast.Expression(last.value), "notebook", "eval"), scope))
            (stored,) = cell["outputs"]
            texts.append("".join(stored["data"]["text/plain"]))
    assert texts[:2] == ["Figure", "Figure"]
    assert texts[3:] == [
        repr(value) for value in displays[3:]
    ]  # of the table, ends of intervals depend on the processor
    assert texts[2].splitlines()[0] == repr(displays[2]).splitlines()[0]
    figures, unit, table, counted, std, effects = displays
    assert len([ax for ax in figures.axes if ax.get_visible()]) == 5
    assert len(unit.axes) == 2
    containing = re.fullmatch(r"of 12: (\d+) intervals contain the value; 12 lines are within the paper's ±", counted)
    assert int(containing[1]) >= 10  # of 95 % each, less three standard errors
    assert effects.judgement == "varies"
    assert isinstance(effects, st.RandomEffects)
    assert table["95 % interval"].iloc[0].startswith("[5.0")
    assert std == pytest.approx(0.01256, abs=5e-6)
