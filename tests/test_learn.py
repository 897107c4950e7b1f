"""Procedural meshes, the data made of them, and training, at toy size."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from bobrossnet.errors import InputError
from bobrossnet.learn import checkpoint, data
from bobrossnet.learn.shapes import FAMILIES, parts, procedural_mesh
from bobrossnet.learn.train import TrainConfig, keep_known, learning_rate, train

TOY = TrainConfig(
    shapes=3, views=1, validation_shapes=1, validation_patches=4, steps=20, batch=4, warmup=5,
    learning_rate=1e-2, validate_every=20, checkpoint_every=10, threads=1,
)  # fmt: skip


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


def test_patches_are_a_function_of_the_seed() -> None:
    first = data.render_patches(1, [4], 2)
    np.testing.assert_array_equal(first, data.render_patches(1, [3, 4], 2)[-len(first) :])
    assert first.shape[1:] == (4, 128, 128)
    assert first.dtype == np.float16
    assert not np.array_equal(first[:2], data.render_patches(2, [4], 2)[:2])
    assert first[:, :2].min() >= 0
    assert first[:, :2].max() <= 1
    gray, depth = first[:, 0], first[:, 1]
    assert not gray[depth == 0].any()  # black where there's no surface


def test_batches_are_a_function_of_seed_and_step() -> None:
    patches = np.random.default_rng(0).random((5, 4, 128, 128)).astype(np.float16)
    partial, reference = data.training_batch(patches, 7, 3, 4)
    again, _ = data.training_batch(patches, 7, 3, 4)
    assert torch.equal(partial, again)
    assert partial.shape == (4, 5, 128, 128)
    assert reference.shape == (4, 1, 128, 128)
    mask = partial[:, :1]
    assert torch.equal(partial[:, 1:2], reference * mask)
    assert not partial[:, 1:][(mask == 0).expand(-1, 4, -1, -1)].any()
    seen = [data.training_batch(patches, 7, step, 5)[1] for step in range(2)]  # two epochs
    for epoch in seen:
        means = sorted(epoch.mean((1, 2, 3)).tolist())
        assert means == pytest.approx(sorted(patches[:, 0].mean((1, 2), np.float32)), rel=1e-3)


def test_fractions_and_masks() -> None:
    fractions = np.array([data.fraction(0, sample) for sample in range(3000)])
    assert fractions.min() >= 0.01
    assert (fractions == 1).mean() == pytest.approx(0.1, abs=0.02)
    assert (fractions < 0.1).mean() == pytest.approx(0.45, abs=0.04)  # half of the decades, of nine tenths
    sparse, dense = data.mask(0, 5, 0.05), data.mask(0, 5, 0.25)
    assert (sparse.sum(), dense.sum()) == (819, 4096)
    assert (dense >= sparse).all()  # nested
    assert not np.array_equal(sparse, data.mask(0, 6, 0.05))


@pytest.fixture(scope="module")
def patches() -> tuple[np.ndarray, np.ndarray]:
    return data.render_patches(0, range(3), 1)[:24], data.render_patches(0, [3], 1)[:4]


@pytest.mark.parametrize("optimizer", ["adamw", "adadelta"])
def test_training_learns_and_resumes(tmp_path: Path, patches: Any, optimizer: str) -> None:
    rate = {"adamw": 1e-2, "adadelta": 1.0}[optimizer]
    config = replace(TOY, optimizer=optimizer, learning_rate=rate, validate_every=5)
    lines: list[str] = []
    whole = train(config, tmp_path / "whole.safetensors", patches=patches, report=lines.append)
    losses = [float(line.split("loss ")[1].split()[0]) for line in lines]
    assert losses[-1] < 0.9 * losses[0]

    class StopError(Exception):
        pass

    def stop(line: str) -> None:
        if "step 15/" in line:
            raise StopError

    interrupted, saved = tmp_path / "interrupted.safetensors", tmp_path / "checkpoint.safetensors"
    with pytest.raises(StopError):  # at step 15, five after the checkpoint
        train(config, interrupted, checkpoint_path=saved, patches=patches, report=stop)
    assert not interrupted.exists()
    resumed = train(config, interrupted, checkpoint_path=saved, patches=patches, report=lines.append)
    assert "resumed at step 10" in lines
    for name, tensor in whole.state_dict().items():
        assert torch.equal(tensor, resumed.state_dict()[name]), name
    with pytest.raises(InputError, match="another seed; move it away"):
        train(replace(config, seed=1), interrupted, checkpoint_path=saved, patches=patches)


def test_training_from_nothing_to_a_weight_file(tmp_path: Path) -> None:
    path = tmp_path / "weights.safetensors"
    config = replace(TOY, shapes=1, steps=2, keep_known=True, bfloat16=True)
    lines: list[str] = []
    train(config, path, report=lines.append)
    network, header = checkpoint.load(path)
    assert header["network"] == "paper"
    assert TrainConfig(**json.loads(header["training"])) == config
    assert "min left" in lines[-1]
    assert all(parameter.isfinite().all() for parameter in network.parameters())


def test_learning_rate() -> None:
    rates = [learning_rate(TOY, step) for step in range(TOY.steps)]
    assert np.argmax(rates) == 4
    assert 0 < rates[-1] < rates[0] < TOY.learning_rate


def test_keep_known() -> None:
    partial = torch.zeros(1, 5, 2, 2)
    partial[0, :2, 0, 0] = torch.tensor([1, 0.5])
    assert keep_known(torch.full((1, 1, 2, 2), 9.0), partial).flatten().tolist() == [0.5, 9, 9, 9]


def test_a_name_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"loss: expected one of l1, l2, ssim, ssim\+l1, ssim\+l2, got 'l3'"):
        train(replace(TOY, loss="l3"), tmp_path / "weights.safetensors")
