"""Arguments shared by the commands, for argparse."""

from __future__ import annotations

import argparse
import math
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from bobrossnet.adapters.files import ALL_ENDINGS, KINDS, UPS
from bobrossnet.picture.camera import FRONT, VIEWS, Camera, as_camera
from bobrossnet.picture.order import check_size
from bobrossnet.picture.samples import grid_side
from bobrossnet.pictures.background import BLACK, background_rows
from bobrossnet.pictures.drawing import Edges
from bobrossnet.support.cluster import check_address
from bobrossnet.support.errors import InputError, brief, check_choice, check_integer, check_number
from bobrossnet.tracing.scene import Scene
from bobrossnet.tracing.section import Section, check_sections

FILES = "; ".join(
    [*(f"{kind}, {' '.join(endings)}" for kind, endings in KINDS.items()), "by default the built-in scene"]
)

Value = TypeVar("Value")


def checked(name: str, check: Callable[[str], Value]) -> Callable[[str], Value]:
    """Return an argparse type from a check of the library: errors start with the option instead of `name`."""

    def parsed(text: str) -> Value:
        try:
            return check(text)
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error).removeprefix(f"{name}: ")) from None

    return parsed


def integer(low: int, high: int) -> Callable[[str], int]:
    """Return an argparse type of integers in [low, high]."""
    return checked("number", lambda text: check_integer("number", _number(int, text), low, high))


def number(low: float, high: float = math.inf, *, above: bool = False) -> Callable[[str], float]:
    """Return an argparse type of numbers in [low, high], or (low, high] if `above`."""
    return checked("number", lambda text: check_number("number", _number(float, text), low, high, above=above))


def _number(kind: Callable[[str], Any], text: str) -> Any:
    try:
        return kind(text)
    except ValueError:
        what = "an integer" if kind is int else "a number"
        raise InputError(f"expected {what}, got {brief(text, of_type=False)}") from None


def add_files(parser: argparse.ArgumentParser) -> None:
    """Add the shape files that a command is about."""
    parser.add_argument("files", nargs="*", metavar="FILE", help=f"{FILES}; sample:NAME; - reads standard input")
    parser.add_argument(
        "--format", type=checked("format", _ending), metavar="ENDING", help="format of standard input, such as stl"
    )


def scene_of(options: argparse.Namespace) -> Scene:
    """Return the scene of the given files, with the requested up axis and sections."""
    import bobrossnet as bob

    sections = check_sections(getattr(options, "section", None))  # before the files are read
    with tempfile.TemporaryDirectory(prefix="bobrossnet-") as folder:
        files = [_of_standard_input(options.format, folder) if file == "-" else file for file in options.files]
        scene = bob.load(files or bob.Instance(bob.happy_tree(), name="happy tree"), up=options.up)
    if only := getattr(options, "only", None):
        scene = scene.isolate(*map(_part, only))
    if hidden := getattr(options, "hide", None):
        scene = scene.hide(*map(_part, hidden))
    return scene.sectioned(sections)


def _part(text: str) -> str | int:
    """A part's number, or its name or path."""
    return int(text) if text.isdecimal() else text


def add_parts(parser: argparse.ArgumentParser) -> None:
    """Add --only and --hide, parts of the scene."""
    for option, what in (("--only", "keep this part alone"), ("--hide", "leave this part out")):
        told = f"{what}: its path, name or number, as info lists them; may be given several times"
        parser.add_argument(option, action="append", metavar="PART", help=told)


def _of_standard_input(ending: str | None, folder: str) -> str:
    """A file with the bytes of standard input."""
    if ending is None:
        raise InputError(f"--format: expected the format of standard input, one of {' '.join(ALL_ENDINGS)}, got none")
    if sys.stdin is None:
        raise InputError("-: expected shapes on standard input, which is closed")
    file = os.path.join(folder, f"standard input{ending}")
    with open(file, "wb") as copy:
        shutil.copyfileobj(sys.stdin.buffer, copy)
    return file


def _ending(text: str) -> str:
    """Return the ending of a format, such as .stl of STL."""
    return check_choice("format", f".{text.lower().lstrip('.')}", ALL_ENDINGS)


def add_size(
    parser: argparse.ArgumentParser,
    default: tuple[int, int] = (480, 640),
    check: Callable[[str], tuple[int, int]] = check_size,
) -> None:
    """Add --size of pictures."""
    height, width = default
    what = f"size in pixels (default: {width}x{height})"
    parser.add_argument("--size", type=checked("size", check), default=default, metavar="WIDTHxHEIGHT", help=what)


