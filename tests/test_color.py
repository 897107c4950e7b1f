"""Colour: materials, meshes with colours and textures, their pictures, and their completion."""

import io
import pickle

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.color import from_srgb, luminance, to_srgb
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.rendering import _at_edges
from bobrossnet.sdf import box, sphere

SIZE = 90, 120
RED = bob.Material("#c33")


def ball(columns=48, rows=24, **colors):
    """Return a unit ball's mesh with uv, and its vertices."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    around, down = 2 * np.pi * u, np.pi * v
    points = np.stack([np.cos(around) * np.sin(down), np.sin(around) * np.sin(down), np.cos(down)], -1).reshape(-1, 3)
    index = np.arange(len(points)).reshape(columns + 1, rows + 1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack([a, d, b], -1).reshape(-1, 3), np.stack([b, d, c], -1).reshape(-1, 3)])
    made = {name: value(points, triangles) for name, value in colors.items()}
    if "texture" in made:
        made["uv"] = np.stack([u, v], -1).reshape(-1, 2)
    return bob.Mesh(points, triangles, points, **made)


def checks(*_):
    texels = np.full((8, 16, 3), (230, 220, 200), np.uint8)
    texels[::2, ::2], texels[1::2, 1::2] = (200, 40, 40), (40, 60, 200)
    return texels


@pytest.fixture(scope="module")
def scene():
    return bob.Scene(
        [
            bob.Instance(ball(texture=checks)).translate((0, -1.1, 0)),
            bob.Instance(ball(colors=lambda points, _: (points + 1) / 2)).translate((0, 1.1, 0)),
            bob.Instance(box(1), material=bob.Material("#e90", metallic=1, roughness=0.3)).translate((0, 0, 1.5)),
        ]
    )


@pytest.fixture(scope="module")
def full(scene):
    return bob.trace(scene, size=SIZE)


# ---- Materials -------------------------------------------------------------------------------------------


def test_metallic_or_roughness_chooses_the_model():
    assert bob.Material().roughness is None
    assert (bob.Material(metallic=1).metallic, bob.Material(metallic=1).roughness) == (1, 0.5)
    assert (bob.Material(roughness=0.2).metallic, bob.Material(roughness=0.2).roughness) == (0, 0.2)
    assert bob.Material("#abc") == bob.Material("#aabbcc")
    assert bob.Material(emissive="#fff").emissive == (1, 1, 1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"metallic": 2}, r"metallic: expected a number in \[0, 1\], got 2"),
        ({"roughness": -1}, r"roughness: expected a number in \[0, 1\], got -1"),
        ({"metallic": 1, "shininess": 5}, "material: expected metallic and roughness, or ambient, .+, got both"),
        ({"emissive": "rot"}, "emissive: expected #rrggbb, a CSS name or 3 numbers, got 'rot'"),
        ({"color": "#abcd"}, "color: expected #rrggbb, a CSS name or 3 numbers, got '#abcd'"),
    ],
)
def test_wrong_materials_are_refused(arguments, message):
    with pytest.raises(bob.InputError, match=f"^{message}"):
        bob.Material(**arguments)


@pytest.mark.parametrize("material", [RED, bob.Material((0.1, 0.5, 0.9), 0.05, 0.5, 0.4, 8, emissive=(0.1, 0, 0.02))])
def test_colors_of_blinn_phong_are_those_of_its_formula(material):
    seen = bob.trace(bob.Instance(sphere(1), material=material), size=SIZE)
    x, y = np.moveaxis(seen.normal.astype(float), -1, 0)
    normal = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], -1)
    light = np.array((-0.3, 0.4, 1)) / np.linalg.norm((-0.3, 0.4, 1))
    half = (light + (0, 0, 1)) / np.linalg.norm(light + (0, 0, 1))
    body = material.ambient + material.diffuse * np.maximum(0, normal @ light)
    highlight = material.specular * np.maximum(0, normal @ half) ** material.shininess
    expected = body[..., None] * material.color + highlight[..., None] + material.emissive
    expected = np.clip(expected, 0, 1) * seen.alpha[..., None]
    np.testing.assert_allclose(seen.color, expected, atol=2e-5)
    assert (seen.albedo == seen.alpha[..., None] * np.float32(material.color)).all()
    np.testing.assert_allclose(luminance(seen.color), seen.gray, atol=1e-5)


def test_white_scenes_hold_no_colors():
    seen = bob.trace(sphere(1), size=SIZE)
    assert seen.channels == ("mask", "gray", "depth", "normal")
    assert (seen.color == seen.gray[..., None]).all()
    assert (seen.albedo == seen.alpha[..., None]).all()
    assert 0.2 < seen.alpha.mean() < 0.9
    part = seen.sample(0.1)
    assert (bob.complete(part, channel="color") == bob.complete(part)[..., None]).all()


def test_white_metal_has_the_gray_of_its_color():
    metal = bob.trace(bob.Instance(sphere(1), material=bob.Material(metallic=1, roughness=0.4)), size=SIZE)
    tinted = bob.trace(bob.Instance(sphere(1), material=bob.Material("#fffffe", metallic=1, roughness=0.4)), size=SIZE)
    np.testing.assert_allclose(tinted.color, metal.color, atol=0.01)
    assert tinted.channels == ("mask", "gray", "depth", "normal", "color", "albedo")
    assert metal.gray.max() == 1  # the highlight


# ---- Meshes ----------------------------------------------------------------------------------------------


def test_uint8_colors_are_srgb():
    corners, triangles = np.eye(3), [(0, 1, 2)]
    made = bob.Mesh(corners, triangles, colors=np.array([(255, 0, 128)] * 3, np.uint8))
    np.testing.assert_allclose(made.colors[0], (1, 0, from_srgb(128 / 255)), rtol=1e-6)


def test_textures_are_seen_where_uv_says(full, scene):
    texture = checks()
    one = bob.trace(ball(texture=checks), bob.Camera(azimuth=0, elevation=0), size=(200, 200))
    row, column = np.mgrid[:200, :200]
    y, z = (column + 0.5 - 100) / 100, (99.5 - row) / 100
    x = np.sqrt(np.maximum(0, 1 - y * y - z * z))
    u, v = np.arctan2(y, x) / (2 * np.pi) % 1, np.arccos(np.clip(z, -1, 1)) / np.pi
    at = u * 16 - 0.5, v * 8 - 0.5  # in texels
    far = [np.abs(t - np.rint(t)) < 0.15 for t in at]  # near a texel's centre: a pixel covers 0.02 texels
    inside = far[0] & far[1] & (x > 0.5)
    expected = from_srgb(texture[np.rint(at[1]).astype(int) % 8, np.rint(at[0]).astype(int) % 16] / 255)
    assert inside.sum() > 1000
    assert np.abs(one.albedo - expected)[inside].mean() < 0.1
    closest = [np.abs(t - np.rint(t)) < 0.03 for t in at]
    exact = closest[0] & closest[1] & (x > 0.5)
    assert exact.sum() > 10
    assert np.abs(one.albedo - expected)[exact].max() < 0.05


def test_textures_seen_from_afar_are_means():
    stripes = np.zeros((64, 64, 3), np.uint8)
    stripes[:, ::2] = 255
    square = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    uv = [(0, 8), (8, 8), (8, 0), (0, 0)]
    tiled = bob.Mesh(*square, uv=uv, texture=stripes)
    seen = bob.trace(tiled, bob.Camera(elevation=90, zoom=1), size=(64, 64))
    inside = seen.alpha.astype(bool)
    assert inside.sum() > 500
    np.testing.assert_allclose(seen.albedo[inside], 0.5, atol=0.02)


SQUARE = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)]
CORNERS = [(0, 1), (1, 1), (1, 0), (0, 0)]


def sheet(z=0, **colors):
    """Return a square of side 2, facing up."""
    return bob.Mesh([(x, y, z) for x, y, _ in SQUARE[0]], SQUARE[1], **colors)


def seen_from_above(*shapes, size=(64, 64), fov=0):
    return bob.trace(shapes, bob.Camera(azimuth=-90, elevation=90, fov=fov), size=size)


def holes(cutoff=0.5, seed=0):
    """Return a sheet with a noisy alpha, and masks of opaque and of certain points, by numpy."""
    alpha = np.random.default_rng(seed).integers(0, 256, (6, 9), np.uint8)
    texture = np.dstack([*[np.full((6, 9), 255, np.uint8)] * 3, alpha])

    def is_there(u, v):
        x, y = u * 9 - 0.5, v * 6 - 0.5
        i, j = np.floor(x).astype(int), np.floor(y).astype(int)
        texel = lambda down, right: alpha[(j + down) % 6, (i + right) % 9] / 255  # noqa: E731
        top, bottom = (texel(down, 0) + (x - i) * (texel(down, 1) - texel(down, 0)) for down in (0, 1))
        found = top + (y - j) * (bottom - top)
        return found >= cutoff, np.abs(found - cutoff) > 1e-4

    return sheet(uv=CORNERS, texture=texture, alpha_cutoff=cutoff), is_there


@pytest.mark.parametrize("cutoff", [0.0, 0.3, 0.5, 0.8])
@pytest.mark.parametrize("fov", [0, 50])
def test_rays_go_on_where_alpha_is_below_the_cutoff(cutoff, fov):
    """They hit the surfaces behind: another sheet with holes, then a floor."""
    above, is_there = holes(cutoff)
    below, is_below = holes(cutoff, seed=1)
    red, green, blue = (
        bob.Instance(shape, material=bob.Material(color))
        for shape, color in zip((above, below, sheet(-1)), np.eye(3), strict=True)
    )
    scene = bob.Scene([blue, red, green.translate((0, 0, -0.5))])
    rng = np.random.default_rng(4)
    x, y = rng.uniform(-0.99, 0.99, (2, 4000))
    origins = np.stack([x, y, np.full(4000, 2.0)], axis=-1)
    hits = scene.closest_hits(origins, np.broadcast_to((0.0, 0.0, -1.0), origins.shape))
    first, sure = is_there((x + 1) / 2, (1 - y) / 2)
    second, sure_too = is_below((x + 1) / 2, (1 - y) / 2)
    expected = np.select([first, second], [2.0, 2.5], 3.0)
    sure &= sure_too
    assert sure.mean() > 0.99
    np.testing.assert_allclose(hits.distance[sure], expected[sure], atol=1e-5)
    if cutoff:
        assert 0.05 < first.mean() < 0.95
    # The same in pictures: each pixel shows one of the three.
    seen = bob.trace(scene, bob.Camera(azimuth=-90, elevation=70, fov=fov), size=(120, 120))
    shown = seen.albedo[seen.alpha > 0]
    assert (np.sort(shown, axis=-1) == (0, 0, 1)).all()
    assert (shown.mean(axis=0) > 0.01).all()


def test_holes_are_the_same_at_every_size_and_in_every_order():
    above, _ = holes()
    scene = bob.Scene([above, bob.Instance(sheet(-1), material=bob.Material((0, 0, 1)))])
    full = seen_from_above(*scene.instances, size=(47, 47))
    large = seen_from_above(*scene.instances, size=(141, 141))
    assert np.array_equal(full.depth > 0, large.depth[1::3, 1::3] > 0)
    np.testing.assert_allclose(full.depth, large.depth[1::3, 1::3], atol=1e-6)
    camera = bob.Camera(azimuth=-90, elevation=90)
    for order in ("lattice", "adaptive", "uniform"):
        part = bob.trace(scene, camera, size=(47, 47), fraction=0.4, order=order)
        traced = part.mask > 0
        assert np.array_equal(part.stack()[:, traced], full.stack()[:, traced])
    view = bob.View(scene, size=(47, 47))
    for azimuth in (-92, -91, -90):
        view.frame(bob.Camera(azimuth=azimuth, elevation=90), fraction=0.2)
    while (frame := view.frame(fraction=0.5)).fraction < 1:
        pass
    assert np.array_equal(frame.gbuffer.depth, full.depth)


def test_alphas_of_vertices_cut_too():
    """Interpolated over the triangle, times the texture's alpha."""
    fading = [(1, 1, 1, 1), (1, 1, 1, 0), (1, 1, 1, 0), (1, 1, 1, 1)]  # from left to right
    half = np.full((1, 1, 4), 255, np.uint8)
    half[..., 3] = 204
    for more, edge in (({}, 0.4), ({"uv": CORNERS, "texture": half}, 0.5)):
        seen = seen_from_above(sheet(colors=fading, alpha_cutoff=0.6 if not more else 0.4, **more), size=(200, 200))
        columns = np.flatnonzero(seen.alpha[100])
        width = 200 / np.sqrt(2)
        assert columns[-1] - columns[0] + 1 == pytest.approx(edge * width, abs=1.5)
    bytes_of = np.array([(255, 128, 0, 51)] * 4, np.uint8)
    made = sheet(colors=bytes_of)
    np.testing.assert_allclose(made.alphas, 0.2, rtol=1e-6)
    np.testing.assert_allclose(made.colors[0], (1, from_srgb(128 / 255), 0), rtol=1e-6)
    assert not seen_from_above(made).alpha.any()


