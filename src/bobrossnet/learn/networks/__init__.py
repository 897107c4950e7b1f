"""The networks, one file each, by the name that their weight files carry."""

from bobrossnet.learn.networks.filling import Filling
from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import Paper
from bobrossnet.learn.networks.pyramid import Pyramid

NETWORKS: dict[str, type[Network]] = {"filling": Filling, "paper": Paper, "pyramid": Pyramid}

LEARNT = tuple(name for name in NETWORKS if name != "filling")
"""Those that have anything to learn."""

__all__ = ["LEARNT", "NETWORKS", "Filling", "Network", "Paper", "Pyramid"]
