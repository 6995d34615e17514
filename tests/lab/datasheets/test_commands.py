"""``sigmatau lot`` on results and ``sigmatau datasheet``: what they print, exit codes, and the how-to page's commands."""

import json
import re
import shlex
import tomllib

import numpy as np
import pytest

from conftest import ROOT
from lot_logs import ACCEL, GYRO, results_of_units
from sigmatau import NoiseModel, list_datasheets
from sigmatau.cli import main

PAGE = (ROOT / "docs" / "how-to" / "datasheets.md").read_text(encoding="utf-8")
SPEC = next(block for block in re.findall(r"^```toml\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE))


@pytest.fixture(scope="module")
def contents():
    return results_of_units()


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


@pytest.mark.parametrize(
    ("command", "instead"),
    [
        (
            "plan icm42688p --term bias_instability --rate 100",
            "sigmatau datasheet show icm42688p --model > icm42688p.toml",
        ),
        ("predict icm42688p --after 60s", "sigmatau datasheet show icm42688p --model"),
        ("simulate ICM-42688-P --hours 1 --rate 1 -o x.csv", "sigmatau datasheet show ICM-42688-P --model"),
        ("psd good.json --model icm42688p", "sigmatau datasheet show icm42688p --model"),
        ("export icm42688p --to kalibr", "take --from-datasheet icm42688p"),
        ("plan icm4268 --term bias_instability --rate 100", "icm4268: No such file or directory"),
    ],
)
def test_a_datasheet_in_place_of_a_model(folder, command, instead, capsys):
    assert main(shlex.split(command)) == 1
    assert instead in capsys.readouterr().err


def run(line):
    return main(shlex.split(line, comments=True)[1:])


def test_the_pages_model_command(tmp_path, monkeypatch, capsys):
    """What it prints is a model file."""
    assert run("sigmatau datasheet show stim300 --model --bias minimum") == 0
    (tmp_path / "stim300.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert "gyro_z" in NoiseModel.read(tmp_path / "stim300.toml").channels
    monkeypatch.chdir(tmp_path)
    assert run("sigmatau simulate stim300.toml --hours 0.01 --rate 10 -o out.csv -q") == 0
    assert run("sigmatau plan stim300.toml --term rate_random_walk --rate 100 --hours 1 -q") == 0


def test_one_unit_is_told_in_full(folder, capsys):
    assert run("sigmatau lot bad.json --spec spec.toml") == 3
    out = capsys.readouterr().out
    assert out.startswith("1 unit against Unit 7: 1 failed\n")
    assert "\nbad against Unit 7: out\n" in out
    assert re.search(
        r"\n  gyro_x +angle random walk +out\n +0\.7\d* \[.*\] deg/√h\n"
        r" +typical 0\.3: above by .* σ\n +maximum 0\.45: above by",
        out,
    )
    assert max(map(len, out.splitlines())) <= 80


def test_several_units_are_counted_and_those_told_that_did_not_pass(folder, capsys):
    assert run("sigmatau lot good.json bad.json short.json --spec spec.toml") == 3
    head, *rows = capsys.readouterr().out.splitlines()
    assert head == "3 units against Unit 7: 1 failed, 1 not judged, 1 passed"
    starts = [row.split("  ")[0] for row in rows[: rows.index("")] if not row.startswith(" ")]
    assert starts == ["failed", "not judged"]
    assert re.match(r"failed +bad +.* is \d+ % above the maximum", " ".join(rows))
    assert run("sigmatau lot good.json bad.json short.json --spec spec.toml --undecided fail") == 3
    assert capsys.readouterr().out.startswith("3 units against Unit 7: 2 failed, 1 passed")


def test_a_file_that_is_none_does_not_hide_the_others(folder, capsys):
    (folder / "cut.json").write_text('{"channels": ')
    assert run("sigmatau lot good.json cut.json bad.json none.json --spec spec.toml") == 3
    head, *_ = out = capsys.readouterr().out.splitlines()
    assert head == "4 units against Unit 7: 1 failed, 1 failed to read, 1 missing, 1 passed"
    assert any(re.match(r"failed to read +cut +not JSON", line) for line in out)
    assert any(re.match(r"missing +none +expected, but there is no file", line) for line in out)
    assert run("sigmatau lot good.json cut.json --spec spec.toml --json") == 4
    content = json.loads(capsys.readouterr().out)
    assert {unit["name"]: unit["state"] for unit in content["units"]} == {"good": "passed", "cut": "unreadable"}


def test_a_folder_is_the_results_in_it(folder, capsys):
    (folder / "results" / "a.png").write_bytes(b"")
    (folder / "results" / ".bad.json.sigmatau-x.json").write_bytes(b"")  # what a killed run leaves
    assert run("sigmatau lot results --spec spec.toml") == 3
    assert capsys.readouterr().out.startswith("2 units against Unit 7: 1 failed, 1 passed")


def test_a_typical_value_passes_and_fails_nobody(folder, capsys):
    """Whatever the convention: it needs a maximum, or a factor that makes one of it."""
    (folder / "open.toml").write_text(
        'name = "open"\nmaker = "M"\nsource = "S"\n'
        '[gyro]\nnoise_density = { typical = "2.76e-5 rad/s/sqrt(Hz)", sided = "unknown" }\n'
    )
    for more in ("", "--sided one", "--sided two"):
        assert run(f"sigmatau lot good.json --spec open.toml --undecided fail {more}") == 4
        out = capsys.readouterr().out
        assert "no maximum in the specification; state one" in out
        assert "open has typical values only, so that no unit passes" in out
    assert run("sigmatau lot good.json --spec open.toml --undecided fail --factor 1") == 3
    assert run("sigmatau lot good.json --spec open.toml --factor 1") == 4
    assert run("sigmatau lot good.json --spec open.toml --factor 1 --undecided pass") == 0
    capsys.readouterr()
    # A sensor that is not there has not been shown to meet anything.
    (folder / "open.toml").write_text(
        'name = "open"\nmaker = "M"\nsource = "S"\n'
        '[gyro]\nrandom_walk = { maximum = "1 deg/sqrt(h)" }\n[accel]\nrandom_walk = { maximum = "1 m/s/sqrt(h)" }\n'
    )
    content = json.loads((folder / "good.json").read_text())
    content["channels"] = {k: v for k, v in content["channels"].items() if k.startswith("gyro")}
    (folder / "half.json").write_text(json.dumps(content))
    assert run("sigmatau lot half.json --spec open.toml --undecided fail") == 3
    assert run("sigmatau lot half.json --spec open.toml") == 4


def test_values_are_printed_as_the_sheet_has_them(folder, capsys):
    """N of good.json is 2.3e-5 rad/√s, 0.00186 deg/s/√Hz of a one-sided density."""
    (folder / "own.toml").write_text(
        'name = "own"\nmaker = "M"\nsource = "S"\n[gyro]\n'
        'noise_density = { typical = "5 mdeg/s/sqrt(Hz)", maximum = "0.007 deg/s/sqrt(Hz)", sided = "one" }\n'
        '[accel]\nnoise_density = { maximum = "70 ug/sqrt(Hz)", sided = "unknown" }\n'
    )
    run("sigmatau lot good.json --spec own.toml")
    out = capsys.readouterr().out
    gyro = re.search(
        r"gyro_x +noise density, one-sided +([\d.]+) (?:\[.*?\]|± [\d.]+) mdeg/s/√Hz +within\n +typical 5: below by .*\n"
        r" +maximum 0\.007 deg/s/√Hz: below by",
        out,
    )
    assert float(gyro[1]) == pytest.approx(1e3 * np.degrees(GYRO) * np.sqrt(2), rel=0.02)
    one, two = re.search(
        r"accel_x +noise density, one-sided +([\d.]+) (?:\[.*?\]|± [\d.]+) µg/√Hz .*\n +maximum 70: .*\n"
        r" +or two-sided +([\d.]+) [\[±].*\n +maximum 70:",
        out,
    ).groups()
    assert float(two) == pytest.approx(ACCEL / 9.80665e-6, rel=0.02)
    assert float(one) / float(two) == pytest.approx(np.sqrt(2), rel=0.01)
    assert "confidence level of above and below: 95 % each" in out


def test_a_fit_that_is_not_adequate_is_named(folder, contents, capsys):
    content = json.loads(contents["bad"])
    for channel in content["channels"].values():
        channel["fit"]["verdict"] = "descriptive"
    (folder / "doubtful.json").write_text(json.dumps(content))
    assert run("sigmatau lot doubtful.json --spec spec.toml") == 4
    assert "no model fits" in capsys.readouterr().out


def test_a_name_cannot_forge_a_line(folder, contents, capsys):
    name = "x\ngood: passed\x1b[31m.json"
    (folder / name).write_text(contents["bad"])
    for more in (["good.json"], []):
        assert main(["lot", name, *more, "--spec", "spec.toml", "-v"]) == 3
        out = capsys.readouterr().out
        assert "x\\ngood: passed\\x1b[31m" in out
        assert "\x1b" not in out
    (folder / "x\x1b[2J.json").write_text("{}")
    assert main(["lot", "x\x1b[2J.json", "good.json", "--spec", "spec.toml"]) == 4
    captured = capsys.readouterr()
    assert "\x1b" not in captured.out + captured.err


def test_files_of_windows_editors(folder):
    for name in ("good.json", "spec.toml"):
        (folder / f"bom-{name}").write_bytes(b"\xef\xbb\xbf" + (folder / name).read_bytes())
    assert run("sigmatau lot bom-good.json --spec bom-spec.toml") == 0


@pytest.mark.parametrize("place", ["--spec", "--json"])
def test_a_name_that_is_too_long_is_named(folder, place, capsys):
    words = ["lot", "good.json", "--spec", "a" * 300 + ".toml"]
    assert main(words if place == "--spec" else ["inspect", "good.json", "--json", "a" * 300]) in (1, 2)
    err = capsys.readouterr().err
    assert "standard output" not in err
    assert "aaa" in err or place == "--json"


def test_axes_that_are_missing_do_not_pass_as_decided(folder, contents, capsys):
    content = json.loads(contents["good"])
    for name in ("gyro_y", "gyro_z", "accel_y", "accel_z"):
        del content["channels"][name]
    (folder / "one.json").write_text(json.dumps(content))
    assert run("sigmatau lot one.json --spec spec.toml --undecided fail") == 3
    assert "accel_y, accel_z, gyro_y, gyro_z: in the datasheet, not in the result" in capsys.readouterr().out
    single = re.sub(r"^\[(gyro|accel)\].*$", r'[\1]\naxes = ["x"]', SPEC.partition("[accel_z]")[0], flags=re.MULTILINE)
    (folder / "single.toml").write_text(single, encoding="utf-8")
    assert run("sigmatau lot one.json --spec single.toml --undecided fail") == 0


def test_json_has_the_claims(folder, capsys):
    assert run("sigmatau lot good.json bad.json --spec spec.toml --json") == 3
    content = json.loads(capsys.readouterr().out)
    assert content["counts"]["failed"] == 1
    assert content["specification"]["name"] == "Unit 7"
    assert [unit["state"] for unit in content["units"]] == ["passed", "failed"]
    (walk,) = [
        c for c in content["units"][1]["claims"] if c["channel"] == "gyro_y" and c["claim"]["key"] == "random_walk"
    ]
    assert walk["readings"][0]["maximum"]["side"] == "above"


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("lot --spec spec.toml", 2, "name the logs or results"),
        ("lot good.json --spec nonesuch", 2, "unknown datasheet 'nonesuch'; known: adis16405"),
        ("lot good.json --spec none.toml", 1, "none.toml: No such file"),
        ("lot good.json --spec spec.toml --level 1.5", 2, "--level must"),
        ("lot good.json --spec spec.toml --factor 0.5", 2, "--factor must"),
        ("export log.csv --to kalibr", 1, "first sigmatau analyze log.csv --json log.json"),
        ("lot empty --spec spec.toml", 1, "empty: no log in this folder"),
        ("datasheet show", 2, "show needs a name"),
        ("datasheet show nonesuch", 2, "unknown datasheet"),
        ("datasheet show icm42688", 2, "unknown datasheet 'icm42688'; is icm42688p meant?"),
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
