"""Milliseconds to complete a sparse picture on the GPU by WebGPU, next to WebAssembly in one worker and in two.

In Chromium, or in Node with Dawn, which is Chromium's WebGPU (npm's package webgpu has its dawn.node):

    python bench/web/webgpu.py
    python bench/web/webgpu.py --node node --dawn node_modules/webgpu/dist/linux-x64/dawn.node

On a machine without this package, `--page FOLDER` takes the folder that `--write FOLDER` made elsewhere.

The times of one worker, two workers and WebGPU are for whole pictures. They include sending samples to the second
worker, and the interpolation on the CPU. "Upload", "compute" and "readback" are steps of the network.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Empty, Queue
from typing import Any

HERE = Path(__file__).parent / "webgpu"
SIZES = ("640x480", "1920x1080", "3840x2160")
GPU_OPTIONS = (
    "--headless",
    "--no-first-run",
    "--ignore-gpu-blocklist",
    "--enable-unsafe-webgpu",
    "--enable-features=Vulkan",
    "--use-angle=vulkan",
    "--disable-vulkan-surface",
    "--enable-dawn-features=allow_unsafe_apis",
    "--disable-dawn-features=timestamp_quantization",
)

Message = dict[str, Any]


def write_page(folder: Path) -> None:
    """Write the viewer's files, and the measuring page."""
    from bobrossnet.page.files import page_files  # a machine with a GPU may lack the package

    with page_files() as files:
        for path, content in files.items():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content if isinstance(content, bytes) else content.read_bytes())
    shutil.copytree(HERE, folder, dirs_exist_ok=True)
    (folder / "package.json").write_text('{"type": "module"}\n')
    (folder / "webgpu.html").write_text('<!doctype html><script>new Worker("page.js", { type: "module" });</script>\n')


class Handler(SimpleHTTPRequestHandler):
    """Serves a folder, and queues the messages that it receives."""

    extensions_map = SimpleHTTPRequestHandler.extensions_map | {".js": "text/javascript", ".wasm": "application/wasm"}

    def __init__(self, messages: Queue[Message], *request: Any, **settings: Any) -> None:
        self.messages = messages
        super().__init__(*request, **settings)

    def end_headers(self) -> None:
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")  # gives the page a finer clock
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        super().end_headers()

    def do_POST(self) -> None:
        self.messages.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        pass


def until_done(messages: Queue[Message], browser: subprocess.Popen[bytes], seconds: float) -> Iterator[Message]:
    """Yield messages up to the last one, or an error if the browser ends or no message arrives in `seconds`."""
    last = time.monotonic()
    while browser.poll() is None and time.monotonic() < last + seconds:
        try:
            message = messages.get(timeout=0.2)
        except Empty:
            continue
        yield message
        if "done" in message or "error" in message:
            return
        last = time.monotonic()
    yield {"error": f"Chromium: expected a message within {seconds:.0f} s, got none"}


def in_chromium(page: Path, settings: Message, command: list[str], seconds: float) -> Iterator[Message]:
    messages: Queue[Message] = Queue()
    (page / "settings.json").write_text(json.dumps(settings))
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, messages, directory=str(page)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options = [f"--user-data-dir={profile}", *(["--no-sandbox"] if os.geteuid() == 0 else [])]
        url = f"http://127.0.0.1:{server.server_port}/webgpu.html"
        with subprocess.Popen([*command, *options, url]) as browser:
            try:
                yield from until_done(messages, browser, seconds)
            finally:
                browser.kill()
    server.shutdown()


def in_node(page: Path, settings: Message, node: str, dawn: Path) -> Iterator[Message]:
    command = [node, str(page / "node.js"), str(dawn.resolve()), json.dumps(settings)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        try:
            yield from map(json.loads, process.stdout)
        except GeneratorExit:
            process.kill()
            raise
    if process.returncode:
        yield {"error": f"node: expected exit status 0, got {process.returncode}"}


WHOLE = ("one", "two", "gpu")
PARTS = ("gpuNetwork", "upload", "compute", "readback", "interpolation")
HEADER = (
    "| size, network | one worker | two workers | WebGPU | gain over one | over two | network on the GPU | upload "
    "| compute | readback | interpolation | first | difference |\n|---|" + "---:|" * 12
)


def line(row: Message) -> str:
    """Format a case's medians in milliseconds, with the fastest and the slowest of whole pictures."""
    times = row["times"]
    one, two, gpu = (times[way]["median"] for way in WHOLE)
    whole = [f"{t['median']:.1f} ({t['min']:.1f}–{t['max']:.1f})" for t in (times[way] for way in WHOLE)]
    parts = [f"{times[way]['median']:.2f}" if way in times else "" for way in PARTS]
    gains = [f"{one / gpu:.2f}", f"{two / gpu:.2f}"]
    end = [f"{row['first']:.0f}", f"{row['differences']['network']:.1e}"]
    cells = [f"{row['width']}x{row['height']}, {row['model']}", *whole, *gains, *parts, *end]
    return f"| {' | '.join(cells)} |" + "".join(f"\n{failure}" for failure in row["failures"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", nargs="+", default=SIZES)
    parser.add_argument("--models", nargs="+", default=["default", "small"])
    parser.add_argument("--share", type=float, default=0.03, help="of the pixels that are traced")
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--chromium", default="chromium")
    parser.add_argument("--option", action="append", default=[], help="of Chromium's command line")
    parser.add_argument("--seconds", type=float, default=120, help="to wait for a case in Chromium")
    parser.add_argument("--software", action="store_true", help="also on a GPU emulated in software")
    parser.add_argument("--node")
    parser.add_argument("--dawn", type=Path)
    parser.add_argument("--write", type=Path, metavar="FOLDER")
    parser.add_argument("--page", type=Path, metavar="FOLDER")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    if arguments.write:
        write_page(arguments.write)
        return
    sizes = [[int(length) for length in reversed(size.split("x"))] for size in arguments.sizes]
    settings = {"sizes": sizes, "models": arguments.models, "share": arguments.share, "runs": arguments.runs}
    found: Message = {"settings": settings, "cores": os.cpu_count(), "rows": []}
    with tempfile.TemporaryDirectory() as folder:
        page = arguments.page or Path(folder)
        if not arguments.page:
            write_page(page)
        if arguments.node:
            messages = in_node(page, settings, arguments.node, arguments.dawn)
        else:
            command = [arguments.chromium, *GPU_OPTIONS, *arguments.option]
            messages = in_chromium(page, settings, command, arguments.seconds)
        for message in messages:
            if "adapter" in message:
                found["adapter"] = message["adapter"]
                print(f"{message['adapter']}, {os.cpu_count()} cores\n\n{HEADER}", flush=True)
                if message["adapter"]["isFallbackAdapter"] and not arguments.software:
                    found["error"] = "navigator.gpu: expected a GPU, got one in software; --software measures it"
                    break
            elif "row" in message:
                found["rows"].append(message["row"])
                print(line(message["row"]), flush=True)
            elif "error" in message:
                found["error"] = message["error"]
            if arguments.json:
                arguments.json.write_text(json.dumps(found, indent=1))
    if "error" in found:
        sys.exit(found["error"])


if __name__ == "__main__":
    main()
