"""`bobrossnet view`: its server's responses, access checks, shutdown, and the page in a folder."""

import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from subprocess import PIPE
from urllib.parse import parse_qs, unquote, urlsplit

import pytest
from clocks import least
from processes import COMMAND, running

import bobrossnet as bob
from bobrossnet.adapters.files import ALL_ENDINGS
from bobrossnet.command_line import cli
from bobrossnet.completion.weights import WEIGHTS
from bobrossnet.page.export import export
from bobrossnet.page.files import GALLERY, READ_IN_PAGE, TYPES, page_files
from bobrossnet.page.server import Server, own_hosts
from bobrossnet.picture.channels import CHANNELS, TRACED
from bobrossnet.support.paths import VIEWER

TRIANGLE = "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"


@pytest.fixture(autouse=True)
def leave_signals_alone():
    handler = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, handler)


@pytest.fixture
def ask(viewer):
    """Send a raw request; return (status, headers, body)."""

    def ask(path, method="GET", **headers):
        connection = http.client.HTTPConnection("127.0.0.1", viewer.server_port, timeout=20)
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, answer.headers, body

    return ask


# ---- Answers ---------------------------------------------------------------------------------------------


def test_files_are_served_as_what_they_are(ask):
    for path, kind in (
        ("/core/core.js", "text/javascript; charset=utf-8"),
        ("/core.wasm", "application/wasm"),
        ("/gallery/index.json", "application/json"),
        ("/gallery/csg.sdf?some=query", "text/plain; charset=utf-8"),
        ("/weights/default.safetensors", "application/octet-stream"),
    ):
        status, headers, body = ask(path)
        file = Path(path.partition("?")[0])
        folder = WEIGHTS.parent if file.parts[1] == "weights" else VIEWER
        assert (status, headers["Content-Type"]) == (200, kind)
        assert body == (folder / file.relative_to("/")).read_bytes()
        assert ask(path, "HEAD")[2] == b""
        assert ask(path, "HEAD")[1]["Content-Length"] == str(len(body))


def test_types_do_not_depend_on_the_machine(ask, monkeypatch):
    monkeypatch.setattr("mimetypes.guess_type", lambda *_: ("text/plain", None))
    assert ask("/core/core.js")[1]["Content-Type"].startswith("text/javascript")


def test_every_answer_has_the_headers(ask):
    for path, method in (("/core/core.js", "GET"), ("/nothing", "GET"), ("/core/core.js", "POST")):
        headers = ask(path, method)[1]
        policy = headers["Content-Security-Policy"]
        for rule in ("default-src 'self'", "script-src 'self' 'wasm-unsafe-eval'", "object-src 'none'"):
            assert rule in policy.split("; ")
        assert "'unsafe-" not in policy
        assert headers["Cross-Origin-Opener-Policy"] == "same-origin"  # these two headers let its workers share memory
        assert headers["Cross-Origin-Embedder-Policy"] == "require-corp"
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"
        assert headers["Cache-Control"] == ("max-age=60" if (path, method) == ("/core/core.js", "GET") else "no-cache")


def test_scenes_are_always_asked_for_anew(ask):
    for path in ("/", "/gallery/index.json", "/gallery/csg.sdf"):
        assert ask(path)[1]["Cache-Control"] == "no-cache"


@pytest.mark.parametrize(
    "path",
    [
        "/nothing",
        "/../cli.py",
        "/%2e%2e/cli.py",
        "/..%2fcli.py",
        "/gallery/../../cli.py",
        "/gallery/..%5c..%5ccli.py",
        "//etc/passwd",
        "/" + str(Path(cli.__file__).as_posix()),
        "/%00",
        "/gallery/",
        "/weights",
    ],
)
def test_nothing_else_is_served(ask, path):
    status, _, body = ask(path)
    assert status == 404
    assert body == b"404 Not Found\n"


