"""NURBS surfaces and tubes from the user's view, compared with closed forms and geomdl."""

import pickle

import numpy as np
import pytest
from nurbs_shapes import cylinder, geomdl_surface, random_surface, sphere, torus

import bobrossnet as bob
from bobrossnet.adapters.container import layout, sealed
from bobrossnet.shapes.affine import mapped, rotation, scaling, translation

SQUARE = np.array([[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 0)]], float)
LINE = [0, 0, 1, 1]
TRIANGLE = [(0, 0), (1, 0), (0, 1)]
PATH = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1)], float)
CUBIC = [0, 0, 0, 0, 1, 1, 1, 1]
NAN = np.nan


def face(points=SQUARE, knots_u=LINE, knots_v=LINE, weights=None, trims=None):
    return bob.Face(points, knots_u, knots_v, weights, trims)


def tube(points=PATH, knots=CUBIC, radius=0.1, weights=None):
    return bob.Tube(points, knots, radius, weights)


# ---- Checks ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: tube(knots=[0, 0, 1]),
            "knots: expected 6 to 8 knots for 4 control points, one for each and degree + 1",
        ),
        (
            lambda: tube(knots=range(9)),
            "knots: expected 6 to 8 knots for 4 control points, one for each and degree + 1",
        ),
        (
            lambda: tube(PATH[:2], [0, 1, 2]),
            "knots: expected 4 knots for 2 control points, one for each and degree + 1",
        ),
        (lambda: tube(knots=[[0, 1]]), "knots: expected shape (n,), got (1, 2)"),
        (lambda: tube(knots="abc"), "knots: expected an array of numbers, got str"),
        (lambda: tube(knots=[0, 0, 0, 0, NAN, 1, 1, 1]), "knots: expected finite numbers, got 1 of 8 NaN or infinite"),
        (lambda: tube(knots=[0, 0, 0, 0, 1, 1, 1, 1e101]), "knots: expected numbers of at most 1e+100 in size"),
        (
            lambda: tube(knots=[0, 0, 0, 1, 0.5, 1, 1, 1]),
            "knots: expected numbers that never decrease, got 1, then 0.5",
        ),
        (
            lambda: tube(knots=[0, 0, 1, 1, 1, 2, 2, 2]),
            "knots: expected a domain, knots[3] to knots[4], that is not empty, got 1 at both",
        ),
        (
            lambda: tube(PATH[[0, 1, 2, 3, 0]], [0, 0, 0.5, 0.5, 0.5, 1, 1]),
            "knots: expected a knot at most degree + 1 = 2 times, got 0.5 3 times",
        ),
        (lambda: tube(PATH, [0, 0, 1, 1, 1, 1]), "knots: expected a knot at most degree + 1 = 2 times, got 1 4 times"),
        (lambda: tube(weights=[1, 1]), "weights: expected shape (4,), got (2,); one weight for each control point"),
        (lambda: tube(weights=[1, 1, NAN, 1]), "weights: expected finite numbers, got 1 of 4 NaN or infinite"),
        (lambda: tube(weights=[1, 1, 0, 1]), "weights: expected numbers above 0, got 0 at weights[2]"),
        (lambda: tube(weights=[1, 1, 1, -2]), "weights: expected numbers above 0, got -2 at weights[3]"),
        (lambda: tube(weights=[1, 1, 1, 1e-11]), "weights: expected weights within a factor of 1e+10, got 1e-11 to 1"),
        (lambda: tube(PATH[:1]), "control_points: expected at least 2 points, got shape (1, 3)"),
        (lambda: tube(PATH[:, :2]), "control_points: expected shape (n, 3), got (4, 2)"),
        (lambda: tube(PATH * NAN), "control_points: expected finite numbers, got 12 of 12 NaN or infinite"),
        (lambda: tube(PATH * 1e101), "control_points: expected numbers of at most 1e+100 in size, got 1e+101"),
        (
            lambda: tube(np.ones((4, 3))),
            "control_points: expected at least two that differ, got [1.0, 1.0, 1.0] 4 times",
        ),
        (lambda: tube(radius=0), "radius: expected a number in (0, 1e+100], got 0"),
        (lambda: tube(radius=NAN), "radius: expected a number in (0, 1e+100], got nan"),
        (lambda: tube(radius="1"), "radius: expected a number, got str '1'"),
        (lambda: tube(radius=[1, 1, -1, 1]), "radius: expected numbers above 0, got -1 at radius[2]"),
        (
            lambda: tube(radius=[1, 1]),
            "radius: expected shape (4,), got (2,); one radius, or one for each control point",
        ),
        (lambda: bob.polyline([(1, 2, 3)] * 3, 1), "points: expected at least two that differ, got [1.0, 2.0, 3.0] 3"),
        (lambda: bob.polyline([(1, 2)], 1), "points: expected shape (n, 3), got (1, 2)"),
        (lambda: bob.polyline(PATH, 0), "radius: expected a number in (0, 1e+100], got 0"),
        (lambda: bob.nurbs_curve(PATH, CUBIC, [1, 1, 1, 0], radius=1), "weights: expected numbers above 0, got 0"),
        (lambda: face(SQUARE[:1]), "control_points: expected at least 2 x 2 points, got shape (1, 2, 3)"),
        (lambda: face(SQUARE[0]), "control_points: expected shape (n, n, 3), got (2, 3)"),
        (lambda: face(knots_u=[0, 1, 1]), "knots_u: expected 4 knots for 2 control points"),
        (lambda: face(knots_v=[0, 0, 1, NAN]), "knots_v: expected finite numbers"),
        (lambda: face(knots_v=[0, 1, 1, 2]), "knots_v: expected a domain, knots_v[1] to knots_v[2], that is not empty"),
        (lambda: face(weights=[1, 1]), "weights: expected shape (2, 2), got (2,)"),
        (lambda: face(weights=[[1, 1], [1, 0]]), "weights: expected numbers above 0, got 0 at weights[1, 1]"),
        (lambda: bob.nurbs_surface(SQUARE, LINE, [0]), "knots_v: expected 4 knots"),
        (lambda: face(trims=3), "trims: expected a sequence of loops, got int"),
        (lambda: face(trims=[TRIANGLE, 3]), "trims[1]: expected points, a TrimCurve or several of these, got int"),
        (lambda: face(trims=["abc"]), "trims[0]: expected points, a TrimCurve or several of these, got str"),
        (lambda: face(trims=[[]]), "trims[0]: expected shape (n, 2), got (0,)"),
        (lambda: face(trims=[TRIANGLE[:2]]), "trims[0]: expected at least 3 points, got 2"),
        (lambda: face(trims=[np.eye(3)]), "trims[0]: expected shape (n, 2), got (3, 3)"),
        (lambda: face(trims=[[(0, 0), (1,)]]), "trims[0]: expected an array of numbers, got list [(0, 0), (1,)]"),
        (lambda: face(trims=[[TRIANGLE, TRIANGLE[:1]]]), "trims[0][1]: expected at least 2 points, got 1"),
        (
            lambda: face(trims=[TRIANGLE, [np.array(TRIANGLE) * NAN, TRIANGLE]]),
            "trims[1][0].control_points: expected finite numbers, got 6 of 6 NaN or infinite",
        ),
        (lambda: bob.TrimCurve(PATH, CUBIC), "control_points: expected shape (n, 2), got (4, 3)"),
        (lambda: bob.TrimCurve(TRIANGLE, [0, 1]), "knots: expected 5 to 6 knots for 3 control points"),
        (lambda: bob.Brep([]), "faces: expected at least one, got none"),
        (lambda: bob.Brep(face()), "faces: expected a sequence of Face, got Face"),
        (lambda: bob.Brep([face(), 3]), "faces[1]: expected a Face, got int"),
        (lambda: face().points(2, 0), "u: expected numbers in the domain 0 to 1, got 2"),
        (lambda: face().points(0, [0, NAN]), "v: expected numbers in the domain 0 to 1, got nan"),
        (lambda: face().points("a", 0), "u: expected an array of numbers, got str"),
        (lambda: face().points([0, 0], [0, 0, 0]), "v: expected a shape that broadcasts with u's (2,), got (3,)"),
        (lambda: face().derivatives(0, 0, -1), "order: expected an integer in 0..9, got -1"),
        (lambda: bob.Scene(face(trims=[])), "shapes: expected a shape or several, got Face"),
        (lambda: bob.Scene(bob.Brep([face(SQUARE * 0)])), "faces: expected at least one face"),
        (
            lambda: bob.Scene(bob.Brep([face(trims=[np.array(TRIANGLE) + 5])])),
            "faces: expected at least one face",
        ),
    ],
)
def test_wrong_inputs_get_one_line(make, message):
    with pytest.raises(bob.InputError) as error:
        make()
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_what_follows_from_the_counts():
    surface = face(np.zeros((3, 4, 3)), [0, 0, 1, 2, 2], [-1, 0, 1, 2, 3, 4, 5])
    assert (surface.degree_u, surface.degree_v) == (1, 2)
    assert surface.domain == ((0, 2), (1, 3))
    assert surface.trims == ()
    assert (tube().degree, tube().domain) == (3, (0, 1))
    curve = bob.TrimCurve(TRIANGLE, [0, 0, 0, 2, 2, 2])
    assert (curve.degree, curve.domain) == (2, (0, 2))


