"""Light against Mitsuba 3: the same converged scenes under the same lights.

Lights, skies, diffuse surfaces, mirrors and glass follow the same formulas in both; metals and highlights have the
same facets and Fresnel reflectance. docs/light.md lists the terms that differ by choice; no scene here has them.
"""

import light_of_mitsuba as scenes
import numpy as np
import pytest
from PIL import Image

from bobrossnet.color import from_srgb

CASES = list(scenes.CASES)


@pytest.fixture(scope="module")
def reference():
    with Image.open(scenes.REFERENCE) as image:
        return np.asarray(image.convert("RGB")) / 255


@pytest.mark.parametrize("name", CASES)
def test_light_is_that_of_mitsuba(name, reference, tmp_path):
    ours, inner = scenes.shown_by_ours(scenes.CASES[name])
    difference = 255 * (ours - reference[scenes.tile(name)])
    picture = np.concatenate([255 * ours, 255 * reference[scenes.tile(name)], 128 + 16 * difference], 1)
    Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).save(tmp_path / "ours, Mitsuba's, 16 times more.png")
    assert inner.mean() > 0.1
    assert np.abs(difference[inner]).mean() < 1, tmp_path
    assert np.abs(difference[inner].mean(0)).max() < 0.4, tmp_path  # a mean has little noise


@pytest.mark.parametrize("name", CASES)
def test_the_reference_is_what_mitsuba_renders(name, reference):
    """Few paths, so means of 8 x 8 pixels are compared."""
    mi = pytest.importorskip("mitsuba", reason="mitsuba is not installed; the reference was compared where it is")
    mi.set_variant("scalar_rgb")
    rendered = np.clip(scenes.rendered_by_mitsuba(scenes.CASES[name], 32), 0, 1)
    expected = from_srgb(reference[scenes.tile(name)])

    def blocks(planes):
        return planes.reshape(6, 8, 8, 8, 3).mean((1, 3))

    assert np.abs(blocks(rendered) - blocks(expected)).mean() < 0.01