def test_other_hosts_and_origins_are_refused(ask, viewer):
    port = viewer.server_port
    for host in (f"127.0.0.1:{port}", f"localhost:{port}"):
        assert ask("/core/core.js", Host=host)[0] == 200
        assert ask("/core/core.js", Host=host, Origin=f"http://{host}")[0] == 200
    for host in (f"example.com:{port}", "127.0.0.1", f"127.0.0.1.example.com:{port}", "", f"LOCALHOST.:{port}"):
        assert ask("/core/core.js", Host=host)[0] == 403
    for origin in ("http://example.com", "null", f"https://127.0.0.1:{port}", f"http://127.0.0.1:{port + 1}", ""):
        assert ask("/core/core.js", Origin=origin)[0] == 403


def test_hosts_have_no_case_and_need_no_port_where_it_is_of_http(ask, viewer, monkeypatch):
    for host in (f"LOCALHOST:{viewer.server_port}", f"LocalHost:{viewer.server_port}"):
        assert ask("/core/core.js", Host=host, Origin=f"http://{host}")[0] == 200
        assert ask(f"http://{host}/core/core.js", Host=host)[0] == 200
    assert ask("/core/core.js", Host="localhost")[0] == 403
    monkeypatch.setattr(viewer, "hosts", own_hosts(80))
    for host in ("localhost", "127.0.0.1", "LOCALHOST", "localhost:80"):
        assert ask("/core/core.js", Host=host, Origin=f"http://{host}")[0] == 200
    for host in ("example.com", "localhost:81", ""):
        assert ask("/core/core.js", Host=host)[0] == 403


@pytest.fixture
def status_of(viewer):
    """Return the status of the response to these lines; "{host}" is replaced by the server's host."""

    def status_of(*lines):
        with socket.create_connection(("127.0.0.1", viewer.server_port), timeout=20) as connection:
            text = "\r\n".join([*lines, "", ""]).replace("{host}", f"127.0.0.1:{viewer.server_port}")
            connection.sendall(text.encode())
            first = connection.makefile("rb").readline().split()
            assert first[0] == b"HTTP/1.1"
            return int(first[1])

    return status_of


@pytest.mark.parametrize(
    ("target", "status"),
    [
        ("http://{host}/core/core.js", 200),
        ("HTTP://{host}/core/core.js?some=query", 200),
        ("http://{host}", 200),
        ("http://{host}/nothing", 404),
        ("http://example.com/core/core.js", 421),
        ("http://example.com:80", 421),
        ("http://{host}.example.com/core/core.js", 400),
        ("http://example.com@{host}/core/core.js", 400),
        ("https://{host}/core/core.js", 421),
        ("http:///core/core.js", 421),
        ("http://[::1]/core/core.js", 421),
        ("http://[::1", 400),
        ("http://[/", 400),
        ("//[::1", 404),
        ("core/core.js", 400),
        ("*", 400),
    ],
)
def test_whole_urls_are_answered_for_this_host_alone(status_of, capfd, target, status):
    assert status_of(f"GET {target} HTTP/1.1", "Host: {host}") == status
    assert capfd.readouterr() == ("", "")


def test_requests_have_one_host(status_of):
    get = "GET /core/core.js HTTP/1.1"
    assert status_of(get, "Host: {host}") == 200
    assert status_of(get) == 400
    for hosts in (("{host}", "example.com"), ("example.com", "{host}"), ("{host}", "{host}")):
        assert status_of(get, *(f"Host: {host}" for host in hosts)) == 400
    assert status_of(get, "Host: {host}", "Origin: http://{host}", "Origin: http://example.com") == 403


def test_many_connections_at_once_do_not_wait():
    """The system drops connections without room, and they retry after one second, two, four …"""

    def connecting():
        with Server({}) as server, ExitStack() as opened:
            start = time.monotonic()
            for _ in range(500):  # before the first is accepted
                opened.enter_context(socket.create_connection(("127.0.0.1", server.server_port), timeout=20))
            return time.monotonic() - start

    assert least(connecting, 1) < 1


def test_only_get_and_head(ask):
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "CONNECT"):
        status, _, body = ask("/core/core.js", method)
        assert status == 501
        assert b"\n" not in body[:-1]


def test_what_is_no_request_ends_in_an_answer(viewer):
    with socket.create_connection(("127.0.0.1", viewer.server_port), timeout=20) as connection:
        connection.sendall(b"\xff\xfe nonsense\r\n\r\n")
        assert connection.recv(1 << 16)


def test_the_port_is_only_on_this_machine(viewer):
    assert viewer.server_address[0] == "127.0.0.1"


