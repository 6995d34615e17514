"""`compare_runs` and ``sigmatau compare``: groups, what is left out, what is printed and written."""

import copy
import csv
import json
import re

import numpy as np
import pytest

from known import seed_of
from paper_tables import csv_of
from sigmatau import DataError, NoiseModel, OptionError, analyze, compare_runs, simulate
from sigmatau.cli import main
from sigmatau.lab.lots.comparison_text import remarks
from sigmatau.noise.terms import TERMS
from sigmatau.results import csv_text

MODEL = NoiseModel(
    channels={
        "gyro_x": {"random_walk": 8.7e-5, "bias_instability": 6e-5},
        "gyro_y": {"random_walk": 8.7e-5, "rate_ramp": 1e-7},
        "accel_x": {"random_walk": 5e-4},
    }
)
DAYS = 4


@pytest.fixture(scope="module")
def made():
    """Results of four days of a unit."""
    found = []
    for day in range(DAYS):
        record = simulate(MODEL, duration=1800, rate=20, rng=seed_of(f"compare day {day}"))
        found.append(analyze(record, notes={"serial number": "A1", "run": f"day {day + 1}"}))
    return found


@pytest.fixture
def days(made):
    return [copy.deepcopy(one.to_dict()) for one in made]


@pytest.fixture
def folder(days, tmp_path, monkeypatch):
    for k, day in enumerate(days, 1):
        (tmp_path / f"day{k}.json").write_text(json.dumps(day, indent=1))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scaled(result, factor, channel="gyro_x", term="random_walk"):
    """The result with a coefficient of another size."""
    one = result["channels"][channel]["fit"]["terms"][term]
    for name in ("value", "low", "high"):
        one[name] *= factor
    return result


