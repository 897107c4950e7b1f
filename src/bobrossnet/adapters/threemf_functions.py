"""Functions of a 3MF, after its Volumetric and Implicit Extensions 1.0: graphs of nodes, as formulas.

A function is evaluated with symbols in the place of its inputs (sdf/symbols.py). Scalars are symbols or numbers,
vectors arrays of 3 of them, matrices of 4 by 4.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.adapters.threemf_colors import numbers
from bobrossnet.sdf.symbols import Symbol, Symbols, color_formula_of, expression_of, substitute
from bobrossnet.shapes.implicit import Implicit
from bobrossnet.support.errors import InputError
from bobrossnet.support.messages import one_line

MAX_NODES = 1 << 16
"""Maximum for all level sets and colours of a model: a chain of functions that each call two can make 2ⁿ."""

MAX_CALLS = 64
"""Maximum depth of function calls."""

SHAPES = {(): "a scalar", (3,): "a vector", (4, 4): "a matrix"}

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices and triangles."""


class Node(NamedTuple):
    kind: str
    get: dict[str, str]
    inputs: dict[str, str]
    """References NODE.OUTPUT, by the names of inputs."""


class Function(NamedTuple):
    inputs: list[str]
    nodes: dict[str, Node]
    outputs: dict[str, str]
    """References NODE.OUTPUT, by the names of outputs."""


class Domain(NamedTuple):
    """Domain of a level set: a mesh, or its box."""

    mesh: str
    is_box: bool


class Functions(dict[str, Function | None]):
    """The functions of a model by id, filled element by element; None for functions of images."""

    def __init__(self) -> None:
        super().__init__()
        self.function: Function | None = None
        self.node: Node | None = None
        self.left = MAX_NODES

    def start(self, local: str, get: dict[str, str]) -> None:
        name = get.get("identifier", "")
        if local in ("implicitfunction", "function") and self.function is None:
            self.function = self[get.get("id", "")] = Function([], {}, {})
        elif self.function is None or local in ("in", "out"):
            pass
        elif local in ("scalarref", "vectorref", "matrixref", "resourceref"):
            if get.get("ref"):  # Gladius once wrote empty ones
                (self.node.inputs if self.node else self.function.outputs)[name] = get["ref"]
        elif self.node:
            pass  # its outputs, whose names follow from its kind
        elif local in ("scalar", "vector", "matrix", "resourceid"):
            self.function.inputs.append(name)
        else:
            self.node = self.function.nodes[name] = Node(local, get, {})

    def end(self, local: str) -> None:
        if self.node and local == self.node.kind:
            self.node = None
        elif local in ("implicitfunction", "function"):
            self.function = None

    def level_set(
        self,
        function: str,
        channel: str,
        matrix: NDArray[np.float64],
        meshes: Mapping[str, Mesh],
        domain: Domain,
        color: _core.ColorFormula | None,
    ) -> Implicit:
        """Return the zero surface of a scalar output; a (4, 4) matrix maps points to the function's."""
        vertices = meshes[domain.mesh][0]
        low, high = vertices.min(axis=0), vertices.max(axis=0)

        def f(x: Any, y: Any, z: Any) -> Any:
            value = self._output(function, channel, _mapped(matrix, x, y, z), meshes, ())
            if not domain.is_box:
                value = np.maximum(value, _distance(_vector(x, y, z), domain.mesh, meshes))
            for axis, middle, half in zip((x, y, z), (low + high) / 2, (high - low) / 2, strict=True):
                value = np.maximum(value, np.abs(axis - middle) - half)
            return value

        expression = expression_of(f, 3, f"function {function}")
        # A domain may be far larger than its shape, and cells are fractions of the bounds.
        try:
            bounds = _core.find_bounds(expression)
        except ValueError:
            bounds = None
        return Implicit(expression, (low, high) if bounds is None else bounds, color)

    def color(
        self, function: str, channel: str, matrix: NDArray[np.float64], meshes: Mapping[str, Mesh]
    ) -> _core.ColorFormula:
        """Return the formula of a vector output, linear RGB."""
        return color_formula_of(
            lambda x, y, z: self._output(function, channel, _mapped(matrix, x, y, z), meshes, (3,)),
            f"function {function}",
        )

    def _output(
        self, function: str, channel: str, position: Any, meshes: Mapping[str, Mesh], shape: tuple[int, ...]
    ) -> Any:
        with np.errstate(all="ignore"):
            outputs = _Evaluation(self, meshes).call(function, {"pos": position}, [channel])
        if np.shape(outputs[channel]) != shape:
            raise InputError(f"{channel}: expected {SHAPES[shape]}, got {SHAPES.get(np.shape(outputs[channel]))}")
        return outputs[channel]


