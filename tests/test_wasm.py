"""The WebAssembly modules: the same pictures as the core in Python, in both instruction sets, and errors in one line.

In simd128, results of + - x / and square roots alone have the same bits as the core's baseline: pixel orders, networks,
masks, depths, normals. A different library's powers shade highlights, and its arc cosines weight the faces around a
mesh's vertices. In relaxed SIMD, products and sums may be fused.
"""

import gzip
import re
from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.guided import smoothed
from bobrossnet.completion.network import make_network
from bobrossnet.completion.weights import UNCERTAINTY, WEIGHTS, read_weights
from bobrossnet.sdf import Mesh, box, sphere
from bobrossnet.sdf.words import WORDS

wasmtime = pytest.importorskip("wasmtime", reason="wasmtime, which runs WebAssembly, is not installed")

from nurbs_shapes import cylinder  # noqa: E402
from wasm_core import FOLDER, CoreError, WasmCore, placed, recorded  # noqa: E402
from word_scripts import COLORED, SCRIPTS  # noqa: E402

pytestmark = pytest.mark.skipif(
    not (FOLDER / "core.wasm").is_file(),
    reason="bobrossnet was built without its WebAssembly modules: ziglang was not installed",
)

SETS = ("", ".relaxed")

EXAMPLES = Path(__file__).parents[1] / "examples"

SIZES = ((1, 1), (1, 2), (2, 1), (3, 5), (7, 4), (16, 16), (33, 61), (64, 100), (17, 1000), (1000, 17))

SCRIPT = "f = sphere(1) & box(1.5)\nf -= cylinder(0.5)\nf | capsule(-Z, Z, 0.2).rotate(0.3, X)\n"

VM = b"a var-x\nb var-y\nc var-z\nd square a\ne square b\nf square c\ng add d e\nh add g f\ni const 0.5\nj sub h i\n"


@pytest.fixture(scope="module", params=SETS, ids=["simd128", "relaxed-simd"])
def core(request):
    return WasmCore(f"core{request.param}")


@pytest.fixture
def baseline():
    """Use Python's core in the instruction set with the same vectors as WebAssembly."""
    best = _core.isa()
    _core.set_isa("baseline")
    yield
    _core.set_isa(best)


def assert_same_nodes(text, nodes, expression):
    ops, operands, values = nodes
    assert ops.tobytes() == expression.ops.tobytes(), text
    assert operands.tobytes() == expression.operands.tobytes(), text
    np.testing.assert_allclose(values, expression.values, rtol=1e-15, err_msg=text)


def noise(size, density=0.1):
    random = np.random.default_rng(0)
    stack = random.random((5, *size), dtype=np.float32)
    stack[3:] = 2 * stack[3:] - 1
    stack[0] = 1
    return np.ascontiguousarray(stack * (random.random(size) < density))


# ---- Modules ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("set_", SETS)
def test_modules_import_nothing(set_):
    """So that a page needs no further file."""
    for name in ("core", "complete"):
        assert not WasmCore(name + set_).module.imports


@pytest.mark.parametrize("set_", SETS)
def test_networks_need_little(set_):
    """Below 300 KB with the report's weights; the whole core, as sent by a server, below 714."""
    weights = (WEIGHTS / "paper.safetensors").stat().st_size
    assert (FOLDER / f"complete{set_}.wasm").stat().st_size + weights < 300_000
    assert len(gzip.compress((FOLDER / f"core{set_}.wasm").read_bytes())) < 714_000


# ---- Networks --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["filling", "small", "paper", "default"])
@pytest.mark.parametrize("set_", SETS, ids=["simd128", "relaxed-simd"])
def test_networks_complete_as_in_python(name, set_, baseline):
    metadata, tensors = read_weights(WEIGHTS / f"{name}.safetensors")
    core = WasmCore(f"complete{set_}")
    network = core.network(metadata["network"], tensors, metadata["inputs"])
    for size in SIZES:
        stack = noise(size)
        expected, gray = (
            make_network(metadata, tensors).predict(bob.GBuffer.from_stack(stack)),
            core.run(network, stack),
        )
        if set_ == "":
            np.testing.assert_array_equal(gray, expected, err_msg=str(size))
        else:
            np.testing.assert_allclose(gray, expected, rtol=0, atol=1e-5, err_msg=str(size))


