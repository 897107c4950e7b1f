"""What all networks have in common: partial G-buffer in, gray picture out, and settings that a weight file can hold."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from typing import Any, ClassVar

import torch
from torch import nn
from torch.utils.flop_counter import FlopCounterMode

from bobrossnet import _core


class Network(nn.Module):
    """A network that maps the planes of its inputs, (N, C, H, W), to its outputs, (N, 1, H, W), for any H and W of at
    least 1."""

    inputs: ClassVar[str] = "mask,gray,depth,normal"
    """The names of the channels that it sees, with commas between them."""
    outputs: ClassVar[str] = "gray"

    @classmethod
    def width(cls) -> int:
        """Return how many planes the inputs have."""
        return _core.Layout(cls.inputs).width

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Network:
        """Return the network of some settings, with new weights.

        Parameters
        ----------
        settings : mapping
            A weight file's header, strings, or a `TrainConfig`'s fields; read are only those that `settings()` returns.

        Raises
        ------
        KeyError, ValueError
            If one is missing, or can't be used.
        """
        raise NotImplementedError

    def settings(self) -> Mapping[str, int | str]:
        """Return what `from_settings` needs to make this network again."""
        raise NotImplementedError

    def multiply_adds(self, height: int = 480, width: int = 640) -> float:
        """Return the multiply-adds of all convolutions for each pixel of a picture.

        What runs at half the resolution counts a quarter for a pixel; what the network pads the picture with counts.
        """
        network = deepcopy(self).to("meta")  # shapes alone, nothing is computed
        with torch.no_grad(), FlopCounterMode(display=False) as counter:
            network(torch.empty((1, self.width(), height, width), device="meta"))
        return float(counter.get_total_flops()) / 2 / (height * width)
