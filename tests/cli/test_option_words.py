"""Command lines, without an analysis: which words belong to which option, and which rate belongs to which log."""

from pathlib import Path

import pytest

from sigmatau.analysis import AnalysisOptions
from sigmatau.cli import main
from sigmatau.cli.app import app
from sigmatau.cli.rates import assign_rates
from sigmatau.cli.reading import ReadingOptions, assign_readings
from sigmatau.cli.words import configured_logs, repeat_options, with_config
from sigmatau.errors import OptionError
from sigmatau.io.read.options import ReadOptions
from sigmatau.typed.config import arguments, from_toml, option_words, to_toml
from sigmatau.typed.pairs import key_numbers
from sigmatau.typed.rates import parse_rate

# Words behind the command, and the same with the option in front of each value.
LINES = {
    "unit": ("a.csv --unit gyro=deg/s accel=g", "a.csv --unit gyro=deg/s --unit accel=g"),
    "unit before the log": ("--unit gyro=deg/s accel=g a.csv", "--unit gyro=deg/s --unit accel=g a.csv"),
    "with =": ("a.csv --unit=gyro=deg/s accel=g", "a.csv --unit=gyro=deg/s --unit accel=g"),
    "comma and space": ("--unit gyro=deg/s,time=s accel=g a.csv", "--unit gyro=deg/s,time=s --unit accel=g a.csv"),
    "repeated": ("--unit gyro=deg/s --unit accel=g a.csv", "--unit gyro=deg/s --unit accel=g a.csv"),
    "channels": ("a.csv --channels time=1 gyro=2:4 -q", "a.csv --channels time=1 --channels gyro=2:4 -q"),
    "scale": ("a.csv --scale gyro=0.1 accel=0.01", "a.csv --scale gyro=0.1 --scale accel=0.01"),
    "offset": ("a.csv --offset gyro=1 accel=2", "a.csv --offset gyro=1 --offset accel=2"),
    "note": ("a.csv --note a=b c=d", "a.csv --note a=b --note c=d"),
    "rate by sensor": ("a.csv --rate gyro=400 accel=200", "a.csv --rate gyro=400 --rate accel=200"),
    "rate by order": ("a.csv b.csv --rate 10 50", "a.csv b.csv --rate 10 --rate 50"),
    "rate before logs": ("--rate 10 50 a.csv b.csv", "--rate 10 --rate 50 a.csv b.csv"),
    "rate of one log": ("a.csv --rate 10 50", "a.csv --rate 10 --rate 50"),
    "rate and unit": (
        "a.csv --rate 10 --unit gyro=deg/s accel=g --rate 5",
        "a.csv --rate 10 --unit gyro=deg/s --unit accel=g --rate 5",
    ),
    "export": ("a.csv --export kalibr=k.yaml px4=p", "a.csv --export kalibr=k.yaml --export px4=p"),
    "a log between": ("--unit gyro=deg/s a.csv accel=g", "--unit gyro=deg/s a.csv accel=g"),
    "a file of that name": ("a.csv --unit gyro=deg/s run=1.csv", "a.csv --unit gyro=deg/s run=1.csv"),
    "a number is a file": ("a.csv --rate 10 77", "a.csv --rate 10 77"),
    "number of another option": ("a.csv --unit gyro=deg/s 50", "a.csv --unit gyro=deg/s 50"),
    "option of one value": ("a.csv --window 0s:5s b=c", "a.csv --window 0s:5s b=c"),
    "flag": ("a.csv --unit gyro=deg/s --at-rest b=c", "a.csv --unit gyro=deg/s --at-rest b=c"),
    "behind --": ("--unit gyro=deg/s -- a=b", "--unit gyro=deg/s -- a=b"),
    "topics": ("a.csv --topic GYR ACC", "a.csv --topic GYR --topic ACC"),
    "topics before a log": ("--topic /imu/gyro /imu/accel run", "--topic /imu/gyro --topic /imu/accel run"),
    "a log behind a topic": ("--topic GYR a.csv logs/*", "--topic GYR a.csv logs/*"),
    "topic and unit": ("a.csv --topic GYR ACC --unit gyro=g", "a.csv --topic GYR --topic ACC --unit gyro=g"),
    "nothing to do": ("a.csv b.csv -q", "a.csv b.csv -q"),
}


