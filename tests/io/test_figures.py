"""`read_figure`: lines, axes and labels of SVG and PDF files, and what is uncertain in them."""

import re
from itertools import pairwise

import numpy as np
import pytest

import sigmatau as st
from conftest import skip_without
from drawn_curves import (
    DEGREES_PER_HOUR,
    FORMATS,
    TERMS,
    TRUTH,
    by_hand,
    deviation,
    drawn,
    figure,
    pdf_file,
    saved,
    times,
)
from sigmatau.io.read.figure.labels import parse_number
from sigmatau.io.read.figure.svg import transform

skip_without("matplotlib", "draws the figures")
skip_without("pypdfium2", "reads PDF files")

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">{}</svg>'
PARABOLA = "M0 0" + "".join(f"L{k} {k * k / 30 + 1}" for k in range(1, 30))


def read(path, **options):
    (curve,) = st.read_figure(path, unit="deg/h", **options).values()
    return curve


def written(path, text):
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", FORMATS)
def test_the_curve_is_that_of_the_figure(tmp_path, name):
    """To the resolution of the coordinates, 1e-6 of the page: the labels are those of the ticks."""
    curve = read(drawn(tmp_path / name))
    assert len(curve.tau) >= 30
    assert curve.tau[0] == pytest.approx(0.01, rel=1e-4)
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=3e-3)  # interpolated between points of the line
    assert st.fit(curve, terms=TERMS)["random_walk"].value == pytest.approx(TRUTH["random_walk"], rel=3e-3)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("texts.svg", {"grid": False}),
        ("type3.pdf", {"grid": False}),
        ("paths.svg", {"size": (3.3, 2.6)}),
        ("type42.pdf", {"size": (3.3, 2.6)}),
        ("texts.svg", {"size": (11.0, 3.0)}),
        ("type42.pdf", {"size": (11.0, 3.0)}),
    ],
    ids=str,
)
def test_styles_of_figures(tmp_path, name, options):
    curve = read(drawn(tmp_path / name, **options))
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=3e-3)


def test_a_figure_of_another_program(tmp_path):
    curve = read(by_hand(tmp_path / "hand.svg"))
    # The smooth line between the points of a model differs from it by 0.2 %.
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=4e-3)


GNUPLOT = """\
<svg width="600" height="480" viewBox="0 0 600 480" xmlns="http://www.w3.org/2000/svg">
<g fill="none" color="black" stroke="currentColor" stroke-width="1.00">{}
<g color="#9400D3"><path stroke='rgb(148, 0, 211)' d='{}'/></g></g></svg>
"""


def test_a_figure_of_gnuplot(tmp_path):
    """Anchors of groups, texts without a place, superscripts by shifts of the baseline, ticks at both ends in one path."""
    text = '<g transform="translate({},{})" fill="black" font-size="12" text-anchor="{}"><text><tspan>{}</tspan></text></g>'
    axes = ""
    for k in range(3):
        x, y = 80 + 125 * k, 400 - 100 * k
        label = f'10</tspan><tspan font-size="9.6" dy="-6.00px">{2 * k - 2}'
        axes += f"<path d='M80,{y} L89,{y} M580,{y} L571,{y}'/>" + text.format(71.3, y + 3.9, "end", f" {10**k}")
        axes += f"<path d='M{x},400 L{x},391'/>" + text.format(x, 421.9, "middle", label)
    tau = np.geomspace(0.01, 100, 30)
    x, y = 80 + 62.5 * (np.log10(tau) + 2), 400 - 100 * np.log10(DEGREES_PER_HOUR * deviation(tau))
    line = "M" + " L".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    curve = read(written(tmp_path / "gnuplot.svg", GNUPLOT.format(axes, line)))
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=6e-3)


def test_lines_are_selected_by_number_or_colour(tmp_path):
    result, axes = figure()
    for factor, color in ((1, "red"), (2, "#00ff00"), (3, "red")):
        axes.plot(times(), factor * DEGREES_PER_HOUR * deviation(times()), color=color)
    path = saved(result, tmp_path / "texts.svg")
    with pytest.raises(st.OptionError, match=r"has 3 lines: 1 #ff0000 \(43 points\), 2 #00ff00"):
        read(path)
    assert read(path, line="#00FF00").adev == pytest.approx(2 * deviation(read(path, line=2).tau), rel=3e-3)
    with pytest.raises(st.OptionError, match="2 lines are '#ff0000'"):
        read(path, line="#ff0000")
    with pytest.raises(st.OptionError, match="no line is '4'"):
        read(path, line="4")
    both = st.read_figure(path, unit="deg/h", line={"gyro_x": 1, "gyro_y": 3})
    assert both["gyro_y"].adev == pytest.approx(3 * both["gyro_x"].adev, rel=1e-4)


