"""Draws the gallery: every word of the modelling language, and models made with them. Writes docs/gallery.md with the
code of each picture, the sheets of pictures in docs/gallery, and the README's strips of them, docs/shapes.png and
docs/nurbs.png.

python docs/gallery.py
"""

from __future__ import annotations

import ast
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.picture.files import GAP, color_to_8_bit, side_by_side, to_8_bit, write_picture
from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.words import WORDS

ROOT = Path(__file__).parent.parent
SHEET_WIDTH = 984
HEIGHT_OF_FLAT_SHAPES = 0.3
SIDE = bob.Camera(azimuth=-60, elevation=30)
FRONT_FROM_ABOVE = bob.Camera(azimuth=-75, elevation=55)
ABOVE = bob.Camera(azimuth=-90, elevation=90)


@dataclass(frozen=True)
class Section:
    """Pictures of one sheet, `columns` in a row: the code of each by its caption.

    The value of the last line is drawn. All share `helpers`, lines of code listed before them.
    """

    title: str
    code: dict[str, str]
    note: str = ""
    columns: int = 6
    camera: bob.Camera = SIDE
    helpers: str = ""

    @property
    def sheet(self) -> str:
        return f"gallery/{self.title.lower().replace(' ', '_')}.png"


# ---- Drawn models ----------------------------------------------------------------------------------------

SOLIDS = {
    "sphere": "sphere(1)",
    "plane": "sphere(1) & plane((1, 0, 1))",
    "slab": "slab(x0=-1, x1=1, y0=-0.6, y1=0.6, z0=-0.4, z1=0.4, k=0.2)",
    "box": "box((1.6, 1.2, 0.8))",
    "rounded_box": "rounded_box((1.6, 1.2, 0.8), 0.2)",
    "wireframe_box": "wireframe_box((1.6, 1.2, 0.8), 0.1)",
    "torus": "torus(1, 0.35)",
    "capsule": "capsule(-X, X + Z, 0.4)",
    "cylinder": "cylinder(0.5) & slab(z0=-1, z1=1)",
    "capped_cylinder": "capped_cylinder(-X, X + Z, 0.4)",
    "rounded_cylinder": "rounded_cylinder(0.8, 0.15, 1.6)",
    "capped_cone": "capped_cone(-X, X + Z, 0.7, 0.2)",
    "rounded_cone": "rounded_cone(0.8, 0.3, 1.4)",
    "ellipsoid": "ellipsoid((1, 0.7, 0.4))",
    "pyramid": "pyramid(1)",
    "tetrahedron": "tetrahedron(1)",
    "octahedron": "octahedron(1)",
    "dodecahedron": "dodecahedron(1)",
    "icosahedron": "icosahedron(1)",
}

FLAT_SHAPES = {
    "circle": "circle(1)",
    "line": "circle(1) & line((1, 1))",
    "slab": "d2.slab(x0=-1, x1=1, y0=-0.6, y1=0.6, k=0.3)",
    "rectangle": "rectangle((2, 1.2))",
    "rounded_rectangle": "rounded_rectangle((2, 1.2), (0.5, 0.3, 0.1, 0))",
    "equilateral_triangle": "equilateral_triangle()",
    "hexagon": "hexagon(1)",
    "rounded_x": "rounded_x(1.4, 0.2)",
    "polygon": "polygon([(np.sin(0.8 * pi * i), np.cos(0.8 * pi * i)) for i in range(5)])",
    "vesica": "vesica(1.2, 0.6)",
}

