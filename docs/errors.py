"""Where the error of completed pictures is, and the limits of better placement and better completion: docs/errors.md.

python docs/errors.py [--limit N]

With BOBROSSNET_MODELS, half of the shapes are files below that folder; all others are made by the package.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_opening, maximum_filter
from work import MODELS

import bobrossnet as bob
from bobrossnet.completion.filling import delaunay_linear
from bobrossnet.learn.evaluation.scenes import Scenes, each_scene, own_scenes, scenes_of_folder
from bobrossnet.picture.files import side_by_side, to_8_bit, write_picture
from bobrossnet.picture.order import pixel_count
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.tables import cell, table
from bobrossnet.tracing.scene import SceneLike

F32: TypeAlias = NDArray[np.float32]
Bits: TypeAlias = NDArray[np.bool_]

HERE = Path(__file__).parent
SIZE = (256, 256)
SHARES = (0.02, 0.05, 0.1)
SHOWN = 0.05
FIGURE = 4_000_500_002  # seed of the first shape in the picture

STEP = 0.03  # minimum difference of depth between neighbours on different surfaces
TURN = np.cos(np.radians(20))  # of the normal between neighbours on both sides of a crease
THIN = 5  # pixels: narrower parts vanish under an opening
STAIN = 0.05  # of albedo between neighbours
ROUNDS = 8  # of the oracle of placement
SHINE = 0.02  # of the highlight's gray

CLASSES = {
    "thin parts": (230, 159, 0),
    "silhouettes": (213, 94, 0),
    "creases": (0, 114, 178),
    "textures": (0, 158, 115),
    "highlights": (240, 228, 66),
    "smooth": (90, 90, 90),
}
"""Colours in the pictures. A pixel belongs to the first class that fits."""


def classes(full: bob.GBuffer) -> dict[str, Bits]:
    """Return the pixels of each of the `CLASSES`, (H, W), of a whole G-buffer."""
    hit, depth = full.alpha > 0, full.depth
    x, y = np.moveaxis(full.normal, -1, 0)
    normal = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], -1)
    highlight = 0.2 * np.maximum(0, normal @ HALFWAY) ** 32 * hit
    opened = binary_opening(hit, np.ones((THIN, THIN)))
    found = {
        "thin parts": binary_dilation(hit & ~opened),
        "silhouettes": _beside(lambda a, b: np.abs(depth[a] - depth[b]) > STEP)
        | _beside(lambda a, b: hit[a] != hit[b]),
        "creases": _beside(lambda a, b: (normal[a] * normal[b]).sum(-1) < TURN) & hit,
        "textures": _beside(lambda a, b: np.abs(full.albedo[a] - full.albedo[b]).max(-1) > STAIN)
        if "albedo" in full.channels
        else np.zeros_like(hit),
        "highlights": highlight > SHINE,
        "smooth": np.ones_like(hit),
    }
    taken = np.zeros_like(hit)
    for name, pixels in found.items():
        found[name] = pixels & ~taken
        taken |= pixels
    return found


LIGHT = np.array([-0.3, 0.4, 1]) / np.linalg.norm([-0.3, 0.4, 1])
HALFWAY = (LIGHT + [0, 0, 1]) / np.linalg.norm(LIGHT + [0, 0, 1])


def _beside(differ: Callable[[tuple[slice, slice], tuple[slice, slice]], Bits]) -> Bits:
    """Return the pixels that differ from a neighbour in their row or column, and those neighbours."""
    found = np.zeros(SIZE, np.bool_)
    whole, first, last = slice(None), slice(None, -1), slice(1, None)
    for a, b in (((first, whole), (last, whole)), ((whole, first), (whole, last))):
        different = differ(a, b)
        found[a] |= different
        found[b] |= different
    return found


# ---- Oracles: they know the truth ------------------------------------------------------------------------


def placed_by_error(full: bob.GBuffer, share: float, complete: Callable[[bob.GBuffer], F32]) -> bob.GBuffer:
    """Return the pixels of an oracle of placement: half by the adaptive order, the others in rounds where the error is.

    A round takes the pixels of the largest error, at most one in each 3 x 3.
    """
    budget = pixel_count(share, full.size)
    mask = full.sample(share / 2).mask.copy()
    for k in range(ROUNDS):
        error = np.abs(complete(_with_mask(full, mask)) - full.gray) * (mask == 0)
        is_peak = (error > 0) & (error == maximum_filter(error, 3))
        count = (budget - int(mask.sum())) // (ROUNDS - k)
        first = np.argpartition((error + is_peak - mask).ravel(), -count)[-count:]  # peaks, then others; no pixel twice
        mask.ravel()[first] = 1
    return _with_mask(full, mask)


def _with_mask(full: bob.GBuffer, mask: F32) -> bob.GBuffer:
    planes = full.planes * mask
    return bob.GBuffer.from_stack(planes, full.layout)


def clipped_to_samples(part: bob.GBuffer, truth: F32, count: int = 8) -> F32:
    """Return the best picture of blends of the nearest traced pixels: the truth, clipped to their range."""
    from scipy.spatial import cKDTree

    known, unknown = np.argwhere(part.mask > 0), np.argwhere(part.mask == 0)
    _, nearest = cKDTree(known).query(unknown, count)
    values = part.gray[tuple(known.T)][nearest]
    image = part.gray.copy()
    image[tuple(unknown.T)] = np.clip(truth[tuple(unknown.T)], values.min(1), values.max(1))
    return image


def nearest_of_same_surface(part: bob.GBuffer, full: bob.GBuffer) -> F32:
    """Return Delaunay's picture where an oracle knows every silhouette: surfaces and background are filled apart."""
    image = np.zeros(full.size, np.float32)
    hit = full.alpha > 0
    inside = (part.mask > 0) & hit
    if inside.any():
        image = np.where(hit, delaunay_linear(part.gray, inside), image)
    return np.where(part.mask > 0, part.gray, image)


