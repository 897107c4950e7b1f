"""The default network: a pyramid of means over the traced pixels, completed from coarse to fine.

The traced pixels are averaged over blocks of 2, 4, ... 64 pixels. From the coarsest level on, the picture is
overwritten by the means of blocks with traced pixels, upsampled, and corrected by two convolutions. Their inputs are
the level's means, the mean positions within the blocks, and the coarser level's features. So averaging and
interpolation need not be learned, only the residual.

Its sibling is core/completion/pyramid.cpp, step for step. Letters in shape comments: N pictures, C channels, H and W
the picture's height and width, padded to even numbers, h and w of a level, 2^level times smaller and rounded up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.functional import relu

from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import pad
from bobrossnet.support.errors import InputError

FEATURES = "12,16,28,32,32,32"  # defaults, also for a weight file without this setting
HANDED_ON = "6,8,8,8,8"
KNOWN, KNOWN_FINEST = 8, 11  # input channels of a level without the coarser one's; the same for level 1
MOST = 1024  # channels
SOFTNESS = 0.05  # of the Gaussian mean: the weight at which it counts half


class Pyramid(Network):
    """Complete the gray picture of a partial G-buffer.

    Parameters
    ----------
    features : str
        Comma-separated numbers of channels between the two convolutions of each level, from level 1 on: multiples of 4.
        Six levels have blocks of up to 64 x 64 pixels.
    handed_on : str
        Numbers of channels that each level passes to the finer one, from level 2 on: one number fewer. The first
        channel corrects the gray.

    Raises
    ------
    InputError
        If the texts are not such numbers.

    Notes
    -----
    The layers' names are the tensors' names in the weight file: `features6.weight`, `features6.bias`, `finer6.weight`,
    ..., down to level 1.

    References
    ----------
    Kraus, *The pull-push algorithm revisited*, 2009, for the pyramid; Shi et al., *Real-time single image and video
    super-resolution using an efficient sub-pixel convolutional neural network*, 2016, for convolution before
    upsampling.
    """

    def __init__(self, features: str = FEATURES, handed_on: str = HANDED_ON) -> None:
        super().__init__()
        of_levels, handed = channels("features", features), [1, *channels("handed_on", handed_on)]
        if len(handed) != len(of_levels) or any(count % 4 for count in of_levels):
            raise InputError(
                "features, handed_on: expected a multiple of 4 for each level, and a number for each but the first, "
                f"got {features} and {handed_on}"
            )
        self.features, self.handed_on, self.levels = features, handed_on, len(of_levels)
        for level in range(self.levels, 0, -1):
            known = (KNOWN if level > 1 else KNOWN_FINEST) + (handed[level] if level < self.levels else 0)
            widen = nn.Conv2d(known, of_levels[level - 1], 3, padding=1)
            finer = nn.Conv2d(of_levels[level - 1], 4 * handed[level - 1], 3, padding=1)
            nn.init.kaiming_normal_(widen.weight, nonlinearity="relu")
            nn.init.kaiming_normal_(finer.weight, nonlinearity="linear")
            finer.weight.data *= 0.3  # small initial corrections
            for name, layer in ((f"features{level}", widen), (f"finer{level}", finer)):
                nn.init.zeros_(layer.bias)  # type: ignore[arg-type]
                self.add_module(name, layer)

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Pyramid:
        """Return the network for a weight file's header or a configuration, with defaults for omitted settings."""
        return cls(settings.get("features", FEATURES), settings.get("handed_on", HANDED_ON))

    def settings(self) -> dict[str, str]:
        """Return the arguments of `from_settings` for this network."""
        return {"features": self.features, "handed_on": self.handed_on}

    def forward(self, gbuffer: Tensor) -> Tensor:
        """Return the gray picture, (N, 1, H, W), linear and not clamped; 0 on certain background.

        Parameters
        ----------
        gbuffer : (N, 5, H, W) float
            mask, gray, depth, normal x, normal y; all 0 where not traced. Any H and W of at least 1.
        """
        pixels = pad(gbuffer, 2)  # (N, 5, H, W)

        sums = [torch.cat([pixels, torch.zeros_like(pixels[:, :2])], 1)]  # of each level
        for level in range(1, self.levels + 1):
            sums.append(pull(pad(sums[-1], 2), level))

        gray = torch.zeros_like(sums[self.levels][:, :1])  # (N, 1, h, w), predicted from the coarser levels
        surface = torch.ones_like(gray)  # 0 on certain background
        handed: list[Tensor] = []  # (N, handed_on, h, w)
        for level in range(self.levels, 0, -1):
            count, mean, position = means(sums[level], level)
            known = (count > 0).to(count)
            surface = surface * spread(1 - known * (mean[:, :1] == 0))
            surprise = known * (mean[:, :1] - gray)
            knows = [gray, surprise, mean[:, 1:], count / (count + 1), position]
            finer_size = sums[level - 1].shape[-2:]
            gray = crop(upsample(gray + surprise), finer_size)
            if level == 1:  # inputs for each pixel
                mask, surprise = pixels[:, :1], pixels[:, :1] * (pixels[:, 1:2] - gray)
                knows = [knows[0], mean[:, 2:], unshuffle(mask), unshuffle(surprise)]
                gray = gray + gaussian_mean(surprise, mask)
            features = relu(self.layer("features", level)(torch.cat([*knows, *handed], 1)))
            finer = crop(functional.pixel_shuffle(self.layer("finer", level)(features), 2), finer_size)
            gray = gray + finer[:, :1]
            surface = crop(functional.interpolate(surface, scale_factor=2, mode="nearest"), finer_size)
            handed = [finer]

        return crop(gray * surface, gbuffer.shape[-2:])

    def layer(self, name: str, level: int) -> nn.Conv2d:
        """Return a level's convolution, "features" or "finer"."""
        return cast(nn.Conv2d, getattr(self, f"{name}{level}"))


