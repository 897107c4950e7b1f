"""The five losses, and that SSIM in torch is the SSIM in numpy."""

import numpy as np
import pytest
import torch

from bobrossnet import metrics
from bobrossnet.learn.losses import LOSSES, l2, ssim


def pair(seed: int = 0, size: tuple[int, int] = (40, 52)) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    reference = torch.rand(3, 1, *size, generator=generator)
    reference[1] = 0  # a black one
    return (reference + 0.1 * torch.randn(3, 1, *size, generator=generator)).clamp(0, 1), reference


@pytest.mark.parametrize("size", [(11, 11), (40, 52), (128, 128)])
def test_ssim_equals_numpy(size: tuple[int, int]) -> None:
    image, reference = pair(size=size)
    expected = [metrics.ssim(x.numpy(), y.numpy()) for x, y in zip(image[:, 0], reference[:, 0], strict=True)]
    np.testing.assert_allclose(ssim(image, reference), expected, atol=2e-6)  # float32 against float64


def test_names() -> None:
    assert list(LOSSES) == ["l1", "l2", "ssim", "ssim+l1", "ssim+l2"]


def test_worked_values() -> None:
    image, reference = torch.full((2, 1, 16, 16), 0.3), torch.full((2, 1, 16, 16), 0.1)
    assert LOSSES["l1"](image, reference).tolist() == pytest.approx([0.2, 0.2])
    assert LOSSES["l2"](image, reference).tolist() == pytest.approx([0.04, 0.04])
    similarity = (2 * 0.3 * 0.1 + metrics.C1) / (0.3**2 + 0.1**2 + metrics.C1)
    assert LOSSES["ssim"](image, reference).tolist() == pytest.approx([1 - similarity] * 2, abs=1e-5)
    both = LOSSES["ssim+l2"](image, reference)
    torch.testing.assert_close(both, LOSSES["ssim"](image, reference) + LOSSES["l2"](image, reference))


@pytest.mark.parametrize("name", list(LOSSES))
def test_zero_where_equal_and_a_gradient_elsewhere(name: str) -> None:
    image, reference = pair()
    assert LOSSES[name](reference, reference).tolist() == pytest.approx([0, 0, 0], abs=1e-6)
    image.requires_grad_()
    LOSSES[name](image, reference).sum().backward()  # type: ignore[no-untyped-call]
    assert image.grad is not None
    assert image.grad.isfinite().all()
    assert (image.grad.flatten(1).abs().sum(1) > 0).all()


def test_black_below_zero_costs_little_but_is_pulled_back() -> None:
    """What's shown is clamped: on black, −0.1 is right and +0.1 far off; neither is without gradient."""
    black = torch.zeros(1, 1, 16, 16)
    below, above = (torch.full_like(black, value, requires_grad=True) for value in (-0.1, 0.1))
    loss = LOSSES["ssim"](below, black)
    assert loss.item() < 0.02 < 0.95 < LOSSES["ssim"](above, black).item()
    loss.backward()  # type: ignore[no-untyped-call]
    assert below.grad is not None
    assert (below.grad < 0).all()  # a step against it goes up, to black
    assert l2(below, black).item() == pytest.approx(0.01)
