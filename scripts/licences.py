#!/usr/bin/env python3
"""Write THIRD_PARTY_LICENSES: what is compiled into the extension or shipped beside it, with the texts of the licences.

``--check`` writes nothing, and fails if the file is not what would be written. ``--bill FILE`` writes the software bill of
materials of the wheels. Needs cargo and its downloaded crates.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FILE = ROOT / "THIRD_PARTY_LICENSES"
UPLOT = ROOT / "python" / "sigmatau" / "reporting" / "assets" / "uplot"
EXTENSION = "sigmatau-py"  # the crate that is linked into the extension
# Platforms of the wheels. A crate that is linked on one of them is listed.
TARGETS = (
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
    "x86_64-pc-windows-msvc",
)
# Preference among the licences that a crate offers.
CHOICES = ("MIT", "BSD-2-Clause", "BSD-3-Clause", "Zlib", "bzip2-1.0.6", "Apache-2.0")
# File of the licence in the folder of a crate: the first that exists.
FILES = {
    "MIT": ("LICENSE-MIT", "LICENSE-MIT.md", "LICENSE", "LICENSE.md", "LICENSE.txt"),
    "BSD-2-Clause": ("LICENSE-BSD", "LICENSE"),
    "BSD-3-Clause": ("LICENSE.BSD-3-Clause", "LICENSE"),
    "Zlib": ("LICENSE-ZLIB", "LICENSE"),
    "bzip2-1.0.6": ("LICENSE",),
    "Apache-2.0": ("LICENSE-APACHE",),
}
# C code in the folder of a crate, with a separate licence.
VENDORED = {"zstd-sys": ("Zstandard (C library in zstd-sys)", "BSD-3-Clause", "zstd/LICENSE")}
# Crates without a text, which use that of another crate of the same repository and authors.
OTHER_TEXT = {"pulp-wasm-simd-flag": "pulp"}
# The compiler links its standard library into every extension. Its text is not among the crates.
STANDARD_LIBRARY = (
    "Rust standard library, with the crates that it contains (gimli, hashbrown, rustc-demangle and others)"
)

_OURS = (ROOT / "LICENSE-MIT").read_text(encoding="utf-8")
MIT_TERMS = " ".join(_OURS[_OURS.index("Permission") :].split())  # the words that nearly all crates share

HEAD = """\
Third-party licences

sigmatau is available under the MIT licence or the Apache licence 2.0, at your choice (LICENSE-MIT, LICENSE-APACHE).
The compiled extension and the reports contain the software of this list. Where a project offers several licences,
the list names the one that is used here. The texts are below the list.

