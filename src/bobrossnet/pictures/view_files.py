"""Views of the shape files of a folder, written as data sets: for nerfstudio, as EXR or npz files, or as WebDataset."""

from __future__ import annotations

import io
import json
import os
import tarfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bobrossnet.adapters.files import check_up, load, shape_files_into
from bobrossnet.picture.exr import openexr, write_exr
from bobrossnet.picture.files import png
from bobrossnet.picture.order import Size
from bobrossnet.picture.pose import Pose
from bobrossnet.pictures.background import Background
from bobrossnet.pictures.rendering import check_picture
from bobrossnet.pictures.views import CHANNELS, PosedView, around, views
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line
from bobrossnet.tracing.light import LightLike, check_light

FORMATS = ("npz", "exr", "webdataset")

TRANSFORMS = "transforms.json"


class ViewStyle(NamedTuple):
    """The options shared by all shapes."""

    cameras: int
    size: Size
    format: str
    samples: int = 4
    background: Background = None
    up: str = "z"
    light: LightLike = None
    ground: bool | None = None


class Written(NamedTuple):
    """The result for a file."""

    file: Path
    place: Path
    error: str | None
    is_new: bool = True


def dataset_of_views(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    style: ViewStyle,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Written]:
    """Write views of each shape file of a folder and its subfolders.

    A shape's folder is complete once its transforms.json exists; shards of a WebDataset are written whole. A second run
    renders only missing shapes, and writes the same bytes.

    Raises
    ------
    InputError
        If an option is out of range, the folder does not exist, or the scheduler can't be reached.
    """
    if style.format not in FORMATS:
        raise InputError(f"format: expected {', '.join(FORMATS)}, got {one_line(style.format)}")
    check_up(style.up)
    check_light(style.light)
    check_picture(style.samples, style.background, style.size)
    if style.format == "exr":
        openexr()  # its lack is said before the first view
    around(style.cameras)
    ending = ".tar" if style.format == "webdataset" else ""
    files, places = shape_files_into(source, out, ending)
    complete = [place if ending else place / TRANSFORMS for place in places]
    missing = [i for i, place in enumerate(complete) if not place.is_file()]
    written = {i: Written(files[i], places[i], None, is_new=False) for i in range(len(files)) if i not in set(missing)}
    tasks = [(str(files[i].absolute()), str(places[i].absolute())) for i in missing]
    for i, error in _done(tasks, style, scheduler):
        written[missing[i]] = Written(files[missing[i]], places[missing[i]], error)
        if progress is not None:
            progress(len(written) / len(files))
    return [written[i] for i in range(len(files))]


def _done(tasks: list[tuple[str, str]], style: ViewStyle, scheduler: str | None) -> Iterator[tuple[int, str | None]]:
    write = partial(_write, style=style)
    if scheduler is None:  # a view is traced by all threads
        yield from ((i, write(*task)) for i, task in enumerate(tasks))
        return
    from bobrossnet.support.cluster import as_done, connected

    with connected(scheduler) as client:
        for i, future in as_done(client, write, tasks):
            yield i, future.result()


def _write(file: str, place: str, style: ViewStyle) -> str | None:
    """Write the views of one file; return the error message, or None."""
    try:
        scene = load(file, up=style.up)
        made = views(
            scene,
            style.cameras,
            CHANNELS,
            size=style.size,
            samples=style.samples,
            background=style.background,
            light=style.light,
            ground=style.ground,
        )
        target = Path(place)
        target.parent.mkdir(parents=True, exist_ok=True)
        (_write_shard if style.format == "webdataset" else _write_folder)(made, target, style)
    except (InputError, MemoryError, OSError) as error:
        return one_line(error) or f"{Path(file).name}: not enough memory"
    return None


def _write_folder(made: Iterator[PosedView], folder: Path, style: ViewStyle) -> None:
    """Write pictures, one file of arrays for each view, and at last transforms.json, as nerfstudio reads it."""
    folder.mkdir(exist_ok=True)
    frames, intrinsics = [], np.eye(3)
    for number, view in enumerate(made):
        intrinsics = view.pose.intrinsics
        write_whole(folder / f"{number:05}.png", png(_color(view)))
        if style.format == "npz":
            write_whole(folder / f"{number:05}.npz", _npz(view))
        else:
            write_exr(folder / f"{number:05}.exr", _planes(view))
        frames.append({"file_path": f"{number:05}.png", **_described(view.pose)})
    height, width = style.size
    transforms = {
        "camera_model": "OPENCV",
        "w": width,
        "h": height,
        "fl_x": intrinsics[0, 0],
        "fl_y": intrinsics[1, 1],
        "cx": intrinsics[0, 2],
        "cy": intrinsics[1, 2],
        "frames": frames,
    }
    write_whole(folder / TRANSFORMS, f"{json.dumps(transforms, indent=1)}\n".encode())


def _write_shard(made: Iterator[PosedView], place: Path, style: ViewStyle) -> None:
    """Write a tar of one sample for each view: NUMBER.png, .npz and .json."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for number, view in enumerate(made):
            about = {"intrinsics": view.pose.intrinsics.tolist(), **_described(view.pose)}
            for ending, content in (
                ("png", png(_color(view))),
                ("npz", _npz(view)),
                ("json", json.dumps(about).encode()),
            ):
                info = tarfile.TarInfo(f"{number:05}.{ending}")
                info.size = len(content)
                tar.addfile(info, io.BytesIO(content))
    write_whole(place, buffer.getvalue())


def _described(pose: Pose) -> dict[str, Any]:
    """Return a pose for JSON: `transform_matrix` is camera to world in OpenGL's convention."""
    return {
        "transform_matrix": pose.camera_to_world.tolist(),
        "world_to_camera_opencv": pose.world_to_camera.tolist(),
    }


def _color(view: PosedView) -> Any:
    assert view.color is not None
    return view.color


def _npz(view: PosedView) -> bytes:
    assert view.depth is not None
    assert view.normal is not None
    assert view.instance is not None
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        depth=view.depth,
        normal=view.normal,
        instance=view.instance,
        mask=view.mask,
        intrinsics=view.pose.intrinsics,
        world_to_camera=view.pose.world_to_camera,
    )
    return buffer.getvalue()


def _planes(view: PosedView) -> dict[str, Any]:
    """Return channels of an EXR: Z, N.X, N.Y, N.Z in scene space, instance + 1 (0: background) and A, the mask."""
    assert view.depth is not None
    assert view.normal is not None
    assert view.instance is not None
    planes = {f"N.{axis}": view.normal[..., i] for i, axis in enumerate("XYZ")}
    planes |= {"Z": view.depth, "A": view.mask.astype(np.float32), "instance": (view.instance + 1).astype(np.uint32)}
    return {name: np.ascontiguousarray(values) for name, values in planes.items()}
