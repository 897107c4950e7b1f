"""A server of the viewer's page, for browsers on this machine alone."""

from __future__ import annotations

import re
import socket
import sys
from http import HTTPStatus
from http.client import HTTP_PORT
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote

from bobrossnet.page.files import TYPES, Files
from bobrossnet.support.errors import InputError, check_integer
from bobrossnet.support.machine import MAX_PORT

HEADERS = {
    "Content-Security-Policy": "; ".join(
        [
            "default-src 'self'",
            "script-src 'self' 'wasm-unsafe-eval'",
            "worker-src 'self'",
            "img-src 'self' blob: data:",
            "connect-src 'self'",
            "object-src 'none'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        ]
    ),
    # Lets the page's workers share memory.
    "Cross-Origin-Embedder-Policy": "require-corp",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}

LASTING = {".css", ".js", ".safetensors", ".svg", ".wasm"}
"""Endings of the page's code, which browsers may cache for a while: each of its workers fetches it again."""

VALID_HOST = re.compile(r"(?:[\w.~%-]+|\[[\da-fA-F:.]+\])(?::\d*)?")
"""A host name or address with an optional port, without a user name."""


def own_hosts(port: int) -> set[str]:
    """Return the valid hosts of this server, in lower case; without a port if that is HTTP's default."""
    names = ("127.0.0.1", "localhost")
    return {f"{name}:{port}" for name in names} | ({*names} if port == HTTP_PORT else set())


class Server(ThreadingHTTPServer):
    """Serves the page on 127.0.0.1.

    Parameters
    ----------
    files : Files
        Everything that can be requested.
    port : int in 0..65535
        0 takes any free port.

    Raises
    ------
    InputError
        If the port is out of range or unavailable.
    """

    daemon_threads = True
    # Either would let another server share the port: the first on Windows, the second elsewhere.
    allow_reuse_address = sys.platform != "win32"
    allow_reuse_port = False
    request_queue_size = 1024
    """Queue of unaccepted connections: the system drops further ones, and each retries after a second."""

    def __init__(self, files: Files, port: int = 0) -> None:
        self.files = dict(files)
        try:
            super().__init__(("127.0.0.1", check_integer("port", port, 0, MAX_PORT)), _Handler)
        except OSError as error:
            raise InputError(f"port: expected a free one, got {port}: {error.strerror}") from error
        self.hosts = own_hosts(self.server_port)

    def server_bind(self) -> None:
        if sys.platform == "win32":  # otherwise others could take the port
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        super().server_bind()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}/"

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore browsers that close connections early; report any other error."""
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Handler(BaseHTTPRequestHandler):
    server: Server
    protocol_version = "HTTP/1.1"
    timeout = 60  # seconds, of idle connections
    disable_nagle_algorithm = True

    def do_GET(self) -> None:
        self._answer()

    def do_HEAD(self) -> None:
        self._answer()

    def _answer(self) -> None:
        # A foreign page could reach this server under another name for 127.0.0.1; the Host header reveals it.
        hosts = self.headers.get_all("Host", [])
        if len(hosts) != 1:
            return self.send_error(HTTPStatus.BAD_REQUEST, f"expected one Host, got {len(hosts)}")
        if hosts[0].lower() not in self.server.hosts:
            return self.send_error(HTTPStatus.FORBIDDEN, "expected the host 127.0.0.1")
        for origin in self.headers.get_all("Origin", []):
            if origin.lower().removeprefix("http://") not in self.server.hosts:
                return self.send_error(HTTPStatus.FORBIDDEN, "expected a request of this page")
        target = self.path
        if not target.startswith("/"):  # an absolute URL, as sent to proxies
            scheme, separator, rest = target.partition("://")
            host, slash, rest = rest.partition("/")
            if not separator or (host and not VALID_HOST.fullmatch(host)):
                return self.send_error(HTTPStatus.BAD_REQUEST, "expected a path or a URL")
            if scheme.lower() != "http" or host.lower() not in self.server.hosts:
                return self.send_error(HTTPStatus.MISDIRECTED_REQUEST, "expected the host 127.0.0.1")
            target = slash + rest
        path = unquote(re.split("[?#]", target, maxsplit=1)[0]).removeprefix("/") or "index.html"
        content = self.server.files.get(path)
        if content is None:
            return self.send_error(HTTPStatus.NOT_FOUND)
        suffix = Path(path).suffix
        kind, caching = TYPES.get(suffix, TYPES[".bob"]), "max-age=60" if suffix in LASTING else "no-cache"
        if isinstance(content, bytes):
            self._start(HTTPStatus.OK, kind, len(content), caching)
            if self.command == "GET":
                self.wfile.write(content)
            return None
        with content.open("rb") as file:
            self._start(HTTPStatus.OK, kind, content.stat().st_size, caching)
            if self.command == "GET":
                self.connection.sendfile(file)
        return None

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send an error; the base class also calls this for malformed requests and other methods."""
        status = HTTPStatus(code)
        body = f"{status.value} {message or status.phrase}\n".encode()
        self.close_connection = True
        self._start(status, TYPES[".txt"], len(body))
        if getattr(self, "command", None) != "HEAD":
            self.wfile.write(body)

    def _start(self, status: HTTPStatus, kind: str, size: int, caching: str = "no-cache") -> None:
        self.send_response(status)
        fields = {"Content-Type": kind, "Content-Length": str(size), "Cache-Control": caching}
        for name, value in {**HEADERS, **fields}.items():
            self.send_header(name, value)
        self.end_headers()

    def version_string(self) -> str:
        return "bobrossnet"

    def log_message(self, *_: object) -> None:
        pass
