"""Edges: lines at borders of faces, creases and silhouettes, against closed forms and against the ids of first hits."""

import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import numpy as np
import pytest
from nurbs_shapes import cylinder, sphere, torus
from PIL import Image

import bobrossnet as bob
from bobrossnet import sdf
from bobrossnet.command_line import cli

SIZE = (240, 320)
CAMERA = bob.Camera(azimuth=25, elevation=35)

CORNERS = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]
HIDDEN_CORNER = 0  # seen from CAMERA, the corner of the three hidden edges


def cube_mesh():
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return bob.Mesh(CORNERS, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def cube_brep():
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            points = np.empty((2, 2, 3))
            points[..., axis] = side
            points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = np.meshgrid((-1, 1), (-1, 1), indexing="ij")
            faces.append(bob.Face(points, [0, 0, 1, 1], [0, 0, 1, 1]))
    return bob.Brep(faces)


CUBES = {
    "mesh": cube_mesh(),
    "brep": cube_brep(),
    "formula": bob.Implicit(sdf.box(2).expression, ((-2, -2, -2), (2, 2, 2))),
}


def seen(scene, camera, points, size=SIZE):
    """Return the rows and columns of points in the scene's units."""
    points = (np.asarray(points) - scene.center) / scene.radius
    return camera.core(scene.center, scene.radius).seen(*size, points.astype(np.float32))[:, :2]


def along(curves, step=1.0):
    """Return places along polylines, (n, 2)."""
    places = []
    for curve in curves:
        for a, b in pairwise(curve):
            count = int(np.ceil(np.linalg.norm(b - a) / step)) + 1
            places.append(a + np.linspace(0, 1, count)[:, None] * (b - a))
    return np.concatenate(places)


def farthest(places, others):
    """Return the largest distance from one of the places to the nearest of the others."""
    return max(np.sqrt(((others - place) ** 2).sum(axis=1).min()) for place in places)


def length(curves):
    return sum(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum() for curve in curves)


@pytest.mark.parametrize(
    "camera", [CAMERA, bob.Camera(azimuth=25, elevation=35, fov=40, zoom=0.9)], ids=["far", "near"]
)
@pytest.mark.parametrize("kind", CUBES)
def test_a_cube_has_its_edges_and_no_others(kind, camera):
    scene = bob.Scene(CUBES[kind])
    drawing = bob.draw(scene, camera, size=SIZE, edges=bob.Edges(hidden=True))
    places = {edge: seen(scene, camera, CORNERS[list(edge)]) for edge in EDGES}
    visible = along([places[edge] for edge in EDGES if HIDDEN_CORNER not in edge], 0.25)
    assert farthest(along(drawing.visible), visible) < 0.3  # at corners, else 0.1
    assert farthest(visible[::2], along(drawing.visible, 0.25)) < 0.5  # the corners
    if kind == "formula":
        assert drawing.hidden == ()
    else:
        hidden = along([places[edge] for edge in EDGES if HIDDEN_CORNER in edge], 0.1)
        assert farthest(along(drawing.hidden), hidden) < 0.15
        assert farthest(hidden, along(drawing.hidden, 0.1)) < 2  # they end at a visible line


BALL = bob.Implicit(sdf.sphere(1).expression, ((-2, -2, -2), (2, 2, 2)))


@pytest.mark.parametrize("shape", [BALL, BALL.mesh(0.05)], ids=["formula", "mesh"])
def test_a_ball_has_its_outline_alone(shape):
    """The mesh has 5,000 triangles, which are no edges."""
    (outline,) = bob.draw(shape, bob.Camera(zoom=0.9), size=SIZE, edges=bob.Edges(hidden=True)).visible
    assert (outline[0] == outline[-1]).all()
    radius = np.linalg.norm(outline - (119.5, 159.5), axis=1)
    assert np.abs(radius - 108 / bob.Scene(shape).radius).max() < (0.1 if isinstance(shape, bob.Implicit) else 1)


def test_a_torus_hides_itself():
    """A silhouette between two places of one smooth face."""
    drawing = bob.draw(torus(), bob.Camera(azimuth=0, elevation=20), size=SIZE)
    inside = [curve for curve in drawing.visible if np.abs(curve - (119.5, 159.5)).max() < 80]
    assert len(drawing.visible) >= 2
    assert length(inside) > 100


def test_seams_are_no_edges():
    """Borders of a cylinder are circles; the line where its surface closes is not drawn."""
    scene = bob.Scene(cylinder())
    camera = bob.Camera(azimuth=0, elevation=30)
    angles = np.linspace(0, 2 * np.pi, 2000)
    circles = [np.stack([0.7 * np.cos(angles), 0.7 * np.sin(angles), np.full(2000, z)], axis=1) for z in (-0.6, 0.4)]
    sides = [[(0, y, z) for z in np.linspace(-0.6, 0.4, 500)] for y in (-0.7, 0.7)]
    expected = np.concatenate([seen(scene, camera, points) for points in (*circles, *sides)])
    drawing = bob.draw(scene, camera, size=SIZE, edges=bob.Edges(hidden=True))
    assert farthest(along(drawing.visible), expected) < 0.3
    assert farthest(along(drawing.hidden), seen(scene, camera, circles[0])) < 0.2


def halves(numbers):
    """Two faces that continue each other in a plane."""
    points = [np.array([[(x, y, 0.0) for y in (0.0, 1.0)] for x in ends]) for ends in ((-1.0, 0.0), (0.0, 1.0))]
    return bob.Brep([bob.Face(p, [0, 0, 1, 1], [0, 0, 1, 1]) for p in points], face_numbers=numbers)


@pytest.mark.parametrize(
    ("numbers", "edges", "lines"),
    [(None, bob.Edges(), 1), ([5, 5], bob.Edges(hidden=True), 0), (None, bob.Edges(smooth=False), 0)],
)
def test_pieces_of_a_face_have_no_border(numbers, edges, lines):
    drawing = bob.draw(halves(numbers), bob.Camera(azimuth=-90, elevation=90), size=SIZE, edges=edges)
    middle = [curve for curve in drawing.visible if np.abs(curve[:, 1] - 159.5).max() < 1]
    assert len(middle) == lines
    assert drawing.hidden == ()


def test_numbers_of_faces_are_kept(tmp_path):
    bob.save_scene(halves([5, 5]), tmp_path / "halves.bob")
    (instance,) = bob.load(tmp_path / "halves.bob").instances
    assert instance.shape.face_numbers.tolist() == [5, 5]
    for wrong in ([1], [1, -1], [0.5, 1], "ab"):
        with pytest.raises(bob.InputError, match="face_numbers"):
            halves(wrong)


def face_ids(scene, camera, size):
    """Return the instance and the face at each pixel, (H, W, 2): pieces of one face have its number."""
    rows, columns = np.indices(size).reshape(2, -1).astype(np.float32)
    core = camera.core(scene.center, scene.radius)
    near, far = (core.points(*size, np.stack([rows, columns, np.full_like(rows, d)], axis=1)) for d in (1.01, 0))
    hits = scene.closest_hits(near.astype(float) * scene.radius + scene.center, (far - near).astype(float))
    faces = hits.primitive.copy()
    for number, instance in enumerate(scene.instances):
        if instance.shape.face_numbers is not None:
            own = hits.instance == number
            faces[own] = instance.shape.face_numbers[faces[own]]
    return np.stack([hits.instance, faces], axis=1).reshape(*size, 2)


def neighbours_differ(scene, camera, size):
    """Return whether the faces of horizontal and of vertical neighbours differ."""
    ids = face_ids(scene, camera, size)
    return [(np.diff(ids, axis=axis) != 0).any(axis=-1) for axis in (1, 0)]


def lines_between(drawing, size):
    """Return whether a line runs within 1/4 pixel of the way between horizontal and vertical neighbours."""
    places = np.round(4 * along(drawing.visible, 0.05)).astype(int)
    fine = np.zeros((4 * size[0] + 1, 4 * size[1] + 1), bool)
    inside = ((places >= 0) & (places < fine.shape)).all(axis=1)
    fine[tuple(places[inside].T)] = True
    near = np.zeros_like(fine)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            near |= np.roll(fine, (down, right), axis=(0, 1))
    across = np.logical_or.reduce([near[:-1:4, k : k - 4 : 4] for k in range(4)])[:, :-1]
    down = np.logical_or.reduce([near[k : k - 4 : 4, :-1:4] for k in range(4)])[:-1]
    return across, down


def check_lines(scene, camera):
    """Check that a line runs between all neighbours of different faces; return the number of such neighbours."""
    lines = lines_between(bob.draw(scene, camera, size=SIZE), SIZE)
    changes = neighbours_differ(scene, camera, SIZE)
    for change, line in zip(changes, lines, strict=True):
        assert (change & ~line).sum() == 0
    return sum(change.sum() for change in changes)


def test_lines_run_where_faces_change():
    """Several parts; one cuts another."""
    parts = bob.Scene([bob.Instance(CUBES["brep"]), bob.Instance(cylinder()).translate((0.4, 0.3, 1.2)), torus()])
    camera = bob.Camera(azimuth=40, elevation=30)
    assert check_lines(parts, camera) > 1000


def step_file(path, shape):
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return bob.load(path)


def test_step_solids_have_lines_at_borders_of_their_faces(tmp_path):
    """A block with a fillet, a hole, a pin and a dent: closed surfaces are cut in pieces, but have no seams."""
    pytest.importorskip("OCP")
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    def pin(x, y, z, radius, height):
        return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1)), radius, height).Shape()

    box = BRepPrimAPI_MakeBox(60.0, 40.0, 15.0).Shape()
    fillet = BRepFilletAPI_MakeFillet(box)
    fillet.Add(5.0, TopoDS.Edge(TopExp_Explorer(box, TopAbs_ShapeEnum.TopAbs_EDGE).Current()))
    block = BRepAlgoAPI_Cut(fillet.Shape(), pin(15, 20, -1, 6, 20)).Shape()
    block = BRepAlgoAPI_Fuse(block, pin(42, 14, 10, 7, 20)).Shape()
    block = BRepAlgoAPI_Cut(block, BRepPrimAPI_MakeSphere(gp_Pnt(42.0, 32.0, 18.0), 8.0).Shape()).Shape()
    scene = step_file(tmp_path / "block.step", block)
    (instance,) = scene.instances
    assert len(instance.shape.faces) > len({*instance.shape.face_numbers.tolist()})
    for azimuth, elevation in ((30, 35), (-70, 50), (200, -30)):
        assert check_lines(scene, bob.Camera(azimuth, elevation)) > 1000


