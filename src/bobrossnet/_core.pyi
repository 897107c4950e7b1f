"""The C++ core (bindings/). Arrays are C-contiguous; none is converted or copied."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]
I32 = NDArray[np.int32]
U8 = NDArray[np.uint8]
U32 = NDArray[np.uint32]

def thread_count() -> int: ...
def set_thread_count(count: int) -> None: ...
def isa() -> str: ...
def set_isa(name: str) -> bool: ...
def end_work() -> None: ...
def begin_fork() -> None: ...

class Reading:
    """Reads a mesh file, whose name ends in `format`, in as many steps as it takes to fetch other files that it names.
    ValueError, of one line, if it can't be read."""

    def __init__(self, format: str, data: bytes) -> None: ...
    def go_on(self) -> str:
        """The name of a file that is needed first, which `give` or `refuse` has to answer; empty at the end."""
    def give(self, data: bytes) -> None: ...
    def refuse(self, why: str) -> None: ...
    def description(self) -> str:
        """All but numbers and images, as JSON (core/files/read.h)."""
    def numbers(self) -> F64:
        """The numbers of what that describes, (n, 1): 13 for each surface, then 16 for each placement."""
    def triangles(self, part: int) -> I32:
        """(T, 3), handed over: the next call has none."""
    def field(self, part: int, number: int) -> F64 | None:
        """Vertices, normals, colors, face_colors, alphas, and from 5 on uv sets, (n, 3), (n, 2) or (n, 1), handed over;
        None if the file has none."""
    def image(self, number: int) -> bytes:
        """The embedded file."""

class Shape:
    """`map`, (4, 4), places a shape: it takes the shape's own units to where it is."""

    def bounds(self, map: F64) -> F64:
        """The lowest and the highest coordinates, (2, 3), of the placed shape."""
    def radius(self, map: F64, center: F64) -> float:
        """The distance from `center` to the farthest point of the placed shape."""
    def prepare(self) -> None:
        """Build what rays need, if it is not there yet."""
    @property
    def bytes(self) -> int:
        """Of what rays need."""

class Picture:
    """`texels` (height, width, 3) are sRGB, from the top row down, `alpha` (height, width); they must not change while
    it lives."""

    def __init__(self, texels: U8, alpha: U8 | None = None) -> None: ...
    @property
    def bytes(self) -> int: ...

class Texture:
    """A picture, which others may share, and how it wraps: repeat, clamp or mirror."""

    def __init__(self, picture: Picture, across: str, down: str) -> None: ...
    def __call__(self, uv: F32, widths: F32) -> F32: ...

class Mesh(Shape):
    """The arrays, `vertices` (v, 3), `triangles` (t, 3), `normals` and `colors` (v, 3), `face_colors` (t, 3), `uv`
    (v, 2) and `alphas` (v,), must not change while it lives."""

    def __init__(
        self,
        vertices: F64,
        triangles: I32,
        normals: F32 | None,
        colors: F32 | None = None,
        face_colors: F32 | None = None,
        uv: F32 | None = None,
        texture: Texture | None = None,
        alphas: F32 | None = None,
        alpha_cutoff: float = 0,
    ) -> None: ...
    def corner_normals(self) -> F32:
        """The unit normals at the corners of its triangles, (t, 3, 3)."""
    @property
    def bvh_bytes(self) -> int: ...

class Implicit(Shape):
    def __init__(self, formula: Expression, bounds: F64, color: ColorFormula | None = None) -> None: ...
    def colors(self, points: F64) -> F32:
        """Linear RGB (n, 3) at points (n, 3), of a shape with colours."""
    @property
    def cells(self) -> int: ...
    @property
    def is_coarse(self) -> bool: ...
    @property
    def unresolved_rays(self) -> int: ...
    def dual_contour(self, step: float) -> tuple[F64, I32]:
        """Vertices (v, 3) and triangles (t, 3), anticlockwise seen from outside. ValueError if there are too many."""

Curve = tuple[F64, F64]
"""Control points (n, 3), each (u, v, weight); knots."""

