"""Other people's tracers: sparse pixels completed along guides, beside lower resolutions and fewer paths denoised, in
four scenes of Mitsuba's, in perspective and orthographic.

Needs the extra `mitsuba`, LLVM (DRJIT_LIBLLVM_PATH), and from PyPI `pyoidn`. Prints docs/tracers.md's tables: `exact`
those without noise, `noise` the other, by default both.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import flip_evaluator
import numpy as np
from mitsuba_scenes import DEPTH, LOOKS, SIZE, scene
from numpy.typing import NDArray
from report import heading, table

import bobrossnet as bob
from bobrossnet.adapters import mitsuba
from bobrossnet.color import to_srgb

F32 = NDArray[np.float32]

PICTURE = f"{SIZE[1]}x{SIZE[0]}"
SPP = 16
TRUTH = 512
"""Paths of each pixel, which are then denoised: what is left of noise is far below all that is compared."""
KEPT = Path("out/tracers")
"""Where the truth is kept, since it takes minutes."""
FRACTIONS = (0.05, 0.1, 0.25)
PIXEL_COSTS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Seconds for a pixel without noise."""


class Result(NamedTuple):
    ssim: float
    flip: float
    seconds: float
    pixels: float = 0
    """How many pixels, of the whole picture's, that took."""


class WithoutGuides:
    """A tracer that finds a picture's pixels."""

    size = SIZE

    def __init__(self, picture: F32, guides: bob.Guides) -> None:
        self.picture, self.known = picture, guides

    def __call__(self, pixels: NDArray[np.int32]) -> bob.Samples:
        row, column = pixels.T
        hit = self.known.hit[row, column] > 0
        found = {name: self.known.channel(name)[row, column] for name in ("depth", "normal", "albedo")}
        return bob.Samples(color=self.picture[row, column], hit=hit, **found)


class Exact(WithoutGuides):
    """The same with guides."""

    def guides(self) -> bob.Guides:
        return self.known