def test_what_is_opaque_has_no_holes():
    """Also at a cutoff of 1, whatever the rounding."""
    texture = np.full((5, 7, 4), 255, np.uint8)
    made = sheet(uv=CORNERS, texture=texture, colors=np.ones((4, 4)), alpha_cutoff=1)
    plain = sheet(uv=CORNERS, texture=texture[..., :3], colors=np.ones((4, 3)))
    assert seen_from_above(made) == seen_from_above(plain)


def test_meshes_with_holes_are_written_and_read(tmp_path):
    texture = np.random.default_rng(0).integers(0, 256, (6, 9, 4), np.uint8)
    made = sheet(uv=CORNERS, texture=texture, colors=np.full((4, 4), 0.9), alpha_cutoff=0.3)
    bob.save_scene(made, tmp_path / "a.bob")
    assert b'"version":"4"' in (tmp_path / "a.bob").read_bytes()
    again = bob.load(tmp_path / "a.bob").instances[0].shape
    assert again.digest == made.digest == pickle.loads(pickle.dumps(made)).digest
    assert again.alpha_cutoff == 0.3
    assert seen_from_above(again) == seen_from_above(made)
    assert sheet(uv=CORNERS, texture=texture, alpha_cutoff=0.4).digest != sheet(uv=CORNERS, texture=texture).digest
    turned = made.turned_upright()
    assert np.array_equal(turned.texture_alpha, texture[..., 3])
    assert np.array_equal(turned.alphas, made.alphas)
    tensors = made.tensors()
    for missing in ("alpha_cutoff", "texture", "colors"):
        with pytest.raises(bob.InputError, match=r"^\w+: "):
            bob.Mesh.from_tensors({name: tensor for name, tensor in tensors.items() if name != missing})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"alpha_cutoff": 2}, r"alpha_cutoff: expected a number in \[0, 1\], got 2"),
        ({"colors": [(1, 1, 1, 2)] * 3}, "colors: expected numbers in 0..1, or uint8, got 1..2"),
        ({"uv": [(0, 0)] * 3, "texture": np.zeros((2, 2, 5), np.uint8)}, r"texture: expected shape \(n, n, 3\)"),
        ({"uv": [(0, 0)] * 3, "texture": [[(1, 2, 3)], []]}, "texture: expected an array of numbers"),
        ({"colors": [(2, 0, 0)] * 3}, "colors: expected numbers in 0..1, or uint8, got 0..2"),
        ({"colors": [(0, 0, 0)]}, r"colors: expected shape \(3, 3\), got \(1, 3\).+ one colour per vertex"),
        ({"face_colors": [(0, 0, 0)] * 2}, r"face_colors: expected shape \(1, 3\)"),
        ({"uv": [(0, 0)] * 3}, "uv: expected uv and texture together, got uv alone"),
        ({"texture": np.zeros((2, 2, 3), np.uint8)}, "uv: expected uv and texture together, got texture alone"),
        ({"uv": [(0, np.nan)] * 3, "texture": np.zeros((2, 2, 3), np.uint8)}, "uv: "),
        ({"uv": [(0, 0)] * 3, "texture": np.zeros((2, 2, 3))}, "texture: expected uint8"),
        ({"uv": [(0, 0)] * 3, "texture": np.zeros((2, 2, 3), np.uint8), "wrap": "x"}, "wrap: expected repeat, clamp"),
    ],
)
def test_wrong_colors_of_meshes_are_refused(arguments, message):
    with pytest.raises(bob.InputError, match=f"^{message}"):
        bob.Mesh(np.eye(3), [(0, 1, 2)], **arguments)


