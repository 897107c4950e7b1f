"""`bobrossnet orbit`: renders a film of one turn around shapes."""

from __future__ import annotations

import argparse
import time
from typing import Any

from bobrossnet.command_line import arguments
from bobrossnet.pictures.filming import FPS, MAX_FRAMES


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    orbit = commands.add_parser(
        "orbit",
        help="make a film of one turn around shapes",
        description="Make a film of one turn around shapes.",
    )
    orbit.set_defaults(run=run)
    arguments.add_files(orbit)
    arguments.add_size(orbit)
    arguments.add_fraction(orbit, 1.0)
    orbit.add_argument(
        "--frames",
        type=arguments.integer(1, MAX_FRAMES),
        default=75,
        metavar="N",
        help="pictures of the turn (default: 75)",
    )
    orbit.add_argument("--fps", type=arguments.number(*FPS), default=25.0, help="pictures a second (default: 25)")
    arguments.add_orbit(orbit)
    arguments.add_zoom(orbit)
    arguments.add_up(orbit)
    arguments.add_parts(orbit)
    arguments.add_model(orbit)
    orbit.add_argument(
        "-o", "--out", default="out.webp", metavar="FILM", help=".webp, .png, .gif, .avif or .mp4 (default: out.webp)"
    )
    arguments.add_samples(
        orbit, 4, "with --fraction 100%%: maximum number of rays for a pixel at an edge, as in render"
    )
    arguments.add_background(orbit, "#ffffff")
    arguments.add_light(orbit)
    arguments.add_edges(orbit)
    arguments.add_section(orbit)
    arguments.add_scheduler(orbit)


def run(options: argparse.Namespace) -> None:
    """Render the film, and print the sizes and times."""
    import bobrossnet as bob
    from bobrossnet.completion.network import NetworkLike, load_network
    from bobrossnet.pictures.filming import check_film_path
    from bobrossnet.support.cluster import check_scheduler
    from bobrossnet.support.machine import limit_memory
    from bobrossnet.support.progress import progress
    from bobrossnet.tracing.light import check_light

    limit_memory()
    # All arguments are checked before the files are read.
    out = check_film_path(options.out, options.size)
    arguments.camera_of(options)
    light = check_light(options.light)
    model: NetworkLike = load_network(options.model)
    if options.scheduler is not None:
        model = options.model  # the workers load it themselves
        check_scheduler(options.scheduler)
    scene = arguments.scene_of(options)
    camera = arguments.camera_of(options, scene)
    film = bob.orbit(
        scene,
        camera,
        frames=options.frames,
        size=options.size,
        samples=options.samples,
        background=arguments.background(options.background),
        fraction=options.fraction,
        model=model,
        light=light,
        ground=options.ground,
        edges=arguments.edges(options) or False,
        scheduler=options.scheduler,
    )
    start = time.perf_counter()
    with progress("turning") as report:
        film.save(out, fps=options.fps, progress=report)
    seconds = time.perf_counter() - start
    print(f"wrote {out}: {film!r} of {scene.describe()}, {len(film) / options.fps:.3g} s long, in {seconds:.1f} s")
