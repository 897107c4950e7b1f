"""What all networks have in common: partial G-buffer in, gray picture out, and settings that a weight file can hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from torch import nn


class Network(nn.Module):
    """A network that maps (N, 5, H, W), as `GBuffer.stack` gives it, to (N, 1, H, W), for any H and W of at least 1."""

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

    def settings(self) -> dict[str, int]:
        """Return what `from_settings` needs to make this network again."""
        raise NotImplementedError
