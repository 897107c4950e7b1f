"""The entries of SparseBench, by name. To add one, write a function, here or in a new file, and its row."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from runpy import run_path
from typing import Any, NamedTuple

import numpy as np
import others
import protocol
from asking import F32, Ask, Placement

import bobrossnet as bob
from bobrossnet.completion.filling import FILLINGS, nearest
from bobrossnet.completion.network import load_network
from bobrossnet.learn.evaluation.methods import Method
from bobrossnet.picture.channels import GIVEN
from bobrossnet.picture.gbuffer import untraced_planes
from bobrossnet.picture.samples import scatter
from bobrossnet.picture.sequence import PixelSequence
from bobrossnet.support.errors import InputError


class Entry(NamedTuple):
    """A method of the benchmark."""

    about: str
    make: Callable[[], Any]
    """Makes the method or placement; ModuleNotFoundError or InputError if a package or file is missing."""
    places: bool = False
    """Whether it chooses its pixels."""
    groups: tuple[str, ...] = ("made", "models", "mitsuba", "measured")
    pictures: int | None = None
    """A slow method is measured on this number of pictures only, without orbits."""
    most: float = 1
    """Greatest share it is measured at."""


def network(name: str) -> Method:
    return partial(bob.complete, model=load_network(name))


def filling(name: str) -> Method:
    import cv2  # telea's, and a package of the extra `train`
    import scipy  # noqa: F401  the others'

    cv2.setNumThreads(1)
    return lambda part: FILLINGS[name](part.gray, part.mask)


def biharmonic() -> Method:
    from skimage.restoration import inpaint_biharmonic

    return lambda part: inpaint_biharmonic(part.gray, part.mask == 0).astype(np.float32)


def oidn_of_nearest() -> Method:
    """Denoise the nearest filling; its steps take the part of the noise."""
    from bobrossnet.adapters import oidn

    oidn.denoise(np.zeros((16, 16, 3), np.float32))  # says if pyoidn is missing

    def complete(part: bob.GBuffer) -> F32:
        filled = nearest(part.gray, part.mask)
        denoised = oidn.denoise(np.repeat(filled[..., None], 3, -1)).mean(-1)
        return np.where(part.mask > 0, part.gray, denoised)

    return complete


def placed(ask: Ask, order: str) -> bob.GBuffer:
    """Return the G-buffer of the first pixels of one of the package's orders."""
    sequence = PixelSequence(ask.size, order, seed=0)
    planes = untraced_planes(ask.size, GIVEN)
    while sequence.done < ask.budget:
        pixels = sequence.next(ask.budget - sequence.done, planes, GIVEN)
        scatter(ask(pixels), pixels, planes, GIVEN)
    return bob.GBuffer.from_stack(planes)


def in_order(order: str, make: Callable[[], Method]) -> Placement:
    """Place by one of the package's orders, and complete by a method for given masks."""
    complete = make()
    return lambda ask: complete(placed(ask, order))


def onnx_file(path: Path) -> Method:
    """Return an ONNX file's method: (1, C, H, W) planes to (1, 1, H, W) gray."""
    session = others.onnx_session(path)
    (source,) = session.get_inputs()
    count = source.shape[1] if isinstance(source.shape[1], int) else len(protocol.PLANES)

    def complete(part: bob.GBuffer) -> F32:
        (gray,) = session.run(None, {source.name: part.stack()[None, :count]})
        return np.where(part.mask > 0, part.gray, gray[0, 0])

    return complete


def _entries() -> dict[str, Entry]:
    networks = {name: f"`complete` with the network {name}" for name in ("default", "small", "paper")}
    networks["filling"] = "`complete` with the pyramid that learned nothing"
    entries = {name: Entry(about, partial(network, name)) for name, about in networks.items()}
    fillings = {
        "delaunay-linear": "linear over Delaunay triangles (scipy)",
        "nearest": "nearest known pixel (scipy)",
        "pull-push": "means of a pyramid",
        "telea": "fast marching (OpenCV)",
    }
    entries |= {name: Entry(about, partial(filling, name)) for name, about in fillings.items()}
    entries["biharmonic"] = Entry("biharmonic inpainting (scikit-image)", biharmonic, pictures=2)
    entries["oidn of nearest"] = Entry("Open Image Denoise of the nearest filling", oidn_of_nearest)
    entries["progiso"] = Entry("network of Dyken et al., TVCG 2024, in blue on white", others.progiso)
    for order in ("adaptive", "squares"):
        for name in ("default", "small", "filling", "delaunay-linear"):
            make = entries[name].make
            about = f"the order {order}, {entries[name].about}"
            entries[f"{order}, {name}"] = Entry(about, partial(in_order, order, make), places=True)
    entries["FAST"] = Entry(
        "Kandel et al., Nature Communications 2023, own weights", others.fast, True, ("measured",), most=0.05
    )
    return entries


ENTRIES = _entries()


def entry_of(name: str) -> tuple[str, Entry]:
    """Return the name and entry of a method: one of `ENTRIES`, a Python file or an ONNX file.

    Raises
    ------
    InputError
        If there is no such method.
    """
    path = Path(name)
    if name in ENTRIES:
        return name, ENTRIES[name]
    if path.suffix == ".onnx" and path.is_file():
        return path.stem, Entry(path.name, partial(onnx_file, path))
    if path.suffix == ".py" and path.is_file():
        return path.stem, _entry_of_file(path)
    raise InputError(f"methods: expected files ending in .py or .onnx, or some of {', '.join(ENTRIES)}, got {name!r}")


def _entry_of_file(path: Path) -> Entry:
    found: dict[str, Any] = run_path(str(path))
    for name, places in (("complete", False), ("place", True)):
        if name in found:
            return Entry(path.name, partial(found.get, name), places)
    raise InputError(f"{path}: expected a function complete(part) or place(ask), got neither")