def test_arrays_are_copied_and_frozen():
    points, knots, weights = SQUARE.copy(), np.array(LINE, float), np.ones((2, 2))
    surface, curve, pipe = face(points, knots, knots, weights, [TRIANGLE]), bob.TrimCurve(TRIANGLE, range(5)), tube()
    for of in (surface, surface.trims[0][0], curve, pipe):
        for name in ("control_points", "knots", "knots_u", "knots_v", "weights", "radii"):
            array = getattr(of, name, None)
            if array is not None:
                assert array.dtype == np.float64
                with pytest.raises(ValueError, match="read-only"):
                    array[0] = 7
    points[:] = 7
    assert np.array_equal(surface.control_points, SQUARE)
    with pytest.raises(AttributeError):
        surface.knots_u = knots


def test_loops_of_any_form():
    curve = bob.TrimCurve(TRIANGLE, [0, 0, 1, 2, 2])
    for trims in (
        [TRIANGLE],
        (np.array(TRIANGLE),),
        [curve],
        [[curve]],
        [[TRIANGLE[:2], TRIANGLE[1:]]],
        [[np.array(TRIANGLE[:2]), TRIANGLE[1:]]],
        [[curve, TRIANGLE[::2]]],
    ):
        (loop,) = face(trims=trims).trims
        assert loop[0].control_points[0].tolist() == [0, 0]
        assert all(isinstance(part, bob.TrimCurve) for part in loop)
        assert len(loop) in (1, 2)


