"""OpenEXR files with any number of channels and any range. Needs the extra `exr`.

The channels are named LAYER.COMPONENT. Their roles follow from common names: Blender's passes, Mitsuba's AOVs, and
the auxiliary images of denoisers.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.guides import Guides
from bobrossnet.picture.order import Size, check_size
from bobrossnet.support.atomic import check_writable, write_whole
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import errors_at
from bobrossnet.support.paths import check_file, path_of

F32 = NDArray[np.float32]
Planes = dict[str, NDArray[Any]]
"""Planes, (H, W) float32, float16 or uint32, by channel name."""

ENDING = ".exr"
MAGIC = b"\x76\x2f\x31\x01"

ROLES = ("color", "depth", "normal", "albedo", "mask")

OF_PICTURE = (
    "dataWindow",
    "displayWindow",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "chromaticities",
    "whiteLuminance",
)
"""Attributes that a completed picture keeps: its place, and the meaning of its numbers."""

KNOWN_BETWEEN = 0.05
"""A layer is dense if its rate of nonzero values outside the mask is at least this fraction of the rate inside."""

BEYOND = 1e9
"""Larger depths are background: Blender writes 1e10 there."""

UNIT = 0.02
"""Tolerance of normals: a layer with X, Y and Z holds normals if their lengths are near 1 or 0.

Other layers are positions or motion.
"""


@dataclass(frozen=True)
class ExrFile:
    """The channels of a file and their roles."""

    planes: Planes
    roles: dict[str, list[str]]
    """Channel names of each of the `ROLES` present, in the order of components."""
    header: dict[str, Any]
    """Attributes of the whole picture from the file's header."""

    @property
    def size(self) -> Size:
        """(height, width)"""
        height, width = next(iter(self.planes.values())).shape
        return height, width

    def role(self, name: str) -> F32 | None:
        """Return the channel of a role, (H, W) or (H, W, components) float32, or None if the file lacks it."""
        names = self.roles.get(name)
        if not names:
            return None
        values = np.stack([self.planes[each].astype(np.float32) for each in names], axis=-1)
        return values[..., 0] if len(names) == 1 else values

    def traced(self) -> NDArray[np.bool_]:
        """Return the known pixels: where the mask or alpha is not 0, or without these, where there is light."""
        color, mask = self.role("color"), self.role("mask")
        assert color is not None
        light = color.reshape(*self.size, -1)
        lit = np.any(light > 0, axis=-1) if mask is None else np.greater(mask, 0)
        known: NDArray[np.bool_] = np.logical_and(np.isfinite(light).all(axis=-1), lit)
        return known

    def gbuffer(self) -> GBuffer:
        """Return the traced pixels as a G-buffer; channels known at all pixels become its guides."""
        traced = self.traced()
        color = self.role("color")
        assert color is not None
        color = np.where(traced.reshape(*self.size, *[1] * (color.ndim - 2)), np.maximum(color, 0), 0)
        light = {"gray" if color.ndim == 2 else "color": color.astype(np.float32)}
        surface: dict[str, Any] = {}
        depth, normal, albedo = (self.role(name) for name in ("depth", "normal", "albedo"))
        if depth is not None:
            hit = np.isfinite(depth) & (np.abs(depth) < BEYOND)
            surface["depth"] = np.where(hit, depth, 0).astype(np.float32)
        if normal is not None:
            surface["normal"] = _toward_viewer(np.nan_to_num(normal))[..., :2]
        if albedo is not None:
            shown = np.clip(np.nan_to_num(albedo), 0, 1).astype(np.float32)
            surface["albedo"] = np.where((shown > 0).any(axis=-1, keepdims=True), shown, 1).astype(np.float32)
        dense = {name: values for name, values in surface.items() if self.is_dense(self.roles[name][0])}
        known = {name: values for name, values in surface.items() if name != "albedo"}
        return GBuffer(mask=traced.astype(np.float32), **light, **known, guides=Guides(**dense) if dense else None)

    def is_dense(self, name: str) -> bool:
        """Return whether a channel is known at all pixels.

        It is, if its role's channels are nonzero nearly as often outside the mask as inside.
        """
        group = next((names for names in self.roles.values() if name in names), [name])
        traced, present = self.traced(), np.any([self.planes[each] != 0 for each in group], axis=0)
        return bool(traced.all() or present[~traced].mean() >= KNOWN_BETWEEN * present[traced].mean())


