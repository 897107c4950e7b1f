"""Everyday tasks: fitted cameras, films, thumbnails, pictures in notebooks."""

from __future__ import annotations

import io
import os
import re
import signal
import socket
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import MODELS, needs_models
from PIL import Image, ImageDraw
from statues import LYING, STANDING

import bobrossnet as bob
from bobrossnet import InputError
from bobrossnet.command_line import cli
from bobrossnet.completion.network import load_network
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.thumbnails import Style, Thumbnail, _made, contact_sheet
from bobrossnet.sdf import box, sphere
from bobrossnet.support import cluster
from bobrossnet.tracing.upright import seems_to_lie

ROD = bob.polyline([(0, 0, 0), (0, 0, 9)], radius=0.3).mesh()
NEEDLE = bob.Mesh([(0, 0, 9), (0.5, 0, 0), (0, 0.5, 0), (-0.5, -0.5, 0)], [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])
BALL = sphere(1)


def box_of(alpha: np.ndarray[Any, Any]) -> list[int]:
    """Return the first and last row and column with content."""
    rows, columns = np.flatnonzero(alpha.any(axis=1)), np.flatnonzero(alpha.any(axis=0))
    return [int(of[i]) for of in (rows, columns) for i in (0, -1)]


def opened(path: Path) -> Image.Image:
    with Image.open(path) as picture:
        picture.load()
        return picture.copy()


# ---- Files that lie --------------------------------------------------------------------------------------


def test_what_lies_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, mesh, lies in (("stands", STANDING, False), ("lies", LYING, True)):
        assert seems_to_lie(bob.Scene(mesh)) is lies
        mesh.save(tmp_path / f"{name}.ply")
        assert cli.main(["info", str(tmp_path / f"{name}.ply")]) == 0
        told = [line for line in capsys.readouterr().out.splitlines() if "--up y" in line]
        assert told == (["up      z; it seems to lie on its back, --up y would turn it upright"] if lies else [])
    assert not seems_to_lie(bob.Scene([LYING, bob.Instance(LYING).rotate(-np.pi / 2, (1, 0, 0)).translate((3, 0, 0))]))


@pytest.mark.parametrize("shape", [BALL, BALL.mesh(0.1), bob.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])])
def test_what_has_no_up_never_lies(shape: bob.Shape) -> None:
    assert not seems_to_lie(bob.Scene(shape))


@needs_models
def test_scans_that_lie() -> None:
    names = "armadillo happy_buddha kitten lion_statue max_planck nefertiti stanford_bunny"
    assert all(seems_to_lie(bob.load(MODELS / f"scans/{name}.ply")) for name in names.split())
    assert not any(
        seems_to_lie(bob.load(MODELS / f"scans/{name}.ply")) for name in ("cyberware_horse", "ycb_foam_brick")
    )


# ---- Cameras that fit ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [BALL, ROD, bob.happy_tree(), box((4, 0.5, 1)).translate((9, 9, 9))])
@pytest.mark.parametrize("fov", [0, 35, 90])
@pytest.mark.parametrize("size", [(120, 160), (200, 100)])
def test_the_silhouette_fills_the_picture(shape: bob.Shape, fov: float, size: tuple[int, int]) -> None:
    camera = bob.fitted(shape, bob.Camera(azimuth=70, elevation=35, zoom=9, pan=(3, 3), fov=fov), size=size, margin=0.1)
    assert (camera.azimuth, camera.elevation, camera.fov) == (70, 35, fov)
    top, bottom, left, right = box_of(bob.render(shape, camera, size=size, samples=1).rgba[..., 3])
    height, width = size
    # One direction reaches the margins, and the other is centred.
    margins = np.array([top / height, 1 - (bottom + 1) / height, left / width, 1 - (right + 1) / width])
    assert margins.min() == pytest.approx(0.1, abs=0.03)
    assert margins[0] == pytest.approx(margins[1], abs=0.06)
    assert margins[2] == pytest.approx(margins[3], abs=0.06)