class TestInMemory:
    def test_objects_dicts_and_files_are_the_same(self, made, days, folder):
        first = compare_runs(made)
        for other in (compare_runs(days), compare_runs(sorted(folder.glob("*.json"))), compare_runs(folder)):
            assert other.columns() == first.columns()

    def test_a_repeatable_unit(self, made):
        compared = compare_runs(made)
        assert compared.groups == ("A1",)
        assert [run.name for run in compared.runs] == [f"day {k}" for k in range(1, DAYS + 1)]
        walk = compared["gyro_x", "random_walk"]
        assert (walk.k, walk.scale, walk.judgement) == (DAYS, "relative", "repeatable")
        assert walk.low < 8.7e-5 < walk.high
        assert compared["A1", "gyro_x", "random_walk"] == walk
        with pytest.raises(KeyError, match="no values of A1 gyro_z"):
            compared["gyro_z", "random_walk"]

    def test_ramps_and_means_keep_their_sign(self, days):
        for k, day in enumerate(days):
            if k % 2:
                one = day["channels"]["gyro_y"]["fit"]["terms"]["rate_ramp"]
                one["value"], one["low"], one["high"] = -one["value"], -one["high"], -one["low"]
        compared = compare_runs(days)
        ramp = compared["gyro_y", "rate_ramp"]
        assert (ramp.scale, ramp.judgement) == ("absolute", "varies")
        assert ramp.low < 0 < ramp.high
        mean = compared["gyro_y", "mean"]
        assert mean.judgement == "without_errors"
        values = [day["channels"]["gyro_y"]["mean"]["value"] for day in days]
        assert mean.std == pytest.approx(np.std(values, ddof=1), rel=1e-12)

    def test_a_run_that_does_not_belong(self, days):
        scaled(days[2], 1.6)
        compared = compare_runs(days)
        (at,) = compared.outliers()
        assert compared.outliers()[at].name == "day 3"
        assert compared.key(at)[1].channel == "gyro_x"
        assert "! gyro_x random walk: run day 3 does not belong: 61 % above the others" in repr(compared)

    def test_a_mean_that_does_not_belong_has_a_difference(self, days):
        """A ratio to a mean near zero would be any number."""
        runs = [copy.deepcopy(days[k % len(days)]) for k in range(12)]
        for k, day in enumerate(runs):
            day["notes"]["run"] = f"run {k}"
            day["channels"]["gyro_x"]["mean"]["value"] = 1e-6 * (-1) ** k
            scaled(day, 1 + 1e-4 * k)
        runs[7]["channels"]["gyro_x"]["mean"]["value"] = np.radians(30) / 3600
        text = " ".join(remarks(compare_runs(runs)))
        assert "gyro_x mean: run run 7 does not belong: +30" in text
        assert "deg/h from the mean of the others" in text

    def test_one_run_is_not_compared(self, days):
        assert "Nothing to compare: each value is from one run." in repr(compare_runs(days[:1]))
        units = repr(compare_runs(days[:2], units=["u", "v"]))
        assert units.startswith("2 results of 2 units\nNothing to compare: each value is from one run.")

    def test_names_and_units(self, days):
        compared = compare_runs(days, names=["a", "b", "c", "d"], units=["u", "u", "v", "v"])
        assert compared.groups == ("u", "v")
        assert [run.name for run in compared.runs] == ["a", "b", "c", "d"]
        assert compared["v", "gyro_x", "random_walk"].k == 2
        with pytest.raises(OptionError, match="one name per result: 1 names, 4 results"):
            compare_runs(days, names=["a"])

    def test_by_run_and_by_axis(self, days):
        for k, day in enumerate(days):
            day["notes"] = {"Serial": f"U{k // 2}", "day": f"{k % 2}"}
        by_run = compare_runs(days, by="run")
        assert by_run.groups == ("0", "1")
        at = [*by_run].index(("0", "gyro_x", "random_walk"))
        assert [run.serial for run, _, _ in by_run.values(at)] == ["U0", "U1"]
        by_axis = compare_runs(days, by="axis")
        assert by_axis.groups == ("",)
        assert by_axis["gyro_x", "random_walk"].k == DAYS
        with pytest.raises(OptionError, match="unit, run, axis"):
            compare_runs(days, by="day")

    def test_terms_that_some_runs_show(self, days):
        terms = days[1]["channels"]["gyro_x"]["fit"]["terms"]
        terms["bias_instability"] = {"observed": False, "upper_limit": 1e-4, "level": 0.95, "unit": "rad/s"}
        compared = compare_runs(days)
        columns = compared.columns()
        row = next(k for k, key in enumerate(compared) if key[1:] == ("gyro_x", "bias_instability"))
        assert (columns["runs"][row], columns["of_runs"][row]) == (DAYS - 1, DAYS)
        assert columns["largest_limit"][row] == 1e-4
        assert "3 of 4" in repr(compared)
        assert "the mean of these is too large" in repr(compared)

    def test_a_run_that_should_show_the_term(self, days):
        terms = days[1]["channels"]["gyro_x"]["fit"]["terms"]
        terms["random_walk"] = {"observed": False, "upper_limit": 1e-6, "level": 0.95, "unit": "rad/sqrt(s)"}
        compared = compare_runs(days)
        ((_, (run,)),) = compared.below().items()
        assert run.name == "day 2"
        assert "run day 2 does not belong: below 0.0034 deg/√h, less than the others predict" in " ".join(
            repr(compared).split()
        )
        terms["random_walk"]["upper_limit"] = 1e-3
        assert not compare_runs(days).below()

    @pytest.mark.parametrize("by", ["unit", "run"])
    def test_a_screen_of_24_lines(self, by, tmp_path):
        """Six axes with four terms, with a run that does not belong in every row, and terms that are not seen."""
        rng = np.random.default_rng(seed_of("a screen of 24 lines"))
        units = {
            "gyro": ("arcsec", "deg/sqrt(h)", "deg/h", "deg/h/sqrt(h)"),
            "accel": ("m/s", "m/s/sqrt(h)", "ug", "m/s/h^(3/2)"),
        }
        rows = ["run,serial,channel,term,value,unit,error_percent,upper_limit"]
        for unit in range(2 if by == "run" else 1):
            for day in range(1, 8):
                for sensor, of in units.items():
                    for axis in "xyz":
                        for term, symbol in zip(TERMS, of, strict=False):
                            value = float(np.exp(0.01 * rng.standard_normal())) * (1.6 if day == 3 else 1.0)
                            seen = day != 5 or term == "random_walk"
                            cells = f"{value},{symbol},1," if seen else f",{symbol},,9"
                            rows.append(f"a day with a long name {day},unit {unit},{sensor}_{axis},{term},{cells}")
        path = tmp_path / "typed.csv"
        path.write_text("\n".join(rows) + "\n")
        lines = repr(compare_runs(path, by=by)).splitlines()
        assert len(lines) <= 23
        assert max(map(len, lines)) <= 80

    def test_holm(self):
        from sigmatau.lab.lots.grouping import holm

        p = np.array([0.01, 0.04, np.nan, 0.03, 0.5, 0.2])
        group = np.array([0, 0, 0, 0, 1, 1])
        np.testing.assert_allclose(holm(p, group), [0.03, 0.06, np.nan, 0.06, 0.5, 0.4], rtol=1e-12)