def test_polylines_go_from_point_to_point():
    points = [(0, 0, 0), (0, 0, 0), (0, 0, 1), (0, 3, 1)]
    pipe = bob.polyline(points, [1, 2, 3, 4])
    assert (pipe.degree, pipe.domain) == (1, (0, 3))
    assert pipe.control_points.tolist() == [list(map(float, point)) for point in points]
    assert pipe.radii.tolist() == [1, 2, 3, 4]
    assert bob.polyline(points, 2).radii.tolist() == [2, 2, 2, 2]


# ---- Evaluation ------------------------------------------------------------------------------------------


def test_one_parameter_may_go_with_many_of_the_other():
    face = bob.Face([[(0, 0, 0), (0, 1, 0)], [(1, 0, 0), (1, 1, 1)]], [0, 0, 1, 1], [0, 0, 1, 1])
    np.testing.assert_allclose(face.points(np.array([0.0, 0.5, 1.0]), 1.0), [(0, 1, 0), (0.5, 1, 0.5), (1, 1, 1)])


@pytest.mark.parametrize("seed", range(6))
def test_points_and_derivatives_are_geomdl_s(seed):
    rng = np.random.default_rng(seed)
    (surface,) = random_surface(rng).faces
    theirs = geomdl_surface(surface)
    u, v = (rng.uniform(low, high, 5) for low, high in surface.domain)
    grid = surface.derivatives(u[:, None], v[None, :], 2)
    assert grid.shape == (5, 5, 3, 3, 3)
    for i in range(5):
        for j in range(5):
            expected = np.array(theirs.derivatives(u[i], v[j], 2))
            for k in range(3):
                for m in range(3 - k):
                    assert grid[i, j, k, m] == pytest.approx(expected[k, m], rel=1e-9, abs=1e-9)
    assert np.array_equal(surface.points(u, v), surface.derivatives(u, v, 0)[:, 0, 0])
    assert surface.points(u[0], v[0]).shape == (3,)


