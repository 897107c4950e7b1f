"""The base class of all networks, from a partial G-buffer to a gray picture, with settings for weight files."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any, ClassVar

import torch
from torch import nn
from torch.utils.flop_counter import FlopCounterMode

from bobrossnet import _core


class Network(nn.Module):
    """A network from planes, (N, C, H, W), to pictures, (N, 1, H, W), for any H and W of at least 1."""

    inputs: ClassVar[str] = "mask,gray,depth,normal"
    """Comma-separated names of its input channels."""
    outputs: ClassVar[str] = "gray"

    @classmethod
    def width(cls) -> int:
        """Return the number of input planes."""
        return _core.Layout(cls.inputs).width

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Network:
        """Return the network with the given settings and new weights.

        Parameters
        ----------
        settings : mapping
            Strings of a weight file's header, or a `TrainConfig`'s fields; only the keys of `settings()` are read.

        Raises
        ------
        KeyError, ValueError
            If a setting is missing or invalid.
        """
        raise NotImplementedError

    def settings(self) -> Mapping[str, int | str]:
        """Return the arguments of `from_settings` for this network."""
        raise NotImplementedError

    def multiply_adds(self, height: int = 480, width: int = 640) -> float:
        """Return the number of multiply-adds of all convolutions, divided by the number of pixels of a picture.

        A layer at half the resolution adds a quarter; the network's padding is included.
        """
        network = deepcopy(self).to("meta")  # shapes alone, without computation
        with torch.no_grad(), FlopCounterMode(display=False) as counter:
            network(torch.empty((1, self.width(), height, width), device="meta"))
        return float(counter.get_total_flops()) / 2 / (height * width)
