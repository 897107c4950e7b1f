"""Shapes in three dimensions, and operations on them. Made by docs/modelling.py."""

import numpy as np
from numpy.typing import NDArray

from bobrossnet.sdf.d2 import SDF2
from bobrossnet.sdf.solid import Solid
from bobrossnet.sdf.words import Color, Easing, Size, Vector

ORIGIN: NDArray[np.int_]
X: NDArray[np.int_]
Y: NDArray[np.int_]
Z: NDArray[np.int_]
UP: NDArray[np.int_]

class SDF3(Solid):
    def union(self, *bs: SDF3, k: float | None = ...) -> SDF3:
        """All points in any of the shapes; k rounds the edges where they meet."""

    def difference(self, *bs: SDF3, k: float | None = ...) -> SDF3:
        """The first shape without the others; k rounds the cuts' edges."""

    def intersection(self, *bs: SDF3, k: float | None = ...) -> SDF3:
        """All points in every one of the shapes; k rounds the edges."""

    def blend(self, *bs: SDF3, k: float = ...) -> SDF3:
        """A weighted mean of distances: k for each next shape, 1 - k for the result so far."""

    def negate(self) -> SDF3:
        """Inside out."""

    def dilate(self, r: float) -> SDF3:
        """Grown by r on all sides, which rounds corners."""

    def erode(self, r: float) -> SDF3:
        """Shrunk by r on all sides."""

    def shell(self, thickness: float) -> SDF3:
        """Hollow: a skin around the surface."""

    def repeat(self, spacing: Size, count: Size | None = ..., padding: Size = ...) -> SDF3:
        """Copies at a spacing (0: no copies along that axis), endless or count on each side; padding is the number
        of neighbours on each side that may reach into a cell."""

    def translate(self, offset: Vector) -> SDF3:
        """Moved by an offset."""

    def scale(self, factor: Size) -> SDF3:
        """Larger by a factor, or one for each axis; then distances are approximate."""

    def elongate(self, size: Size) -> SDF3:
        """Cut through the middle and pulled apart by size on each side of each axis."""

    def color(self, c: Color) -> SDF3:
        """The whole shape in a colour: "#rrggbb", a CSS color name, or three numbers of linear light in 0..1."""

    def rotate(self, angle: float, vector: Vector = ...) -> SDF3:
        """Turned around a vector by an angle in radians."""

    def rotate_to(self, a: Vector, b: Vector) -> SDF3:
        """Turned by the angle between two vectors, from b to a."""

    def orient(self, axis: Vector) -> SDF3:
        """Turned by the angle between z and an axis, from the axis to z."""

    def circular_array(self, count: int, offset: float = ...) -> SDF3:
        """Copies in a circle around the z axis, each moved outwards by an offset."""

    def twist(self, k: float) -> SDF3:
        """Turned around the z axis by k radians for each unit of height."""

    def bend(self, k: float) -> SDF3:
        """Bent around the z axis, by k radians for each unit along x."""

    def bend_linear(self, p0: Vector, p1: Vector, v: Vector, e: Easing = ...) -> SDF3:
        """Moved by v beyond p1, not at all before p0, and by an eased share of it on the way."""

    def bend_radial(self, r0: float, r1: float, dz: float, e: Easing = ...) -> SDF3:
        """Raised by dz outside radius r1 around the z axis, by nothing inside r0, and eased between them."""

    def transition_linear(self, f1: SDF3, p0: Vector = ..., p1: Vector = ..., e: Easing = ...) -> SDF3:
        """From shape f0 at p0 to shape f1 at p1, eased."""

    def transition_radial(self, f1: SDF3, r0: float = ..., r1: float = ..., e: Easing = ...) -> SDF3:
        """From shape f0 within radius r0 around the z axis to shape f1 beyond r1, eased."""

    def wrap_around(self, x0: float, x1: float, r: float | None = ..., e: Easing = ...) -> SDF3:
        """The part along x from x0 to x1, wrapped around the z axis at radius r; by default it fits once."""

    def slice(self) -> SDF2:
        """The section in the plane z = 0."""

def sphere(radius: float = ..., center: Vector = ...) -> SDF3:
    """A ball."""

def plane(normal: Vector = ..., point: Vector = ...) -> SDF3:
    """Half of space: the side that the normal points to."""

def slab(
    x0: float | None = ...,
    y0: float | None = ...,
    z0: float | None = ...,
    x1: float | None = ...,
    y1: float | None = ...,
    z1: float | None = ...,
    k: float | None = ...,
) -> SDF3:
    """The region between planes across the axes; each plane is optional, and k rounds the edges."""

def box(size: Size = ..., center: Vector = ..., a: Vector | None = ..., b: Vector | None = ...) -> SDF3:
    """A box of given sides around a center, or from corner a to corner b."""

def rounded_box(size: Size, radius: float) -> SDF3:
    """A box around the origin with round edges and corners."""

def wireframe_box(size: Size, thickness: float) -> SDF3:
    """The twelve edges of a box as bars."""

def torus(r1: float, r2: float) -> SDF3:
    """A ring around the z axis: r1 to the middle of the tube, whose radius is r2."""

