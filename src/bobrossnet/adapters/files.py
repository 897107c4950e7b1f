"""Reads files: returns a scene or a mesh, or raises an error of one line.

Meshes and 3MF are read in the core, as in the page.
"""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from bobrossnet.adapters.container import ENDING as SCENE_ENDING
from bobrossnet.adapters.container import read_scene
from bobrossnet.adapters.core_files import read_in_core
from bobrossnet.adapters.foreign import is_foreign, shapes_of
from bobrossnet.adapters.geomdl import read_geomdl
from bobrossnet.adapters.gismo import read_gismo
from bobrossnet.adapters.grids import read_bpt, read_cpt
from bobrossnet.adapters.joined import Joined, joined
from bobrossnet.adapters.opencascade import read_iges, read_step
from bobrossnet.adapters.part import Found
from bobrossnet.adapters.rhino import read_3dm
from bobrossnet.adapters.script import read_script
from bobrossnet.adapters.vm import read_vm
from bobrossnet.shapes.affine import TURNS
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.shapes.mesh import Mesh
from bobrossnet.shapes.shape import Shape
from bobrossnet.shapes.tree import happy_tree
from bobrossnet.support.atomic import check_folder
from bobrossnet.support.errors import InputError, InputWarning, check_choice, each_of
from bobrossnet.support.messages import counted, name_of, one_line, warn_of
from bobrossnet.support.paths import VIEWER, check_file, is_path, path_of
from bobrossnet.tracing.instance import Instance
from bobrossnet.tracing.scene import READERS, Scene, SceneLike, as_scene
from bobrossnet.tracing.upright import seems_to_lie

SAMPLE, HAPPY_TREE = "sample:", "happy_tree"
"""The start of the names of shapes that the package brings, and the name of its tree."""

MESH_ENDINGS = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".3mf")
GLTF = (".glb", ".gltf")
SCRIPT_READERS: dict[str, Callable[[Path], Implicit]] = {".sdf": read_script}
FORMULA_READERS: dict[str, Callable[[Path], Implicit]] = {".vm": read_vm}
SCENE_READERS: dict[str, Callable[[Path], SceneLike]] = {SCENE_ENDING: read_scene}
NURBS_READERS: dict[str, Callable[[Path], SceneLike]] = {
    ".json": read_geomdl,
    ".xml": read_gismo,
    ".bpt": read_bpt,
    ".cpt": read_cpt,
}
CAD_READERS: dict[str, Callable[[Path], SceneLike]] = {
    ".3dm": read_3dm,
    ".step": read_step,
    ".stp": read_step,
    ".iges": read_iges,
    ".igs": read_iges,
}

IMPLICIT_READERS = SCRIPT_READERS | FORMULA_READERS
INSTANCE_READERS = SCENE_READERS | NURBS_READERS | CAD_READERS
"""Readers of files whose shapes have their own names and materials, or are of several kinds."""

ALL_ENDINGS = (*MESH_ENDINGS, *IMPLICIT_READERS, *INSTANCE_READERS)

KINDS: dict[str, tuple[str, ...]] = {
    "meshes": MESH_ENDINGS,
    "CAD parts": tuple(CAD_READERS),
    "NURBS surfaces": tuple(NURBS_READERS),
    "shape scripts": tuple(SCRIPT_READERS),
    "formulas": tuple(FORMULA_READERS),
    "scenes": tuple(SCENE_READERS),
}
"""The endings of all files that are read, by what these hold."""

SILENT = (".ply", ".obj", ".stl", ".off")
"""Endings of meshes whose format does not say which axis is up."""

UPS = ("auto", *TURNS)

Source: TypeAlias = str | bytes | os.PathLike[Any] | Scene | Instance | Shape


def load(source: Source | Iterable[Source], *, up: str = "z") -> Scene:
    """Make a scene of a file, a shape, or several of either.

    Parameters
    ----------
    source : path, Shape, Instance, Scene or iterable of these
        Files are scenes, .bob, which `save_scene` writes; meshes, .ply, .obj, .stl, .off, .glb, .gltf or .3mf; NURBS
        surfaces, .3dm (Rhino's), .step, .stp, .iges, .igs, .json (geomdl's), .xml (G+Smo's), .bpt (Bezier patches) or
        .cpt (grids of control points); shape scripts, .sdf; or formulas, .vm. All are placed as their coordinates say;
        instances are named after their files where these have no names for them. "sample:gear" is a shape of the
        gallery. Meshes and scenes of trimesh are accepted, too.
    up : str
        The axis that points up in `source`, "z", "y", "x", "-z", "-y" or "-x"; it is turned to z, as by `Scene.turned`.
        "auto" is "z", except for .ply, .obj, .stl and .off, whose formats don't say: "y" where the shape otherwise
        seems to lie on its back, with a warning of one line.

    Returns
    -------
    Scene

    Raises
    ------
    InputError
        If a file can't be read or holds nothing to trace, in one line that starts with the file's name; or for `up`.

    Warns
    -----
    InputWarning
        If a part of a file was left out or is not shown as it is.
    """
    check_up(up)
    is_one = is_path(source) or isinstance(source, Shape | Instance | Scene) or is_foreign(source)
    each = [source] if is_one else list(each_of("source", source, "a path, a shape or several"))
    for path in filter(is_path, each):  # all are checked before the first is read
        _check_source(path)
    items = [_loaded(item) if is_path(item) else item for item in each]
    if len(items) > 1:
        _warn_of_several(each, items)
    only = items[0] if len(items) == 1 else None
    if up == "auto":
        items, up = _upright(each, items), "z"
        only = items[0] if len(items) == 1 else None
    scene = only if isinstance(only, Scene) else Scene(items)  # which is measured already
    return scene.turned(up)