OPERATIONS_ON_SOLIDS = {
    "union": "box(1.4).union(sphere(0.5, center=(0, 0, 0.9)), k=0.3)",
    "difference": "box(1.4).difference(sphere(0.7, center=(0.7, -0.7, 0.7)), k=0.1)",
    "intersection": "box(1.4).intersection(sphere(0.9), k=0.1)",
    "blend": "box(1.4).blend(octahedron(1.2))",
    "negate": "box(1.4) & sphere(0.85).negate()",
    "dilate": "box(1.2) | box(1.2).dilate(0.2) & plane(X)",
    "erode": "torus(1, 0.4) & plane(-X) | torus(1, 0.4).erode(0.2)",
    "shell": "sphere(1).shell(0.15) & plane((-1, 1, -1))",
    "repeat": "sphere(0.4).repeat(1, count=(2, 1, 0))",
    "translate": "box(0.8) | box(0.8).translate((1.2, 0, 0.6))",
    "scale": "sphere(0.5).translate(-X) | sphere(0.5).scale((1, 1, 2)).translate(X)",
    "elongate": "torus(0.5, 0.2).elongate((0.8, 0, 0))",
    "color": 'box(1.4).color("#c33") - sphere(0.9).color("#fd3") | sphere(0.5).color("#39c")',
    "rotate": "box((2, 0.6, 0.3)) | box((2, 0.6, 0.3)).rotate(pi / 3, Z).translate(Z)",
    "rotate_to": "capped_cone(-Z, Z, 0.5, 0.1).rotate_to(X + Z, Z)",
    "orient": "capped_cone(-Z, Z, 0.5, 0.1).orient(X)",
    "circular_array": "capsule(ORIGIN, X, 0.25).circular_array(7, 0.8)",
    "twist": "box((1, 1, 3)).twist(pi / 6) & cylinder(1)",
    "bend": "box((3, 0.5, 0.5)).bend(0.5) & cylinder(2)",
    "bend_linear": "capsule(-2 * X, 2 * X, 0.25).bend_linear(-X, X, Z, ease.in_out_quad)",
    "bend_radial": "(cylinder(2) & slab(z0=0, z1=0.2)).bend_radial(2, 0.5, 1, ease.in_out_quad)",
    "transition_linear": "box(1.4).transition_linear(cylinder(0.5), -Z / 2, Z / 2) & slab(z0=-0.7, z1=0.7)",
    "transition_radial": "box((3, 3, 0.3)).transition_radial(sphere(0.8), 1.4, 0.2)",
    "wrap_around": "(box((8, 0.1, 0.2)) | sphere(0.4).repeat((1, 0, 0))).wrap_around(-4, 4)",
    "slice": "(sphere(1) - torus(0.6, 0.2)).slice()",
}

OPERATIONS_ON_FLAT_SHAPES = {
    "union": "rectangle(1.4).union(circle(0.6, center=(0.7, 0.7)), k=0.3)",
    "difference": "rectangle(1.4).difference(circle(0.6, center=(0.7, 0.7)), k=0.1)",
    "intersection": "rectangle(1.4).intersection(circle(0.85), k=0.1)",
    "blend": "rectangle(1.4).blend(hexagon(1), k=0.5)",
    "negate": "circle(1) & rectangle(0.8).negate()",
    "dilate": "hexagon(1) | hexagon(1).dilate(0.2) & line((-1, 0))",
    "erode": "hexagon(1) & line((-1, 0)) | hexagon(1).erode(0.2)",
    "shell": "equilateral_triangle().shell(0.2)",
    "repeat": "circle(0.4).repeat(1, count=(2, 1))",
    "translate": "rectangle(0.8) | rectangle(0.8).translate((1, 0.5))",
    "scale": "circle(0.5).translate((-1, 0)) | circle(0.5).scale((1, 2)).translate((1, 0))",
    "elongate": "vesica(0.8, 0.4).elongate((0.6, 0))",
    "color": 'hexagon(1).color("#39c").union(circle(0.6, center=(0.8, 0.6)).color("#fd3"), k=0.5)',
    "rotate": "rectangle((2, 0.4)) | rectangle((2, 0.4)).rotate(pi / 3)",
    "circular_array": "hexagon(0.3).translate((1, 0)).circular_array(7)",
    "extrude": "hexagon(1).extrude(1.5)",
    "extrude_to": "rectangle(1.6).extrude_to(circle(0.6), 2, ease.in_out_quad)",
    "revolve": "hexagon(0.4).revolve(1)",
}

EASINGS = {word.name: f"ribbon.bend_linear(-X, X, 2 * Y, ease.{word.name})" for word in WORDS if word.kind == "easing"}

