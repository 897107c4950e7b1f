"""Every argument of every public function, with unusable values: success, or a one-line InputError."""

import inspect
import os
import warnings

import numpy as np

import bobrossnet as bob
from bobrossnet import sdf
from bobrossnet.command_line import cli

HOSTILE = {
    "None": None,
    "empty": "",
    "word": "b" * 300,
    "surrogate": "\ud800",
    "nul": "a\0b",
    "bytes": b"x",
    "huge": 10**400,
    "digits": 10**5000,
    "-1": -1,
    "nan": float("nan"),
    "inf": float("inf"),
    "1e308": 1e308,
    "list": [],
    "dict": {},
    "set": {1},
    "object": object(),
    "type": int,
    "lambda": lambda *_: None,
    "complex": 1j,
    "ragged": [(1, 2), (3,)],
    "nested": [[["x"]]],
    "array0": np.zeros(()),
    "array3": np.zeros(3),
    "array22": np.full((2, 2), np.nan),
    "objects": np.array([None, object()]),
    "strings": np.array(["a", "b"]),
    "images": np.zeros((0, 4, 4), np.uint8),
    "True": True,
    "module": np,
}

ALLOWED = (TypeError, ValueError, OSError)
"""InputError is a ValueError."""

SLOW = {"workers", "scheduler"}
"""Arguments with values that start processes or connect to other machines."""

LEFT_OUT = {
    "Between": "made by measure",
    "Brep": "an argument of nurbs_surface, which makes one",
    "Drawing": "made by draw",
    "Contours": "made by section",
    "Face": "made by a Brep",
    "FaceMeasures": "made by measure",
    "Frame": "made by progressive and View",
    "Hits": "made by closest_hits",
    "InputError": "an exception",
    "InputTypeError": "an exception",
    "InputWarning": "a warning",
    "Measures": "made by measure",
    "Part": "made by Scene.parts",
    "Pick": "made by pick",
    "Picture": "made by render",
    "Shape": "abstract",
    "Tube": "made by nurbs_curve and polyline",
    "TrimCurve": "an argument of nurbs_surface",
    "export": "needs PyTorch",
    "thread_count": "has no arguments",
    "thumbnails": "starts processes",
    "view": "needs a notebook",
}
"""Public names that are not called, and the reason."""


