"""Parts of machines: turned, milled, drilled and cast."""

# mypy: disable-error-code="no-any-return"
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bobrossnet import implicit
from bobrossnet.learn.shapes.copies import around
from bobrossnet.sdf import d2
from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.d3 import ORIGIN, SDF3, X, Y, Z, box, capped_cylinder, cylinder, rounded_box, slab, sphere, torus
from bobrossnet.tracing.scene import SceneLike

Rng = np.random.Generator


def drilled_block(rng: Rng) -> SceneLike:
    """A block with stepped bores along its axes, chamfered or rounded."""
    size = rng.uniform(0.8, 2, 3)
    solid = rounded_box(size, rng.uniform(0.01, 0.15)) if rng.random() < 0.5 else box(size)
    k = rng.choice([0.01, 0.05, 0.12])
    for axis, names in ((X, "yz"), (Y, "xz"), (Z, "xy")):
        room = min(size["xyz".index(name)] for name in names)
        if rng.random() < 0.75:
            radius = rng.uniform(0.15, 0.4) * room
            at = rng.uniform(-0.1, 0.1, 3)
            solid = solid.difference(cylinder(radius).translate(at).orient(axis), k=k)
            if rng.random() < 0.5:  # a counterbore
                top = cylinder(min(1.5 * radius, 0.46 * room)) & slab(z0=rng.uniform(0.2, 0.45) * size.min())
                solid = solid.difference(top.translate(at * (1, 1, 0)).orient(axis), k=k)
    if rng.random() < 0.4:
        solid &= sphere(0.5 * float(np.linalg.norm(size)) * rng.uniform(0.75, 0.95))
    return solid


def flange(rng: Rng) -> SceneLike:
    """A disc with a hub, a bore and a circle of bolt holes, with or without ribs from the hub to the disc."""
    disc, height = rng.uniform(0.06, 0.3), rng.uniform(0.3, 1.5)
    hub, fillet = rng.uniform(0.3, 0.55), rng.choice([0.01, 0.1, 0.2])
    holes = int(rng.integers(3, 13))
    solid = capped_cylinder(-Z * disc / 2, Z * disc / 2, 1)
    if rng.random() < 0.3:
        corners = int(rng.integers(3, 7))
        ears = around(cylinder(0.25), corners, 0.9).union(cylinder(0.85), k=0.2)
        solid, holes = ears & slab(z0=-disc / 2, z1=disc / 2), corners
    solid = solid.union(capped_cylinder(ORIGIN, Z * height, hub), k=fillet)
    if rng.random() < 0.5:
        wide = rng.uniform(0.03, 0.07)
        reach = d2.polygon([(0, 0), (0.95, 0), (0.95, disc), (hub, 0.9 * height), (0, 0.9 * height)])
        rib = reach.extrude(wide).rotate(np.pi / 2, X)
        solid = solid.union(around(rib, holes), k=0.2 * fillet)
    bolt = cylinder(rng.uniform(0.2, 0.4) * np.pi * 0.8 / holes if holes > 5 else rng.uniform(0.05, 0.13))
    middle = (hub + 1) / 2 + 0.04
    solid -= around(bolt, holes, middle).rotate(np.pi / holes)
    solid -= cylinder(hub * rng.uniform(0.4, 0.85))
    if rng.random() < 0.4:
        solid -= torus(1, rng.uniform(0.02, 0.08)).k(0.02)
    return solid


