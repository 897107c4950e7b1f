"""The documentation site, built by `make docs`.

It has the repository's documents, the API reference from docstrings, the commands from their help texts, and the live
page.
"""

from __future__ import annotations

import argparse
from importlib.metadata import metadata
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import bobrossnet
from bobrossnet.command_line.cli import parser
from bobrossnet.page.export import export
from bobrossnet.page.files import page_files

project = "BobRossNet"
SUMMARY = metadata("bobrossnet")["Summary"]
version = release = bobrossnet.__version__

# The source is the whole repository, so that links between its files stay valid.
root_doc = "docs/site/index"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CONVENTIONS.md",
    "CHANGELOG.md",
    "bench/sparse/*.md",
    "docs/*.md",
    "docs/how-to/*.md",
    "docs/quality/*.md",
    "docs/reference/*.md",
    "docs/report/*.md",
    "docs/results/*.md",
    "docs/site/*.md",
    "docs/tutorials/*.md",
    "src/bobrossnet/weights/*.md",
]
exclude_patterns = [".venv", "build", "dist", "out"]  # Sphinx would search them, following links
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
suppress_warnings = ["ref.python", "myst.header"]  # types in docstrings; sections of other documents

myst_heading_anchors = 4
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"

html_theme = "pydata_sphinx_theme"
html_title = "BobRossNet"
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {"**": []}  # the top bar lists all documents
html_show_sourcelink = False


class Commands(SphinxDirective):
    """Lists the output of --help of each command."""

    def run(self) -> list[nodes.Node]:
        shown: list[nodes.Node] = []
        (subparsers,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
        for name, command in subparsers.choices.items():
            section = nodes.section(ids=[name])
            section += nodes.title(text=f"bobrossnet {name}")
            section += nodes.literal_block(text=command.format_help(), language="text")
            shown.append(section)
        return shown


def add_page(app: Sphinx, error: Exception | None) -> None:
    """Add the page and llms.txt, a list of all documents for language models, and a start page."""
    if error is None and app.builder.format == "html":
        out = Path(app.outdir)
        with page_files() as files:
            export(files, out / "page")
        place = f"{app.config.root_doc}.html"
        titles = sorted((name, app.env.titles[name].astext()) for name in app.env.all_docs)
        lines = [f"- [{title}]({name}.html)" for name, title in titles]
        (out / "llms.txt").write_text(
            "\n".join([f"# {project}", "", f"> {SUMMARY}", "", "## Pages", "", *lines, ""]), "utf-8"
        )
        begin = f'<!doctype html><meta http-equiv="refresh" content="0; url={place}"><a href="{place}">{project}</a>'
        (out / "index.html").write_text(begin, "utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension with Sphinx."""
    app.add_directive("commands", Commands)
    app.connect("build-finished", add_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
