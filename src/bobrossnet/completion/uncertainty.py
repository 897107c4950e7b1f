"""Predicted error of a completed picture."""

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
    """Predict the absolute error of each completed pixel.

    A separate small network predicts it from the nearest traced pixels: their distance, their contrast, and the
    completing network's error at them, where the truth is known. The mean over a picture is an upper bound in about
    nine of ten pictures, and seldom exceeds twice the true error. A single pixel's value is a likelihood, since the
    position of an edge within a gap is unknown.

    Parameters
    ----------
    gbuffer : GBuffer, (H, W)
        Of any size, with any pixels traced, in any order.
    model : str, path or Network
        The network that completes the picture, as in `complete`.

    Returns
    -------
    (H, W) float32 in 0..1
        The expected absolute error of `complete(gbuffer, model=model)` in gray: 0 at traced pixels, or their expected
        noise, from its variance. For high-dynamic-range pictures, gray is encoded by `GBuffer.transfer`. Guides are
        ignored.

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
        noise = np.sqrt(np.float32(2 / np.pi) * gbuffer.channel("variance"))  # mean of |x|, x normal
        if (transfer := gbuffer.transfer) is not None:
            noise *= transfer.slope(gbuffer.gray)
        np.copyto(error, noise, where=gbuffer.mask > 0)
    return error


def mean_error(gbuffer: GBuffer, model: NetworkLike) -> float:
    """Return the expected mean absolute error of the completed picture, the mean of `uncertainty`."""
    return float(uncertainty(gbuffer, model=model).mean(dtype=np.float64))


@cache
def _predictor() -> _core.ErrorPredictor:
    return _core.ErrorPredictor(read_weights(UNCERTAINTY)[1])