@pytest.mark.parametrize("set_", SETS, ids=["simd128", "relaxed-simd"])
def test_colors_are_completed_as_in_python(set_, baseline):
    layout, core, random = (
        _core.Layout("mask,gray,depth,normal,color,albedo"),
        WasmCore(f"complete{set_}"),
        np.random.default_rng(3),
    )
    for height, width in SIZES:
        planes = random.random((11, height, width), np.float32)
        planes *= random.random((height, width)) < 0.1
        planes[0] = planes[0] > 0
        gray = random.random((height, width), np.float32) * (random.random((height, width)) < 0.7).astype(np.float32)
        expected, color = (np.full((3, height, width), np.nan, np.float32) for _ in range(2))
        _core.complete_along(layout, planes, _core.Layout("color"), planes[1], gray, None, expected)
        core.made("complete_color", planes, gray, height, width, color)
        known = planes[0] > 0
        np.testing.assert_array_equal(color[:, known], planes[5:8, known])
        if set_ == "":
            np.testing.assert_array_equal(color, expected)
        else:
            np.testing.assert_allclose(color, expected, rtol=0, atol=1e-5)


def test_known_pixels_are_kept(core):
    stack = noise((9, 14), 0.5)
    gray = np.linspace(-1, 2, 9 * 14, dtype=np.float32).reshape(9, 14)
    gray[3, 3] = np.nan
    expected = gray.copy()
    _core.keep_known(_core.gbuffer_layout(), stack, _core.Layout("gray"), expected[None])
    _, tensors = read_weights(WEIGHTS / "paper.safetensors")
    core.made("keep_known", core.network("paper", tensors), stack, gray.size, gray)
    np.testing.assert_array_equal(gray, expected)


def test_errors_are_predicted_as_in_python(core, baseline):
    _, tensors = read_weights(UNCERTAINTY)
    predictor = core.predictor(tensors)
    for size in SIZES:
        stack = noise(size, 0.1)
        gray = noise(size, 1)[1]
        expected = np.empty_like(gray)
        _core.ErrorPredictor(tensors)(_core.gbuffer_layout(), stack, gray[None], expected[None])
        np.testing.assert_allclose(core.predict_error(predictor, stack, gray), expected, rtol=0, atol=1e-5)
    core.call("free_predictor", predictor)


# ---- Pixel orders ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (130, 67), (240, 320)])
def test_the_adaptive_order_is_that_of_python(core, size):
    traced = bob.trace(bob.happy_tree(), size=size).stack()
    for seed, planes in ((0, traced), (2**64 - 1, noise(size, 1))):
        order = _core.AdaptiveOrder(seed, *size)
        for found in core.adaptive_order(seed, planes):
            np.testing.assert_array_equal(found, order.next(_core.gbuffer_layout(), planes))


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (130, 67), (240, 320)])
def test_the_order_of_squares_is_that_of_python(core, size):
    for planes in (bob.trace(bob.happy_tree(), size=size).stack(), noise(size, 1)):
        order = _core.SquaresOrder(*size)
        for found in core.squares_order(planes):
            np.testing.assert_array_equal(found, order.next(_core.gbuffer_layout(), planes))


# ---- Scenes ----------------------------------------------------------------------------------------------


def mesh():
    random = np.random.default_rng(0)
    return bob.Mesh(random.normal(size=(60, 3)), random.permuted(np.tile(np.arange(60), (4, 1)), axis=1).reshape(-1, 3))


def with_holes():
    """Holes of a texture and of vertices."""
    random, points = np.random.default_rng(2), np.random.default_rng(0).normal(size=(60, 3))
    return bob.Mesh(
        points,
        mesh().triangles,
        colors=random.uniform(size=(60, 4)),
        uv=random.uniform(-1, 2, (60, 2)),
        texture=random.integers(0, 256, (16, 8, 4), np.uint8),
        wrap=("mirror", "repeat"),
        alpha_cutoff=0.2,
    )


def script(text=SCRIPT):
    made = _core.run_script(text.encode())
    return bob.Implicit(made.expression, color=made.color)


def ball():
    made = sphere(1).mesh(0.4)
    return Mesh(made.vertices, made.triangles)


def tube():
    return bob.Tube([(-1, 0, 0), (0, 1, 0), (0, -1, 0.5), (1, 0, 0)], [0, 0, 0, 0, 1, 1, 1, 1], 0.1)


SCENES = {
    "mesh": mesh,
    "script": script,
    "brep": cylinder,
    "tube": tube,
    "several": lambda: [mesh(), bob.Instance(script()).scale(0.5).translate((2, 0, 0)), cylinder(), tube()],
    "colored": lambda: [
        bob.Mesh(mesh().vertices, mesh().triangles, colors=np.random.default_rng(1).uniform(size=(60, 3))),
        bob.Instance(script(), material=bob.Material("#b87333", metallic=1, roughness=0.3)).translate((2, 0, 0)),
    ],
    "colored with holes": with_holes,
    "colored brep": lambda: bob.Brep(
        [
            bob.Face(face.control_points, face.knots_u, face.knots_v, face.weights, face.trims, color)
            for face, color in zip(cylinder().faces, ("#c33", "#39c", None, "#fd3") * 2, strict=False)
        ]
    ),
    "mesh in a formula": lambda: ball().sdf().dilate(0.1) - sphere(0.7).translate((0.5, 0, 0)),
    "colored mesh in a formula": lambda: ball().sdf().color("#c33") | box(1).translate((1, 0, 0)).color("#39c"),
    "colored script": lambda: script(
        "f = sphere(1).color('#c33') & box(1.5).color('#39c').k(0.2)\nf -= cylinder(0.5).twist(1).color((1, 0.5, 0))\n"
    ),
}