class Calls:
    """Small valid calls."""

    def __init__(self, folder):
        self.folder = folder
        mesh = bob.Mesh([(0, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2)])
        self.mesh, self.scene, self.camera = mesh, bob.Scene(mesh), bob.Camera()
        self.part = bob.trace(mesh, size=(8, 8), fraction=0.5)
        self.full = bob.trace(mesh, size=(8, 8))
        mesh.save(folder / "mesh.ply")

    def functions(self):
        part, full, mesh, scene = self.part, self.full, self.mesh, self.scene
        gray = np.full((8, 8), 0.5, np.float32)
        ball = sdf.sphere(1)
        camera = self.camera
        yield "Camera", bob.Camera, {"position": (9, 0, 0), "target": (0, 0, 0), "fov": 30, "up": (0, 0, 1)}
        yield (
            "Camera of an orbit",
            bob.Camera,
            {"azimuth": 0, "elevation": 0, "roll": 0, "zoom": 1, "fov": 0, "pan": (0, 0)},
        )
        yield "Edges", bob.Edges, {"width": 2, "color": "#000", "hidden": True}
        yield "Film", bob.Film, {"scene": scene, "cameras": [camera], "size": (8, 8)}
        yield (
            "GBuffer",
            bob.GBuffer,
            {
                "mask": np.ones((8, 8), bool),
                "gray": gray,
                "depth": gray,
                "normal": np.zeros((8, 8, 2), np.float32),
            },
        )
        yield (
            "Guides",
            bob.Guides,
            {"depth": gray, "normal": np.zeros((8, 8, 2)), "albedo": np.ones((8, 8, 3)), "hit": gray},
        )
        yield "Implicit", bob.Implicit, {"expression": ball.expression, "bounds": ((-2, -2, -2), (2, 2, 2))}
        yield "Instance", bob.Instance, {"shape": mesh}
        yield "Glass", bob.Glass, {"color": "#fff", "ior": 1.5, "attenuation": "#4a7", "distance": 0.5}
        yield "Light", bob.Light, {"direction": (0, 0, 1), "angle": 5, "color": "#fff", "intensity": 1}
        yield "Material", bob.Material, {"color": "#fff"}
        yield "Mesh", bob.Mesh, {"vertices": mesh.vertices, "triangles": mesh.triangles}
        yield "Samples", bob.Samples, {"gray": [0.5, 0.5]}
        yield "Scene", bob.Scene, {"shapes": mesh}
        yield "Section", bob.Section, {"normal": (1, 0, 0), "offset": 0.5}
        yield "section", bob.section, {"scene": mesh, "section": "z=0"}
        yield "Sky", bob.Sky, {"top": "#fff", "bottom": "#000"}
        yield "SceneTracer", bob.SceneTracer, {"scene": scene, "camera": camera, "size": (8, 8)}
        yield "SDF3", sdf.SDF3, {"function": lambda p: p[:, 0]}
        yield "SDF2", sdf.SDF2, {"function": lambda p: p[:, 0]}
        yield "View", bob.View, {"scene": scene, "size": (8, 8)}
        yield "save", bob.save, {"image": gray, "path": self.folder / "gray.png"}
        yield "sheet", bob.sheet, {"scene": mesh, "views": ["top"], "size": (240, 240), "title": "a", "unit": "mm"}
        yield "draw", bob.draw, {"scene": scene, "camera": camera, "size": (8, 8)}
        yield "Drawing.save", bob.draw(mesh, size=(8, 8)).save, {"path": self.folder / "a.svg"}
        yield (
            "views",
            bob.views,
            {"scene": mesh, "cameras": [camera], "channels": ["depth"], "size": (8, 8), "samples": 1},
        )
        yield "complete", bob.complete, {"gbuffer": part, "model": "filling", "channel": "gray"}
        yield "measure", bob.measure, {"what": bob.Scene(mesh, unit="mm"), "unit": "m"}
        yield "pick", bob.pick, {"scene": mesh, "row": 0, "column": 0, "camera": camera, "size": (8, 8), "snap": 2}
        yield "fitted", bob.fitted, {"scene": scene, "camera": camera, "size": (8, 8)}
        yield "happy_tree", bob.happy_tree, {}
        yield "implicit", bob.implicit, {"function": lambda x, y, z: x * x + y * y + z * z - 1}
        yield "load", bob.load, {"source": self.folder / "mesh.ply"}
        yield "load_mesh", bob.load_mesh, {"path": self.folder / "mesh.ply"}
        yield (
            "nurbs_curve",
            bob.nurbs_curve,
            {"control_points": [(0, 0, 0), (1, 0, 0)], "knots": [0, 0, 1, 1], "radius": 0.1},
        )
        yield (
            "nurbs_surface",
            bob.nurbs_surface,
            {
                "control_points": np.random.default_rng(1).random((2, 2, 3)),
                "knots_u": [0, 0, 1, 1],
                "knots_v": [0, 0, 1, 1],
            },
        )
        yield (
            "Face.points",
            bob.nurbs_surface(np.random.default_rng(1).random((2, 2, 3)), [0, 0, 1, 1], [0, 0, 1, 1]).faces[0].points,
            {"u": 0.5, "v": 0.5},
        )
        yield "orbit", bob.orbit, {"scene": scene, "camera": camera, "frames": 2, "size": (8, 8)}
        yield "pixel_order", bob.pixel_order, {"size": (8, 8), "order": "lattice", "seed": 0, "start": 0, "count": 4}
        yield "polyline", bob.polyline, {"points": [(0, 0, 0), (1, 0, 0)], "radius": 0.1}
        yield (
            "progressive",
            first_frame,
            {"scene": scene, "camera": camera, "size": (8, 8), "fraction": 0.5},
        )
        yield "psnr", bob.psnr, {"image": gray, "reference": gray}
        yield "ssim", bob.ssim, {"image": np.zeros((16, 16), np.float32), "reference": np.zeros((16, 16), np.float32)}
        yield "render", bob.render, {"scene": scene, "camera": camera, "size": (8, 8)}
        yield "render of a part", bob.render, {"scene": scene, "fraction": 0.5, "size": (8, 8), "model": "filling"}
        yield "save_scene", bob.save_scene, {"scene": scene, "path": self.folder / "out.bob"}
        yield "set_thread_count", bob.set_thread_count, {"count": 2}
        yield (
            "trace",
            bob.trace,
            {"scene": scene, "camera": camera, "size": (8, 8), "order": "lattice", "fraction": 0.5},
        )
        yield "uncertainty", bob.uncertainty, {"gbuffer": part}
        yield "GBuffer.sample", full.sample, {"fraction": 0.5}
        yield "Picture.save", bob.render(mesh, size=(8, 8)).save, {"path": self.folder / "a.png"}
        yield "Scene.mesh", scene.mesh, {"step": 0.5}
        yield "Scene.part", scene.part, {"which": 0}
        yield "Scene.color", scene.color, {"part": 0, "color": "red"}
        yield "Scene.explode", scene.explode, {"factor": 1, "axis": "x"}
        yield "Scene.turned", scene.turned, {"up": "y"}
        yield "Scene.converted", bob.Scene(mesh, unit="mm").converted, {"unit": "m"}
        yield "Camera.named", bob.Camera.named, {"view": "front"}
        yield "View.pick", bob.View(scene, size=(8, 8)).pick, {"row": 0, "column": 0}
        yield "Scene.closest_hits", scene.closest_hits, {"origins": [(9, 0, 0)], "directions": [(-1, 0, 0)]}
        yield "Mesh.save", mesh.save, {"path": self.folder / "a.stl"}
        yield "Mesh.mesh", mesh.mesh, {"step": 0.5}
        yield "Instance.translate", bob.Instance(mesh).translate, {"offset": (0, 0, 1)}
        yield "Instance.scale", bob.Instance(mesh).scale, {"factor": 2}
        yield "Instance.rotate", bob.Instance(mesh).rotate, {"angle": 1, "vector": (0, 0, 1)}
        yield "Instance.transformed", bob.Instance(mesh).transformed, {"matrix": np.eye(4)}
        yield "SDF3.save", ball.save, {"path": self.folder / "a.stl", "step": 0.5, "samples": 64}
        yield "SDF3.generate", ball.generate, {"step": 0.5}
        yield "SDF3.generate of samples", ball.generate, {"samples": 100}
        yield "SDF3.sample_slice", ball.sample_slice, {"w": 4, "h": 4, "z": 0}
        yield "SDF3()", ball, {"points": [(0, 0, 0)]}
        yield "SDF3.k", ball.k, {"k": 0.1}
        yield "write_binary_stl", sdf.write_binary_stl, {"path": self.folder / "b.stl", "points": np.eye(3)}
        yield "image", sdf.image, {"path_or_array": np.eye(4, dtype=np.uint8) * 255}
        yield "measure_image", sdf.measure_image, {"path_or_array": np.eye(4, dtype=np.uint8) * 255}
        yield "text", sdf.text, {"font_name": "none.ttf", "text": "a"}
        yield "sdf.Mesh.sdf", sdf.Mesh(mesh.vertices, mesh.triangles).sdf, {}
        yield "sdf.Mesh.from_file", sdf.Mesh.from_file, {"path": self.folder / "mesh.ply"}