def capsule(a: Vector, b: Vector, radius: float) -> SDF3:
    """All points within a radius of the line from a to b."""

def cylinder(radius: float) -> SDF3:
    """A cylinder around the z axis without ends."""

def capped_cylinder(a: Vector, b: Vector, radius: float) -> SDF3:
    """A cylinder from a to b with flat ends."""

def rounded_cylinder(ra: float, rb: float, h: float) -> SDF3:
    """A cylinder around the z axis of radius ra and height h, its edges rounded with radius rb."""

def capped_cone(a: Vector, b: Vector, ra: float, rb: float) -> SDF3:
    """A cone from radius ra at a to radius rb at b, with flat ends."""

def rounded_cone(r1: float, r2: float, h: float) -> SDF3:
    """The hull of two balls: radius r1 at the origin, radius r2 at height h."""

def ellipsoid(size: Size) -> SDF3:
    """An ellipsoid with these semi-axes; its distances are approximate."""

def pyramid(h: float) -> SDF3:
    """A pyramid of height h on a square of side 1."""

def tetrahedron(r: float) -> SDF3:
    """A regular tetrahedron with a corner at (r, r, r)."""

def octahedron(r: float) -> SDF3:
    """A regular octahedron with corners at r on the axes."""

def dodecahedron(r: float) -> SDF3:
    """A regular dodecahedron with edges that touch the sphere of radius r."""

def icosahedron(r: float) -> SDF3:
    """A regular icosahedron with corners on the sphere of radius r."""

def union(a: SDF3, *bs: SDF3, k: float | None = ...) -> SDF3:
    """All points in any of the shapes; k rounds the edges where they meet."""

def difference(a: SDF3, *bs: SDF3, k: float | None = ...) -> SDF3:
    """The first shape without the others; k rounds the cuts' edges."""

def intersection(a: SDF3, *bs: SDF3, k: float | None = ...) -> SDF3:
    """All points in every one of the shapes; k rounds the edges."""

def blend(a: SDF3, *bs: SDF3, k: float = ...) -> SDF3:
    """A weighted mean of distances: k for each next shape, 1 - k for the result so far."""

def negate(other: SDF3) -> SDF3:
    """Inside out."""

def dilate(other: SDF3, r: float) -> SDF3:
    """Grown by r on all sides, which rounds corners."""

def erode(other: SDF3, r: float) -> SDF3:
    """Shrunk by r on all sides."""

def shell(other: SDF3, thickness: float) -> SDF3:
    """Hollow: a skin around the surface."""

def repeat(other: SDF3, spacing: Size, count: Size | None = ..., padding: Size = ...) -> SDF3:
    """Copies at a spacing (0: no copies along that axis), endless or count on each side; padding is the number of
    neighbours on each side that may reach into a cell."""

def translate(other: SDF3, offset: Vector) -> SDF3:
    """Moved by an offset."""

def scale(other: SDF3, factor: Size) -> SDF3:
    """Larger by a factor, or one for each axis; then distances are approximate."""

def elongate(other: SDF3, size: Size) -> SDF3:
    """Cut through the middle and pulled apart by size on each side of each axis."""

def color(other: SDF3, c: Color) -> SDF3:
    """The whole shape in a colour: "#rrggbb", a CSS color name, or three numbers of linear light in 0..1."""

def rotate(other: SDF3, angle: float, vector: Vector = ...) -> SDF3:
    """Turned around a vector by an angle in radians."""

def rotate_to(other: SDF3, a: Vector, b: Vector) -> SDF3:
    """Turned by the angle between two vectors, from b to a."""

def orient(other: SDF3, axis: Vector) -> SDF3:
    """Turned by the angle between z and an axis, from the axis to z."""

def circular_array(other: SDF3, count: int, offset: float = ...) -> SDF3:
    """Copies in a circle around the z axis, each moved outwards by an offset."""

def twist(other: SDF3, k: float) -> SDF3:
    """Turned around the z axis by k radians for each unit of height."""

def bend(other: SDF3, k: float) -> SDF3:
    """Bent around the z axis, by k radians for each unit along x."""

def bend_linear(other: SDF3, p0: Vector, p1: Vector, v: Vector, e: Easing = ...) -> SDF3:
    """Moved by v beyond p1, not at all before p0, and by an eased share of it on the way."""

def bend_radial(other: SDF3, r0: float, r1: float, dz: float, e: Easing = ...) -> SDF3:
    """Raised by dz outside radius r1 around the z axis, by nothing inside r0, and eased between them."""

def transition_linear(f0: SDF3, f1: SDF3, p0: Vector = ..., p1: Vector = ..., e: Easing = ...) -> SDF3:
    """From shape f0 at p0 to shape f1 at p1, eased."""

def transition_radial(f0: SDF3, f1: SDF3, r0: float = ..., r1: float = ..., e: Easing = ...) -> SDF3:
    """From shape f0 within radius r0 around the z axis to shape f1 beyond r1, eased."""

def wrap_around(other: SDF3, x0: float, x1: float, r: float | None = ..., e: Easing = ...) -> SDF3:
    """The part along x from x0 to x1, wrapped around the z axis at radius r; by default it fits once."""

def slice(other: SDF3) -> SDF2:
    """The section in the plane z = 0."""
