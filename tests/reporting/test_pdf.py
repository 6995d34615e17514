"""The report as a PDF: its text, read back from the file, its pictures, and names that would be markup."""

import dataclasses
import importlib.util
import io
import re
import xml.etree.ElementTree as ET
from datetime import UTC, datetime

import numpy as np
import pytest

from known import seed_of
from reporting.pdf_text import pages_of
from sigmatau import Record, analyze
from sigmatau.plot import printed, svg
from sigmatau.reporting import pdf
from sigmatau.reporting.charts import packed, unpacked
from sigmatau.reporting.content import collect_content

SVG = "{http://www.w3.org/2000/svg}"
DATE = datetime(2026, 11, 23, 10, 30, tzinfo=UTC)
HOSTILE = (
    *('#import "x"', "$x^2$", "]", "<script>alert(1)</script>", "'\"`\\", "#panic()"),
    *("_x_*y*", "x^{3/2}", "// x", "😀", "a" * 10_000),
)
HEBREW, ARABIC = "שלום", "مرحبا"


def content(record, *, with_record=True, command=None, **options):
    return collect_content(analyze(record, **options), record if with_record else None, command=command, date=DATE)


def pages(given):
    return pages_of(pdf.typeset(pdf._template(), pdf._values(given), format="pdf", pretty=True))


def squeezed(text):
    return re.sub(r"[\s\u200b]", "", "".join(text))


def in_print(text):
    """A text as it is read back."""
    return squeezed(pdf._numbers(text)).replace("^{3/2}", "3/2").replace("^2", "2")


def noise(name, shape, size=1.0):
    return size * np.random.default_rng(seed_of(f"pdf {name}")).standard_normal(shape)


@pytest.fixture(scope="module")
def six():
    gyro, accel = noise("six gyro", (20_000, 3), 1e-3), noise("six accel", (20_000, 3), 1e-2) + np.array([0, 0, 9.81])
    gyro[7_000, 1] = 0.05
    gyro[12_000:12_400] = np.nan
    return content(
        Record.from_arrays(rate=100, gyro=gyro, accel=accel), command="sigmatau analyze six.csv --report r.pdf"
    )


def test_all_that_a_report_says_is_on_its_pages(six):
    found = pages(six)
    text = squeezed(found)
    assert "".join(map(in_print, six.overview.labels)) in text
    for sensor in six.overview.sensors:
        assert "".join(map(in_print, sensor.units)) in text
        for axis in sensor.axes:
            texts = [part for each in axis.coefficients for part in (each.value, each.interval)]
            assert "".join(map(in_print, [*texts, axis.trust])) in text
    for one in six.findings:
        assert in_print(one.message) in text
        assert in_print(one.action) in text
    for table in six.coefficients:
        assert in_print(table.verdict) in text
        for term, value, interval, unit in table.rows:
            row = (term, value, unit, interval) if unit else (term, interval)
            assert "".join(map(in_print, row)) in text
        for note in table.notes:
            assert in_print(note) in text
    for name, value in six.done:
        assert squeezed(name + value) in text
    for k, page in enumerate(found):
        assert f"{k + 1} of {len(found)}" in page
        assert "2026-11-23 10:30 UTC" in page
    for field in ("Checked by", "Signature", "Date"):
        assert field in found[0]


def test_warnings_come_before_notes(six):
    severities = {one.severity for one in six.findings}
    assert {"warning", "info"} <= severities
    words = [one["word"] for key in ("grave", "notes") for one in pdf._values(six)[key]]
    assert words == sorted(words, key=("Error", "Warning", "Note").index)
    text = squeezed(pages(six))
    at = {one.severity: text.index(in_print(one.message)) for one in reversed(six.findings)}
    assert at["warning"] < at["info"]


def test_many_notes_have_a_section_of_their_own(six):
    (note,) = [one for one in six.findings if one.severity == "info"][:1]
    many = [dataclasses.replace(note, message=f"note number {k}") for k in range(pdf._NOTES_AT_ONCE + 1)]
    found = pages(dataclasses.replace(six, findings=tuple(many)))
    assert "note number 0" not in found[0]
    told = re.search(
        r"(\d) notes on the record: page (\d)",
        squeezed(found[0]).replace("notesontherecord:page", " notes on the record: page "),
    )
    assert int(told.group(1)) == len(many)
    assert "note number 0" in found[int(told.group(2)) - 1]
    few = pages(dataclasses.replace(six, findings=tuple(many[:-1])))
    assert all(one.message in few[0] for one in many[:-1])


def test_the_same_content_gives_the_same_bytes(six):
    made = pdf.document(six)
    assert made == pdf.document(six)
    assert made.startswith(b"%PDF-")
    assert len(made) < 1_000_000
    assert set(re.findall(rb"D:\d+Z", made)) == {b"D:20261123103000Z"}


