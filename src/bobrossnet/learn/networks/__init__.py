"""The networks, one file each, by the name that their weight files carry."""

from bobrossnet.learn.networks.filling import Filling
from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import Paper
from bobrossnet.learn.networks.pyramid import Pyramid

NETWORKS: dict[str, type[Network]] = {"filling": Filling, "paper": Paper, "pyramid": Pyramid}
"""One of your own, put in here, can be trained by its name: `TrainConfig(network=name)`."""


def learnt() -> tuple[str, ...]:
    """Return the names of those that have anything to learn."""
    return tuple(name for name, network in NETWORKS.items() if network is not Filling)


__all__ = ["NETWORKS", "Filling", "Network", "Paper", "Pyramid", "learnt"]
