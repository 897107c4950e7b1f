"""The predicted error of completed pictures."""

import numpy as np
import pytest
from models import MODELS, needs_models

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion import uncertainty
from bobrossnet.completion.network import load_network
from bobrossnet.completion.weights import UNCERTAINTY, read_weights
from bobrossnet.learn.calibrate import FEATURES, HIGHEST, LOWEST, SURE, calibrate
from bobrossnet.learn.evaluation.scenes import each_scene, scenes_of_folder

SIZE = (60, 83)


def by_the_layers(gbuffer, model, weights):
    """Compute the prediction from its features, in numpy."""
    features = np.empty((FEATURES, *gbuffer.size), np.float32)
    predicted = load_network(model).predict(gbuffer)
    _core.error_features(gbuffer.layout.core, gbuffer.planes, predicted[None], features)
    hidden = np.einsum("jk,kyx->jyx", weights["hidden.weight"], features) + weights["hidden.bias"][:, None, None]
    output = np.einsum("j,jyx->yx", weights["output.weight"][0], np.maximum(hidden, 0)) + weights["output.bias"]
    return np.where(gbuffer.mask > 0, 0, np.exp(np.clip(output, LOWEST, HIGHEST)))


@pytest.mark.parametrize("model", ["default", "paper"])
@pytest.mark.parametrize("fraction", [0.001, 0.05, 0.6])
def test_it_is_what_was_learned(fraction, model, tree, every_instruction_set):
    part = bob.trace(tree, size=SIZE, fraction=fraction)
    for name in every_instruction_set:
        _core.set_isa(name)
        error = bob.uncertainty(part, model=model)
        assert error.dtype == np.float32
        expected = by_the_layers(part, model, read_weights(UNCERTAINTY)[1])
        np.testing.assert_allclose(error, expected, rtol=1e-4, atol=1e-6, err_msg=name)


def test_what_is_traced_is_certain(tree):
    part = bob.trace(tree, size=SIZE, fraction=0.2)
    error = bob.uncertainty(part)
    assert ((error == 0) == (part.mask == 1)).all()
    assert error.max() <= 1
    assert not bob.uncertainty(bob.trace(tree, size=SIZE)).any()


def test_nothing_known_is_not_certain():
    nothing = np.zeros(SIZE, np.float32)
    error = bob.uncertainty(
        bob.GBuffer(mask=nothing, gray=nothing, depth=nothing, normal=np.zeros((*SIZE, 2), np.float32))
    )
    assert np.isfinite(error).all()
    assert error.mean() > 0.01


def test_it_is_where_the_picture_is_wrong(tree):
    full = bob.trace(tree, size=(240, 320))
    for order in ("uniform", "lattice", "adaptive"):
        part = full.sample(0.05, order=order)
        wrong, expected = np.abs(bob.complete(part) - full.gray).ravel(), bob.uncertainty(part).ravel()
        worst = np.argsort(expected)[-len(expected) // 10 :]
        assert wrong[worst].sum() > 0.45 * wrong.sum()
        assert np.corrcoef(wrong, expected)[0, 1] > 0.4


@needs_models
@pytest.mark.filterwarnings("ignore::bobrossnet.support.errors.InputWarning")
def test_it_is_calibrated_on_real_models():
    ratios = []
    for number, _, scene in each_scene(scenes_of_folder(MODELS, 14), stacklevel=1):
        full = bob.trace(scene, bob.Camera(azimuth=50 * number), size=(160, 160))
        for order in ("uniform", "lattice", "adaptive"):
            for fraction in (0.01, 0.05, 0.25):
                part = full.sample(fraction, order=order, seed=number)
                wrong = np.abs(bob.complete(part) - full.gray).mean()
                ratios.append((wrong + 1e-6) / (bob.uncertainty(part).mean() + 1e-6))
    assert np.mean(np.array(ratios) <= 1) >= 0.85
    assert np.mean(np.abs(np.log2(ratios)) <= 1) >= 0.8


def test_it_can_be_learned_again(tmp_path, tree, monkeypatch):
    file = tmp_path / "uncertainty.safetensors"
    ratios = calibrate(file, shapes=5, steps=300)
    assert np.mean(np.array(ratios) <= 1) == pytest.approx(SURE, abs=0.03)
    metadata, tensors = read_weights(file)
    assert metadata["network"] == "uncertainty"
    part = bob.trace(tree, size=SIZE, fraction=0.1)
    monkeypatch.setattr(uncertainty, "_predictor", lambda: _core.ErrorPredictor(tensors))
    error = bob.uncertainty(part)
    np.testing.assert_allclose(error, by_the_layers(part, "default", tensors), rtol=1e-4, atol=1e-6)
    assert 0.2 < error.mean() / np.abs(bob.complete(part) - bob.trace(tree, size=SIZE).gray).mean() < 5


def test_learning_again_makes_the_same_file(tmp_path):
    one, two = tmp_path / "one.safetensors", tmp_path / "two.safetensors"
    assert calibrate(one, shapes=2, steps=5) == calibrate(two, shapes=2, steps=5)
    assert one.read_bytes() == two.read_bytes()


def test_bad_arguments_are_named(tmp_path):
    with pytest.raises(bob.InputError, match="gbuffer: expected a GBuffer, got list"):
        bob.uncertainty([])
    with pytest.raises(bob.InputError, match="model: expected one of default, filling, paper, small or"):
        bob.uncertainty(bob.trace(bob.happy_tree(), size=(8, 8), fraction=0.5), model="oil")
    with pytest.raises(bob.InputError, match="shapes: expected an integer in 2"):
        calibrate(tmp_path / "x.safetensors", shapes=1)
    with pytest.raises(bob.InputError, match=r"nowhere"):
        calibrate(tmp_path / "nowhere" / "x" / "y.safetensors", shapes=2)