def test_scenes_with_colors_are_written_and_read(scene, full, tmp_path):
    bob.save_scene(scene, tmp_path / "a.bob")
    again = bob.load(tmp_path / "a.bob")
    assert bob.trace(again, size=SIZE) == full
    assert [i.material for i in again.instances] == [i.material for i in scene.instances]
    assert b'"version":"2"' in (tmp_path / "a.bob").read_bytes()
    bob.save_scene(bob.Instance(sphere(1), material=RED), tmp_path / "b.bob")
    assert b'"version":"1"' in (tmp_path / "b.bob").read_bytes()  # readable by older releases


def test_colored_meshes_turn_upright_with_their_colors():
    made = ball(texture=checks)
    turned = made.turned_upright()
    assert np.array_equal(turned.texture, made.texture)
    assert np.array_equal(turned.uv, made.uv)


# ---- Completing ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("channel", ["gray", "color", "albedo", "alpha"])
def test_traced_pixels_are_kept_in_every_channel(full, channel):
    assert np.array_equal(bob.complete(full, channel=channel), full.channel(channel))
    part = full.sample(0.1)
    completed, traced = bob.complete(part, channel=channel), part.mask > 0
    assert completed.shape == full.channel(channel).shape
    assert np.array_equal(completed[traced], full.channel(channel)[traced])
    assert np.abs(completed - full.channel(channel)).mean() < 0.04
    assert 0 <= completed.min() <= completed.max() <= 1


