"""Mitsuba scenes for measuring foreign tracers, from soft light to mirrors.

The constants of guided completion (core/completion/guided.cpp) were tuned on `TUNED`, in perspective. `HELD_OUT`
measures how they generalise, so no constant is ever tuned on it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from report import MODELS

SIZE = (360, 480)
DEPTH = 8
"""Maximum number of surfaces on a path."""

LOOKS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float], float]] = {
    "Cornell box": ((0, 0, 3.9), (0, 0, 0), 39.3),
    "interior": ((3.2, 1.6, 3.4), (-0.3, 0.75, -0.2), 50),
    "textured mesh": ((1.5, 2.6, 2.8), (0, 0, 0), 38),
    "metal": ((0, 1.3, 4.2), (0, 0.1, 0), 36),
    "still life": ((0.3, 1.5, 4.2), (0, 0.55, 0), 34),
    "plastic and metal": ((2.2, 2.7, 4.4), (0, 0.1, 0), 40),
    "rods": ((1.6, 1.9, 4.6), (0, 0.75, 0), 36),
    "scans": ((0.4, 1.6, 3.4), (0, 0.42, 0), 32),
}
"""Position, target, and horizontal field of view in degrees of each camera."""


def scene(name: str, *, orthographic: bool = False, size: tuple[int, int] = SIZE) -> Any:
    """Return a scene in Mitsuba's current variant, in perspective or by parallel rays over about the same width."""
    import mitsuba as mi

    position, target, fov = LOOKS[name]
    place = mi.ScalarTransform4f().look_at(origin=position, target=target, up=(0, 1, 0))
    sensor: dict[str, Any] = {"type": "perspective", "fov": fov, "fov_axis": "x"}
    if orthographic:
        half = float(np.linalg.norm(np.subtract(position, target)) * np.tan(np.radians(fov / 2)))
        sensor, place = {"type": "orthographic"}, place @ mi.ScalarTransform4f().scale([half, half, 1])
    film = {"type": "hdrfilm", "width": size[1], "height": size[0], "rfilter": {"type": "box"}}
    made = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": DEPTH},
        "sensor": {**sensor, "to_world": place, "film": film},
        **CONTENTS[name](),
    }
    return mi.load_dict(made)


def cornell_box() -> dict[str, Any]:
    """Mitsuba's Cornell box, with a ball of glass and one of metal instead of its boxes."""
    import mitsuba as mi

    box = mi.cornell_box()
    kept = {name: box[name] for name in box if name not in ("type", "integrator", "sensor", "small-box", "large-box")}
    return {
        **kept,
        "glass": {**ball((0.35, -0.66, 0.35), 0.34), "bsdf": {"type": "dielectric"}},
        "metal": {
            **ball((-0.4, -0.6, -0.25), 0.4),
            "bsdf": {"type": "roughconductor", "material": "Au", "alpha": 0.15},
        },
    }


