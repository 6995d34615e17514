"""How the site of the documentation is put together and checked; `make docs` builds it."""

import json
import re
import sys
from pathlib import PurePosixPath

import pytest

import sigmatau
from conftest import ROOT
from sigmatau.cli.app import EXAMPLES
from sigmatau.findings.finding import Details

sys.path.append(str(ROOT / "docs"))

from website import api, checks, command_line, excerpts, kinds, notebooks, schema, stage


def with_links(text, source="docs/theory/fit.md"):
    return stage.with_links(text, PurePosixPath(source), stage.pages())


def test_theory_page_is_added_made_or_not(tmp_path, monkeypatch):
    monkeypatch.setattr(stage, "ROOT", tmp_path)
    page = tmp_path / "site" / "alive" / "index.html"
    page.parents[1].mkdir()
    stage.add_alive(tmp_path / "site")
    assert "make alive" in page.read_text(encoding="utf-8")
    (tmp_path / "target" / "alive").mkdir(parents=True)
    (tmp_path / "target" / "alive" / "index.html").write_text("made", encoding="utf-8")
    stage.add_alive(tmp_path / "site")
    assert page.read_text(encoding="utf-8") == "made"
    link = re.search(r'href="([^"]+)"', (stage.DOCS / "theory" / "alive.md").read_text(encoding="utf-8"))[1]
    assert (tmp_path / "site" / "theory" / link).resolve() == page.resolve()


def test_pages_are_staged_once():
    staged = stage.pages()
    assert staged[PurePosixPath("docs/how-to/README.md")] == PurePosixPath("how-to/index.md")
    assert staged[PurePosixPath("README.md")] == PurePosixPath("overview.md")
    assert len(set(staged.values())) == len(staged)


@pytest.mark.parametrize(
    ("written", "staged"),
    [
        ("[a](../numbers.md#units)", "[a](../numbers.md#units)"),
        ("[a](../how-to/README.md)", "[a](../how-to/index.md)"),
        ("[a](../how-to/)", "[a](../how-to/index.md)"),
        ("[a](../notebook.ipynb)", "[a](../notebook.md)"),
        ("[a](../../README.md#install)", "[a](../overview.md#install)"),
        ("[a](../../CONTRIBUTING.md)", "[a](../contributing.md)"),
        ("[`a`](../../python/sigmatau/units.py)", "`a` (`python/sigmatau/units.py`)"),
        ("![a](../figures/fit.svg)", "![a](../figures/fit.svg)"),
        ("[a](https://example.org/README.md)", "[a](https://example.org/README.md)"),
        ("[a](#units) and [b](nowhere.md)", "[a](#units) and [b](nowhere.md)"),
        ("```text\n[a](../how-to/README.md)\n```", "```text\n[a](../how-to/README.md)\n```"),
    ],
)
def test_links(written, staged):
    assert with_links(written) == staged


def test_the_order_of_a_section_is_that_of_its_index():
    texts = {
        "index": "",
        "start": "# S\n",
        "reference": "# R\n",
        "performance": "# P\n",
        "contributing": "# C\n",
        "how-to/index": "# H\n[x](c.md) [y](a.md#b)\n```text\n[z](b.md)\n```\n",
        **dict.fromkeys(["how-to/a", "how-to/b", "how-to/c", "new"], "# T\n"),
    }
    below = stage.contents(texts)
    assert below["how-to/index"] == ["how-to/c", "how-to/a", "how-to/b"]
    assert below["reference"] == ["new"]


def test_every_public_name_has_a_page():
    pages = api.pages()
    text = "".join(pages.values())
    for name in sigmatau.__all__:
        if not name.startswith("__"):
            assert re.search(rf":: sigmatau\.{name}\n", text), name
    names = [name.lower() for name in pages]
    assert len(names) == len(set(names))


def test_every_command_and_option_is_on_the_page(capsys):
    from sigmatau.cli import main

    page = command_line.page()
    for command, examples in EXAMPLES.items():
        (section,) = re.findall(
            rf"^sigmatau {command}\n-+\n(.*?)(?=^sigmatau [^\n]*\n-+\n|\Z)", page, re.DOTALL | re.MULTILINE
        )
        for line in examples.splitlines():
            assert f"   {line}\n" in section, line
        if command not in ("analyze", "lot", "store list"):
            continue  # the others are made alike, and their help takes as long
        assert main([*command.split(), "--help"]) == 0
        options = set(re.findall(r"^[│ ]*\*? *(--[a-z][a-z-]*)", capsys.readouterr().out, flags=re.MULTILINE))
        assert options
        for option in options - {"--help", "--version"}:
            assert re.search(rf"^\.\. option:: .*{option}\b", section, flags=re.MULTILINE), f"{command} {option}"


def test_the_details_of_every_finding_are_on_the_page():
    page = kinds.page()
    explained = re.findall(
        r"^\| `([a-z_]+)` \|", (ROOT / "docs" / "findings.md").read_text().partition("## Time stamps")[2], re.M
    )
    assert sorted(re.findall(r"^\.\. describe:: (.*)$", page, flags=re.MULTILINE)) == sorted(explained)
    assert re.search(
        r"   - ``samples``: int; number of samples in these runs.*\n   - ``share``: float; part of all samples",
        page,
        re.IGNORECASE,
    )


