"""The tools for agents, by the protocol's own client: looking, picking, measuring, comparing, and refusals."""

import asyncio
import base64
import io
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from clocks import least
from PIL import Image
from processes import COMMAND, running

import bobrossnet as bob
from bobrossnet.agents.workspace import Workspace
from bobrossnet.measuring.volumes import closed_volume
from bobrossnet.sdf import X, Z, box, capped_cylinder, cylinder

needs_cad = pytest.mark.skipif(find_spec("OCP") is None, reason="OpenCascade is not installed")

PLATE = box((6, 4, 1)) - cylinder(0.8).translate(1.5 * X)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    for name, shape in {
        "plate": PLATE,
        "no_hole": box((6, 4, 1)),
        "thick": box((6, 4, 1.2)) - cylinder(0.8).translate(1.5 * X),
        "mirrored": box((6, 4, 1)) - cylinder(0.8).translate(-1.5 * X),
    }.items():
        shape.mesh(0.1).save(folder / f"{name}.stl")
    plate = bob.load_mesh(folder / "plate.stl")
    bob.Mesh(plate.vertices, plate.triangles[:, ::-1]).save(folder / "inside_out.stl")
    bob.Mesh(plate.vertices, plate.triangles[:-40]).save(folder / "open.stl")
    # One face of the plate, its top, is inside out.
    flipped = plate.triangles.copy()
    top = (plate.vertices[flipped][..., 2] > 0.499).all(axis=1)
    flipped[top] = flipped[top, ::-1]
    bob.Mesh(plate.vertices, flipped).save(folder / "inverted_face.stl")
    pin = capped_cylinder(-Z, Z, 0.8).mesh(0.1)
    thick_pin = capped_cylinder(-Z, Z, 0.9).mesh(0.1)
    for name, part in {"fits": pin, "collides": thick_pin}.items():
        parts = [bob.Instance(plate, name="plate"), bob.Instance(part, name="pin").translate(1.5 * X + (0, 0, 0.2))]
        bob.save_scene(bob.Scene(parts), folder / f"{name}.bob")
    for name in ("step-tessellated/solid-and-triangles.step", "3mf-build-of-parts/box.3mf"):
        shutil.copy(Path(__file__).parent / "cases" / name, folder)
    return folder


def client(of):
    """Return a client of a server, or of one for a folder. Their imports take two seconds, here in one worker alone."""
    from mcp.client import Client

    from bobrossnet.agents.server import server

    return Client(server([of]) if isinstance(of, Path) else of)


@pytest.fixture
def calls(folder):
    """Calls tools one after another; each result is the object in the tool's text, or a picture's array."""

    def run(*wanted):
        async def session():
            async with client(folder) as session:
                return [await session.call_tool(name, settings) for name, settings in wanted]

        return [contents(result) for result in finished(session())]

    return run


