"""Scores, their means, gains and tables, on made-up numbers, files and a toy data set."""

import csv
import io
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.color import luminance, to_srgb
from bobrossnet.command_line import cli
from bobrossnet.completion.filling import delaunay_linear
from bobrossnet.completion.network import load_network
from bobrossnet.completion.weights import weights_path
from bobrossnet.learn import checkpoint, commands
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.dataset.loader import Batches
from bobrossnet.learn.dataset.plan import PATCHES, SIZES, STAGES
from bobrossnet.learn.evaluation.costs import cost_table, measure_costs
from bobrossnet.learn.evaluation.evaluate import evaluate_dataset, evaluate_folder, evaluate_scenes
from bobrossnet.learn.evaluation.runs import rivals
from bobrossnet.learn.evaluation.scenes import own_scenes, scenes_of_folder, with_colors
from bobrossnet.learn.evaluation.scores import Evaluation
from bobrossnet.learn.networks import NETWORKS, Paper
from bobrossnet.metrics import flip
from bobrossnet.support.errors import InputError, InputWarning

NEAREST = ("nearest", "uniform")
TRIANGLE = "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"


def made_up(differences: Any, shapes: tuple[str, ...] | None = None) -> Evaluation:
    """A model and a filling: SSIM (P, F) `differences` above 0.5, and 0.5; PSNR 30 and 20; FLIP 0.1 and 0.2."""
    above = np.array(differences)
    constant = np.ones_like(above)
    kept = np.stack([0.5 + above, 30 * constant, 0.1 * constant], -1)
    filling = np.stack([0.5 * constant, 20 * constant, 0.2 * constant], -1)
    pictures = tuple(f"picture {i}" for i in range(len(above)))
    by_method = {"paper raw": kept - 0.01, "paper kept": kept, "nearest": filling}
    scores = {(method, "uniform"): values for method, values in by_method.items()}
    return Evaluation(pictures, shapes or pictures, (0.01, 0.05)[: above.shape[1]], scores)


# ---- Means, gains, tables --------------------------------------------------------------------------------


def test_gain_is_paired() -> None:
    result = made_up([[0.1, -0.02], [0.2, -0.02], [0.3, -0.02], [0.4, -0.02]])
    half = 3.18244631 * math.sqrt((0.15**2 + 0.05**2) * 2 / 3) / 2  # Student's t of 3 degrees; n - 1 = 3; √n = 2
    np.testing.assert_allclose(result.gain("paper kept", "nearest"), [[0.25, half], [-0.02, 0]], atol=1e-9)
    np.testing.assert_allclose(result.gain("nearest", "paper kept")[:, 0], [-0.25, 0.02], atol=1e-9)
    assert result.gain_table("paper kept").splitlines()[2:] == [
        "| over nearest | +0.2500 ± 0.2054 | -0.0200 ± 0.0000 |",
    ]
    # Difficulty common to both methods widens no interval.
    hard = np.array([0.1, 0.4, 0, 0.3])[:, None, None]
    scores = {run: values - hard for run, values in result.scores.items()}
    shifted = Evaluation(result.pictures, result.shapes, result.fractions, scores)
    gains = [evaluation.gain("paper kept", "nearest") for evaluation in (shifted, result)]
    np.testing.assert_allclose(*gains, atol=1e-12)


def test_less_flip_is_a_gain() -> None:
    np.testing.assert_allclose(made_up([[0.1], [0.2]]).gain("paper kept", "nearest", "flip"), [[0.1, 0]], atol=1e-12)


@pytest.mark.parametrize("of_a_shape", [1, 5])
def test_gain_covers_the_truth_in_95_of_100(of_a_shape: int) -> None:
    """Also with correlated pictures of one shape, for which plain standard errors would be too small."""
    rng = np.random.default_rng(0)
    names = tuple(np.repeat([f"shape {i}" for i in range(10)], of_a_shape))
    trials = []
    for _ in range(1500):
        difference = 0.03 + 0.1 * np.repeat(rng.normal(size=10), of_a_shape) + 0.03 * rng.normal(size=len(names))
        trials.append(made_up(difference[:, None], names).gain("paper kept", "nearest")[0])
    means, halves = np.transpose(trials)
    assert np.mean(np.abs(means - 0.03) <= halves) == pytest.approx(0.95, abs=0.017)  # three standard errors