class _Evaluation:
    """Evaluates the needed nodes in order."""

    def __init__(self, functions: Functions, meshes: Mapping[str, Mesh]) -> None:
        self.functions, self.meshes = functions, meshes
        self.calls: list[str] = []

    def call(self, name: str, inputs: dict[str, Any], wanted: list[str]) -> dict[str, Any]:
        """Outputs of a function by their names."""
        function = self.functions.get(name)
        if function is None:
            got = "one of an image, which is not read" if name in self.functions else "none"
            raise InputError(f"expected a function with id {one_line(name)}, got {got}")
        if name in self.calls or len(self.calls) == MAX_CALLS:
            raise InputError(f"expected functions at most {MAX_CALLS} deep that do not call themselves, got others")
        for each in function.inputs:
            if each not in inputs:
                raise InputError(f"expected a value for the input {one_line(each)}, got none")
        self.calls.append(name)
        values: dict[str, dict[str, Any]] = {"inputs": inputs}
        found = {}
        for output in wanted:
            reference = function.outputs.get(output)
            if reference is None:
                raise InputError(
                    f"expected an output {one_line(output)}, got {', '.join(map(one_line, function.outputs))}"
                )
            self.evaluate(function, reference, values)
            found[output] = _at(values, reference)
        self.calls.pop()
        return found

    def evaluate(self, function: Function, reference: str, values: dict[str, dict[str, Any]]) -> None:
        """Evaluate the node of a reference, after all nodes it depends on."""
        open_: list[tuple[str, bool]] = [(_node_of(reference), False)]
        being_evaluated: set[str] = set()
        while open_:
            name, has_inputs = open_.pop()
            if name in values:
                continue
            node = function.nodes.get(name)
            if node is None:
                raise InputError(f"expected a node {one_line(name)}, got none")
            if has_inputs:
                self.functions.left -= 1
                if self.functions.left < 0:
                    raise InputError(f"expected at most {MAX_NODES:,} nodes to evaluate, got more")
                inputs = {key: _at(values, each) for key, each in node.inputs.items()}
                values[name] = self.outputs(name, node, inputs)
                being_evaluated.discard(name)
                continue
            if name in being_evaluated:
                raise InputError(f"expected nodes without a cycle, got one through {one_line(name)}")
            being_evaluated.add(name)
            open_.append((name, True))
            open_ += [(_node_of(each), False) for each in node.inputs.values()]

    def outputs(self, name: str, node: Node, inputs: dict[str, Any]) -> dict[str, Any]:
        """Return the outputs of a node by name, or a single output as ""."""
        try:
            if node.kind == "functioncall":
                function = _resource(inputs, "functionID")
                given = {key: value for key, value in inputs.items() if key != "functionID"}
                called = self.functions.get(function)
                return self.call(function, given, list(called.outputs) if called else [])
            if node.kind in ("mesh", "unsignedmesh"):
                distance = _distance(inputs["pos"], _resource(inputs, "mesh"), self.meshes)
                return {"": distance if node.kind == "mesh" else np.abs(distance)}
            if node.kind == "decomposevector":
                return dict(zip("xyz", _shaped(inputs["A"], (3,)), strict=True))
            if node.kind in CONSTANTS:
                return {"": CONSTANTS[node.kind](node.get)}
            if node.kind not in NODES:
                raise InputError(f"expected a supported kind of node, got {one_line(node.kind)}")
            names, compute = NODES[node.kind]
            return {"": compute(*(inputs[each] for each in names))}
        except KeyError as error:
            raise InputError(f"{one_line(name)}: expected {one_line(error.args[0])}, got none") from error


