"""A mesh that stands, and the same as files store it that have y up."""

import bobrossnet as bob
from bobrossnet.sdf import box

STANDING = (box((2, 1.6, 0.2)).translate((0, 0, 0.1)) | box((0.5, 0.5, 2)).translate((-0.2, 0, 1))).mesh(0.05)
LYING = bob.Mesh(STANDING.vertices[:, [0, 2, 1]] * (1, 1, -1), STANDING.triangles)