def test_figures_side_by_side_have_their_axes(tmp_path):
    from matplotlib.figure import Figure

    for name in ("texts.svg", "type42.pdf"):
        result = Figure(figsize=(9, 8))
        for k, axes in enumerate(result.subplots(2, 2).ravel()):
            axes.loglog(times(), 10**k * DEGREES_PER_HOUR * deviation(times()))
        path = saved(result, tmp_path / name)
        for k in range(4):
            curve = read(path, line=k + 1)
            assert curve.adev == pytest.approx(10**k * deviation(curve.tau), rel=3e-3)


def test_linear_axes_and_markers(tmp_path):
    result, axes = figure()
    axes.plot(times(), DEGREES_PER_HOUR * deviation(times()), "s")
    axes.set(yscale="linear", ylim=(0, None))
    curve = read(saved(result, tmp_path / "type42.pdf"))
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=5e-3)


def test_a_line_is_read_where_it_is_visible(tmp_path):
    for name in FORMATS:
        result, axes = figure()
        axes.plot(times(), DEGREES_PER_HOUR * deviation(times()))
        axes.set(xlim=(0.1, 100), ylim=(5, 60))
        curve = read(saved(result, tmp_path / name))
        assert 0.099 < curve.tau[0] < 0.2
        assert 70 < curve.tau[-1] <= 101
        assert curve.adev == pytest.approx(deviation(curve.tau), rel=3e-3)


def test_stated_axes(tmp_path):
    """With the coordinates of the drawing by hand, in the place of its labels."""
    path = by_hand(tmp_path / "hand.svg", x=(), y=())
    with pytest.raises(st.OptionError, match="x axis has no labels beside ticks, letters may be outlines"):
        read(path)
    axes = {"x_axis": {60: 0.01, 560: 1000}, "y_axis": {320: 1, 20: 1000}}
    curve = read(path, **axes)
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=4e-3)
    with pytest.raises(st.OptionError, match="a logarithmic axis has no value 0"):
        read(path, **axes | {"y_axis": {320: 0, 20: 1000}})
    with pytest.raises(st.OptionError, match="do not rise to the right"):
        read(path, **axes | {"x_axis": {560: 0.01, 60: 1000}})
    with pytest.raises(st.OptionError, match="neither rise nor fall"):
        read(path, **axes | {"x_axis": {60: 0.01, 300: 5, 560: 1}})
    linear = read(path, **axes | {"y_axis": {320: 1, 20: 1000}}, linear="y")
    assert linear.adev[0] * DEGREES_PER_HOUR == pytest.approx(1 + 999 * (np.log10(180) / 3), rel=0.01)


def test_a_variance(tmp_path):
    result, axes = figure()
    axes.plot(times(), (DEGREES_PER_HOUR * deviation(times())) ** 2)
    path = saved(result, tmp_path / "texts.svg")
    curve = read(path, content="variance")
    assert curve.adev == pytest.approx(deviation(curve.tau), rel=3e-3)
    assert np.diag(read(path).digitising)[:3] == pytest.approx(4 * np.diag(curve.digitising)[:3])


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ({"x": ("1000", "100", "10", "1", "0.1", "0.01")}, "values of its x axis fall to the right: 1000, 100"),
        ({"y": ("1000", "100", "10", "1")}, "values of its y axis fall upwards"),
        ({"x": ("0", "0.1", "1", "10", "100", "1000")}, "x axis has no labels beside ticks, numbers in it: "),
        ({"x": ("0.01", "0.1", "1", "20", "100", "1000")}, "x axis has no labels beside ticks, numbers in it: "),
        ({"x": ("0.01", "0.1")}, "x axis has no labels beside ticks"),
        ({"y": ("a", "b", "c", "d")}, "y axis has no labels beside ticks, numbers in it: 0.01, 0.1"),
        ({"rest": '<text x="200" y="316" class="lb" text-anchor="middle">3</text>'}, "x axis"),
    ],
)
def test_uncertain_axes_are_asked_for(tmp_path, labels, message):
    with pytest.raises(st.OptionError, match=re.escape(message)):
        read(by_hand(tmp_path / "hand.svg", **labels))


