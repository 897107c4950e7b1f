"""The page on quality, from a few tiny shapes: its measurements, its text, its figures."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import bobrossnet as bob
from bobrossnet.completion.weights import weights_path
from bobrossnet.learn import checkpoint
from bobrossnet.learn.evaluation.scores import Evaluation
from bobrossnet.learn.evaluation.stability import Stability

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def quality():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs")
        yield import_module("quality")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two shapes, one of them coloured."""
    place = tmp_path_factory.mktemp("shapes")
    (place / "a.sdf").write_text('sphere(1).color("#c62")\n')
    (place / "b.sdf").write_text("box(1)\n")
    return place


@pytest.fixture(scope="module")
def done(quality, folder, tmp_path_factory):
    """Return the page at small scale, written once."""
    work = tmp_path_factory.mktemp("quality")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("bobrossnet.learn.evaluation.costs.SIZE", (48, 64))
        patch.setitem(
            import_module("bobrossnet.learn.figures.style")._STYLE, "savefig.dpi", 50
        )  # drawing is the slow part
        patch.setattr(quality, "SUBJECTS", (quality.Subject("a.sdf", "ball", bob.Camera()),))
        quality.main(["--scale", "small", "--shapes", str(folder), "--work", str(work)])
    return work


def test_the_page(done, quality):
    page = (done / "quality.md").read_text()
    for part in (
        "[tried.md](tried.md)",
        "| default kept, lattice",
        "| default kept, adaptive",
        "| worse by 0.005",
        "## Adaptive pixels",
        "2 real shapes, 64x64:",
        "Pixels to trace for a mean SSIM of 0.95 and 0.99",
        "## Perspective",
        "60°",
        "## Colour",
        "1 pictures of real shapes that have colours.",
        "2 pictures of our own shapes.",
        "| from delaunay-linear, uniform",
        "## Known error",
        "| adaptive |   0.002 |",
        "quality/a-orders.png",
        "2 pictures of 2 shapes.",
        "| delaunay-linear, uniform",
        "| delaunay-linear, lattice",
        "| delaunay-linear, adaptive",
        "| pull-push, uniform",
        "## Temporal stability\n\n### On real shapes\n\nOn orbits at 5 %, default kept, adaptive flickers by ",
        "Flicker in gray levels of 255, means over 1 shape.",
        "Flicker of default kept, adaptive, change in percent:",
        "| method          | parameters | multiply-adds a pixel |",
        "quality/curves-own.png",
    ):
        assert part in page
    for name in ("curves-real", "curves-own", "costs", "a", "a-orders"):
        assert (done / "quality" / f"{name}.png").exists()
    assert np.asarray(Image.open(done / "quality" / "a.png")).shape[1] == 6 * (48 + 4) - 4


def test_nothing_is_measured_twice(done, quality, folder, tmp_path, monkeypatch):
    """With different weights of the same name, only these are measured."""
    asked = []

    def once(measure):
        return lambda scenes, models, **options: asked.append((models, options)) or measure(scenes, models, **options)

    for name in ("evaluate_scenes", "measure_stability"):
        monkeypatch.setattr(quality, name, once(getattr(quality, name)))
    scale = quality.SCALES["small"]
    arguments = done, "real", quality.scenes_of_folder(folder, scale.real)
    before = quality.measure_quality(*arguments, "default", scale)
    assert asked == []
    weights = tmp_path / "default.safetensors"
    network, _ = checkpoint.load(weights_path("default"))
    with np.errstate(all="ignore"):
        for parameter in network.parameters():
            parameter.data *= 0.9
    checkpoint.save(weights, network)
    after = quality.measure_quality(*arguments, str(weights), scale)
    assert [models for models, _ in asked] == [[str(weights)]]
    assert asked[0][1]["orders"] == list(quality.ORDERS)
    for run in before.scores:
        same = np.array_equal(before.scores[run], after.scores[run])
        assert same == (run[0] != "default kept"), run


def evaluation(quality, change):
    """Return errors of the network with both orders, `change` times the errors of linear filling, on three shapes."""
    errors = np.array([[0.2, 0.1], [0.3, 0.2], [0.4, 0.2]])

    def scores(values):
        return np.stack([1 - values, -10 * np.log10(values), values], -1)

    orders = quality.ORDERS
    runs = {("ours kept", order): scores(change * errors) for order in orders}
    runs |= {(method, order): scores(errors) for method in ("delaunay-linear", "paper kept") for order in orders}
    return Evaluation(("view 0",) * 3, ("a", "b", "c"), (0.01, 0.25), runs)


def test_what_is_asked_for_in_color(quality):
    (*_, table) = quality.in_colors({"shapes": evaluation(quality, 0.7)}, quality.SCALES["small"], "ours kept")
    assert "| from delaunay-linear, uniform  | -30.0 ± 0.0 yes | -30.0 ± 0.0 yes |" in table
    (*_, table) = quality.in_colors({"shapes": evaluation(quality, 0.9)}, quality.SCALES["small"], "ours kept")
    assert "| from delaunay-linear, adaptive | -10.0 ± 0.0 no | -10.0 ± 0.0 no |" in table
    assert len(quality.in_colors({"shapes": {}}, quality.SCALES["small"], "ours kept")) == 2


def steady(quality, change):
    runs = [(method, order) for method in ("ours kept", "delaunay-linear", "paper kept") for order in quality.ORDERS]
    factor = {run: change if run[0] == "ours kept" else 1 for run in runs}
    frames = np.array([[[np.nan, np.nan, 0.5], [0.6, 0.1, 0]]] * 3)
    return Stability(
        ("a", "b", "c"),
        np.array([0.01, 1]),
        {run: factor[run] * frames for run in runs},
        (0.05,),
        {run: factor[run] * np.full((3, 1), 0.2) for run in runs},
    )


@pytest.mark.parametrize(("change", "met"), [(0.65, 34), (0.75, 33), (0.84, 32), (0.9, 31), (1.1, 0)])
def test_what_was_reached(quality, change, met):
    """The limits are 0.7 and 0.8 with the lattice, 0.85 with uniform, and below 1 for all others."""
    text = "\n".join(quality.targets(evaluation(quality, change), "shapes", steady(quality, change), "ours kept"))
    assert f" {met} of 34 are met." in text
    first = f"| ours kept, uniform | 1 % | -15 | {100 * (change - 1):+.1f}".replace(" ", "")
    assert first in text.replace(" ", "")


def test_what_is_not_sure(quality):
    result = evaluation(quality, 0.8)
    result.scores["ours kept", "uniform"][:, 0, 0] = 1 - np.array([0.2, 0.3, 0.1])
    text = "\n".join(quality.targets(result, "shapes", steady(quality, 0.8), "ours kept"))
    assert [line.split("|")[-2].strip() for line in text.splitlines() if "ours kept, uniform" in line] == [
        "maybe",
        "yes",
    ]
