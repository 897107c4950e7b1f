"""One step of a converging picture."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.complete import complete, completed_color
from bobrossnet.completion.guided import complete_guided, guided_alpha, smoothed
from bobrossnet.completion.network import Network
from bobrossnet.completion.uncertainty import mean_error
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import Size
from bobrossnet.pictures.background import Background, picture_of
from bobrossnet.pictures.rendered import Picture


def smaller(size: Size, scale: float) -> Size:
    """Return the size of a moving picture: height and width divided by `scale`."""
    height, width = (max(1, round(length / scale)) for length in size)
    return height, width


def enlarged(picture: NDArray[np.float32], size: Size) -> NDArray[np.float32]:
    """Return a picture, (h, w) or (h, w, channels), enlarged bilinearly to (H, W)."""
    planes = np.ascontiguousarray(picture[None] if picture.ndim == 2 else np.moveaxis(picture, -1, 0))
    output = np.empty((len(planes), *size), np.float32)
    _core.enlarge(planes, output)
    return output[0] if picture.ndim == 2 else np.moveaxis(output, 0, -1)


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Frame:
    """One step of a converging picture. In a notebook it shows itself; `save` writes it."""

    image: NDArray[np.float32]
    """(H, W): traced pixels unchanged, the others completed; in 0..1 unless traced values exceed it."""
    gbuffer: GBuffer
    """All pixels traced so far; of a moving view, it may be smaller than the image."""
    fraction: float
    """Share of the pixels traced so far, 1 in the last frame."""
    seconds: float
    """Time for tracing and completing this frame."""
    network: Network
    """The network that completed the image."""
    shown: GBuffer
    """Input of the completion: traced pixels, and samples reprojected from earlier cameras."""
    guided_color: NDArray[np.float32] | None = None
    """The colour completed along guides, if that has been done."""
    guided_alpha: NDArray[np.float32] | None = None
    """The same for alpha."""

    @property
    def is_guided(self) -> bool:
        """Whether the image was completed along guides instead of by the network."""
        return self.shown.guides is not None

    @property
    def is_enlarged(self) -> bool:
        """Whether the image was completed at a smaller size, and enlarged."""
        return self.shown.size != self.image.shape

    @property
    def color(self) -> NDArray[np.float32]:
        """(H, W, 3), linear RGB in the image's range, completed along with the image; computed on each access."""
        if self.is_guided:
            return complete_guided(self.shown, "color") if self.guided_color is None else self.guided_color.copy()
        if self.shown.mask.all():
            color = self.shown.color.copy()
        else:
            color = completed_color(self.shown, complete(self.shown, self.network) if self.is_enlarged else self.image)
        return enlarged(color, self.image.shape) if self.is_enlarged else color

    @property
    def alpha(self) -> NDArray[np.float32]:
        """(H, W): completed coverage of each pixel; 1 everywhere if the background is lit. Computed on each access."""
        shown = self.shown
        if "shadow" not in shown.layout.places:  # the core's light shows no background
            missed = (shown.mask > 0) & (shown.depth == 0)
            if (shown.gray[missed] > 0).any():
                return np.ones_like(self.image)
        if self.is_guided:
            return guided_alpha(shown) if self.guided_alpha is None else self.guided_alpha.copy()
        alpha = complete(shown, self.network, channel="alpha")
        return enlarged(alpha, self.image.shape) if self.is_enlarged else alpha

    def picture(self, background: Background = None) -> Picture:
        """Return the frame in sRGB, on a background as in `render`."""
        color, alpha = self.color, self.alpha
        if self.is_guided and not self.is_enlarged:
            color, alpha = smoothed(self.shown, color, alpha)
        return picture_of(color, alpha, background)

    def save(self, path: str | os.PathLike[str], background: Background = None) -> None:
        """Write the frame's picture in the format of the ending, as `Picture.save` does."""
        self.picture(background).save(path)

    def _repr_png_(self) -> bytes:
        return self.picture()._repr_png_()

    def __repr__(self) -> str:
        height, width = self.image.shape
        return f"Frame({height} x {width}, {100 * self.fraction:.4g} % traced, {1000 * self.seconds:.3g} ms)"

    @property
    def error(self) -> float:
        """Predicted mean absolute error of the image, in gray: an upper bound in about nine of ten pictures. 0 in the
        last frame. Computed on each access, in the time of two completions."""
        return mean_error(self.gbuffer, self.network)