@pytest.mark.parametrize("kind", SCENES)
def test_scenes_are_traced_as_in_python(core, kind, baseline, monkeypatch):
    made = recorded(monkeypatch)
    scene, size = bob.Scene(SCENES[kind]()), (61, 90)
    theirs, pixels = core.scene(made, scene._arrangement), bob.pixel_order(size, count=3000)
    for fov in (0, 40):
        camera = bob.Camera(azimuth=50, elevation=25, roll=10, zoom=1.1, fov=fov, pan=(0.1, -0.05))
        traced = bob.trace(scene, camera, size=size, fraction=3000 / (61 * 90), order="lattice")
        expected = traced.planes[: 8 if kind.startswith("colored") else 5]
        planes = core.trace(theirs, camera, size, pixels)
        assert expected[2].any()
        np.testing.assert_array_equal(planes[0], expected[0], err_msg=f"{fov=}")
        np.testing.assert_allclose(planes, expected, rtol=0, atol=1e-5, err_msg=f"{fov=}")
        if not core.relaxed:
            np.testing.assert_array_equal(planes[2], expected[2], err_msg=f"{fov=}")
            if kind not in ("mesh", "several", "colored", "colored with holes"):
                np.testing.assert_array_equal(planes[3:5], expected[3:5], err_msg=f"{fov=}")


@pytest.mark.parametrize("fov", [0, 40])
def test_a_camera_that_moved_expects_what_it_does_in_python(core, fov, baseline, monkeypatch):
    made, size = recorded(monkeypatch), (61, 90)
    before, camera = bob.Camera(azimuth=50, fov=fov), bob.Camera(azimuth=53, elevation=22, zoom=1.05, fov=fov)
    scene = bob.Scene(bob.happy_tree())
    seen = np.concatenate([bob.trace(scene, before, size=size, fraction=0.5).stack(), np.zeros((1, *size))])
    seen = seen.astype(np.float32)
    layout = _core.remembered_layout(False)
    history = _core.History(layout, *size)
    history.add(before.core((0, 0, 0), 1), seen)
    planes, off_center = np.empty_like(seen), np.empty(size, np.float32)
    surfaces = history.expect(camera.core((0, 0, 0), 1), planes, off_center, scene.core)
    order = _core.RefreshOrder(*size)
    order.begin(5)
    pixels = order.next(layout, np.zeros_like(seen), planes, off_center, 200)
    assert 300 < surfaces < planes[0].sum() < planes[0].size
    for found, expected in zip(
        core.expected(core.scene(made, scene._arrangement), before, seen, camera, 200),
        (planes, off_center, surfaces, pixels),
        strict=True,
    ):
        np.testing.assert_array_equal(found, expected)


def test_frames_of_light_are_those_of_python(core, baseline, monkeypatch):
    """In motion, at rest, and in motion again: the same pixels have the same paths, unless rounding parts them."""
    made, size, share = recorded(monkeypatch), (60, 80), 0.1
    scene = bob.Scene(SCENES["several"]())
    first, second, third = (bob.Camera(azimuth=azimuth) for azimuth in (30, 32, 34))
    view = bob.View(scene, size=size, light="studio", ground=True)
    light = core.light(core.scene(made, scene._arrangement), 30, scene.radius)
    for camera in (first, second, None, None, third):
        frame = view.frame(camera, fraction=share)
        mask, picture = core.lit_frame(light, camera, size, share * frame.image.size)
        guides = frame.gbuffer.guides
        shown = (guides.hit > 0) | (guides.ground.hit > 0)
        assert ((mask * shown > 0) != (frame.gbuffer.mask > 0)).mean() < 0.001
        color, alpha = smoothed(frame.shown, frame.color, frame.alpha)
        expected = np.concatenate([np.moveaxis(color, -1, 0), alpha[None]])
        assert np.abs(picture - expected).mean() < 1e-5
    core.call("free_light", light)