FORMULAS = {
    "tanglecube": """
bob.implicit(lambda x, y, z: x**4 + y**4 + z**4 - 5 * (x * x + y * y + z * z) + 11.8)
""",
    "gyroid": """
def gyroid(x, y, z):
    return np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)

bob.implicit(gyroid).shell(0.4) & sphere(2.5 * pi)
""",
    "Mandelbulb": """
def doubled(cosine, sine):
    return 2 * cosine * cosine - 1, 2 * cosine * sine

def mandelbulb(x, y, z):
    a, b, c = x, y, z
    for _ in range(2):
        across, r = np.hypot(a, b), np.sqrt(a * a + b * b + c * c)
        theta = np.clip(c / r, -1, 1), np.clip(across / r, 0, 1)
        phi = np.clip(a / across, -1, 1), np.clip(b / across, -1, 1)
        for _ in range(3):
            theta, phi = doubled(*theta), doubled(*phi)
        escaped = r > 4
        a = np.where(escaped, a, x + r**8 * theta[1] * phi[0])
        b = np.where(escaped, b, y + r**8 * theta[1] * phi[1])
        c = np.where(escaped, c, z + r**8 * theta[0])
    return np.sqrt(a * a + b * b + c * c) - 2

bob.implicit(mandelbulb, bounds=((-1.3, -1.3, -1.3), (1.3, 1.3, 1.3)))
""",
    "superquadric": """
bob.implicit(lambda x, y, z: np.abs(x) ** 0.5 + np.abs(y) ** 0.5 + np.abs(z) ** 0.5 - 1)
""",
    "heart": """
def heart(x, y, z):
    return (x * x + 2.25 * y * y + z * z - 1) ** 3 - (x * x + 0.1125 * y * y) * z**3

bob.implicit(heart)
""",
    "Barth's sextic": """
def barth(x, y, z):
    p = (3 + np.sqrt(5)) / 2  # the golden ratio's square
    x, y, z = x * x, y * y, z * z
    return 4 * (p * x - y) * (p * y - z) * (p * z - x) - (2 + np.sqrt(5)) * (x + y + z - 1) ** 2

bob.implicit(barth).negate() & sphere(2)
""",
    "Klein's bottle": """
def klein(x, y, z):
    s = x * x + y * y + z * z - 1
    return (s + 2 * y) * ((s - 2 * y) ** 2 - 8 * z * z) + 16 * x * z * (s - 2 * y)

bob.implicit(klein) & plane(-Y)
""",
    "Chmutov's sextic": """
def chebyshev(x):
    return ((32 * x * x - 48) * x * x + 18) * x * x - 1

bob.implicit(lambda x, y, z: chebyshev(x) + chebyshev(y) + chebyshev(z) + 1)
""",
    "trefoil": """
def trefoil(x, y, z):
    turn = 1.5 * np.arctan2(y, x)
    out = np.hypot(x, y) - 1
    across, along = out * np.cos(turn) + z * np.sin(turn), z * np.cos(turn) - out * np.sin(turn)
    return np.hypot(np.abs(across) - 0.35, along) - 0.2

bob.implicit(trefoil, bounds=((-2, -2, -1), (2, 2, 1)))
""",
    "metaballs": """
def metaballs(x, y, z):
    centers = [(np.cos(2 * i), np.sin(2 * i), 0.4 * np.sin(5 * i)) for i in range(6)]
    return 3 - sum(0.6 / ((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) for a, b, c in centers)

bob.implicit(metaballs)
""",
    "ripples": """
def ripples(x, y, z):
    r = np.hypot(x, y)
    return z - np.cos(3 * r) / (1 + r)

bob.implicit(ripples) & cylinder(5) & slab(z0=-1)
""",
    "a custom operation": """
@op3
def dimpled(other, depth):
    def f(p):
        return other(p) + depth * np.sin(10 * p).prod(axis=1, keepdims=True)
    return f

sphere(1).dimpled(0.05)
""",
}