def _upright(sources: list[Any], items: list[SceneLike]) -> list[SceneLike]:
    """Turn all meshes of files that don't say which axis is up, if together they seem to lie."""
    silent = [is_path(source) and Path(os.fsdecode(source)).suffix.lower() in SILENT for source in sources]
    scenes = [as_scene(item) for item, is_silent in zip(items, silent, strict=True) if is_silent]
    if not scenes or not seems_to_lie(scenes[0] if len(scenes) == 1 else Scene(scenes)):
        return items
    name = name_of(path_of(sources[silent.index(True)])) + (" and others" if len(scenes) > 1 else "")
    text = f"{name}: seems to lie on its back, so its y is taken as up; set up to z to keep it as stored"
    warnings.warn(text, InputWarning, stacklevel=3)
    return [as_scene(item).turned("y") if own else item for item, own in zip(items, silent, strict=True)]


def _warn_of_several(sources: list[Any], items: list[SceneLike]) -> None:
    """Warn about the lights of files that are opened with others, and the unit assumed for files without one."""
    unit = next((item.unit for item in items if isinstance(item, Scene) and item.unit), None)
    for source, item in zip(sources, items, strict=True):
        if not is_path(source) or not isinstance(item, Scene):
            continue
        told = []
        if item.light is not None:
            told.append("its lights are not shown, because other shapes are opened with it")
        if unit is not None and item.unit is None:
            told.append(f"its lengths are taken as {unit}, the unit of the other files; it does not say its own")
        for text in told:
            warnings.warn(f"{name_of(path_of(source))}: {text}", InputWarning, stacklevel=3)


def _check_source(path: str | bytes | os.PathLike[str]) -> None:
    """Raise InputError unless a path is the name of a sample, or a file with a known ending."""
    if isinstance(path, str) and path.startswith(SAMPLE):
        check_choice(SAMPLE.rstrip(":"), path.removeprefix(SAMPLE), (HAPPY_TREE, *sorted(_samples())))
        return
    file = path_of(path)
    with _errors_of_one_line(file, "scene"):
        check_file(file)
        if (ending := file.suffix.lower()) not in ALL_ENDINGS:
            raise InputError(f"expected one of {' '.join(ALL_ENDINGS)}, got {one_line(ending) or 'no ending'}")


def _samples() -> dict[str, Path]:
    return {file.stem: file for file in (VIEWER / "gallery").glob("*") if file.suffix in (".bob", ".sdf")}


def check_up(up: str) -> None:
    """Raise InputError unless it is an axis that points up in files."""
    check_choice("up", up, UPS)


def _shapes_of(value: Any) -> SceneLike | None:
    """Lets scenes be made of paths and of other libraries' meshes."""
    if is_path(value):
        return load(value)
    return shapes_of(value) if is_foreign(value) else None


READERS.append(_shapes_of)


def _loaded(path: str | bytes | os.PathLike[Any]) -> SceneLike:
    if isinstance(path, str) and path.startswith(SAMPLE):
        return sample(path)
    file = path_of(path)
    ending = file.suffix.lower()
    if ending in MESH_ENDINGS:
        read, shapes = _read_mesh(path)
        with _errors_of_one_line(file, "mesh"):
            instances = [*(read.instances(file.name) if len(read.part.triangles) else ()), *shapes]
            scene = Scene(instances, unit=read.unit)
            scene.has_front = ending in GLTF  # it says that +z is its front, which is -y once it stands
            return scene
    with _errors_of_one_line(file, "shape" if ending in IMPLICIT_READERS else "scene"):
        if ending in IMPLICIT_READERS:
            # Scenes are made here, so that their errors name the file.
            return Scene(Instance(IMPLICIT_READERS[ending](file), name=file.name))
        if file.stat().st_size == 0:
            raise InputError("expected a scene, got an empty file")
        found = INSTANCE_READERS[ending](file)
        return Scene(found, unit=found.unit) if isinstance(found, Found) else as_scene(found)


def sample(name: str) -> SceneLike:
    """A shape of the gallery, `sample:gear`, or the built-in tree, `sample:happy_tree`."""
    chosen = name.removeprefix(SAMPLE)
    return Instance(happy_tree(), name="happy tree") if chosen == HAPPY_TREE else _loaded(_samples()[chosen])