Surface = tuple[F64, F64, F64, Sequence[Sequence[Curve]]]
"""Control points (n, m, 4), each (x, y, z, weight); knots of u and of v; loops of curves."""

class Brep(Shape):
    """ValueError if the trims leave nothing."""

    def __init__(
        self, faces: Sequence[Surface], tolerance: float, colors: F32 | None = None, numbers: I32 | None = None
    ) -> None: ...
    @property
    def is_coarse(self) -> bool: ...
    @property
    def patches(self) -> int: ...
    @property
    def pieces(self) -> int: ...

class Tube(Shape):
    """`control_points` (n, 5), each (x, y, z, radius, weight)."""

    def __init__(self, control_points: F64, knots: F64) -> None: ...
    @property
    def pieces(self) -> int: ...

def find_bounds(formula: Expression) -> F64 | None:
    """A box (2, 3) around the inside of a formula; None if it has none, ValueError if it does not end."""

def vm_solid(formula: Expression) -> tuple[Expression, F64 | None, bool]:
    """The solid of a .vm file's formula, where to look for it, and whether that cuts it."""

def linear_color(text: str) -> list[float] | None:
    """Linear RGB of "#rrggbb", "#rgb" or a CSS color name; None of another text."""

class Material:
    """`color` is linear RGB."""

    def __init__(
        self,
        color: tuple[float, float, float],
        ambient: float,
        diffuse: float,
        specular: float,
        shininess: float,
        metallic: float,
        roughness: float,
        emissive: tuple[float, float, float],
        transmission: float = 0,
        ior: float = 1.5,
        attenuation: tuple[float, float, float] = (1, 1, 1),
        attenuation_distance: float = ...,
    ) -> None: ...
    @property
    def color(self) -> list[float]: ...
    @property
    def ambient(self) -> float: ...
    @property
    def diffuse(self) -> float: ...
    @property
    def specular(self) -> float: ...
    @property
    def shininess(self) -> float: ...
    @property
    def metallic(self) -> float: ...
    @property
    def roughness(self) -> float:
        """Below 0 of Blinn-Phong."""
    @property
    def emissive(self) -> list[float]: ...

def shape_digest(kind: str, tensors: dict[str, NDArray[Any]]) -> bytes:
    """SHA-256 of what a shape is."""

def singular_values(map: F64) -> list[float]:
    """Of the linear part of a map, (4, 4): three, the largest first."""

def instance_digest(shape: bytes, transform: F64, material: Material) -> bytes:
    """SHA-256 of a shape's digest, its transform (4, 4), and its material."""

class Arrangement:
    """Shapes in their places: `transforms` (n, 4, 4) take their own units to those of all. ValueError if they are in
    one point, or beyond what float64 holds."""

    def __init__(self, shapes: Sequence[Shape], transforms: F64, materials: Sequence[Material]) -> None: ...
    @property
    def boxes(self) -> F64:
        """(n, 2, 3): the lowest and highest coordinates of each."""
    @property
    def center(self) -> F64: ...
    @property
    def radius(self) -> float: ...
    def scene(self, digests: Sequence[bytes]) -> Scene:
        """As rays meet it, in the unit sphere, and in the canonical order by the digests of the shapes, one for each
        place; in the given one without."""

class DiscLight:
    """`height` is that of its cap of the unit sphere, `color` what a white, rough surface that faces it reflects."""

    def __init__(
        self, direction: tuple[float, float, float], height: float, color: tuple[float, float, float]
    ) -> None: ...

class Environment: ...

def environment(texels: F32) -> Environment:
    """Of (H, W, 3), equirectangular. ValueError if it is too large."""

class Lights:
    def __init__(
        self,
        discs: list[DiscLight],
        top: tuple[float, float, float],
        bottom: tuple[float, float, float],
        environment: Environment | None,
        turn: float,
        ground: float | None,
        radius: float,
        bounces: int,
    ) -> None: ...