def test_a_taken_port_is_told(viewer):
    with pytest.raises(bob.InputError, match=f"^port: expected a free one, got {viewer.server_port}: "):
        Server({}, viewer.server_port)
    with pytest.raises(bob.InputError, match=r"^port: expected an integer in 0\.\.65535, got 70000"):
        Server({}, 70_000)


# ---- Folders ---------------------------------------------------------------------------------------------


def test_export(tmp_path, capsys):
    """All files of the page are present, and refer to each other by relative paths."""
    (tmp_path / "a part.obj").write_text(TRIANGLE)
    folder = tmp_path / "page"
    assert cli.main(["view", str(tmp_path / "a part.obj"), "--export", str(folder)]) == 0
    written = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}
    shipped = {f.relative_to(VIEWER).as_posix() for f in VIEWER.rglob("*") if f.suffix in TYPES}
    assert capsys.readouterr().out == f"wrote {folder}: {len(written)} files, which any web server can show\n"
    assert written == shipped | {
        "files/a part.bob",
        "gallery/happy_tree.bob",
        "weights/default.safetensors",
        "weights/filling.safetensors",
        "weights/paper.safetensors",
        "weights/small.safetensors",
        "weights/uncertainty.safetensors",
    }
    for name in written:
        file = folder / name
        if file.suffix in (".html", ".js", ".css"):
            paths = re.findall(r"""(?:from |import\(|src=|href=|url\(|new URL\()\s*["'`]([^"'`]*)""", file.read_text())
            for path in paths:
                assert not path.startswith("/")
                assert "://" not in path
    first = json.loads((folder / GALLERY).read_bytes())[0]
    assert first == {"file": "../files/a%20part.bob", "title": "a part", "kind": "file"}
    assert bob.load(folder / "files/a part.bob").counts() == {"shape": 1, "triangle": 1}


def test_export_turns_upright(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE.replace("v 0 0 1", "v 0 0 3"))
    assert cli.main(["view", str(tmp_path / "a.obj"), "--up", "y", "--export", str(tmp_path / "page")]) == 0
    expected = bob.load(tmp_path / "a.obj").turned_upright()
    assert bob.trace(bob.load(tmp_path / "page/files/a.bob"), size=(20, 20)) == bob.trace(expected, size=(20, 20))


def test_export_with_a_lens_and_a_background(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE)
    page = tmp_path / "page"
    look = ["--fov", "50", "--background", "#ffffff,#99bbdd"]
    assert cli.main(["view", str(tmp_path / "a.obj"), *look, "--export", str(page)]) == 0
    text = (page / "index.html").read_text()
    gradient = "linear-gradient(rgb(255, 255, 255), rgb(153, 187, 221))"
    assert f'<body data-field-of-view="50deg" data-background="{gradient}">' in text
    assert text.replace(text[text.index("<body") : text.index(">", text.index("<body")) + 1], "<body>") == (
        (VIEWER / "index.html").read_text()
    )
    assert cli.main(["view", "--export", str(tmp_path / "plain")]) == 0
    assert (tmp_path / "plain/index.html").read_bytes() == (VIEWER / "index.html").read_bytes()
    one = tmp_path / "one.html"
    assert cli.main(["view", "--background", "transparent", "--export", str(one)]) == 0
    assert '<bob-view alt="Picture of happy tree" camera-controls background="transparent">' in one.read_text()


