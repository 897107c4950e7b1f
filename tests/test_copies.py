"""Pickled and copied public objects: each is equal to the original, or explains why it can't be copied."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import sdf
from bobrossnet.completion.network import load_network

SIZE = (24, 32)
COPIES: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
}
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)


def surface() -> bob.Brep:
    grid = np.array([[(x, y, x * y) for y in (0, 1)] for x in (0, 1)], float)
    return bob.nurbs_surface(grid, (0, 0, 1, 1), (0, 0, 1, 1))


def scene() -> bob.Scene:
    return bob.Scene([bob.happy_tree(), bob.Instance(surface(), material=bob.Material("#c33"), name="red")])


def guides() -> bob.Guides:
    return bob.Guides(depth=np.linspace(0, 1, 12).reshape(3, 4))


def part() -> bob.GBuffer:
    return bob.trace(scene(), size=SIZE, fraction=0.3)


def picked() -> bob.Pick:
    found = bob.pick(bob.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)]), 12, 16, "top", size=SIZE)
    assert found is not None
    return found


MAKERS: dict[str, Callable[[], Any]] = {
    "Between": lambda: bob.measure(found := picked(), found),
    "Brep": surface,
    "Camera": lambda: bob.Camera(position=(3, 0, 1), fov=50),
    "Drawing": lambda: bob.draw(scene(), size=SIZE),
    "Edges": lambda: bob.Edges(2, "#c33", hidden=True),
    "Contours": lambda: bob.section(surface(), "x=0.5"),
    "Face": lambda: surface().faces[0],
    "FaceMeasures": lambda: bob.measure(picked()),
    "Film": lambda: bob.orbit(scene(), frames=2, size=SIZE, samples=1),
    "Frame": lambda: next(iter(bob.progressive(scene(), size=SIZE, fraction=0.3))),
    "GBuffer": part,
    "Guides": guides,
    "Hits": lambda: scene().closest_hits([(9, 0, 0)], [(-1, 0, 0)]),
    "Implicit": lambda: bob.Implicit(sdf.sphere(1).expression, ((-1, -1, -1), (1, 1, 1)), "#c33"),
    "Instance": lambda: bob.Instance(surface()).translate((1, 2, 3)),
    "Glass": lambda: bob.Glass(ior=1.33, attenuation="#4a7", distance=0.5),
    "Light": lambda: bob.Light((1, 2, 3), angle=5, color="#fed"),
    "Material": lambda: bob.Material("#b87333", metallic=1),
    "Measures": lambda: bob.measure(scene()),
    "Mesh": lambda: bob.Mesh(SQUARE, [(0, 1, 2), (0, 2, 3)], colors=SQUARE / 2),
    "Network": lambda: load_network("small"),
    "Part": lambda: scene().part("red"),
    "Pick": picked,
    "Picture": lambda: bob.render(scene(), size=SIZE, samples=1),
    "SDF2": lambda: sdf.circle(1) | sdf.rectangle(1),
    "SDF3": lambda: sdf.sphere(1).color("#c33") & sdf.box(1.5),
    "Samples": lambda: bob.Samples(gray=[0.1, 0.2], depth=[0.3, 0.4], hit=[True, False]),
    "Scene": scene,
    "SceneTracer": lambda: bob.SceneTracer(scene(), bob.Camera(), SIZE),
    "Section": lambda: bob.Section("z>0.5"),
    "Sky": lambda: bob.Sky(image=np.ones((2, 4, 3)), turn=30),
    "TrimCurve": lambda: bob.TrimCurve([(0, 0), (1, 0), (1, 1)], (0, 0, 0.5, 1, 1)),
    "Tube": lambda: bob.polyline(SQUARE, 0.1),
    "View": lambda: bob.View(scene(), size=SIZE),
}
NO_OBJECTS = {"InputError", "InputTypeError", "InputWarning", "Shape"}
STAY = {"View"}

PIXELS = np.argwhere(np.ones(SIZE)).astype(np.int32)
USED: dict[str, Callable[[Any], Any]] = {
    "Drawing": lambda drawing: (drawing.visible, drawing.hidden, drawing.svg(), drawing.coverage()),
    "Film": lambda film: [picture.rgba for picture in film],
    "Frame": lambda frame: (
        frame.image,
        frame.color,
        frame.error,
        frame.fraction,
        frame.gbuffer.planes,
        frame.shown.planes,
    ),
    "Network": lambda network: network.predict(part()),
    "Picture": lambda picture: (picture.color, picture.alpha, picture.rgba),
    "SDF2": lambda shape: (shape.expression, shape([(0.2, 0.3)])),
    "Scene": lambda held: (held.center, held.radius, bob.trace(held, size=SIZE).planes),
    "SceneTracer": lambda tracer: (tracer.size, tracer.camera, tracer(PIXELS).values),
}
"""Result for objects with external state."""


def held(value: Any) -> Any:
    """Return an object's contents, down to arrays and plain values."""
    if isinstance(value, bob.Shape):
        return type(value), value.digest
    if (used := USED.get(type(value).__name__)) is not None:
        return held(used(value))
    if isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes()
    if isinstance(value, tuple | list):
        return [held(each) for each in value]
    if is_dataclass(value):
        return [held(getattr(value, each.name)) for each in fields(value)]
    slots = getattr(type(value), "__slots__", ())
    return [held(getattr(value, name)) for name in slots] if slots else value


def frozen(value: Any, inside: frozenset[int] = frozenset()) -> list[bool]:
    """Return which of an object's arrays are read-only."""
    if isinstance(value, np.ndarray):
        return [not value.flags.writeable]
    if id(value) in inside or type(value).__module__.startswith("numpy"):
        return []
    names = [*getattr(type(value), "__slots__", ()), *sorted(getattr(value, "__dict__", {}))]
    parts = value if isinstance(value, tuple | list) else [getattr(value, name) for name in names]
    return [each for part in parts for each in frozen(part, inside | {id(value)})]


def test_all_classes_are_here() -> None:
    public = {name for name in bob.__all__ if isinstance(getattr(bob, name), type)}
    assert public - NO_OBJECTS - MAKERS.keys() == set()


@pytest.mark.parametrize("way", COPIES)
@pytest.mark.parametrize("name", MAKERS)
def test_objects_have_copies(name: str, way: str) -> None:
    made = MAKERS[name]()
    if name in STAY:
        with pytest.raises(bob.InputError, match=rf"^{name}: .*; make another.*$"):
            COPIES[way](made)
        return
    again = COPIES[way](made)
    assert type(again) is type(made)
    assert held(again) == held(made)
    if name in ("GBuffer", "Guides", "Face", "TrimCurve", "Instance", "Mesh", "Tube"):
        assert frozen(again) == frozen(made)