class Lighting:
    def __init__(self, scene: Scene, lights: Lights) -> None: ...
    def trace(
        self,
        camera: Camera,
        height: int,
        width: int,
        pixels: I32,
        first: U32,
        count: int,
        seed: int,
        apart: bool,
        layout: Layout,
        samples: F32,
    ) -> None:
        """Writes samples (n, C), means of `count` paths from the one numbered `first` (n,) on."""

    def first_hits(self, camera: Camera, planes: F32) -> None:
        """Writes (10, H, W): mask, depth, normal and albedo of the scene, mask and depth of the ground, `behind`."""

    def hits_at_edges(self, camera: Camera, planes: F32, side: int) -> tuple[I32, F32]:
        """Pixels of first hits (10, H, W) whose neighbours differ, (n, 2), and the hits in them, (n, side**2, 10)."""

STUDIO_LIGHTS: list[tuple[float, float, float, list[float], float]]
"""Discs: azimuth from the camera's on, elevation and angle in degrees, linear RGB, intensity."""
STUDIO_SKY: tuple[list[float], list[float], float]
"""Linear RGB of top and bottom, and their intensity."""
LIGHT_PATHS: int
EDGE_RAYS: tuple[int, int]

class LightPace:
    """Number of pixels in a frame of moving light."""

    def pixels(self, total: int, left: float) -> int:
        """For a picture of so many pixels, and the time left after its first hits."""

    def traced(self, pixels: int, time: float) -> None: ...
    def completed(self, time: float) -> None: ...

class LightHistory:
    """Paths on surfaces, at most one mean for each pixel. `guides` and `ground` are (7, H, W)."""

    layout: ClassVar[Layout]
    def __init__(self, height: int, width: int) -> None: ...
    def __len__(self) -> int: ...
    def move(self, camera: Camera, guides: F32, ground: F32 | None) -> None:
        """Reprojects all samples for another camera."""

    def trace(
        self,
        lighting: Lighting,
        camera: Camera,
        pixels: I32,
        first: U32,
        count: int,
        seed: int,
        at_rest: bool,
        guides: F32,
        ground: F32 | None,
    ) -> F32:
        """Adds `count` paths to each pixel, and returns their means, (n, C) of the layout."""

    def next(self, count: int, seed: int, at_rest: bool, guides: F32, ground: F32 | None) -> I32:
        """The pixels that need paths most, (n, 2)."""

    def write(self, guides: F32, ground: F32 | None, planes: F32) -> None:
        """Writes all samples to planes (C, H, W) of zeros."""

CREASE_OF_EDGES: float

def visible_edges(scene: Scene, camera: Camera, height: int, width: int, smooth: bool) -> tuple[F32, NDArray[np.int64]]:
    """Curves: their points (n, 2), rows and columns, and each one's end among them."""

def joined(points: F32, segments: NDArray[np.uint32], tolerance: float) -> tuple[F32, NDArray[np.int64]]:
    """The curves of segments (m, 2) between points (n, 2)."""

def dashed(points: F32, ends: NDArray[np.int64], dash: float, gap: float) -> tuple[F32, NDArray[np.int64]]: ...
def draw_strokes(points: F32, ends: NDArray[np.int64], width: float, coverage: F32) -> None:
    """Raises `coverage` (H, W) to that of strokes."""

def pixels_at_edges(color: F32, alpha: F32) -> I32:
    """The pixels, (n, 2), of color (H, W, 3) and alpha (H, W) that are far from the mean of two opposite neighbours."""

def smooth_edges(pixels: I32, hits: F32, guides: F32, ground: F32 | None, color: F32, alpha: F32) -> None:
    """Replaces color (3, H, W) and alpha (H, W) at edges by means over their hits, (n, k, 10)."""

class Scene:
    """Where instances coincide, the first is seen. Their numbers are those that they have in the arrangement."""

    def sectioned(self, planes: F64) -> Scene:
        """The same scene, cut by planes (n, 4): normals of length 1, and offsets, in the unit sphere."""

    @property
    def open_instances(self) -> list[int]:
        """Those that a section shows without caps."""

    @property
    def to_shapes(self) -> F64:
        """(n, 3, 4): from the unit sphere to the coordinates in which rays meet each shape."""
    def closest_hits(
        self, origins: F32, directions: F32, t: F32, instance: I32, primitive: I32, u: F64, v: F64
    ) -> None: ...
    def trace_means(self, camera: Camera, height: int, width: int, pixels: I32, side: int) -> F32:
        """The means over side x side rays in each pixel, (n, 5): whether they need more, linear RGB, coverage."""

    def trace(self, camera: Camera, height: int, width: int, pixels: I32, layout: Layout, samples: F32) -> None:
        """Writes samples (n, C): the first number of each says whether the ray hit."""

    @property
    def bytes(self) -> int: ...

