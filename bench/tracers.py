"""Foreign tracers: sparse pixels completed along guides, compared with lower resolutions and fewer denoised paths.

The scenes are Mitsuba's, in perspective and orthographic. Needs the extras `mitsuba` and `oidn`, and LLVM
(DRJIT_LIBLLVM_PATH). Prints the tables of docs/results/tracers.md: `exact` without noise, `noise` with noise, by
default both; with --held-out for the scenes that no constant was tuned on.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mitsuba_scenes import DEPTH, HELD_OUT, SIZE, TUNED, scene
from numpy.typing import NDArray
from report import MODELS, heading, table

import bobrossnet as bob
from bobrossnet.adapters import mitsuba, oidn
from bobrossnet.color import to_srgb
from bobrossnet.metrics import flip

F32 = NDArray[np.float32]

PICTURE = f"{SIZE[1]}x{SIZE[0]}"
TOTAL = SIZE[0] * SIZE[1]
SPP = 16
TRUTH = 256
"""Paths of each pixel before denoising."""
KEPT = Path("out/tracers")
"""Cache of the references, since they take minutes."""
FRACTIONS = (0.05, 0.1, 0.25)
PIXEL_COSTS = (1e-6, 1e-5, 1e-4, 1e-3)
"""Seconds for a pixel without noise."""
MOST_COST = 0.1
"""Costs of a pixel among which the best method is searched."""


class Result(NamedTuple):
    ssim: float
    flip: float
    pixels: float
    """Number of pixels, relative to the whole picture's."""
    seconds: float = 0
    """Additional seconds."""


class WithoutGuides:
    """A tracer that looks up a picture's pixels."""

    size = SIZE

    def __init__(self, picture: F32, guides: bob.Guides) -> None:
        self.picture, self.known = picture, guides

    def __call__(self, pixels: NDArray[np.int32]) -> bob.Samples:
        row, column = pixels.T
        hit = self.known.hit[row, column] > 0
        found = {name: self.known.channel(name)[row, column] for name in ("depth", "normal", "albedo")}
        return bob.Samples(color=self.picture[row, column], hit=hit, **found)


class Exact(WithoutGuides):
    """The same tracer with guides."""

    def guides(self) -> bob.Guides:
        return self.known