def test_normals_of_a_sphere():
    (ball,) = sphere(2.0).faces
    u, v = np.meshgrid(np.linspace(0, 2, 9), np.linspace(0, 4, 9))
    points, normals = ball.points(u, v), ball.normals(u, v)
    assert np.abs(np.linalg.norm(points, axis=2) - 2).max() < 1e-14
    pole = np.isin(u, (0, 2))
    assert np.abs(np.abs((points * normals).sum(axis=2)) - 2)[~pole].max() < 1e-13
    assert not normals[pole].any()


def test_weights_count_by_their_ratios():
    rng = np.random.default_rng(3)
    (surface,) = random_surface(rng, rational=True).faces
    for scale in (1e-90, 1e90):
        scaled = face(surface.control_points, surface.knots_u, surface.knots_v, surface.weights * scale)
        assert scaled.points(1.5, 2.5) == pytest.approx(surface.points(1.5, 2.5), rel=1e-13)


# ---- Files -----------------------------------------------------------------------------------------------


def shapes():
    rng = np.random.default_rng(1)
    mixed = [*random_surface(rng, rational=False).faces, *cylinder().faces, *random_surface(rng, rational=True).faces]
    return [
        bob.Brep(mixed),
        torus(),
        face_of_two_loops(),
        tube(),
        tube(radius=[0.1, 0.2, 0.1, 0.3], weights=[1, 2, 1, 1]),
        bob.polyline(PATH, 0.2),
    ]


def face_of_two_loops():
    half = [
        [(0.2, 0.2), (0.8, 0.2)],
        bob.TrimCurve([(0.8, 0.2), (0.8, 0.8), (0.2, 0.2)], [0, 0, 0, 1, 1, 1], [1, 3, 1]),
    ]
    return bob.nurbs_surface(SQUARE, LINE, LINE, trims=[half, [(0.3, 0.25), (0.4, 0.25), (0.4, 0.3)]])


@pytest.mark.parametrize("number", range(6))
def test_shapes_round_trip(number, tmp_path):
    shape = shapes()[number]
    bob.save_scene(shape, tmp_path / "a.bob")
    for again in (bob.load(tmp_path / "a.bob").instances[0].shape, pickle.loads(pickle.dumps(shape))):
        assert type(again) is type(shape)
        assert again.digest == shape.digest
        assert {name: t.tobytes() for name, t in again.tensors().items()} == {
            name: t.tobytes() for name, t in shape.tensors().items()
        }
        assert repr(again) == repr(shape)
        if isinstance(shape, bob.Brep):
            assert [f.weights is None for f in again.faces] == [f.weights is None for f in shape.faces]
            assert [list(map(len, f.trims)) for f in again.faces] == [list(map(len, f.trims)) for f in shape.faces]
    assert bob.trace(bob.load(tmp_path / "a.bob"), size=(32, 32)) == bob.trace(shape, size=(32, 32))