def test_psnr_is_that_of_the_mean_squared_error() -> None:
    result = made_up([[0.1], [0.2]])
    result.scores[NEAREST][:, 0, 1] = (20, math.inf)  # one of the two pictures is exact
    assert result.mean("nearest", "psnr") == pytest.approx([-10 * math.log10(0.01 / 2)])
    gain, half = result.gain("paper kept", "nearest", "psnr")[0]
    assert gain == pytest.approx(30 + 10 * math.log10(0.01 / 2))
    # The standard error of `nearest`'s mean error equals it, and t with 1 degree of freedom is 12.7.
    assert half == pytest.approx(12.7062047 * 10 / math.log(10))
    result.scores[NEAREST][:, 0, 1] = math.inf
    assert result.mean("nearest", "psnr") == [math.inf]
    assert result.table("psnr").splitlines()[-1] == "| nearest    | **∞** |"
    assert result.gain_table("paper kept", "psnr").splitlines()[-1].endswith("– |")


def test_tables() -> None:
    result = made_up([[0.1, -0.02], [0.2, -0.02]])
    assert result.table() == "\n".join(
        [
            "| traced     |        1 % |        5 % |",
            "| ---------- | ---------: | ---------: |",
            "| paper raw  |     0.6400 |     0.4700 |",
            "| paper kept | **0.6500** |     0.4800 |",
            "| nearest    |     0.5000 | **0.5000** |",
        ]
    )
    assert result.table("psnr").splitlines()[4] == "| nearest    |     20.00 |     20.00 |"
    assert "| paper raw  | **0.0900** | **0.0900** |" in result.table("flip")  # lower is better
    for part in ("2 pictures of 2 shapes", "SSIM:\n\n| traced", result.gain_table("paper kept"), result.table("flip")):
        assert part in str(result)
    single = made_up([[0.1, -0.02]])
    assert np.isnan(single.gain("paper kept", "nearest")[:, 1]).all()
    scores = {run: values for run, values in single.scores.items() if run != NEAREST}
    alone = Evaluation(single.pictures, single.shapes, single.fractions, scores)
    assert "Gain" not in str(alone)


def test_csv_has_every_score() -> None:
    result = made_up([[0.1, -0.02], [0.2, 1 / 3]])
    result.scores[NEAREST][0, 1, 1] = math.inf
    rows = list(csv.DictReader(io.StringIO(result.csv())))
    assert len(rows) == 3 * 2 * 2
    assert list(rows[0]) == ["method", "order", "shape", "picture", "fraction", "ssim", "psnr", "flip"]
    for run, scores in result.scores.items():
        of_run = [row for row in rows if (row["method"], row["order"]) == run]
        read = [[float(row[name]) for name in ("ssim", "psnr", "flip")] for row in of_run]
        np.testing.assert_array_equal(np.reshape(read, scores.shape), scores)
    assert rows[5]["fraction"] == "0.05"
    assert (rows[6]["picture"], rows[6]["shape"]) == ("picture 1", "picture 1")

    again = Evaluation.from_csv(result.csv())
    assert (again.pictures, again.shapes) == (result.pictures, result.shapes)
    assert (again.fractions, list(again.scores)) == (result.fractions, list(result.scores))
    for run, scores in result.scores.items():
        np.testing.assert_array_equal(again.scores[run], scores)
    for text in (
        "",
        "method,order,shape\n",
        result.csv().replace("0.05", "x"),
        "\n".join(result.csv().splitlines()[:-1]),
    ):
        with pytest.raises(InputError, match="text: expected the scores of an evaluation, got "):
            Evaluation.from_csv(text)