PROGRAMS = {
    "constructive solid geometry": """
f = sphere(1) & box(1.5)
c = cylinder(0.5)
f - (c.orient(X) | c.orient(Y) | c.orient(Z))
""",
    "a knurled knob": """
f = rounded_cylinder(1, 0.1, 1.6)
groove = cylinder(0.08).circular_array(30, 1)
f -= (groove.twist(0.6) | groove.twist(-0.6)).k(0.05)
f - (cylinder(0.4) & slab(z0=-0.3)).k(0.1)
""",
    "a chain": """
link = torus(0.5, 0.12).elongate((0.4, 0, 0))
even = link.repeat((2.6, 0, 0), count=(1, 0, 0))
odd = link.rotate(pi / 2, X).repeat((2.6, 0, 0), count=(1, 0, 0)).translate(1.3 * X)
even | odd
""",
    "a name plate": """
from matplotlib import get_data_path

font = get_data_path() + "/fonts/ttf/DejaVuSans-Bold.ttf"
width, height = measure_text(font, "Bob Ross", height=1)
plate = rounded_box((width + 1, height + 1, 0.4), 0.15)
plate - text(font, "Bob Ross", height=1).extrude(0.2).translate(0.2 * Z)
""",
    "Mandelbrot's set": """
y, x = np.mgrid[-1.2:1.2:97j, -2.1:0.7:113j]
z = x + 1j * y
for _ in range(20):
    z = np.where(np.abs(z) < 2, z * z + x + 1j * y, 2)

image(np.abs(z) < 2).extrude(0.1)
""",
    "a mesh, hollowed": """
tree = bob.happy_tree()
Mesh(tree.vertices, tree.triangles).sdf().shell(0.04) & slab(y0=0)
""",
    "gear.sdf": """
bob.load("examples/gear.sdf")
""",
    "vase.sdf": """
bob.load("examples/vase.sdf")
""",
    "tower.sdf": """
bob.load("examples/tower.sdf")
""",
    "toadstool.sdf": """
bob.load("examples/toadstool.sdf")
""",
    "colours that are formulas": """
def waves(p):
    x, y, z = p[:, 0], p[:, 1], p[:, 2]
    return 0.5 + 0.5 * np.sin(7 * x), 0.2, 0.5 + 0.5 * np.sin(5 * z + 3 * y)

sphere(1).color(waves) | torus(1.3, 0.15).color(lambda p: np.abs(p) / 1.5)
""",
}

NURBS_HELPERS = """
CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)])
WEIGHTS = np.array([1, np.sqrt(0.5)] * 4 + [1])
QUARTERS = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4]

def clamped(count, degree=3):
    return np.clip(np.arange(-degree, count + 1), 0, count - degree)

def revolved(profile, knots, weights=1, trims=None):
    r, z = np.transpose(profile)
    points = [np.stack([x * r, y * r, z], axis=1) for x, y in CIRCLE]
    return bob.nurbs_surface(points, QUARTERS, knots, np.outer(WEIGHTS, weights * np.ones(len(r))), trims)

def rectangle_trim(u, v):
    return [(0, 0), (u, 0), (u, v), (0, v)]

def ellipse_trim(u, v, radius_u, radius_v):
    return bob.TrimCurve((u, v) + CIRCLE * (radius_u, radius_v), QUARTERS, WEIGHTS)
"""