def first_frame(*args, **kwargs):
    frames = bob.progressive(*args, **kwargs)
    try:
        return next(frames)
    finally:
        frames.close()


first_frame.__signature__ = inspect.signature(bob.progressive)


def told(function, arguments):
    """Return the defect of a call's outcome, or None."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            function(**arguments)
        except ALLOWED as error:
            text = str(error)
            if type(error) not in (bob.InputError, bob.InputTypeError):
                return f"{type(error).__name__}: {text[:150]}"
            if "\n" in text or len(text) > 500:
                return f"not one short line: {text[:150]}"
            text.encode()
            return None
        except Exception as error:
            return f"{type(error).__name__}: {str(error)[:150]}"
    return None


def problems(name, function, arguments):
    parameters = inspect.signature(function).parameters
    for parameter in parameters.values():
        if parameter.name in SLOW or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        for label, value in HOSTILE.items():
            wrong = told(function, {**arguments, parameter.name: value})
            if wrong is not None:
                yield f"{name}({parameter.name}={label}): {wrong}"


def test_every_public_name_is_called(tmp_path):
    called = {name.split()[0] for name, *_ in Calls(tmp_path).functions()}
    public = {name for name in bob.__all__ if callable(getattr(bob, name))}
    assert public - called == set(LEFT_OUT)


def test_functions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = []
    threads = bob.thread_count()
    for name, function, arguments in Calls(tmp_path).functions():
        found += problems(name, function, arguments)
    bob.set_thread_count(threads)
    assert not found, "\n".join(found)


def test_words():
    found = []
    base = {2: sdf.circle(1), 3: sdf.sphere(1)}
    for module, dimensions in ((sdf.d2, 2), (sdf.d3, 3)):
        for word in (word for word in sdf.words.WORDS if word.dimensions == dimensions):
            function = getattr(module, word.name)
            for place, parameter in enumerate(word.parameters):
                for label, value in HOSTILE.items():
                    needed = [
                        value if i == place else base[dimensions] if each.type == "sdf" else EXAMPLES.get(each.type)
                        for i, each in enumerate(word.parameters[: place + 1])
                    ]
                    wrong = told(lambda function=function, needed=needed: function(*needed), {})
                    if wrong is not None:
                        found.append(f"{word.name}({parameter.name}={label}): {wrong}")
    assert not found, "\n".join(found)


EXAMPLES = {"number": 1, "integer": 2, "vector": (1, 1, 1), "size": 1, "easing": sdf.ease.linear, "color": "#fff"}


def test_only_files_are_read_as_weights(tmp_path, capsys):
    """A pipe would block its reader forever, and no disk allows a name of 300 characters."""
    os.mkfifo(tmp_path / "pipe.safetensors")
    render = ["render", "--size", "8x8", "--fraction", "50%", "-o", str(tmp_path / "a.png"), "--model"]
    for model in (str(tmp_path / "pipe.safetensors"), "x" * 300, f"{'x' * 300}.safetensors"):
        for command in (*([*render, model],), ["info", model]):
            assert cli.main(command) == 2
            said = capsys.readouterr().err
            assert said.startswith("bobrossnet: error: ")
            assert said.count("\n") == 1


def test_bytes_name_files(tmp_path):
    mesh = bob.Mesh([(0, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2)])
    for name, save in (
        ("a.stl", mesh.save),
        ("a.bob", lambda path: bob.save_scene(mesh, path)),
        ("a.png", bob.render(mesh, size=(8, 8)).save),
    ):
        save(os.fsencode(tmp_path / name))
        assert (tmp_path / name).is_file()
    assert bob.load(os.fsencode(tmp_path / "a.stl")).counts() == {"shape": 1, "triangle": 1}
