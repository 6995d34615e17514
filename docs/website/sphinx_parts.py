"""Extensions of Sphinx for the site: formulas as MathML, references in docstrings, signatures, names of languages."""

from __future__ import annotations

import functools
import importlib
import inspect
import re
from typing import Any

from docutils import nodes
from jinja2 import BaseLoader
from jinja2.sandbox import SandboxedEnvironment
from latex2mathml.converter import convert
from numpydoc import docscrape_sphinx
from pygments.lexers.python import PythonLexer
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.search.en import SearchEnglish
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

_log = logging.getLogger(__name__)
_BAR = re.compile(r"``.*?``|`[^`]*`|\|")  # code, in which bars remain, or a bar
_LEFT_OVER = re.compile(r"<m[io]>\\")


def _mathml(latex: str, display: str, node: nodes.Element) -> str:
    made = convert(latex, display=display)
    if _LEFT_OVER.search(made):
        _log.warning("formula with a command that latex2mathml does not know: %s", latex, location=node)
    return made


def _inline(writer: Any, node: nodes.math) -> None:  # noqa: ANN401  a translator of Sphinx
    writer.body.append(_mathml(node.astext(), "inline", node))
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:  # noqa: ANN401
    writer.body.append(f'<div class="formula">{_mathml(node.astext(), "block", node)}</div>\n')
    raise nodes.SkipNode


@functools.cache
def _exists(name: str) -> bool:
    """Whether a dotted name is a module or an attribute."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        try:
            value: Any = importlib.import_module(".".join(parts[:length]))
        except ImportError:
            continue
        for part in parts[length:]:
            if not hasattr(value, part) and part not in getattr(value, "__dataclass_fields__", {}):
                return False
            value = getattr(value, part, None)
        return True
    return False


def _missing(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.Element) -> nodes.Element | None:
    """Resolve a class by its last name if that is unique; an existing name without a page remains as code."""
    if node.get("refdomain") == "py":
        target = node["reftarget"].removesuffix("()")
        objects = env.domains.python_domain.objects
        alike = [name for name in objects if name.endswith(f".{target}")] if target[:1].isupper() else []
        if len(alike) == 1:
            target_page = objects[alike[0]]
            return make_refnode(
                app.builder, node["refdoc"], target_page.docname, target_page.node_id, content, alike[0]
            )
        if target.startswith("sigmatau.") and not _exists(target):
            _log.warning("no such name in the package: %s", target, location=node, type="ref", subtype="python")
        return content
    return None


def _signature(
    app: Sphinx,
    what: str,
    name: str,
    found: object,
    options: object,
    signature: str | None,
    returns: str | None,
) -> tuple[str | None, str | None]:
    """Arguments of a class that its examples call; other classes are results, which users do not create."""
    if what == "exception" or (
        what == "class" and f"{getattr(found, '__name__', '')}(" not in (inspect.getdoc(found) or "")
    ):
        return "", None
    return signature, returns


def _bars(app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]) -> None:
    """Escape the bars of absolute values, which would be a substitution in reStructuredText."""
    example = False
    for k, line in enumerate(lines):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        if "|" in line and not example:
            lines[k] = _BAR.sub(lambda match: match[0] if match[0] != "|" else r"\|", line)


def _with_one_template() -> None:
    """Make numpydoc compile its template only once instead of for each docstring, a twentieth of the whole build."""
    environments: list[SandboxedEnvironment] = []

    def environment(loader: BaseLoader) -> SandboxedEnvironment:
        if not environments:
            environments.append(SandboxedEnvironment(loader=loader))
        return environments[0]

    docscrape_sphinx.SandboxedEnvironment = environment


def _with_each_stem_once() -> None:
    """Make the search index compute the stem of a word only once, a twentieth of the whole build."""
    SearchEnglish.stem = functools.lru_cache(maxsize=None)(SearchEnglish.stem)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register everything with Sphinx."""
    _with_one_template()
    _with_each_stem_once()
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.add_lexer("python-file", PythonLexer)
    app.connect("missing-reference", _missing)
    app.connect("autodoc-process-docstring", _bars, priority=900)
    app.connect("autodoc-process-signature", _signature, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
