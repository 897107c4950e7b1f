"""The losses, and the equality of SSIM in torch and in numpy."""

import numpy as np
import pytest
import torch

from bobrossnet import metrics
from bobrossnet.color import to_srgb
from bobrossnet.learn.losses import LOSSES, OF_REPORT, l2, ssim, visible


def pair(seed: int = 0, size: tuple[int, int] = (40, 52)) -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(seed)
    reference = torch.rand(3, 1, *size, generator=generator)
    reference[1] = 0  # a black one
    return (reference + 0.1 * torch.randn(3, 1, *size, generator=generator)).clamp(0, 1), reference


@pytest.mark.parametrize("size", [(11, 11), (40, 52), (128, 128)])
def test_ssim_equals_numpy(size: tuple[int, int]) -> None:
    image, reference = pair(size=size)
    expected = [metrics.ssim(x.numpy(), y.numpy()) for x, y in zip(image[:, 0], reference[:, 0], strict=True)]
    # float32 against float64. As below, but the pictures vary by 0.17 where their squares reach 0.7, and S is 0.9: at
    # worst 77 u · 1.3 · 0.9 / 0.17 = 3e-5 in one window, the smallest picture. Sums in random orders differed by
    # 1.4e-6.
    np.testing.assert_allclose(ssim(image, reference), expected, atol=1e-5)


def test_names() -> None:
    assert OF_REPORT == ("l1", "l2", "ssim", "ssim+l1", "ssim+l2")
    assert list(LOSSES) == [*OF_REPORT, "ssim+visible"]


def test_worked_values() -> None:
    """Two flat pictures, x = 0.03 and y = 0.01, so dark that C1 matters.

    The error of float32: the variance E[x² + y²] - (E[x]² + E[y]²) is 0, but the rounding error of the two terms is
    divided by C2 = 0.0009. A sum of 11 products is within 11 u, u = 2⁻²⁴, in any order; smoothing has two sums, so a
    term is within 27 u, including its weights' rounding, and a squared mean within 50 u. With the covariance, where the
    terms are 2xy, S is within 77 u (x² + y² + 2xy) S / C2 = 5e-6. (At 0.3 and 0.1: 5e-4, about the effect of C1.)
    """
    image, reference = torch.full((2, 1, 16, 16), 0.03), torch.full((2, 1, 16, 16), 0.01)
    assert LOSSES["l1"](image, reference).tolist() == pytest.approx([0.02, 0.02], rel=1e-5)
    assert LOSSES["l2"](image, reference).tolist() == pytest.approx([0.0004, 0.0004], rel=1e-5)
    similarity = (2 * 0.03 * 0.01 + metrics.C1) / (0.03**2 + 0.01**2 + metrics.C1)
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
    """Displayed pictures are clamped: on black, −0.1 is right and +0.1 far off; both have a gradient."""
    black = torch.zeros(1, 1, 16, 16)
    below, above = (torch.full_like(black, value, requires_grad=True) for value in (-0.1, 0.1))
    loss = LOSSES["ssim"](below, black)
    assert loss.item() < 0.02 < 0.95 < LOSSES["ssim"](above, black).item()
    loss.backward()  # type: ignore[no-untyped-call]
    assert below.grad is not None
    assert (below.grad < 0).all()  # a step against it increases them, towards black
    assert l2(below, black).item() == pytest.approx(0.01)


@pytest.mark.parametrize("level", [0.0, 0.02, 0.2, 0.7])
def test_visible_differences_are_those_of_flip(level: float) -> None:
    """For flat pictures FLIP has nothing to smooth and no edges; metrics.flip takes sRGB."""
    for step in (0.02, 0.1):
        pictures = np.full((2, 1, 1, 16, 16), level, np.float32)
        pictures[0] += step
        expected = metrics.flip(*to_srgb(pictures[:, 0, 0]))
        assert visible(*torch.from_numpy(pictures)).item() == pytest.approx(expected, rel=0.35)
    black = torch.zeros(1, 1, 16, 16)
    below = torch.full_like(black, -0.1, requires_grad=True)
    loss = visible(below, black)
    assert loss.item() < 0.002
    loss.backward()  # type: ignore[no-untyped-call]
    assert below.grad is not None
    assert (below.grad < 0).all()