def test_frames_are_planned_as_in_python(core):
    modes, completions = ("whole", "squares", "adaptive", "reproject"), ("filling", "small", "default")
    ours = _core.FramePlanner(640 * 480, [*completions])
    theirs = core.made("make_planner", 0)
    before, random = bob.Camera(), np.random.default_rng(3)
    seen = set()
    for _ in range(300):
        camera = bob.Camera(azimuth=30 + 20 * random.random())
        seconds, rate = random.choice([0.005, 0.02, 0.1]), 10 ** random.uniform(5, 7.5)
        cameras = [each.core((0, 0, 0), 1) for each in (before, camera)]
        parallax = _core.parallax(*cameras, 480, 640)
        mode = ours.plan(seconds, parallax)
        seen.add(mode)
        found = core.call("plan_frame", theirs, placed(before), placed(camera), 480, 640, seconds, 1.0)
        assert modes[found] == mode
        m = modes.index(mode)
        known = random.random() ** 3
        completion = ours.completion(mode, known, seconds)
        assert completions[core.call("frame_completion", theirs, m, known, seconds, 1.0)] == completion
        c = completions.index(completion)
        assert core.call("frame_tracing", theirs, m, c, seconds) == ours.for_tracing(mode, completion, seconds)
        assert core.call("frame_pixels", theirs, m, seconds) == ours.pixels_in(mode, seconds)
        is_first = int(random.integers(2))
        ours.traced(mode, 3000, 3000 / rate, bool(is_first))
        core.call("planner_traced", theirs, m, 3000.0, 3000 / rate, is_first)
        ours.completed(completion, 640 * 480, 0.002 * (1 + c))
        core.call("planner_completed", theirs, c, 640.0 * 480, 0.002 * (1 + c))
        if mode == "reproject":
            ours.reprojected(640 * 480, 0.004)
            core.call("planner_reprojected", theirs, 640.0 * 480, 0.004)
    assert seen == set(modes)
    core.call("free_planner", theirs)


def test_languages_are_those_of_python(core):
    for function, python, text in (("run_script", lambda t: _core.run_script(t).expression, SCRIPT.encode()),
                                   ("parse_vm", _core.parse_vm, VM)):  # fmt: skip
        bounds = np.zeros((2, 3))
        core.made("find_bounds", core.made(function, text), bounds)
        np.testing.assert_allclose(bounds, _core.find_bounds(python(text)), rtol=1e-12)


def test_scripts_have_the_same_nodes_as_in_python(core):
    """Though compiled by another compiler.

    Only the last bits of sines and cosines differ between libraries: because of them, constants of gear.sdf are equal
    in one and different in the other.
    """
    examples = [(EXAMPLES / name).read_text() for name in ("tower.sdf", "vase.sdf")]
    assert all(re.search(rf"\b{word.name}\(|ease\.{word.name}\b", "\n".join(SCRIPTS)) for word in WORDS)
    for text in [*SCRIPTS, *examples]:
        assert_same_nodes(text, core.nodes("run_script", text.encode()), _core.run_script(text.encode()).expression)


def test_colors_of_scripts_have_the_same_nodes_as_in_python(core):
    assert core.color_nodes(b"sphere(1)") is None
    for text in COLORED:
        color = _core.run_script(text.encode()).color
        *nodes, roots = core.color_nodes(text.encode())
        assert_same_nodes(text, nodes, color)
        np.testing.assert_array_equal(roots, color.roots)


@pytest.mark.parametrize("line", ["compare x y", "round x", "not x", "mod x y", "and x y", "or x y", "recip x"])
def test_vm_files_have_the_same_nodes_as_in_python(core, line):
    text = f"x var-x\ny var-y\na {line}\nb square y\nc add b a\n".encode()
    assert_same_nodes(line, core.nodes("parse_vm", text), _core.parse_vm(text))


# ---- Errors ----------------------------------------------------------------------------------------------


def test_errors_are_those_of_python_and_the_module_goes_on(core):
    for text in (b"sphere(", b"a = 1\nsphere(a, b=2)", b"x", "sphere('\N{SNOWMAN}')".encode(), b"sphere(1e999)"):
        with pytest.raises(ValueError) as expected:
            _core.run_script(text)
        with pytest.raises(CoreError) as found:
            core.made("run_script", text)
        assert str(found.value) == str(expected.value)
    with pytest.raises(CoreError, match=r"encode1\.weight: expected in the weights, not found"):
        core.network("paper", {})
    with pytest.raises(CoreError, match="expected weights of one of the networks filling, paper, pyramid, got 'x'"):
        core.network("x", {})
    with pytest.raises(CoreError, match="index out of range"):
        core.mesh(np.zeros((3, 3)), np.array([(0, 1, 3)], np.int32), None)
    assert core.made("run_script", b"sphere(1)")