def add_fraction(container: argparse._ActionsContainer, default: float | None, told: str = "") -> None:
    """Add --fraction, the share of the pixels to trace; `told` describes a default that depends on other arguments."""
    container.add_argument(
        "--fraction",
        type=fraction,
        default=default,
        metavar="PERCENT",
        help=f"share of the pixels to trace, 5%% or 0.05; 100%% is the exact picture "
        f"(default: {told if default is None else f'{100 * default:g}%%'})",
    )


def add_orbit(parser: argparse.ArgumentParser) -> None:
    """Add the angles and the field of view of an orbiting camera."""
    home = Camera()
    for name, told in (
        ("azimuth", f"angle about the vertical (default: {home.azimuth:g}, or {FRONT:g} if -y is the file's front)"),
        ("elevation", f"angle above the horizon (default: {home.elevation:g})"),
    ):
        parser.add_argument(f"--{name}", type=float, metavar="DEGREES", help=told)
    roll = f"rotation of the camera, anticlockwise (default: {home.roll:g})"
    parser.add_argument("--roll", type=float, default=home.roll, metavar="DEGREES", help=roll)
    add_view(parser)
    add_fov(parser)


def add_fov(parser: argparse.ArgumentParser) -> None:
    """Add --fov, the field of view."""
    parser.add_argument(
        "--fov",
        type=float,
        default=Camera().fov,
        metavar="DEGREES",
        help="perspective: the angle of the picture's height, such as 35 (default: 0, orthographic)",
    )


def add_zoom(parser: argparse.ArgumentParser) -> None:
    """Add --zoom."""
    zoom = Camera().zoom
    parser.add_argument("--zoom", type=float, default=zoom, help=f"1 fits the bounding sphere (default: {zoom:g})")


def add_model(parser: argparse.ArgumentParser) -> None:
    """Add --model, the network that completes pictures."""
    parser.add_argument(
        "--model",
        default="default",
        help="name of shipped weights, such as small, or a .safetensors file (default: default)",
    )


def add_samples(parser: argparse.ArgumentParser, default: int | None, what: str, told: str = "") -> None:
    """Add --samples of each pixel; `told` describes a default that depends on other arguments."""
    parser.add_argument(
        "--samples",
        type=checked("samples", _samples),
        default=default,
        metavar="N",
        help=f"{what} (default: {told or default})",
    )


def _samples(text: str) -> int:
    samples: int = _number(int, text)
    grid_side(samples)
    return samples


def add_seed(parser: argparse.ArgumentParser, of: str, high: int) -> None:
    """Add --seed; `of` names the random numbers."""
    parser.add_argument("--seed", type=integer(0, high), default=0, help=f"seed of {of} (default: 0)")


def add_background(parser: argparse.ArgumentParser, default: str | None, told: str = "") -> None:
    """Add --background, parsed by `background`; `told` describes a default that depends on other arguments."""
    parser.add_argument(
        "--background",
        type=checked("background", _background),
        metavar="COLOR",
        default=default,
        help="transparent, or a colour such as #ffffff, or two for top and bottom: #ffffff,#99bbdd "
        f"(default: {told or default})",
    )


def add_light(parser: argparse.ArgumentParser) -> None:
    """Add --light and --ground."""
    parser.add_argument(
        "--light",
        metavar="LIGHT",
        help="headlight, studio, or the file of an equirectangular environment: .hdr, .exr or a picture "
        "(default: a scene file's lights, otherwise the headlight)",
    )
    parser.add_argument(
        "--ground",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="draw shadows on a plane below the shapes (default: with the light studio)",
    )


def add_edges(parser: argparse.ArgumentParser) -> None:
    """Add --edges and the look of its lines; `edges` reads them."""
    parser.add_argument(
        "--edges", action="store_true", help="draw lines at borders of NURBS faces, at creases and silhouettes"
    )
    parser.add_argument(
        "--hidden", action="store_true", help="also draw hidden borders and creases, thin and dashed; implies --edges"
    )
    parser.add_argument(
        "--line-width",
        type=checked("width", lambda text: Edges(width=_number(float, text)).width),
        metavar="PIXELS",
        help="width of edges at any zoom (default: 1.5)",
    )
    parser.add_argument(
        "--line-color",
        type=checked("color", lambda text: Edges(color=text).color),
        metavar="COLOR",
        help="colour of edges (default: #000000)",
    )