def moving(one, _):
    one["rest"]["verdict"] = "not_at_rest"
    for channel in one["channels"].values():
        del channel["fit"]


def same_log(one, other):
    one["source"]["sha256"] = other["source"]["sha256"] = "0" * 64


def in_another_unit(one, _):
    for term in one["channels"]["accel_x"]["fit"]["terms"].values():
        if isinstance(term, dict):
            term["unit"] = term["unit"].replace("m/s", "rad")


def without_a_model(one, _):
    for channel in one["channels"].values():
        channel["fit"]["verdict"] = "descriptive"
        for term in channel["fit"]["terms"].values():
            if isinstance(term, dict):
                term.pop("upper_limit", None)


def with_value(value):
    def change(one, _):
        one["channels"]["gyro_x"]["fit"]["terms"]["random_walk"] |= {"high": value, "value": value}

    return change


def of_gyro(change):
    return lambda one, _: change(one["channels"]["gyro_x"])


FAILED = {"schema": 2, "error": {"message": "no channel is left", "exit_code": 1}, "channels": {}}
CHANGES = {
    "failed": (lambda one, _: FAILED, "the analysis failed: no channel is left"),
    "not at rest": (moving, "not at rest"),
    "a newer schema": (lambda one, _: one | {"schema": 99}, "schema 99"),
    "a copy": (lambda _, other: copy.deepcopy(other), "of the same log as r0"),
    "the same log analysed again": (same_log, "of the same log as r0"),
    **{f"{value!r}": (with_value(value), "is not a number") for value in (float("nan"), "1", True, 1e999)},
    "another unit": (in_another_unit, "accel_x: in another unit"),
    "no model fits": (without_a_model, "no coefficient has an interval"),
    **{
        f"changed by hand {k}": (of_gyro(change), "or changed: channels.gyro_x")
        for k, change in enumerate((
            lambda gyro: gyro["fit"]["terms"].__setitem__("random_walk", "x"),
            lambda gyro: gyro["fit"]["terms"]["random_walk"].__setitem__("level", 2),
            lambda gyro: gyro.__setitem__("mean", [1]),
            lambda gyro: gyro.pop("quantity") and None,
        ))
    },
}  # fmt: skip


class TestNotUsed:
    """Each is named with its reason, and the others are compared."""

    def reasons(self, days):
        compared = compare_runs(days, names=[f"r{k}" for k in range(len(days))])
        assert compared["gyro_x", "random_walk"].k == len(days) - len(compared.unused)
        return compared.unused

    @pytest.mark.parametrize("change", CHANGES)
    def test_why(self, change, days):
        do, words = CHANGES[change]
        days[1] = do(days[1], days[0]) or days[1]
        reasons = self.reasons(days)
        assert [*reasons] == ["r1"]
        assert words in reasons["r1"]

    def test_no_values(self, days, tmp_path):
        path = tmp_path / "none.csv"
        path.write_text("run,channel,term,value,unit\n1,gyro_x,random_walk,,deg/sqrt(h)\n")
        assert list(compare_runs([*days, path]).unused.values()) == ["no values"]

    def test_a_table_without_rows(self, days, tmp_path):
        path = tmp_path / "none.csv"
        path.write_text("run,channel,term,value,unit\n")
        with pytest.raises(DataError, match="has no rows below its header"):
            compare_runs([path])
        assert list(compare_runs([*days, path]).unused.values()) == ["has no rows below its header"]

    def test_two_values_of_one_run(self, tmp_path):
        """They would be compared as two runs."""
        path = tmp_path / "twice.csv"
        rows = "1,gyro_x,random_walk,0.1,deg/sqrt(h)\n1,gyro_x,random_walk,0.2,deg/sqrt(h)\n"
        path.write_text(f"run,channel,term,value,unit\n{rows}")
        with pytest.raises(DataError, match="row 3: a second row of random_walk of gyro_x in the run '1'"):
            compare_runs([path])

    def test_nothing_is_left(self, days):
        with pytest.raises(DataError, match="not a result"):
            compare_runs({"a": 1})
        with pytest.raises(DataError, match="no result can be used; the first: run 1"):
            compare_runs([{"a": 1}, {"b": 1}])
        with pytest.raises(DataError, match="no results"):
            compare_runs([])


