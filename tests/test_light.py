"""Light: worked values, shadows, skies, and a scene's own light."""

import math

import numpy as np
import nurbs_shapes as nurbs
import pytest
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.color import to_srgb
from bobrossnet.completion.complete import complete
from bobrossnet.completion.guided import noise_shown
from bobrossnet.picture.environment import read_hdr
from bobrossnet.pictures.rendering import finished, light_to_be_seen
from bobrossnet.tracing.light import studio
from bobrossnet.tracing.lit import LitTracer, lit_tracer
from bobrossnet.tracing.pixels import tiled_pixels
from bobrossnet.tracing.trace import traced_light

SIZE = (48, 64)
WHITE = bob.Material("#fff", ambient=0, diffuse=1, specular=0)  # diffuse, and reflects all light
ABOVE = bob.Camera(elevation=90, azimuth=0)


def square(side=2.0, z=0.0):
    h = side / 2
    return bob.Mesh([(-h, -h, z), (h, -h, z), (h, h, z), (-h, h, z)], [(0, 1, 2), (0, 2, 3)])


def white(shape):
    return bob.Instance(shape, material=WHITE)


def sphere_mesh(subdivisions=3):
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions)
    return bob.Mesh(ball.vertices, ball.faces)


def lit(scene, light, camera=ABOVE, size=SIZE, paths=64, **options):
    """Return samples of all pixels of a scene, (H, W, C), by name."""
    tracer = LitTracer(scene, camera, size, light, paths=paths, **options)
    pixels = tiled_pixels(size)
    samples = tracer(pixels)
    found = {}
    for name in ("gray", "color", "shadow", "variance"):
        values = samples.channel(name)
        planes = np.empty((*size, *values.shape[1:]), np.float32)
        planes[pixels[:, 0], pixels[:, 1]] = values
        found[name] = planes
    found["hit"] = complete(bob.trace(scene, camera, size=size), channel="alpha") > 0
    return found


def inner(mask, margin=2):
    """Return pixels of the mask with neighbours of the mask."""
    kept = mask.copy()
    for _ in range(margin):
        padded = np.pad(kept, 1)
        kept = kept & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return kept


# ---- Worked values ---------------------------------------------------------------------------------------


def test_a_plane_is_not_occluded_at_all():
    """Under a white sky a white diffuse plane is exactly as bright: no ray hits its own origin."""
    seen = lit(white(square()), bob.Sky())
    assert inner(seen["hit"]).sum() > 100
    np.testing.assert_allclose(seen["gray"][inner(seen["hit"])], 1, rtol=1e-5)


def test_a_plane_is_as_bright_as_its_light_says():
    """A light's colour is the radiance of a white surface facing it; other surfaces have a cosine factor."""
    for angle, tolerance in ((0, 1e-5), (30, 2e-3), (90, 6e-3)):
        for elevation in (90, 60, 46):
            e = math.radians(elevation)
            sun = bob.Light((math.cos(e), 0, math.sin(e)), angle=angle, color=(0.5, 0.25, 1.0), intensity=0.8)
            seen = lit(white(square()), sun, paths=64)
            color = seen["color"][inner(seen["hit"])].mean(0)
            np.testing.assert_allclose(color, 0.8 * math.sin(e) * np.array([0.5, 0.25, 1.0]), rtol=tolerance)


def test_a_sky_of_two_colours_is_what_its_integral_says():
    """For L = b + (t - b) (1 + z) / 2 the irradiance at a normal n is pi ((t + b) / 2 + (t - b) n_z / 3)."""
    seen = lit(white(square()), bob.Sky((0.9, 0.9, 0.9), (0.3, 0.3, 0.3)), paths=256)
    assert seen["gray"][inner(seen["hit"])].mean() == pytest.approx(0.6 + 0.2, abs=1e-3)


def test_a_sphere_shades_the_plane_below_it_as_its_solid_angle_says():
    """A sphere of radius 1 on a plane occludes 1 / d^3 of the sky's light, at a distance d of its centre."""
    ball = bob.implicit(lambda x, y, z: x**2 + y**2 + (z - 1) ** 2 - 1, bounds=((-1, -1, 0), (1, 1, 2)))
    black = bob.Material("#000", ambient=0, diffuse=0, specular=0)
    scene = bob.Scene([white(square(16)), bob.Instance(ball, material=black)])
    camera = bob.Camera(elevation=90, azimuth=0, zoom=2.2)
    seen = lit(scene, bob.Sky(), camera, (64, 64), paths=256, bounces=1)
    full = bob.trace(scene, camera, size=(64, 64))
    x, y, z = np.moveaxis(world_points(scene, camera, full), -1, 0)
    on_plane = inner(np.abs(z) < 1e-3) & (x**2 + y**2 < 9)
    expected = (1 - (x**2 + y**2 + 1) ** -1.5)[on_plane]
    assert on_plane.sum() > 300
    error = seen["gray"][on_plane] - expected
    assert np.abs(error).mean() < 0.008
    assert abs(error.mean()) < 0.002


def test_an_edge_of_90_degrees_hides_what_its_integral_says():
    """An infinite wall of height H occludes (1 - x / sqrt(x^2 + H^2)) / 2 of the sky's light, at a distance x."""
    wall = bob.Mesh([(0, -200, 0), (0, 200, 0), (0, 200, 2), (0, -200, 2)], [(0, 1, 2), (0, 2, 3)])
    floor = bob.Mesh([(-20, -200, 0), (20, -200, 0), (20, 200, 0), (-20, 200, 0)], [(0, 1, 2), (0, 2, 3)])
    black = bob.Material("#000", ambient=0, diffuse=0, specular=0)
    scene = bob.Scene([white(floor), bob.Instance(wall, material=black)])
    camera = bob.Camera(elevation=90, azimuth=0, zoom=scene.radius / 6)
    seen = lit(scene, bob.Sky(), camera, (48, 48), paths=256, bounces=1)
    rows = np.arange(48)
    x = np.abs((rows - 23.5) * 12 / 48)  # at azimuth 0, +x points down
    expected = 1 - 0.5 * (1 - x / np.sqrt(x**2 + 4))
    np.testing.assert_allclose(seen["gray"].mean(1), expected, atol=0.006)


