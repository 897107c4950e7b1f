"""Scenes under lights, for Mitsuba 3 and for this package. As a script, it makes the reference picture by Mitsuba:

python tests/light_of_mitsuba.py
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

import bobrossnet as bob
from bobrossnet.color import to_srgb
from bobrossnet.tracing.lit import LitTracer
from bobrossnet.tracing.pixels import tiled_pixels

SIZE = (48, 64)

COLUMNS = 4
"""Of the reference picture, whose tiles are the cases in their order, as sRGB of 8 bits."""

REFERENCE = Path(__file__).parent / "cases" / "light" / "mitsuba.png"
REFERENCE_PATHS = 2**14

FAR = 1e4
"""Distance of a lamp that replaces a disc at infinity: directions differ by less than 1/1000 over a scene."""


@dataclass(frozen=True)
class Thing:
    """A shape of unit size with a material, in both tracers."""

    shape: str
    """One of `SHAPES`."""
    place: tuple[float, float, float]
    material: bob.Material
    bsdf: dict[str, Any]
    size: float = 1.0
    turn: float = 0.0
    """Degrees about z."""
    medium: dict[str, Any] | None = None


@dataclass(frozen=True)
class Case:
    things: list[Thing]
    lights: list[bob.Light | bob.Sky]
    bounces: int = 2
    """Surfaces of a path, except mirrors."""
    paths: int = 256
    """Of a pixel of ours."""


def shape(name: str) -> Any:
    if name == "ball":
        return bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1, bounds=((-1, -1, -1), (1, 1, 1)))
    return bob.Mesh(*MESHES[name])


def floor() -> tuple[Any, ...]:
    return [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2), (0, 2, 3)]


def block() -> tuple[Any, ...]:
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return [corners[i] for side in sides for i in side], [
        (4 * k + a, 4 * k + b, 4 * k + c) for k in range(6) for a, b, c in ((0, 1, 2), (0, 2, 3))
    ]


def ring() -> tuple[Any, ...]:
    """A torus with given normals."""
    around, across = 96, 48
    a, b = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    normals = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], -1).reshape(-1, 3)
    centers = np.stack([np.cos(a), np.sin(a), 0 * a], -1).reshape(-1, 3)
    i, j = np.indices((around, across)).reshape(2, -1)

    def corner(di: int, dj: int) -> Any:
        return (i + di) % around * across + (j + dj) % across

    faces = np.concatenate([np.stack([corner(0, 0), corner(1, 0), corner(1, 1)], -1),
                            np.stack([corner(0, 0), corner(1, 1), corner(0, 1)], -1)])  # fmt: skip
    return 0.68 * centers + 0.32 * normals, faces, normals


MESHES = {"floor": floor(), "block": block(), "ring": ring()}


# ---- Materials -------------------------------------------------------------------------------------------


def rgb(color: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(c) for c in color]}


def matt(*color: float) -> dict[str, Any]:
    return {
        "material": bob.Material(color, ambient=0, diffuse=1, specular=0),
        "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(color)}},
    }


def metal(roughness: float, *color: float) -> dict[str, Any]:
    """Metals have the same facets and Schlick's Fresnel in both."""
    bsdf = {"type": "principled", "base_color": rgb(color), "metallic": 1.0, "roughness": roughness}
    return {"material": bob.Material(color, metallic=1, roughness=roughness), "bsdf": bsdf}


def gloss(roughness: float) -> dict[str, Any]:
    """The highlight of a black body: facets whose Fresnel reflectance is Schlick's, 4 % from the front."""
    bsdf = metal(roughness, 0.04, 0.04, 0.04)["bsdf"]
    return {"material": bob.Material("#000", metallic=0, roughness=roughness), "bsdf": bsdf}