def test_an_interval_without_width_is_no_error(days):
    """A value with a zero error is not infinitely exact."""
    one = days[1]["channels"]["gyro_x"]["fit"]["terms"]["random_walk"]
    one["low"] = one["high"] = one["value"]
    assert compare_runs(days)["gyro_x", "random_walk"].k == DAYS - 1


def test_a_spread_of_zero_without_an_interval(tmp_path, capsys):
    """Of runs that differ by far less than their errors; 0 with an interval of those that do not."""
    table = tmp_path / "table.csv"
    for percent, between in ((10, "0"), (0.1, "0.00 [0.00, 0.12]")):
        rows = "".join(f"{k},gyro_x,random_walk,{1 + 1e-3 * (k % 2)},deg/sqrt(h),{percent}\n" for k in range(5))
        table.write_text(f"run,channel,term,value,unit,error_percent\n{rows}")
        assert main(["compare", str(table)]) == 0
        row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("gyro_x"))
        assert re.search(rf" 0\.055 +{re.escape(between)} ", row), row


def test_a_table_with_decimal_commas_is_the_same_table(tmp_path, capsys):
    rows = "".join(f"{k},gyro_x,random_walk,{1 + 0.1 * k},deg/sqrt(h),2.5\n" for k in range(5))
    text = f"run,channel,term,value,unit,error_percent\n{rows}"
    tables = {"table.csv": text, "semicolons.csv": text.replace(",", ";").replace(".", ",")}
    for name, content in tables.items():
        (tmp_path / name).write_text(content)
    printed = []
    for name in tables:
        assert main(["compare", str(tmp_path / name), "--csv", str(tmp_path / "of.csv"), "--decimal-comma"]) == 0
        printed.append((capsys.readouterr().out, (tmp_path / "of.csv").read_text()))
    assert printed[0] == printed[1]
    assert ";random_walk;" in printed[0][1]