def changed(shape, **arrays):
    return {name: arrays.get(name, tensor) for name, tensor in shape.tensors().items()}


BREP = face_of_two_loops()
FACES = BREP.tensors()["faces"]


@pytest.mark.parametrize(
    ("cls", "tensors", "message"),
    [
        (bob.Brep, {}, "control_points: expected an array of float64, got none"),
        (bob.Brep, {**BREP.tensors(), "more": FACES}, "more: expected only faces"),
        (bob.Brep, changed(BREP, faces=FACES.astype(np.int64)), "faces: expected int32, got int64"),
        (bob.Brep, changed(BREP, faces=FACES[:, :4]), "faces: expected shape (n, 5), got (1, 4)"),
        (bob.Brep, changed(BREP, faces=FACES[:0]), "control_points: expected 0, got 4"),
        (bob.Brep, changed(BREP, faces=-FACES), "faces: expected counts of at least 0, got -2"),
        (bob.Brep, changed(BREP, faces=FACES + 1), "faces[0].control_points: expected 9 and more, got 4"),
        (
            bob.Brep,
            changed(BREP, faces=np.full((1, 5), 2**31 - 1, np.int32)),
            f"faces[0].control_points: expected {(2**31 - 1) ** 2} and more, got 4",
        ),
        (bob.Brep, changed(BREP, faces=FACES * [0, 1, 1, 1, 1]), "faces: expected int32, got int64"),
        (
            bob.Brep,
            changed(BREP, faces=np.int32([[0, 2, 1, 1, 2]])),
            "faces[0].control_points: expected at least 2 x 2 points, got shape (0, 2, 3)",
        ),
        (bob.Brep, changed(BREP, faces=np.int32([[2, 2, 1, 2, 2]])), "faces[0].knots: expected 9 and more, got 8"),
        (bob.Brep, changed(BREP, faces=np.int32([[2, 2, 1, 0, 2]])), "faces[0].knots_v: expected 4 knots"),
        (bob.Brep, changed(BREP, faces=np.int32([[2, 2, 1, 1, 3]])), "faces[0].loops: expected 3 and more, got 2"),
        (bob.Brep, changed(BREP, loops=np.int32([2, -1])), "loops: expected counts of at least 0, got -1"),
        (bob.Brep, changed(BREP, loops=np.int32([2, 0])), "faces[0].trims[1]: expected shape (n, 2), got (0,)"),
        (bob.Brep, changed(BREP, loops=np.int32([2, 2**31 - 1])), "faces[0].trims[1][1].trims: expected 4 and more"),
        (bob.Brep, changed(BREP, trims=BREP.tensors()["trims"] + np.int32(1)), "faces[0].trims[0][0]."),
        (
            bob.Brep,
            changed(BREP, trim_knots=BREP.tensors()["trim_knots"][::-1]),
            "faces[0].trims[0][0].knots: expected",
        ),
        (bob.Brep, changed(BREP, knots=BREP.tensors()["knots"] * NAN), "faces[0].knots_u: expected finite numbers"),
        (bob.Brep, changed(BREP, control_points=np.zeros((4, 4))), "faces[0].weights: expected numbers above 0"),
        (bob.Brep, changed(BREP, control_points=np.zeros((5, 4))), "faces[0].weights: expected numbers above 0"),
        (bob.Brep, changed(BREP, control_points=np.ones((5, 4))), "control_points: expected 4, got 5"),
        (bob.Brep, changed(BREP, control_points=np.ones((4, 3))), "control_points: expected shape (n, 4), got (4, 3)"),
        (bob.Tube, changed(tube(), radii=np.float64(1)), "radii: expected shape (n,), got ()"),
        (bob.Tube, changed(tube(), radii=np.zeros(4)), "radius: expected numbers above 0, got 0 at radius[0]"),
        (bob.Tube, changed(tube(), knots=np.zeros(8)), "knots: expected a domain"),
        (bob.Tube, {**tube().tensors(), "weights": np.zeros(4)}, "weights: expected numbers above 0"),
        (bob.Tube, {**tube().tensors(), "degree": np.zeros(4)}, "degree: expected only control_points, knots, radii"),
    ],
)
def test_tensors_that_are_no_shape_are_refused(cls, tensors, message):
    with pytest.raises(bob.InputError) as error:
        cls.from_tensors(tensors)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("number", [0, 2, 4])
