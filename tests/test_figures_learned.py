"""Figures of learned and measured data at toy size: losses, scores, stages and temporal stability."""

import csv
import math

import numpy as np
import pytest
import torch

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.learn import reference
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.dataset.plan import SIZES
from bobrossnet.learn.evaluation.stability import measure_stability
from bobrossnet.learn.figures import FIGURES, LeftOutError, Sources, draw_figures, losses
from bobrossnet.learn.figures.losses import MEASURES, TRAINED, UNSEEN, compare_losses, show_losses
from bobrossnet.learn.figures.scores import read_means, show_scores
from bobrossnet.learn.figures.stability import show_stability
from bobrossnet.learn.figures.stages import complete_stages
from bobrossnet.learn.figures.style import style
from bobrossnet.learn.losses import LOSSES, OF_REPORT
from bobrossnet.support.errors import InputError

MEANS = {
    "mine raw": {0.01: 0.80, 0.05: 0.87, 0.25: 0.93, 0.5: 0.95, 0.75: 0.96, 1.0: 0.98},
    "mine kept": {0.01: 0.81, 0.05: 0.88, 0.25: 0.94, 0.5: 0.97, 0.75: 0.98, 1.0: 1.0},
    "nearest": {0.01: 0.73, 0.05: 0.82, 0.25: 0.92, 0.5: 0.95, 0.75: 0.98, 1.0: 1.0},
}


def shown(drawing):
    """Return the pictures in a figure, in the order of its axes."""
    return [image.get_array() for axes in drawing.figure.axes for image in axes.get_images()]