def test_luminance_of_completed_colors_is_completed_gray(full):
    part = full.sample(0.1)
    found, gray = luminance(bob.complete(part, channel="color")), bob.complete(part)
    assert np.abs(found - gray).mean() < 0.002


def test_between_pixels_that_agree_colors_are_interpolated():
    across = np.arange(128, dtype=np.float32)
    red, blue = 0.2 + 0.001 * across, 0.5 - 0.001 * across[:, None]
    color = np.stack(np.broadcast_arrays(red, np.float32(0.3), blue), -1)
    depth, normal = np.full((128, 128), 0.5, np.float32), np.zeros((128, 128, 2), np.float32)
    mask, inside = np.ones((128, 128), np.float32), np.s_[16:112, 16:112]
    for scale in (1, 1000):  # display-referred, and of any range
        full = bob.GBuffer(mask=mask, depth=depth, normal=normal, color=np.float32(scale) * color)
        completed = bob.complete(full.sample(1 / 16, order="lattice"), channel="color") / scale
        assert np.abs(completed - color)[inside].max() < 1e-4  # their ratio to gray would give errors of 0.0008


def test_colors_are_closer_than_gray_or_those_around(full):
    part = full.sample(0.1)
    error = np.abs(bob.complete(part, channel="color") - full.color).mean()
    assert error < 0.7 * np.abs(bob.complete(part)[..., None] - full.color).mean()


