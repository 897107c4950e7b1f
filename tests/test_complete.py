"""Completion in the core: equal to PyTorch, exact at known pixels, with clear errors."""

import os
import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
import torch
from safetensors.numpy import save_file
from thread_counts import with_threads

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.completion.network import load_network, make_network
from bobrossnet.completion.weights import DEFAULTS, WEIGHTS, read_weights
from bobrossnet.learn import checkpoint
from bobrossnet.learn.networks import Filling, Paper, Pyramid
from bobrossnet.picture.channels import CHANNELS

PAPER = WEIGHTS / "paper.safetensors"
# Even and odd, smaller than a vector and a block; the core's tests use the same sizes under the sanitizers.
SIZES = [(1, 1), (2, 3), (5, 7), (1, 258), (61, 47), (64, 64), (100, 70), (130, 257), (17, 1000), (1000, 17)]


@pytest.fixture(scope="module")
def pyramid(tmp_path_factory):
    """A weight file of a new pyramid, with biases."""
    torch.manual_seed(0)
    network = Pyramid()
    for name, parameter in network.named_parameters():
        if name.endswith("bias"):
            torch.nn.init.normal_(parameter, std=0.1)
    path = tmp_path_factory.mktemp("weights") / "pyramid.safetensors"
    checkpoint.save(path, network)
    return path


def noise(size, density):
    """Return a G-buffer (5, H, W) of noise, a third of it background, known at a share of the pixels."""
    random = np.random.default_rng(0)
    stack = random.random((5, *size), dtype=np.float32)
    stack[3:] = 2 * stack[3:] - 1
    stack[1] *= random.random(size) < 0.7
    stack[0] = 1
    return stack * (random.random(size) < density)


@pytest.mark.parametrize("size", [(480, 640), *SIZES])
@pytest.mark.parametrize("groups", [4, 1])
def test_core_equals_pytorch(size, groups, every_instruction_set):
    """Within 1e-5: both sum in float32, in different orders. Weights have unit scale, larger than trained ones."""
    torch.manual_seed(0)
    network = Paper(groups=groups).eval()
    tensors = {name: tensor.numpy() for name, tensor in network.state_dict().items()}
    core = make_network({"network": "paper", **DEFAULTS}, tensors)
    stack = np.random.default_rng(0).random((5, *size), dtype=np.float32)
    with torch.no_grad():
        expected = network(torch.from_numpy(stack)[None])[0, 0].numpy()
    for name in every_instruction_set:
        _core.set_isa(name)
        gray = core.predict(bob.GBuffer.from_stack(stack))
        assert np.abs(gray - expected).max() < 1e-5, name


def test_shipped_weights_equal_pytorch(tree, every_instruction_set):
    _, tensors = read_weights(PAPER)
    network = Paper(groups=4).eval()
    network.load_state_dict({name: torch.from_numpy(tensor) for name, tensor in tensors.items()})
    part = bob.trace(tree, size=(240, 322), fraction=0.05)
    with torch.no_grad():
        expected = network(torch.from_numpy(part.stack().copy())[None])[0, 0].numpy()
    for name in every_instruction_set:
        _core.set_isa(name)
        assert np.abs(load_network("paper").predict(part) - expected).max() < 1e-5, name


@pytest.mark.parametrize("size", SIZES)
def test_pyramid_equals_pytorch(size, pyramid, every_instruction_set):
    network = checkpoint.load(pyramid)[0].eval()
    core = load_network(pyramid)
    for density in (0, 0.001, 0.01, 0.1, 1):
        stack = noise(size, density)
        with torch.no_grad():
            expected = network(torch.from_numpy(stack)[None])[0, 0].numpy()
        for name in every_instruction_set:
            _core.set_isa(name)
            gray = core.predict(bob.GBuffer.from_stack(stack))
            assert np.abs(gray - expected).max() < 1e-5, (name, density)
            assert np.array_equal(gray == 0, expected == 0), (name, density)


@pytest.mark.parametrize("size", [(480, 640), *SIZES])
def test_filling_equals_pytorch(size, every_instruction_set):
    network, core = Filling(), load_network("filling")
    for density in (0, 0.001, 0.01, 0.1, 1):
        stack = noise(size, density)
        expected = network(torch.from_numpy(stack)[None, :2])[0, 0].numpy()
        for name in every_instruction_set:
            _core.set_isa(name)
            gray = core.predict(bob.GBuffer.from_stack(stack))
            assert np.abs(gray - expected).max() < 1e-5, (name, density)


