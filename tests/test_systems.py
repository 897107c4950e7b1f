"""Windows and browsers, simulated on Linux (systems.py): missing features are not used."""

import os
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import pytest
from processes import running
from systems import EXCLUSIVE, SIGBREAK

import bobrossnet as bob
from bobrossnet.adapters import beside
from bobrossnet.support.errors import InputError

ROOT = Path(__file__).parent.parent
SYSTEMS = Path(__file__).parent / "systems.py"
COMMAND = "import sys; from bobrossnet.command_line.cli import main; sys.exit(main(sys.argv[1:]))"

TEXTURED = """
import numpy as np
from PIL import Image
Image.fromarray(np.full((4, 4, 3), 200, np.uint8)).save("wood.png")
open("part.mtl", "wb").write(b"newmtl wood\\nmap_Kd wood.png\\n")
open("part.obj", "wb").write(
    b"mtllib part.mtl\\nv 0 0 0\\nv 0 1 0\\nv 0 0 1\\nvt 0 0\\nvt 1 0\\nvt 0 1\\nusemtl wood\\nf 1/1 2/2 3/3\\n"
)
"""


def command_of(system, code, *arguments):
    return [sys.executable, "-X", "warn_default_encoding", str(SYSTEMS), system, "-c", code, *map(str, arguments)]


def played(system, code, *arguments, folder, **environment):
    """Return the output of a program on another system; it must exit with 0."""
    environment = {**os.environ, "PYTHONIOENCODING": "cp1252", **environment}
    done = subprocess.run(
        command_of(system, code, *arguments), cwd=folder, env=environment, capture_output=True, timeout=120
    )
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.decode()


def test_windows_runs_what_machines_must(tmp_path):
    """And prints names outside its code page."""
    code = f"""
import runpy
import bobrossnet as bob
from bobrossnet.command_line.cli import main

runpy.run_path({str(ROOT / "tests/installed.py")!r}, run_name="__main__")
bob.save_scene(bob.sdf.sphere(1), "größe–∞.bob")
main(["info", "größe–∞.bob"])
"""
    printed = played("win32", code, folder=tmp_path)
    assert f"bobrossnet {bob.__version__}, Python" in printed
    assert "file    größe–∞.bob" in printed


def test_windows_reads_cad(tmp_path):
    pytest.importorskip("rhino3dm")
    import rhino3dm

    file = rhino3dm.File3dm()
    file.Objects.AddSphere(rhino3dm.Sphere(rhino3dm.Point3d(0, 0, 0), 1))
    file.Write(str(tmp_path / "ball.3dm"), 7)
    (tmp_path / "broken.3dm").write_bytes(b"3D Geometry File Format ")
    (tmp_path / "crash.py").write_text("import os\n\n\ndef crash():\n    os.abort()\n", "utf-8")
    code = """
import sys
import bobrossnet as bob
from bobrossnet.adapters.apart import call_apart

sys.path.insert(0, ".")
print(bob.load("ball.3dm").describe())
for call in (lambda: bob.load("broken.3dm"), lambda: call_apart("crash", "crash")):
    try:
        call()
    except bob.InputError as error:
        print(error)
"""
    printed = played("win32", code, folder=tmp_path)
    assert "1 shape" in printed
    assert "broken.3dm: expected a Rhino file" in printed
    assert "the reader crashed" in printed