def test_other_channels_are_refused(full):
    with pytest.raises(bob.InputError, match="channel: expected one of gray, color, albedo, alpha, got 'depth'"):
        bob.complete(full, channel="depth")


def test_adaptive_pixels_go_to_edges_of_color():
    """Red and green with equal luminance, on one plane."""
    red, green = (0.5, 0, 0), (0, 0.5 * 0.2126 / 0.7152, 0)
    square = [(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0), (1, -1, 0), (1, 1, 0)]
    faces = [(0, 1, 2), (0, 2, 3), (1, 4, 5), (1, 5, 2)]
    plane = bob.Mesh(square, faces, face_colors=[red, red, green, green])
    full = bob.trace(plane, bob.Camera(azimuth=0, elevation=90), size=(200, 200))
    # The camera looks down with x to the bottom: the edge is a row.
    part = full.sample(0.05)
    edge = np.abs(np.diff(full.color[..., 0], axis=0)).max(axis=1).argmax()
    rows = part.mask[:, 60:140].mean(axis=1)
    assert rows[edge - 1 : edge + 3].mean() > 3 * rows[edge + 10 : edge + 40].mean()


# ---- Users' tracers --------------------------------------------------------------------------------------


def test_samples_of_color_alone_are_enough():
    samples = bob.Samples(color=[(1, 0, 0), (0, 0.5, 0)])
    assert samples.hit.all()
    np.testing.assert_allclose(samples.gray, (0.2126, 0.3576), atol=1e-6)
    for name, value in (("depth", 0.5), ("normal", 0), ("albedo", 1)):
        assert (samples.channel(name) == value).all()
    with pytest.raises(bob.InputError, match="gray: expected gray or color, got neither"):
        bob.Samples(depth=[1.0])
    with pytest.raises(bob.InputError, match=r"color: expected values of at least 0, got -2"):
        bob.Samples(color=[(-2, 0, 0)])