def interior() -> dict[str, Any]:
    """A room of glossy floor, lacquer and plastic, lit by a window and a lamp."""
    wall = {"type": "diffuse", "reflectance": rgb(0.75, 0.72, 0.66)}
    wood = {"type": "roughplastic", "diffuse_reflectance": rgb(0.35, 0.18, 0.08), "alpha": 0.1}
    return {
        "floor": {**sheet((0, 0, 0), (5, 5), "up"), "bsdf": {
            "type": "roughplastic", "alpha": 0.08, "diffuse_reflectance": {
                "type": "checkerboard", "color0": rgb(0.45, 0.3, 0.2), "color1": rgb(0.6, 0.52, 0.42),
                "to_uv": scaled_uv(8, 8)}}},
        "back": {**sheet((0, 1.5, -2.5), (5, 3), "front"), "bsdf": wall},
        "left": {**sheet((-2.5, 1.5, 0), (5, 3), "right"), "bsdf": wall},
        "ceiling": {**sheet((0, 3, 0), (5, 5), "down"), "bsdf": wall},
        "window": {**sheet((-2.49, 1.7, -0.6), (0.8, 0.6), "right"),
                   "emitter": {"type": "area", "radiance": rgb(11, 13, 16)}},
        "lamp": {**ball((0.9, 2.3, -1.2), 0.15), "emitter": {"type": "area", "radiance": rgb(45, 34, 20)}},
        "table": {**block((0.1, 0.68, -0.5), (0.9, 0.04, 0.6)), "bsdf": wood},
        **{f"leg {i}": {**block((0.1 + x, 0.33, -0.5 + z), (0.04, 0.33, 0.04)), "bsdf": wood}
           for i, (x, z) in enumerate([(-0.8, -0.5), (0.8, -0.5), (-0.8, 0.5), (0.8, 0.5)])},
        "lacquer": {**ball((-0.35, 0.97, -0.45), 0.25), "bsdf": {
            "type": "plastic", "diffuse_reflectance": rgb(0.6, 0.03, 0.03)}},
        "vase": {"type": "cylinder", "p0": [0.4, 0.72, -0.7], "p1": [0.4, 1.2, -0.7], "radius": 0.12, "bsdf": {
            "type": "twosided", "bsdf": {"type": "roughconductor", "material": "Cu", "alpha": 0.12}}},
        "cube": {**block((-1.5, 0.35, 0.9), (0.35, 0.35, 0.35)), "bsdf": {
            "type": "roughplastic", "diffuse_reflectance": rgb(0.1, 0.25, 0.5), "alpha": 0.2}},
        "mirror": {**sheet((0.9, 1.6, -2.48), (0.5, 0.7), "front"), "bsdf": {
            "type": "conductor", "material": "Ag"}},
    }  # fmt: skip


def textured_mesh() -> dict[str, Any]:
    """A knot of 40,000 triangles with tiles of random colours, under a lamp and a dim sky."""
    import mitsuba as mi

    rng = np.random.default_rng(0)
    tiles = rng.uniform(0.05, 0.85, (8, 64, 3)).astype(np.float32).repeat(16, 0).repeat(16, 1)
    row, column = np.indices(tiles.shape[:2]) % 16
    tiles[(row < 2) | (column < 2)] = 0.8
    material = mi.load_dict({
        "type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {
            "type": "bitmap", "bitmap": mi.Bitmap(tiles), "raw": True}}})  # fmt: skip
    vertices, uv, faces = knot(800, 25)
    mesh = mi.Mesh("knot", len(vertices), len(faces), has_vertex_texcoords=True, props=with_bsdf(material))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = vertices.ravel()
    parameters["vertex_texcoords"] = uv.ravel()
    parameters["faces"] = faces.ravel()
    parameters.update()
    return {
        "knot": mesh,
        "ground": {**sheet((0, -0.75, 0), (8, 8), "up"), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "checkerboard", "color0": rgb(0.3, 0.35, 0.4),
                                               "color1": rgb(0.55, 0.5, 0.45), "to_uv": scaled_uv(12, 12)}}},
        "sky": {"type": "constant", "radiance": rgb(0.35, 0.42, 0.5)},
        "lamp": {**ball((2, 3.5, 1.5), 0.35), "emitter": {"type": "area", "radiance": rgb(38, 34, 28)}},
    }  # fmt: skip


