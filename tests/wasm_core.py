"""The core as a WebAssembly module, run by wasmtime: viewer/core/core.js for numpy arrays."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import wasmtime

from bobrossnet import _core
from bobrossnet.completion.weights import DEFAULTS
from bobrossnet.support.paths import VIEWER

FOLDER = VIEWER

MAKERS = ("Mesh", "Texture", "Picture", "Implicit", "Brep", "Tube", "Arrangement")

WRAPS = ("repeat", "clamp", "mirror")


class CoreError(ValueError):
    """An error from the module."""


@cache
def compiled(name: str) -> tuple[wasmtime.Module, wasmtime.Engine]:
    config = wasmtime.Config()
    config.wasm_exceptions = True
    engine = wasmtime.Engine(config)
    return wasmtime.Module.from_file(engine, str(FOLDER / f"{name}.wasm")), engine


class WasmCore:
    """An instance of a module.

    Parameters
    ----------
    name : str
        "core" or "complete"; ".relaxed" at the end for relaxed-simd.
    """

    def __init__(self, name: str) -> None:
        self.module, engine = compiled(name)
        self.relaxed = name.endswith(".relaxed")
        self._store = wasmtime.Store(engine)
        self._exports = wasmtime.Instance(self._store, self.module, []).exports(self._store)
        self._exports["_initialize"](self._store)
        self._memory = self._exports["memory"]

    def call(self, name, *arguments):
        """Call a function.

        Arrays and texts are copied to the module's memory, texts followed by their size; writable arrays are copied
        back.
        """
        given, arrays, lent = [], [], []
        for argument in arguments:
            if isinstance(argument, str | bytes):
                text = argument.encode() if isinstance(argument, str) else argument
                address = self._put(text)
                lent.append(address)
                given += [address, len(text)]
            elif isinstance(argument, np.ndarray):
                assert argument.flags.c_contiguous
                address = self._put(argument.tobytes())
                lent.append(address)
                given.append(address)
                if argument.flags.writeable:
                    arrays.append((address, argument))
            else:
                given.append(argument)
        result = self._exports[name](self._store, *given)
        for address, array in arrays:
            array[...] = np.frombuffer(
                self._memory.read(self._store, address, address + array.nbytes), array.dtype
            ).reshape(array.shape)
        for address in lent:
            self._exports["release"](self._store, address)
        return result

    def made(self, name, *arguments):
        """Call a function that returns 0 on failure; raise CoreError then."""
        result = self.call(name, *arguments)
        if not result:
            address = self._exports["error"](self._store)
            text = self._memory.read(self._store, address, address + 1000)
            raise CoreError(bytes(text).split(b"\0")[0].decode())
        return result

    def _put(self, data: bytes) -> int:
        address = self._exports["allocate"](self._store, len(data))
        assert address
        self._memory.write(self._store, data, address)
        return address

    # ---- Networks ----------------------------------------------------------------------------------------

    def network(self, name, tensors, inputs=DEFAULTS["inputs"]):
        return self._made_of(tensors, lambda weights: self.made("make_network", name, weights), inputs)

    def predictor(self, tensors):
        return self._made_of(tensors, lambda weights: self.made("make_predictor", weights))

    def _made_of(self, tensors, make, inputs=DEFAULTS["inputs"]):
        weights = self.made("make_weights", inputs, DEFAULTS["outputs"])
        addresses = []
        for key, tensor in tensors.items():
            addresses.append(self._put(tensor.tobytes()))
            shape = np.array(tensor.shape, np.int32)
            self.made("add_tensor", weights, key, shape, tensor.ndim, addresses[-1])
        try:
            return make(weights)
        finally:
            self.call("free_weights", weights)
            for address in addresses:
                self.call("release", address)

    def run(self, network, stack):
        height, width = stack.shape[1:]
        gray = np.full((height, width), np.nan, np.float32)
        self.made("run_network", network, stack, height, width, gray, 0, height)
        return gray

    def predict_error(self, predictor, stack, gray):
        error = np.full(gray.shape, np.nan, np.float32)
        self.made("predict_error", predictor, stack, gray, *gray.shape, error)
        return error

    # ---- Scenes ------------------------------------------------------------------------------------------

    def adaptive_order(self, seed, planes):
        """Return all pixels in this order, round by round."""
        return self._rounds(self.made("make_adaptive_order", *halves(seed), *planes.shape[1:]), planes)

    def squares_order(self, planes):
        """Return all pixels in this order, round by round."""
        return self._rounds(self.made("make_squares_order", *planes.shape[1:]), planes)

    def _rounds(self, order, planes):
        count, left = np.zeros(1, np.uint32), planes[0].size
        while left > 0:
            address = self.made("next_round", order, 0, planes, count)
            found = self._memory.read(self._store, address, address + 8 * int(count[0]))
            yield np.frombuffer(found, np.int32).reshape(-1, 2)
            left -= int(count[0])
        with pytest.raises(CoreError, match="pixels that are left"):
            self.made("next_round", order, 0, planes, count)
        self.call("free_round_order", order)

    def expected(self, scene, before, seen, camera, count):
        """Reproject a history of gray planes (C, H, W) of a scene to another camera.

        Returns the planes, the offsets from the centre, and the number of pixels on a surface; and the first pixels to
        trace there.
        """
        size = seen.shape[1:]
        history = self.made("make_history", 0, *size)
        self.made("add_to_history", history, placed(before), seen)
        planes, off_center = np.full_like(seen, np.nan), np.full(size, np.nan, np.float32)
        surfaces = np.zeros(1, np.uint32)
        self.made("expect_from_history", history, scene, placed(camera), planes, off_center, surfaces)
        self.call("free_history", history)
        order, found = self.made("make_refresh_order", *size), np.zeros(1, np.uint32)
        self.call("begin_refresh", order, *halves(5))
        traced = np.zeros_like(seen)
        address = self.made("next_refresh", order, 0, traced, planes, off_center, count, found)
        pixels = self._memory.read(self._store, address, address + 8 * int(found[0]))
        self.call("free_refresh_order", order)
        return planes, off_center, int(surfaces[0]), np.frombuffer(pixels, np.int32).reshape(-1, 2)

    def light(self, scene, azimuth, radius):
        """Return the studio around a scene, with a ground."""
        return self.made("make_studio", scene, float(azimuth), 1, float(radius))

    def lit_frame(self, light, camera, size, count):
        """Turn to a camera, or rest if it is None, and trace `count` pixels.

        Returns the mask of pixels with paths of this camera or without need of any, and the picture, (4, H, W), of
        colour and coverage.
        """
        if camera is None:
            self.made("rest_light", light)
        else:
            self._shown = placed(camera)
            self.made("move_light", light, self._shown, *size)
        found = np.zeros(1, np.uint32)
        address = self.made("next_light", light, float(count), found)
        wanted = np.frombuffer(self._memory.read(self._store, address, address + 12 * int(found[0])), np.int32)
        traced = np.zeros((len(wanted) // 3, 7), np.float32)
        paths, seed = self.call("light_paths"), self.call("light_seed", light)
        self.made("trace_light", light, self._shown, *size, wanted, len(traced), paths, seed, traced)
        self.made("add_light", light, wanted, len(traced), traced)
        mask, picture = np.zeros(size, np.float32), np.zeros((4, *size), np.float32)
        self.call("light_mask", light, mask)
        self.made("complete_light", light, 1, picture)
        return mask, picture

    def expression(self, expression):
        arrays = expression.ops, expression.operands, expression.values, len(expression)
        meshes = self.meshes(expression)
        made = self.made("make_expression", *arrays, meshes)
        self.call("free_meshes", meshes)
        return made

    def meshes(self, formula):
        """Return the meshes of an expression or a colour formula, to be freed."""
        if not formula.mesh_arrays:
            return 0
        sizes, vertices, triangles = formula.mesh_arrays
        return self.made("make_meshes", sizes, len(sizes), vertices, len(vertices), triangles, len(triangles))

    def nodes(self, language, text):
        """Return the ops, operands and values of a script or a .vm file."""
        expression = self.made(language, text)
        nodes = nodes_of(self.call("expression_size", expression))
        self.call("read_expression", expression, *nodes)
        self.call("free_expression", expression)
        return nodes

    def color_nodes(self, text):
        """Return these for a script's colour, and its roots; None for a script without colour."""
        expression = self.made("run_script", text)
        count, nodes = self.call("color_size", expression), None
        if count:
            nodes = *nodes_of(count), np.zeros(3, np.uint32)
            self.call("read_color", expression, *nodes)
        self.call("free_expression", expression)
        return nodes

    def mesh(
        self, vertices, triangles, normals, colors=None, face_colors=None, uv=None, texture=None, alphas=None, cutoff=0
    ):
        """Make a mesh like `_core.Mesh`, but for the texture: a picture in the module, and its wrap modes."""
        picture, *wrap = texture or (0, "repeat", "repeat")
        arrays = normals, colors, face_colors, uv, alphas
        *given, of_vertices = [0 if array is None else array for array in arrays]
        look = *given, picture, *map(WRAPS.index, wrap), of_vertices, float(cutoff)
        return self.made("make_mesh", vertices, len(vertices), triangles, len(triangles), *look)

    def texture(self, made, texture):
        """Return the `mesh` argument for one of the core's textures."""
        picture, *wrap = made[id(texture)][1]
        texels, alpha = made[id(picture)][1]
        return self.made("make_picture", texels, *texels.shape[:2], 0 if alpha is None else alpha), *wrap

    def implicit(self, expression, bounds, color=None):
        formula = self.expression(expression)
        if color is not None:
            given = color.ops, color.operands, color.values, len(color), color.roots
            meshes = self.meshes(color)
            self.made("color_expression", formula, *given, meshes)
            self.call("free_meshes", meshes)
        return self.made("make_implicit", formula, bounds)

    def brep(self, faces, tolerance, colors=None, _numbers=None):
        table, loops, trims = [], [], []
        points, knots, trim_points, trim_knots = [], [], [], []
        for control_points, knots_u, knots_v, of_face in faces:
            n, m = control_points.shape[:2]
            table.append((n, m, len(knots_u) - n - 1, len(knots_v) - m - 1, len(of_face)))
            points.append(control_points.ravel())
            knots += [knots_u, knots_v]
            for loop in of_face:
                loops.append(len(loop))
                for curve_points, curve_knots in loop:
                    trims.append((len(curve_points), len(curve_knots) - len(curve_points) - 1))
                    trim_points.append(curve_points.ravel())
                    trim_knots.append(curve_knots)

        def joined(parts):
            return np.concatenate([*parts, np.zeros(1)])

        integers = [np.array(values or [0], np.int32) for values in (loops, trims)]
        return self.made(
            "make_brep", np.array(table, np.int32), len(table), joined(points), joined(knots),
            *integers, joined(trim_points), joined(trim_knots), float(tolerance), 0 if colors is None else colors,
        )  # fmt: skip

    def tube(self, control_points, knots):
        count = len(control_points)
        return self.made("make_tube", control_points, count, knots, len(knots) - count - 1)

    def scene(self, made, arrangement):
        """Rebuild the scene given to Python's core, from the result of `recorded`."""
        shapes, transforms, materials = made[id(arrangement)][1]
        numbers = np.array(
            [
                [*m.color, m.ambient, m.diffuse, m.specular, m.shininess, m.metallic, m.roughness, *m.emissive]
                + [
                    m.clearcoat,
                    m.clearcoat_roughness,
                    m.transmission,
                    m.ior,
                    *m.attenuation,
                    m.attenuation_distance,
                    m.is_thin,
                ]
                for m in materials
            ]
        )
        handles = []
        for shape in shapes:
            kind, arguments = made[id(shape)]
            if kind == "Mesh":
                arguments = [
                    self.texture(made, each) if index == 6 and each else each for index, each in enumerate(arguments)
                ]
            handles.append(getattr(self, kind.lower())(*arguments))
        return self.made("make_scene", np.array(handles, np.uint32), len(handles), transforms, numbers, np.zeros(4))

    def trace(self, scene, camera, size, pixels):
        """Return planes of mask, gray, depth, normal, and color if the scene has colours."""
        colored = int(self.call("scene_is_colored", scene))
        planes = np.zeros((8 if colored else 5, *size), np.float32)
        samples = np.full((len(pixels), 12 if colored else 6), np.nan, np.float32)
        self.made("trace", scene, placed(camera), *size, pixels, len(pixels), colored, samples)
        added = np.zeros(1, np.uint32)
        self.made("add_samples", colored, 1, pixels, samples, len(pixels), planes, *size, added)
        assert added[0] == len(pixels)
        return planes


def nodes_of(count):
    return np.zeros(count, np.uint8), np.zeros((count, 3), np.uint32), np.zeros(count)


def placed(camera):
    """Return an orbiting camera, as the module's arguments."""
    angles = camera.azimuth, camera.elevation, camera.roll
    return np.array([*angles, camera.zoom, *camera.pan, camera.fov], np.float32)


def halves(seed):
    """Return a seed as the module's arguments: its low and high halves, as wasmtime's numbers."""
    return np.array([seed & 0xFFFFFFFF, seed >> 32], np.uint32).view(np.int32).tolist()


def recorded(monkeypatch):
    """Record the construction of the core's shapes and scenes from now on: by `id`, class name and arguments."""
    made = {}

    def recorder(name, original):
        def make(*arguments):
            result = original(*arguments)
            made[id(result)] = (name, arguments)
            return result

        return make

    for name in MAKERS:
        monkeypatch.setattr(_core, name, recorder(name, getattr(_core, name)))
    return made
