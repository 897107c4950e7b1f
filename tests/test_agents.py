"""The tools for agents, by the protocol's own client: looking, picking, measuring, comparing, and what is refused."""

import asyncio
import base64
import io
import json
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from mcp import StdioServerParameters
from mcp.client import Client
from mcp.client.stdio import stdio_client
from PIL import Image

import bobrossnet as bob
from bobrossnet.agents.measures import closed_volume
from bobrossnet.agents.server import server
from bobrossnet.sdf import X, box, cylinder

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
    return folder


@pytest.fixture
def calls(folder):
    """Calls tools in turn; each result is what their texts hold, or a picture's array."""

    def run(*wanted):
        async def session():
            async with Client(server([folder])) as client:
                return [await client.call_tool(name, settings) for name, settings in wanted]

        return [contents(result) for result in finished(session())]

    return run


def finished(coroutine):
    """Run it in a thread of its own: browsers of other tests keep a loop in this one."""
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
        async with Client(server([folder])) as client:
            return {tool.name: tool.description for tool in (await client.list_tools()).tools}

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
    assert edge["hit"]["name"] == "plate.stl"
    assert edge["hit"]["point"][2] == pytest.approx(0.5, abs=1e-3)
    assert np.allclose(edge["hit"]["normal"], (0, 0, 1), atol=1e-3)
    assert hole == {"hit": None}
    assert across["distance"] == pytest.approx(abs(across["offset"][1]), rel=1e-3)
    assert across["angle"] < 0.1
    assert background.endswith("second: expected a pixel with a surface, got background")


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
        ("pick", {"row": 0, "column": 0}, "pick: expected a picture of a single view before"),
        ("measure", {"first": [1], "second": [2, 3]}, "pick: expected a picture of a single view before"),
        ("mesh", {"out": "x.doc", "script": "sphere(1)"}, "x.doc: "),
    ],
)
def test_bad_calls_are_one_line(calls, tool, settings, message):
    (said,) = calls((tool, settings))
    assert message in said
    assert "\n" not in said


def test_five_faults_are_told_apart(calls):
    names = ("plate", "inside_out", "open")
    plate, inside_out, opened = calls(*(("describe", {"file": f"{name}.stl"}) for name in names))
    volume = 6 * 4 - np.pi * 0.8**2
    assert plate["parts"][0]["volume"] == pytest.approx(volume, rel=0.01)
    assert inside_out["parts"][0]["inside_out"] is True
    assert opened["parts"][0]["closed"] is False

    seconds = ("plate", "no_hole", "thick", "mirrored")
    wanted = [{"first": "plate.stl", "second": f"{name}.stl", "size": "256x128"} for name in seconds]
    same, hole, thick, mirrored = (numbers for _, numbers in calls(*(("compare", each) for each in wanted)))
    assert all(view == {"silhouette_iou": 1, "largest_depth_difference": 0} for view in same["views"].values())
    assert hole["views"]["top"]["silhouette_iou"] == pytest.approx(1 - np.pi * 0.8**2 / 24, abs=0.01)
    assert hole["views"]["front"]["silhouette_iou"] > 0.99
    assert thick["views"]["top"]["largest_depth_difference"] == pytest.approx(0.1, abs=0.002)
    assert thick["size"] == [[6, 4, 1], [6, 4, 1.2]]
    assert mirrored["size"][0] == mirrored["size"][1]
    assert mirrored["views"]["top"]["silhouette_iou"] < hole["views"]["top"]["silhouette_iou"]


def test_colliding_parts_have_bounds_that_overlap(calls):
    (told,) = calls(("describe", {"script": "f = box(2) | box(2).translate(X)"}))
    assert told["size"] == pytest.approx([3, 2, 2], rel=1e-3)


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
def test_a_hundred_calls_keep_no_memory(calls):
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

    look = ("look", {"script": "sphere(1) & box(1.5)", "views": ["top"], "size": "200x150"})
    calls(*[look] * 20)
    before = resident()
    calls(*[look] * 100)
    assert resident() - before < 30


def test_the_command_speaks_the_protocol(folder):
    async def session():
        arguments = ["-m", "bobrossnet", "mcp", str(folder)]
        command = StdioServerParameters(command=sys.executable, args=arguments, env=dict(os.environ))
        async with Client(stdio_client(command)) as client:
            return await client.call_tool("describe", {"file": "plate.stl"})

    told = contents(finished(session()))
    assert told["size"] == [6, 4, 1]