def test_seams_of_a_step_file_are_no_edges(tmp_path):
    pytest.importorskip("OCP")
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeSphere

    camera, edges = bob.Camera(azimuth=0, elevation=90, zoom=0.9), bob.Edges(hidden=True)
    for shape in (BRepPrimAPI_MakeSphere(4.0).Shape(), BRepPrimAPI_MakeCylinder(4.0, 2.0).Shape()):
        (instance,) = step_file(tmp_path / "closed.step", shape).instances
        for angle in (0, 0.7):
            scene = bob.Scene(instance.rotate(angle, (0, 0, 1)))
            (outline,) = bob.draw(scene, camera, size=SIZE, edges=edges).visible
            assert np.ptp(np.linalg.norm(outline - (119.5, 159.5), axis=1)) < 0.2


@pytest.mark.parametrize("zoom", [0.7, 7])
def test_lines_have_one_width_at_any_zoom(zoom):
    camera = bob.Camera(azimuth=-90, elevation=90, zoom=zoom)
    for width in (0.5, 1, 2.25):
        coverage = bob.draw(halves(None), camera, size=SIZE, edges=bob.Edges(width)).coverage()
        across = coverage[110:130, 140:180].sum(axis=1)
        assert across == pytest.approx(np.full(20, width), abs=0.02)


