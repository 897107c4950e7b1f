"""Built, turned and carved objects: buildings, furniture, vessels, game pieces, letters."""

# mypy: disable-error-code="no-any-return"
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet.learn.shapes.copies import around
from bobrossnet.sdf import d2
from bobrossnet.sdf.d3 import (
    ORIGIN,
    X,
    Y,
    Z,
    box,
    capped_cone,
    capped_cylinder,
    cylinder,
    rounded_box,
    slab,
    sphere,
    torus,
)
from bobrossnet.tracing.scene import SceneLike

Rng = np.random.Generator


def die(rng: Rng) -> SceneLike:
    """A die with pips, with corners rounded or cut by a ball."""
    solid = rounded_box(2, rng.uniform(0.02, 0.5))
    if rng.random() < 0.5:
        solid &= sphere(rng.uniform(1.35, 1.6))
    pip, apart = rng.uniform(0.12, 0.22), rng.uniform(0.4, 0.55)
    hollow = sphere(pip).translate(Z)
    one = hollow
    pairs = hollow.translate((apart, apart, 0)) | hollow.translate((-apart, -apart, 0))
    four = pairs | pairs.rotate(np.pi / 2)
    six = four | hollow.translate((apart, 0, 0)) | hollow.translate((-apart, 0, 0))
    faces = [one, six.rotate(np.pi, X), pairs.rotate(np.pi / 2, X), (four | one).rotate(-np.pi / 2, X)]
    faces += [(pairs | one).rotate(np.pi / 2, Y), four.rotate(-np.pi / 2, Y)]
    for face in faces:
        solid = solid.difference(face, k=rng.choice([0.005, 0.05]))
    return solid


def building(rng: Rng) -> SceneLike:
    """A tower of shrinking storeys with rows of windows, a door, and a roof: flat, pitched or with a dome."""
    size = np.array([rng.uniform(0.8, 1.6), rng.uniform(0.8, 1.6), rng.uniform(0.8, 2.4)])
    blocks, low = int(rng.integers(1, 4)), 0.0
    pitch = rng.uniform(0.2, 0.4, 2)
    window = rng.uniform(0.4, 0.7, 2) * pitch
    windows = box((window[0], 9, window[1])).repeat((pitch[0], 0, pitch[1])).translate((pitch[0] / 2, 0, pitch[1] / 2))
    across = windows.rotate(np.pi / 2)
    depth = rng.uniform(0.03, 0.1)
    solid = box(a=(-0.65 * size[0], -0.65 * size[1], -0.12), b=(0.65 * size[0], 0.65 * size[1], 0))
    for _ in range(blocks):
        block = box(a=(-size[0] / 2, -size[1] / 2, low), b=(size[0] / 2, size[1] / 2, low + size[2]))
        if rng.random() < 0.2:
            block = capped_cylinder(Z * low, Z * (low + size[2]), size[:2].min() / 2)
        cut = (windows & slab(x0=depth - size[0] / 2, x1=size[0] / 2 - depth)) | (
            across & slab(y0=depth - size[1] / 2, y1=size[1] / 2 - depth)
        )
        cut &= slab(z0=low + 0.08, z1=low + size[2] - 0.08)
        solid |= block - (cut - block.erode(depth))
        solid |= box((size[0] + 0.1, size[1] + 0.1, 0.06)).translate(Z * (low + size[2]))
        low += size[2]
        size *= (*rng.uniform(0.5, 0.85, 2), rng.uniform(0.4, 0.9))
    size[:2] *= 1.5
    kind = rng.choice(["flat", "pitched", "dome", "spire"])
    if kind == "pitched":
        gable = d2.polygon([(-size[0] / 2, 0), (size[0] / 2, 0), (0, 0.5 * size[0])]).extrude(size[1])
        solid |= gable.rotate(np.pi / 2, X).translate(Z * low)
    elif kind == "dome":
        solid |= (sphere(0.45 * size[:2].min()) & slab(z0=0)).translate(Z * low)
    elif kind == "spire":
        solid |= capped_cone(Z * low, Z * (low + rng.uniform(0.5, 1.5)), 0.35 * size[:2].min(), 0.01)
    return solid


