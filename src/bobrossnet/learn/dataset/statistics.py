"""Statistics of a data set's pictures compared with pictures of real shapes, measure by measure.

A pixel is *hit* where a ray hit a surface; neighbours share a side. Letters: P pictures, M measures, B bins.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats

from bobrossnet.adapters.files import load
from bobrossnet.learn.dataset.plan import Plan
from bobrossnet.learn.dataset.store import Dataset, part_of
from bobrossnet.learn.shape_files import left_out, shape_files, spread
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.errors import InputError
from bobrossnet.support.tables import table
from bobrossnet.tracing.trace import trace

SIZE = 256  # side of the measured views, pixels
JUMP = 0.03  # depth difference of neighbours from which there is an edge: at 256 pixels, surfaces at 83° or more
CREASE = 30.0  # degrees between neighbours' normals, from which there is a crease, without a jump in depth
FLAT = 1.0  # degrees between neighbours' normals, below which they are coplanar
BLUR = 1.0  # pixels, standard deviation of the Gaussian that removes fine detail
BINS = 16  # of gray, 0..1
CLEAR = 0.2  # Kolmogorov-Smirnov distance: 1.6 % of pairs of samples of 120 from one distribution differ more

MEASURES = {
    "coverage": "hit pixels",
    "silhouettes": "pixels at silhouettes",
    "depth edges": "pixels at depth edges",
    "creases": "pixels at creases",
    "flat": "pixels on planes",
    "mean gray": "bright pixels",
    "gradient energy": "gradient energy",
    "fine detail": "gradient energy that is fine detail",
    "components": "separate pieces in the picture",
    "holes": "holes in the silhouette",
    "width": "wide places",
}
"""Names of the measures (formulas: `picture_statistics`), and the property that grows with each."""


class PictureStatistics(NamedTuple):
    """The measures of a picture, (M,) float64 in the order of `MEASURES`, and its gray histogram, (B,) float64."""

    measures: NDArray[np.float64]
    histogram: NDArray[np.float64]


def picture_statistics(gbuffer: GBuffer) -> PictureStatistics | None:
    """Measure a picture.

    - coverage: share of hit pixels. The next four are shares of these:
    - silhouettes: hit pixels next to a pixel that is not hit
    - depth edges: depth differs from a neighbour's by more than `JUMP`
    - creases: the normal turns by more than `CREASE` to a neighbour without a jump in depth
    - flat: the normal turns by less than `FLAT` to the neighbours to the right and below
    - mean gray: over hit pixels, as is the histogram of shares
    - gradient energy: sum of squared differences of gray between hit neighbours, by hit pixel
    - fine detail: share of that energy lost when gray is blurred by a Gaussian of `BLUR` pixels over hit pixels alone
      (normalised convolution, Knutsson and Westin 1993): 0.72 for a step, near 0 for smooth gray, near 1 for noise; 0
      without any energy
    - components: connected components of hit pixels, by sides and corners
    - holes: connected components of pixels that are not hit, by sides alone, away from the border
    - width: 4 times the mean distance of hit pixels to the nearest pixel that is not hit, or to the border, relative to
      the picture's shorter side: w for a long strip of width w, 4/3 of the radius of a disc

    Parameters
    ----------
    gbuffer : GBuffer, every pixel traced

    Returns
    -------
    PictureStatistics, or None if no pixel is hit
    """
    hit = gbuffer.depth > 0
    count = int(np.count_nonzero(hit))
    if count == 0:
        return None
    depth, gray = gbuffer.depth.astype(np.float64), gbuffer.gray.astype(np.float64)
    normal = gbuffer.normal.astype(np.float64)
    z = np.sqrt(np.maximum(1 - (normal**2).sum(-1, keepdims=True), 0))
    normal = np.concatenate([normal, z], -1)  # (H, W, 3)
    weight = ndimage.gaussian_filter(hit.astype(np.float64), BLUR)
    blurred = ndimage.gaussian_filter(np.where(hit, gray, 0), BLUR) / np.where(hit, weight, 1)

    silhouette, edge, crease, curved = (np.zeros(hit.shape, bool) for _ in range(4))
    energy = fine_energy = 0.0
    for axis in (0, 1):
        one, other = _neighbours(hit, axis)
        both = one & other
        _mark_both(silhouette, axis, one != other)
        jump = both & (_distance(depth[..., None], axis) > JUMP)
        _mark_both(edge, axis, jump)
        turn = _distance(normal, axis)  # a chord of the unit sphere
        _mark_both(crease, axis, both & ~jump & (turn > _chord(CREASE)))
        _neighbours(curved, axis)[0][...] |= ~both | (turn >= _chord(FLAT))
        energy += float((_distance(gray[..., None], axis)[both] ** 2).sum())
        fine_energy += float((_distance(blurred[..., None], axis)[both] ** 2).sum())

    _, hole_count = ndimage.label(~np.pad(hit, 1))  # padding joins everything at the border
    to_background = ndimage.distance_transform_edt(np.pad(hit, 1))[1:-1, 1:-1]
    measures = {
        "coverage": count / hit.size,
        "silhouettes": np.count_nonzero(silhouette & hit) / count,
        "depth edges": np.count_nonzero(edge) / count,
        "creases": np.count_nonzero(crease) / count,
        "flat": np.count_nonzero(hit & ~curved) / count,
        "mean gray": gray[hit].mean(),
        "gradient energy": energy / count,
        "fine detail": 1 - fine_energy / energy if energy > 0 else 0,
        "components": ndimage.label(hit, np.ones((3, 3)))[1],
        "holes": hole_count - 1,
        # The distance to a boundary is half a pixel less than to the nearest pixel beyond it.
        "width": 4 * (to_background[hit].mean() - 0.5) / min(hit.shape),
    }
    histogram = np.histogram(gray[hit], BINS, (0, 1))[0] / count
    return PictureStatistics(np.array([measures[name] for name in MEASURES], np.float64), histogram)


def _neighbours(array: NDArray[Any], axis: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return views of the pixels with a next neighbour along an axis, and of these neighbours."""
    along = np.moveaxis(array, axis, 0)
    return np.moveaxis(along[:-1], 0, axis), np.moveaxis(along[1:], 0, axis)


