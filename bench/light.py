"""Light from few paths: some pixels with many paths, completed along first hits, against denoised full pictures.

python bench/light.py [--paths 1 2 4 16] [--scenes tree bunny] [--lights sky studio]
python bench/light.py --moving [--scenes gear bunny truck]

Every contender has the same number of paths per surface pixel, and the same first hits. The reference has 512.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import bobrossnet as bob
from bobrossnet.color import luminance
from bobrossnet.completion.guided import complete_guided, guided_alpha, smoothed
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import Size
from bobrossnet.pictures.background import picture_of
from bobrossnet.tracing.light import LightLike, studio
from bobrossnet.tracing.lit import LitTracer
from bobrossnet.tracing.trace import traced_light

F32 = NDArray[np.float32]
T = TypeVar("T")
MODELS = Path(__file__).parents[2] / "shared/models"
SCENES = {
    "tree": None,
    "bunny": "scans/stanford_bunny.ply",
    "truck": "loader_originals/glb_material/CesiumMilkTruck.glb",
    "rocker arm": "mechanical/rocker_arm.ply",
    "lamp": "furniture_household/barn_lamp.ply",
    "house": "architecture/scene_house.ply",
    "gear": "mechanical/differential_ring_gear.ply",
}
SIZE = (288, 384)
SHARES = {1: 0.08, 2: 0.12, 4: 0.2, 8: 0.3, 16: 0.5}
"""Share of traced pixels, by number of paths per pixel of the picture."""

LIGHTS: dict[str, tuple[LightLike, int]] = {"sky": ([bob.Sky()], 1), "studio": ("studio", 2)}
"""Maximum number of surfaces on a path: 1 is ambient occlusion."""


def seen(
    scene: bob.Scene, camera: bob.Camera, light: str, paths: int, seed: int = 0, size: Size = SIZE, apart: bool = False
) -> LitTracer:
    """Return the tracer with `paths` paths per pixel."""
    lights, bounces = LIGHTS[light]
    return LitTracer(scene, camera, size, lights, paths=paths, bounces=bounces, seed=seed, apart=apart)


def shown(gray: F32) -> F32:
    """Encode as displayed, so that errors are perceptual."""
    displayed: F32 = np.clip(gray, 0, 1) ** np.float32(1 / 2.2)
    return displayed


def ours(scene: bob.Scene, camera: bob.Camera, light: str, paths: int, seed: int = 1) -> F32:
    """Trace a share of the pixels, and complete them along first hits."""
    share = SHARES[paths]
    part = traced_light(seen(scene, camera, light, round(paths / share), seed), share, "default", seed, None)
    return luminance(smoothed(part, complete_guided(part, "color"), guided_alpha(part))[0])


def whole(scene: bob.Scene, camera: bob.Camera, light: str, paths: int, seed: int = 1) -> GBuffer:
    """Trace all pixels, with paths over the whole area of each."""
    return traced_light(seen(scene, camera, light, paths, seed, apart=True), 1.0, "lattice", seed, None)


def along_guides(part: GBuffer) -> F32:
    """Denoise all pixels along their guides, by the fit that completes sparse ones."""
    return complete_guided(part, "gray")


def bilateral(part: GBuffer, reach: int = 6, sigmas: tuple[float, float, float] = (0.15, 0.01, 3.5)) -> F32:
    """Apply a plain cross-bilateral filter of 13 x 13 pixels, by normal, depth and distance."""
    guides = part.guides
    assert guides is not None
    gray, divisor = part.gray, np.maximum(luminance(guides.albedo), 0.02)
    light, (of_normal, of_depth, of_place) = gray / divisor, sigmas
    features = np.concatenate(
        [guides.normal / of_normal, guides.depth[..., None] / of_depth, guides.hit[..., None] / 0.3], -1
    )
    height, width = gray.shape
    pad = [(reach, reach), (reach, reach)]
    padded, lights, hits = np.pad(features, [*pad, (0, 0)]), np.pad(light, pad), np.pad(guides.hit, pad)
    total, weights = np.zeros_like(gray), np.zeros_like(gray)
    for down in range(2 * reach + 1):
        for right in range(2 * reach + 1):
            there = np.s_[down : down + height, right : right + width]
            apart = ((padded[there] - features) ** 2).sum(-1)
            far = ((down - reach) ** 2 + (right - reach) ** 2) / of_place**2
            weight = np.exp(-0.5 * (apart + far)) * (hits[there] > 0)
            total += weight * lights[there]
            weights += weight
    filtered: F32 = np.where(guides.hit > 0, total / np.maximum(weights, 1e-6), 0) * divisor
    return filtered


def denoised(part: GBuffer) -> F32:
    from bobrossnet.adapters import oidn

    return luminance(oidn.denoise(part))


def half_resolution(scene: bob.Scene, camera: bob.Camera, light: str, paths: int, seed: int = 1) -> F32:
    """Trace a quarter of the pixels with four times the paths, and upsample them along the same guides."""
    part = traced_light(
        seen(scene, camera, light, 4 * paths, seed, (SIZE[0] // 2, SIZE[1] // 2)), 1.0, "lattice", seed, None
    )
    fine = seen(scene, camera, light, 1, apart=True).guides()
    planes = np.zeros((part.layout.width, *SIZE), np.float32)
    planes[:, ::2, ::2] = part.planes
    return complete_guided(GBuffer.from_stack(planes, part.layout, fine, False), "gray")


def scores(image: F32, truth: F32) -> tuple[float, float]:
    a, b = shown(image).astype(np.float32), shown(truth).astype(np.float32)
    return bob.ssim(a, b), float(np.abs(a - b).mean())


def moving(names: list[str], size: Size = (480, 640), turn: float = 2, count: int = 16) -> None:
    """The time of the first picture of `progressive`; frames of `View` in an orbit, and the last one's error.

    Frames of .5 % of the pixels have the full size; those of 33 ms, the default, are as large as time allows."""
    print(f"640x480, the studio, {turn} degrees a frame; SSIM against 256 paths; medians in ms with the picture\n")
    columns = ["scene", "first picture, CPU", "frame of .5 %, CPU", "SSIM", "new paths alone"]
    columns += ["frame of 33 ms, CPU", "elapsed", "height", "SSIM"]
    print(f"| {' | '.join(columns)} |\n{'|---' * len(columns)}|")
    for name in names:
        scene = scene_of(name)
        camera = bob.fitted(scene, bob.Camera(), size=size, margin=0.13)
        ways = [replace(camera, azimuth=camera.azimuth + turn * i) for i in range(count)]
        lights = studio(ways[0])
        tracer = LitTracer(scene, ways[-1], size, lights, ground=True, paths=256, seed=99)
        part = traced_light(tracer, 1.0, "lattice", 99, None)
        truth = before_gray(picture_of(*smoothed(part, complete_guided(part, "color"), guided_alpha(part))))
        first = [timed(first_picture, scene, camera, size)[1] for _ in range(5)]
        cells = [f"{name} | {1000 * np.median(first):.0f}"]
        for share in (0.005, None):
            view = bob.View(scene, size=size, light=lights, ground=True)
            frames, cpu, elapsed = zip(*[timed(shown_frame, view, way, share) for way in ways], strict=True)
            frame = frames[-1]
            cells.append(f"{1000 * np.median(cpu[3:]):.0f}")
            if share is None:
                cells += [f"{1000 * np.median(elapsed[3:]):.0f}", str(frame.shown.size[0])]
            cells.append(f"{bob.ssim(before_gray(frame.picture()), truth):.3f}")
            if share is not None:
                alone = bob.View(scene, size=size, light=lights, ground=True).frame(ways[-1], fraction=share)
                cells.append(f"{bob.ssim(before_gray(alone.picture()), truth):.3f}")
        print(f"| {' | '.join(cells)} |", flush=True)


def first_picture(scene: bob.Scene, camera: bob.Camera, size: Size) -> NDArray[np.uint8]:
    return next(iter(bob.progressive(scene, camera, size=size, light="studio"))).picture().rgba


def shown_frame(view: bob.View, camera: bob.Camera, share: float | None) -> bob.Frame:
    frame = view.frame(camera, fraction=share)
    frame.picture().rgba  # noqa: B018
    return frame


def timed(work: Callable[..., T], *arguments: Any) -> tuple[T, float, float]:
    """Return the result, and processor and elapsed time in seconds."""
    cpu, start = time.process_time(), time.perf_counter()
    result = work(*arguments)
    return result, time.process_time() - cpu, time.perf_counter() - start


def before_gray(picture: bob.Picture) -> F32:
    rgba = picture.rgba.astype(np.float32) / 255
    return np.asarray(luminance(rgba[..., :3]) * rgba[..., 3] + 0.5 * (1 - rgba[..., 3]), np.float32)


def scene_of(name: str) -> bob.Scene:
    file = SCENES[name]
    return bob.Scene(bob.happy_tree() if file is None else bob.load(MODELS / file))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paths", type=int, nargs="+", default=[1, 2, 4, 16])
    parser.add_argument("--scenes", nargs="+", default=None)
    parser.add_argument("--lights", nargs="+", default=list(LIGHTS))
    parser.add_argument("--truth", type=int, default=512)
    parser.add_argument("--moving", action="store_true")
    options = parser.parse_args()
    if options.moving:
        return moving(options.scenes or ["gear", "bunny", "truck"])
    names = ["ours", "all + our fit", "all + OIDN", "all + bilateral", "half + our fit"]
    print("SSIM (mean absolute error in 1/255) as displays show it, 384x288\n")
    print("| light | scene | paths | " + " | ".join(names) + " |\n|---|---|---|" + "---|" * len(names))
    for light in options.lights:
        for name in options.scenes or [name for name in SCENES if name != "gear"]:
            scene = scene_of(name)
            camera = bob.fitted(scene, bob.Camera(), size=SIZE)
            camera = replace(camera, zoom=0.9 * camera.zoom)
            truth = whole(scene, camera, light, options.truth, seed=99).gray
            for paths in options.paths:
                part = whole(scene, camera, light, paths)
                images = [ours(scene, camera, light, paths), along_guides(part), denoised(part), bilateral(part)]
                images.append(half_resolution(scene, camera, light, paths))
                found = [scores(image, truth) for image in images]
                cells = " | ".join(f"{ssim:.3f} ({255 * error:.2f})" for ssim, error in found)
                print(f"| {light} | {name} | {paths} | {cells} |", flush=True)


if __name__ == "__main__":
    start = time.perf_counter()
    main()
    print(f"\n{time.perf_counter() - start:.0f} s")