def test_names_are_text_and_never_markup():
    names = (*HOSTILE, HEBREW, ARABIC, "right\u202eleft")
    record = Record.from_arrays(rate=100, **{name: noise(name[:40], 4_000) for name in names})
    given = content(record, command="sigmatau analyze " + "/x" * 5_000)
    title, hostile_note = (
        '#let x = "' + "$" * 5_000,
        dataclasses.replace(_note(), message="#panic() $ ] <b>", axes="*a*"),
    )
    given = dataclasses.replace(given, title=title, findings=(hostile_note,))
    found = pages(given)
    text = squeezed(found)
    for name in HOSTILE[:-1]:
        assert text.count(squeezed(name)) >= 3, name  # in the overview, in legends and in the coefficients
    for name in (HEBREW, ARABIC):
        assert name[::-1] in text or name in text
    assert "a" * 26 + "…" + "a" * 13 in text
    assert "a" * pdf._MAX_FACT not in text
    assert "right\\u202eleft" in text
    assert "\u202e" not in text
    assert '#letx="$$' in text
    assert "*a*:#panic()$]<b>." in text
    assert "/x/x…/x/x" in text
    longest = max(len(line) for page in found for line in page.split("\n"))
    assert longest < 250  # a line of the smallest type across the page has fewer characters


def _note():
    y = noise("note", 4_000)
    y[100] = 50
    return content(Record.from_arrays(rate=100, gyro_x=y)).findings[0]


def test_a_sensor_that_moves():
    t = np.arange(20_000) / 100
    record = Record.from_arrays(rate=100, gyro=np.sin(t)[:, None] * [1, 2, 3] + noise("moving", (20_000, 3), 1e-3))
    given = content(record)
    assert given.verdict == "not_at_rest"
    found = pages(given)
    assert "Not at rest" in found[0]
    assert "No coefficients: the sensor is not at rest." in found[0]
    text = squeezed(found)
    assert "Residuals" not in text
    assert "Dashed" not in text
    assert "Timeseries" in text


def test_without_the_record_there_is_what_the_analysis_knows():
    record = Record.from_arrays(rate=100, gyro_x=noise("alone", 20_000))
    text = squeezed(pages(content(record, with_record=False)))
    assert "Allandeviation" in text
    assert "Residuals" in text
    assert "Timeseries" not in text
    assert "Powerspectraldensity" not in text
    assert "Stability" not in text


def test_the_terms_of_one_channel_have_symbols():
    record = Record.from_arrays(rate=100, gyro_x=noise("terms", 40_000) + np.cumsum(noise("terms walk", 40_000, 1e-3)))
    given = content(record)
    parts = given.charts["channels"]["gyro_x"]["deviation"]["parts"]
    (figure,) = pdf._values(given)["figures"]["deviation"]
    texts = [one.text for one in ET.fromstring(figure["svg"]).iter(f"{SVG}text")]
    assert {part.split(" ")[-1] for part in parts} <= set(texts)
    assert len(parts) >= 2


def test_thirty_channels():
    record = Record.from_arrays(rate=100, **{f"signal{k}": noise(f"thirty {k}", 2_000) for k in range(30)})
    given = content(record)
    made = pdf.document(given)
    assert len(made) < 500_000
    text = squeezed(pages(given))
    assert all(text.count(f"signal{k}") >= 4 for k in range(30))


def test_figures_are_drawn(six):
    from PIL import Image

    drawn = pdf.typeset(pdf._template(), pdf._values(six), format="png", ppi=72)
    for number, colours in ((0, 3), (1, 3)):
        image = np.asarray(Image.open(io.BytesIO(drawn[number])).convert("RGB")).astype(int)
        for colour in pdf.COLOURS[:colours]:
            wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
            assert (np.abs(image - wanted).max(axis=-1) < 48).sum() > 30, (number, colour)


def test_a_spike_and_what_was_left_out_show_in_the_time_series(six):
    spike = pdf._fewer(np.array([0.0, -1, 0, 0, 0]), np.array([0.0, 0, 9, 0, 0]), 2)
    assert [column.tolist() for column in spike] == [[-1, 0], [9, 0]]
    gyro, _ = pdf._values(six)["figures"]["series"]
    grey = [one for one in ET.fromstring(gyro["svg"]).iter(f"{SVG}rect") if one.get("fill") == "#c8cdd3"]
    left, width = (float(grey[0].get(key)) for key in ("x", "width"))
    frame = next(ET.fromstring(gyro["svg"]).iter(f"{SVG}clipPath"))[0]
    start, span = (float(frame.get(key)) for key in ("x", "width"))
    assert left == pytest.approx(start + span * 120 / 200, abs=0.5)  # missing from 120 s to 124 s of 200 s
    assert width == pytest.approx(span * 4 / 200, abs=0.5)


def test_without_typst_the_command_to_install_it_is_told(monkeypatch, six):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match=re.escape("a PDF report needs typst: pip install 'sigmatau[pdf]'")):
        pdf.document(six)