class View:
    """A view of a scene: its reference, and its renderings."""

    def __init__(self, name: str, orthographic: bool) -> None:
        self.name, self.orthographic = name, orthographic
        self.tracer = self.tracer_of(SIZE, SPP)
        self.guides = self.tracer.guides()
        kept = KEPT / f"{name}{' orthographic' * orthographic}.npy"
        if not kept.is_file():
            raw = everywhere(self.tracer_of(SIZE, SPP, seed=1), TRUTH // SPP)
            kept.parent.mkdir(parents=True, exist_ok=True)
            np.save(kept, oidn.denoise(raw, self.guides))
        self.truth: F32 = np.load(kept)

    def tracer_of(self, size: tuple[int, int], spp: int, seed: int = 2) -> Any:
        return mitsuba.tracer(scene(self.name, orthographic=self.orthographic, size=size), spp=spp, seed=seed)

    def score(self, picture: F32) -> tuple[float, float]:
        """Return SSIM, as the mean of the three components, and FLIP, both in sRGB."""
        shown, wanted = to_srgb(picture), to_srgb(self.truth)
        ssim = statistics.fmean(bob.ssim(shown[..., k], wanted[..., k]) for k in range(3))
        return ssim, flip(shown, wanted)

    # Without noise: pixels are looked up in the reference, at a nominal cost.

    def exact(self, fraction: float, guided: bool = True) -> Result:
        """Complete sparse pixels, with or without guides."""
        tracer = Exact(self.truth, self.guides) if guided else WithoutGuides(self.truth, self.guides)
        frame = next(bob.progressive(tracer=tracer, first=fraction))
        color, seconds = fastest(partial(bob.complete, frame.gbuffer, channel="color"))
        return Result(*self.score(color), fraction, seconds)

    def enlarged(self, factor: int) -> Result:
        """Downsample the reference by means, and upsample it bilinearly."""
        picture, seconds = fastest(partial(enlarge, block_means(self.truth, factor)))
        return Result(*self.score(picture), 1 / factor**2, seconds)

    # With noise: the cost is the number of one-path pixels, in shares of `SPP`.

    def sparse(self, fraction: float) -> Result:
        tracer = self.tracer_of(SIZE, SPP)
        return Result(*self.score(next(bob.progressive(tracer=tracer, first=fraction)).color), fraction)

    @cache  # noqa: B019  views live for the whole program
    def noisy(self, spp: int, factor: int) -> tuple[F32, bob.Guides]:
        tracer = self.tracer_of((SIZE[0] // factor, SIZE[1] // factor), spp)
        return everywhere(tracer, 1), tracer.guides()

    def dense(self, spp: int, factor: int = 1, denoises: bool = True) -> Result:
        """Render all pixels of a resolution, optionally denoised, and upsample them."""
        color, guides = self.noisy(spp, factor)
        picture = enlarge(oidn.denoise(color, guides) if denoises else color)
        return Result(*self.score(picture), spp / SPP / factor**2)


def fastest(run: Callable[[], Any]) -> tuple[Any, float]:
    """Return the result, and the seconds of the fastest of 9 runs; the others waited for other load."""
    seconds = []
    for _ in range(9):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    return result, min(seconds)


def everywhere(tracer: Any, passes: int) -> F32:
    """Return the mean colours of `passes` passes over all pixels."""
    height, width = tracer.size
    pixels = np.argwhere(np.ones(tracer.size)).astype(np.int32)
    total = np.zeros((height * width, 3))
    for _ in range(passes):
        total += tracer(pixels).color
    return (total / passes).astype(np.float32).reshape(height, width, 3)


def block_means(picture: F32, factor: int) -> F32:
    height, width = picture.shape[0] // factor, picture.shape[1] // factor
    blocks = picture.reshape(height, factor, width, factor, 3)
    means: F32 = blocks.mean(axis=(1, 3))
    return means


def enlarge(picture: F32) -> F32:
    """Upsample to `SIZE`, bilinearly."""
    if picture.shape[:2] == SIZE:
        return picture
    import cv2

    cv2.setNumThreads(1)  # its threads wait for each other on a busy machine
    return np.asarray(cv2.resize(picture, SIZE[::-1], interpolation=cv2.INTER_LINEAR), np.float32)


def named(methods: dict[str, Callable[[View], Result]], views: list[View]) -> dict[str, list[Result]]:
    results: dict[str, list[Result]] = {}
    for name, method in methods.items():
        results[name] = [method(view) for view in views]
        print(name, [f"{r.ssim:.4f}" for r in results[name]], file=sys.stderr, flush=True)
    return results


def cell(results: list[Result]) -> str:
    """Format SSIM in perspective and orthographic."""
    return ", ".join(f"{result.ssim:.3f}" for result in results)


def quality(results: dict[str, list[Result]], views: list[View], cost: str, of: Callable[[list[Result]], str]) -> None:
    """Print the quality and the cost of pictures."""
    names = list(dict.fromkeys(view.name for view in views))
    rows = []
    for method, each in results.items():
        cells = [cell([r for r, view in zip(each, views, strict=True) if view.name == name]) for name in names]
        ssim, flip = statistics.fmean(r.ssim for r in each), statistics.fmean(r.flip for r in each)
        rows.append([method, *cells, f"{ssim:.3f}", f"{flip:.3f}", of(each)])
    table(["method", *names, "mean SSIM", "mean FLIP", cost], rows)


def by_cost(exact: dict[str, list[Result]], guides_seconds: float) -> None:
    """Print seconds by the cost of a pixel."""
    rows = []
    for method, each in exact.items():
        times = [f"{1e3 * seconds_of(method, each, guides_seconds, cost):,.0f}" for cost in PIXEL_COSTS]
        rows.append([method, f"{statistics.fmean(r.ssim for r in each):.3f}", *times])
    everything = [f"{1e3 * TOTAL * cost:,.0f}" for cost in PIXEL_COSTS]
    rows.append(["every pixel", "1", *everything])
    table(["method", "mean SSIM", *(f"{1e6 * cost:,.0f} µs a pixel" for cost in PIXEL_COSTS)], rows)


def seconds_of(method: str, each: list[Result], guides_seconds: float, cost: float) -> float:
    """Return the time of a picture at `cost` seconds per pixel."""
    own = statistics.median(result.seconds for result in each) + (guides_seconds if "along" in method else 0)
    return own + each[0].pixels * TOTAL * cost


def where_best(exact: dict[str, list[Result]], views: list[View], guides_seconds: float) -> None:
    """Print the break-even cost of a pixel: above it, sparse pixels beat lower resolutions in equal time."""
    lower = [method for method in exact if "resolution" in method]
    costs = np.geomspace(1e-7, MOST_COST, 601)
    rows = []
    for index, view in enumerate(views):
        row = [f"{view.name}, {'by parallel rays' if view.orthographic else 'in perspective'}"]
        for quality in ("ssim", "flip"):
            sign = 1 if quality == "ssim" else -1
            good = {method: sign * getattr(each[index], quality) for method, each in exact.items()}
            for rival in lower:
                best = []
                for cost in costs:
                    seconds = {m: seconds_of(m, each, guides_seconds, cost) for m, each in exact.items()}
                    in_time = [m for m in exact if seconds[m] <= seconds[rival]]
                    best.append(max(in_time, key=good.__getitem__) not in lower)
                row.append(span(costs, best))
        rows.append(row)
    table(["picture", *(f"{name}, {method}" for name in ("SSIM", "FLIP") for method in lower)], rows)


def span(costs: NDArray[np.float64], best: list[bool]) -> str:
    """Describe the range of costs where a method is best."""
    if not any(best):
        return "never"
    first, last = (int(index) for index in np.flatnonzero(best)[[0, -1]])
    assert all(best[first : last + 1]), "more than one span"
    low, high = (f"{float(f'{1e6 * costs[index]:.2g}'):g} µs" for index in (first, last))
    return f"from {low} " + ("on" if last == len(best) - 1 else f"to {high}")


def main() -> None:
    parts = {"exact": without_noise, "noise": with_noise}
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="exact|noise", default=list(parts))
    parser.add_argument("--held-out", action="store_true")
    arguments = parser.parse_args()
    try:
        import mitsuba as mi
        import pyoidn  # noqa: F401

        mi.set_variant("llvm_ad_rgb")
        mitsuba.tracer(mi.load_dict(mi.cornell_box()))
    except (ImportError, bob.InputError) as error:
        print(f"skipped {Path(sys.argv[0]).name}: {error}")
        return
    names = HELD_OUT if arguments.held_out else TUNED
    if "scans" in names and not MODELS.is_dir():
        print(f"skipped scans: no shapes at {MODELS}; name their folder in BOBROSSNET_MODELS")
        names = tuple(name for name in names if name != "scans")
    views = [View(name, orthographic) for name in names for orthographic in (False, True)]
    for part in arguments.parts:
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

    heading("From what cost of a pixel on sparse pixels are best in the time of a lower resolution")
    where_best(results, views, seconds)


def with_noise(views: list[View]) -> None:
    methods: dict[str, Callable[[View], Result]] = {}
    for fraction in FRACTIONS:
        methods[f"{fraction:.0%} of the pixels, {SPP} paths each"] = partial(View.sparse, fraction=fraction)
    for spp in (1, 4, SPP):
        methods[f"all pixels, {spp} path{'s' * (spp > 1)} each, OIDN"] = partial(View.dense, spp=spp)
    for factor in (2, 4):
        for denoises in (False, True):
            name = f"1/{factor} of the resolution, {SPP} paths" + (", OIDN" if denoises else "")
            methods[name] = partial(View.dense, spp=SPP, factor=factor, denoises=denoises)
    heading(f"Path tracer of depth {DEPTH}, {PICTURE}: SSIM in perspective, orthographic")
    quality(named(methods, views), views, "paths a pixel", lambda each: f"{SPP * each[0].pixels:g}")


if __name__ == "__main__":
    main()
