"""Trace a few percent of the pixels, see the whole picture.

>>> import bobrossnet as bob
>>> scene = bob.Scene(bob.happy_tree())
>>> part = bob.trace(scene, bob.Camera(azimuth=30, elevation=20), size=(120, 160), fraction=0.05)
>>> image = bob.complete(part)
"""

from typing import Any

# Imported first: it refuses sub-interpreters and keeps Ctrl-C during imports quiet.
from bobrossnet.command_line import starting  # noqa: F401

# isort: split
from bobrossnet._core import thread_count
from bobrossnet.adapters.container import save_scene
from bobrossnet.adapters.files import load, load_mesh
from bobrossnet.completion.complete import complete
from bobrossnet.completion.uncertainty import uncertainty
from bobrossnet.frames.frame import Frame
from bobrossnet.frames.motion import View
from bobrossnet.frames.progressive import progressive
from bobrossnet.measuring.measure import Between, FaceMeasures, Measures, measure
from bobrossnet.measuring.picking import Pick, pick
from bobrossnet.metrics import psnr, ssim
from bobrossnet.onnx import export
from bobrossnet.page.notebooks import register, view
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.files import save
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.order import pixel_order
from bobrossnet.picture.samples import Samples
from bobrossnet.pictures.drawing import Drawing, Edges, draw
from bobrossnet.pictures.filming import Film, orbit
from bobrossnet.pictures.fitting import fitted
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.rendering import render
from bobrossnet.pictures.sheets import sheet
from bobrossnet.pictures.thumbnails import thumbnails
from bobrossnet.pictures.views import views
from bobrossnet.sdf.formula import implicit
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.nurbs import Brep, Face, TrimCurve, nurbs_surface
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.tree import happy_tree
from bobrossnet.shapes.tube import Tube, nurbs_curve, polyline
from bobrossnet.support.errors import InputError, InputTypeError, InputWarning
from bobrossnet.support.machine import set_thread_count
from bobrossnet.tracing.contours import Contours, section
from bobrossnet.tracing.glass import Glass
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.light import Light, Sky
from bobrossnet.tracing.material import Material
from bobrossnet.tracing.parts import Part
from bobrossnet.tracing.scene import Hits, Scene
from bobrossnet.tracing.section import Section
from bobrossnet.tracing.trace import SceneTracer, trace

__all__ = [
    "Between",
    "Brep",
    "Camera",
    "Contours",
    "Drawing",
    "Edges",
    "Face",
    "FaceMeasures",
    "Film",
    "Frame",
    "GBuffer",
    "Glass",
    "Guides",
    "Hits",
    "Implicit",
    "InputError",
    "InputTypeError",
    "InputWarning",
    "Instance",
    "Light",
    "Material",
    "Measures",
    "Mesh",
    "Part",
    "Pick",
    "Picture",
    "Samples",
    "Scene",
    "SceneTracer",
    "Section",
    "Shape",
    "Sky",
    "TrimCurve",
    "Tube",
    "View",
    "complete",
    "draw",
    "export",
    "fitted",
    "happy_tree",
    "implicit",
    "load",
    "load_mesh",
    "measure",
    "nurbs_curve",
    "nurbs_surface",
    "orbit",
    "pick",
    "pixel_order",
    "polyline",
    "progressive",
    "psnr",
    "render",
    "save",
    "save_scene",
    "section",
    "set_thread_count",
    "sheet",
    "ssim",
    "thread_count",
    "thumbnails",
    "trace",
    "uncertainty",
    "view",
    "views",
]

register()

__version__: str


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version  # slow to import

        return version("bobrossnet")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