def test_a_penumbra_is_as_wide_as_the_light_says():
    """Under a half plane at height h and a disc of angular diameter a, it is 2 h tan(a / 2) wide."""
    shade = bob.Mesh([(0, -9, 1), (9, -9, 1), (9, 9, 1), (0, 9, 1)], [(0, 1, 2), (0, 2, 3)])
    scene = bob.Scene([white(square(18)), white(shade)])
    # From the edge's open side: a slanted view under the half plane.
    look = bob.Camera(azimuth=180, elevation=45, zoom=scene.radius / 1.5)
    angle = 20
    seen = lit(scene, bob.Light((0, 0, 1), angle=angle), look, (96, 96), paths=256, bounces=1)
    full = bob.trace(scene, look, size=(96, 96))
    origins = world_points(scene, look, full)
    on_floor = np.isclose(origins[..., 2], 0, atol=1e-3)
    x, gray = origins[..., 0][on_floor], seen["gray"][on_floor]
    half = math.tan(math.radians(angle / 2))
    assert gray[x < -half - 0.05] == pytest.approx(1, abs=0.01)
    assert gray[x > half + 0.05].max() < 0.01
    # The share of a disc beyond a chord, almost unchanged by projection.
    s = np.clip(x / half, -1, 1)
    expected = (np.arccos(s) - s * np.sqrt(1 - s**2)) / math.pi
    assert np.abs(gray - expected).mean() < 0.012


def world_points(scene, camera, full):
    """Return the visible point of each pixel, (H, W, 3), for an orthographic camera."""
    height, width = full.size
    a, e = math.radians(camera.azimuth), math.radians(camera.elevation)
    right = np.array([-math.sin(a), math.cos(a), 0])
    up = np.array([-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e)])
    toward = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
    pixel = 2 / (camera.zoom * min(height, width))
    across = (np.arange(width) + 0.5 - width / 2) * pixel
    above = (height / 2 - 0.5 - np.arange(height)) * pixel
    z = 2 * full.depth - 1
    local = across[None, :, None] * right + above[:, None, None] * up + z[..., None] * toward
    return scene.center + scene.radius * local


# ---- Self-intersection -----------------------------------------------------------------------------------


ROUND = {
    "mesh": lambda: sphere_mesh(3),
    "implicit": lambda: bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1, bounds=((-1, -1, -1), (1, 1, 1))),
    "nurbs": nurbs.sphere,
    "tube": lambda: bob.polyline([(-1, 0, 0), (1, 0, 0)], radius=0.5),
}


@pytest.mark.parametrize("kind", ROUND)
@pytest.mark.parametrize("scale", [1, 1e-3, 1e4])
def test_convex_shapes_do_not_shade_themselves(kind, scale):
    """Rays start just above the surface, for every kind and size of shape: nothing is occluded."""
    placed = white(ROUND[kind]()).scale(scale)
    seen = lit(placed, bob.Sky(), bob.Camera(), (24, 32), paths=32)
    gray = seen["gray"][inner(seen["hit"])]
    assert len(gray) > 40
    assert gray == pytest.approx(1, abs=1e-5)


def test_small_and_flattened_instances_do_not_shade_themselves():
    big = bob.Mesh([(-50, 0, -60), (50, 0, -60), (0, 0, -61)], [(0, 1, 2)])
    for ball in (sphere_mesh(2), nurbs.sphere()):
        thing = white(ball).scale((1, 1, 0.02)).rotate(0.3, (1, 2, 3))
        scene = bob.Scene([thing, big])
        camera = bob.Camera(position=(30, 0, 0), target=(0, 0, 0), fov=5)
        seen = lit(scene, bob.Sky(), camera, (24, 24), paths=16)
        gray = seen["gray"][inner(seen["hit"], 1)]
        assert len(gray) > 10
        assert np.abs(gray - 1).max() < 1e-3


# ---- Materials -------------------------------------------------------------------------------------------


COATS = [{}, {"clearcoat": 1}, {"clearcoat": 0.5, "clearcoat_roughness": 0.3}]


@pytest.mark.parametrize("metallic", [0, 1])
@pytest.mark.parametrize("roughness", [0, 0.2, 0.5, 1])
@pytest.mark.parametrize("coat", COATS)
def test_white_surfaces_in_a_white_world_are_white(metallic, roughness, coat):
    """The furnace test: under uniform light, all light is reflected."""
    material = bob.Material("#fff", metallic=metallic, roughness=roughness, **coat)
    ball = bob.Instance(nurbs.sphere(), material=material)
    seen = lit(ball, bob.Sky(), bob.Camera(), (24, 32), paths=128)
    gray = seen["gray"][inner(seen["hit"])]
    assert gray.mean() == pytest.approx(1, abs=0.02)
    assert gray.max() < 1.1
    assert gray.min() > 0.9


@pytest.mark.parametrize("roughness", [0, 0.3])
def test_a_clear_coat_reflects_as_glass_does(roughness):
    """A black surface under it reflects 4 % of the light from above, and Schlick's share at 60 degrees."""
    coated = bob.Material("#000", ambient=0, diffuse=0, specular=0, clearcoat=0.5, clearcoat_roughness=roughness)
    for elevation, reflectance in ((90, 0.04), (30, 0.04 + 0.96 * 0.5**5)):
        camera = bob.Camera(elevation=elevation, zoom=8)
        seen = lit(bob.Instance(square(4), material=coated), bob.Sky(), camera, paths=256)
        assert seen["gray"][inner(seen["hit"])].mean() == pytest.approx(0.5 * reflectance, rel=0.02 + roughness / 3)


def test_a_mirror_shows_what_is_around():
    """A smooth metal ball reflects the sky's top at its top, and a coloured wall in the wall's direction."""
    chrome = bob.Instance(nurbs.sphere(), material=bob.Material("#fff", metallic=1, roughness=0))
    seen = lit(chrome, bob.Sky("#fff", "#000"), bob.Camera(elevation=0), (33, 33), paths=64)
    middle = seen["gray"][:, 16]
    heights = (16 - np.arange(33)) * 2 / 33
    at = np.abs(heights) < 0.9
    # The reflection of the view at a normal of height h rises by 2 h sqrt(1 - h^2).
    expected = 0.5 + heights[at] * np.sqrt(1 - heights[at] ** 2)
    np.testing.assert_allclose(middle[at], expected, atol=0.04)


def test_light_comes_back_from_other_surfaces_only_if_it_may():
    red = bob.Instance(bob.Mesh([(0, -5, 0), (0, 5, 0), (0, 5, 5), (0, -5, 5)], [(0, 1, 2), (0, 2, 3)]),
                       material=bob.Material("#f00", ambient=0, diffuse=1, specular=0))  # fmt: skip
    scene = bob.Scene([white(square(10)), red])
    shades = []
    for bounces in (1, 2):
        seen = lit(scene, bob.Light((1, 0, 0.2), angle=1), bob.Camera(elevation=90), bounces=bounces)
        color = seen["color"][seen["color"][..., 0] > 0].reshape(-1, 3).mean(0)
        shades.append(color[0] / color[1])
    assert shades[0] == pytest.approx(1, abs=0.05)
    assert shades[1] > 1.05


def test_lamps_light_other_surfaces():
    lamp = bob.Instance(square(4, 3), material=bob.Material("#000", emissive="#fff"))
    seen = lit([white(square(4)), lamp], [], bob.Camera(elevation=20), bounces=1)
    assert 0.1 < np.median(seen["gray"][(seen["gray"] > 0) & (seen["gray"] < 1)]) < 0.9


# ---- Glass -----------------------------------------------------------------------------------------------


