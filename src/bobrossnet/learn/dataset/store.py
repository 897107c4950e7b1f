"""A data set on disk: a Zarr 3 group with an array for each view size. Each view is one file, written at once.

    DIR/zarr.json                     attributes: format, seed, test_shapes, sources, channels, stages, colored
    DIR/views_128 | 256 | 512         (shapes, 4, size, size) float16: gray, depth, normal x, normal y
        chunks (1, 4, 128, 128)       a patch; zstd over shuffled bytes, and their CRC-32C
        shards (1, 4, size, size)     a view

All 0 off the surface. float16 keeps gray to 0.00025, a sixteenth of an 8-bit step. A view without a file is not
rendered yet. Files are synced before they are renamed into place, so that existing files are complete even after a
power cut.
"""

from __future__ import annotations

import asyncio
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.codecs import BloscCodec, Crc32cCodec
from zarr.core.buffer import Buffer
from zarr.storage import LocalStore

from bobrossnet.learn.checks import BUILD, INDEX, check_dataset
from bobrossnet.learn.dataset.plan import PATCH, SIZES, STAGES, Plan
from bobrossnet.picture.channels import GIVEN
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.atomic import replace
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line
from bobrossnet.support.paths import path_of
from bobrossnet.support.threads import lazy

FORMAT = "bobrossnet-dataset-1"
CHANNELS = ("gray", "depth", "normal x", "normal y")
"""Planes of the format, (4, H, W) for views and patches, a subset of a G-buffer's."""

PARTIAL = ".partial"
"""Ending of an unfinished file."""

PLANES = np.r_[GIVEN.places["gray"], GIVEN.places["depth"], GIVEN.places["normal"]]
"""Their positions in `GBuffer.stack`."""


class Dataset:
    """The views of a data set.

    Attributes
    ----------
    path : folder
    plan : Plan of the samples
    sources : of each shape, "made NUMBER" for `procedural_scene(NUMBER)`, "colored NUMBER" for `colored_scene(NUMBER)`,
        or the path of its file
    """

    def __init__(self, path: Path, plan: Plan, sources: Sequence[str], arrays: dict[int, Any]) -> None:
        self.path = path
        self.plan = plan
        self.sources = tuple(sources)
        self._arrays = arrays

    @classmethod
    def create(cls, path: str | os.PathLike[str], plan: Plan, sources: Sequence[str]) -> Dataset:
        """Create a data set's folder without views, or continue one with the same plan and sources.

        Raises
        ------
        InputError
            If the folder has other contents, or can't be written.
        """
        path = path_of(path)
        attributes = {
            "format": FORMAT,
            "seed": plan.seed,
            "test_shapes": plan.test_shapes,
            "channels": list(CHANNELS),
            "stages": list(STAGES),
            "sources": list(sources),
            **({"colored": True} if plan.colored else {}),
        }
        if (path / INDEX).exists():
            found = dict(_open_group(path).attrs)
            if found != attributes:
                different = ", ".join(
                    sorted(name for name in {**found, **attributes} if found.get(name) != attributes.get(name))
                )
                raise InputError(f"{path}: expected the data set begun there, got another {different}")
        elif path.exists() and not (
            path.is_dir() and all(p.name.startswith("views_") or p.suffix == PARTIAL for p in path.iterdir())
        ):
            raise InputError(f"{path}: expected an empty folder or a data set, got other files")
        try:
            for leftover in path.glob(f"**/*{PARTIAL}"):  # of a killed build
                leftover.unlink()
            for size in SIZES:
                if not (path / f"views_{size}" / INDEX).exists():
                    zarr.create_array(
                        _SyncedStore(path / f"views_{size}"),
                        shape=(plan.shapes, len(CHANNELS), size, size),
                        dtype=np.float16,
                        chunks=(1, len(CHANNELS), PATCH, PATCH),
                        shards=(1, len(CHANNELS), size, size),
                        compressors=[
                            BloscCodec(typesize=2, cname="zstd", clevel=5, shuffle="shuffle"),
                            Crc32cCodec(),
                        ],
                        dimension_names=("shape", "channel", "row", "column"),
                        config={"write_empty_chunks": True},  # a file marks its view as done
                    )
            # The group last: it makes the folder a data set.
            if not (path / INDEX).exists():
                zarr.create_group(_SyncedStore(path), attributes=attributes)
        except OSError as error:
            raise InputError(f"{path}: can't write there: {error.strerror}") from error
        return cls._of(path)

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Dataset:
        """Open a data set to read from it.

        Raises
        ------
        InputError
            If the folder has no data set, its index is damaged, or views are missing or empty.
        """
        dataset = cls._of(Path(path))
        missing = sum(not dataset.has(shape, size) for shape in range(dataset.plan.shapes) for size in SIZES)
        if missing:
            raise InputError(
                f"{path}: expected all {dataset.plan.shapes * len(SIZES)} views, got {missing} fewer; "
                f"{BUILD} completes it"
            )
        for size in SIZES:
            for shape in range(dataset.plan.shapes):
                if dataset._file(shape, size).stat().st_size == 0:
                    raise dataset._damaged(shape, size)
        return dataset

    @classmethod
    def _of(cls, path: Path) -> Dataset:
        attributes = _open_group(path).attrs
        if attributes.get("format") != FORMAT:
            raise InputError(f"{path}: expected a data set of format {FORMAT!r}, got {attributes.get('format')!r}")
        sources: Any = attributes.get("sources")
        if not (isinstance(sources, list) and all(isinstance(source, str) for source in sources)):
            raise _damaged_index(path / INDEX, "it has no list of sources")
        numbers: list[Any] = [attributes.get(name) for name in ("seed", "test_shapes")]
        plan = Plan(numbers[0], len(sources), numbers[1], bool(attributes.get("colored", False)))
        arrays = {}
        for size in SIZES:
            place = path / f"views_{size}"
            arrays[size] = _opened(place, zarr.open_array)
            shape = plan.shapes, len(CHANNELS), size, size
            if arrays[size].shape != shape or arrays[size].dtype != np.float16:
                raise _damaged_index(place / INDEX, f"its array is {arrays[size].dtype} {arrays[size].shape}")
        return cls(path, plan, sources, arrays)

    def has(self, shape: int, size: int) -> bool:
        """Return whether a view exists."""
        return self._file(shape, size).exists()

    def write(self, shape: int, size: int, view: NDArray[np.float16]) -> None:
        """Store a view, (4, size, size); a failed write leaves no file."""
        self._file(shape, size).unlink(missing_ok=True)  # zarr would first read a damaged one
        zarr.open_array(_SyncedStore(self.path / f"views_{size}"), mode="r+")[shape] = view

    def read(self, shape: int, size: int) -> NDArray[np.float16]:
        """Return a view, (4, size, size) float16.

        Raises
        ------
        InputError
            If its file is damaged.
        """
        try:
            if self._file(shape, size).stat().st_size == 0:  # zarr would take it for a view of zeros
                raise self._damaged(shape, size)
            return np.asarray(self._arrays[size][shape])
        except InputError:
            raise
        except (OSError, ValueError, RuntimeError) as error:  # from zarr and its codecs
            raise self._damaged(shape, size) from error

    def patches(self, shape: int) -> NDArray[np.float16]:
        """Return all patches of a shape, (21, 4, 128, 128) float16, in the order of `Plan.sample`."""
        return np.concatenate([_cut(self.read(shape, size)) for size in SIZES])

    @lazy
    def detail(self) -> NDArray[np.float64]:
        """Return the detail of each patch, (shapes, 21): the mean difference of gray between neighbours.

        In a coloured data set it is the square root of this mean: differences grow with a shape's brightness and its
        texture's frequency. Without the root, 36 % of the draws would show the white fifth of the shapes, and 7 % the
        eighth with a single material; with it these are 29 and 9 %, and 35 % show the textured third.
        """
        differences = np.array(
            [[_detail(patch[0].astype(float)) for patch in self.patches(shape)] for shape in range(self.plan.shapes)]
        )
        return np.sqrt(differences) if self.plan.colored else differences

    def _damaged(self, shape: int, size: int) -> InputError:
        file = self._file(shape, size)
        return InputError(f"{file}: expected a view as it was written, got a damaged one; {BUILD} renders it again")

    def _file(self, shape: int, size: int) -> Path:
        return self.path / f"views_{size}" / "c" / str(shape) / "0" / "0" / "0"


