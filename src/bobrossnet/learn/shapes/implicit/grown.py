"""Organic solids: smooth blends of simple ones."""

# mypy: disable-error-code="no-any-return"
from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bobrossnet.learn.shapes.copies import around
from bobrossnet.sdf.d3 import ORIGIN, SDF3, X, Y, Z, box, capsule, ellipsoid, plane, rounded_box, slab, sphere
from bobrossnet.tracing.scene import SceneLike

Rng = np.random.Generator


def _direction(rng: Rng) -> NDArray[np.float64]:
    """Return a unit vector, uniform on the sphere."""
    vector: NDArray[np.float64] = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _blob(rng: Rng, count: int, k: float) -> SDF3:
    centers, radii = [np.zeros(3)], [rng.uniform(0.4, 0.7)]
    solid = sphere(radii[0])
    for _ in range(count):
        near = int(rng.integers(len(radii)))
        radius = rng.uniform(0.2, 0.55)
        center = centers[near] + 0.9 * radii[near] * _direction(rng)
        solid = solid.union(sphere(radius, center), k=k)
        centers.append(center)
        radii.append(radius)
    return solid


def blob(rng: Rng) -> SceneLike:
    """Blended balls, with or without dents or flat cuts."""
    solid = _blob(rng, int(rng.integers(3, 13)), rng.uniform(0.02, 0.4))
    if rng.random() < 0.3:
        solid -= sphere(rng.uniform(0.3, 0.6), 0.7 * _direction(rng)).k(rng.uniform(0.02, 0.2))
    if rng.random() < 0.3:
        solid &= plane(_direction(rng), 0.3 * _direction(rng))
    return solid


def creature(rng: Rng) -> SceneLike:
    """A symmetric animal or doll: body, head, limbs, ears or horns, eyes, with or without a snout and a tail."""
    k = rng.uniform(0.04, 0.15)
    upright = rng.random() < 0.5
    body = np.array([rng.uniform(0.3, 0.5), rng.uniform(0.3, 0.5), rng.uniform(0.5, 0.8)])
    if not upright:
        body = body[[0, 2, 1]]
    _, deep, tall = body
    solid = ellipsoid(body)
    head = rng.uniform(0.25, 0.45)
    at = np.array([0, 0 if upright else -deep - 0.3 * head, tall + rng.uniform(0.1, 0.8) * head])
    solid = solid.union(capsule((0, 0 if upright else -0.7 * deep, 0.5 * tall), at, 0.5 * head), k=k)
    solid = solid.union(sphere(head, at), k=0.5 * k)
    if rng.random() < 0.6:
        solid = solid.union(capsule(at, at - Y * head * rng.uniform(1, 1.6), head * rng.uniform(0.3, 0.6)), k=k)
    ears, ear_length = rng.uniform(0.08, 0.2), rng.uniform(0.8, 2.2)
    lean = np.array([rng.uniform(0.3, 1), 0, 1]) * ear_length * head
    leg, length = rng.uniform(0.1, 0.18), rng.uniform(0.4, 1)
    reach = rng.uniform((0.4, -0.5, -0.6), (1, 0.2, 0.6))
    tail = rng.uniform((-0.3, 0.4, -0.2), (0.3, 1, 0.8))
    for side in (np.array([-1, 1, 1]), np.array([1, 1, 1])):
        ear = capsule(at, at + side * lean, ears)
        solid = solid.union(ear, k=0.5 * k)
        rows = [0.0] if upright else [-0.6 * deep, 0.6 * deep]
        for row in rows:
            hip = np.array([0.55 * body[0], row, -0.4 * tall])
            foot = hip + (0.1, 0, -0.5 * tall - length)
            solid = solid.union(capsule(side * hip, side * foot, leg), k=k)
            solid = solid.union(ellipsoid((1.2 * leg, 2 * leg, leg)).translate(side * foot - Y * leg), k=0.5 * k)
        if upright:
            shoulder = np.array([0.7 * body[0], 0, 0.5 * tall])
            hand = shoulder + reach
            solid = solid.union(capsule(side * shoulder, side * hand, 0.7 * leg), k=k)
            solid = solid.union(sphere(1.3 * leg, side * hand), k=0.5 * k)
        eye = at + head * np.array([0.4, -0.8, 0.35])
        solid |= sphere(0.18 * head, side * eye)
    if rng.random() < 0.6:
        root = np.array([0, 0.8 * deep, -0.3 * tall])
        solid = solid.union(capsule(root, root + tail, 0.6 * leg), k=k)
        solid = solid.union(capsule(root + tail, root + 1.6 * tail * (-1, 1, 1), 0.4 * leg), k=0.5 * k)
    return solid


