"""What the site adds to Sphinx: formulas as MathML, references of docstrings, signatures, names of languages."""

from __future__ import annotations

import functools
import importlib
import inspect
import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from numpydoc.docscrape_sphinx import SphinxDocString
from pygments.lexers.python import PythonLexer
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util import logging
from sphinx.util.nodes import make_refnode

_log = logging.getLogger(__name__)
_BAR = re.compile(r"``.*?``|`[^`]*`|\|")  # code, which keeps its bars, or a bar
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
            found: Any = importlib.import_module(".".join(parts[:length]))
        except ImportError:
            continue
        for part in parts[length:]:
            if not hasattr(found, part) and part not in getattr(found, "__dataclass_fields__", {}):
                return False
            found = getattr(found, part, None)
        return True
    return False


def _missing(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.Element) -> nodes.Element | None:
    """A class is found by its last name if no other has it; a name without a page stays as code, if it exists."""
    if node.get("refdomain") == "py":
        target = node["reftarget"].removesuffix("()")
        objects = env.domains.python_domain.objects
        alike = [name for name in objects if name.endswith(f".{target}")] if target[:1].isupper() else []
        if len(alike) == 1:
            there = objects[alike[0]]
            return make_refnode(app.builder, node["refdoc"], there.docname, there.node_id, content, alike[0])
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
    """Arguments of a class that its examples make; any other is a result, which nobody calls."""
    if what == "exception" or (
        what == "class" and f"{getattr(found, '__name__', '')}(" not in (inspect.getdoc(found) or "")
    ):
        return "", None
    return signature, returns


def _bars(app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]) -> None:
    """The bars of absolute values: in reStructuredText they would stand for a substitution."""
    example = False
    for k, line in enumerate(lines):
        example = line.lstrip().startswith(">>>") or (example and bool(line.strip()))
        if "|" in line and not example:
            lines[k] = _BAR.sub(lambda match: match[0] if match[0] != "|" else r"\|", line)


def _with_one_template() -> None:
    """Have numpydoc compile its template once. It does so for each docstring, which takes an eighth of the whole build."""
    load = SphinxDocString.load_config

    def load_config(self: SphinxDocString, config: dict[str, Any]) -> None:
        load(self, config | template)
        template["template"] = self.template

    template: dict[str, Any] = {}
    SphinxDocString.load_config = load_config


def setup(app: Sphinx) -> dict[str, bool]:
    """Register everything with Sphinx."""
    _with_one_template()
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.add_lexer("python-file", PythonLexer)
    app.connect("missing-reference", _missing)
    app.connect("autodoc-process-docstring", _bars, priority=900)
    app.connect("autodoc-process-signature", _signature, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
