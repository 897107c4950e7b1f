"""Shape scripts and .vm files: scripts make the same shapes as Python; errors name their place; shapes of formulas."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import bobrossnet as bob
from bobrossnet.adapters.script import read_script
from bobrossnet.adapters.vm import read_vm
from bobrossnet.sdf.d3 import SDF3
from bobrossnet.support.errors import InputError

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.sdf"))
(DOCUMENTED,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "scripts.md").read_text(), re.DOTALL)

PROGRAMS = [
    "f = sphere(1) & box(1.5)\nc = cylinder(0.5)\nf -= c.orient(X) | c.orient(Y) | c.orient(Z)",
    "s = sphere(0.75)\ns = s.translate(Z * -3) | s.translate(Z * 3)\nf = s.union(capsule(Z * -3, Z * 3, 0.5), k=1)",
    "f = box((1, 1, 4)).rotate(pi / 4).circular_array(24, 1.6).twist(0.75).k(0.1) | cylinder(1)",
    "f = rounded_box([3.2, 1, 0.25], 0.1).bend_linear(X * 0.75, X * 2.25, Z * -0.1875, ease.in_out_quad)",
    "f = union(*[sphere(r).translate((r * r, 0, 0)) for r in range(1, 9) if r % 3], k=0.25)",
    "a, (b, c) = 7 // 2, (-7 % 3, 2 ** -2)\nf = ellipsoid((a, b, c)) - d2.slab(x0=a / 4).extrude(sqrt(a) + c ** 0.5)",
    "f = polygon([(cos(i), sin(i)) for i in range(6)]).extrude(1)\nfor i, v in enumerate([X, Y + Z]):\n"
    "    f |= sphere(i + 1 if i else 0.5).translate(v * i - UP / 3 + ORIGIN)",
    "f = rectangle(1).revolve(2).scale(round(2.675, 2)).translate(sum([X, 2 * Y, -Z]) ** 2)",
]


def as_python(program):
    """Return the shape that Python makes of a program, named f."""
    names = {}
    exec("from math import *\nfrom bobrossnet.sdf import *\n" + program, names)
    return names


@pytest.fixture
def script(tmp_path):
    """Return a function from a script's text or bytes to the shape in its file."""

    def read(source):
        path = tmp_path / "shape.sdf"
        path.write_bytes(source if isinstance(source, bytes) else source.encode())
        return read_script(path)

    return read


@pytest.fixture
def vm(tmp_path):
    def read(text):
        path = tmp_path / "shape.vm"
        path.write_text(text)
        return read_vm(path)

    return read


# ---- Scripts ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("program", [*PROGRAMS, DOCUMENTED])
def test_a_script_is_the_same_program_in_python(script, program):
    shape = script(program)
    assert isinstance(shape, SDF3)
    assert shape.expression == as_python(program)["f"].expression


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_programs_in_python(example):
    shape = read_script(example)
    # Python has no value of a program: the last line gets a name.
    *lines, last = example.read_text().rstrip().splitlines()
    name, _, _ = last.partition(" -= ")
    program = "\n".join([*lines, last if " -= " in last else f"f = {last}"])
    assert shape.expression == as_python(program)[name if " -= " in last else "f"].expression


def test_expressions_of_numbers_are_pythons(script):
    numbers = """-7 // 2; 7 // -2.5; -7.5 % 2; 7 % -3; 2 ** 3 ** 2 / 100; -2 ** 2; 1 - 2 - 3; 8 / 4 / 2; 0.1 + 0.2;
        round(0.5); round(1.005, 2); int(-3.7); floor(-3.7); degrees(1); atan2(-1, -2); max((1, 5, 2)); (1, 2, 3)[-2];
        1 < 2 < 3; not 0 or 5; 3 if [] else 4; len(range(3, 20, 4)); sum([x for x in range(9) if x % 2])"""
    for text in numbers.split(";"):
        text = text.strip()
        value = float(as_python(f"f = {text}")["f"])
        assert script(f"f = plane(X, (({text}) * 1.0, 0, 0))")([(0, 0, 0)]) == value, text


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("", "line 1, column 1: expected a shape"),
        ("f = circle(2)", "line 1, column 1: expected a 3D shape as the script's result, got a 2D one; .extrude(1)"),
        (
            'f = text("font.ttf", "a").extrude(1)',
            "line 1, column 5: text: scripts read no fonts and no pictures; write the program in Python",
        ),
        ("f = sphere(1)\nimport os", "line 2, column 1: import: scripts have every word already; delete this line"),
        ("\n\nopen('x')", "line 3, column 1: open: scripts make shapes and nothing else"),
        ("f = sphere(1).twist('a')", "line 1, column 15: twist: k: expected a number, got a string"),
        ("# zwölf €\nf = 'zwölf €' | 3", "line 2, column 15: |: expected two shapes, got a string and a number"),
        (b"f = sphere(1) # \xff", "line 1, column 17: expected valid UTF-8"),
        ("f = " + "(" * 100_000, "line 1, column 105: expected less nesting"),
        ("for i in range(10000):\n  for j in range(10000): pass", "line 2, column 26: expected at most 1000000 steps"),
        (b" " * (1 << 20) + b" ", "line 1, column 1: expected at most 1048576 bytes, got 1048577"),
    ],
)
def test_errors_say_where(script, source, message):
    with pytest.raises(InputError, match="^" + re.escape(message)):
        script(source)


