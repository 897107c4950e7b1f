"""The default network in PyTorch: its parts, any size, its receptive field, and certain background."""

from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional

from bobrossnet.completion.weights import DEFAULTS
from bobrossnet.learn import checkpoint
from bobrossnet.learn.networks import Pyramid
from bobrossnet.learn.networks.pyramid import FEATURES, HANDED_ON, KNOWN, KNOWN_FINEST
from bobrossnet.support.errors import InputError

LEVELS = 6


def sparse(size: tuple[int, int], density: float, seed: int = 0) -> Tensor:
    """Return a G-buffer (1, 5, H, W) of noise, part of it background, known at a share of the pixels."""
    generator = torch.Generator().manual_seed(seed)
    values = torch.rand(5, *size, generator=generator)
    shown, mask = (torch.rand(2, *size, generator=generator) < torch.tensor([0.7, density])[:, None, None]).float()
    return (mask * torch.stack([torch.ones(size), values[1] * shown, values[2], *(2 * values[3:] - 1)]))[None]


def with_biases(network: Pyramid) -> Pyramid:
    """Return a new network with biases, like a trained one."""
    for name, parameter in network.named_parameters():
        if name.endswith("bias"):
            nn.init.normal_(parameter, std=0.1)
    return network


def test_parameters() -> None:
    network = Pyramid()
    names = [f"{kind}{level}" for level in range(LEVELS, 0, -1) for kind in ("features", "finer")]
    assert [name for name, _ in network.named_children()] == names
    expected = 0
    widths = [int(width) for width in FEATURES.split(",")]
    handed_on = [1, *(int(width) for width in HANDED_ON.split(",")), 0]
    for level in range(1, LEVELS + 1):
        features, finer = network.layer("features", level), network.layer("finer", level)
        known = KNOWN_FINEST if level == 1 else KNOWN
        assert features.weight.shape == (widths[level - 1], known + handed_on[level], 3, 3)
        assert finer.weight.shape == (4 * handed_on[level - 1], widths[level - 1], 3, 3)
        expected += sum(layer.weight.numel() + layer.out_channels for layer in (features, finer))
    assert sum(parameter.numel() for parameter in network.parameters()) == expected


@pytest.mark.parametrize("size", [(1, 1), (5, 7), (64, 64), (65, 129)])
def test_any_size(size: tuple[int, int]) -> None:
    """An additional odd row or column without known pixels changes nothing; pictures of a batch are independent."""
    torch.manual_seed(1)
    network, (height, width) = Pyramid(), size
    gbuffer = torch.cat([sparse(size, 0.2, seed) for seed in (0, 1)])
    image = network(gbuffer)
    assert image.shape == (2, 1, height, width)
    padded = torch.zeros(2, 5, height + height % 2, width + width % 2)
    padded[..., :height, :width] = gbuffer
    torch.testing.assert_close(image, network(padded)[..., :height, :width])
    torch.testing.assert_close(image[1:], network(gbuffer[1:]))


def test_arithmetic_is_that_of_the_picture() -> None:
    """Little is computed beyond its edges, for any size."""
    network = Pyramid()
    whole = network.multiply_adds(512, 640)
    assert whole < 1226
    assert network.multiply_adds(480, 640) == pytest.approx(whole, rel=1e-3)


def doubled(x: np.ndarray) -> np.ndarray:
    """Double the rows by bilinear interpolation, with weights of a quarter and three quarters."""
    before, after = np.concatenate([x[:1], x[:-1]]), np.concatenate([x[1:], x[-1:]])
    return np.stack([(3 * x + before) / 4, (3 * x + after) / 4], 1).reshape(-1, x.shape[1])


