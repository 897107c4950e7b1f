"""The modelling language: each word compared with its formula in plain numpy, programs, and errors of bad calls."""

import inspect
import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bobrossnet as bob
from bobrossnet import sdf
from bobrossnet.sdf import d2, d3, ease, solid
from bobrossnet.sdf.d3 import SDF3, X, Y, Z
from bobrossnet.sdf.words import WORDS, Word
from bobrossnet.support.errors import InputError, InputTypeError

ROOT_3 = np.sqrt(3)


@pytest.fixture(scope="module")
def points():
    """Points near the origin and far from it, (n, 3)."""
    rng = np.random.default_rng(7)
    return np.concatenate([rng.normal(size=(400, 3)) * scale for scale in (0.3, 1, 3, 30, 1e4)])


# ---- Formulas of points p, (n, 2) or (n, 3), and a word's arguments; shapes and easings are functions -------


def norm(*columns):
    return np.sqrt(sum(np.square(column) for column in columns))


def length(p):
    return norm(*p.T)


def unit(v):
    return np.asarray(v, float) / np.linalg.norm(v)


def box_of(q):
    """Return the distance from a box for distances q beyond its faces."""
    return length(np.maximum(q, 0)) + np.minimum(q.max(axis=1), 0)


def stack(*columns):
    return np.stack(np.broadcast_arrays(*columns), axis=1)


def turned(p, angle, axis):
    """Rotate points by -angle, by Rodrigues' formula, as the shape is rotated by the angle."""
    k = unit(axis)
    cross = np.cross(k, p)
    return p * np.cos(angle) - cross * np.sin(angle) + np.outer(p @ k, k) * (1 - np.cos(angle))


def sphere(p, radius=1, center=0):
    return length(p - np.asarray(center)) - radius


def plane(p, normal=(0, 0, 1), point=0):
    return (np.asarray(point) - p) @ unit(normal)


def slab(p, k=None, **cuts):
    names = [name for axis in "xyz" for name in (f"{axis}0", f"{axis}1")]
    sides = [
        (p[:, "xyz".index(name[0])] - cuts[name]) * (1 if name[1] == "1" else -1) for name in names if name in cuts
    ]
    result = sides[0]
    for side in sides[1:]:
        result = rounded_max(result, side, k)
    return result


def box(p, size=1, center=0, a=None, b=None):
    if a is not None:
        size, center = np.subtract(b, a), np.add(a, b) / 2
    return box_of(np.abs(p - np.asarray(center)) - np.asarray(size) / 2)


def rounded_box(p, size, radius):
    return box_of(np.abs(p) - np.asarray(size) / 2 + radius) - radius


def wireframe_box(p, size, thickness):
    outer = np.abs(p) - np.asarray(size) / 2 - thickness / 2
    bar = np.abs(outer + thickness / 2) - thickness / 2
    return np.min([box_of(np.where(np.arange(3) == axis, outer, bar)) for axis in range(3)], axis=0)


def torus(p, r1, r2):
    return norm(norm(p[:, 0], p[:, 1]) - r1, p[:, 2]) - r2


def capsule(p, a, b, radius):
    a, b = np.asarray(a), np.asarray(b)
    t = np.clip((p - a) @ (b - a) / np.dot(b - a, b - a), 0, 1)
    return length(p - a - np.outer(t, b - a)) - radius


def along_and_away(p, a, b):
    axis = unit(np.subtract(b, a))
    along = (p - np.asarray(a)) @ axis
    return along, length(p - np.asarray(a) - np.outer(along, axis)), np.linalg.norm(np.subtract(b, a))


def capped_cylinder(p, a, b, radius):
    along, away, span = along_and_away(p, a, b)
    return box_of(stack(away - radius, np.maximum(-along, along - span)))


def rounded_cylinder(p, ra, rb, h):
    return box_of(stack(norm(p[:, 0], p[:, 1]) - ra + rb, np.abs(p[:, 2]) - h / 2 + rb)) - rb


def capped_cone(p, a, b, ra, rb):
    along, away, span = along_and_away(p, a, b)
    cap = np.maximum(-along, along - span)
    rim = np.maximum(0, away - np.where(along < span / 2, ra, rb))
    t = np.clip(((rb - ra) * (away - ra) + along * span) / ((rb - ra) ** 2 + span**2), 0, 1)
    side = away - ra - t * (rb - ra)
    inside = (side < 0) & (cap < 0)
    return np.where(inside, -1, 1) * np.minimum(norm(rim, cap), norm(side, along - t * span))


def rounded_cone(p, r1, r2, h):
    away, z = norm(p[:, 0], p[:, 1]), p[:, 2]
    slope = np.arcsin((r1 - r2) / h)
    along = z * np.cos(slope) - away * np.sin(slope)
    ends = np.where(along < 0, norm(away, z) - r1, norm(away, z - h) - r2)
    side = away * np.cos(slope) + z * np.sin(slope) - r1
    return np.where((along >= 0) & (along <= h * np.cos(slope)), side, ends)


def ellipsoid(p, size):
    k0, k1 = length(p / np.asarray(size)), length(p / np.square(size))
    return k0 * (k0 - 1) / k1


def pyramid(p, h):
    beyond = np.sort(np.abs(p[:, :2]) - 0.5, axis=1)
    x, y, z, m = beyond[:, 1], p[:, 2], beyond[:, 0], h * h + 0.25
    qx, qy, qz = z, h * y - x / 2, h * x + y / 2
    t = np.clip((qy - z / 2) / (m + 0.25), 0, 1)
    nearest = np.minimum(m * np.maximum(qx, 0) ** 2 + qy**2, m * (qx + t / 2) ** 2 + (qy - m * t) ** 2)
    squared = np.where((qy > 0) & (-qx * m - qy / 2 > 0), 0, nearest)
    return norm(np.sqrt(squared), qz) / np.sqrt(m) * np.where(np.maximum(qz, -y) < 0, -1, 1)


