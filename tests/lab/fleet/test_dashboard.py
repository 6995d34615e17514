"""The dashboard of a fleet on the loopback."""

import socket
import urllib.request

import pytest
from fleets import Processes, ended, free_port, make_logs

from conftest import skip_without
from sigmatau.cli import main

skip_without("distributed", "fleets need the extra cluster")
skip_without("bokeh", "the dashboard needs the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")


def test_the_page_is_on_the_loopback_while_the_command_runs(tmp_path):
    logs, port = make_logs(tmp_path / "logs", 4), free_port()
    with Processes(tmp_path) as processes:
        process = processes.fleet(logs, "--store", "lab.db", "--workers", 1, "--dashboard", port, pause=1.5)
        processes.wait_for_reads(1)
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/status", timeout=20) as page:
            assert "Dask" in page.read().decode()
        _, err = ended(process)
    assert err.splitlines()[0] == f"dashboard: http://127.0.0.1:{port}/status"


def test_a_port_in_use_is_an_error(tmp_path, capsys):
    logs = make_logs(tmp_path / "logs", 1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert main(["fleet", "analyze", str(logs), "--store", str(tmp_path / "lab.db"), "--dashboard", str(port)]) == 1
    assert f"port {port} of the dashboard: Address already in use; choose another port" in capsys.readouterr().err


@pytest.mark.parametrize("further", [("0",), ("70000",), ("8787", "--scheduler", "tcp://127.0.0.1:1")])
def test_wrong_options_of_the_dashboard(further, tmp_path, capsys):
    assert main(["fleet", "analyze", str(tmp_path), "--store", str(tmp_path / "lab.db"), "--dashboard", *further]) == 2
    assert f"--dashboard {further[0]}: " in capsys.readouterr().err
