"""Procedural meshes and evaluation, at toy size."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.complete.model import weights_path
from bobrossnet.errors import InputError
from bobrossnet.learn import checkpoint
from bobrossnet.learn.evaluate import Evaluation, evaluate
from bobrossnet.learn.shapes.meshes import FAMILIES, parts, procedural_mesh


@pytest.mark.parametrize("seed", range(0, 60, 3))
def test_procedural_mesh(seed: int) -> None:
    mesh, again = procedural_mesh(seed), procedural_mesh(seed)
    np.testing.assert_array_equal(mesh.vertices, again.vertices)
    np.testing.assert_array_equal(mesh.triangles, again.triangles)
    size = np.ptp(mesh.vertices, axis=0)
    assert size.max() == pytest.approx(2)
    assert 12 <= len(mesh.triangles) < 500_000
    assert not np.array_equal(mesh.vertices[:50], procedural_mesh(seed + 1).vertices[:50])


@pytest.mark.parametrize("family", list(FAMILIES))
@pytest.mark.parametrize("seed", range(4))
def test_every_family(family: str, seed: int) -> None:
    vertices, triangles = FAMILIES[family](np.random.default_rng(seed))
    assert np.isfinite(vertices).all()
    assert triangles.min() >= 0
    assert triangles.max() < len(vertices)
    assert np.ptp(vertices, axis=0).max() > 0


@pytest.mark.parametrize(
    "part",
    [
        parts.sphere(24),
        parts.torus(1, 0.3),
        parts.box(1, 2, 3),
        parts.box(1, 2, 3, 0.1),
        parts.cylinder(1, 2),
        parts.extrude(parts.round_outline(12), parts.round_outline(12) * 0.5, 0.3),
        parts.isosurface(sum(axis**2 for axis in parts.lattice(20)) - 0.5),  # type: ignore[arg-type]
        parts.isosurface(sum(abs(axis) for axis in parts.lattice(16)) - 0.8),  # type: ignore[arg-type]
        parts.bitmap(np.eye(3, dtype=bool)[[0, 0, 1]], 1, 1),
    ],
    ids=["sphere", "torus", "box", "bevelled", "cylinder", "tube", "ball", "octahedron", "bitmap"],
)
def test_parts_are_closed_and_face_outwards(part: parts.Part) -> None:
    vertices, triangles = part
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = np.cross(b - a, c - a)
    np.testing.assert_allclose(area.sum(0), 0, atol=1e-9)  # closed
    assert (a * area).sum() / 6 > 0.1  # volume


def made_up(differences: list[list[float]]) -> Evaluation:
    """An evaluation of a model whose SSIM is (P, F) `differences` above 0.5, the filling's; its PSNR is 30, 20."""
    above = np.array(differences)
    model, filling = np.stack([0.5 + above, np.full_like(above, 30)], -1), np.full((*above.shape, 2), (0.5, 20))
    pictures = tuple(f"picture {i}" for i in range(len(above)))
    return Evaluation(pictures, (0.01, 0.05)[: above.shape[1]], {"paper": model, "nearest": filling})


def test_gain_is_paired() -> None:
    result = made_up([[0.1, -0.02], [0.2, -0.02], [0.3, -0.02], [0.4, -0.02]])
    half = 1.96 * math.sqrt((0.15**2 + 0.05**2) * 2 / 3) / 2  # n - 1 = 3; √n = 2
    np.testing.assert_allclose(result.gain("nearest"), [[0.25, half], [-0.02, 0]], atol=1e-12)
    assert result.gain_table() == (
        "| traced | 1 % | 5 % |\n| --- | --- | --- |\n| over nearest | +0.2500 ± 0.1265 | -0.0200 ± 0.0000 |"
    )
    with pytest.raises(InputError, match="over: expected one of nearest, got 'paper'"):
        result.gain("paper")
    # A difficulty that both methods share widens nothing.
    hard = np.array([0.1, 0.4, 0, 0.3])[:, None, None]
    shifted = Evaluation(result.pictures, result.fractions, {k: v - hard for k, v in result.scores.items()})
    np.testing.assert_allclose(shifted.gain("nearest"), result.gain("nearest"), atol=1e-12)