class PictureTracing:
    """The pixels of an order, or "tiles" for all of them, from rays to planes (C, H, W) that are 0 at first."""

    def __init__(
        self, scene: Scene, camera: Camera, height: int, width: int, layout: Layout, order: str, seed: int
    ) -> None: ...
    def trace(self, count: int, planes: F32) -> None:
        """Goes on until so many pixels are traced."""

    @property
    def done(self) -> int: ...

class Layout:
    """Channels one after the other, by their names with commas between them; ValueError of one that there is not."""

    def __init__(self, names: str) -> None: ...
    @property
    def names(self) -> str: ...
    @property
    def width(self) -> int:
        """Components of all channels."""

def channels() -> list[tuple[str, int, float, float, float, bool]]:
    """(name, components, low, high, value where a ray missed, whether that is seen) of every channel that there is."""

def gbuffer_layout() -> Layout:
    """What the tracer finds and a G-buffer holds; the mask comes first."""

def remembered_layout(is_colored: bool) -> Layout:
    """The same, with what else a moving camera remembers, to shade anew what another one has seen."""

class Camera:
    """The fields of bobrossnet.Camera; `standpoint`: its position, target and up in the unit sphere's coordinates."""

    def __init__(
        self,
        azimuth: float,
        elevation: float,
        roll: float,
        zoom: float,
        pan: tuple[float, float],
        fov: float,
        standpoint: tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]] | None,
    ) -> None: ...
    def pose(self, height: int, width: int) -> tuple[list[float], list[float], list[float], list[float], float]:
        """Axes to the right, up and toward the camera; the eye, or the picture's centre before the unit sphere; and the
        side of a pixel, in perspective at a distance of 1."""
    def rays(self, height: int, width: int, pixels: I32) -> tuple[NDArray[np.int64], F32, F32]:
        """Which of the pixels' rays meet the unit sphere, (k,); their origins, just outside of it or where the camera
        stands, and directions, (k, 3) each."""
    def seen(self, height: int, width: int, points: F32) -> F32:
        """Row, column and depth at which each of the points (n, 3) of the unit sphere is seen, (n, 3); NaN for row and
        column of what is not in front of the camera."""
    def points(self, height: int, width: int, seen: F32) -> F32:
        """The points, (n, 3), that are seen at rows, columns and depths (n, 3)."""
    def in_scene(self, height: int, width: int, directions: F32, places: F32) -> F32:
        """Directions (n, 3) of the screen space at rows and columns (n, 2), in the scene's axes."""

def pixel_order(order: str, seed: int, height: int, width: int, start: int, pixels: I32) -> None: ...

class RoundOrder:
    """Which pixels come next, round by round, by what those before show."""

    def next(self, layout: Layout, planes: F32) -> I32:
        """The next round, (n, 2) rows and columns; all pixels of the rounds before are in planes (C, H, W)."""
    @property
    def bytes(self) -> int: ...

class AdaptiveOrder(RoundOrder):
    """Wherever they are needed most; where guides (C, H, W) are known, also at surfaces that no traced pixel shows."""

    def __init__(
        self, seed: int, height: int, width: int, guides_layout: Layout | None = None, guides: F32 | None = None
    ) -> None: ...

class SquaresOrder(RoundOrder):
    """Squares that differ, row by row; of a picture whose pixels with a mask, (H, W), are traced already. By priority,
    large ones first."""

    def __init__(self, height: int, width: int, traced: F32 | None = None, by_priority: bool = False) -> None: ...