def test_evaluations_side_by_side() -> None:
    result = made_up([[0.1, -0.02], [0.2, 1 / 3]])
    parts = [
        Evaluation(
            result.pictures,
            result.shapes,
            result.fractions,
            {(name, "uniform"): result.scores[name, "uniform"] for name in names},
        )
        for names in (("paper raw", "paper kept"), ("nearest",))
    ]
    assert str(parts[0].beside(parts[1])) == str(result)
    with pytest.raises(InputError, match="other: expected an evaluation of the same pictures"):
        parts[0].beside(made_up([[0.1, -0.02]]))


def test_names_that_name_nothing() -> None:
    result = made_up([[0.1]])
    with pytest.raises(
        InputError, match="method: expected one of paper raw, paper kept, nearest in order uniform, got 'paper'"
    ):
        result.gain("nearest", "paper")
    with pytest.raises(InputError, match=r"in order uniform, got \('nearest', 'lattice'\)"):
        result.mean(("nearest", "lattice"))
    with pytest.raises(InputError, match="metric: expected one of ssim, psnr, flip, got 'mse'"):
        result.mean("nearest", "mse")
    with pytest.raises(InputError, match="metric: expected one of"):
        result.table("mse")


def two_orders() -> Evaluation:
    """The model as made up in order uniform, better by 0.1 in order other; the filling in order uniform alone."""
    one = made_up([[0.1, -0.02], [0.2, 0.04]])
    better = {
        (method, "other"): one.scores[method, "uniform"] + [0.1, 5, -0.05] for method in ("paper raw", "paper kept")
    }
    other = Evaluation(one.pictures, one.shapes, one.fractions, better)
    return one.beside(other)


def test_orders_side_by_side() -> None:
    result = two_orders()
    assert result.orders == ("uniform", "other")
    assert list(result.of_order("other").scores) == [("paper raw", "other"), ("paper kept", "other")]
    ours = ("paper kept", "other")
    np.testing.assert_allclose(result.mean(ours) - result.mean("paper kept"), 0.1)
    np.testing.assert_allclose(result.gain(ours, "nearest")[:, 0], [0.25, 0.11])
    assert rivals(result.scores, ours) == [("paper kept", "uniform"), NEAREST]
    assert rivals(result.scores, "paper kept") == [NEAREST]  # other orders are no rivals of the first
    assert result.gain_table(ours).splitlines()[2].startswith("| over paper kept, uniform | +0.1000 ± 0.0000 |")
    assert "| paper raw, other    |" in result.table()
    assert "1 - SSIM of paper kept, other, change in percent:" in str(result)
    assert result.error_table(ours) in str(result)
    again = Evaluation.from_csv(result.csv())
    assert list(again.scores) == list(result.scores)
    assert str(again) == str(result)


def test_change_of_error_is_a_ratio_of_means() -> None:
    result = two_orders()
    # Errors 0.3 and 0.2 over 0.5 and 0.5: the ratio is 0.5, deviations ±0.1, t with 1 degree of freedom is 12.7.
    change, half = result.change_of_error(("paper kept", "other"), "nearest")[0]
    assert change == pytest.approx(-0.5)
    assert half == pytest.approx(12.7062047 * 0.1)
    assert result.change_of_error("paper kept", "nearest", "psnr")[0] == pytest.approx([0.1 - 1, 0])
    assert result.change_of_error("paper kept", "nearest", "flip")[0] == pytest.approx([-0.5, 0])
    assert (
        result.error_table(("paper kept", "other"))
        .splitlines()[3]
        .startswith("| from nearest, uniform    | -50.0 ± 127.1 |")
    )
    # If the other is exact, there is no ratio.
    result.scores[NEAREST][..., 0] = 1
    assert np.isnan(result.change_of_error("paper kept", "nearest")[0, 1])