@pytest.mark.parametrize("shape", [bob.happy_tree(), NEEDLE, bob.Mesh(NEEDLE.vertices + 7, NEEDLE.triangles)])
def test_cameras_that_fit_leave_nothing_out(shape: bob.Shape) -> None:
    for azimuth in range(0, 360, 30):
        camera = bob.fitted(shape, bob.Camera(azimuth=azimuth, fov=azimuth % 60), size=(150, 200))
        alpha = bob.render(shape, camera, size=(150, 200), samples=1).rgba[..., 3]
        assert not alpha[0].any()
        assert not alpha[-1].any()
        assert not alpha[:, 0].any()
        assert not alpha[:, -1].any()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: bob.fitted(BALL, margin=0.5), "margin: expected a number in [0, 0.45], got 0.5"),
        (
            lambda: bob.fitted(BALL, bob.Camera(position=(3, 0, 0), fov=50)),
            "camera: expected an orbiting camera, got one at a position",
        ),
        (lambda: bob.fitted(3), "shapes: expected a shape or several, got int"),
        (lambda: bob.orbit(BALL, frames=0), "frames: expected an integer in 1..10000, got 0"),
        (lambda: bob.orbit(BALL, bob.Camera(position=(3, 0, 0), fov=50)), "camera: expected an orbiting camera"),
        (lambda: bob.orbit(BALL, fraction=0), "fraction: expected a number in (0, 1], got 0"),
        (lambda: bob.Film(BALL, []), "cameras: expected at least one, got none"),
        (lambda: bob.Film(BALL, [3]), "camera: expected a Camera, got int"),  # type: ignore[list-item]
        (lambda: bob.Film(BALL, "front"), "cameras: expected several cameras, got one; put it in a list"),
        (
            lambda: bob.orbit(BALL).save("x.avi"),
            "x.avi: expected a film's ending (.webp .png .gif .avif .mp4), got .avi",
        ),
        (lambda: bob.orbit(BALL).save("x.gif", fps=0), "fps: expected a number in [0.1, 100], got 0"),
        (lambda: bob.thumbnails("nowhere", "out"), "nowhere: expected a shape file or a folder of them"),
        (lambda: bob.thumbnails(".", "out", up="w"), "up: expected one of auto, x, y, z, -x, -y, -z, got 'w'"),
        (lambda: bob.thumbnails(".", "out", workers=0), "workers: expected an integer in 1..256, got 0"),
        (lambda: contact_sheet([]), "sheet: expected at least one thumbnail, got none"),
    ],
)
def test_mistakes_are_told(call: Any, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as error:
        call()
    assert str(error.value).startswith(message)
    assert not any(tmp_path.iterdir())


# ---- Films -----------------------------------------------------------------------------------------------


def test_a_film_is_its_pictures() -> None:
    cameras = [bob.Camera(azimuth=10), "top", bob.Camera(azimuth=200, elevation=-30, fov=40)]
    film = bob.Film(bob.happy_tree(), cameras, size="40x30", background="#fff")
    for picture, camera in zip(film, cameras, strict=True):
        assert np.array_equal(picture.rgba, bob.render(bob.happy_tree(), camera, size=(30, 40), background="#fff").rgba)
    assert repr(film) == "Film(3 pictures of 40 x 30)"


def test_an_orbit_is_one_turn() -> None:
    film = bob.orbit(BALL, bob.Camera(azimuth=40, elevation=5, fov=30), frames=8)
    assert [camera.azimuth for camera in film.cameras] == [40 + 45 * i for i in range(8)]
    assert {replace(camera, azimuth=0) for camera in film.cameras} == {bob.Camera(azimuth=0, elevation=5, fov=30)}


@pytest.mark.parametrize("ending", [".webp", ".png", ".gif", ".avif"])
@pytest.mark.parametrize("background", [None, "#ffffff"])
def test_films_are_written(ending: str, background: str | None, tmp_path: Path) -> None:
    red = bob.Instance(bob.happy_tree(), material=bob.Material("#c03020"))
    film = bob.orbit(red, frames=4, size="80x60", background=background)
    shares: list[float] = []
    film.save(tmp_path / f"a{ending}", fps=40, progress=shares.append)
    assert shares == [0.25, 0.5, 0.75, 1]
    with Image.open(tmp_path / f"a{ending}") as file:
        assert (file.n_frames, file.size, file.info.get("loop", 0)) == (4, (80, 60), 0)  # type: ignore[attr-defined]
        durations = []
        for i, picture in enumerate(film):
            file.seek(i)
            file.load()
            durations.append(file.info["duration"])
            shown = np.asarray(file.convert("RGBA")).astype(int)
            alpha = picture.rgba[..., 3:] / 255
            assert np.abs(shown[..., :3] - picture.rgba[..., :3])[alpha[..., 0] == 1].mean() < 9  # of lossy formats
            assert np.abs(shown[..., 3] / 255 - alpha[..., 0]).mean() < {".gif": 0.03, ".avif": 0.005}.get(
                ending, 0.001
            )
    assert sum(durations) == pytest.approx(100, abs=20)  # GIF counts in hundredths


def test_films_as_mp4(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    film = bob.orbit(bob.happy_tree(), frames=5, size="81x61", background="#336699")
    film.save(tmp_path / "a.mp4", fps=10)
    with av.open(tmp_path / "a.mp4") as file:
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
        assert float(file.streams.video[0].average_rate) == 10
    assert [frame.shape for frame in frames] == [(62, 82, 3)] * 5
    for frame, picture in zip(frames, film, strict=True):
        assert np.abs(frame[:61, :81].astype(int) - picture.rgba[..., :3]).mean() < 6


def test_a_film_shows_itself() -> None:
    html = bob.orbit(BALL, frames=3, size="20x20")._repr_html_()
    assert re.match(r'<img alt="" src="data:image/webp;base64,[\w+/=]+">$', html)


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Return the address of a cluster of one process."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


def test_a_cluster_makes_the_same_film(scheduler: str) -> None:
    options: dict[str, Any] = {"frames": 9, "size": "20x20", "fraction": 0.2}
    here, there = bob.orbit(BALL, **options), bob.orbit(BALL, **options, scheduler=scheduler)
    drawn = list(there)
    assert len(drawn) == 9
    for expected, picture in zip(here, drawn, strict=True):
        assert np.array_equal(picture.rgba, expected.rgba)


def test_a_cluster_makes_the_same_thumbnails(
    scheduler: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = bob.thumbnails(folder, tmp_path / "here", size="32x24")
    assert (
        cli.main(["thumbs", str(folder), "-o", str(tmp_path / "there"), "--size", "32x24", "--scheduler", scheduler])
        == 1
    )
    printed = capsys.readouterr()
    assert "wrote 2 pictures" in printed.out
    assert f"left out: {folder}/deeper/broken.obj: expected triangles, got none" in printed.err
    for each in made:
        if each.picture is not None:
            there = tmp_path / "there" / each.picture.relative_to(tmp_path / "here")
            assert there.read_bytes() == each.picture.read_bytes()


def test_no_cluster_is_one_line(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(bob.InputError, match="scheduler: expected a Dask scheduler's address, got 'nonsense'"):
        bob.thumbnails(folder, tmp_path / "out", scheduler="nonsense")
    with pytest.raises(bob.InputError, match="scheduler: expected a Dask scheduler's address, got 'nonsense'"):
        list(bob.orbit(BALL, frames=2, scheduler="nonsense"))
    monkeypatch.setattr(cluster, "ANSWER_SECONDS", 1)
    with (
        socket.create_server(("127.0.0.1", 0)) as silent,
        pytest.raises(bob.InputError, match=r"scheduler: expected .* got '127.0.0.1:[0-9]+': no answer in 1 seconds"),
    ):
        bob.thumbnails(folder, tmp_path / "out", scheduler=f"127.0.0.1:{silent.getsockname()[1]}")
    with pytest.raises(bob.InputTypeError, match="model: expected a name or a path for a cluster, got a Network"):
        bob.orbit(BALL, model=load_network("default"), scheduler="nonsense")


def test_orbit_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "turn.webp"
    assert cli.main(["orbit", "--frames", "3", "--size", "64x48", "--fraction", "20%", "-o", str(out)]) == 0
    assert capsys.readouterr().out.startswith(f"wrote {out}: Film(3 pictures of 64 x 48) of 1 shape")
    with Image.open(out) as file:
        assert file.n_frames == 3  # type: ignore[attr-defined]
        assert file.convert("RGB").getpixel((0, 0)) == (255, 255, 255)


def test_render_makes_a_picture_to_look_at_of_files(tmp_path: Path) -> None:
    """Exact, antialiased, fitted and transparent: equal to `bob.render` with a fitted camera."""
    ROD.save(tmp_path / "rod.ply")
    options = ["render", str(tmp_path / "rod.ply"), "--size", "48x96"]
    picture, photo, near = (tmp_path / name for name in ("rod.png", "rod.jpg", "near.png"))
    assert cli.main([*options, "-o", str(picture)]) == 0
    rod = bob.load(tmp_path / "rod.ply")
    expected = bob.render(rod, bob.fitted(rod, size="48x96"), size="48x96")
    assert np.array_equal(np.asarray(opened(picture)), expected.rgba)
    assert cli.main([*options, "-o", str(photo)]) == 0
    assert min(opened(photo).getpixel((0, 0))) > 250  # white, instead of transparent
    assert cli.main([*options, "--zoom", "2", "-o", str(near)]) == 0
    assert np.array_equal(np.asarray(opened(near)), bob.render(rod, bob.Camera(zoom=2), size="48x96").rgba)


@pytest.mark.parametrize("amount", [["--fraction", "100%"], ["--fraction", "20%"], ["--error", "0.01"]])
def test_an_amount_to_trace_is_of_pixel_centres(amount: list[str], tmp_path: Path) -> None:
    ROD.save(tmp_path / "rod.ply")
    out = tmp_path / "rod.png"
    assert (
        cli.main(
            [
                "render",
                str(tmp_path / "rod.ply"),
                "--size",
                "48x96",
                *amount,
                "--samples",
                "1",
                "--background",
                "#000",
                "-o",
                str(out),
            ]
        )
        == 0
    )
    rod = bob.load(tmp_path / "rod.ply")
    if amount[0] == "--error":
        *_, frame = bob.progressive(rod, size="48x96", fraction=0.01, until=0.01)
        gray = frame.image
    else:
        gray = bob.complete(bob.trace(rod, size="48x96", fraction=float(amount[1][:-1]) / 100))
    assert np.array_equal(np.asarray(opened(out))[..., 0], color_to_8_bit(gray))


def test_render_fits_on_the_command_line(tmp_path: Path) -> None:
    ROD.save(tmp_path / "rod.ply")
    boxes = []
    for fit in ("sphere", "silhouette"):
        out = tmp_path / f"{fit}.png"
        options = ["--size", "48x96", "--fit", fit, "--fraction", "100%", "--background", "transparent"]
        assert cli.main(["render", str(tmp_path / "rod.ply"), *options, "-o", str(out)]) == 0
        boxes.append(box_of(np.asarray(opened(out))[..., 3]))
    (top, bottom, *_), (higher, lower, *_) = boxes
    assert bottom - top < 48
    assert lower - higher > 80


# ---- Thumbnails ------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two shapes, one in a subfolder, a broken one, and an unrelated file."""
    (tmp_path / "in/deeper").mkdir(parents=True)
    ROD.save(tmp_path / "in/rod.ply")
    (tmp_path / "in/deeper/ball.sdf").write_text("sphere(1)")
    (tmp_path / "in/deeper/broken.obj").write_text("f 1 2\n")
    (tmp_path / "in/notes.txt").write_text("nothing")
    return tmp_path / "in"


def test_thumbnails_of_a_folder(folder: Path, tmp_path: Path) -> None:
    shares: list[float] = []
    made = bob.thumbnails(folder, tmp_path / "out", size="32x24", progress=shares.append)
    out = tmp_path / "out"
    assert [(each.file, each.picture, each.is_new) for each in made] == [
        (folder / "deeper/ball.sdf", out / "deeper/ball.sdf.png", True),
        (folder / "deeper/broken.obj", None, True),
        (folder / "rod.ply", out / "rod.ply.png", True),
    ]
    assert made[1].error == "broken.obj: expected triangles, got none"
    assert sorted(path.name for path in out.rglob("*.png")) == ["ball.sdf.png", "rod.ply.png"]
    assert shares == pytest.approx([1 / 3, 2 / 3, 1])
    drawn = np.asarray(opened(out / "deeper/ball.sdf.png"))
    fitting = bob.fitted(BALL, size=(24, 32))
    assert np.array_equal(drawn, bob.render(BALL, fitting, size=(24, 32)).rgba)


def test_thumbnails_that_are_there_stay(folder: Path, tmp_path: Path) -> None:
    bob.thumbnails(folder, tmp_path / "out", size="32x24")
    kept, changed = tmp_path / "out/rod.ply.png", tmp_path / "out/deeper/ball.sdf.png"
    kept.write_bytes(b"mine")
    os.utime(folder / "deeper/ball.sdf", (4e9, 4e9))
    made = bob.thumbnails(folder, tmp_path / "out", size="16x16")
    assert [each.is_new for each in made] == [True, True, False]
    assert kept.read_bytes() == b"mine"
    assert opened(changed).size == (16, 16)
    assert all(each.is_new for each in bob.thumbnails(folder, tmp_path / "out", size="16x16", anew=True))
    assert opened(kept).size == (16, 16)


def test_a_file_that_ends_its_process_costs_itself_alone(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Like a crash in a foreign reader; here the process ends itself as it reads the file."""
    (folder / "deadly.sdf").write_text("sphere(2)")
    (tmp_path / "sitecustomize.py").write_text(
        "import sys, os, signal\n"
        "def ends(event, arguments):\n"
        "    if event == 'open' and str(arguments[0]).endswith('deadly.sdf'):\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
        "sys.addaudithook(ends)\n"
    )
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    made = {each.file.name: each for each in bob.thumbnails(folder, tmp_path / "out", size="16x16")}
    assert made["deadly.sdf"].error == "deadly.sdf: its reader ended without a word, perhaps for want of memory"
    assert {name for name, each in made.items() if each.picture} == {"ball.sdf", "rod.ply"}
    assert signal.SIGKILL  # the name used by the file above


def test_no_files_are_no_error(tmp_path: Path) -> None:
    assert bob.thumbnails(tmp_path, tmp_path / "out") == []
    assert list(_made([], Style((8, 8), bob.Camera(), 1, None, "z"), 2)) == []


def test_a_contact_sheet(folder: Path, tmp_path: Path) -> None:
    made = bob.thumbnails(folder, tmp_path / "out", size="64x48")
    sheet = contact_sheet(made, columns=2)
    assert sheet.shape[1] == 2 * 64 + 4
    assert (sheet[:48, :64] != 255).any()  # the ball
    assert (sheet[48:70, :64] < 128).any()  # its name
    assert contact_sheet([*made, *made, Thumbnail(folder, None, "broken")], columns=2).shape[0] == 2 * sheet.shape[0]


def test_a_contact_sheet_names_files_in_one_line(folder: Path, tmp_path: Path) -> None:
    picture = next(each.picture for each in bob.thumbnails(folder, tmp_path / "out", size="64x48") if each.picture)
    assert contact_sheet([Thumbnail(folder / "two\nlines.ply", picture, None)]).shape[1] == 64


def test_folders_may_begin_at_home(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(folder.parent))
    monkeypatch.setenv("USERPROFILE", str(folder.parent))
    made = bob.thumbnails(f"~/{folder.name}", "~/pictures", size="16x16")
    pictures = [each.picture for each in made if each.picture is not None]
    assert pictures
    assert all(folder.parent / "pictures" in picture.parents for picture in pictures)


def test_a_file_is_no_folder_for_pictures(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match=r"^out: expected a folder to write to, got .* is a file"):
            bob.thumbnails(folder, place)


def test_a_read_only_folder_is_named_before_pictures_are_made(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(InputError, match=rf"^out: expected a folder .*, where {re.escape(str(tmp_path))} is read-only"):
        bob.thumbnails(folder, tmp_path / "below" / "out")


def test_thumbs_on_the_command_line(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, sheet = tmp_path / "out", tmp_path / "sheet.png"
    options = ["-o", str(out), "--size", "32x32", "--background", "#ffffff", "--sheet", str(sheet)]
    assert cli.main(["thumbs", str(folder), *options]) == 1
    told = capsys.readouterr()
    lines = [line for line in told.err.splitlines() if not line.startswith("drawing: ")]
    assert lines == [f"left out: {folder}/deeper/broken.obj: expected triangles, got none"]
    assert re.search(rf"wrote 2 pictures to {out} in .* s; 0 pictures were there, 1 file left out\n$", told.out)
    assert opened(sheet).size[0] > 32
    assert opened(out / "rod.ply.png").convert("RGBA").getpixel((0, 0)) == (255, 255, 255, 255)
    next(folder.rglob("broken.obj")).unlink()
    assert cli.main(["thumbs", str(folder), *options]) == 0
    assert "wrote 0 pictures" in capsys.readouterr().out


def test_equal_names_have_pictures_and_captions_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    captions: list[str] = []
    draw = ImageDraw.ImageDraw.text
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda *a, **k: (captions.append(a[2]), draw(*a, **k)))
    for name in ("a/x.ply", "b/x.ply", "b/y.ply"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        ROD.save(tmp_path / name)
    made = bob.thumbnails(tmp_path, tmp_path / "out", size="256x32", samples=1)
    assert len({each.picture for each in made}) == 3
    contact_sheet(made)
    assert captions == ["a/x.ply", "b/x.ply", "y.ply"]


@needs_models
def test_thumbnails_of_real_files(tmp_path: Path) -> None:
    made = bob.thumbnails(MODELS / "loader_originals", tmp_path, size="64x64", samples=1)
    assert {each.file.name: each.error for each in made if each.error} == {}
    assert "firetruck.gltf" in {each.file.name for each in made}  # it is compressed by Draco
    for each in made:
        assert each.picture is not None
        assert np.asarray(opened(each.picture))[..., 3].mean() > 10


# ---- Notebooks -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("thing", "size"),
    [
        (BALL, (256, 256)),
        (bob.Instance(ROD), (256, 256)),
        (bob.Scene([BALL, ROD]), (256, 256)),
        (bob.happy_tree(), (256, 256)),
        (bob.trace(BALL, size=(30, 40), fraction=0.1), (40, 30)),
        (bob.render(BALL, size=(30, 40)), (40, 30)),
    ],
)
def test_what_shows_itself(thing: Any, size: tuple[int, int]) -> None:
    with Image.open(io.BytesIO(thing._repr_png_())) as picture:
        assert picture.size == size
        assert np.ptp(np.asarray(picture.convert("L"))) > 50