def part_of(view: NDArray[np.float32], mask: NDArray[Any]) -> GBuffer:
    """Return a view or patch, (4, H, W), as a G-buffer. The pixels of `mask`, (H, W) of 0 and 1, are traced."""
    planes = np.empty((1 + len(CHANNELS), *mask.shape), np.float32)
    planes[0] = mask
    np.multiply(view, mask, out=planes[1:])
    return GBuffer.from_stack(planes)


def _cut(view: NDArray[np.float16]) -> NDArray[np.float16]:
    """Cut a view into patches, row by row: (4, size, size) → (n, 4, 128, 128)."""
    channels, size, _ = view.shape
    n = size // PATCH
    return view.reshape(channels, n, PATCH, n, PATCH).transpose(1, 3, 0, 2, 4).reshape(-1, channels, PATCH, PATCH)


def joined(patches: NDArray[np.float16]) -> NDArray[np.float16]:
    """Join a view's patches, (n², 4, 128, 128) → (4, size, size)."""
    count, channels, _, _ = patches.shape
    n = math.isqrt(count)
    rows = patches.reshape(n, n, channels, PATCH, PATCH).transpose(2, 0, 3, 1, 4)
    return rows.reshape(channels, n * PATCH, n * PATCH)


def _detail(gray: NDArray[np.float64]) -> float:
    """Return the mean absolute difference between neighbours, (H, W)."""
    return sum(float(np.abs(np.diff(gray, axis=axis)).mean()) for axis in (0, 1))


class _SyncedStore(LocalStore):
    """A store that renames files into place only when their content is on the disk."""

    async def set(self, key: str, value: Buffer) -> None:
        await asyncio.to_thread(self.set_sync, key, value)

    async def set_if_not_exists(self, key: str, value: Buffer) -> None:
        if not (self.root / key).exists():
            await self.set(key, value)

    def set_sync(self, key: str, value: Buffer) -> None:
        file = self.root / key
        file.parent.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(PARTIAL)
        with partial.open("wb") as written:
            written.write(value.to_bytes())
            written.flush()
            os.fsync(written.fileno())
        replace(partial, file)
        if sys.platform != "win32":  # folders can't be opened there
            inside = file.relative_to(self.root).parents
            for folder in [*(self.root / some for some in inside), self.root.parent]:  # new folders are synced too
                _sync_folder(folder)


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _opened(path: Path, of: Callable[..., Any]) -> Any:
    index = path / INDEX
    try:
        return of(path, mode="r")
    except Exception as error:  # zarr raises any type
        raise _damaged_index(index, one_line(error) if index.exists() else "it is not there") from error


def _damaged_index(file: Path, why: str) -> InputError:
    return InputError(f"{file}: expected the index of a data set, got a damaged one ({why}); remove it and run {BUILD}")


def _open_group(path: Path) -> zarr.Group:
    check_dataset(path)
    group: zarr.Group = _opened(path, zarr.open_group)
    return group