def test_progressive_pictures_end_with_a_tracers_colors(full):
    def tracer(pixels):
        return bob.Samples(color=full.color[tuple(pixels.T)])

    frames = list(bob.progressive(tracer=tracer, size=SIZE, fraction=0.3))
    assert all(frame.color.shape == (*SIZE, 3) for frame in frames)
    assert np.array_equal(frames[-1].color, full.color)
    assert np.abs(frames[0].color - full.color).mean() < 0.05


def test_views_carry_colors_along(scene):
    view = bob.View(scene, size=SIZE)
    for azimuth in (28, 29, 30):
        frame = view.frame(bob.Camera(azimuth=azimuth), fraction=0.1)
    exact = bob.trace(scene, bob.Camera(azimuth=30), size=SIZE)
    anew = bob.complete(exact.sample(0.1), channel="color")
    assert np.abs(frame.color - exact.color).mean() < np.abs(anew - exact.color).mean()
    while frame.fraction < 1:
        frame = view.frame(fraction=0.5)
    assert np.array_equal(frame.color, exact.color)


def test_gbuffers_are_made_of_colors(full):
    made = bob.GBuffer(mask=full.mask, depth=full.depth, normal=full.normal, color=full.color, albedo=full.albedo)
    assert np.array_equal(made.color, full.color)
    np.testing.assert_allclose(made.gray, luminance(full.color), atol=1e-6)
    white = bob.GBuffer(mask=full.mask, gray=full.gray, depth=full.depth, normal=full.normal, color=full.color)
    assert np.array_equal(white.albedo, np.repeat(full.alpha[..., None], 3, -1))
    with pytest.raises(bob.InputError, match="gray: expected gray or color, got neither"):
        bob.GBuffer(mask=full.mask, depth=full.depth, normal=full.normal)


# ---- Pictures --------------------------------------------------------------------------------------------


def test_displayed_light_is_its_srgb_rounded():
    light = np.concatenate(
        [np.linspace(-0.1, 1.1, 100_000, dtype=np.float32), np.float32([np.nan, np.inf, -np.inf, 0, 1])]
    )
    exact = 255 * to_srgb(np.nan_to_num(light, nan=0).astype(np.float64))
    assert np.abs(_core.displayed(light) - exact).max() < 0.501


