"""The networks, one file each, by the name that their weight files carry."""

from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import Paper
from bobrossnet.learn.networks.pyramid import Pyramid

NETWORKS: dict[str, type[Network]] = {"paper": Paper, "pyramid": Pyramid}

__all__ = ["NETWORKS", "Network", "Paper", "Pyramid"]