def glass(shape, **options):
    return bob.Instance(shape, material=bob.Glass(**options))


def box(low, high):
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)], float)
    faces = [
        (0, 2, 3),
        (0, 3, 1),
        (4, 5, 7),
        (4, 7, 6),
        (0, 1, 5),
        (0, 5, 4),
        (2, 6, 7),
        (2, 7, 3),
        (0, 4, 6),
        (0, 6, 2),
    ]
    return bob.Mesh(corners, [*faces, (1, 3, 7), (1, 7, 5)])


@pytest.mark.parametrize("kind", ROUND)
@pytest.mark.parametrize("options", [{}, {"ior": 2.42}, {"roughness": 0.1}, {"transmission": 0.5}])
def test_glass_in_a_white_world_is_white(kind, options):
    """The furnace: both branches of Fresnel together reflect and transmit all light, up to the stated depth."""
    seen = lit(glass(ROUND[kind](), **options), bob.Sky(), bob.Camera(), (24, 32), paths=64)
    gray = seen["gray"][inner(seen["hit"])]
    assert gray.mean() == pytest.approx(1, abs=0.01)
    assert gray.max() < 1.05


def test_rough_glass_is_nearly_white_in_a_white_world():
    """What two of its facets would reflect or refract is lost."""
    seen = lit(glass(nurbs.sphere(), roughness=0.5), bob.Sky(), bob.Camera(), (24, 32), paths=64)
    assert 0.8 < seen["gray"][inner(seen["hit"])].mean() <= 1.01


def test_a_slab_of_glass_offsets_what_is_behind_it():
    """By t sin(a) (1 - cos(a) / sqrt(n^2 - sin(a)^2)): Snell."""
    n, thick = 1.5, 0.6
    slab = box((-4, -4, 1), (4, 4, 1 + thick))
    half = bob.Mesh([(0, -4, 0.01), (4, -4, 0.01), (4, 4, 0.01), (0, 4, 0.01)], [(0, 1, 2), (0, 2, 3)])
    lamp = bob.Instance(square(8), material=bob.Material("#000", emissive="#fff"))
    dark = bob.Instance(half, material=bob.Material("#000", ambient=0, diffuse=0, specular=0))
    look, size = bob.Camera(azimuth=0, elevation=45, zoom=3), (96, 96)
    edges = []
    for index in (1, n):
        scene = bob.Scene([lamp, dark, glass(slab, ior=index)])
        gray = lit(scene, bob.Sky("#000"), look, size, paths=64)["gray"][:, 30:60].mean(1)
        edges.append((np.flatnonzero(gray > 0.5 * gray.max())[-1], scene.radius))
    (plain, radius), (offset, _) = edges
    pixels = (offset - plain) * 2 / (3 * 96) * radius
    a = math.radians(45)
    expected = thick * math.sin(a) * (1 - math.cos(a) / math.sqrt(n**2 - math.sin(a) ** 2))
    assert abs(pixels) == pytest.approx(expected, abs=1.1 * 2 / (3 * 96) * radius)


def test_glass_takes_light_away_by_beer():
    slab = box((-2, -2, 0), (2, 2, 0.5))
    tinted = glass(slab, ior=1, attenuation=(0.5, 0.25, 1.0), distance=0.5)
    seen = lit(tinted, bob.Sky(), ABOVE)
    np.testing.assert_allclose(seen["color"][inner(seen["hit"])].mean(0), (0.5, 0.25, 1), atol=1e-3)


@pytest.mark.parametrize("roughness", [0, 0.3])
def test_light_goes_straight_through_a_sheet_of_glass(roughness):
    """It loses (1 - R) / (1 + R) by both of its sides, is tinted once, and is not bent."""
    pane = glass(square(3), ior=2, thin=True, color=(0.5, 1, 1), roughness=roughness, attenuation="#000", distance=0.01)
    seen = lit(pane, bob.Sky("#000", "#fff"), ABOVE, paths=256)  # seen from above, white below alone
    reflected = (1 / 3) ** 2
    through = (1 - reflected) / (1 + reflected)
    expected = np.array([0.5, 1, 1]) * through
    np.testing.assert_allclose(seen["color"][inner(seen["hit"])].mean(0), expected, atol=0.02 + 0.1 * roughness)


# ---- Lights behind panes ---------------------------------------------------------------------------------


UNDER = bob.Camera(position=(0, 0, 0.9), target=(0, 0, 0), up=(1, 0, 0), fov=20)
"""Below panes at a height of 1, of what is on the ground."""

SUN_HEIGHT = math.sin(math.radians(60))
SUN_DIRECTION = (math.cos(math.radians(60)), 0, SUN_HEIGHT)

WHITE_WORLDS = {
    "sky": bob.Sky(),
    "environment": bob.Sky(image=np.ones((8, 16, 3), np.float32)),
    "discs": [bob.Light((0, 0, 1), angle=180), bob.Light((0, 0, -1), angle=180)],
}


def pane(z=1.0, **options):
    return glass(square(400, z), thin=True, **options)


def through_a_pane(cosine, ior=1.5):
    """Fresnel's transmittance of two parallel sides, after any number of reflections between them."""
    beyond = np.sqrt(1 - (1 - cosine**2) / ior**2)
    across = (cosine - ior * beyond) / (cosine + ior * beyond)
    within = (ior * cosine - beyond) / (ior * cosine + beyond)
    reflected = (across**2 + within**2) / 2
    return (1 - reflected) / (1 + reflected)


def mean_through_a_pane():
    """Of light from a white sky, by the cosine of its angle to the plane behind the pane."""
    squares = (np.arange(10_000) + 0.5) / 10_000
    return through_a_pane(np.sqrt(squares)).mean()


@pytest.mark.parametrize("angle", [0, 0.5])
@pytest.mark.parametrize(
    ("panes", "share"),
    [
        ([pane()], through_a_pane(SUN_HEIGHT)),
        ([pane(), pane(2)], through_a_pane(SUN_HEIGHT) ** 2),
        ([pane(z) for z in range(1, 32)], through_a_pane(SUN_HEIGHT) ** 31),
        ([pane(color=(0.5, 0.25, 1), ior=2)], through_a_pane(SUN_HEIGHT, 2) * np.array([0.5, 0.25, 1])),
        ([pane(transmission=0.5)], through_a_pane(SUN_HEIGHT) / 2),
    ],
    ids=["one", "two", "as many as on a path", "tinted", "half"],
)
def test_the_sun_shines_through_panes(panes, share, angle):
    """A plane is lit by Fresnel's share of the sun, and four paths are enough."""
    seen = lit([white(square()), *panes], bob.Light(SUN_DIRECTION, angle=angle), UNDER, paths=4, bounces=1)
    expected = np.broadcast_to(SUN_HEIGHT * share, 3)
    np.testing.assert_allclose(seen["color"].mean((0, 1)), expected, rtol=1e-4)
    np.testing.assert_allclose(seen["color"], np.broadcast_to(expected, (*SIZE, 3)), rtol=3e-3)