@pytest.mark.parametrize(("name", "title"), [("paths.svg", "τ [h]"), ("type3.pdf", "averaging time (min)")])
def test_times_that_are_not_in_seconds(tmp_path, name, title):
    result, axes = figure()
    axes.plot(times(), DEGREES_PER_HOUR * deviation(times()))
    axes.set_xlabel(title)
    unit = title.rstrip("])").rpartition("[")[2].rpartition("(")[2]
    with pytest.raises(st.OptionError, match=f"has an x axis in {unit}"):
        read(saved(result, tmp_path / name))


def test_two_y_axes_are_asked_for(tmp_path):
    result, axes = figure()
    axes.plot(times(), DEGREES_PER_HOUR * deviation(times()))
    axes.twinx().set(yscale="log", ylim=(1e-3, 1))
    with pytest.raises(st.OptionError, match="it has two y axes"):
        read(saved(result, tmp_path / "texts.svg"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<", "is damaged: unclosed token in line 1"),
        ("<html/>", "is XML, but not SVG"),
        ('<!DOCTYPE svg [<!ENTITY a "h"><!ENTITY b "&a;&a;">]><svg>&b;</svg>', "defines entities"),
        ('<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg>&a;</svg>', "defines entities"),
        (SVG.format("<g>" * 300 + "</g>" * 300), "has too many paths"),
        (SVG.format('<g id="a"><use href="#a"/></g>'), "has too many paths"),
        (SVG.format('<image href="a.png"/>'), "has a picture of pixels, and no line"),
        (SVG.format('<path stroke="red" d="M0 0 L1 nan L 2 2L1e400 3L4 4"/>'), "has no line that can be a curve"),
        (SVG.format(f'<path stroke="red" d="{PARABOLA}Z"/>'), "has no line that can be a curve"),
        *(
            (SVG.format(f'<path stroke="red" {hidden} d="{PARABOLA}"/>'), "has no line that can be a curve")
            for hidden in ('display="none"', 'opacity="0"', 'visibility="hidden"', 'style="stroke:none"')
        ),
    ],
)
def test_svg_files_without_a_curve(tmp_path, text, message):
    with pytest.raises(st.DataError, match=message):
        read(written(tmp_path / "f.svg", text))


def test_references_are_not_expanded_without_end(tmp_path):
    groups = '<g id="a0"><path d="M0 0L1 1"/></g>'
    groups += "".join(f'<g id="a{k + 1}">' + f'<use href="#a{k}"/>' * 10 + "</g>" for k in range(9))
    with pytest.raises(st.DataError, match="has too many paths"):
        read(written(tmp_path / "f.svg", SVG.format(groups)))


def test_use_symbols_and_parts_of_a_line(tmp_path):
    """A line in three parts, inside a symbol that is moved; the curve is that of the file by hand."""
    path = by_hand(tmp_path / "hand.svg")
    expected = read(path).adev
    text = path.read_text()
    whole = re.search(r'<path class="st0"[^>]*/>', text)[0]
    text = text.replace(whole, '<use href="#line" x="-20" y="10"/>')
    moved = f'<defs><symbol id="line"><g transform="translate(20 -10)">{whole}</g></symbol></defs>'
    path.write_text(text.replace("<style>", moved + "<style>"))
    assert read(path).adev == pytest.approx(expected, rel=1e-9)
    curve = "M0 140" + "".join(f"L{40 * k} {140 + 15 * k}" for k in range(1, 13))
    points = re.findall(r"[ML](\d+ \d+)", curve)
    parts = "".join(f"M{a}L{b}" for a, b in pairwise(points))
    whole, divided = (read(by_hand(tmp_path / "parts.svg", curve=each)).adev for each in (curve, parts))
    assert np.array_equal(whole, divided)