def shape_files(place: str | os.PathLike[str]) -> list[Path]:
    """The files of a folder, and below it, whose endings `load` knows, sorted; of a file, itself.

    Raises
    ------
    InputError
        If there is no such place.
    """
    place = path_of(place, "source")
    if place.is_file():
        return [place]
    if not place.is_dir():
        raise InputError(f"{place}: expected a shape file or a folder of them, got no such file")
    return sorted(path for path in place.rglob("*") if path.suffix.lower() in ALL_ENDINGS and path.is_file())


def shape_files_into(
    source: str | os.PathLike[str], out: str | os.PathLike[str], ending: str
) -> tuple[list[Path], list[Path]]:
    """Return `shape_files`, and a path for each in the folder `out`: in the same subfolder, with an ending appended.

    Raises
    ------
    InputError
        If there is no such source, or if a file is in place of the folder.
    """
    files, place, folder = shape_files(source), path_of(source, "source"), check_folder(out, "out")
    base = place if place.is_dir() else place.parent
    return files, [folder / f"{file.relative_to(base)}{ending}" for file in files]


def load_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read a triangle mesh from a file.

    All parts of a file become one mesh, placed as the file places them. glTF is y-up by its specification
    and is turned to z-up; the other formats are taken as stored. Polygons become triangles, concave ones by
    ear clipping.

    Vertices that no triangle uses are left out. Each triangle takes its material's colour. A texture is kept only
    if the whole file has the same one. `load` makes an instance for each material instead.

    Parameters
    ----------
    path : str or path
        A file whose name ends in one of `MESH_ENDINGS`, in any case.

    Returns
    -------
    Mesh, with normals only where the file stores normals.

    Raises
    ------
    InputError
        If there is no such file, or nothing in it can be drawn; one line that starts with the file's name.

    Warns
    -----
    InputWarning
        If triangles were left out because they touch a vertex that is missing or not finite, or a material or a
        texture because it can't be read.
    """
    return _read_mesh(path, takes_shapes=False)[0].mesh()


def _read_mesh(path: str | bytes | os.PathLike[Any], *, takes_shapes: bool = True) -> tuple[Joined, Sequence[Instance]]:
    """Return the drawable triangles of a mesh file, and its other shapes.

    There may be no triangles next to other shapes, unless a caller takes none of these.
    """
    file = path_of(path)
    ending = one_line(file.suffix.lower())
    with _quiet(), _errors_of_one_line(file, "mesh"):
        check_file(file)
        if ending not in MESH_ENDINGS:
            hint = "; bobrossnet.load reads it" if ending in ALL_ENDINGS else ""
            raise InputError(f"expected one of {' '.join(MESH_ENDINGS)}, got {ending or 'no ending'}{hint}")
        if file.stat().st_size == 0:
            raise InputError("expected a mesh, got an empty file")
        found = read_in_core(file)
        read = joined(found)
        total = len(read.part.triangles)
        if found.shapes and not takes_shapes:
            left = f"left out beam lattices and formulas, which bobrossnet.load shows ({len(found.shapes):,})"
            if not total:
                raise InputError(f"expected triangles, got none; {left}")
            warn_of(file, left)
        drawn = read.drawn() if total or not found.shapes else read
    if dropped := total - len(drawn.part.triangles):
        warnings.warn(
            f"{name_of(file)}: left out {dropped:,} of {counted(total, 'triangle')} that touch a missing or non-finite "
            "vertex",
            InputWarning,
            stacklevel=3,
        )
    return drawn, found.shapes


# ---- Errors of one line ----------------------------------------------------------------------------------


@contextmanager
def _errors_of_one_line(file: Path, kind: str) -> Iterator[None]:
    """Whatever is raised becomes an InputError of one line that starts with the file's name."""
    name = name_of(file)
    try:
        yield
    except InputError as error:
        raise InputError(f"{name}: {one_line(error)}") from error
    except MemoryError as error:
        raise InputError(f"{name}: expected a {kind} that fits into memory, got a larger one") from error
    except RecursionError as error:
        raise InputError(f"{name}: expected a {kind}, got data nested too deeply") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: expected text; byte {error.start:,} is not valid UTF-8") from error
    except Exception as error:  # readers raise all kinds of errors on foreign bytes
        reason = one_line(f"{type(error).__name__}: {error}")
        ending = one_line(file.suffix.lower())
        raise InputError(f"{name}: expected a {ending} {kind}, could not read it ({reason})") from error


_ONE_AT_A_TIME = threading.RLock()
"""Filters of warnings belong to the process: of two threads, each would undo the other's."""

if hasattr(os, "register_at_fork"):  # the threads that may hold it do not exist in a forked process
    os.register_at_fork(after_in_child=_ONE_AT_A_TIME._at_fork_reinit)  # type: ignore[attr-defined]


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress numpy's warnings about odd numbers, and repeat the readers' own afterwards."""
    with _ONE_AT_A_TIME, warnings.catch_warnings(record=True) as told, np.errstate(all="ignore"):
        warnings.simplefilter("always")
        yield
    for warning in told:
        if isinstance(warning.message, InputWarning):
            warnings.warn(warning.message, stacklevel=6)