def test_change_of_error_covers_the_truth_in_95_of_100() -> None:
    """Hard pictures have larger errors of both methods, and proportional differences."""
    rng = np.random.default_rng(0)
    trials = []
    for _ in range(1000):
        theirs = np.repeat(rng.uniform(0.1, 0.3, 30), 2)
        ours = theirs * (0.8 + 0.1 * np.repeat(rng.normal(size=30), 2))
        result = made_up((0.5 - ours)[:, None], tuple(np.repeat([f"shape {i}" for i in range(30)], 2)))
        result.scores[NEAREST][:, 0, 0] = 1 - theirs
        trials.append(result.change_of_error("paper kept", "nearest")[0])
    means, halves = np.transpose(trials)
    assert np.mean(np.abs(means + 0.2) <= halves) == pytest.approx(0.95, abs=0.03)


# ---- Costs -----------------------------------------------------------------------------------------------


def test_costs() -> None:
    costs = measure_costs(["paper"], ["nearest"], runs=1)
    assert list(costs) == ["paper kept", "nearest"]
    assert costs["paper kept"][1:] == (10_346, 2452.5)
    assert costs["nearest"][1:] == (None, None)
    assert min(cost.milliseconds for cost in costs.values()) > 0
    assert cost_table(costs).splitlines()[-1].startswith("| nearest    |          – |                     – |")
    # The widest layer alone would be 900; a quarter, since it runs at half the resolution, in four groups.
    assert Paper(groups=1).multiply_adds(64, 96) == 2452.5 + 3 * 900 + 3 * 225
    assert all(network.from_settings({"groups": 4}).multiply_adds(64, 64) > 0 for network in NETWORKS.values())
    assert Paper().multiply_adds(62, 94) == pytest.approx(2452.5 * (64 * 96) / (62 * 94))  # padded


# ---- A folder of files -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two meshes, a script, one unreadable file, and one in an excluded folder."""
    folder = tmp_path_factory.mktemp("broken_odd") / "shapes"  # parents of the folder are ignored
    (folder / "broken_odd").mkdir(parents=True)
    for name in ("a.obj", "b.OBJ", "broken_odd/c.obj"):
        (folder / name).write_text(TRIANGLE)
    (folder / "d.obj").write_text("f 1 2 3\n")
    (folder / "e.sdf").write_text("sphere(1)\n")
    (folder / "notes.txt").write_text("hello")
    return folder


OPTIONS: dict[str, Any] = {"size": (16, 20), "fractions": [0.1, 1.0]}


def test_evaluation_of_a_folder(shapes: Path) -> None:
    with pytest.warns(InputWarning, match=r"left out: d\.obj: "):
        result = evaluate_folder(shapes, ["paper"], views=2, **OPTIONS)
    assert result.shapes == ("a.obj", "a.obj", "b.OBJ", "b.OBJ", "e.sdf", "e.sdf")
    assert result.pictures == ("view 0", "view 1") * 3
    methods = ["paper raw", "paper kept", "nearest", "pull-push", "delaunay-linear", "telea"]
    assert list(result.scores) == [(method, "uniform") for method in methods]
    assert {scores.shape for scores in result.scores.values()} == {(6, 2, 3)}
    for (method, _), scores in result.scores.items():
        exact = (scores[:, 1] == (1, math.inf, 0)).all()
        assert exact == (method != "paper raw"), method  # it repaints known pixels

    full = bob.trace(bob.load(shapes / "b.OBJ"), bob.Camera(azimuth=30 + 180, elevation=45), size=(16, 20))
    part = full.sample(0.1, order="uniform", seed=3)
    image = bob.complete(part, model="paper")
    expected = [bob.ssim(image, full.gray), bob.psnr(image, full.gray), flip(image, full.gray)]
    assert result.scores["paper kept", "uniform"][3, 0].tolist() == expected
    painted = np.clip(load_network("paper").predict(part), 0, 1)
    np.testing.assert_array_equal(painted[part.mask == 0], image[part.mask == 0])
    assert result.scores["paper raw", "uniform"][3, 0, 0] == bob.ssim(painted, full.gray)


