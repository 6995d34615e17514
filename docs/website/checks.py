"""Checks of the built site: it works without a network, and its search answers questions."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

REMOTE = re.compile(r"^(?:https?:)?//", flags=re.IGNORECASE)
# Attributes by which a page loads a file. A link (`a href`) does not load a file.
_LOADS = {
    ("script", "src"),
    ("link", "href"),
    ("img", "src"),
    ("img", "srcset"),
    ("source", "src"),
    ("source", "srcset"),
    ("iframe", "src"),
    ("video", "src"),
    ("audio", "src"),
    ("embed", "src"),
    ("object", "data"),
    ("image", "href"),
    ("image", "xlink:href"),
    ("use", "href"),
    ("use", "xlink:href"),
}
_CSS = re.compile(r"""(?:url\(|@import)\s*["']?\s*((?:https?:)?//[^"')\s]+)""", flags=re.IGNORECASE)
_JS = re.compile(
    r"""(?:\bsrc\s*=|\bfetch\(|\bimport\(|\bfrom|importScripts\(|\.open\(\s*["']GET["'],)\s*["'`]((?:https?:)?//[^"'`]+)""",
    flags=re.IGNORECASE,
)


class _Loads(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self._code = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._code = tag if tag in ("script", "style") else ""
        for name, value in attrs:
            if (tag, name) in _LOADS:
                self.found += [address for address in re.split(r",\s+|\s+", value or "") if REMOTE.match(address)]
            elif name == "style":
                self.found += _CSS.findall(value or "")

    def handle_endtag(self, tag: str) -> None:
        self._code = ""

    def handle_data(self, data: str) -> None:
        if self._code:
            self.found += (_CSS if self._code == "style" else _JS).findall(data)


def remote(path: Path) -> list[str]:
    """Addresses from which a file of the site loads other files."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if path.suffix == ".html":
        parser = _Loads()
        parser.feed(text)
        return parser.found
    return (_JS if path.suffix == ".js" else _CSS).findall(text)


def offline(site: Path) -> Iterator[str]:
    """Complaints about files that load other files from the network."""
    for path in sorted(site.rglob("*")):
        if path.suffix in (".html", ".css", ".js", ".svg"):
            for address in remote(path):
                yield f"{path.relative_to(site)} loads {address}"


# Typical queries, and pages of which at least one must be among the first results.
FIRST = 5
QUESTIONS = {
    "units density discrete sqrt(Hz)": ("questions/density-or-discrete",),
    "noise density continuous or discrete": ("questions/density-or-discrete",),
    "bias instability random walk filter": ("questions/bias-instability-or-random-walk",),
    "gyroscope_random_walk bias instability": ("questions/bias-instability-or-random-walk",),
    "random walk from datasheet": ("questions/random-walk-from-a-datasheet",),
    "how long to record": ("questions/how-long-to-record",),
    "NaN short log": ("questions/nan-on-a-short-log",),
    "gaps": ("questions/gaps", "how-to/gaps"),
    "irregular time stamps": ("questions/gaps", "how-to/gaps"),
    "correlation time Gauss-Markov": ("questions/correlation-time",),
    "which axis": ("questions/which-axis",),
    "maximum or mean of three axes": ("questions/which-axis",),
    "inflate": ("questions/inflation",),
    "datasheet": ("questions/random-walk-from-a-datasheet", "how-to/datasheets"),
    "memory slow": ("questions/memory-and-time",),
    "ROS 2 bag": ("questions/install-and-ros",),
    "no IMU messages topic": ("questions/install-and-ros",),
    "falling tail": ("questions/falling-tail",),
    "curve falls at end": ("questions/falling-tail",),
}


def node() -> str | None:
    """Node.js of the system, or that of playwright."""
    if program := shutil.which("node"):
        return program
    try:
        from playwright._impl._driver import compute_driver_executable
    except ImportError:
        return None
    return str(compute_driver_executable()[0])


def pictures(site: Path) -> Iterator[str]:
    """Examples without a figure, which have a placeholder in the gallery."""
    for page in sorted((site / "examples").glob("plot_*.html")):
        if not (site / "_images" / f"sphx_glr_{page.stem}_001.png").exists():
            yield f"examples/{page.name}: no figure; draw it on axes of plt.subplots"


def searched(site: Path, queries: list[str]) -> dict[str, list[str]]:
    """Names of the pages that the search page of the site shows for each query, the best first."""
    program = node()
    if program is None:
        raise FileNotFoundError("the search cannot be tried without node (Node.js)")
    script = Path(__file__).with_name("search.js")
    done = subprocess.run([program, str(script), str(site), *queries], capture_output=True, text=True, check=True)
    pages: dict[str, list[str]] = json.loads(done.stdout)
    return pages


def search(site: Path) -> Iterator[str]:
    """Complaints about questions whose answer is not among the first results."""
    for query, results in searched(site, list(QUESTIONS)).items():
        if not any(name.startswith(QUESTIONS[query]) for name in results[:FIRST]):
            yield f"search for {query!r}: none of {', '.join(QUESTIONS[query])} in {', '.join(results[:FIRST])}"
