"""How frames are made: the core decides by what everything took, and by the networks that there are."""

from __future__ import annotations

from bobrossnet import _core
from bobrossnet.completion.network import NetworkLike, load_network
from bobrossnet.picture.order import ADAPTIVE, ORDERS_BY_SIGHT, SQUARES, Size

AUTO = "auto"

ORDER_OF = {"whole": "lattice", "squares": SQUARES, "adaptive": ADAPTIVE}
"""The order of a picture's pixels, by the planner's modes."""


class Planner:
    """The core's planner, and what completes pictures.

    Parameters
    ----------
    size : (height, width)
    model : str, path or Network
        As in `complete`; or "auto": for each picture the one that leaves the least error in its time.
    order : str
        Of the pixels: only where they are placed by need, "auto" has several.

    Raises
    ------
    InputError
        As of `load_network`.
    """

    def __init__(self, size: Size, model: NetworkLike, order: str = ADAPTIVE) -> None:
        if isinstance(model, str) and model == AUTO:
            names = ("filling", "default") if order in (*ORDERS_BY_SIGHT, "default") else ("default",)
            self.networks = {name: load_network(name) for name in names}
        else:
            self.networks = {"default": load_network(model)}
        self.core = _core.FramePlanner(size[0] * size[1], list(self.networks))