@pytest.mark.parametrize("name", LINES)
def test_values_in_a_row(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for file in ("run=1.csv", "77", "run"):
        Path(file).write_text("")
    typed, repeated = LINES[name]
    assert repeat_options(app, ["analyze", *typed.split()]) == ["analyze", *repeated.split()]


@pytest.mark.parametrize("command", ["inspect", "psd", "deviation", "watch", "lot", "fleet"])
def test_every_command_that_reads_a_log(command):
    words = [command, "a.csv", "--unit", "gyro=deg/s", "accel=g", "--rate", "gyro=4", "accel=2"]
    repeated = [command, "a.csv", "--unit", "gyro=deg/s", "--unit", "accel=g", "--rate", "gyro=4", "--rate", "accel=2"]
    assert repeat_options(app, words) == repeated


def test_an_export_too():
    words = ["export", "m.toml", "--to", "vins", "--name", "topic=/a", "gravity=9.8"]
    assert repeat_options(app, words) == [*words[:-1], "--name", words[-1]]
    words = ["store", "add", "a=b", "c=d", "--store", "x"]  # options of a command in a command
    assert repeat_options(app, words) == words


@pytest.mark.parametrize(
    ("words", "rate"),
    [
        ([], None),
        (["100"], 100.0),
        (["1e2"], 100.0),
        (["gyro=400,accel=200"], {"gyro": 400.0, "accel": 200.0}),
        (["gyro=400", "accel=200"], {"gyro": 400.0, "accel": 200.0}),
        (["gyro=400", "gyro=400"], {"gyro": 400.0}),
    ],
)
def test_rate_of_a_log(words, rate):
    assert parse_rate(words) == rate
    assert ReadingOptions(rate=words).arguments()["rate"] == rate


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["10", "50"], "--rate 10 50: 2 rates for one log, as '50' is not a file"),
        (["10,50"], "2 rates for one log"),
        (["10", "gyro=50"], "one rate, or one for each sensor"),
        (["gyro=10", "gyro=50"], "'gyro' is given twice"),
        (["fast"], "'fast': must be a number without a unit"),
        (["gyro=fast"], "must be a number"),
        (["100Hz"], "must be a number without a unit"),
        (["=5"], "no log of this command has the name ''"),
        (["b.csv=5"], "no log of this command has the name 'b.csv'"),
        (["x/b=5"], "no log of this command has the name 'x/b'"),
    ],
)
def test_refused_rates(words, message):
    with pytest.raises(OptionError) as refused:
        parse_rate(words)
    assert message in refused.value.for_command_line()


A, B, C = Path("day/a.csv"), Path("day/b.csv"), Path("night/b.csv")


@pytest.mark.parametrize(
    ("words", "logs", "rates"),
    [
        ([], [A, B], [[], []]),
        (["10"], [A, B], [["10"], ["10"]]),
        (["10", "50"], [A, B], [["10"], ["50"]]),
        (["10,50"], [A, B], [["10"], ["50"]]),
        (["b.csv=50", "a.csv=10"], [A, B], [["10"], ["50"]]),
        (["day/b.csv=50", "10"], [A, B], [["10"], ["50"]]),
        (["10", "a.csv=5,b.csv=6"], [A, B], [["5"], ["6"]]),
        (["night/b.csv=50", "10"], [A, B, C], [["10"], ["10"], ["50"]]),
        (["gyro=400", "accel=200"], [A, B], [["gyro=400", "accel=200"]] * 2),
        (["gyro=400,accel=200", "b.csv=5"], [A, B], [["gyro=400", "accel=200"], ["5"]]),
    ],
)
def test_rates_of_logs(words, logs, rates):
    assert list(assign_rates(words, logs, logs).values()) == rates
    assert list(assign_readings(ReadingOptions(rate=words), logs, logs)) == logs


@pytest.mark.parametrize(
    ("words", "logs", "message"),
    [
        (["10", "50"], [A], "2 rates for one log"),
        (["10", "50"], [A, B, C], "2 numbers for 3 logs"),
        (["10", "50", "b.csv=3"], [A, B], "2 numbers for 2 logs"),
        (["b.csv=3"], [A, B, C], "2 logs have this name"),
        (["c.csv=3"], [A, B], "no log of this command has the name 'c.csv'"),
        (["a.csv=3", "a.csv=4"], [A, B], "given twice"),
        (["10", "gyro=5"], [A, B], "one rate, or one for each sensor"),
        (["a.csv=fast"], [A, B], "must be a number"),
    ],
)
def test_refused_rates_of_logs(words, logs, message):
    with pytest.raises(OptionError, match=message):
        assign_rates(words, logs, logs)


