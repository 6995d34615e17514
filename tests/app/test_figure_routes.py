"""Requests of the step in which the curves of a figure are clicked: pictures, curves, and what is refused."""

import json
import shlex
import struct
import zlib

import numpy as np
import pytest

pytest.importorskip("matplotlib")
pytest.importorskip("starlette")

from clicked_figures import Picture, covered, request, truths
from workbench_served import TOKEN

import sigmatau as st
from drawn_curves import drawn, pdf_file
from known import seed_of
from sigmatau.cli import main

pytest_plugins = ["workbench_pages"]  # the fixtures


@pytest.fixture(scope="module")
def figures(folder):
    place = folder / "figures"
    place.mkdir()
    return place


@pytest.fixture(scope="module")
def picture(figures):
    return Picture(figures / "gyro.png")


def png(width, height, *, damage=False):
    """A PNG file with a size, and no pixels."""
    data = b"\x89PNG\r\n\x1a\n"
    for kind, body in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IEND", b"")):
        data += struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body) + damage)
    return data


def error_of(answer, status):
    assert answer.status_code == status, answer.text
    return answer.json()["error"]


def test_the_kind_of_a_figure(page, figures, picture):
    entries = page.get("api/files", params={"path": str(figures)}).json()["entries"]
    assert {entry["name"]: entry["kind"] for entry in entries}["gyro.png"] == "figure"
    assert page.post("api/open", path=str(picture.path)).json()["kind"] == "figure"


@pytest.mark.parametrize(
    ("name", "media"),
    [("a.png", "image/png"), ("a.jpg", "image/jpeg"), ("a.webp", "image/webp"), ("a.gif", "image/gif")],
)
def test_a_picture_is_served_as_it_is(page, figures, name, media):
    path = Picture(figures / name).path
    assert page.post("api/figure", path=str(path)).json() == {
        "form": media.removeprefix("image/"), "width": 640, "height": 480, "lines": 0
    }  # fmt: skip
    answer = page.post("api/figure/picture", path=str(path))
    assert (answer.headers["content-type"], answer.content) == (media, path.read_bytes())
    assert answer.headers["x-content-type-options"] == "nosniff"


def test_vector_figures(page, figures):
    """A page of a PDF file is rendered; lines that are read without clicks are counted."""
    pytest.importorskip("pypdfium2")
    svg, pdf = drawn(figures / "texts.svg"), drawn(figures / "type42.pdf")
    facts = page.post("api/figure", path=str(svg)).json()
    assert (facts["form"], facts["lines"]) == ("svg", 1)
    assert facts["width"] / facts["height"] == pytest.approx(640 / 480, rel=0.01)
    assert page.post("api/figure/picture", path=str(svg)).headers["content-type"] == "image/svg+xml"
    assert page.post("api/figure", path=str(pdf)).json() == {"form": "pdf", "width": None, "height": None, "lines": 1}
    answer = page.post("api/figure/picture", path=str(pdf))
    assert answer.headers["content-type"] == "image/png"
    assert struct.unpack_from(">II", answer.content, 16) == pytest.approx((1920, 1440), abs=2)  # 300 dpi
    (figures / "scan.pdf").write_bytes(pdf_file(b"q 9 0 0 9 0 0 cm BI /W 1/H 1/CS/G/BPC 8 ID a EI Q"))
    assert page.post("api/figure", path=str(figures / "scan.pdf")).json()["lines"] == 0
    error = error_of(page.post("api/figure/picture", path=str(pdf), page=3), 400)
    assert (error["option"], error["hint"][0]["option"]) == ("page", "page")


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("huge.png", png(60_000, 60_000), "has 60000 × 60000 pixels, above 60 million. Cut out the figure"),
        ("empty.png", png(0, 5), "has no width or height"),
        ("checksum.png", png(5, 5, damage=True), "is damaged. Download it, or save it again"),
        ("cut.png", png(5, 5)[:30], "is damaged"),
        ("cut.jpg", b"\xff\xd8\xff\xe0\x00\x10JFIF", "is damaged"),
        ("cut.gif", b"GIF89a\x01", "is damaged"),
        ("cut.webp", b"RIFF\0\0\0\0WEBPVP8X", "is damaged"),
        ("text.png", b"tau,adev\n1,2\n", "is not a picture that a browser shows. Save it as PNG"),
        ("photo.png", b"BM\0\0\0\0", "is not a picture that a browser shows"),
        ("page.svg", b"<html/>", "is XML, but not SVG"),
        ("empty.pdf", b"%PDF-1.4\nnothing", "is damaged, or is not a PDF file"),
    ],
)
def test_files_that_are_no_picture(page, figures, name, data, message):
    if name.endswith("pdf"):
        pytest.importorskip("pypdfium2")
    (figures / name).write_bytes(data)
    for path in ("api/figure/picture", *(["api/figure"] if not name.endswith("pdf") else [])):
        assert message in error_of(page.post(path, path=str(figures / name)), 422)["message"]


