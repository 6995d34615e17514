"""Attacks on the server: each is refused, and says nothing of the files."""

import pytest

from sigmatau.app.answers import CallError
from sigmatau.app.guard import HEADERS, MAX_BODY

pytest_plugins = ["workbench_pages"]  # the fixtures

TOKEN, MAX_UPLOAD = "a-token-of-the-tests", 3_000_000


@pytest.mark.parametrize(
    ("path", "headers", "status"),
    [
        (f"/{TOKEN}/", {}, 200),
        (f"/{TOKEN}/", {"Host": "localhost:PORT"}, 200),
        (f"/{TOKEN}/api/about", {"Origin": "http://127.0.0.1:PORT"}, 200),
        (f"/{TOKEN}/", {"Host": "evil.example"}, 403),  # a name that was pointed at this computer
        (f"/{TOKEN}/", {"Host": "evil.example:PORT"}, 403),
        (f"/{TOKEN}/", {"Host": "127.0.0.1"}, 403),
        (f"/{TOKEN}/", {"Host": "127.0.0.1:1"}, 403),
        (f"/{TOKEN}/api/about", {"Origin": "http://evil.example"}, 403),
        (f"/{TOKEN}/api/about", {"Origin": "null"}, 403),  # a page in a frame without an origin
        (f"/{TOKEN}/api/about", {"Origin": "http://localhost:PORT"}, 403),  # not that of this Host
        (f"/{TOKEN}/api/about", {"Sec-Fetch-Site": "cross-site"}, 403),
        (f"/{TOKEN}", {}, 404),
        ("/", {}, 404),
        (f"/{TOKEN[:-1]}/", {}, 404),
        (f"/{TOKEN}x/", {}, 404),
        (f"/{'a' * 32}/api/about", {}, 404),
        ("/%F0%28%8C%28/", {}, 404),
        ("/api/about", {}, 404),
        (f"/x/../{TOKEN}/../api/about", {}, 404),
    ],
)
def test_who_is_answered(client, path, headers, status):
    headers = {name: value.replace("PORT", str(client.base_url.port)) for name, value in headers.items()}
    answer = client.get(path, headers=headers)
    assert answer.status_code == status
    assert {name: answer.headers.get(name) for name in HEADERS} == HEADERS
    assert not any(name.lower().startswith("access-control") for name in answer.headers)
    if status != 200:
        assert set(answer.json()["error"]) == {"message", "hint", "code"}
        assert TOKEN not in answer.text


@pytest.mark.parametrize("method", ["OPTIONS", "PUT", "TRACE"])
def test_other_methods(client, method):
    """A browser that asks whether another site may send something gets no leave."""
    asked = {"Access-Control-Request-Method": "POST", "Origin": str(client.base_url).rstrip("/")}
    answer = client.request(method, f"/{TOKEN}/api/open", headers=asked)
    assert answer.status_code == 404
    assert not any(name.lower().startswith("access-control") for name in answer.headers)


def test_no_script_of_a_page_is_inline(page):
    policy = HEADERS["Content-Security-Policy"]
    assert "script-src 'self'" in policy
    assert "unsafe" not in policy
    text = page.get("").text
    assert "<script>" not in text
    assert "http://" not in text.replace("http://www.w3.org", "")
    assert "https://" not in text


@pytest.mark.parametrize(
    "path",
    [
        "../secret.csv",
        "/etc/passwd",
        "link.csv",
        "inner/link/secret.csv",
        "",
        "\0",
        "~",
        "http://x/y",
        "a" * 5000,
        None,
        3,
    ],
)
def test_files_elsewhere_cannot_be_named(page, tmp_path_factory, folder, path):
    outside = tmp_path_factory.mktemp("outside")
    (outside / "secret.csv").write_text("time,gyro_x [rad/s]\n0,1\n")
    (folder / "inner").mkdir(exist_ok=True)
    for link, to in ((folder / "link.csv", outside / "secret.csv"), (folder / "inner" / "link", outside)):
        link.unlink(missing_ok=True)
        link.symlink_to(to)
    named = f"{folder}/{path}" if isinstance(path, str) and not path.startswith(("/", "http")) else path
    for ask in ("api/open", "api/envelope", "api/analyze"):
        answer = page.post(ask, path=named)
        expected = 404 if path != "" else (422, 202)  # the folder itself is no log
        assert answer.status_code in (expected if isinstance(expected, tuple) else (expected,)), answer.text
    for link in (folder / "link.csv", folder / "inner" / "link"):
        link.unlink()