def test_gain_covers_the_truth_in_95_of_100() -> None:
    rng = np.random.default_rng(0)
    trials = np.array([made_up(rng.normal(0.03, 0.1, (50, 1)).tolist()).gain("nearest")[0] for _ in range(2000)])
    covered = np.mean(np.abs(trials[:, 0] - 0.03) <= trials[:, 1])
    assert covered == pytest.approx(0.945, abs=0.015)  # 1.96 for Student's 2.01; three standard errors of the trials


def test_tables() -> None:
    result = made_up([[0.1, -0.02], [0.2, -0.02]])
    assert result.table("ssim").splitlines()[2:] == [
        "| paper | **0.6500** | 0.4800 |",
        "| nearest | 0.5000 | **0.5000** |",
    ]
    assert result.table("psnr").splitlines()[3] == "| nearest | 20.00 | 20.00 |"
    for part in ("SSIM\n\n| traced", result.gain_table(), "PSNR, dB\n\n| traced"):
        assert part in str(result)
    single = made_up([[0.1, -0.02]])
    assert np.isnan(single.gain("nearest")[:, 1]).all()
    alone = Evaluation(single.pictures, single.fractions, {"paper": single.scores["paper"]})
    assert "Gain" not in str(alone)


def test_evaluation_of_a_folder(tmp_path: Path) -> None:
    """Names, files left out, progress, and a model called like a filling."""
    weights = tmp_path / "nearest.safetensors"
    checkpoint.save(weights, checkpoint.load(weights_path("paper"))[0])
    models = tmp_path / "broken_odd" / "models"  # what lies above the folder doesn't matter
    (models / "broken_odd").mkdir(parents=True)
    triangle = "v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n"
    for name in ("a.obj", "b.OBJ", "broken_odd/c.obj"):
        (models / name).write_text(triangle)
    for i in range(23):
        (models / f"z{i:02}.obj").write_text("f 1 2 3\n")
    lines: list[str] = []
    options: dict[str, Any] = {"size": (16, 20), "fractions": [0.1, 0.5], "report": lines.append}
    result = evaluate(weights, models, views=2, **options)
    assert result.pictures == ("a.obj view 0", "a.obj view 1", "b.OBJ view 0", "b.OBJ view 1")
    assert list(result.scores) == ["model nearest", "nearest", "pull-push", "delaunay-linear"]
    assert {scores.shape for scores in result.scores.values()} == {(4, 2, 2)}
    assert not np.array_equal(result.scores["model nearest"], result.scores["nearest"])
    assert sum(line.startswith("left out: ") for line in lines) == 23
    assert lines[-1] == "evaluated 25/25 files"  # though the 25th was left out

    camera = bob.Camera(azimuth=30 + 180, elevation=45)
    full = bob.trace(bob.Scene(bob.load_mesh(models / "b.OBJ")), camera, size=(16, 20))
    image = bob.complete(full.sample(0.5, seed=3), model=weights)
    expected = [bob.ssim(image, full.gray), bob.psnr(image, full.gray)]
    assert result.scores["model nearest"][3, 1].tolist() == expected

    for bad, message in (
        ({"views": 0}, "views: expected an integer in 1"),
        ({"limit": 0}, "limit: expected an integer in 1"),
        ({"size": (10, 20)}, "size: expected at least 11x11 pixels"),
        ({"fractions": []}, "fractions: expected at least one"),
        ({"fractions": [0]}, "fractions: expected a number in"),
        ({"fillings": ["farthest"]}, "fillings: expected some of nearest, pull-push, delaunay-linear, got 'farthest'"),
        ({"order": "spiral"}, "order: expected one of uniform"),
    ):
        with pytest.raises(InputError, match=message):
            evaluate(weights, models, **{**options, **bad})
    with pytest.raises(InputError, match="expected mesh files"):
        evaluate(weights, models / "broken_odd" / "none", **options)