def test_several_files_are_one_scene(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.obj").write_text(TRIANGLE)
    files = [str(tmp_path / f"{name}.obj") for name in ("a", "b")]
    assert cli.main(["view", *files, "--export", str(tmp_path / "page")]) == 0
    assert bob.load(tmp_path / "page/files/scene.bob").counts() == {"shape": 2, "triangle": 2}


def test_mistakes_are_one_line(tmp_path, capsys, monkeypatch):
    (tmp_path / "file").write_text("")

    def said(*arguments):
        assert cli.main(["view", *map(str, arguments)]) == 2
        error = capsys.readouterr().err
        assert error.startswith("bobrossnet: error: ")
        assert error.count("\n") == 1
        return error

    assert "export: expected a folder to write to, got " in said("--export", tmp_path / "file")
    assert "missing.ply: expected a file" in said("missing.ply")
    assert "fov: expected degrees in [0.1, 175]" in said("--fov", "190", "--export", tmp_path / "a")
    assert "background: expected #rrggbb, a CSS name or 3 numbers, got 'rot'" in said("--background", "rot")
    assert "port: expected an integer in 0..65535, got -1" in said("--port", "-1", "--no-browser")
    monkeypatch.setattr("bobrossnet.page.files.VIEWER", tmp_path)
    assert "viewer: expected core.wasm in the package, got none; run `make page`" in said("--no-browser")


def test_files_last_as_long_as_their_context():
    with page_files(bob.happy_tree(), "tree") as files:
        made = [file for file in files.values() if isinstance(file, Path) and VIEWER not in file.parents]
        packed = [file for file in made if file.suffix == ".bob"]
        assert len(packed) == 2
        assert all(file.is_file() for file in packed)
    assert not any(file.exists() for file in packed)
    with pytest.raises(bob.InputError, match="can't write the page there"):
        export({"a.js": b"", "a.js/b.js": b""}, packed[0].parent)


# ---- The command -----------------------------------------------------------------------------------------


@contextmanager
def viewing(folder, *arguments):
    """Run the command; return the process and its first line."""
    command = [sys.executable, "-m", "bobrossnet", "view", *map(str, arguments)]
    environment = {**os.environ, "TMPDIR": str(folder)}
    with running(command, stdout=PIPE, stderr=PIPE, env=environment, cwd=folder) as process:
        yield process, process.stdout.readline()


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=["Ctrl-C", "SIGTERM", "SIGHUP"])
def test_it_shows_a_file_until_it_is_ended(tmp_path, sent):
    (tmp_path / "part.obj").write_text(TRIANGLE)
    with viewing(tmp_path, "part.obj", "--no-browser") as (process, line):
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)(/\?scene=files/part\.bob)  \(Ctrl-C ends it\)\n", line)
        assert found, line + process.stderr.read() * (not line)
        with closing(http.client.HTTPConnection("127.0.0.1", int(found[1]), timeout=20)) as connection:
            connection.request("GET", "/files/part.bob")
            assert b"bobrossnet-scene" in connection.getresponse().read()
            process.send_signal(sent)  # while a connection is open
            assert process.wait(timeout=20) == 0
        assert process.stdout.read() == process.stderr.read() == ""
    assert [file.name for file in tmp_path.iterdir()] == ["part.obj"]


def test_a_closed_terminal_leaves_nothing(tmp_path):
    """The shell and the system both send SIGHUP, and output is no longer possible."""
    (tmp_path / "part.obj").write_text(TRIANGLE)
    with viewing(tmp_path, "part.obj", "--no-browser") as (process, line):
        assert line
        assert len(list(tmp_path.iterdir())) == 2
        process.stdout.close()
        process.stderr.close()
        for _ in range(20):
            process.send_signal(signal.SIGHUP)
            time.sleep(0.002)
        assert process.wait(timeout=20) in (0, 130)  # the latter if it was not serving yet
    assert [file.name for file in tmp_path.iterdir()] == ["part.obj"]


def test_nohup_is_heeded(tmp_path):
    command = ["nohup", sys.executable, "-m", "bobrossnet", "view", "--no-browser"]
    with running(command, stdout=PIPE, stderr=PIPE, stdin=PIPE, env={**os.environ, "TMPDIR": str(tmp_path)}) as process:
        assert process.stdout.readline().startswith("http://")
        process.send_signal(signal.SIGHUP)
        time.sleep(0.2)
        assert process.poll() is None


STRANGE = b"a #1? 100%41&b=c+d<e>\"'\\\t\n\xe9.obj"
"""All characters allowed in a file name, with a byte that is not UTF-8."""