def read_exr(path: str | os.PathLike[str], names: Mapping[str, str] | None = None) -> ExrFile:
    """Read a file of scanlines or tiles, with one part or several of equal size.

    Parameters
    ----------
    path : str or path
    names : mapping, optional
        Maps "color", "depth", "normal", "albedo" and "mask" to a layer or a channel, where common names do not decide.

    Raises
    ------
    InputError
        If OpenEXR is not installed, the file can't be read or has no colours, or a name matches no layer of it.
    """
    library = openexr()
    path = path_of(path)
    if os.path.exists(path):
        with errors_at(str(path)):
            check_file(path)
    try:
        with path.open("rb") as stream:  # OpenEXR also prints its errors
            first = stream.read(len(MAGIC))
    except OSError as error:
        raise InputError(f"{path}: expected an OpenEXR file, can't read it: {error.strerror}") from None
    if first != MAGIC:
        raise InputError(f"{path}: expected an OpenEXR file, got {'another' if first else 'an empty file'}")
    try:
        with library.File(str(path), separate_channels=True) as file:
            # Copies, because closing the file frees its headers.
            parts = [(dict(part.header), {n: c.pixels for n, c in part.channels.items()}) for part in file.parts]
    except Exception as error:  # OpenEXR raises plain exceptions
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{path}: expected an OpenEXR file, can't read it: {reason}") from None
    planes: Planes = {}
    for header, channels in parts:
        prefix = f"{header['name']}." if len(parts) > 1 and header.get("name") else ""
        for name, pixels in channels.items():
            if pixels is None or pixels.ndim != 2 or pixels.dtype.hasobject:  # of a deep picture, an array each
                raise InputError(f"{path}: expected a flat picture, got a deep one, in {name}; flatten it first")
            planes[name if name not in planes else prefix + name] = pixels
    if not planes:
        raise InputError(f"{path}: expected an OpenEXR file with channels, got none; it may be cut short")
    sizes = {pixels.shape for pixels in planes.values()}
    if len(sizes) > 1:
        raise InputError(f"{path}: expected channels of one size, got {len(sizes)} different ones")
    check_size(next(iter(sizes)))
    windows = {str(header.get("dataWindow")) for header, channels in parts if channels}
    if len(windows) > 1:
        raise InputError(f"{path}: expected parts with one data window, got {len(windows)} different ones")
    roles = _roles(planes)
    for role, name in (names or {}).items():
        roles[role] = _named(path, planes, role, name)
    if "color" not in roles:
        raise InputError(f"{path}: expected colours, R, G and B or Y, got {_listed(planes)}; --color names a layer")
    return ExrFile(planes, roles, {name: value for name, value in parts[0][0].items() if name in OF_PICTURE})


def write_exr(
    path: str | os.PathLike[str], planes: Mapping[str, NDArray[Any]], header: Mapping[str, Any] | None = None
) -> None:
    """Write channels, (H, W) float32, float16 or uint32, by name, without loss; a failed write leaves no file."""
    library = openexr()
    place = check_writable(path, "a picture", [ENDING])
    channels = {name: np.ascontiguousarray(pixels) for name, pixels in planes.items()}
    settings = {**(header or {}), "compression": library.ZIP_COMPRESSION, "type": library.scanlineimage}
    with tempfile.TemporaryDirectory(prefix="bobrossnet-") as folder:
        beside = Path(folder) / "picture.exr"
        library.File(settings, channels).write(str(beside))
        write_whole(place, beside.read_bytes())


