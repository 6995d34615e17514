"""The certificate: incomplete and wrong files are refused by name, and page 1 says what a laboratory signs."""

import dataclasses
import re
import struct
import zlib
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

import sigmatau as st
from known import seed_of
from reporting.pdf_text import pages_of
from sigmatau.cli import main
from sigmatau.errors import DataError
from sigmatau.record.record import TemperatureRange
from sigmatau.reporting import pdf
from sigmatau.reporting.certificate_file import FIELDS, read_certificate
from sigmatau.reporting.content import collect_content
from sigmatau.reporting.html import page
from sigmatau.reporting.logo import read_logo

PAGE = Path(__file__).parents[2] / "docs/how-to/certificate.md"
EXAMPLE = re.search(r"<!-- save: lab.toml -->\n```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
SPEC = """
name = "Unit 7"
maker = "us"
source = "specification 12"

[gyro]
random_walk = { maximum = "0.4 deg/sqrt(h)" }
"""
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 1"><rect width="2" height="1" fill="#0b5cad"/></svg>'


def png(width, height, rows=None):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    body = zlib.compress(b"".join(b"\0" + bytes(width) for _ in range(height if rows is None else rows)))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


@pytest.fixture(scope="module")
def analysis():
    """A gyro whose z axis is at its maximum, 0.4 deg/√h; by the log on 7 May at 24.9 °C."""
    rng = np.random.default_rng(seed_of("certificate of a gyro"))
    n = 20_000
    walks = np.array([1e-4, 1.05e-4, 0.4 / 60 * np.pi / 180])
    record = st.Record.from_arrays(rate=10, gyro=rng.standard_normal((n, 3)) * walks * np.sqrt(10))
    made = st.analyze(record)
    warm = TemperatureRange(mean=24.9, low=24.6, high=25.1)
    return dataclasses.replace(
        made, source=dataclasses.replace(made.source, started="2026-05-07T09:30:00", temperature=warm)
    )


@pytest.fixture
def lab(tmp_path):
    """Writes the example of the page with replacements, beside its logo and specification."""
    (tmp_path / "logo.svg").write_bytes(SVG)
    (tmp_path / "spec.toml").write_text(SPEC)

    def write(*replacements):
        text = EXAMPLE
        for old, new in replacements:
            assert re.search(old, text, re.MULTILINE), old
            text = re.sub(old, new, text, flags=re.MULTILINE)
        (tmp_path / "lab.toml").write_text(text, encoding="utf-8")
        return tmp_path / "lab.toml"

    return write


def without(key):
    return (rf"^{key} = .*\n", "")


def facts(certificate):
    return {f"{title}.{label}": text for title, rows in certificate.facts for label, text in rows}


class TestFile:
    def test_the_example_has_every_key(self, lab):
        file = read_certificate(lab())
        for table, names in FIELDS.items():
            assert {*file.texts[table]} | ({"factor"} if table == "decision" else set()) == {*names}

    @pytest.mark.parametrize(
        "key", sorted(f"{t}.{n}" for t, names in FIELDS.items() for n, about in names.items() if about.required)
    )
    def test_every_required_key_is_asked_for(self, key, lab):
        table, _, name = key.partition(".")
        text = EXAMPLE.partition(f"[{table}]")
        body, end, rest = text[2].partition("\n[")
        file = lab()
        file.write_text(text[0] + text[1] + re.sub(rf"^{name} = .*\n", "", body, flags=re.MULTILINE) + end + rest)
        with pytest.raises(DataError, match=f"lacks {key}$"):
            read_certificate(file)

    def test_all_missing_keys_are_named_at_once(self, lab):
        with pytest.raises(DataError, match=r"lacks instrument\.model, report\.number, report\.reviewer$"):
            read_certificate(lab(without("model"), without("number"), ("^reviewer = .*", 'reviewer = ""')))

    def test_unknown_keys_are_refused(self, lab):
        with pytest.raises(DataError, match=r"unknown key report\.nummer \(meant: report\.number\?\)"):
            read_certificate(lab(("^operator", 'nummer = "1"\noperator')))
        with pytest.raises(DataError, match=r"unknown key signature"):
            read_certificate(lab(("^\\[report\\]", "[signature]\nx = 1\n[report]")))

    @pytest.mark.parametrize(
        ("old", "new", "reason"),
        [
            ('^kind = "calibration certificate"', 'kind = "diploma"', "report.kind 'diploma' must be 'test report'"),
            ("^date = 2026-05-07", 'date = "May"', "measurement.date 'May' must be a date"),
            ("^place = .*", "place = 3", "measurement.place must be a text in quotes"),
            ("^place = .*", f'place = "{"x" * 601}"', "at most 600 characters"),
            ('^sided = "one"', 'sided = "three"', "decision.sided 'three' must be 'one' or 'two'"),
            ("^factor = 1.5", "factor = true", "decision.factor True must be a number"),
            ("^factor = 1.5", "factor = 0.5", "decision.factor 0.5 must be a number from 1"),
            (*without("traceability"), "lacks method.traceability"),
            ("^reviewer = .*", 'reviewer = "  "', "lacks report.reviewer"),
            (
                "^issued = .*",
                "issued = 1999-01-01",
                "report.issued, 1999-01-01, is before measurement.date, 2026-05-07",
            ),
            ("^received = .*", "received = 2027-05-04", "measurement.date, 2026-05-07, is before instrument.received"),
            ("^\\[customer\\]", "[customer", "not TOML"),
            ('^logo = "logo.svg"', 'logo = "absent.png"', "absent.png: the logo does not exist"),
        ],
    )
    def test_wrong_values(self, old, new, reason, lab):
        with pytest.raises(DataError, match=re.escape(reason)):
            read_certificate(lab((old, new)))

    def test_a_test_report_needs_no_traceability(self, lab):
        assert read_certificate(lab(without("kind"), without("traceability"))).text("report", "kind") == ""

    def test_a_missing_file(self, tmp_path):
        with pytest.raises(DataError, match=r"lab.toml: does not exist; docs/how-to/certificate.md has an example"):
            read_certificate(tmp_path / "lab.toml")

    def test_of_a_unit(self, lab):
        with pytest.raises(DataError, match=r"instrument.serial of a lot is the name of each unit; leave it out"):
            read_certificate(lab(), each_unit=True)
        file = read_certificate(lab(without("serial")), each_unit=True)
        unit = file.of_unit("SN7\n")
        assert (unit.text("instrument", "serial"), unit.text("report", "number")) == ("SN7\\n", "2026-0042-SN7\\n")
        assert unit.text("instrument", "model") == file.text("instrument", "model")
        assert file.text("instrument", "serial") == ""

    def test_a_large_file(self, lab):
        with pytest.raises(DataError, match="64 KiB"):
            read_certificate(lab(("^\\[customer\\]", "# " + "x" * (1 << 16) + "\n[customer]")))


class TestLogo:
    @pytest.mark.parametrize("content", [SVG, b'<?xml version="1.0"?>\n<!-- made by hand -->' + SVG, png(4, 2)])
    def test_pictures(self, content, tmp_path):
        (tmp_path / "logo").write_bytes(content)
        logo = read_logo(tmp_path / "logo")
        assert logo.content == content
        assert logo.url.startswith(f"data:image/{'png' if content.startswith(bytes([137])) else 'svg+xml'};base64,")

    @pytest.mark.parametrize(
        ("content", "reason"),
        [
            (SVG.replace(b"<rect", b"<script>1</script><rect"), "scripts"),
            (SVG.replace(b"<rect", b'<rect onclick="f()"'), "scripts"),
            (SVG.replace(b"<rect", b'<image href="http://192.0.2.1/x.png"/><rect'), "links"),
            (b'<?xml version="1.0"?>' + SVG.replace(b"<rect", b"<!ENTITY a 'b'><rect"), "entities"),
            (b"<!DOCTYPE svg>" + SVG, "must be a PNG or an SVG"),
            (b"GIF89a", "must be a PNG or an SVG"),
            (png(4, 2)[:20], "damaged PNG"),
            (png(60_000, 60_000, rows=1), "60000 × 60000 pixels"),
            (SVG + b" " * (512 << 10), "512 KiB"),
        ],
    )
    def test_refused(self, content, reason, tmp_path):
        (tmp_path / "logo").write_bytes(content)
        with pytest.raises(DataError, match=reason):
            read_logo(tmp_path / "logo")


class TestFacts:
    def test_date_and_temperature_of_the_log(self, analysis, lab):
        made = facts(st.certify(analysis, lab(without("date"), without("temperature"))))
        assert made["Measurement.Measured"] == "2026-05-07 09:30 (by the log)"
        assert made["Measurement.Temperature"] == "24.9 °C, 24.6 to 25.1 °C (sensor, by the log)"

    def test_both_are_needed_from_somewhere(self, analysis, lab):
        bare = dataclasses.replace(analysis.source, started=None, temperature=None)
        other = dataclasses.replace(analysis, source=bare)
        with pytest.raises(DataError, match=r"lacks measurement\.date, and the log has no date"):
            st.certify(other, lab(without("date")))
        with pytest.raises(DataError, match=r"lacks measurement\.temperature"):
            st.certify(other, lab(without("temperature")))

    def test_a_date_that_contradicts_the_log(self, analysis, lab):
        assert facts(st.certify(analysis, lab(("^date = .*", "date = 2026-05-08"))))["Measurement.Measured"] == (
            "2026-05-08 (log: 2026-05-07 09:30)"
        )
        with pytest.raises(DataError, match=r"2026-05-09 is not that of the log, 2026-05-07"):
            st.certify(analysis, lab(("^date = .*", "date = 2026-05-09"), without("issued")))

    def test_a_log_after_the_issue(self, analysis, lab):
        with pytest.raises(DataError, match=r"report.issued, 2026-05-04, is before the date of the log, 2026-05-07"):
            st.certify(analysis, lab(without("date"), without("received"), ("^issued = .*", "issued = 2026-05-04")))

    def test_the_day_in_the_name_of_a_log_without_dates(self, analysis, lab):
        bare = dataclasses.replace(analysis.source, started=None, path="2025/SN7_2026-05-06.csv")
        made = facts(st.certify(dataclasses.replace(analysis, source=bare), lab(without("date"))))
        assert made["Measurement.Measured"] == "2026-05-06 (by the name of the log)"

    def test_the_day_of_the_analysis_is_only_that_of_issue(self, analysis, lab):
        made = facts(st.certify(analysis, lab(without("issued")), date=datetime(2027, 1, 2, tzinfo=UTC)))
        assert [label for label, text in made.items() if "2027" in text] == ["Method.Issued"]

    def test_without_fits(self, analysis, lab):
        with pytest.raises(DataError, match="nothing to certify"):
            st.certify(dataclasses.replace(analysis, fits={}), lab((r"(?s)^\[decision\].*", "")))


class TestDecision:
    def test_guard_band(self, analysis, lab):
        made = st.certify(analysis, lab())
        rows = {row.axis: row for row in made.limits}
        assert rows["gyro_x"].outcome == "conforms"
        assert (rows["gyro_x"].consumer, rows["gyro_x"].producer) == ("< 0.01 %", "–")
        assert rows["gyro_z"].outcome == "not decided"
        assert dict(made.statements)["Decision rule"].startswith("Guard band w = U (ISO 14253-1")
        assert dict(made.statements)["Statement of conformity"] == (
            "Of 3 judged values against Unit 7: 1 is not decided, 2 conform."
        )

    def test_the_risk_is_that_of_the_outcome(self, analysis, lab, tmp_path):
        """A value far above its maximum is rejected: the producer's risk is small, and the consumer has none."""
        file = lab()
        (tmp_path / "spec.toml").write_text(SPEC.replace("0.4 deg", "0.3 deg"))
        row = next(row for row in st.certify(analysis, file).limits if row.axis == "gyro_z")
        assert row.outcome == "does not conform"
        assert (row.consumer, row.producer) == ("–", "< 0.01 %")

    def test_simple_acceptance(self, analysis, lab):
        made = st.certify(analysis, lab(('^rule = "guard band"', 'rule = "simple-acceptance"')))
        assert "not decided" not in {row.outcome for row in made.limits}
        assert "Simple acceptance" in dict(made.statements)["Decision rule"]

    @pytest.mark.parametrize(
        ("old", "new", "reason"),
        [
            ('^rule = "guard band"', 'rule = "lenient"', "decision.rule 'lenient' must be"),
            ("random_walk = .*", 'random_walk = { typical = "0.4 deg/sqrt(h)" }', "no maximum of a measured value"),
        ],
    )
    def test_refused(self, old, new, reason, analysis, lab, tmp_path):
        file = lab(without("factor")) if old.startswith("random") else lab((old, new))
        (tmp_path / "spec.toml").write_text(re.sub(old, new, SPEC) if old.startswith("random") else SPEC)
        with pytest.raises(DataError, match=reason):
            st.certify(analysis, file)

    def test_without_a_specification(self, analysis, lab):
        made = st.certify(analysis, lab((r"(?s)^\[decision\].*", "")))
        assert made.limits == ()
        assert [heading for heading, _ in made.statements] == ["Uncertainty", "Scope", "Remarks"]

    def test_unknown_specification(self, analysis, lab):
        with pytest.raises(DataError, match="neither a file beside it nor in"):
            st.certify(analysis, lab(('^specification = "spec.toml"', 'specification = "absent"')))

    def test_a_specification_of_the_current_folder_is_not_used(self, analysis, lab, tmp_path, monkeypatch):
        (tmp_path / "here").mkdir()
        (tmp_path / "here" / "other.toml").write_text(SPEC)
        monkeypatch.chdir(tmp_path / "here")
        for name in ("other.toml", "x" * 300 + ".toml"):
            file = lab(('^specification = "spec.toml"', f'specification = "{name}"'))
            with pytest.raises(DataError, match="neither a file beside it nor in"):
                st.certify(analysis, file)


@pytest.fixture(scope="module")
def printed(analysis, tmp_path_factory):
    pytest.importorskip("typst", reason="a PDF needs typst")
    folder = tmp_path_factory.mktemp("lab")
    (folder / "logo.svg").write_bytes(SVG)
    (folder / "spec.toml").write_text(SPEC)
    (folder / "lab.toml").write_text(EXAMPLE, encoding="utf-8")
    content = collect_content(analysis, None, certificate=st.certify(analysis, folder / "lab.toml"))
    return pages_of(pdf.typeset(pdf._template(), pdf._values(content), format="pdf", pretty=True))


class TestPages:
    def test_every_page_has_its_number_and_the_level(self, printed):
        for number, text in enumerate(printed, 1):
            squeezed = re.sub(r"\s", "", text)
            assert f"Page{number}of{len(printed)}" in squeezed
            assert "2026-0042" in squeezed
            assert "95%intervals" in squeezed

    def test_page_1_has_all_facts(self, printed, analysis, lab):
        first = re.sub(r"[\s\u200b]", "", printed[0])
        made = st.certify(analysis, lab())
        for text in (*facts(made).values(), *made.laboratory, *(name for _, name in made.signatures)):
            if text != "in memory":
                assert re.sub(r"\s", "", text) in first, text
        assert "Endofreport2026-0042" in re.sub(r"\s", "", printed[-1])

    def test_a_page_in_html(self, analysis, lab):
        hostile = ('^name = "Example Navigation Ltd"', "name = '<script>alert(1)</script>'")
        certificate = st.certify(analysis, lab(hostile))
        made = page(collect_content(analysis, None, certificate=certificate))
        assert "<script>alert" not in made
        assert "&lt;script&gt;alert(1)&lt;/script&gt;" in made
        assert made.count('<img src="data:image/svg+xml;base64,') == 1
        assert made.index('id="certificate"') < made.index('id="summary"')
        assert '@bottom-left { content: "2026-0042"' in made

    def test_without_a_certificate_both_dates_are_named(self, analysis):
        made = page(collect_content(analysis, None, date=datetime(2027, 1, 2, tzinfo=UTC)))
        assert "Recorded 2026-05-07 09:30, by the clock of the log. Analysed 2027-01-02 00:00 UTC." in made
        assert 'id="certificate"' not in made


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--certificate", "lab.toml"], "--certificate needs --report"),
        (["--certificate", "lab.toml", "--report", "r.html", "--joint-axes"], "--certificate is for one log"),
        (["--certificate", "lab.toml", "--report", "reports", "--jobs", "2"], "--certificate is for one log"),
        (["--certificate", "lab.toml", "--report", "r.html", "--export", "model=lab.toml"], "the file that is read"),
        (["--certificate", "lab.toml", "--report", "r.html", "--export", "model=spec.toml"], "the file that is read"),
        (["--certificate", "lab.toml", "--report", "r.html", "--plot", "logo.svg"], "the file that is read"),
    ],
)
def test_options(words, reason, lab, tmp_path, monkeypatch, capsys):
    lab()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csv").write_text("gyro_x [rad/s]\n1\n")
    assert main(["analyze", "x.csv", *words]) == 2
    assert reason in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('^rule = "guard band"', 'rule = "lenient"', "lab.toml: decision.rule 'lenient' must be"),
        ('^specification = "spec.toml"', 'specification = "absent"', "lab.toml: decision.specification 'absent' is"),
        ("^factor = 1.5", "", "lab.toml: Unit 7 states no maximum; state one, or decision.factor"),
        ("^temperature = .*", "", "lab.toml: lacks measurement.temperature, and the log has no thermometer"),
        ("^date = .*", "", "lab.toml: lacks measurement.date, and the log has no date"),
    ],
)
def test_errors_come_before_the_analysis(old, new, reason, lab, tmp_path, monkeypatch, capsys):
    lab((old, new))
    monkeypatch.chdir(tmp_path)
    if old.startswith("^factor"):
        (tmp_path / "spec.toml").write_text(SPEC.replace("maximum", "typical"))
    (tmp_path / "x.csv").write_text("gyro_x [rad/s]\n" + "1\n2\n" * 2000)

    def analyze(*_, **__):
        raise AssertionError

    monkeypatch.setattr("sigmatau.cli.analyze.analyze", analyze)
    assert main(["analyze", "x.csv", "--rate", "10", "--certificate", "lab.toml", "--report", "r.html"]) == 1
    assert reason in capsys.readouterr().err