def around(x: np.ndarray) -> np.ndarray:
    """Return the 3x3 neighbourhood of each pixel, zeros beyond the edges: (h, w, 3, 3)."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(x, 1), (3, 3))


@pytest.mark.parametrize("size", [(64, 128), (37, 150)])
@pytest.mark.parametrize("density", [0.003, 0.1, 1])
def test_step_by_step(density: float, size: tuple[int, int]) -> None:
    """The network implemented again, block by block in NumPy, without its helpers."""
    torch.manual_seed(2)
    network = with_biases(Pyramid())
    gbuffer = sparse(size, density)
    if density == 1:
        gbuffer[:, 1, :40, :50] = 0  # nothing but background
    blocks = [-(-length // 64) for length in size]  # of the coarsest level
    mask, value, depth, nx, ny = np.zeros((5, 64 * blocks[0], 64 * blocks[1]))
    for plane, channel in zip((mask, value, depth, nx, ny), gbuffer[0].double().numpy(), strict=True):
        plane[: size[0], : size[1]] = channel
    rows, columns = np.indices(mask.shape) + 0.5

    def cut(x: np.ndarray, side: int) -> np.ndarray:
        """Crop to the blocks with a pixel of the picture, in pairs of pixels."""
        height, width = (-(-length // side) if side > 1 else length + length % 2 for length in size)
        return x[:height, :width]

    def convolve(layer: nn.Conv2d, channels: list[np.ndarray]) -> np.ndarray:
        stack = torch.from_numpy(np.stack(channels))[None]
        result = functional.conv2d(stack, layer.weight.double(), layer.bias.double(), padding=1)  # type: ignore[union-attr]
        return result[0].detach().numpy()

    gray, handed, surface = np.zeros(blocks), [], np.ones(blocks)
    for level in range(LEVELS, 0, -1):
        side = 2**level

        def sums(x: np.ndarray, side: int = side) -> np.ndarray:
            return cut(x.reshape(x.shape[0] // side, side, x.shape[1] // side, side).sum((1, 3)), side)

        count = sums(mask)
        mean = {name: sums(mask * x) / np.maximum(count, 1) for name, x in
                {"gray": value, "depth": depth, "nx": nx, "ny": ny}.items()}  # fmt: skip
        right = sums(mask * (columns % side / side - 0.5)) / np.maximum(count, 1)
        down = sums(mask * (rows % side / side - 0.5)) / np.maximum(count, 1)
        background = (count > 0) & (mean["gray"] == 0)
        surface = surface * (around(1.0 - background).max((2, 3)) > 0)
        surprise = np.where(count > 0, mean["gray"] - gray, 0)
        start = cut(doubled(doubled(gray + surprise).T).T, side // 2)
        if level > 1:
            knows = [gray, surprise, mean["depth"], mean["nx"], mean["ny"], count / (count + 1), right, down]
        else:
            traced, unexpected = cut(mask, 1), cut(mask, 1) * (cut(value, 1) - start)
            phases = [x[i::2, j::2] for x in (traced, unexpected) for i in (0, 1) for j in (0, 1)]
            knows = [gray, mean["nx"], mean["ny"], *phases]
            weights = np.outer([1, 2, 1], [1, 2, 1]) / 16
            start = start + (around(unexpected) * weights).sum((2, 3)) / ((around(traced) * weights).sum((2, 3)) + 0.05)
        features = np.maximum(convolve(network.layer("features", level), knows + handed), 0)
        finer = convolve(network.layer("finer", level), list(features))
        handed = []
        for four in finer.reshape(-1, 4, *count.shape):
            plane = np.empty((2 * count.shape[0], 2 * count.shape[1]))
            for i, phase in enumerate(four):
                plane[i // 2 :: 2, i % 2 :: 2] = phase
            handed.append(cut(plane, side // 2))
        gray = start + handed[0]
        surface = cut(surface.repeat(2, 0).repeat(2, 1), side // 2)
    image = network(gbuffer)[0, 0].detach().numpy()
    assert (surface == 0).any() == (density == 1)
    assert np.abs(image - (gray * surface)[: size[0], : size[1]]).max() < 1e-5


def test_far_from_the_surface_it_is_exactly_zero() -> None:
    torch.manual_seed(3)
    network = with_biases(Pyramid())
    gbuffer = sparse((128, 192), 1)
    gbuffer[:, 1:, :, 64:] = 0
    image = network(gbuffer)[0, 0]
    assert (image[:, 64 + 2 :] == 0).all()
    assert (image[:, :64] != 0).all()
    gbuffer[:, :, :, 128:] = 0  # unknown there
    assert (network(gbuffer)[0, 0, :, 160:] != 0).all()


def test_receptive_field() -> None:
    """Four of the coarsest blocks above and below a row of pairs of them."""
    torch.manual_seed(4)
    network = Pyramid()
    for parameter in network.parameters():
        parameter.data.abs_()  # no ReLU may hide a path
    gbuffer = sparse((1024, 8), 0.5).requires_grad_()
    seen = []
    for row in (512, 640 - 1):
        (gradient,) = torch.autograd.grad(network(gbuffer)[0, 0, row, 4], gbuffer)
        seen += gradient.abs().sum((0, 1, 3)).nonzero().flatten().tolist()
    assert (min(seen), max(seen)) == (512 - 256, 640 + 256 - 1)


def test_weight_file_round_trip(tmp_path: Path) -> None:
    path, network = tmp_path / "weights.safetensors", with_biases(Pyramid("4,12,16", "5,2"))
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    checkpoint.save(path, network, {"training": "{}", **DEFAULTS})
    again, header = checkpoint.load(path)
    widths = {"features": "4,12,16", "handed_on": "5,2"}
    assert header == {"format": "bobrossnet-1", "network": "pyramid", "training": "{}", **DEFAULTS, **widths}
    gbuffer = sparse((9, 70), 0.1)
    torch.testing.assert_close(again(gbuffer), network(gbuffer))
    assert again.settings() == widths


@pytest.mark.parametrize(
    ("features", "handed_on"),
    [("", ""), ("4,8", ""), ("4,8", "2,2"), ("4,6", "2"), ("4,0", "2"), ("4;8", "2"), ("4,8", "-1"), ("4,8", "2048")],
)
def test_widths_that_are_none(features: str, handed_on: str) -> None:
    with pytest.raises(InputError, match=r"(features|handed_on): expected"):
        Pyramid(features, handed_on)
