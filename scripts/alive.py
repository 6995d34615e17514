"""Put the theory page together: ``scripts/alive.py MODULE.wasm OUTPUT.html``; `make alive` does so.

The page is one file that opens without a network and without a server: the scripts of crates/web/page and the numbers and
colours of the report, as one script each for the page and its workers, the module, compressed, in base 64, and the licences
of the crates in it.
"""

from __future__ import annotations

import base64
import gzip
import html
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "crates" / "web" / "page"
ASSETS = ROOT / "python" / "sigmatau" / "reporting" / "assets"

# A script comes after those whose constants it reads.
SCRIPTS = ["core", "settings", "sampled", "chart", "figures", "read_off", "results", "lengths", "log", "main"]
OF_PAGE = (ASSETS / "page.js", ASSETS / "numbers.js", *(PAGE / f"{name}.js" for name in SCRIPTS))
OF_WORKER = (PAGE / "core.js", PAGE / "worker.js")

_MODULE_WORDS = re.compile(r"^(import .*;\n|export )", re.MULTILINE)


def bundled(scripts: tuple[Path, ...]) -> str:
    """Modules without imports and exports, which share one scope."""
    text = "\n".join(script.read_text(encoding="utf-8") for script in scripts)
    return f'(() => {{\n"use strict";\n{_MODULE_WORDS.sub("", text)}\n}})();'


def page(module: bytes) -> str:
    """The page with a module."""
    style = (ASSETS / "report.css").read_text(encoding="utf-8") + (PAGE / "alive.css").read_text(encoding="utf-8")
    licences = (ROOT / "THIRD_PARTY_LICENSES").read_text(encoding="utf-8")
    parts = {
        "style": style,
        "core": base64.b64encode(gzip.compress(module, mtime=0)).decode("ascii"),
        "worker": bundled(OF_WORKER),
        "script": bundled(OF_PAGE),
        "licences": html.escape(licences, quote=False),
    }
    text = (PAGE / "index.html").read_text(encoding="utf-8")
    for name, part in parts.items():
        if "</script" in part.lower():
            raise ValueError(f"the {name} of the page would end its element: it contains </script")
        text = text.replace(f"/* {name} */", part, 1)
    return text


def main() -> int:
    """Write the page."""
    module, output = map(Path, sys.argv[1:])
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(page(module.read_bytes()), encoding="utf-8")
    size = module.stat().st_size
    sys.stdout.write(f"   {output}: {output.stat().st_size / 1e3:.0f} kB, with a module of {size / 1e3:.0f} kB\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
