"""The protocol of SparseBench: see README.md. A change here makes a new version."""

from __future__ import annotations

VERSION = 1

SIZE = (256, 256)
SHARES = (0.005, 0.01, 0.02, 0.05, 0.1, 0.25)
PLANES = ("mask", "gray", "depth", "normal x", "normal y")
MASKS = ("uniform", "lattice")
"""Pixel orders of the track of given masks; the seed is the picture's index."""
FREE = "free"
"""Name of the track of free placement, in the place of a mask's."""

COUNT = 100
"""Number of the package's pictures."""
SEED = 4_100_000_000
"""First seed of their shapes: beyond the seeds of all data sets and reports."""
AZIMUTH_STEP, ELEVATIONS, FOVS = 37, (20, 45), (0, 40)
BRIGHT = 0.25
"""Least mean gray of textured surfaces."""
KINDS = ("shape", "shape", "texture", "isosurface", "nurbs")

ORBIT_EVERY = 4
"""One picture in this number has an orbit."""
ORBIT_FRAMES, ORBIT_STEP, ORBIT_SHARE = 8, 2.0, 0.05

MITSUBA_PATHS = 256
MITSUBA_SCENES = ("Cornell box", "interior", "metal", "still life", "plastic and metal", "rods")
