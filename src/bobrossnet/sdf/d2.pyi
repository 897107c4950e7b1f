"""Shapes in two dimensions, and operations on them. Made by docs/modelling.py."""

import numpy as np
from numpy.typing import NDArray

from bobrossnet.sdf.d3 import SDF3
from bobrossnet.sdf.words import Color, Easing, Flat, Points, Size, Vector

ORIGIN: NDArray[np.int_]
X: NDArray[np.int_]
Y: NDArray[np.int_]
UP: NDArray[np.int_]

class SDF2(Flat):
    def union(self, *bs: SDF2, k: float | None = ...) -> SDF2:
        """All points in any of the shapes; k rounds the edges where they meet."""

    def difference(self, *bs: SDF2, k: float | None = ...) -> SDF2:
        """The first shape without the others; k rounds the cuts' edges."""

    def intersection(self, *bs: SDF2, k: float | None = ...) -> SDF2:
        """All points in every one of the shapes; k rounds the edges."""

    def blend(self, *bs: SDF2, k: float = ...) -> SDF2:
        """A weighted mean of distances: k for each next shape, 1 - k for the result so far."""

    def negate(self) -> SDF2:
        """Inside out."""

    def dilate(self, r: float) -> SDF2:
        """Grown by r on all sides, which rounds corners."""

    def erode(self, r: float) -> SDF2:
        """Shrunk by r on all sides."""

    def shell(self, thickness: float) -> SDF2:
        """Hollow: a skin around the surface."""

    def repeat(self, spacing: Size, count: Size | None = ..., padding: Size = ...) -> SDF2:
        """Copies at a spacing (0: no copies along that axis), endless or count on each side; padding is the number
        of neighbours on each side that may reach into a cell."""

    def translate(self, offset: Vector) -> SDF2:
        """Moved by an offset."""

    def scale(self, factor: Size) -> SDF2:
        """Larger by a factor, or one for each axis; then distances are approximate."""

    def elongate(self, size: Size) -> SDF2:
        """Cut through the middle and pulled apart by size on each side of each axis."""

    def color(self, c: Color) -> SDF2:
        """The whole shape in a colour: "#rrggbb", a CSS color name, or three numbers of linear light in 0..1."""

    def rotate(self, angle: float) -> SDF2:
        """Turned around the origin by an angle in radians, clockwise."""

    def circular_array(self, count: int) -> SDF2:
        """Copies turned around the origin."""

    def extrude(self, h: float) -> SDF3:
        """Height h, half of it to either side of z = 0."""

    def extrude_to(self, b: SDF2, h: float, e: Easing = ...) -> SDF3:
        """From shape a at the bottom to shape b at the top, h above it, eased."""

    def revolve(self, offset: float = ...) -> SDF3:
        """Turned around the z axis, its own y becoming z, after a move outwards by an offset."""

def circle(radius: float = ..., center: Vector = ...) -> SDF2:
    """A disk."""

def line(normal: Vector = ..., point: Vector = ...) -> SDF2:
    """Half of the plane: the side that the normal points to."""

def slab(
    x0: float | None = ...,
    y0: float | None = ...,
    x1: float | None = ...,
    y1: float | None = ...,
    k: float | None = ...,
) -> SDF2:
    """The region between lines across the axes; each line is optional, and k rounds the corners."""

def rectangle(size: Size = ..., center: Vector = ..., a: Vector | None = ..., b: Vector | None = ...) -> SDF2:
    """A rectangle of given sides around a center, or from corner a to corner b."""

def rounded_rectangle(size: Size, radius: Size, center: Vector = ...) -> SDF2:
    """A rectangle with round corners: one radius, or four, clockwise from the corner of largest x and y."""

def equilateral_triangle() -> SDF2:
    """A triangle of side 2 that points up, around the origin."""

def hexagon(r: float) -> SDF2:
    """A regular hexagon with corners at r on the x axis."""

def rounded_x(w: float, r: float) -> SDF2:
    """Two crossed lines along the diagonals, w wide, with everything within r of them."""

def polygon(points: Points) -> SDF2:
    """A polygon from its corners in order; where it crosses itself, even-odd."""

def vesica(r: float, d: float) -> SDF2:
    """The intersection of two disks of radius r with centers d to the left and right of the origin."""

def union(a: SDF2, *bs: SDF2, k: float | None = ...) -> SDF2:
    """All points in any of the shapes; k rounds the edges where they meet."""

def difference(a: SDF2, *bs: SDF2, k: float | None = ...) -> SDF2:
    """The first shape without the others; k rounds the cuts' edges."""

def intersection(a: SDF2, *bs: SDF2, k: float | None = ...) -> SDF2:
    """All points in every one of the shapes; k rounds the edges."""

def blend(a: SDF2, *bs: SDF2, k: float = ...) -> SDF2:
    """A weighted mean of distances: k for each next shape, 1 - k for the result so far."""

def negate(other: SDF2) -> SDF2:
    """Inside out."""

def dilate(other: SDF2, r: float) -> SDF2:
    """Grown by r on all sides, which rounds corners."""

def erode(other: SDF2, r: float) -> SDF2:
    """Shrunk by r on all sides."""

def shell(other: SDF2, thickness: float) -> SDF2:
    """Hollow: a skin around the surface."""

def repeat(other: SDF2, spacing: Size, count: Size | None = ..., padding: Size = ...) -> SDF2:
    """Copies at a spacing (0: no copies along that axis), endless or count on each side; padding is the number of
    neighbours on each side that may reach into a cell."""

def translate(other: SDF2, offset: Vector) -> SDF2:
    """Moved by an offset."""

def scale(other: SDF2, factor: Size) -> SDF2:
    """Larger by a factor, or one for each axis; then distances are approximate."""

def elongate(other: SDF2, size: Size) -> SDF2:
    """Cut through the middle and pulled apart by size on each side of each axis."""

def color(other: SDF2, c: Color) -> SDF2:
    """The whole shape in a colour: "#rrggbb", a CSS color name, or three numbers of linear light in 0..1."""

def rotate(other: SDF2, angle: float) -> SDF2:
    """Turned around the origin by an angle in radians, clockwise."""

def circular_array(other: SDF2, count: int) -> SDF2:
    """Copies turned around the origin."""

def extrude(other: SDF2, h: float) -> SDF3:
    """Height h, half of it to either side of z = 0."""

def extrude_to(a: SDF2, b: SDF2, h: float, e: Easing = ...) -> SDF3:
    """From shape a at the bottom to shape b at the top, h above it, eased."""

def revolve(other: SDF2, offset: float = ...) -> SDF3:
    """Turned around the z axis, its own y becoming z, after a move outwards by an offset."""
