"""The networks, one file each, by the names in their weight files."""

from bobrossnet.learn.networks.filling import Filling
from bobrossnet.learn.networks.network import Network
from bobrossnet.learn.networks.paper import Paper
from bobrossnet.learn.networks.pyramid import Pyramid

NETWORKS: dict[str, type[Network]] = {"filling": Filling, "paper": Paper, "pyramid": Pyramid}
"""Networks by name; an added one can be trained as `TrainConfig(network=name)`."""


def learnt() -> tuple[str, ...]:
    """Return the names of networks with learned weights."""
    return tuple(name for name, network in NETWORKS.items() if network is not Filling)


__all__ = ["NETWORKS", "Filling", "Network", "Paper", "Pyramid", "learnt"]