def test_damaged_tensors_make_a_picture_or_one_line(number, tmp_path):
    shape = shapes()[number]
    rng = np.random.default_rng(number)
    scene = {
        "shapes": [shape.kind],
        "instances": [
            {
                "shape": 0,
                "transform": np.eye(4).tolist(),
                "material": {"color": [1, 1, 1], "ambient": 0, "diffuse": 1, "specular": 0, "shininess": 1},
                "name": None,
            }
        ],
    }
    refused = 0
    for _ in range(40):
        tensors = {name: tensor.copy() for name, tensor in shape.tensors().items()}
        name = rng.choice(list(tensors))
        content = tensors[name].reshape(-1).view(np.uint8)
        content[rng.integers(len(content))] ^= 1 << rng.integers(8)
        (tmp_path / "a.bob").write_bytes(sealed(layout(scene, {f"0.{name}": t for name, t in tensors.items()})))
        try:
            bob.trace(bob.load(tmp_path / "a.bob"), size=(8, 8))
        except bob.InputError as error:
            refused += 1
            assert "\n" not in str(error)  # noqa: PT017
    assert refused > 3


# ---- Words -----------------------------------------------------------------------------------------------


def test_descriptions():
    mixed = shapes()[0]
    words = mixed.describe()
    assert words["faces"] == "5, 2 trimmed, 2 rational"
    assert "(1, 1) x 2" in words["degrees"]
    assert words["control points"] == f"{sum(f.control_points.size // 3 for f in mixed.faces)}"
    assert words["trims"] == "2 loops of 2 curves"
    assert " in " in words["patches"]
    assert words["patches"].endswith(" MiB")
    assert bob.Brep([face(trims=[TRIANGLE])]).describe()["trims"] == "1 loop of 1 curve"
    assert bob.Brep([face()]).describe()["trims"] == "none"
    words = tube(radius=[1, 2, 3, 4]).describe()
    assert words["thickness"] == "radius 1 to 4"
    assert (words["degree"], words["control points"]) == ("3", "4, not rational")
    assert tube(weights=[1, 1, 1, 2]).describe()["control points"] == "4, rational"
    assert bob.Scene([mixed, mixed, tube()]).describe() == "3 shapes, 10 faces, 1 tube"
    assert bob.Scene([mixed, tube()]).counts() == {"shape": 2, "face": 5, "tube": 1}


# ---- Rays ------------------------------------------------------------------------------------------------


def rays(seed, count):
    """Return rays from outside and inside the unit sphere, towards points about its centre."""
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    outside = rng.integers(2, size=(count, 1))
    return (0.6 + 0.6 * outside) * rng.uniform(-1, 1, (count, 3)) - 3 * outside * direction, direction


def distances(solid, origin, direction, steps=4000):
    """Return the first roots of a signed distance along rays, by sphere tracing."""
    t = np.zeros(len(origin))
    sign = np.sign(solid(origin))
    for _ in range(steps):
        d = sign * solid(origin + t[:, None] * direction)
        t = np.minimum(t + np.maximum(d, 0), 20)
        if ((d < 1e-10) | (t == 20)).all():
            break
    return np.where((d < 1e-9) & (t < 10), t, np.inf)


def ball_distance(p):
    return np.linalg.norm(p, axis=1) - 1


def torus_distance(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.7, p[:, 2]) - 0.25


def cylinder_distance(p):
    across, along = np.hypot(p[:, 0], p[:, 1]) - 0.7, np.abs(p[:, 2] + 0.1) - 0.5
    return np.minimum(np.maximum(across, along), 0) + np.hypot(np.maximum(across, 0), np.maximum(along, 0))