# ---- Values ----------------------------------------------------------------------------------------------


def _node_of(reference: str) -> str:
    return reference.partition(".")[0]


def _at(values: dict[str, dict[str, Any]], reference: str) -> Any:
    name, _, output = reference.partition(".")
    outputs = values.get(name, {})
    if output in outputs:
        return outputs[output]
    if "" in outputs:  # of a node's only output, files have several names
        return outputs[""]
    raise InputError(f"expected a value {one_line(reference)}, got none")


def _array(values: Any) -> Symbols:
    return np.array(values, dtype=object).view(Symbols)


def _vector(x: Any, y: Any, z: Any) -> Symbols:
    return _array([_shaped(each, ()) for each in (x, y, z)])


def _shaped(value: Any, shape: tuple[int, ...]) -> Any:
    if isinstance(value, str) or np.shape(value) != shape:
        raise InputError(f"expected {SHAPES[shape]}, got {SHAPES.get(np.shape(value), 'another')}")
    return value


def _alike(compute: Callable[..., Any]) -> Callable[..., Any]:
    """Check that the operands have one shape, then compute componentwise."""

    def checked(*operands: Any) -> Any:
        for each in operands:
            _shaped(each, np.shape(operands[0]))
        return compute(*operands)

    return checked


def _mapped(matrix: NDArray[np.float64], x: Any, y: Any, z: Any) -> Symbols:
    if np.array_equal(matrix, np.eye(4)):
        return _vector(x, y, z)
    return _times(_array(matrix.tolist()), _vector(x, y, z))


def _times(matrix: Any, vector: Any) -> Symbols:
    """A matrix times (x, y, z, 1), less the last component."""
    m, v = _shaped(matrix, (4, 4)), _shaped(vector, (3,))
    return _array([m[row][0] * v[0] + m[row][1] * v[1] + m[row][2] * v[2] + m[row][3] for row in range(3)])


def _dot(a: Any, b: Any) -> Any:
    p = _shaped(a, (3,)) * _shaped(b, (3,))
    return p[0] + p[1] + p[2]


def _cross(a: Any, b: Any) -> Symbols:
    p, q = _shaped(a, (3,)), _shaped(b, (3,))
    return _array([p[i - 2] * q[i - 1] - p[i - 1] * q[i - 2] for i in range(3)])


def _inverse(matrix: Any) -> Symbols:
    try:
        return _array(np.linalg.inv(np.array(_shaped(matrix, (4, 4)), np.float64)).tolist())
    except (TypeError, ValueError, np.linalg.LinAlgError) as error:
        raise InputError("expected a matrix of constants that has an inverse, got another") from error


def _select(a: Any, b: Any, c: Any, d: Any) -> Any:
    if not np.shape(a):
        return _choice(a, b, c, d)
    chosen = [_choice(*each) for each in zip(*(np.asarray(x, object).ravel() for x in (a, b, c, d)), strict=True)]
    return _array(chosen).reshape(np.shape(a))


def _choice(a: Any, b: Any, c: Any, d: Any) -> Any:
    is_below = np.less(a, b)
    return (c if is_below else d) if isinstance(is_below, bool | np.bool_) else np.where(is_below, c, d)


def _divide(a: Any, b: Any) -> Any:
    """Divide. A constant 0 gives infinity even at a = 0, so that the clamp of a repetition is defined."""
    if np.shape(a):
        return _array([_divide(*each) for each in zip(np.ravel(a), np.ravel(b), strict=True)]).reshape(np.shape(a))
    if isinstance(b, Symbol) or b != 0:
        return np.divide(a, b)
    return _choice(a, 0.0, -np.inf, np.inf)


def _power(a: Any, b: Any) -> Any:
    if not np.shape(a):
        return np.power(a, b)
    return _array([np.power(p, q) for p, q in zip(np.ravel(a), np.ravel(b), strict=True)]).reshape(np.shape(a))


def _matrix_of_scalars(*components: Any) -> Symbols:
    rows = iter(_shaped(each, ()) for each in components)
    return _array([[next(rows) for _ in range(4)] for _ in range(4)])


