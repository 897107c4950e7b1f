"""The report's network: a U-Net of six 3x3 convolutions, 10,346 parameters.

Its sibling is core/completion/paper.cpp, step for step. Letters in shape comments: N pictures, C channels, H and W the
padded picture's height and width.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.functional import relu

from bobrossnet.learn.networks.network import Network
from bobrossnet.support.errors import InputError


class Paper(Network):
    """Complete the gray picture of a partial G-buffer.

    Parameters
    ----------
    groups : int
        Groups of the two wide layers, `encode2` and `encoded`: 4 as in the report, with 10,346 parameters; 1 for full
        convolutions, with 31,946. Divides 20.

    Raises
    ------
    InputError
        If `groups` doesn't divide 20.

    Notes
    -----
    The layers' names are the tensors' names in the weight file (`encode1.weight`, `encode1.bias`, ...).
    """

    multiple = 4  # two poolings: the picture is padded to this multiple

    def __init__(self, groups: int = 4) -> None:
        super().__init__()
        if groups < 1 or 20 % groups:
            raise InputError(f"groups: expected a divisor of 20, got {groups}")
        self.groups = groups
        self.encode1 = nn.Conv2d(self.width(), 20, 3, padding=1)
        self.encode2 = nn.Conv2d(20, 80, 3, padding=1, groups=groups)
        self.encoded = nn.Conv2d(80, 20, 3, padding=1, groups=groups)
        self.decode1 = nn.Conv2d(20, 5, 3, padding=1)
        self.decode2 = nn.Conv2d(5 + 20, 5, 3, padding=1)
        self.output = nn.Conv2d(5 + self.width(), 1, 3, padding=1)
        for layer in (self.encode1, self.encode2, self.encoded, self.decode1, self.decode2, self.output):
            # He initialisation: with PyTorch's default the scale falls by a factor of about 2.4 in each layer before
            # ReLU.
            nn.init.kaiming_normal_(layer.weight, nonlinearity="linear" if layer is self.output else "relu")
            nn.init.zeros_(layer.bias)  # type: ignore[arg-type]

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Paper:
        """Return `Paper(groups)` with the groups of a weight file's header or a configuration."""
        return cls(groups=int(settings["groups"]))

    def settings(self) -> dict[str, int]:
        """Return the arguments of `from_settings` for this network."""
        return {"groups": self.groups}

    def forward(self, gbuffer: Tensor) -> Tensor:
        """Return the gray picture, (N, 1, H, W), linear and not clamped.

        Parameters
        ----------
        gbuffer : (N, 5, H, W) float
            mask, gray, depth, normal x, normal y; all 0 where not traced. Any H and W of at least 1.
        """
        height, width = gbuffer.shape[-2:]
        input = pad(gbuffer, self.multiple)  # (N, 5, H, W)

        # ReLU after pooling gives the same result, on a quarter of the pixels.
        encode1 = relu(pool(self.encode1(input)))  # (N, 20, H/2, W/2)
        encode2 = relu(pool(self.encode2(encode1)))  # (N, 80, H/4, W/4)
        encoded = relu(self.encoded(shuffle(encode2, self.groups)))  # (N, 20, H/4, W/4)

        decode1 = upsample(relu(self.decode1(encoded)))  # (N, 5, H/2, W/2)
        decode2 = upsample(relu(self.decode2(torch.cat([decode1, encode1], 1))))  # (N, 5, H, W)
        output: Tensor = self.output(torch.cat([decode2, input], 1))  # (N, 1, H, W)

        return output[..., :height, :width]


def pad(x: Tensor, multiple: int) -> Tensor:
    """Pad with zeros at the bottom and the right, up to the next multiple."""
    height, width = x.shape[-2:]
    return functional.pad(x, (0, -width % multiple, 0, -height % multiple))


def pool(x: Tensor) -> Tensor:
    """Return the maximum of each 2x2 block: (N, C, H, W) → (N, C, H/2, W/2)."""
    return functional.max_pool2d(x, 2)


def upsample(x: Tensor) -> Tensor:
    """Repeat each pixel 2x2 times: (N, C, H, W) → (N, C, 2H, 2W)."""
    return functional.interpolate(x, scale_factor=2, mode="nearest")


def shuffle(x: Tensor, groups: int) -> Tensor:
    """Distribute each group's channels over all groups, so that consecutive grouped layers mix.

    As in ShuffleNet, 2017: channel g · C/groups + i moves to i · groups + g. It keeps the channels-last memory layout
    of training, which fast convolutions need.
    """
    n, channels, height, width = x.shape
    pixels = x.permute(0, 2, 3, 1).reshape(n, height, width, groups, channels // groups)
    return pixels.transpose(3, 4).reshape(n, height, width, channels).permute(0, 3, 1, 2)
