"""What a fleet says of schedulers and workers that cannot do its work, before a log is blamed for it."""

import socket
from ipaddress import ip_address

import pytest

from conftest import skip_without
from sigmatau._version import __version__
from sigmatau.errors import DataError
from sigmatau.lab.fleet import run
from sigmatau.lab.fleet.logs import Log
from sigmatau.lab.fleet.tasks import FleetJob
from sigmatau.lab.store.naming import Naming

skip_without("distributed", "fleets need the extra cluster")
skip_without("sqlalchemy", "fleets need the extra store")

JOB = FleetJob(reading={}, settings={}, naming=Naming(folders=True))


class Scheduler:
    """A client of a scheduler with some workers, which run what they are sent."""

    cluster = None
    status = "running"

    def __init__(self, **versions):
        self.versions = versions
        self.asked = []

    def scheduler_info(self, n_workers):
        return {"workers": {}}

    def nthreads(self):
        return dict.fromkeys(self.versions, 1)

    def run(self, function, *arguments, workers, on_error):
        assert on_error == "return"
        assert function(*arguments) == __version__  # what every worker is asked for
        self.asked.append(sorted(workers))
        return {worker: self.versions[worker] for worker in workers}

    def cancel(self, futures, *, force):
        pass


@pytest.mark.parametrize(
    ("version", "told"),
    [
        (ModuleNotFoundError("No module named 'sigmatau'"), "worker b has no sigmatau: No module named"),
        ("0.0.1", f"worker b has sigmatau 0.0.1, and this process {__version__}; install the same"),
    ],
)
def test_worker_with_another_package(version, told):
    with pytest.raises(DataError, match=told):
        run.run_fleet(Scheduler(a=__version__, b=version), [], JOB, done=lambda _: None)


def test_port_that_says_nothing(monkeypatch):
    """`distributed.Client` would wait for it without end."""
    monkeypatch.setattr(run, "_ANSWER", 0.5)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with (
            pytest.raises(DataError, match=r"no scheduler answers: nothing was received in 0\.5 s"),
            run.cluster(scheduler=address),
        ):
            pass


class Losing(Scheduler):
    """Results of `lossy` logs are gone with their worker so many times before they can be fetched."""

    def __init__(self, lossy, times, *, status="running"):
        super().__init__(a=__version__)
        self.lossy, self.times, self.after = lossy, times, status
        self.tasks = []

    def submit(self, function, *arguments, pure):
        assert (function, pure) == (run.analyse, False)
        logs = arguments[0]
        self.tasks.append([log.place for log in logs])
        lost = self.lossy in self.tasks[-1] and self.times > 0
        if lost:
            self.times -= 1
            self.status = self.after
        return Result(
            f"task {len(self.tasks)}", "lost" if lost else "finished", ([log.place for log in logs], 2.0 * len(logs))
        )


class Result:
    """A future that is over."""

    def __init__(self, key, status, value):
        self.key, self.status, self.value = key, status, value

    def add_done_callback(self, function):
        function(self)

    def result(self):
        return self.value

    def release(self):
        pass


def of_losing(client):
    done = []
    run.run_fleet(client, [Log(place=place, size=1, changed="") for place in "abcd"], JOB, done=done.extend)
    return done


@pytest.mark.parametrize("times", [0, 1, 2])
def test_a_result_that_is_lost_with_its_worker_is_made_again(times):
    client = Losing("b", times)
    assert sorted(of_losing(client)) == ["a", "b", "c", "d"]
    assert sorted(client.tasks) == sorted([["a"], ["c"], ["d"], *[["b"]] * (1 + times)])


def test_a_log_whose_result_is_always_lost_fails_alone():
    client = Losing("b", 100)
    *others, failed = sorted(of_losing(client), key=lambda one: not isinstance(one, str))
    assert sorted(others) == ["a", "c", "d"]
    assert (failed.log.place, failed.code) == ("b", 1)
    assert "its worker was killed at each attempt" in str(failed.error)
    assert len(client.tasks) < 12


def test_a_result_that_is_lost_with_the_scheduler_ends_the_run():
    with pytest.raises(DataError, match="the scheduler was lost"):
        of_losing(Losing("b", 1, status="closed"))


def test_processes_of_this_host_listen_on_the_loopback_only():
    """Scheduler, workers and dashboard: nobody else on the network reaches them."""
    psutil = pytest.importorskip("psutil")
    with run.cluster(workers=1):
        main = psutil.Process()
        sockets = [
            each for process in (main, *main.children(recursive=True)) for each in process.net_connections("inet")
        ]
        addresses = {each.laddr.ip for each in sockets if each.status == psutil.CONN_LISTEN}
    assert addresses
    assert all(ip_address(address).is_loopback for address in addresses), addresses


@pytest.mark.parametrize(
    ("address", "encrypted", "message"),
    [
        ("tls://127.0.0.1:1", False, "no certificate; set"),
        ("tcp://127.0.0.1:1", True, "no scheduler answers"),
    ],
)
def test_an_encrypted_scheduler_needs_a_certificate(address, encrypted, message):
    import dask

    settings = {"distributed.comm.require-encryption": encrypted}
    with dask.config.set(settings), pytest.raises(DataError, match=message), run.cluster(scheduler=address):
        pass