def _matrix_of_columns(*columns: Any) -> Symbols:
    return _array([*zip(*(_shaped(each, (3,)) for each in columns), strict=True), (0.0, 0.0, 0.0, 1.0)])


def _resource(inputs: dict[str, Any], name: str) -> str:
    value = inputs[name]
    if not isinstance(value, str):
        raise InputError(f"{name}: expected the id of a resource, got a value")
    return value


def _distance(position: Any, mesh: str, meshes: Mapping[str, Mesh]) -> Any:
    """The signed distance to a mesh."""
    if mesh not in meshes:
        raise InputError(f"expected a mesh with id {one_line(mesh)}, got none")
    vertices, triangles = meshes[mesh]
    try:
        expression = _core.distance_to_mesh(vertices, triangles.astype(np.int32))
    except ValueError as error:
        raise InputError(f"mesh {one_line(mesh)}: {error}") from error
    (value,) = substitute(expression, _shaped(position, (3,)).reshape(1, 3)).ravel()
    return value


# ---- Kinds of nodes --------------------------------------------------------------------------------------


def _constants(get: dict[str, str], *names: str) -> list[float]:
    values: list[float] = numbers([get[name] for name in names]).tolist()
    return values


def _constant_matrix(get: dict[str, str]) -> Symbols:
    values = numbers(get["matrix"].split())
    if len(values) != 16:
        raise InputError(f"matrix: expected 16 numbers, got {len(values)}")
    return _array(values.reshape(4, 4).tolist())


CONSTANTS: dict[str, Callable[[dict[str, str]], Any]] = {
    "constant": lambda get: _constants(get, "value")[0],
    "constvec": lambda get: _array(_constants(get, "x", "y", "z")),
    "constmat": _constant_matrix,
    "constresourceid": lambda get: get["value"],
    "resourceid": lambda get: get["value"],
}

OF_ONE: dict[str, Callable[..., Any]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "arcsin": np.arcsin,
    "asin": np.arcsin,
    "arccos": np.arccos,
    "acos": np.arccos,
    "arctan": np.arctan,
    "atan": np.arctan,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "log2": np.log2,
    "log10": np.log10,
    "cosh": np.cosh,
    "sinh": np.sinh,
    "tanh": np.tanh,
    "round": np.rint,
    "ceil": np.ceil,
    "floor": np.floor,
    "sign": np.sign,
    "fract": lambda a: a - np.floor(a),
}

OF_TWO: dict[str, Callable[..., Any]] = {
    "addition": np.add,
    "subtraction": np.subtract,
    "multiplication": np.multiply,
    "division": _divide,
    "min": np.minimum,
    "max": np.maximum,
    "fmod": np.fmod,
    "mod": np.remainder,
    "pow": _power,
    "arctan2": np.arctan2,
    "atan2": np.arctan2,
}

NODES: dict[str, tuple[tuple[str, ...], Callable[..., Any]]] = {
    **{kind: (("A",), _alike(compute)) for kind, compute in OF_ONE.items()},
    **{kind: (("A", "B"), _alike(compute)) for kind, compute in OF_TWO.items()},
    "clamp": (("A", "min", "max"), _alike(lambda a, low, high: np.maximum(low, np.minimum(a, high)))),
    "select": (("A", "B", "C", "D"), _alike(_select)),
    "dot": (("A", "B"), _dot),
    "cross": (("A", "B"), _cross),
    "length": (("A",), lambda a: np.sqrt(_dot(a, a))),
    "composevector": (("x", "y", "z"), _vector),
    "vectorfromscalar": (("A",), lambda a: _vector(a, a, a)),
    "composematrix": (tuple(f"m{row}{column}" for row in range(4) for column in range(4)), _matrix_of_scalars),
    "matrixfromcolumns": (("A", "B", "C", "D"), _matrix_of_columns),
    "matrixfromrows": (("A", "B", "C", "D"), lambda *rows: _matrix_of_columns(*rows).T),
    "matvecmultiplication": (("A", "B"), _times),
    "matrixvectormultiplication": (("A", "B"), _times),
    "transpose": (("A",), lambda a: _shaped(a, (4, 4)).T),
    "inverse": (("A",), _inverse),
}
"""Names of inputs, and the function of them, by kinds of nodes."""
