"""``sigmatau compare`` and ``sigmatau datasheet``: what they print, exit codes, and the how-to page's commands."""

import json
import re
import shlex
import tomllib

import numpy as np
import pytest

from conftest import ROOT
from known import seed_of
from sigmatau import NoiseModel, Record, analyze, list_datasheets
from sigmatau.cli import main

PAGE = (ROOT / "docs" / "how-to" / "datasheets.md").read_text(encoding="utf-8")
SPEC = next(block for block in re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE))

# Random walks of about a sixth of the page's maxima, and the same ten times larger; of the short one B cannot be told.
_RATE, _GYRO, _ACCEL = 100.0, 2.3e-5, 2.5e-4
_UNITS = {"good": (1.0, 1 << 15), "bad": (10.0, 1 << 15), "short": (1.0, 500)}


@pytest.fixture(scope="module")
def contents():
    found = {}
    for name, (factor, n) in _UNITS.items():
        noise = np.random.default_rng(seed_of(f"unit {name}")).standard_normal((n, 6)) * factor * np.sqrt(_RATE)
        record = Record.from_arrays(
            rate=_RATE, gyro=_GYRO * noise[:, :3], accel=_ACCEL * noise[:, 3:], unit={"gyro": "rad/s", "accel": "m/s^2"}
        )
        found[name] = json.dumps(analyze(record).to_dict())
    return found


@pytest.fixture
def folder(tmp_path, monkeypatch, contents):
    for name, content in contents.items():
        (tmp_path / f"{name}.json").write_text(content)
    (tmp_path / "spec.toml").write_text(SPEC, encoding="utf-8")
    (tmp_path / "results").mkdir()
    for name in ("good", "bad"):
        (tmp_path / "results" / f"{name}.json").write_text(contents[name])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(line):
    return main(shlex.split(line, comments=True)[1:])


@pytest.mark.parametrize(
    ("line", "code"), re.findall(r"^(sigmatau compare .*?) +# exit code (\d)$", PAGE, flags=re.MULTILINE)
)
def test_the_pages_commands_end_as_it_says(line, code, folder, capsys):
    assert run(line) == int(code), capsys.readouterr()


def test_the_page_has_all_exit_codes():
    assert set(re.findall(r"# exit code (\d)$", PAGE, flags=re.MULTILINE)) == {"0", "1", "3"}