NURBS = {
    "a vase": """
profile = [(0, 0), (0.7, 0), (0.6, 0.3), (1.5, 0.9), (1, 2.1), (0.2, 2.4), (0.4, 3.1), (0.8, 3.2)]
revolved(profile, clamped(len(profile)))
""",
    "a lantern": """
half = [(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)]
up = np.array([(0, 0.2), (-0.1, 0.9), (0.2, 1.2), (0.5, 1.8)])
down = np.array([(0.5, 1.8), (0.5, 1.2), (0.2, 0.9), (0, 0.2)])
slits = [[bob.TrimCurve((u, 0) + curve, clamped(4)) for curve in (up, down)] for u in np.arange(-2, 17) / 4]
lantern = revolved(half, [0, 0, 0, 1, 1, 2, 2, 2], WEIGHTS[:5], [rectangle_trim(4, 2), *slits])
[lantern, capsule(-0.7 * Z, 0.1 * Z, 0.2)]
""",
    "a ring of ribbons": """
ribbons = [[(0, v), (4, v + 16), (4, v + 16.6), (0, v + 0.6)] for v in np.arange(-16, 4)]
revolved(0.4 * CIRCLE + (1, 0), QUARTERS, WEIGHTS, ribbons)
""",
    "a cup": """
cup = revolved([(0, 0), (0.4, 0), (0.9, 0.1), (1, 0.7), (1, 1.4)], clamped(5))
saucer = revolved([(0, -0.05), (0.8, -0.05), (1.2, 0), (1.6, 0.15), (1.8, 0.3)], clamped(5))
handle = [(0.9, 0, 1.1), (1.3, 0, 1.3), (1.7, 0, 0.9), (1.2, 0, 0.4), (0.8, 0, 0.35)]
[cup, saucer, bob.nurbs_curve(handle, clamped(5), radius=[0.06, 0.12, 0.12, 0.09, 0.06])]
""",
    "a sea shell": """
turns = np.linspace(0, 7 * pi, 85)
points = []
for i, (angle, size) in enumerate(zip(turns, np.exp(0.13 * turns))):
    r, z = size * (CIRCLE.T * (0.95 if i % 2 else 1.05) + [[1], [-2]])
    points.append(np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1))
bob.nurbs_surface(points, clamped(len(points)), QUARTERS, np.tile(WEIGHTS, (len(points), 1)))
""",
    "a Moebius strip": """
angles = 2 * pi * np.arange(27) / 24
points = []
for a in angles:
    out = np.array([np.cos(a), np.sin(a), 0])
    points.append([(1 + x * np.cos(a / 2)) * out + x * np.sin(a / 2) * Z for x in (-0.5, 0.5)])
holes = [ellipse_trim(3.5 + i, 0.5, 0.35, 0.3) for i in range(24)]
bob.nurbs_surface(points, np.arange(31), [0, 0, 1, 1], trims=[[(3, 0), (27, 0), (27, 1), (3, 1)], *holes])
""",
    "a spire": """
points = []
for level, size in enumerate([1.2, 1, 0.8, 0.7, 0.7, 0.8, 0.9, 0.8, 0.4, 0]):
    angles = 2 * pi * np.arange(15) / 12 + 0.25 * level
    star = size * np.resize([1, 0.6], 15)
    points.append(np.stack([star * np.cos(angles), star * np.sin(angles), np.full(15, 0.4 * level)], axis=1))
bob.nurbs_surface(points, clamped(10), np.arange(19))
""",
    "a perforated sheet": """
x, y = np.meshgrid(np.linspace(-1, 1, 8), np.linspace(-1, 1, 8), indexing="ij")
points = np.stack([x, y, 0.25 * np.sin(3 * x + 1) * np.cos(3 * y)], axis=-1)
grid = np.arange(15) / 3 + 1 / 6
holes = [ellipse_trim(u, v, *2 * [0.03 + 0.12 * np.sin(0.7 * u + 0.6 * v) ** 2]) for u in grid for v in grid]
bob.nurbs_surface(points, clamped(8), clamped(8), trims=[rectangle_trim(5, 5), *holes])
""",
    "a flower": """
out, up = [0, 0.1, 0.25, 0.5, 0.9, 1.3], [0, 0.4, 0.8, 1.1, 1.2, 1.0]
width = [0.05, 0.15, 0.3, 0.45, 0.35, 0]
points = [[(r - 0.2 * w * (1 - y * y), w * y, z) for y in (-1, -0.4, 0.4, 1)] for r, w, z in zip(out, width, up)]
petal = bob.Instance(bob.nurbs_surface(points, clamped(6), clamped(4)))
petals = [petal.rotate(pi / 3 * (i + 0.3), Z).translate(-0.1 * (i % 2) * Z) for i in range(6)]
thread = [(0, 0, 0.2), (0.05, 0, 0.6), (0.1, 0, 0.9), (0.3, 0, 1.2), (0.36, 0, 1.22)]
stamen = bob.Instance(bob.nurbs_curve(thread, clamped(5), radius=[0.01, 0.02, 0.02, 0.01, 0.08]))
[*petals, *(stamen.rotate(pi / 3 * (i + 0.8), Z) for i in range(6))]
""",
    "a spring": """
t = np.linspace(0, 16 * pi, 129)
r = 0.6 + 0.4 * np.sin(t / 16)
points = np.stack([r * np.cos(t), r * np.sin(t), t / 18], axis=1)
bob.nurbs_curve(points, clamped(129), radius=0.15 * r**2)
""",
    "a knot": """
t = 2 * pi * np.arange(67) / 64
r = 1 + 0.45 * np.cos(5 * t)
points = np.stack([r * np.cos(2 * t), r * np.sin(2 * t), 0.45 * np.sin(5 * t)], axis=1)
bob.nurbs_curve(points, np.arange(71), radius=0.13 + 0.04 * np.cos(10 * t))
""",
    "a stool": """
i = np.arange(47)
angle = 2 * pi * i * 9 / 23
points = np.stack([np.cos(angle), np.sin(angle), 1.1 * (-1.0) ** i], axis=1)
bob.polyline(points, radius=0.05)
""",
}

