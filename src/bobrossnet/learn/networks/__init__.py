"""The networks, one file each, by the name that their weight files carry."""

from torch import nn

from bobrossnet.learn.networks.paper import Paper

NETWORKS: dict[str, type[nn.Module]] = {"paper": Paper}

__all__ = ["NETWORKS", "Paper"]
