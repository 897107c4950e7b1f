"""Reads 3MF, a package of XML: objects and their placements, colours of triangles, textures and beams.

trimesh 5.2 needs lxml and networkx for it, and walks every path through the components, so a few lines of a file
can make 2ⁿ paths.
"""

from __future__ import annotations

import zlib
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import IO, NamedTuple, TypeAlias
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from bobrossnet._core import ColorFormula
from bobrossnet.adapters.opc import Package
from bobrossnet.adapters.part import Found, Names, Part, counted, placed
from bobrossnet.adapters.threemf_beams import Lattice
from bobrossnet.adapters.threemf_colors import Palette, Swatch, Textures, numbers
from bobrossnet.adapters.threemf_functions import Domain, Functions, Mesh
from bobrossnet.adapters.xml import read_xml
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import errors_at, one_line, warn_of
from bobrossnet.support.units import unit_of_word
from bobrossnet.tracing.instance import Instance, Piece
from bobrossnet.tracing.material import Material
from bobrossnet.tracing.scene import MAX_INSTANCES

MICROSOFT = "http://schemas.microsoft.com/3dmanufacturing/"
CONSORTIUM = "http://schemas.3mf.io/"

EXTENSIONS = {
    MICROSOFT + "material/2015/02": "m",
    MICROSOFT + "production/2015/06": "p",
    MICROSOFT + "slice/2015/07": "s",
    MICROSOFT + "beamlattice/2017/02": "b",
    MICROSOFT + "beamlattice/balls/2020/07": "b2",
    MICROSOFT + "trianglesets/2021/07": "t",
    MICROSOFT + "displacement/2022/07": "d",
    CONSORTIUM + "3dmanufacturing/displacement/2023/10": "d",
    CONSORTIUM + "3dmanufacturing/booleanoperations/2023/07": "bo",
    CONSORTIUM + "3dmanufacturing/volumetric/2022/01": "v",
    CONSORTIUM + "3dmanufacturing/implicit/2023/12": "i",
}
"""Usual prefixes of the known extensions, by namespace. Meshes are right without the unread ones."""

NOT_SHOWN = {
    "m:multiproperties": "multiproperties",
    "m:pbspeculardisplayproperties": "display properties",
    "m:pbmetallicdisplayproperties": "display properties",
    "m:pbspeculartexturedisplayproperties": "display properties",
    "m:pbmetallictexturedisplayproperties": "display properties",
    "m:translucentdisplayproperties": "display properties",
    "d:displacementmesh": "displacements",
    "bo:booleanshape": "Boolean operations",
    "v:composite": "mixtures of materials",
    "v:property": "properties in space",
}
"""Names of unread elements in the warning."""

MESH_OF_DISPLACEMENT = {f"d:{name}": name for name in ("vertex", "triangle")}

Key: TypeAlias = tuple[str, str]
"""Name of an object's part in the package, and its id there."""


class Reference(NamedTuple):
    key: Key
    matrix: NDArray[np.float64]  # (4, 4), multiplied from the left
    path: tuple[str, ...] = ()  # of the object that refers


class Object(NamedTuple):
    name: str
    parts: list[Part]
    instances: list[Instance]
    """Shapes other than meshes."""
    components: list[Reference]


def read_3mf(file: Path, instances: list[Instance] | None = None) -> Found[Part]:
    """Read the meshes of the build of a 3MF, each in its place.

    `instances` receives the other shapes. If omitted, one warning names them, together with everything else that is
    not shown. An unreadable texture is left out with a separate warning.

    Raises
    ------
    InputError
        If the file has no model, unpacks to too many bytes, requires an unknown extension, or names a missing object;
        or if it has too many objects.
    """
    left: Counter[str] = Counter()
    try:
        with ZipFile(file) as archive:
            objects, built, unit = _read_models(Package(file, archive), left)
            parts, shapes = _built(objects, built)
    except (BadZipFile, zlib.error, OSError, EOFError, NotImplementedError) as error:
        raise InputError(f"expected a zip file that can be unpacked, got another ({error})") from error
    if instances is None:
        left["beam lattices and formulas, which bobrossnet.load shows"] += len(shapes)
    else:
        instances += shapes
    names = ", ".join(f"{name} ({count:,})" for name, count in left.items() if count)
    if names and not (parts or instances):
        raise InputError(f"expected triangles, got none; left out {names}")
    if names:
        warn_of(file, f"left out {names}")
    return Found(parts, unit)