SCENES = {
    "a wood": """
hills = bob.implicit(lambda x, y, z: z + 0.9 - 0.15 * np.sin(2 * x) * np.cos(3 * y)) & cylinder(3) & slab(z0=-1.5)
tree = bob.Instance(bob.happy_tree())
trees = [tree, tree.scale(0.6).translate((1.8, 0.5, -0.3)), tree.scale(0.5).translate((-1.6, -1, -0.4))]
[hills, *trees]
""",
    "materials": """
ball = sphere(1)
chalk = bob.Material("#e0e0e0", ambient=0.2, diffuse=0.8, specular=0)
wax = bob.Material("#ffffff", diffuse=0.6, specular=0.4, shininess=8)
pearl = bob.Material("#b0b0b0", diffuse=0.8, specular=0.6, shininess=200)
[bob.Instance(ball, material=each).translate((2.2 * i, 0, 0)) for i, each in enumerate([chalk, wax, pearl])]
""",
    "a table": """
top = rounded_box((4, 2.4, 0.2), 0.08)
leg = bob.Instance(capped_cone(-2 * Z, ORIGIN, 0.08, 0.15), material=bob.Material("#b0b0b0"))
legs = [leg.translate((x, y, 0)) for x in (-1.6, 1.6) for y in (-0.9, 0.9)]
gear, tower = (bob.load(f"examples/{name}.sdf").instances[0] for name in ("gear", "tower"))
tree = bob.Instance(bob.happy_tree()).scale(0.5).translate((-0.8, 0, 0.55))
[top, *legs, gear.scale(0.3).translate((0, -0.5, 0.19)), tower.scale(0.3).translate((0.8, 0.1, 0.73)), tree]
""",
}

SECTIONS = [
    Section("Solids", SOLIDS),
    Section(
        "Flat shapes",
        FLAT_SHAPES,
        f"Flat shapes are drawn {HEIGHT_OF_FLAT_SHAPES:g} high.",
        camera=FRONT_FROM_ABOVE,
    ),
    Section("Operations on solids", OPERATIONS_ON_SOLIDS),
    Section("Operations on flat shapes", OPERATIONS_ON_FLAT_SHAPES, camera=FRONT_FROM_ABOVE),
    Section(
        "Easing functions",
        EASINGS,
        "From above: a ribbon that is moved by 2 along y as x goes from -1 to 1.",
        columns=9,
        camera=ABOVE,
        helpers="ribbon = box((2.4, 0.2, 0.2))",
    ),
    Section("Formulas", FORMULAS, columns=4),
    Section(
        "Programs",
        PROGRAMS,
        "Scripts are in `examples`; [scripts.md](scripts.md) describes them.",
        columns=4,
    ),
    Section(
        "NURBS",
        NURBS,
        "Surfaces, trimmed or not, and tubes along curves; [nurbs.md](nurbs.md) describes them. The code starts with"
        " functions that several pictures use.",
        columns=4,
        helpers=NURBS_HELPERS,
    ),
    Section("Scenes", SCENES, columns=3),
]
HIGHLIGHTS = ["constructive solid geometry", "gyroid", "gear.sdf", "tanglecube", "vase.sdf", "a wood"]
NURBS_HIGHLIGHTS = ["a vase", "a lantern", "a ring of ribbons", "a sea shell", "a flower", "a knot"]