def metal() -> dict[str, Any]:
    """Balls of metal from polished to rough, lit by visible surroundings alone."""
    import mitsuba as mi

    row, column = np.indices((256, 512))
    up, around = row / 256, column / 512 * 2 * np.pi
    sky = np.stack([0.35 + 0.5 * up, 0.5 + 0.35 * up, 0.95 - 0.1 * up], -1) * (up < 0.5)[..., None]
    ground = np.stack([0.28 + 0 * up, 0.24 + 0 * up, 0.2 + 0 * up], -1) * (up >= 0.5)[..., None]
    picture = (sky + ground) * (0.8 + 0.2 * np.sin(9 * around))[..., None]
    for where, strength, width in ((1.2, 40, 0.12), (3.9, 12, 0.3), (5.2, 25, 0.08)):
        turned = np.abs((around - where + np.pi) % (2 * np.pi) - np.pi)
        picture += strength * np.exp(-((turned / width) ** 2) - ((up - 0.3) / 0.06) ** 2)[..., None]
    surroundings = mi.Bitmap(picture.astype(np.float32))
    kinds = [("Au", 0.02), ("Cu", 0.1), ("Al", 0.2), ("Cr", 0.35)]
    balls = {
        f"ball {i}": {**ball((1.1 * (i - 1.5), 0, 0.3 * (i % 2)), 0.5), "bsdf": {
            "type": "roughconductor", "material": name, "alpha": alpha}}
        for i, (name, alpha) in enumerate(kinds)
    }  # fmt: skip
    return {
        **balls,
        "ground": {**sheet((0, -0.5, 0), (2.6, 1.6), "up"), "bsdf": {
            "type": "roughconductor", "material": "Ag", "alpha": 0.3}},
        "surroundings": {"type": "envmap", "bitmap": surroundings},
    }  # fmt: skip


