"""The page of the tutorial runs once; its notebook has the same steps, and its filter is as consistent as it says."""

import importlib.util
import json

import numpy as np
import pytest
from pages import blocks, run_page, statements, without_comments

import sigmatau as st
from conftest import ROOT

LONGEST = 100  # characters of a line that a user writes

_spec = importlib.util.spec_from_file_location("tutorial", ROOT / "docs" / "tutorial.py")
tutorial = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(tutorial)


def test_the_notebook_is_made_from_the_page():
    """`docs/tutorial.py` writes it."""
    assert tutorial.NOTEBOOK.read_text(encoding="utf-8") == tutorial.notebook()


def test_the_cells_do_what_the_blocks_of_the_page_do():
    """So that only one of them is run."""
    cells = json.loads(tutorial.NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    code = [cell["source"] for cell in cells if cell["cell_type"] == "code"]
    assert len(code) >= 15
    assert max(len(line.rstrip()) for source in code for line in source) <= LONGEST
    expected = []
    for block in blocks(tutorial.PAGE.read_text(encoding="utf-8")):
        assert block.note != "not run"
        if block.note == "save":
            expected.append((block.of, block.content))
        elif block.shows == "file":
            expected.append(("!", f"cat {block.of}"))
        elif block.language == "sh":
            expected += [("!", without_comments(one).strip().replace("\\\n", " ")) for one in statements(block.content)]
        elif block.language == "python":
            expected.append(("python", block.content))
    assert [*tutorial.steps(cells)] == expected


def test_cells_are_run(tmp_path):
    page = "<!-- save: a.toml -->\n```toml\nx = 1\n```\n\n```sh\ncp a.toml \\\n    b.toml\n```\n"
    page += "\n```python\nfrom pathlib import Path\ntext = Path('b.toml').read_text()\n```\n"
    assert tutorial.run(tutorial.cells(page), tmp_path)["text"] == "x = 1\n"
    with pytest.raises(RuntimeError, match=r"plan none\.toml failed"):
        tutorial.run(tutorial.cells("```sh\nsigmatau plan none.toml\n```\n"), tmp_path)


def test_page(tmp_path):
    """The filter with the model of the log is consistent; those with a wrong random walk are not."""
    page = run_page(tutorial.PAGE, tmp_path)
    page.check()
    scope = page.scope
    innovations = scope["innovations"][np.isfinite(scope["innovations"])]
    assert len(innovations) > 8_900
    # 99.99 % of a mean of squares of standard normal numbers
    assert np.mean(innovations**2) == pytest.approx(1.0, abs=3.9 * np.sqrt(2 / len(innovations)))
    wrong, *_ = scope["track"](st.ChannelModel(terms=scope["wrong"]), scope["y"][:500])
    assert np.nanmean(wrong**2) > 10
    written = {path.name for path in tmp_path.iterdir()}
    assert {"imu.json", "imu.yaml", "matrices.npz", "allan.png", "report.html"} <= written