@pytest.mark.parametrize(
    "shade",
    [[pane(roughness=0.4)], [glass(box((-9, -9, 1), (9, 9, 1.1)))], [pane(z) for z in range(1, 33)]],
    ids=["rough", "solid", "more than on a path"],
)
def test_the_sun_does_not_shine_straight_through_rough_and_solid_glass(shade):
    seen = lit([white(square()), *shade], bob.Light(SUN_DIRECTION, angle=0), UNDER, paths=4, bounces=1)
    assert not seen["gray"].any()


@pytest.mark.parametrize("world", WHITE_WORLDS)
def test_light_through_panes_counts_once(world):
    """Lights that are both drawn and found: the balance heuristic gives a plane the pane's share of a white world."""
    seen = lit([white(square()), pane()], WHITE_WORLDS[world], UNDER, paths=64, bounces=1)
    assert seen["gray"].mean() == pytest.approx(mean_through_a_pane(), rel=1e-3)
    assert seen["gray"].std() < 0.006


@pytest.mark.parametrize("world", WHITE_WORLDS)
@pytest.mark.parametrize("options", [{}, {"ior": 2}])
def test_a_white_ball_behind_panes_in_a_white_world_is_white(world, options):
    """The furnace, from inside of a box of panes."""
    ball = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1, bounds=((-1, -1, -1), (1, 1, 1)))
    panes = glass(box(3 * (-1.6,), 3 * (1.6,)), thin=True, **options)
    inside = bob.Camera(position=(1.5, 0, 0.2), target=(0, 0, 0), fov=40)
    seen = lit([white(ball), panes], WHITE_WORLDS[world], inside, (24, 32), paths=256, bounces=8)
    assert seen["gray"].mean() == pytest.approx(1, abs=2e-3)
    assert np.abs(seen["gray"] - 1).max() < 0.05


@pytest.mark.parametrize(
    ("light", "lost"),
    [
        (bob.Light(SUN_DIRECTION, angle=0), 1 - through_a_pane(SUN_HEIGHT)),
        (bob.Light(SUN_DIRECTION, angle=0.5), 1 - through_a_pane(SUN_HEIGHT)),
        (bob.Sky(), 1 - mean_through_a_pane()),
        (WHITE_WORLDS["environment"], 1 - mean_through_a_pane()),
        (
            [bob.Sky(), bob.Light(SUN_DIRECTION, angle=0.5)],
            1 - (mean_through_a_pane() + SUN_HEIGHT * through_a_pane(SUN_HEIGHT)) / (1 + SUN_HEIGHT),
        ),
    ],
    ids=["point", "sun", "sky", "environment", "sun and sky"],
)
def test_panes_cast_light_shadows_on_the_ground(light, lost):
    stone = white(box((9, 9, 0), (9.1, 9.1, 0.1)))
    shadow = lit([pane(), stone], light, UNDER, paths=64, bounces=1, ground=True)["shadow"]
    assert shadow.mean() == pytest.approx(lost, abs=3e-4)
    assert shadow.std() < 0.003


def test_tinted_panes_cast_shadows_of_what_they_hold_back():
    """Nothing of red light passes a cyan pane; the luminance of white light lacks its red."""
    stone = white(box((9, 9, 0), (9.1, 9.1, 0.1)))
    for color, kept in (("#f00", 0), ("#fff", 1 - 0.2126), ("#0f0", 1)):
        sun = bob.Light(SUN_DIRECTION, angle=0.5, color=color)
        seen = lit([pane(color=(0, 1, 1)), stone], sun, UNDER, paths=16, bounces=1, ground=True)
        assert seen["shadow"].mean() == pytest.approx(1 - kept * through_a_pane(SUN_HEIGHT), abs=1e-3)


def test_light_behind_panes_is_reprojected():
    """A moving camera keeps samples of a ball that the sun lights through a pane, with Fresnel's share of its light."""
    upright = bob.Mesh([(2, -3, -3), (2, 3, -3), (2, 3, 3), (2, -3, 3)], [(0, 1, 2), (0, 2, 3)])
    kept, light = [], []
    for index in (1, 1.5):
        scene = bob.Scene([white(sphere_mesh()), glass(upright, thin=True, ior=index)])
        view = bob.View(scene, size=(96, 128), light=bob.Light((1, 0, 0), angle=0.5), ground=False)
        view.frame(bob.Camera(azimuth=88, elevation=0, zoom=3), fraction=0.3)
        frame = view.frame(bob.Camera(azimuth=90, elevation=0, zoom=3), fraction=1e-4)
        old = (frame.shown.mask > 0) & (frame.gbuffer.mask == 0) & (frame.shown.guides.hit > 0)
        kept.append(old.sum())
        light.append(frame.shown.gray[old].mean())
    assert kept[1] > max(100, 0.95 * kept[0])
    assert light[1] / light[0] == pytest.approx(through_a_pane(1), abs=0.02)


def test_a_camera_may_be_inside_of_sheets():
    ball = glass(sphere_mesh(), thin=True, ior=1.0)
    camera = bob.Camera(position=(0, 0, 0), target=(0, 0, 1), up=(1, 0, 0), fov=20)
    assert lit(ball, bob.Sky(), camera, (8, 8), paths=16)["gray"] == pytest.approx(1, abs=1e-3)


def test_a_camera_may_be_inside_of_glass():
    """Its rays are refracted only on the way out: beyond the critical angle they are reflected."""
    pool = glass(box((-2, -2, -2), (2, 2, 2)), ior=1.5, attenuation=(0.5, 0.5, 0.5), distance=1.0)
    camera = bob.Camera(position=(0, 0, 0), target=(0, 0, 1), up=(1, 0, 0), fov=20)
    seen = lit(pool, bob.Sky(), camera, (16, 16), paths=256)
    middle = seen["gray"][7:9, 7:9].mean()
    # 96 % leave at once after two units; some light comes back from the floor, dimmed by six units more.
    assert middle == pytest.approx(0.96 * 0.25, abs=0.01)


def test_water_may_reach_into_its_glass():
    """The last solid that was entered decides: overlapping solids of equal index look like one."""
    both = [glass(sphere_mesh()), glass(sphere_mesh()).scale(0.8)]
    sky = bob.Sky("#fff", "#000")
    one = lit(both[0], sky, bob.Camera(elevation=0), (33, 33), paths=64)["gray"]
    two = lit(both, sky, bob.Camera(elevation=0), (33, 33), paths=64)["gray"]
    assert np.abs(one - two).mean() < 0.01