def test_folders_elsewhere_are_not_listed(page, folder):
    assert page.get("api/files", params={"path": str(folder.parent)}).status_code == 404
    assert page.get("api/files", params={"path": f"{folder}/.."}).status_code == 404
    assert page.get("api/files", params={"path": str(folder)}).json()["parent"] is None


@pytest.mark.parametrize("name", ["../routes.py", "..%2froutes.py", "/etc/passwd", "uplot/../../content.py", ""])
def test_static_names(page, name):
    assert page.get(f"static/{name}").status_code == 404


def test_large_bodies(page, client):
    """By the length that is stated, and by what comes."""
    big = b'{"options": "' + b"x" * MAX_BODY + b'"}'
    answer = client.post(f"/{TOKEN}/api/open", content=big)
    assert (answer.status_code, answer.json()["error"]["code"]) == (413, "size")
    chunks = (b"x" * 65536 for _ in range(MAX_BODY // 65536 + 2))
    answer = client.post(f"/{TOKEN}/api/open", content=chunks)
    assert answer.status_code == 413


def test_large_uploads_leave_nothing(client, workbench):
    for content in (b"x" * (MAX_UPLOAD + 1), (b"x" * 65536 for _ in range(MAX_UPLOAD // 65536 + 2))):
        answer = client.post(f"/{TOKEN}/api/upload?name=big.csv", content=content)
        assert answer.status_code == 413
        assert answer.json()["error"]["code"] == "size"
    assert not any(path.stat().st_size > 100_000 for path in workbench.uploads._folder.iterdir())


def test_uploads_share_their_room(workbench):
    """Those that are coming too: many at once do not have more than one after the other."""
    uploads = workbench.uploads
    first, second = (uploads.begin("a.csv")[0] for _ in range(2))
    room = uploads.room()
    uploads.receive(first, room // 2 + 1)
    with pytest.raises(CallError, match="too large"):
        uploads.receive(second, room // 2 + 1)
    for id_ in (first, second):
        uploads.end(id_, None)
    assert uploads.room() == room


@pytest.mark.parametrize(
    "name",
    [
        "../../etc/cron.d/x",
        "C:\\Windows\\a.csv",
        "<img src=x onerror=alert(1)>.csv",
        "\u202egpj.csv",
        "",
        "a" * 3000,
        ".bashrc",
    ],
)
def test_hostile_names(client, workbench, folder, name):
    """A name is shown, and is never the name of a file."""
    rows = (folder / "static.csv").read_bytes()[:20000].rpartition(b"\n")[0]
    answer = client.post(f"/{TOKEN}/api/upload", params={"name": name}, content=rows)
    assert answer.status_code == 200
    upload = workbench.uploads.find(answer.json()["file"])
    assert upload.path.parent == workbench.uploads._folder
    assert upload.path.name.replace(".", "").isalnum()
    opened = client.post(f"/{TOKEN}/api/open", json={"file": answer.json()["file"]})
    assert opened.status_code == 200, opened.text
    assert opened.headers["content-type"] == "application/json"
    assert str(upload.path) not in opened.text
    assert client.delete(f"/{TOKEN}/api/upload/{answer.json()['file']}").status_code == 200
    assert not upload.path.exists()


@pytest.mark.parametrize("body", [b"", b"[]", b"nonsense", b'{"a": NaN}', b"\xff\xfe", b"[" * 100000])
def test_bodies_that_are_no_objects(client, body):
    answer = client.post(f"/{TOKEN}/api/open", content=body)
    assert (answer.status_code, answer.json()["error"]["code"]) == (400, "option")
