"""Procedural meshes, the data made of them, training and evaluation, at toy size."""

import json
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from bobrossnet.complete.model import weights_path
from bobrossnet.errors import InputError
from bobrossnet.learn import checkpoint, data
from bobrossnet.learn.config import OPTIMIZERS, TrainConfig, config_from_settings
from bobrossnet.learn.shapes.meshes import FAMILIES, parts, procedural_mesh
from bobrossnet.learn.train import keep_known, predict, train, validate

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
    fractions = np.array([data.sample_fraction(0, sample) for sample in range(3000)])
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


def test_a_checkpoint_of_another_configuration(tmp_path: Path, patches: Any) -> None:
    saved, out = tmp_path / "checkpoint.safetensors", tmp_path / "weights.safetensors"
    config = replace(TOY, steps=2, checkpoint_every=1, validate_every=2)
    train(config, out, checkpoint_path=saved, patches=patches)
    train(replace(config, threads=2), out, checkpoint_path=saved, patches=patches)  # threads may differ
    message = "got one of seed 0 instead of 1, batch 4 instead of 2; move the file away"
    with pytest.raises(InputError, match=message):
        train(replace(config, seed=1, batch=2), out, checkpoint_path=saved, patches=patches)

    tensors, header = checkpoint.read_tensors(saved)
    settings = json.loads(header["training"])
    del settings["loss"]  # as if an older version had written it, or a newer one
    checkpoint.write_tensors(saved, tensors, {**header, "training": json.dumps({**settings, "momentum": 0.9})})
    with pytest.raises(InputError, match=r"loss None instead of 'ssim\+l2', momentum 0.9 instead of None"):
        train(config, out, checkpoint_path=saved, patches=patches)
    with pytest.raises(InputError, match="expected a checkpoint, got a file without its step"):
        train(config, out, checkpoint_path=out, patches=patches)


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


def test_schedules() -> None:
    _, cosine = OPTIMIZERS["adamw"]
    rates = [cosine(TOY, step) for step in range(TOY.steps)]
    assert np.argmax(rates) == 4
    assert 0 < rates[-1] < rates[0] < TOY.learning_rate
    assert cosine(replace(TOY, warmup=0), 10) == pytest.approx(TOY.learning_rate / 2)
    _, constant = OPTIMIZERS["adadelta"]
    assert {constant(TOY, step) for step in range(TOY.steps)} == {TOY.learning_rate}


def test_keep_known() -> None:
    partial = torch.zeros(2, 5, 2, 2)
    partial[0, :2, 0, 0] = torch.tensor([1, 0.5])
    partial[1, 0] = 1  # wholly traced
    image = keep_known(torch.full((2, 1, 2, 2), 9.0), partial)
    assert image.flatten(1).tolist() == [[0.5, 9, 9, 9], [9, 9, 9, 9]]


def test_validation_is_of_the_prediction(patches: Any) -> None:
    network, _ = checkpoint.load(weights_path("paper"))
    scores = validate(network, patches[1], TOY)
    assert list(scores) == [0.01, 0.05, 0.25, 0.75, 1.0]
    assert scores[0.01] < scores[0.05] < scores[0.25] < scores[0.75] < 1
    partial, _ = data.batch(patches[1], np.ones((len(patches[1]), 128, 128), np.float32))
    with torch.no_grad():
        half, single = predict(network, partial, bfloat16=True), predict(network, partial)
    assert half.dtype == single.dtype == torch.float32
    assert 0 < (half - single).abs().mean() < 0.02  # bfloat16 has 8 bits, over six layers


NAN = math.nan


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("loss", "l3", r"loss: expected one of l1, l2, ssim, ssim\+l1, ssim\+l2, got 'l3'"),
        ("network", "papper", "network: expected one of paper, got 'papper'"),
        ("order", ["uniform"], "order: expected one of uniform, got"),
        ("optimizer", None, "optimizer: expected one of adamw, adadelta, got None"),
        ("groups", 0, "groups: expected an integer in 1"),
        ("seed", -1, "seed: expected an integer in 0"),
        ("shapes", 0, "shapes: expected an integer in 1..500000, got 0"),
        ("views", 0, "views: expected an integer in 1"),
        ("validation_shapes", 0, "validation_shapes: expected an integer in 1"),
        ("validation_patches", 0, "validation_patches: expected an integer in 1"),
        ("steps", -1, "steps: expected an integer in 0"),
        ("batch", 0, "batch: expected an integer in 1"),
        ("batch", 4.0, "batch: expected an integer, got float 4.0"),
        ("warmup", -1, "warmup: expected an integer in 0"),
        ("validate_every", 0, "validate_every: expected an integer in 1"),
        ("checkpoint_every", 0, "checkpoint_every: expected an integer in 1"),
        ("threads", 0, "threads: expected an integer in 1..1024, got 0"),
        ("learning_rate", NAN, "learning_rate: expected a number above 0, got nan"),
        ("learning_rate", 0, "learning_rate: expected a number above 0, got 0"),
        ("weight_decay", -1e-4, "weight_decay: expected a number of at least 0, got -0.0001"),
        ("weight_decay", math.inf, "weight_decay: expected a number of at least 0, got inf"),
        ("keep_known", "no", "keep_known: expected True or False, got 'no'"),
        ("bfloat16", 1, "bfloat16: expected True or False, got 1"),
    ],
)
def test_a_configuration_that_cannot_be(field: str, value: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(TOY, **{field: value})


def test_no_field_goes_unchecked() -> None:
    for field in fields(TrainConfig):
        with pytest.raises(InputError, match=f"^{field.name}: expected"):
            replace(TOY, **{field.name: None})  # type: ignore[arg-type]


def test_numbers_of_numpy_can_be_written_to_a_header() -> None:
    config = replace(TOY, seed=np.int64(3), learning_rate=np.float32(0.5))
    assert (config.seed, type(config.seed), type(config.learning_rate)) == (3, int, float)


def test_settings() -> None:
    config = config_from_settings(["steps=20", "bfloat16=true", "learning_rate=1", "loss=l1"])
    assert config == TrainConfig(steps=20, bfloat16=True, learning_rate=1.0, loss="l1")
    assert config_from_settings([]) == TrainConfig()
    for setting, message in {
        "step=20": "step=20: expected NAME=VALUE with a name of network, groups, seed",
        "steps=2e3": "steps=2e3: expected a value of type int",
        "bfloat16=1": "bfloat16=1: expected true or false",
        "batch=0": "batch: expected an integer in 1..2147483647, got 0",
        "learning_rate=nan": "learning_rate: expected a number above 0, got nan",
    }.items():
        with pytest.raises(InputError, match=message):
            config_from_settings([setting])


def test_what_cannot_be_trained_is_refused_before_rendering(tmp_path: Path, patches: Any) -> None:
    lines: list[str] = []
    with pytest.raises(InputError, match="groups: expected a divisor of 20, got 3"):
        train(replace(TOY, groups=3), tmp_path / "weights.safetensors", report=lines.append)
    with pytest.raises(InputError, match="patches: expected some of each kind, got 0 and 4"):
        train(TOY, tmp_path / "weights.safetensors", patches=(patches[0][:0], patches[1]), report=lines.append)
    assert not lines