class View:
    """A scene, seen once: its truth, and whatever renders it."""

    def __init__(self, name: str, orthographic: bool) -> None:
        self.name, self.orthographic = name, orthographic
        self.tracer = self.tracer_of(SIZE, SPP)
        self.guides = self.tracer.guides()
        kept = KEPT / f"{name}{' orthographic' * orthographic}.npy"
        if not kept.is_file():
            raw = everywhere(self.tracer_of(SIZE, SPP, seed=1), TRUTH // SPP)
            kept.parent.mkdir(parents=True, exist_ok=True)
            np.save(kept, denoised(raw, self.guides))
        self.truth: F32 = np.load(kept)

    def tracer_of(self, size: tuple[int, int], spp: int, seed: int = 2) -> Any:
        return mitsuba.tracer(scene(self.name, orthographic=self.orthographic, size=size), spp=spp, seed=seed)

    def score(self, picture: F32) -> tuple[float, float]:
        """SSIM, the mean of the three components, and FLIP, both of sRGB."""
        shown, wanted = to_srgb(picture), to_srgb(self.truth)
        ssim = statistics.fmean(bob.ssim(shown[..., k], wanted[..., k]) for k in range(3))
        _, flip, _ = flip_evaluator.evaluate(wanted, shown, "LDR")
        return ssim, float(flip)

    # Without noise: pixels are those of the truth, and cost what they are said to.

    def exact(self, fraction: float, guided: bool = True) -> Result:
        """Sparse pixels along guides, or without them."""
        tracer = Exact(self.truth, self.guides) if guided else WithoutGuides(self.truth, self.guides)
        frame = next(bob.progressive(tracer=tracer, first=fraction))
        color, seconds = fastest(partial(bob.complete, frame.gbuffer, channel="color"))
        return Result(*self.score(color), seconds, fraction)

    def enlarged(self, factor: int) -> Result:
        """A picture of a lower resolution, of means of the truth's pixels, enlarged bilinearly."""
        picture, seconds = fastest(partial(enlarge, block_means(self.truth, factor)))
        return Result(*self.score(picture), seconds, 1 / factor**2)

    # With noise, in the time that it takes.

    def sparse(self, fraction: float) -> Result:
        tracer = self.tracer_of(SIZE, SPP)
        next(bob.progressive(tracer=tracer, first=fraction)).color  # noqa: B018  compiles
        tracer._guides = None
        start = time.perf_counter()
        color = next(bob.progressive(tracer=tracer, first=fraction)).color
        return Result(*self.score(color), time.perf_counter() - start, fraction)

    def dense(self, spp: int, factor: int = 1, oidn: bool = True) -> Result:
        """All pixels of a resolution, denoised if asked for, and enlarged."""
        size = SIZE[0] // factor, SIZE[1] // factor
        tracer = self.tracer_of(size, spp)
        everywhere(tracer, 1), tracer.guides()
        tracer._guides = None
        start = time.perf_counter()
        color = everywhere(tracer, 1)
        if oidn:
            color = denoised(color, tracer.guides())
        picture = enlarge(color)
        return Result(*self.score(picture), time.perf_counter() - start, spp / SPP / factor**2)


def fastest(run: Callable[[], Any]) -> tuple[Any, float]:
    """What it returns, and the seconds of the fastest of 9: the others waited for whatever else the machine did."""
    seconds = []
    for _ in range(9):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    return result, min(seconds)


def everywhere(tracer: Any, passes: int) -> F32:
    """The mean colours of so many passes over all pixels."""
    height, width = tracer.size
    pixels = np.argwhere(np.ones(tracer.size)).astype(np.int32)
    total = np.zeros((height * width, 3))
    for _ in range(passes):
        total += tracer(pixels).color
    return (total / passes).astype(np.float32).reshape(height, width, 3)


def denoised(color: F32, guides: bob.Guides) -> F32:
    import pyoidn

    z = np.sqrt(np.maximum(0, 1 - np.square(guides.normal).sum(axis=-1))) * guides.hit
    normal = np.concatenate([guides.normal, z[..., None]], axis=-1).astype(np.float32)
    result: F32 = pyoidn.denoise(color, albedo=np.ascontiguousarray(guides.albedo), normal=np.ascontiguousarray(normal))
    return result


def block_means(picture: F32, factor: int) -> F32:
    height, width = picture.shape[0] // factor, picture.shape[1] // factor
    blocks = picture.reshape(height, factor, width, factor, 3)
    means: F32 = blocks.mean(axis=(1, 3))
    return means


def enlarge(picture: F32) -> F32:
    """To `SIZE`, bilinearly."""
    if picture.shape[:2] == SIZE:
        return picture
    import cv2

    cv2.setNumThreads(1)  # several wait for each other on a busy machine
    return np.asarray(cv2.resize(picture, SIZE[::-1], interpolation=cv2.INTER_LINEAR), np.float32)


def named(methods: dict[str, Callable[[View], Result]], views: list[View]) -> dict[str, list[Result]]:
    results: dict[str, list[Result]] = {}
    for name, method in methods.items():
        results[name] = [method(view) for view in views]
        print(name, [f"{r.ssim:.4f}" for r in results[name]], file=sys.stderr, flush=True)
    return results


def cell(results: list[Result]) -> str:
    """SSIM in perspective and orthographic."""
    return ", ".join(f"{result.ssim:.3f}" for result in results)


def quality(results: dict[str, list[Result]], views: list[View], cost: str, of: Callable[[list[Result]], str]) -> None:
    """Print what pictures are like, and what they cost."""
    names = list(LOOKS)
    rows = []
    for method, each in results.items():
        cells = [cell([r for r, view in zip(each, views, strict=True) if view.name == name]) for name in names]
        ssim, flip = statistics.fmean(r.ssim for r in each), statistics.fmean(r.flip for r in each)
        rows.append([method, *cells, f"{ssim:.3f}", f"{flip:.3f}", of(each)])
    table(["method", *names, "mean SSIM", "mean FLIP", cost], rows)


def by_cost(exact: dict[str, list[Result]], guides_seconds: float) -> None:
    """Seconds by the cost of a pixel."""
    rows = []
    total = SIZE[0] * SIZE[1]
    for method, each in exact.items():
        own = statistics.median(r.seconds for r in each) + (guides_seconds if "along" in method else 0)
        times = [f"{1e3 * (own + each[0].pixels * total * cost):,.0f}" for cost in PIXEL_COSTS]
        rows.append([method, f"{statistics.fmean(r.ssim for r in each):.3f}", *times])
    everything = [f"{1e3 * total * cost:,.0f}" for cost in PIXEL_COSTS]
    rows.append(["every pixel", "1", *everything])
    table(["method", "mean SSIM", *(f"{1e6 * cost:,.0f} µs a pixel" for cost in PIXEL_COSTS)], rows)


def main() -> None:
    try:
        import mitsuba as mi
        import pyoidn  # noqa: F401

        mi.set_variant("llvm_ad_rgb")
        mitsuba.tracer(mi.load_dict(mi.cornell_box()))
    except (ImportError, bob.InputError) as error:
        print(f"skipped {Path(sys.argv[0]).name}: {error}")
        return
    parts = {"exact": without_noise, "noise": with_noise}
    wanted = sys.argv[1:] or list(parts)
    views = [View(name, orthographic) for name in LOOKS for orthographic in (False, True)]
    for part in wanted:
        parts[part](views)


def without_noise(views: list[View]) -> None:
    methods: dict[str, Callable[[View], Result]] = {}
    for fraction in FRACTIONS:
        methods[f"{fraction:.0%} along guides"] = partial(View.exact, fraction=fraction)
    for fraction in FRACTIONS:
        methods[f"{fraction:.0%} without guides"] = partial(View.exact, fraction=fraction, guided=False)
    for factor in (2, 4):
        methods[f"1/{factor} of the resolution"] = partial(View.enlarged, factor=factor)
    results = named(methods, views)
    heading(f"Without noise, {PICTURE}: SSIM in perspective, orthographic; ms to complete or enlarge")
    quality(results, views, "ms", lambda each: f"{1e3 * statistics.median(r.seconds for r in each):.0f}")

    heading("The same by what a pixel costs: milliseconds in all")

    def find_guides() -> None:
        views[0].tracer._guides = None
        views[0].tracer.guides()

    _, seconds = fastest(find_guides)
    print(f"Guides of all pixels, nine rays each, take {1e3 * seconds:.0f} ms of that.\n")
    by_cost(results, seconds)


def with_noise(views: list[View]) -> None:
    methods: dict[str, Callable[[View], Result]] = {}
    for fraction in FRACTIONS:
        methods[f"{fraction:.0%} of the pixels, {SPP} paths each"] = partial(View.sparse, fraction=fraction)
    for spp in (1, 4, SPP):
        methods[f"all pixels, {spp} path{'s' * (spp > 1)} each, OIDN"] = partial(View.dense, spp=spp)
    for factor in (2, 4):
        for oidn in (False, True):
            name = f"1/{factor} of the resolution, {SPP} paths" + (", OIDN" if oidn else "")
            methods[name] = partial(View.dense, spp=SPP, factor=factor, oidn=oidn)
    heading(f"Path tracer of depth {DEPTH}, {PICTURE}: SSIM in perspective, orthographic")
    quality(named(methods, views), views, "paths a pixel", lambda each: f"{SPP * each[0].pixels:g}")


if __name__ == "__main__":
    main()