def channels(name: str, text: str) -> list[int]:
    """Parse the numbers of channels of a setting, at least 1 each.

    Raises
    ------
    InputError
        If the text has other contents.
    """
    numbers = text.split(",") if text else []
    if not all(number.isascii() and number.isdecimal() and 0 < int(number) <= MOST for number in numbers):
        raise InputError(f"{name}: expected numbers of 1 to {MOST} with commas between them, got {text!r}")
    return [int(number) for number in numbers]


def pull(sums: Tensor, level: int) -> Tensor:
    """Return a level's sums from the next finer one's: (N, 7, 2h, 2w) → (N, 7, h, w).

    Sums over the traced pixels of each block: count, gray, depth, normal x, normal y, and the offsets to the right of
    and below the block's centre, in pixels.
    """
    total = 4 * functional.avg_pool2d(sums, 2)
    upper_left, upper_right, lower_left, lower_right = torch.chunk(unshuffle(sums[:, :1]), 4, 1)
    quarter = 2.0 ** (level - 2)  # distance of the quarters' centres from the block's, along each axis
    right = total[:, 5:6] + quarter * (upper_right + lower_right - upper_left - lower_left)
    down = total[:, 6:7] + quarter * (lower_left + lower_right - upper_left - upper_right)
    return torch.cat([total[:, :5], right, down], 1)


def crop(x: Tensor, size: Sequence[int]) -> Tensor:
    """Crop pictures to their first rows and columns; `size` is (height, width)."""
    return x[..., : size[0], : size[1]]


def means(sums: Tensor, level: int) -> tuple[Tensor, Tensor, Tensor]:
    """Return the counts, means and positions of the traced pixels in each block.

    (N, 1, h, w) counts; (N, 4, h, w) mean gray, depth and normal; (N, 2, h, w) mean position, in sides of the block. 0
    in blocks without traced pixels.
    """
    count = sums[:, :1]
    mean = sums[:, 1:] / count.clamp(min=1)
    return count, mean[:, :4], mean[:, 4:] / 2**level


def spread(x: Tensor) -> Tensor:
    """Return the maximum of the 3x3 neighbourhood of each pixel, (N, C, h, w)."""
    return functional.max_pool2d(x, 3, stride=1, padding=1)


def upsample(x: Tensor) -> Tensor:
    """Double a picture bilinearly, edges repeated: (N, C, h, w) → (N, C, 2h, 2w)."""
    return functional.interpolate(x, scale_factor=2, mode="bilinear", align_corners=False)


def unshuffle(x: Tensor) -> Tensor:
    """Turn the pixels of each 2x2 block into channels, row by row: (N, 1, 2h, 2w) → (N, 4, h, w)."""
    return functional.pixel_unshuffle(x, 2)


def gaussian_mean(values: Tensor, mask: Tensor) -> Tensor:
    """Return the Gaussian mean of known values in 3x3 pixels, attenuated where few are known: (N, 1, H, W).

    Parameters
    ----------
    values : (N, 1, H, W), 0 where not known
    mask : (N, 1, H, W), 1 where known
    """
    kernel = values.new_tensor([[1, 2, 1], [2, 4, 2], [1, 2, 1]])[None, None] / 16
    weight, total = (functional.conv2d(plane, kernel, padding=1) for plane in (mask, values))
    return total / (weight + SOFTNESS)