def test_fields_are_described_by_comments_or_by_a_section():
    class Kind(Details, code="kind"):
        """A kind.

        Attributes
        ----------
        low, high : float
            Ends. [s]
        """

        low: "float"
        high: "float | None"
        count: "int"  # how many

    assert [*kinds.fields(Kind)] == [
        ("low", "float", "Ends. [s]"),
        ("high", "float or None", "Ends. [s]"),
        ("count", "int", ""),
    ]


def test_every_field_of_the_schema_is_on_the_page():
    page = schema.page()
    for path in (
        "channels.NAME.curve.tau_s",
        "channels.NAME.fit.terms.random_walk.value",
        "findings[].code",
        "rest.verdict",
    ):
        assert re.search(rf"   \* - (\*\*)?{re.escape(path)}(\*\*)?\n", page), path


def test_a_notebook_shows_its_outputs(tmp_path):
    from matplotlib import pyplot as plt

    cells = [
        {"cell_type": "markdown", "source": ["# Title\n", "Text."]},
        {"cell_type": "code", "source": ["print('said')\n", "x = 6"]},
        {"cell_type": "code", "source": ["x * 7"]},
        {"cell_type": "code", "source": ["import matplotlib.pyplot as plt\n", "_ = plt.plot([1, 2])"]},
    ]
    notebook = tmp_path / "n.ipynb"
    notebook.write_text(json.dumps({"cells": cells}))
    plt.close("all")  # of other tests of this process, which would be on the page too
    page = notebooks.markdown(notebook)
    assert page.startswith("# Title\nText.\n\nTo run it yourself: {download}`n.ipynb`.\n\n```python\n")
    assert "```python\nprint('said')\nx = 6\n```\n\n```text\nsaid\n```\n" in page
    assert "```python\nx * 7\n```\n\n```text\n42\n```" in page
    assert page.count("data:image/png;base64,") == 1


def test_a_notebook_with_commands_of_a_shell_is_not_run(tmp_path):
    notebook = tmp_path / "n.ipynb"
    cells = [{"cell_type": "code", "source": ["!sigmatau inspect log.csv"]}, {"cell_type": "code", "source": ["1 / 0"]}]
    notebook.write_text(json.dumps({"cells": cells}))
    assert notebooks.markdown(notebook) == "```python\n!sigmatau inspect log.csv\n```\n\n```python\n1 / 0\n```\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.html", '<script src="https://cdn.example/x.js"></script>'),
        ("a.html", '<link rel="stylesheet" href="//cdn.example/x.css">'),
        ("a.html", '<img srcset="local.png 1x, http://example.org/x.png 2x">'),
        ("a.html", '<style>@font-face { src: url("https://fonts.example/f.woff2") }</style>'),
        ("a.html", '<p style="background: url(https://example.org/x.png)">'),
        ("a.html", '<script>import("https://cdn.example/x.js")</script>'),
        ("a.css", '@import "https://fonts.example/f.css";'),
        ("a.js", 'script.src = "https://cdn.example/x.js";'),
        ("a.js", 'fetch("https://example.org/data")'),
    ],
)
def test_what_is_loaded_from_elsewhere_is_found(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    assert len([*checks.offline(tmp_path)]) == 1


def test_what_a_reader_may_follow_is_not_loaded(tmp_path):
    (tmp_path / "a.html").write_text(
        '<a href="https://example.org">x</a><img src="data:image/png;base64,AA"><script src="x.js">'
    )
    (tmp_path / "x.js").write_text("// see https://example.org\nconst address = 'https://example.org';\n")
    assert not [*checks.offline(tmp_path)]


def test_excerpts_are_the_text_below_the_title(tmp_path):
    """By page, without menus, scripts and formulas; the search page reads them from one file."""
    article = (
        '<nav>Menu</nav><article class="bd-article"><h1>Title<a class="headerlink" href="#t">#</a></h1>'
        "<p>First <b>words</b>,<br> a&lt;b <math><mi>x</mi></math>end.</p><script>f()</script></article><p>Foot</p>"
    )
    assert excerpts.text_of(article) == "First words, a<b end."
    (tmp_path / "how-to").mkdir()
    (tmp_path / "_static").mkdir()
    (tmp_path / "how-to" / "a.html").write_text(article)
    (tmp_path / "_static" / "b.html").write_text(article)
    excerpts.write(tmp_path)
    written = (tmp_path / "_static" / "search-texts.js").read_text()
    assert json.loads(written.removeprefix("window.SEARCH_TEXTS = ").rstrip(";\n")) == {
        "how-to/a": "First words, a<b end."
    }


def test_an_example_without_a_figure_is_a_complaint(tmp_path):
    """Its picture in the gallery would be a placeholder."""
    for name in ("examples/plot_1.html", "examples/plot_2.html", "_images/sphx_glr_plot_1_001.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    (complaint,) = checks.pictures(tmp_path)
    assert complaint.startswith("examples/plot_2.html: no figure")