@pytest.mark.parametrize(
    ("text", "point"),
    [
        ("translate(2,3)", (3, 5)),
        ("scale(2) translate(1)", (4, 4)),
        ("rotate(90)", (-2, 1)),
        ("rotate(90 1 1)", (0, 1)),
        ("matrix(1 0 0 -1 0 10)", (1, 8)),
        ("skewX(45)", (3, 2)),
    ],
)
def test_transforms(text, point):
    """Of the point (1, 2)."""
    a, b, c, d, e, f = transform(text)
    assert (a + 2 * c + e, b + 2 * d + f) == pytest.approx(point)


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("0.01", (0.01, False)),
        ("10^−2", (0.01, True)),
        ("10⁻²", (0.01, True)),
        ("10-2", (0.01, True)),
        ("1E-2", (0.01, False)),
        ("2×10^3", (2000.0, True)),
        (r"2\times10^3", (2000.0, True)),
        ("0,01", (0.01, False)),
        ("1,000", (1000.0, False)),
        ("102", (102.0, False)),
        ("τ", None),
        ("10^", None),
        ("1.2.3", None),
    ],
)
def test_numbers_of_labels(text, number):
    assert parse_number(text) == (None if number is None else (pytest.approx(number[0]), number[1]))


ENCRYPTED = b"/ID[<00><00>]/Encrypt<</Filter/Standard/V 1/R 2/O<" + b"41" * 32 + b">/U<" + b"42" * 32 + b">/P -4>>"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"%PDF-1.4\nnothing", "is damaged, or is not a PDF file"),
        (pdf_file(b"0 0 m 9 9 l S", trailer=ENCRYPTED), "is encrypted. Save it without a password"),
        (pdf_file(b"0 0 m 9 9 l S"), "has no line that can be a curve"),
        (pdf_file(b"q 9 0 0 9 0 0 cm BI /W 1/H 1/CS/G/BPC 8 ID a EI Q"), "has a picture of pixels"),
        (b"\x89PNG\r\n", "is a picture of pixels"),
    ],
)
def test_pdf_files_without_a_curve(tmp_path, data, message):
    (tmp_path / "f.pdf").write_bytes(data)
    with pytest.raises(st.DataError, match=message):
        read(tmp_path / "f.pdf")


def test_pages_and_turned_pages(tmp_path):
    from matplotlib.backends.backend_pdf import PdfPages

    path = tmp_path / "pages.pdf"
    with PdfPages(path) as pages:
        for has_curve in (False, True):
            result, axes = figure()
            if has_curve:
                axes.plot(times(), DEGREES_PER_HOUR * deviation(times()))
            pages.savefig(result)
    with pytest.raises(st.OptionError, match=r"has 2 pages\. Give the page"):
        read(path)
    with pytest.raises(st.OptionError, match="must be from 1 to 2, not 3"):
        read(path, page=3)
    assert read(path, page=2).tau[0] == pytest.approx(0.01, rel=1e-4)
    line = b"1 w 50 300 m " + b" ".join(b"%d %d l" % (50 + 20 * k, 300 - 9 * k) for k in range(1, 21)) + b" S"
    axes = {"x_axis": {50: 0.1, 450: 100}, "y_axis": {100: 100, 300: 1}}
    (tmp_path / "plain.pdf").write_bytes(pdf_file(line))
    turned = b"0 1 -1 0 600 0 cm " + line.replace(b"1 w", b"1 w", 1)
    (tmp_path / "turned.pdf").write_bytes(pdf_file(turned, page=b"/Rotate 90"))
    plain, turned = (read(tmp_path / f"{name}.pdf", **axes) for name in ("plain", "turned"))
    assert plain.tau == pytest.approx(np.asarray(turned.tau))
    # 200 points are two decades, on a page turned from 400 to 600 points of height.
    assert turned.adev == pytest.approx(plain.adev * 10 ** (-200 / 100), rel=1e-3)


@pytest.mark.long
def test_a_malicious_file_ends(tmp_path):
    """Forms within forms, a billion of them: the process that reads them is ended."""
    forms = [
        b"<</Type/XObject/Subtype/Form/BBox[0 0 1 1]/Resources<</XObject<</F %d 0 R>>>>/Length 60>>stream\n%s\nendstream"
        % (6 + k, b"/F Do " * 10 if k < 8 else b"0 0 m 1 1 l S".ljust(60))
        for k in range(9)
    ]
    (tmp_path / "f.pdf").write_bytes(
        pdf_file(b"/F Do " * 10, page=b"/Resources<</XObject<</F 5 0 R>>>>", further=forms)
    )
    with pytest.raises(st.DataError, match=r"needs too much time or memory|has too many paths"):
        read(tmp_path / "f.pdf")