def glass(ior: float = 1.5, roughness: float = 0, attenuation: tuple[float, ...] | None = None) -> dict[str, Any]:
    bsdf: dict[str, Any] = {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    if roughness:
        bsdf |= {"type": "roughdielectric", "alpha": roughness**2, "distribution": "ggx"}
    if attenuation is None:
        return {"material": bob.Glass(ior=ior, roughness=roughness), "bsdf": bsdf}
    density = -np.log(attenuation)
    medium = {"type": "homogeneous", "albedo": 0.0, "sigma_t": rgb(density / density.max()), "scale": density.max()}
    return {"material": bob.Glass(ior=ior, attenuation=attenuation, distance=1.0), "bsdf": bsdf, "medium": medium}


def pane(*color: float) -> dict[str, Any]:
    bsdf = {"type": "thindielectric", "int_ior": 1.5, "ext_ior": 1.0, "specular_transmittance": rgb(color)}
    return {"material": bob.Glass(thin=True, color=color), "bsdf": bsdf}


# ---- Cases -----------------------------------------------------------------------------------------------


def environment() -> Any:
    """A landscape with a window and a small lamp, without symmetry."""
    row, column = np.indices((256, 512)) + 0.5
    up, around = row / 256, column / 256 * np.pi
    sky = np.stack([0.2 + 0.3 * up, 0.3 + 0.2 * up, 0.65 - 0.1 * up], -1)
    texels = np.where(up[..., None] < 0.5, sky, (0.22, 0.17, 0.12)) * (1 + 0.5 * np.sin(around))[..., None]
    for where, height, color, width in ((1.2, 0.3, (3, 2.2, 1.2), 0.4), (4.4, 0.22, (0.7, 1.4, 2.8), 0.5)):
        turned = np.abs((around - where + np.pi) % (2 * np.pi) - np.pi)
        texels += np.exp(-((turned / width) ** 2) - (np.pi * (up - height) / width) ** 2)[..., None] * color
    return texels.astype(np.float32)


ON_FLOOR = [
    Thing("floor", (0, 0, 0), **matt(0.6, 0.55, 0.5), size=30),
    Thing("ball", (-1.1, 0.2, 0.9), **matt(0.8, 0.2, 0.1), size=0.9),
    Thing("block", (1.1, 0.5, 0.6), **matt(0.3, 0.5, 0.7), size=0.6, turn=25),
    Thing("ring", (0.3, -1.3, 0.26), **matt(0.7, 0.7, 0.3), size=0.8),
]
IN_THE_AIR = [*ON_FLOOR[1:], Thing("block", (0.3, 0.6, -0.7), **matt(0.6, 0.6, 0.6), size=0.7, turn=10)]
KEY = bob.Light((1, -0.7, 1.6), angle=24, color=(1, 0.9, 0.8))
SUN = bob.Light((-1, -1.5, 1.2), angle=0.5, color=(0.9, 0.8, 0.6))


def balls(*looks: dict[str, Any], shape: str = "ball") -> list[Thing]:
    return [Thing(shape, (1.35 * (i - 1), 0.4 - 0.6 * (i % 2), 0.62), **look, size=0.6) for i, look in enumerate(looks)]


GOLD = (0.95, 0.7, 0.35)
CASES = {
    "key light": Case(ON_FLOOR, [KEY]),
    "sun and sky": Case(ON_FLOOR, [SUN, bob.Sky((0.25, 0.35, 0.5))], bounces=3),
    "sky": Case(ON_FLOOR, [bob.Sky((0.8, 0.9, 1.0))]),
    "two colours": Case(IN_THE_AIR, [bob.Sky((0.5, 0.7, 1.0), (0.6, 0.3, 0.1))]),
    "environment": Case(IN_THE_AIR, [bob.Sky(image=environment(), turn=130, intensity=0.8)]),
    "metal": Case(
        [ON_FLOOR[0], *balls(metal(0.15, *GOLD), metal(0.25, *GOLD), metal(0.35, 0.9, 0.9, 0.9))],
        [bob.Sky(image=environment(), turn=-60)], bounces=4, paths=160,
    ),
    "gloss": Case(
        [*balls(gloss(0.2), gloss(0.4), gloss(0.7)), Thing("ring", (0, -1.6, 0.1), **gloss(0.3), size=0.7)],
        [bob.Sky(image=environment(), turn=-60)], bounces=4,
    ),
    "highlights": Case(
        [*balls(metal(0.2, *GOLD), metal(0.35, *GOLD), gloss(0.4)),
         Thing("ring", (0, -1.6, 0.1), **gloss(0.6), size=0.7)],
        [KEY], paths=1024,
    ),
    "mirrors": Case(
        [ON_FLOOR[0], *balls(metal(0, 1, 1, 1), metal(0, *GOLD), matt(0.2, 0.6, 0.3)),
         Thing("block", (0.2, 1.6, 0.9), **metal(0, 0.8, 0.8, 0.8), size=0.9, turn=30)],
        [bob.Sky(image=environment(), turn=-60)], bounces=8, paths=160,
    ),
    "glass": Case(
        [ON_FLOOR[0], *balls(glass(), matt(0.8, 0.3, 0.2), glass(2.4)),
         Thing("block", (0.2, 1.6, 0.72), **glass(1.33, attenuation=(0.3, 0.7, 0.5)), size=0.7, turn=30)],
        [bob.Sky(image=environment(), turn=-60)], bounces=8,
    ),
    "rough glass": Case(
        [ON_FLOOR[0], *balls(glass(1.5, 0.4), matt(0.8, 0.3, 0.2), glass(1.5, 0.6))],
        [bob.Sky((0.5, 0.7, 1.0), (0.6, 0.3, 0.1))], bounces=8,
    ),
    "panes": Case(
        [ON_FLOOR[0], *balls(matt(0.8, 0.8, 0.8), matt(0.8, 0.3, 0.2), metal(0.3, *GOLD)),
         Thing("block", (-1.35, 0.4, 0.72), **pane(0.6, 0.9, 1.0), size=0.7, turn=15),
         Thing("block", (1.35, 0.4, 0.72), **pane(1.0, 1.0, 1.0), size=0.7)],
        [bob.Sky(image=environment(), turn=-60)], bounces=8, paths=512,
    ),
}  # fmt: skip

POSITION, TARGET, FOV = (0.4, -7.0, 4.6), (0.1, 0.0, 0.45), 30.0


# ---- Both tracers ----------------------------------------------------------------------------------------


CAMERA = bob.Camera(position=POSITION, target=TARGET, fov=FOV)


def of_ours(case: Case) -> bob.Scene:
    return bob.Scene([
        bob.Instance(shape(thing.shape), material=thing.material)
        .scale(thing.size).rotate(math.radians(thing.turn), (0, 0, 1)).translate(thing.place)
        for thing in case.things
    ])  # fmt: skip


def shown_by_ours(case: Case) -> tuple[Any, Any]:
    """Return sRGB in 0..1, (H, W, 3), and the pixels to compare: those without background in or next to them."""
    scene = of_ours(case)
    tracer = LitTracer(scene, CAMERA, SIZE, case.lights, paths=case.paths, bounces=case.bounces, apart=True)
    pixels = tiled_pixels(SIZE)
    samples = tracer(pixels)
    color = np.zeros((*SIZE, 3), np.float32)
    color[tuple(pixels.T)] = samples.color
    hit = np.pad(bob.trace(scene, CAMERA, size=SIZE).alpha > 0, 1, mode="edge")
    inner = np.all([hit[i : i + SIZE[0], j : j + SIZE[1]] for i in range(3) for j in range(3)], axis=0)
    return to_srgb(color), inner


def of_mitsuba(case: Case, size: tuple[int, int] = SIZE) -> Any:
    """Return the case as a scene of Mitsuba's current variant."""
    import mitsuba as mi

    turned = mi.ScalarTransform4f()
    film = {"type": "hdrfilm", "width": size[1], "height": size[0], "rfilter": {"type": "box"}}
    place = turned.look_at(origin=POSITION, target=TARGET, up=(0, 0, 1))
    has_media = any(thing.medium for thing in case.things)
    sees_through = any("dielectric" in thing.bsdf["type"] or thing.bsdf.get("roughness") == 0 for thing in case.things)
    depth = 64 if sees_through else case.bounces + 1
    made = {
        "type": "scene",
        "integrator": {"type": "volpath" if has_media else "path", "max_depth": depth, "rr_depth": 100},
        "sensor": {"type": "perspective", "fov": FOV, "fov_axis": "y", "to_world": place, "film": film},
    }
    for i, thing in enumerate(case.things):
        own = turned.translate(list(thing.place)).rotate([0, 0, 1], thing.turn).scale(thing.size)
        look = {"bsdf": thing.bsdf} | ({"interior": thing.medium} if thing.medium else {})
        if thing.shape == "ball":
            made[f"thing {i}"] = {"type": "sphere", "to_world": own, **look}
        else:
            made[f"thing {i}"] = mesh(thing.shape, own, look)
    for i, light in enumerate(case.lights):
        made[f"light {i}"] = lamp(light) if isinstance(light, bob.Light) else sky(light)
    return mi.load_dict(made)


def mesh(name: str, place: Any, look: dict[str, Any]) -> Any:
    import mitsuba as mi

    vertices, faces, *normals = (np.asarray(values) for values in MESHES[name])
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(look["bsdf"])
    if "interior" in look:
        properties["interior"] = mi.load_dict(look["interior"])
    made = mi.Mesh(name, len(vertices), len(faces), has_vertex_normals=bool(normals), props=properties)
    matrix = np.array(place.matrix)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = (vertices @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    if normals:
        turned = normals[0] @ np.linalg.inv(matrix[:3, :3])
        turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
        parameters["vertex_normals"] = turned.astype(np.float32).ravel()
    parameters.update()
    return made


def lamp(light: bob.Light) -> dict[str, Any]:
    """A disc of the light's angle, far away. Its radiance is the colour over sin^2 of half the angle."""
    import mitsuba as mi

    half = math.radians(light.angle / 2)
    radiance = np.array(light.color) * light.intensity / math.sin(half) ** 2
    at = [FAR * x for x in light.direction]
    place = mi.ScalarTransform4f().look_at(origin=at, target=(0, 0, 0), up=(0.3, 0.9, 0.1)).scale(FAR * math.tan(half))
    return {"type": "disk", "to_world": place, "emitter": {"type": "area", "radiance": rgb(radiance)}}


def sky(light: bob.Sky) -> dict[str, Any]:
    """Mitsuba's environments have y up, and their middle at z; ours have z up, and their middle at -x."""
    import mitsuba as mi

    if light.image is None and light.top == light.bottom:
        return {"type": "constant", "radiance": rgb(np.array(light.top) * light.intensity)}
    if light.image is not None:
        texels = light.image * np.float32(light.intensity) * np.float32(light.top)
    else:
        share = 0.5 + 0.5 * np.cos((np.arange(512) + 0.5) * np.pi / 512)[:, None, None]
        texels = light.intensity * (share * np.array(light.top) + (1 - share) * np.array(light.bottom))
        texels = np.broadcast_to(texels, (512, 1024, 3))
    upright = [[0, 0, -1, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]
    place = mi.ScalarTransform4f().rotate([0, 0, 1], light.turn) @ mi.ScalarTransform4f(upright)
    bitmap = mi.Bitmap(np.ascontiguousarray(texels, np.float32))
    return {"type": "envmap", "bitmap": bitmap, "to_world": place}


def rendered_by_mitsuba(case: Case, paths: int, size: tuple[int, int] = SIZE) -> Any:
    """Return linear RGB, (H, W, 3)."""
    import mitsuba as mi

    return np.array(mi.render(of_mitsuba(case, size), spp=paths))[..., :3]


# ---- The reference ---------------------------------------------------------------------------------------


def tile(name: str) -> tuple[slice, slice]:
    """Return a case's rows and columns in the reference picture."""
    row, column = divmod(list(CASES).index(name), COLUMNS)
    height, width = SIZE
    return slice(row * height, (row + 1) * height), slice(column * width, (column + 1) * width)


def main() -> None:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    sheet = np.zeros((-(-len(CASES) // COLUMNS) * SIZE[0], COLUMNS * SIZE[1], 3), np.uint8)
    for name, case in CASES.items():
        shown = to_srgb(rendered_by_mitsuba(case, REFERENCE_PATHS))
        sheet[tile(name)] = np.rint(255 * shown)
        ours, inner = shown_by_ours(case)
        print(f"{name}: {255 * np.abs(ours - shown)[inner].mean():.2f} of 255", flush=True)
    REFERENCE.parent.mkdir(exist_ok=True)
    Image.fromarray(sheet).save(REFERENCE, optimize=True)


if __name__ == "__main__":
    main()
