"""Sections: caps of every kind of shape, in every picture."""

import pickle

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line.cli import main
from bobrossnet.sdf import box, sphere

CAMERA = bob.Camera(azimuth=40, elevation=25)
SIZE = (60, 80)


def on_caps(scene, camera=CAMERA, size=(96, 96)):
    """Of all pixels: whether a cap is seen, and where it is, (H, W, 3)."""
    h, w = size
    full = bob.trace(scene, camera, size=size)
    eye = np.array([np.cos(np.radians(camera.azimuth)) * np.cos(np.radians(camera.elevation)),
                    np.sin(np.radians(camera.azimuth)) * np.cos(np.radians(camera.elevation)),
                    np.sin(np.radians(camera.elevation))])  # fmt: skip
    right = np.array([-np.sin(np.radians(camera.azimuth)), np.cos(np.radians(camera.azimuth)), 0])
    up = np.cross(eye, right)
    x = (np.arange(w) + 0.5 - w / 2) / (min(size) / 2)
    y = (h / 2 - np.arange(h) - 0.5) / (min(size) / 2)
    start = scene.center + scene.radius * (2 * eye + x[None, :, None] * right + y[:, None, None] * up)
    hits = scene.closest_hits(start.reshape(-1, 3), np.broadcast_to(-eye, (h * w, 3)))
    points = start.reshape(-1, 3) - np.where(np.isfinite(hits.distance), hits.distance, 0)[:, None] * eye
    assert (np.isfinite(hits.distance) == (full.depth.reshape(-1) > 0)).mean() > 0.999
    return (hits.primitive <= -2).reshape(size), points.reshape(h, w, 3), hits


@pytest.mark.parametrize(
    ("text", "normal", "offset"),
    [
        ("x=0", (1, 0, 0), 0),
        ("x<2", (1, 0, 0), 2),
        (" y <= -1.5 ", (0, 1, 0), -1.5),
        ("z>3", (0, 0, -1), -3),
        ("Z>=1e-3", (0, 0, -1), -1e-3),
    ],
)
def test_sections_as_text(text, normal, offset):
    section = bob.Section(text)
    assert section.normal == pytest.approx(normal)
    assert section.offset == pytest.approx(offset)


def test_a_section_is_scaled_to_a_normal_of_length_one():
    section = bob.Section(normal=(0, 3, 4), offset=10)
    assert section.normal == pytest.approx((0, 0.6, 0.8))
    assert section.offset == 2
    assert section == bob.Section((0, 0.6, 0.8), 2)


@pytest.mark.parametrize("section", ["", "x", "w=3", "x=nan", "x=inf", "x==3", "x=", "x=3mm", "x=0 and y=0"])
def test_texts_that_mean_nothing(section):
    with pytest.raises(bob.InputError, match=r"^section: expected an axis, a relation and a number"):
        bob.render(box(1), section=section)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: bob.Section((0, 0, 0)), "normal: expected a length above 0"),
        (lambda: bob.Section((0, np.nan, 1)), "normal: expected finite numbers"),
        (lambda: bob.Section((0, 0, 1), np.nan), "offset: expected"),
        (lambda: bob.Section("x=0", 3), "offset: expected none with a section as text"),
        (lambda: bob.Scene(box(1), section=["x=0"] * 7), "section: expected at most 6, got 7"),
        (
            lambda: bob.trace(box(1), section=3),
            "section: expected a Section, a text such as 'x=0' or several, got int 3",
        ),
        (lambda: bob.trace(box(1), section=[3]), "section: expected a Section or a text such as 'x=0', got int 3"),
        (lambda: bob.View(tracer=lambda camera, pixels: None, section="x=0"), "section: expected none with a tracer"),
    ],
)
def test_sections_out_of_range(make, message):
    with pytest.raises(bob.InputError) as error:
        make()
    assert str(error.value).startswith(message)


SHAPES = {
    "formula": lambda: sphere(1) - sphere(0.6),
    "mesh": lambda: (sphere(1) - sphere(0.6)).mesh(0.04),
    "two instances": lambda: bob.Scene(
        [sphere(1), bob.Instance(box(0.5), bob.Instance(box(1)).translate((0, 0, 3)).transform)]
    ),
}


@pytest.mark.parametrize("kind", ["formula", "mesh"])
def test_a_hollow_part_has_a_cap_with_its_hole(kind):
    scene = bob.Scene(SHAPES[kind](), section="x=0.2")
    capped, points, _ = on_caps(scene)
    y, z = points[..., 1], points[..., 2]
    assert np.abs(points[capped][:, 0] - 0.2).max() < 1e-5
    r = np.hypot(y[capped], z[capped])
    assert r.max() < np.sqrt(1 - 0.04) + 2e-3
    assert r.min() > np.sqrt(0.36 - 0.04) - 2e-3
    # Of the ring that the camera looks at, nothing is missing.
    expected = np.pi * (1 - 0.36) * np.cos(np.radians(40)) * np.cos(np.radians(25))
    assert capped.sum() * (2 * scene.radius / 96) ** 2 == pytest.approx(expected, rel=0.02)


