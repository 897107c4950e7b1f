"""SSIM, PSNR and FLIP: compared with scikit-image, by hand, and their errors."""

import time

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from bobrossnet.metrics import C1, flip, psnr, ssim
from bobrossnet.support.errors import InputError, InputTypeError


def pictures(size: tuple[int, int], noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return a smooth picture with a black half, and a noisy copy."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: size[0], : size[1]]
    reference = np.where(x < size[1] / 2, 0, 0.5 + 0.4 * np.sin(x / 7 + y / 5))
    return np.clip(reference + rng.normal(0, noise, size), 0, 1), reference


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.1, 1.0])
@pytest.mark.parametrize("size", [(11, 11), (11, 40), (64, 75), (137, 139), (200, 128)])
def test_ssim_equals_scikit_image(size: tuple[int, int], noise: float) -> None:
    image, reference = pictures(size, noise)
    expected = structural_similarity(  # type: ignore[no-untyped-call]
        image, reference, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1
    )
    assert ssim(image, reference) == pytest.approx(expected, abs=1e-6)
    image32, reference32 = image.astype(np.float32), reference.astype(np.float32)
    assert ssim(image32, reference32) == pytest.approx(expected, abs=1e-6)


def test_ssim_worked_values() -> None:
    black, white = np.zeros((20, 30)), np.ones((20, 30))
    assert ssim(white, white) == 1
    assert ssim(black, white) == pytest.approx(C1 / (1 + C1))  # constant: only luminance counts
    assert ssim(white * 0.01, black) == pytest.approx(0.5)  # on black, an offset of one percent halves it


def test_ssim_is_symmetric_and_falls_with_noise() -> None:
    scores = []
    for noise in (0.0, 0.01, 0.1, 0.3):
        image, reference = pictures((64, 64), noise)
        assert ssim(image, reference) == pytest.approx(ssim(reference, image), abs=1e-12)
        scores.append(ssim(image, reference))
    assert scores == sorted(scores, reverse=True)


def test_psnr() -> None:
    image, reference = pictures((64, 75), 0.1)
    expected = peak_signal_noise_ratio(reference, image, data_range=1)  # type: ignore[no-untyped-call]
    assert psnr(image, reference) == pytest.approx(expected)
    assert psnr(reference + 0.1, reference) == pytest.approx(20)
    assert psnr(reference, reference) == float("inf")


def test_flip_of_gray_as_colors_is_that_of_gray() -> None:
    image, reference = pictures((64, 75), 0.1)
    as_colors = flip(*(np.repeat(gray[..., None], 3, 2) for gray in (image, reference)))
    assert as_colors == pytest.approx(flip(image, reference), abs=1e-5)
    assert psnr(*(np.repeat(gray[..., None], 3, 2) for gray in (image, reference))) == pytest.approx(
        psnr(image, reference)
    )


def test_flip_worked_values() -> None:
    black, white = np.zeros((20, 30)), np.ones((20, 30))
    assert flip(white, white) == 0
    # A lightness of 100, compressed: 100^0.7; beyond 0.4 of the maximum difference, 41.276.
    assert flip(white, black) == pytest.approx(0.95 + 0.05 * (100**0.7 / 41.276 - 0.4) / 0.6, abs=1e-4)
    assert flip(white + 1, black - 1) == flip(white, black)  # clamped


def test_flip_is_symmetric_and_grows_with_noise() -> None:
    scores = []
    for noise in (0.0, 0.01, 0.1, 0.3):
        image, reference = pictures((64, 64), noise)
        assert flip(image, reference) == pytest.approx(flip(reference, image), abs=1e-6)
        scores.append(flip(image, reference))
    assert scores == sorted(scores)
    assert scores[0] == 0


@pytest.mark.parametrize("metric", [ssim, psnr, flip])
def test_bad_input(metric: object) -> None:
    assert callable(metric)
    good = np.zeros((16, 16))
    with pytest.raises(InputError, match=r"expected shape \(16, 16\) to match reference, got \(16, 17\)"):
        metric(np.zeros((16, 17)), good)
    with pytest.raises(InputError, match="reference: expected finite numbers, got 256 of 256"):
        metric(good, good * np.nan)
    with pytest.raises(InputTypeError, match=r"image: expected floats in 0\.\.1, got dtype uint8"):
        metric(good.astype(np.uint8), good)
    message = r"shape \(n, n\), got" if metric is ssim else r"shape \(16, 16\) to match reference, got"
    with pytest.raises(InputError, match=rf"image: expected {message} \(16, 16, 3\)"):
        metric(np.zeros((16, 16, 3)), good)
    with pytest.raises(InputError, match=r"image: expected shape \(n, n(, 3)?\), got \(16, 16, 4\)"):
        metric(np.zeros((16, 16, 4)), good)


def test_ssim_needs_its_window() -> None:
    with pytest.raises(InputError, match=r"at least 11x11 pixels, the SSIM window, got \(10, 64\)"):
        ssim(np.zeros((10, 64)), np.zeros((10, 64)))


def test_ssim_is_fast() -> None:
    image, reference = pictures((480, 640), 0.1)
    times = []
    for _ in range(5):
        start = time.process_time()
        ssim(image, reference)
        times.append(time.process_time() - start)
    assert min(times) < 0.25  # 0.034 s, with a margin for slower machines