class TestCommand:
    def test_the_screen(self, folder, capsys):
        assert main(["compare", "day1.json", "day2.json", "day3.json", "day4.json"]) == 0
        out, err = capsys.readouterr()
        assert err == ""
        assert out.startswith("4 runs of A1: day 1, day 2, day 3, day 4\n")
        assert "repeatable" in out
        assert "turn-on bias, STD: gyro_x" in out
        assert len(out.splitlines()) <= 24
        assert max(map(len, out.splitlines())) <= 80

    def test_what_it_writes(self, folder, capsys):
        words = [
            "compare",
            "day1.json",
            "day2.json",
            "day3.json",
            "--json",
            "r.json",
            "--csv",
            "r.csv",
            "--plot",
            "f.png",
        ]
        assert main(words) == 0
        content = json.loads((folder / "r.json").read_text())
        assert set(content) == {"by", "level", "runs", "rows", "values", "clocks_off", "not_used"}
        rows = list(csv.DictReader((folder / "r.csv").read_text().splitlines()))
        assert [row["term"] for row in rows] == content["rows"]["term"]
        assert (folder / "f.png").stat().st_size > 10_000
        capsys.readouterr()
        assert main([*words[:4], "--json", "-"]) == 0
        assert json.loads(capsys.readouterr().out)["runs"][0]["serial"] == "A1"

    def test_a_folder_of_tables(self, made, tmp_path, capsys, monkeypatch):
        from sigmatau.results import csv_text

        monkeypatch.chdir(tmp_path)
        (tmp_path / "out").mkdir()
        for k, one in enumerate(made, 1):
            (tmp_path / "out" / f"day{k}.csv").write_text(csv_text(one.columns()))
            (tmp_path / "out" / f"day{k}-curves.csv").write_text(csv_text(one.curves.columns()))
        (tmp_path / "out" / "log.csv").write_text("time,gx\n0,1\n")
        compared = compare_runs("out")
        other = compare_runs(made)
        assert compared["gyro_x", "random_walk"].tau_high == pytest.approx(
            other["gyro_x", "random_walk"].tau_high, rel=1e-9
        )
        assert len(compared.runs) == DAYS

    def test_units_by_folder(self, days, tmp_path):
        for k, day in enumerate(days):
            del day["notes"]
            place = tmp_path / f"unit{k // 2}"
            place.mkdir(exist_ok=True)
            (place / f"day{k % 2}.json").write_text(json.dumps(day))
        compared = compare_runs(tmp_path)
        assert compared.groups == ("unit0", "unit1")
        assert "4 results of 2 units" in repr(compared)
        assert max(map(len, repr(compared).splitlines())) <= 80
        assert len(repr(compared).splitlines()) <= 24

    def test_results_without_names_of_units_are_told_to_be_one_unit(self, folder, capsys):
        assert main(["compare", "day1.json", "day2.json"]) == 0
        assert "one unit" not in capsys.readouterr().err
        for path in folder.glob("*.json"):
            path.write_text(json.dumps(json.loads(path.read_text()) | {"notes": {}}))
        assert main(["compare", "day1.json", "day2.json"]) == 0
        assert "one unit is assumed" in capsys.readouterr().err

    def test_results_that_cannot_be_used_are_named(self, folder, capsys):
        (folder / "cut.json").write_text('{"schema": 2,')
        (folder / "list.json").write_text("[]")
        assert main(["compare", "."]) == 1
        out, err = capsys.readouterr()
        assert "4 runs of A1" in out
        assert "sigmatau: not used: cut.json: not JSON" in err
        assert "not used: list.json: a result of sigmatau analyze is an object" in err

    @pytest.mark.parametrize(
        ("words", "code", "message"),
        [
            ([], 2, "no results; give JSON files"),
            (["none.json"], 1, "none.json: No such file"),
            (["day1.json", "--level", "1.5"], 2, "--level must be between 0 and 1"),
            (["day1.json", "--jobs", "0"], 2, "--jobs 0: must be"),
            (["day1.json", "--plot", "f.txt"], 2, "the name must end in"),
            (["day1.json", "--json", "day1.json"], 2, "is the file that is read"),
            ([".", "--json", "new.json"], 1, "inside a folder of results"),
            (["empty"], 1, "empty: no result in this folder"),
            (["log.csv"], 1, "log.csv: not a table of coefficients"),
            (["log.csv"], 1, "sigmatau analyze LOG --json"),
            (["day1.json", "day2.json", "--by", "run", "--plot", "f.png"], 1, "two units in one run"),
            (["day1.json", "--plot", "f.png"], 1, "nothing to draw"),
        ],
    )  # fmt: skip
    def test_errors(self, words, code, message, folder, capsys):
        (folder / "empty").mkdir()
        (folder / "log.csv").write_text("a,b\n1,2\n")
        before = sorted(folder.iterdir())
        assert main(["compare", *words]) == code
        assert message in capsys.readouterr().err
        assert sorted(folder.iterdir()) == before


@pytest.fixture(scope="module")
def read_off_days():
    """Three days of a gyro with quantization noise and a random walk, read off and fitted."""
    model = NoiseModel(channels={"gyro_x": {"quantization": 2.5e-5, "random_walk": 2.7e-5}})
    days = [simulate(model, duration=900, rate=50, rng=seed_of(f"read off, day {day}")) for day in range(3)]
    return {method: [analyze(day, method=method) for day in days] for method in ("read-off", "likelihood")}


class TestReadOff:
    """Tables I and III by either method: δ of eq. (26) is δ, and never a standard error."""

    @pytest.mark.parametrize("method", ["read-off", "likelihood"])
    @pytest.mark.parametrize("form", ["json", "csv", "store"])
    def test_of_every_form(self, method, form, read_off_days, tmp_path):
        files = []
        for k, analysis in enumerate(read_off_days[method]):
            files.append(tmp_path / f"day{k}.{'csv' if form == 'csv' else 'json'}")
            files[-1].write_text(csv_text(analysis.columns()) if form == "csv" else analysis.to_json())
        if form == "store":
            pytest.importorskip("sqlalchemy")
            place = str(tmp_path / "lines.db")
            assert main(["store", "add", *map(str, files), "--unit", "A", "--store", place, "-q"]) == 0
            from sigmatau.lab.store.store import Store

            with Store(place) as store:
                compared = store.compare()
        else:
            compared = compare_runs(files)
        lines = [analysis.read_off["gyro_x"]["quantization"] for analysis in read_off_days[method]]
        rows = compared.columns()
        at = rows["term"].index("quantization")
        assert rows["paper_delta"][at] == pytest.approx(np.mean([line.error for line in lines]))
        assert rows["paper_accepts"][at] is (rows["std"][at] < rows["paper_delta"][at])
        errors = [error for *_, error in compared.values(at)]
        if method == "read-off":
            assert np.isnan(errors).all()
            assert (rows["mean_error"][at], rows["std_below_error"][at]) == (None, None)
            assert rows["judgement"][at] == "without_errors"
            assert [value for _, value, _ in compared.values(at)] == pytest.approx([line.value for line in lines])
        else:
            assert rows["mean_error"][at] < 0.5 * rows["paper_delta"][at]
            assert rows["judgement"][at] != "without_errors"


