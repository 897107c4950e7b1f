"""The report's network in PyTorch: SPEC's table, any size, and the mixing of groups by shuffling."""

from pathlib import Path

import pytest
import torch
from torch import nn

from bobrossnet.completion.weights import DEFAULTS
from bobrossnet.learn import checkpoint
from bobrossnet.learn.networks import Paper
from bobrossnet.learn.networks.paper import shuffle
from bobrossnet.support.errors import InputError

# SPEC.md's table: in, out, groups, parameters
LAYERS = {
    "encode1": (5, 20, 1, 920),
    "encode2": (20, 80, 4, 3680),
    "encoded": (80, 20, 4, 3620),
    "decode1": (20, 5, 1, 905),
    "decode2": (25, 5, 1, 1130),
    "output": (10, 1, 1, 91),
}


def count(module: nn.Module) -> int:
    return sum(parameter.numel() for parameter in module.parameters())


def test_parameters_are_the_reports() -> None:
    network = Paper()
    assert count(network) == 10_346
    assert count(Paper(groups=1)) == 31_946
    assert [name for name, _ in network.named_children()] == list(LAYERS)
    for name, (inputs, outputs, groups, parameters) in LAYERS.items():
        layer = getattr(network, name)
        assert (layer.in_channels, layer.out_channels, layer.groups) == (inputs, outputs, groups)
        assert count(layer) == parameters
        assert (layer.kernel_size, layer.padding) == ((3, 3), (1, 1))
    assert count(Paper(groups=1).encoded) == 14_420


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (4, 4), (5, 7), (13, 9), (64, 48), (129, 127)])
def test_any_size_is_zero_padded(size: tuple[int, int]) -> None:
    torch.manual_seed(1)
    network, (height, width) = Paper(), size
    gbuffer = torch.randn(2, 5, height, width)
    image = network(gbuffer)
    assert image.shape == (2, 1, height, width)
    padded = torch.zeros(2, 5, height + -height % 4, width + -width % 4)
    padded[..., :height, :width] = gbuffer
    torch.testing.assert_close(image, network(padded)[..., :height, :width])


def test_step_by_step() -> None:
    """The table implemented again, without the network's helpers."""
    torch.manual_seed(2)
    net, gbuffer = Paper(), torch.randn(1, 5, 16, 24)
    pool, up = nn.MaxPool2d(2), nn.Upsample(scale_factor=2, mode="nearest")
    skip = pool(net.encode1(gbuffer).relu())
    wide = pool(net.encode2(skip).relu())
    shuffled = torch.stack([wide[:, g * 20 + i] for i in range(20) for g in range(4)], 1)
    coarse = up(net.decode1(net.encoded(shuffled).relu()).relu())
    fine = up(net.decode2(torch.cat([coarse, skip], 1)).relu())
    torch.testing.assert_close(net(gbuffer), net.output(torch.cat([fine, gbuffer], 1)))


def test_shuffle() -> None:
    channels = torch.arange(12.0).view(1, 12, 1, 1)
    assert shuffle(channels, 4).flatten().tolist() == [0, 3, 6, 9, 1, 4, 7, 10, 2, 5, 8, 11]
    torch.testing.assert_close(shuffle(channels, 1), channels)


def test_shuffle_mixes_the_groups() -> None:
    """Each channel of `encoded` depends on every group of `encode2`; without shuffling, on one."""
    network = Paper()
    wide = torch.rand(1, 80, 6, 6, requires_grad=True)
    for channel in range(20):
        for shuffled, groups in ((shuffle(wide, 4), 4), (wide, 1)):
            (gradient,) = torch.autograd.grad(network.encoded(shuffled)[0, channel].sum(), wide)
            assert (gradient.reshape(4, -1).abs().sum(1) > 0).sum() == groups


def test_receptive_field() -> None:
    """A pixel depends on 14 to 20 pixels in each direction, and no more."""
    torch.manual_seed(0)
    gbuffer = torch.rand(1, 5, 96, 96, requires_grad=True)
    network = Paper()
    for parameter in network.parameters():
        parameter.data.abs_()  # no ReLU may hide a path
    (gradient,) = torch.autograd.grad(network(gbuffer)[0, 0, 48, 48], gbuffer)
    rows = gradient.abs().sum((0, 1, 3)).nonzero().flatten()
    assert 14 <= 48 - int(rows.min()) <= 20
    assert 14 <= int(rows.max()) - 48 <= 20


@pytest.mark.parametrize("groups", [4, 1])
def test_weight_file_round_trip(tmp_path: Path, groups: int) -> None:
    path, network = tmp_path / "weights.safetensors", Paper(groups)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    checkpoint.save(path, network, {"training": "{}", **DEFAULTS})
    again, header = checkpoint.load(path)
    assert header == {"format": "bobrossnet-1", "network": "paper", "groups": str(groups), "training": "{}", **DEFAULTS}
    gbuffer = torch.rand(1, 5, 9, 13)
    torch.testing.assert_close(again(gbuffer), network(gbuffer))
    assert set(again.state_dict()) == {f"{layer}.{kind}" for layer in LAYERS for kind in ("weight", "bias")}
    assert [file.name for file in tmp_path.iterdir()] == ["weights.safetensors"]


def test_equal_weights_make_equal_files(tmp_path: Path) -> None:
    network = Paper()
    for name in map(str, range(8)):
        metadata = {letter: letter for letter in "abcdefgh"}
        checkpoint.save(tmp_path / name, network, metadata)
    contents = {file.read_bytes() for file in tmp_path.iterdir()}
    assert len(contents) == 1
    tensors, header = checkpoint.read_tensors(tmp_path / "0")
    assert header.items() > metadata.items()
    assert all(torch.equal(tensor, tensors[name]) for name, tensor in network.state_dict().items())
    assert tensors.keys() == network.state_dict().keys()


def test_weight_file_that_does_not_fit(tmp_path: Path) -> None:
    path = tmp_path / "weights.safetensors"
    path.write_bytes(b"no")
    with pytest.raises(InputError, match="expected a safetensors file"):
        checkpoint.load(path)
    checkpoint.write_tensors(path, Paper().state_dict(), {"format": "other"})
    with pytest.raises(InputError, match="expected weights of format bobrossnet-1, got format 'other'"):
        checkpoint.load(path)
    header = {"format": "bobrossnet-1", "network": "paper", "groups": "4"}
    checkpoint.write_tensors(path, Paper(1).state_dict(), header)
    with pytest.raises(InputError, match="expected the tensors of 'paper'"):
        checkpoint.load(path)
    checkpoint.write_tensors(path, Paper().state_dict(), {**header, "groups": "3"})
    with pytest.raises(InputError, match="got groups: expected a divisor of 20, got 3"):
        checkpoint.load(path)
    checkpoint.write_tensors(path, Paper().state_dict(), {"format": "bobrossnet-1", "network": "paper"})
    with pytest.raises(InputError, match="expected the tensors of 'paper', got 'groups'"):
        checkpoint.load(path)


@pytest.mark.parametrize("groups", [0, -4, 3, 40])
def test_groups_that_divide_nothing(groups: int) -> None:
    with pytest.raises(InputError, match=f"groups: expected a divisor of 20, got {groups}"):
        Paper(groups)


def test_settings_make_the_network_again() -> None:
    network = Paper(groups=2)
    assert Paper.from_settings(network.settings()).settings() == {"groups": 2}
    assert Paper.from_settings({"groups": "2", "format": "other"}).settings() == {"groups": 2}
