"""Planning of frames: the core decides from measured times and the available networks."""

from __future__ import annotations

from bobrossnet import _core
from bobrossnet.completion.network import NetworkLike, load_network
from bobrossnet.picture.order import ADAPTIVE, ORDERS_BY_SIGHT, SQUARES, Size

AUTO = "auto"

ORDER_OF = {"whole": "lattice", "squares": SQUARES, "adaptive": ADAPTIVE}
"""Pixel order of each mode of the planner."""


class Planner:
    """The core's frame planner with its networks.

    Parameters
    ----------
    size : (height, width)
    model : str, path or Network
        As in `complete`; or "auto": for each frame, the most accurate network within the frame budget.
    order : str
        The pixel order; "auto" has a choice of networks only with adaptive orders.

    Raises
    ------
    InputError
        As in `load_network`.
    """

    def __init__(self, size: Size, model: NetworkLike, order: str = ADAPTIVE) -> None:
        if isinstance(model, str) and model == AUTO:
            names = ("filling", "default") if order in (*ORDERS_BY_SIGHT, "default") else ("default",)
            self.networks = {name: load_network(name) for name in names}
        else:
            self.networks = {"default": load_network(model)}
        self.core = _core.FramePlanner(size[0] * size[1], list(self.networks))