class History:
    """What earlier pictures say about the next one."""

    def __init__(self, layout: Layout, height: int, width: int) -> None: ...
    def add(self, camera: Camera, planes: F32) -> None:
        """Takes over what was traced, planes (C, H, W)."""
    def expect(self, camera: Camera, planes: F32, off_center: F32, scene: Scene | None = None) -> int:
        """Writes what is expected, planes (C, H, W) and (H, W); returns at how many pixels a surface is.
        Where the layout has the instance, gray and colour are the scene's, shaded anew."""
    def clear(self) -> None: ...
    @property
    def bytes(self) -> int: ...

class RefreshOrder:
    """Which pixels come next where something is expected."""

    def __init__(self, height: int, width: int) -> None: ...
    def begin(self, seed: int) -> None:
        """Begins another picture."""
    def next(self, layout: Layout, traced: F32, picture: F32, off_center: F32, wanted: int) -> I32:
        """The next round, (n, 2) rows and columns; traced and picture are planes (C, H, W)."""

def parallax(before: Camera, after: Camera, height: int, width: int) -> float:
    """How far near things move past those half of all depth behind them, as a share of the picture's height: a median;
    infinite where most of the picture was behind the first camera."""

class FrameConstants:
    """Of the planner, as core/frame/pace.h explains them."""

    least_tracing: float
    margin: float
    untried: float
    doubt: float
    floor: float
    fade: float
    growth: float

    def __init__(self) -> None: ...

class FramePlanner:
    """How frames of so many pixels are made, by the error that is expected when their time is over. Modes: "whole",
    "squares", "adaptive", "reproject"; completions: "filling", "small", "default". It has no clock."""

    def __init__(self, pixels: int, completions: list[str], constants: FrameConstants = ...) -> None: ...
    def traced(self, mode: str, pixels: float, seconds: float, is_first_round: bool) -> None:
        """So many pixels were chosen and traced in so many seconds; those of a first round lie all over the picture,
        whatever they show."""
    def completed(self, completion: str, pixels: float, seconds: float) -> None: ...
    def reprojected(self, pixels: float, seconds: float) -> None: ...
    def plan(self, seconds: float, parallax: float) -> str:
        """How to make a picture in so many seconds; parallax: infinite where nothing can be reprojected."""
    def plan_pixels(self, pixels: int, parallax: float) -> str:
        """The same where a number of pixels is asked for."""
    def completion(self, mode: str, known: float, seconds: float) -> str:
        """What is to complete a picture of which this share is known when a frame of so many seconds is over, infinite
        where it traces nothing further."""
    def for_tracing(self, mode: str, completion: str, seconds: float) -> float:
        """Seconds for tracing in a frame of so many."""
    def for_completing(self, completion: str) -> float:
        """Seconds; 0 where nothing was measured."""
    def pixels_in(self, mode: str, seconds: float) -> float:
        """How many pixels fit into a call of so many seconds; 0 if less than a call costs."""
    def worthwhile(self, mode: str) -> float:
        """How many pixels take as long as the call around them."""

def scatter(layout: Layout, pixels: I32, samples: F32, planes: F32) -> None:
    """Writes samples (n, C) to their pixels in planes (C, H, W)."""

class Network:
    """`tensors` by their names; ValueError if they are not those of such a network, or the layouts are not its own."""

    def __init__(self, name: str, tensors: Mapping[str, F32], inputs: Layout, outputs: Layout) -> None: ...
    @property
    def inputs(self) -> Layout: ...
    @property
    def outputs(self) -> Layout: ...
    def __call__(self, layout: Layout, planes: F32, output: F32) -> None:
        """From a G-buffer's planes (C, H, W) of a layout to the outputs' (width, H, W). ValueError if the layout lacks
        one of the inputs."""

class ErrorPredictor:
    """`tensors` by their names; ValueError if they are not its own."""

    def __init__(self, tensors: Mapping[str, F32]) -> None: ...
    def __call__(self, layout: Layout, planes: F32, gray: F32, error: F32) -> None:
        """From a G-buffer's planes (C, H, W) and a network's own output (1, H, W) to the expected absolute error of the
        completed gray (1, H, W)."""