def test_parts_are_scored_side_by_side(monkeypatch: pytest.MonkeyPatch) -> None:
    """Results keep their order in any completion order, and at most one picture per thread is made ahead."""
    scenes = {
        name: partial(bob.sdf.box, size) for name, size in (("a", 1), ("b", 2), ("c", (1, 2, 3)), ("d", (3, 1, 1)))
    }
    options: dict[str, Any] = {"size": (16, 20), "fractions": [0.1, 0.5], "orders": ["uniform", "lattice"]}
    monkeypatch.setattr(bob, "thread_count", lambda: 1)
    alone = evaluate_scenes(scenes, ["paper"], **options)
    monkeypatch.setattr(bob, "thread_count", lambda: 3)
    assert evaluate_scenes(scenes, ["paper"], **options).csv() == alone.csv()

    made: list[str] = []

    def make(name: str) -> Any:
        made.append(name)
        return bob.sdf.sphere(1)

    def fail(part: bob.GBuffer) -> None:
        raise RuntimeError("of a method")

    monkeypatch.setattr("bobrossnet.learn.evaluation.evaluate.all_methods", lambda *_, **__: {"failing": fail})
    with pytest.raises(RuntimeError, match="of a method"):
        evaluate_scenes({str(k): partial(make, str(k)) for k in range(9)}, **options)
    assert made == ["0", "1", "2", "3"]


def test_evaluation_in_perspective() -> None:
    scenes = {"ball": bob.sdf.sphere, "box": lambda: bob.sdf.box(1)}
    options: dict[str, Any] = {"fractions": [0.1], "orders": ["uniform"], "fillings": [], "repainting": False}
    result = evaluate_scenes(scenes, ["paper"], size=(16, 20), fov=60, **options)
    full = bob.trace(bob.sdf.box(1), bob.Camera(azimuth=30, fov=60), size=(16, 20))
    image = bob.complete(full.sample(0.1, order="uniform", seed=1), model="paper")
    assert result.scores["paper kept", "uniform"][1, 0, 0] == bob.ssim(image, full.gray)


def test_evaluation_in_color() -> None:
    scenes = {"ball": lambda: bob.sdf.sphere(1).color("#c62"), "box": lambda: bob.sdf.box(1).color(lambda p: abs(p))}
    options: dict[str, Any] = {"size": (16, 20), "fractions": [0.1], "orders": ["uniform"]}
    result = evaluate_scenes(
        scenes, ["paper"], channel="color", repainting=False, fillings=["delaunay-linear"], **options
    )
    full = bob.trace(scenes["box"](), bob.Camera(azimuth=30), size=(16, 20))
    part = full.sample(0.1, order="uniform", seed=1)
    filled = np.stack([delaunay_linear(part.color[..., k], part.mask) for k in range(3)], -1)
    for method, image in (("paper kept", bob.complete(part, "paper", channel="color")), ("delaunay-linear", filled)):
        expected = [
            bob.ssim(luminance(image), luminance(full.color)),
            bob.psnr(image, full.color),
            flip(to_srgb(image), to_srgb(full.color)),
        ]
        assert result.scores[method, "uniform"][1, 0].tolist() == expected
    for bad, message in (
        ({"channel": "depth"}, "channel: expected one of gray, color, got 'depth'"),
        ({"channel": "color"}, "repainting: expected False for colours"),
    ):
        with pytest.raises(InputError, match=message):
            evaluate_scenes(scenes, ["paper"], **options, **bad)


def test_scenes_with_colors(shapes: Path) -> None:
    scenes = {"white": bob.sdf.sphere, "red": lambda: bob.sdf.sphere(1).color("#c00")}
    assert list(with_colors(scenes)) == ["red"]
    with pytest.warns(InputWarning, match=r"left out: d\.obj: "):
        assert with_colors(scenes_of_folder(shapes)) == {}


def test_own_scenes_in_color_are_colored() -> None:
    assert all(make().is_colored for make in own_scenes(4, colored=True).values())
    assert not any(make().is_colored for make in own_scenes(2).values())


