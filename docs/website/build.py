"""Build the documentation: ``python docs/website/build.py``; `make docs` does so.

The pages are collected in target/docs/source; the site is target/docs/html. A warning of Sphinx is an error.
"""

from __future__ import annotations

import itertools
import os
import shutil
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path[0] = str(Path(__file__).resolve().parents[1])


def _cpu() -> float:
    """CPU time so far, including ended processes. [s]"""
    return sum(os.times()[:4])


def main() -> int:
    """Build and check the site; return the exit code of the build, or 1 if a check fails."""
    from sphinx.cmd.build import main as sphinx

    from website import checks, excerpts
    from website.stage import DOCS, ROOT, add_alive, stage

    out = ROOT / "target" / "docs"
    shutil.rmtree(out, ignore_errors=True)
    times = [_cpu()]
    stage(out / "source")
    times.append(_cpu())
    options = ["-b", "html", "-c", str(DOCS), "-d", str(out / "doctrees"), "-j", "auto", "-q", "-W"]
    if status := sphinx([*options, str(out / "source"), str(out / "html")]):
        return status
    times.append(_cpu())
    excerpts.write(out / "html")
    add_alive(out / "html")
    complaints = [*checks.offline(out / "html"), *checks.pictures(out / "html")]
    if checks.node() is None and "--all" not in sys.argv:
        sys.stderr.write("The search was not tried: there is no node (Node.js).\n")
    else:
        complaints += checks.search(out / "html")
    sys.stderr.writelines(f"{complaint}\n" for complaint in complaints)
    times.append(_cpu())
    pages, made, checked = (f"{after - before:.0f} s" for before, after in itertools.pairwise(times))
    sys.stdout.write(
        f"   CPU: pages {pages}, Sphinx {made}, checks {checked}; {(out / 'html' / 'index.html').relative_to(ROOT)}\n"
    )
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