def bracket(rng: Rng) -> SceneLike:
    """An angle with slots and holes, a gusset, and a rounded bend."""
    wide, thick = rng.uniform(0.6, 2), rng.uniform(0.06, 0.25)
    long, tall = rng.uniform(0.8, 2, 2)
    k = rng.choice([0.01, 0.1, 0.25])
    foot = box(a=(0, -wide / 2, 0), b=(long, wide / 2, thick))
    back = box(a=(0, -wide / 2, 0), b=(thick, wide / 2, tall))
    solid = foot.union(back, k=k)
    if rng.random() < 0.5 and tall > wide:  # a round upper end
        end = d2.rectangle(a=(-9, -9), b=(9, tall - wide / 2)) | d2.circle(wide / 2, (0, tall - wide / 2))
        solid &= end.extrude(9).rotate(np.pi / 2, X).rotate(np.pi / 2)
    if rng.random() < 0.7:
        side = 0.8 * min(long, tall)
        gusset = d2.polygon([(0, 0), (side, 0), (0, side)]).extrude(thick).rotate(np.pi / 2, X)
        if rng.random() < 0.5:
            aside = Y * (wide - thick) / 2
            gusset = gusset.translate(aside) | gusset.translate(-aside)
        solid = solid.union(gusset, k=0.3 * k)
    hole = rng.uniform(0.06, 0.12) * wide
    count = int(rng.integers(1, 4))
    for at in np.linspace(-0.36, 0.36, count) * wide if count > 1 else [0.25 * wide]:
        slot = cylinder(hole).elongate((rng.choice([0, 0.12, 0.3]) * long / 2, 0, 0)).translate((0.6 * long, at, 0))
        solid -= slot & slab(z1=thick + 0.01)
        solid -= (cylinder(hole).orient(X) & slab(x1=thick + 0.01)).translate((0, at, 0.7 * tall))
    return solid


def _tooth(rng: Rng, tip: float, root: float, count: int) -> SDF2:
    """A tooth along x, with sloped flanks, from inside the root to outside the tip."""
    foot = np.pi / count * root * rng.uniform(0.6, 0.9)
    head = np.pi / count * tip * rng.uniform(0.15, 0.45)
    return d2.polygon([(0.8 * root, -foot), (tip + 0.05, -head), (tip + 0.05, head), (0.8 * root, foot)])


def gear(rng: Rng) -> SceneLike:
    """A gear, spur, helical or internal, with a web, holes or spokes and a keyway."""
    count, wide = int(rng.integers(8, 40)), rng.uniform(0.15, 0.6)
    root = 1 - rng.uniform(1.5, 3) / count
    teeth = (d2.circle(root) | _tooth(rng, 1, root, count).circular_array(count)) & d2.circle(1)
    if rng.random() < 0.2:  # internal teeth
        solid = (d2.circle(rng.uniform(1.1, 1.4)) - teeth).extrude(wide)
        return solid - around(cylinder(0.04), int(rng.integers(3, 9)), 1.08)
    solid = teeth.extrude(wide)
    if rng.random() < 0.4:
        solid = solid.twist(rng.uniform(-1, 1))
    hub, rim = rng.uniform(0.2, 0.35), 0.85 * root
    if rng.random() < 0.7:
        pocket = (d2.circle(rim) - d2.circle(hub)).extrude(wide)
        depth = rng.uniform(0.6, 0.9) * wide
        for side in (-1, 1):
            solid = solid.difference(pocket.translate(Z * side * depth), k=rng.choice([0.01, 0.04]))
    holes = int(rng.integers(3, 8))
    if rng.random() < 0.6:
        middle = (hub + rim) / 2
        solid -= around(cylinder(min(0.35 * (rim - hub), 0.7 * np.pi * middle / holes)), holes, middle)
    bore = rng.uniform(0.3, 0.7) * hub
    return solid - (cylinder(bore) | box((0.5 * bore, 1.5 * bore, 4)).translate(Y * bore * 0.75))


