"""What a fleet says of schedulers and workers that cannot do its work, before a log is blamed for it."""

import socket

import pytest

pytest.importorskip("distributed", reason="fleets need the extra cluster")
pytest.importorskip("sqlalchemy", reason="fleets need the extra store")

from sigmatau._version import __version__
from sigmatau.errors import DataError
from sigmatau.fleet import run
from sigmatau.fleet.tasks import Job
from sigmatau.store.naming import Naming

JOB = Job(reading={}, settings={}, options={}, naming=Naming(folders=True))


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


def test_workers_are_asked_once(monkeypatch):
    monkeypatch.setattr(run, "_RECOUNT", 0.0)
    client, told = Scheduler(a=__version__, b=OSError("is gone")), []
    fleet = run._Run(client, JOB, lambda _: None, told.append)
    fleet._start()
    fleet._start()
    client.versions["c"] = __version__
    fleet._start()
    assert (client.asked, told) == ([["a", "b"], ["c"]], [])


def test_waiting_for_workers_is_told_once(monkeypatch):
    monkeypatch.setattr(run, "_RECOUNT", 0.0)
    client, told = Scheduler(), []
    fleet = run._Run(client, JOB, lambda _: None, told.append)
    fleet._start()
    fleet._start()
    assert told == ["the scheduler has no workers; waiting for them"]
    client.versions["a"] = __version__
    fleet._start()
    del client.versions["a"]
    fleet._start()
    assert len(told) == 2


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
