"""Every question of the page and its answer."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest
from workbench_logs import write_log, write_long

import sigmatau as st
from known import seed_of
from sigmatau import Analysis, analyze, read
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.typed.config import typable
from sigmatau.typed.forms import spelled

pytest_plugins = ["workbench_pages"]  # the fixtures


def test_about(page, folder):
    about = page.get("api/about").json()
    assert about["roots"] == [str(folder)]
    assert {"kalibr", "gtsam"} <= {target["name"] for target in about["targets"]}
    assert [term["slope"] for term in about["terms"]] == [-1, -0.5, 0, 0.5, 1]
    assert about["stages"][0] == "read"
    # The options of an export are those that are declared, and each target says what it has a use for.
    assert {each["name"] for each in about["choices"]} == {spelled(name) for name in typable(Choices)} - {"name"}
    targets = {target["name"]: target for target in about["targets"]}
    assert targets["kalibr"]["choices"]["axes"] == ["worst", "mean"]
    assert "step" not in targets["kalibr"]["choices"]
    assert targets["px4"]["choices"]["step"] is True
    assert "consistent" not in targets["gazebo"]["choices"]["rate-random-walk"]
    assert {each["key"]: each["default"] for each in targets["kalibr"]["names"]} == {"topic": "/imu0"}


def test_page_and_what_it_loads(page):
    assert page.get("").headers["content-type"].startswith("text/html")
    assert page.get("static/plot.js").headers["content-type"].startswith("text/javascript")
    assert page.get("static/uplot/uPlot.min.css").status_code == 200
    assert page.get("nothing").status_code == 404


def test_files(page, folder, tmp_path):
    (folder / "sub").mkdir(exist_ok=True)
    (folder / ".hidden.csv").write_text("x")
    (folder / "notes.md").write_text("x")
    entries = {entry["name"]: entry for entry in page.get("api/files", params={"path": str(folder)}).json()["entries"]}
    assert entries["static.csv"]["kind"] == "log"
    assert entries["static.csv"]["bytes"] == (folder / "static.csv").stat().st_size
    assert entries["sub"]["kind"] == "folder"
    assert not {".hidden.csv", "notes.md"} & set(entries)
    assert page.get("api/files").json()["entries"][0]["path"] == str(folder)
    above = page.get("api/files", params={"path": str(folder / "sub")}).json()
    assert above["parent"] == str(folder)


def test_open(page):
    opened = page.post("api/open", path=str(page.log)).json()
    assert (opened["kind"], opened["rows"], opened["rate_hz"], opened["duration_s"]) == ("log", 6000, 100.0, 60.0)
    assert opened["question"] is None
    time_column, *channels = opened["columns"]
    assert (time_column["role"], time_column["values"]) == ("time", [0.0, 0.01, 0.02, 0.03, 0.04])
    up = channels[-1]
    assert (up["role"], up["channel"], up["unit"], up["unit_how"]) == ("channel", "accel_z", "m/s^2", "stated")
    assert up["mean_si"] == pytest.approx(9.81, abs=0.01)
    assert up["peak_to_peak"] == pytest.approx(0.08, rel=0.3)
    assert (up["gaps"], up["missing"], len(up["spark"])) == (0, 0, 64)
    assert all(low <= high for low, high in up["spark"])
    assert [(mean["sensor"], mean["verdict"]) for mean in opened["means"]] == [("gyro", "offset"), ("accel", "gravity")]
    assert opened["command"] == f"sigmatau analyze {page.log}"


def test_open_with_options(page):
    opened = page.post(
        "api/open", path=str(page.log), options={"unit": {"gyro": "deg/s"}, "channels": "gyro=2:4"}
    ).json()
    columns = opened["columns"]
    assert [column["role"] for column in columns] == ["time", *["channel"] * 3, *["ignored"] * 3]
    assert (columns[1]["unit"], columns[1]["unit_how"], columns[1]["unit_si"]) == ("deg/s", "given", "rad/s")
    assert columns[4]["values"]
    assert opened["command"].endswith("--unit gyro=deg/s --channels gyro=2:4")


def test_a_log_without_names_asks(page, folder):
    log = write_log(folder / "headerless.csv", header=False)
    opened = page.post("api/open", path=str(log)).json()
    assert (opened["question"]["code"], opened["question"]["option"]) == ("option", "unit")
    assert opened["columns"][6]["channel"] == "accel_z"  # by gravity
    assert [len(column["values"]) for column in opened["columns"]] == [5] * 7
    assert all(len(column["spark"]) == 64 for column in opened["columns"])
    assert page.post("api/envelope", path=str(log)).status_code == 400
    chosen = {"channels": "time=1,gyro=2:4,accel=5:7", "unit": "time=s,gyro=rad/s,accel=m/s^2"}
    opened = page.post("api/open", path=str(log), options=chosen).json()
    assert opened["question"] is None
    assert opened["columns"][6]["channel"] == "accel_z"
    page_words = page.post("api/open", path=str(log)).json()["question"]
    assert "--" not in page_words["question"] + page_words["message"]
    assert page_words["question"].startswith("does not state the unit of gyro and accel. ")
    assert "deg/s rms" in page_words["hint"][0]["remark"]
    partial = page.post("api/open", path=str(log), options={"channels": "time=1,gyro=2:4"}).json()
    assert partial["question"]["option"] == "unit"
    assert partial["columns"][1]["channel"] == "gyro_x"
    assert partial["question"]["hint"]


def test_envelope(page):
    whole = page.post("api/envelope", path=str(page.log), width=100).json()
    assert (whole["start_s"], whole["end_s"], len(whole["channels"])) == (0.0, 60.0, 6)
    x = read(page.log).stream_of("gyro_y").column("gyro_y")
    drawn = whole["channels"]["gyro_y"]
    assert len(drawn["t"]) == 100
    assert (min(drawn["low"]), max(drawn["high"])) == pytest.approx((x.min(), x.max()), rel=1e-5)
    part = page.post("api/envelope", path=str(page.log), channel="gyro_y", from_s=10, to_s=20, width=4000).json()
    assert set(part["channels"]) == {"gyro_y"}
    assert part["channels"]["gyro_y"]["low"] == pytest.approx(x[1000:2000], rel=1e-5)
    assert part["channels"]["gyro_y"]["t"][0] == 10.0


@pytest.mark.parametrize(
    "body", [{"width": 0}, {"width": 10**9}, {"width": "x"}, {"from_s": "x"}, {"channel": "no"}, {"channel": 3}]
)
def test_wrong_envelopes(page, body):
    assert page.post("api/envelope", path=str(page.log), **body).status_code == 400


def test_analysis(page, result):
    answer = page.get(f"api/results/{result}").json()
    direct = analyze(read(page.log))
    assert answer["result"] == json.loads(direct.to_json())
    assert Analysis.from_dict(answer["result"]).fits
    assert answer["summary"]["headline"].startswith("6 axes")
    assert set(answer["charts"]["channels"]["gyro_x"]) == {"deviation"}
    assert answer["command"] == f"sigmatau analyze {page.log}"
    full = page.get(f"api/results/{result}/charts").json()
    assert {"deviation", "density", "series"} <= set(full["channels"]["gyro_x"])


def test_stages_are_in_order(page):
    state = page.ended(page.post("api/analyze", path=str(page.log)).json()["job"])
    assert [stage["name"] for stage in state["stages"]] == page.get("api/about").json()["stages"]
    assert all(stage["done"] for stage in state["stages"])
    assert sum(stage["seconds"] for stage in state["stages"]) <= state["elapsed_s"] + 0.01


def test_config_repeats_an_analysis_to_the_last_digit(page, tmp_path):
    options = {
        "window": "0s:50s", "leave_out": ["10s:11s", "20s:20.5s"], "terms": ["random_walk", "bias_instability"],
        "unit": {"gyro": "rad/s"}, "taus": "octave", "read_off_at": {"random_walk": "0.1s:1s"}, "keep": "spikes",
        "note": {"serial number": "A \"1\""},
    }  # fmt: skip
    done = page.analysed(options=options)
    (tmp_path / "session.toml").write_bytes(page.get(f"api/results/{done}/session.toml").content)
    command = [sys.executable, "-m", "sigmatau", "analyze", "--config", "session.toml", "--json", "again.json", "-q"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "again.json").read_bytes() == page.get(f"api/results/{done}/result.json").content
    shown = page.get(f"api/results/{done}").json()
    assert shown["options"] == options
    back = page.post("api/config", toml=shown["toml"]).json()
    assert back == {"options": options, "log": str(page.log), "target": None, "choices": {}}
    assert page.post("api/config", options=options, log=str(page.log)).json()["toml"] == shown["toml"]
    assert {span["why"] for span in shown["left_out"]} >= {"window", "left_out"}


def test_the_command_line_repeats_it_too(page, tmp_path):
    import shlex

    done = page.analysed(options={"window": "0s:50s", "method": "gls", "tau_min": 0.02, "at_rest": True})
    words = shlex.split(page.get(f"api/results/{done}").json()["command"])
    command = [sys.executable, "-m", *words, "--json", "again.json", "-q"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    assert (tmp_path / "again.json").read_bytes() == page.get(f"api/results/{done}/result.json").content


@pytest.mark.parametrize(
    ("options", "option"),
    [
        ({"nonsense": 1}, "nonsense"),
        ({"window": "from the start"}, "window"),
        ({"method": "guess"}, "method"),
        ({"at_rest": "yes"}, "at_rest"),
        ({"rate": "fast"}, "rate"),
        ({"skip": "x"}, "skip"),
        ({"unit": "rad/s"}, "unit"),
        ({"unit": {"gyro": ["rad/s"]}}, "config"),
    ],
)
def test_wrong_options(page, options, option):
    state = page.ended(page.post("api/analyze", path=str(page.log), options=options).json()["job"])
    assert (state["state"], state["error"]["code"], state["error"]["option"]) == ("failed", "option", option)


def test_read_off_by_hand(page, result):
    line = page.post(f"api/results/{result}/read-off", channel="gyro_x", term="random_walk", tau_s=0.5).json()
    assert line["refused"] is None
    assert line["value"] == pytest.approx(1e-4, rel=0.1)
    assert line["low"] < 1e-4 * 1.1
    assert line["relative_error"] > 0
    refused = page.post(f"api/results/{result}/read-off", channel="gyro_x", term="rate_ramp", from_s=0.1, to_s=1).json()
    assert refused["value"] is None
    assert "slope" in refused["refused"]
    forced = page.post(
        f"api/results/{result}/read-off", channel="gyro_x", term="rate_ramp", from_s=0.1, to_s=1, force=True
    ).json()
    assert forced["forced"]
    for wrong in ({"channel": "no"}, {"term": "no"}, {"tau_s": -1}, {"tau_s": None}, {"from_s": 5, "to_s": 1}):
        body = {"channel": "gyro_x", "term": "random_walk", "tau_s": 0.5} | ({"tau_s": None} if "to_s" in wrong else {})
        assert page.post(f"api/results/{result}/read-off", **body | wrong).status_code == 400, wrong


def test_export(page, result):
    made = page.post(
        "api/export", result=result, target="kalibr", choices={"rate_random_walk": "gyro=1e-6 rad/s/sqrt(s)"}
    )
    assert made.status_code == 200, made.text
    (file,) = made.json()["files"]
    assert "gyroscope_noise_density" in file["text"]
    assert made.json()["command"].startswith("sigmatau export result.json --to kalibr --rate-random-walk ")
    assert not any("--" in note["text"] + note["action"] for note in made.json()["warnings"])
    wrong = page.post("api/export", result=result, target="kalibr", choices={"nonsense": 1})
    assert wrong.status_code == 400
    assert page.post("api/export", result=result, target="nothing").status_code == 400
    assert page.post("api/export", result="nothing", target="kalibr").status_code == 404


def test_the_session_writes_the_file_that_was_shown(page, result, tmp_path):
    """A configuration with a target has its file with all choices, by the command line too."""
    choices = {"horizon": "10s", "noise-factor": {"gyro": 2}, "name": {"topic": "/imu1"}, "consistent": "bias"}
    shown = page.post("api/export", result=result, target="kalibr", choices=choices).json()
    stated = page.post("api/config", options={}, log=str(page.log), target="kalibr", choices=choices).json()
    assert stated["command"].endswith(
        "--export kalibr=kalibr.yaml --horizon 10s --noise-factor gyro=2 --name topic=/imu1 --consistent bias"
    )
    (tmp_path / "session.toml").write_text(stated["toml"], encoding="utf-8")
    assert (
        main(["analyze", "--config", str(tmp_path / "session.toml"), "--export", f"kalibr={tmp_path / 'k'}", "-q"]) == 0
    )
    assert (tmp_path / "k").read_text(encoding="utf-8") == shown["files"][0]["text"]
    back = page.post("api/config", toml=stated["toml"]).json()
    assert back == {"options": {}, "log": str(page.log), "target": "kalibr", "choices": choices}


def test_factors_over_the_sensor_at_rest(page, result):
    """With motors on, the file states the factors over the result at rest."""
    made = page.post("api/export", result=result, target="kalibr", inflate=result).json()
    assert "gyro_x over the record at rest: random walk x 1.00" in made["files"][0]["text"]
    assert made["command"].endswith("--inflate static.json -o kalibr.yaml")


def test_turn_on_biases_of_a_model_file(page, result, folder):
    """The model file of ``sigmatau compare --model``, as a file of the folders."""
    unit = st.NoiseModel(channels={f"gyro_{x}": {"random_walk": 1e-5} for x in "xyz"})
    unit = unit.with_turn_on({f"gyro_{x}": st.TurnOn(sigma=1.25e-3) for x in "xyz"})
    (folder / "unit.toml").write_text(unit.to_toml(), encoding="utf-8")
    made = page.post("api/export", result=result, target="okvis2", turn_on={"path": str(folder / "unit.toml")})
    assert made.status_code == 200, made.text
    assert "0.00125" in made.json()["files"][0]["text"]
    assert f"--turn-on {folder / 'unit.toml'} -o" in made.json()["command"]
    refused = page.post("api/export", result=result, target="okvis2", turn_on={"path": "/etc/passwd"})
    assert refused.status_code == 404


def test_a_report_to_print(page, result):
    pytest.importorskip("typst", reason="it sets the pages")
    assert page.get("api/about").json()["no_pdf"] == ""
    answer = page.get(f"api/results/{result}/report.pdf")
    assert (answer.content[:5], answer.headers["content-type"]) == (b"%PDF-", "application/pdf")


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        ("report.html", b"<!DOCTYPE html>"),
        ("curve.csv", b"channel,tau_s,adev"),
        ("coefficients.csv", b"channel,term,value"),
        ("result.json", b"{"),
        ("session.toml", b"# Options"),
        ("figure.svg", b"<?xml"),
        ("figure.png", b"\x89PNG"),
    ],
)
def test_downloads(page, result, name, begins):
    answer = page.get(f"api/results/{result}/{name}")
    assert answer.content.startswith(begins)
    assert answer.headers["content-disposition"].startswith("attachment;")


def test_a_result_is_opened(page, result, folder):
    (folder / "result.json").write_bytes(page.get(f"api/results/{result}/result.json").content)
    opened = page.post("api/open", path=str(folder / "result.json")).json()
    assert opened["kind"] == "result"
    answer = page.get(f"api/results/{opened['result']}").json()
    assert not answer["has_samples"]
    assert answer["result"] == page.get(f"api/results/{result}").json()["result"]
    assert page.get(f"api/results/{opened['result']}/charts").status_code == 409
    assert page.get(f"api/results/{opened['result']}/report.html").status_code == 200
    assert page.get(f"api/results/{opened['result']}/session.toml").status_code == 404
    assert page.post("api/export", result=opened["result"], target="ros").status_code == 200
    both = page.post("api/compare", results=[result, {"path": str(folder / "result.json")}])
    assert both.status_code == 200
    assert page.post("api/compare", results=[result, {"path": "/etc/passwd"}]).status_code == 404


def test_the_picture_is_the_same_after_the_analysis(page, folder):
    """It then comes from the process that analysed the log: the process that opened it has released the record."""
    log = str(write_log(folder / "pictured.csv"))
    asked = {"path": log, "from_s": 3.0, "to_s": 7.5, "width": 50}
    changed = {**asked, "options": {"unit": {"gyro": "deg/s"}}}
    before = [page.post("api/envelope", **body).json() for body in (asked, changed)]
    page.analysed(path=log)
    assert [page.post("api/envelope", **body).json() for body in (asked, changed, asked)] == [*before, before[0]]
    assert before[0]["channels"]["gyro_x"]["high"] != before[1]["channels"]["gyro_x"]["high"]


def test_compare(page, result, folder):
    log = write_log(folder / "another.csv")
    second = page.analysed(path=str(log))
    compared = page.post("api/compare", results=[result, second]).json()
    assert len(compared["curves"]) == len(compared["names"]) == 2
    assert compared["table"]["channel"]
    assert {each["verdict"] for each in compared["differences"] if each["term"] == "random_walk"} <= {"same", "differs"}
    assert not any(each["changed"] for each in compared["differences"])
    assert compared["command"].splitlines() == [
        f"sigmatau analyze {page.log} --json static.json",
        f"sigmatau analyze {log} --json another.json",
        "sigmatau compare static.json another.json",
    ]
    assert page.post("api/compare", results=[result]).status_code == 400
    assert page.post("api/compare", results=[result, "nothing"]).status_code == 404


def test_an_upload_is_analysed(page, client):
    answer = page.client.post(
        page.get("").url.copy_with(raw_path=page.get("").url.raw_path + b"api/upload?name=mine.csv"),
        content=page.log.read_bytes(),
    ).json()
    done = page.analysed(path=None, file=answer["file"])
    shown = page.get(f"api/results/{done}").json()
    assert shown["result"]["source"]["path"] == "mine.csv"
    expected = json.loads(analyze(read(page.log)).to_json())
    assert shown["result"]["channels"] == expected["channels"]
    assert shown["command"] == "sigmatau analyze mine.csv"
    page.delete(f"api/upload/{answer['file']}")
    assert page.post("api/open", file=answer["file"]).status_code == 404


def test_cancel(page, folder):
    """The process ends, and the next analysis has another one."""
    log = write_long(folder / "long.npy")
    job = page.post("api/analyze", path=str(log)).json()["job"]
    while page.get(f"api/jobs/{job}").json()["state"] == "waiting":
        time.sleep(0.01)
    began = time.perf_counter()
    assert page.delete(f"api/jobs/{job}").json()["state"] == "cancelled"
    assert time.perf_counter() - began < 1
    assert page.get(f"api/jobs/{job}").json()["result"] is None
    assert page.analysed()


def test_two_pages_at_once(page, folder):
    """The analysis of one does not keep the other from looking, nor from its own analysis."""
    log = write_long(folder / "long.npy")
    slow = page.post("api/analyze", path=str(log)).json()["job"]
    assert page.post("api/envelope", path=str(page.log)).status_code == 200
    quick = page.ended(page.post("api/analyze", path=str(page.log)).json()["job"])
    assert quick["state"] == "done"
    assert page.ended(slow)["state"] == "done"


def test_damaged_moving_and_missing_logs(page, folder):
    damaged = folder / "damaged.csv"
    text = write_log(damaged).read_text().splitlines()
    damaged.write_text("\n".join([*text[:4000], "12.3,what,is,this", *text[4001:]]))
    assert page.post("api/open", path=str(damaged)).status_code in (200, 422)
    moving = folder / "moving.csv"
    table = np.loadtxt(write_log(moving), delimiter=",", skiprows=1)
    table[:, 1:4] += np.sin(table[:, :1])
    np.savetxt(moving, table, delimiter=",", header=moving.read_text().splitlines()[0], comments="")
    done = page.get(f"api/results/{page.analysed(path=str(moving))}").json()
    assert done["result"]["rest"]["verdict"] != "at_rest"
    (folder / "empty.csv").write_text("")
    answer = page.post("api/open", path=str(folder / "empty.csv"))
    assert (answer.status_code, answer.json()["error"]["code"]) == (422, "data")
    assert page.post("api/open", path=str(folder / "nothing.csv")).status_code == 404


def test_a_worker_that_dies_is_replaced(page, workbench):
    job = workbench.jobs.find(page.post("api/analyze", path=str(page.log)).json()["job"])
    while job._worker is None:
        time.sleep(0.005)
    job._worker.end()
    assert page.ended(job.id)["state"] in ("failed", "done")
    assert page.analysed()


def test_a_look_that_takes_too_long_is_ended(page, workbench, monkeypatch):
    monkeypatch.setattr("sigmatau.app.routes._PATIENCE", 0.0)
    answer = page.post("api/open", path=str(page.log))
    assert (answer.status_code, answer.json()["error"]["code"]) == (500, "failed")
    monkeypatch.undo()
    assert page.post("api/open", path=str(page.log)).status_code == 200


def test_two_topics(page, folder):
    """The columns of both are shown, each with its channels; stamps have all digits."""
    stamps = 1_700_000_000_000_000_000 + np.arange(1000) * 10_000_000
    noise = np.random.default_rng(seed_of("two topics")).standard_normal((1000, 3)) * 1e-2
    header = "time [ns],kind,x,y,z"
    with (folder / "kinds.csv").open("w") as file:
        print(header, file=file)
        for stamp, (x, y, z) in zip(stamps, noise.tolist(), strict=True):
            print(f"{stamp},gyro,{x},{y},{z}", f"{stamp},accel,{x},{y},{z + 9.81}", sep="\n", file=file)
    opened = page.post("api/open", path=str(folder / "kinds.csv"), options={"unit": "gyro=rad/s,accel=m/s^2"}).json()
    channels = {
        column["channel"]: column["topic"] for column in opened["columns"] if column["channel"] not in (None, "time")
    }
    assert channels == {
        **{f"gyro_{axis}": "gyro" for axis in "xyz"},
        **{f"accel_{axis}": "accel" for axis in "xyz"},
    }
    assert opened["columns"][0]["values"][0] == int(float(stamps[0]))
    assert [topic["chosen"] for topic in opened["topics"]] == [True, True]


def test_gaps_of_one_column_are_remarked(page, folder):
    lines = write_log(folder / "gaps.csv").read_text().splitlines()
    for row in (100, 101, 500):
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:2], "", *cells[3:]])
    (folder / "gaps.csv").write_text("\n".join(lines))
    columns = page.post("api/open", path=str(folder / "gaps.csv")).json()["columns"]
    assert (columns[2]["missing"], columns[2]["gaps"]) == (3, 2)
    assert "missing" in columns[2]["remark"]
    assert columns[3]["remark"] is None
