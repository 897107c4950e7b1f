"""Shapes that would take minutes to build: their budget of work, and interrupts of building."""

from __future__ import annotations

import signal
import subprocess
import sys
import time

import pytest
from clocks import least
from processes import running

SHAPES = {
    "surface": """
r = np.random.default_rng(0)
n, p = 60, 9
u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
knots = np.concatenate([np.zeros(p), np.linspace(0, 1, n - p + 1), np.ones(p)])
points = np.stack([u, v, r.standard_normal((n, n))], -1)
shape = bob.Brep([bob.Face(points, knots, knots, 10 ** r.uniform(-4, 4, (n, n)))])
""",
    "formula": """
g = _core.Graph()
a = g.binary("add", g.x(), g.binary("multiply", g.y(), g.z()))
for i in range(200_000):
    a = g.unary("sin", a)
shape = bob.Implicit(g.expression(a), ((-1, -1, -1), (1, 1, 1)))
""",
}


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("shape", SHAPES)
def test_building_is_stopped_at_once(shape, stop):
    code = (
        "import signal, numpy as np, bobrossnet as bob\nfrom bobrossnet import _core\n"
        f"signal.signal(signal.SIGTERM, signal.default_int_handler)\n{SHAPES[shape]}\n"
        "print('building', flush=True)\nshape.core\n"
    )

    def stopping() -> float:
        with running([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "building\n"
            time.sleep(0.1)  # the surface takes 0.4 s in all
            process.send_signal(stop)
            start = time.monotonic()
            _, errors = process.communicate(timeout=20)
            assert errors.splitlines()[-1] == "KeyboardInterrupt"
            return time.monotonic() - start

    assert least(stopping, 2) < 2