def tetrahedron(p, r):
    normals = np.array([(1, 1, -1), (-1, -1, -1), (1, -1, 1), (-1, 1, 1)]) / ROOT_3
    return (p @ normals.T).max(axis=1) - r / ROOT_3


def octahedron(p, r):
    return (np.abs(p).sum(axis=1) - r) / ROOT_3


GOLDEN = (1 + np.sqrt(5)) / 2


def dodecahedron(p, r):
    normals = [np.roll(unit((GOLDEN, 1, 0)), turn) for turn in range(3)]
    return (np.abs(p) @ np.transpose(normals)).max(axis=1) - r * normals[0][0]


def icosahedron(p, r):
    midradius = r * 0.8506507174597755  # GOLDEN / sqrt(GOLDEN**2 + 1), with the digits of the original
    normals = [*(np.roll(unit((GOLDEN**2, 1, 0)), turn) for turn in range(3)), unit((1, 1, 1))]
    return (np.abs(p) @ np.transpose(normals)).max(axis=1) - midradius * normals[0][0]


def line(p, normal=(0, 1), point=0):
    return plane(p, normal, point)


def rounded_rectangle(p, size, radius, center=0):
    p = p - np.asarray(center)
    corners = np.broadcast_to(radius, 4)
    right, top = p[:, 0] > 0, p[:, 1] > 0
    r = np.select([right & top, right, ~top], corners[:3], corners[3])
    return box_of(np.abs(p) - np.asarray(size) / 2 + r[:, None]) - r


def polygon(p, points):
    """Signed by winding angles, where the word counts crossings."""
    corners = np.asarray(points, float)
    distance, angle = np.full(len(p), np.inf), np.zeros(len(p))
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        distance = np.minimum(distance, capsule(p, a, b, 0))
        u, v = a - p, b - p
        angle += np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    winding = np.rint(angle / (2 * np.pi)).astype(int)
    return np.where(winding % 2, -1, 1) * distance


def equilateral_triangle(p):
    return polygon(p, [(-1, -1 / ROOT_3), (1, -1 / ROOT_3), (0, 2 / ROOT_3)])


def hexagon(p, r):
    return polygon(p, [(r * np.cos(a), r * np.sin(a)) for a in np.arange(6) * np.pi / 3])


def rounded_x(p, w, r):
    q = np.minimum(np.abs(p).sum(axis=1), w) / 2
    return length(np.abs(p) - q[:, None]) - r


def vesica(p, r, d):
    x, y = np.abs(p).T
    b = np.sqrt(r * r - d * d)
    return np.where((y - b) * d > x * b, norm(x, y - b), norm(x + d, y) - r)


def rounded_max(a, b, k):
    """Return the maximum, with a parabolic blend between."""
    if not k:
        return np.maximum(a, b)
    h = np.clip(0.5 + 0.5 * (a - b) / k, 0, 1)
    return b + (a - b) * h + k * h * (1 - h)


def folded(join):
    def fold(p, a, *bs, **k):
        result = a(p)
        for b in bs:
            result = join(result, b(p), **k)
        return result

    return fold


def repeat(p, f, spacing, count=None, padding=0):
    spacing = np.broadcast_to(spacing, p.shape[1]).astype(float)
    index = np.zeros_like(p)
    index[:, spacing != 0] = np.round(p[:, spacing != 0] / spacing[spacing != 0])
    if count is not None:
        index = np.clip(index, -np.asarray(count), np.asarray(count))
    reach = np.where(spacing == 0, 0, np.broadcast_to(padding, p.shape[1]))
    neighbors = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in reach)), axis=-1).reshape(-1, p.shape[1])
    return np.min([f(p - spacing * (index + neighbor)) for neighbor in neighbors], axis=0)


def circular_array(p, f, count, offset=0):
    """Return the copies on either side of a point."""
    angle = np.arctan2(p[:, 1], p[:, 0]) % (2 * np.pi / count)
    away = norm(p[:, 0], p[:, 1])

    def copy(a):
        return f(stack(away * np.cos(a) - offset, away * np.sin(a), p[:, 2]))

    return np.minimum(copy(angle), copy(angle - 2 * np.pi / count))


def circular_array_2d(p, f, count):
    return np.min([rotate_2d(p, f, 2 * np.pi * i / count) for i in range(count)], axis=0)


def rotate_2d(p, f, angle):
    return f(turned(np.column_stack([p, np.zeros(len(p))]), -angle, Z)[:, :2])


def rotate_to(p, f, a, b):
    a, b = unit(a), unit(b)
    axis = np.cross(b, a)
    if np.linalg.norm(axis) < 1e-12:
        across = np.cross(a, X if a[1] or a[2] else Y)
        return f(p if a @ b > 0 else turned(p, np.pi, across))
    return f(turned(p, np.arctan2(np.linalg.norm(axis), a @ b), axis))


def elongate(p, f, size):
    q = np.abs(p) - np.asarray(size)
    return f(np.maximum(q, 0)) + np.minimum(q.max(axis=1), 0)


def linear(t):
    return t


def twist(p, f, k):
    return f(stack(*rotated(p, k * p[:, 2]), p[:, 2]))


def bend(p, f, k):
    return f(stack(*rotated(p, k * p[:, 0]), p[:, 2]))


def rotated(p, angle):
    turned = (p[:, 0] + 1j * p[:, 1]) * np.exp(1j * angle)
    return turned.real, turned.imag


def on_the_way(p, p0, p1, e):
    way = np.subtract(p1, p0)
    return e(np.clip((p - np.asarray(p0)) @ way / (way @ way), 0, 1))


