"""Processes ended by SIGKILL leave the old output or the whole new one; the next run removes their temporary files."""

import json
import os
import subprocess
import sys

import pytest

from conftest import ROOT

KILLS = int(os.environ.get("SIGMATAU_KILLS", "8"))  # of each kind; `make fuzz` ends 200

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no forks")


@pytest.mark.parametrize("kind", ["json", "migration", "report", "archive"])
def test_outputs_are_old_or_new(tmp_path, kind):
    if kind == "migration":
        pytest.importorskip("sqlalchemy")
    command = [sys.executable, "tests/killed.py", kind, str(tmp_path), str(KILLS)]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    outcomes = json.loads(ended.stdout)
    print(kind, outcomes)
    assert outcomes["old"] + outcomes["new"] == KILLS
    assert outcomes["old"] > 0