def hand(rng: Rng) -> SceneLike:
    """A palm with individually bent fingers, and a wrist."""
    count = int(rng.integers(3, 7))
    wide, thick, k = 0.26 * count, rng.uniform(0.2, 0.35), rng.uniform(0.03, 0.12)
    solid = rounded_box((wide, 1, thick), 0.45 * thick)
    solid = solid.union(
        capsule(ORIGIN, (0, -rng.uniform(0.8, 1.6), 0), rng.uniform(0.25, 0.4)).scale((1, 1, 0.7)), k=0.2
    )
    radius = rng.uniform(0.09, 0.13)
    for finger, across in enumerate(np.linspace(-0.42, 0.42, count) * wide):
        joint = np.array([across, 0.45, 0])
        curl, spread = rng.uniform(0, 0.9), rng.normal(across * 0.3, 0.08)
        for bone in range(3):
            length = rng.uniform(0.25, 0.4) * (0.75 if finger in (0, count - 1) else 1)
            angle = (bone + 0.3) * curl
            end = joint + length * np.array([np.sin(spread), np.cos(angle), np.sin(angle)])
            solid = solid.union(capsule(joint, end, radius * (1 - 0.12 * bone)), k=k if bone == 0 else 0.02)
            joint = end
    knuckle = np.array([0.5 * wide + rng.uniform(0.2, 0.35), rng.uniform(0, 0.2), rng.uniform(0, 0.3)])
    solid = solid.union(capsule((0.3 * wide, -0.3, 0), knuckle, 1.2 * radius), k=k)
    solid = solid.union(capsule(knuckle, knuckle + (0.08, 0.35, rng.uniform(0, 0.2)), radius), k=0.02)
    return solid.rotate(np.pi / 2, X)


def coral(rng: Rng) -> SceneLike:
    """A tree of forking, tapering branches, with or without balls at their ends."""
    k, spread, keep = rng.uniform(0.01, 0.08), rng.uniform(0.3, 0.9), rng.uniform(0.6, 0.85)
    thin, buds = rng.uniform(0.6, 0.85), rng.random() < 0.5
    radius = rng.uniform(0.05, 0.16)
    tips = [(np.zeros(3), np.array([0.0, 0, 1]), radius, 0.7)]
    solid = capsule(ORIGIN, Z * 0.02, 1.3 * radius)
    most = int(rng.integers(16, 45))
    for _ in range(most):
        start, direction, radius, length = tips.pop(0)
        end = start + length * direction
        solid = solid.union(capsule(start, end, radius), k=k)
        for _ in range(int(rng.integers(2, 4))):
            aside = direction + spread * rng.normal(size=3)
            tips.append((end, aside / np.linalg.norm(aside), max(thin * radius, 0.02), length * rng.uniform(keep, 1)))
    if buds:
        for start, _, radius, _ in tips[::2]:
            solid = solid.union(sphere(2.2 * radius, start), k=k)
    return solid


def skin(rng: Rng) -> SceneLike:
    """A thin skin around a blob or a twisted bar, cut open by a plane or pierced by balls."""
    solid = _blob(rng, int(rng.integers(1, 6)), rng.uniform(0.1, 0.4))
    thick = rng.uniform(0.02, 0.1)
    skin = solid.shell(thick)
    if rng.random() < 0.4:
        skin = skin | solid.erode(rng.uniform(0.12, 0.2)).shell(thick)
    if rng.random() < 0.6:
        skin &= plane(_direction(rng) - Z, rng.uniform(-0.2, 0.2) * Z)
    else:
        for _ in range(int(rng.integers(2, 7))):
            skin -= sphere(rng.uniform(0.15, 0.45), rng.uniform(0.5, 1) * _direction(rng) + 0.2 * Z).k(0.02)
    return skin


def foam(rng: Rng) -> SceneLike:
    """A lattice of balls, inside the shape of a solid or subtracted from it."""
    pitch = rng.uniform(0.3, 0.8)
    radius = pitch * rng.uniform(0.35, 0.62)
    shift = rng.uniform(0, pitch, 3)
    balls = sphere(radius).repeat(pitch, padding=1 if radius > 0.5 * pitch else 0).translate(shift)
    whole = [
        lambda: sphere(1),
        lambda: rounded_box(rng.uniform(1.2, 2, 3), 0.1),
        lambda: capsule(-Z * 0.6, Z * 0.6, 0.7),
        lambda: _blob(rng, 4, 0.3),
    ][rng.integers(4)]()
    if radius < 0.48 * pitch and rng.random() < 0.5:
        return balls & whole
    k = rng.uniform(0.01, 0.1)
    if rng.random() < 0.5:
        return whole.difference(balls, k=k)
    return whole.erode(0.5 * radius).union(balls & whole, k=k)


def twisted_bar(rng: Rng) -> SceneLike:
    """Parallel bars, a cross or a bent slab, twisted about their length, tapered, straight or bowed."""
    count, tall = int(rng.integers(2, 7)), rng.uniform(1, 2.5)
    kind = rng.choice(["cord", "slab", "prism"])
    if kind == "cord":
        strand = capsule(-Z * 9, Z * 9, rng.uniform(0.5, 1) * 0.9 / count)
        solid = around(strand, count, rng.uniform(0.3, 0.5))
    elif kind == "slab":
        solid = box((1.1, rng.uniform(0.08, 0.4), 9))
        if rng.random() < 0.5:
            solid |= solid.rotate(np.pi / 2)
    else:
        solid = box((rng.uniform(0.5, 0.9), rng.uniform(0.5, 0.9), 9)).dilate(rng.choice([0, 0.1]))
    solid = solid.twist(rng.uniform(0.5, 4)) & slab(z0=-tall / 2, z1=tall / 2).k(rng.choice([0.01, 0.1]))
    bow = rng.choice([0, 0.3, 0.8])
    if bow:
        solid = solid.bend_linear(-Z * tall / 2, Z * tall / 2, X * bow)
    if rng.random() < 0.5:
        solid |= ellipsoid((0.8, 0.8, 0.2)).translate(-Z * tall / 2).k(0.1)
    return solid


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {
    family.__name__: family for family in (blob, creature, hand, coral, skin, foam, twisted_bar)
}
