"""One run on a GPU: the ceiling of learning, and better weights of the default network.

Processes make whole views of the package's own shapes, 256x256, with the places of their pixels in the adaptive order;
meanwhile several networks learn from them on the GPU, all from the same mini-batches. Scores are of held-out own shapes
and of real ones, which nothing learns from.

    python run.py --out OUT --until SECONDS --start UNIX_TIME [--views N] [--batch N] [--workers N] [--refs FILE]
"""

from __future__ import annotations

import argparse
import mmap
import multiprocessing
import os
import sys
import time
import traceback
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"  # of each process

import numpy as np  # noqa: E402

HERE = Path(__file__).parent
SIZE = 256
PLANES = 5  # gray, depth, normal x, normal y as float16; place in the adaptive order as uint16
BEFORE = int(os.environ.get("BEFORE", 500))  # shapes to learn from before those
HELD_OUT = 96  # own shapes that nothing learns from
FIRST_HELD_OUT = 4_000_000_000
FIRST = 3_000_000_000  # seeds of the shapes to learn from: of no data set of a seed below 3,000
SETTINGS = (
    ("adaptive", 0.01), ("adaptive", 0.02), ("adaptive", 0.05), ("adaptive", 0.10), ("adaptive", 0.25),
    ("lattice", 0.02), ("lattice", 0.10), ("uniform", 0.02), ("uniform", 0.10),
)  # fmt: skip

# ---- making views, in processes without torch -----------------------------------------------------------------------


def make_views(held_out, real, real_scores, views, done, scores, next_shape, next_slot, until):
    """Make views of one shape after the other until there is no place or time left."""
    import warnings

    warnings.simplefilter("ignore")
    os.nice(2)
    import bobrossnet as bob
    from bobrossnet import _core
    from bobrossnet.completion.filling import delaunay_linear
    from bobrossnet.learn.shapes import procedural_scene
    from bobrossnet.learn.shapes.colors import colored_scene
    from bobrossnet.metrics import ssim
    from bobrossnet.picture.gbuffer import GBuffer
    from bobrossnet.picture.sequence import places_in_sequence

    _core.set_thread_count(1)

    def view(scene, camera, size, seed):
        full = bob.trace(scene, camera, size=(size, size))
        places = places_in_sequence(full.planes, full.layout, "adaptive", seed)
        planes = np.concatenate([full.gray[None], full.depth[None], np.moveaxis(np.asarray(full.normal), -1, 0)])
        bits = np.empty((PLANES, size, size), np.uint16)
        bits[:4] = planes.astype(np.float16).view(np.uint16)
        bits[4] = places // (size * size // SIZE**2)  # as shares of 65,536
        return bits

    def put(slot, bits):
        views[slot] = bits
        done[slot] = 1

    while time.time() < until:
        with next_shape.get_lock():
            shape = next_shape.value
            next_shape.value += 1
        try:
            # First some views to learn from, then what scores need.
            if 0 <= (test := shape - BEFORE) < held_out:
                scene = procedural_scene(FIRST_HELD_OUT + test)
                camera = bob.Camera(azimuth=30 * test % 360, elevation=(20, 45)[test % 2])
                bits = view(scene, camera, SIZE, test)
                gray = bits[0].view(np.float16).astype(np.float32)
                for i, (order, share) in enumerate(SETTINGS):
                    if order == "adaptive":
                        mask = bits[4] < round(share * SIZE**2)
                        scores[test, i] = ssim(delaunay_linear(gray * mask, mask.astype(np.float32)), gray)
                put(test, bits)
                continue
            if 0 <= (number := test - held_out) < len(real_scores):
                planes, places = real[0][number].astype(np.float32), real[1][number]
                whole = GBuffer.from_stack(np.concatenate([np.ones_like(planes[:1]), planes]))
                for i, (order, share) in enumerate(SETTINGS):
                    if order == "adaptive":
                        part = GBuffer.from_stack(whole.planes * (places < round(share * SIZE**2)))
                        real_scores[number, i, 0] = ssim(delaunay_linear(part.gray, part.mask), whole.gray)
                    else:
                        part = whole.sample(share, order=order, seed=number)
                    real_scores[number, i, 1] = ssim(bob.complete(part, model="filling"), whole.gray)
                    real_scores[number, i, 2] = ssim(bob.complete(part), whole.gray)
                continue
            rng = np.random.default_rng([7, shape])
            scene = (colored_scene if rng.random() < 0.33 else procedural_scene)(FIRST + shape)
            for k in range(3):
                camera = bob.Camera(
                    azimuth=rng.uniform(0, 360),
                    elevation=float(np.degrees(np.arcsin(rng.uniform(-0.5, 1)))),
                    roll=rng.normal(0, 10),
                    fov=rng.uniform(20, 70) if rng.random() < 0.25 else 0,
                )
                large = k == 0 and rng.random() < 0.3  # quarters of a view of twice the size
                bits = view(scene, camera, SIZE * (2 if large else 1), shape)
                parts = [
                    bits[:, y : y + SIZE, x : x + SIZE]
                    for y in range(0, bits.shape[1], SIZE)
                    for x in range(0, bits.shape[2], SIZE)
                ]
                for part in parts:
                    if part[0].view(np.float16).std() < 0.02:  # next to nothing to learn
                        continue
                    with next_slot.get_lock():
                        slot = next_slot.value
                        next_slot.value += 1
                    if slot >= len(views):
                        return
                    put(slot, part)
        except Exception:
            traceback.print_exc(limit=3)