def test_pictures_have_straight_alpha():
    """The premultiplied colour of arrays of any order; nothing where nothing is covered."""
    alpha = np.float32([[0, 0.001, 0.25], [0.5, 1, 1.5]])
    color = np.moveaxis(np.float32([[[0.3] * 3] * 2, [[0.25, 0.25, 0.05], [0.25, 0.5, 2]], [[0] * 3] * 2]), 0, -1)
    rgba = _core.rgba(color, alpha)
    assert rgba[..., 3].tolist() == [[0, 0, 64], [128, 255, 255]]
    assert not rgba[alpha < 0.01].any()
    expected = [color_to_8_bit(np.float32(own)).tolist() for own in ([1, 0.2, 0], [0.6, 0.5, 0], [0.3, 0.5, 0])]
    assert [rgba[i, j, :3].tolist() for i, j in ((0, 2), (1, 0), (1, 1))] == expected


def test_enlarged_planes_are_bilinear():
    ramp = np.add.outer(np.arange(4.0), 10 * np.arange(5.0)).astype(np.float32)
    output = np.empty((2, 8, 15), np.float32)
    _core.enlarge(np.stack([ramp, -ramp]), output)
    rows, columns = np.clip((np.arange(8) + 0.5) / 2 - 0.5, 0, 3), np.clip((np.arange(15) + 0.5) / 3 - 0.5, 0, 4)
    np.testing.assert_allclose(output[0], np.add.outer(rows, 10 * columns), atol=1e-5)
    np.testing.assert_array_equal(output[1], -output[0])


def test_srgb_goes_both_ways():
    values = np.linspace(0, 1, 256)
    np.testing.assert_allclose(to_srgb(from_srgb(values)), values, atol=1e-6)
    assert to_srgb(np.array([0.5]))[0] == pytest.approx(0.7353569, abs=1e-6)


def test_pixel_centres_are_what_was_traced(scene, full):
    picture = bob.render(scene, size=SIZE, samples=1)
    assert np.array_equal(picture.color, full.color)
    assert np.array_equal(picture.alpha, full.alpha)
    hit = full.alpha > 0
    assert np.array_equal(picture.rgba[hit][:, :3], np.rint(to_srgb(full.color[hit]) * 255))
    assert (picture.rgba[~hit] == 0).all()


def test_edges_are_as_smooth_as_with_many_rays_everywhere(scene):
    """Of 16 rays a pixel, pixels that differ from their neighbours get all."""
    many = bob.trace(scene, size=(4 * SIZE[0], 4 * SIZE[1]))
    truth = many.color.reshape(SIZE[0], 4, SIZE[1], 4, 3).mean(axis=(1, 3))
    coverage = many.alpha.reshape(SIZE[0], 4, SIZE[1], 4).mean(axis=(1, 3))
    picture = bob.render(scene, size=SIZE, samples=16)
    assert bob.ssim(luminance(to_srgb(picture.color)), luminance(to_srgb(truth))) > 0.998
    assert np.abs(picture.alpha - coverage).mean() < 0.001
    one, four = (bob.render(scene, size=SIZE, samples=n) for n in (1, 4))
    errors = [np.abs(p.color - truth).mean() for p in (one, four, picture)]
    assert errors[2] < 0.5 * errors[1] < 0.5 * errors[0]