def test_a_file_of_any_name_is_served_at_the_address_that_is_printed(tmp_path):
    (tmp_path / os.fsdecode(STRANGE)).write_text(TRIANGLE)
    with viewing(tmp_path, "--no-browser", os.fsdecode(STRANGE)) as (process, line):
        url = urlsplit(line.partition(" ")[0])
        assert url.port, process.stderr.read()
        (scene,) = parse_qs(url.query, strict_parsing=True)["scene"]
        with closing(http.client.HTTPConnection("127.0.0.1", url.port, timeout=20)) as connection:
            connection.request("GET", f"/{scene}")
            assert b"bobrossnet-scene" in connection.getresponse().read()
            connection.request("GET", f"/{GALLERY}")
            gallery = json.loads(connection.getresponse().read())
    name = STRANGE.removesuffix(b".obj").decode("utf-8", "replace")
    assert gallery[0] == {"file": f"../{scene}", "title": name, "kind": "file"}


def test_names_as_long_as_disks_take_are_exported(tmp_path):
    for name in ("x" * 252, "é" * 126, os.fsdecode(b"\xe9" * 252)):
        file = tmp_path / f"{name}.vm"
        file.write_text("_0 var-x\n_1 square _0\n_2 const 1\n_3 sub _1 _2\n")
        page = tmp_path / "page"
        assert cli.main(["view", str(file), "--export", str(page)]) == 0
        (scene,) = (page / "files").glob("*.bob")
        assert unquote(json.loads((page / GALLERY).read_bytes())[0]["file"]) == f"../files/{scene.name}"
        shutil.rmtree(page)


def test_any_name_is_printed(tmp_path):
    name = os.fsdecode(STRANGE)
    (tmp_path / name).write_text(TRIANGLE)
    command = [*COMMAND, "mesh", name, "-o", name.replace(".obj", ".stl")]
    for encoding in ("utf-8", "ascii"):
        environment = {**os.environ, "PYTHONIOENCODING": encoding}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path, timeout=60)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("wrote a #1? 100%41")


def test_it_opens_a_browser(tmp_path, monkeypatch):
    browser, opened = tmp_path / "browser", tmp_path / "opened"
    browser.write_text(f'#!/bin/sh\necho "$1" > {opened}.part; mv {opened}.part {opened}\n')
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", str(browser))
    with viewing(tmp_path) as (_, line):
        end = time.monotonic() + 20
        while not opened.exists() and time.monotonic() < end:
            time.sleep(0.02)
        assert opened.read_text().strip() == line.partition(" ")[0]


def test_what_the_page_knows_is_what_python_knows():
    (converted,) = re.findall(r"CONVERTED = \[(.+?)\]", (VIEWER / "core/endings.js").read_text())
    assert {*READ_IN_PAGE, *re.findall(r'"(.+?)"', converted)} == set(ALL_ENDINGS)
    (home,) = re.findall(r"HOME = Object\.freeze\(\{(.+?)\}\)", (VIEWER / "picture/camera.js").read_text())
    values = {name: float(value) for name, value in re.findall(r"(\w+): ([-.\d]+)", home)}
    camera = bob.Camera()
    pan_x, pan_y = camera.pan
    known = {name: getattr(camera, name) for name in ("azimuth", "elevation", "roll", "zoom", "fov")}
    assert values == {**known, "panX": pan_x, "panY": pan_y}


def test_the_page_gives_cameras_numbers_in_the_order_of_the_core():
    header = (Path(__file__).parent.parent / "core/picture/camera.h").read_text()
    (members,) = re.findall(r"struct Camera \{(.+?)std::optional.+?\};", header, re.DOTALL)
    types = re.findall(r"^ *(\w+) .+;", members, re.MULTILINE)
    names = re.findall(r"(\w+) = [-\d]", members)
    assert set(types) == {"float"}
    (home,) = re.findall(r"HOME = Object\.freeze\(\{(.+?)\}\)", (VIEWER / "picture/camera.js").read_text())
    assert [name.lower() for name in re.findall(r"(\w+):", home)] == [
        name.removesuffix("_degrees").replace("_", "") for name in names
    ]


def test_the_page_has_the_channels_of_the_core():
    text = (VIEWER / "picture/channels.js").read_text()
    (components,) = re.findall(r"COMPONENTS = \{(.+?)\}", text)
    (layout,) = re.findall(r"GBUFFER = \[(.+?)\]", text)
    assert dict(re.findall(r"(\w+): (\d+)", components)) == {c.name: str(c.components) for c in CHANNELS.values()}
    assert ",".join(re.findall(r"\w+", layout)) == TRACED.names
