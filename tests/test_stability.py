"""Temporal stability: properties of the measure, and networks, fillings and orders at toy size."""

import csv
import io
from functools import partial

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.evaluation.scenes import own_scenes, scenes_of_dataset, scenes_of_folder
from bobrossnet.learn.evaluation.stability import (
    ORBIT_FRACTIONS,
    Stability,
    change_and_flicker,
    measure_stability,
    moving_flicker,
)
from bobrossnet.support.errors import InputError, InputWarning

TRIANGLE = "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"
TOY = {"frames": 4, "size": (24, 32), "orbit_frames": 2}


# ---- The measure -----------------------------------------------------------------------------------------


def test_monotone_convergence_has_no_flicker():
    rng = np.random.default_rng(0)
    truth, start = rng.random((2, 12, 13))
    progress = np.sort(rng.random((9, 12, 13)), 0)  # each pixel at a different pace, from both sides, without overshoot
    measured = change_and_flicker(start + progress * (truth - start), truth)
    np.testing.assert_allclose(measured[1:, 1], 0, atol=1e-15)
    assert (measured[1:, 0] > 0.01).all()
    assert np.isnan(measured[0, :2]).all()


def test_a_step_away_counts_twice():
    """0.2 away and back: each frame changes by 0.2, and all of it is flicker, counted at the step away."""
    truth = np.full((4, 5), 0.9)
    frames = np.stack([truth - (0.3 if i % 2 == 0 else 0.5) for i in range(6)])
    change, flicker, error = change_and_flicker(frames, truth).T
    np.testing.assert_allclose(change[1:], 0.2)
    np.testing.assert_allclose(flicker[1:], [0.4, 0, 0.4, 0, 0.4], atol=1e-15)
    np.testing.assert_allclose(error, [0.3, 0.5] * 3)


def test_to_pass_the_truth_is_flicker():
    frames = np.array([0.0, 0.75]).reshape(2, 1, 1)
    assert change_and_flicker(frames, np.array([[0.5]]))[1].tolist() == [0.75, 0.5, 0.25]


def test_flicker_is_never_negative_and_adds_up():
    rng = np.random.default_rng(1)
    frames, truth = rng.random((7, 8, 9)), rng.random((8, 9))
    change, flicker, error = change_and_flicker(frames, truth).T
    assert (flicker[1:] >= 0).all()
    assert flicker[1:].sum() == pytest.approx(change[1:].sum() - (error[0] - error[-1]))


def test_on_an_orbit_the_truths_own_change_is_no_flicker():
    rng = np.random.default_rng(2)
    truths = rng.random((4, 5, 6))
    assert moving_flicker(truths + 0.1, truths) == pytest.approx(0)
    assert moving_flicker(truths + 0.1 * (-1) ** np.arange(4)[:, None, None], truths) == pytest.approx(0.2)
    with pytest.raises(InputError, match="at least 2, got 1"):
        moving_flicker(truths[:1], truths[:1])
    with pytest.raises(InputError, match="frames: expected shape"):
        change_and_flicker(truths[:, :4], truths[0])


# ---- Methods ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stability():
    scenes = {"tree": bob.happy_tree, "ball": lambda: bob.implicit(lambda x, y, z: x * x + y * y + z * z - 1)}
    return measure_stability(scenes, ["paper"], fillings=["delaunay-linear", "nearest"], **TOY)


def test_networks_and_fillings(stability):
    methods = ["paper raw", "paper kept", "delaunay-linear", "nearest"]
    assert list(stability.frames) == list(stability.orbit) == [(method, "uniform") for method in methods]
    assert stability.shapes == ("tree", "ball")
    for (method, _), frames in stability.frames.items():
        assert frames.shape == (2, 4, 3)
        assert (frames[:, 1:, 1] >= -1e-12).all()
        assert (frames[:, -1, 2] == 0).all() == (method != "paper raw")  # all traced: exact, except for the raw output
        assert np.isfinite(stability.orbit[method, "uniform"]).all()
    raw, kept = (stability.mean(method) for method in methods[:2])
    assert raw[:, 2].mean() > kept[:, 2].mean()
    flicker, change = stability.total("paper kept")
    assert 0 < flicker < change
    assert flicker == pytest.approx(change - kept[0, 2])  # from its first error to 0

    view = bob.trace(bob.happy_tree(), bob.Camera(azimuth=40, elevation=25), size=TOY["size"])
    frames = [bob.complete(view.sample(fraction, order="uniform"), model="paper") for fraction in stability.fractions]
    np.testing.assert_allclose(stability.frames["paper kept", "uniform"][0], change_and_flicker(frames, view.gray))


def made_up(order, flickers):
    """Return a network with given flicker by view, in a single step and in orbits; nearest has 0.4 and 0.1."""
    flickers = np.array(flickers)

    def frames(values):
        return np.stack([[[np.nan, np.nan, 0.5], [0.5 + value, value, 0]] for value in values])

    ones = np.ones_like(flickers)
    return Stability(
        tuple(f"shape {i}" for i in range(len(flickers))),
        np.array([0.01, 1]),
        {("mine kept", order): frames(flickers), ("nearest", order): frames(0.4 * ones)},
        ORBIT_FRACTIONS,
        {
            ("mine kept", order): np.outer(flickers, [0.1, 0.05]),
            ("nearest", order): np.outer(ones, [0.1, 0.05]),
        },
    )


