"""How wrong a completed picture is expected to be."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.complete import check_gbuffer
from bobrossnet.completion.display import displayed
from bobrossnet.completion.network import NetworkLike, load_network
from bobrossnet.completion.weights import UNCERTAINTY, read_weights
from bobrossnet.picture.gbuffer import GBuffer


def uncertainty(gbuffer: GBuffer, *, model: NetworkLike = "default") -> NDArray[np.float32]:
    """Predict by how much each pixel of the completed picture is wrong.

    A small network of its own predicts it from the nearest traced pixels around each pixel: how far they are, how much
    they differ, and how wrong the completing network is at them, where the truth is known. Its mean is an upper bound
    in about nine of ten pictures, and seldom above twice the truth; of single pixels it says how likely an error is,
    since nobody knows on which side of a gap an edge runs.

    Parameters
    ----------
    gbuffer : GBuffer, (H, W)
        Of any size, with any pixels traced, in any order.
    model : str, path or Network
        Of which network the completed picture is, as in `complete`.

    Returns
    -------
    (H, W) float32 in 0..1
        The expected absolute error of `complete(gbuffer, model=model)`, in gray; 0 where pixels were traced, or what
        noise leaves there by its variance. Of
        pictures of any range, that of gray as `GBuffer.transfer` encodes it; of those with guides, as if these were
        not known.

    Raises
    ------
    InputError
        As `complete`.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> full = bob.trace(bob.happy_tree(), size=(120, 160))
    >>> few, more = full.sample(0.05), full.sample(0.2)
    >>> bool(bob.uncertainty(few).mean() > bob.uncertainty(more).mean())
    True
    """
    check_gbuffer(gbuffer)
    shown = displayed(gbuffer)
    predicted = load_network(model).predict(shown)
    error = np.empty(gbuffer.size, np.float32)
    _predictor()(shown.layout.core, shown.planes, predicted[None], error[None])
    if "variance" in gbuffer.layout.places:
        noise = np.sqrt(np.float32(2 / np.pi) * gbuffer.channel("variance"))  # the mean of what is distributed normally
        if (transfer := gbuffer.transfer) is not None:
            noise *= transfer.slope(gbuffer.gray)
        np.copyto(error, noise, where=gbuffer.mask > 0)
    return error


def mean_error(gbuffer: GBuffer, model: NetworkLike) -> float:
    """The mean of `uncertainty`: the expected mean absolute error of the completed picture."""
    return float(uncertainty(gbuffer, model=model).mean(dtype=np.float64))


@cache
def _predictor() -> _core.ErrorPredictor:
    return _core.ErrorPredictor(read_weights(UNCERTAINTY)[1])
