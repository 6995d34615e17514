"""Three hosts in network namespaces, one of which is cut off in the middle: the run completes."""

import contextlib
import os
import shutil
import subprocess

import pytest
from fleets import Processes, contents, ended, make_logs

from conftest import skip_without

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

LOGS = 44
# A host that is gone answers nothing: this decides how soon the others notice. Dask's own values are 30 s and 5 minutes.
NOTICE = {
    "DASK_DISTRIBUTED__COMM__TIMEOUTS__TCP": "11s",
    "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "10s",
    "DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "8s",
}


def ip(*words):
    subprocess.run(["ip", *map(str, words)], check=True, capture_output=True, text=True)


class Hosts:
    """Network namespaces with an address each, joined by a bridge in another one."""

    def __init__(self, count):
        self.names = [f"st{os.getpid()}h{k}" for k in range(count)]
        self.hub = f"st{os.getpid()}hub"
        self.addresses = [f"10.213.7.{k + 1}" for k in range(count)]

    def __enter__(self):
        ip("netns", "add", self.hub)
        ip("-n", self.hub, "link", "add", "bridge", "type", "bridge")
        ip("-n", self.hub, "link", "set", "bridge", "up")
        for k, (name, address) in enumerate(zip(self.names, self.addresses, strict=True)):
            ip("netns", "add", name)
            ip("-n", self.hub, "link", "add", f"port{k}", "type", "veth", "peer", "name", "eth", "netns", name)
            ip("-n", self.hub, "link", "set", f"port{k}", "master", "bridge", "up")
            ip("-n", name, "address", "add", f"{address}/24", "dev", "eth")
            ip("-n", name, "link", "set", "eth", "up")
            ip("-n", name, "link", "set", "lo", "up")
        return self

    def __exit__(self, *_):
        for name in (*self.names, self.hub):
            with contextlib.suppress(subprocess.CalledProcessError):
                ip("netns", "delete", name)

    def on(self, host):
        """What runs a command on a host."""
        return ("ip", "netns", "exec", self.names[host])

    def cut_off(self, host):
        ip("-n", self.hub, "link", "set", f"port{host}", "down")


@pytest.fixture
def hosts():
    if shutil.which("ip") is None:
        pytest.skip("iproute2 is not installed: apt-get install iproute2")
    made = Hosts(3)
    try:
        made.__enter__()
    except subprocess.CalledProcessError as error:
        made.__exit__()
        pytest.skip(f"network namespaces are not permitted here: {error.stderr.strip()}")
    try:
        yield made
    finally:
        made.__exit__()


def test_a_host_is_cut_off(hosts, tmp_path):
    logs = make_logs(tmp_path / "logs", LOGS)
    with Processes(tmp_path) as processes:
        _, address = processes.scheduler(host=hosts.addresses[0], port=8786, prefix=hosts.on(0), settings=NOTICE)
        for host in range(3):
            processes.worker(address, pause=0.1, prefix=hosts.on(host), settings=NOTICE)
        process = processes.fleet(logs, "--store", "a.db", "--scheduler", address, prefix=hosts.on(0), **NOTICE)
        processes.wait_for_reads(18)
        assert len({worker for worker, _ in processes.reads()}) == 3
        hosts.cut_off(2)
        out, _ = ended(process)
    assert out == f"{LOGS} of {LOGS} logs analysed\n"
    found = contents(tmp_path / "a.db")
    assert len(found) == LOGS
    assert {state for state, _, _ in found.values()} == {"fitted"}
