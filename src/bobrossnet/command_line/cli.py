"""The command line: `bobrossnet view | mesh | pack`, and the commands of this folder and of learn/commands.py.

Slow modules are imported inside functions, so that --help and usage errors answer at once.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import io
import os
import signal
import sys
import time
import warnings
from collections.abc import Sequence
from importlib.metadata import distribution
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import quote

from bobrossnet import __version__
from bobrossnet.command_line import complete, info, mcp, measure, orbit, render, sheet, starting, thumbs
from bobrossnet.command_line.arguments import (
    add_background,
    add_files,
    add_fov,
    add_light,
    add_up,
    background,
    integer,
    positive,
    scene_of,
    with_lists_joined,
)
from bobrossnet.pictures.background import BLACK
from bobrossnet.shapes.mesh import FORMATS as MESH_FORMATS
from bobrossnet.support.interrupts import ENDING
from bobrossnet.support.machine import MAX_PORT, limit_memory
from bobrossnet.support.messages import counted

USAGE_ERROR = 2

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a write to a full disk."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    The status is 0, or the command's status; 2 after an error, reported in one line on stderr; 130 after Ctrl-C.
    """
    from bobrossnet.support.errors import InputError

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # any file name can be printed
            stream.reconfigure(encoding="utf-8" if sys.platform == "win32" else None, errors="backslashreplace")
    try:
        starting.done()
        for sent in ENDING:  # unfinished files are removed
            if signal.getsignal(sent) != signal.SIG_IGN:  # nohup ignores it
                signal.signal(sent, _terminate)
        return _run(arguments)
    except (InputError, _UsageError) as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("not enough memory for a picture or a shape of this size")
    except ModuleNotFoundError as error:
        return _fail(f"this command needs {error.name}: pip install 'bobrossnet[train]'")
    except OSError as error:
        if _is_closed_pipe(error):
            _discard_output()  # the reader has closed the pipe
            return 0
        if error.errno not in FULL:
            raise
        try:
            _flush_output()
        except OSError:
            _discard_output()
        return _fail(f"can't write {error.filename or 'the output'}: {error.strerror}")
    except KeyboardInterrupt as interrupt:
        with contextlib.suppress(OSError):  # the terminal may be closed
            print(": ".join(["bobrossnet: interrupted", *map(str, interrupt.args)]), file=sys.stderr)
        return starting.INTERRUPTED


def _run(arguments: Sequence[str] | None) -> int:
    from bobrossnet.support.errors import InputWarning

    try:
        made = parser()
        if "_ARGCOMPLETE" in os.environ:  # a shell asks for completions
            import argcomplete

            argcomplete.autocomplete(made)
        options = made.parse_args(with_lists_joined(sys.argv[1:] if arguments is None else arguments))
        with warnings.catch_warnings():
            warnings.simplefilter("always", InputWarning)
            options.warnings = []

            def show(message: Warning | str, *_: Any, **__: Any) -> None:
                options.warnings.append(str(message))
                print(f"bobrossnet: warning: {message}", file=sys.stderr)

            warnings.showwarning = show
            status: int = options.run(options) or 0
    except SystemExit:  # --help and --version
        _flush_output()
        raise
    _flush_output()
    return status


def _flush_output() -> None:
    """Flush stdout while errors can still be reported."""
    if sys.stdout is not None:  # None if stdout is closed
        sys.stdout.flush()


def _is_closed_pipe(error: OSError) -> bool:
    """Return whether the output's reader has closed the pipe; on Windows that is an invalid argument without a file."""
    on_windows = sys.platform == "win32" and error.errno == errno.EINVAL and error.filename is None
    return isinstance(error, BrokenPipeError) or on_windows


def _discard_output() -> None:
    """Redirect stdout to nowhere, so that Python does not fail to flush it at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _UsageError(Exception):
    """A usage error, printed as one line without argparse's usage text."""


class _Parser(argparse.ArgumentParser):
    def parse_known_args(self, *arguments: Any, **options: Any) -> tuple[Any, list[str]]:
        """Refuse unknown arguments here: the error names the command, whose help lists the known ones."""
        found, unknown = super().parse_known_args(*arguments, **options)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        raise _UsageError(f"{message} (see {self.prog} --help)")


def parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    made = _Parser(prog="bobrossnet", description="Trace a few percent of the pixels, see the whole picture.")
    made.add_argument("--version", action="version", version=__version__)
    commands = made.add_subparsers(metavar="COMMAND", required=True, parser_class=_Parser)

    render.add(commands)
    sheet.add(commands)
    measure.add(commands)
    orbit.add(commands)
    thumbs.add(commands)
    complete.add(commands)

    view = commands.add_parser(
        "view",
        help="show shapes in a browser",
        description="Show shapes in a page where they can be turned; only browsers on this machine can reach it.",
    )
    view.set_defaults(run=_view)
    add_files(view)
    view.add_argument(
        "--port", type=integer(0, MAX_PORT), default=0, help="port of the page; 0 takes a free one (default: 0)"
    )
    view.add_argument("--no-browser", action="store_true", help="only print the page's address")
    add_up(view)
    add_fov(view)
    add_background(view, BLACK)
    add_light(view)
    view.add_argument(
        "--export",
        metavar="PAGE.html|DIR",
        help="write a single-file page with the shapes, or a folder for any web server, without opening a browser",
    )

    mesh = commands.add_parser(
        "mesh",
        help="write shapes as triangles",
        description="Write shapes as triangles, for printers and other programs.",
    )
    mesh.set_defaults(run=_mesh)
    add_files(mesh)
    mesh.add_argument(
        "--step",
        type=positive,
        metavar="LENGTH",
        help="length of the triangles' sides, in the files' unit (default: 1/128 of each shape's longest side)",
    )
    add_up(mesh, "z")
    endings = ", ".join(MESH_FORMATS)
    mesh.add_argument(
        "-o", "--out", default="out.stl", metavar="MESH", help=f"file to write: {endings} (default: out.stl)"
    )

    pack = commands.add_parser("pack", help="write a scene of shapes", description="Write shapes to one scene file.")
    pack.set_defaults(run=_pack)
    pack.add_argument("scene", metavar="SCENE.bob", help="the file to write")
    add_files(pack)
    add_up(pack, "z")
    add_light(pack)

    info.add(commands)
    mcp.add(commands)

    for point in distribution("bobrossnet").entry_points.select(group="bobrossnet.commands"):
        point.load()(commands)
    return made


def _view(options: argparse.Namespace) -> None:
    import threading
    import webbrowser

    from bobrossnet.page.export import export, export_file
    from bobrossnet.page.files import page_files, scene_address, title_of, tree
    from bobrossnet.page.look import attributes
    from bobrossnet.page.server import Server
    from bobrossnet.support.atomic import check_folder, check_writable
    from bobrossnet.support.errors import InputError
    from bobrossnet.tracing.light import HEADLIGHT, STUDIO, check_light
    from bobrossnet.tracing.lit import relit

    limit_memory()
    files = options.files
    light = check_light(options.light)  # all are checked before the files are read
    look = attributes(options.fov, background(options.background), light)
    if not files and (isinstance(light, list) or options.ground is not None):
        raise InputError(f"light: expected {HEADLIGHT} or {STUDIO}, and no ground, without a file")
    name = title_of(files[0]) if len(files) == 1 else "scene"
    if options.export is None:
        with Server({}, options.port) as server:  # a port in use is refused before the files are read
            scene = relit(scene_of(options), light, options.ground) if files else None
            with page_files(scene, name, look) as page:
                server.files = dict(page)
                # Quoted twice: the parameter is a URL, and # and ? have a meaning in URLs.
                url = server.url + (f"?scene={quote(scene_address(name))}" if files else "")
                print(f"{url}  (Ctrl-C ends it)", flush=True)
                if not options.no_browser:
                    # Browsers in a terminal block until they are closed.
                    threading.Thread(target=webbrowser.open, args=[url], daemon=True).start()
                with contextlib.suppress(KeyboardInterrupt):  # Ctrl-C ends the server
                    server.serve_forever()
        return
    is_page = Path(options.export).suffix.lower() == ".html"
    out = check_writable(options.export) if is_page else check_folder(options.export, "export")
    scene = relit(scene_of(options), light, options.ground) if files else None
    if is_page:
        export_file(scene or tree(), name if files else "happy tree", out, look)
        print(f"wrote {out}: one file, which any browser can show")
        return
    with page_files(scene, name, look) as page:
        export(page, out)
        print(f"wrote {out}: {counted(len(page), 'file')}, which any web server can show")


def _mesh(options: argparse.Namespace) -> None:
    from bobrossnet.shapes.mesh import check_mesh_path

    limit_memory()
    out = check_mesh_path(options.out)
    scene = scene_of(options)
    start = time.perf_counter()
    mesh = scene.mesh(options.step)
    seconds = time.perf_counter() - start
    mesh.save(out)
    print(f"wrote {out}: {counted(len(mesh.triangles), 'triangle')} of {scene.describe()}, made in {seconds:.1f} s")


def _pack(options: argparse.Namespace) -> None:
    import bobrossnet as bob
    from bobrossnet.adapters.container import check_scene_path
    from bobrossnet.tracing.light import check_light
    from bobrossnet.tracing.lit import relit

    limit_memory()
    out = check_scene_path(options.scene)
    light = check_light(options.light)  # before the files are read
    scene = relit(scene_of(options), light, options.ground)
    bob.save_scene(scene, out)
    print(f"wrote {out}: {scene.describe()}")


def _fail(message: str) -> int:
    print(f"bobrossnet: error: {' '.join(message.split())}", file=sys.stderr)
    return USAGE_ERROR


def _terminate(*_: Any) -> NoReturn:
    """Raise KeyboardInterrupt, as Ctrl-C does; later signals, such as a second SIGHUP, must not stop the cleanup."""
    for sent in ENDING:
        signal.signal(sent, signal.SIG_IGN)
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