def rows_of(text):
    return list(csv.DictReader(text.splitlines()))


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return a data set of three shapes: the built-in scene from three sides, repeated in larger pictures."""
    dataset = Dataset.create(tmp_path_factory.mktemp("learned") / "data", Plan(shapes=3, test_shapes=1), ["made 0"] * 3)
    scene = bob.Scene(bob.happy_tree())
    for shape in range(3):
        patch = bob.trace(scene, dataset.plan.camera(shape, 128), size=(128, 128)).stack()[1:].astype(np.float16)
        for size in SIZES:
            dataset.write(shape, size, np.tile(patch, (1, size // 128, size // 128)))
    return Dataset.open(dataset.path)


@pytest.fixture(scope="module")
def comparison(data):
    state = torch.get_rng_state()
    found = compare_losses(data, samples=3, unseen=2, steps=3, batch=2)
    assert torch.equal(torch.get_rng_state(), state)
    return found


# ---- temporal stability -------------------------------------------------------------------------------------


def test_stability_is_drawn():
    stability = measure_stability({"tree": bob.happy_tree}, ["paper"], frames=4, size=(24, 32), orbit_frames=2)
    with style():
        drawing = show_stability(stability)
    assert drawing.figure.axes[0].get_legend().get_texts()[1].get_text() == "paper kept"
    curve = drawing.figure.axes[0].get_lines()[1].get_ydata()
    np.testing.assert_allclose(curve[:-1], 255 * stability.mean("paper kept")[1:-1, 1])
    assert np.isnan(curve[-1])  # zero at the exact picture, which a logarithm can't show
    assert drawing.csv == stability.csv()


# ---- losses -------------------------------------------------------------------------------------------------


def test_all_losses_are_compared(comparison):
    assert list(comparison.scores) == [(loss, name) for loss in OF_REPORT for name in (TRAINED, UNSEEN)]
    for row in comparison.scores.values():
        assert list(row) == list(MEASURES)
        assert all(math.isfinite(value) for value in row.values())
    assert comparison.counts == {TRAINED: 3, UNSEEN: 2}
    assert len({row["ssim"] for row in comparison.scores.values()}) == 10  # each its own network
    rows = rows_of(comparison.csv())
    assert float(rows[3]["l2"]) == pytest.approx(comparison.scores["l2", UNSEEN]["l2"], abs=1e-6)


def test_losses_are_lowered_and_the_same_again(data, comparison, monkeypatch):
    monkeypatch.setattr(losses, "OF_REPORT", ("l1", "l2"))  # each loss has a separate training
    untrained = compare_losses(data, samples=3, unseen=2, steps=0, batch=2)
    assert (
        len({tuple(row.values()) for (_, name), row in untrained.scores.items() if name == TRAINED}) == 1
    )  # one start
    for loss, measure in (("l1", "l1"), ("l2", "l2")):
        assert comparison.scores[loss, TRAINED][measure] < untrained.scores[loss, TRAINED][measure]
    again = compare_losses(data, samples=3, unseen=2, steps=3, batch=2)
    assert again.scores == {key: scores for key, scores in comparison.scores.items() if key[0] in losses.OF_REPORT}


def test_losses_are_drawn(comparison):
    with style():
        drawing = show_losses(comparison)
    pictures = shown(drawing)
    assert len(pictures) == 2 * (2 + 5)
    titles = [axes.get_title() for axes in drawing.figure.axes[:7]]
    trained = comparison.shown[0]
    assert titles[0] == "reference"
    assert titles[-1] == f"SSIM + L2\nSSIM {trained.scores['ssim+l2']:.3f}"
    assert bob.ssim(trained.images["l1"], trained.reference) == pytest.approx(trained.scores["l1"], abs=1e-5)
    assert "3 samples" in drawing.caption


# ---- scores and stages --------------------------------------------------------------------------------------


def test_the_reports_numbers():
    assert list(reference.SSIM) == [0.01, 0.25, 0.5, 0.75, 1.0]
    assert np.mean(list(reference.SSIM.values())) == pytest.approx(0.9349864)
    assert reference.LOSS in LOSSES


def test_scores_are_drawn_beside_the_reports(tmp_path):
    lines = ["method,order,shape,picture,fraction,ssim,psnr,flip"]
    for method, means in MEANS.items():
        for fraction, mean in means.items():
            for picture, offset in enumerate((-0.01, 0.01)):
                lines.append(f"{method},uniform,a,{picture},{fraction},{mean + offset},inf,0.1")
    path = tmp_path / "scores.csv"
    path.write_text("\n".join(lines))
    means = read_means(path)
    assert means["mine raw"] == pytest.approx(MEANS["mine raw"])

    captions = draw_figures(tmp_path / "out", Sources(scores=path), only=["6.2"], report=lambda line: None)
    assert list(captions) == ["6.2"]
    rows = rows_of((tmp_path / "out/figure-6.2.csv").read_text())
    assert {row["method"] for row in rows} == {"the report", *MEANS}
    with style():
        axes = show_scores(means).figure.axes
    (theirs, raw, kept, _), words = axes[0].get_lines(), [text.get_text() for text in axes[0].get_legend().get_texts()]
    assert words == ["the report", "mine raw", "mine kept", "nearest"]
    np.testing.assert_allclose(theirs.get_ydata(), list(reference.SSIM.values()))
    np.testing.assert_allclose(kept.get_xdata(), [100 * fraction for fraction in MEANS["mine kept"]])
    np.testing.assert_allclose(raw.get_ydata(), list(MEANS["mine raw"].values()))


def test_scores_that_cant_be_read(tmp_path):
    with pytest.raises(LeftOutError, match="--scores"):
        FIGURES["6.2"](Sources())
    path = tmp_path / "other.csv"
    path.write_text("method,fraction\nmine raw,0.01\n")
    with pytest.raises(InputError, match="expected the scores of an evaluation"):
        read_means(path)
    with pytest.raises(InputError, match=r"nowhere\.csv: can't read it"):
        read_means(tmp_path / "nowhere.csv")
    with pytest.raises(InputError, match="expected a method NAME kept, got mine raw"):
        show_scores({"mine raw": MEANS["mine raw"]})


def test_stages_converge():
    full = bob.trace(bob.happy_tree(), size=(64, 64))
    sparse, half, whole = complete_stages(full, (0.05, 0.5, 1.0))
    assert sparse.completed_ssim < half.completed_ssim < whole.completed_ssim == 1
    assert whole.raw_ssim == bob.ssim(whole.raw, full.gray) < 1  # the raw network output is never exact
    np.testing.assert_array_equal(half.completed, bob.complete(full.sample(0.5, order="uniform")))
    with pytest.raises(InputError, match="every pixel traced"):
        complete_stages(sparse.part, (0.01,))


@pytest.mark.parametrize(("name", "first", "last"), [("6.3", "1 % traced", "10 % traced"), ("6.4", "25 %", "100 %")])
def test_stages_are_drawn(name, first, last):
    drawing = FIGURES[name](Sources(size=64))
    assert len(shown(drawing)) == 1 + 3 * 4
    titles = [axes.get_title() for axes in drawing.figure.axes if axes.get_images()]
    assert any(title.startswith(first) for title in titles)
    assert any(title.startswith(last) for title in titles)
    rows = rows_of(drawing.csv)
    assert len(rows) == 4
    assert ("completed: SSIM 1" in titles) == (name == "6.4")
    assert f"output: SSIM {float(rows[0]['raw_ssim']):.3f}" in titles


def test_command_passes_what_figures_need(tmp_path, data, comparison, monkeypatch):
    asked = []
    monkeypatch.setattr(losses, "compare_losses", lambda _, steps, seed: asked.append((steps, seed)) or comparison)
    scores = tmp_path / "scores.csv"
    rows = ["mine raw,uniform,a,1,0.25,0.9,30,0.1", "mine kept,uniform,a,1,0.25,0.95,35,0.1"]
    rows += ["mine kept,other,a,1,0.25,0.5,35,0.1"]  # not drawn
    scores.write_text("\n".join(["method,order,shape,picture,fraction,ssim,psnr,flip", *rows]))
    out = tmp_path / "out"
    arguments = ["--data", str(data.path), "--scores", str(scores), "--steps", "7", "--only", "5.1,6.2"]
    assert cli.main(["figures", str(out), *arguments]) == 0
    written = {path.name for path in out.iterdir()}
    assert written == {f"figure-{name}.{ending}" for name in ("5.1", "6.2") for ending in ("svg", "png", "csv")}
    assert asked == [(7, 0)]