def test_packed_numbers_are_unpacked():
    given = np.append(noise("packed", 1000), np.nan)
    back = unpacked(packed(given))
    half = (np.nanmax(given) - np.nanmin(given)) / 65534 / 2
    assert np.nanmax(np.abs(back - given)) <= half * (1 + 1e-6)
    assert np.isnan(back[-1])
    assert np.isfinite(back[:-1]).all()
    assert unpacked(packed(np.full(3, 7.5))).tolist() == [7.5] * 3


@pytest.mark.parametrize(
    ("low", "high", "texts"),
    [
        (-2.1, 2.1, ["0.01", "0.1", "1", "10", "100"]),
        (-9.0, -6.0, ["10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶"]),
        (-12.0, 0.0, ["10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]),
        (np.log10(20), np.log10(600), ["20", "50", "100", "200", "500"]),
        (np.log10(0.88), np.log10(1.14), ["0.9", "0.95", "1", "1.05", "1.1"]),
        (np.log10(1.5e-8), np.log10(6e-8), ["2·10⁻⁸", "3·10⁻⁸", "4·10⁻⁸", "5·10⁻⁸", "6·10⁻⁸"]),
    ],
)
def test_numbers_at_a_logarithmic_axis(low, high, texts):
    major, minor = svg.log_ticks(low, high, 7)
    assert [text for _, text in major] == texts
    assert all(low - 1e-9 <= place <= high + 1e-9 for place in [*(place for place, _ in major), *minor])


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0, 7200, [0, 2000, 4000, 6000]),
        (-0.49, 0.49, [-0.4, -0.2, 0, 0.2, 0.4]),
        (3, 3, []),
        (1e9, 1e9 + 1, [1e9, 1e9 + 0.2, 1e9 + 0.4, 1e9 + 0.6, 1e9 + 0.8, 1e9 + 1]),
    ],
)
def test_even_ticks(low, high, ticks):
    assert svg.even_ticks(low, high, 7) == pytest.approx(ticks)


def test_a_line_is_drawn_through_its_points_and_interrupted():
    drawing = svg.Drawing(25.4 * 2, 25.4)
    axes = drawing.axes(0, 0, 25.4 * 2, 25.4)
    axes.log_x(0, 2)
    axes.log_y(0, 1)
    axes.line(np.array([0.0, 1, 1.2, 1.5, 2]), np.array([0.0, 0.5, np.nan, 0.5, 1]), "#000", 1)
    (path,) = ET.fromstring(drawing.svg()).iter(f"{SVG}path")
    assert path.get("d") == "M0.0 72.0L72.0 36.0M108.0 36.0L144.0 0.0"


def test_models_are_dashed_where_they_were_fitted_and_lines_have_triangles():
    tau = np.geomspace(0.01, 100, 41)
    adev = tau**-0.5
    curve = {"tau": tau, "adev": adev, "low": 0.9 * adev, "high": 1.1 * adev, "model": 1.05 * adev}
    drawn = ET.fromstring(printed.deviations([curve, curve], [(0.1, 10), (0.01, 100)], width=84, height=58))
    dashes = [path.get("stroke-dasharray") for path in drawn.iter(f"{SVG}path")]
    assert [dashes.count(one) for one in ("3.0 1.5", "0.6 1.2")] == [2, 1]
    dashed = next(path for path in drawn.iter(f"{SVG}path") if path.get("stroke-dasharray") == "3.0 1.5")
    assert dashed.get("d").count("M") + dashed.get("d").count("L") == 21  # two decades, ten steps each
    density = {"frequency": tau, **dict.fromkeys(("density", "low", "high", "model"), adev)}
    lines = [np.array([0.5, 2.0]), np.empty(0)]
    drawn = ET.fromstring(printed.densities([density, density], [np.inf, 1.0], lines, width=84, height=52))
    triangles = [path for path in drawn.iter(f"{SVG}path") if path.get("d").count("z") == 2]
    assert [path.get("fill") for path in triangles] == [pdf.COLOURS[0]]


def test_maps_are_coloured_where_the_noise_changes():
    times, tau = np.arange(5.0, 100, 5), np.array([0.1, 0.2, 0.4])
    adev = np.ones((19, 3))
    adev[10:14, 1] = 3
    adev[2] = np.nan
    found = printed.Map(times=times, tau=tau, window=10.0, adev=adev)
    drawn = ET.fromstring(printed.maps([found], 2.0, width=84))
    frame, *cells = (one.attrib for one in drawn.iter(f"{SVG}rect"))
    left, wide = float(frame["x"]), float(frame["width"])
    spans = {one["fill"]: (float(one["x"]), float(one["width"])) for one in cells}
    assert len(cells) == 2
    assert set(spans) == {printed.MAP_COLOURS[-1], "#c8cdd3"}
    assert spans[printed.MAP_COLOURS[-1]] == pytest.approx((left + wide * 52.5 / 100, wide * 20 / 100), abs=0.3)
    assert spans["#c8cdd3"] == pytest.approx((left + wide * 12.5 / 100, wide * 5 / 100), abs=0.3)
