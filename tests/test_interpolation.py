"""The lattice interpolation in PyTorch equals the core's."""

import numpy as np
import pytest
import torch

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.learn.networks.interpolation import blend, interpolated


@pytest.mark.parametrize("size", [(1, 1), (22, 60), (64, 64), (97, 131), (256, 200)])
@pytest.mark.parametrize("order", ["adaptive", "lattice", "uniform"])
def test_it_is_the_cores(size, order, tree):
    full = bob.trace(tree, size=size)
    for fraction in (0.01, 0.05, 0.25, 1):
        part = full.sample(fraction, order=order)
        image = np.random.default_rng(0).random((1, *size), np.float32)
        expected = image.copy()
        _core.interpolate_lattice(part.layout.core, part.planes, _core.Layout("gray"), expected)
        gray, mask = (torch.from_numpy(plane.copy())[None, None] for plane in (part.gray, part.mask))
        value, weight = interpolated(gray, mask)
        assert not weight[mask > 0].any()
        ours = blend(torch.from_numpy(image)[None], value, weight)[0].numpy()
        untraced = (part.mask == 0)[None]
        np.testing.assert_allclose(ours[untraced], expected[untraced], atol=1e-6, rtol=0)


def test_most_of_an_adaptive_picture_is_interpolated(tree):
    part = bob.trace(tree, size=(128, 128)).sample(0.25, order="adaptive")
    gray, mask = (torch.from_numpy(plane.copy())[None, None] for plane in (part.gray, part.mask))
    _, weight = interpolated(gray, mask)
    assert weight[gray == 0].mean() > 0.5