def error_features(layout: Layout, planes: F32, gray: F32, features: F32) -> None:
    """What an error predictor predicts from, (14, H, W)."""

def interpolate_lattice(known: Layout, planes: F32, completed: Layout, output: F32) -> None:
    """Improves completed channels where traced pixels of the lattice agree."""

def complete_along(
    known: Layout, planes: F32, completed: Layout, known_guide: F32, guide: F32, unit: float | None, output: F32
) -> None:
    """Completes one channel, which `completed` names, by its ratio to a guide of which all pixels are known; where
    traced pixels of the lattice agree it is interpolated. Values of any range come with the `unit` that counts as 1."""

def complete_guided(
    known: Layout, planes: F32, guides_layout: Layout, guides: F32, completed: Layout, covered_only: bool, output: F32
) -> None:
    """Completes gray or color, which `completed` names, along the mask, depth, normal and albedo of all pixels;
    `covered_only` leaves those without coverage at 0."""

def keep_known(known: Layout, planes: F32, completed: Layout, output: F32) -> None:
    """Puts the traced pixels of planes back into completed channels; clamps the others to the channels' ranges."""

class TooLargeError(ValueError):
    """A formula of more steps than the core takes."""

class Expression:
    """A formula f(x, y, z), immutable; equal if its nodes are.

    Node i has the number of an op, ops[i]; up to three earlier nodes, operands[i]; and a constant's value, a power's
    exponent, the place of a mesh, or 1 of a select at which the formula does not jump, values[i]. The last node is the
    result. Meshes are there one after the other: `mesh_sizes` (m, 2), how many vertices and triangles each has,
    `mesh_vertices` (v, 3), -1..1, and `mesh_triangles` (t, 3). ValueError if they are no formula.
    """

    def __init__(
        self,
        ops: U8,
        operands: U32,
        values: F64,
        mesh_sizes: U32 | None = None,
        mesh_vertices: F32 | None = None,
        mesh_triangles: U32 | None = None,
    ) -> None: ...
    @property
    def ops(self) -> U8: ...
    @property
    def operands(self) -> U32: ...
    @property
    def values(self) -> F64: ...
    @property
    def mesh_arrays(self) -> tuple[()] | tuple[U32, F32, U32]:
        """Its meshes as the constructor takes them; empty if it has none."""
    def uses(self, op: str) -> bool: ...
    def __call__(self, points: F64) -> F64:
        """The values at points (n, 3), in double precision."""
    def __len__(self) -> int: ...
    def __hash__(self) -> int: ...

def distance_to_mesh(vertices: F64, triangles: I32) -> Expression:
    """The signed distance from a mesh, (v, 3) and (t, 3); ValueError unless it is closed."""

class ColorFormula:
    """A colour (r, g, b)(x, y, z), linear RGB, immutable; equal if its nodes and roots are.

    Nodes are as of an Expression; red, green and blue are the nodes `roots`. ValueError if they are no formula.
    """

    def __init__(
        self,
        ops: U8,
        operands: U32,
        values: F64,
        roots: U32,
        mesh_sizes: U32 | None = None,
        mesh_vertices: F32 | None = None,
        mesh_triangles: U32 | None = None,
    ) -> None: ...
    @staticmethod
    def constant(r: float, g: float, b: float) -> ColorFormula: ...
    @property
    def ops(self) -> U8: ...
    @property
    def operands(self) -> U32: ...
    @property
    def values(self) -> F64: ...
    @property
    def roots(self) -> U32: ...
    @property
    def mesh_arrays(self) -> tuple[()] | tuple[U32, F32, U32]: ...
    def __call__(self, points: F64) -> F64:
        """The colours (n, 3), clamped to 0..1, at points (n, 3), in double precision."""
    def __len__(self) -> int: ...
    def __hash__(self) -> int: ...