def test_the_pages_model_command(tmp_path, monkeypatch, capsys):
    (line,) = re.findall(r"^(sigmatau datasheet show .*?) > stim300.toml$", PAGE, flags=re.MULTILINE)
    assert run(line) == 0
    (tmp_path / "stim300.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert "gyro_z" in NoiseModel.read(tmp_path / "stim300.toml").channels
    monkeypatch.chdir(tmp_path)
    assert run("sigmatau simulate stim300.toml --hours 0.01 --rate 10 -o out.csv -q") == 0
    assert run("sigmatau plan stim300.toml --term rate_random_walk --rate 100 --hours 1 -q") == 0


def test_one_unit_is_told_in_full(folder, capsys):
    assert run("sigmatau compare bad.json --datasheet spec.toml") == 3
    out = capsys.readouterr().out
    assert out.startswith("bad.json against Unit 7: out\n")
    line = next(row for row in out.splitlines() if row.startswith("  gyro_x"))
    assert re.search(
        r"angle random walk +0\.7\d* \[.*\] deg/√h +typical 0\.3: above by .* σ; maximum 0\.45: above by", line
    )
    assert line.endswith("out")


def test_several_units_are_a_line_each_and_a_count(folder, capsys):
    assert run("sigmatau compare good.json bad.json short.json --datasheet spec.toml") == 3
    good, bad, short, total, ends = capsys.readouterr().out.splitlines()
    assert good == "good.json: within"
    assert bad.startswith("bad.json: out: gyro_x angle random walk (above by")
    assert short.startswith("short.json: undecided: ")
    assert total == "3 units against Unit 7: 1 within, 1 undecided, 1 out"
    assert ends == "passed: 2, failed: 1"
    assert run("sigmatau compare good.json bad.json short.json --datasheet spec.toml --undecided fail") == 3
    assert capsys.readouterr().out.splitlines()[-1] == "passed: 1, failed: 2"


def test_a_file_that_is_none_does_not_hide_the_others(folder, capsys):
    (folder / "cut.json").write_text('{"channels": ')
    assert run("sigmatau compare good.json cut.json bad.json none.json --datasheet spec.toml") == 1
    captured = capsys.readouterr()
    good, bad, total, ends = captured.out.splitlines()
    assert good == "good.json: within"
    assert bad.startswith("bad.json: out: ")
    assert total.startswith("2 units against Unit 7: 1 within, 1 out")
    assert ends == "passed: 1, failed: 1, not compared: 2"
    first, second = captured.err.splitlines()
    assert first.startswith("sigmatau: cut.json: not JSON")
    assert second.startswith("sigmatau: none.json: No such file")
    assert run("sigmatau compare good.json cut.json --datasheet spec.toml --json") == 1
    content = json.loads(capsys.readouterr().out)
    assert [unit["unit"] for unit in content["units"]] == ["good.json"]
    assert [unit["unit"] for unit in content["not_compared"]] == ["cut.json"]
    assert run("sigmatau compare cut.json none.json --datasheet spec.toml") == 1
    assert capsys.readouterr().out == ""


def test_a_folder_is_the_results_in_it(folder, capsys):
    (folder / "results" / "a.png").write_bytes(b"")
    assert run("sigmatau compare results --datasheet spec.toml") == 3
    bad, good, *_ = capsys.readouterr().out.splitlines()
    assert bad.startswith("results/bad.json: out: ")
    assert good == "results/good.json: within"


def test_a_typical_value_fails_nobody(folder, capsys):
    """Above it, or above it by one reading of the sheet: said in the table, and no failure even where doubt fails."""
    (folder / "open.toml").write_text(
        'name = "open"\nmaker = "M"\nsource = "S"\n'
        '[gyro]\nnoise_density = { typical = "2.76e-5 rad/s/sqrt(Hz)", sided = "unknown" }\n'
    )
    for more, status in (("", "undecided"), ("--sided one", "above typical"), ("--sided two", "within")):
        assert run(f"sigmatau compare good.json --datasheet open.toml --undecided fail {more}") == 0
        captured = capsys.readouterr()
        assert captured.out.startswith(f"good.json against open: {status}\n")
        assert ("a typical value fails no unit" in captured.out) == (status == "undecided")
        assert captured.err == ""
    assert run("sigmatau compare good.json --datasheet open.toml --undecided fail --factor 1") == 3
    assert run("sigmatau compare good.json --datasheet open.toml --factor 1") == 0
    assert "1 of 1 passed undecided and may be out" in capsys.readouterr().err
    # A sensor that is not there has not been shown to keep to anything.
    (folder / "open.toml").write_text(
        'name = "open"\nmaker = "M"\nsource = "S"\n'
        '[gyro]\nrandom_walk = { typical = "1 deg/sqrt(h)" }\n[accel]\nrandom_walk = { typical = "1 m/s/sqrt(h)" }\n'
    )
    content = json.loads((folder / "good.json").read_text())
    content["channels"] = {k: v for k, v in content["channels"].items() if k.startswith("gyro")}
    (folder / "half.json").write_text(json.dumps(content))
    assert run("sigmatau compare half.json --datasheet open.toml --undecided fail") == 3


def test_values_are_printed_as_the_sheet_has_them(folder, capsys):
    """N of good.json is 2.3e-5 rad/√s, 0.00186 deg/s/√Hz of a one-sided density."""
    (folder / "own.toml").write_text(
        'name = "own"\nmaker = "M"\nsource = "S"\n[gyro]\n'
        'noise_density = { typical = "5 mdeg/s/sqrt(Hz)", maximum = "0.007 deg/s/sqrt(Hz)", sided = "one" }\n'
        '[accel]\nnoise_density = { maximum = "70 ug/sqrt(Hz)", sided = "unknown" }\n'
    )
    run("sigmatau compare good.json --datasheet own.toml")
    out = capsys.readouterr().out
    gyro = re.search(
        r"gyro_x +noise density, one-sided +([\d.]+) \[.*?\] mdeg/s/√Hz +typical 5: below by .*;"
        r" maximum 0\.007 deg/s/√Hz: below by",
        out,
    )
    assert float(gyro[1]) == pytest.approx(1e3 * np.degrees(_GYRO) * np.sqrt(2), rel=0.02)
    one, two = re.search(
        r"accel_x +noise density, one-sided +([\d.]+) \[.*?\] µg/√Hz +maximum 70: .*\n"
        r" +or two-sided +([\d.]+) \[.* maximum 70:",
        out,
    ).groups()
    assert float(two) == pytest.approx(_ACCEL / 9.80665e-6, rel=0.02)
    assert float(one) / float(two) == pytest.approx(np.sqrt(2), rel=0.01)
    assert "confidence level of above and below: 95 % each" in out


def test_undecided_is_said_when_it_passes(folder, capsys):
    assert run("sigmatau compare short.json --datasheet spec.toml") == 0
    assert "1 of 1 passed undecided and may be out" in capsys.readouterr().err
    assert run("sigmatau compare short.json --datasheet spec.toml -q") == 0
    assert capsys.readouterr().err == ""


def test_a_fit_that_is_not_adequate_is_named_where_it_passes(folder, contents, capsys):
    content = json.loads(contents["bad"])
    for channel in content["channels"].values():
        channel["fit"]["verdict"] = "descriptive"
    (folder / "doubtful.json").write_text(json.dumps(content))
    assert run("sigmatau compare doubtful.json good.json --datasheet spec.toml") == 0
    assert "1 of 2 passed undecided (1 because no model fits)" in capsys.readouterr().err


def test_a_name_cannot_forge_a_line(folder, contents, capsys):
    name = "x\ngood.json: within\x1b[31m.json"
    (folder / name).write_text(contents["bad"])
    for more in (["good.json"], []):
        assert main(["compare", name, *more, "--datasheet", "spec.toml"]) == 3
        out = capsys.readouterr().out
        assert "x\\ngood.json: within\\x1b[31m.json" in out
        assert "\x1b" not in out
    (folder / "x\x1b[2J.json").write_text("{}")
    assert main(["compare", "x\x1b[2J.json", "good.json", "--datasheet", "spec.toml"]) == 1
    assert "\x1b" not in capsys.readouterr().err


@pytest.mark.parametrize("key", ["low", "high", "upper_limit"])
def test_a_damaged_result_does_not_stop_the_others(folder, contents, key, capsys):
    content = json.loads(contents["good"])
    content["channels"]["gyro_x"]["fit"]["terms"]["random_walk"][key] = 1e308
    (folder / "damaged.json").write_text(json.dumps(content))
    assert run("sigmatau compare damaged.json good.json --datasheet spec.toml") == 1
    captured = capsys.readouterr()
    assert "good.json: within" in captured.out
    assert "damaged.json: channel 'gyro_x'" in captured.err


def test_files_of_windows_editors(folder):
    for name in ("good.json", "spec.toml"):
        (folder / f"bom-{name}").write_bytes(b"\xef\xbb\xbf" + (folder / name).read_bytes())
    assert run("sigmatau compare bom-good.json --datasheet bom-spec.toml") == 0


@pytest.mark.parametrize("place", ["--datasheet", "--json"])
def test_a_name_that_is_too_long_is_named(folder, place, capsys):
    words = ["compare", "good.json", "--datasheet", "a" * 300 + ".toml"]
    assert main(words if place == "--datasheet" else ["inspect", "good.json", "--json", "a" * 300]) in (1, 2)
    err = capsys.readouterr().err
    assert "standard output" not in err
    assert "aaa" in err or place == "--json"


def test_axes_that_are_missing_do_not_pass_as_decided(folder, contents, capsys):
    content = json.loads(contents["good"])
    for name in ("gyro_y", "gyro_z", "accel_y", "accel_z"):
        del content["channels"][name]
    (folder / "one.json").write_text(json.dumps(content))
    assert run("sigmatau compare one.json --datasheet spec.toml --undecided fail") == 3
    assert "accel_y, accel_z, gyro_y, gyro_z: in the datasheet, not in the result" in capsys.readouterr().out
    single = re.sub(r"^\[(gyro|accel)\].*$", r'[\1]\naxes = ["x"]', SPEC.partition("[accel_z]")[0], flags=re.MULTILINE)
    (folder / "single.toml").write_text(single, encoding="utf-8")
    assert run("sigmatau compare one.json --datasheet single.toml --undecided fail") == 0


def test_json_is_the_verdicts(folder, capsys):
    assert run("sigmatau compare good.json bad.json --datasheet spec.toml --json") == 3
    content = json.loads(capsys.readouterr().out)
    assert content["failed"] == 1
    assert content["datasheet"]["name"] == "Unit 7"
    assert [unit["status"] for unit in content["units"]] == ["within", "out"]
    (walk,) = [
        c for c in content["units"][1]["claims"] if c["channel"] == "gyro_y" and c["claim"]["key"] == "random_walk"
    ]
    assert walk["readings"][0]["maximum"]["side"] == "above"


def test_options_reach_the_comparison(folder, capsys):
    (folder / "open.toml").write_text(
        'name = "open"\nmaker = "M"\nsource = "S"\n'
        '[gyro]\nnoise_density = { typical = "2.76e-5 rad/s/sqrt(Hz)", sided = "unknown" }\n'
    )
    base = "sigmatau compare good.json --datasheet open.toml -q"
    assert run(f"{base} --factor 1") == 0
    assert "one-sided or two-sided" in capsys.readouterr().out
    assert run(f"{base} --factor 1 --sided one") == 3
    assert run(f"{base} --factor 1 --sided two") == 0
    assert run(f"{base} --factor 1.5 --sided one") == 0
    assert run(base) == 0


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("compare --datasheet spec.toml", 2, "no result"),
        ("compare good.json", 2, "datasheet"),
        ("compare good.json --datasheet nonesuch", 2, "unknown datasheet 'nonesuch'; known: adis16405"),
        ("compare good.json --datasheet none.toml", 1, "none.toml: No such file"),
        ("compare good.json --datasheet motionpak2", 1, "MotionPak II-3g: the datasheet has no noise specification"),
        ("compare good.json --datasheet spec.toml --level 1.5", 2, "--level must"),
        ("compare good.json --datasheet spec.toml --factor 0.5", 2, "--factor must"),
        ("compare cut.json --datasheet spec.toml", 1, "cut.json: not JSON"),
        ("compare list.json --datasheet spec.toml", 1, "list.json: not a result"),
        ("compare log.csv --datasheet spec.toml", 1, "first sigmatau analyze log.csv --json log.json"),
        ("export log.csv --to kalibr", 1, "first sigmatau analyze log.csv --json log.json"),
        ("compare empty --datasheet spec.toml", 1, "empty: no .json in this folder"),
        ("compare deep.json --datasheet spec.toml", 1, "deep.json: "),
        ("compare spec.toml --datasheet spec.toml", 1, "spec.toml: unknown key"),
        ("datasheet show", 2, "show needs a name"),
        ("datasheet show nonesuch", 2, "unknown datasheet"),
        ("datasheet list cimu", 2, "sigmatau datasheet show cimu"),
        ("datasheet list --model", 2, "--model needs one datasheet"),
        ("datasheet show cimu --model --json", 2, "not both"),
        ("datasheet show cimu --sided one", 2, "need --model"),
        ("datasheet show icm42688p --model", 2, "--sided one or two"),
        ("datasheet show motionpak2 --model", 1, "no noise specification"),
    ],
)
def test_refusals(line, code, words, folder, capsys):
    (folder / "cut.json").write_text('{"channels": ')
    (folder / "list.json").write_text("[]")
    (folder / "deep.json").write_text("[" * 100_000)
    (folder / "log.csv").write_text("time [s],gyro_x [rad/s]\n0,1\n")
    (folder / "empty").mkdir()
    assert run(f"sigmatau {line}") == code
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.out == ""


