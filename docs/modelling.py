"""Writes the files generated from the modelling language's table.

These are docs/modelling.md, and the stubs of d2, d3 and ease for editors and type checkers.

python docs/modelling.py
"""

from __future__ import annotations

import textwrap
from dataclasses import replace
from pathlib import Path

from bobrossnet.sdf.words import WORDS, Parameter, Word

ROOT = Path(__file__).parent.parent
LINE = 120

# ---- The document ----------------------------------------------------------------------------------------

HEAD = """# The modelling language

Shapes are formulas, negative inside, after fogleman/sdf (github.com/fogleman/sdf): a program written
for it runs with the first line `from bobrossnet.sdf import *`.
`f.save("part.stl")` writes triangles with sharp edges; `f.save("part.3mf")` writes the formula itself, in millimetres,
by 3MF's Volumetric and Implicit Extensions; `f.save("part.png", camera=bob.Camera(azimuth=30))`
draws a picture without triangles. `bob.trace(f)` traces a shape like any other.

`a | b`, `a & b` and `a - b` are union, intersection and difference. `b.k(0.1)` rounds the edge of the next operation
on b with this radius: `a - b.k(0.1)`. The shape b itself does not change; no shape ever does. Angles are in radians;
`degrees` and `radians` convert. X, Y, Z, UP and ORIGIN are vectors. A number in place of a vector applies to all
axes. An easing may be any function of t made of operators and numpy's functions.

`f.color("#c33")` colours a shape: "#rrggbb", a CSS color name, three numbers in 0..1 of linear light, or in Python a
function of points (n, 2 or 3) that returns (n, 3). Unions show the colour of the visible surface, and k blends
colours as it blends shapes. A cut has the tool's colour if the tool has one: `part - hole.color("#c33")` is a white
part with red holes, `part.color("#c33") - hole` is red throughout. In an intersection, a shape without a colour takes
the other's; elsewhere it is white.

A name that exists in two and in three dimensions means the 3D form, except for an operation on a flat shape; `d2` and
`d3` contain both: `d2.slab(x0=0)`. To define your own shapes and operations, decorate functions with `@sdf2`,
`@sdf3`, `@op2`, `@op3`, `@op23` and `@op32` (`help("bobrossnet.sdf.custom")`).

Every value equals fogleman/sdf's, with these exceptions:

- `rounded_rectangle` respects its center.
- Places where a formula there divides 0 by 0, such as repeated corners of a polygon or the centre of an ellipsoid,
  have a value.
- k applies when shapes are joined, not when they are evaluated.
- Text and pictures have outlines instead of pixels, and meshes have distances from their triangles instead of a
  grid's.

This list is made by docs/modelling.py from the table in core/modelling.
"""

TEXT_AND_PICTURES = """## Text and pictures

| | |
|---|---|
| `text(font_name, text, width=None, height=None)` | A line of text, from a font file or the name of a font. |
| `measure_text(font_name, text, width=None, height=None)` | Its width and height. |
| `image(path_or_array, width=None, height=None, pixels=4194304)` | The white region of a picture. |
| `measure_image(path_or_array, width=None, height=None)` | Its width and height. |

These are flat shapes around the origin, by default of height 1. They exist in Python only: scripts and the page
read neither fonts nor pictures, but show them in `.bob` files. Text needs fontTools: `pip install 'bobrossnet[text]'`.

Letters are outlines of lines and arcs that follow the font's curves, TrueType or CFF, to 3e-5 of the font's size;
overlapping contours are united. Spacing follows the letters' widths and the font's `kern` table. There are no
ligatures, and joining scripts are not shaped. The width spans from the start of the first letter to the end of the
last one's advance, spaces included; the height from the lowest to the highest point, as in Pillow.

A picture's outline follows half of white, between pixels as well, simplified by at most a quarter of a pixel;
pictures with more than `pixels` pixels are reduced first. White regions end at the frame, with corners cut by half a
pixel.

Distances from these outlines are exact. A dozen letters are ready in half a second. More than about fifty letters, or
an intricate picture, take seconds to prepare and trace slowly: make one shape per line of text, and put them into one
scene.
"""

MESHES = """## Meshes

| | |
|---|---|
| `Mesh.from_file(path)` | A mesh from a .stl, .ply, .obj, .off, .glb, .gltf or .3mf file. |
| `Mesh(vertices, triangles)` | A mesh of arrays, as in `bob.Mesh`. |
| `mesh.sdf(voxel_size=None, half_width=None)` | Its inside, a solid in the mesh's units. |

These exist in Python only: scripts and the page read no meshes for their formulas, but show them in `.bob` files.

A mesh's solid can be cut, rounded, hollowed, bent, coloured and repeated like any other. Its distances are exact
everywhere: from the triangles, with corners rounded to 1e-7 of the mesh's size. There is no grid: `voxel_size` and
`half_width` change nothing. Colours, textures and normals of the mesh are left out, so facets are visible.

The mesh must be closed: every edge lies in equally many triangles in both directions, after vertices within
1e-12 of the mesh's size are merged. Otherwise the error counts the open edges, or the edges between triangles of
opposite winding. The inside is the region that the surface winds around, clockwise or anticlockwise, so parts may
overlap; distances then include hidden surfaces.

On two cores, 70,000 triangles are ready in two seconds, 350,000 in five. A ray takes longer than in
`bob.Mesh`, with the same picture: trace `bob.Mesh` if no operation follows.
"""

