"""`bobrossnet render`: renders a picture of shapes."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bobrossnet.command_line import arguments
from bobrossnet.command_line.report import Report, add_report, plural
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import DEFAULT_ORDER, MAX_SEED, ORDERS, PRIORITY
from bobrossnet.pictures.drawing import SVG, svg_color
from bobrossnet.support.errors import InputError, check_choice
from bobrossnet.support.messages import counted

if TYPE_CHECKING:
    import bobrossnet as bob
    from bobrossnet.pictures.background import Background

FRACTION = 0.1
"""Default share of pixels for the built-in scene, and for panels with a reference."""

STEP = 0.01  # share of the pixels between two checks of the expected error
LARGE = 3840 * 2160
"""Number of pixels above which completion takes too long to repeat for timing."""


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    render = commands.add_parser(
        "render",
        help="make a picture of shapes",
        description="Make a picture of shapes. By default, pictures of files are exact and framed by the silhouette. "
        "With --fraction or --error, the bounding sphere is framed, some pixels are traced, and the others are "
        "completed; --panels compares these.",
    )
    render.set_defaults(run=run)
    arguments.add_files(render)
    arguments.add_size(render)
    amount = render.add_mutually_exclusive_group()
    arguments.add_fraction(amount, None, f"100%% for files, else and with --panels {100 * FRACTION:g}%%")
    amount.add_argument(
        "--error",
        type=arguments.positive,
        metavar="GRAY",
        help="trace until the predicted mean error is below this gray of 0 to 1, such as 0.002",
    )
    render.add_argument(
        "--order",
        type=arguments.checked("order", lambda text: check_choice("order", text, (*ORDERS, "default"))),
        default="default",
        metavar="ORDER",
        help=f"pixel order: {', '.join(ORDERS)} (default: {PRIORITY} from 512x512 pixels on, else {DEFAULT_ORDER})",
    )
    arguments.add_seed(render, "the order", MAX_SEED)
    arguments.add_orbit(render)
    arguments.add_zoom(render)
    for name, metavar, what in (
        ("pan", "X,Y", "moves the camera right and up, in radii of the bounding sphere"),
        ("position", "X,Y,Z", "with --fov: the camera's position in the shapes' units, instead of an orbit"),
        ("target", "X,Y,Z", "with --position: a point in the middle of the picture (default: the shapes' centre)"),
    ):
        default = getattr(Camera(), name)
        render.add_argument(f"--{name}", type=arguments.numbers, default=default, metavar=metavar, help=what)
    render.add_argument(
        "--fit",
        choices=("sphere", "silhouette"),
        help="framing: the bounding sphere, the same at any angle, or the visible silhouette, ignoring zoom and "
        "pan (default: silhouette for files; sphere with --fraction, --error, --zoom, --pan or --position)",
    )
    arguments.add_up(render)
    arguments.add_parts(render)
    arguments.add_model(render)
    render.add_argument(
        "-o",
        "--out",
        default="out.png",
        metavar="PICTURE",
        help="file to write, with --style lines also .svg; - writes a PNG to standard output (default: out.png)",
    )
    arguments.add_samples(
        render,
        None,
        "for exact pictures: maximum number of rays for a pixel at an edge, a square from 4 to 64; 1: one ray through "
        "each centre",
        "4",
    )
    arguments.add_background(
        render,
        None,
        "transparent, or #ffffff in formats without transparency",
    )
    arguments.add_light(render)
    render.add_argument(
        "--style",
        choices=("shaded", "lines"),
        default="shaded",
        help="lines draws only the edges, on white (default: shaded)",
    )
    arguments.add_edges(render)
    arguments.add_section(render)
    render.add_argument(
        "--panels", action="store_true", help="draw three pictures: traced pixels on green, completed, reference"
    )
    add_report(render)


def _settle(options: argparse.Namespace, is_seen: bool) -> None:
    """Choose the defaults that depend on other options."""
    from bobrossnet.picture.files import is_opaque
    from bobrossnet.support.errors import InputError

    is_whole = bool(options.files) and options.fraction is None and options.error is None and not options.panels
    is_lines = options.style == "lines"
    if is_lines and (options.fraction is not None or options.error is not None or not is_seen):
        raise InputError("--style lines: expected no --fraction, --error, --panels or .exr, since all lines are exact")
    if options.fraction is None:
        options.fraction = 1.0 if is_whole else FRACTION
    if options.samples is None:
        options.samples = 4 if is_seen else 1
    if options.fit is None:
        home = Camera()
        placed = any(getattr(options, name) != getattr(home, name) for name in ("zoom", "pan", "position"))
        options.fit = "silhouette" if is_whole and not placed else "sphere"
    if options.background is None and is_lines:
        options.background = "transparent" if Path(options.out).suffix.lower() == SVG else "#ffffff"
    elif options.background is None and is_seen:
        options.background = "#ffffff" if is_opaque(options.out) else "transparent"


def _camera(options: argparse.Namespace, scene: bob.Scene | None = None) -> Camera:
    """Return the camera of an orbit or, with --position, of a place."""
    if options.position is None and options.target is None:
        return arguments.camera_of(options, scene)
    angles = {name: getattr(options, name) for name in ("azimuth", "elevation") if getattr(options, name) is not None}
    if options.view is not None:
        raise InputError("--view: expected no --position or --target with it")
    held = {name: getattr(options, name) for name in ("roll", "zoom", "fov", "pan", "position", "target")}
    return Camera(**angles, **held)


def run(options: argparse.Namespace) -> None:
    """Render the picture, and print the sizes and times."""
    import bobrossnet as bob
    from bobrossnet.completion.complete import GUIDED
    from bobrossnet.completion.exr import channels_of
    from bobrossnet.completion.network import NetworkLike, load_network
    from bobrossnet.picture.exr import ENDING, openexr, write_exr
    from bobrossnet.picture.files import (
        FORMATS,
        check_sides,
        color_to_8_bit,
        side_by_side,
        traced_on_green,
    )
    from bobrossnet.pictures.fitting import fitted, margin_of
    from bobrossnet.pictures.rendering import check_picture, finished, traced_to_be_seen
    from bobrossnet.support.atomic import check_writable
    from bobrossnet.support.machine import limit_memory
    from bobrossnet.support.progress import progress
    from bobrossnet.tracing.light import check_light

    limit_memory()
    told = Report(options)
    is_lines = options.style == "lines"
    out = (
        Path(".png")
        if told.to_stdout
        else check_writable(options.out, "a picture", (*FORMATS, SVG if is_lines else ENDING))
    )
    if (kind := FORMATS.get(out.suffix.lower())) is not None:
        check_sides(out, kind, options.size)
    is_exr = out.suffix.lower() == ENDING
    is_seen = not options.panels and not is_exr
    _settle(options, is_seen)
    lines = arguments.edges(options, wanted=is_lines)
    if lines is not None and not is_seen:
        raise bob.InputError(
            "--edges: expected no --panels or .exr, which hold the pixels of the network and the tracer"
        )
    if is_exr and (options.panels or options.background is not None or options.samples > 1):
        raise bob.InputError(
            f"{out}: expected no --panels, --background or --samples, which change only display pictures"
        )
    if is_exr:
        openexr()  # its lack is said before any time is spent on the picture
    background = arguments.background(options.background)
    check_picture(options.samples, background, options.size)
    if out.suffix.lower() == SVG and background is not None:
        svg_color("background", background)
    camera = _camera(options)  # all are checked before the files are read
    light = check_light(options.light)
    model: NetworkLike = load_network(options.model)
    start = time.perf_counter()
    scene = arguments.scene_of(options)
    camera = _camera(options, scene)
    scene.core  # noqa: B018  built here, to exclude its time from the rays'
    if options.fit == "silhouette":
        camera = fitted(
            scene.sectioned(None), camera, size=options.size, margin=margin_of(scene, light, options.ground)
        )
    ready_ms = 1000 * (time.perf_counter() - start)
    height, width = options.size
    if is_lines:
        _draw_lines(options, told, scene, camera, lines, background)
        return

    view: dict[str, Any] = {"size": options.size, "order": options.order, "seed": options.seed}
    view |= {"light": light, "ground": options.ground}

    def timed_trace(what: str, fraction: float) -> tuple[bob.GBuffer, float]:
        start = time.perf_counter()
        with progress(what) as show:
            if is_seen:
                seen = {"samples": options.samples, **view}
                gbuffer = traced_to_be_seen(scene, camera, fraction=fraction, progress=show, **seen)
            else:
                gbuffer = bob.trace(scene, camera, fraction=fraction, progress=show, **view)
        return gbuffer, 1000 * (time.perf_counter() - start)

    if options.error is None:
        part, trace_ms = timed_trace("tracing", options.fraction)
    else:
        start = time.perf_counter()
        with progress("tracing") as show:
            for frame in bob.progressive(scene, camera, fraction=STEP, until=options.error, model=model, **view):
                show(frame.fraction)
        part, trace_ms = frame.gbuffer, 1000 * (time.perf_counter() - start)
    exact = part.fraction == 1
    model = model if part.guides is None else GUIDED
    if height * width <= LARGE and not exact:
        bob.complete(part, model=model)  # the first run allocates memory
    start = time.perf_counter()
    image = bob.complete(part, model=model)
    complete_ms = 1000 * (time.perf_counter() - start)

    rays = int(part.mask.sum())
    told.line(f"scene      {scene.describe()}, loaded and built in {ready_ms:.0f} ms")
    what = counted(rays, "ray") if part.guides is None else f"{rays:,} pixels' light and all first hits"
    told.line(f"traced     {100 * part.fraction:.4g} % of {width}x{height}: {what} in {trace_ms:.1f} ms")
    expected = f", expected error {frame.error:.2g} of gray 0..1" if options.error is not None else ""
    if not exact:
        told.line(f"completed  in {complete_ms:.1f} ms{expected}")
    if options.panels:
        full, full_ms = (part, trace_ms) if exact else timed_trace("tracing the reference", 1.0)
        quality = f"SSIM {bob.ssim(image, full.gray):.4f}" if min(options.size) >= 11 else "too small for SSIM"
        told.line(f"reference  {width * height:,} rays in {full_ms:.1f} ms; completed against it: {quality}")
        completed, reference = (color_to_8_bit(bob.complete(g, model, channel="color")) for g in (part, full))
        picture = side_by_side(
            [
                (
                    traced_on_green(part),
                    f"traced: {100 * part.fraction:.4g} %, {counted(rays, 'ray')}, {trace_ms:.1f} ms",
                ),
                (completed, f"completed: {complete_ms:.1f} ms, {quality}"),
                (reference, f"reference: {width * height:,} rays, {full_ms:.1f} ms"),
            ]
        )
    elif not is_exr:
        start = time.perf_counter()
        picture = finished(
            part,
            scene,
            camera,
            samples=options.samples,
            background=background,
            model=model,
            drawing=None if lines is None else bob.draw(scene, camera, size=options.size, edges=lines),
        ).rgba
        picture = picture if background is None else picture[..., :3]  # opaque
        if exact and options.samples > 1 and part.guides is None:
            told.line(f"edges      smoothed in {1000 * (time.perf_counter() - start):.1f} ms")
    if part.guides is None and any(isinstance(instance.material, bob.Glass) for instance in scene.instances):
        told.line("glass      is opaque under the headlight; --light studio shows through it")
    if scene.unresolved_rays:
        passed = counted(scene.unresolved_rays, "ray")
        told.line(f"unresolved {passed} passed places where a sheet thinner than 1e-6 could hide")
    if is_exr:
        write_exr(out, channels_of(part, image, model))
    name = out if is_exr else told.write(picture)
    told.line(f"wrote      {name}")
    told.fields |= {
        "picture": options.out,
        "size": [width, height],
        "scene": plural(scene.counts()),
        "fraction": part.fraction,
        "rays": rays,
        "unresolved_rays": scene.unresolved_rays,
        "expected_error": None if options.error is None else frame.error,
        "camera": told_camera(camera),
        "milliseconds": {"load": ready_ms, "trace": trace_ms, "complete": 0 if exact else complete_ms},
    }
    told.end()


def _draw_lines(
    options: argparse.Namespace,
    told: Report,
    scene: bob.Scene,
    camera: Camera,
    lines: bob.Edges | None,
    background: Background,
) -> None:
    """Write a line drawing, and print its numbers."""
    import bobrossnet as bob
    from bobrossnet.support.atomic import write_whole

    start = time.perf_counter()
    drawing = bob.draw(scene, camera, size=options.size, edges=lines)
    milliseconds = 1000 * (time.perf_counter() - start)
    counts = {"visible": len(drawing.visible), "hidden": len(drawing.hidden)}
    told.line(f"scene      {scene.describe()}")
    told.line(f"drawn      {counts['visible']:,} visible curves, {counts['hidden']:,} hidden in {milliseconds:.1f} ms")
    if Path(options.out).suffix.lower() == SVG:
        write_whole(options.out, drawing.svg(background).encode())
        name = options.out
    else:
        rgba = drawing.picture(background).rgba
        name = told.write(rgba if background is None else rgba[..., :3])
    told.line(f"wrote      {name}")
    told.fields |= {
        "picture": options.out,
        "size": list(options.size[::-1]),
        "scene": plural(scene.counts()),
        "curves": counts,
        "camera": told_camera(camera),
        "milliseconds": {"draw": milliseconds},
    }
    told.end()


def told_camera(camera: Camera) -> dict[str, Any]:
    """Return a camera as a dictionary for JSON."""
    names = ("azimuth", "elevation", "roll", "zoom", "fov", "pan", "position", "target")
    return {name: getattr(camera, name) for name in names}