# ---- Pictures --------------------------------------------------------------------------------------------


def made(code: str, helpers: str = "") -> bob.Scene:
    """Return the value of the code's last line, as a scene."""
    names: dict[str, Any] = {"bob": bob}
    exec(f"from bobrossnet.sdf import *\n{helpers}", names)
    module = ast.parse(code)
    last = module.body.pop()
    assert isinstance(last, ast.Expr), code
    exec(compile(module, "gallery", "exec"), names)
    result = eval(compile(ast.Expression(last.value), "gallery", "eval"), names)
    return bob.Scene(result.extrude(HEIGHT_OF_FLAT_SHAPES) if isinstance(result, SDF2) else result)


def draw(section: Section, caption: str, side: int) -> tuple[NDArray[np.uint8], str]:
    """Return the fully traced picture, (side, side) uint8, or (side, side, 3) if coloured, and its caption."""
    scene = made(section.code[caption], section.helpers)
    seen = bob.trace(scene, section.camera, size=(side, side))
    return color_to_8_bit(seen.color) if scene.is_colored else to_8_bit(seen.gray), caption


def sheet(section: Section) -> NDArray[np.uint8]:
    """Return all pictures of a section in rows, above their captions: (H, W) uint8, or (H, W, 3) if any is coloured."""
    side = SHEET_WIDTH // section.columns - GAP
    panels = [draw(section, caption, side) for caption in section.code]
    panels += [(np.full((side, side), 255, np.uint8), "")] * (-len(panels) % section.columns)
    rows = [side_by_side(panels[i : i + section.columns]) for i in range(0, len(panels), section.columns)]
    joined = np.concatenate(rows)
    return joined if (joined != joined[..., :1]).any() else joined[..., 0]


def strip(names: list[str]) -> NDArray[np.uint8]:
    """Return highlights in a row: (H, W) uint8."""
    side = SHEET_WIDTH // len(names) - GAP
    pictures = [draw(section, name, side)[0] for name in names for section in SECTIONS if name in section.code]
    return np.concatenate(pictures, axis=1)


# ---- The page --------------------------------------------------------------------------------------------

HEAD = """# Gallery

Pictures of the [modelling language](modelling.md), of other implicit surfaces, and of NURBS. Each picture's code is
below it; it needs `from bobrossnet.sdf import *` and `import bobrossnet as bob`. `bob.trace` draws the result of the
last line. Every pixel is traced.

Made by docs/gallery.py.
"""


def document() -> str:
    parts = [HEAD]
    for section in SECTIONS:
        code = "\n".join(_listing(caption, code) for caption, code in section.code.items()).rstrip()
        if section.helpers:
            code = f"{section.helpers.strip()}\n\n{code}"
        parts.append(f"## {section.title}\n\n{section.note}\n\n" if section.note else f"## {section.title}\n\n")
        parts[-1] += f"![{', '.join(section.code)}]({section.sheet})\n\n```python\n{code}\n```\n"
    return "\n".join(parts)


def _listing(caption: str, code: str) -> str:
    """Return the code's listing; one line of code needs no caption."""
    return f"# {caption}\n{code.strip()}\n" if code.startswith("\n") else code


def main() -> None:
    os.chdir(ROOT)
    docs = ROOT / "docs"
    (docs / "gallery").mkdir(exist_ok=True)
    (docs / "gallery.md").write_text(document(), "utf-8")
    for section in SECTIONS:
        write_picture(docs / section.sheet, sheet(section))
    write_picture(docs / "shapes.png", strip(HIGHLIGHTS))
    write_picture(docs / "nurbs.png", strip(NURBS_HIGHLIGHTS))


if __name__ == "__main__":
    main()
