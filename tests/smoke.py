"""Smoke test of an installed package, in an environment with only its core dependencies.

    python tests/smoke.py               # everything, about 15 s
    python tests/smoke.py --no-demo     # without the two hours of the demo, about 5 s

It needs neither compiler, network, pytest nor source tree. It fails with the assertion that does not hold.
"""

import argparse
import json
import os
import subprocess
import sys
import sysconfig
import tempfile
from importlib import metadata, resources
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import sigmatau as st

# Commands that need an extra, and the extra that their messages must name. Installed modules are skipped.
EXTRAS = {
    "matplotlib": ("plot", ["analyze", "log.csv", "--plot", "figure.png"]),
    "typst": ("pdf", ["analyze", "log.csv", "--report", "report.pdf"]),
    "pypdfium2": ("figure", ["curve", "figure.pdf", "--unit", "deg/h"]),
    "starlette": ("app", ["app", "--no-browser"]),
    "sqlalchemy": ("store", ["store", "add", "result.json", "--store", "lab.db"]),
    "pyarrow": ("parquet", ["simulate", "unit.toml", "--hours", "0.01", "--rate", "100", "-o", "log.parquet"]),
}


def sigmatau(*arguments, code=0):
    """Run the command like a user; return its output."""
    done = subprocess.run(
        [sys.executable, "-m", "sigmatau", *arguments], capture_output=True, text=True, encoding="utf-8", check=False
    )
    assert done.returncode == code, f"sigmatau {' '.join(arguments)}: exit code {done.returncode}\n{done.stderr}"
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout, done.stderr


def installed_files():
    """Check that the package is complete, and of one version."""
    assert metadata.version("sigmatau") == st.__version__
    for name in st.__all__:
        try:
            getattr(st, name)
        except ImportError as error:
            assert name == "Store", name
            assert find_spec("sqlalchemy") is None
            assert "sigmatau[store]" in str(error), error  # noqa: PT017  there is no pytest
    files = resources.files("sigmatau")
    for name in ("py.typed", "data/hg1700.toml", "schema/result-2.schema.json", "reporting/assets/uplot/LICENSE"):
        assert files.joinpath(*name.split("/")).is_file(), f"{name} is not installed"
    licences = {Path(str(file)).name for file in metadata.files("sigmatau") or [] if "licenses" in str(file)}
    assert {"LICENSE-MIT", "LICENSE-APACHE", "THIRD_PARTY_LICENSES"} <= licences, licences
    assert len(st.list_datasheets()) > 20


def numbers():
    """Check that the coefficients of a simulated sensor are recovered and that the threads of the extension start."""
    model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-3}, "accel_x": {"random_walk": 2e-3}})
    record = st.simulate(model, duration=1000, rate=100, rng=1)
    analysis = st.analyze(record)
    for name, truth in (("gyro_x", 1e-3), ("accel_x", 2e-3)):
        walk = analysis[name]["random_walk"]
        # 1e5 samples: the standard deviation of a random walk is 0.22 %. The tolerance is five of them; the seed is fixed.
        assert abs(walk.value / truth - 1) < 0.011, walk
        assert walk.low < walk.value < walk.high
    curve = analysis.curves["gyro_x"]
    assert np.all(np.diff(curve.tau) > 0)
    assert "random walk" in str(analysis)


def commands():
    """Check that each group of commands works, and that commands without their extra name it."""
    out, _ = sigmatau("--version")
    assert out.strip() == f"sigmatau {st.__version__}"
    channels = (
        '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\n[channels.accel_x]\nrandom_walk = "0.05 m/s/sqrt(h)"\n'
    )
    Path("unit.toml").write_text(channels, encoding="utf-8")
    sigmatau("simulate", "unit.toml", "--hours", "0.1", "--rate", "100", "--seed", "1", "-o", "log.csv")
    out, _ = sigmatau("inspect", "log.csv")
    assert "gyro_x" in out
    sigmatau("analyze", "log.csv", "--json", "result.json", "--report", "report.html", "--export", "gtsam=gtsam.json")
    assert json.loads(Path("result.json").read_text(encoding="utf-8"))["schema"] == 2
    page = Path("report.html").read_text(encoding="utf-8")
    assert "uPlot" in page
    assert "gyro_x" in page
    sigmatau("plan", "result.json", "--term", "bias_instability", "--hours", "12")
    for module, (extra, arguments) in EXTRAS.items():
        if find_spec(module) is None:
            _, err = sigmatau(*arguments, code=1)
            assert f"sigmatau[{extra}]" in err, f"{arguments}: the message does not name the extra {extra}: {err}"


def manual():
    """Check that the man pages are where `man` finds them if the environment is on the path."""
    page = Path(sysconfig.get_path("data")) / "share" / "man" / "man1" / "sigmatau.1"
    assert page.is_file(), f"{page} is not installed"


def demo():
    """Two hours of six axes, with the report."""
    out, _ = sigmatau("demo", "--output", "demo", "--quiet")
    assert "truth" in out
    names = sorted(path.name for path in Path("demo").iterdir())
    assert names == ["hg1700.toml", "report.html", "result.json", "static.csv"], names
    assert (
        "<svg" in Path("demo/report.html").read_text(encoding="utf-8")
        or Path("demo/report.html").stat().st_size > 100_000
    )


def main():
    """Run all in an empty folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--no-demo", action="store_true")
    parser.add_argument(
        "--no-manual", action="store_true", help="of a package that was not made by scripts/distribute.py"
    )
    options = parser.parse_args()
    assert "site-packages" in str(st.__file__), f"not the installed package: {st.__file__}"
    checks = [installed_files, numbers, commands]
    checks += [] if options.no_manual else [manual]
    checks += [] if options.no_demo else [demo]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for check in checks:
            check()
            print(f"{check.__name__}: passed")
        os.chdir(Path(folder).parent)
    print(f"{len(checks)} passed, 0 failed, Python {sys.version.split()[0]}, NumPy {np.__version__}")


if __name__ == "__main__":
    main()
