"""Which network completes a picture: the cheapest that is as good for it."""

from __future__ import annotations

from dataclasses import dataclass

from bobrossnet.completion.network import Network, NetworkLike, load_network
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.picture.order import ADAPTIVE, ORDERS_BY_SIGHT

AUTO = "auto"

DENSE = 0.05
"""Share of the pixels, traced or expected, from which on the filling is as good as any network, in a third of the time,
where they were placed by need (docs/quality.md)."""


@dataclass(frozen=True)
class Choice:
    """A network for pictures of which little is known, and one for the others."""

    sparse: Network
    dense: Network

    def of(self, gbuffer: GBuffer) -> Network:
        """The one for a picture."""
        return self.sparse if gbuffer.fraction < DENSE else self.dense


def choice_of(model: NetworkLike, order: str = ADAPTIVE) -> Choice:
    """What `model` names, for pixels in an order: "auto" is the default network, and the filling where enough is known
    of pixels that were placed by need. InputError as of `load_network`."""
    if not (isinstance(model, str) and model == AUTO):
        network = load_network(model)
        return Choice(network, network)
    default = load_network("default")
    return Choice(default, load_network("filling") if order in (*ORDERS_BY_SIGHT, "default") else default)
