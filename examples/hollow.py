"""Hollow a mesh for a 3D printer: a wall, ribs inside, and a drain hole at the bottom; and a picture of the inside.

python examples/hollow.py [mesh file]
"""

import sys

import numpy as np

import bobrossnet as bob
from bobrossnet.sdf import Mesh
from bobrossnet.sdf.d3 import SDF3, Y, capped_cone, cylinder, slab, sphere, torus


def pawn() -> Mesh:
    """Return a chess piece, as a default mesh."""
    body = capped_cone((0, 0, 0), (0, 0, 2.6), 0.95, 0.35) | torus(0.9, 0.25) | sphere(0.65, (0, 0, 2.9)).k(0.15)
    mesh = (body & slab(z0=-0.2)).mesh(0.05)
    return Mesh(mesh.vertices, mesh.triangles)


def hollowed(mesh: Mesh) -> SDF3:
    """Return the mesh hollowed, with a wall of a 40th of its size and crossed ribs."""
    low, high = mesh.bounding_box(np.eye(4))
    size, middle = (high - low).max(), (low + high) / 2
    solid = mesh.sdf()
    inside = solid.erode(size / 40)
    rib = slab(z0=-size / 200, z1=size / 200).repeat(size / 6)
    ribs = (rib.rotate(np.pi / 4, Y) | rib.rotate(-np.pi / 4, Y)).translate(middle)
    drain = (cylinder(size / 20) & slab(z1=size / 6)).translate((middle[0], middle[1], low[2]))
    hollow: SDF3 = solid - (inside.color("#e8b04a") - ribs.color("#e8b04a")) - drain
    return hollow


def main() -> None:
    mesh = Mesh.from_file(sys.argv[1]) if len(sys.argv) > 1 else pawn()
    part = hollowed(mesh)
    low, high = mesh.bounding_box(np.eye(4))
    part.save("hollow.stl", step=(high - low).max() / 100)
    middle = (low + high) / 2
    open_in_front, camera = part & slab(y0=middle[1]), bob.Camera(azimuth=-75, elevation=15)
    bob.render(open_in_front, camera, size=(640, 480), background="#fff").save("hollow.png")
    print(f"hollow.png and hollow.stl: of {mesh}")


if __name__ == "__main__":
    main()