def outwards(p, r0, r1, e):
    return e(np.clip((norm(p[:, 0], p[:, 1]) - r0) / (r1 - r0), 0, 1))


def transition_linear(p, f0, f1, p0=(0, 0, -1), p1=(0, 0, 1), e=linear):
    t = on_the_way(p, p0, p1, e)
    return t * f1(p) + (1 - t) * f0(p)


def transition_radial(p, f0, f1, r0=0, r1=1, e=linear):
    t = outwards(p, r0, r1, e)
    return t * f1(p) + (1 - t) * f0(p)


def wrap_around(p, f, x0, x1, r=None, e=linear):
    r = abs(x1 - x0) / (2 * np.pi) if r is None else r
    t = e(np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) + 0.5)
    return f(stack(x0 + (x1 - x0) * t, r - norm(p[:, 0], p[:, 1]), p[:, 2]))


def extrude_to(p, a, b, h, e=linear):
    t = e(np.clip(p[:, 2] / h, -0.5, 0.5) + 0.5)
    d = (1 - t) * a(p[:, :2]) + t * b(p[:, :2])
    return box_of(stack(d, np.abs(p[:, 2]) - h / 2))


def in_out(into):
    """Return the easing that runs `into` at double speed, and then in reverse."""
    return lambda t, *k: np.where(t < 0.5, into(2 * t, *k) / 2, 1 - into(2 - 2 * t, *k) / 2)


def out(into):
    return lambda t, *k: 1 - into(1 - t, *k)


def in_elastic(t, k=0.5):
    return -(2.0 ** (10 * (t - 1))) * np.sin((t - 1 - k / 4) * 2 * np.pi / k)


def bounced(t):
    """The arcs of a ball, each between two bounces."""
    pieces = [
        (121 / 16, 0, 0),
        (363 / 40, -99 / 10, 17 / 5),
        (4356 / 361, -35442 / 1805, 16061 / 1805),
        (54 / 5, -513 / 25, 268 / 25),
    ]
    piece = np.searchsorted([4 / 11, 8 / 11, 9 / 10], t, side="right")
    a, b, c = np.array(pieces)[piece].T
    return a * t * t + b * t + c


def overshooting(k):
    return lambda t: t * t * ((k + 1) * t - k)


def in_expo(t):
    return np.where(t == 0, 0, 2.0 ** (10 * t - 10))


EASED_IN = {
    "quad": lambda t: t**2,
    "cubic": lambda t: t**3,
    "quart": lambda t: t**4,
    "quint": lambda t: t**5,
    "sine": lambda t: 1 - np.cos(t * np.pi / 2),
    "expo": in_expo,
    "circ": lambda t: 1 - np.sqrt(np.maximum(1 - t * t, 0)),
    "elastic": in_elastic,
    "back": overshooting(1.70158),
    "bounce": out(bounced),
    "square": lambda t: np.where(t < 1, 0.0, 1.0),
}
EASINGS = {"linear": linear}
for _name, _into in EASED_IN.items():
    EASINGS |= {f"in_{_name}": _into, f"out_{_name}": out(_into), f"in_out_{_name}": in_out(_into)}
EASINGS["in_out_back"] = in_out(overshooting(1.70158 * 1.525))
EASINGS["in_out_square"] = lambda t: np.where(t < 0.5, 0.0, 1.0)

FORMULAS_OF_BOTH = {
    "union": folded(lambda a, b, k=None: -rounded_max(-a, -b, k)),
    "difference": folded(lambda a, b, k=None: rounded_max(a, -b, k)),
    "intersection": folded(lambda a, b, k=None: rounded_max(a, b, k)),
    "blend": folded(lambda a, b, k=0.5: k * b + (1 - k) * a),
    "negate": lambda p, f: -f(p),
    "color": lambda p, f, c: f(p),  # tests/test_formula_color.py tests the colours
    "dilate": lambda p, f, r: f(p) - r,
    "erode": lambda p, f, r: f(p) + r,
    "shell": lambda p, f, thickness: np.abs(f(p)) - thickness / 2,
    "repeat": repeat,
    "translate": lambda p, f, offset: f(p - np.asarray(offset)),
    "scale": lambda p, f, factor: f(p / np.asarray(factor)) * np.min(factor),
    "elongate": elongate,
}
FORMULAS = {
    3: FORMULAS_OF_BOTH
    | {
        "sphere": sphere,
        "plane": plane,
        "slab": slab,
        "box": box,
        "rounded_box": rounded_box,
        "wireframe_box": wireframe_box,
        "torus": torus,
        "capsule": capsule,
        "cylinder": lambda p, radius: norm(p[:, 0], p[:, 1]) - radius,
        "capped_cylinder": capped_cylinder,
        "rounded_cylinder": rounded_cylinder,
        "capped_cone": capped_cone,
        "rounded_cone": rounded_cone,
        "ellipsoid": ellipsoid,
        "pyramid": pyramid,
        "tetrahedron": tetrahedron,
        "octahedron": octahedron,
        "dodecahedron": dodecahedron,
        "icosahedron": icosahedron,
        "rotate": lambda p, f, angle, vector=(0, 0, 1): f(turned(p, angle, vector)),
        "rotate_to": rotate_to,
        "orient": lambda p, f, axis: rotate_to(p, f, (0, 0, 1), axis),
        "circular_array": circular_array,
        "twist": twist,
        "bend": bend,
        "bend_linear": lambda p, f, p0, p1, v, e=linear: f(p - np.outer(on_the_way(p, p0, p1, e), v)),
        "bend_radial": lambda p, f, r0, r1, dz, e=linear: f(p - np.outer(dz * outwards(p, r0, r1, e), (0, 0, 1))),
        "transition_linear": transition_linear,
        "transition_radial": transition_radial,
        "wrap_around": wrap_around,
        "slice": lambda p, f: f(np.column_stack([p, np.zeros(len(p))])),
    },
    2: FORMULAS_OF_BOTH
    | {
        "circle": sphere,
        "line": line,
        "slab": slab,
        "rectangle": box,
        "rounded_rectangle": rounded_rectangle,
        "equilateral_triangle": equilateral_triangle,
        "hexagon": hexagon,
        "rounded_x": rounded_x,
        "polygon": polygon,
        "vesica": vesica,
        "rotate": rotate_2d,
        "circular_array": circular_array_2d,
        "extrude": lambda p, f, h: box_of(stack(f(p[:, :2]), np.abs(p[:, 2]) - h / 2)),
        "extrude_to": extrude_to,
        "revolve": lambda p, f, offset=0: f(stack(norm(p[:, 0], p[:, 1]) - offset, p[:, 2])),
    },
    0: EASINGS,
}