def finished(coroutine):
    """Run it in a new thread: browsers of other tests keep a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()


def contents(result):
    if result.is_error:
        (text,) = result.content
        return text.text
    parts = [
        json.loads(part.text)
        if part.type == "text"
        else np.asarray(Image.open(io.BytesIO(base64.b64decode(part.data))))
        for part in result.content
    ]
    return parts[0] if len(parts) == 1 else parts


def test_tools_are_listed(folder):
    async def session():
        async with client(folder) as session:
            return {tool.name: tool.description for tool in (await session.list_tools()).tools}

    tools = finished(session())
    assert set(tools) == {"look", "describe", "pick", "measure", "compare", "mesh"}
    assert all(len(text) > 40 for text in tools.values())


def test_looking_at_files_and_scripts(calls):
    sheet, view, script = calls(
        ("look", {"file": "plate.stl", "size": "640x480"}),
        ("look", {"file": "plate.stl", "views": ["top"], "size": "320x240"}),
        ("look", {"script": "sphere(1) & box(1.5)", "views": ["top", "front"], "size": "320x240"}),
    )
    assert sheet.shape == (480, 640, 3)
    assert view.shape == (240, 320, 3)
    assert script.shape == (240, 320, 3)
    assert all((picture != 255).any() for picture in (sheet, view, script))


def test_cutting_and_highlighting(calls):
    seen = {"file": "plate.stl", "views": ["right"], "size": "320x240", "edges": False}
    whole, cut, picked, red, wrong, nobody = calls(
        ("look", seen),
        ("look", {**seen, "section": ["x=1.5"]}),
        ("pick", {"row": 120, "column": 230}),
        ("look", {**seen, "highlight": ["plate.stl"]}),
        ("look", {**seen, "section": ["sideways"]}),
        ("look", {**seen, "highlight": ["nobody"]}),
    )
    assert (whole != cut).any()
    assert picked["hit"]["point"][0] == pytest.approx(1.5, abs=1e-3)
    assert np.ptp(whole.astype(int), axis=-1).max() < 10
    assert np.ptp(red.astype(int), axis=-1).max() > 60
    assert "section: expected an axis" in wrong
    assert "nobody" in nobody


def test_picking_and_measuring(calls):
    height, width = 240, 320
    _, edge, hole, across, background = calls(
        ("look", {"file": "plate.stl", "views": ["top"], "size": f"{width}x{height}"}),
        ("pick", {"row": height // 2, "column": width // 3}),
        ("pick", {"row": height // 2, "column": width // 2 + 72}),  # within the hole
        ("measure", {"first": [60, 60], "second": [180, 60]}),
        ("measure", {"first": [60, 60], "second": [0, 0]}),
    )
    assert edge["hit"]["part"] == "plate.stl"
    assert edge["hit"]["point"][2] == pytest.approx(0.5, abs=1e-3)
    assert np.allclose(edge["hit"]["normal"], (0, 0, 1), atol=1e-3)
    assert hole == {"hit": None}
    assert across["distance"] == pytest.approx(abs(across["offset"][1]), rel=1e-3)
    assert across["angle"] < 0.1
    assert background.endswith("second: expected a pixel with a surface, got background")


def test_points_snap_to_corners_and_edges(calls):
    look = ("look", {"file": "plate.stl", "views": ["top"], "size": "320x240", "edges": False})
    (seen,) = calls(look)
    rows, columns = np.nonzero((seen != 255).any(axis=-1))
    corner = [int(rows.min()) + 4, int(columns.min()) + 4]
    hole = [120, int(np.flatnonzero((seen[120] == 255).all(axis=-1) & (np.arange(320) > 160))[0])]  # its left end
    other = [int(rows.max()) - 4, int(columns.max()) - 4]
    snapping = {"snap": 10}
    _, free, snapped, edge, across, wrong = calls(
        look,
        ("pick", {"row": corner[0], "column": corner[1]}),
        ("pick", {"row": corner[0], "column": corner[1], **snapping}),
        ("pick", {"row": hole[0], "column": hole[1], **snapping}),
        ("measure", {"first": corner, "second": other, **snapping}),
        ("pick", {"row": 0, "column": 0, "snap": -1}),
    )
    assert "snapped" not in free["hit"]
    assert snapped["hit"]["snapped"] == "corner"
    np.testing.assert_allclose(snapped["hit"]["point"], (-3, 2, 0.5), atol=1e-5)
    assert edge["hit"]["snapped"] == "edge"
    assert np.hypot(edge["hit"]["point"][0] - 1.5, edge["hit"]["point"][1]) == pytest.approx(0.8, abs=2e-3)
    assert across["distance"] == pytest.approx(np.hypot(6, 4), abs=1e-5)
    assert across["second"]["snapped"] == "corner"
    assert wrong.endswith("snap: expected a number in [0, 320], got -1")


def test_a_picked_point_is_where_the_picture_shows_it(calls):
    """At a corner seen in perspective of no axis: the points of three pixels lie on the planes of the block."""
    _, *picked = calls(
        ("look", {"script": "box((2, 3, 4))", "size": "200x200", "views": ["isometric"]}),
        *(("pick", {"row": row, "column": column}) for row, column in ((60, 100), (120, 60), (120, 140))),
    )
    on = [np.isclose(np.abs(pick["hit"]["point"]), (1, 1.5, 2), atol=1e-3) for pick in picked]
    assert [row.tolist() for row in on] == [[False, False, True], [False, True, False], [True, False, False]]
    normals = [np.round(pick["hit"]["normal"], 3).tolist() for pick in picked]
    assert normals == [[0, 0, 1], [0, -1, 0], [1, 0, 0]]


def test_a_mistake_in_a_script_has_its_place(calls):
    (said,) = calls(("look", {"script": "f = sphere(1)\ng = boxx(2)"}))
    assert "line 2, column 5: boxx: " in said
    assert "\n" not in said


@pytest.mark.parametrize("name", ["../secret.stl", "/etc/passwd", "link.stl", "~/x.stl", "a\0b", "", "."])
def test_files_elsewhere_are_refused(calls, folder, name):
    secret = folder.parent / "secret.stl"
    bob.happy_tree().save(secret)
    if not (folder / "link.stl").is_symlink():
        os.symlink(secret, folder / "link.stl")
    read, written = calls(("describe", {"file": name}), ("mesh", {"out": name, "script": "sphere(1)", "step": 0.5}))
    for said in (read, written):
        assert isinstance(said, str)
        assert "\n" not in said
    assert "Error executing tool describe: " in read


@pytest.mark.parametrize(
    ("tool", "settings", "message"),
    [
        ("look", {}, "file, script: expected one of them"),
        ("look", {"script": "sphere(1)", "size": "4000x10"}, "size: expected at most 2048 pixels a side, got 4000x10"),
        ("look", {"script": "sphere(1)", "views": ["above"]}, "views: expected one of front, "),
        ("look", {"file": "missing.stl", "size": "4000x10"}, "size: expected at most 2048 pixels a side, got 4000x10"),
        ("look", {"file": "missing.stl", "views": ["above"]}, "views: expected one of front, "),
        ("look", {"file": "missing.stl", "section": ["q=1"]}, "section: expected "),
        ("look", {"file": "missing.stl", "unit": "furlong"}, "unit: expected one of "),
        ("compare", {"first": "missing.stl", "second": "missing.stl", "view": "above"}, "view: expected one of "),
        ("mesh", {"out": "x.doc", "file": "missing.stl"}, "x.doc: "),
        ("pick", {"row": 0, "column": 0}, "pick: expected an earlier picture; call look first"),
        ("measure", {"first": [1], "second": [2, 3]}, "pick: expected an earlier picture; call look first"),
        ("mesh", {"out": "x.doc", "script": "sphere(1)"}, "x.doc: "),
    ],
)
def test_bad_calls_are_one_line(calls, tool, settings, message):
    (said,) = calls((tool, settings))
    assert message in said
    assert "\n" not in said


def test_the_five_faults_of_the_document(calls):
    """docs/agents.md has these numbers."""
    names = ("plate", "thick", "inside_out", "inverted_face", "open")
    plate, thick, inside_out, inverted, opened = calls(*(("describe", {"file": f"{name}.stl"}) for name in names))
    volume = 6 * 4 - np.pi * 0.8**2
    assert plate["volume"] == plate["parts"][0]["volume"] == pytest.approx(volume, rel=0.01)
    assert thick["size"] == [6, 4, 1.2]
    assert inside_out["parts"][0]["inside_out"] is True
    assert "inside_out" not in plate["parts"][0]
    part = inverted["parts"][0]
    assert (part["closed"], part["open_edges"]) == (False, 0)
    assert part["flipped_edges"] > 100
    part = opened["parts"][0]
    assert (part["closed"], part["flipped_edges"]) == (False, 0)
    assert part["open_edges"] > 10

    wanted = [{"first": "plate.stl", "second": f"{name}.stl", "size": "384x128"} for name in ("plate", "no_hole")]
    wanted += [{"first": "plate.stl", "second": f"{name}.stl", "size": "384x128"} for name in ("thick", "mirrored")]
    answers = calls(*(("compare", each) for each in wanted))
    same, hole, thick, mirrored = (numbers for _, numbers in answers)
    assert all(view == {"silhouette_iou": 1, "largest_depth_difference": 0} for view in same["views"].values())
    assert hole["views"]["top"]["silhouette_iou"] == pytest.approx(1 - np.pi * 0.8**2 / 24, abs=0.01)
    assert hole["views"]["front"]["silhouette_iou"] > 0.99
    assert thick["views"]["top"]["largest_depth_difference"] == pytest.approx(0.1, abs=0.002)
    assert thick["size"] == [[6, 4, 1], [6, 4, 1.2]]
    assert mirrored["size"][0] == mirrored["size"][1]
    assert mirrored["views"]["top"]["silhouette_iou"] < hole["views"]["top"]["silhouette_iou"]

    fits, collides = calls(*(("describe", {"file": f"{name}.bob"}) for name in ("fits", "collides")))
    assert all(each["depth"] < 0.01 for each in fits["overlaps"])
    (overlap,) = collides["overlaps"]
    assert overlap["parts"] == ["plate", "pin"]
    assert overlap["volume"] == pytest.approx(np.pi * (0.9**2 - 0.8**2), rel=0.1)  # of a ring as high as the plate


def test_pictures_of_differences(calls):
    """Red where only the first has a surface, blue where only the second, orange where depths differ."""

    def shares(picture):
        third = picture[:, -picture.shape[1] // 3 :].reshape(-1, 3).astype(int)
        return [float((np.abs(third - color).sum(axis=1) < 60).mean()) for color in ((222, 45, 38), (33, 102, 220))]

    seen = {"first": "no_hole.stl", "view": "top", "size": "600x150"}
    (same, _), (hole, _), (filled, _), (script, _) = calls(
        ("compare", {**seen, "second": "no_hole.stl"}),
        ("compare", {**seen, "second": "plate.stl"}),
        ("compare", {**seen, "first": "plate.stl", "second": "no_hole.stl"}),
        ("compare", {**seen, "script": "box((6, 4, 1)) - cylinder(0.8).translate(1.5 * X)"}),
    )
    assert shares(same) == [0, 0]
    for picture, first, second in ((hole, True, False), (filled, False, True), (script, True, False)):
        red, blue = shares(picture)
        assert (red > 0.03, blue > 0.03) == (first, second)
    both = calls(("compare", seen), ("compare", {**seen, "second": "plate.stl", "script": "sphere(1)"}))
    assert all("file, script: expected one of them" in said for said in both)


@needs_cad
def test_faces_are_highlighted(calls):
    """By the name that pick returns; the part stays closed in sections."""
    step = {"file": "solid-and-triangles.step", "views": ["top"], "size": "200x150", "edges": False}
    pixel = {"row": 50, "column": 160}  # of the solid at the right, next to its hole
    plain, picked = calls(("look", step), ("pick", pixel))
    name = picked["hit"]["highlight"]
    red, again, _, cap, wrong = calls(
        ("look", {**step, "highlight": [name]}),
        ("pick", pixel),
        ("look", {**step, "highlight": [name], "section": ["z=20"]}),
        ("pick", pixel),
        ("look", {**step, "highlight": [name.rpartition("#")[0] + "#999"]}),
    )
    changed = (plain != red).any(axis=-1)
    assert changed[50, 160]
    assert changed.sum() < 0.9 * (plain != 255).any(axis=-1).sum()
    assert picked == again  # faces have the numbers of the file
    assert cap["hit"]["section"] == 0
    assert "face: expected an integer in 0..7, got 999" in wrong


def test_pixels_of_sheets_are_picked(calls):
    """Each view in its place; sections too, whose caps belong to the part."""
    _, top, front, between, cap = calls(
        ("look", {"script": "box((6, 4, 1))", "views": ["top", "front"], "size": "800x400", "section": ["x=0"]}),
        ("pick", {"row": 95, "column": 200}),
        ("pick", {"row": 95, "column": 600}),
        ("measure", {"first": [95, 200], "second": [95, 600]}),
        ("pick", {"row": 285, "column": 200}),
    )
    assert (top["hit"]["normal"], front["hit"]["normal"]) == ([0, 0, 1], [0, -1, 0])
    assert between["angle"] == 90
    assert cap["hit"]["section"] == 0
    assert cap["hit"]["point"][0] == pytest.approx(0, abs=1e-3)


@needs_cad
def test_the_walk_of_an_agent(calls):
    """One session: a STEP file, a mistake in a script, a 3MF that is cut, a face, its measures, a path elsewhere."""
    box = {"file": "box.3mf", "views": ["right"], "size": "200x150"}
    solid = {"file": "solid-and-triangles.step"}
    step, told, mistake, whole, cut, picked, measured, elsewhere, _, face = calls(
        ("look", {**solid, "size": "640x480"}),
        ("describe", solid),
        ("look", {"script": "f = sphere(1)\ng = spere(2)"}),
        ("look", box),
        ("look", {**box, "section": ["x=1"]}),
        ("pick", {"row": 80, "column": 100}),
        ("measure", {"first": [80, 100], "second": [90, 100]}),
        ("describe", {"file": "../elsewhere.stl"}),
        ("look", {**solid, "views": ["right"], "size": "200x200"}),
        ("measure", {"first": [130, 100]}),
    )
    assert step.shape == (480, 640, 3)
    assert told["kinds"] == ["brep", "mesh"]
    assert told["unit"] == "mm"
    assert told["parts"][1]["volume"] == pytest.approx(5151.77, rel=1e-5)
    assert "line 2, column 5: spere: " in mistake
    assert (whole != cut).any()
    assert picked["hit"]["point"][0] == pytest.approx(1, abs=1e-3)
    assert measured["distance"] == pytest.approx(abs(measured["offset"][2]), rel=1e-3)
    assert elsewhere.startswith("Error executing tool describe: file: expected a path below")
    assert face["kind"] == "plane"
    assert face["unit"] == "mm"
    assert {"area", "thickness"} < {*face}


def test_a_file_that_changes_is_read_again(calls, folder):
    def size():
        (told,) = calls(("describe", {"file": "changing.stl"}))
        return told["size"]

    box(1).mesh(0.5).save(folder / "changing.stl")
    before, again = calls(*[("describe", {"file": "changing.stl"})] * 2)
    assert before == again
    box(2).mesh(0.5).save(folder / "changing.stl")
    assert before["size"] == [1, 1, 1]
    assert size() == [2, 2, 2]


def test_kept_files_are_few_and_current(folder):
    space = Workspace([folder])
    scene, _ = space.scene("plate.stl", None)
    assert space.scene("plate.stl", None)[0] is scene
    assert space.scene("plate.stl", None, "y")[0] is not scene
    space.scene("thick.stl", None)
    assert space.scene("plate.stl", None)[0] is not scene  # two are kept
    box(1).mesh(0.5).save(folder / "changing.stl")
    changing, _ = space.scene("changing.stl", None)
    box(2).mesh(0.5).save(folder / "changing.stl")
    assert space.scene("changing.stl", None)[0] is not changing


def test_meshes_are_written(calls, folder):
    (told,) = calls(("mesh", {"out": "ball.stl", "script": "sphere(1)", "step": 0.1}))
    assert told["closed"]
    assert told["volume"] == pytest.approx(4 / 3 * np.pi, rel=0.01)
    assert len(bob.load_mesh(folder / "ball.stl").triangles) == told["triangles"]


def test_volumes():
    tetrahedron = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    triangles = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], np.int32)
    assert closed_volume(tetrahedron, triangles) == pytest.approx(1 / 6)
    assert closed_volume(tetrahedron + 1e6, triangles) == pytest.approx(1 / 6)
    assert closed_volume(tetrahedron, triangles[:, ::-1]) == pytest.approx(-1 / 6)
    assert closed_volume(tetrahedron, triangles[:3]) is None
    soup = tetrahedron[triangles].reshape(-1, 3)  # as STL has it
    assert closed_volume(soup, np.arange(12, dtype=np.int32).reshape(4, 3)) == pytest.approx(1 / 6)


@pytest.mark.measures
def test_calls_keep_no_memory(calls):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

    five = [
        ("look", {"script": "sphere(1) & box(1.5)", "views": ["top"], "size": "200x150"}),
        ("pick", {"row": 75, "column": 100}),
        ("look", {"file": "plate.stl", "size": "320x240"}),
        ("describe", {"file": "no_hole.stl"}),
        ("compare", {"first": "plate.stl", "second": "thick.stl", "size": "150x50"}),
    ]
    calls(*five * 4)  # until the allocators' memory stops growing

    def growth():
        before = resident()
        calls(*five * 10)
        return resident() - before

    assert least(growth, 30) < 30


def test_the_command_speaks_the_protocol(folder):
    from mcp import StdioServerParameters
    from mcp.client.stdio import stdio_client

    async def session():
        arguments = ["-m", "bobrossnet", "mcp", str(folder)]
        command = StdioServerParameters(command=sys.executable, args=arguments, env=dict(os.environ))
        async with client(stdio_client(command)) as session:
            return await session.call_tool("describe", {"file": "plate.stl"})

    told = contents(finished(session()))
    assert told["size"] == [6, 4, 1]


def test_the_command_serves_http_on_this_machine(folder):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]

    async def session():
        async with client(f"http://127.0.0.1:{port}/mcp") as session:
            return await session.call_tool("describe", {"file": "plate.stl"})

    with running([*COMMAND, "mcp", str(folder), "--port", str(port)], stderr=subprocess.DEVNULL):
        until = time.monotonic() + 60
        while True:
            try:
                socket.create_connection(("127.0.0.1", port), 1).close()
                break
            except OSError:
                assert time.monotonic() < until
                time.sleep(0.1)
        told = contents(finished(session()))
    assert told["size"] == [6, 4, 1]
