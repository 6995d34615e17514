"""A wall clock that jumps by hours during a fleet: every log is once in the store, with the digits of another run."""

import time

from fleets import HOOK, Processes, contents, ended, make_logs

from conftest import skip_without

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

LOGS = 40
JUMPS = """
import os, time

def jump():
    \"\"\"An hour forward 5 s after the start of the fleet, two hours back 3 s later.\"\"\"
    true, true_ns, begun = time.time, time.time_ns, float(os.environ["CLOCK_BEGUN"])
    def shift():
        passed = true() - begun
        return 0.0 if passed < 5 else 3600.0 if passed < 8 else -7200.0
    time.time = lambda: true() + shift()
    time.time_ns = lambda: true_ns() + int(1e9 * shift())

jump()
"""


def test_the_clock_jumps_during_a_fleet(tmp_path):
    logs = make_logs(tmp_path / "logs", LOGS)
    with Processes(tmp_path) as processes:
        ended(processes.fleet(logs, "--store", "even.db", "--workers", 1))
        (tmp_path / "sitecustomize.py").write_text(JUMPS + HOOK)
        begun = time.time()
        jumped = processes.fleet(logs, "--store", "jumped.db", "--workers", 2, pause=0.5, CLOCK_BEGUN=str(begun))
        out, err = ended(jumped)
        assert time.time() - begun > 8
    assert out == f"{LOGS} of {LOGS} logs analysed\n"
    assert "Traceback" not in err
    assert contents(tmp_path / "jumped.db") == contents(tmp_path / "even.db")
    assert len(contents(tmp_path / "even.db")) == LOGS
