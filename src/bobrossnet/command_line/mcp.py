"""`bobrossnet mcp`: tools for agents that design parts."""

from __future__ import annotations

import argparse
from typing import Any

from bobrossnet.command_line.arguments import integer
from bobrossnet.support.machine import MAX_PORT


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    mcp = commands.add_parser(
        "mcp",
        help="serve pictures and measures to agents",
        description="Serve tools of the Model Context Protocol: look, describe, pick, measure, compare, mesh. Needs "
        "the extra mcp.",
    )
    mcp.set_defaults(run=run)
    mcp.add_argument("folders", nargs="*", default=["."], metavar="DIR", help="folders to read and write (default: .)")
    told = "serve HTTP on this machine only, instead of standard input and output"
    mcp.add_argument("--port", type=integer(1, MAX_PORT), help=told)


def run(options: argparse.Namespace) -> None:
    """Serve until the client ends."""
    from bobrossnet.agents.workspace import check_folders
    from bobrossnet.support.errors import InputError
    from bobrossnet.support.machine import limit_memory

    check_folders(options.folders)  # before slow imports
    try:
        from bobrossnet.agents.server import server
    except ModuleNotFoundError as error:
        raise InputError(f"mcp: this command needs {error.name}: pip install 'bobrossnet[mcp]'") from None

    limit_memory()
    made = server(options.folders)
    if options.port is None:
        made.run("stdio")
    else:
        made.run("streamable-http", host="127.0.0.1", port=options.port)