class TestTyped:
    @pytest.mark.parametrize(("table", "lines"), [
        ("I", ("STD             0.0171", "yes, δ = 0.074  yes, δ = 0.020  yes, δ = 0.016")),
        ("III", ("STD             0.037", "yes, δ = 0.068    no, δ = 0.0032    no, δ = 0.0028")),
    ])  # fmt: skip
    def test_the_papers_tables(self, table, lines, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "table.csv").write_text(csv_of(table))
        assert main(["compare", "table.csv", "--table"]) == 0
        out = capsys.readouterr().out
        for line in lines:
            assert " ".join(line.split()) in " ".join(out.split())
        assert re.search(r"^STD < error +no, error = \d", out, flags=re.MULTILINE)  # ours, under its own name
        spreads = {"I": ("1.81 [1.16, 3.98]", "4.7"), "III": ("0.72 [0.46, 1.59]", "1.9")}[table]
        assert all(text in out for text in spreads)

    def rows(self, tmp_path, *lines, head="run,channel,term,value,unit,error"):
        path = tmp_path / "typed.csv"
        path.write_text("\n".join([head, *lines]) + "\n")
        return path

    def test_without_errors(self, tmp_path):
        path = self.rows(tmp_path, "1,gyro_x,random_walk,0.1,deg/sqrt(h),", "2,gyro_x,random_walk,0.12,deg/sqrt(h),")
        found = compare_runs(path)["gyro_x", "random_walk"]
        assert found.judgement == "without_errors"
        assert found.std == pytest.approx(0.02 / np.sqrt(2) * np.pi / 180 / 60, rel=1e-9)

    @pytest.mark.parametrize(
        ("line", "words"),
        [
            ("1,gyro_x,random_walk,x,deg/sqrt(h),", "row 2: value 'x' is not a number"),
            ("1,gyro_x,random_walk,nan,deg/sqrt(h),", "row 2: value 'nan' is not a finite number"),
            ("1,gyro_x,random_walk,-1,deg/sqrt(h),", "must be positive"),
            ("1,gyro_x,random_walk,1,deg/sqrt(h),0", "error 0 must be positive"),
            ("1,gyro_x,random_walk,1,deg/h,", "'deg/h' is not a unit of random_walk of gyro_x"),
            ("1,gyro_x,arw,1,deg/sqrt(h),", "unknown term 'arw'; it is random_walk here"),
        ],
    )
    def test_refusals(self, line, words, tmp_path):
        with pytest.raises(DataError, match=words.replace("(", r"\(").replace(")", r"\)")):
            compare_runs(self.rows(tmp_path, line))

    def test_a_missing_column(self, tmp_path):
        path = self.rows(tmp_path, "1,gyro_x,random_walk,1", head="run,channel,term,value")
        with pytest.raises(DataError, match="column 'unit' is missing"):
            compare_runs(path)


def test_clocks(days):
    """A run whose lines are all 1 % higher was sampled by another clock."""
    frequencies = (1.0, 1.7, 2.9, 4.3)
    for k, day in enumerate(days):
        of = 1.01 if k == 2 else 1.0
        lines = []
        for f in frequencies:
            ends = {"value": f * of, "low": f * of * 0.9995, "high": f * of * 1.0005, "unit": "Hz"}
            lines.append({"amplitude": {"value": 1.0, "low": 0.9, "high": 1.1, "unit": "rad/s"}, "frequency": ends})
        day["channels"]["gyro_x"]["fit"]["terms"]["sinusoid"] = lines
    compared = compare_runs(days)
    (name,) = compared.clocks_off
    assert name == "A1 day 3"
    assert compared.clocks_off[name].size == pytest.approx(1.01, abs=0.001)