def test_guides_behind_mirrors_and_glass_are_of_what_they_show():
    red = bob.Instance(square(6, -1), material=bob.Material("#f00", ambient=0, diffuse=1, specular=0))
    camera = bob.Camera(elevation=60, zoom=2)
    chrome = bob.Instance(square(6, 2), material=bob.Material("#fff", metallic=1, roughness=0))
    cases = {
        "glass": ([red, glass(box((-3, -3, 0), (3, 3, 0.5)))], (1, 0, 0)),
        "mirror": ([red, chrome], (1, 1, 1)),
        "sheet": ([red, glass(square(6, 2), thin=True)], (1, 0, 0)),
        "rough": ([red, glass(box((-3, -3, 0), (3, 3, 0.5)), roughness=0.5)], None),
    }
    for name, (scene, albedo) in cases.items():
        guides = LitTracer(scene, camera, SIZE, [bob.Sky()]).guides()
        middle = np.s_[20:28, 28:36]
        assert (guides.behind[middle] == (albedo is not None)).all(), name
        if albedo is not None:
            np.testing.assert_allclose(guides.channel("albedo")[middle], np.broadcast_to(albedo, (8, 8, 3)), atol=1e-6)
    plain = LitTracer([red], camera, SIZE, [bob.Sky()]).guides()
    assert not plain.behind.any()


def test_bad_glass_is_named():
    for options, name in (
        ({"ior": 0.9}, "ior"),
        ({"ior": 101}, "ior"),
        ({"distance": 0}, "distance"),
        ({"transmission": 2}, "transmission"),
    ):
        with pytest.raises(bob.InputError, match=f"{name}: expected"):
            bob.Glass(**options)
    assert bob.Glass() == bob.Glass()
    assert bob.Glass() != bob.Glass(ior=1.4)


# ---- Environments ----------------------------------------------------------------------------------------


def sun_map():
    texels = np.full((32, 64, 3), 0.1, np.float32)
    texels[6, 40] = (900, 800, 700)
    return texels


def test_an_environment_is_what_its_sum_says():
    """A plane's irradiance from a bright texel is radiance times solid angle times cosine, with little noise."""
    texels = sun_map()
    polar = (6.5) * math.pi / 32
    solid = (math.pi / 32) * (2 * math.pi / 64) * math.sin(polar)
    expected = 0.1 + (800 - 0.1) * solid * math.cos(polar) / math.pi
    seen = lit(white(square()), bob.Sky(image=texels), paths=64)
    green = seen["color"][..., 1][inner(seen["hit"])]
    assert green.mean() == pytest.approx(expected, rel=0.03)
    assert green.std() < 0.1 * expected


def test_an_environment_is_seen_where_it_is():
    """The picture's centre is the direction -x; columns go clockwise from there, towards +y."""
    texels = np.zeros((16, 32, 3), np.float32)
    texels[:, 12:20, 0] = 1  # -x
    texels[:, 20:28, 1] = 1  # a quarter clockwise from above: +y
    texels[:3] = (0, 0, 1)
    for turn, red, green in ((0, (-1, 0, 0), (0, 1, 0)), (90, (0, -1, 0), (-1, 0, 0))):
        colors = {}
        for toward in (red, green, (0, 0, 1)):
            normal = np.array(toward, float)
            across = np.array([0, 0, 1.0]) if abs(normal[2]) < 0.5 else np.array([1.0, 0, 0])
            u = np.cross(across, normal)
            v = np.cross(normal, u)
            sheet = bob.Mesh([-u - v, u - v, u + v, -u + v], [(0, 1, 2), (0, 2, 3)])
            camera = bob.Camera(position=tuple(5 * normal), target=(0, 0, 0), fov=20, up=tuple(across))
            seen = lit(white(sheet), bob.Sky(image=texels, turn=turn), camera, (16, 16), paths=64)
            colors[toward] = seen["color"][8, 8].argmax()
        assert colors == {red: 0, green: 1, (0, 0, 1): 2}


@pytest.mark.parametrize("runs", [True, False])
def test_radiance_files_are_read(runs):
    rng = np.random.default_rng(0)
    width = 12 if runs else 5
    rgbe = rng.integers(0, 256, (3, width, 4), np.uint8)
    rgbe[..., 3] = rng.integers(120, 140, (3, width))
    rgbe[1, :, 0] = 7
    data = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X %d\n" % width
    for row in rgbe:
        if not runs:
            data += row.tobytes()
            continue
        data += bytes((2, 2, 0, width))
        for component in row.T:
            same = (component == component[0]).all()
            data += bytes((128 + width, component[0])) if same else bytes((width,)) + component.tobytes()
    wanted = rgbe[..., :3] * np.exp2(rgbe[..., 3:].astype(float) - 136)
    np.testing.assert_allclose(read_hdr(data), wanted, rtol=1e-6)
    for cut in (1, 20, len(data) - 40, len(data) - 1):
        with pytest.raises(bob.InputError, match="image: "):
            read_hdr(data[:cut])


# ---- Edges -----------------------------------------------------------------------------------------------


def test_edges_within_a_texture_are_means_over_their_pixels():
    """Dark components keep their highlights, and bright ones take no light from dark neighbours."""
    colors = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255), (0, 0, 0), (255, 255, 255)], np.uint8)
    texture = colors[np.random.default_rng(0).integers(0, 5, (16, 16))].repeat(8, 0).repeat(8, 1)
    corners = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    sheet = bob.Mesh(corners, [(0, 1, 2), (0, 2, 3)], uv=[(0, 0), (1, 0), (1, 1), (0, 1)], texture=texture)
    scene = bob.Scene(bob.Instance(sheet, material=bob.Material("#fff", metallic=0, roughness=0.4)))
    camera = bob.Camera(elevation=50)
    picture = bob.render(scene, camera, size=SIZE, light="studio", ground=False)
    expected = lit(scene, "studio", camera, paths=256, apart=True)["color"]
    inside = inner(picture.alpha == 1, 1)
    error = 255 * (to_srgb(picture.color) - to_srgb(expected))[inside]
    assert inside.sum() > 500
    assert np.abs(error).mean() < 5
    assert abs(error.mean()) < 3


# ---- The ground ------------------------------------------------------------------------------------------


def test_the_ground_shows_shadows_and_nothing_else():
    picture = bob.render(white(sphere_mesh()), bob.Camera(zoom=0.5), size=(96, 128), light="studio", samples=4)
    alpha, color = picture.alpha, picture.color
    hit = bob.trace(sphere_mesh(), bob.Camera(zoom=0.5), size=(96, 128)).alpha > 0
    away = ~inner(~hit, 1) == False  # noqa: E712
    shadow = away & (alpha > 0.3)
    assert shadow.sum() > 50
    assert color[away].max() < 0.02
    assert alpha[:10].max() < 0.05  # the sky, and the ground far from the ball
    assert alpha[inner(hit)].min() > 0.99


def test_what_floats_high_has_no_shadow_without_a_ground():
    picture = bob.render(white(sphere_mesh()), size=(48, 64), light="studio", ground=False, samples=1)
    hit = bob.trace(sphere_mesh(), size=(48, 64)).alpha > 0
    assert picture.alpha[inner(~hit, 1)].max() == 0