def test_backgrounds_lie_behind(scene):
    before_white = bob.render(scene, size=SIZE, background="#fff")
    transparent = bob.render(scene, size=SIZE)
    assert (before_white.rgba[..., 3] == 255).all()
    shown = Image.alpha_composite(Image.new("RGBA", SIZE[::-1], "white"), Image.fromarray(transparent.rgba))
    solid = transparent.rgba[..., 3] == 255
    assert np.array_equal(np.asarray(shown)[solid], before_white.rgba[solid])
    expected = transparent.color + (1 - transparent.alpha[..., None])
    np.testing.assert_allclose(before_white.color, expected, atol=1e-6)
    two = bob.render(scene, size=SIZE, background=("#ff0000", "#0000ff")).rgba
    assert two[0, 0].tolist() == [255, 0, 0, 255]
    assert two[-1, -1].tolist() == [0, 0, 255, 255]
    assert 120 < two[SIZE[0] // 2, 0, 0] < 135


def test_sparse_pictures_are_completed(scene):
    sparse, exact = (bob.render(scene, size=SIZE, background="#fff", fraction=f, samples=1) for f in (0.1, 1.0))
    assert 0 < np.abs(sparse.color - exact.color).mean() < 0.03


def test_pictures_show_and_write_themselves(scene, tmp_path):
    picture = bob.render(scene, size="120x90")
    assert np.array_equal(np.asarray(picture), picture.rgba)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(picture._repr_png_()))), picture.rgba)
    for ending in ("png", "webp", "jpg", "bmp", "tif"):
        picture.save(tmp_path / f"a.{ending}")
        with Image.open(tmp_path / f"a.{ending}") as written:
            assert written.size == (120, 90)
    with Image.open(tmp_path / "a.png") as written:
        assert np.array_equal(np.asarray(written), picture.rgba)
    with pytest.raises(bob.InputError, match="expected a picture's ending"):
        picture.save(tmp_path / "a.xyz")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"samples": 0}, "samples: expected an integer in 1..64, got 0"),
        ({"samples": 3}, "samples: expected one of 1, 4, 9, 16, 25, 36, 49, 64, got 3"),
        ({"light": "lamp"}, "light: expected headlight, studio or the path of an environment, got 'lamp'"),
        ({"background": "weiss"}, "background: expected #rrggbb, a CSS name or 3 numbers, got 'weiss'"),
        ({"background": 3}, "background: expected #rrggbb, a CSS name or 3 numbers, got 3"),
        ({"background": ("#fff", "x")}, "background: expected #rrggbb, a CSS name or 3 numbers, got 'x'"),
    ],
)
def test_wrong_pictures_are_refused(scene, arguments, message):
    with pytest.raises(bob.InputError, match=f"^{message}$"):
        bob.render(scene, **arguments)


def test_edges_are_where_pixels_are_not_the_mean_of_those_around():
    """Steps and lines, up to the picture's corners; not slopes, and not stale memory."""
    height, width = 7, 9
    slope = np.linspace(0, 1, width, dtype=np.float32)[None, :, None] ** 2 * np.ones((height, 1, 3), np.float32)
    inside = np.zeros((height, width), bool)
    inside[1:-1, 1:-1] = True
    step = np.zeros((height, width, 3), np.float32)
    step[:2, :3] = 0.5
    expected = np.zeros((height, width), bool)
    expected[:3, :4] = True
    expected[0, :2] = False
    line = np.zeros((height, width, 3), np.float32)
    line[-1] = 1
    for _ in range(20):
        dirty = [np.full(4 * (height + 2) * (width + 2), value, np.float32) for value in (np.nan, 1e30, -7)]
        del dirty  # its values stay in memory that is reused
        found = np.zeros((height, width), bool)
        found[tuple(_at_edges(slope, np.ones((height, width), np.float32)).T)] = True
        assert not (found & inside).any()
        found[:] = False
        found[tuple(_at_edges(step, np.ones((height, width), np.float32)).T)] = True
        assert (found == expected).all()
        found[:] = False
        found[tuple(_at_edges(line, np.ones((height, width), np.float32)).T)] = True
        assert found[-2:].all()
        assert not found[:-2].any()


def test_rays_of_a_pixel_are_no_larger_picture(monkeypatch):
    """A picture has the package's maximum of pixels, for any samples; in bands it is the same."""
    tree = bob.happy_tree()
    whole = [bob.render(tree, size=(48, 40), samples=samples) for samples in (4, 64)]
    monkeypatch.setattr("bobrossnet.picture.order.MAX_PIXELS", 48 * 40)
    monkeypatch.setattr("bobrossnet.pictures.rendering.BATCH", 7 * 64)
    for samples, picture in zip((4, 64), whole, strict=True):
        banded = bob.render(tree, size=(48, 40), samples=samples)
        np.testing.assert_array_equal(banded.color, picture.color)
        np.testing.assert_array_equal(banded.alpha, picture.alpha)


def test_what_samples_refuse_is_refused_before_the_first_ray():
    def progress(_):
        raise AssertionError

    with pytest.raises(bob.InputError, match=r"^size: expected at most 268,435,455 pixels a side with 64 samples"):
        bob.render(bob.happy_tree(), size=(1, 2**28), samples=64, progress=progress)