# ---- Calls of each word ----------------------------------------------------------------------------------


@dataclass
class Both:
    """An argument in two forms: the language's, and the formula's."""

    word: Any
    formula: Any


def shape(dimensions, name, *args, **kwargs):
    module, formula = (d2 if dimensions == 2 else d3), FORMULAS[dimensions][name]
    return Both(getattr(module, name)(*args, **kwargs), lambda p: formula(p, *args, **kwargs))


def call(*args, **kwargs):
    return args, kwargs


BOX = shape(3, "box", (1, 2, 0.7))
BALL = shape(3, "sphere", 0.8, (0.3, 0.2, -0.1))
ROD = shape(3, "capsule", (0.1, 0.2, -0.5), (0.6, -0.3, 1), 0.3)
RECTANGLE = shape(2, "rectangle", (1, 2), (0.2, 0.1))
DISK = shape(2, "circle", 0.7, (0.3, -0.1))
SMOOTH, SWINGING = Both(ease.in_out_quad, EASINGS["in_out_quad"]), Both(ease.out_elastic, EASINGS["out_elastic"])
CUSTOM = Both(lambda t: t * t * (3 - 2 * t), lambda t: t * t * (3 - 2 * t))

CONE_ENDS = ((0.1, 0.2, -0.3), (0.5, 1, 1.2))
HOUSE = [(0, 0), (2, 0.2), (2.5, 1.5), (1.2, 0.9), (1, 2.2), (-0.5, 1.1)]
ACUTE = [(0, 0), (3, 0.5), (3.5, 1), (0.5, 0.4)]
STAR = [(np.cos(4 * np.pi * i / 5), np.sin(4 * np.pi * i / 5)) for i in range(5)]


def calls_of_both(f, g, h, v, size):
    """Calls of the operations of shapes f, g and h in any dimension, with a vector and a size."""
    return {
        "union": [call(f, g, h), call(f, g, h, k=0.3), call(f), call(f, g, k=0)],
        "difference": [call(f, g, h), call(f, g, h, k=0.4)],
        "intersection": [call(f, g), call(f, g, h, k=0.5)],
        "blend": [call(f, g, h), call(f, g, k=0.2), call(f, g, k=-1)],
        "negate": [call(f)],
        "color": [call(f, "#c33"), call(f, c=(0.5, 0, 1))],
        "dilate": [call(f, 0.2), call(f, r=-0.1)],
        "erode": [call(f, 0.2), call(f, -0.1)],
        "shell": [call(f, 0.1)],
        "repeat": [
            call(h, 3),
            call(h, (1.5, 2.5, 0)[: len(v)], padding=1),
            call(h, (2.0, 0, 3)[: len(v)], (2, 1, 1)[: len(v)], (1, 1, 0)[: len(v)]),
            call(h, spacing=-1.5, count=2),
        ],
        "translate": [call(f, v), call(f, offset=np.array(v))],
        "scale": [call(f, 2), call(f, size), call(f, factor=-0.5)],
        "elongate": [call(f, size), call(f, 0.3)],
    }


