"""Types of the modelling words and their operators, for a type checker alone: `make mypy`."""

from typing import assert_type

from bobrossnet import sdf
from bobrossnet.sdf import X, box, circle, cylinder, rectangle, sphere

f = sphere(1) & box(1.5)
f -= cylinder(0.5).orient(X)
assert_type(f | sphere(2).k(0.1), sdf.SDF3)
assert_type(circle(1) - rectangle(1), sdf.SDF2)
sphere(1) | circle(1)  # type: ignore[operator]