def test_the_default_camera_looks_at_the_cut():
    for section in ("x=0", "y=0", "z=0"):
        capped, _, _ = on_caps(bob.Scene(sphere(1), section=section), bob.Camera())
        assert capped.sum() > 1000


def test_the_bounding_sphere_and_the_camera_stay():
    whole = bob.Scene(sphere(1).translate((1, 2, 3)))
    cut = whole.sectioned("x=1")
    assert cut.radius == whole.radius
    assert (cut.center == whole.center).all()
    kept = bob.trace(cut, CAMERA, size=SIZE, section="x<9")
    np.testing.assert_allclose(kept.gray, bob.trace(whole, CAMERA, size=SIZE).gray, atol=1e-5)


def test_sections_of_a_call_replace_those_of_the_scene():
    scene = bob.Scene(sphere(1), section="x=0")
    assert scene.section == (bob.Section("x=0"),)
    uncut, cut = bob.trace(sphere(1), size=SIZE), bob.trace(sphere(1), size=SIZE, section="x=0")
    assert (bob.trace(scene, size=SIZE, section=[]).gray == uncut.gray).all()
    assert (bob.trace(scene, size=SIZE).gray == cut.gray).all()
    assert (bob.trace(scene.sectioned(None), size=SIZE).gray == uncut.gray).all()
    assert (bob.trace(scene, size=SIZE, section="x=0.5").depth != cut.depth).any()
    assert pickle.loads(pickle.dumps(scene)).section == scene.section


def test_turned_upright_with_its_section():
    scene = bob.Scene(sphere(1) - sphere(0.5), section=bob.Section((0, 1, 0), 0.25)).turned_upright()
    np.testing.assert_allclose(scene.section[0].normal, (0, 0, 1), atol=1e-12)
    assert scene.section[0].offset == 0.25


def test_nested_parts_hatch_apart_and_keep_their_colors():
    inner = bob.Instance(sphere(0.5), material=bob.Material("#00f"))
    outer = bob.Instance(sphere(1), material=bob.Material("#f00"))
    scene = bob.Scene([outer, inner], section="x=0")
    front = bob.Camera(0, 0)
    capped, points, hits = on_caps(scene, front, (128, 128))
    r = np.hypot(points[..., 1], points[..., 2])
    assert (hits.instance.reshape(128, 128)[capped] == (r[capped] < 0.5)).all()
    full = bob.trace(scene, front, size=(128, 128))
    reverse = bob.trace(bob.Scene([inner, outer], section="x=0"), front, size=(128, 128))
    assert (full.color == reverse.color).all()
    red, blue = full.albedo[..., 0][capped & (r > 0.5)], full.albedo[..., 2][capped & (r < 0.5)]
    for color in (red, blue):
        assert 0.65 < color.min() < 0.9
        assert color.max() > 0.99

    def slope(part):
        """How much the hatching changes along one diagonal, compared with the other."""
        shade = np.where(part, full.albedo.sum(-1), np.nan)
        return np.nanmean(np.abs(shade[1:, 1:] - shade[:-1, :-1])) - np.nanmean(np.abs(shade[1:, :-1] - shade[:-1, 1:]))

    assert slope(r > 0.5) * slope(r < 0.5) < 0
    # Hatching is colour alone.
    assert np.ptp(full.depth[capped]) < 1e-6
    assert np.abs(full.normal[capped]).max() < 1e-6


def test_an_open_shape_shows_its_inside_and_says_so():
    mesh = sphere(1).mesh(0.05)
    kept = (mesh.vertices[mesh.triangles][..., 2] < 0.5).all(axis=1)
    part = bob.Instance(bob.Mesh(mesh.vertices, mesh.triangles[kept]), name="bowl")
    with pytest.warns(bob.InputWarning, match=r"^section: expected closed shapes.*bowl.*inside instead of a cap$"):
        full = bob.trace(part, bob.Camera(0, 0), size=SIZE, section="x=0")
    assert full.depth[30, 40] < 0.1  # the far wall
    assert full.gray[30, 40] > 0.5


@pytest.mark.filterwarnings("error")
def test_an_open_shape_that_no_plane_cuts_is_no_matter():
    flat = bob.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    bob.trace([flat, bob.Instance(sphere(1)).translate((5, 0, 0))], size=SIZE, section="x=5")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("section", "seen"), [("x=-9", False), ("x>9", False), ("x=9", True)])
def test_a_plane_that_misses_everything(section, seen):
    full = bob.trace(sphere(1), CAMERA, size=SIZE, section=section)
    assert full.depth.any() == seen


