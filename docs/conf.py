"""Settings of Sphinx. `make docs` puts the pages together (docs/website) and builds them from there."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from numpydoc.xref import DEFAULT_LINKS  # noqa: E402

import sigmatau  # noqa: E402
from website.api import EXPORTED  # noqa: E402

project = "sigmatau"
author = "the authors of sigmatau"
project_copyright = f"{author}; MIT or Apache-2.0"
version = release = sigmatau.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.extlinks",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "website.sphinx_parts",
]
root_doc = "index"
templates_path: list[str] = []
language = "en"
smartquotes = False  # "half" in a docstring is code
# Files of sphinx-gallery that are no pages.
exclude_patterns = [
    "examples/*.py",
    "examples/*.ipynb",
    "examples/*.json",
    "examples/*.zip",
    "examples/sg_execution_times.rst",
]
show_warning_types = True
# Files of other programs are not always what their lexer knows: the YAML of OpenCV, CSV.
suppress_warnings = ["misc.highlighting_failure"]

# Markdown, as Git hosts read it.
myst_enable_extensions = ["attrs_block", "dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 6
html_math_renderer = "mathml"

# Docstrings: `name` is a Python object.
default_role = "py:obj"
add_module_names = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = False
autodoc_docstring_signature = False  # no docstring begins with a signature
maximum_signature_line_length = 78
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {name: name for name in DEFAULT_LINKS} | {name: f"sigmatau.{name}" for name in EXPORTED}
extlinks = {"doi": ("https://doi.org/%s", "doi:%s")}

sphinx_gallery_conf: dict[str, Any] = {
    "examples_dirs": [str(HERE / "gallery")],
    "gallery_dirs": ["examples"],
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": ("__repr__",),
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "remove_config_comments": True,
    "image_srcset": ["2x"],
    "abort_on_example_error": True,
}

html_theme = "pydata_sphinx_theme"
html_title = "sigmatau"
html_static_path = [str(HERE / "website" / "static")]
html_css_files = ["site.css"]
html_js_files = [("search-ranking.js", {"defer": "defer"})]
html_favicon = str(HERE / "website" / "static" / "sigmatau.svg")
html_logo = html_favicon
html_show_sourcelink = False
html_copy_source = False
html_theme_options: dict[str, Any] = {
    "logo": {"text": "sigmatau"},
    "header_links_before_dropdown": 6,
    "show_toc_level": 2,
    "navigation_depth": 3,
    "show_nav_level": 1,
    "collapse_navigation": True,
    "search_bar_text": "Search: bias instability, gaps, --leave-out …",
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "navbar_end": ["theme-switcher"],
}
html_sidebars = {"index": []}
copybutton_selector = "div.highlight-sh pre, div.highlight-python pre, div.highlight-toml pre"