# ---- The first picture of light --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "hits"),
    [({"fraction": 0.3}, (4, 16, 16, 16)), ({"first": 1.0}, (16,)), ({"fraction": 0.3, "until": 1.0}, (16,))],
    ids=["replaced", "of all pixels", "perhaps the last"],
)
def test_only_a_picture_that_is_replaced_has_few_hits_at_edges(options, hits):
    frames = list(bob.progressive(white(sphere_mesh()), size=(24, 32), light="studio", **options))
    assert tuple(frame.shown.guides.edges.hits.shape[1] for frame in frames) == hits
    np.testing.assert_array_equal(frames[0].shown.guides.hit, frames[-1].shown.guides.hit)


# ---- A moving camera -------------------------------------------------------------------------------------


def turned(degrees):
    return bob.Camera(azimuth=30 + degrees, zoom=0.8)


def truth_of(scene, light, camera, size):
    tracer = LitTracer(scene, camera, size, light, ground=True, paths=192, seed=77)
    return finished(traced_light(tracer, 1.0, "lattice", 0, None), scene, camera, **PLAIN)


PLAIN = {"samples": 4, "background": None, "model": "default"}


def error_of(picture, truth):
    return np.abs(picture.color - truth.color).mean() + np.abs(picture.alpha - truth.alpha).mean()


def test_reprojected_light_leaves_less_error_than_new_paths_alone():
    scene, size = bob.Scene(bob.happy_tree()), (96, 128)
    lights = studio(turned(0))
    view = bob.View(scene, size=size, light=lights, ground=True)
    for i in range(7):
        frame = view.frame(turned(2 * i), fraction=0.015)
    assert frame.fraction < 0.03 < frame.shown.fraction
    alone = bob.View(scene, size=size, light=lights, ground=True).frame(turned(12), fraction=0.015)
    truth = truth_of(scene, lights, turned(12), size)
    assert error_of(frame.picture(), truth) < min(0.05, 0.75 * error_of(alone.picture(), truth))


def test_a_camera_at_rest_settles_to_the_converged_picture():
    """Paths of earlier cameras give way to this one's; then noise falls."""
    scene, size = bob.Scene([white(square(6)), white(sphere_mesh()).translate((0, 0, 1))]), (48, 64)
    lights = [bob.Light((1, 1, 2), angle=10), bob.Sky(intensity=0.3)]
    view = bob.View(scene, size=size, light=lights, ground=True)
    errors, truth = [], truth_of(scene, lights, turned(3), size)
    view.frame(turned(0), fraction=0.2)
    for _ in range(12):
        frame = view.frame(turned(3), fraction=0.5)
        errors.append(error_of(frame.picture(), truth))
    assert frame.fraction > 0.5  # the rest shows nothing
    np.testing.assert_allclose(frame.shown.planes, frame.gbuffer.planes, atol=1e-5)
    assert errors[-1] < 0.5 * errors[0]
    assert errors[-1] < 0.006


@pytest.mark.parametrize(
    ("material", "share_kept"),
    [
        (WHITE, (0.5, 1)),
        (bob.Material("#fff", metallic=1, roughness=0), (0, 0)),
        (bob.Material("#fff", metallic=1, roughness=0.2), (0, 0.1)),
        (bob.Material("#fff", metallic=0, roughness=0.6), (0.4, 1)),
    ],
)
def test_mirrors_and_highlights_are_not_reprojected(material, share_kept):
    ball = bob.Scene(bob.Instance(sphere_mesh(), material=material))
    view = bob.View(ball, size=(96, 128), light="studio", ground=False)
    before, after = view.frame(turned(0), fraction=0.2), view.frame(turned(3), fraction=1e-4)
    hits = after.shown.guides.hit > 0
    kept = np.count_nonzero((after.shown.mask > 0) & (after.gbuffer.mask == 0) & hits)
    least, most = share_kept
    assert least <= kept / np.count_nonzero(before.shown.mask * before.shown.guides.hit) <= most


def test_samples_do_not_drift():
    """There and back again, a sample is where it was: the edge of a shadow stays as sharp."""
    scene, size = bob.Scene(white(sphere_mesh())), (96, 128)
    view = bob.View(scene, size=size, light=[bob.Light((1, 1, 2), angle=1)], ground=True)
    first = view.frame(turned(0), fraction=0.1)
    for degrees in (1, 2, 1, 0):
        last = view.frame(turned(degrees), fraction=1e-4)
    both = (first.shown.mask > 0) & (last.shown.mask > 0)
    assert both.sum() > 0.5 * first.shown.mask.sum()
    same = np.isclose(first.shown.channel("shadow"), last.shown.channel("shadow"), atol=1e-4)
    assert same[both].mean() > 0.97


def test_views_begin_anew_whatever_their_seed():
    view = bob.View(bob.Scene(bob.happy_tree(), light="studio"), size=SIZE, seed=2**64 - 1)
    first = view.frame(turned(0), fraction=0.05)
    view.frame(turned(5), fraction=0.05)
    view.forget()
    again = view.frame(turned(0), fraction=0.05)
    assert again.fraction == first.fraction == again.shown.fraction
    view.close()
    jump = view.frame(bob.Camera(azimuth=210), fraction=0.05)  # nothing is known of its other side
    assert np.isfinite(jump.picture().color).all()


def test_views_under_the_headlight_are_as_they_were():
    with_light = bob.View(bob.happy_tree(), size=SIZE, light="headlight").frame(fraction=0.1)
    assert np.array_equal(with_light.image, bob.View(bob.happy_tree(), size=SIZE).frame(fraction=0.1).image)
    with pytest.raises(bob.InputError, match="light: expected none with a tracer"):
        bob.View(tracer=lambda camera, pixels: None, light="studio")


def test_a_camera_at_rest_shows_the_picture_of_all_paths():
    """Once each pixel has this camera's paths, earlier cameras do not matter."""
    scene = bob.Scene([white(square(6)), white(sphere_mesh()).translate((0, 0, 1))])
    light = bob.Light((1, 1, 2), angle=9)
    whole = traced_light(lit_tracer(scene, turned(3), SIZE, light, True), 1, "default", 0, None)
    expected = finished(whole, scene, turned(3), samples=4, background=None, model="default")
    pictures = []
    for first in (0, 90):
        view = bob.View(scene, size=SIZE, light=light, ground=True)
        view.frame(turned(first), fraction=0.3)
        view.frame(turned(3), fraction=0.3)
        pictures.append(view.frame(turned(3), fraction=1.0).picture().rgba)
        assert not np.array_equal(pictures[-1], view.frame(fraction=0.5).picture().rgba)  # less noise
    np.testing.assert_array_equal(*pictures)
    np.testing.assert_allclose(pictures[0].astype(int), expected.rgba, rtol=0, atol=1)


