"""The page as a file: one, small, without anything from elsewhere, and nothing from a log that is HTML."""

import json
import re
from html import unescape

import numpy as np
import pytest
from report_records import DATE, HOSTILE, signals, six_axes

import sigmatau as st
from sigmatau.cli import main
from sigmatau.errors import DataError, OptionError
from sigmatau.reporting.content import collect_content
from sigmatau.reporting.html import page as page_of
from sigmatau.reporting.markup import data, element, script, style

CSS = re.compile(r"--([a-z0-9-]+): (#[0-9a-f]{3,6})\b")


@pytest.fixture(scope="module")
def record():
    return six_axes()


@pytest.fixture(scope="module")
def analysis(record):
    return st.analyze(record)


@pytest.fixture(scope="module")
def page(record, analysis, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "six axes.html"
    st.report(analysis, path, record=record, command="sigmatau analyze x.csv", date=DATE)
    return path


def test_one_small_file(page):
    text = page.read_text(encoding="utf-8")
    assert len(text.encode()) < 500_000
    assert not re.search(r'(?:src|href)="(?!#|data:)', text)
    assert "@import" not in text
    assert not re.search(r"url\((?!data:|#)", text)
    assert "default-src 'none'" in unescape(text)
    uplot = text.split("var uPlot=")[0]
    assert "https://github.com/leeoniya/uPlot" in uplot
    assert "Permission is hereby granted" in uplot  # its licence goes with it


def test_the_same_report_twice_is_the_same_file(page, record, analysis, tmp_path):
    st.report(analysis, tmp_path / "again.html", record=record, command="sigmatau analyze x.csv", date=DATE)
    assert (tmp_path / "again.html").read_bytes() == page.read_bytes()


def test_numbers_of_the_table_stand_in_the_page(page, analysis):
    text = page.read_text(encoding="utf-8")
    for name, fitted in analysis.fits.items():
        assert f"<bdi>{name}</bdi>" in text
        value, interval, _ = fitted.texts("random_walk")[-1]
        assert f">{value}<" in text
        assert interval in text


def test_names_are_text(tmp_path):
    record = signals(HOSTILE.values())
    path = tmp_path / "x.html"
    st.report(st.analyze(record), path, record=record)
    text = path.read_text(encoding="utf-8")
    assert "<script>document" not in text
    assert len(re.findall(r"<script", text)) == len(re.findall(r"</script>", text)) == 2
    (inside,) = re.findall(r'<script type="application/json" id="charts">(.*?)</script>', text)
    charts = json.loads(inside)
    assert set(charts["channels"]) == set(HOSTILE.values())


def test_what_is_not_drawn_has_a_reason(record):
    rng = np.random.default_rng(22)
    x = rng.standard_normal(12_000)
    x[rng.random(len(x)) < 0.3] = np.nan
    holes = st.Record.from_arrays(rate=100.0, gyro_x=x)
    shown = page_of(collect_content(st.analyze(holes), holes))
    assert "Not drawn: no stretch of the record without missing samples is long enough." in shown
    assert " % of the samples missing, white noise lies up to 1.20 times above the model" in shown
    bare = page_of(collect_content(st.analyze(record, method="read-off"), None))
    assert bare.count("made without the samples of the record") == 3
    assert "where the fitted model says that its term is most of the" in bare
    assert "read off the curves" in bare


def test_elements():
    assert element("td", "a<b", class_='"x"') == '<td class="&quot;x&quot;">a&lt;b</td>'
    assert element("input", hidden=True, open=False) == "<input hidden>"
    assert "</script><" not in data(["</script><script>"], id_="x")
    with pytest.raises(ValueError, match="JSON compliant"):
        data([float("nan")], id_="x")
    for make in (script, style):
        with pytest.raises(ValueError, match="must not contain"):
            make("</SCRIPT></style>")


def test_other_endings(analysis, tmp_path):
    with pytest.raises(OptionError, match=r"must end in \.html or \.pdf"):
        st.report(analysis, tmp_path / "x.docx")
    with pytest.raises(DataError, match="no directory"):
        st.report(analysis, tmp_path / "none" / "x.html")
    assert list(tmp_path.iterdir()) == []


def _luminance(colour):
    colour = colour[1:] if len(colour) == 7 else "".join(2 * c for c in colour[1:])
    parts = np.array([int(colour[k : k + 2], 16) / 255 for k in (0, 2, 4)])
    linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def _contrast(a, b):
    low, high = sorted((_luminance(a), _luminance(b)))
    return (high + 0.05) / (low + 0.05)


def test_colours_can_be_read(page):
    """WCAG 2.1 AA: 4.5 in both themes, for names of lines in their colours too; the two definitions of the dark one are the
    same.
    """
    text = page.read_text(encoding="utf-8")
    light, system, dark = (dict(CSS.findall(part)) for part in re.findall(r":root[^{]*\{(.*?)\}", text, re.DOTALL)[:3])
    assert system == dark
    for theme in (light, dark):
        for ground in ("ground", "raised"):
            for ink in ("ink", "soft", "link", "guide", "poor", *(f"axis-{k}" for k in range(6))):
                assert _contrast(theme[ink], theme[ground]) >= 4.5, (ink, ground)
        for mark in ("good", "partial", "poor", "info"):
            assert _contrast(theme[mark], theme[f"{mark}-ground"]) >= 4.5, mark


@pytest.fixture
def log(tmp_path):
    x = np.random.default_rng(5).standard_normal((3000, 3)) * 1e-3
    np.savetxt(tmp_path / "a.csv", x, delimiter=",", header="gyro_x,gyro_y,gyro_z", comments="")
    return tmp_path / "a.csv"


OPTIONS = ["--rate", "50", "--unit", "gyro=rad/s"]


def test_command(log, tmp_path, capsys):
    out = tmp_path / "r.html"
    assert main(["analyze", str(log), *OPTIONS, "--report", str(out)]) == 0
    text = out.read_text(encoding="utf-8")
    assert "SHA-256" in text
    assert "a.csv – noise report" in text
    assert "--report" not in capsys.readouterr().err  # what was asked for is not offered
    assert main(["analyze", str(log), *OPTIONS]) == 0
    assert "--report r.html" in capsys.readouterr().err


def test_notes_of_the_user(log, tmp_path, capsys):
    out = tmp_path / "r.html"
    notes = ["--note", "serial number=A<1>, 2", "--note", "operator = N. N."]
    assert main(["analyze", str(log), *OPTIONS, "--report", str(out), *notes]) == 0
    text = out.read_text(encoding="utf-8")
    assert "<bdi>A&lt;1&gt;, 2</bdi>" in text
    assert "<bdi>operator</bdi>" in text
    assert main(["analyze", str(log), *OPTIONS, *notes]) == 2
    assert "--note needs --report" in capsys.readouterr().err
    assert main(["analyze", str(log), *OPTIONS, "--report", str(out), "--note", "A123"]) == 2
    assert "NAME=TEXT" in capsys.readouterr().err