def test_pyramid_of_other_widths(tmp_path, tree):
    """The core derives levels and channels from the tensors."""
    network = Pyramid("4,12,16", "5,2").eval()
    checkpoint.save(tmp_path / "small.safetensors", network)
    model = load_network(tmp_path / "small.safetensors")
    part = bob.trace(tree, size=(60, 81), fraction=0.1)
    with torch.no_grad():
        expected = network(torch.from_numpy(part.stack().copy())[None])[0, 0].numpy()
    assert np.abs(model.predict(part) - expected).max() < 1e-5


def test_known_pixels_are_exact(tree):
    for fraction in (0.01, 0.3):
        part = bob.trace(tree, size=(100, 150), fraction=fraction)
        image = bob.complete(part)
        known = part.mask > 0
        assert image.dtype == np.float32
        assert np.array_equal(image[known], part.gray[known])
        assert image.min() >= 0
        assert image.max() <= 1
        assert image[~known].any()


def test_everything_traced_is_exactly_what_was_traced(tree):
    full = bob.trace(tree, size=(50, 70))
    assert np.array_equal(bob.complete(full), full.gray)


def test_more_pixels_make_a_better_picture(tree):
    full = bob.trace(tree, size=(240, 320))
    quality = [bob.ssim(bob.complete(full.sample(f)), full.gray) for f in (0.01, 0.05, 0.25, 0.5, 1.0)]
    assert quality == sorted(quality)
    assert quality[-1] == pytest.approx(1)


def test_threads_do_not_matter(tree, pyramid):
    part = bob.trace(tree, size=(123, 217), fraction=0.1)
    for model in ("filling", "paper", pyramid):
        images = with_threads((1, 2, 5), partial(bob.complete, part, model=model))
        assert np.array_equal(images[0], images[1])
        assert np.array_equal(images[0], images[2])


def test_from_several_threads_at_once(tree, pyramid):
    parts = [bob.trace(tree, size=size, fraction=0.1) for size in ((123, 217), (123, 217), (60, 80))]
    for model in ("filling", "paper", pyramid):
        expected = [bob.complete(part, model=model) for part in parts]
        with ThreadPoolExecutor(3) as pool:
            images = list(pool.map(lambda part, model=model: bob.complete(part, model=model), 5 * parts))
        assert all(np.array_equal(image, expected[i % 3]) for i, image in enumerate(images))


def test_nothing_known_or_everything_extreme_is_finite(pyramid):
    for model in map(load_network, ("filling", pyramid)):
        stack = np.zeros((5, 70, 90), np.float32)
        assert np.isfinite(model.predict(bob.GBuffer.from_stack(stack.copy()))).all()
        stack[:] = 1
        stack[3:] = -1
        assert np.isfinite(model.predict(bob.GBuffer.from_stack(stack))).all()


def test_models_by_name_and_path(tree, tmp_path):
    part = bob.trace(tree, size=(60, 80), fraction=0.1)
    copy = tmp_path / "mine.safetensors"
    shutil.copy(PAPER, copy)
    paper, default = bob.complete(part, model="paper"), bob.complete(part)
    for model in (copy, str(copy), load_network("paper")):
        assert np.array_equal(bob.complete(part, model=model), paper)
    assert np.array_equal(bob.complete(part, model="default"), default)
    assert not np.array_equal(paper, default)


def test_a_file_written_anew_is_read_anew(tree, tmp_path):
    part = bob.trace(tree, size=(60, 80), fraction=0.1)
    file = tmp_path / "mine.safetensors"
    metadata, tensors = read_weights(PAPER)
    save_file(tensors, file, metadata)
    before = bob.complete(part, model=file)
    save_file({name: 0 * tensor for name, tensor in tensors.items()}, file, metadata)
    os.utime(file, ns=(0, file.stat().st_mtime_ns + 10**9))  # file systems have coarse clocks
    assert not np.array_equal(bob.complete(part, model=file), before)