def test_frames_of_glass_are_transparent_beside_it():
    glass = bob.Instance(sphere_mesh(), material=bob.Glass())
    frame = bob.View(glass, size=SIZE, light="studio").frame(fraction=0.3)
    assert frame.alpha.min() == frame.picture().alpha.min() == 0
    assert frame.alpha.max() == 1


def test_a_frame_traces_as_many_pixels_as_its_time_allows():
    pace = _core.LightPace()
    assert pace.pixels(1000, 5.0) == 5  # at least .5 %
    pace.traced(100, 1.0)
    pace.completed(2.0)
    assert pace.pixels(1000, 5.0) == 300
    assert pace.pixels(100, 5.0) == 100
    assert pace.pixels(1000, 1.0) == 5
    pace.traced(1, 0.3)  # a call of few pixels, which costs more than their paths
    assert pace.pixels(1000, 5.0) == 220


def test_samples_of_moving_light_are_no_dots():
    """A traced pixel in a shadow's edge is as its neighbours, however the fit misses its own light."""
    scene = bob.Scene(white(sphere_mesh()).translate((0, 0, 1)))
    view = bob.View(scene, size=(96, 128), light=[bob.Light((1, 1, 2), angle=10)], ground=True)
    view.frame(turned(0), fraction=0.01)
    frame = view.frame(turned(2), fraction=0.01)
    traced = (frame.shown.mask > 0) & (frame.shown.depth == 0)
    alpha = frame.alpha
    around = (alpha[:-2, 1:-1] + alpha[2:, 1:-1] + alpha[1:-1, :-2] + alpha[1:-1, 2:]) / 4
    dots = np.abs(alpha[1:-1, 1:-1] - around)[traced[1:-1, 1:-1]]
    assert np.count_nonzero(dots > -1) > 50
    assert np.quantile(dots, 0.95) < 0.01


def test_a_moving_frame_is_as_large_as_its_time_allows():
    pace = _core.LightPace()
    assert pace.scale(1000, 1.0) == 1  # nothing is known
    pace.shown(1000, 10.0)
    assert pace.scale(1000, 15.0) == 1
    assert pace.scale(1000, 10.0) == 1.25
    assert pace.scale(1000, 3.6) == 2
    assert pace.scale(1000, 1e-3) == 3  # at least a third
    assert pace.scale(1000, 3.6) == 2.5  # a fifth must be left before it grows
    assert pace.scale(1000, 5.0) == 2
    pace.shown(250, 5.0)
    assert pace.scale(1000, 10.0) == 1.5


def test_moving_frames_under_lights_are_smaller_and_enlarged():
    """Time decides about the size of a frame whose camera moves, and of no other."""
    scene, size = bob.Scene(bob.happy_tree(), light="studio"), (95, 127)
    view, whole = bob.View(scene, size=size), bob.View(scene, size=size)
    first = view.frame(turned(0), ms=1e-3)
    assert not first.is_enlarged
    for i in range(1, 6):
        moving, expected = view.frame(turned(2 * i), ms=1e-3), whole.frame(turned(2 * i), fraction=0.005)
        assert moving.is_enlarged
        assert not expected.is_enlarged
    assert moving.gbuffer.size == moving.shown.size == (32, 42)
    assert moving.image.shape == moving.alpha.shape == moving.color.shape[:2] == moving.picture().size == size
    assert 0 < moving.fraction < moving.gbuffer.fraction / 8.5
    shown = [
        np.asarray(frame.picture(background="#888").rgba[..., 0], np.float32) / 255 for frame in (moving, expected)
    ]
    assert np.abs(shown[0] - shown[1]).mean() < 0.03
    assert bob.ssim(*shown) > 0.6
    assert not view.frame(turned(10), ms=1e-3).is_enlarged  # at rest
    assert not view.frame(turned(12), fraction=0.01).is_enlarged


# ---- Doors -----------------------------------------------------------------------------------------------


def test_without_lights_nothing_changes():
    tree = bob.happy_tree()
    plain = bob.trace(tree, size=SIZE)
    assert bob.trace(tree, size=SIZE, light="headlight") == plain
    assert bob.trace(bob.Scene(tree, light="studio"), size=SIZE, light="headlight") == plain
    assert np.array_equal(bob.render(tree, size=SIZE).rgba, bob.render(tree, size=SIZE, light="headlight").rgba)


def test_a_scene_carries_its_light():
    sun = bob.Light((1, 1, 2), angle=3)
    scene = bob.Scene(bob.happy_tree(), light=[sun, bob.Sky("#888")], ground=True)
    by_scene = bob.trace(scene, size=SIZE, fraction=0.2)
    given = bob.trace(bob.happy_tree(), size=SIZE, fraction=0.2, light=[sun, bob.Sky("#888")], ground=True)
    assert by_scene == given
    assert by_scene.channel("shadow").max() > 0.2


def test_traced_light_is_the_first_of_progressive_and_of_any_number_of_threads():
    scene = bob.Scene(bob.happy_tree())
    parts = with_threads((1, 3), lambda: bob.trace(scene, size=SIZE, fraction=0.3, light="studio"))
    assert parts[0] == parts[1]
    other = bob.trace(scene, size=SIZE, fraction=0.3, light="studio", seed=1)
    assert not np.array_equal(other.planes, parts[0].planes)


def test_passes_go_on_until_the_error_is_small():
    """Pixels are traced again after all have been traced, with new paths; the picture converges."""
    ball = bob.Scene([white(square(6)), white(sphere_mesh()).translate((0, 0, 1))])
    camera = bob.Camera(elevation=40)
    light = [bob.Light((1, 1, 2), angle=10), bob.Sky(intensity=0.3)]
    frames = []
    for frame in bob.progressive(ball, camera, size=SIZE, fraction=0.5, until=1e-9, light=light):
        frames.append(frame)
        if len(frames) == 8:
            break
    truth = lit(ball, light, camera, paths=1024)["gray"]
    errors = [np.abs(frame.image - truth).mean() for frame in (frames[0], frames[7])]
    assert errors[1] < errors[0]
    assert errors[1] < 0.01


def plate_on_the_ground():
    """A scene with a steep penumbra next to a contact."""
    plate = bob.sdf.cylinder(1) & bob.sdf.slab(z0=0, z1=0.4)
    return bob.Scene(plate)


def test_noise_that_is_predicted_after_completion_is_there():
    scene = plate_on_the_ground()
    runs = [
        traced_light(lit_tracer(scene, bob.Camera(), SIZE, "studio", None, seed=seed), 1, "default", 0, None)
        for seed in range(12)
    ]
    predicted = np.mean([noise_shown(each) for each in runs], axis=0)
    shown = np.array(
        [
            to_srgb(complete(each, "guided", channel="color")).max(-1) + complete(each, "guided", channel="alpha")
            for each in runs
        ]
    )
    noisy = predicted > 1 / 255
    assert 0.01 < noisy.mean() < 0.3
    assert 0.25 < np.median(shown.std(axis=0)[noisy] / predicted[noisy]) < 2
    assert np.median(shown.std(axis=0)[predicted == 0]) < 1 / 255


