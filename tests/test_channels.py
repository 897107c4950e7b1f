"""Channels and layouts, the interface of tracer, G-buffer and networks, from Python."""

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.network import load_network
from bobrossnet.picture.channels import CHANNELS, TRACED, Layout

SIZE = (24, 32)


@pytest.fixture(scope="module")
def scene():
    return bob.Scene(bob.happy_tree())


def traced(scene, names, size=SIZE):
    """Return every pixel's sample, with the named channels."""
    layout = _core.Layout(names)
    pixels = bob.pixel_order(size)
    samples = np.full((len(pixels), layout.width), np.nan, np.float32)
    scene.core.trace(bob.Camera().core((0, 0, 0), 1), *size, pixels, layout, samples)
    return pixels, samples


def test_layouts_list_channels_by_name():
    layout = _core.Layout("normal,gray")
    assert layout.names == "normal,gray"
    assert layout.width == 3
    assert Layout("normal,gray").places == {"normal": slice(0, 2), "gray": slice(2, 3)}
    assert layout == _core.Layout("normal,gray") != _core.Layout("gray,normal")
    assert Layout("normal,gray") == Layout("normal,gray") != Layout("gray,normal")
    assert _core.gbuffer_layout() == TRACED.core
    assert next(iter(TRACED.places)) == "mask"


@pytest.mark.parametrize("names", ["", "gray,", "gray, depth", "grey", "alphas"])
def test_unknown_channels_are_named(names):
    unknown = names.split(",")[-1]
    with pytest.raises(ValueError, match=f"^expected channels among {','.join(CHANNELS)}, got '{unknown}'$"):
        _core.Layout(names)


def test_channels_are_within_their_ranges(scene):
    layout = Layout(",".join(CHANNELS))
    pixels, samples = traced(scene, layout.names)
    planes = np.zeros((layout.width, *SIZE), np.float32)
    _core.scatter(layout.core, pixels, samples, planes)
    gbuffer = bob.GBuffer.from_stack(planes, layout)
    missed = samples[:, 0] == 0
    assert missed.any()
    assert not missed.all()
    for name, channel in CHANNELS.items():
        values = gbuffer.channel(name)
        assert values.shape == (SIZE if channel.components == 1 else (*SIZE, channel.components))
        assert channel.low <= values.min() <= values.max() <= channel.high
        assert (samples[missed, layout.places[name]] == channel.missed).all()


def test_instances_are_found_by_their_places_in_the_canonical_order():
    ball = bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1, bounds=((-1, -1, -1), (1, 1, 1)))
    grays = (0.2, 0.5, 0.9)
    balls = [
        bob.Instance(ball, material=bob.Material(color=(g, g, g), ambient=1, diffuse=0, specular=0)) for g in grays
    ]
    scene = bob.Scene([each.translate((0, 3 * i, 0)) for i, each in enumerate(balls)])
    _, samples = traced(scene, "mask,gray,instance")
    found = {(round(float(gray), 3), int(instance)) for hit, gray, instance in samples if hit}
    assert {gray for gray, _ in found} == set(grays)
    assert {instance for _, instance in found} == {0, 1, 2}
    assert len(found) == 3


def test_any_channels_are_traced_and_scattered(scene):
    _, whole = traced(scene, TRACED.names)
    pixels, some = traced(scene, "mask,normal,gray")
    assert np.array_equal(some, np.hstack([whole[:, TRACED.places[name]] for name in ("mask", "normal", "gray")]))
    planes = np.zeros((4, *SIZE), np.float32)
    _core.scatter(_core.Layout("mask,normal,gray"), pixels, some, planes)
    gbuffer = bob.trace(scene, size=SIZE)
    assert np.array_equal(planes[0], gbuffer.mask)
    assert np.array_equal(planes[1:3], np.moveaxis(gbuffer.normal, -1, 0))
    assert np.array_equal(planes[3], gbuffer.gray)


def test_networks_take_their_channels_out_of_any_layout(scene):
    gbuffer = bob.trace(scene, size=SIZE, fraction=0.2)
    network = load_network("paper")
    names = ("mask", "normal", "depth", "gray")
    planes = np.concatenate([gbuffer.planes[TRACED.places[name]] for name in names])
    image = np.empty(SIZE, np.float32)
    network.core(_core.Layout(",".join(names)), planes, image[None])
    assert np.array_equal(image, network.predict(gbuffer))


def test_what_a_network_lacks_is_named(scene):
    network = load_network("default").core
    planes, output = np.zeros((2, *SIZE), np.float32), np.empty((1, *SIZE), np.float32)
    message = "^expected a G-buffer with the channel depth, got one with mask,gray$"
    with pytest.raises(ValueError, match=message):
        network(_core.Layout("mask,gray"), planes, output)
    with pytest.raises(ValueError, match=r"^expected a G-buffer with the channel gray, got one with mask,depth$"):
        _core.keep_known(_core.Layout("mask,depth"), planes, network.outputs, output)


def test_arrays_of_another_width_are_refused(scene):
    pixels, samples = traced(scene, "mask,gray")
    with pytest.raises(ValueError, match=r"^samples: expected the layout's width$"):
        scene.core.trace(bob.Camera().core((0, 0, 0), 1), *SIZE, pixels, TRACED.core, samples)
    with pytest.raises(ValueError, match=r"^samples: expected the layout's width$"):
        _core.scatter(TRACED.core, pixels, samples, np.zeros((TRACED.width, *SIZE), np.float32))
    with pytest.raises(ValueError, match=r"^planes: expected one for each component$"):
        _core.scatter(_core.Layout("mask,gray"), pixels, samples, np.zeros((5, *SIZE), np.float32))


def test_cameras_and_materials_travel_as_objects(scene):
    pixels = bob.pixel_order(SIZE)
    met, origins, directions = bob.Camera(azimuth=0, elevation=0).core((0, 0, 0), 1).rays(*SIZE, pixels)
    assert 0 < len(met) < len(pixels)
    assert len(origins) == len(directions) == len(met)
    assert np.allclose(directions, (-1, 0, 0), atol=1e-7)
    assert np.allclose(np.linalg.norm(origins, axis=1), 1, atol=3e-3)
    assert len(bob.Camera(zoom=2).core((0, 0, 0), 1).rays(*SIZE, pixels)[0]) == len(pixels)

    material = bob.Material("#ff0000", ambient=0.25, shininess=8)
    core = material.core()
    assert [*core.color, core.ambient, core.diffuse, core.specular, core.shininess] == [1, 0, 0, 0.25, 0.7, 0.2, 8]
    with pytest.raises(TypeError):
        scene.core.trace((30, 20, 0, 1), *SIZE, pixels, TRACED.core, np.empty((len(pixels), 5), np.float32))
    with pytest.raises(TypeError):
        _core.Arrangement([bob.happy_tree().core], np.eye(4)[None], [(1, 1, 1, 0.1, 0.7, 0.2, 32)])
