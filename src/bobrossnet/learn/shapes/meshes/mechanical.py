"""Machines and their parts: gears, plates with holes, bolts, jointed arms, vehicles."""

from __future__ import annotations

import numpy as np

from bobrossnet.learn.shapes.meshes import parts
from bobrossnet.learn.shapes.meshes.parts import Part, Rng, join, moved, ring, rotation


def gear(rng: Rng) -> Part:
    """Toothed or lobed wheels with a bore, a hub and holes, sometimes two that mesh."""
    teeth = int(rng.integers(6, 40))
    steps = 8
    phase = (np.arange(teeth * steps) % steps) / steps
    depth = rng.uniform(0.05, 0.25)
    toothed = rng.random() < 0.7
    shape = np.clip(2.5 * np.abs(2 * phase - 1) - 0.75, 0, 1) if toothed else 0.5 + 0.5 * np.cos(2 * np.pi * phase)
    circle = parts.round_outline(teeth * steps)
    outer, bore, height = circle * (1 - depth * shape)[:, None], rng.uniform(0.1, 0.65), rng.uniform(0.08, 0.7)
    pieces = [parts.extrude(outer, circle * bore, height)]
    if rng.random() < 0.5:  # a hub
        pieces.append(parts.extrude(circle * (bore + 0.12), circle * bore, height * rng.uniform(1.2, 2.5)))
    if rng.random() < 0.4:  # an axle
        pieces.append(moved(parts.cylinder(bore * 0.9, height * 4, 32), offset=(0, 0, -height)))
    if rng.random() < 0.4:  # pins
        pieces += ring(parts.cylinder(0.06, height * 1.2, 12), (bore + 1 - depth) / 2, int(rng.integers(3, 12)))
    if rng.random() < 0.25:  # a second that meshes
        pieces += [moved(piece, rotation(2, np.pi / teeth), (2 - depth, 0, 0)) for piece in pieces]
    return join(pieces)


def flange(rng: Rng) -> Part:
    """Plates with holes, alone, at right angles, or stacked on posts: brackets, perforated sheets, boards."""
    nx, ny = int(rng.integers(1, 9)), int(rng.integers(1, 9))
    thickness = rng.uniform(0.05, 0.5)
    first = parts.plate((nx, ny), rng.uniform(0.1, 0.45), thickness, int(rng.choice([6, 24, 36])))
    pieces = [first]
    if rng.random() < 0.4:
        upright = parts.plate((nx, int(rng.integers(1, 4))), rng.uniform(0.1, 0.45), thickness)
        pieces.append(moved(upright, rotation(0, np.pi / 2), (0, -0.5 + thickness, 0.5)))
    if rng.random() < 0.3:
        gap = rng.uniform(0.5, 2)
        post = parts.cylinder(0.1, gap, 12)
        pieces.append(moved(first, offset=(0, 0, gap)))
        pieces += [moved(post, offset=(x, y, 0)) for x in (0, nx - 1) for y in (0, ny - 1)]
    if rng.random() < 0.4:
        peg = fastener(rng)
        pieces += [moved(peg, offset=(x, y, 0)) for x in range(nx) for y in range(ny) if rng.random() < 0.5]
    return join(pieces)


def fastener(rng: Rng) -> Part:
    """A bolt, a pin or a stud."""
    head = moved(parts.cylinder(0.3, 0.15, int(rng.choice([6, 24]))), offset=(0, 0, 0.4))
    return join([parts.cylinder(0.15, rng.uniform(0.5, 1.5), 16), head])


def robot_arm(rng: Rng) -> Part:
    """Links and joints in a chain: arms, legs, lamps, cranes."""
    pieces = [parts.cylinder(0.5, 0.25, 32, rng.uniform(0.5, 1))]
    at, radius = np.array([0, 0, 0.25]), rng.uniform(0.1, 0.3)
    turn = np.eye(3)
    for _ in range(int(rng.integers(2, 7))):
        length = rng.uniform(0.3, 1.2)
        kind = rng.integers(3)  # a link is a tube, a bar or two rails
        if kind == 0:
            link = parts.cylinder(radius * 0.7, length, 24, rng.uniform(0.6, 1))
        elif kind == 1:
            link = moved(parts.box(radius * 1.2, radius, length, radius * 0.3), offset=(0, 0, length / 2))
        else:
            rail = parts.box(radius * 0.2, radius, length)
            link = join([moved(rail, offset=(x, 0, length / 2)) for x in (-radius / 2, radius / 2)])
        joint = moved(parts.cylinder(radius, radius * 2, 32), rotation(1, np.pi / 2), (-radius, 0, 0))
        pieces += [moved(joint, turn, at), moved(link, turn, at)]
        at = at + turn @ (0, 0, length)
        turn = turn @ rotation(int(rng.integers(3)), rng.uniform(-1.2, 1.2))
        radius *= rng.uniform(0.75, 1)
    finger = parts.box(radius * 0.3, radius * 0.5, radius * 3)
    pieces += [moved(finger, turn, at + turn @ (side * radius, 0, radius)) for side in (-1, 1)]
    return join(pieces)


def vehicle(rng: Rng) -> Part:
    """A body, a cabin and wheels or rotors: cars, planes, carts, quadrotors."""
    length, width, height = rng.uniform(1.5, 3), rng.uniform(0.6, 1.2), rng.uniform(0.25, 0.7)
    if rng.random() < 0.4:
        body = moved(parts.sphere(64), np.diag([length / 2, width / 2, height]))
    else:
        body = parts.box(length, width, height, rng.uniform(0, 0.2))
    cabin = parts.box(length * rng.uniform(0.2, 0.6), width * 0.85, height, rng.uniform(0.02, 0.15))
    pieces = [body, moved(cabin, offset=(rng.uniform(-0.3, 0.3), 0, height * 0.8))]
    wheel = _wheel(rng)
    axles = int(rng.integers(0, 4))
    for i in range(axles):
        x = length * (0.8 * i / max(axles - 1, 1) - 0.4)
        pieces += [moved(wheel, rotation(0, np.pi / 2), (x, side * width / 2, -height / 2)) for side in (-1, 1)]
    if rng.random() < 0.5:  # wings and a fin
        sheared = np.eye(3) + rng.uniform(-0.3, 0.3) * np.eye(3)[[1, 0, 2]] * 0.3
        pieces.append(moved(parts.box(length * 0.25, 2.5 * width, 0.05), sheared))
        pieces.append(moved(parts.box(0.3, 0.04, 0.7), offset=(-length / 2, 0, height)))
    if rng.random() < 0.3:  # rotors
        blade = join([moved(parts.box(1, 0.08, 0.015), rotation(2, np.pi / 2 * i)) for i in range(2)])
        places = [(x, y) for x in (-0.8, 0.8) for y in (-0.8, 0.8)] if rng.random() < 0.5 else [(0.0, 0.0)]
        for x, y in places:
            pieces.append(moved(blade, rotation(2, rng.uniform(0, 3)), (x, y, height + 0.5)))
            pieces.append(parts.rod(np.array([x * 0.5, y * 0.3, 0]), np.array([x, y, height + 0.5]), 0.04))
    return join(pieces)


def _wheel(rng: Rng) -> Part:
    """A tyre, a disc and spokes."""
    radius = rng.uniform(0.2, 0.45)
    tyre = parts.torus(radius, radius * 0.35, 32, 12)
    disc = moved(parts.cylinder(radius * 0.9, 0.16, 24), offset=(0, 0, -0.08))
    return join([tyre, disc, *ring(parts.box(radius, radius * 0.15, 0.22), radius * 0.4, int(rng.integers(3, 9)))])