@settings(deadline=None, max_examples=300)
@given(st.binary(max_size=60) | st.text(alphabet="f=sphere(1)|-X*2 \n:,.[]'\"#\\\t", max_size=60).map(str.encode))
def test_any_bytes_are_a_shape_or_one_line(tmp_path_factory, source):
    path = tmp_path_factory.getbasetemp() / "any.sdf"
    path.write_bytes(source)
    for read in (read_script, read_vm):
        message = "line 1, column 1: no error"
        try:
            read(path)
        except InputError as error:
            message = str(error)
        assert re.fullmatch(r"line \d+(, column \d+)?: [ -~]+", message)


# ---- .vm files -------------------------------------------------------------------------------------------


def test_vm_formula(vm):
    shape = vm("# a sphere\n_0 var-x\n_1 square _0\n_2 var-y\n_3 square _2\n_4 add _1 _3\n_5 var-z\n_6 square _5\n"
               "_7 add _4 _6\n_8 sqrt _7\n_9 const 2.5\n_a sub _8 _9\n")  # fmt: skip
    points = np.random.default_rng(1).normal(size=(100, 3))
    np.testing.assert_allclose(shape.expression(points), np.linalg.norm(points, axis=1) - 2.5, atol=1e-14)


def test_vm_without_z_is_extruded(vm):
    shape = vm("x var-x\ny var-y\nf add x y")
    points = np.random.default_rng(1).normal(size=(100, 3)) * (1, 1, 0.05)
    x, y, z = points.T
    np.testing.assert_allclose(shape.expression(points), np.maximum(x + y, abs(z) - 0.05), atol=1e-15)
    assert (shape.bounds[:, :2] == [(-1, -1), (1, 1)]).all()
    assert shape.bounds[0, 2] < -0.05
    assert shape.bounds[1, 2] > 0.05


def test_vm_is_cut_only_where_it_has_no_bounds(vm):
    squares = "x var-x\ny var-y\nz var-z\na square x\nb square y\nc square z\nd add a b\ne add d c\nr const 9\n"
    assert vm(squares + "f sub e r").bounds is None
    np.testing.assert_array_equal(vm(squares + "f sub r e").bounds, [(-1, -1, -1), (1, 1, 1)])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: expected a formula, got no operation"),
        ("x var-x\n# comment\ny add x z", "line 3: expected a name of a line above, got 'z'"),
        ("x var-x\ny frobnicate x", "line 2: expected an operation such as add, max or var-x, got 'frobnicate'"),
        ("x const one", "line 1: expected a number, got 'one'"),
    ],
)
def test_vm_errors_say_where(vm, text, message):
    with pytest.raises(InputError, match="^" + re.escape(message)):
        vm(text)


# ---- Files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("gear.SDF", "f = sphere(1)\nwhile True: pass", "gear.SDF: line 2, column 1: while: loops are written for"),
        ("none.sdf", "sphere(0)", "none.sdf: shape: expected a surface within the bounds"),
        ("none.vm", "one const 1", "none.vm: shape: expected"),
        ("hi.vm", "x var-x\ny frob x", "hi.vm: line 2: expected an operation such as add"),
    ],
)
def test_load_names_the_file(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match="^" + re.escape(message)):
        bob.load(tmp_path / name)


@pytest.mark.parametrize("ending", [".sdf", ".vm"])
def test_load_without_a_file(tmp_path, ending):
    with pytest.raises(InputError, match=rf"^none\{ending}: expected a file, found nothing"):
        bob.load(tmp_path / f"none{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with pytest.raises(InputError, match=rf"^folder\{ending}: expected a file, got a folder"):
        bob.load(tmp_path / f"folder{ending}")


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_can_be_traced(example):
    gray = bob.trace(bob.load(example), bob.Camera(azimuth=30, elevation=30), size=(60, 80)).gray
    assert 0.1 < np.count_nonzero(gray) / gray.size < 0.9