def pictures_of(full: bob.GBuffer, share: float) -> dict[str, F32]:
    """Return the pictures to compare, by name."""
    part = full.sample(share)
    ours, filling, linear = (
        bob.complete(part),
        bob.complete(part, model="filling"),
        delaunay_linear(part.gray, part.mask),
    )
    candidates = np.stack([ours, filling, linear])
    best = np.abs(candidates - full.gray).argmin(0)
    placed = placed_by_error(full, share, bob.complete)
    return {
        "default": ours,
        "filling": filling,
        "delaunay-linear": linear,
        "the best of these three, pixel by pixel": np.take_along_axis(candidates, best[None], 0)[0],
        "delaunay-linear, silhouettes known": nearest_of_same_surface(part, full),
        "best blend of the 8 nearest samples": clipped_to_samples(part, full.gray),
        "default, pixels placed by the error": bob.complete(placed),
        "best blend, pixels placed by the error": clipped_to_samples(placed, full.gray),
    }


# ---- Page ------------------------------------------------------------------------------------------------


def scenes(limit: int) -> Scenes:
    """Return half coloured and half white shapes of the package, or real files in the place of the white ones."""
    real = scenes_of_folder(MODELS, limit // 2) if MODELS.is_dir() else own_scenes(limit // 2)
    white, colored = own_scenes(limit // 4, 4_000_500_000), own_scenes(limit // 4, 4_000_600_000, colored=True)
    return {**real, **white, **colored}


def view(number: int, scene: SceneLike) -> bob.GBuffer:
    """Return a scene with every pixel traced; the number turns the camera."""
    camera = bob.Camera(azimuth=(40 * number) % 360, elevation=(20, 45)[number % 2])
    return bob.trace(scene, camera, size=SIZE)


def write_figure() -> None:
    """Write the picture: of some shapes of the package the truth, its classes, the completed picture, and its error."""
    rows = []
    for full in (view(number, scene) for number, _, scene in each_scene(own_scenes(3, FIGURE), stacklevel=1)):
        image = bob.complete(full.sample(SHOWN))
        colors = np.zeros((*SIZE, 3), np.uint8)
        for name, pixels in classes(full).items():
            if name != "smooth":
                colors[pixels] = CLASSES[name]
        panels = {
            "all pixels": to_8_bit(full.gray),
            "classes": colors,
            f"{100 * SHOWN:g} %: SSIM {bob.ssim(image, full.gray):.3f}": to_8_bit(image),
            "error x 4": to_8_bit(np.clip(4 * np.abs(image - full.gray), 0, 1)),
        }
        rows.append(side_by_side([(panel, caption) for caption, panel in panels.items()]))
    write_picture(HERE / "errors.png", np.concatenate(rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--limit", type=int, default=40, help="number of shapes")
    limit = parser.parse_args().limit
    errors = np.zeros((len(SHARES), len(CLASSES)))
    without = np.zeros((len(SHARES), len(CLASSES)))
    pixels = np.zeros(len(CLASSES))
    scores: dict[str, list[list[float]]] = {}
    count = 0
    for number, _, scene in each_scene(scenes(limit), stacklevel=1):
        full = view(number, scene)
        found, count = classes(full), count + 1
        pixels += [mask.mean() for mask in found.values()]
        by_name: dict[str, list[float]] = {}
        for k, share in enumerate(SHARES):
            for name, image in pictures_of(full, share).items():
                by_name.setdefault(name, []).append(bob.ssim(image, full.gray))
                if name == "default":
                    error = np.abs(image - full.gray)
                    for c, mask in enumerate(found.values()):
                        errors[k, c] += error[mask].sum()
                        without[k, c] += bob.ssim(np.where(mask, full.gray, image), full.gray) - by_name[name][-1]
        for name, values in by_name.items():
            scores.setdefault(name, []).append(values)
    write_figure()
    means = {name: np.mean(values, 0) for name, values in scores.items()}
    write_whole(HERE / "errors.md", page(count, pixels / count, errors, without / count, means).encode())


def page(
    count: int,
    pixels: NDArray[np.float64],
    errors: NDArray[np.float64],
    without: NDArray[np.float64],
    means: Mapping[str, NDArray[np.float64]],
) -> str:
    """Return the page; `errors` (shares, classes) are sums, `without` means of SSIM gained."""
    shares = [f"{100 * share:g} %" for share in SHARES]
    of_error = 100 * errors / errors.sum(1, keepdims=True)
    left = 1 - means["default"]
    rows = [
        [name, f"{100 * pixels[c]:.1f} %", *(f"{x:.0f} %" for x in of_error[:, c])]
        + [f"{100 * x:.0f} %" for x in without[:, c] / left]
        for c, name in enumerate(CLASSES)
    ]
    where = table(["class", "pixels", *(f"error, {s}" for s in shares), *(f"1 - SSIM, {s}" for s in shares)], rows)
    limits = [
        [name, *(cell(x, 4) for x in values), *(f"{100 * x:+.0f} %" for x in (1 - values) / left - 1)]
        for name, values in means.items()
    ]
    oracles = table(["picture", *(f"SSIM, {s}" for s in shares), *(f"1 - SSIM, {s}" for s in shares)], limits)
    names = list(CLASSES)
    edges = sum(of_error[SHARES.index(SHOWN), names.index(name)] for name in ("silhouettes", "creases"))
    return TEXT.format(count=count, where=where, oracles=oracles, thin=THIN, shown=f"{100 * SHOWN:g} %", edges=edges)


TEXT = """# Where the error is

`python docs/errors.py` made this page from {count} pictures of 256x256 pixels: half of real shapes, a quarter of the
package's white ones, a quarter of its coloured ones. The pixels are placed in the adaptive order, and the default
network completes them.

![All pixels; classes; the picture from {shown} of the pixels; its error, four times; a row for each shape.](errors.png)

Orange: thin parts. Red: silhouettes. Blue: creases. Green: textures. Yellow: highlights.

## By class

"Error" is the class's share of the absolute error. "1 - SSIM" is the share that would vanish if the class's pixels were
exact; since an SSIM window covers several classes, these don't add up to 100 %.

{where}

- **Thin parts** are narrower than {thin} pixels, **silhouettes** steps of depth, **creases** turns of the normal by
  more than 20° between neighbours, **textures** steps of albedo, **highlights** pixels with a specular gray above 0.02.
- A pixel belongs to the first class that fits, in the table's order.

## Limits

Oracles know the truth, so no method reaches them. The column "change" compares 1 - SSIM with the default network.

{oracles}

- **Best blend**: each untraced pixel is the truth, clipped to the range of its 8 nearest samples.
- **Silhouettes known**: surfaces and background are filled separately; nothing else is known.
- **Placed by the error**: half of the pixels by the adaptive order, the others in eight rounds at the peaks of the
  completed picture's true error.

## What follows

- **Edges**: at {shown}, silhouettes and creases have {edges:.0f} % of the error. The position of an edge between two
  samples is missing, not shading. Textures, highlights and thin parts have little of it in these pictures.
- **The samples suffice**: blends of eight neighbours could do nearly everything. A network that chooses weights of
  samples along an edge could gain as much; choosing among the three completed pictures could gain a quarter.
- **Placement matters more than completion from 5 % on**, and less at 2 %: the next network should place pixels.
"""


if __name__ == "__main__":
    main()