def still_life() -> dict[str, Any]:
    """Glass in front of diffuse bodies on a table, with a brick wall behind, and one lamp."""
    import mitsuba as mi

    rng = np.random.default_rng(1)
    bricks = (rng.uniform(0.25, 0.6, (12, 12, 1)) * (1, 0.55, 0.4)).astype(np.float32)
    wall = bricks.repeat(24, 0).repeat(48, 1)
    wall[:: 2 * 24] *= 0.9
    row, column = np.indices(wall.shape[:2])
    shifted = column + 24 * (row // 24 % 2)
    wall[(row % 24 < 2) | (shifted % 48 < 2)] = 0.7
    wall *= rng.uniform(0.85, 1, wall.shape[:2]).astype(np.float32)[..., None]
    return {
        "table": {**sheet((0, 0, 0), (6, 5), "up"), "bsdf": diffuse(0.5, 0.42, 0.33)},
        "wall": {**sheet((0, 2, -1.6), (6, 4), "front"), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": mi.Bitmap(wall), "raw": True}}},
        "glass": {**ball((0.45, 0.4, 0.7), 0.4), "bsdf": {"type": "dielectric"}},
        "small glass": {**ball((-0.35, 0.2, 1.1), 0.2), "bsdf": {"type": "dielectric", "int_ior": 1.7}},
        "pane": {**block((-0.9, 0.55, 0.3), (0.02, 0.55, 0.5)), "bsdf": {"type": "thindielectric"}},
        "orange": {**ball((-0.25, 0.35, 0), 0.35), "bsdf": diffuse(0.85, 0.4, 0.06)},
        "lime": {**ball((0.95, 0.28, -0.2), 0.28), "bsdf": diffuse(0.35, 0.6, 0.08)},
        "box": {**block((-0.95, 0.45, -0.6), (0.3, 0.45, 0.3)), "bsdf": diffuse(0.15, 0.3, 0.6)},
        "can": {"type": "cylinder", "p0": [0.35, 0, -0.7], "p1": [0.35, 0.9, -0.7], "radius": 0.25, "bsdf": {
            "type": "twosided", "bsdf": diffuse(0.7, 0.68, 0.62)}},
        "lamp": {**sheet((0.8, 3.2, 1), (1.4, 1), "down"), "emitter": {"type": "area", "radiance": rgb(16, 14.5, 12)}},
    }  # fmt: skip


def plastic_and_metal() -> dict[str, Any]:
    """Rows of balls and cubes, alternately of rough metal and of plastic, on tiles under a sky with a sun."""
    import mitsuba as mi

    up, around = (np.indices((128, 256)).astype(np.float32).T / (128, 256)).T
    picture = np.stack([0.2 + 0.2 * up, 0.3 + 0.15 * up, 0.6 - 0.1 * up], -1) * (up < 0.5)[..., None] + 0.08
    picture += 60 * np.exp(-(((around - 0.3) / 0.02) ** 2) - ((up - 0.22) / 0.03) ** 2)[..., None]
    rng = np.random.default_rng(2)
    tiles = rng.uniform(0.1, 0.7, (10, 10, 3)).astype(np.float32).repeat(24, 0).repeat(24, 1)
    bodies = {}
    for i in range(4):
        for j in range(4):
            place, half = (0.85 * (i - 1.5), 0.3, 0.85 * (j - 1.5)), 0.3
            body = ball(place, half) if (i // 2 + j) % 2 else block(place, (0.8 * half, half, 0.8 * half))
            hue = [float(value) for value in rng.uniform(0.05, 0.8, 3)]
            metal = {"type": "roughconductor", "material": ("Au", "Cu", "Al", "Cr")[i], "alpha": 0.08 + 0.07 * j}
            plastic = {"type": "plastic" if j % 2 else "roughplastic", "diffuse_reflectance": rgb(*hue)}
            bodies[f"body {i} {j}"] = {**body, "bsdf": metal if (i + j) % 2 else plastic}
    return {
        **bodies,
        "ground": {**sheet((0, 0, 0), (6, 6), "up"), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": mi.Bitmap(tiles), "raw": True}}},
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(picture.astype(np.float32))},
    }  # fmt: skip


def rods() -> dict[str, Any]:
    """A cage of thin white rods in a corner of coloured walls, with colour bleeding."""
    made = {}
    for i in range(9):
        for j in range(9):
            x, z = 0.25 * (i - 4), 0.25 * (j - 4)
            made[f"upright {i} {j}"] = {"p0": [x, 0, z], "p1": [x, 1.4, z]}
    for k in range(4):
        for i in range(9):
            at, height = 0.25 * (i - 4), 0.35 * (k + 1)
            made[f"along {k} {i}"] = {"p0": [-1.05, height, at], "p1": [1.05, height, at]}
            made[f"across {k} {i}"] = {"p0": [at, height - 0.03, -1.05], "p1": [at, height - 0.03, 1.05]}
    white = {"type": "twosided", "bsdf": diffuse(0.8, 0.8, 0.8)}
    return {
        **{name: {"type": "cylinder", **ends, "radius": 0.018, "bsdf": white} for name, ends in made.items()},
        "floor": {**sheet((0, 0, 0), (4, 4), "up"), "bsdf": diffuse(0.6, 0.6, 0.55)},
        "red": {**sheet((-1.6, 1.5, 0), (4, 3), "right"), "bsdf": diffuse(0.7, 0.06, 0.05)},
        "green": {**sheet((0, 1.5, -1.6), (4, 3), "front"), "bsdf": diffuse(0.08, 0.5, 0.1)},
        "lamp": {**ball((1.2, 2.6, 1), 0.25), "emitter": {"type": "area", "radiance": rgb(40, 38, 34)}},
        "sky": {"type": "constant", "radiance": rgb(0.25, 0.3, 0.38)},
    }


def scans() -> dict[str, Any]:
    """Scans: a rabbit of plastic, a cat of stone and a banana with photographic texture, on a cloth."""
    import mitsuba as mi

    def placed(file: str, size: float, at: tuple[float, float, float], turn: float, tilt: float = 0) -> dict[str, Any]:
        """Return a file's mesh, scaled, turned upright and rotated about the vertical."""
        place = mi.ScalarTransform4f().translate(list(at)).rotate([0, 1, 0], turn).scale(size).rotate([1, 0, 0], tilt)
        return {"type": file.rpartition(".")[2], "filename": str(MODELS / file), "to_world": place}

    row, column = np.indices((480, 480))
    cloth = np.where(((row // 20 + column // 20) % 2)[..., None], (0.5, 0.12, 0.1), 0.65).astype(np.float32)
    photographs = {"type": "bitmap", "filename": str(MODELS / "textured" / "ycb_banana" / "texture_map.png")}
    return {
        "rabbit": {**placed("scans/stanford_bunny.ply", 6, (-0.35, -0.2, -0.1), 20), "bsdf": {
            "type": "roughplastic", "diffuse_reflectance": rgb(0.55, 0.4, 0.3), "alpha": 0.2}},
        "cat": {**placed("scans/egyptian_cat_statue.ply", 0.5, (0.62, 0.5, -0.3), -35), "bsdf": {
            "type": "twosided", "bsdf": diffuse(0.25, 0.24, 0.28)}},
        "banana": {**placed("textured/ycb_banana/textured_simple_reoriented.obj", 5, (0.05, 0.03, 0.75), 15, -90),
                   "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": photographs}}},
        "cloth": {**sheet((0, 0, 0), (8, 8), "up"), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "bitmap", "bitmap": mi.Bitmap(cloth), "raw": True}}},
        "window": {**sheet((-2.2, 1.6, 0.6), (1.6, 1.6), "right"), "emitter": {
            "type": "area", "radiance": rgb(7, 7.5, 8)}},
        "sky": {"type": "constant", "radiance": rgb(0.3, 0.28, 0.25)},
    }  # fmt: skip


CONTENTS = {
    "Cornell box": cornell_box,
    "interior": interior,
    "textured mesh": textured_mesh,
    "metal": metal,
    "still life": still_life,
    "plastic and metal": plastic_and_metal,
    "rods": rods,
    "scans": scans,
}

TUNED = ("Cornell box", "interior", "textured mesh", "metal")
HELD_OUT = tuple(name for name in CONTENTS if name not in TUNED)


def diffuse(red: float, green: float, blue: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": rgb(red, green, blue)}


def rgb(red: float, green: float, blue: float) -> dict[str, Any]:
    return {"type": "rgb", "value": [red, green, blue]}


def ball(center: tuple[float, float, float], radius: float) -> dict[str, Any]:
    return {"type": "sphere", "center": list(center), "radius": radius}


def block(center: tuple[float, float, float], half: tuple[float, float, float]) -> dict[str, Any]:
    import mitsuba as mi

    return {"type": "cube", "to_world": mi.ScalarTransform4f().translate(list(center)).scale(list(half))}


def sheet(center: tuple[float, float, float], size: tuple[float, float], faces: str) -> dict[str, Any]:
    """Return a rectangle facing up, down, front (z) or right (x)."""
    import mitsuba as mi

    turns = {"up": ([1, 0, 0], -90), "down": ([1, 0, 0], 90), "front": ([1, 0, 0], 0), "right": ([0, 1, 0], 90)}
    axis, angle = turns[faces]
    place = mi.ScalarTransform4f().translate(list(center)).rotate(axis, angle).scale([size[0] / 2, size[1] / 2, 1])
    return {"type": "rectangle", "to_world": place}


def scaled_uv(across: float, down: float) -> Any:
    import mitsuba as mi

    return mi.ScalarTransform3f().scale([across, down])


def with_bsdf(bsdf: Any) -> Any:
    import mitsuba as mi

    properties = mi.Properties()
    properties["mesh_bsdf"] = bsdf
    return properties


def knot(along: int, across: int) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.uint32]]:
    """Return a trefoil's vertices, texture coordinates and triangles, with vertices duplicated along seams."""
    t, s = np.meshgrid(np.linspace(0, 1, along + 1), np.linspace(0, 1, across + 1), indexing="ij")
    angle = 2 * np.pi * t

    def course(a: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([np.sin(a) + 2 * np.sin(2 * a), 0.9 * np.sin(3 * a), np.cos(a) - 2 * np.cos(2 * a)], -1) / 3

    forward = course(angle + 1e-4) - course(angle - 1e-4)
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    side = np.cross(forward, (0, 1, 0.3))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    above = np.cross(side, forward)
    turn = 2 * np.pi * s[..., None]
    vertices = course(angle) + 0.2 * (np.cos(turn) * side + np.sin(turn) * above)
    corner = (np.arange(along)[:, None] * (across + 1) + np.arange(across)).ravel()
    faces = np.concatenate([
        np.stack([corner, corner + across + 1, corner + 1], -1),
        np.stack([corner + 1, corner + across + 1, corner + across + 2], -1),
    ])  # fmt: skip
    uv = np.stack([t, s], -1)
    return vertices.reshape(-1, 3).astype(np.float32), uv.reshape(-1, 2).astype(np.float32), faces.astype(np.uint32)