def test_list_and_show(capsys):
    assert run("sigmatau datasheet list") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(list_datasheets())
    assert run("sigmatau datasheet list --json") == 0
    assert set(json.loads(capsys.readouterr().out)) == set(list_datasheets())
    assert run("sigmatau datasheet show ISM330DHCX") == 0
    out = capsys.readouterr().out
    assert "typical 60 ug/sqrt(Hz), maximum 100 ug/sqrt(Hz) (one- or two-sided: not stated)" in out
    assert run("sigmatau datasheet show ism330dhcx --model --sided one --bias minimum --use maximum") == 0
    out = capsys.readouterr().out
    assert out.startswith("# ISM330DHCX (STMicroelectronics); ")
    # Which of the sheet's numbers it is stands beside each.
    assert "# gyro angle random walk: typical 0.21 deg/sqrt(h), the datasheet has no maximum value\n" in out
    assert "# accel noise density: maximum 100 ug/sqrt(Hz), taken as one-sided\n" in out
    assert set(tomllib.loads(out)["channels"]) == {f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"}
    assert run("sigmatau datasheet show hg1700 --model") == 0
    assert (
        "# gyro angle random walk: maximum 0.15 deg/sqrt(h), the datasheet has no typical value\n"
        in capsys.readouterr().out
    )


def test_ranges_are_printed_as_ranges(capsys):
    assert run("sigmatau datasheet show mpu6050") == 0
    assert re.search(r"gyro +bandwidth +5 Hz to 256 Hz\n", capsys.readouterr().out)


def test_the_pages_shares_are_those_of_the_study():
    """Its table: at the limit by two levels, then 10 and 25 % above it."""
    study = (ROOT / "docs" / "study" / "datasheets.md").read_text(encoding="utf-8")
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in study.splitlines() if line.startswith("| ")]
    header = next(row for row in cells if row[:2] == ["compared", "percent"])
    by_ratio = {row[0]: dict(zip(header, row, strict=True)) for row in cells if row[1:2] == ["out"]}
    by_level = {row[0]: row[1:] for row in cells if len(row) == 4 and row[0] != "compared"}
    rows = re.findall(r"^\| (\w.*?) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", PAGE, flags=re.MULTILINE)
    assert len(rows) == 5
    for name, *shares in rows:
        assert shares == [*by_level[name][:2], by_ratio[name]["1.1"], by_ratio[name]["1.25"]]
    assert {row["0.9"] for row in by_ratio.values()} == {"0.0"}