CALLS = {
    3: {
        **calls_of_both(BOX, BALL, ROD, (0.5, -1, 2), (0.25, 0.5, 0.75)),
        "sphere": [call(), call(1.3, (0.1, 0.2, 0.3)), call(radius=2, center=X), call(-1)],
        "plane": [call(), call((1, 2, -0.5), (0.3, 0.1, 0.2)), call(-X)],
        "slab": [call(x0=-1, y1=0.5, z0=-0.2, z1=0.8), call(x1=1, y0=0.1, y1=2, k=0.3), call(z0=0)],
        "box": [call(), call(2), call((1, 2, 3), (0.1, 0.2, 0.3)), call(a=(-1, -2, 0), b=(0.5, 1, 2))],
        "rounded_box": [call((1, 2, 3), 0.25), call(1, 0.1), call(size=(0.2, 4, 1.5), radius=0)],
        "wireframe_box": [call((1, 2, 3), 0.1), call(2, 0.3)],
        "torus": [call(1, 0.25), call(r1=0.5, r2=0.7)],
        "capsule": [call(-Z, Z, 0.5), call((0.1, 0.2, -0.5), (0.6, -0.3, 1), 0.3), call(X, -2 * X, radius=0)],
        "cylinder": [call(0.7)],
        "capped_cylinder": [call(-Z, Z, 0.5), call((0.1, 0.2, 0.3), (1, -1, 2), 0.6), call(Y, -Y, 2)],
        "rounded_cylinder": [call(0.5, 0.1, 2), call(ra=1, rb=0, h=0.5)],
        "capped_cone": [call(-Z, Z, 1, 0.5), call(*CONE_ENDS, 1, 0.4), call(*CONE_ENDS, 0.5, 0.5), call(X, Y, 0, 1)],
        "rounded_cone": [call(0.75, 0.25, 2), call(0.25, 0.75, 1), call(0.5, 0.5, 1)],
        "ellipsoid": [call((1, 2, 3)), call(0.7), call((0.1, 1, 1))],
        "pyramid": [call(1), call(2.3), call(0.2)],
        "tetrahedron": [call(1), call(0.3)],
        "octahedron": [call(1), call(0.3)],
        "dodecahedron": [call(1), call(0.3)],
        "icosahedron": [call(1), call(0.3)],
        "rotate": [call(ROD, 0.7), call(ROD, -2, (1, 2, 3)), call(ROD, np.pi / 2, X), call(ROD, angle=10, vector=-Y)],
        "rotate_to": [
            call(ROD, (1, 2, 3), (-1, 0.5, 2)),
            call(ROD, (1, 2, 3), (2, 4, 6)),
            call(ROD, X, -X),
            call(ROD, Z, -2 * Z),
        ],
        "orient": [call(ROD, axis) for axis in (X, Y, Z, -X, (1, 1, -2))],
        "circular_array": [call(ROD, 7, 2), call(ROD, 1), call(ROD, count=4, offset=-1), call(ROD, 24, 1.6)],
        "twist": [call(ROD, 1.5), call(BOX, -0.2)],
        "bend": [call(ROD, 0.7), call(BOX, -0.2)],
        "bend_linear": [
            call(ROD, -Z, Z, X),
            call(ROD, (0, 1, 0), (1, 2, 3), (1, 0, 2), SMOOTH),
            call(ROD, -Z, Z, X, e=CUSTOM),
        ],
        "bend_radial": [call(BOX, 0.5, 2, 1), call(BOX, 1, 2, -1, SWINGING)],
        "transition_linear": [call(BOX, BALL), call(BOX, BALL, (0, 1, 0), (1, 2, 0), SWINGING)],
        "transition_radial": [call(BOX, BALL), call(BOX, BALL, 0.5, 3, e=SMOOTH)],
        "wrap_around": [call(ROD, -2, 3), call(ROD, 2, -1, 1.5, SMOOTH)],
        "slice": [call(BOX), call(ROD)],
    },
    2: {
        **calls_of_both(RECTANGLE, DISK, shape(2, "hexagon", 0.6), (0.5, -1), (0.25, 0.5)),
        "circle": [call(), call(1.3, (0.1, 0.2)), call(radius=2, center=d2.X)],
        "line": [call(), call((1, 2), (0.1, 0.2))],
        "slab": [call(x0=-1, y1=0.5), call(x0=-1, x1=1, y0=0.1, y1=2, k=0.3)],
        "rectangle": [call(), call(2), call((1, 2), (0.1, 0.2)), call(a=(0, 0), b=(1, 3))],
        "rounded_rectangle": [call(2, 0.3), call((2, 3), (0.1, 0.2, 0.3, 0.4)), call((2, 3), 0, center=(1, 0.5))],
        "equilateral_triangle": [call()],
        "hexagon": [call(1), call(r=0.3)],
        "rounded_x": [call(1, 0.2), call(0.3, 0)],
        "polygon": [
            call(HOUSE),
            call(HOUSE[::-1]),
            call(STAR),
            call(ACUTE),
            call(ACUTE[::-1]),
            call(points=np.array([(0, 0), (1, 0), (0, 1)])),
        ],
        "vesica": [call(1.5, 0.7), call(1.5, -0.7), call(1, 0)],
        "rotate": [call(RECTANGLE, 0.7), call(RECTANGLE, np.pi / 2)],
        "circular_array": [call(RECTANGLE, 5), call(RECTANGLE, count=1)],
        "extrude": [call(RECTANGLE, 1.2), call(DISK, 0)],
        "extrude_to": [call(RECTANGLE, DISK, 1.5), call(RECTANGLE, DISK, 2, SMOOTH), call(DISK, RECTANGLE, -1)],
        "revolve": [call(DISK), call(DISK, 1.5)],
    },
    0: {name: [call(), *([call(0.3)] if name.endswith("elastic") else [])] for name in EASINGS},
}


def calls_of(word: Word):
    return CALLS[word.dimensions][word.name]


def word_id(word: Word):
    return f"{f'd{word.dimensions}' if word.dimensions else 'ease'}.{word.name}"


def chosen(value, which):
    return getattr(value, which) if isinstance(value, Both) else value


def both_forms(word, args, kwargs):
    """Return the values of a word's call, and of its formula."""

    def arguments(which):
        return [chosen(a, which) for a in args], {name: chosen(value, which) for name, value in kwargs.items()}

    module = {0: ease, 2: d2, 3: d3}[word.dimensions]
    formula = FORMULAS[word.dimensions][word.name]
    words_args, words_kwargs = arguments("word")
    args, kwargs = arguments("formula")
    return getattr(module, word.name)(*words_args, **words_kwargs), lambda p: formula(p, *args, **kwargs)


def assert_alike(values, expected, points):
    scale = 1 + np.abs(expected) + np.abs(points).max(axis=1)
    worst = np.argmax(np.abs(values - expected) / scale)
    assert np.abs(values[worst] - expected[worst]) <= 1e-9 * scale[worst], points[worst]


@pytest.mark.parametrize("word", [word for word in WORDS if word.dimensions], ids=word_id)
def test_word_is_its_formula(word, points):
    points = points[:, : word.result_dimensions]
    for args, kwargs in calls_of(word):
        made, formula = both_forms(word, args, kwargs)
        assert made.dimensions == word.result_dimensions
        values = made(points)
        assert values.shape == (len(points), 1)
        assert values.dtype == np.float64
        assert_alike(values[:, 0], formula(points), points)