def castle(rng: Rng) -> SceneLike:
    """Walls with battlements, corner towers, a keep and a gate, with or without conical roofs."""
    corners = int(rng.integers(3, 7))
    tower, tall, wall = rng.uniform(0.15, 0.3), rng.uniform(0.7, 1.4), rng.uniform(0.35, 0.6)
    half = np.pi / corners
    inner = np.cos(half)
    side = d2.rectangle((0.12, 2 * np.sin(half) + 0.01)).extrude(wall).translate(Z * wall / 2)
    side -= box((1, 0.07, 0.2)).repeat((0, 0.14, 0)).translate(Z * wall)
    walls = around(side, corners, inner).rotate(half)
    turret = capped_cylinder(ORIGIN, Z * tall, tower) | capped_cylinder(
        Z * (tall - 0.2), Z * (tall + 0.05), 1.2 * tower
    )
    if rng.random() < 0.5:
        turret |= capped_cone(Z * tall, Z * (tall + rng.uniform(0.3, 0.8)), 1.3 * tower, 0.01)
    else:
        turret -= cylinder(0.9 * tower) & slab(z0=tall - 0.05)
        turret -= around(box((9, 0.1, 0.2)) & slab(x0=0), int(rng.integers(3, 8))).translate(Z * tall)
    turret -= box((9, 0.05, 0.2)).translate(Z * 0.6 * tall)
    solid = walls | around(turret, corners, 1)
    keep = rng.uniform(1, 1.8)
    if rng.random() < 0.8:
        hold = box(a=(-0.3, -0.3, 0), b=(0.3, 0.3, keep)) - box((0.1, 9, 0.15)).repeat((0.2, 0, 0.4)).translate(Z * 0.3)
        solid |= hold | box((0.7, 0.7, 0.15)).translate(Z * keep)
    gate = (d2.rectangle((0.22, 0.4)) | d2.circle(0.11, (0, 0.2))).extrude(1).rotate(np.pi / 2, X).rotate(np.pi / 2)
    solid -= gate.translate((inner, 0, 0.05)).rotate(half)
    return solid | capped_cylinder(-Z * 0.1, ORIGIN, 1.35)


