"""`bobrossnet render`: a picture of shapes."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Any

from bobrossnet import arguments
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import DEFAULT_ORDER, ORDERS

if TYPE_CHECKING:
    import bobrossnet as bob

STEP = 0.01  # of the pixels: after each the expected error is looked at
LARGE = 3840 * 2160
"""Pixels from which on completing is no matter of milliseconds, and is not done twice to be timed."""


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    render = commands.add_parser("render", help="make a picture of shapes", description="Make a picture of shapes.")
    render.set_defaults(run=run)
    arguments.add_files(render)
    arguments.add_size(render)
    amount = render.add_mutually_exclusive_group()
    arguments.add_fraction(amount, 0.1)
    amount.add_argument(
        "--error",
        type=arguments.positive,
        metavar="GRAY",
        help="trace as many pixels instead as it takes to expect this mean error, in gray of 0 to 1, such as 0.002",
    )
    render.add_argument(
        "--order",
        default="default",
        help=f"sequence of the pixels, one of {', '.join(ORDERS)} (default: {DEFAULT_ORDER})",
    )
    render.add_argument("--seed", type=int, default=0, help="of the order (default: 0)")
    arguments.add_orbit(render)
    arguments.add_zoom(render)
    for name, metavar, what in (
        ("pan", "X,Y", "moves the camera right and up, in radii of the bounding sphere"),
        ("position", "X,Y,Z", "with --fov: where the camera stands, in the shapes' units, instead of an orbit"),
        ("target", "X,Y,Z", "with --position: where it looks (default: the centre of the shapes)"),
    ):
        default = getattr(Camera(), name)
        render.add_argument(f"--{name}", type=arguments.numbers, default=default, metavar=metavar, help=what)
    render.add_argument(
        "--fit",
        choices=("sphere", "silhouette"),
        default="sphere",
        help="what fills the picture: the bounding sphere, at any angle the same, or what is seen, whatever the zoom "
        "and pan (default: sphere)",
    )
    arguments.add_up(render)
    arguments.add_model(render)
    render.add_argument("-o", "--out", default="out.png", metavar="PICTURE", help="default: out.png")
    arguments.add_samples(
        render,
        1,
        "with --fraction 100%%: rays at most for each pixel along edges, 4 or 16; 1 goes through pixels' centres",
    )
    arguments.add_background(render, arguments.BLACK)
    render.add_argument("--panels", action="store_true", help="traced pixels on green | completed | reference")


def run(options: argparse.Namespace) -> None:
    """Make the picture, and print what was done in what time."""
    import bobrossnet as bob
    from bobrossnet.atomic import check_writable
    from bobrossnet.completion.exr import channels_of
    from bobrossnet.completion.network import load_network
    from bobrossnet.fitting import fitted
    from bobrossnet.machine import limit_memory
    from bobrossnet.picture.exr import ENDING, write_exr
    from bobrossnet.picture.files import (
        FORMATS,
        color_to_8_bit,
        side_by_side,
        to_8_bit,
        traced_on_green,
        write_picture,
    )
    from bobrossnet.progress import progress
    from bobrossnet.rendering import check_picture, finished

    limit_memory()
    out = check_writable(options.out, "a picture", (*FORMATS, ENDING))
    if out.suffix.lower() == ENDING and (options.panels or options.background is not None or options.samples > 1):
        raise bob.InputError(
            f"{out}: expected no --panels, --background or --samples, which are for pictures to look at"
        )
    background = arguments.background(options.background)
    check_picture(options.samples, background)
    orbit = options.azimuth, options.elevation, options.roll, options.zoom
    place = {"position": options.position, "target": options.target}
    camera = bob.Camera(*orbit, fov=options.fov, pan=options.pan, **place)
    model = load_network(options.model)
    start = time.perf_counter()
    scene = arguments.scene_of(options)
    scene.core  # noqa: B018  built here, so that its time is not taken for the rays'
    if options.fit == "silhouette":
        camera = fitted(scene, camera, size=options.size)
    ready_ms = 1000 * (time.perf_counter() - start)
    height, width = options.size

    view: dict[str, Any] = {"size": options.size, "order": options.order, "seed": options.seed}

    def timed_trace(what: str, fraction: float) -> tuple[bob.GBuffer, float]:
        start = time.perf_counter()
        with progress(what) as report:
            gbuffer = bob.trace(scene, camera, fraction=fraction, progress=report, **view)
        return gbuffer, 1000 * (time.perf_counter() - start)

    if options.error is None:
        part, trace_ms = timed_trace("tracing", options.fraction)
    else:
        start = time.perf_counter()
        with progress("tracing") as report:
            for frame in bob.progressive(scene, camera, fraction=STEP, until=options.error, model=model, **view):
                report(frame.fraction)
        part, trace_ms = frame.gbuffer, 1000 * (time.perf_counter() - start)
    if height * width <= LARGE:
        bob.complete(part, model=model)  # the first run fetches memory
    start = time.perf_counter()
    image = bob.complete(part, model=model)
    complete_ms = 1000 * (time.perf_counter() - start)

    rays = int(part.mask.sum())
    print(f"scene      {scene.describe()}, loaded and built in {ready_ms:.0f} ms")
    print(f"traced     {100 * part.fraction:.4g} % of {width}x{height}: {rays:,} rays in {trace_ms:.1f} ms")
    expected = f", expected error {frame.error:.2g} of gray 0..1" if options.error is not None else ""
    print(f"completed  in {complete_ms:.1f} ms{expected}")
    if options.panels:
        whole = part.fraction == 1
        full, full_ms = (part, trace_ms) if whole else timed_trace("tracing the reference", 1.0)
        quality = f"SSIM {bob.ssim(image, full.gray):.4f}" if min(options.size) >= 11 else "too small for SSIM"
        print(f"reference  {width * height:,} rays in {full_ms:.1f} ms; completed against it: {quality}")
        completed, exact = to_8_bit(image), to_8_bit(full.gray)
        if scene.is_colored:
            completed, exact = (color_to_8_bit(bob.complete(g, model, channel="color")) for g in (part, full))
        picture = side_by_side(
            [
                (traced_on_green(part), f"traced: {100 * part.fraction:.4g} %, {rays:,} rays, {trace_ms:.1f} ms"),
                (completed, f"completed: {complete_ms:.1f} ms, {quality}"),
                (exact, f"reference: {width * height:,} rays, {full_ms:.1f} ms"),
            ]
        )
    elif scene.is_colored or options.background is not None or options.samples > 1:
        picture = finished(part, scene, camera, samples=options.samples, background=background, model=model).rgba
        picture = picture if background is None else picture[..., :3]
    else:
        picture = to_8_bit(image)
    if scene.unresolved_rays:
        print(f"unresolved {scene.unresolved_rays:,} rays passed places where a sheet thinner than 1e-6 could hide")
    if out.suffix.lower() == ENDING:
        write_exr(out, channels_of(part, image, model))
    else:
        write_picture(out, picture)
    print(f"wrote      {out}")