SECTIONS = [
    ("Solids", lambda word: word.kind == "shape" and word.dimensions == 3),
    ("Flat shapes", lambda word: word.kind == "shape" and word.dimensions == 2),
    ("Operations on solids", lambda word: word.kind == "operation" and word.dimensions == 3),
    ("Operations on flat shapes", lambda word: word.kind == "operation" and word.dimensions == 2),
    ("Easing functions", lambda word: word.kind == "easing"),
]


def document() -> str:
    parts = [HEAD]
    for title, belongs in SECTIONS:
        rows = [f"| `{_called(word)}` | {word.meaning.replace('|', '&#124;')} |" for word in WORDS if belongs(word)]
        parts.append("\n".join([f"## {title}", "", "| | |", "|---|---|", *rows]) + "\n")
        if title == "Flat shapes":
            parts += [TEXT_AND_PICTURES, MESHES]
    return "\n".join(parts)


def _called(word: Word) -> str:
    """Return the call as written: operations as methods of their first argument."""
    if word.kind == "shape":
        return word.describe()
    if word.kind == "easing":
        return f"ease.{word.describe()}"
    first, *rest = word.parameters
    result = " → solid" if word.result_dimensions > word.dimensions else ""
    result = " → flat" if word.result_dimensions < word.dimensions else result
    return f"{first.name}.{replace(word, parameters=tuple(rest)).describe()}{result}"


# ---- The stubs -------------------------------------------------------------------------------------------

STUB = '''"""{title} Made by docs/modelling.py."""

import numpy as np
from numpy.typing import NDArray

{imports}
{constants}

class {shape}({base}):
{methods}
{functions}'''

IMPORTS = {
    2: """from bobrossnet.sdf.d3 import SDF3
from bobrossnet.sdf.words import Color, Easing, Flat, Points, Size, Vector
""",
    3: """from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.solid import Solid
from bobrossnet.sdf.words import Color, Easing, Size, Vector
""",
}

EASING_STUB = '''"""Easing functions: from 0 at t = 0 to 1 at t = 1. Made by docs/modelling.py."""

from typing import Any

{functions}'''

TYPES = {
    "number": "float",
    "integer": "int",
    "vector": "Vector",
    "size": "Size",
    "numbers": "Size",
    "points": "Points",
    "easing": "Easing",
    "color": "Color",
}


def stub(dimensions: int) -> str:
    words = [word for word in WORDS if word.dimensions == dimensions and word.kind != "easing"]
    operations = [word for word in words if word.kind == "operation"]
    flat = dimensions == 2
    names = ["ORIGIN", "X", "Y", "UP"] if flat else ["ORIGIN", "X", "Y", "Z", "UP"]
    return STUB.format(
        title=f"Shapes in {'two' if flat else 'three'} dimensions, and operations on them.",
        imports=IMPORTS[dimensions],
        constants="\n".join(f"{name}: NDArray[np.int_]" for name in names),
        shape=f"SDF{dimensions}",
        base="Flat" if flat else "Solid",
        methods="\n".join(_definition(word, method=True) for word in operations),
        functions="\n".join(_definition(word) for word in words),
    )


def easing_stub() -> str:
    words = [word for word in WORDS if word.kind == "easing"]
    functions = []
    for word in words:
        k = "".join(f", {parameter.name}: float = ..." for parameter in word.parameters[1:])
        functions.append(f'def {word.name}(t: Any{k}) -> Any:\n    """{word.meaning}"""\n')
    return EASING_STUB.format(functions="\n".join(functions))


def _definition(word: Word, method: bool = False) -> str:
    parameters = [_typed(word, parameter) for parameter in word.parameters]
    if method:
        parameters[0] = "self"
    indent = "    " if method else ""
    result = f") -> SDF{word.result_dimensions}:"
    line = f"{indent}def {word.name}({', '.join(parameters)}{result}"
    if len(line) > LINE:
        inner = "".join(f"\n{indent}    {parameter}," for parameter in parameters)
        line = f"{indent}def {word.name}({inner}\n{indent}{result}"
    meaning = textwrap.wrap(word.meaning, LINE - len(indent) - 10)
    text = f"\n{indent}    ".join(meaning)
    return f'{line}\n{indent}    """{text}"""\n'


def _typed(word: Word, parameter: Parameter) -> str:
    kind = f"SDF{word.dimensions}" if parameter.type == "sdf" else TYPES[parameter.type]
    if parameter.variadic:
        return f"*{parameter.name}: {kind}"
    if parameter.required:
        return f"{parameter.name}: {kind}"
    return f"{parameter.name}: {kind}{' | None' if parameter.default is None and kind != 'Easing' else ''} = ..."


def files() -> dict[Path, str]:
    """Return the generated texts by path."""
    package = ROOT / "src/bobrossnet/sdf"
    return {
        ROOT / "docs/modelling.md": document(),
        package / "d2.pyi": stub(2),
        package / "d3.pyi": stub(3),
        package / "ease.pyi": easing_stub(),
    }


def main() -> None:
    for path, text in files().items():
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