SOLIDS = {
    "sphere": (sphere, ball_distance),
    "torus": (torus, torus_distance),
    "cylinder": (cylinder, cylinder_distance),
    "straight tube": (
        lambda: bob.polyline([(-0.5, 0, 0), (0.5, 0, 0)], 0.3),
        lambda p: (
            np.linalg.norm(p - np.stack([np.clip(p[:, 0], -0.5, 0.5), *np.zeros((2, len(p)))], axis=1), axis=1) - 0.3
        ),
    ),
}

PLACES = [
    np.eye(4),
    translation((1e4, 0, -300)) @ scaling(1e-3),
    translation((0, 7, 0)) @ rotation(0.7, (1, 2, 3)) @ scaling(1e5),
]


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("place", PLACES, ids=["in place", "small and afar", "large and turned"])
def test_hits_are_those_of_the_closed_form(name, place):
    """Except for rays within 1e-4 radii of a silhouette or an edge; distances within 1e-5 radii."""
    make, solid = SOLIDS[name]
    origin, direction = rays(4, 2000)
    expected = distances(solid, origin, direction)
    unit = np.linalg.norm(place[:3, 0])
    scene = bob.Scene(bob.Instance(make(), place))
    hits = scene.closest_hits(mapped(place, origin), direction @ place[:3, :3].T)
    differ = np.isfinite(hits.distance) != np.isfinite(expected)
    assert differ.mean() < 2e-3
    both = np.isfinite(hits.distance) & np.isfinite(expected)
    assert 0.2 < both.mean() < 0.98
    points = origin + np.where(both, hits.distance / unit, 0)[:, None] * direction
    rounding = 4e-16 * np.abs(place[:3, 3]).max() / unit
    assert np.abs(solid(points[both])).max() < 1e-5 + rounding
    assert (np.abs(hits.distance[both] / unit - expected[both]) > 1e-4).mean() < 2e-3


def test_parameters_of_hits_are_where_they_are():
    rng = np.random.default_rng(8)
    for seed, shape in enumerate(
        [sphere(), torus(), cylinder(), *(random_surface(rng) for _ in range(4)), shapes()[0]]
    ):
        place = PLACES[seed % 3]
        scene = bob.Scene([bob.Instance(shape, place)])
        origin, direction = rays(seed, 500)
        hits = scene.closest_hits(mapped(place, origin), direction @ place[:3, :3].T)
        hit = hits.instance == 0
        assert hit.mean() > 0.1
        points = mapped(place, origin)
        points[hit] += hits.distance[hit, None] * unit_rows(direction @ place[:3, :3].T)[hit]
        for i in np.flatnonzero(hit):
            (of,) = shape.faces[hits.primitive[i] : hits.primitive[i] + 1]
            there = mapped(place, of.points(*clipped(of, hits.u[i], hits.v[i]))[None])[0]
            assert np.linalg.norm(there - points[i]) < 2e-5 * scene.radius
        miss = ~hit
        assert (hits.primitive[miss] == -1).all()
        assert not hits.u[miss].any()
        assert not hits.v[miss].any()


