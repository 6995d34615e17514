"""A served workbench, and requests of its page."""

import contextlib
import json
import socket
import threading
import time

import httpx
import uvicorn

from sigmatau.app.server import guarded

TOKEN = "a-token-of-the-tests"


class Page:
    """A page that sends requests below the address, and waits for an analysis."""

    def __init__(self, client, log):
        self.client, self.log = client, log

    def get(self, path, /, **more):
        return self.client.get(f"/{TOKEN}/{path}", **more)

    def post(self, path, /, **body):
        # escaped as ASCII: a hostile name may hold what UTF-8 cannot
        headers = {"Content-Type": "application/json"}
        return self.client.post(f"/{TOKEN}/{path}", content=json.dumps(body), headers=headers)

    def delete(self, path):
        return self.client.delete(f"/{TOKEN}/{path}")

    def ended(self, job):
        while (state := self.get(f"api/jobs/{job}").json())["state"] in ("waiting", "running"):
            time.sleep(0.02)
        return state

    def analysed(self, **body):
        """The identifier of the result of an analysis."""
        state = self.ended(self.post("api/analyze", **{"path": str(self.log)} | body).json()["job"])
        assert state["state"] == "done", state
        return state["result"]


@contextlib.contextmanager
def serving(workbench):
    """A client of a workbench that is served."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        application = guarded(workbench, token=TOKEN, port=port)
        server = uvicorn.Server(uvicorn.Config(application, log_level="critical", lifespan="off", ws="none"))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=120, trust_env=False) as asking:
                yield asking
        finally:  # also after a failed test, or its process would not end
            server.should_exit = True
            thread.join()
