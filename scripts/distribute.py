#!/usr/bin/env python3
"""Make and check the release files: one source distribution, and wheels built from it.

``distribute.py sdist``            dist/sigmatau-VERSION.tar.gz, with the man pages and the README of the package index
``distribute.py wheel [--target TRIPLE] [--zig]``   a wheel from that file; ``--zig`` links for glibc 2.17 (manylinux2014)
``distribute.py check``            contents, sizes, symbols and paths of all files in dist/
``distribute.py recipe``           the conda recipe, rendered for all platforms; needs py-rattler-build

Needs maturin on the path or next to this Python, and ziglang for ``--zig``. ``sdist`` needs the built package.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import struct
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DIST = ROOT / "dist"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NAME = f"{PROJECT['name']}-{PROJECT['version']}"
PYTHON_TAG = "cp311-abi3"  # one wheel per platform, for Python 3.11 and later
GLIBC = (2, 17)  # newest symbols of glibc that a wheel may need: manylinux2014
LARGEST = 4_000_000  # of a distribution [bytes]; the largest of November 2026 has 2.8 MB
BILL = "sbom.cdx.json"  # software bill of materials, CycloneDX
LICENCES = ("LICENSE-MIT", "LICENSE-APACHE", "THIRD_PARTY_LICENSES")
# Files that a wheel must contain. Tests in the source tree do not detect a missing one.
NEEDED = (
    "sigmatau/__init__.py",
    "sigmatau/__init__.pyi",
    "sigmatau/py.typed",
    "sigmatau/data/hg1700.toml",
    "sigmatau/data/datasheets/bmi088.toml",
    "sigmatau/reporting/assets/uplot/LICENSE",
    "sigmatau/reporting/assets/uplot/uPlot.iife.min.js",
    "sigmatau/reporting/assets/report.typ",
    "sigmatau/schema/result-2.schema.json",
    f"{NAME}.data/data/share/man/man1/sigmatau.1",
    f"{NAME}.data/data/share/man/man1/sigmatau-analyze.1",
    *(f"{NAME}.dist-info/licenses/{name}" for name in LICENCES),
    "sigmatau/app/page/index.html",
    f"{NAME}.dist-info/sboms/{BILL}",
)
# Files that a source distribution must contain besides those of the wheel.
NEEDED_OF_SOURCE = ("Cargo.lock", "README.md", "pyproject.toml", "tests/smoke.py", *LICENCES)
CONDA_PLATFORMS = ("linux-64", "linux-aarch64", "osx-64", "osx-arm64", "win-64")
_SYMBOL_TABLE = 2  # type of a section of an ELF file: SHT_SYMTAB


def run(*command: str | Path, cwd: Path = ROOT, **variables: str) -> None:
    """Run a command with further environment variables; end the program if it fails."""
    done = subprocess.run([str(word) for word in command], cwd=cwd, env=os.environ | variables, check=False)
    if done.returncode:
        sys.exit(f"failed: {' '.join(str(word) for word in command)}")


def maturin() -> str:
    """Program maturin of this environment."""
    neighbour = Path(sys.executable).with_name("maturin" + (".exe" if os.name == "nt" else ""))
    program = str(neighbour) if neighbour.exists() else shutil.which("maturin")
    if program is None:
        sys.exit("maturin is not installed: pip install maturin")
    return program


def sdist() -> None:
    """Build the source distribution from a copy of the tracked files; the tree does not change."""
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / NAME
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout
        for name in listed.decode().split("\0"):
            if name and (ROOT / name).is_file():
                (stage / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, stage / name)
        path = os.pathsep.join([str(ROOT / "python"), *filter(None, [os.environ.get("PYTHONPATH")])])
        man = stage / "sigmatau.data" / "data" / "share" / "man" / "man1"
        run(sys.executable, ROOT / "scripts" / "manual.py", man, PYTHONPATH=path)
        run(sys.executable, stage / "scripts" / "long_description.py", "-o", stage / "README.md")
        run(sys.executable, ROOT / "scripts" / "licences.py", "--bill", stage / BILL)
        settings = stage / "pyproject.toml"
        text = settings.read_text(encoding="utf-8")
        settings.write_text(
            text.replace("[tool.maturin]\n", '[tool.maturin]\ndata = "sigmatau.data"\n').replace(
                "[tool.maturin.sbom]\n", f'[tool.maturin.sbom]\ninclude = ["{BILL}"]\n'
            ),
            encoding="utf-8",
        )
        run(maturin(), "sdist", "--out", DIST, cwd=stage)


def wheel(target: str | None, *, zig: bool) -> None:
    """Build a wheel from the source distribution, without paths of this machine."""
    source = DIST / f"{NAME}.tar.gz"
    if not source.exists():
        sys.exit(f"{source} is missing: run distribute.py sdist first")
    # The folder is always the same: its name is in the flags, on which all crates depend.
    folder = ROOT / "target" / "from-sdist"
    shutil.rmtree(folder, ignore_errors=True)
    with tarfile.open(source) as archive:
        # Python 3.11.2 of Debian 12 has no filters; later versions require one.
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(folder)
    tree = folder / NAME
    cargo = Path(os.environ.get("CARGO_HOME", Path.home() / ".cargo")).resolve()
    renamed = {str(tree): "sigmatau", str(cargo): "cargo"}
    command = [maturin(), "build", "--release", "--locked", "--out", str(DIST)]
    if target:
        command += ["--target", target]
    # zig links for the glibc of the tag; with "pypi" it would use its newest glibc.
    command += ["--zig", "--compatibility", "manylinux2014"] if zig else ["--compatibility", "pypi"]
    flags = {"CARGO_ENCODED_RUSTFLAGS": "\x1f".join(f"--remap-path-prefix={old}={new}" for old, new in renamed.items())}
    if os.name != "nt":  # flags for C code; the compiler of Windows has no such option
        prefixes = [f"-ffile-prefix-map={old}={new}" for old, new in renamed.items()]
        flags["CFLAGS"] = " ".join([os.environ.get("CFLAGS", ""), *prefixes]).strip()
    flags["CARGO_TARGET_DIR"] = os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target" / "wheel"))
    # maturin finds zig through the first python3 on the path
    flags["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    run(*command, cwd=tree, **flags)


def faults_of_wheel(path: Path) -> Iterator[str]:
    """Find the faults of a wheel."""
    with zipfile.ZipFile(path) as archive:
        contents = {info.filename: archive.read(info) for info in archive.infolist() if not info.is_dir()}
    if not path.name.startswith(f"{NAME}-{PYTHON_TAG}-"):
        yield f"the name is not {NAME}-{PYTHON_TAG}-…"
    if path.name.endswith("-linux_x86_64.whl") or path.name.endswith("-linux_aarch64.whl"):
        yield "the wheel is not a manylinux wheel; the package index takes no other for Linux"
    yield from (f"{name} is missing" for name in NEEDED if name not in contents)
    for name, content in contents.items():
        if not name.startswith(("sigmatau/", f"{NAME}.dist-info/", f"{NAME}.data/data/share/man/man1/")):
            yield f"{name} does not belong into a wheel"
        if "__pycache__" in name or name.endswith((".pyc", ".rs", ".orig")) or re.match(r"sigmatau/tests?/", name):
            yield f"{name} does not belong into a wheel"
        yield from (f"{name} contains the path {place}" for place in paths_of_the_machine(content))
        if name.endswith((".so", ".pyd")):
            yield from (f"{name}: {fault}" for fault in faults_of_library(content))
    libraries = [name for name in contents if name.endswith((".so", ".pyd", ".dll", ".dylib"))]
    if len(libraries) != 1:
        yield f"one library is expected, not {libraries}"
    metadata = contents.get(f"{NAME}.dist-info/METADATA", b"").decode()
    if "](docs/" in metadata:
        yield "the long description has relative links"


def paths_of_the_machine(content: bytes) -> list[str]:
    """Folders of the build machine that a file names."""
    places = {str(Path.home()), str(ROOT), tempfile.gettempdir(), os.environ.get("CARGO_HOME", "")} - {"", "/"}
    return sorted(place for place in places if re.search(re.escape(place.encode()) + rb"[/\\]", content))


def faults_of_library(content: bytes) -> Iterator[str]:
    """Faults of a compiled library; only ELF is examined."""
    if content[:4] != b"\x7fELF":
        return
    if _SYMBOL_TABLE in section_types(content):
        yield "not stripped"
    newest = max(((int(a), int(b)) for a, b in re.findall(rb"GLIBC_(\d+)\.(\d+)", content)), default=GLIBC)
    if newest > GLIBC:
        yield f"needs glibc {newest[0]}.{newest[1]}, newer than {GLIBC[0]}.{GLIBC[1]}"


def section_types(content: bytes) -> list[int]:
    """Types of the sections of a 64-bit little-endian ELF file."""
    (start,) = struct.unpack_from("<Q", content, 0x28)
    size, count = struct.unpack_from("<HH", content, 0x3A)
    return [struct.unpack_from("<I", content, start + place * size + 4)[0] for place in range(count)]


def faults_of_source(path: Path) -> Iterator[str]:
    """Faults of a source distribution."""
    with tarfile.open(path) as archive:
        members = [member for member in archive.getmembers() if member.isfile()]
        contents = {member.name: archive.extractfile(member).read() for member in members}  # type: ignore[union-attr]
    sources = [name.replace("sigmatau/", "python/sigmatau/", 1) for name in NEEDED if name.startswith("sigmatau/")]
    man = "sigmatau.data/data/share/man/man1/sigmatau.1"
    for name in (*sources, man, BILL, *NEEDED_OF_SOURCE):
        if f"{NAME}/{name}" not in contents:
            yield f"{name} is missing"
    for name, content in contents.items():
        if name.endswith((".so", ".pyc", ".pyd")) or "/target/" in name:
            yield f"{name} does not belong into a source distribution"
        yield from (f"{name} contains the path {place}" for place in paths_of_the_machine(content))


def check() -> int:
    """Report the faults of the files in dist/; return 1 if there are any."""
    files = sorted(DIST.glob(f"{NAME}*"))
    if not files:
        sys.exit(f"nothing to check in {DIST}")
    wrong = 0
    for path in files:
        faults = list(faults_of_wheel(path) if path.suffix == ".whl" else faults_of_source(path))
        if path.stat().st_size > LARGEST:
            faults.append(f"{path.stat().st_size} bytes, more than {LARGEST}")
        sys.stdout.write(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB, {'FAULTS' if faults else 'good'}\n")
        sys.stdout.writelines(f"  {fault}\n" for fault in faults)
        wrong += len(faults)
    return int(wrong > 0)


def recipe() -> None:
    """Render the conda recipe for each platform, with the versions of conda-forge."""
    import rattler_build

    text = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    pins = {"python": ["3.11.* *_cpython"], "c_compiler": ["gcc"], "rust_compiler": ["rust"], "c_stdlib": ["sysroot"]}
    for platform in CONDA_PLATFORMS:
        config = rattler_build.RenderConfig(platform=rattler_build.PlatformConfig(target_platform=platform))
        variants = rattler_build.VariantConfig(pins)
        (made,) = rattler_build.Stage0Recipe.from_yaml(text).render(variants, config)
        sys.stdout.write(
            f"{platform}: {made.recipe.package.name} {made.recipe.package.version}, build {made.recipe.build.string}\n"
        )


def main() -> int:
    """Run the command of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["sdist", "wheel", "check", "recipe"])
    parser.add_argument("--target", help="Rust target triple of the wheel; default: this machine's")
    parser.add_argument("--zig", action="store_true", help="compile C and link with zig")
    options = parser.parse_args()
    DIST.mkdir(exist_ok=True)
    if options.what == "sdist":
        sdist()
    elif options.what == "wheel":
        wheel(options.target, zig=options.zig)
    elif options.what == "recipe":
        recipe()
    else:
        return check()
    return 0


if __name__ == "__main__":
    sys.exit(main())