def test_render_draws_lines_over_the_picture():
    plain = bob.render(CUBES["brep"], CAMERA, size=SIZE)
    lined = bob.render(CUBES["brep"], CAMERA, size=SIZE, edges=bob.Edges(2, "#f00"))
    coverage = bob.draw(CUBES["brep"], CAMERA, size=SIZE, edges=bob.Edges(2)).coverage()
    assert (lined.color[coverage == 0] == plain.color[coverage == 0]).all()
    assert (lined.color[coverage == 1] == (1, 0, 0)).all()
    assert (lined.alpha[coverage == 1] == 1).all()
    assert 400 < (coverage == 1).sum() < 4000
    sparse = bob.render(CUBES["brep"], CAMERA, size=SIZE, fraction=0.05, edges=bob.Edges(2, "#f00"))
    assert (sparse.color[coverage == 1] == (1, 0, 0)).all()


def test_parts_that_touch_have_a_line_between_them():
    cube = bob.Instance(CUBES["mesh"])
    drawing = bob.draw([cube, cube.translate((0, 2, 0))], bob.Camera(azimuth=0, elevation=0), size=SIZE)
    middle = [curve for curve in drawing.visible if np.abs(curve[:, 1] - 159.5).max() < 1]
    assert length(middle) > 90


def test_a_drawing_is_written_as_svg_and_pixels(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    CUBES["mesh"].save("cube.stl")
    view = ["render", "cube.stl", "--size", "320x240", "--style", "lines"]
    assert cli.main([*view, "--hidden", "-o", "cube.svg", "--json"]) == 0
    svg = ElementTree.parse("cube.svg").getroot()
    groups = {group.get("id"): group for group in svg.iter() if group.get("id")}
    assert svg.get("viewBox") == "0 0 320 240"
    assert len(groups["hidden"]) >= 1
    assert "stroke-dasharray" in groups["hidden"].attrib
    assert 3 <= len(groups["visible"]) <= 12
    assert cli.main([*view, "-o", "cube.png"]) == 0
    with Image.open("cube.png") as picture:
        gray = np.asarray(picture.convert("L"))
    assert (gray == 255).mean() > 0.9
    assert (gray < 40).sum() > 300
    assert cli.main([*view[:-2], "--edges", "--line-width", "3", "-o", "shaded.png"]) == 0
    assert cli.main([*view[:-2], "-o", "cube.svg"]) == 2
    assert cli.main([*view, "--fraction", "5%"]) == 2
    assert cli.main([*view[:-2], "--edges", "-o", "cube.exr"]) == 2


@pytest.mark.parametrize("edges", ["hidden", 1.5, None, {"width": 2}])
def test_other_edges_are_refused(edges):
    with pytest.raises(bob.InputTypeError, match="edges: expected"):
        bob.render(CUBES["mesh"], size=(8, 8), edges=edges)


@pytest.mark.parametrize(
    "settings", [{"width": 0}, {"width": np.nan}, {"width": 1e9}, {"color": "no"}, {"hidden": "yes"}]
)
def test_edges_out_of_range_are_refused(settings):
    with pytest.raises(bob.InputError, match=next(iter(settings))):
        bob.Edges(**settings)


def test_pictures_of_one_pixel_and_cameras_inside():
    for size in ((1, 1), (1, 50), (50, 1)):
        bob.draw(CUBES["brep"], CAMERA, size=size, edges=bob.Edges(hidden=True)).coverage()
    inside = bob.Camera(position=(0, 0, 0), target=(1, 0.2, 0.1), fov=90)
    drawing = bob.draw(CUBES["mesh"], inside, size=SIZE, edges=bob.Edges(hidden=True))
    assert length(drawing.visible) > 300
    assert drawing.hidden == ()


@pytest.mark.parametrize("kind", ["brep", "mesh", "formula"])
def test_caps_of_sections_have_outlines(kind):
    """Also where a cap meets its part at less than a crease: the plane cuts the top off a ball."""
    ball = sdf.sphere(1)
    shape = {"brep": sphere(), "mesh": ball.mesh(0.1), "formula": ball}[kind]
    scene = bob.Scene(shape, section="z=0.97")
    drawn = bob.draw(scene, bob.Camera(elevation=90), size=(96, 96))
    radii = [np.linalg.norm(curve - 47.5, axis=1).max() / 48 for curve in drawn.visible]
    assert min(radii) == pytest.approx(np.sqrt(1 - 0.97**2), abs=0.06)