def test_where_noise_would_be_seen_pixels_are_traced_again():
    scene = plate_on_the_ground()

    def tracer(seed=0, paths=16):
        return lit_tracer(scene, bob.Camera(), SIZE, "studio", None, seed=seed, paths=paths)

    def alpha(gbuffer):
        return complete(gbuffer, "guided", channel="alpha")

    truth, once, seen = (
        traced_light(tracer(1, 512), 1, "default", 0, None),
        traced_light(tracer(), 1, "default", 0, None),
        light_to_be_seen(tracer()),
    )
    again = (seen.gray != once.gray) | (seen.channel("shadow") != once.channel("shadow"))
    assert 0 < again.mean() < 0.3
    error, error_once = (np.square(alpha(each) - alpha(truth))[again].mean() for each in (seen, once))
    assert error < 0.5 * error_once
    np.testing.assert_array_equal(
        bob.render(scene, size=SIZE, light="studio").rgba,
        finished(seen, scene, bob.Camera(), samples=4, background=None, model="default").rgba,
    )


def test_a_camera_at_rest_traces_noise_again_where_render_does():
    scene = plate_on_the_ground()
    expected = bob.render(scene, size=SIZE, light="studio").rgba.astype(int)
    view = bob.View(scene, size=SIZE, light="studio")
    pictures = [view.frame(bob.Camera(), fraction=1.0).picture().rgba for _ in range(5)]  # in motion, then four passes
    np.testing.assert_allclose(pictures[-1], expected, rtol=0, atol=1)
    assert np.abs(pictures[1] - expected).max() > 1


def test_the_picture_of_a_few_pixels_is_near_the_whole_one():
    tree = bob.Scene(bob.happy_tree())
    whole = bob.render(tree, size=(120, 160), light="studio", samples=4)
    part = bob.render(tree, size=(120, 160), light="studio", samples=4, fraction=0.1)
    assert np.abs(part.color - whole.color).mean() < 0.015
    assert np.abs(part.alpha - whole.alpha).mean() < 0.02


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: bob.Light((0, 0, math.nan)), "direction: expected finite"),
        (lambda: bob.Light((0, 0, 0)), "direction: expected a length above 0"),
        (lambda: bob.Light((0, 0, 1), angle=181), "angle: expected"),
        (lambda: bob.Light((0, 0, 1), intensity=math.inf), "intensity: expected"),
        (lambda: bob.Sky(image=np.full((2, 4, 3), np.nan)), "image: expected"),
        (lambda: bob.Sky(image=np.full((2, 4, 3), -1.0)), "image: expected"),
        (
            lambda: bob.Sky(image=np.broadcast_to(np.float32(1), (8000, 16000, 3))),
            "image: expected an environment of at most",
        ),
        (lambda: bob.Sky("#fff", "#000", image=np.ones((2, 4, 3))), "bottom: expected none"),
        (lambda: bob.render(bob.happy_tree(), light="moonshine"), "light: expected headlight, studio or the path"),
        (lambda: bob.render(bob.happy_tree(), light="no.hdr"), "no.hdr: can't read it"),
        (lambda: bob.render(bob.happy_tree(), light=5), "light: expected a Light, a Sky or several, got int"),
        (lambda: bob.render(bob.happy_tree(), light=[bob.Sky(), bob.Sky()]), "light: expected at most one Sky"),
        (lambda: bob.render(bob.happy_tree(), light=40 * [bob.Light((0, 0, 1))]), "light: expected at most 32, got 40"),
        (lambda: bob.render(bob.happy_tree(), ground=True), "ground: expected none under the headlight"),
    ],
)
def test_bad_lights_are_named(make, message):
    with pytest.raises(bob.InputError) as error:
        make()
    assert str(error.value).startswith(message)


def test_extreme_scenes_end():
    """Black and blinding skies, inside-out and open meshes, a camera inside a mirror box, a thousand nested balls."""
    ball = sphere_mesh(1)
    inside_out = bob.Mesh(ball.vertices, ball.triangles[:, ::-1])
    mirror = bob.Material("#fff", metallic=1, roughness=0)
    within = bob.Camera(position=(0.1, 0, 0), target=(1, 0, 0), fov=90)
    crystal = bob.Instance(ball, material=bob.Glass(ior=100))
    balls = [bob.Instance(ball, material=bob.Glass()).scale(1 - i / 1001) for i in range(1000)]
    nested = [bob.Instance(ball, material=mirror).scale(1 - i / 1001) for i in range(1000)]
    for scene, light, camera in (
        (ball, bob.Sky("#000"), bob.Camera()),
        (ball, bob.Sky(image=np.zeros((4, 8, 3))), bob.Camera()),
        (ball, bob.Sky("#fff", intensity=1e6), bob.Camera()),
        (inside_out, "studio", bob.Camera()),
        (bob.Mesh(ball.vertices, ball.triangles[:9]), "studio", bob.Camera()),
        (bob.Instance(ball, material=mirror), "studio", within),
        (nested, "studio", bob.Camera()),
        (balls, "studio", bob.Camera()),
        (crystal, "studio", within),
        (bob.Instance(bob.Mesh(ball.vertices, ball.triangles[:9]), material=bob.Glass()), "studio", bob.Camera()),
        (ball, bob.Light((0, 0, 1), angle=180), bob.Camera(elevation=-30)),
    ):
        picture = bob.render(scene, camera, size=(12, 16), light=light, samples=1)
        assert np.isfinite(picture.color).all()
        assert np.isfinite(picture.alpha).all()


def test_damaged_radiance_files_are_refused_in_a_line():
    """Random bytes in a run-length encoded file: read or refused, without any other error."""
    rng = np.random.default_rng(1)
    row = bytes((2, 2, 0, 16)) + 4 * (bytes((128 + 16, 130)))
    good = b"#?RADIANCE\n\n-Y 4 +X 16\n" + 4 * row
    assert read_hdr(good).shape == (4, 16, 3)
    refused = []
    for _ in range(2000):
        data = bytearray(good)
        for _ in range(rng.integers(1, 4)):
            data[rng.integers(len(data))] = rng.integers(256)
        try:
            read_hdr(bytes(data[: rng.integers(1, len(data) + 1)]))
        except bob.InputError as error:
            refused.append(str(error))
    assert len(refused) > 1000
    assert not any("\n" in message for message in refused)


def test_skies_are_equal_if_their_pictures_are():
    ones, twos = np.ones((2, 4, 3)), np.full((2, 4, 3), 2.0)
    assert bob.Sky(image=ones) == bob.Sky(image=ones.copy())
    assert bob.Sky(image=ones) != bob.Sky(image=twos)
    assert bob.Sky(image=ones) != bob.Sky()
    assert bob.Light((0, 0, 2)) == bob.Light((0, 0, 1))