def changed_weights(file, metadata=None, **changed):
    known, tensors = read_weights(PAPER)
    tensors = {name: changed.get(name.replace(".", "_"), tensor) for name, tensor in tensors.items()}
    save_file(
        {name: t for name, t in tensors.items() if t is not None},
        file,
        known if metadata is None else metadata,
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda f: None, "can't read"),
        (lambda f: f.write_bytes(b""), "expected a safetensors file"),
        (lambda f: f.write_bytes(b"\xff" * 4096), "expected a safetensors file"),
        (lambda f: f.write_bytes(PAPER.read_bytes()[:-100]), "expected a safetensors file"),
        (
            lambda f: changed_weights(f, {"format": "pt"}),
            "expected weights of format bobrossnet-1, got format 'pt'",
        ),
        (lambda f: changed_weights(f, {"format": "bobrossnet-1", "network": "oil"}), "got 'oil'"),
        (
            lambda f: changed_weights(f, {"format": "bobrossnet-1", "network": "paper", "inputs": "mask,oil"}),
            f"expected channels among {','.join(CHANNELS)}, got 'oil'",
        ),
        (
            lambda f: changed_weights(f, {"format": "bobrossnet-1", "network": "paper", "outputs": "depth"}),
            "outputs: expected gray, got depth",
        ),
        (
            lambda f: changed_weights(f, {"format": "bobrossnet-1", "network": "pyramid", "inputs": "mask,gray"}),
            "inputs: expected mask,gray,depth,normal, got mask,gray",
        ),
        (lambda f: changed_weights(f, encoded_bias=None), "encoded.bias: expected in the weights, not found"),
        (
            lambda f: changed_weights(f, encode1_weight=np.zeros((20, 4, 3, 3), np.float32)),
            "encode1.weight: expected shape (20, 5 / groups, 3, 3), got (20, 4, 3, 3)",
        ),
        (
            lambda f: changed_weights(f, output_bias=np.full(1, np.nan, np.float32)),
            "output.bias: expected finite",
        ),
        (
            lambda f: changed_weights(f, output_bias=np.zeros(1)),
            "output.bias: expected finite float32 values, got float64",
        ),
    ],
)
def test_bad_weight_files_are_named(make, message, tmp_path, tree):
    file = tmp_path / "bad.safetensors"
    make(file)
    with pytest.raises(bob.InputError) as error:
        bob.complete(bob.trace(tree, size=(20, 20), fraction=0.5), model=file)
    assert message in str(error.value)
    assert "bad.safetensors" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"features1.weight": None}, "features1.weight: expected in the weights, not found"),
        (
            {"features2.weight": (20, 12, 3, 3)},
            "features2.weight: expected shape (a multiple of 4, 16, 3, 3), got (20, 12, 3, 3)",
        ),
        (
            {"finer3.weight": (30, 28, 3, 3)},
            "finer3.weight: expected shape (a multiple of 4, 28, 3, 3), got (30, 28, 3, 3)",
        ),
        ({"finer3.bias": (30,)}, "finer3.bias: expected shape (32), got (30)"),
        ({"finer1.weight": (8, 12, 3, 3)}, "finer1.weight: expected shape (4, 12 / groups, 3, 3), got (8, 12, 3, 3)"),
    ],
)
def test_a_pyramid_that_does_not_fit_is_named(changed, message, pyramid, tmp_path):
    metadata, tensors = read_weights(pyramid)
    tensors |= {name: shape and np.zeros(shape, np.float32) for name, shape in changed.items()}
    file = tmp_path / "bad.safetensors"
    save_file({name: tensor for name, tensor in tensors.items() if tensor is not None}, file, metadata)
    with pytest.raises(bob.InputError, match=re.escape(f"bad.safetensors: {message}")):
        load_network(file)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"gbuffer": np.zeros((5, 8, 8), np.float32)}, "gbuffer: expected a GBuffer, got ndarray"),
        (
            {"model": "oil"},
            "model: expected one of default, filling, paper, small or a .safetensors file, got 'oil'",
        ),
        ({"model": 3}, "model: expected a file name, got int"),
        ({"model": "../paper"}, "model: expected one of"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    part = bob.GBuffer.from_stack(np.zeros((5, 8, 8), np.float32))
    with pytest.raises(bob.InputError) as error:
        bob.complete(**({"gbuffer": part} | arguments))
    assert str(error.value).startswith(message)


def test_arrays_in_the_place_of_a_gbuffer_are_answered_with_how_to_make_one():
    part = bob.trace(bob.happy_tree(), size=(16, 16), fraction=0.5)
    with pytest.raises(bob.InputTypeError, match=r"ndarray; bobrossnet.GBuffer\(mask=, gray=, depth=, normal=\) makes"):
        bob.complete(part.gray, part.mask)
