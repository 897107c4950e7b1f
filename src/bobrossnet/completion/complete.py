"""Completing any channel of a G-buffer: gray and coverage by a network, colours along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.display import displayed, restored
from bobrossnet.completion.guided import complete_guided, guided_alpha
from bobrossnet.completion.network import Network, NetworkLike, load_network
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.errors import InputError, InputTypeError, check_choice

GUIDED = "guided"
"""The name of what completes along guides, without a network."""

DISPLAYED_MIDDLE = 0.2
"""What the middle of a picture of any range is taken for where colours are compared with what is display-referred."""


def complete(gbuffer: GBuffer, model: NetworkLike = "default", *, channel: str = "gray") -> NDArray[np.float32]:
    """Fill in the pixels that were not traced.

    Parameters
    ----------
    gbuffer : GBuffer, (H, W)
        Of any size, with any pixels traced.
    model : str, path or Network
        Name of shipped weights ("default", "filling", "paper", "small"), or a .safetensors file. "filling" needs no
        learning and a third of the default's time, and is as good from 5 % of adaptive pixels on; "small" lies between.
        Of a G-buffer with guides, "default" completes gray and colour along these instead, as does "guided".
    channel : "gray", "color", "albedo" or "alpha"
        What to complete. The network completes gray, and coverage for albedo and alpha; colours follow them, by what
        their ratio is at the traced pixels around.

    Returns
    -------
    (H, W) float32, or (H, W, 3) of colours, in linear RGB
        In 0..1, unless more was traced: then in its units, and at least 0. Traced pixels are returned unchanged, but
        for noisy ones along guides; with every pixel traced, this is `gbuffer.gray`, or the other channel.

    Raises
    ------
    InputError
        If `gbuffer` is not a GBuffer or lacks a channel that the network needs, or the weights can't be used, or
        there is no such channel.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> part = bob.trace(bob.happy_tree(), size=(120, 160), fraction=0.05)
    >>> image = bob.complete(part)
    >>> image.shape
    (120, 160)
    >>> bob.complete(part, channel="color").shape
    (120, 160, 3)
    """
    check_gbuffer(gbuffer)  # first: whoever passes arrays instead, as in complete(gray, mask), is told how
    check_choice("channel", channel, ("gray", "color", "albedo", "alpha"))
    if channel in ("gray", "color") and follows_guides(gbuffer, model):
        return complete_guided(gbuffer, channel)
    if channel == "alpha" and "shadow" in gbuffer.layout.places and follows_guides(gbuffer, model):
        return guided_alpha(gbuffer)
    network = load_network(model)
    if gbuffer.mask.all():
        return gbuffer.channel(channel).copy()
    if channel in ("gray", "color"):
        gray = _completed(gbuffer, network)
        return gray if channel == "gray" else completed_color(gbuffer, gray)
    alpha = gbuffer.alpha
    coverage = GBuffer(mask=gbuffer.mask, gray=alpha, depth=gbuffer.depth, normal=gbuffer.normal)
    covered = _completed(coverage, network)
    return covered if channel == "alpha" else _completed_along("albedo", gbuffer, alpha, covered)


def follows_guides(gbuffer: GBuffer, model: NetworkLike) -> bool:
    """Whether `model` completes a G-buffer along its guides."""
    name = model if isinstance(model, str) else None
    if name == GUIDED and gbuffer.guides is None:
        raise InputError("model: expected a G-buffer with guides for 'guided', got one without")
    return gbuffer.guides is not None and name in ("default", GUIDED)


def completed_color(gbuffer: GBuffer, gray: NDArray[np.float32]) -> NDArray[np.float32]:
    """The completed colour of a G-buffer whose completed gray is known."""
    middle = None if gbuffer.transfer is None else gbuffer.transfer.middle
    unit = None if middle is None else middle / DISPLAYED_MIDDLE
    return _completed_along("color", gbuffer, gbuffer.gray, gray, unit)


def _completed(gbuffer: GBuffer, network: Network) -> NDArray[np.float32]:
    """The gray, of which not every pixel was traced."""
    shown = displayed(gbuffer)
    image, outputs = network.run(shown), network.core.outputs
    _core.interpolate_lattice(shown.layout.core, shown.planes, outputs, image[None])
    _core.keep_known(shown.layout.core, shown.planes, outputs, image[None])
    return restored(image, gbuffer)


def _completed_along(
    name: str,
    gbuffer: GBuffer,
    known: NDArray[np.float32],
    completed: NDArray[np.float32],
    unit: float | None = None,
) -> NDArray[np.float32]:
    """A channel of colours along another one, (H, W), as traced and as completed; of values of any range, `unit` is
    what counts as 1."""
    if name not in gbuffer.layout.places:  # of what is white
        return np.repeat(completed[..., None], 3, -1)
    output = np.empty((3, *completed.shape), np.float32)
    channel = _core.Layout(name)
    _core.complete_along(gbuffer.layout.core, gbuffer.planes, channel, known, completed, unit, output)
    return np.moveaxis(output, 0, -1)


def check_gbuffer(gbuffer: object) -> None:
    """Raise InputTypeError unless it is one."""
    if not isinstance(gbuffer, GBuffer):
        hint = "bobrossnet.GBuffer(mask=, gray=, depth=, normal=) makes one of arrays"
        raise InputTypeError(f"gbuffer: expected a GBuffer, got {type(gbuffer).__name__}; {hint}")