@pytest.mark.parametrize(
    ("sections", "text"),
    [
        (["x=0"], "got nothing by x=0; it reaches from (0, 0, 0) to (1, 1, 1)"),
        ([bob.Section((1, 1, 0), 0)], "got nothing by (0.707, 0.707, 0) 0; it reaches from (0, 0, 0) to (1, 1, 1)"),
        (["x>0.6", "x=0.4"], "got nothing by x>0.6, x=0.4; it reaches from (0, 0, 0) to (1, 1, 1)"),
        (["x=0.01"], None),
        (["x>0"], None),
    ],
)
@pytest.mark.parametrize("draw", [bob.render, bob.sheet])
def test_sections_that_leave_nothing_are_told(draw, sections, text, recwarn):
    *own, last = sections
    scene = bob.Scene(box(1).translate((0.5, 0.5, 0.5)).mesh(0.25), section=own)
    draw(scene, size=(300, 400), section=last if draw is bob.sheet else sections)  # a sheet adds to the scene's
    told = [str(warning.message) for warning in recwarn]
    assert told == ([] if text is None else [f"section: expected some of the scene in the picture, {text}"])


@pytest.mark.parametrize("make", [lambda: box(1), lambda: bob.Mesh(*cube())])
def test_a_plane_in_a_face(make):
    camera = bob.Camera(azimuth=30, elevation=50)
    # The kept part ends at its own face: a cap. A part that only touches the kept side is gone.
    below = bob.trace(make(), camera, size=(64, 64), section="z=0.5")
    capped, points, _ = on_caps(bob.Scene(make(), section="z=0.5"), camera, (64, 64))
    top = (np.abs(points[..., 2] - 0.5) < 1e-5) & (below.depth > 0)
    assert (capped == top).mean() > 0.995
    assert capped.sum() > 500
    assert not bob.trace(make(), camera, size=(64, 64), section="z>0.5").depth.any()


def cube():
    vertices = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def test_rays_of_every_kind_of_picture():
    scene = bob.Scene(sphere(1) - sphere(0.6), section="x=0")
    full = bob.trace(scene, CAMERA, size=SIZE)
    sparse = bob.trace(scene, CAMERA, size=SIZE, fraction=0.3)
    kept = sparse.mask > 0
    assert (sparse.depth[kept] == full.depth[kept]).all()
    assert np.abs(bob.complete(sparse) - full.gray).mean() < 0.05
    assert bob.render(scene, CAMERA, size=SIZE).rgba[..., 3].any()
    *_, last = bob.progressive(scene.sectioned(None), CAMERA, size=SIZE, section="x=0", fraction=0.5)
    assert (last.image == full.gray).all()
    view = bob.View(scene.sectioned(None), size=SIZE, section="x=0")
    for azimuth in (34, 37, 40):
        frame = view.frame(bob.Camera(azimuth, 25), fraction=0.4)
    assert np.abs(frame.image - full.gray).mean() < 0.02
    frame = view.frame(fraction=1)
    assert (frame.image == full.gray).all()
    film = bob.orbit(scene.sectioned(None), frames=1, size=SIZE, samples=1, section="x=0")
    assert (next(iter(film)).rgba == bob.render(scene, bob.Camera(), size=SIZE, samples=1).rgba).all()
    assert (bob.sheet(scene, size="240x240").rgba != bob.sheet(scene.sectioned(None), size="240x240").rgba).any()


def test_light_enters_through_the_cut():
    hollow = sphere(1) - sphere(0.9)
    sun = bob.Light(direction=(1, 0, 0.2), angle=1)
    cut = bob.trace(hollow, bob.Camera(0, 0), size=(24, 24), section="x=0", light=sun)
    assert cut.color[12, 12].min() > 0.5  # of the far wall
    assert cut.depth[12, 12] < 0.1


def test_a_cut_ball_of_glass_is_closed():
    # Where a ball is all there is, light of one colour from everywhere is all that one sees, whatever the cut.
    glass = bob.Instance(sphere(1), material=bob.Glass())
    cut = bob.trace(glass, bob.Camera(20, 0), size=(16, 16), section="x=0.2", light=bob.Sky((0.5, 0.5, 0.5)))
    inside = cut.depth > 0
    np.testing.assert_allclose(cut.color[inside].mean(), 0.5, atol=0.05)


def test_the_command_line(tmp_path, capsys):
    out = tmp_path / "cut.png"
    assert main(
        ["render", "--size", "64x48", "--section", "x=0", "--section", "z<9", "--fraction", "100%", "-o", str(out)]
    ) in (0, None)
    cut = np.asarray(Image.open(out))
    main(["render", "--size", "64x48", "--fraction", "100%", "-o", str(out)])
    assert (cut != np.asarray(Image.open(out))).any()
    assert main(["render", "--section", "w=0"]) == 2
    assert "--section: expected an axis, a relation and a number" in capsys.readouterr().err