def test_pictures_outside_of_the_folders_are_refused(page, tmp_path):
    (tmp_path / "a.png").write_bytes(png(5, 5))
    assert error_of(page.post("api/figure/picture", path=str(tmp_path / "a.png")), 404)["code"] == "missing"


def test_the_curve_is_that_of_the_command(page, picture, tmp_path, capsys, monkeypatch):
    """The page saves the table, and shows the command: both give the same text and the same model."""
    answer = page.post("api/figure/curves", **request(picture, rng=np.random.default_rng(seed_of("command")))).json()
    (channel,) = answer["channels"]
    assert covered(channel["table"]["rows"]) == dict.fromkeys(truths(), True)
    assert channel["off"] == []
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clicks.csv").write_text(answer["csv"])
    assert main(shlex.split(answer["command"])[1:]) == 0
    out, _ = capsys.readouterr()
    assert out.rstrip("\n") == answer["text"]
    assert (tmp_path / "figure.toml").read_text() == answer["model"]
    # The line of the model lies on the curve, in the coordinates of the picture.
    places = np.array(picture.points(200))
    x, y = np.array(channel["x"]), np.array(channel["y"])
    assert y == pytest.approx(np.interp(x, *places.T), abs=3)
    assert np.all(np.array(channel["high"]) < y)
    assert np.all(y < np.array(channel["low"]))


def test_several_curves_with_all_options(page, picture, tmp_path, capsys, monkeypatch):
    body = request(picture, rate=100, hours=24, point_error=0.7, content="variance")
    points = body["curves"][0]["points"]
    curves = [{"name": "gyro_x", "points": points}, {"name": "gyro_y", "points": [[x + 0.5, y - 9] for x, y in points]}]
    answer = page.post("api/figure/curves", **body | {"curves": curves}).json()
    assert [channel["name"] for channel in answer["channels"]] == ["gyro_x", "gyro_y"]
    assert answer["length_s"] is None
    assert "--columns x=1,gyro_x=2,gyro_y=3" in answer["command"]
    assert answer["csv"].splitlines()[0] == "x,gyro_x,gyro_y"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clicks.csv").write_text(answer["csv"])
    assert main(shlex.split(answer["command"])[1:]) == 0
    assert capsys.readouterr()[0].rstrip("\n") == answer["text"]
    # The variance of the first curve is its deviation in the figure.
    axes = {f"{way}_axis": {round(place, 2): float(text) for place, text in body[f"{way}_axis"]} for way in "xy"}
    read = st.read_figure("clicks.csv", unit="deg/h", content="variance", columns={"x": "1", "gyro_x": "2"}, **axes)
    assert 3600 * np.degrees(read["gyro_x"].adev[0]) == pytest.approx(np.sqrt(180.7), rel=0.02)


def test_a_wrong_click_is_marked(page, picture):
    body = request(picture, rng=np.random.default_rng(seed_of("wrong click")))
    body["curves"][0]["points"][7][1] -= 12
    assert page.post("api/figure/curves", **body).json()["channels"][0]["off"] == [7]


def test_a_wrong_unit_has_a_note(page, picture):
    """deg/h that are clicked as deg/s have more noise than any gyro."""
    for unit, is_doubted in (("deg/s", True), ("deg/h", False)):
        answer = page.post("api/figure/curves", **request(picture) | {"unit": unit}).json()
        (channel,) = answer["channels"]
        assert any("noisiest gyros" in note for note in channel["table"]["notes"]) == is_doubted


def test_points_that_are_too_few_for_a_fit(page, picture):
    """The last ones are above a third of the shortest record."""
    (channel,) = page.post("api/figure/curves", **request(picture, count=8)).json()["channels"]
    assert "no fit: only" in channel["table"]["verdict"]
    assert "Click further points" in channel["table"]["notes"][0]


def axis(*ticks):
    return [list(tick) for tick in ticks]


POINTS = [[100 + 20 * k, 100 + 5 * k] for k in range(12)]


