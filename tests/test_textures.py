"""Textures compared with Mitsuba's: the same mesh, coordinates and picture, sampled by the same rays."""

import numpy as np
import pytest

import bobrossnet as bob

mi = pytest.importorskip("mitsuba", reason="Mitsuba, whose textures these are compared with, is not installed")

SIZE = HEIGHT, WIDTH = (90, 120)
CAMERA = bob.Camera(position=(0.4, -2.5, 1.9), target=(0, 0, 0.1), fov=40)
ROUNDING = 2 / 255


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("scalar_rgb")


def hill(columns=24, rows=20, tiles=1.0):
    """Return a wavy sheet, from -1 to 1: vertices, triangles, texture coordinates."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1), indexing="ij")
    points = np.stack([2 * u - 1, 1 - 2 * v, 0.2 * np.sin(5 * u) * np.cos(4 * v)], axis=-1).reshape(-1, 3)
    index = np.arange(len(points)).reshape(columns + 1, rows + 1)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate([np.stack([a, d, b], -1).reshape(-1, 3), np.stack([b, d, c], -1).reshape(-1, 3)])
    bent = np.stack([u + 0.1 * np.sin(3 * v), v + 0.1 * u * u], axis=-1).reshape(-1, 2)
    return points, triangles, tiles * bent - (0.3 if tiles > 1 else 0)


def in_mitsuba(points, triangles, uv, texels, wrap):
    """Return the sheet as a Mitsuba scene."""
    properties = mi.Properties()
    bitmap = {"type": "bitmap", "bitmap": mi.Bitmap(texels), "filter_type": "bilinear", "wrap_mode": wrap}
    properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": bitmap})
    mesh = mi.Mesh("sheet", len(points), len(triangles), has_vertex_texcoords=True, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = points.astype(np.float32).ravel()
    parameters["faces"] = triangles.astype(np.uint32).ravel()
    parameters["vertex_texcoords"] = uv.astype(np.float32).ravel()
    parameters.update()
    return mi.load_dict({"type": "scene", "mesh": mesh})


def albedo_of(scene, times=1):
    """Return albedo at the pixel centres of a picture with `times` the rows and columns, (H, W, 3), NaN outside."""
    height, width = times * HEIGHT, times * WIDTH
    position = np.array(CAMERA.position)
    forward = np.array(CAMERA.target) - position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    slope = np.tan(np.radians(CAMERA.fov) / 2)
    found = np.full((height, width, 3), np.nan)
    for row, column in np.ndindex(height, width):
        across, along = (2 * column + 1 - width) / height * slope, (height - 2 * row - 1) / height * slope
        direction = forward + across * right + along * up
        hit = scene.ray_intersect(mi.Ray3f(position.tolist(), (direction / np.linalg.norm(direction)).tolist()))
        if hit.is_valid():
            found[row, column] = hit.bsdf().eval_diffuse_reflectance(hit)
    return found


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
def test_magnified_textures_are_mitsubas(wrap):
    """The mean, and all except a few pixels, where a ray passes an edge."""
    points, triangles, uv = hill(tiles=3)
    texels = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
    seen = bob.trace(bob.Mesh(points, triangles, uv=uv, texture=texels, wrap=wrap), CAMERA, size=SIZE)
    expected = albedo_of(in_mitsuba(points, triangles, uv, texels, wrap))
    both = (seen.alpha > 0) & np.isfinite(expected[..., 0])
    assert both.mean() > 0.3
    assert (both == (seen.alpha > 0)).mean() > 0.999
    difference = np.abs(seen.albedo - expected).max(axis=-1)[both]
    assert difference.mean() < ROUNDING / 10
    assert np.quantile(difference, 0.999) < ROUNDING


def test_minified_textures_are_means_over_pixels():
    """The mean of 6 x 6 of Mitsuba's rays in each pixel, and nearer to it than single rays are."""
    points, triangles, uv = hill()
    rng = np.random.default_rng(1)
    tiles = rng.integers(30, 250, (60, 60, 3), np.uint8).repeat(8, axis=0).repeat(8, axis=1)
    texels = np.clip(tiles + rng.integers(-30, 30, tiles.shape), 0, 255).astype(np.uint8)
    made = bob.Mesh(points, triangles, uv=uv, texture=texels, wrap="clamp")
    seen = bob.trace(made, CAMERA, size=SIZE)
    scene = in_mitsuba(points, triangles, uv, texels, "clamp")
    mean = albedo_of(scene, 6).reshape(HEIGHT, 6, WIDTH, 6, 3).mean(axis=(1, 3))
    one = albedo_of(scene)
    inside = np.isfinite(mean[..., 0]) & (seen.alpha > 0)
    assert inside.mean() > 0.3
    errors = [np.abs(found - mean)[inside].mean() for found in (seen.albedo, one)]
    assert errors[0] < 0.03
    assert errors[0] < 0.6 * errors[1]
    biases = (seen.albedo - mean)[inside].mean(axis=0)
    assert np.abs(biases).max() < 0.005