# ---- main -----------------------------------------------------------------------------------------------------------


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--until", type=float, required=True, help="seconds after --start at which all is over")
    parser.add_argument("--start", type=float, default=time.time())
    parser.add_argument("--views", type=int, default=36000)
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--workers", type=int, default=14)
    parser.add_argument("--validate-every", type=float, default=80)
    parser.add_argument("--finish", type=float, default=14, help="seconds kept for the last scores")
    parser.add_argument("--least", type=int, default=2000, help="views to begin with")
    parser.add_argument("--refs", type=Path, help="G-buffers to score, .npz; none if omitted")
    parser.add_argument("--limit-refs", type=int, default=1000)
    parser.add_argument("--held-out", type=int, default=HELD_OUT)
    parser.add_argument("--wide", default="32,48,64,64,64,64")
    parser.add_argument("--teacher", default="32,64,96,128,160")
    options = parser.parse_args()
    deadline = options.start + options.until
    options.out.mkdir(parents=True, exist_ok=True)

    # Processes begin before torch does: they are forked.
    for slots in (options.views, options.views // 2, options.views // 4):
        try:
            memory = mmap.mmap(-1, slots * PLANES * SIZE * SIZE * 2)
            break
        except OSError:
            traceback.print_exc(limit=1)
    views = np.frombuffer(memory, np.uint16).reshape(slots, PLANES, SIZE, SIZE)
    flags = mmap.mmap(-1, slots)
    done = np.frombuffer(flags, np.uint8)
    kept = mmap.mmap(-1, HELD_OUT * len(SETTINGS) * 8)
    delaunay = np.frombuffer(kept, np.float64).reshape(HELD_OUT, len(SETTINGS))
    context = multiprocessing.get_context("fork")
    next_shape, next_slot = context.Value("q", 0), context.Value("q", HELD_OUT)
    if options.refs:
        refs = np.load(options.refs)
        real = refs["views"][: options.limit_refs], refs["places"][: options.limit_refs]
    else:
        real = np.zeros((0, 4, SIZE, SIZE), np.float16), np.zeros((0, SIZE, SIZE), np.uint16)
    kept_too = mmap.mmap(-1, max(len(real[0]) * len(SETTINGS) * 3 * 8, 8))
    real_scores = np.frombuffer(kept_too, np.float64, len(real[0]) * len(SETTINGS) * 3).reshape(-1, len(SETTINGS), 3)
    arguments = (options.held_out, real, real_scores, views, done, delaunay, next_shape, next_slot, deadline - 60)
    workers = [context.Process(target=make_views, args=arguments, daemon=True) for _ in range(options.workers)]
    for worker in workers:
        worker.start()
    try:
        from learning import learn  # torch

        learn(options, deadline, views, done, delaunay, real, real_scores)
    finally:
        for worker in workers:
            worker.terminate()


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
