"""Random textures for training: tiles, checks, gratings, noise of several scales, blobs, lettering.

A texture is (`SIDE`, `SIDE`, 3) uint8, sRGB, and tiles seamlessly. `u` and `v` are 0..1, to the right and down.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bobrossnet.learn.shapes.meshes.parts import Array, Rng

SIDE = 512  # texels

Picture = Array
"""(`SIDE`, `SIDE`, 3) float64, sRGB 0..1 or slightly beyond."""


def some_texture(rng: Rng) -> NDArray[np.uint8]:
    """Return a texture of a random kind."""
    return np.rint(255 * np.clip(_some_picture(rng), 0, 1)).astype(np.uint8)


def some_color(rng: Rng) -> Array:
    """Return a colour, (3,) sRGB 0..1, of any brightness except near black, mostly muted."""
    value, saturation = rng.uniform(0.2, 1), rng.beta(1.2, 1.6)
    hue = np.abs((6 * rng.random() + np.array([0, 4, 2])) % 6 - 3) - 1
    return np.asarray(value * (1 - saturation * (1 - np.clip(hue, 0, 1))))


def palette(rng: Rng, count: int) -> Array:
    """Return `count` colours, (count, 3) sRGB: unrelated, or shades of one."""
    colors = np.array([some_color(rng) for _ in range(count)])
    if rng.random() < 0.4:
        colors = np.clip(colors[0] * rng.uniform(0.3, 1.4, (count, 1)) + rng.normal(0, 0.05, (count, 3)), 0, 1)
    return colors


def tiles(rng: Rng) -> Picture:
    """Tiles, bricks or planks with individual colours and joints."""
    rows, columns = int(rng.choice([2, 4, 6, 8, 12])), int(rng.integers(2, 11))
    v, u = _places()
    row = np.floor(v * rows).astype(int)
    across = (u * columns + 0.5 * (rng.random() < 0.5) * (row % 2)) % columns
    colors = palette(rng, int(rng.integers(2, 6)))
    chosen = rng.integers(len(colors), size=(rows, columns))[row, np.floor(across).astype(int)]
    shade = rng.uniform(0.85, 1.15, (rows, columns))[row, np.floor(across).astype(int)]
    joint = rng.uniform(0.02, 0.12)
    apart = (v * rows % 1 < joint) | (across % 1 < joint * rng.choice([0, 0.5, 1]))
    return np.where(apart[..., None], some_color(rng), colors[chosen] * shade[..., None])


def checks(rng: Rng) -> Picture:
    """Squares of two colours."""
    count = 2 * int(rng.integers(1, 13))
    v, u = _places()
    colors = palette(rng, 2)
    return np.asarray(colors[(np.floor(u * count) + np.floor(v * count)).astype(int) % 2])


def gratings(rng: Rng) -> Picture:
    """Stripes, soft or hard, in one direction or crossed in two."""
    v, u = _places()
    colors = palette(rng, 3)
    picture = np.broadcast_to(colors[0], (SIDE, SIDE, 3))
    hard, duty = rng.random() < 0.5, rng.uniform(-0.6, 0.6)
    for color in colors[1 : 2 + rng.integers(2)]:
        waves = rng.integers(-16, 17, 2)
        wave = np.sin(2 * np.pi * (waves[0] * u + waves[1] * v) + rng.uniform(0, 6.3))
        share = (wave > duty) * 1.0 if hard else 0.5 + 0.5 * wave
        picture = picture + share[..., None] * (color - picture) * rng.uniform(0.5, 1)
    return picture


def clouds(rng: Rng) -> Picture:
    """Noise of several scales, from stains to grain, on a ramp of a few colours with additional grain."""
    height = _noise(rng, rng.uniform(0.7, 2.2), rng.uniform(0.5, 6))
    colors = palette(rng, int(rng.integers(2, 5)))
    places = np.clip(0.5 + rng.uniform(0.15, 0.4) * height, 0, 1) * (len(colors) - 1)
    picture = np.stack([np.interp(places, np.arange(len(colors)), colors[:, i]) for i in range(3)], -1)
    grain = 1 + rng.choice([0, 0.05, 0.15]) * _noise(rng, rng.uniform(0.3, 1), 20)
    return np.asarray(picture * grain[..., None])


def blobs(rng: Rng) -> Picture:
    """Spots, patches and veins with hard edges: levels of smooth noise."""
    height = _noise(rng, rng.uniform(1.8, 3), rng.uniform(1, 8))
    colors = palette(rng, int(rng.integers(2, 6)))
    levels = np.sort(rng.uniform(-1.2, 1.2, len(colors) - 1))
    picture = colors[np.searchsorted(levels, height)]
    if rng.random() < 0.3:
        picture = np.where((np.abs(height - levels[0]) < rng.uniform(0.02, 0.15))[..., None], some_color(rng), picture)
    return np.asarray(picture)


def lettering(rng: Rng) -> Picture:
    """Lines of letters, random strokes of 5 x 3 squares, with gaps between words."""
    lines = int(rng.choice([4, 6, 8, 12, 16, 24]))
    letters = int(lines * rng.uniform(1, 1.8))
    strokes = rng.random((lines, letters, 5, 3)) < 0.6
    strokes &= rng.random((lines, letters, 1, 1)) < 0.85
    cells = np.pad(strokes, ((0, 0), (0, 0), (0, 3), (0, 1)))
    page = cells.transpose(0, 2, 1, 3).reshape(lines * 8, letters * 4)
    v, u = _places()
    inked = page[np.floor(v * page.shape[0]).astype(int), np.floor(u * page.shape[1]).astype(int)]
    paper, ink = palette(rng, 2)
    return np.asarray(np.where(inked[..., None], ink, paper))


def collage(rng: Rng) -> Picture:
    """Two kinds next to each other, as where a picture on a wall ends."""
    height = _noise(rng, rng.uniform(2, 3), 1)
    return np.where((height > rng.uniform(-0.7, 0.7))[..., None], _some_picture(rng), _some_picture(rng))


KINDS: dict[Callable[[Rng], Picture], float] = {
    clouds: 0.27,
    blobs: 0.16,
    tiles: 0.15,
    checks: 0.07,
    gratings: 0.1,
    lettering: 0.1,
    collage: 0.15,
}
"""Weight of each kind. A generator's texture depends on every entry and on their order."""


def _some_picture(rng: Rng) -> Picture:
    return list(KINDS)[rng.choice(len(KINDS), p=list(KINDS.values()))](rng)


def _places() -> tuple[Array, Array]:
    """Return v and u of the texel centres, (SIDE, SIDE) each."""
    places = (np.arange(SIDE) + 0.5) / SIDE
    v, u = np.meshgrid(places, places, indexing="ij")
    return v, u


def _noise(rng: Rng, falloff: float, least: float) -> Array:
    """Return noise of unit variance, (SIDE, SIDE).

    The amplitudes fall with a power of the frequency, from `least` waves across the texture on.
    """
    waves = np.hypot(*np.meshgrid(np.fft.fftfreq(SIDE, 1 / SIDE), np.fft.rfftfreq(SIDE, 1 / SIDE), indexing="ij"))
    amplitudes = np.where(waves > 0, np.maximum(waves, least) ** -falloff, 0)
    height = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(SIDE, SIDE))) * amplitudes, s=(SIDE, SIDE))
    return np.asarray(height / height.std())