@pytest.mark.parametrize("word", [word for word in WORDS if word.dimensions], ids=word_id)
def test_values_are_finite_in_special_places(word):
    steps = np.array([-1, -0.5, 0, 0.5, 1])
    grid = np.stack(np.meshgrid(*[steps] * word.result_dimensions), axis=-1).reshape(-1, word.result_dimensions)
    for args, kwargs in calls_of(word):
        assert np.isfinite(both_forms(word, args, kwargs)[0](grid)).all()


@pytest.mark.parametrize("word", [word for word in WORDS if not word.dimensions], ids=word_id)
def test_easing_is_its_formula(word):
    t = np.concatenate([np.linspace(0, 1, 1001), np.random.default_rng(1).random(100)])
    easing = getattr(ease, word.name)
    for args, kwargs in calls_of(word):
        np.testing.assert_allclose(easing(t, *args, **kwargs), EASINGS[word.name](t, *args), rtol=0, atol=1e-12)
    assert easing(0.25) == easing(np.array([[0.25]]))[0, 0]


def test_every_formula_is_a_word():
    words = {(word.dimensions, word.name) for word in WORDS}
    assert words == {(d, name) for d, formulas in FORMULAS.items() for name in formulas}
    assert words == {(d, name) for d, calls in CALLS.items() for name in calls}


@pytest.mark.parametrize("word", [word for word in WORDS if word.kind == "operation"], ids=word_id)
def test_operations_are_methods(word, points):
    args, kwargs = calls_of(word)[0]
    made, _ = both_forms(word, args, kwargs)
    shape, *rest = (chosen(a, "word") for a in args)
    method = getattr(shape, word.name)(*rest, **kwargs)
    assert method.expression == made.expression
    assert next(iter(inspect.signature(getattr(type(shape), word.name)).parameters)) == "self"


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.floats(0.01, 10), min_size=6, max_size=6),
    st.floats(-10, 10),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
)
def test_models_of_any_arguments(sizes, angle, axis):
    a, b, c, d, e, f = sizes
    p = np.random.default_rng(3).normal(size=(200, 3)) * 5
    made = (d3.box((a, b, c)).rotate(angle, axis) | d3.capped_cone(axis, (d, e, f), a, b).k(d)) - d3.torus(e + f, f)
    first = box(turned(p, angle, axis), (a, b, c))
    joined = -rounded_max(-first, -capped_cone(p, axis, (d, e, f), a, b), d)
    assert_alike(made(p)[:, 0], np.maximum(joined, -torus(p, e + f, f)), p)


# ---- Smooth edges ----------------------------------------------------------------------------------------


def test_k_of_the_second_shape_rounds(points):
    box, rounded = d3.box(1.5), d3.sphere().k(0.25)
    for made, named in (
        (box | rounded, d3.union),
        (box & rounded, d3.intersection),
        (box - rounded, d3.difference),
    ):
        assert made.expression == named(box, d3.sphere(), k=0.25).expression
        assert made.expression == named(box, rounded).expression
        assert named(box, rounded, k=0.5).expression == named(box, d3.sphere(), k=0.5).expression
    assert (rounded | box).expression == (d3.sphere() | box).expression  # the second shape's radius counts
    assert (box | d3.sphere().k(0)).expression == (box | d3.sphere()).expression


def test_k_makes_a_new_shape():
    for made, box in ((d3.sphere(), d3.box()), (d2.circle(), d2.rectangle())):
        sharp, rounded = (box | made).expression, made.k(0.2)
        assert type(rounded) is type(made)
        assert rounded.expression == made.expression
        assert (box | made).expression == sharp != (box | rounded).expression
        assert (box | rounded.k()).expression == sharp
    cut = d3.SDF3(d3.plane(), bounds=((-1, -1, -1), (1, 1, 1)))
    assert (cut.k(0.2).bounds == cut.bounds).all()


def test_k_is_forgotten_by_operations():
    moved = d3.sphere().k(0.2).translate(X)
    assert (d3.box() | moved).expression == (d3.box() | d3.sphere().translate(X)).expression


# ---- Programs --------------------------------------------------------------------------------------------