def _distance(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Return the Euclidean distance between neighbours' values, (H, W, n)."""
    one, other = _neighbours(values, axis)
    length: NDArray[np.float64] = np.linalg.norm(one - other, axis=-1)
    return length


def _mark_both(marks: NDArray[np.bool_], axis: int, between: NDArray[np.bool_]) -> None:
    """Mark the pixels on both sides of marked boundaries."""
    for side in _neighbours(marks, axis):
        side |= between


def _chord(degrees: float) -> float:
    return float(2 * np.sin(np.radians(degrees) / 2))


class Population(NamedTuple):
    """The measures of several pictures.

    Attributes
    ----------
    measures : (P, M) float64, in the order of `MEASURES`
    histogram : (B,) float64, mean of the pictures' gray histograms
    """

    measures: NDArray[np.float64]
    histogram: NDArray[np.float64]


def population(pictures: Iterable[GBuffer]) -> Population:
    """Measure pictures, one at a time; pictures without a hit pixel are omitted.

    Raises
    ------
    InputError
        If every picture is omitted.
    """
    measured = [statistics for picture in pictures if (statistics := picture_statistics(picture)) is not None]
    if not measured:
        raise InputError("pictures: expected at least one with a visible surface, got none")
    measures, histograms = zip(*measured, strict=True)
    return Population(np.stack(measures), np.mean(histograms, axis=0))


def pictures_of_dataset(dataset: Dataset) -> Iterator[GBuffer]:
    """Yield each shape's view of `SIZE` pixels."""
    for shape in range(dataset.plan.shapes):
        view = dataset.read(shape, SIZE).astype(np.float32)
        yield part_of(view, np.ones((SIZE, SIZE), np.float32))


def pictures_of_files(paths: Iterable[Path], plan: Plan) -> Iterator[GBuffer]:
    """Yield a view of each file, by the plan's camera of the shape with the same number.

    Parameters
    ----------
    paths : shape files
    plan : Plan

    Warns
    -----
    InputWarning
        If a file is omitted because it can't be loaded.
    """
    for number, path in enumerate(paths):
        try:
            scene = load(path)
        except InputError as error:
            left_out(error, stacklevel=2)
        else:
            yield trace(scene, plan.camera(number, SIZE), size=(SIZE, SIZE))


@dataclass(frozen=True)
class Comparison:
    """A comparison of two populations. `str()` returns it as markdown.

    Attributes
    ----------
    own, real : Population, of the data set and of real shapes
    distances : (M,) float64
        Two-sample Kolmogorov-Smirnov statistic of each measure, the largest difference of the two cumulative
        distributions: 0 for equal populations, 1 for disjoint ones. Negative where own pictures have less than real
        ones at this difference.
    gray_distance : float
        Total variation distance of the histograms, half the sum of their absolute differences, 0..1.
    """

    own: Population
    real: Population
    distances: NDArray[np.float64]
    gray_distance: float

    def table(self) -> str:
        """Return medians, 10th and 90th percentiles, and distances as a markdown table, the largest distance first."""
        rows = []
        for i in np.argsort(-abs(self.distances), kind="stable"):
            spans = [_span(population.measures[:, i]) for population in (self.own, self.real)]
            rows.append((list(MEASURES)[i], *spans, f"{self.distances[i]:+.2f}"))
        return table(["", "own median (10 % .. 90 %)", "real median (10 % .. 90 %)", "distance"], rows)

    def histogram_table(self) -> str:
        """Return the gray histograms as a markdown table, in percent."""
        rows = []
        for i, (own, real) in enumerate(zip(100 * self.own.histogram, 100 * self.real.histogram, strict=True)):
            bin_name = f"{i / BINS:.2f} .. {(i + 1) / BINS:.2f}"
            rows.append((bin_name, f"{own:.1f} %", f"{real:.1f} %", f"{own - real:+.1f}"))
        return table(["gray", "own", "real", "difference"], rows)

    def sentences(self) -> list[str]:
        """Return a sentence for each measure with a distance above `CLEAR`."""
        return [
            f"Own shapes have {'more' if self.distances[i] > 0 else 'less' if _is_mass(phrase) else 'fewer'} {phrase}."
            for i, phrase in enumerate(MEASURES.values())
            if abs(self.distances[i]) > CLEAR
        ]

    def __str__(self) -> str:
        counts = f"{len(self.own.measures)} own pictures and {len(self.real.measures)} real ones, {SIZE}x{SIZE} pixels"
        differences = "\n".join(f"- {sentence}" for sentence in self.sentences()) or "Nothing differs clearly."
        return "\n\n".join(
            [
                f"{counts}. Distances: Kolmogorov-Smirnov, negative where own pictures have less.",
                self.table(),
                f"Clear differences, of more than {CLEAR:g}:\n\n{differences}",
                f"Gray of hit pixels; total variation distance {self.gray_distance:.3f}:",
                self.histogram_table(),
            ]
        )


def compare(own: Population, real: Population) -> Comparison:
    """Compare a data set's population with one of real shapes."""
    distances = []
    for one, other in zip(own.measures.T, real.measures.T, strict=True):
        result = stats.ks_2samp(one, other, method="asymp")
        # scipy's sign is positive where the first population has less.
        distances.append(0.0 - result.statistic_sign * result.statistic)
    gray_distance = float(abs(own.histogram - real.histogram).sum() / 2)
    return Comparison(own, real, np.array(distances), gray_distance)


def compare_with_folder(dataset: Dataset, folder: str | Path, *, limit: int | None = None) -> Comparison:
    """Compare a data set with the shapes below a folder, from the cameras of its plan.

    Parameters
    ----------
    dataset : Dataset
    folder : folder of shape files
        Searched recursively, in the order of the names.
    limit : maximum number of files, spread evenly, optional

    Raises
    ------
    InputError
        If no file can be loaded.

    Warns
    -----
    InputWarning
        If a file is omitted because it can't be loaded.
    """
    paths = spread(shape_files(folder), limit)
    if not paths:
        raise InputError(f"{folder}: expected shape files, got none")
    real = population(pictures_of_files(paths, dataset.plan))
    return compare(population(pictures_of_dataset(dataset)), real)


def _is_mass(phrase: str) -> bool:
    return "energy" in phrase


def _span(values: NDArray[np.float64]) -> str:
    low, middle, high = np.percentile(values, (10, 50, 90))
    return f"{middle:.3g} ({low:.3g} .. {high:.3g})"