def _read_models(package: Package, left: Counter[str]) -> tuple[dict[Key, Object], list[Reference], str]:
    """Read the objects of the root model and of the models it names; return them, and the root's build and unit."""
    found = package.target("/3dmodel") or package.part("3D/3dmodel.model")
    root = found or next(iter(package.ending_in(".model")), None)
    if root is None:
        raise InputError("expected a 3MF with a 3D/3dmodel.model in it, got none")
    objects: dict[Key, Object] = {}
    textures = Textures(package)
    models, done = [root], {root.filename}
    built: list[Reference] | None = None
    unit = ""
    while models:
        info = models.pop()
        package.count("a 3MF model", info)
        with package.archive.open(info) as stream:
            model = _Model(package, info.filename, textures, left)
            model.read(stream)
        objects |= model.objects
        built = model.built if built is None else built  # other models' are for them alone
        unit = unit or model.unit
        for name in model.named:
            other = package.part(name)
            if other is not None and other.filename not in done:
                done.add(other.filename)
                models.append(other)
    return objects, built or [], unit


def _built(objects: dict[Key, Object], built: list[Reference]) -> tuple[list[Part], list[Instance]]:
    """Place the build: components are placed relative to their object."""
    parts: list[Part] = []
    shapes: list[Instance] = []
    visited = total = 0
    names = Names()
    references = built[::-1]
    while references:
        key, matrix, parent = references.pop()
        found = objects.get(key)
        if found is None:
            raise InputError(f"expected an object with id {key[1]}, found none")
        visited += 1
        if visited > MAX_INSTANCES:
            raise InputError("expected finitely many components, got too many; does one hold itself?")
        path = names.path(parent, found.name)
        for part in found.parts:
            total = counted(total, len(part.triangles) + len(part.vertices))
            if len(part.vertices):
                runs = (Piece(path, len(part.triangles)),) if len(part.triangles) else ()
                parts.append(placed(part._replace(runs=runs), matrix))
        shapes += [replace(instance, pieces=(Piece(path),)).transformed(matrix) for instance in found.instances]
        if len(shapes) > MAX_INSTANCES:
            raise InputError(f"expected at most {MAX_INSTANCES:,} beam lattices and formulas, got more")
        references += [Reference(child, matrix @ place, path) for child, place, _ in reversed(found.components)]
    return parts, shapes


