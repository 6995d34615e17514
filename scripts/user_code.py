"""Check the types of user code, the Python of the README and the use of results, with our strict mypy settings.

    python scripts/user_code.py

It runs after mypy of the package, and takes a second with its cache.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

# Use of the names of the README; a type that a user must narrow would be an error here.
TYPED = """
noise: float = walk.to("deg/sqrt(h)")
ends: tuple[float | None, float | None] = (walk.low, walk.high)
largest: float | None = limit
text: str = analysis.export(to="kalibr")
lines: list[str] = st.export(analysis.model, to="gtsam").splitlines()
modelled: float = analysis.model["gyro_x"]["random_walk"]
longest: float = float(curve.tau[-1])
"""


def main() -> int:
    """Write the code to a file and check it; return the exit code of mypy."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```", readme, flags=re.MULTILINE | re.DOTALL)
    if not blocks:
        raise SystemExit("README.md has no Python")
    with tempfile.TemporaryDirectory() as folder:
        code = Path(folder) / "user_code.py"
        code.write_text("\n".join(blocks) + TYPED, encoding="utf-8")
        return subprocess.run([sys.executable, "-m", "mypy", str(code)], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    raise SystemExit(main())