def test_a_folder_shows_no_order():
    with pytest.raises(OptionError, match=r"a folder does not show their order. Give a\.csv=HZ"):
        assign_rates(["10", "50"], [A, B], [Path("day")])


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("log.csv --rate 10 50", "--rate 10 50: 2 rates for one log, as '50' is not a file"),
        ("log.csv 50", "'50' is not a file. Write a rate directly behind --rate"),
        ("--unit gyro=deg/s log.csv accel=g", "'accel=g' is not a file. Write it directly behind its option"),
        ("log.csv log2.csv --rate 1 2 3", "3 numbers for 2 logs"),
        ("log.csv log2.csv --joint --rate 1 2 3", "3 numbers for 2 logs"),
    ],
)
def test_slips_are_no_logs(line, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for file in ("log.csv", "log2.csv"):
        Path(file).write_text("gyro_x [deg/s]\n" + "1\n2\n3\n4\n" * 9)
    for command in ("analyze", "lot"):
        if command == "analyze" or ("--joint" not in line and "log2" in line):
            assert main([command, *line.split()]) == 2
            assert message in capsys.readouterr().err


def test_each_log_at_its_rate(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for file in ("a.csv", "b.csv"):
        Path(file).write_text("gyro_x\n" + "1\n2\n4\n3\n" * 30)
    line = "analyze a.csv b.csv --unit gyro=deg/s --rate 10 50 --method read-off -q --at-rest"
    assert main(line.split()) == 0
    out = capsys.readouterr().out
    assert "10 Hz" in out.split("b.csv")[0]
    assert "50 Hz" in out.split("b.csv")[1]


@pytest.mark.parametrize(
    ("text", "number"), [("1/16.4", 1 / 16.4), ("1/131", 1 / 131), ("9.80665/2048", 9.80665 / 2048), ("-1e-3/2", -5e-4)]
)
def test_a_scale_may_be_a_quotient(text, number):
    assert key_numbers([f"gyro={text}"], "scale", "gyro=0.01") == {"gyro": pytest.approx(number, rel=1e-15)}


@pytest.mark.parametrize("text", ["1/0", "1/2/3", "1/", "/2", "1/nan", "a/2"])
def test_other_quotients_are_refused(text):
    with pytest.raises(OptionError, match="is not a number"):
        key_numbers([f"gyro={text}"], "scale", "gyro=0.01")


CONFIG = """
log = "log.csv"
window = "0s:50s"
unit = { gyro = "deg/s", accel = "g" }
leave-out = ["1s:2s", "3s:4s"]
terms = ["random_walk", "bias_instability"]
taus = [0.1, 1, 10]
at_rest = true
force = false
rate = 100
note = ["serial number=A 1"]
"""


def test_a_configuration_file_as_words_and_as_values():
    table, log = from_toml(CONFIG)
    assert log == "log.csv"
    words = option_words(table)
    assert words == [
        "--window", "0s:50s", "--unit", "gyro=deg/s,accel=g", "--leave-out", "1s:2s", "--leave-out", "3s:4s",
        "--terms", "random_walk,bias_instability", "--taus", "0.1,1,10", "--at-rest", "--rate", "100",
        "--note", "serial number=A 1",
    ]  # fmt: skip
    assert arguments(ReadOptions, table) == {"unit": {"gyro": "deg/s", "accel": "g"}, "rate": 100.0}
    assert arguments(AnalysisOptions, table) == {
        "window": "0s:50s", "leave_out": ["1s:2s", "3s:4s"], "terms": ["random_walk", "bias_instability"],
        "taus": [0.1, 1.0, 10.0], "at_rest": True,
    }  # fmt: skip
    assert from_toml(to_toml(table, log=log)) == ({k: v for k, v in table.items() if v is not False}, log)
    assert from_toml(to_toml({"note": {'a "b"\\': "\x7f\n\u2028é"}}))[0] == {"note": {'a "b"\\': "\x7f\n\u2028é"}}


@pytest.mark.parametrize("text", ["rate = nan", "unit = { gyro = inf }", "rate = 1e999", f"rate = {'9' * 5000}"])
def test_numbers_of_a_file_are_finite(text):
    with pytest.raises(OptionError, match="the configuration is not TOML"):
        from_toml(text)


def test_typed_options_replace_those_of_the_file(tmp_path):
    (tmp_path / "a.toml").write_text(CONFIG)
    words = with_config(["analyze", "x.csv", "--config", str(tmp_path / "a.toml"), "--window=1s:9s", "--rate", "50"])
    assert "0s:50s" not in words
    assert words.count("--rate") == 1
    assert "--at-rest" in words
    assert with_config(["inspect", "--config", "b.toml"]) == ["inspect", "--config", "b.toml"]
    assert configured_logs(tmp_path / "a.toml") == (tmp_path / "log.csv",)


@pytest.mark.parametrize(
    ("text", "message", "code"),
    [
        ("window = [", "not TOML", 2),
        ("nonsense = 1", "--nonsense", 2),
        ("log = 3", "must be the name of a file", 2),
        ("window = 1979-05-27", "a value must be", 2),
        (None, "cannot be read", 1),
    ],
)
def test_wrong_configuration_files(tmp_path, capsys, text, message, code):
    file = tmp_path / "a.toml"
    if text is not None:
        file.write_text(text)
    assert main(["analyze", "x.csv", "--config", str(file)]) == code
    assert message in capsys.readouterr().err