def test_several_models_and_a_limit(shapes: Path, tmp_path: Path) -> None:
    weights = tmp_path / "nearest.safetensors"  # named like a filling
    checkpoint.save(weights, checkpoint.load(weights_path("paper"))[0])
    result = evaluate_folder(shapes, ["paper", weights], fillings=["nearest"], limit=2, **OPTIONS)
    assert result.shapes == ("a.obj", "e.sdf")  # the first and the last
    methods = ["paper raw", "paper kept", "nearest raw", "nearest kept", "nearest"]
    assert [method for method, _ in result.scores] == methods
    np.testing.assert_array_equal(result.scores["nearest kept", "uniform"], result.scores["paper kept", "uniform"])
    assert [line.split("|")[1].strip() for line in result.gain_table("paper kept").splitlines()[2:]] == [
        "over nearest kept",
        "over nearest",
    ]
    alone = evaluate_folder(shapes, ["paper"], fillings=[], repainting=False, limit=2, **OPTIONS)
    assert list(alone.scores) == [("paper kept", "uniform")]
    with pytest.raises(InputError, match="models: expected different names, got nearest, nearest"):
        evaluate_folder(shapes, [weights, weights], **OPTIONS)


def test_what_cannot_be_evaluated(shapes: Path) -> None:
    for bad, message in (
        ({"models": [], "fillings": []}, "models: expected one or more, or fillings, got neither"),
        ({"views": 0}, "views: expected an integer in 1"),
        ({"limit": 0}, "limit: expected an integer in 1"),
        ({"size": (10, 20)}, "size: expected at least 11x11 pixels"),
        ({"fractions": []}, "fractions: expected at least one"),
        ({"fractions": [0]}, "fractions: expected a number in"),
        ({"fillings": ["far"]}, "fillings: expected some of nearest, pull-push, delaunay-linear, telea, got 'far'"),
        ({"orders": ["spiral"]}, "order: expected one of uniform"),
        ({"orders": []}, "orders: expected one or more, each once, got none"),
        ({"orders": ["uniform", "uniform"]}, "orders: expected one or more, each once, got uniform, uniform"),
    ):
        with pytest.raises(InputError, match=message):
            evaluate_folder(shapes, **{**OPTIONS, **bad})
    with pytest.raises(InputError, match="none: expected a shape file or a folder of them, got no such file"):
        evaluate_folder(shapes / "none", **OPTIONS)


