"""The page on where the error is: classes of pixels, oracles, text."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def errors():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs")
        yield import_module("errors")


@pytest.fixture(scope="module")
def full(errors):
    """A box with a thin rod."""
    rod = bob.polyline([(0, 0, -1), (0, 0, 1)], radius=0.01)
    return bob.trace([bob.sdf.box(1), rod], bob.Camera(azimuth=30), size=errors.SIZE)


def test_classes_share_the_pixels(errors, full):
    found = errors.classes(full)
    assert list(found) == list(errors.CLASSES)
    assert (np.sum(list(found.values()), 0) == 1).all()
    for name in ("thin parts", "silhouettes", "creases", "smooth"):
        assert found[name].any(), name
    assert not found["creases"][:8].any()


def test_oracles_know_the_truth(errors, full):
    part = full.sample(0.05)
    placed = errors.placed_by_error(full, 0.05, bob.complete)
    assert placed.mask.sum() == part.mask.sum() == round(0.05 * full.mask.size)
    error = {name: np.abs(image - full.gray).mean() for name, image in errors.pictures_of(full, 0.05).items()}
    assert error["default, pixels placed by the error"] < error["default"]
    assert error["best blend of the 8 nearest samples"] < error["the best of these three, pixel by pixel"]
    assert error["the best of these three, pixel by pixel"] <= min(error["default"], error["delaunay-linear"])


def test_the_page_is_what_its_script_writes(errors):
    """But for the numbers."""
    zeros = np.zeros((len(errors.SHARES), len(errors.CLASSES)))
    text = errors.page(1, zeros[0], zeros + 1, zeros, {"default": np.full(len(errors.SHARES), 0.9)})
    current = (ROOT / "docs/errors.md").read_text("utf-8")

    def words(page):
        return [line for line in page.splitlines() if "|" not in line and not any(map(str.isdigit, line))]

    assert words(text) == words(current)