@pytest.mark.parametrize(
    ("changes", "status", "message"),
    [
        ({"y_axis": axis((400, "0"), (50, "1000"))}, 400, "a logarithmic axis has no value 0"),
        ({"y_axis": axis((400, "-1"), (50, "1000"))}, 400, "a logarithmic axis has no value -1"),
        ({"x_axis": axis((80, "10"), (500, "10"))}, 400, "the values neither rise nor fall"),
        ({"x_axis": axis((80, "0.1"), (80.4, "10"))}, 400, "two ticks of the x axis are at the same place"),
        ({"x_axis": axis((80, "10"), (500, "0.1"))}, 400, "values of the x axis, 10, 0.1, do not rise to the right"),
        ({"y_axis": axis((50, "1"), (400, "1000"))}, 400, "do not rise upwards"),
        ({"x_axis": axis((80, ""), (500, "10"))}, 400, "the value of a tick of the x axis is empty"),
        ({"x_axis": axis((80, "ten"), (500, "10"))}, 400, "is 'ten'. Write a number, e.g. 0.01 or 1e-2"),
        ({"x_axis": axis((80, "10m"), (500, "10"))}, 400, "'10m' is not clear on the x axis"),
        ({"y_axis": axis((400, "1 s"), (50, "1000"))}, 400, "'1 s' is not clear on the y axis"),
        ({"x_axis": axis((80, "1"))}, 400, "the x axis needs two ticks"),
        ({"x_axis": axis((None, "1"), (500, "10"))}, 400, "Click it again"),
        ({"curves": []}, 400, "there are no clicked points"),
        ({"curves": [{"name": "", "points": POINTS[:1]}]}, 422, "clicks.csv: has 1 points. Click 8 or more"),
        (
            {"curves": [{"name": "a", "points": POINTS}, {"name": "b", "points": POINTS[:3]}]},
            422,
            "has 3 points of b. Click 8 or more",
        ),
        ({"curves": [{"name": "", "points": [[1, None], *POINTS]}]}, 400, "must be pairs of numbers"),
        ({"curves": [{"name": "", "points": [[1e300, 1], *POINTS]}]}, 400, "must be pairs of numbers"),
        ({"curves": [{"name": "", "points": [POINTS[0], *POINTS]}]}, 422, "has two points at x = 100"),
        ({"curves": [{"name": "", "points": POINTS}, {"name": "a", "points": POINTS}]}, 400, "curves needs a name"),
        ({"curves": [{"name": "a", "points": POINTS}, {"name": "a", "points": POINTS}]}, 400, "called 'a'"),
        ({"curves": [{"name": "a=1,b", "points": POINTS}]}, 400, "the name 'a=1,b' of a curve is not possible"),
        ({"curves": [{"name": "x", "points": POINTS}]}, 400, "the name 'x' of a curve is not possible"),
        ({"curves": [{"name": "", "points": [[k, 50] for k in range(6000)]}]}, 400, "more than 5000 points"),
        ({"unit": ""}, 400, "of the y axis is missing"),
        ({"unit": "deg/sqrt(h)"}, 400, "is not the unit of a rate"),
        ({"unit": 3}, 400, "must be a text"),
        ({"point_error": 0}, 400, "“Clicking error” must be a positive number"),
        ({"rate": "fast"}, 400, "“Sampling rate [Hz]” must be a positive number"),
        ({"hours": -1}, 400, "“Length of the record [h]” must be a positive number"),
        ({"hours": 1e-3}, 422, "above half of the record. Correct its length"),
        ({"linear": "z"}, 400, "must be one of x, y, xy"),
        ({"content": "power"}, 400, "must be one of deviation, variance"),
        ({"linear": "x", "x_axis": axis((150, "1"), (500, "10"))}, 422, "values that are not positive"),
    ],
)
def test_clicks_that_cannot_be_used(page, changes, status, message):
    body = {
        "curves": [{"name": "", "points": POINTS}],
        "x_axis": axis((80, "0.01"), (500, "1000")),
        "y_axis": axis((400, "1"), (50, "1000")),
        "unit": "deg/h",
    }
    assert page.post("api/figure/curves", **body).status_code == 200
    assert message in error_of(page.post("api/figure/curves", **body | changes), status)["message"]


def test_numbers_that_are_not_finite_are_no_json(page, client):
    body = json.dumps({"curves": [{"name": "", "points": [[float("nan"), 1.0]]}]})
    answer = client.post(f"/{TOKEN}/api/figure/curves", content=body, headers={"Content-Type": "application/json"})
    assert error_of(answer, 400)["message"] == "the body is not JSON"