class Graph:
    """Builds expressions. Its values are integers; those of another graph are refused with a ValueError."""

    def __init__(self) -> None: ...
    def x(self) -> int: ...
    def y(self) -> int: ...
    def z(self) -> int: ...
    def constant(self, value: float) -> int: ...
    def unary(self, op: str, a: int, exponent: int = 0) -> int: ...
    def binary(self, op: str, a: int, b: int) -> int: ...
    def select(self, a: int, b: int, c: int) -> int:
        """b where a < 0, else c."""
    def piecewise(self, a: int, b: int, c: int) -> int:
        """The same where b and c meet."""
    def substitute(self, f: Expression, x: int, y: int, z: int) -> int: ...
    def substitute_color(self, f: ColorFormula, x: int, y: int, z: int) -> tuple[int, int, int]: ...
    def expression(self, root: int) -> Expression: ...
    def color_formula(self, r: int, g: int, b: int) -> ColorFormula: ...
    def __len__(self) -> int: ...

class CallError(ValueError):
    """What is wrong with the arguments of a word, in one line."""

class CallTypeError(TypeError):
    """The same, where an argument has the wrong type or there are too many or too few."""

class Sdf:
    """A shape of the modelling language, of 2 or 3 dimensions; k is what `.k()` set."""

    def __init__(
        self, dimensions: int, expression: Expression, k: float | None = None, color: ColorFormula | None = None
    ) -> None: ...
    @property
    def dimensions(self) -> int: ...
    @property
    def expression(self) -> Expression: ...
    @property
    def k(self) -> float | None: ...
    @property
    def color(self) -> ColorFormula | None: ...

class Easing:
    """A function of t, an expression in x."""

    def __init__(self, expression: Expression) -> None: ...
    @property
    def expression(self) -> Expression: ...

def vocabulary() -> list[tuple[Any, ...]]:
    """(name, kind, dimensions, result dimensions, parameters, meaning) of each word.

    A parameter is (name, type, required, default, variadic).
    """

def call(index: int, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    """Call a word of the vocabulary. CallError, CallTypeError or TooLargeError say what can't be."""

def call_method(sdf: Sdf, name: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any: ...
def combine(op: str, a: Sdf, b: Sdf) -> Any:
    """Union "|", intersection "&" or difference "-"."""

def region(outlines: list[NDArray[np.float64]]) -> Expression | None:
    """The signed distance in x and y from what closed outlines wind around; None where that is nothing.

    An outline is (n, 3): x, y and the bulge of the piece from there to the next row's place, from the last to the
    first: the tangent of a quarter of an arc's angle, positive anticlockwise, 0 of a straight line. TooLargeError where
    the formula grows too large.
    """

def run_script(source: bytes) -> Sdf:
    """The shape of a script; ValueError with line and column if it is none."""

def parse_vm(text: bytes) -> Expression:
    """The formula of a .vm file; ValueError with its line if it is none."""

def basis_derivatives(degree: int, knots: F64, u: F64, order: int) -> tuple[NDArray[np.int64], F64]:
    """The spans (k,) of parameters (k,), and the derivatives 0..order of the degree + 1 basis functions that are not
    zero on them, (k, order + 1, degree + 1). Parameters outside of the domain continue its first or last span."""

def homogeneous(points: F64) -> F64:
    """Points (n, k), each with its weight behind it, multiplied by their weights, of which the largest becomes 1."""

def face_extremes(faces: Sequence[Surface], directions: F64) -> F64:
    """(n, 3, 2): the smallest and largest products of each face's points with each of three directions (3, 3)."""

def face_moments(faces: Sequence[Surface]) -> F64:
    """(n, 15): of each face its area, the integral (3,) of its unit normal, that of position times normal, (3, 3), and
    (u, v) of a point inside."""

def surface_derivatives(
    control_points: F64, knots_u: F64, knots_v: F64, degree_u: int, degree_v: int, u: F64, v: F64, order: int
) -> F64:
    """The partial derivatives (k, order + 1, order + 1, 3) of a surface of homogeneous control points (n, m, 4) at
    parameters (k,): [:, i, j] is the i-th in u, the j-th in v. Those with i + j > order are zero."""

def triangulate(points: I32, edges: I32) -> I32:
    """Triangles (t, 3) between points (n, 2), in 0..2**25, that differ, of what an odd number of loops of edges (m, 2)
    surround. ValueError if edges cross."""