class _Model:
    """The objects and the build of one model file."""

    def __init__(self, package: Package, name: str, textures: Textures, left: Counter[str]) -> None:
        self.package, self.name, self.left = package, name, left
        self.palette = Palette(textures)
        self.objects: dict[Key, Object] = {}
        self.built: list[Reference] = []
        self.unit = "mm"
        self.named: list[str] = []
        """Other models in the package."""
        self.kinds: dict[str, str] = {}
        """Prefixes of the kinds of elements, by namespace."""
        self.prefixes: dict[str, str] = {}
        self.functions = Functions()
        self.meshes: dict[str, Mesh] = {}
        """Meshes of objects, by id: functions may use them."""
        self.level_sets: list[tuple[str, dict[str, str], Material | None, str]] = []
        """Ids of their objects, attributes, materials and names."""
        self.volume = ""
        self.color_of: dict[str, dict[str, str]] = {}
        """Attributes of colour functions, by the ids of their volumes."""
        self._start_object({})

    def read(self, stream: IO[bytes]) -> None:
        read_xml(stream, self._start, self._end, prefix=self.prefixes.__setitem__)
        if not self.kinds:
            raise InputError("expected a 3MF model, got XML without elements")
        for number, get, material, label in self.level_sets:
            if shape := self._level_set(get):
                instance = Instance(shape, material=material, name=label)
                self.objects[self.name, number] = Object(one_line(label), [], [instance], [])

    def _start_object(self, get: dict[str, str]) -> None:
        self.get = get
        self.points: list[list[str]] = []
        self.corners: list[list[str]] = []
        self.chosen: list[tuple[Swatch, ...]] = []  # of each triangle's corners
        self.components: list[Reference] = []
        self.lattice: Lattice | None = None
        self.of_object: tuple[Swatch, ...] = ((get["pid"], get.get("pindex", "")),) if "pid" in get else ()

    def _start_model(self, name: str, get: dict[str, str]) -> None:
        core, _, local = name.rpartition("}")
        if local != "model":
            raise InputError(f"expected a 3MF model, got the element {one_line(local)}")
        self.kinds = {core: ""} | {namespace: prefix + ":" for namespace, prefix in EXTENSIONS.items()}
        self.unit = unit_of_word(get.get("unit", "")) or self.unit
        for prefix in get.get("requiredextensions", "").split():
            namespace = self.prefixes.get(prefix)
            if namespace not in self.kinds:
                raise InputError(
                    f"requiredextensions: expected supported extensions, got {one_line(namespace or prefix)}"
                )

    def _start(self, name: str, get: dict[str, str]) -> None:
        if not self.kinds:
            self._start_model(name, get)
        namespace, _, local = name.rpartition("}")
        if namespace not in self.kinds:
            return
        kind = self.kinds[namespace] + local
        if kind.startswith("i:"):
            self.functions.start(local, get)
            return
        kind = MESH_OF_DISPLACEMENT.get(kind, kind)
        palette = self.palette
        if kind == "vertex":
            self.points.append(_values(kind, get, "x", "y", "z"))
        elif kind == "triangle":
            self.corners.append(_values(kind, get, "v1", "v2", "v3"))
            first = get.get("p1")
            if first is None:
                self.chosen.append(self.of_object)
            else:
                group = get.get("pid", self.get.get("pid", ""))
                self.chosen.append(((group, first), (group, get.get("p2", first)), (group, get.get("p3", first))))
        elif kind in ("component", "item"):
            (self.components if kind == "component" else self.built).append(self._reference(kind, get))
        elif kind == "object":
            self._start_object({"id": _values(kind, get, "id")[0]} | get)
            if self._attribute(get, "s:meshresolution") == "lowres":
                self.left["slices of coarse meshes"] += 1
        elif kind in ("basematerials", "m:colorgroup"):
            palette.start(get.get("id", ""), flat=kind == "basematerials")
        elif kind in ("base", "m:color"):
            palette.add(get.get("displaycolor" if kind == "base" else "color", ""))
        elif kind == "m:compositematerials":
            palette.start_mixtures(get.get("id", ""), get.get("matid", ""), get.get("matindices", ""))
        elif kind == "m:composite":
            palette.add_mixture(get.get("values", ""))
        elif kind == "m:texture2d":
            palette.pictures[get.get("id", "")] = get.get("path", ""), _wrap(get, "u"), _wrap(get, "v")
        elif kind == "m:texture2dgroup":
            palette.start(get.get("id", ""), get.get("texid", ""))
        elif kind == "m:tex2coord":
            palette.add_place(_values(kind, get, "u", "v"))
        elif kind == "b:beamlattice":
            self.lattice = Lattice(get, self.get)
        elif kind == "b:beam" and self.lattice:
            self.lattice.add_beam(get, *_values(kind, get, "v1", "v2"))
        elif kind == "b2:ball" and self.lattice:
            self.lattice.add_ball(get, *_values(kind, get, "vindex"))
        elif kind == "v:functionfromimage3d":
            self.functions[get.get("id", "")] = None
        elif kind == "v:volumedata":
            self.volume = get.get("id", "")
        elif kind == "v:color":
            self.color_of[self.volume] = get
        elif kind == "v:levelset":
            label = self.get.get("name") or self.get.get("partnumber") or self.package.file.name
            material = Material(color=self.palette.of(self.of_object)[0]) if self.of_object else None
            self.level_sets.append((self.get.get("id", ""), get, material, label))
        elif kind in NOT_SHOWN:
            self.left[NOT_SHOWN[kind]] += 1

    def _end(self, name: str) -> None:
        namespace, _, local = name.rpartition("}")
        if self.kinds.get(namespace) == "i:":
            self.functions.end(local)
        if local != "object" or self.kinds.get(namespace) != "":
            return
        vertices = numbers(self.points).reshape(-1, 3)
        triangles = numbers(self.corners).astype(np.int64).reshape(-1, 3)
        self.meshes[self.get.get("id", "")] = vertices, triangles
        instances = []
        if self.lattice:
            tubes = self.lattice.tubes(vertices, self.palette, self.left)
            label = self.get.get("name") or self.package.file.name
            instances = [Instance(tube, material=Material(color=color), name=label) for tube, color in tubes]
        parts = self.palette.parts(vertices, triangles, self.chosen) if len(triangles) or not instances else []
        number = self.get.get("id", "")
        name = one_line(self.get.get("name") or self.get.get("partnumber") or "") or f"object {one_line(number)}"
        self.objects[self.name, number] = Object(name, parts, instances, self.components)
        self._start_object({})

    def _level_set(self, get: dict[str, str]) -> Implicit | None:
        """Return the surface of a function within a mesh or its box; None for a function of an image."""
        function, channel, domain = _values("levelset", get, "functionid", "channel", "meshid")
        if domain not in self.meshes or not len(self.meshes[domain][0]):
            raise InputError(f"levelset: expected a mesh with id {one_line(domain)} around it, got none")
        if function in self.functions and self.functions[function] is None:
            self.left["level sets of images"] += 1
            return None
        within = Domain(domain, get.get("meshbboxonly") in ("true", "1"))
        matrix, color = _matrix(get.get("transform")), self._color(get.get("volumeid", ""))
        with errors_at("levelset"):
            return self.functions.level_set(function, channel, matrix, self.meshes, within, color)

    def _color(self, volume: str) -> ColorFormula | None:
        get = self.color_of.get(volume)
        if get is None:
            return None
        function, channel = _values("color", get, "functionid", "channel")
        if function in self.functions and self.functions[function] is None:
            self.left["colours of images in space"] += 1
            return None
        with errors_at("color"):
            return self.functions.color(function, channel, _matrix(get.get("transform")), self.meshes)

    def _attribute(self, get: dict[str, str], kind: str) -> str | None:
        """An attribute of an extension, by its usual prefix."""
        for name, value in get.items():
            namespace, _, local = name.rpartition("}")
            if namespace and self.kinds.get(namespace, "") + local == kind:
                return value
        return None

    def _reference(self, kind: str, get: dict[str, str]) -> Reference:
        (number,) = _values(kind, get, "objectid")
        path = self._attribute(get, "p:path")
        if path is None:
            return Reference((self.name, number), _matrix(get.get("transform")))
        self.named.append(path)
        found = self.package.part(path)
        return Reference((found.filename if found else path, number), _matrix(get.get("transform")))


def _wrap(texture: dict[str, str], axis: str) -> str:
    """Return the wrap mode of a texture along an axis; `none` counts as clamp."""
    style = texture.get(f"tilestyle{axis}", "wrap")
    return {"mirror": "mirror", "clamp": "clamp", "none": "clamp"}.get(style, "repeat")


def _values(element: str, attributes: dict[str, str], *names: str) -> list[str]:
    try:
        return [attributes[name] for name in names]
    except KeyError as error:
        raise InputError(f"{element}: expected the attribute {error.args[0]}, got none") from error


def _matrix(text: str | None) -> NDArray[np.float64]:
    """Read the 12 numbers of a transform, which 3MF multiplies from the right."""
    matrix = np.eye(4)
    if text:
        values = numbers(text.split())
        if len(values) != 12:
            raise InputError(f"transform: expected 12 numbers, got {len(values)}")
        matrix[:3] = values.reshape(4, 3).T
    return matrix
