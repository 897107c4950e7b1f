"""Statistics of pictures: known pictures, and comparisons of populations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.command_line.cli import main
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.dataset.plan import SIZES
from bobrossnet.learn.dataset.statistics import (
    BINS,
    CLEAR,
    MEASURES,
    Population,
    compare,
    compare_with_folder,
    picture_statistics,
    pictures_of_dataset,
    pictures_of_files,
    population,
)
from bobrossnet.support.errors import InputError

SIDE = 64
ROWS, COLUMNS = np.mgrid[:SIDE, :SIDE].astype(np.float32)
DISC = np.hypot(ROWS - SIDE / 2 + 0.5, COLUMNS - SIDE / 2 + 0.5) < SIDE / 4
ALL = np.ones((SIDE, SIDE), bool)


def picture(hit, *, gray=0.5, depth=0.5, normal=(0, 0)) -> bob.GBuffer:
    """Return a picture that faces the camera where `hit`, with defaults for other channels."""
    normal = np.broadcast_to(np.asarray(normal, np.float32), (*hit.shape, 2)) * hit[..., None]
    return bob.GBuffer(
        mask=np.ones(hit.shape, np.float32),
        gray=(gray * hit).astype(np.float32),
        depth=(depth * hit).astype(np.float32),
        normal=normal.astype(np.float32),
    )


def measures(gbuffer: bob.GBuffer) -> dict[str, float]:
    found = picture_statistics(gbuffer)
    assert found is not None
    return dict(zip(MEASURES, found.measures, strict=True))


def test_disc() -> None:
    m = measures(picture(DISC))
    radius = SIDE / 4
    assert m["coverage"] == pytest.approx(np.pi / 16, rel=0.02)
    assert m["width"] == pytest.approx(4 / 3 * radius / SIDE, rel=0.05)
    # A digital circle: sqrt(8) r pixels for the borders in each of the two directions, minus pixels on both.
    assert m["silhouettes"] == pytest.approx(4 * np.sqrt(2) * radius / DISC.sum(), rel=0.1)
    assert (m["components"], m["holes"], m["mean gray"]) == (1, 0, 0.5)
    assert m["depth edges"] == m["creases"] == m["gradient energy"] == m["fine detail"] == 0
    assert m["flat"] == pytest.approx(1 - (2 * radius + 2 * radius - np.sqrt(2) * radius) / DISC.sum(), abs=0.03)


def test_strip() -> None:
    strip = np.zeros((SIDE, SIDE), bool)
    strip[20:24] = True
    m = measures(picture(strip))
    assert m["width"] == pytest.approx(4 / SIDE, rel=0.05)
    assert m["silhouettes"] == 0.5


def test_components_and_holes() -> None:
    hit = np.zeros((SIDE, SIDE), bool)
    hit[5:20, 5:20] = True
    hit[8:10, 8:10] = hit[15, 15] = False  # two holes
    hit[40:50, 40:50] = hit[50:55, 50:55] = True  # one piece: they touch at a corner
    hit[60:, 30:40] = True
    hit[62:, 32] = False  # reaches the border: not a hole
    m = measures(picture(hit))
    assert (m["components"], m["holes"]) == (3, 2)


def test_checkerboard_of_depth() -> None:
    board = (ROWS // 8 + COLUMNS // 8) % 2
    beside_border = [np.isin(i % 8, (0, 7)) & (i > 0) & (i < SIDE - 1) for i in (ROWS, COLUMNS)]
    m = measures(picture(ALL, depth=0.4 + 0.1 * board, gray=0.3 + 0.2 * board))
    assert m["depth edges"] == (beside_border[0] | beside_border[1]).mean()
    assert m["creases"] == m["silhouettes"] == 0
    assert m["coverage"] == m["flat"] == 1
    # 7 borders of 64 pixels each way, a step of 0.2.
    assert m["gradient energy"] == pytest.approx(14 * SIDE * 0.04 / SIDE**2, rel=1e-4)
    assert measures(picture(ALL, depth=0.4 + 0.02 * board))["depth edges"] == 0


def test_creases() -> None:
    roof = np.stack([np.where(COLUMNS < 32, -0.5, 0.5), 0 * ROWS], -1)  # 60 degrees at the ridge
    m = measures(picture(ALL, normal=roof))
    assert m["creases"] == pytest.approx(2 / SIDE)
    assert m["flat"] == pytest.approx(1 - 1 / SIDE)
    assert measures(picture(ALL, normal=roof / 2))["creases"] == 0  # 29 degrees
    m = measures(picture(ALL, normal=roof, depth=np.where(COLUMNS < 32, 0.3, 0.7)))  # two surfaces
    assert m["creases"] == 0
    assert m["depth edges"] == pytest.approx(2 / SIDE)


def test_fine_detail() -> None:
    slope = picture(ALL, gray=COLUMNS / SIDE)
    step = picture(ALL, gray=np.where(COLUMNS < 32, 0.3, 0.7))
    noise = picture(ALL, gray=np.random.default_rng(0).random((SIDE, SIDE)))
    assert measures(slope)["fine detail"] < 0.1
    assert measures(step)["fine detail"] == pytest.approx(0.72, abs=0.01)
    assert measures(noise)["fine detail"] > 0.9


def test_gray_histogram() -> None:
    found = picture_statistics(picture(DISC, gray=np.where(ROWS < SIDE / 2, 0.28, 0.7)))
    assert found is not None
    expected = np.zeros(BINS)
    expected[[4, 11]] = 0.5
    np.testing.assert_allclose(found.histogram, expected)


def test_empty_pictures_are_left_out() -> None:
    empty = picture(~ALL)
    assert picture_statistics(empty) is None
    assert len(population([empty, picture(DISC)]).measures) == 1
    with pytest.raises(InputError, match="pictures: expected at least one with a visible surface"):
        population([empty])


def test_equal_populations_are_at_distance_0() -> None:
    own = population([picture(DISC), picture(ALL, gray=COLUMNS / SIDE)])
    same = compare(own, own)
    assert (same.distances == 0).all()
    assert same.gray_distance == 0
    assert same.sentences() == []
    assert "Nothing differs clearly." in str(same)


def test_different_populations() -> None:
    rng = np.random.default_rng(1)
    real = Population(rng.random((40, len(MEASURES))), np.full(BINS, 1 / BINS))
    own = real.measures.copy()
    own[:, 1] += 2  # silhouettes
    own[:, 3] -= 2  # creases
    own[:, 6] -= 2  # gradient energy
    own[:, 5] += CLEAR / 4  # mean gray, not clearly
    dark = np.zeros(BINS)
    dark[: BINS // 2] = 2 / BINS
    comparison = compare(Population(own, dark), real)
    assert dict(zip(MEASURES, comparison.distances, strict=True)) == pytest.approx(
        dict.fromkeys(MEASURES, 0)
        | {"silhouettes": 1, "creases": -1, "gradient energy": -1, "mean gray": comparison.distances[5]}
    )
    assert comparison.gray_distance == pytest.approx(0.5)
    assert comparison.sentences() == [
        "Own shapes have more pixels at silhouettes.",
        "Own shapes have fewer pixels at creases.",
        "Own shapes have less gradient energy.",
    ]
    table = comparison.table().splitlines()
    assert {len(line) for line in table} == {len(table[0])}
    assert len(table) == 2 + len(MEASURES)
    assert "| 0.94 .. 1.00 |  0.0 % | 6.2 % |       -6.2 |" in comparison.histogram_table()


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A data set of two files, compared with their folder: the same pictures, up to float16."""
    shapes = tmp_path / "shapes"
    shapes.mkdir()
    box = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
    for name in ("a.off", "b.off"):
        (shapes / name).write_text(box)
    (shapes / "c.off").write_text("nothing of the kind")
    plan = Plan(seed=3, shapes=2, test_shapes=1)
    files = sorted(shapes.glob("[ab].off"))
    dataset = Dataset.create(tmp_path / "set", plan, [str(file) for file in files])
    for number, file in enumerate(files):
        for size in SIZES:
            view = bob.trace(bob.load(file), plan.camera(number, size), size=(size, size)).stack()[1:]
            dataset.write(number, size, view.astype(np.float16))

    own = population(pictures_of_dataset(dataset))
    direct = population(pictures_of_files(files, plan))
    np.testing.assert_allclose(own.measures, direct.measures, rtol=0.05)

    markdown = tmp_path / "comparison.md"
    assert main(["dataset", "compare", str(tmp_path / "set"), str(shapes), "--markdown", str(markdown)]) in (0, None)
    out, err = capsys.readouterr()
    assert err.startswith("bobrossnet: warning: left out: c.off: ")
    assert "2 own pictures and 2 real ones, 256x256 pixels." in markdown.read_text()
    assert markdown.read_text() in out
    with pytest.raises(InputError, match="expected shape files, got none"):
        compare_with_folder(dataset, tmp_path / "set" / "views_128" / "c")