PROGRAMS = {
    "solids": """
f = sphere(1) & box(1.5)
c = cylinder(0.5)
f -= c.orient(X) | c.orient(Y) | c.orient(Z)
""",
    "gear": """
f = sphere(2) & slab(z0=-0.4, z1=0.4).k(0.1)
f -= cylinder(0.9).k(0.1)
f -= cylinder(0.3).circular_array(12, 2).k(0.1)
""",
    "knurled": """
f = rounded_cylinder(1, 0.1, 5)
x = box((1, 1, 4)).rotate(pi / 4).circular_array(20, 1.6)
f -= (x.twist(0.7) | x.twist(-0.7)).k(0.1)
f -= cylinder(0.4).k(0.1)
for z in (-2.5, 2.5):
    f -= cylinder(0.25).orient(X).translate(Z * z).k(0.1)
""",
    "pawn": """
def section(z0, z1, d0, d1, e=ease.linear):
    f = cylinder(d0 / 2).transition_linear(cylinder(d1 / 2), Z * z0, Z * z1, e)
    return f & slab(z0=z0, z1=z1)
f = section(0, 0.3, 1, 1.2)
f |= rounded_cylinder(0.6, 0.1, 0.2).translate(Z * 0.4).k(0.05)
f |= section(0.5, 1.7, 1, 0.3, ease.out_quad).k(0.01)
f |= sphere(0.3).translate(Z * 1.9).k(0.05)
""",
    "woven": """
f = rounded_box([3.2, 1, 0.25], 0.1).translate((1.5, 0, 0.06))
f = f.bend_linear(X * 0.75, X * 2.25, Z * -0.19, ease.in_out_quad)
f = f.circular_array(3, 0).repeat((2.7, 5.4, 0), padding=1)
f |= f.translate((2.7 / 2, 2.7, 0))
f &= cylinder(10)
f |= (cylinder(12) - cylinder(10)) & slab(z0=-0.5, z1=0.5).k(0.25)
""",
    "blobs": """
s = sphere(0.75)
s = s.translate(Z * -3) | s.translate(Z * 3)
s = s.union(capsule(Z * -3, Z * 3, 0.5), k=1)
f = sphere(1.5).union(s.orient(X), s.orient(Y), s.orient(Z), k=1)
""",
    "boxes": """
c = rounded_box((0.2, 1e9, 1.5), 0.1).translate(Z * 1.5 / 2).repeat((2.4, 0, 0))
f = rounded_box((11.75, 5.75, 1e9), 0.5)
f &= slab(z0=0.125).k(0.25)
c &= f
f = f.shell(0.25)
f &= slab(z1=2).k(0.125)
f = f | c
""",
    "flat": """
f = hexagon(1).extrude(1) | rectangle(2).extrude_to(circle(1), 2, ease.in_out_quad).translate(X * np.float64(3))
f |= d2.slab(x0=-1, x1=1, y0=0, y1=1).revolve(3).slice().extrude(0.1) | rounded_x(2, degrees(radians(0.2))).extrude(1)
""",
}
INSIDE = {
    "solids": (0.7, 0.7, 0),
    "gear": (1.3, 0, 0),
    "knurled": (0.6, 0, 1),
    "pawn": (0, 0, 0.15),
    "woven": (11, 0, 0),
    "blobs": (0, 0, 3),
    "boxes": (0, 0, 0.2),
    "flat": (0, 0, 0),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_run_with_another_import_line(name):
    names: dict[str, Any] = {}
    exec("from bobrossnet.sdf import *\n" + PROGRAMS[name], names)
    shape = names["f"]
    assert isinstance(shape, SDF3)
    assert shape([INSIDE[name]])[0, 0] < 0
    assert shape([(100, 0, 50)])[0, 0] > 0


def test_star_import_prefers_three_dimensions():
    names: dict[str, Any] = {}
    exec("from bobrossnet.sdf import *", names)
    assert names["union"] is d3.union
    assert names["slab"] is d3.slab
    assert names["circle"] is d2.circle
    assert names["X"] is d3.X
    assert {"d2", "d3", "ease", "np", "pi", "degrees", "radians", "SDF2", "SDF3", "UP", "ORIGIN"} <= names.keys()


def test_operations_suit_the_shapes_dimensions():
    assert d3.union(d2.circle(), d2.rectangle()).dimensions == 2
    assert d3.translate(d2.circle(), (1, 2)).expression == d2.circle().translate((1, 2)).expression


def test_shapes_from_functions_of_points(points):
    made = SDF3(lambda p: np.linalg.norm(p, axis=1) - 1)
    assert_alike(made(points)[:, 0], sphere(points), points)
    assert made.translate(X).dimensions == 3
    assert isinstance(made, SDF3)


def test_easings_inside_functions():
    t = np.linspace(0, 1, 11)
    rod = d3.capsule(-Z, Z, 0.2)
    bent = rod.bend_linear(-Z, Z, X, lambda t: 1 - ease.in_elastic(1 - t, 0.3))
    assert bent.expression == rod.bend_linear(-Z, Z, X, lambda t: 1 - ease.in_elastic(1 - t, k=0.3)).expression
    along = np.column_stack([0 * t, 0 * t, 2 * t - 1])
    expected = capsule(along - np.outer(1 - in_elastic(1 - t, 0.3), X), -Z, Z, 0.2)
    assert_alike(bent(along)[:, 0], expected, along)


def test_shapes_are_pickled():
    shape = pickle.loads(pickle.dumps(d3.sphere(2).k(0.5)))
    assert shape.expression == d3.sphere(2).expression
    assert (d3.box() | shape).expression == (d3.box() | d3.sphere(2).k(0.5)).expression


def test_help_shows_names_defaults_and_meaning():
    assert str(inspect.signature(d3.sphere)) == "(radius=1, center=(0, 0, 0))"
    assert str(inspect.signature(d3.bend_linear)) == "(other, p0, p1, v, e=ease.linear)"
    assert str(inspect.signature(d2.SDF2.union)) == "(self, *bs, k=None)"
    assert str(inspect.signature(ease.in_elastic)) == "(t, k=0.5)"
    for word in WORDS:
        function = getattr({0: ease, 2: d2, 3: d3}[word.dimensions], word.name)
        assert function.__name__ == word.name
        assert function.__doc__.startswith(word.meaning)


# ---- Errors ----------------------------------------------------------------------------------------------

MISTAKES = {
    "sphere: radius: expected a number, got a 3D shape": lambda: d3.sphere(d3.box()),
    "sphere: radius: expected a number, got a string": lambda: d3.sphere("1"),
    "sphere: radius: expected a number, got True": lambda: d3.sphere(True),
    "sphere: radius: expected finite numbers, got nan": lambda: d3.sphere(np.nan),
    "sphere: radius: expected finite numbers, got inf": lambda: d3.sphere(10**400),
    "sphere: center: expected a 3D vector, got a list of 2 numbers": lambda: d3.sphere(center=(1, 2)),
    "sphere: expected an argument named one of radius, center, got size": lambda: d3.sphere(size=1),
    "sphere: radius: expected one argument, got two": lambda: d3.sphere(1, radius=1),
    "torus: r2: expected a number, got nothing": lambda: d3.torus(1),
    "torus: expected at most 2 arguments (r1, r2), got 3": lambda: d3.torus(1, 2, 3),
    "box: size: expected finite numbers, got (1, inf, 2)": lambda: d3.box((1, np.inf, 2)),
    "box: b: expected a corner, as the other is given, got None": lambda: d3.box(a=X),
    "plane: normal: expected a vector of a length above 0, got (0, 0, 0)": lambda: d3.plane((0, 0, 0)),
    "slab: expected at least one of x0, y0, z0, x1, y1, z1, got none": lambda: d3.slab(),
    "capsule: b: expected another point than a, got (0, 0, 1)": lambda: d3.capsule(Z, Z, 1),
    "rounded_cone: h: expected a number other than 0, got 0": lambda: d3.rounded_cone(1, 1, 0),
    "rounded_cone: h: expected a number of at least |r1 - r2|, got 1": lambda: d3.rounded_cone(1, 4, 1),
    "ellipsoid: size: expected numbers other than 0, got (1, 0, 2)": lambda: d3.ellipsoid((1, 0, 2)),
    "scale: factor: expected numbers other than 0, got 0": lambda: d3.sphere().scale(0),
    "circular_array: count: expected a whole number, got 2.5": lambda: d3.sphere().circular_array(2.5),
    "circular_array: count: expected a whole number in 1..10000, got 0": lambda: d2.circle().circular_array(0),
    "repeat: count: expected whole numbers of at least 0, got -1": lambda: d3.sphere().repeat(1, -1),
    "repeat: padding: expected at most 10000 copies of the shape, got 50": lambda: d3.sphere().repeat(1, padding=50),
    "polygon: points: expected at least 3 different points, got ((0, 0), (1, 1), (0, 0))": lambda: d2.polygon(
        [(0, 0), (1, 1), (0, 0)]
    ),
    "polygon: points: expected a list of 2D points, got a list of 2": lambda: d2.polygon([(0, 0), (1, 1, 1)]),
    "vesica: d: expected a number of at most r, got 2": lambda: d2.vesica(1, 2),
    "rounded_rectangle: radius: expected a number or 4 numbers, got (1, 2)": lambda: d2.rounded_rectangle(1, (1, 2)),
    "bend_linear: p1: expected another point than p0, got (1, 0, 0)": lambda: d3.sphere().bend_linear(X, X, Y),
    "bend_radial: r1: expected another number than r0, got 1": lambda: d3.sphere().bend_radial(1, 1, 1),
    "bend_linear: e: expected an easing function, got a number": lambda: d3.sphere().bend_linear(X, Y, Z, 1),
    "union: k: expected a number of at least 0, got -1": lambda: d3.union(d3.sphere(), d3.box(), k=-1),
    "union: bs: expected a 3D shape, got a number": lambda: d3.union(d3.sphere(), 1),
    "union: bs: expected a 3D shape, got a 2D shape": lambda: d3.sphere() | d2.circle(),
    "extrude: other: expected a 2D shape, got a 3D shape": lambda: d2.extrude(d3.sphere(), 1),
    "extrude_to: h: expected a number other than 0, got 0": lambda: d2.circle().extrude_to(d2.circle(), 0),
    "shape.k: k: expected a number of at least 0, got -1": lambda: d3.sphere().k(-1),
    "in_elastic: k: expected a number other than 0, got 0": lambda: ease.in_elastic(0.5, 0),
    "in_quad: t: expected a number or an array, got str": lambda: ease.in_quad("half"),
    "linear: missing a required argument: 't'": lambda: ease.linear(),
    "sphere: radius: expected a number, a vector, a shape or an easing function, got dict": lambda: d3.sphere({}),
    "points: expected shape (n, 3), got (1, 2)": lambda: d3.sphere()([(1, 2)]),
}


@pytest.mark.parametrize("message", MISTAKES)
def test_mistakes_are_told_in_one_line(message):
    with pytest.raises(InputError) as raised:
        MISTAKES[message]()
    assert str(raised.value) == message


def test_wrong_types_are_type_errors():
    with pytest.raises(InputTypeError):
        d3.sphere("1")
    with pytest.raises(TypeError, match="unsupported operand"):
        d3.sphere() | 1


def test_models_beyond_all_size_are_refused():
    shape = d2.polygon([(np.cos(a), np.sin(a)) for a in np.linspace(0, 6, 500)])
    with pytest.raises(InputError, match="1048576 steps"):
        shape.circular_array(9999)


# ---- Pictures --------------------------------------------------------------------------------------------


def test_save_draws_a_picture(tmp_path, monkeypatch):
    traced = {}

    def trace(shape, camera, *, size):
        traced.update(shape=shape, camera=camera, size=size)
        return bob.trace(bob.happy_tree(), camera, size=size)

    monkeypatch.setattr(solid, "trace", trace)
    camera = bob.Camera(azimuth=10)
    shape = d3.sphere()
    shape.save(tmp_path / "a.png", samples=2**20, bounds=((-1, -1, -1), (1, 1, 1)), size=(30, 40), camera=camera)
    assert (tmp_path / "a.png").exists()
    assert traced["shape"].expression == shape.expression
    assert traced["shape"].bounds.tolist() == [[-1, -1, -1], [1, 1, 1]]
    assert traced["camera"] is camera
    assert traced["size"] == (30, 40)


def test_programs_are_traced():
    names: dict[str, Any] = {}
    exec("from bobrossnet.sdf import *\n" + PROGRAMS["solids"], names)
    seen = bob.trace(names["f"], bob.Camera(azimuth=30, elevation=20), size=(40, 60))
    assert 0.1 < (seen.gray > 0).mean() < 0.5


def test_the_module_has_all_words():
    words = {word.name for word in sdf.words.WORDS if word.kind != "easing"}
    assert words < set(sdf.__all__) == {name for name in vars(sdf) if name in sdf.__all__}
    modules = (sdf.d2, sdf.d3, sdf.custom, sdf.lettering, sdf.masks, sdf.meshes)
    assert set(sdf.__all__) >= {name for module in modules for name in module.__all__}