def mug(rng: Rng) -> SceneLike:
    """A mug, a bowl or a vase on a foot, with or without handles, flutes or a saucer."""
    tall, wall = rng.uniform(0.6, 2), rng.uniform(0.03, 0.1)
    count = 8
    heights = np.linspace(0, tall, count)
    phase, swing, lean = rng.uniform(0, 2 * np.pi), rng.uniform(0, 0.25), rng.uniform(-0.1, 0.3)
    radii = 0.7 + lean * (heights / tall - 0.5) + swing * np.sin(phase + heights / tall * rng.uniform(1, 5))
    outline = np.stack([np.maximum(radii, 0.15), heights], 1)
    body = d2.polygon([(-1, 0), *outline, (-1, tall)])  # extended across the axis, to leave no edge there
    hollow = outline - (wall, 0)
    hollow[0, 1] = wall
    inside = d2.polygon([(-1, wall), *hollow, (hollow[-1, 0], tall + 0.2), (-1, tall + 0.2)]).revolve()
    solid = body.revolve()
    if rng.random() < 0.4:
        flutes = int(rng.integers(6, 13))
        flute = min(1.5 / flutes, wall)  # not through the wall
        solid -= around(cylinder(flute), flutes, radii.max() + 0.3 * flute)
    handles = int(rng.integers(0, 3))
    if handles:
        ring = torus(rng.uniform(0.22, 0.38) * tall, rng.uniform(0.04, 0.1)).rotate(np.pi / 2, X)
        ring = ring.scale((rng.uniform(0.7, 1.1), 1.3, 1)).translate(Z * tall / 2)
        solid = solid.union(around(ring, handles, 0.95 * radii[count // 2]), k=0.08)
    solid -= inside
    if rng.random() < 0.3:
        solid |= capped_cylinder(-Z * 0.06, Z * wall, 1.3) - (sphere(4).translate(Z * 4.03) - cylinder(0.4))
    return solid


def turned_piece(rng: Rng) -> SceneLike:
    """A chess piece, a baluster or a lamp, turned on a lathe, with a carved head."""
    count, tall = int(rng.integers(8, 16)), rng.uniform(1.5, 3)
    heights = np.sort(rng.uniform(0.12, 1, count - 1)) * tall
    radii = rng.uniform(0.12, 0.5, count - 1) * rng.choice([0.6, 1], count - 1)
    if rng.random() < 0.6:  # taper towards the head
        radii *= np.linspace(1.3, 0.7, count - 1)
    base = rng.uniform(0.5, 0.8)
    outline = d2.polygon([(-1, 0), (base, 0), (base, 0.1 * tall), *zip(radii, heights, strict=True), (-1, heights[-1])])
    rounding = rng.choice([0, 0.03, 0.06])
    solid = outline.dilate(rounding).revolve()
    for height in rng.choice(heights, 3):
        solid = solid.union(torus(rng.uniform(0.15, 0.35), rng.uniform(0.03, 0.07)).translate(Z * height), k=0.04)
    head = rng.uniform(0.25, 0.45)
    top = Z * (heights[-1] + 0.6 * head)
    kind = rng.choice(["ball", "crown", "tower", "cross", "shade"])
    if kind == "ball":
        solid = solid.union(sphere(head).translate(top), k=0.08)
        solid -= box((0.06, 2, 2 * head)).rotate(0.5, Y).translate(top + X * 0.5 * head)
    elif kind == "shade":
        shade = capped_cone(top, top + Z * 0.8, 1.6 * head, head)
        solid |= shade.shell(0.04) & slab(z0=top[2] + 0.05, z1=top[2] + 0.75) | capped_cylinder(
            ORIGIN, top + Z * 0.5, 0.05
        )
    elif kind == "cross":
        solid |= (box((0.6 * head, 0.2, 2 * head)) | box((1.6 * head, 0.2, 0.6 * head))).translate(top)
    else:
        crown = capped_cone(top - Z * head, top + Z * 0.5 * head, 0.6 * head, head) - sphere(0.8 * head).translate(
            top + Z * 0.8 * head
        )
        teeth = int(rng.integers(2, 6))
        solid |= crown - around(box((9, 0.12, 0.5 * head)), teeth).translate(top + Z * 0.5 * head)
    return solid


def letter(rng: Rng) -> SceneLike:
    """Strokes as in letters, straight and round, extruded with sharp or rounded edges."""
    wide, thick = rng.uniform(0.08, 0.2), rng.uniform(0.15, 0.6)
    rounding = rng.choice([0, 0.3, 0.8]) * wide
    square = rng.random() < 0.5
    row = int(rng.integers(1, 4))
    outline = None
    for place in range(row):
        for _ in range(int(rng.integers(2, 5))):
            a, b = rng.integers((-1, -2), (2, 3), (2, 2)) * (0.5, 0.5)
            if rng.random() < 0.3 or (a == b).all():
                radius = rng.choice([0.35, 0.5])
                stroke = d2.circle(radius).shell(2 * wide).translate((0, rng.choice([-0.5, 0.5])))
                if rng.random() < 0.6:
                    stroke &= d2.line(rng.choice([-1, 1]) * np.array([1, 0]))
            else:
                length = float(np.linalg.norm(b - a))
                end = 0.0 if square else 0.99 * wide
                stroke = d2.rounded_rectangle((length + 2 * wide, 2 * wide), end)
                stroke = stroke.rotate(-np.arctan2(*(b - a)[::-1])).translate((a + b) / 2)
            stroke = stroke.translate((1.5 * (place - (row - 1) / 2), 0))
            outline = stroke if outline is None else outline | stroke
    assert outline is not None
    solid = outline.erode(rounding).extrude(thick).dilate(rounding) if rounding else outline.extrude(thick)
    if rng.random() < 0.3:
        solid |= box((1.5 * row + 0.2, 2.6, 0.1)).translate(-Z * thick / 2)
    return solid.rotate(np.pi / 2, X)


def outline(rng: Rng) -> SceneLike:
    """An outline, extruded or tapered to another: a star, a polygon of random corners, a cloud; hollow or pierced."""
    corners = int(rng.integers(3, 13))
    angles = np.arange(2 * corners) * np.pi / corners
    kind = rng.choice(["star", "random", "cloud"])
    if kind == "star":
        radii = np.where(np.arange(2 * corners) % 2, rng.uniform(0.4, 0.85), 1)
    else:
        radii = rng.uniform(0.5, 1, 2 * corners)
    flat = d2.polygon(np.stack([radii * np.cos(angles), radii * np.sin(angles)], 1))
    if kind == "cloud":
        flat = d2.circle(0.6).union(
            d2.circle(rng.uniform(0.2, 0.35)).translate((0.65, 0)).circular_array(corners), k=0.1
        )
    height, rounding = rng.uniform(0.2, 1.5), rng.choice([0, 0.04, 0.1])
    if rng.random() < 0.3:
        solid = flat.extrude_to(flat.scale(rng.uniform(0.3, 0.8)).rotate(rng.uniform(0, 1)), height)
    else:
        solid = flat.erode(rounding).extrude(height).dilate(rounding) if rounding else flat.extrude(height)
    kind = rng.choice(["solid", "hollow", "pierced", "cup"])
    if kind == "hollow":
        solid -= flat.erode(rng.uniform(0.05, 0.15)).extrude(9)
    elif kind == "pierced":
        solid -= around(cylinder(rng.uniform(0.05, 0.12)), corners, 0.35)
    elif kind == "cup":
        solid -= flat.erode(0.08).extrude(height).translate(Z * 0.1)
    return solid


def furniture(rng: Rng) -> SceneLike:
    """A chair, a table, a bench or shelves: boards on legs, square or round, straight or splayed."""
    size = np.array([rng.uniform(0.6, 2), rng.uniform(0.6, 1.2), rng.uniform(0.5, 1.2)])
    board, leg = rng.uniform(0.04, 0.14), rng.uniform(0.03, 0.09)
    rounding = rng.choice([0.005, 0.03])
    x, y, z = size * (0.5, 0.5, 1)
    if rng.random() < 0.25:
        shelves = int(rng.integers(2, 6))
        tall = rng.uniform(1, 2.5)
        cells = rounded_box((2 * x, 2 * y, tall), rounding)
        hollow = box((2 * x - 0.12, 2 * y, tall / shelves - 0.06))
        for level in range(shelves):
            cells -= hollow.translate((0, -0.06, (level + 0.5) * tall / shelves - tall / 2))
            if rng.random() < 0.5:
                at = rng.uniform(-0.7, 0.7) * x
                cells |= box((0.06, 2 * y - 0.02, tall / shelves)).translate(
                    (at, 0, (level + 0.5) * tall / shelves - tall / 2)
                )
        return cells
    solid = rounded_box((2 * x + 0.1, 2 * y + 0.1, board), min(rounding, 0.4 * board)).translate(Z * z)
    splay = rng.choice([0, 0.12])
    for right in (-1, 1):
        for front in (-1, 1):
            top = np.array([right * (x - leg), front * (y - leg), z])
            foot = top * (1 + splay, 1 + splay, 0)
            if splay or rounding > 0.01:
                solid |= capped_cone(foot, top, 0.7 * leg, leg)
            else:
                solid |= box(a=(*(top[:2] - leg), 0), b=(*(top[:2] + leg), z))
    if rng.random() < 0.5:
        solid |= box((2 * x - 2 * leg, 0.05, 0.05)).translate((0, y - leg, 0.4 * z)) | box(
            (2 * x - 2 * leg, 0.05, 0.05)
        ).translate((0, leg - y, 0.4 * z))
    if rng.random() < 0.6:  # a back
        tall = rng.uniform(0.5, 1)
        back = box(a=(-x, y - board, z), b=(x, y, z + tall))
        pitch = 2 * x / int(rng.integers(2, 8))
        gaps = box((0.6 * pitch, 9, 0.7 * tall)) if rng.random() < 0.6 else box((9, 9, 0.1))
        spacing = (pitch, 0, 0) if rng.random() < 0.6 else (0, 0, 0.2)
        inside = box((2 * x - 0.1, 9, 0.8 * tall))
        solid |= back - (gaps.repeat(spacing) & inside).translate(Z * (z + 0.5 * tall))
    return solid


def temple(rng: Rng) -> SceneLike:
    """Columns, fluted or plain, on steps, under a gable or in a circle under a dome."""
    tall, radius = rng.uniform(0.8, 1.5), rng.uniform(0.07, 0.13)
    column = capped_cone(ORIGIN, Z * tall, radius, 0.8 * radius)
    if rng.random() < 0.5:
        column -= around(cylinder(0.2 * radius), 10, radius)
    capital = 2.6 * radius
    column |= box((capital, capital, 0.1)).translate(Z * tall) | capped_cylinder(ORIGIN, Z * 0.08, 1.3 * radius)
    steps = int(rng.integers(1, 5))
    if rng.random() < 0.4:
        count = int(rng.integers(5, 13))
        solid = around(column, count, 1)
        for step in range(steps):
            solid |= capped_cylinder(-Z * 0.1 * (step + 1), -Z * 0.1 * step, 1.2 + 0.12 * step)
        roof = (sphere(1.1) & slab(z0=0)) if rng.random() < 0.5 else capped_cone(ORIGIN, Z * 0.6, 1.2, 0.02)
        return solid | capped_cylinder(Z * (tall + 0.02), Z * (tall + 0.2), 1.15) | roof.translate(Z * (tall + 0.15))
    front, deep = int(rng.integers(1, 4)), int(rng.integers(1, 5))
    pitch = rng.uniform(3.5, 5) * radius
    rows = column.repeat((pitch, pitch, 0), count=(front, deep, 0))
    x, y = (front + 0.4) * pitch, (deep + 0.4) * pitch
    solid = rows - box((2 * x - 1.3 * pitch, 2 * y - 1.3 * pitch, 9))
    for step in range(steps):
        wide = 0.1 * (step + 1)
        solid |= box(a=(-x - wide, -y - wide, -0.1 * (step + 1)), b=(x + wide, y + wide, -0.1 * step))
    if rng.random() < 0.6:
        solid |= box(a=(0.65 * pitch - x, 0.65 * pitch - y, 0), b=(x - 0.65 * pitch, y - 0.65 * pitch, tall))
    solid |= box(a=(-x, -y, tall), b=(x, y, tall + 0.15))
    gable = d2.polygon([(-1.1 * x, 0), (1.1 * x, 0), (0, rng.uniform(0.3, 0.7) * x)]).extrude(2.1 * y)
    return solid | gable.rotate(np.pi / 2, X).translate(Z * (tall + 0.15))


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {
    family.__name__: family for family in (die, building, castle, mug, turned_piece, letter, outline, furniture, temple)
}