def housing(rng: Rng) -> SceneLike:
    """A hollow box, open at the top, with ribs, screw bosses, holes in its walls, and with or without vents."""
    size = np.array([rng.uniform(1.2, 2), rng.uniform(0.8, 1.6), rng.uniform(0.4, 1)])
    wall, radius = rng.uniform(0.04, 0.1), rng.uniform(0.02, 0.2)
    inner = size - 2 * wall
    solid = rounded_box(size, radius) & slab(z1=size[2] * 0.4)
    solid -= rounded_box(inner * (1, 1, 2), max(radius - wall, 0.01)).translate(Z * inner[2] / 2)
    low = slab(z0=-size[2] / 2 + wall / 2, z1=size[2] * rng.uniform(0, 0.3))
    if rng.random() < 0.6:
        spacing = inner[0] / int(rng.integers(2, 7))
        ribs = box((0.4 * wall, inner[1] + wall, size[2])).repeat((spacing, 0, 0), count=(2, 0, 0))
        solid |= ribs & slab(z0=-size[2] / 2 + wall / 2, z1=-size[2] * rng.uniform(0, 0.3)) & box(inner + 0.5 * wall)
    corner = inner / 2 - 0.12
    boss = (cylinder(0.1) - cylinder(0.05)).translate((corner[0], corner[1], 0))
    boss |= boss.rotate(np.pi)
    mirrored = (cylinder(0.1) - cylinder(0.05)).translate((-corner[0], corner[1], 0))
    solid = solid.union((boss | mirrored | mirrored.rotate(np.pi)) & low, k=0.02)
    vents = int(rng.integers(1, 7))
    vent = (
        rounded_box((0.5 * size[0] / vents, 4, 0.25 * size[2]), 0.04)
        if rng.random() < 0.5
        else cylinder(0.08).orient(Y)
    )
    spacing = 0.8 * size[0] / vents
    solid -= vent.repeat((spacing, 0, 0), count=(vents // 2, 0, 0))
    if rng.random() < 0.5:  # a grille below
        slots = box((0.05, inner[1] * 0.6, 9)).repeat((0.12, 0, 0)) & box(inner * (0.7, 1, 1)).translate(
            -Z * inner[2] / 2
        )
        solid -= slots
    return solid.rotate(rng.choice([0, 0, 1, 2]) * np.pi / 2, X)


def heat_sink(rng: Rng) -> SceneLike:
    """Fins or pins on a plate, or fins around a core."""
    fins, height = int(rng.integers(4, 13)), rng.uniform(0.3, 1.2)
    share = rng.uniform(0.15, 0.5)  # width of a fin, as a share of the pitch
    kind = rng.choice(["plates", "pins", "round", "discs"])
    if kind == "round":
        blade = box((0.7, share * 2 * np.pi * 0.5 / (2 * fins), height))
        solid = blade.circular_array(2 * fins, 0.65).union(
            capped_cylinder(-Z * height / 2, Z * height / 2, 0.45), k=0.05
        )
        return solid - cylinder(rng.uniform(0.1, 0.35))
    pitch = 1.8 / fins
    if kind == "discs":
        disc = slab(z0=-share * pitch / 2, z1=share * pitch / 2).repeat((0, 0, pitch))
        solid = (cylinder(1) & disc).union(cylinder(rng.uniform(0.3, 0.7)), k=0.05) & slab(z0=-0.9, z1=0.9)
        return solid - cylinder(rng.uniform(0.1, 0.25))
    plate = rng.uniform(0.08, 0.25)
    if kind == "pins":
        pin = cylinder(0.5 * share * pitch + 0.02) if rng.random() < 0.5 else box((share * pitch, share * pitch, 9))
        standing = pin.repeat((pitch, pitch, 0))
    else:
        standing = slab(x0=-share * pitch / 2, x1=share * pitch / 2).repeat((pitch, 0, 0))
        if rng.random() < 0.5:
            standing -= slab(y0=-0.08, y1=0.08).repeat((0, rng.uniform(0.4, 0.9), 0)) & slab(z0=plate + 0.2 * height)
    solid = standing & box(a=(-0.95, -0.95, 0), b=(0.95, 0.95, plate + height))
    solid = solid.union(box(a=(-1, -1, 0), b=(1, 1, plate)), k=rng.choice([0.005, 0.04]))
    return solid


def perforated_plate(rng: Rng) -> SceneLike:
    """A plate with rows of holes, flat or rolled into a tube or a bow."""
    pitch, share = rng.uniform(0.12, 0.5), rng.uniform(0.25, 0.42)
    hole = [
        lambda: d2.circle(share * pitch),
        lambda: d2.hexagon(share * pitch),
        lambda: d2.rounded_rectangle(1.8 * share * pitch, 0.3 * share * pitch),
        lambda: d2.rectangle(1.8 * share * pitch).rotate(np.pi / 4).scale(0.75),
        lambda: d2.circle(0.5 * share * pitch).elongate((0.5 * share * pitch, 0)),
    ][rng.integers(5)]()
    thick = rng.uniform(0.03, 0.2)
    if rng.random() < 0.6:  # offset every second row by half a pitch
        rows = hole.repeat((pitch, 1.732 * pitch))
        holes = rows | rows.translate((pitch / 2, 0.866 * pitch))
    else:
        holes = hole.repeat(pitch)
    outline = [
        lambda: d2.rounded_rectangle((2, rng.uniform(1, 2)), rng.uniform(0.02, 0.4)),
        lambda: d2.circle(1),
        lambda: d2.hexagon(1.1),
    ][rng.integers(3)]()
    sheet = (outline - (holes & outline.erode(rng.uniform(0.05, 0.15)))).extrude(thick)
    if rng.random() < 0.5:
        return sheet.rotate(np.pi / 2, X).bend(rng.uniform(0.3, 1.2)) & box(2.5)
    return sheet.rotate(rng.choice([0, np.pi / 3]), X)


def _thread(radius: float, depth: float, pitch: float) -> SDF3:
    """An infinite rod along z with a threaded surface."""
    turn = 2 * np.pi / pitch
    return implicit(
        lambda x, y, z: (
            0.7 * (np.sqrt(x * x + y * y) - radius + depth * np.abs(np.sin((turn * z - np.arctan2(y, x)) / 2)))
        )
    )


def bolt(rng: Rng) -> SceneLike:
    """A threaded rod with a head: hexagonal, round with a slot, or with a socket; or knurled."""
    radius, length, pitch = rng.uniform(0.25, 0.5), rng.uniform(1, 2.8), rng.uniform(0.1, 0.25)
    rod = _thread(radius, 0.5 * pitch, pitch) & slab(z0=-length)
    solid = (rod | (cylinder(radius) & slab(z0=-length * rng.uniform(0, 0.6)))) & slab(z1=0.05)
    tall, wide = rng.uniform(0.25, 0.5), radius * rng.uniform(1.5, 2)
    kind = rng.choice(["hexagon", "slot", "socket", "knurled"])
    if kind == "hexagon":
        head = d2.hexagon(wide).extrude(tall).translate(Z * tall / 2) & sphere(1.06 * np.hypot(wide, tall / 2))
        if rng.random() < 0.5:
            head |= capped_cylinder(-Z * 0.03, Z * 0.05, 1.2 * wide)
    elif kind == "slot":
        head = sphere(1.2 * wide).translate(Z * (tall - 1.2 * wide)) & slab(z0=0)
        cut = box((9, 0.25 * radius, tall))
        if rng.random() < 0.5:
            cut = (cut | cut.rotate(np.pi / 2)) & cylinder(0.7 * wide)
        head -= cut.translate(Z * tall)
    elif kind == "socket":
        head = capped_cylinder(ORIGIN, Z * tall, wide) - d2.hexagon(0.6 * wide).extrude(tall).translate(Z * tall)
    else:
        ridges = int(rng.integers(12, 40))
        head = implicit(
            lambda x, y, z: (
                np.sqrt(x * x + y * y)
                - wide
                + 0.03 * np.sin(ridges * np.arctan2(y, x) + 6 * z) * np.sin(ridges * np.arctan2(y, x) - 6 * z)
            )
        ) & slab(z0=0, z1=tall)
    return solid | head.k(rng.choice([0.005, 0.05]))


def nut(rng: Rng) -> SceneLike:
    """A nut: a chamfered prism, round with notches, or with wings, around a threaded bore."""
    tall, radius, pitch = rng.uniform(0.4, 1), rng.uniform(0.45, 0.65), rng.uniform(0.1, 0.25)
    kind = rng.choice(["prism", "notched", "winged", "castle"])
    if kind == "winged":
        wing = sphere(0.45).scale((1, 0.25, 1)).translate((1.1, 0, 0.3))
        solid = capped_cylinder(-Z * tall / 2, Z * tall / 2, 0.8).union(around(wing, 2), k=0.15)
    elif kind == "notched":
        count = int(rng.integers(4, 25))
        solid = capped_cylinder(-Z * tall / 2, Z * tall / 2, 1)
        solid -= box((0.2, 2 / count, 9)).circular_array(count, 1).k(0.02)
    else:
        side = d2.hexagon(1) if rng.random() < 0.8 else d2.rectangle(1.6)
        solid = side.extrude(tall) & sphere(np.hypot(0.93, tall / 2))
    if kind == "castle":
        crown = capped_cylinder(ORIGIN, Z * 0.9 * tall, 0.8)
        solid = (solid | crown) - around(box((9, 0.2, 0.5 * tall)), 3).translate(Z * 0.8 * tall)
    return solid - _thread(radius, 0.5 * pitch, pitch)


def crank(rng: Rng) -> SceneLike:
    """A crankshaft: main journals on its axis, offset crankpins, and webs between them."""
    throws, throw = int(rng.integers(1, 5)), rng.uniform(0.3, 0.6)
    pin, journal = rng.uniform(0.12, 0.2), rng.uniform(0.15, 0.25)
    web, gap = rng.uniform(0.08, 0.15), rng.uniform(0.2, 0.35)
    step = 2 * (web + gap)
    length = throws * step + gap
    solid = cylinder(journal) & slab(z0=0, z1=length)
    turn = rng.choice([np.pi, 2 * np.pi / 3, np.pi / 2])
    for i in range(throws):
        low = gap + i * step
        outline = d2.circle(1.6 * pin, (throw, 0)).union(d2.circle(1.5 * journal, (-0.1, 0)), k=0.5)
        if throws < 4:
            outline |= d2.circle(throw, (-0.15, 0)) & d2.slab(x1=-0.1)
        cheek = outline.extrude(web)
        middle = gap + web
        solid -= cylinder(2 * journal) & slab(z0=low + web, z1=low + web + gap)
        part = cheek | cheek.translate(Z * middle) | capped_cylinder(ORIGIN, Z * middle, pin).translate(X * throw)
        solid = solid.union(part.translate(Z * (low + web / 2)).rotate(i * turn), k=0.03)
    if rng.random() < 0.5:
        solid |= capped_cylinder(Z * (length - 0.05), Z * (length + 0.15), 0.55)
    return solid.rotate(np.pi / 2, X)


def wheel(rng: Rng) -> SceneLike:
    """A wheel: tyre with treads, rim, hub, straight or swept spokes."""
    wide, rim = rng.uniform(0.2, 0.6), rng.uniform(0.65, 0.85)
    tyre = (d2.rounded_rectangle((1 - rim, wide), 0.45 * min(1 - rim, wide)).translate(((1 + rim) / 2, 0))).revolve()
    treads = int(rng.integers(8, 40))
    if rng.random() < 0.6:
        groove = box((0.12, 1.3 / treads, 0.45 * wide)).translate(Z * 0.3 * wide).circular_array(treads, 1)
        tyre -= groove | groove.rotate(np.pi, X).rotate(np.pi / treads)
    solid = tyre | (capped_cylinder(-Z * 0.3 * wide, Z * 0.3 * wide, rim + 0.03) - cylinder(rim - 0.06))
    hub, count = rng.uniform(0.12, 0.3), int(rng.integers(3, 13))
    thick = rng.uniform(0.2, 0.5) * np.pi * hub / count + 0.02
    spoke = box(a=(0, -thick, -0.15 * wide), b=(rim, thick, 0.15 * wide))
    if rng.random() < 0.4:
        spoke = spoke.bend(rng.uniform(0.4, 0.9)) & cylinder(rim)
    spokes = around(spoke, count) & box((3, 3, wide))
    solid = solid.union(spokes, k=0.04)
    solid = solid.union(capped_cylinder(-Z * 0.4 * wide, Z * 0.4 * wide, hub), k=0.05)
    return (solid - cylinder(0.4 * hub)).rotate(np.pi / 2, X)


def connector(rng: Rng) -> SceneLike:
    """A plug: a shell around rows of pins, on a flange with two holes, with a cable behind."""
    columns, rows = int(rng.integers(2, 10)), int(rng.integers(1, 4))
    pitch = 0.2
    size = np.array([columns, rows]) * pitch + 0.15
    outline = d2.rounded_rectangle(size, rng.uniform(0.02, 0.12))
    depth = rng.uniform(0.3, 0.8)
    body = (outline.dilate(0.08).extrude(depth) - outline.extrude(9)).translate(Z * depth / 2)
    pin = cylinder(0.05) if rng.random() < 0.5 else box((0.08, 0.08, 9))
    at = (0.5 * pitch * ((columns + 1) % 2), 0.5 * pitch * ((rows + 1) % 2), 0)
    pins = pin.repeat((pitch, pitch, 0)).translate(at) & slab(z0=-0.1, z1=0.8 * depth)
    solid = body | (pins & outline.erode(0.06).extrude(9))
    base = (
        d2.rounded_rectangle(size + (0.7, 0.2), 0.1).extrude(0.1)
        - cylinder(0.08).translate(X * (size[0] / 2 + 0.22))
        - cylinder(0.08).translate(-X * (size[0] / 2 + 0.22))
    )
    solid |= base
    back = rounded_box((size[0], size[1] + 0.1, 0.6), 0.08).translate(-Z * 0.3)
    cable = cylinder(rng.uniform(0.08, 0.15)) & slab(z0=-rng.uniform(0.8, 2), z1=-0.3)
    return solid | back.union(cable, k=0.1)


def pipe_fitting(rng: Rng) -> SceneLike:
    """Hollow pipes that meet with fillets, with collars or flanges at their ends."""
    radius, wall, k = rng.uniform(0.25, 0.4), rng.uniform(0.03, 0.1), rng.choice([0.01, 0.1, 0.25])
    angles = np.cumsum(rng.choice([0.5, 0.75, 1], int(rng.integers(2, 4)))) * np.pi
    axes = [np.array([np.cos(angle), np.sin(angle), 0]) for angle in angles]
    if rng.random() < 0.5:
        axes.append(Z)
    outer, inner = sphere(radius), sphere(radius - wall)
    holes = int(rng.integers(4, 9))
    for axis in axes:
        outer = outer.union(capped_cylinder(ORIGIN, axis, radius), k=k)
        inner |= capped_cylinder(ORIGIN, 1.2 * axis, radius - wall)
    collar = rng.uniform(1.2, 1.7) * radius
    for axis in axes:
        end = capped_cylinder(0.85 * axis, axis, collar)
        if collar > 1.5 * radius:
            end -= around(cylinder(0.15 * radius), holes, (collar + radius) / 2).orient(axis)
        outer |= end
    return outer - inner


FAMILIES: dict[str, Callable[[Rng], SceneLike]] = {
    family.__name__: family
    for family in (
        drilled_block,
        flange,
        bracket,
        gear,
        housing,
        heat_sink,
        perforated_plate,
        bolt,
        nut,
        crank,
        wheel,
        connector,
        pipe_fitting,
    )
}