def _roles(planes: Planes) -> dict[str, list[str]]:
    """Assign roles to channels by common names."""
    layers: dict[str, dict[str, str]] = {}
    for name in planes:
        layer, _, component = name.rpartition(".")
        layers.setdefault(layer, {})[component.upper()] = name
    roles: dict[str, list[str]] = {}

    def components(layer: str, letters: Sequence[str]) -> list[str]:
        held = layers[layer]
        return [held[letter] for letter in letters] if all(letter in held for letter in letters) else []

    def last(layer: str) -> str:
        return layer.rpartition(".")[2].lower()

    def choose(role: str, *candidates: list[str]) -> None:
        chosen = next((names for names in candidates if names), None)
        if chosen:
            roles[role] = chosen

    main = [
        *(layer for layer in layers if layer == ""),
        *(
            layer
            for layer in layers
            if last(layer) in ("combined", "color", "colour", "beauty", "rgb", "rgba", "image")
        ),
    ]
    choose("color", *(components(layer, "RGB") for layer in main), *(components(layer, "Y") for layer in main))
    deep = [layer for layer in layers if any(word in last(layer) for word in ("depth", "zdepth")) or last(layer) == "z"]
    choose(
        "depth",
        *(components(layer, letter) for layer in deep for letter in "ZVTYR"),
        *(components(layer, "Z") for layer in main if "X" not in layers[layer]),
        *(components(layer, ["DEPTH"]) for layer in layers),
        *(components(layer, "T") for layer in layers),  # of Mitsuba's AOV, under any name
    )
    pointing = [
        layer for layer in layers if components(layer, "XYZ") and _are_normals(planes, components(layer, "XYZ"))
    ]
    said = sorted(pointing, key=lambda layer: not (last(layer).startswith("n") or "normal" in last(layer)))
    choose("normal", *(components(layer, "XYZ") for layer in said))
    of_surfaces = [layer for layer in layers if any(word in last(layer) for word in ("albedo", "diffcol", "basecolor"))]
    choose(
        "albedo",
        *(components(layer, "RGB") for layer in sorted(of_surfaces, key=lambda layer: "albedo" not in layer.lower())),
    )
    choose(
        "mask",
        *(components(layer, ["MASK"]) for layer in layers),
        *(list(layers[layer].values())[:1] for layer in layers if last(layer) == "mask"),
        *(components(layer, "A") for layer in main),
    )
    return roles


def _are_normals(planes: Planes, names: list[str]) -> bool:
    length = np.sqrt(sum(np.nan_to_num(planes[name].astype(np.float64)) ** 2 for name in names))
    fit = (np.abs(length - 1) < UNIT) | (length < UNIT)
    return bool(length.max(initial=0) < 1 + UNIT and fit.mean() > 0.5)  # along edges, normals are means


def _named(path: Path, planes: Planes, role: str, name: str) -> list[str]:
    """Return the channels of the layer, or the channel, of that name."""
    if name in planes:
        return [name]
    letters = {"color": "RGB", "albedo": "RGB", "normal": "XYZ"}.get(role)
    if letters and all(f"{name}.{letter}" in planes for letter in letters):
        return [f"{name}.{letter}" for letter in letters]
    only = [each for each in planes if each.rpartition(".")[0] == name]
    if letters or len(only) != 1:
        raise InputError(f"{path}: {role}: expected a layer or channel of {_listed(planes)}, got {name!r}")
    return only


def _listed(planes: Planes) -> str:
    return ", ".join(list(planes)[:20]) + (", ..." if len(planes) > 20 else "")


def _toward_viewer(normal: F32) -> F32:
    """Turn world-space normals to a view along their mean direction: G-buffers have screen-space normals."""
    mean = normal.reshape(-1, 3).mean(axis=0, dtype=np.float64)
    if not (size := float(np.linalg.norm(mean))):
        return normal
    z = mean / size
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    axes = np.stack([x, np.cross(z, x), z], axis=-1)
    turned: F32 = np.clip(normal @ axes, -1, 1).astype(np.float32)
    return turned


def openexr() -> Any:
    """Return the library OpenEXR; raise InputError if it is not installed."""
    try:
        import OpenEXR
    except ModuleNotFoundError as error:
        raise InputError(f"OpenEXR files need {error.name}: pip install 'bobrossnet[exr]'") from None
    return OpenEXR