def unit_rows(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def clipped(of, u, v):
    """Clamp parameters that leave the domain by rounding."""
    (u0, u1), (v0, v1) = of.domain
    assert u0 - 1e-5 * (u1 - u0) <= u <= u1 + 1e-5 * (u1 - u0)
    assert v0 - 1e-5 * (v1 - v0) <= v <= v1 + 1e-5 * (v1 - v0)
    return np.clip(u, u0, u1), np.clip(v, v0, v1)


def test_the_parameter_of_a_tube():
    pipe = bob.polyline([(0, 0, 0), (1, 0, 0), (1, 0, 2)], 0.1)
    hits = bob.Scene(pipe).closest_hits([(0.25, 0, 5), (5, 0, 1.5), (9, 9, 9)], [(0, 0, -1), (-1, 0, 0), (0, 0, 1)])
    assert hits.distance[:2] == pytest.approx([4.9, 3.9], rel=1e-5)
    assert hits.u == pytest.approx([0.25, 1.75, 0], abs=1e-5)
    assert hits.v.tolist() == [0, 0, 0]


# ---- Extents ---------------------------------------------------------------------------------------------


def samples(shape):
    """Return many points of an untrimmed shape."""
    grids = [np.meshgrid(*(np.linspace(*ends, 201) for ends in of.domain)) for of in shape.faces]
    return np.concatenate([of.points(u, v).reshape(-1, 3) for of, (u, v) in zip(shape.faces, grids, strict=True)])


MAPS = [*PLACES, rotation(0.3, (0, 1, 1)) @ scaling((1, 2, 0.3)), scaling((-1, 1, 1)) @ translation((1e6, 0, 0))]


@pytest.mark.parametrize("place", MAPS, ids=range(len(MAPS)))
@pytest.mark.parametrize("seed", [None, 1, 2, 3])
def test_boxes_hold_the_surface_closely(seed, place):
    """Within 1e-3 of the shape's size, and never too small beyond float32 rounding."""
    shape = torus() if seed is None else random_surface(np.random.default_rng(seed))
    points = mapped(place, samples(shape))
    center = points.mean(axis=0)
    size = np.linalg.norm(place[:3, :3], 2) * 1.8
    rounding = 1e-6 * size + 1e-15 * np.abs(points).max()
    low, high = shape.bounding_box(place)
    assert (low <= points.min(axis=0) + rounding).all()
    assert (high >= points.max(axis=0) - rounding).all()
    assert np.abs(low - points.min(axis=0)).max() < 1.5e-3 * size
    assert np.abs(high - points.max(axis=0)).max() < 1.5e-3 * size
    farthest = np.linalg.norm(points - center, axis=1).max()
    assert farthest - rounding <= shape.radius(place, center) < farthest + 1.5e-3 * size


def test_boxes_of_what_trims_leave():
    low, high = bob.nurbs_surface(SQUARE, LINE, LINE, trims=[[(0.1, 0.2), (0.5, 0.2), (0.1, 0.7)]]).bounding_box(
        np.eye(4)
    )
    assert low == pytest.approx([0.1, 0.2, 0], abs=1e-3)
    assert high == pytest.approx([0.5, 0.7, 0], abs=1e-3)


@pytest.mark.parametrize("place", PLACES, ids=range(3))
def test_boxes_of_tubes(place):
    path, radii = [(0, 0, 0), (1, 0, 0), (1, 2, 0)], [0.1, 0.3, 0.2]
    pipe = bob.polyline(path, radii)
    unit = np.linalg.norm(place[:3, 0])
    ends = mapped(place, np.array(path, float))
    reach = unit * np.array(radii)[:, None]
    low, high = pipe.bounding_box(place)
    slack = 2.5e-3 * unit + 1e-15 * np.abs(ends).max()
    assert low == pytest.approx((ends - reach).min(axis=0), abs=slack)
    assert high == pytest.approx((ends + reach).max(axis=0), abs=slack)
    farthest = (np.linalg.norm(ends - ends[0], axis=1) + reach[:, 0]).max()
    assert pipe.radius(place, ends[0]) == pytest.approx(farthest, abs=slack)


def test_an_ellipsoid_of_a_ball_s_sweep():
    """Boxes are exact under general affine maps, distances up to the ratio of their singular values."""
    pipe = bob.polyline([(-1, 0, 0), (1, 0, 0)], 0.5)
    low, high = pipe.bounding_box(scaling((1, 2, 0.1)))
    assert high == pytest.approx([1.5, 1, 0.05], abs=2e-3)
    assert low == pytest.approx([-1.5, -1, -0.05], abs=2e-3)
    assert 1.5 <= pipe.radius(scaling((1, 2, 0.1)), np.zeros(3)) <= 2 + 5e-3
