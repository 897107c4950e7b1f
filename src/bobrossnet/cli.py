"""The command line: `bobrossnet render | view | mesh | pack | info`, and those of learn/commands.py.

Nothing slow is imported up here, so that --help and mistakes are answered at once.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import json
import os
import signal
import sys
import time
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn
from urllib.parse import quote

from bobrossnet import __version__, arguments, starting
from bobrossnet.adapters.files import KINDS
from bobrossnet.arguments import with_lists_joined
from bobrossnet.learn.commands import add_commands
from bobrossnet.machine import limit_memory
from bobrossnet.picture.camera import Camera
from bobrossnet.picture.order import DEFAULT_ORDER, ORDERS
from bobrossnet.shapes.mesh import FORMATS as MESH_FORMATS

if TYPE_CHECKING:
    import bobrossnet as bob

USAGE_ERROR = 2

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What writing fails with where there is no more space."""

STEP = 0.01  # of the pixels: after each the expected error is looked at
LARGE = 3840 * 2160
"""Pixels from which on completing is no matter of milliseconds, and is not done twice to be timed."""

FILES = "; ".join(
    [*(f"{kind}, {' '.join(endings)}" for kind, endings in KINDS.items()), "by default the built-in scene"]
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status: 0, 2 after an error of one line on stderr, 130 after Ctrl-C."""
    from bobrossnet.errors import InputError

    try:
        starting.done()
        for sent in (signal.SIGTERM, signal.SIGHUP):  # so that files in the making are cleaned up
            if signal.getsignal(sent) != signal.SIG_IGN:  # which nohup sets
                signal.signal(sent, _terminate)
        _run(arguments)
        return 0
    except (InputError, _UsageError) as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("not enough memory for a picture or a shape of this size")
    except ModuleNotFoundError as error:
        return _fail(f"this command needs {error.name}: pip install 'bobrossnet[train]'")
    except BrokenPipeError:
        _discard_output()  # the reader is gone
        return 0
    except OSError as error:
        if error.errno not in FULL:
            raise
        try:
            _flush_output()
        except OSError:
            _discard_output()
        return _fail(f"can't write {error.filename or 'the output'}: {error.strerror}")
    except KeyboardInterrupt as interrupt:
        with contextlib.suppress(OSError):  # of a terminal that was closed
            print(": ".join(["bobrossnet: interrupted", *map(str, interrupt.args)]), file=sys.stderr)
        return starting.INTERRUPTED


def _run(arguments: Sequence[str] | None) -> None:
    from bobrossnet.errors import InputWarning

    try:
        options = _parser().parse_args(with_lists_joined(sys.argv[1:] if arguments is None else arguments))
        with warnings.catch_warnings():
            warnings.simplefilter("always", InputWarning)
            warnings.showwarning = _print_warning
            options.run(options)
    except SystemExit:  # after --help and --version
        _flush_output()
        raise
    _flush_output()


def _flush_output() -> None:
    """Write what was printed while an error can still be told."""
    if sys.stdout is not None:  # as it is where it was closed
        sys.stdout.flush()


def _discard_output() -> None:
    """Let nothing more be written to stdout, which Python would try as it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _UsageError(Exception):
    """argparse's errors, in one line instead of its usage text."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise _UsageError(f"{message} (see {self.prog} --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="bobrossnet", description="Trace a few percent of the pixels, see the whole picture.")
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)

    render = commands.add_parser("render", help="make a picture of shapes", description="Make a picture of shapes.")
    render.set_defaults(run=_render)
    render.add_argument("files", nargs="*", metavar="FILE", help=FILES)
    render.add_argument(
        "--size", type=arguments.size, default=(480, 640), metavar="WIDTHxHEIGHT", help="default: 640x480"
    )
    amount = render.add_mutually_exclusive_group()
    amount.add_argument(
        "--fraction",
        type=arguments.fraction,
        default=0.1,
        metavar="PERCENT",
        help="share of the pixels to trace, 5%% or 0.05; 100%% is the exact picture (default: 10%%)",
    )
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
    home = Camera()
    for name, angle in (("azimuth", home.azimuth), ("elevation", home.elevation), ("roll", home.roll)):
        render.add_argument(f"--{name}", type=float, default=angle, metavar="DEGREES", help=f"default: {angle:g}")
    render.add_argument(
        "--zoom", type=float, default=home.zoom, help=f"1 fits the bounding sphere (default: {home.zoom:g})"
    )
    render.add_argument(
        "--fov",
        type=float,
        default=home.fov,
        metavar="DEGREES",
        help="perspective: the angle of the picture's height, such as 35 (default: 0, orthographic)",
    )
    for name, metavar, what in (
        ("pan", "X,Y", "moves the camera right and up, in radii of the bounding sphere"),
        ("position", "X,Y,Z", "with --fov: where the camera stands, in the shapes' units, instead of an orbit"),
        ("target", "X,Y,Z", "with --position: where it looks (default: the centre of the shapes)"),
    ):
        default = getattr(home, name)
        render.add_argument(f"--{name}", type=arguments.numbers, default=default, metavar=metavar, help=what)
    arguments.add_up(render)
    render.add_argument("--model", default="default", help="name of shipped weights or a .safetensors file")
    render.add_argument("-o", "--out", default="out.png", metavar="PICTURE", help="default: out.png")
    render.add_argument(
        "--samples",
        type=int,
        default=1,
        metavar="N",
        help="with --fraction 100%%: rays at most for each pixel along edges, 4 or 16 (default: 1, pixels' centres)",
    )
    render.add_argument(
        "--background",
        metavar="COLOR",
        help="transparent, or a color such as #ffffff, or two for top and bottom: #ffffff,#99bbdd (default: #000000)",
    )
    render.add_argument("--panels", action="store_true", help="traced pixels on green | completed | reference")

    view = commands.add_parser(
        "view",
        help="show shapes in a browser",
        description="Show shapes in a page where they can be turned; only browsers on this machine can reach it.",
    )
    view.set_defaults(run=_view)
    view.add_argument("files", nargs="*", metavar="FILE", help=FILES)
    view.add_argument("--port", type=int, default=0, help="of the page; 0 takes a free one (default: 0)")
    view.add_argument("--no-browser", action="store_true", help="only print the page's address")
    arguments.add_up(view)
    view.add_argument("--export", metavar="DIR", help="write the page to a folder for any web server, and show nothing")

    mesh = commands.add_parser(
        "mesh",
        help="write shapes as triangles",
        description="Write shapes as triangles, for printers and other programs.",
    )
    mesh.set_defaults(run=_mesh)
    mesh.add_argument("files", nargs="*", metavar="FILE", help=FILES)
    mesh.add_argument(
        "--step",
        type=arguments.positive,
        metavar="LENGTH",
        help="how long their sides are, in the files' unit (default: 1/128 of each shape's longest side)",
    )
    arguments.add_up(mesh)
    endings = ", ".join(MESH_FORMATS)
    mesh.add_argument("-o", "--out", default="out.stl", metavar="MESH", help=f"{endings} (default: out.stl)")

    pack = commands.add_parser("pack", help="write a scene of shapes", description="Write shapes to one scene file.")
    pack.set_defaults(run=_pack)
    pack.add_argument("scene", metavar="SCENE.bob", help="the file to write")
    pack.add_argument("files", nargs="*", metavar="FILE", help=FILES)
    arguments.add_up(pack)

    info = commands.add_parser(
        "info",
        help="tell what is in a shape file, a scene, a weight file or a training's folder",
        description="Tell what is in a shape file, a scene, a weight file or a training's folder.",
    )
    info.set_defaults(run=_info)
    info.add_argument(
        "file",
        metavar="FILE",
        help="shapes, a scene, a .safetensors file, the name of shipped weights, or a folder",
    )

    add_commands(commands)
    return parser


def _render(options: argparse.Namespace) -> None:
    import bobrossnet as bob
    from bobrossnet.completion.network import load_network
    from bobrossnet.picture.files import (
        check_picture_path,
        color_to_8_bit,
        side_by_side,
        to_8_bit,
        traced_on_green,
        write_picture,
    )
    from bobrossnet.progress import progress
    from bobrossnet.rendering import check_picture, finished

    limit_memory()
    out = check_picture_path(options.out)
    background = arguments.background(options.background)
    check_picture(options.samples, background)
    orbit = options.azimuth, options.elevation, options.roll, options.zoom
    place = {"position": options.position, "target": options.target}
    camera = bob.Camera(*orbit, fov=options.fov, pan=options.pan, **place)
    model = load_network(options.model)
    start = time.perf_counter()
    scene = _scene(options)
    scene.core  # noqa: B018  built here, so that its time is not taken for the rays'
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
    write_picture(out, picture)
    print(f"wrote      {out}")


def _scene(options: argparse.Namespace) -> bob.Scene:
    """The scene of the files that were named, turned as was asked for."""
    import bobrossnet as bob

    files = options.files
    scene = bob.load(files) if files else bob.Scene(bob.Instance(bob.happy_tree(), name="happy tree"))
    return scene.turned_upright() if options.up == "y" else scene


def _view(options: argparse.Namespace) -> None:
    import threading
    import webbrowser

    from bobrossnet.view import Server, export, page_files, scene_path

    limit_memory()
    files = options.files
    name = Path(files[0]).stem if len(files) == 1 else "scene"
    with page_files(_scene(options) if files else None, name) as page:
        if options.export is not None:
            export(page, Path(options.export))
            print(f"wrote {options.export}: {len(page)} files, which any web server can show")
            return
        with Server(page, options.port) as server:
            url = server.url + (f"?scene={quote(scene_path(name))}" if files else "")
            print(f"{url}  (Ctrl-C ends it)", flush=True)
            if not options.no_browser:
                # Browsers in a terminal only return when they are left.
                threading.Thread(target=webbrowser.open, args=[url], daemon=True).start()
            with contextlib.suppress(KeyboardInterrupt):  # how it ends
                server.serve_forever()


def _mesh(options: argparse.Namespace) -> None:
    from bobrossnet.shapes.mesh import check_mesh_path

    limit_memory()
    out = check_mesh_path(options.out)
    scene = _scene(options)
    start = time.perf_counter()
    mesh = scene.mesh(options.step)
    seconds = time.perf_counter() - start
    mesh.save(out)
    print(f"wrote {out}: {len(mesh.triangles):,} triangles of {scene.describe()}, made in {seconds:.1f} s")


def _pack(options: argparse.Namespace) -> None:
    import bobrossnet as bob
    from bobrossnet.adapters.container import check_scene_path

    limit_memory()
    out = check_scene_path(options.scene)
    scene = _scene(options)
    bob.save_scene(scene, out)
    print(f"wrote {out}: {scene.describe()}")


def _info(options: argparse.Namespace) -> None:
    import bobrossnet as bob
    from bobrossnet.completion.network import find_weights
    from bobrossnet.completion.weights import read_weights

    limit_memory()
    configuration = Path(options.file) / "config.json"
    if configuration.is_file():
        _print_configuration(_read_configuration(configuration))
        return
    weights = find_weights(options.file)
    if weights is not None:
        metadata, tensors = read_weights(weights)
        training = metadata.pop("training", "{}")
        _print_table({"file": weights, **metadata, "parameters": f"{sum(t.size for t in tensors.values()):,}"})
        _print_table({name: f"{tensor.shape}" for name, tensor in sorted(tensors.items())}, indent="  ")
        _print_configuration({"training": json.loads(training)})
        return
    scene = bob.load(options.file)
    _print_table(
        {
            "file": options.file,
            "scene": scene.describe(),
            "sphere": f"{_vector(scene.center)}, radius {scene.radius:.6g}",
        }
    )
    for instance, (low, high) in zip(scene.instances, scene.boxes, strict=True):
        print()
        _print_table(
            {
                "shape": instance.shape.kind + (f", {instance.name!r}" if instance.name else ""),
                **instance.shape.describe(),
                "bounds": f"{_vector(low)} .. {_vector(high)}",
                "material": _material(instance.material),
            },
            indent="  ",
        )


def _material(material: bob.Material) -> str:
    names = ("ambient", "diffuse", "specular", "shininess") if material.roughness is None else ("metallic", "roughness")
    numbers = ", ".join(f"{name} {getattr(material, name):.6g}" for name in names)
    emissive = f", emissive {_vector(material.emissive)}" if any(material.emissive) else ""
    return f"linear RGB {_vector(material.color)}, {numbers}{emissive}"


def _read_configuration(path: Path) -> dict[str, dict[str, Any]]:
    """What a training run wrote about itself."""
    from bobrossnet.errors import InputError

    try:
        parts = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: expected a training's configuration, can't read it: {error}") from error
    if not (isinstance(parts, dict) and all(isinstance(fields, dict) for fields in parts.values())):
        raise InputError(f"{path}: expected a training's configuration, got other JSON")
    return parts


def _print_configuration(parts: dict[str, dict[str, Any]]) -> None:
    for name, fields in parts.items():
        if fields:
            print(name)
            _print_table(fields, indent="  ")


def _vector(numbers: Iterable[float]) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in numbers) + ")"


def _print_table(rows: dict[str, Any], indent: str = "") -> None:
    width = max(map(len, rows), default=0)
    for name, value in rows.items():
        print(f"{indent}{name:{width}}  {value}")


def _print_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    print(f"bobrossnet: warning: {message}", file=sys.stderr)


def _fail(message: str) -> int:
    print(f"bobrossnet: error: {' '.join(message.split())}", file=sys.stderr)
    return USAGE_ERROR


def _terminate(*_: Any) -> NoReturn:
    """As Ctrl-C; what follows, as the second SIGHUP of a closed terminal, must not stop the cleaning up."""
    for sent in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(sent, signal.SIG_IGN)
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
