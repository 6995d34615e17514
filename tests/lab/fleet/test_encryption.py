"""The commands of docs/how-to/fleet.md about encryption: certificate, settings, scheduler, worker and client."""

import re
import shutil
import subprocess

import pytest
from fleets import Processes, contents, ended, free_port, make_logs

from conftest import ROOT, skip_without

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

PAGE = (ROOT / "docs" / "how-to" / "fleet.md").read_text(encoding="utf-8").partition("### Encryption")[2]


def block(language):
    """The first block of the section in a language."""
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[1]


@pytest.mark.skipif(shutil.which("openssl") is None, reason="no openssl")
def test_the_page_makes_a_fleet_with_tls(tmp_path):
    subprocess.run(block("sh"), shell=True, check=True, cwd=tmp_path, capture_output=True)
    config = tmp_path / "config"
    config.mkdir()
    settings = block("yaml").replace("/home/lab", str(tmp_path))
    assert settings.count(str(tmp_path / "fleet.key")) == 3
    (config / "tls.yaml").write_text(settings)
    logs, port = make_logs(tmp_path / "logs", 6), free_port()
    address = f"tls://127.0.0.1:{port}"
    encrypted = {"DASK_CONFIG": str(config)}
    with Processes(tmp_path) as processes:
        listening = ("--protocol", "tls", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--no-show")
        processes.start("-m", "distributed.cli.dask_scheduler", *listening, **encrypted)
        processes.worker(address, settings=encrypted)
        fleet = processes.fleet(logs, "--store", "lab.db", "--scheduler", address, **encrypted)
        assert ended(fleet)[0] == "6 of 6 logs analysed\n"
        assert len(contents(tmp_path / "lab.db")) == 6
        for wrong, settings in ((address, {}), (f"tcp://127.0.0.1:{port}", {}), (f"tcp://127.0.0.1:{port}", encrypted)):
            fleet = processes.fleet(logs, "--store", "other.db", "--scheduler", wrong, **settings)
            _, err = ended(fleet, code=1)
            assert err.startswith(f"sigmatau: {wrong}: ")
            assert "Traceback" not in err
            assert len(err.splitlines()) == 1