# ---- A data set ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Three shapes of noise on the left and background on the right; two of them for testing."""
    plan = Plan(seed=5, shapes=3, test_shapes=2)
    made = Dataset.create(tmp_path_factory.mktemp("data") / "set", plan, ["made 7", "made 8", "made 9"])
    for shape in range(3):
        for size in SIZES:
            view = np.random.default_rng((shape, size)).random((4, size, size)).astype(np.float16)
            view[..., size // 4 :] = 0
            made.write(shape, size, view)
    return made


def test_evaluation_of_a_dataset(dataset: Dataset) -> None:
    result = evaluate_dataset(dataset.path, ["paper"], fractions=[0.25], fillings=[])
    tested = sorted({dataset.plan.sample(int(n)).shape for n in dataset.plan.split("test")})
    assert result.shapes == tuple(np.repeat([f"made {7 + shape}" for shape in tested], PATCHES))
    assert len(result.pictures) == 2 * PATCHES
    assert result.pictures[:3] == ("128x128 row 0 column 0", "256x256 row 0 column 0", "256x256 row 0 column 1")
    assert result.pictures[-1] == "512x512 row 3 column 3"

    # Exactly the samples of a loader.
    batch = Batches(dataset, "test", size=len(STAGES) * PATCHES, shuffle=False)[1]
    for patch in (0, 1, 7):
        number = patch * len(STAGES) + STAGES.index(0.25)
        part = bob.GBuffer.from_stack(batch.partial[number].numpy())
        image, reference = bob.complete(part, model="paper"), batch.reference[number, 0].numpy()
        expected = [bob.ssim(image, reference), bob.psnr(image, reference), flip(image, reference)]
        assert result.scores["paper kept", "uniform"][PATCHES + patch, 0].tolist() == expected


def test_other_fractions_and_a_limit(dataset: Dataset) -> None:
    result = evaluate_dataset(dataset, [], fractions=[0.02, 0.1], fillings=["nearest"], limit=1)
    scores = result.scores[NEAREST]
    assert len(scores) == PATCHES
    noise = np.isfinite(scores[:, 0, 1])  # some patches are empty: any filling of them is exact
    assert 0 < noise.sum() < PATCHES
    few, more = scores[noise, :, 1].mean(0)
    assert few < more
    with pytest.raises(InputError, match="expected a data set, got none"):
        evaluate_dataset(dataset.path / "none")


# ---- The command -----------------------------------------------------------------------------------------


def test_the_command_writes_tables(
    shapes: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bobrossnet.learn.evaluation.costs.SIZE", (48, 64))  # Delaunay triangles are slow
    scores, tables = tmp_path / "scores.csv", tmp_path / "tables.md"
    options = ["--models", "paper", "default", "--fractions", "5%,0.5", "--size", "20x16", "--views", "2"]
    assert cli.main(["evaluate", str(shapes), *options, "--csv", str(scores), "--markdown", str(tables)]) == 0
    printed = capsys.readouterr()
    assert "warning: left out: d.obj: " in printed.err
    assert "| paper kept      |     10,346 |                 2,452 |" in printed.out
    assert printed.out == f"{tables.read_text()}wrote {scores}\nwrote {tables}\n"
    assert "Means over 6 pictures of 3 shapes." in printed.out
    assert "| traced          |        5 % |       50 % |" in printed.out
    assert len(scores.read_text().splitlines()) == 1 + 8 * 6 * 2


def test_the_command_in_color(shapes: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--models", "paper", "--fractions", "5%", "--size", "20x16", "--color"]
    assert cli.main(["evaluate", str(shapes), *options]) == 0
    printed = capsys.readouterr()
    assert "paper kept" in printed.out
    assert "paper raw" not in printed.out


def test_the_command_refuses_before_it_works(
    shapes: Path, dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments, message in (
        ([str(dataset.path), "--size", "64x64"], "--size and --views: expected with a folder of files"),
        ([str(dataset.path), "--views", "2"], "--size and --views: expected with a folder of files"),
        ([str(dataset.path), "--color"], "--color: expected with a folder of files; a data set holds gray pictures"),
        ([str(shapes), "--csv", str(tmp_path / "no" / "scores.csv")], "there is no folder"),
        ([str(shapes), "--markdown", str(tmp_path)], "expected a file to write, got a folder"),
        ([str(shapes), "--fractions", "5%,,"], "--fractions: expected a share of the pixels"),
        ([str(shapes), "--models", "oil"], "model: expected one of"),
        ([str(shapes), "--orders", "uniform,spiral"], "order: expected one of uniform"),
        ([str(tmp_path / "missing")], "missing: expected a shape file or a folder of them"),
    ):
        assert cli.main(["evaluate", *arguments]) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.count("\n") == 1
        assert message in printed.err


def test_a_quick_evaluation_needs_no_files(capsys, monkeypatch):
    monkeypatch.setattr(commands, "QUICK_SHAPES", 2)
    assert cli.main(["evaluate", "--quick", "--size", "32x32"]) == 0
    told = capsys.readouterr().out
    assert "default" in told
    assert "paper" not in told.split("##")[0]
    assert cli.main(["evaluate"]) == 2
    assert "PLACE: expected a data set or a folder of shape files; --quick generates" in capsys.readouterr().err


def test_no_picture_begins_after_the_time_is_up():
    scenes = own_scenes(3)
    assert len(evaluate_scenes(scenes, (), size=(16, 16), fractions=(0.1,), seconds=0).pictures) == 1
    assert len(evaluate_scenes(scenes, (), size=(16, 16), fractions=(0.1,)).pictures) == 3