Written by scripts/licences.py from Cargo.lock and the sources of the crates.
"""


@dataclass(frozen=True, order=True)
class Component:
    """Shipped software: name with version, licence and text."""

    name: str
    licence: str
    text: str


def metadata() -> dict[str, Any]:
    """The dependency graph of the workspace on all platforms of the wheels."""
    targets = [word for target in TARGETS for word in ("--filter-platform", target)]
    command = ["cargo", "metadata", "--format-version=1", "--locked", *targets]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode:
        sys.exit(f"cargo metadata failed: {done.stderr.strip()}")
    graph: dict[str, Any] = json.loads(done.stdout)
    return graph


def linked(graph: dict[str, Any]) -> list[dict[str, Any]]:
    """Packages of crates.io that are linked into the extension: no build scripts, procedural macros or tests."""
    packages = {package["id"]: package for package in graph["packages"]}
    edges = {node["id"]: node["deps"] for node in graph["resolve"]["nodes"]}
    todo = [identifier for identifier, package in packages.items() if package["name"] == EXTENSION]
    identifiers: set[str] = set()
    while todo:
        identifier = todo.pop()
        if identifier in identifiers:
            continue
        identifiers.add(identifier)
        for edge in edges[identifier]:
            macro = any("proc-macro" in target["kind"] for target in packages[edge["pkg"]]["targets"])
            if not macro and any(kind["kind"] is None for kind in edge["dep_kinds"]):
                todo.append(edge["pkg"])
    return sorted(
        (packages[identifier] for identifier in identifiers if packages[identifier]["source"]),
        key=lambda package: package["name"],
    )


def chosen(package: dict[str, Any]) -> str:
    """Choose a licence among those that a crate offers."""
    offered = re.split(r"\s+OR\s+|/", package["license"] or "")
    for licence in CHOICES:
        if licence in offered:
            return licence
    sys.exit(f"{package['name']}: no rule for the licence {package['license']!r}; see CHOICES of scripts/licences.py")


def text_in(folder: Path, licence: str) -> str | None:
    """The text of the licence among the files of a crate."""
    for name in FILES[licence]:
        if (folder / name).is_file():
            return (folder / name).read_text(encoding="utf-8")
    return None


def components(graph: dict[str, Any]) -> Iterator[Component]:
    """Third-party components that are shipped."""
    folders = {package["name"]: Path(package["manifest_path"]).parent for package in graph["packages"]}
    for package in linked(graph):
        name, licence = package["name"], chosen(package)
        text = text_in(folders[OTHER_TEXT.get(name, name)], licence)
        if text is None:
            sys.exit(f"{name}: no text of the licence {licence} in {folders[name]}; see TEXT_OF of scripts/licences.py")
        yield Component(f"{name} {package['version']}", licence, text)
        if name in VENDORED:
            title, licence, path = VENDORED[name]
            yield Component(title, licence, (folders[name] / path).read_text(encoding="utf-8"))
    version = re.search(r"\(v([\d.]+)\)", (UPLOT / "uPlot.iife.min.js").read_text(encoding="utf-8")[:200])
    if version is None:
        sys.exit(f"{UPLOT}: no version in the first line of uPlot")
    yield Component(f"uPlot {version[1]} (in reports)", "MIT", (UPLOT / "LICENSE").read_text(encoding="utf-8"))
    owner = "Copyright (c) The Rust Project Contributors"
    unicode = folders["unicode-ident"] / "LICENSE-UNICODE"  # another crate, which is not linked, has the same tables
    yield Component("Unicode tables (in the Rust standard library)", "Unicode-3.0", unicode.read_text(encoding="utf-8"))
    yield Component(STANDARD_LIBRARY, "MIT", re.sub(r"Copyright .*", owner, _OURS))


def crate_component(package: dict[str, Any], checksum: str) -> dict[str, Any]:
    """Describes a crate as CycloneDX does."""
    url = f"pkg:cargo/{package['name']}@{package['version']}"
    return {
        "type": "library",
        "bom-ref": url,
        "name": package["name"],
        "version": package["version"],
        "purl": url,
        "licenses": [{"license": {"id": chosen(package)}}],
        "hashes": [{"alg": "SHA-256", "content": checksum}],
        "scope": "required",
    }


def bill_of_materials(graph: dict[str, Any]) -> dict[str, Any]:
    """The linked crates as a CycloneDX 1.5 bill, with the checksums of Cargo.lock.

    maturin could write one, but its bill names folders of the machine that built the wheel.
    """
    locked = tomllib.loads((ROOT / "Cargo.lock").read_text(encoding="utf-8"))["package"]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    packages = {package["id"]: package for package in graph["packages"]}
    checksums = {(row["name"], row["version"]): row["checksum"] for row in locked if "checksum" in row}
    crates = linked(graph)
    components = [crate_component(crate, checksums[crate["name"], crate["version"]]) for crate in crates]
    references = {crate["id"]: row["bom-ref"] for crate, row in zip(crates, components, strict=True)}
    wheel = f"pkg:pypi/{project['name']}@{project['version']}"
    edges: dict[str, set[str]] = {wheel: set()} | {reference: set() for reference in references.values()}
    for node in graph["resolve"]["nodes"]:
        targets = {references[edge["pkg"]] for edge in node["deps"] if edge["pkg"] in references}
        if node["id"] in references:
            edges[references[node["id"]]] |= targets
        elif packages[node["id"]]["source"] is None:  # a crate of this workspace
            edges[wheel] |= targets
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {
            "component": {
                "type": "library",
                "bom-ref": wheel,
                "name": project["name"],
                "version": project["version"],
                "purl": wheel,
                "licenses": [{"expression": project["license"]}],
            }
        },
        "components": components,
        "dependencies": [{"ref": reference, "dependsOn": sorted(edges[reference])} for reference in sorted(edges)],
    }


def parted(text: str) -> tuple[list[str], str]:
    """Split a text into the lines above the words of the MIT licence, without its title, and those words; without these
    words, nothing and the whole text.
    """
    flat = text.replace("“", '"').replace("”", '"')
    start = flat.find("Permission is hereby granted")
    if start < 0 or " ".join(flat[start:].split()) != MIT_TERMS:
        return [], text.strip("\n")
    lines = [line.strip() for line in flat[:start].splitlines()]
    return [line for line in lines if line and not re.fullmatch(r"\W*(The )?MIT License\W*(\(MIT\))?", line)], MIT_TERMS


def render(graph: dict[str, Any]) -> str:
    """Render the file: a list of all components, then each text once, with the copyright owners above it."""
    every = list(components(graph))
    width = max(len(component.name) for component in every if component.name != STANDARD_LIBRARY)
    pages = [HEAD, "".join(f"{component.name:{width}}  {component.licence}\n" for component in every)]
    texts: dict[str, list[Component]] = {}
    for component in every:
        texts.setdefault(parted(component.text)[1], []).append(component)
    for terms, members in texts.items():
        page = ["-" * 100, "", f"{members[0].licence}, of:", ""]
        for component in members:
            page.append(f"  {component.name}")
            page += [f"    {owner}" for owner in parted(component.text)[0]]
        shown = _OURS[_OURS.index("Permission") :].strip() if terms == MIT_TERMS else terms
        pages.append("\n".join([*page, "", *(line.rstrip() for line in shown.splitlines()), ""]))
    return "\n".join(pages)


def main() -> int:
    """Do what the command line says."""
    if "--bill" in sys.argv[1:]:
        bill = bill_of_materials(metadata())
        Path(sys.argv[-1]).write_text(json.dumps(bill, indent=1) + "\n", encoding="utf-8")
        return 0
    text = render(metadata())
    if "--check" in sys.argv[1:]:
        if FILE.read_text(encoding="utf-8") != text:
            sys.stderr.write(f"{FILE.name} is out of date: run scripts/licences.py\n")
            return 1
        return 0
    FILE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