def test_windows_consoles_end_programs_by_a_signal_of_their_own(tmp_path):
    (tmp_path / "part.stl").write_bytes(b"")
    bob.happy_tree().save(tmp_path / "part.stl")
    command = command_of("win32", COMMAND, "view", "part.stl", "--no-browser")
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with running(command, cwd=tmp_path, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout.readline().startswith("http://127.0.0.1:")
        assert list(tmp_path.glob("bobrossnet-view-*"))
        process.send_signal(SIGBREAK)
        assert process.wait(timeout=20) in (0, 130)
    assert not list(tmp_path.glob("bobrossnet-view-*"))


def test_windows_replaces_files_that_are_open_for_a_moment(tmp_path):
    code = """
import threading
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.errors import InputError

write_whole("part.txt", b"old")
reader = open("part.txt", "rb")
threading.Timer(0.2, reader.close).start()
write_whole("part.txt", b"new")
print(open("part.txt", "rb").read())
with open("part.txt", "rb"):
    try:
        write_whole("part.txt", b"newest")
    except InputError as error:
        print(error)
"""
    new, refused = played("win32", code, folder=tmp_path).splitlines()
    assert new == "b'new'"
    assert "part.txt: can't write it: another program has it open" in refused
    assert [file.name for file in tmp_path.iterdir()] == ["part.txt"]


def test_windows_keeps_what_is_sent_as_the_page_ends(tmp_path):
    code = """
from bobrossnet.page.files import TREE, page_files

with page_files() as files:
    sent = files[TREE].open("rb")
print(len(sent.read(8)))
"""
    assert played("win32", code, folder=tmp_path, TMPDIR=str(tmp_path)) == "8\n"


def test_windows_ports_have_one_server(tmp_path):
    code = f"""
import socket
from bobrossnet.page.server import Server

with Server({{}}) as server:
    for option in (socket.SO_REUSEADDR, {EXCLUSIVE}):
        print(bool(server.socket.getsockopt(socket.SOL_SOCKET, option)))
"""
    assert played("win32", code, folder=tmp_path).split() == ["False", "True"]


def test_windows_pools_are_smaller(tmp_path):
    code = """
import os
import bobrossnet as bob
from bobrossnet.pictures.thumbnails import MAX_PROCESSES

os.sched_getaffinity, os.cpu_count = None, lambda: 128
print(MAX_PROCESSES, bob.thumbnails(".", "pictures"))
"""
    assert played("win32", code, folder=tmp_path) == "61 []\n"


def test_windows_interrupts_no_process_that_its_console_has_interrupted(tmp_path):
    code = """
from multiprocessing import Process
from bobrossnet.support.interrupts import interrupt

interrupt(Process())
"""
    played("win32", code, folder=tmp_path)


def test_windows_outputs_lose_their_readers(tmp_path):
    code = """
import errno, sys
from bobrossnet.command_line import cli

def lost(*_):
    raise OSError(errno.EINVAL, "Invalid argument")

cli._run = lost
sys.exit(cli.main([]))
"""
    played("win32", code, folder=tmp_path)


def test_browsers_trace_and_show(tmp_path):
    """All except files whose readers need a process; thumbnails are rendered one after the other."""
    bob.happy_tree().save(tmp_path / "tree.stl")
    for name in ("part.step", "part.igs", "part.3dm"):
        (tmp_path / name).write_bytes(b"?")
    code = (
        TEXTURED
        + """
import bobrossnet as bob
from bobrossnet.page.export import export_file
from bobrossnet.page.widget import script

scene = bob.load(["part.obj", bob.sdf.sphere(1)])
bob.render(scene, size="32x24").save("part.png")
bob.save_scene(scene, "part.bob")
print([frame.fraction for frame in bob.progressive(scene, size=(24, 32), frame_ms=20)][-1])
print(bob.View(scene, size=(24, 32)).frame(ms=5).image.shape)
print(bob.complete(bob.trace(scene, size=(24, 32), fraction=0.1)).shape)
export_file(scene, "part", bob.support.paths.path_of("page.html"))
print(len(script(scene)) > 100_000)
for made in bob.thumbnails(".", "pictures", size="16x16"):
    print(made.file.name, made.error)
"""
    )
    printed = played("emscripten", code, folder=tmp_path)
    assert printed.startswith("1.0\n(24, 32)\n(24, 32)\nTrue\n")
    assert "part.obj None\n" in printed
    assert "tree.stl None\n" in printed
    for ending in (".step", ".igs", ".3dm"):
        assert f"part{ending}: reading {ending} files needs a process, which browsers don't start" in printed


@pytest.mark.parametrize("program", ["bobrossnet", "bobrossnet.exe"])
def test_the_command_is_known_by_its_program(program):
    code = f"""
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.argv[0] = "folder/{program}"
from bobrossnet.command_line import starting
print(signal.getsignal(signal.SIGINT) is starting._leave)
"""
    assert subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True).stdout == b"True\n"


@pytest.mark.parametrize("name", ["//server/share/wood.png", "/wood.png", "C:/wood.png", "C:wood.png"])
def test_names_of_windows_lead_nowhere_else(tmp_path, monkeypatch, name):
    """And no server is contacted."""
    (tmp_path / "C:wood.png").write_bytes(b"")
    monkeypatch.setattr(beside, "PurePath", PureWindowsPath)
    monkeypatch.setattr(os.path, "realpath", lambda path: pytest.fail(f"the disk was asked for {path}"))
    with pytest.raises(InputError, match="in or below its folder"):
        beside.find_beside(tmp_path / "part.obj", name)


def test_libraries_of_servers_are_not_asked_for(tmp_path, monkeypatch):
    (tmp_path / "part.obj").write_bytes(
        b"mtllib \\\\server\\share\\wood.mtl\nusemtl wood\nv 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"
    )
    asked, is_file = [], Path.is_file
    monkeypatch.setattr(Path, "is_file", lambda path: asked.append(str(path)) or is_file(path))
    with pytest.warns(bob.InputWarning, match="materials were left out"):
        bob.load(tmp_path / "part.obj")
    assert not [path for path in asked if path.startswith("//server")]


def test_texts_have_an_encoding():
    """The default on Windows lacks most letters."""
    command = [sys.executable, "-m", "ruff", "check", "--preview", "--select", "PLW1514", "--quiet"]
    done = subprocess.run(
        [*command, "src", "bench", "docs", "examples", "core"], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert done.stdout == ""
