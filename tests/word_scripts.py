"""Scripts that call every word of the modelling language, for comparing builds."""

import re

SOLIDS = """\
sphere(1.25, (1, 2, 3))
plane((1, 2, 3), (0.5, 0, 0))
slab(x0=-1, y0=-2, z0=-0.5, x1=1, z1=0.5, k=0.1)
box((1, 2, 3), (0.5, 0, 0))
box(a=(-1, -2, 0), b=(3, 4, 5))
rounded_box((1, 2, 3), 0.25)
wireframe_box((1, 2, 3), 0.125)
torus(1, 0.25)
capsule((-1, 0, 0), (1, 2, 3), 0.25)
cylinder(0.5)
capped_cylinder((-1, 0, 0), (1, 2, 3), 0.25)
rounded_cylinder(0.5, 0.1, 2)
capped_cone((-1, 0, 0), (1, 2, 3), 1, 0.5)
rounded_cone(0.75, 0.25, 1)
ellipsoid((1, 2, 3))
pyramid(1)
tetrahedron(1)
octahedron(1)
dodecahedron(1)
icosahedron(1)
union(sphere(1), box(1.5), torus(1, 0.25))
sphere(1) | box(1.5).k(0.25)
sphere(1) - box(1.5).k(0.25) - cylinder(0.5)
sphere(1) & box(1.5).k(0.25)
difference(sphere(1), box(1.5), cylinder(0.5), k=0.125)
intersection(sphere(1), box(1.5), cylinder(0.5))
sphere(1).blend(box(1.5), k=0.25)
negate(box(1)) & sphere(2)
box(1).dilate(0.25).erode(0.125).shell(0.1)
box(1).translate((1, 2, 3)).scale((1, 2, 3)).rotate(0.5, (1, 2, 3))
torus(1, 0.25).rotate_to(X, (1, 2, 3)).orient((3, 2, 1))
box(1).repeat(2, count=(1, 2, 3))
box(1).repeat((2, 2, 0), padding=1)
box(1).elongate((1, 0.5, 0.25))
box(0.25).circular_array(7, 1)
box(1).twist(0.5)
box(1).bend(0.5)
box(1).bend_linear(-Z, Z, (1, 2, 0), ease.in_out_quad)
box(1).bend_radial(0.25, 2, -0.5, ease.in_out_cubic)
box(1).transition_linear(sphere(1), e=ease.in_out_quad)
box(1).transition_radial(sphere(1), e=ease.in_out_sine)
box((4, 0.5, 0.5)).wrap_around(-2, 2, e=ease.out_quad)
sphere(1).slice().extrude(1)
sphere(1).color("#c33")
""".splitlines()

FLAT = """\
circle(1, (1, 2))
line((1, 2), (0.5, 0)) & circle(3)
d2.slab(x0=-1, y0=-2, x1=1, k=0.1)
rectangle((1, 2), (0.5, 0))
rounded_rectangle((2, 3), (0.1, 0.2, 0.3, 0.4))
equilateral_triangle()
hexagon(1)
rounded_x(1, 0.25)
polygon([(0, 0), (2, 0), (1, 2)])
polygon([(0, 0), (2, 0), (0.5, 0.5), (0, 2)])
vesica(1, 0.5)
hexagon(1).rotate(0.5).translate((1, 2)).scale((1, 2))
hexagon(0.25).translate((1, 0)).circular_array(5)
(hexagon(1) | circle(1).k(0.25)).shell(0.1).repeat((3, 3), count=1)
hexagon(1).elongate((1, 0.5)) - circle(0.25)
hexagon(1).color((0.25, 0.5, 1))
""".splitlines()

EASINGS = ["linear"] + [
    prefix + name
    for name in ("quad", "cubic", "quart", "quint", "sine", "expo", "circ", "elastic", "back", "bounce", "square")
    for prefix in ("in_", "out_", "in_out_")
]

SCRIPTS = (
    SOLIDS
    + [f"({flat}).{solid}" for flat in FLAT for solid in ("extrude(1)", "revolve(3)")]
    + [f"hexagon(1).extrude_to(circle(1), 2, ease.{easing})" for easing in EASINGS]
)

SHAPES = re.compile(r"\b(sphere|box|torus|cylinder|octahedron|circle|rectangle|hexagon)(\((?:[^()]|\([^()]*\))*\))")


def colored(text):
    """Return the script with a colour for each of its shapes of several words."""
    colors = iter(["'#c33'", "(0, 0.25, 1)", "'#fd3'"] * 100)
    return SHAPES.sub(lambda match: f"{match[0]}.color({next(colors)})", text)


COLORED = [colored(text) for text in SCRIPTS if SHAPES.search(text)]