def test_changes_are_in_pairs_with_their_intervals():
    made = made_up("uniform", [0.1, 0.3])
    # Half of 0.4 on average, deviations ±0.1 / 0.4, t with 1 degree of freedom is 12.7; a fifth in the orbits, ±0.1 of
    # it.
    half = 12.7062047 * 0.25
    expected = [[-0.5, half], [-0.8, 0.4 * half], [-0.8, 0.4 * half]]
    np.testing.assert_allclose(made.change_of_flicker("mine kept", "nearest"), expected)
    row = "| from nearest | -50.0 ± 317.7 | -80.0 ± 127.1 | -80.0 ± 127.1 |"
    assert made.change_table("mine kept").splitlines()[-1] == row
    lines = made.table().splitlines()
    assert lines[0] == "| method    | flicker of all frames | of all change, % | orbit at 5 % | orbit at 25 % |"
    assert lines[2] == "| mine kept |             **51.00** |        **28.57** |     **5.10** |      **2.55** |"
    assert made.table() in str(made)
    assert made.change_table("mine kept") in str(made)
    assert np.isnan(made_up("uniform", [0.1]).change_of_flicker("mine kept", "nearest")[:, 1]).all()


def test_orders_side_by_side():
    both = made_up("uniform", [0.1, 0.3]).beside(made_up("other", [0.05, 0.1]))
    assert both.orders == ("uniform", "other")
    rows = both.change_table(("mine kept", "other")).splitlines()[2:]
    assert [row.split("|")[1].strip() for row in rows] == [
        "from mine kept, uniform",
        "from nearest, uniform",
        "from nearest, other",
    ]
    again = Stability.from_csv(both.csv())
    assert (again.shapes, again.orbit_fractions, list(again.frames)) == (
        both.shapes,
        ORBIT_FRACTIONS,
        list(both.frames),
    )
    assert str(again) == str(both)
    with pytest.raises(InputError, match="other: expected a stability of the same views"):
        both.beside(made_up("uniform", [0.1]))
    with pytest.raises(
        InputError, match="method: expected one of mine kept, nearest in order uniform, other, got 'mine'"
    ):
        both.total("mine")
    for text in ("", both.csv().replace("0.01", "x"), "\n".join(both.csv().splitlines()[:-1])):
        with pytest.raises(InputError, match="text: expected the result of a stability measurement, got "):
            Stability.from_csv(text)


def test_csv_has_every_number(stability):
    rows = list(csv.DictReader(io.StringIO(stability.csv())))
    assert len(rows) == 4 * 2 * (4 + len(ORBIT_FRACTIONS))
    assert (rows[0]["flicker"], rows[0]["shape"]) == ("", "tree")
    expected = stability.frames["paper raw", "uniform"][0, 1, 1]
    assert float(rows[1]["flicker"]) == pytest.approx(expected, rel=1e-5)


# ---- Scenes ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("models")
    for name in ("a", "b"):
        (place / f"{name}.obj").write_text(TRIANGLE)
    (place / "c.obj").write_text("f 1 2 3\n")
    return place


def test_shapes_of_a_folder(folder):
    assert list(scenes_of_folder(folder)) == ["a.obj", "b.obj", "c.obj"]
    with pytest.warns(InputWarning, match=r"left out: c\.obj: "):
        stability = measure_stability(scenes_of_folder(folder, 2), [], fillings=["nearest"], **TOY)
    assert stability.shapes == ("a.obj",)
    with pytest.warns(InputWarning, match="left out"):
        with pytest.raises(InputError, match="scenes: expected at least one that can be loaded, got none"):
            measure_stability(scenes_of_folder(folder / "c.obj"), [], fillings=["nearest"], **TOY)


def test_shapes_of_a_data_set(tmp_path):
    dataset = Dataset.create(tmp_path / "data", Plan(seed=5, shapes=3, test_shapes=2), ["made 7", "made 8", "made 9"])
    scenes = scenes_of_dataset(dataset)
    tested = sorted({dataset.plan.sample(int(number)).shape for number in dataset.plan.split("test")})
    assert list(scenes) == [f"made {7 + shape}" for shape in tested]
    assert isinstance(next(iter(scenes.values()))(), bob.Scene)
    assert list(scenes_of_dataset(dataset, 1)) == list(scenes)[:1]


def test_shapes_of_the_package_itself():
    first, second = own_scenes(2).values()
    assert isinstance(first(), bob.Scene)
    assert first().radius != second().radius


def test_the_command_prints_it(folder, capsys, monkeypatch):
    monkeypatch.setattr("bobrossnet.learn.evaluation.costs.SIZE", (48, 64))
    monkeypatch.setattr("bobrossnet.learn.evaluation.stability.measure_stability", partial(measure_stability, **TOY))
    options = ["--models", "paper", "--orders", "uniform", "--limit", "1", "--fractions", "5%", "--size", "16x16"]
    assert cli.main(["evaluate", str(folder), *options]) == 0
    assert "Flicker" not in capsys.readouterr().out
    assert cli.main(["evaluate", str(folder), *options, "--stability"]) == 0
    printed = capsys.readouterr().out
    assert "Flicker in gray levels of 255, means over 1 shape." in printed
    assert "| from delaunay-linear |" in printed


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"frames": 1}, "frames: expected an integer in 2"),
        ({"orbit_frames": 1}, "orbit_frames: expected an integer in 2"),
        ({"fillings": []}, "models: expected one or more, or fillings, got neither"),
        ({"orders": []}, "orders: expected one or more, each once, got none"),
        ({"scenes": {}}, "scenes: expected at least one that can be loaded, got none"),
    ],
)
def test_what_cannot_be_measured(bad, message):
    with pytest.raises(InputError, match=message):
        measure_stability(**{"scenes": {"tree": bob.happy_tree}, "models": [], "fillings": ["nearest"], **TOY, **bad})