def edges(options: argparse.Namespace, wanted: bool = False) -> Edges | None:
    """Return the lines that `add_edges` asks for, or None; `wanted` asks for them as well."""
    given = {"width": options.line_width, "color": options.line_color}
    look = {name: value for name, value in given.items() if value is not None}
    if not (wanted or options.edges or options.hidden or look):
        return None
    return Edges(**look, hidden=options.hidden)


def add_section(parser: argparse.ArgumentParser, told: str = "cut the shapes open") -> None:
    """Add --section, planes that cut the shapes open; `told` says what becomes of them."""
    parser.add_argument(
        "--section",
        action="append",
        type=checked("section", Section),
        metavar="PLANE",
        help=f"{told}: x=0 or x<0 keeps the side of smaller x, so that the default camera sees the cut; x>0 keeps the "
        "other side; in the shapes' units; may be given up to six times",
    )


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Add --scheduler, the address of a cluster."""
    parser.add_argument(
        "--scheduler",
        type=checked("scheduler", check_address),
        metavar="ADDRESS",
        help="render on the cluster of this Dask scheduler",
    )


def add_pictures_of_folder(parser: argparse.ArgumentParser, told: str, size: tuple[int, int]) -> None:
    """Add a folder of shape files, --out, which `told` describes, and the look of the pictures."""
    parser.add_argument("folder", metavar="DIR", help="folder of the shape files")
    parser.add_argument("-o", "--out", required=True, metavar="OUT", help=f"{told}; created if it does not exist")
    add_size(parser, size)
    add_up(parser)
    add_samples(parser, 4, "maximum number of rays for a pixel at an edge, a square from 1 to 64")
    add_background(parser, "transparent")
    add_light(parser)
    add_scheduler(parser)


def add_up(parser: argparse.ArgumentParser, default: str = "auto") -> None:
    """Add --up, the up axis of the files."""
    what = "the shapes' upward axis, which is turned to z"
    auto = "; auto: y if the format does not record it and the mesh seems to lie on its back, else z"
    parser.add_argument("--up", choices=UPS, default=default, help=f"{what}{auto} (default: {default})")


def add_view(parser: argparse.ArgumentParser) -> None:
    """Add --view, the name of a view."""
    parser.add_argument("--view", choices=tuple(VIEWS), help="direction, instead of --azimuth and --elevation")


def thumbnail_camera_of(options: argparse.Namespace) -> Camera | None:
    """Return the camera of all thumbnails; None if each file has its default."""
    camera = camera_of(options)
    return None if camera == Camera() and options.azimuth is None else camera


def camera_of(options: argparse.Namespace, scene: Scene | None = None) -> Camera:
    """Return the orbiting camera of --view or the angles, in place of the scene's default."""
    given = {name: getattr(options, name) for name in ("azimuth", "elevation") if getattr(options, name) is not None}
    if options.view is not None:
        if given:
            raise InputError(f"--view: expected no --{next(iter(given))} with it")
        given = dict(zip(("azimuth", "elevation"), VIEWS[options.view], strict=True))
    given |= {name: getattr(options, name) for name in ("roll", "zoom", "fov", "pan") if hasattr(options, name)}
    return replace(as_camera(None, scene), **given)


def fraction(text: str) -> float:
    number, percent, rest = text.partition("%")
    try:
        value = float(number) / (100 if percent else 1)
    except ValueError:
        value = -1
    if rest or not 0 < value <= 1:
        raise argparse.ArgumentTypeError(f"expected a share of the pixels, above 0% to 100% or 0 to 1, got {text!r}")
    return value


positive = number(0, above=True)


def background(text: str | None) -> str | tuple[str, str] | None:
    """Parse "transparent", a colour, or two separated by a comma, to the background of `render`; None is black."""
    if text == "transparent":
        return None
    first, comma, second = (text or BLACK).partition(",")
    return (first, second) if comma else first


def _background(text: str) -> str:
    background_rows(background(text), 1)
    return text


def numbers(text: str) -> tuple[float, ...]:
    """Parse coordinates from a list such as 1,-0.5,2."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected numbers with commas between them, got {text!r}") from None


def with_lists_joined(arguments: Sequence[str]) -> list[str]:
    """Join lists and axes that begin with a minus to their options, since argparse would take them for options."""
    joined: list[str] = []
    for argument in arguments:
        if joined and re.fullmatch(r"--\w+", joined[-1]) and re.match(r"-([\d.]+,|[xyz]$)", argument):
            joined[-1] += f"={argument}"
        else:
            joined.append(argument)
    return joined


def fractions(text: str) -> tuple[float, ...]:
    """Parse shares of the pixels from a list such as 1%,5%."""
    return tuple(fraction(part) for part in text.split(","))
